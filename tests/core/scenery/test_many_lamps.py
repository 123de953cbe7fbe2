"""Many lamps, of which a sample takes a few: their light is the sum of what each gives alone.

The stages that take all lamps are the second algorithm; tolerances come from the scatter of the samples themselves.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import NX, PITCH, RED, B, X, lane_buffer
from lensbench.core.scenery import scene_steps
from lensbench.core.scenery.shading.many_lamps import COLUMNS, FACING, MANY_LAMPS, MIDDLE, PICKS, lamp_shares
from tests.core.scenery.test_scene import shoot

BLACK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
PAPER = lb.Material((1.0, 0.8, 0.6))
GROUND = lb.Rectangle((0.0, -100.0, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, -1e4), PAPER)
BALL = lb.Sphere((150.0, 0.0, 100.0), 100.0, PAPER)
SAMPLES = 1024


def lamps(count, seed=1):
    """Lamps of three kinds, sizes and colours, scattered over the ground."""
    random, found = np.random.default_rng(seed), []
    for j in range(count):
        x, y, z = random.uniform((-900.0, 150.0, -900.0), (900.0, 500.0, 900.0))
        material = lb.Material(tuple(random.uniform(0.0, 1.0, 3) * random.lognormal(0.0, 1.0) * 20.0), "lamp")
        size, normal = random.uniform(3.0, 20.0), tuple(random.normal(size=3))
        found.append((lb.Sphere((x, y, z), size, material), lb.Disk((x, y, z), normal, size, material),
                      lb.Rectangle.facing((x, y, z), (x + normal[0], y + normal[1], z + normal[2]), 3.0 * size, size,
                                          material))[j % 3])
    return found


def lit(shapes, things=(GROUND, BALL), **more):
    """A scene of lamps and things under a black sky."""
    every = (*things, *shapes)
    return lb.Scene("lamps", sky=BLACK, spheres=tuple(o for o in every if isinstance(o, lb.Sphere)),
                    plates=tuple(o for o in every if isinstance(o, lb.Rectangle | lb.Disk)), **more)


def all_taken(scene, monkeypatch):
    """Stages of a scene in which each sample takes all lamps."""
    with monkeypatch.context() as patch:
        patch.setattr(scene_steps, "MANY_LAMPS", math.inf)
        return replace(scene, name=f"{scene.name}, all taken").steps()


def seen(steps, count=40, seed=3):
    """Radiance of points of the ground: means (count, 3) over SAMPLES points of the lights, and their variances."""
    x, z = np.random.default_rng(8).uniform(-800.0, 800.0, (2, count))
    random = np.random.default_rng(seed)
    o = np.repeat(np.column_stack([x, np.full(count, -99.0), z]), SAMPLES, 0)
    # SAMPLES strata along V0, so that neither estimate is noisier than it must be
    v0 = (np.tile(np.arange(SAMPLES), count) + random.random(count * SAMPLES)) / SAMPLES
    found = shoot(steps, o, [0.0, -1.0, 0.0], (v0, random.random(count * SAMPLES))).reshape(count, SAMPLES, 3)
    return found.mean(1), found.var(1) / SAMPLES


def assert_same_light(one, other):
    """Means differ by no more than their standard errors allow; strata only make these smaller."""
    (a, va), (b, vb) = one, other
    error = np.sqrt(va + vb)
    assert np.all(abs(a - b) < 5.0 * error + 1e-9)
    # The sum over all points and colours, weighed by 1 / error, would show a bias far below the error of one point
    known = error > 0.0
    assert abs(((a - b)[known] / error[known]).mean()) < 0.5
    assert a.sum() == pytest.approx(b.sum(), rel=0.01)


def names(scene):
    return [step.kernel.__name__ for step in scene.steps()]


def test_up_to_a_number_of_lamps_each_has_its_own_stage():
    assert names(lit(lamps(MANY_LAMPS))).count("lamp_rays") == MANY_LAMPS
    many = names(lit(lamps(MANY_LAMPS + 1)))
    assert "lamp_rays" not in many and many.count("many_lamps") == 1


def test_black_lamps_do_not_count_and_moving_ones_keep_a_stage_of_their_own():
    black = [replace(o, material=lb.Material((0.0,) * 3, "lamp")) for o in lamps(20, seed=2)]
    assert "many_lamps" not in names(lit([*lamps(MANY_LAMPS), *black]))
    moving = [replace(o, velocity=(1.0, 0.0, 0.0)) for o in lamps(3, seed=2)]
    many = names(lit([*lamps(60), *black, *moving]))
    assert many.count("many_lamps") == 1 and many.count("lamp_rays") == 3


@pytest.mark.slow
def test_the_light_of_many_lamps_is_the_sum_of_what_each_gives_alone():
    many = lamps(60)
    total, variance = np.zeros((40, 3)), np.zeros((40, 3))
    for one in many:
        mean, own = seen(lit([one]).steps(), seed=4)
        total, variance = total + mean, variance + own
    assert total.min() > 0.0
    assert_same_light(seen(lit(many).steps()), (total, variance))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [0, 1, 2])
def test_lamps_of_one_kind_give_what_all_of_them_give(kind, monkeypatch):
    scene = lit(lamps(200)[kind::3])
    assert_same_light(seen(scene.steps()), seen(all_taken(scene, monkeypatch), seed=4))


@pytest.mark.slow
def test_lamps_behind_a_wall_give_nothing_and_others_what_they_gave(monkeypatch):
    wall = lb.Rectangle((0.0, 400.0, 0.0), (0.0, 0.0, 5000.0), (0.0, 500.0, 0.0), PAPER)
    left = [replace(o, centre=(-abs(o.centre[0]) - 50.0, *o.centre[1:])) for o in lamps(60)]
    steps = lit(left, (GROUND, wall)).steps()
    random = np.random.default_rng(5)
    o = np.column_stack([random.uniform(100.0, 800.0, 2048), np.full(2048, -99.0), random.uniform(-800.0, 800.0, 2048)])
    assert np.all(shoot(steps, o, [0.0, -1.0, 0.0], random.random((2, 2048))) == 0.0)
    assert np.all(shoot(steps, o * (-1.0, 1.0, 1.0), [0.0, -1.0, 0.0], random.random((2, 2048))).sum(1) > 0.0)
    both = lit([*left, *lamps(60, seed=7)], (GROUND, wall, BALL))
    assert_same_light(seen(both.steps()), seen(all_taken(both, monkeypatch), seed=4))


@pytest.mark.slow
def test_black_lamps_among_many_change_no_bit():
    random = np.random.default_rng(6)
    black = [replace(o, material=lb.Material((0.0,) * 3, "lamp")) for o in lamps(20, seed=2)]
    o = np.column_stack([random.uniform(-800.0, 800.0, 512), np.full(512, -99.0), np.zeros(512)])
    v = random.random((2, 512))
    with_black, without = (shoot(lit(shapes).steps(), o, [0.0, -1.0, 0.0], v)
                           for shapes in ([*lamps(60), *black], lamps(60)))
    assert np.array_equal(with_black, without)


@pytest.mark.slow
@pytest.mark.parametrize("things", ["moving", "mesh"])
def test_moving_shapes_and_meshes_hide_many_lamps(things, monkeypatch):
    if things == "mesh":
        roof = lb.Mesh.of([[-400, 60, -400], [400, 60, -400], [0, 100, 500]], [[0, 1, 2]], PAPER)
        scene = lit(lamps(60), meshes=(roof,))
        assert names(scene).count("many_lamp_rays") == PICKS
    else:
        roof = lb.Disk((-200.0, 80.0, 0.0), (0.0, 1.0, 0.2), 300.0, PAPER, velocity=(0.0, 0.0, 30.0))
        scene = lit([*lamps(60), replace(lamps(1, seed=9)[0], velocity=(5.0, 0.0, 0.0))], (GROUND, BALL, roof))
    open_, covered = seen(lit(lamps(60)).steps()), seen(scene.steps())
    assert covered[0].sum() < 0.9 * open_[0].sum()
    assert_same_light(covered, seen(all_taken(scene, monkeypatch), seed=4))


@pytest.mark.slow
def test_lamps_are_chosen_by_what_they_give():
    mean, variance = seen(lit(lamps(200)).steps())
    # 0.21 of the mean; 0.34 where the weights leave out the cosines, 0.64 the distance too, 1.9 where all are equal
    assert np.sqrt(variance * SAMPLES).mean() < 0.28 * mean.mean()


@pytest.mark.slow
def test_points_at_another_depth_leave_the_choice_as_it_is():
    steps, v = lit(lamps(200)).steps(), np.random.default_rng(9).random((2, 1024))
    near, far = (-300.0, -99.0, 200.0), (-600.0, 900.0, -700.0)
    alone = shoot(steps, np.tile(near, (1024, 1)), [0.0, -1.0, 0.0], v)[::2]
    beside = shoot(steps, np.tile([near, far], (512, 1)), [0.0, -1.0, 0.0], v)[::2]
    # the mean of the normals is rounded otherwise for half as many of them: a choice may fall on the next lamp
    assert np.isclose(alone, beside, rtol=1e-6).all(1).mean() > 0.99


def test_disks_keep_their_edge_when_the_ratio_of_areas_is_rounded_up():
    """On the axis of a disk as far away as its radius, the light is L sin² 45°; of a square of its area 0.44 L."""
    def ratio(normal):
        a, b = np.array(lb.Disk((0.0, 0.0, 0.0), tuple(normal.tolist()), 10.0).half_axes)
        return 10.0**2 / np.linalg.norm(np.cross(a, b))

    # Which directions these are depends on how the processor's library rounds
    normal = next(normal for normal in np.random.default_rng(1).normal(size=(1000, 3)) if ratio(normal) > 1.0)
    facing = normal / np.linalg.norm(normal)
    disk = lb.Disk(tuple((10.0 * facing).tolist()), tuple(normal.tolist()), 10.0, lb.Material((1.0,) * 3, "lamp"))
    ground = lb.Disk((0.0, 0.0, 0.0), disk.normal, 500.0, lb.Material((1.0,) * 3))
    count, v = 60, np.random.default_rng(1).random((2, 4096))
    found = shoot(lit([disk] * count, (ground,)).steps(), np.tile(facing, (4096, 1)), -facing, v)
    assert found.mean() / count == pytest.approx(0.5, rel=0.03)                         # noise: 0.7 %


@pytest.mark.parametrize("turn", [1, 2])
def test_lamps_have_the_same_shares_whichever_axes_of_the_world_they_lie_along(turn):
    """x, y and z of all points, normals and lamps change places."""
    random, count = np.random.default_rng(4), 60
    table = random.uniform(1.0, 2.0, (COLUMNS, count))
    table[MIDDLE:MIDDLE + 3] = random.uniform(-900.0, 900.0, (3, count))
    facing = random.normal(size=(3, count))
    table[FACING:FACING + 3] = facing / np.linalg.norm(facing, axis=0) * (random.random(count) < 0.8)
    lanes = lane_buffer(np.float64)
    row = lanes.reshape(-1, PITCH)[:, :B]
    normals = random.normal(size=(3, B)) + np.array([[3.0], [-1.0], [2.0]])
    row[X:X + 3], row[NX:NX + 3] = random.uniform(-30.0, 30.0, (3, B)), normals / np.linalg.norm(normals, axis=0)
    row[RED] = 1.0
    one = lamp_shares(lanes, table.ravel(), count).copy()
    for rows, first in ((row, X), (row, NX), (table, MIDDLE), (table, FACING)):
        rows[first:first + 3] = np.roll(rows[first:first + 3], turn, 0)
    assert one.max() > 0.0
    np.testing.assert_allclose(lamp_shares(lanes, table.ravel(), count), one, rtol=1e-9)
