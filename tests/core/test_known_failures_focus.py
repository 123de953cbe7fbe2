"""Where other systems fail to focus, each in the very situation: see docs/stability.md.

The ids of the failures are those of app/studies/stability/known_failures.toml, each with the name of its test.
"""

import math

import mpmath
import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import PBRT_FOCUS, lens as reference_lens, rms_on_film
from tests.library import CLASSICS

WIDE = lenses.load("pbrt-wide-22mm")
FILM = lb.Film(36.0, 24.0, 90, 60)
FAR = (1e3, 1e4, 1e5, 1e6, 1e7, 1e9)            # mm
FOCUSABLE = [name for name in CLASSICS if lenses.load(name).is_rotationally_symmetric]


def conjugate(lens: lb.Lens, focus_distance: float) -> mpmath.mpf:
    """The film distance by 50 digits: the system matrix is multiplied out, and its conjugates solved for."""
    with mpmath.workdps(50):
        m = mpmath.eye(2)                               # (height, index × slope) from the first vertex on
        n = [mpmath.mpf(index) for index in lens.indices()]
        for i, surface in enumerate(lens.surfaces):
            m = mpmath.matrix([[1, 0], [-(n[i + 1] - n[i]) * mpmath.mpf(surface.curvature), 1]]) * m
            if i < len(lens.surfaces) - 1:
                m = mpmath.matrix([[1, mpmath.mpf(surface.thickness) / n[i + 1]], [0, 1]]) * m
        a, b, c, d = m[0, 0], m[0, 1], m[1, 0], m[1, 1]
        # The axis point x before the first vertex is imaged at f: (a + f c) x + b + f d = 0, x + length + f = distance
        away = mpmath.mpf(focus_distance) - sum(mpmath.mpf(surface.thickness) for surface in lens.surfaces[:-1])
        p, q = c * away - a + d, a * away + b
        return (p + mpmath.sqrt(p * p + 4 * c * q)) / (2 * c)


@pytest.mark.parametrize("method", ["paraxial", "real"])
def test_pbrt_v3_122_a_focus_that_is_too_near_is_refused_with_the_nearest_distance(method):
    """The very lens, stop and distance: there the square root is of a negative number."""
    lens = WIDE.with_stop_radius(8.756 / 2)
    fo = lb.first_order(lens)
    for ask in (lambda: lb.film_distance(lens, 50.0, method), lambda: lb.LensCamera(lens, FILM, 50.0,
                                                                                  focus_method=method)):
        with pytest.raises(lb.FocusError) as refused:
            ask()
        metres = float(str(refused.value).split("nearest distance of this lens is ")[1].split(" m")[0])
        assert math.isfinite(lb.film_distance(lens, 1000.0 * metres, method))
        # the conjugates are nearest to each other at magnification −1: four focal lengths and the hiatus apart
        assert 1000.0 * metres == pytest.approx(4.0 * fo.efl + lens.length + fo.rear_principal - fo.front_principal,
                                                rel=2e-3)


@pytest.mark.parametrize("metres", [0.25, 0.3, 0.5, 0.8, 1.0, 2.0, 5.0, 20.0, 1e3, 1e6])
def test_pbrt_v3_134_a_small_light_in_focus_is_a_point_and_no_noise(metres):
    """A slip in the coefficient of the root put the film anywhere; here each ray of its centre finds the light."""
    lens = lb.stopped_down(WIDE, 16.0)
    camera = lb.LensCamera(lens, FILM, 1000.0 * metres)
    n = 400
    uv = np.column_stack([(np.arange(n) + 0.5) / n, np.arange(n) * 0.618 % 1.0])
    rays = camera.generate_rays(np.tile([45.0, 30.0], (n, 1)), uv)
    there = rays.weights > 0.0
    assert there.mean() > 0.95
    reach = (1000.0 * metres + rays.origins[there, 2]) / -rays.directions[there, 2]
    beside = np.hypot(*(rays.origins[there] + reach[:, None] * rays.directions[there])[:, :2].T)
    # within what spherical aberration leaves at f/16: a tenth of a pixel, seen from the camera
    assert beside.max() / (1000.0 * metres) < 0.1 * FILM.pitch / lb.first_order(lens).efl


@pytest.mark.parametrize("name", ["dgauss", "fisheye"])
def test_pbrt_v3_124_the_closed_form_is_that_of_fifty_digits_and_of_the_corrected_program(name):
    lens = reference_lens(name)
    for metres, thick in PBRT_FOCUS[name]["focus"]:
        if thick is not None:
            film = lb.film_distance(lens, 1000.0 * metres)
            assert film == pytest.approx(float(conjugate(lens, 1000.0 * metres)), abs=3e-14 * (lens.length + film))
            # cardinal points of the other come from a ray of finite height
            assert film == pytest.approx(1000.0 * thick, abs=2e-3)


@pytest.mark.parametrize("name", FOCUSABLE)
def test_pbrt_v3_135_no_distance_beyond_the_nearest_is_ever_refused(name):
    lens = lenses.load(name)
    nearest = lb.nearest_focus(lens)
    if not math.isfinite(nearest):
        pytest.fail("a lens of the library that focuses on nothing but infinity")
    for distance in (nearest, nearest * (1.0 + 1e-12), 1.001 * nearest, 1.1 * nearest, 3.0 * nearest, *FAR, math.inf):
        assert lb.film_distance(lens, max(distance, nearest)) > -lens.length
        if distance > 1.2 * nearest:                    # the real nearest is a little elsewhere
            assert lb.film_distance(lens, distance, "real") > -lens.length


@pytest.mark.parametrize("radius", [4.378, 2.0, 1.0, 0.1, 0.02])
def test_pbrt_v3_136_every_stop_and_distance_of_a_tour_gives_a_camera_that_sees(radius):
    """The scene's frames are the same lens at many distances: each must see light, and no ray be what is no number."""
    lens = WIDE.with_stop_radius(radius)
    uv = np.random.default_rng(1).random((200, 2))
    raster = np.tile([45.0, 30.0], (200, 1))
    for distance in np.geomspace(lb.nearest_focus(lens) * 1.01, 1e7, 12):
        rays = lb.LensCamera(lens, FILM, distance).generate_rays(raster, uv)
        lit = rays.weights > 0.0
        assert lit.mean() > 0.9 and np.isfinite(rays.weights).all()
        assert np.isfinite(rays.origins[lit]).all() and np.isfinite(rays.directions[lit]).all()


@pytest.mark.parametrize("radius", [1.0, 0.5, 0.1, 0.02])
def test_pbrt_v3_123_the_search_for_focus_ends_at_any_stop_and_finds_the_paraxial_limit(radius):
    """The very lens and distance: aperture 2 mm, 0.2 m; and far smaller stops, where spherical aberration dies out."""
    lens = WIDE.with_stop_radius(radius)
    film = lb.film_distance(lens, 200.0, "real")
    before = 200.0 - lens.length - film

    def through(slope):
        """Height at the stop, and where the ray of an axis point crosses the axis behind the last vertex."""
        ray = lb.trace(lens, [0.0, 0.0, -before], [0.0, slope, 1.0], record=True, clip=False)
        (_, y, z), (_, dy, dz) = ray.points[0], ray.directions[0]
        return ray.paths[0, 1 + lens.stop_index, 1], z - y * dz / dy - lens.length

    slope = 1e-4
    for _ in range(20):
        slope *= radius / through(slope)[0]
    marginal, paraxial = through(slope)[1], through(0.01 * slope)[1]
    # Of spherical aberration of the third order the least rms blur lies two thirds of the way to the marginal focus
    assert film - paraxial == pytest.approx((marginal - paraxial) * 2.0 / 3.0, rel=0.01, abs=1e-11)
    assert abs(film - float(conjugate(lens, 200.0))) < 0.024 * radius**2


@pytest.mark.parametrize("name", ["pbrt-wide-22mm", "pbrt-fisheye-10mm", "lv-zeiss-biogon-21-f45",
                                  "lentil-nikon-retrofocus-1971"])
def test_a_wide_lens_focused_on_ten_metres_is_focused_on_ten_metres(name):
    """By one ray at 0.15 of the rear radius it is focused on seven."""
    lens = lenses.load(name)
    assert lb.focused_distance(lens, lb.film_distance(lens, 10_000.0)) == pytest.approx(10_000.0, rel=1e-10)
    film = lb.film_distance(lens, 10_000.0, "real")
    # The least blur of rays traced one by one: the vertex of the parabola through three places of the film
    step = 0.01
    nearer, here, farther = (rms_on_film(lens, film + k * step, 10_000.0) ** 2 for k in (-1, 0, 1))
    off = 0.5 * step * (nearer - farther) / (nearer - 2.0 * here + farther)
    # the grain of 400 rays; three metres of object distance are 4 to 20 times as much
    assert abs(off) < 1e-3 < 0.25 * lb.first_order(lens).efl ** 2 * (1.0 / 7_000.0 - 1.0 / 10_000.0)


@pytest.mark.parametrize("name", FOCUSABLE)
def test_focus_keeps_its_digits_out_to_a_thousand_kilometres(name):
    """The difference of two large numbers under a root cost others half a millimetre at ten kilometres."""
    lens = lenses.load(name).at(close=0.0)
    if lens.has_focus_groups:
        lens = lb.Lens(lens.surfaces, lens.stop_index)                  # unit focusing has the closed form
    fo, ulp = lb.first_order(lens), 4e-14 * (lens.length + lb.first_order(lens).efl)
    for distance in FAR:
        if distance > lb.nearest_focus(lens):
            film = lb.film_distance(lens, distance)
            assert abs(film - float(conjugate(lens, distance))) < ulp
            assert film - fo.bfl == pytest.approx(float(conjugate(lens, distance) - mpmath.mpf(fo.bfl)), abs=ulp)


@pytest.mark.parametrize("name", ["pbrt-fisheye-10mm", "lenshh-petzval", "optiland-tessar-f45"])
def test_aberration_aware_7_the_point_in_focus_has_the_smallest_spot_at_the_aperture_that_is_used(name):
    """Focused by a narrow bundle and used wide open, a lens has its smallest spot elsewhere."""
    lens, distance = lenses.load(name), 3000.0
    camera = lb.LensCamera(lens, FILM, distance, focus_method="real")
    spots = {at: rms_on_film(lens, camera.film_distance, at) for at in (0.8 * distance, distance, 1.25 * distance)}
    assert spots[distance] == min(spots.values())
    narrow = lb.film_distance(lens.with_stop_radius(0.2 * lens.stop.semi_diameter), distance, "real")
    assert spots[distance] < 0.6 * rms_on_film(lens, narrow, distance)
    # Of every ray that the camera sends, all being as likely: what they miss the point in focus by
    n = 1 << 12
    uv = np.column_stack([(np.arange(n) + 0.5) / n, np.arange(n) * 0.6180339887498949 % 1.0])
    blur = []
    for method in ("paraxial", "real"):
        rays = lb.LensCamera(lens, FILM, distance, focus_method=method).generate_rays(np.tile([45.0, 30.0], (n, 1)), uv)
        lit = rays.weights > 0.0
        reach = (distance + rays.origins[lit, 2]) / -rays.directions[lit, 2]
        beside = (rays.origins[lit] + reach[:, None] * rays.directions[lit])[:, :2]
        blur.append(math.sqrt((beside**2).sum(1).mean()))
    assert blur[1] < 0.6 * blur[0]


@pytest.mark.parametrize("name", CLASSICS)
def test_lentil_44_the_focal_length_is_the_limit_of_real_rays_as_their_height_goes_to_zero(name):
    """Not that of a ray at some height: spherical aberration is in that one."""
    lens = lenses.load(name)
    efl = lb.first_order(lens).efl
    height = 0.02 * lb.first_order(lens).entrance_pupil.radius
    found = []
    for h in (height, 0.5 * height):
        ray = lb.trace(lens, [0.0, h, -1.0], [0.0, 0.0, 1.0], clip=False)
        found.append(-h / ray.directions[0, 1] * ray.directions[0, 2])
    # Richardson: the error goes as h²; what is left, as h⁴
    assert (4.0 * found[1] - found[0]) / 3.0 == pytest.approx(efl, rel=2e-7)
    if lens.stated_efl:
        assert efl == pytest.approx(lens.stated_efl, rel=0.03)
