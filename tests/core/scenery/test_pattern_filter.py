"""Patterns over the footprint of a pixel are means that quadrature finds; pictures are free of aliasing and rings.

Slow: the stages of surfaces in double precision are compiled for these tests.
"""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import BLUE, GREEN, PIXEL_SIDE, PIXEL_SPREAD, RED, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.texture import ripmap

pytestmark = pytest.mark.slow
WHITE = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
FILM = lb.Film(36.0, 24.0, 120, 80)


def seen(scene, points, foot=0.0, spread=0.0):
    """What rays from the origin to points (n, 3) see, with pixels of this foot (mm) and spread: (n, 3)."""
    points = np.asarray(points, float)
    d = points / np.linalg.norm(points, axis=1)[:, None]
    zero = np.zeros(len(d))
    given = {X: zero, Y: zero, Z: zero, L: d[:, 0], M: d[:, 1], N: d[:, 2], PIXEL_SIDE: zero + foot,
             PIXEL_SPREAD: zero + spread}
    return Program(scene.steps(shadows=False), np.float64).run(given, [RED, GREEN, BLUE], len(d)).T


def wall(pattern, turned=0.0):
    """A wall of 800 × 480 mm in front, 1000 mm away, radiance 0.9 and 0.1; turned about the vertical (radians)."""
    c, s = math.cos(turned), math.sin(turned)
    return lb.Scene("wall", plates=(lb.Rectangle((0.0, 0.0, -1000.0), (400.0 * c, 0.0, 400.0 * s), (0.0, 240.0, 0.0),
                                                 lb.Material((0.9,) * 3, "light", pattern=pattern)),))


def on_wall(u, v, turned=0.0):
    c, s = math.cos(turned), math.sin(turned)
    return np.column_stack([400.0 * c * u, 240.0 * v, -1000.0 + 400.0 * s * u])


def box_mean(scene, u, v, wide, high, turned=0.0, m=60):
    """Of the sharp pattern over boxes (mm, along the wall's sides) about places of the wall."""
    k = (np.arange(m) + 0.5) / m - 0.5
    a, b = (values.ravel() for values in np.meshgrid(k, k))
    total = np.zeros(len(u))
    for j in range(len(u)):
        points = on_wall(u[j] + a * wide[j] / 400.0, v[j] + b * high[j] / 240.0, turned)
        total[j] = seen(scene, points)[:, 0].mean()
    return total


INK = (0.1,) * 3
PATTERNS = [lb.Pattern("checker", INK, 16.0, 10.0), lb.Pattern("grid", INK, 16.0, 10.0, 12.0),
            lb.Pattern("ruler", INK, 90.0, line=0.3)]


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda p: p.kind)
@pytest.mark.parametrize("turned", [0.0, 1.1])
def test_a_pattern_is_its_mean_over_the_footprint(pattern, turned):
    random = np.random.default_rng(2)
    n = 25
    # a foot that does not grow: a telecentric pixel; inside the wall, and of a ruler below the shortest ticks' tops
    u, v = random.uniform(-0.8, 0.8, n), random.uniform(-0.7, 0.7, n)
    ruler = pattern.kind == "ruler"
    v = random.uniform(-0.97, -0.9, n) if ruler else v
    foot = 0.4 if ruler else 20.0
    scene, points = wall(pattern, turned), on_wall(u, v, turned)
    d = points / np.linalg.norm(points, axis=1)[:, None]
    normal, side = np.array([-math.sin(turned), 0.0, math.cos(turned)]), np.array(
        [math.cos(turned), 0.0, math.sin(turned)])
    wide = foot * np.sqrt(1.0 + (d @ side / (d @ normal)) ** 2)
    high = foot * np.sqrt(1.0 + (d[:, 1] / (d @ normal)) ** 2)
    wanted = box_mean(scene, u, v, wide, high, turned)
    # of the midpoint rule: an edge may lie anywhere within one of the 60 cells of either side
    assert seen(scene, points, foot=foot)[:, 0] == pytest.approx(wanted, abs=0.8 * 1.1 / 60)


def test_a_star_fades_to_grey_towards_its_centre_as_arcs_of_the_footprint_do():
    scene = wall(lb.Pattern("star", INK, 24.0))
    random = np.random.default_rng(3)
    angle = random.uniform(0.0, 2 * math.pi, 400)
    for radius, spread_over in ((150.0, 5.0), (60.0, 5.0)):
        # the star's sectors are equal angles of u, v; on a wall that is no square its arcs are those of an ellipse
        def at(turn, radius=radius):
            return on_wall(radius / 240.0 * np.cos(turn), radius / 240.0 * np.sin(turn))
        slope = np.hypot(np.sin(angle) * 240.0 / 400.0, np.cos(angle))
        arcs = (np.arange(400) + 0.5) / 400 - 0.5
        exact = np.array([seen(scene, at(a + s * spread_over / radius * arcs))[:, 0].mean()
                          for a, s in zip(angle, slope, strict=True)])
        found = seen(scene, at(angle), foot=spread_over)[:, 0]
        # widths are of rays that are a little oblique: sixth of a radian, 1.5 % of a width of 0.5 of a sector
        assert np.sqrt(((found - exact) ** 2).mean()) < 0.02
    assert seen(scene, on_wall(np.array([0.01]), np.array([0.003])), foot=20.0)[0] == pytest.approx(0.5, abs=1e-12)


def test_every_reduction_of_an_image_has_its_mean_and_a_white_one_stays_white():
    random = np.random.default_rng(4)
    for shape in ((2, 2, 3), (37, 5, 3), (64, 100, 3)):
        image = random.random(shape)
        across, down, starts, texels = ripmap(image)
        sizes = [(shape[1], shape[0]), *((a, b) for a in across[1:] for b in down[1:])]
        assert len(texels) == sum(a * b for a, b in sizes)
        for start, (a, b) in zip(starts, sizes, strict=True):
            assert texels[start:start + a * b].mean(0) == pytest.approx(image.mean((0, 1)), abs=1e-12)


def test_an_image_is_smoothed_to_about_its_mean_under_a_footprint_and_exact_under_none():
    image = np.kron(np.indices((32, 32)).sum(0) % 2, np.ones((2, 2)))[..., None] * np.ones(3)     # a fine checker
    scene = wall(lb.Pattern("image", image=lb.Image.of(image)))
    random = np.random.default_rng(5)
    points = on_wall(*random.uniform(-0.9, 0.9, (2, 2000)))
    sharp, smooth = seen(scene, points)[:, 0], seen(scene, points, foot=12.0 * 12.5)[:, 0]      # 12 texels across
    assert sharp.std() > 0.25                       # black and white
    assert np.abs(smooth - 0.45).max() < 0.02       # half of 0.9
    white = wall(lb.Pattern("image", image=lb.Image.of(np.ones((19, 33, 3)))))
    for foot in (0.0, 3.0, 40.0, 500.0):
        assert seen(white, points, foot=foot) == pytest.approx(0.9, abs=1e-6)       # float32 texels


def test_tiles_far_smaller_than_a_pixel_show_their_mean():
    scene = lb.Scene("one", sky=WHITE, floor=lb.Floor(-100.0, 50.0, (0.8,) * 3, (0.2,) * 3))
    points = [(x, -100.0, -40000.0) for x in np.linspace(-99, 99, 40)]
    assert seen(scene, points, spread=1e-3) == pytest.approx(0.5, abs=1e-12)        # a pixel there covers 16 m of floor


def test_a_mirror_carries_the_footprint_on_to_what_it_shows():
    floor = lb.Floor(-100.0, 50.0, (0.8,) * 3, (0.2,) * 3)
    mirror = lb.Rectangle((0.0, 0.0, -900.0), (4000.0, 0.0, 0.0), (0.0, 240.0, 0.0), lb.Material((1.0,) * 3, "metal"))
    random = np.random.default_rng(6)
    ways = np.column_stack([random.uniform(-0.3, 0.3, 500), random.uniform(-0.1, -0.04, 500), np.full(500, -1.0)])
    shown = seen(lb.Scene("m", WHITE, floor=floor, plates=(mirror,)), ways, spread=0.0015)
    open_ = seen(lb.Scene("o", WHITE, floor=floor), ways, spread=0.0015)
    # the mirror shows the floor before it turned round: behind it 900 mm, 18 tiles, with its colours exchanged
    assert np.quantile(np.abs(shown + open_ - 1.0), 0.98) < 1e-3       # but for the lift off the mirror, at edges
    assert 0.1 < np.mean(np.abs(open_ - 0.5) < 0.2) < 0.9              # some are filtered
    sharp = seen(lb.Scene("m", WHITE, floor=floor, plates=(mirror,)), ways)
    assert np.abs(sharp - shown).max() > 0.2                            # and not all are as they would be at a point


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_a_flat_field_shows_no_ring_at_any_radius(name):
    # a white wall with a pattern of one colour, so that it is filtered: what is left is the smooth falloff of the lens
    white = lb.Rectangle((0.0, 0.0, -1000.0), (1e5, 0.0, 0.0), (0.0, 1e5, 0.0), lb.Material(
        (1.0,) * 3, "light", pattern=lb.Pattern("grid", (1.0,) * 3, 900.0, 900.0, 3.0)))
    scene = lb.Scene("white", sky=WHITE, plates=(white,))
    film = lb.Film(24.0, 24.0, 192, 192)
    camera = lb.LensCamera(lenses.load(name), film, 1200.0)
    image = lb.render(camera, scene, samples=16)[..., 1]
    plain = lb.render(camera, lb.Scene("sky", sky=WHITE), samples=16)[..., 1]
    y, x = np.mgrid[0:192, 0:192] + 0.5
    radii = np.hypot(x - 96.0, y - 96.0)
    profile = rings(image, radii)
    assert image == pytest.approx(plain, abs=1e-5)                      # a pattern that is none
    # a ring differs from the parabola through its neighbours by no more than the noise of its pixels
    noise = np.array([image[(radii >= r) & (radii < r + 2)].std() / np.sqrt(((radii >= r) & (radii < r + 2)).sum())
                      for r in range(0, 92, 2)])
    k = np.arange(-3, 4)
    basis = np.column_stack([np.ones(6), k[k != 0], k[k != 0] ** 2])
    middle = np.linalg.pinv(basis)[0]
    smooth = np.array([profile[j + k[k != 0]] @ middle for j in range(3, len(profile) - 3)])
    doubt = np.array([math.hypot(noise[j], np.sqrt((middle**2) @ noise[j + k[k != 0]] ** 2))
                      for j in range(3, len(profile) - 3)])
    assert (np.abs(profile[3:-3] - smooth) < 4.0 * doubt + 1e-3 * profile[0]).all()


def rings(image, radii):
    """Means of an image over rings two pixels wide about its centre."""
    return np.array([image[(radii >= r) & (radii < r + 2)].mean() for r in range(0, 92, 2)])


def test_the_first_sample_is_nearer_to_the_last_and_the_last_is_none_the_less_sharp():
    # a floor to its horizon, seen by a pinhole: what one sample is off is aliasing
    scene = lb.Scene("floor", sky=WHITE, floor=lb.Floor(-100.0, 40.0, (0.9,) * 3, (0.1,) * 3, turn=0.3))
    camera = lb.PerspectiveCamera(FILM, fov=0.8)

    def taken(samples, filtered, seed):
        picture = lb.Rendering(camera, scene, seed, filtered=filtered)
        picture.add(samples)
        return picture.image().astype(float)

    def off(a, b):
        return math.sqrt(((a - b) ** 2).mean())

    last, other = taken(1024, False, 1), taken(1024, False, 2)
    assert off(taken(1, True, 3), last) < 0.5 * off(taken(1, False, 3), last)
    assert off(taken(16, True, 3), last) < 0.8 * off(taken(16, False, 3), last)
    # 1024 samples: the pictures with and without differ by 0.01 of white, the size of the noise of 50
    filtered = taken(1024, True, 3)
    assert off(filtered, last) < 0.004, (off(filtered, last), off(other, last))


def test_a_picture_without_patterns_is_the_same_with_and_without_filter():
    camera = lb.PerspectiveCamera(FILM)
    scene = lb.Scene("ball", sky=WHITE, spheres=(lb.Sphere((0.0, 0.0, -500.0), 90.0),))
    pictures = []
    for filtered in (False, True):
        picture = lb.Rendering(camera, scene, filtered=filtered)
        picture.add(2)
        pictures.append(picture.image())
    assert np.array_equal(*pictures)
