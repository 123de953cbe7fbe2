"""Focusing: the closed form, the real lens, their inverse, and how much light comes through."""

from math import hypot, inf, nan, nextafter

import numpy as np
import pytest
from hypothesis import given, strategies as st

import lensbench as lb
from lensbench import lenses as library
from lensbench.core.optics import focus
from lensbench.core.optics.axis_contrast import axis_contrast
from lensbench.core.optics.focus import focused
from lensbench.core.optics.paraxial import ray_matrix
from tests.core.oracles import LAW, NAMES, PBRT_FOCUS, REFERENCE, biconvex, lens, rms_on_film

FAR_ENOUGH = st.floats(0.25, 1e7)       # metres


@LAW
@given(st.sampled_from(NAMES), FAR_ENOUGH)
def test_the_paraxial_film_meets_the_paraxial_image(name, metres):
    """A ray from the axis point of the object crosses the axis on the film, by the ABCD matrix alone."""
    wide = lens(name)
    film = lb.film_distance(wide, 1000.0 * metres)
    before = 1000.0 * metres - film - wide.length
    a, b, c, d = ray_matrix(wide, 0, len(wide.surfaces))
    height = (a + film * c) + (b + film * d) / before            # on the film, per unit height at the first vertex
    assert abs(height) < 1e-13


@pytest.mark.parametrize("name", NAMES)
def test_the_film_tends_to_the_rear_focus_with_distance_and_is_there_at_infinity(name):
    fo = lb.first_order(lens(name))
    assert lb.film_distance(lens(name), inf) == fo.bfl
    for metres in (1e5, 1e7, 1e9):
        # Newton: x x' = f², to the rounding of the film distance itself
        extension = lb.film_distance(lens(name), 1000.0 * metres) - fo.bfl
        assert extension == pytest.approx(fo.efl**2 / (1000.0 * metres), rel=1e-3 / (metres / 1e5) + 1e-8, abs=1e-14)


@pytest.mark.parametrize("name", ["dgauss", "fisheye"])
def test_pbrts_cardinal_points_are_those_of_its_finite_ray(name):
    wide = lens(name)
    height = PBRT_FOCUS[name]["film_diagonal"]                  # a thousandth of it in metres is that many mm
    for side, (start, way) in enumerate(((-1.0, 1.0), (wide.length + 1.0, -1.0))):
        t = lb.trace(wide, [0.0, height, start], [0.0, 0.0, way])
        (_, y, z), (_, dy, dz) = t.points[0], t.directions[0]
        focus, plane = (wide.length + 1000.0 * PBRT_FOCUS[name][key][side] for key in ("fz", "pz"))
        assert (z - y * dz / dy, z + (height - y) * dz / dy) == pytest.approx((focus, plane), abs=1e-8)


@pytest.mark.parametrize(("name", "metres", "thick"),
                         [(name, *row) for name in ("dgauss", "fisheye") for row in PBRT_FOCUS[name]["focus"]])
def test_film_distances_agree_with_pbrts_closed_form(name, metres, thick):
    wide = lens(name)
    if thick is None:
        with pytest.raises(lb.FocusError, match=f"focus at {metres:g} m: the nearest distance of this lens is 0.196 m"):
            lb.film_distance(wide, 1000.0 * metres)
        return
    # pbrt's cardinal points come from a ray of finite height: its own error of focus, and 10 × for the nearest
    rear_focus_error = abs(1000.0 * PBRT_FOCUS[name]["fz"][0] - lb.first_order(wide).bfl)
    tolerance = max(1e-5 if metres >= 0.5 else 1e-4, 1.3 * rear_focus_error)
    assert rear_focus_error < (1e-5 if name == "dgauss" else 6e-4)
    assert lb.film_distance(wide, 1000.0 * metres) == pytest.approx(1000.0 * thick, abs=tolerance)


@LAW
@given(st.sampled_from(NAMES), FAR_ENOUGH)
def test_the_plane_in_focus_is_the_one_that_was_asked_for(name, metres):
    film = lb.film_distance(lens(name), 1000.0 * metres)
    extension = film - lb.first_order(lens(name)).bfl
    # the film's own rounding, 1e-14 mm, is all that the distance suffers from
    assert lb.focused_distance(lens(name), film) == pytest.approx(1000.0 * metres, rel=1e-12 + 4e-14 / extension)


def test_a_film_at_the_rear_focus_or_nearer_sees_infinity():
    bfl = lb.first_order(lens("dgauss")).bfl
    assert lb.focused_distance(lens("dgauss"), bfl) == lb.focused_distance(lens("dgauss"), bfl - 3.0) == inf


@pytest.mark.parametrize("name", NAMES)
def test_the_nearest_focus_is_at_magnification_one_and_nothing_nearer_can_be_had(name):
    wide, fo = lens(name), lb.first_order(lens(name))
    nearest = lb.nearest_focus(wide)
    hiatus = wide.length + fo.rear_principal - fo.front_principal
    assert nearest == pytest.approx(4.0 * fo.efl + hiatus, rel=1e-14)
    assert lb.film_distance(wide, nearest) == pytest.approx(fo.bfl + fo.efl, rel=1e-6)      # a square root of rounding
    with pytest.raises(lb.FocusError, match=r"the nearest distance of this lens is 0\.\d+ m"):
        lb.film_distance(wide, nearest * (1.0 - 1e-12))


@pytest.mark.parametrize("name", NAMES)
def test_the_distance_that_the_error_names_can_be_focused(name):
    for method in ("paraxial", "real"):
        with pytest.raises(lb.FocusError) as caught:
            lb.film_distance(lens(name), 50.0, method)
        metres = float(str(caught.value).split("lens is ")[1].split(" m")[0])
        assert lb.film_distance(lens(name), 1000.0 * metres, method) > 0.0
        assert 0.9 < 1000.0 * metres / lb.nearest_focus(lens(name)) < 1.1


@pytest.mark.parametrize("method", ["paraxial", "real", "contrast"])
@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "canon-ef-l-usm-14-f28"])         # unit focusing, focus groups
def test_the_nearest_distance_of_each_method_is_the_limit_of_its_film_distance(name, method):
    wide = library.load(name)
    nearest = lb.nearest_focus(wide, method)
    for distance in (nearest, nextafter(nearest, 0.0)):         # by rounding alone
        assert lb.film_distance(wide, distance, method) > 0.0
    with pytest.raises(lb.FocusError, match="nearest distance of this lens is"):
        lb.film_distance(wide, nearest * (1.0 - 1e-12), method)
    with pytest.raises(ValueError, match="it must be 'paraxial', 'real' or 'contrast'"):
        lb.nearest_focus(wide, "exact")


@pytest.mark.parametrize("name", ["minolta-af-apo-tele-200-f28", "vivitar-series-1-auto-telephoto-135-f23",
                                  "fujifilm-fujinon-gf-r-lm-ois-wr-macro-120-f4"])
def test_a_telephoto_with_a_far_front_focus_is_focused_by_real_rays(name):
    # an object before the front focus by a focal length lies behind the first vertex, and no ray of it passes
    telephoto = library.load(name)
    nearest = lb.nearest_focus(telephoto)
    assert focused(telephoto, 1.1 * nearest, "real").positions.close == pytest.approx(
        focused(telephoto, 1.1 * nearest).positions.close, abs=0.03)


def test_a_lens_whose_front_principal_plane_lies_deep_focuses_up_to_its_first_vertex():
    """A strong retrofocus: the object touches the glass before the magnification reaches one."""
    retrofocus = lb.Lens((lb.Surface(2.0, 9.0, lb.Glass(1.6), curvature=-0.1), lb.Surface(80.0, 9.0, curvature=0.1),
                          lb.Surface(6.0, 20.0, lb.Glass(1.6), curvature=0.02),
                          lb.Surface(0.0, 20.0, curvature=-0.03)), 2)
    fo = lb.first_order(retrofocus)
    assert fo.front_principal > 2.0 * fo.efl > 0.0
    nearest = lb.nearest_focus(retrofocus)
    assert nearest == pytest.approx(retrofocus.length + lb.film_distance(retrofocus, nearest), rel=1e-12)
    small = retrofocus.with_stop_radius(0.1)
    real = lb.film_distance(small, 1.1 * nearest, "real")
    assert real == pytest.approx(lb.film_distance(retrofocus, 1.1 * nearest), rel=1e-3)


@pytest.mark.parametrize("distance", [nan, -1000.0, 0.0, -inf])
@pytest.mark.parametrize("method", ["paraxial", "real", "contrast"])
def test_an_invalid_distance_is_refused(distance, method):
    with pytest.raises(lb.FocusError, match="nearest distance of this lens is"):
        lb.film_distance(biconvex(), distance, method)


def test_a_lens_that_does_not_converge_says_so():
    for bad in (biconvex(-0.01), biconvex(0.0)):
        for ask in (lambda x: lb.film_distance(x, inf), lambda x: lb.film_distance(x, inf, "real"), lb.nearest_focus,
                    lambda x: lb.focused_distance(x, 10.0)):
            with pytest.raises(lb.FocusError, match="does not converge"):
                ask(bad)


def test_an_unknown_method_is_refused():
    with pytest.raises(ValueError, match="'paraxial', 'real' or 'contrast'"):
        lb.film_distance(biconvex(), inf, "magic")


# --- The real lens

@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("metres", [0.5, 3.0, inf])
def test_real_focus_has_the_least_blur_of_all_film_distances(name, metres):
    wide = lens(name)
    film = lb.film_distance(wide, 1000.0 * metres, "real")
    least, nearer, farther = (rms_on_film(wide, film + step, 1000.0 * metres) for step in (0.0, -0.02, 0.02))
    assert least < min(nearer, farther)
    assert least < rms_on_film(wide, lb.film_distance(wide, 1000.0 * metres), 1000.0 * metres)
    # a parabola of the squared radius through the three: its vertex within a micrometre, the grain of 400 rays
    a, b, c = nearer**2, least**2, farther**2
    assert abs(0.5 * 0.02 * (a - c) / (a - 2.0 * b + c)) < 1e-3


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("distance", [300.0, 2000.0, 1e7, inf])
def test_real_focus_tends_to_the_paraxial_one_as_the_stop_closes_even_to_a_fiftieth_mm(name, distance):
    shifts = [lb.film_distance(lens(name).with_stop_radius(radius), distance, "real")
              - lb.film_distance(lens(name), distance) for radius in (0.4, 0.2, 0.1, 0.02)]
    ratios = np.array(shifts[:-1]) / shifts[1:]
    # spherical aberration goes as the square of the aperture
    np.testing.assert_allclose(ratios, [4.0, 4.0, 25.0], rtol=0.03)
    assert abs(shifts[-1]) < 3e-5


@pytest.mark.parametrize("name", NAMES)
def test_real_focus_on_a_distance_is_steady_out_to_ten_kilometres(name):
    at_infinity = lb.film_distance(lens(name), inf, "real")
    for metres in (1e4, 1e6):
        extension = lb.film_distance(lens(name), 1000.0 * metres, "real") - at_infinity
        assert extension == pytest.approx(lb.first_order(lens(name)).efl ** 2 / (1000.0 * metres), rel=0.05, abs=1e-12)


# --- Light

@pytest.mark.parametrize("name", ["dgauss", "fisheye"])
def test_the_working_f_number_is_that_of_the_real_marginal_ray(name):
    reference = REFERENCE[name]
    film = reference["paraxial"]["d"]["img_plane_from_last_vertex"]
    height = reference["exit_pupil_on_axis"]
    # the reference's interval is bisected to about 1e-6
    assert lb.working_f_number(lens(name), film) == pytest.approx(hypot(height, film) / (2.0 * height), rel=1e-5)


@LAW
@given(st.floats(0.02, 0.5), st.floats(0.15, 1e4))
def test_the_working_f_number_of_a_small_stop_grows_with_the_magnification(stop, metres):
    """N (1 − m / m_P) paraxially, m_P the pupils' magnification."""
    small = biconvex(0.01).with_stop_radius(stop)
    fo = lb.first_order(small)
    distance = 1000.0 * metres + lb.nearest_focus(small)
    film = lb.film_distance(small, distance)
    magnification = -(film - fo.bfl) / fo.efl
    pupil_magnification = fo.exit_pupil.radius / fo.entrance_pupil.radius
    expected = fo.f_number * (1.0 - magnification / pupil_magnification)
    assert lb.working_f_number(small, film) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("film", [0.0, -3.0, nan])
def test_a_film_within_the_lens_has_no_working_f_number(film):
    with pytest.raises(lb.LensError, match="behind the last vertex"):
        lb.working_f_number(biconvex(), film)


def test_a_film_at_the_rear_focus_is_focused_at_infinity_by_real_rays():
    """Also where it lies behind it by rounding only: the nearness of the object is then 0."""
    lens = lb.stopped_down(library.load("pbrt-dgauss-50mm"), 8.0)
    image = focus._imager(lens, "real")
    film = rear = image(0.0)
    assert focus._object_of(lens, rear, image) == inf
    for _ in range(20):
        film = nextafter(film, inf)
        assert focus._object_of(lens, film, image) > 1e9
    assert focus._object_of(lens, rear + 1.0, image) == pytest.approx(lb.focused_distance(lens, rear + 1.0), rel=0.02)


@given(st.floats(-1e9, 1e9).filter(lambda value: abs(value) > 1e-9) | st.just(0.0))
def test_a_limit_of_either_sign_is_rounded_up_to_four_digits(value):
    rounded = focus._rounded_up(value)
    assert value <= rounded * (1.0 + 1e-12 * (1 if rounded > 0.0 else -1)) + 1e-300
    assert rounded - value <= 1.001e-3 * abs(value)


def test_groups_are_focused_alike_from_wherever_they_are():
    lens = library.load("lv-minolta-af-100mm-f28-macro")
    for distance in (700.0, 2000.0, inf):
        expected = focused(lens.at(close=0.0), distance).positions.close
        for close in (0.2, 0.7, 1.0, expected):
            assert focused(lens.at(close=close), distance).positions.close == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("f_number", [8.0, 16.0, 22.0])
def test_the_contrast_of_a_small_stop_is_that_of_a_perfect_lens(f_number):
    """(2/π) (arccos x − x √(1 − x²)), x = λ N × frequency; the working f-number, a quadrature of 8 azimuths."""
    stopped = lb.stopped_down(library.load("pbrt-dgauss-50mm"), f_number)
    film = lb.film_distance(stopped, inf, "contrast")
    x = 587.56e-6 * f_number * 30.0
    perfect = 2.0 / np.pi * (np.arccos(x) - x * np.sqrt(1.0 - x * x))
    assert axis_contrast(stopped, np.array([film]))[0] == pytest.approx(perfect, abs=0.012)
    assert axis_contrast(stopped, np.array([film]), frequency=1e-6)[0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("name", ["hypergon-103-f20", "minolta-af-apo-tele-200-f28"])
def test_reversed_lines_are_not_taken_for_sharp_ones(name):
    """Rays of a round pupil, from the trace: the cosine sum at the chosen film is positive."""
    name = next(known for known in library.names() if known.endswith(name))
    design = library.load(name)
    film = lb.film_distance(design, inf, "contrast")
    heights = (np.arange(400) + 0.5) / 400.0 * lb.first_order(design).entrance_pupil.radius
    origins = np.stack([0.0 * heights, heights, np.full(400, -10.0)], 1)
    rays = lb.trace(design, origins, np.tile([0.0, 0.0, 1.0], (400, 1)))
    passed = rays.fate == lb.Fate.PASSED
    (_, y, z), (_, m, n), rings = rays.points[passed].T, rays.directions[passed].T, heights[passed]
    landed = y + (film + design.length - z) * m / n
    across = np.cos((np.arange(64) + 0.5) / 64.0 * np.pi)
    signed = (rings[:, None] * np.cos(2.0 * np.pi * 30.0 * landed[:, None] * across)).sum() / (64.0 * rings.sum())
    assert signed > 0.1
