"""Checks of a prescription: they explain known errors, find inserted errors, and accept sound lenses."""

from dataclasses import replace

import pytest
from hypothesis import given, settings

from lensbench import Glass, Lens, Surface, first_order, lenses
from tests.lenses.formats.test_toml_format import prescriptions
from tests.lenses.published import published
from tests.lenses.test_position_table import lenses_with_positions
from tests.library import EVERY

MOVING = [name for name in EVERY if lenses.load(name if isinstance(name, str) else name.values[0]).positions]

# What each published table with an error in it must be found out by
SUSPECTS = {
    "lentil-canon-14mm-1982": {"focal-length"},
    "lentil-cooke-anamorphic-1954": {"foci", "back-focus", "focal-length"},
    "lentil-fisheye-aspheric": {"focal-length", "crossing"},
    "lib-bertele-sonnar-f15": {"solved-radius"},
    "lib-matsubara-1977": {"back-focus"},
    "lib-sonnefeld-1935": {"back-focus", "solved-radius"},
    "lib-us4505553": {"glass", "back-focus", "f-number", "blur", "stop"},
    "lv-nikon-fisheye-nikkor-6mm-f28": {"focal-length", "back-focus", "f-number"},
}


FABRICATION = {"edge", "thickness", "slope"}
STEEP = ("lenshh-laikin-fisheye160-f2", "lib-miyamoto-fisheye-1964")    # beyond 70° at rims that are published


def kinds(lens):
    return {finding.kind for finding in lenses.check(lens)}


@pytest.mark.parametrize("name", SUSPECTS)
def test_a_published_table_with_an_error_is_found_out(name):
    assert kinds(published(name)) >= SUSPECTS[name]


def test_the_lost_sign_of_the_6_mm_fisheye_is_found():
    proposals = [finding.proposal for finding in lenses.check(published("lv-nikon-fisheye-nikkor-6mm-f28"))]
    assert "radius of surface 16: 45 instead of -45" in proposals[0]


@pytest.mark.parametrize("name", SUSPECTS)
def test_no_other_published_error_is_explained_by_chance(name):
    proposals = [finding.proposal for finding in lenses.check(published(name)) if finding.proposal]
    # In one, a glass that is named CAF2 has the numbers of a placeholder: the name is the proposal
    assert bool(proposals) == (name in ("lv-nikon-fisheye-nikkor-6mm-f28", "lib-us4505553"))


@pytest.mark.parametrize("name", EVERY)
def test_a_sound_lens_raises_no_alarm(name):
    # Of glass that is hard to make, most of it at estimated rims: `test_check_fabrication`
    assert kinds(lenses.load(name)) <= FABRICATION
    assert {finding.severity for finding in lenses.check(lenses.load(name))} <= (
        {"note", "warning"} if name in STEEP else {"note"})


def test_a_sound_anamorphic_lens_raises_no_alarm():
    assert lenses.check(published("lentil-schneider-anamorphic-31-2001")) == []


def test_that_there_is_no_stop_is_said_and_nothing_else():
    assert kinds(published("lentil-takumar-1969")) == {"no-stop"}


@pytest.mark.parametrize("name", SUSPECTS)
def test_the_findings_do_not_depend_on_the_scale(name):
    # but for a solved radius, whose digits a scale changes as well, and edges below 0.1 mm; a power of two keeps all
    # ratios exact
    lens, scaled = published(name), {"solved-radius", "edge"}
    assert kinds(lens.scaled(4.0)) - scaled == kinds(lens) - scaled


# Errors that are put in: into lenses whose stated focal length and back focus are those of their surfaces

SOUND = ["pbrt-dgauss-50mm", "lv-czj-tessar-50-f28", "lv-zeiss-distagon-35mm-f4-contarex", "lib-tronnier-1953",
         "lv-leica-summicron-m-50f2-v5"]


def exact(name):
    """A library lens with its own figures as the stated ones."""
    lens = lenses.load(name)
    fo = first_order(lens)
    return with_surface(replace(lens, stated_efl=float(f"{fo.efl:.5g}")), len(lens.surfaces) - 1,
                        thickness=float(f"{fo.bfl:.6g}"))


def with_surface(lens, i, **changes):
    surfaces = list(lens.surfaces)
    surfaces[i] = replace(surfaces[i], **changes)
    return replace(lens, surfaces=tuple(surfaces))


def proposals(lens):
    return [finding.proposal for finding in lenses.check(lens) if finding.proposal]


@pytest.mark.parametrize("name", SOUND)
def test_a_lost_sign_is_found_wherever_it_is_lost(name):
    lens = exact(name)
    for i, surface in enumerate(lens.surfaces):
        wrong = with_surface(lens, i, curvature=-surface.curvature)
        if not kinds(wrong) & {"focal-length", "back-focus"}:
            continue                                    # too weak a surface for its sign to be seen
        told = proposals(wrong)
        assert told and f"radius of surface {i}: {1.0 / surface.curvature:.7g} instead of" in told[0]


@pytest.mark.parametrize(("name", "surface", "quantity", "wrong"), [
    ("pbrt-dgauss-50mm", 0, "radius", 29.475 + 40.0),               # 69.475 for 29.475
    ("lv-czj-tessar-50-f28", 1, "thickness", None),                 # its point moved
    ("lv-leica-summicron-m-50f2-v5", 2, "radius", None),
])
def test_a_misread_digit_or_point_is_found(name, surface, quantity, wrong):
    lens = exact(name)
    right = lens.surfaces[surface]
    if quantity == "radius":
        radius = 1.0 / right.curvature
        spoiled = with_surface(lens, surface, curvature=1.0 / (wrong or 10.0 * radius))
        told = f"radius of surface {surface}: {radius:.7g} instead of"
    else:
        spoiled = with_surface(lens, surface, thickness=wrong or 10.0 * right.thickness)
        told = f"thickness of surface {surface}: {right.thickness:.7g} instead of"
    assert any(told in proposal for proposal in proposals(spoiled))


# One defect at a time, in a biconvex lens before its stop

BICONVEX = Lens((Surface(6.0, 10.0, Glass(1.5168, 64.17), curvature=0.02), Surface(3.0, 10.0, curvature=-0.02),
                 Surface(0.0, 8.0, curvature=0.0)), 2)


def test_a_biconvex_lens_raises_no_alarm():
    assert lenses.check(BICONVEX) == []


@pytest.mark.parametrize(("kind", "surface", "change"), [
    ("edge", 0, {"curvature": 0.09}),                               # sags of 6.3 and 1 mm, of 6 mm
    ("hemisphere", 0, {"curvature": 0.11}),
    ("hemisphere", 0, {"curvature": 0.06, "conic": 3.0}),
    ("thickness", 0, {"thickness": 0.0}),
    ("crossing", 1, {"curvature": -0.02, "aspheric": ((4, 1e-3),)}),
    ("stop", 2, {"semi_diameter": 30.0}),
    ("edge", 0, {"thickness": 1.5}),
])
def test_each_defect_is_named_with_its_surface(kind, surface, change):
    spoiled = BICONVEX if kind != "crossing" else replace(
        BICONVEX, surfaces=(*BICONVEX.surfaces[:2], Surface(5.0, 10.0, curvature=-0.01), BICONVEX.surfaces[2]),
        stop_index=3)
    pairs = [(finding.kind, finding.surface) for finding in lenses.check(with_surface(spoiled, surface, **change))]
    assert (kind, surface) in pairs


@pytest.mark.parametrize("glass", [Glass(1.5, 40.0), Glass(1.9, 60.0), Glass(2.4, 30.0)])
def test_numbers_far_from_every_known_glass_are_reported(glass):
    findings = lenses.check(with_surface(BICONVEX, 0, glass=glass))
    assert [finding.surface for finding in findings if finding.kind == "glass"] == [0]


@pytest.mark.parametrize("glass", [Glass(1.5), Glass(1.4918, 57.4), Glass(1.46, 67.8), Glass(1.84666, 23.78, "J-SF03")])
def test_a_glass_of_unknown_dispersion_a_plastic_and_a_made_up_name_raise_no_alarm(glass):
    assert lenses.check(with_surface(BICONVEX, 0, glass=glass)) == []


def test_a_glass_with_the_numbers_of_another_is_reported_with_the_right_ones():
    findings = lenses.check(with_surface(BICONVEX, 0, glass=Glass(1.6727, 32.2, "N-BK7")))
    assert [finding.kind for finding in findings] == ["glass"] and "1.5168" in findings[0].proposal


def test_several_names_with_the_same_impossible_numbers_are_one_finding():
    findings = [finding for finding in lenses.check(published("lib-us4505553")) if finding.kind == "glass"]
    assert len(findings) == 1 and all(name in findings[0].message for name in ("NBFD5", "FDS9", "CAF2"))


def test_a_glass_that_is_opaque_at_the_d_line_is_reported():
    infrared = Glass(3.4, None, "silicon", "cauchy", (3.4,), (1.2, 8.0))
    assert kinds(with_surface(BICONVEX, 0, glass=infrared)) == {"glass"}


def test_an_afocal_and_a_diverging_lens_are_reported():
    plate = with_surface(with_surface(BICONVEX, 0, curvature=0.0), 1, curvature=0.0)
    assert "afocal" in lenses.check(plate)[0].message
    hollow = with_surface(with_surface(BICONVEX, 0, curvature=-0.02), 1, curvature=0.02)
    assert any("diverges" in finding.message for finding in lenses.check(hollow))


@pytest.mark.slow
@given(prescriptions())
@settings(max_examples=150)
def test_of_any_table_something_can_be_said(lens):
    for finding in lenses.check(lens):
        assert finding.message and "nan" not in finding.message
        assert finding.surface is None or 0 <= finding.surface < len(lens.surfaces)


# Positions

NIKKOR = "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"


def moved(name, i, j, k, gap):
    """A library lens with one gap of one station changed."""
    lens = lenses.load(name)
    table = [[list(gaps) for gaps in row] for row in lens.positions.thicknesses]
    table[i][j][k] = gap(table[i][j][k])
    thicknesses = tuple(tuple(map(tuple, row)) for row in table)
    return replace(lens, positions=replace(lens.positions, thicknesses=thicknesses)).at()


def told(lens):
    return [finding.message for finding in lenses.check(lens) if finding.kind == "position"]


def test_a_gap_that_is_wrong_at_one_station_is_found_there():
    # 25.29743 misread as 28.29743: neither in focus, nor of its focal length, nor as long as the others
    wrong = told(moved(NIKKOR, 1, 0, 2, lambda gap: gap + 3.0))
    assert all(message.startswith("at 105 mm, ") for message in wrong)
    assert any("paraxial focus" in message for message in wrong)
    assert ("at 105 mm, infinity: the gaps behind surfaces 4, 8, 15, 20 add up to 61.6749 mm, at the others to "
            "58.6749 mm") in wrong


def test_the_last_digit_of_a_gap_that_no_focus_betrays_is_found_by_the_sum_of_its_neighbours():
    assert told(moved(NIKKOR, 2, 1, 0, lambda gap: gap + 0.01)) == [
        "at 196 mm, close: the gaps behind surfaces 4, 8, 15, 20 add up to 58.6849 mm, at the others to 58.6749 mm"]
    # a zoom that changes its length: to focus, its second group moves between two that do not
    assert told(moved("lv-pentax-02-standard-zoom-5-15-f28-45", 1, 1, 0, lambda gap: gap + 0.001)) == [
        "at 10 mm, close: the gaps behind surfaces 6, 8 add up to 12.072 mm, at infinity to 12.071 mm"]


def test_a_negative_gap_is_found_at_its_station_and_nowhere_else():
    wrong = told(moved(NIKKOR, 2, 0, 2, lambda gap: -gap))
    assert any(message.startswith("at 196 mm, infinity: the air behind surface 15 has a thickness of -1.9617")
               for message in wrong)
    assert not any("71.4 mm" in message or "105 mm" in message for message in wrong)


def test_a_station_of_another_focal_length_than_stated_is_found():
    lens = lenses.load(NIKKOR)
    stated = replace(lens, positions=replace(lens.positions, focal_lengths=(71.4, 150.0, 196.0)))
    assert told(stated)[0].startswith("at 150 mm, infinity: the focal length is 105 mm, 30 % from the stated 150 mm")
    assert len(told(stated)) == 1


def test_a_front_group_that_is_too_small_for_the_long_end_is_found_there():
    lens = lenses.load(NIKKOR)
    small = tuple(replace(s, semi_diameter=0.6 * s.semi_diameter) if i < 5 else s for i, s in enumerate(lens.surfaces))
    wrong = lenses.check(replace(lens, surfaces=small))
    assert wrong and {finding.kind for finding in wrong} == {"position"}
    assert all(finding.message.startswith("at 196 mm, infinity: ") for finding in wrong)
    assert any("the stop does not limit the light" in finding.message for finding in wrong)


def test_a_near_station_that_is_in_focus_elsewhere_than_stated_is_found():
    lens = lenses.load("lv-minolta-af-100mm-f28-macro")
    far_off = replace(lens, positions=replace(lens.positions, distances=((float("inf"), 700.0),)))
    assert told(far_off) == ["at close: it is in focus at 0.3518 m from the film, where 0.7 m is stated"]
    still = tuple((row[0], row[0]) for row in lens.positions.thicknesses)
    assert told(replace(lens, positions=replace(lens.positions, thicknesses=still))) == [
        "at close: it is in focus no nearer than infinity"]


@pytest.mark.slow
@given(lenses_with_positions())
@settings(max_examples=60)
def test_no_table_of_positions_is_too_odd_to_be_checked(lens):
    for finding in lenses.check(lens):
        assert finding.message and "\n" not in finding.message


@pytest.mark.parametrize("name", MOVING)
def test_the_library_has_no_findings_at_any_position(name):
    lens = lenses.load(name)
    assert kinds(lens) <= FABRICATION
    if lens.has_focus_groups:
        assert kinds(lens.at(close=1.0)) <= FABRICATION
