"""Tracing where digits are few: flat glass, far sources, the smallest stops, and rays that are none."""

from math import inf, nan

import mpmath
import numpy as np
import pytest

import lensbench as lb
from tests.core.oracles import NAMES, biconvex, lens


def in_forty_digits(stack: lb.Lens, origin, direction):
    """Point and direction after the lens: the quadratic of each sphere and Snell's law, in 40 digits."""
    with mpmath.workdps(40):
        p, d = mpmath.matrix(origin), mpmath.matrix(direction)
        d /= mpmath.norm(d)
        n = stack.indices()
        for i, (surface, z) in enumerate(zip(stack.surfaces, stack.vertices, strict=True)):
            c, q = mpmath.mpf(surface.curvature), p - mpmath.matrix([0, 0, z])
            if c == 0:
                distance, normal = -q[2] / d[2], mpmath.matrix([0, 0, 1])
            else:
                q -= mpmath.matrix([0, 0, 1 / c])                       # from the centre
                b, e = (q.T * d)[0], (q.T * q)[0] - 1 / c**2
                root = mpmath.sqrt(b * b - e)
                distance = -b - root if c > 0 else -b + root
                normal = -c * (q + distance * d)
            p += distance * d
            ratio, cosine = mpmath.mpf(n[i]) / n[i + 1], (d.T * normal)[0]
            d = ratio * d + (mpmath.sqrt(1 - ratio**2 * (1 - cosine**2)) - ratio * cosine) * normal
        return np.array([float(x) for x in p]), np.array([float(x) for x in d])


@pytest.mark.parametrize("radius", [1e9, -1e9, 1e6, 50.0, -50.0])
@pytest.mark.parametrize("distance", [0.0, 10.0, 1e4])
def test_nearly_flat_glass_and_far_origins_keep_every_digit(radius, distance):
    window = lb.Lens((lb.Surface(6.0, 50.0, lb.Glass(1.6), curvature=1.0 / radius),
                      lb.Surface(0.0, 50.0, curvature=0.0)), 0)
    direction = np.array([0.02, -0.01, 1.0])
    origin = np.array([3.0, 2.0, 0.0]) - distance * direction
    t = lb.trace(window, origin, direction)
    point, after = in_forty_digits(window, origin, direction)
    np.testing.assert_allclose(t.points[0], point, rtol=0.0, atol=1e-15 * (30.0 + distance))
    np.testing.assert_allclose(t.directions[0], after, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_a_source_ten_kilometres_away_loses_no_more_than_its_coordinates_do(name):
    origin = np.array([1e5, 0.0, -1e7])
    direction = np.array([0.0, 0.5, 0.0]) - origin
    t = lb.trace(lens(name), origin, direction)
    point, after = in_forty_digits(lens(name), origin, direction)
    assert t.fate[0] == lb.Fate.PASSED
    np.testing.assert_allclose(t.points[0], point, atol=1e-8)            # 1e7 mm · 2⁻⁵³ in each coordinate
    np.testing.assert_allclose(t.directions[0], after, atol=1e-9)


def test_a_surface_of_radius_1e9_bends_as_a_plane_does():
    rear = lb.Surface(0.0, 9.0, curvature=0.0)
    flat, nearly = (lb.Lens((lb.Surface(3.0, 9.0, lb.Glass(1.5), curvature=c), rear), 0) for c in (0.0, 1e-9))
    rays = [0.0, 3.0, -2.0], [0.1, 0.0, 1.0]
    np.testing.assert_allclose(lb.trace(flat, *rays).points, lb.trace(nearly, *rays).points, atol=3.0**2 / 2e9)


def test_a_stop_of_a_fiftieth_of_a_millimetre_passes_its_own_axis_alone():
    pinhole = lens("dgauss").with_stop_radius(0.02)
    heights = np.array([0.0, 0.028, 0.03])
    t = lb.trace(pinhole, np.column_stack([0 * heights, heights, 0 * heights]), [0.0, 0.0, 1.0])
    assert list(t.fate) == [lb.Fate.PASSED, lb.Fate.PASSED, lb.Fate.CLIPPED]
    assert t.surface[2] == pinhole.stop_index


# --- Input

@pytest.mark.parametrize(("origins", "directions", "dtype", "message"), [
    ([[0.0, 0.0, 0.0], [0.0, nan, 0.0]], [0.0, 0.0, 1.0], float, "origins: row 1 contains a number that is not finite"),
    ([0.0, 0.0, 0.0], [0.0, inf, 1.0], float, "directions: row 0 contains a number that is not finite"),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], float, "directions: row 0 is zero"),
    ([0.0, 0.0], [0.0, 1.0], float, "must be \\(n, 3\\)"),
    (np.zeros((2, 3)), np.ones((3, 3)), float, "2 origins and 3 directions do not broadcast"),
    ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], np.int32, "float32 or float64"),
])
def test_rays_that_are_none_are_refused_in_one_line(origins, directions, dtype, message):
    with pytest.raises(ValueError, match=message):
        lb.trace(biconvex(), origins, directions, dtype=dtype)


def test_no_rays_at_all_are_traced_to_nothing():
    t = lb.trace(biconvex(), np.empty((0, 3)), np.empty((0, 3)), record=True)
    assert t.points.shape == (0, 3) and t.paths.shape == (0, 3, 3)


def test_directions_of_any_length_give_the_same_ray():
    way = np.array([0.01, 0.0, 1.0])
    short, long = (lb.trace(biconvex(), [0.0, 2.0, -5.0], way * length) for length in (1e-200, 1e200))
    np.testing.assert_allclose(short.points, long.points, rtol=1e-15)
