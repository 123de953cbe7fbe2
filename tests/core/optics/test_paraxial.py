"""First-order optics against published and 40-digit values, closed forms and the optical invariant."""

import pickle
from dataclasses import replace
from math import inf, isfinite, nan

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import lensbench as lb
from lensbench import lenses as library
from lensbench.core.optics.paraxial import ray_matrix
from tests.core.oracles import LAW, NAMES, REFERENCE, WAVELENGTHS, biconvex, lens, lenses, of_one_colour


@pytest.mark.parametrize(("name", "line"), WAVELENGTHS)
def test_first_order_data_agree_with_the_forty_digit_tracer(name, line):
    expected = REFERENCE[name]["paraxial"][line]
    fo = lb.first_order(lens(name, line))
    found = {
        "efl": fo.efl, "bfl": fo.bfl, "ffl": fo.ffl, "pp1": fo.front_principal, "ppk": fo.rear_principal,
        "enp_dist": fo.entrance_pupil.z, "exp_dist": fo.exit_pupil.z - lens(name, line).length,
        "petzval_radius": fo.petzval_radius,
        # the reference of the triplet is stopped down to a pupil of 12.5 mm: radii relative to the stop's
        "enp_radius": fo.entrance_pupil.radius * expected["stop_radius"] / fo.stop_radius,
        "exp_radius": fo.exit_pupil.radius * expected["stop_radius"] / fo.stop_radius,
        "fno": fo.f_number * fo.stop_radius / expected["stop_radius"],
    }
    assert found == pytest.approx({key: expected[key] for key in found}, rel=1e-11)


@LAW
@given(st.floats(1.3, 2.0), st.floats(10.0, 200.0), st.floats(10.0, 200.0), st.floats(0.1, 15.0))
def test_a_thick_lens_obeys_the_lensmaker(n, r1, r2, thickness):
    fo = lb.first_order(lb.Lens((lb.Surface(thickness, 5.0, lb.Glass(n), curvature=1 / r1),
                                 lb.Surface(0.0, 5.0, curvature=-1 / r2)), 0))
    power = (n - 1) * (1 / r1 + 1 / r2 - (n - 1) * thickness / (n * r1 * r2))
    assume(abs(power) > 1e-4)
    assert fo.efl == pytest.approx(1 / power, rel=1e-10)
    assert fo.front_principal == pytest.approx((n - 1) * thickness / (n * r2) / power, rel=1e-9)
    assert fo.rear_principal == pytest.approx(-(n - 1) * thickness / (n * r1) / power, rel=1e-9)
    assert fo.petzval_radius == pytest.approx(-n / ((n - 1) * (1 / r1 + 1 / r2)), rel=1e-10)


@LAW
@given(lenses())
def test_the_optical_invariant_is_kept_between_any_two_rays(stack):
    a, b, c, d = ray_matrix(stack, 0, len(stack.surfaces))
    assert a * d - b * c == pytest.approx(1.0, abs=1e-12 * (1.0 + abs(a * d) + abs(b * c)))


@LAW
@given(lenses(), st.floats(0.01, 100.0))
def test_first_order_data_scale_with_the_lens(stack, factor):
    fo, scaled = lb.first_order(stack), lb.first_order(stack.scaled(factor))
    assume(isfinite(fo.efl) and abs(fo.efl) < 1e5)
    for name in ("efl", "bfl", "ffl", "front_principal", "rear_principal"):
        expected = getattr(fo, name) * factor
        assert getattr(scaled, name) == pytest.approx(expected, rel=1e-6, abs=1e-9 * abs(fo.efl) * factor)
    assert scaled.f_number == pytest.approx(fo.f_number, rel=1e-9)


@LAW
@given(lenses())
def test_a_reversed_lens_swaps_its_ends(stack):
    n, z, count = stack.indices(), stack.vertices, len(stack.surfaces)
    turned = lb.Lens(tuple(
        lb.Surface(z[i] - z[i - 1] if i else 0.0, surface.semi_diameter, lb.Glass(n[i]), curvature=-surface.curvature)
        for i, surface in reversed(list(enumerate(stack.surfaces)))), count - 1 - stack.stop_index)
    fo, back = lb.first_order(stack), lb.first_order(turned)
    assume(isfinite(fo.efl) and abs(fo.efl) < 1e5)
    found, expected = (back.efl, back.bfl, back.front_principal), (fo.efl, -fo.ffl, -fo.rear_principal)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6)      # six digits are left where surfaces nearly cancel
    assert back.exit_pupil.z == pytest.approx(stack.length - fo.entrance_pupil.z, rel=1e-9, abs=1e-9)
    assert back.exit_pupil.radius == pytest.approx(fo.entrance_pupil.radius, rel=1e-9)


def test_a_stop_in_first_and_in_last_position_is_its_own_image():
    front = lb.Lens((lb.Surface(7.0, 3.0, curvature=0.0), *biconvex().surfaces), 0)
    assert (lb.first_order(front).entrance_pupil.z, lb.first_order(front).entrance_pupil.radius) == (0.0, 3.0)
    glass, rear = biconvex().surfaces
    behind = lb.Lens((glass, lb.Surface(7.0, 20.0, curvature=rear.curvature), lb.Surface(0.0, 3.0, curvature=0.0)), 2)
    assert (lb.first_order(behind).exit_pupil.z, lb.first_order(behind).exit_pupil.radius) == (11.0, 3.0)


def test_a_stop_in_a_focus_makes_the_lens_telecentric():
    lens_behind = biconvex()
    front_focus = -lb.first_order(lens_behind).ffl
    towards_film = lb.first_order(lb.Lens((lb.Surface(front_focus, 3.0, curvature=0.0), *lens_behind.surfaces), 0))
    assert (towards_film.exit_pupil.z, towards_film.exit_pupil.radius) == (inf, inf)
    assert towards_film.f_number == pytest.approx(towards_film.efl / 6.0, rel=1e-12)
    glass, rear = lens_behind.surfaces
    rear_focus = lb.first_order(lens_behind).bfl
    towards_scene = lb.Lens((glass, lb.Surface(rear_focus, 20.0, curvature=rear.curvature),
                             lb.Surface(0.0, 3.0, curvature=0.0)), 2)
    assert (lb.first_order(towards_scene).entrance_pupil.z, lb.first_order(towards_scene).f_number) == (inf, 0.0)
    with pytest.raises(lb.LensError, match="telecentric"):
        lb.stopped_down(towards_scene, 8.0)


def test_flat_glass_is_afocal_and_says_so_by_infinities():
    window = lb.Lens((lb.Surface(5.0, 10.0, lb.Glass(1.5), curvature=0.0), lb.Surface(0.0, 10.0, curvature=0.0)), 0)
    fo = lb.first_order(window)
    assert {fo.efl, fo.bfl, fo.ffl, fo.f_number, fo.front_principal, fo.rear_principal, fo.petzval_radius} == {inf}
    assert fo.exit_pupil.z == pytest.approx(5.0 - 5.0 / 1.5, rel=1e-15)      # the glass lifts what lies behind it
    with pytest.raises(lb.LensError, match="afocal"):
        lb.stopped_down(window, 8.0)


def test_two_lenses_with_a_common_focus_are_afocal_within_rounding():
    eyepiece = biconvex(0.02)
    fo = lb.first_order(eyepiece)
    gap = fo.bfl - fo.ffl
    first = eyepiece.surfaces[0], lb.Surface(gap, 20.0, curvature=-0.02)
    assert lb.first_order(lb.Lens((*first, *eyepiece.surfaces), 0)).efl == inf


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("f_number", [4.5, 8.0, 22.0])
def test_stopping_down_gives_the_f_number_asked_for(name, f_number):
    wide_open = lens(name)
    closed = lb.stopped_down(wide_open, f_number)
    assert lb.first_order(closed).f_number == pytest.approx(f_number, rel=1e-14)
    assert closed.stop.semi_diameter < wide_open.stop.semi_diameter
    assert closed.surfaces[:closed.stop_index] == wide_open.surfaces[:wide_open.stop_index]


@pytest.mark.parametrize("f_number", [0.0, -2.0, nan, inf, 1.4, 2.02])
def test_an_f_number_that_cannot_be_is_refused(f_number):
    with pytest.raises(lb.LensError, match="f-number|maximum aperture of this lens is f/2.03"):
        lb.stopped_down(lens("dgauss"), f_number)


def test_the_engraved_f_number_means_wide_open():
    engraved = replace(lens("dgauss"), stated_f_number=2.0)
    assert lb.stopped_down(engraved, 2.0) == engraved
    assert lb.stopped_down(engraved, lb.first_order(engraved).f_number) == engraved
    with pytest.raises(lb.LensError, match="maximum aperture"):
        lb.stopped_down(engraved, 1.99)
    nonsense = replace(engraved, stated_f_number=1.2)
    with pytest.raises(lb.LensError, match="maximum aperture"):
        lb.stopped_down(nonsense, 1.2)


def test_transmission_is_fresnels_at_every_glass_surface():
    one = biconvex(index=1.5)
    assert lb.transmission(one) == pytest.approx(0.96**2, rel=1e-15)
    assert lb.t_number(one) == pytest.approx(lb.first_order(one).f_number / 0.96, rel=1e-15)
    indices = np.array(lens("dgauss").indices())
    pairs = zip(indices[:-1], indices[1:], strict=True)
    by_hand = np.prod([4 * a * b / (a + b) ** 2 for a, b in pairs])       # T = 4 n n' / (n + n')²
    assert lb.transmission(lens("dgauss")) == pytest.approx(by_hand, rel=1e-14)


def test_a_coating_replaces_the_reflection_of_surfaces_to_air_alone():
    one = biconvex(index=1.5)
    layer = ((1.38**2 - 1.5) / (1.38**2 + 1.5)) ** 2            # a quarter wave at 0.55 µm
    assert lb.transmission(one, 0.55, "single-layer") == pytest.approx((1.0 - layer)**2, rel=1e-14)
    assert lb.transmission(one, 0.55, lb.Coating.table((0.5,), (0.02,))) == pytest.approx(0.98**2, rel=1e-14)
    gauss = lens("dgauss")
    n = gauss.indices(0.55)
    by_hand = np.prod([1.0 - (0.0 if 1.0 in (a, b) else ((a - b) / (a + b)) ** 2)      # none at 0.55 µm to air
                       for a, b in zip(n[:-1], n[1:], strict=True) if a != b])
    assert lb.transmission(gauss, 0.55, coating="multi-layer") == pytest.approx(by_hand, rel=1e-12)
    with pytest.raises(lb.CoatingError, match="choose one of"):
        lb.transmission(one, coating="gold")


def test_a_surface_with_a_coating_of_its_own_keeps_it():
    one = biconvex(index=1.5)
    first = replace(one.surfaces[0], coating=lb.Coating.table((0.5,), (0.1,)))
    own = replace(one, surfaces=(first, *one.surfaces[1:]))
    assert lb.transmission(own) == pytest.approx(0.9 * 0.96, rel=1e-14)
    assert lb.transmission(own, 0.55, lb.Coating()) == lb.transmission(own, 0.55, "uncoated")


def test_equal_lenses_are_found_by_their_hash_also_in_another_process():
    """Figures are kept by lens: an equal one has the hash of the first, and a pickled one carries no stale hash."""
    first, again = (library.load("lentil-schneider-anamorphic-31-2001") for _ in range(2))
    assert first == again and hash(first) == hash(again)
    assert replace(first, blades=5) not in {first}
    carried = pickle.loads(pickle.dumps(first))
    assert "_hash" not in vars(carried) and {first: 1}[carried] == 1
    assert first.section("x") is first.section("x") and first.section("x") != first.section("y")
    for cut in (first, first.surfaces[0]):
        with pytest.raises(lb.LensError, match="section 'z'"):
            cut.section("z")


@pytest.mark.parametrize("name", ["lv-minolta-af-100mm-f28-macro", "lib-tronnier-1953"])
def test_the_f_number_at_infinity_is_that_of_the_dry_lens_focused_there(name):
    """Wherever its groups are, whatever is before it, and of the colour that is asked for."""
    stack = library.load(name)
    fo = lb.first_order(stack.at(close=0.0))
    expected = fo.efl / (2.0 * fo.entrance_pupil.radius)
    for close in (0.0, 0.4, 1.0):
        moved = stack.at(close=close) if stack.has_focus_groups else stack
        for index in (1.0, 1.333):
            assert lb.f_number_at_infinity(replace(moved, front_index=index)) == pytest.approx(expected, rel=1e-12)
    blue = lb.f_number_at_infinity(stack, 0.4358)
    assert blue == pytest.approx(lb.f_number_at_infinity(of_one_colour(stack, 0.4358)), rel=1e-12)
    assert blue != pytest.approx(expected, rel=1e-6)
