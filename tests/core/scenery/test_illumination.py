"""Light on the scenes' surfaces, mirrors, glass and coats: closed forms, quadrature and conservation.

Slow: the shading in double precision is compiled for these tests alone.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import DEPTH, FINISH, NX, NY, NZ, TB, TG, TR, L, M, N, Step as Stage, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.shading.bounces import specular_bounce
from lensbench.core.scenery.surface_codes import GLASS, METAL
from tests.core.scenery.test_meshes import sphere_mesh
from tests.core.scenery.test_scene import random_rays, shoot, square_lights, unit

pytestmark = pytest.mark.slow
BLACK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
WHITE = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
PAPER = lb.Material((1.0, 1.0, 1.0))
GROUND = lb.Rectangle((0.0, -100.0, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, -1e4), PAPER)
FRESNEL_0 = ((1.5 - 1.0) / (1.5 + 1.0)) ** 2


def seen_on_ground(scene, points, side=64):
    """Mean radiance of the ground at points (n, 2) of x, z, looked at from above, over side² points of the lights."""
    v = square_lights(side)
    out = []
    for x, z in points:
        o = np.tile([x + 3.0, -99.0, z], (side * side, 1))
        out.append(shoot(scene.steps(), o, np.array([x, -100.0, z]) - o, v)[:, 0].mean())
    return np.array(out)


def schlick(cosine):
    return FRESNEL_0 + (1.0 - FRESNEL_0) * (1.0 - cosine) ** 5


# Sky

@pytest.mark.parametrize("material", [PAPER, *(
    pytest.param(lb.Material((1.0,) * 3, *kind), marks=pytest.mark.slow)
    for kind in (("coat",), ("coat", 0.9), ("metal",)))])
def test_white_things_vanish_before_a_white_sky(material):
    # the furnace: whatever reflects all of the light is as bright as what lights it
    scene = lb.Scene("furnace", sky=WHITE, spheres=(lb.Sphere((0.0, 0.0, -500.0), 150.0, material),),
                     plates=(lb.Disk((90.0, 0.0, -300.0), (1.0, 2.0, 3.0), 60.0, material),))
    o, d = random_rays(3000, spread=0.4)
    assert shoot(scene.steps(shadows=False), o, d) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("shape", ["ball", "mesh", "pane"])
def test_glass_vanishes_before_a_white_sky(shape):
    """What glass reflects inside was lost: a ball had 0.9616 in its middle and 0.784 near its rim, a pane 0.963."""
    white = lb.Material((1.0,) * 3, "glass")
    thing = {"ball": {"spheres": (lb.Sphere((0.0, 0.0, -500.0), 100.0, white),)},
             "mesh": {"meshes": (sphere_mesh(40, 100.0, (0.0, 0.0, -500.0), material=white),)},
             "pane": {"plates": (lb.Disk((0.0, 0.0, -500.0), (1.0, 0.3, 1.0), 120.0, white),)}}[shape]
    scene = lb.Scene("furnace", sky=WHITE, **thing)
    o = np.column_stack([100.0 * np.linspace(0.0, 0.97, 20000), np.zeros(20000), np.zeros(20000)])
    light = shoot(scene.steps(), o, [0.0, 0.0, -1.0])[:, 0]
    if shape == "mesh":                         # of the paths of seven rounds: a thousandth is reflected more often
        assert light.mean() == pytest.approx(1.0, abs=2e-3)
    else:
        assert light == pytest.approx(1.0, abs=1e-6)


def test_a_glass_ball_sends_what_it_reflects_inside_where_fresnel_and_snell_say():
    """Before a sky that brightens upwards: the sum over k reflections inside, by turning the ray in its plane."""
    n, height = 200000, 0.7
    scene = lb.Scene("ball", sky=lb.Sky((1.0,) * 3, (0.0,) * 3, (0.0,) * 3), spheres=(
        lb.Sphere((0.0, 0.0, -500.0), 100.0, lb.Material((1.0,) * 3, "glass")),))
    light = shoot(scene.steps(), np.tile([0.0, 100.0 * height, 0.0], (n, 1)), [0.0, 0.0, -1.0])[:, 0]
    outer, inner = math.asin(height), math.asin(height / 1.5)
    f = float(schlick(math.cos(outer)))
    # Deflection towards the axis: 2 (θ − θ′), and π − 2 θ′ more for each reflection inside
    turns = [2.0 * (outer - inner) + k * (math.pi - 2.0 * inner) for k in range(40)]
    wanted = [max(0.0, -math.sin(turn)) for turn in turns]
    expected = f * max(0.0, math.sin(math.pi - 2.0 * outer)) + (1.0 - f) ** 2 * sum(
        f**k * radiance for k, radiance in enumerate(wanted))
    # Of light after four and more reflections, F⁴ < 10⁻⁵, the direction is that after three
    assert light.mean() == pytest.approx(expected, abs=4.0 * light.std() / math.sqrt(n) + f**4)
    assert expected > 1.02 * f * math.sin(math.pi - 2.0 * outer)


@pytest.mark.parametrize("shadows", [False, True])
def test_a_sky_lights_a_surface_as_its_quadrature_says(shadows):
    sky = lb.Sky((0.2, 0.5, 1.0), (1.0, 0.8, 0.6), (0.3, 0.1, 0.0))
    theta = (np.arange(400) + 0.5) / 400 * math.pi
    phi = (np.arange(800) + 0.5) / 800 * 2 * math.pi
    t, q = np.meshgrid(theta, phi, indexing="ij")
    w = np.stack([np.sin(t) * np.cos(q), np.cos(t), np.sin(t) * np.sin(q)], -1)
    solid = np.sin(t) * (math.pi / 400) * (2 * math.pi / 800)
    up = w[..., 1:2]
    radiance = np.where(up >= 0.0, np.array(sky.horizon) + up * (np.array(sky.zenith) - sky.horizon), sky.ground)
    for normal in unit(np.array([(0, 1, 0.01), (0, 0.5, 1), (0, 0, 1), (0, -0.4, 1), (0, -1, 0.01)], float)):
        wanted = (radiance * (np.maximum(w @ normal, 0.0) * solid)[..., None]).sum((0, 1)) / math.pi
        scene = lb.Scene("one", sky=sky, plates=(lb.Disk((0.0, 0.0, -100.0), tuple(normal), 5.0, PAPER),))
        # the quartic instead of the arc cosine is good to 0.002 of zenith − horizon
        assert shoot(scene.steps(shadows), np.array([0.0, 0.0, -100.0]) + 50 * normal, -normal)[0] == pytest.approx(
            wanted, abs=2e-3)


def test_a_sphere_above_the_horizon_holds_off_its_cosine_times_its_solid_angle_over_pi():
    ball = lb.Sphere((0.0, -100.0 + 80.0, 0.0), 60.0, PAPER)
    scene = lb.Scene("one", sky=WHITE, spheres=(ball,), plates=(GROUND,))
    x = np.array([70.0, 120.0, 300.0])
    d2 = x**2 + 80.0**2
    o = np.column_stack([x + 3.0, np.full(3, -99.0), np.zeros(3)])
    seen = shoot(scene.steps(), o, np.column_stack([x, np.full(3, -100.0), np.zeros(3)]) - o)[:, 0]
    assert seen == pytest.approx(1.0 - 60.0**2 / d2 * 80.0 / np.sqrt(d2), abs=1e-9)


def test_what_bulges_holds_no_light_off_itself():
    scene = lb.Scene("one", sky=WHITE, spheres=(lb.Sphere((0.0, 0.0, -500.0), 150.0, PAPER),))
    o, d = random_rays(2000, spread=0.4)
    assert shoot(scene.steps(), o, d) == pytest.approx(1.0, abs=1e-9)


def test_an_enclosed_scene_is_lit_by_its_ambient_light_alone():
    scene = lb.Scene("in", sky=WHITE, enclosed=True, ambient=(0.2, 0.3, 0.4), plates=(GROUND,))
    for shadows in (False, True):
        assert shoot(scene.steps(shadows), np.zeros(3), [0.1, -1.0, -0.2])[0] == pytest.approx((0.2, 0.3, 0.4))
    assert shoot(scene.steps(), np.zeros(3), [0.0, 1.0, 0.0])[0] == pytest.approx(1.0)


# Sun

def test_the_suns_disk_carries_the_light_that_falls_from_it():
    radius = 0.02
    sun = lb.Sun((0.0, 0.6, -0.8), (0.7, 0.5, 0.3), radius)
    scene = lb.Scene("sun", sky=BLACK, sun=sun)
    s = np.array([0.0, 0.6, -0.8])
    across = np.array([1.0, 0.0, 0.0])
    inside, outside = (math.cos(a) * s + math.sin(a) * across for a in (0.999 * radius, 1.001 * radius))
    seen = shoot(scene.steps(), np.zeros(3), np.stack([s, inside, outside]))
    # a disk of radiance L gives the irradiance π L sin² α
    assert seen[:2] * math.sin(radius) ** 2 == pytest.approx(np.array([sun.colour] * 2), rel=1e-6)
    assert np.all(seen[2] == 0.0)


def test_a_penumbra_is_the_part_of_the_suns_disk_above_the_edge():
    radius, height = 0.05, 400.0
    edge = lb.Rectangle((-5000.0, -100.0 + height, 0.0), (5000.0, 0.0, 0.0), (0.0, 0.0, -8000.0), PAPER)
    scene = lb.Scene("sun", sky=BLACK, sun=lb.Sun((0.0, 1.0, 0.0), (1.0,) * 3, radius), plates=(GROUND, edge))
    half = height * math.tan(radius)
    u = np.array([-1.1, -0.8, -0.3, 0.0, 0.5, 0.9, 1.1])
    c = np.clip(u, -1.0, 1.0)
    wanted = 1.0 - (np.arccos(c) - c * np.sqrt(1.0 - c * c)) / math.pi         # a segment of the disk
    # 64² points of the disk: a strip as wide as two of them may be wrong; the sun's cosine is within 0.002 of 1
    assert seen_on_ground(scene, np.column_stack([u * half, np.zeros(7)])) == pytest.approx(wanted, abs=0.02)


def test_spheres_disks_and_rectangles_cast_their_outline():
    sun = lb.Sun((0.0, 1.0, 0.0), (1.0,) * 3, 1e-5)
    things = {lb.Sphere((0.0, 300.0, 0.0), 50.0): lambda x, z: np.hypot(x, z) < 50.0,
              lb.Disk((0.0, 300.0, 0.0), (0.0, 1.0, 0.0), 50.0): lambda x, z: np.hypot(x, z) < 50.0,
              lb.Rectangle((0.0, 300.0, 0.0), (40.0, 0.0, 0.0), (0.0, 0.0, 70.0)):
                  lambda x, z: (abs(x) < 40.0) & (abs(z) < 70.0)}
    points = np.random.default_rng(4).uniform(-100.0, 100.0, (600, 2))
    o = np.column_stack([points[:, 0], np.full(600, -50.0), points[:, 1]])
    for thing, covers in things.items():
        spheres, plates = ((thing,), (GROUND,)) if isinstance(thing, lb.Sphere) else ((), (GROUND, thing))
        scene = lb.Scene("sun", sky=BLACK, sun=sun, spheres=spheres, plates=plates)
        seen = shoot(scene.steps(), o, [0.0, -1.0, 0.0])[:, 0]
        assert seen == pytest.approx(np.where(covers(*points.T), 0.0, 1.0), abs=1e-6)
        assert shoot(scene.steps(shadows=False), o, [0.0, -1.0, 0.0])[:, 0] == pytest.approx(1.0, abs=1e-6)


def test_the_shadow_of_a_glass_ball_keeps_its_light():
    ball = lb.Sphere((0.0, -40.0, 0.0), 50.0, lb.Material((1.0,) * 3, "glass"))
    scene = lb.Scene("sun", sky=BLACK, sun=lb.Sun((0.0, 1.0, 0.0), (1.0,) * 3, 1e-5), spheres=(ball,), plates=(GROUND,))
    rho2 = (np.arange(400) + 0.5) / 400                     # equal areas of the disk below the ball
    o = np.column_stack([50.0 * np.sqrt(rho2), np.full(400, -99.0), np.zeros(400)])
    assert shoot(scene.steps(), o, [0.0, -1.0, 0.0])[:, 0].mean() == pytest.approx(0.85, abs=1e-4)


# Lamps

def lamp_quadrature(light, point, normal, side=600):
    """Irradiance / π at a point from a rectangle or disk of radiance 1, over its front and back."""
    a, b = np.array(light.right), np.array(light.up)
    u = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    p, q = np.meshgrid(u, u, indexing="ij")
    inside = (p * p + q * q <= 1.0) if isinstance(light, lb.Disk) else np.ones_like(p, bool)
    to = np.array(light.centre) + p[..., None] * a + q[..., None] * b - point
    d2 = np.sum(to * to, -1)
    w = to / np.sqrt(d2)[..., None]
    facing = abs(w @ unit(np.cross(a, b)))
    area = 4.0 * math.sqrt((a @ a) * (b @ b)) / side**2
    return (inside * np.maximum(w @ normal, 0.0) * facing / d2).sum() * area / math.pi


@pytest.mark.parametrize("light", [
    lb.Rectangle.facing((300.0, 400.0, -200.0), (0.0, -100.0, 0.0), 250.0, 400.0, lb.Material((1.0,) * 3, "lamp")),
    lb.Disk((-350.0, 250.0, 100.0), (0.5, -1.0, 0.2), 160.0, lb.Material((1.0,) * 3, "lamp")),
    lb.Rectangle((0.0, 20.0, 0.0), (150.0, 0.0, 0.0), (0.0, 90.0, 0.0), lb.Material((1.0,) * 3, "lamp")),
])
def test_a_lamp_gives_what_its_quadrature_gives(light):
    scene = lb.Scene("lamp", sky=BLACK, plates=(GROUND, light))
    points = np.array([(0.0, 40.0), (120.0, -60.0), (-400.0, 300.0)])
    wanted = [lamp_quadrature(light, np.array([x, -100.0, z]), np.array([0.0, 1.0, 0.0])) for x, z in points]
    # both are midpoint rules; the disk's edge is a square's steps in the oracle
    assert seen_on_ground(scene, points) == pytest.approx(np.array(wanted), rel=3e-3)


def test_a_lamp_falls_off_as_the_inverse_square():
    light = lb.Sphere((0.0, 0.0, 0.0), 10.0, lb.Material((1.0,) * 3, "lamp"))
    for distance in (50.0, 100.0, 2000.0):
        ground = lb.Rectangle((0.0, -distance, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, -1e4), PAPER)
        scene = lb.Scene("lamp", sky=BLACK, spheres=(light,), plates=(ground,))
        o = np.tile([3.0, 1.0 - distance, 0.0], (4096, 1))
        d = np.array([0.0, -1.0, 0.0])
        seen = shoot(scene.steps(), o, d, square_lights(64))[:, 0].mean()
        d2 = 3.0**2 + distance**2
        assert seen == pytest.approx(10.0**2 / d2 * distance / math.sqrt(d2), rel=1e-5)   # L cos θ sin² θm


def test_what_stands_behind_a_lamp_casts_no_shadow_from_it():
    material = lb.Material((1.0,) * 3, "lamp")
    lamps = (lb.Disk((0.0, 50.0, 0.0), (0.0, 1.0, 0.0), 20.0, material), lb.Sphere((0.0, 50.0, 0.0), 20.0, material))
    behind = (lb.Disk((0.0, 150.0, 0.0), (0.0, 1.0, 0.0), 80.0), lb.Sphere((0.0, 190.0, 0.0), 80.0))
    wall = lb.Rectangle((500.0, 400.0, 0.0), (0.0, 0.0, 300.0), (0.0, 500.0, 0.0), PAPER)
    # every other ray of a block looks high up the wall, so that the objects between count for the block
    o = np.tile([(63.0, -99.0, 0.0), (400.0, 800.0, 0.0)], (256, 1))
    d = np.tile([(-3.0, -1.0, 0.0), (1.0, 0.0, 0.0)], (256, 1))
    v = np.random.default_rng(2).random((2, 512))

    def seen(*things):
        spheres = tuple(s for s in things if isinstance(s, lb.Sphere))
        plates = (GROUND, wall, *(p for p in things if isinstance(p, lb.Disk)))
        return shoot(lb.Scene("lamp", sky=BLACK, spheres=spheres, plates=plates).steps(), o, d, v)[::2]

    for lamp in lamps:
        alone = seen(lamp)
        assert np.all(alone > 0.0)
        for thing in behind:
            assert seen(lamp, thing) == pytest.approx(alone, rel=1e-9)


def test_light_is_counted_once():
    lamp = lb.Rectangle((0.0, 300.0, 0.0), (50.0, 0.0, 0.0), (0.0, 0.0, 50.0), lb.Material((3.0,) * 3, "lamp"))
    glow = lb.Rectangle((0.0, 300.0, 0.0), (50.0, 0.0, 0.0), (0.0, 0.0, 50.0), lb.Material((3.0,) * 3, "light"))
    other = lb.Sphere((300.0, 300.0, 0.0), 20.0, lb.Material((9.0,) * 3, "lamp"))
    for plate in (lamp, glow):
        scene = lb.Scene("lamp", sky=BLACK, spheres=(other,), plates=(GROUND, plate))
        assert shoot(scene.steps(), np.zeros(3), [0.0, 1.0, 0.01])[0] == pytest.approx(3.0)      # not lit by the other
    alone = lb.Scene("light", sky=BLACK, plates=(GROUND, glow))
    assert shoot(alone.steps(), np.zeros(3), [0.0, -1.0, 0.01])[0] == pytest.approx(0.0)         # only seen


@pytest.mark.parametrize("lamp", [
    lb.Disk((30.0, 500.0, -40.0), (0.3, -0.8, 0.2), 80.0, lb.Material((3.0, 2.0, 1.0), "lamp")),
    lb.Rectangle((30.0, 500.0, -40.0), (70.0, 0.0, 0.0), (0.0, 20.0, 60.0), lb.Material((3.0, 2.0, 1.0), "lamp")),
    lb.Sphere((30.0, 500.0, -40.0), 60.0, lb.Material((3.0, 2.0, 1.0), "lamp"))])
def test_without_shadows_a_lamp_is_a_point_at_its_middle_at_rest_or_not(lamp):
    """It gives L cos θ cos θ′ A / (π d²), a sphere L cos θ times the solid angle over π that it fills."""
    ball = lb.Sphere((30.0, 300.0, -40.0), 50.0, lb.Material((1.0,) * 3, "metal"))      # it would cast a shadow
    scene = lb.Scene("lamp", sky=BLACK, ambient=(0.1,) * 3, spheres=(ball,), plates=(GROUND,))
    x, z = np.random.default_rng(3).uniform(-300.0, 300.0, (2, 40))
    to = np.array(lamp.centre) - np.column_stack([x, np.full(40, -100.0), z])
    d2, cosine = (to**2).sum(1), to[:, 1] / np.sqrt((to**2).sum(1))
    if isinstance(lamp, lb.Sphere):
        light = cosine * 2.0 * (1.0 - np.sqrt(1.0 - lamp.radius**2 / d2))
    else:
        a, b = (np.array(lamp.right), np.array(lamp.up))
        normal = np.cross(a, b) * (math.pi if isinstance(lamp, lb.Disk) else 4.0)       # as long as its area
        light = cosine * abs(to @ normal) / np.sqrt(d2) / (math.pi * d2)
    o, d = np.column_stack([x, np.full(40, -99.0), z]), [0.0, -1.0, 0.0]
    kind = "spheres" if isinstance(lamp, lb.Sphere) else "plates"
    for thing in (lamp, replace(lamp, velocity=(1e-6, 0.0, 0.0))):
        lit = replace(scene, **{kind: (*getattr(scene, kind), thing)})
        assert shoot(lit.steps(shadows=False), o, d)[:, 0] == pytest.approx(0.1 + 3.0 * light, rel=1e-6)


# Mirrors and glass

def test_a_mirror_shows_what_stands_where_its_image_is():
    things = lb.Scene("things", sky=lb.Sky(), floor=lb.Floor(), sun=lb.Sun((0.3, 0.8, 0.6)),
                      spheres=(lb.Sphere((-200.0, -50.0, -300.0), 90.0, lb.Material((0.7, 0.2, 0.1))),))
    mirror = lb.Rectangle((0.0, 0.0, -900.0), (4000.0, 0.0, 0.0), (0.0, 240.0, 0.0), lb.Material((1.0,) * 3, "metal"))
    scene = lb.Scene("mirror", things.sky, things.sun, things.floor, things.spheres, (mirror,))
    random = np.random.default_rng(3)
    d = np.column_stack([random.uniform(-0.3, 0.3, 2000), random.uniform(-0.2, 0.2, 2000), np.full(2000, -1.0)])
    o = np.array([0.0, 0.0, -700.0])
    from_behind = shoot(things.steps(shadows=False), o * (1, 1, -1) + (0.0, 0.0, -1800.0), d * (1, 1, -1))
    # the lift off the mirror, 4e-6 of the coordinates, shifts all by 8 µm of a ball of 90 mm
    apart = np.any(abs(shoot(scene.steps(shadows=False), o, d) - from_behind) > 1e-4, 1)
    assert np.mean(apart) < 2e-3


def refract(d, n, ratio):
    """Snell's law in vectors; n against d, ratio = index before / after."""
    c = -np.sum(d * n, -1, keepdims=True)
    return ratio * d + (ratio * c - np.sqrt(1.0 - ratio**2 * (1.0 - c * c))) * n


def bounced(o, d, t, normal, gloss):
    n = len(d)
    rows = {X: o[:, 0], Y: o[:, 1], Z: o[:, 2], L: d[:, 0], M: d[:, 1], N: d[:, 2], DEPTH: t, FINISH: np.full(n, gloss),
            NX: normal[:, 0], NY: normal[:, 1], NZ: normal[:, 2], TR: np.ones(n), TG: np.ones(n), TB: np.ones(n)}
    out = Program([Stage(specular_bounce)], np.float64).run(rows, [X, Y, Z, L, M, N], n).T
    return out[:, :3], out[:, 3:]


def test_a_glass_ball_is_passed_as_snell_says_twice():
    random = np.random.default_rng(6)
    radius, centre = 40.0, np.array([5.0, -3.0, -200.0])
    aim = centre + radius * 0.9 * unit(random.normal(0, 1, (500, 3)))
    o = random.normal(0.0, 5.0, (500, 3))
    d = unit(aim - o)
    t = lb.Scene("ball", spheres=(lb.Sphere(tuple(centre), radius),)).distance(o, d)
    hit = o + t[:, None] * d
    normal = (hit - centre) / radius
    inner = refract(d, normal, 1 / 1.5)
    chord = -2.0 * np.sum((hit - centre) * inner, 1)
    leave = hit + chord[:, None] * inner
    outer = refract(inner, -(leave - centre) / radius, 1.5)
    point, direction = bounced(o, d, t, normal, GLASS + radius)
    assert direction == pytest.approx(outer, abs=1e-12)
    # lifted off the surface by 4e-6 of the coordinates
    assert np.linalg.norm(point - leave, axis=1) == pytest.approx(0.0, abs=4e-6 * 500)
    assert np.all(np.linalg.norm(point - centre, axis=1) > radius)


def test_a_glass_ball_focuses_near_its_axis_as_a_ball_lens():
    # back focus of a ball: R (2 − n) / (2 (n − 1)), and n = 1.5 gives R / 2
    radius, height = 30.0, 0.01
    depth = radius - math.sqrt(radius**2 - height**2)
    o, d = np.array([[0.0, height, 100.0]]), np.array([[0.0, 0.0, -1.0]])
    normal = np.array([[0.0, height, radius - depth]]) / radius
    point, direction = bounced(o, d, np.array([100.0 - radius + depth]), normal, GLASS + radius)
    axis = point[0, 2] - point[0, 1] * direction[0, 2] / direction[0, 1]
    assert -axis - radius == pytest.approx(radius / 2, rel=1e-3)        # the lift counts for 1e-4 mm of 0.003


def test_a_pane_is_passed_straight_and_metal_mirrors():
    d = unit(np.array([[0.2, -0.3, -1.0]]))
    o, normal, t = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([100.0])
    point, direction = bounced(o, d, t, normal, GLASS)
    assert direction == pytest.approx(d) and point[0, 2] < (100.0 * d)[0, 2]
    point, direction = bounced(o, d, t, normal, METAL)
    assert direction == pytest.approx(d * (1, 1, -1)) and point[0, 2] > (100.0 * d)[0, 2]


@pytest.mark.parametrize("name", ["still-life", "room"])
def test_gated_steps_change_nothing_but_the_time(name):
    steps = lb.builtin_scene(name).steps()
    assert any(step.gated for step in steps)
    o, d = random_rays(3000, seed=9, spread=0.3)
    order = np.argsort(d[:, 1])                             # blocks like rows of a picture: some meet no mirror
    o, d, v = o[order], d[order], np.random.default_rng(1).random((2, 3000))
    always = [step._replace(gated=False) for step in steps]
    assert np.array_equal(shoot(steps, o, d, v), shoot(always, o, d, v))


def test_a_scene_pays_only_for_what_it_has():
    def kernels(scene, shadows=True):
        return [step.kernel.py_func.__name__ for step in scene.steps(shadows)]

    ball = lb.Sphere((0.0, 0.0, -9.0), 1.0)
    plain = lb.Scene("plain", sun=lb.Sun((0.0, 1.0, 0.0)), floor=lb.Floor(), spheres=(ball,))
    assert kernels(plain, shadows=False) == ["gradient_sky", "sun_disk", "floor", "beam", "spheres", "daylight"]
    assert not {"specular_bounce", "clearcoat", "rough_clearcoat", "lamp_rays", "planar"} & set(kernels(plain))
    assert kernels(lb.builtin_scene("white-wall")) == ["gradient_sky", "daylight"]


# Coats

def test_a_coat_shows_a_lamp_by_fresnels_part_and_dims_what_is_below():
    lamp = lb.Disk((0.0, 0.0, 500.0), (0.0, 0.0, 1.0), 100.0, lb.Material((10.0,) * 3, "light"))
    albedo = 0.5
    wall = lb.Rectangle((0.0, 0.0, -100.0), (500.0, 0.0, 0.0), (0.0, 500.0, 0.0), lb.Material((albedo,) * 3, "coat"))
    scene = lb.Scene("coat", sky=BLACK, ambient=(0.4,) * 3, plates=(wall, lamp))
    slope = np.array([0.0, 0.1, 0.3])                       # of the ray; the lamp is 600 mm from the wall
    seen = shoot(scene.steps(), np.zeros(3), np.column_stack([slope, np.zeros(3), -np.ones(3)]))[:, 0]
    f = schlick(1.0 / np.hypot(1.0, slope))
    mirrored = np.where(slope * 700.0 < 100.0, 10.0, 0.0)
    assert seen == pytest.approx(f * mirrored + (1.0 - f) * albedo * 0.4, abs=1e-6)


def test_a_rough_coat_spreads_a_small_light_and_keeps_its_flux():
    # a light far above a black coat, looked at from above: at x a facet of half the ray's slope mirrors it
    height, alpha = 1000.0, 0.05
    light = lb.Sphere((0.0, 1e6, 0.0), 1e3, lb.Material((1e4,) * 3, "light"))
    scene = lb.Scene("wet", sky=BLACK, spheres=(light,),
                     floor=lb.Floor(-height, 100.0, (0.0,) * 3, (0.0,) * 3, gloss=1.0 - alpha))
    x = np.concatenate([np.linspace(0.0, 1000.0, 4001)])
    seen = shoot(scene.steps(), np.zeros(3), np.column_stack([x, np.full(x.size, -height), np.zeros(x.size)]))[:, 0]
    slope = np.tan(np.arctan(x / height) / 2.0)
    # ∫ of radiance over slopes, each as a facet towards the ray shows it = F(0) L Ω / 4: as much as a smooth coat
    # mirrors, within what the tail beyond has
    tilt = np.arctan(slope)
    facing = np.cos(tilt) ** 4 * np.cos(2.0 * tilt)
    flux = np.sum(seen * facing * 2.0 * math.pi * slope * np.gradient(slope))
    omega = math.pi * (1e3 / (1e6 + height)) ** 2
    tail = 1.0 / (1.0 + (slope[-1] / alpha) ** 2)
    assert flux / (FRESNEL_0 * 1e4 * omega / 4.0) == pytest.approx(1.0 - tail, abs=0.03)


@pytest.mark.parametrize("gloss", [0.72, 0.9, 0.99])
def test_a_small_light_in_a_rough_coat_is_as_bright_as_the_facets_that_mirror_it_and_are_not_hidden(gloss):
    # F D G G / (4 cos θ) of Trowbridge and Reitz with Smith's G, from steep to grazing, where it is far from F
    height, alpha2 = 300.0, (1.0 - gloss) ** 2
    light = lb.Sphere((4e6, 1e6, 0.0), 400.0, lb.Material((1e4,) * 3, "light"))
    scene = lb.Scene("wet", sky=BLACK, spheres=(light,),
                     floor=lb.Floor(-height, 100.0, (0.0,) * 3, (0.0,) * 3, gloss=gloss))
    x = np.array([300.0, 900.0, 1200.0, 3000.0, 9000.0, 20000.0])
    points = np.column_stack([x, np.full(x.size, -height), np.zeros(x.size)])
    seen = shoot(scene.steps(), np.zeros(3), points)[:, 0]
    way, to = unit(points), np.array(light.centre) - points
    half, distance = unit(unit(to) - way), np.linalg.norm(to, axis=1)
    facets = alpha2 / (math.pi * (1.0 + (alpha2 - 1.0) * half[:, 1] ** 2) ** 2)
    view, slant = -way[:, 1], unit(to)[:, 1]
    open_ = np.prod([2.0 * c / (c + np.sqrt(alpha2 + (1.0 - alpha2) * c * c)) for c in (view, slant)], 0)
    bright = schlick(np.sum(half * unit(to), 1)) * facets * open_ / (4.0 * view)
    bright *= 1e4 * math.pi * (light.radius / distance) ** 2
    assert seen == pytest.approx(bright, rel=2e-3)


@pytest.mark.parametrize("gloss", [0.8, 0.95, 0.99])
def test_a_large_light_in_a_rough_coat_is_no_brighter_than_itself(gloss):
    light = lb.Sphere((0.0, 2000.0, 0.0), 800.0, lb.Material((2.0,) * 3, "light"))
    black = (0.0,) * 3
    scene = lb.Scene("wet", sky=BLACK, spheres=(light,), floor=lb.Floor(-300.0, 100.0, black, black, gloss=gloss))
    x = np.linspace(0.0, 300.0, 200)
    seen = shoot(scene.steps(), np.zeros(3), np.column_stack([x, np.full(200, -300.0), np.zeros(200)]))[:, 0]
    f = schlick(300.0 / np.hypot(300.0, x))
    assert np.all(seen <= 2.0 * f * (1.0 + 1e-6))
    assert seen[0] > 0.3 * 2.0 * FRESNEL_0


def floors():
    """A floor through the origin of the world, as a planar shape and as a mesh."""
    corners = [[-500.0, 0.0, 500.0], [500.0, 0.0, 500.0], [500.0, 0.0, -500.0], [-500.0, 0.0, -500.0]]
    grey = lb.Material((0.5,) * 3)
    return {"planar": {"plates": (lb.Rectangle((0.0, 0.0, 0.0), (500.0, 0.0, 0.0), (0.0, 0.0, -500.0), grey),)},
            "mesh": {"meshes": (lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], grey),)}}


@pytest.mark.parametrize("kind", floors())
def test_a_floor_through_the_origin_seen_from_afar_does_not_shadow_itself(kind):
    """The points are small numbers there, but off the floor by the rounding of the way from the camera."""
    scene = lb.Scene(kind, sky=BLACK, sun=lb.Sun((0.3, 1.0, 0.2), (1.0, 1.0, 1.0)), **floors()[kind])
    view = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 300, 200), fov=0.03, weights="one",
                                world_from_camera=lb.look_at((0.0, 2000.0, 3000.0), (0.0, 0.0, 0.0)))
    shown = lb.render(view, scene, samples=2)
    assert np.ptp(shown) < 2e-3 * shown.max()           # points of the sun's disk: 1e-3
