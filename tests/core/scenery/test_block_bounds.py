"""What a block of rays cannot reach is passed by, and nothing else: pictures are the same bit for bit without that."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import (
    A0, A3, A6, BEAM, BLUE, GREEN, PITCH, RED, TIME, V0, V1, B, L, M, N, Step, X, Y, Z, lane_buffer, rows, stage
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.block_bounds import beam, beam_misses, lit_bounds, shadow_bounds
from lensbench.core.scenery.scene import Scene
from tests.core.scenery.test_moving_objects import crowd
from tests.core.scenery.test_scene import shoot, unit

BLOCKS = 120


@stage
def everywhere(lanes, p, ints, key):
    """Instead of `beam`: the rays of the block can meet anything."""
    rows(lanes)[BEAM][0] = lanes.dtype.type(0)


def scattered(random) -> Scene:
    """Small and large balls and plates of all materials all round the origin, on a floor."""
    kinds = ["matte", "coat", "metal", "glass", "light", "lamp"]

    def thing(kind):
        away = np.exp(random.uniform(np.log(60.0), np.log(6000.0)))
        place, size = tuple(unit(random.normal(size=3)) * away), away * random.uniform(0.01, 0.3)
        material = lb.Material(tuple(random.uniform(0.1, 1.0, 3)), kind)
        a, b = np.linalg.qr(random.normal(size=(3, 2)))[0].T * size
        made = [lb.Sphere(place, min(size, 0.5 * away), material), lb.Disk(place, tuple(a), size, material),
                lb.Rectangle(place, tuple(a), tuple(0.3 * b), material)]
        return made[random.integers(0, 3)]

    things = [thing(kinds[j % 3 if j < 60 else j % 6]) for j in range(90)]
    balls = tuple(o for o in things if isinstance(o, lb.Sphere))
    return Scene("scattered", floor=lb.Floor(-300.0, 90.0), spheres=balls,
                 plates=tuple(o for o in things if not isinstance(o, lb.Sphere)))


def bundle(random, real):
    """A block of rays (X … N) as cameras make them, and as nobody does."""
    kind = random.integers(0, 6)
    forward = unit(random.normal(size=3)) if random.random() < 0.9 else np.array([0.0, random.choice([-1.0, 1.0]), 0.0])
    right, up = np.linalg.qr(np.column_stack([forward, random.normal(size=(3, 2))]))[0].T[1:]
    wide = 10.0 ** random.uniform(-3.0, 0.0)                    # half of the block's angle
    x, y = random.uniform(-wide, wide, (2, B))
    d = forward + x[:, None] * right + 0.5 * y[:, None] * up
    o = random.normal(0.0, 100.0, 3) + np.zeros((B, 3))
    if kind == 1:                                               # through a lens, to a plane of focus
        across = random.normal(0.0, 8.0, (B, 2)) @ [right, up]
        o, d = o + across, d - across / 10.0 ** random.uniform(2.0, 4.0)
    elif kind == 2:                                             # side by side
        o, d = o + 300.0 * (d - forward), forward + np.zeros((B, 3))
    elif kind == 3:                                             # to all sides
        d = random.normal(size=(B, 3))
    elif kind == 4:                                             # from depths of their own, as behind a mirror
        o = o + random.uniform(-200.0, 200.0, (B, 1)) * forward
    d = unit(d)
    lost = random.random(B) < random.choice([0.0, 0.3, 0.99])
    if kind == 5:
        d[lost], o[lost] = 0.0, 1e9                             # a path that has ended
    else:
        d[lost], o[lost] = np.nan, np.nan
    return np.concatenate([o.T, d.T]).astype(real)


def unculled(steps):
    """The same steps, but everything is offered to every ray."""
    return [step._replace(kernel=everywhere) if step.kernel is beam else step for step in steps]


@pytest.mark.slow
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("seed", range(4))
def test_what_a_block_passes_by_is_met_by_none_of_its_rays(seed, real):
    random = np.random.default_rng(seed)
    scene = scattered(random) if seed else crowd(3)
    rays = np.concatenate([bundle(random, real) for _ in range(BLOCKS)], 1)
    given = dict(zip([X, Y, Z, L, M, N, V0, V1, TIME], [*rays, *random.random((3, rays.shape[1]))], strict=True))
    steps = scene.steps(shadows=False)
    assert any(step.kernel is beam for step in steps)
    culled, plain = (Program(which, real).run(given, [RED, GREEN, BLUE], rays.shape[1])
                     for which in (steps, unculled(steps)))
    np.testing.assert_array_equal(culled, plain)


@stage
def passed_by(lanes, p, ints, key):
    """RED of lane j: 1 where ball j, three numbers in p and 10 mm wide, is outside the block's beam."""
    real = lanes.dtype.type
    red, seen = rows(lanes)[RED], rows(lanes)[BEAM]
    beam(lanes, p, ints, key)
    for j in range(p.size // 3):
        half = real(5)
        red[j] = real(beam_misses(seen, p[3 * j], p[3 * j + 1], p[3 * j + 2], half, half, half))


def test_a_narrow_block_passes_by_what_is_a_little_off_its_edges():
    """Rays of a square of 0.1 × 0.1 on a plane at 1: a ball 1 m away is passed by from 5 mm beyond the edge on."""
    random = np.random.default_rng(1)
    d = unit(np.column_stack([*random.uniform(-0.05, 0.05, (2, B)), np.full(B, -1.0)]))
    for axis in (0, 1):
        for side in (-1.0, 1.0):
            balls = np.tile([0.0, 0.0, -1000.0], (B, 1))
            balls[:, axis] = side * np.linspace(40.0, 70.0, B)
            given = dict(zip([L, M, N], d.T, strict=True))
            found = Program([Step(passed_by, balls)]).run(given, [RED], B)[0] == 1.0
            # half of the ball, its half along the way at the edge's slope, 0.2 % for rays that look aside: 56 mm
            assert not found[abs(balls[:, axis]) < 54.5].any() and found[abs(balls[:, axis]) > 56.0].all()
    behind = np.tile([0.0, 0.0, 20.0], (B, 1))
    assert Program([Step(passed_by, behind)]).run(dict(zip([L, M, N], d.T, strict=True)), [RED], B).all()


def test_the_box_of_shadow_rays_and_that_of_lit_points_hold_them_within_three_millimetres():
    random = np.random.default_rng(8)
    lanes = lane_buffer(np.float64)
    row = lanes.reshape(-1, PITCH)
    points, ways = random.normal(0.0, 300.0, (B, 3)), unit(random.normal(size=(B, 3)))
    far, lit = random.uniform(1.0, 900.0, B), random.random(B) < 0.8
    for k in range(3):
        row[A0 + k][:B], row[A3 + k][:B] = points[:, k], ways[:, k]
    row[A6][:B], row[GREEN][:B] = far, lit
    ends = np.concatenate([points[lit], (points + far[:, None] * ways)[lit]])
    for box, held in ((shadow_bounds(lanes), ends), (lit_bounds(lanes), points[lit])):
        assert (np.array(box[:3]) <= held.min(0)).all() and (np.array(box[:3]) > held.min(0) - 3.0).all()
        assert (np.array(box[3:]) >= held.max(0)).all() and (np.array(box[3:]) < held.max(0) + 3.0).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_stands_close_before_a_lamp_holds_its_light_off(axis, sign):
    """A disk 1 mm before a smaller lamp, whichever way the lamp lies."""
    ahead, aside = sign * np.eye(3)[axis], np.eye(3)[(axis + 1) % 3]
    lit, before = (lb.Disk(tuple(away * ahead), tuple(ahead), 60.0, lb.Material((1.0,) * 3)) for away in (0.0, 99.0))
    lamp = lb.Disk(tuple(100.0 * ahead), tuple(ahead), 20.0, lb.Material((1.0,) * 3, "lamp"))
    random = np.random.default_rng(axis)
    points = random.uniform(-20.0, 20.0, (200, 3)) * (1.0 - abs(ahead))
    origins, lights = points + 30.0 * ahead + 40.0 * aside, random.random((2, 200))
    dark = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    free, held = (shoot(lb.Scene("one", sky=dark, plates=plates).steps(), origins, points - origins, lights, np.float32)
                  for plates in ((lit, lamp), (lit, lamp, before)))
    assert (free > 0.01).all() and (held == 0.0).all()


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_what_lies_on_a_ray_is_not_passed_by_wherever_the_rays_begin(real):
    """Parallel rays that begin on a line, whichever way both lie: small balls on the rays."""
    random = np.random.default_rng(6)
    for _ in range(100):
        way, line = unit(random.normal(size=(2, 3)))
        along, far = random.uniform(-200.0, 200.0, B), random.uniform(0.0, 500.0, B)
        given = dict(zip([X, Y, Z, L, M, N], [*np.outer(line, along), *np.tile(way[:, None], B)], strict=True))
        balls = np.outer(along, line) + far[:, None] * way
        assert not Program([Step(passed_by, balls)], real).run(given, [RED], B).any()
