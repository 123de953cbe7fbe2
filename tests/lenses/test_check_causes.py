"""Named causes: a good lens is damaged in a known way, and `check` must name that way with the right value."""

import random
from dataclasses import replace
from functools import cache
from math import inf

import pytest

from lensbench import Glass, Lens, Surface, first_order, lenses
from lensbench.core.optics.system import FieldPoint, SystemData
from lensbench.lenses.checks.figures import lit_field
from tests.lenses.published import published

SPHERICAL = ["pbrt-dgauss-50mm", "lv-czj-tessar-50-f28", "lv-zeiss-distagon-35mm-f4-contarex", "lib-tronnier-1953",
             "lv-leica-summicron-m-50f2-v5", "lib-bertele-sonnar-1998704a"]
ASPHERIC = ["lv-nikon-z-58f095-noct", "lib-us7558005a", "lv-pentax-02-standard-zoom-5-15-f28-45"]


@cache
def sound(name):
    """A library lens at its first station, with its own figures as the stated ones."""
    lens = replace(lenses.load(name).at(), positions=None)
    fo = first_order(lens)
    f_number = lens.stated_f_number or float(f"{fo.f_number:.2g}")
    lens = replace(lens, stated_efl=float(f"{fo.efl:.5g}"), stated_f_number=f_number, findings=())
    return with_surface(lens, len(lens.surfaces) - 1, thickness=float(f"{fo.bfl:.6g}"))


def with_surface(lens, i, **changes):
    surfaces = list(lens.surfaces)
    surfaces[i] = replace(surfaces[i], **changes)
    return replace(lens, surfaces=tuple(surfaces))


def with_surfaces(lens, changed):
    return replace(lens, surfaces=tuple(changed(i, surface) for i, surface in enumerate(lens.surfaces)))


def warnings(lens):
    return {finding.kind for finding in lenses.check(lens) if finding.severity == "warning"}


def first_cause(lens):
    return next(finding for finding in lenses.check(lens) if finding.change is not None)


def names_it(lens, kind, after, quantity=None):
    """Require that the first finding is this cause and proposes this value."""
    cause = lenses.check(lens)[0]
    assert cause.kind == kind and cause.change is not None and cause.proposal
    assert cause.change.after == pytest.approx(after, rel=1e-3)
    assert quantity is None or cause.change.quantity == quantity
    return cause


@pytest.mark.parametrize("name", SPHERICAL + ASPHERIC)
def test_a_lens_with_its_own_figures_has_no_cause(name):
    assert not [finding for finding in lenses.check(sound(name)) if finding.severity == "warning" or finding.change]


@pytest.mark.parametrize("name", SPHERICAL)
def test_a_lens_that_was_computed_in_water_is_recognised(name):
    wet = replace(sound(name), front_index=1.333)
    fo = first_order(wet)
    wet = with_surface(replace(wet, stated_efl=fo.efl, stated_f_number=None), -1, thickness=fo.bfl)
    names_it(replace(wet, front_index=1.0), "medium", 1.333, "front_index")
    names_it(replace(sound(name), front_index=1.333), "medium", 1.0)


@pytest.mark.parametrize("name", [name for name in SPHERICAL + ASPHERIC if "us7558005a" not in name])
@pytest.mark.parametrize("factor", [1.0 / 25.4, 25.4, 0.1, 10.0])
def test_lengths_in_another_unit_are_recognised(name, factor):
    lens = sound(name)
    names_it(replace(lens.scaled(1.0 / factor), stated_efl=lens.stated_efl), "scale", factor)


@pytest.mark.parametrize("name", SPHERICAL)
def test_a_table_normalised_to_100_is_recognised(name):
    lens = sound(name)
    normal = replace(lens.scaled(100.0 / first_order(lens).efl), stated_efl=lens.stated_efl)
    if abs(lens.stated_efl / 100.0 - 0.1) > 0.01:
        assert "normalised to a focal length of 100" in names_it(normal, "scale", lens.stated_efl / 100.0).message


@pytest.mark.parametrize("thickness", [2.5, 4.0])
@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lv-zeiss-distagon-35mm-f4-contarex",
                                  "lv-leica-summicron-m-50f2-v5"])
def test_an_omitted_plate_is_found_with_its_thickness(name, thickness):
    # by Snell: a plate of thickness t moves the focus back by t (1 − 1/n)
    lens = replace(sound(name), year=None)
    stored = lens.surfaces[-1].thickness + thickness * (1.0 - 1.0 / 1.5168)
    cause = names_it(with_surface(lens, -1, thickness=stored), "cover-glass", thickness)
    assert cause.figures["blur_after"] < 0.3 * cause.figures["blur"]
    # before there were sensors there was no cover glass before the film
    assert "cover-glass" not in warnings(with_surface(replace(lens, year=1950), -1, thickness=stored))


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lv-leica-summicron-m-50f2-v5"])
def test_what_a_table_leaves_out_behind_its_last_gap_is_measured_in_air(name):
    lens = replace(sound(name), year=None)
    short = with_surface(lens, -1, thickness=lens.surfaces[-1].thickness - 3.0)
    assert "equal 3 mm of air" in first_cause(short).proposal


@pytest.mark.parametrize("name", ["lv-nikon-z-58f095-noct", "lv-pentax-02-standard-zoom-5-15-f28-45"])
def test_conics_given_as_1_plus_k_are_recognised(name):
    lens = sound(name)
    wrong = with_surfaces(lens, lambda i, s: replace(s, conic=s.conic + 1.0) if s.aspheric or s.conic else s)
    if warnings(wrong):                                 # else too weak to be seen
        assert names_it(wrong, "conic", first_cause(wrong).change.before - 1.0).change.quantity == "conic"


def shifts_within_range(name):
    """The shifts by one term, 2 and -2, that keep every power of a lens in the range of the formats, 2 to 20."""
    powers = [power for s in sound(name).surfaces for power, _ in s.aspheric]
    return [shift for shift in (2, -2) if 2 <= min(powers) + shift and max(powers) + shift <= 20]


@pytest.mark.parametrize(("name", "shift"), [(name, shift) for name in ASPHERIC for shift in shifts_within_range(name)])
def test_coefficients_shifted_by_one_term_are_recognised(name, shift):
    lens = sound(name)
    wrong = with_surfaces(lens, lambda i, s: replace(s, aspheric=tuple((p + shift, a) for p, a in s.aspheric)))
    cause = lenses.check(wrong)[0]
    assert cause.kind == "asphere"
    assert cause.change.after == cause.change.before - shift


def test_at_least_one_damage_to_aspheres_is_seen_on_each_lens():
    # what keeps the two tests above from passing because nothing is wrong
    for name in ("lv-nikon-z-58f095-noct", "lv-pentax-02-standard-zoom-5-15-f28-45"):
        wrong = with_surfaces(sound(name), lambda i, s: replace(s, conic=s.conic + 1.0) if s.aspheric or s.conic else s)
        shifted = with_surfaces(sound(name), lambda i, s: replace(s, aspheric=tuple((p - 2, a) for p, a in s.aspheric)))
        assert warnings(wrong) or warnings(shifted)


@pytest.mark.parametrize("name", SPHERICAL)
def test_the_stop_at_the_wrong_surface_is_found(name):
    lens = sound(name)
    for i in (lens.stop_index - 1, lens.stop_index + 1):
        moved = replace(lens, stop_index=i)
        if warnings(moved):
            names_it(moved, "stop", lens.stop_index, "stop_index")


@pytest.mark.parametrize("name", SPHERICAL)
def test_rims_that_are_diameters_are_recognised(name):
    wrong = with_surfaces(sound(name), lambda i, s: replace(s, semi_diameter=2.0 * s.semi_diameter))
    names_it(wrong, "rim", sound(name).stop.semi_diameter, "semi_diameter")


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lv-zeiss-distagon-35mm-f4-contarex",
                                  "lv-leica-summicron-m-50f2-v5"])
def test_a_field_that_the_rims_do_not_light_is_reported(name):
    lens = sound(name)
    lit, _ = lit_field(lens)
    stated = replace(lens, system=SystemData(fields=(FieldPoint(0.0, lit),)))
    assert "field" not in warnings(stated)
    narrow = with_surfaces(stated, lambda i, s: replace(s, semi_diameter=0.5 * s.semi_diameter)
                           if abs(i - lens.stop_index) > 1 else s)
    assert "field" in warnings(narrow)


def test_the_lit_field_of_a_single_stop_before_a_thin_lens_is_its_geometry():
    # the rim of the lens, 5 mm high, stands 20 mm behind the stop: tan 14.04° = 5/20
    lens = Lens((Surface(20.0, 1.0, curvature=0.0), Surface(1.0, 5.0, Glass(1.5), curvature=1e-9),
                 Surface(50.0, 50.0, curvature=-1e-9)), 0)
    assert lit_field(lens)[0] == pytest.approx(14.04, abs=0.25) and lit_field(lens)[1] == 1


@pytest.mark.parametrize("name", SPHERICAL)
def test_a_misread_index_is_found(name):
    lens = sound(name)
    elements = [i for i, s in enumerate(lens.surfaces) if s.glass.n_d > 1.0]
    i = max(elements, key=lambda i: abs(lens.surfaces[i].curvature))
    glass = lens.surfaces[i].glass
    digit = int(f"{glass.n_d:.5f}"[3])
    wrong = round(glass.n_d + (0.04 if digit < 5 else -0.04), 7)
    cause = names_it(with_surface(lens, i, glass=Glass(wrong, glass.v_d)), "digit", glass.n_d, "n_d")
    assert cause.surface == i


@pytest.mark.parametrize("name", [name for name in SPHERICAL if "tronnier" in name or name.startswith("lv-")])
def test_an_abbe_number_that_no_glass_has_is_traced_to_a_digit(name):
    lens = sound(name)
    count = 0
    for i, surface in enumerate(lens.surfaces):
        v_d = surface.glass.v_d
        if v_d is None or not 30.0 < v_d < 70.0 or lens.surfaces.count(surface) > 1:
            continue
        wrong = with_surface(lens, i, glass=Glass(surface.glass.n_d, float("9" + f"{v_d:.2f}"[1:])))
        if "glass" in warnings(wrong):
            digits = [f.change.after for f in lenses.check(wrong) if f.kind == "digit" and f.change.quantity == "V_d"]
            assert any(abs(value - v_d) < 0.02 for value in digits)
            count += 1
    assert count


@pytest.mark.slow
@pytest.mark.parametrize("name", SPHERICAL)
def test_of_random_misread_digits_no_other_number_is_accused_first(name):
    lens, rng = sound(name), random.Random(name)
    right = wrong = 0
    for _ in range(12):
        i = rng.choice([i for i, s in enumerate(lens.surfaces) if s.curvature])
        radius = 1.0 / lens.surfaces[i].curvature
        text = f"{radius:.3f}"
        k = rng.choice([k for k, letter in enumerate(text) if letter.isdigit()][:3])
        spoiled = float(text[:k] + rng.choice("123456789") + text[k + 1:])
        causes = [f for f in lenses.check(with_surface(lens, i, curvature=1.0 / spoiled)) if f.change]
        if spoiled != round(radius, 3) and causes:
            right += any(f.surface == i and f.change.quantity == "radius" for f in causes)
            wrong += causes[0].surface != i
    assert right >= 4 and wrong <= 2


def test_a_zoom_whose_last_gap_is_missing_from_its_table_is_recognised():
    name = "lv-pentax-02-standard-zoom-5-15-f28-45"
    lens = lenses.load(name)
    table = lens.positions
    last = table.gaps.index(len(lens.surfaces) - 1)
    kept = [k for k in range(len(table.gaps)) if k != last]
    cut = replace(table, gaps=tuple(table.gaps[k] for k in kept), thicknesses=tuple(
        tuple(tuple(gaps[k] for k in kept) for gaps in row) for row in table.thicknesses))
    causes = [f for f in lenses.check(replace(lens, positions=cut).at()) if f.change]
    assert causes[0].kind == "position" and causes[0].surface == len(lens.surfaces) - 1


# What is unusual and not wrong

BICONVEX = Lens((Surface(6.0, 10.0, Glass(1.5168, 64.17), curvature=0.02), Surface(3.0, 10.0, curvature=-0.02),
                 Surface(0.0, 8.0, curvature=0.0)), 2)


@pytest.mark.parametrize("glass", [Glass(1.74, 16.0), Glass(1.67, 19.2), Glass(1.7, 15.0)])
def test_a_resin_of_high_index_is_no_finding(glass):
    findings = lenses.check(with_surface(with_surface(BICONVEX, 0, glass=glass), 2, semi_diameter=4.0))
    assert "glass" not in {finding.kind for finding in findings}


def test_a_stated_figure_that_the_computed_one_rounds_to_is_no_finding():
    efl = first_order(BICONVEX).efl
    for computed, stated, kinds in ((2.14, 2.1, set()), (2.04, 2.0, set()), (2.16, 2.1, {"focal-length"}),
                                    (20.6, 21.0, set()), (20.4, 21.0, {"focal-length"})):
        assert warnings(replace(BICONVEX.scaled(computed / efl), stated_efl=stated)) == kinds


def test_an_engraved_zoom_range_is_a_note():
    lens = lenses.load("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed")
    nominal = replace(lens, positions=replace(lens.positions, focal_lengths=(70.0, 105.0, 203.0))).at()
    findings = [f for f in lenses.check(nominal) if "focal length" in f.message]
    assert findings and all(finding.severity == "note" for finding in findings)


def test_a_near_limit_that_the_modelled_gaps_do_not_reach_is_a_note():
    lens = lenses.load("lv-minolta-af-100mm-f28-macro")
    other = replace(lens, positions=replace(lens.positions, distances=((inf, 700.0),)))
    assert warnings(other) == set() and "0.7 m is stated" in lenses.check(other)[0].message


# Published tables with an error in them

@pytest.mark.parametrize(("name", "kind", "surface", "after"), [
    ("canon-rf-is-stm-28-70-f28", "cover-glass", 27, 2.04),
    ("fujifilm-fujinon-23-f2", "cover-glass", 14, 2.068),
    ("fujifilm-fujinon-xf-r-23-f14", "asphere", None, 0.0),
    ("itoh-wide-angle-zoom-100-146-f345", "position", 18, 189.53),
    ("konica-minolta-fl-hexanon-ar-300-f63", "digit", 9, 50.1),
    ("nikon-ai-nikkor-s-if-ed-200-f2", "digit", 17, 65.74),
    ("olympus-om-zuiko-fisheye-16-f35", "stop", 12, 4.946),
    ("schneider-kreuznach-super-angulon-65-f8", "digit", 9, 1.4645),
    ("sigma-14-f4", "hemisphere", 1, 9.0102),
    ("tamron-sp-af-di-ld-if-macro-b01-180-f35", "digit", 4, 37.17),
])
def test_the_cause_of_a_published_error_is_named_first(name, kind, surface, after):
    cause = first_cause(published(name))
    assert (cause.kind, cause.surface) == (kind, surface)
    assert cause.change.after == pytest.approx(after, rel=2e-3)


@pytest.mark.parametrize("name", ["carl-zeiss-rudolph-double-gauss-50-f45", "phone-56-f35"])
def test_a_film_set_for_the_full_aperture_of_a_published_lens_is_a_note(name):
    findings = lenses.check(published(name))
    assert [(finding.kind, finding.severity) for finding in findings] == [("back-focus", "note")]


def test_an_f2_lens_whose_aspheres_lost_their_r4_is_reported_with_that_and_no_number_is_made_up():
    """The patent's terms alternate (f = 1 mm): r⁴ 9.39e-5, r⁶ 35.7, r⁸ 9.08e-10, r¹⁰ 17.0, r¹² 7.8e-16."""
    blur, terms = lenses.check(published("leica-apo-summicron-m-asph-35-f2"))
    assert blur.kind == "blur" and blur.figures["blur"] > blur.figures["allowed"]
    assert terms.kind == "asphere" and terms.change is None and "surfaces 0, 11, 14, 15" in terms.message


def test_the_field_that_small_rims_leave_dark_is_reported_beside_the_stop():
    assert "field" in warnings(published("olympus-om-zuiko-fisheye-16-f35"))
