"""Light tracing by mirrors, panes and balls: every light appears in its place, and once."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.rendering.light_rays import connect_by_ball, specular_objects, visible_lights
from lensbench.core.scenery.objects.basic_shapes import Disk, Rectangle, Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.illumination import INDEX
from lensbench.core.scenery.small_lights import small_lights

BLACK = (0.0, 0.0, 0.0)
DARK = Sky(BLACK, BLACK, BLACK)
FILM = lb.Film(36.0, 24.0, 90, 60)
LIGHT = Material((40.0, 30.0, 20.0), "light")
TINT = (0.9, 0.8, 0.7)
THINGS = {
    "a mirror": Rectangle((-100.0, -150.0, -1600.0), (700.0, 0.0, 0.0), (0.0, 0.0, -900.0), Material(TINT, "metal")),
    "a round mirror": Disk((0.0, -180.0, -1500.0), (0.1, 1.0, 0.05), 480.0, Material(TINT, "metal")),
    "a pane": Rectangle((60.0, 0.0, -2000.0), (500.0, 0.0, 120.0), (0.0, 700.0, 0.0), Material(TINT, "glass")),
    "a metal ball": Sphere((-40.0, -60.0, -1500.0), 200.0, Material(TINT, "metal")),
    "a glass ball": Sphere((40.0, 20.0, -1500.0), 200.0, Material(TINT, "glass"))}
CASES = [(name, model) for name in ("a mirror", "a round mirror", "a pane") for model in ("trace", "thin", "pinhole")]
CASES += [(name, model) for name in ("a metal ball", "a glass ball") for model in ("near", "near pinhole")]


def camera(model):
    if model.startswith("near"):
        return lb.PerspectiveCamera(FILM, fov=0.25, lens_radius=0.0 if model == "near pinhole" else 15.0,
                                    focus_distance=1300.0)
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1300.0, 2.0, model=model)


def lights(size, behind=False):
    """Lights that the camera sees straight, in the objects, or both; or lights behind the camera."""
    return tuple(Sphere((x, y, away if behind else -away), size * away, LIGHT) for x, y, away in (
        (-700.0, 420.0, 5200.0), (900.0, 900.0, 7000.0), (150.0, 300.0, 3100.0), (-1600.0, 500.0, 6000.0)))


def pictures(scene, model, samples, own=128):
    rendering, plain = (lb.Rendering(camera(model), scene, seed=3 + traced, light_tracing=traced)
                        for traced in (True, False))
    rendering.add(own)
    plain.add(samples)
    return rendering, rendering.image().astype(float), plain.image().astype(float)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "model"), CASES)
def test_light_by_a_specular_object_is_that_of_the_cameras_rays(name, model):
    """Within four times the noise of so many of the camera's rays as meet a light; less, by their even places.

    The light that is seen straight is the same either way; it is subtracted, with the object black.
    """
    thing, metal = THINGS[name], name == "a metal ball"
    ball = isinstance(thing, Sphere)
    black = Material(BLACK)
    spots = lights(0.003 if model == "pinhole" else 0.04 if metal else 0.008, behind=metal)

    def scene(seen):
        return Scene("by one thing", sky=DARK, spheres=(*((seen,) if ball else ()), *spots),
                     plates=() if ball else (seen,))

    rendering, found, plain = pictures(scene(thing), model, 4096)
    assert rendering._light_image.excluded.bends == {scene(thing).objects.index(thing)}
    straight, _, without = pictures(scene(replace(thing, material=black) if ball else Rectangle(
        thing.centre, thing.right, thing.up, black)), model, 4096)
    found, plain = found.sum((0, 1)) - straight.image().astype(float).sum((0, 1)), (plain - without).sum((0, 1))
    rays = plain[0] / LIGHT.colour[0] * 4096
    assert rays > 1000
    np.testing.assert_allclose(found, plain, rtol=4.0 / math.sqrt(rays))


@pytest.mark.parametrize("kind", ["metal", "glass"])
@settings(max_examples=200)
@given(st.floats(-1.3, 1.3), st.floats(3.0, 60.0), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_the_path_by_a_ball_obeys_the_laws_of_reflection_and_refraction(kind, angle, far, x, y):
    """Snell's law and the mirror's, in their vector form, from the ball's own surface on: the ray meets the point."""
    centre, radius = np.array([30.0, -20.0, -1000.0]), 100.0
    start = np.array([x, y, 0.0]) * 1000.0
    point = centre + far * radius * np.array([math.sin(angle) * 0.6, math.sin(angle) * 0.8, -math.cos(angle)])
    if kind == "metal":
        point[2] = 2.0 * centre[2] - point[2]
    ball = np.array([[*centre, radius, 1.0 if kind == "metal" else -1.0]])
    d, passing, miss = connect_by_ball(start[None], point[None], ball)
    d = d[0]
    assert miss[0] <= 0.0 or kind == "glass"
    if miss[0] > -1e-3:                                     # grazing: the path is hardly there
        return
    assert np.linalg.norm(d) == pytest.approx(1.0, abs=1e-12)
    at, way = _onwards(start, d, centre, radius, kind)
    to = point - at
    assert np.linalg.norm(np.cross(way, to)) < 1e-6 * np.linalg.norm(to) * far
    assert way @ to > 0.0
    assert passing[0] == pytest.approx(np.linalg.norm(np.cross(d, centre - start)), rel=1e-9, abs=1e-9)


def _onwards(origin, direction, centre, radius, kind):
    """The ray after a ball: a point on it, and its direction."""
    def surface(o, d, last):
        to = o - centre
        half = to @ d
        root = math.sqrt(half * half - to @ to + radius * radius)
        point = o + d * (-half + root if last else -half - root)
        return point, (point - centre) / radius

    def refracted(d, normal, ratio):
        cosine = -(d @ normal)
        return ratio * d + (ratio * cosine - math.sqrt(1.0 - ratio * ratio * (1.0 - cosine * cosine))) * normal

    point, normal = surface(origin, direction, False)
    if kind == "metal":
        return point, direction - 2.0 * (direction @ normal) * normal
    inside = refracted(direction, normal, 1.0 / INDEX)
    point, normal = surface(point, inside, True)
    return point, refracted(inside, -normal, INDEX)


@pytest.mark.slow
def test_no_visible_light_is_taken_for_an_invisible_one():
    """Rays from all over the eye by each object: the lights that they meet are visible or undecided."""
    random = np.random.default_rng(7)
    balls = tuple(Sphere(tuple(random.uniform((-3000.0, -1500.0, -9000.0), (3000.0, 2500.0, 500.0))),
                         random.uniform(10.0, 60.0), LIGHT) for _ in range(400))
    things = tuple(THINGS.values())
    spheres = tuple(t for t in things if isinstance(t, Sphere))
    plates = tuple(t for t in things if not isinstance(t, Sphere))
    scene = Scene("all", spheres=(*spheres, *balls), plates=plates)
    eye, reach, n = np.zeros(3), 40.0, 40000
    origins = random.normal(size=(n, 3))
    origins *= (reach * random.random(n) ** (1 / 3) / np.linalg.norm(origins, axis=1))[:, None]
    small = small_lights(scene.objects)
    centres, radii = np.array([light.centre for light in small]), np.array([light.radius for light in small])
    for mirror in specular_objects(scene, np.eye(3), np.zeros(3)):
        thing = scene.objects[mirror.number]
        there, odd = visible_lights(mirror, centres, radii, eye, reach)
        assert there.any() and (~there & ~odd).sum() > 10
        target = np.asarray(thing.centre) + (
            random.normal(size=(n, 3)) * thing.radius * 0.5 if mirror.radius > 0.0
            else random.uniform(-1, 1, (n, 1)) * thing.right + random.uniform(-1, 1, (n, 1)) * thing.up)
        met = set()
        for o, d in zip(origins[:4000], (target - origins)[:4000], strict=True):
            d = d / np.linalg.norm(d)
            after = _after(thing, mirror, o, d)
            if after is None:
                continue
            to = centres - after[0]
            along = to @ after[1]
            met |= set(np.nonzero((along > 0.0) & ((to**2).sum(1) - along**2 < radii**2))[0].tolist())
        assert len(met) > 10
        assert all(there[j] or odd[j] for j in met)


def _after(thing, mirror, o, d):
    if mirror.radius > 0.0:
        to = o - mirror.centre
        if (to @ d) ** 2 - to @ to + mirror.radius**2 <= 0.0:
            return None
        return _onwards(o, d, mirror.centre, mirror.radius, "metal" if mirror.metal else "glass")
    normal = np.cross(thing.right, thing.up)
    normal /= np.linalg.norm(normal)
    at = o + d * (((mirror.centre - o) @ normal) / (d @ normal))
    u, v = ((at - mirror.centre) @ axis / (np.asarray(axis) @ axis) for axis in (thing.right, thing.up))
    if (u * u + v * v > 1.0) if mirror.disk else max(abs(u), abs(v)) > 1.0:
        return None
    return at, d - 2.0 * (d @ normal) * normal if mirror.metal else d


def test_an_object_between_mirror_and_light_hides_the_image():
    mirror = THINGS["a mirror"]
    light = Sphere((150.0, 400.0, -4100.0), 30.0, LIGHT)
    wall = Rectangle((95.0, 90.0, -2900.0), (90.0, 0.0, 0.0), (0.0, 110.0, 0.0), Material(BLACK))
    scene = Scene("hidden", sky=DARK, spheres=(light,), plates=(mirror, wall))
    rendering, found, plain = pictures(scene, "trace", 2048)
    assert rendering._light_image.excluded.bends == {1}
    without = lb.Rendering(camera("trace"), Scene("open", sky=DARK, spheres=(light,), plates=(mirror,)))
    without.add(64)
    assert 0.3 < found.sum() / without.image().astype(float).sum() < 0.95
    np.testing.assert_allclose(found.sum((0, 1)), plain.sum((0, 1)), rtol=8e-3)


@pytest.mark.slow
def test_the_night_is_as_bright_as_by_the_cameras_rays():
    """The table's mirror, the crystal ball, the wet street: 16 passes against 2048 samples, whose noise is 0.1 %."""
    scene = lb.builtin_scene("night-lights")
    rendering, found, plain = pictures(scene, "trace", 2048, 16)
    assert len(rendering._light_image.excluded.bends) == 3
    np.testing.assert_allclose(found.sum((0, 1)), plain.sum((0, 1)), rtol=3e-3)


@pytest.mark.parametrize("name", ["a mirror", "a round mirror", "a pane"])
def test_a_point_is_seen_by_a_flat_object_where_the_line_to_its_image_crosses_it(name):
    random = np.random.default_rng(5)
    thing, centres = THINGS[name], random.uniform((-2500.0, -1500.0, -6000.0), (2500.0, 1500.0, 500.0), (4000, 3))
    (flat,) = specular_objects(Scene("one", plates=(thing,)), np.eye(3), np.zeros(3))
    middle, right, up = (np.array(each) for each in (thing.centre, *thing.half_axes))
    normal = np.cross(right, up) / np.linalg.norm(np.cross(right, up))
    high = (centres - middle) @ normal
    images = centres - 2.0 * high[:, None] * normal if name != "a pane" else centres
    for eye in np.array([[0.0, 0.0, 0.0], [150.0, 90.0, 30.0]]):
        own = (eye - middle) @ normal
        at = eye + (own / (own - (images - middle) @ normal))[:, None] * (images - eye) - middle
        u, v = (at @ axis / (axis @ axis) for axis in (right, up))
        inside = u * u + v * v <= 1.0 if name == "a round mirror" else np.maximum(abs(u), abs(v)) <= 1.0
        there, odd = visible_lights(flat, centres, np.full(4000, 1e-9), eye, 1e-9)
        assert not odd.any() and 100 < there.sum() < 3900
        np.testing.assert_array_equal(there, inside & ((high * own > 0.0) == (name != "a pane")))


@pytest.mark.parametrize("name", ["a mirror", "a round mirror", "a pane"])
def test_a_light_that_some_point_of_the_eye_sees_by_a_flat_object_is_visible(name):
    """Lines from points of the eye to points of the light's image, where they cross the object."""
    random, thing, reach, n = np.random.default_rng(6), THINGS[name], 150.0, 300
    centres = random.uniform((-2500.0, -1500.0, -6000.0), (2500.0, 1500.0, 500.0), (600, 3))
    radii = random.uniform(50.0, 500.0, 600)
    (flat,) = specular_objects(Scene("one", plates=(thing,)), np.eye(3), np.zeros(3))
    middle, right, up = (np.array(each) for each in (thing.centre, *thing.half_axes))
    normal = np.cross(right, up) / np.linalg.norm(np.cross(right, up))
    there, odd = visible_lights(flat, centres, radii, np.zeros(3), reach)
    ways = random.normal(size=(2, n, 3))
    eyes, ends = ways / np.linalg.norm(ways, axis=2)[..., None]
    eyes, seen = reach * eyes, np.zeros(600, bool)
    for j in np.flatnonzero(~odd):
        points = centres[j] + radii[j] * ends
        high, own = (points - middle) @ normal, (eyes - middle) @ normal
        images = points - 2.0 * high[:, None] * normal if name != "a pane" else points
        at = eyes + (own / (own - (images - middle) @ normal))[:, None] * (images - eyes) - middle
        u, v = (at @ axis / (axis @ axis) for axis in (right, up))
        inside = u * u + v * v <= 1.0 if name == "a round mirror" else np.maximum(abs(u), abs(v)) <= 1.0
        seen[j] = (inside & ((high * own > 0.0) == (name != "a pane"))).any()
    assert 20 < seen.sum() < 500 and (~there & ~odd).sum() > 20
    assert there[seen].all()


@pytest.mark.parametrize("name", THINGS)
def test_which_lights_an_object_shows_does_not_depend_on_where_the_world_has_its_origin(name):
    """Lights from near to far, some too near a ball to decide."""
    random = np.random.default_rng(8)
    thing, eye = THINGS[name], np.zeros(3)
    scene = Scene("one", spheres=(thing,)) if isinstance(thing, Sphere) else Scene("one", plates=(thing,))
    ways = random.normal(size=(3000, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    centres = thing.centre + ways * random.uniform(250.0, 4000.0, (3000, 1))
    radii = random.uniform(1.0, 40.0, 3000)
    found = []
    for shift in np.array([[0.0, 0.0, 0.0], [900.0, -1300.0, 2100.0], [40.0, 60.0, 1500.0]]):
        (here,) = specular_objects(scene, np.eye(3), shift)
        found.append(visible_lights(here, centres + shift, radii, eye + shift, 20.0))
    assert 20 < found[0][0].sum() < 2980 and 20 < found[0][1].sum() < 2980
    for there, odd in found[1:]:
        np.testing.assert_array_equal(there, found[0][0])
        np.testing.assert_array_equal(odd, found[0][1])
