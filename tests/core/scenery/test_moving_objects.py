"""Objects that move: at every moment the picture is that of objects at rest in the same places."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench.core.kernels.block import (
    BLUE, FINISH, GREEN, NY, RED, SB, SG, SR, TB, TG, TIME, TR, V0, V1, L, M, N, X, Y, Z
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.moving_objects import to_rest_frame
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.clearcoat import clearcoat
from lensbench.core.scenery.surface_codes import SHARP
from tests.core.imaging.test_animated_transform import DARK, FILM, kernels, turned
from tests.core.scenery.test_scene import unit

LIGHT = lb.Material((1.0,) * 3, "light")
PAPER = lb.Material((0.8, 0.7, 0.6))
triples = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def shoot(steps, o, d, time, v=(0.5, 0.5)):
    """Run the steps over unit rays (n, 3) at times (n,): RED, GREEN, BLUE as (n, 3)."""
    n = len(d)
    o, time = np.broadcast_to(o, (n, 3)), np.broadcast_to(time, (n,))
    given_ = {X: o[:, 0], Y: o[:, 1], Z: o[:, 2], L: d[:, 0], M: d[:, 1], N: d[:, 2], TIME: time,
              V0: np.broadcast_to(v[0], (n,)), V1: np.broadcast_to(v[1], (n,))}
    return Program(steps, np.float64).run(given_, [RED, GREEN, BLUE], n).T


def moved(thing, seconds):
    """The object at rest, in the place where it is then."""
    spin = np.array(thing.spin)
    rate = np.linalg.norm(spin)
    turn = turned(spin if rate > 0.0 else (1.0, 0.0, 0.0), rate * seconds)[:3, :3]
    pivot = np.array(thing.centre if thing.pivot is None else thing.pivot)
    centre = pivot + np.array(thing.velocity) * seconds + turn @ (np.array(thing.centre) - pivot)
    still = {"velocity": (0.0,) * 3, "spin": (0.0,) * 3, "pivot": None, "centre": tuple(centre)}
    if isinstance(thing, lb.Disk):
        still["normal"] = tuple(turn @ thing.normal)
    if isinstance(thing, lb.Rectangle):
        still |= {"right": tuple(turn @ thing.right), "up": tuple(turn @ thing.up)}
    return replace(thing, **still)


def frozen(scene, seconds):
    """The scene at rest as it is then."""
    return replace(scene, spheres=tuple(moved(s, seconds) for s in scene.spheres),
                   plates=tuple(moved(p, seconds) for p in scene.plates))


def crowd(seed, n=12):
    """Balls and plates on a table, some at rest, some that fly, turn, and go round a pivot."""
    random = np.random.default_rng(seed)
    kinds = ("matte", "metal", "glass", "coat")
    balls, flat = [], []
    for j in range(n):
        place = (random.uniform(-300.0, 300.0), random.uniform(-150.0, 200.0), random.uniform(-1500.0, -700.0))
        more = {"material": lb.Material(tuple(random.uniform(0.1, 0.9, 3)), kinds[j // 2 % len(kinds)],
                                        1.0 if j % 2 else 0.9)}
        if j % 4:
            more["velocity"] = tuple(random.normal(0.0, 100.0, 3))
        if j % 4 > 1:
            more["spin"] = tuple(random.normal(0.0, 2.0, 3))
        if j % 4 > 2:
            more["pivot"] = tuple(place + random.normal(0.0, 60.0, 3))
        size = random.uniform(20.0, 60.0)
        balls.append(lb.Sphere(place, size, **more))
        place = tuple(place + random.normal(0.0, 100.0, 3))
        a, b = np.linalg.qr(random.normal(size=(3, 2)))[0].T * size * [[1.5], [0.8]]
        flat.append(lb.Disk(place, tuple(a), size, **more) if j % 2 else
                    lb.Rectangle(place, tuple(a), tuple(b), **more))
    return Scene("crowd", sun=lb.Sun((0.4, 0.8, 0.3), angular_radius=0.05), floor=lb.Floor(-250.0, 90.0),
                 spheres=tuple(balls), plates=tuple(flat))


def rays(n, seed=0, spread=0.4):
    """Rays like rows of a picture: each block is a thin wedge."""
    random = np.random.default_rng(seed)
    d = np.column_stack([np.tile(np.linspace(-spread, spread, 512), n // 512),
                         np.repeat(random.uniform(-0.3, 0.3, n // 512), 512), np.full(n, -1.0)])
    return random.normal(0.0, 5.0, (n, 3)), unit(d)


# Where things are

@pytest.mark.slow
def test_a_ray_meets_what_stands_in_its_way_at_its_time():
    scene, (o, d) = crowd(1), rays(8 * 512)
    time = np.random.default_rng(2).uniform(0.0, 0.7, len(d))
    for opening in (0.0, 2.5, -1.0):
        depth, hit, _ = shoot(scene.depth_steps(opening), o, d, time).T
        found = np.where(hit == 1.0, depth, np.inf)
        for k in range(0, len(d), 61):
            still = frozen(scene, opening + time[k])
            here = still.distance(o[k], d[k])[0]
            assert found[k] == pytest.approx(here, rel=1e-9)
            assert scene.distance(o[k], d[k], opening + time[k])[0] == pytest.approx(here, rel=1e-9)


@pytest.mark.parametrize("time", [0.0, 0.4, 3.0])
def test_a_place_of_a_thing_that_flies_and_turns_is_in_its_rest_frame_where_it_began(time):
    pivot, velocity, spin = np.array([30.0, -20.0, -900.0]), np.array([70.0, -110.0, 40.0]), np.array([0.3, 1.1, -0.7])
    rate = np.linalg.norm(spin)
    place, way = np.array([55.0, 10.0, -860.0]), np.array([0.48, -0.6, 0.64])
    turn = turned(spin, rate * time)[:3, :3]
    there = pivot + velocity * time + turn @ (place - pivot)
    motion = (*pivot, *velocity, *spin / rate, rate / (2.0 * math.pi), 0.0)
    found = to_rest_frame.py_func(np.float64, motion, time, *there, *turn @ way)
    assert found == pytest.approx([*place, *way], abs=1e-9)


@pytest.mark.slow
def test_no_block_passes_by_what_crosses_it_meanwhile():
    # many small and fast things before a wide pupil, all at one time in each of the frozen scenes
    random = np.random.default_rng(5)
    slopes, away = random.uniform(-0.35, 0.35, (60, 2)), random.uniform(300.0, 2000.0, 60)
    balls = tuple(lb.Sphere((float(x * z), float(y * z), -float(z)), float(r), LIGHT, velocity=tuple(v), spin=tuple(w),
                            pivot=tuple(np.array((x * z, y * z, -z)) + w * 30.0))
                  for (x, y), z, r, v, w in zip(slopes, away, random.uniform(1.0, 4.0, 60),
                                                random.normal(0.0, 400.0, (60, 3)), random.normal(0.0, 1.0, (60, 3)),
                                                strict=True))
    scene = Scene("flies", spheres=balls)
    moments = random.uniform(0.0, 0.3, 8)
    for y in np.linspace(-0.3, 0.3, 12):
        d = unit(np.column_stack([np.linspace(-0.4, 0.4, 512), np.full(512, y), np.full(512, -1.0)]))
        o, which = random.uniform(-15.0, 15.0, (512, 3)), random.integers(0, 8, 512)
        depth, hit, _ = shoot(scene.depth_steps(), o, d, moments[which]).T
        found = np.where(hit == 1.0, depth, np.inf)
        for k, moment in enumerate(moments):
            mine = which == k
            assert found[mine] == pytest.approx(frozen(scene, moment).distance(o[mine], d[mine]), rel=1e-6)


@pytest.mark.slow
@settings(max_examples=25)
@given(triples, triples, triples, st.floats(-2.0, 2.0))
def test_the_distance_to_a_moving_thing_is_that_to_one_that_stands_there(velocity, spin, pivot, time):
    more = {"velocity": tuple(100.0 * x for x in velocity), "spin": spin,
            "pivot": tuple(50.0 * x + c for x, c in zip(pivot, (0.0, 0.0, -1000.0), strict=True))}
    scene = Scene("one", spheres=(lb.Sphere((60.0, 0.0, -900.0), 150.0, **more),),
                  plates=(lb.Rectangle((-80.0, 30.0, -1000.0), (150.0, 0.0, 0.0), (0.0, 90.0, 20.0), **more),))
    o, d = rays(512, spread=0.3)
    depth, hit, _ = shoot(scene.depth_steps(), o, d, time).T
    found, wanted = np.where(hit == 1.0, depth, np.inf), frozen(scene, time).distance(o, d)
    edge = np.isfinite(found) != np.isfinite(wanted)                # a ray may graze an edge
    assert edge.sum() <= 1
    assert found[~edge] == pytest.approx(wanted[~edge], rel=1e-7)


# What they look like

# instead of the floor, whose mirror image is lit as it is below the balls at 0 s
TABLE = lb.Rectangle((0.0, -250.0, -1000.0), (2000.0, 0.0, 0.0), (0.0, 0.0, -2000.0), lb.Material((0.4,) * 3, "coat"))
CROWD = crowd(3)
GLOSSY = tuple(lb.Sphere((x, y, -700.0), 90.0, lb.Material((0.3, 0.2, 0.1), "coat", gloss))
               for x, y, gloss in ((-130.0, 60.0, 1.0), (90.0, 60.0, 0.8)))
LAMPS = (lb.Rectangle((500.0, 400.0, -900.0), (80.0, 0.0, 0.0), (0.0, 60.0, 60.0), lb.Material((9.0,) * 3, "lamp"),
                      velocity=(-300.0, 100.0, 50.0), spin=(0.5, 1.0, -2.0), pivot=(450.0, 300.0, -800.0)),
         lb.Sphere((-500.0, 300.0, -700.0), 40.0, lb.Material((20.0,) * 3, "lamp"), velocity=(200.0, -50.0, 0.0)))


@pytest.mark.slow
@pytest.mark.parametrize("shadows", [False, True])
@pytest.mark.parametrize("moment", [0.0, 0.31])
def test_light_and_shadow_are_those_of_the_scene_as_it_stands_then(moment, shadows):
    scene = replace(CROWD, floor=None, plates=(*CROWD.plates, TABLE, LAMPS[0]),
                    spheres=(*CROWD.spheres, *GLOSSY, LAMPS[1]))
    o, d = rays(6 * 512, seed=4)
    v = np.random.default_rng(6).random((2, len(d))) if shadows else (0.5, 0.5)     # or the middle of each lamp
    here = shoot(scene.steps(shadows, opening=2.0 - moment), o, d, moment, v)
    wanted = shoot(frozen(scene, 2.0).steps(shadows), o, d, 0.0, v)
    # an edge or a mirrored ray may fall to the other side by a digit
    assert np.mean(np.any(abs(here - wanted) > 1e-7 + 1e-7 * wanted, 1)) < 2e-3


@pytest.mark.slow
def test_a_coat_mirrors_a_lamp_where_it_is():
    scene = Scene("mirror", sky=DARK, plates=(TABLE, LAMPS[0]), spheres=(LAMPS[1],))
    moments = np.linspace(0.0, 0.7, 8)
    for lamp in LAMPS:
        # towards the lamp's image below the table
        images = np.array([np.multiply(moved(lamp, t).centre, (1.0, -1.0, 1.0)) for t in moments]) - (0.0, 500.0, 0.0)
        seen = shoot(scene.steps(), np.zeros(3), unit(images), moments)
        for k, t in enumerate(moments):
            still = frozen(scene, t)
            assert seen[k] == pytest.approx(shoot(still.steps(), np.zeros(3), unit(images[k:k + 1]), 0.0)[0], rel=1e-9)
            dull = replace(TABLE, material=lb.Material((0.4,) * 3))
            matte = replace(still, plates=(dull, *still.plates[1:]))
            plain = shoot(matte.steps(), np.zeros(3), unit(images[k:k + 1]), 0.0)
            assert seen[k, 0] > plain[0, 0] + 0.02 * lamp.material.colour[0]        # a coat mirrors 4 % at least


@pytest.mark.parametrize("lamp", [LAMPS[0], lb.Disk((400.0, 350.0, -900.0), (-0.5, -0.6, 0.2), 90.0, LIGHT,
                                                    velocity=(-200.0, 100.0, 50.0), spin=(0.5, 1.0, -2.0))])
def test_a_sharp_coat_shows_a_flat_lamp_within_its_edge_and_no_further(lamp):
    """Fresnel's part of its light, as Schlick has it, at places within the lamp and none beside it; the stage alone.

    The last places lie on the axes of the lamp, just within its edge and just beside it.
    """
    scene = Scene("mirror", sky=DARK, plates=(TABLE, lamp))
    (step,) = [step for step in scene.steps() if step.kernel is clearcoat]
    place, moments = np.array([20.0, -250.0, -1000.0]), np.tile([0.0, 0.2, 0.5], 3)
    still = [moved(lamp, t) for t in moments]
    for share, turn, lit in ((0.6, 1.0, 1.0), (1.5, 1.0, 0.0), (0.97, 0.5 * math.pi, 1.0), (1.03, 0.5 * math.pi, 0.0)):
        aims = np.array([o.centre + share * (np.array([math.cos(k * turn), math.sin(k * turn)]) @ (o.right, o.up))
                         for k, o in enumerate(still)])
        x, y, z = unit(aims - place).T
        ones = np.ones(9)
        given_ = {X: place[0] * ones, Y: place[1] * ones, Z: place[2] * ones, L: x, M: -y, N: z, NY: ones,
                  TIME: moments, FINISH: SHARP * ones, TR: ones, TG: ones, TB: ones}
        seen = Program([step], np.float64).run(given_, [SR, SG, SB], 9).T
        wanted = lit * (0.04 + 0.96 * (1.0 - y[:, None]) ** 5) * lamp.material.colour
        np.testing.assert_allclose(seen, wanted, rtol=1e-9)


@pytest.mark.slow
def test_every_lane_sees_the_shadow_of_its_own_time():
    ground = lb.Rectangle((0.0, -100.0, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, -1e4), lb.Material((1.0,) * 3))
    sun = lb.Sun((0.0, 1.0, 0.0), (1.0,) * 3, 1e-5)
    shade = lb.Rectangle((0.0, 300.0, 0.0), (40.0, 0.0, 0.0), (0.0, 0.0, 60.0), velocity=(100.0, 0.0, 0.0),
                         spin=(0.0, math.pi, 0.0))
    scene = Scene("sun", sky=DARK, sun=sun, plates=(ground, shade))
    random = np.random.default_rng(4)
    x, z, time = random.uniform(-150.0, 250.0, 2000), random.uniform(-120.0, 120.0, 2000), random.random(2000)
    o = np.column_stack([x, np.full(2000, -50.0), z])
    seen = shoot(scene.steps(), o, np.tile([0.0, -1.0, 0.0], (2000, 1)), time)[:, 0]
    # in the shade's own axes, turned about y by −π t from where it is
    c, s = np.cos(math.pi * time), np.sin(math.pi * time)
    u, w = c * (x - 100.0 * time) - s * z, s * (x - 100.0 * time) + c * z
    assert seen == pytest.approx(np.where((abs(u) < 40.0) & (abs(w) < 60.0), 0.0, 1.0), abs=1e-9)


@pytest.mark.slow
def test_a_moving_ball_holds_off_the_skys_light_where_it_is():
    white = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    ground = lb.Rectangle((0.0, -100.0, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, -1e4), lb.Material((1.0,) * 3))
    ball = lb.Sphere((-50.0, -20.0, 0.0), 60.0, velocity=(400.0, 0.0, 0.0))
    time = np.linspace(0.0, 0.5, 200)
    o = np.column_stack([np.full(200, 400.0), np.full(200, -99.0), np.zeros(200)])
    seen = shoot(Scene("one", sky=white, spheres=(ball,), plates=(ground,)).steps(), o,
                 np.tile([0.0, -1.0, 0.0], (200, 1)), time)[:, 0]
    d2 = (400.0 + 50.0 - 400.0 * time) ** 2 + 80.0**2
    assert seen == pytest.approx(1.0 - 60.0**2 / d2 * 80.0 / np.sqrt(d2), abs=1e-9)


@pytest.mark.slow
def test_a_pattern_spins_with_its_plate():
    star = lb.Material((0.75,) * 3, "light", pattern=lb.Pattern("star", (0.25,) * 3, columns=6.0))
    wheel = lb.Disk((0.0, 0.0, -1000.0), (0.0, 0.0, 1.0), 100.0, star, spin=(0.0, 0.0, 3.0))
    random = np.random.default_rng(1)
    angle, time = random.uniform(0.0, 2.0 * math.pi, 1500), random.uniform(0.0, 2.0, 1500)
    d = unit(np.column_stack([60.0 * np.cos(angle), 60.0 * np.sin(angle), np.full(1500, -1000.0)]))
    seen = shoot(Scene("wheel", sky=DARK, plates=(wheel,)).steps(), np.zeros(3), d, time, )[:, 0]
    sector = np.mod(angle - 3.0 * time, 2.0 * math.pi) * 6.0 / math.pi
    clear = abs(sector - np.round(sector)) > 1e-3                   # the pattern's arc tangent is good to 1e-5
    assert seen[clear] == pytest.approx(np.where(sector[clear] // 1 % 2 == 1, 0.25, 0.75))


# Pictures

def lit(camera, scene, samples):
    """The part of each pixel that is lit: the picture over that of a white wall."""
    white = lb.render(camera, lb.builtin_scene("white-wall"), samples=64)
    return (lb.render(camera, scene, samples=samples) / white)[..., 0]


@pytest.mark.slow
@pytest.mark.parametrize("ramp", [0.0, 0.2])
def test_the_blur_of_a_thing_that_passes_is_the_cumulative_of_the_shutter(ramp):
    """1 mm at 1 m is 1 px: an edge at 80 mm/s, from x = 0 on to the right; 0.5 s open."""
    plate = lb.Rectangle((-5000.0, 0.0, -1000.0), (5000.0, 0.0, 0.0), (0.0, 9e3, 0.0), LIGHT, velocity=(80.0, 0.0, 0.0))
    camera = lb.PerspectiveCamera(FILM, fov=2.0 * math.atan(0.040), shutter_close=0.5, shutter_ramp=ramp)
    line = lit(camera, Scene("edge", sky=DARK, plates=(plate,)), 256).mean(0)
    x = (np.arange(120 * 50) + 0.5) / 50
    passed = np.clip((x - 60.0) / 80.0, 0.0, 0.5)
    grid = np.linspace(0.0, 0.5, 5001)
    through = np.ones_like(grid) if ramp == 0.0 else np.clip(np.minimum(grid, 0.5 - grid) / ramp, 0.0, 1.0)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (through[1:] + through[:-1]))])
    wanted = 1.0 - np.interp(passed, grid, area / area[-1])
    np.testing.assert_allclose(line, wanted.reshape(120, 50).mean(1), atol=2e-3)       # 80 lines of 256 samples


@pytest.mark.slow
@pytest.mark.parametrize(("direction", "sign"), [("down", 1.0), ("up", -1.0)])
def test_a_rolling_shutter_leans_what_passes_by_speed_times_readout(direction, sign):
    plate = lb.Rectangle((-5000.0, 0.0, -1000.0), (5000.0, 0.0, 0.0), (0.0, 9e3, 0.0), LIGHT, velocity=(30.0, 0.0, 0.0))
    camera = lb.PerspectiveCamera(FILM, fov=2.0 * math.atan(0.040), shutter_open=1.0, shutter_close=1.0, readout=0.8,
                                  readout_direction=direction)
    edge = lit(camera, Scene("edge", sky=DARK, plates=(replace(plate, centre=(-5030.0, 0.0, -1000.0)),)), 256).sum(1)
    place = (np.arange(80) + 0.5) / 80
    wanted = 60.0 + 30.0 * 0.8 * (place if sign > 0.0 else 1.0 - place)
    np.testing.assert_allclose(edge, wanted, atol=0.04)             # two pixels of 64 samples and more share an edge


@pytest.mark.slow
def test_a_scene_in_motion_is_the_same_bit_for_bit_for_any_number_of_threads():
    camera = lb.PerspectiveCamera(lb.Film(pixels_x=60, pixels_y=40), lens_radius=8.0, focus_distance=1000.0,
                                  shutter_close=0.3, readout=0.1)
    pictures = [lb.render(camera, crowd(3), samples=3, seed=7, threads=threads) for threads in (1, 2, 5)]
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert np.isfinite(pictures[0]).all()
    assert not np.array_equal(pictures[0], lb.render(camera, frozen(crowd(3), 0.0), samples=3, seed=7))


@pytest.mark.slow
def test_depth_is_that_of_things_where_they_are_at_that_time():
    wall = lb.Rectangle((0.0, 0.0, -1700.0), (9e3, 0.0, 0.0), (0.0, 9e3, 0.0), velocity=(0.0, 0.0, 400.0))
    camera = lb.PerspectiveCamera(FILM, shutter_open=1.0, shutter_close=2.0)
    for time in (0.0, 0.5):
        np.testing.assert_allclose(lb.depth_map(camera, Scene("wall", plates=(wall,)), time), 1300.0 - 400.0 * time,
                                   rtol=1e-6)


# What it costs

@pytest.mark.slow
def test_only_what_moves_is_paid_for():
    ball, sun = lb.Sphere((0.0, 0.0, -900.0), 50.0, PAPER), lb.Sun((0.0, 1.0, 0.0))
    still = Scene("one", sun=sun, floor=lb.Floor(), spheres=(ball,))
    assert not still.moves
    assert kernels(still.steps()) == kernels(still.steps(opening=5.0)) == [
        "begin_path", "gradient_sky", "sun_disk", "floor", "beam", "spheres", "gather_emission", "ambient", "sun_rays",
        "shadows", "add_lit", "finish_path"]
    flying = replace(still, spheres=(ball, replace(ball, velocity=(1.0, 0.0, 0.0))))
    assert flying.moves and flying != still
    assert kernels(flying.steps()) == [
        "begin_path", "gradient_sky", "sun_disk", "floor", "beam", "spheres", "moving", "gather_emission", "ambient",
        "sun_rays", "shadows", "add_lit", "finish_path"]
    assert kernels(flying.steps(shadows=False)) == [
        "gradient_sky", "sun_disk", "floor", "beam", "spheres", "moving", "daylight"]
    light = lb.Sphere((9.0, 0.0, -900.0), 5.0, LIGHT, velocity=(1.0, 0.0, 0.0))
    occluders, with_light = ([step.parameters for step in replace(still, spheres=spheres).steps()
                              if step.kernel.__name__ == "shadows"] for spheres in ((ball,), (ball, light)))
    np.testing.assert_array_equal(occluders, with_light)                            # a light casts no shadow
    camera = lb.PerspectiveCamera(FILM)
    assert "sample_times" not in kernels(lb.Rendering(camera, still)._programs.before)
    assert "sample_times" in kernels(lb.Rendering(camera, flying)._programs.before)


@pytest.mark.parametrize("make", [
    lambda: lb.Sphere((0.0, 0.0, 0.0), 1.0, velocity=(math.nan, 0.0, 0.0)),
    lambda: lb.Disk((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0, spin=(0.0, math.inf, 0.0)),
    lambda: lb.Rectangle((0.0,) * 3, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), pivot=(math.nan, 0.0, 0.0))])
def test_motion_that_is_no_number_is_refused(make):
    with pytest.raises(lb.SceneError, match="must be a finite number"):
        make()


@pytest.mark.slow
def test_the_fairground_is_the_same_in_single_precision_at_every_moment():
    scene = lb.builtin_scene("fairground")
    o, d = rays(10 * 512, seed=7)
    random = np.random.default_rng(8)
    given_ = {X: o[:, 0], Y: o[:, 1], Z: o[:, 2], L: d[:, 0], M: d[:, 1], N: d[:, 2],
              TIME: random.uniform(0.0, 0.1, len(d)),
              V0: random.random(len(d)), V1: random.random(len(d))}
    single, double = (Program(scene.steps(opening=40.0), real).run(given_, [RED, GREEN, BLUE], len(d)).T
                      for real in (np.float32, np.float64))
    # an edge falls to the other side, or a mirrored ray finds another light, for a few rays in a thousand
    apart = np.any(abs(single - double) > 2e-3 + 0.01 * double, 1)
    assert np.isfinite(single).all() and np.mean(apart) < 0.012


@pytest.mark.slow
def test_what_is_seen_at_a_moment_does_not_depend_on_when_the_shutter_opened():
    """A wheel of plates that swing about a pivot and fly: at 0.7 s after 0, and at 0.2 s after 0.5."""
    spokes = tuple(lb.Rectangle((80.0 * math.cos(a), 80.0 * math.sin(a), -900.0 - 20.0 * k),
                                (60.0 * math.cos(a), 60.0 * math.sin(a), 10.0),
                                (-9.0 * math.sin(a), 9.0 * math.cos(a), 0.0),
                                velocity=(40.0, -30.0, 20.0), spin=(0.3, 0.0, 1.9), pivot=(0.0, 0.0, -900.0))
                   for k, a in enumerate(np.linspace(0.0, 5.0, 5)))
    balls = tuple(lb.Sphere((150.0, 10.0 * k, -950.0), 25.0, velocity=(0.0, 20.0, 0.0), spin=(0.0, 0.0, -1.1),
                            pivot=(0.0, 0.0, -950.0)) for k in range(3))
    scene = Scene("wheel", sky=DARK, spheres=balls, plates=spokes)
    film = lb.Film(36.0, 24.0, 90, 60)
    early, late = (lb.depth_map(lb.PerspectiveCamera(film, fov=0.6, shutter_open=opening, shutter_close=opening + 1.0),
                                scene, 0.7 - opening) for opening in (0.0, 0.5))
    moved = lb.depth_map(lb.PerspectiveCamera(film, fov=0.6, shutter_close=1.0), scene, 0.2)
    there = np.isfinite(early)
    assert 0.02 < there.mean() < 0.9 and (np.isfinite(moved) != there).mean() > 0.01
    same = np.isfinite(late) == there               # but for rays along an edge
    assert same.mean() > 0.998
    np.testing.assert_allclose(late[same & there], early[same & there], rtol=1e-3)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_ball_that_flies_through_a_narrow_block_of_rays_is_met_at_its_times(axis):
    random = np.random.default_rng(axis)
    velocity = tuple(4000.0 * np.eye(3)[axis])
    scene = Scene("ball", spheres=(lb.Sphere(tuple(np.array((0.0, 0.0, -2000.0)) - 0.15 * np.array(velocity)), 80.0,
                                             LIGHT, velocity=velocity),))
    o, time = random.uniform(-2.0, 2.0, (512, 3)), random.uniform(0.0, 0.3, 512)
    d = unit(np.column_stack([random.uniform(-1e-3, 1e-3, (512, 2)), np.full(512, -1.0)]))
    depth, hit, _ = shoot(scene.depth_steps(), o, d, time).T
    to = np.array(scene.spheres[0].centre) + time[:, None] * velocity - o
    along = (to * d).sum(1)
    inside = 80.0**2 - (to**2).sum(1) + along**2
    assert 10 < (inside > 0.0).sum()
    np.testing.assert_array_equal(hit == 1.0, inside > 0.0)
    np.testing.assert_allclose(depth[inside > 0.0], (along - np.sqrt(np.maximum(inside, 0.0)))[inside > 0.0], rtol=1e-9)
