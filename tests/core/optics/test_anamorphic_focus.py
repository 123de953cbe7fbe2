"""Focusing lenses with cylinders: between their two foci, where the light of the whole pupil is spread least."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses

DISTANCES = (math.inf, 3000.0, 1500.0)         # mm from the film


def anamorphic(stop=10.2):
    return lenses.load("lentil-schneider-anamorphic-31-2001").with_stop_radius(stop)


def bundle(lens, object_distance, steps=900):
    """Points and slopes (n, 2) behind the last vertex of rays of an axis point, even on the first vertex's plane."""
    reach = 2.2 * lens.stop.semi_diameter + 0.2
    place = (np.arange(steps) + 0.5) / steps * 2.0 * reach - reach
    x, y = (grid.ravel() for grid in np.meshgrid(place, place))
    starts = np.column_stack([x, y, 0.0 * x])
    ways = np.column_stack([x, y, np.full(x.size, object_distance)]) / object_distance if object_distance < math.inf \
        else np.tile([0.0, 0.0, 1.0], (x.size, 1))
    t = lb.trace(lens, starts - 40.0 * ways, ways)
    passed = t.fate == lb.Fate.PASSED
    assert 0.05 < passed.mean() < 0.9
    slopes = t.directions[passed, :2] / t.directions[passed, 2:]
    return t.points[passed, :2] + (lens.length - t.points[passed, 2:]) * slopes, slopes


@pytest.mark.slow
@pytest.mark.parametrize("distance", DISTANCES)
def test_the_real_focus_is_where_the_rays_of_the_whole_pupil_are_spread_least(distance):
    lens = anamorphic()
    film = lb.film_distance(lens, distance, "real")
    points, slopes = bundle(lens, distance - lens.length - film)
    best = -(points * slopes).sum() / (slopes**2).sum()
    assert film == pytest.approx(best, abs=2e-3)         # 900 rays across tell the pupil's rim to a thousandth
    spread = lb.real_circle_of_confusion(lens, film, [distance])[0][0] if distance < math.inf else None
    if spread is not None:
        rms = math.sqrt(((points + film * slopes) ** 2).sum(1).mean())
        assert spread == pytest.approx(2.0 * math.sqrt(2.0) * rms, rel=2e-3)


@pytest.mark.parametrize("distance", DISTANCES)
def test_the_paraxial_focus_is_the_limit_of_the_real_one(distance):
    shifts = [abs(lb.film_distance(anamorphic(stop), distance, "real") - lb.film_distance(anamorphic(stop), distance))
              for stop in (1.0, 0.5, 0.25)]
    for wide, narrow in zip(shifts, shifts[1:], strict=False):
        assert wide / narrow == pytest.approx(4.0, rel=0.05)            # it falls as the square
    film = lb.film_distance(anamorphic(0.01), distance)
    at = [distance if distance < math.inf else 1e12]
    thick, real = (blur(anamorphic(0.01), film, at) for blur in (
        lb.thick_circle_of_confusion, lambda *given: lb.real_circle_of_confusion(*given)[0]))
    assert thick == pytest.approx(real, rel=1e-4)


@pytest.mark.parametrize("distance", DISTANCES)
def test_the_film_lies_between_the_foci_of_the_sections(distance):
    lens = anamorphic()
    film = lb.film_distance(lens, distance)
    foci = lb.section_foci(lens, distance, film)
    # Each is where rays near the axis cross it
    before = distance - lens.length - film
    for axis, focus in enumerate(foci):
        start, way = [0.0, 0.0, -50.0], [0.0, 0.0, 1.0]
        start[axis] = 1e-3 * (1.0 - 50.0 / before)
        way[axis] = 1e-3 / before
        t = lb.trace(lens, start, way)
        slope = t.directions[0, axis] / t.directions[0, 2]
        assert lens.length + focus == pytest.approx(t.points[0, 2] - t.points[0, axis] / slope, abs=1e-6)
    # Behind the stop it is a lens of rotation: both cones are alike, and the film lies in the middle
    assert film == pytest.approx(np.mean(foci), abs=0.02 * abs(foci[0] - foci[1]))
    assert abs(foci[0] - foci[1]) == pytest.approx({math.inf: 0.024, 3000.0: 0.95, 1500.0: 1.9}[distance], rel=0.05)


def test_focused_distance_inverts_film_distance_for_anamorphic_lenses():
    lens = anamorphic()
    for distance in (800.0, 3000.0, 1e5):
        assert lb.focused_distance(lens, lb.film_distance(lens, distance)) == pytest.approx(distance, rel=1e-9)
    assert lb.focused_distance(lens, 40.0) == math.inf
    nearest = lb.nearest_focus(lens)
    for method in ("paraxial", "real"):
        assert lb.film_distance(lens, 1.02 * nearest, method) > 50.0
    assert lb.film_distance(lens, nearest) > 50.0
    with pytest.raises(lb.FocusError, match="nearest distance"):
        lb.film_distance(lens, 0.999 * nearest)


def test_a_lens_of_rotation_has_one_focus_and_a_cylinder_focuses_a_line():
    dgauss = lenses.load("pbrt-dgauss-50mm")
    film = lb.film_distance(dgauss, 2000.0)
    assert lb.section_foci(dgauss, 2000.0, film) == pytest.approx((film, film), rel=1e-12)
    glass = lb.Glass(1.5)
    for across in (0.0, 0.02):                  # power up alone, or across alone
        front = lb.Surface(2.0, 5.0, glass, curvature=0.02 - across, curvature_x=across)
        cylinder = lb.Lens((front, lb.Surface(0.0, 5.0, curvature=0.0)), 0)
        film = lb.film_distance(cylinder, math.inf)
        assert film == pytest.approx(1.0 / (0.5 * 0.02) - 2.0 / 1.5, rel=1e-12)        # n′ f / n less the glass
        foci = lb.section_foci(cylinder, math.inf, film)
        near = [lb.film_distance(cylinder, 500.0, method) for method in ("paraxial", "real")]
        assert near[0] == pytest.approx(lb.film_distance(cylinder.section("x" if across else "y"), 500.0), rel=1e-9)
        assert near[1] == pytest.approx(near[0], rel=0.01)             # spherical aberration
        assert (foci.index(math.inf) == 0) == (across == 0.0) and film in [pytest.approx(focus) for focus in foci]


def test_the_working_f_number_goes_with_the_light():
    lens = anamorphic()
    far = lb.film_distance(lens, math.inf)
    for axis in "xy":           # the stop alone limits, and the group behind it has one power
        assert lb.working_f_number(lens, far) == pytest.approx(lb.working_f_number(lens.section(axis), far), rel=1e-6)


@pytest.mark.parametrize("index", [1.0, 1.333])
def test_the_paraxial_focus_is_that_of_a_narrow_real_beam_in_any_medium(index):
    """Each section counts by its cone, as wide as the stop lets it be from there."""
    lens = replace(anamorphic(0.05), front_index=index)
    for distance in (math.inf, 3000.0):
        film = lb.film_distance(lens, distance)
        assert lb.film_distance(lens, distance, "real") == pytest.approx(film, abs=2e-4)
