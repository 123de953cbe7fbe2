"""Where other systems lose or bend rays wrongly, each in the very situation: see docs/stability.md.

The ids of the failures are those of app/studies/stability/known_failures.toml, each with the name of its test.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses

FILM = lb.Film(36.0, 24.0, 90, 60)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("radius", [math.inf, 1e15, 1e9, -1e9])
@pytest.mark.parametrize("degrees", [0.0, 5.0, 40.0, 80.0])
def test_pbrt_v3_91_a_flat_window_shifts_a_ray_by_the_closed_form_and_turns_it_by_nothing(degrees, radius, real):
    """A plane there is the stop, and a radius of 1e9 mm may replace it: a float32 has no digits left in its square."""
    n, thickness, angle = 1.52, 6.0, math.radians(degrees)
    c = 0.0 if math.isinf(radius) else 1.0 / radius
    window = lb.Lens((lb.Surface(thickness, 50.0, lb.Glass(n), curvature=c), lb.Surface(0.0, 50.0, curvature=c)), 0)
    way = np.array([0.0, math.sin(angle), math.cos(angle)])
    t = lb.trace(window, [[1.0, -2.0, -3.0]], way[None], dtype=real)
    assert t.fate[0] == lb.Fate.PASSED
    aside = np.linalg.norm(np.cross(t.points[0] - [1.0, -2.0, -3.0], way))
    shift = thickness * math.sin(angle) * (1.0 - math.cos(angle) / math.sqrt(n * n - math.sin(angle) ** 2))
    # Rounding of points some tens of millimetres away; and a sphere's own slope there
    bend = 50.0 / abs(radius)
    assert aside == pytest.approx(shift, abs=float(300.0 * np.finfo(real).eps) + 6.0 * bend)
    np.testing.assert_allclose(t.directions[0], way, atol=float(8.0 * np.finfo(real).eps) + bend)


def test_lentil_23_a_last_element_that_is_a_cylinder_bends_as_one():
    """It is taken for a sphere there. Here rays of the camera lead back to their film points by Snell's law alone."""
    index, thickness, c = 1.6, 5.0, -1.0 / 40.0
    rear = lb.Surface(0.0, 9.0, curvature=c, curvature_x=0.0)
    lens = lb.Lens((lb.Surface(thickness, 8.0, lb.Glass(index), curvature=0.0), rear), 0)
    camera = lb.LensCamera(lens, FILM, 2000.0)
    random = np.random.default_rng(1)
    raster = random.random((500, 2)) * [90.0, 60.0]
    rays = camera.generate_rays(raster, random.random((500, 2)))
    lit = rays.weights > 0.0
    assert lit.mean() > 0.9
    at = rays.origins[lit] + [0.0, 0.0, lens.length + camera.film_distance]
    into = -rays.directions[lit]                                            # towards the film
    at -= (at[:, 2] / into[:, 2])[:, None] * into                           # on the flat front
    p, q = into[:, 0] / index, into[:, 1] / index
    inside = np.column_stack([p, q, np.sqrt(1.0 - p * p - q * q)])
    # The cylinder y² + (z − r)² = r² about (0, r), its vertex at the thickness
    y, z = at[:, 1], at[:, 2] - thickness - 1.0 / c
    a, b, e = q * q + inside[:, 2] ** 2, y * q + z * inside[:, 2], y * y + z * z - 1.0 / c**2
    hit = at + ((-b + np.sqrt(b * b - a * e)) / a)[:, None] * inside
    normal = np.column_stack([0.0 * y, hit[:, 1], hit[:, 2] - thickness - 1.0 / c]) * -c
    cosine = (inside * normal).sum(1)
    along = np.sqrt(1.0 - index**2 * (1.0 - cosine**2)) - index * cosine
    out = index * inside + along[:, None] * normal
    np.testing.assert_allclose(out[:, 0], into[:, 0], atol=1e-14)            # nothing happens along the axis
    film = hit + ((lens.length + camera.film_distance - hit[:, 2]) / out[:, 2])[:, None] * out
    true = np.column_stack([(0.5 - raster[:, 0] / 90.0) * 36.0, (raster[:, 1] / 60.0 - 0.5) * 24.0])[lit]
    np.testing.assert_allclose(film[:, :2], true, atol=1e-10)


def test_one_ray_that_fails_leaves_the_others_and_what_is_summed_over_them_as_they_are():
    """A miss, a total reflection, a point within the lens: each is its own, and no figure of a plot is lost by it."""
    ball = lb.Lens((lb.Surface(4.0, 30.0, lb.Glass(1.9), curvature=0.1), lb.Surface(0.0, 30.0, curvature=0.0)), 0)
    heights = np.array([0.0, 2.0, 9.9, 10.1, 25.0, 4.0])
    t = lb.trace(ball, np.column_stack([0.0 * heights, heights, 0.0 * heights - 5.0]), [0.0, 0.0, 1.0], record=True)
    assert list(t.fate[[0, 1, 3, 4, 5]]) == [lb.Fate.PASSED, lb.Fate.PASSED, lb.Fate.MISSED, lb.Fate.MISSED,
                                             lb.Fate.PASSED]
    assert np.isfinite(t.points).all() and np.isfinite(t.directions).all()
    alone = lb.trace(ball, [[0.0, 4.0, -5.0]], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(t.points[5], alone.points[0])
    # Curves of figures: the failed places alone are no numbers
    lens = lenses.load("pbrt-dgauss-50mm")
    film = lb.film_distance(lens, 2000.0)
    distances = np.array([500.0, film + 0.5 * lens.length, 2000.0, math.inf])
    for curve in (lb.thick_circle_of_confusion(lens, film, distances),
                  *lb.real_circle_of_confusion(lens, film, distances)):
        assert list(np.isnan(curve)) == [False, True, False, False]
    falloff = lb.falloff(lenses.load("pbrt-fisheye-10mm"), 24.0, [0.0, 5.0, 30.0])
    assert np.isfinite(falloff.total).all() and list(falloff.total > 0.0) == [True, True, False]


def test_pbrt_v3_318_two_colours_meet_where_the_indices_of_each_have_their_focus():
    """There a gap has one index for all colours. A thin lens's foci of F and C lie f / V apart."""
    glass = lb.Glass(1.5168, 64.17)
    thin = lb.Lens((lb.Surface(1e-6, 5.0, glass, curvature=0.02), lb.Surface(0.0, 5.0, curvature=-0.02)), 0)
    blue, middle, red = (lb.first_order(thin, line).efl for line in (lb.F_LINE, lb.D_LINE, lb.C_LINE))
    assert (red - blue) / middle == pytest.approx(1.0 / 64.17, rel=1e-2)        # to the first order in 1 / V
    low = 1e-3                                                                  # and rays near the axis go there
    for line, focus in ((lb.F_LINE, blue), (lb.C_LINE, red)):
        t = lb.trace(thin, [0.0, low, -1.0], [0.0, 0.0, 1.0], line)
        assert -low / t.directions[0, 1] == pytest.approx(focus, rel=1e-6)


@pytest.mark.parametrize("degrees", [30.0, 60.0, 75.0, 85.0])
@pytest.mark.parametrize("name", ["pbrt-fisheye-10mm", "lenshh-laikin-fisheye160-f2", "lentil-minolta-fisheye-1978"])
def test_chief_rays_of_fisheyes_are_aimed_beyond_sixty_degrees(name, degrees):
    """Where a search from the paraxial entrance pupil is lost, for the real one has moved by many millimetres."""
    lens, angle = lenses.load(name), math.radians(degrees)
    if lenses.load(name) == lenses.load("lenshh-laikin-fisheye160-f2") and degrees > 80.0:
        with pytest.raises(lb.LensError, match="no light|chief"):
            lb.chief_ray(lens, angle, clip=True)
        return
    chief = lb.chief_ray(lens, angle)
    into = np.array([0.0, math.sin(angle), math.cos(angle)])
    start = chief.points[0] - 20.0 * into
    t = lb.trace(lens, start, into, record=True, clip=False, forward=True)
    assert t.fate[0] == lb.Fate.PASSED
    assert abs(t.paths[0, 1 + lens.stop_index, 1]) < 1e-9 * lens.stop.semi_diameter
    moved = abs(chief.pupil_z - lb.first_order(lens).entrance_pupil.z)
    assert degrees < 60.0 or moved > 0.2


def test_a_film_point_that_nothing_reaches_sends_no_samples_out():
    """There it gets a full box of useless ones. Here its weight is 0 before any ray is traced."""
    lens = lenses.load("pbrt-fisheye-10mm")
    camera = lb.LensCamera(lens, replace(FILM, width=72.0, height=48.0), 2000.0)
    dark = np.column_stack([np.linspace(0.0, 8.0, 50), np.full(50, 30.0)])
    assert (36.0 - dark[:, 0] * 0.8 > camera.pupil.dark_beyond).all()
    rays = camera.generate_rays(dark, np.random.default_rng(1).random((50, 2)))
    assert not rays.weights.any()
    points, area = lb.exit_pupil(lens, camera.film_distance, [0.0, 36.0]).sample([[36.0, 0.0]], [[0.3, 0.6]])
    assert area[0] == 0.0 and np.isfinite(points).all()
