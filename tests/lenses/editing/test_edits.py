"""Each edit changes just its numbers, what cannot be is refused with a reason, and the light does what it should."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

import lensbench as lb
from lensbench import AIR, Glass, Surface, lenses
from lensbench.core.optics.finding import Kind
from lensbench.lenses.editing import cells, elements, structure
from lensbench.lenses.editing.document import EditError, LensDocument, Pickup, Solve, from_text, lost_edits, to_text
from lensbench.lenses.editing.faults import faults
from lensbench.lenses.file_error import LensFileError
from tests.lenses.editing import oracle

TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
GAUSS = LensDocument(lenses.load("pbrt-dgauss-50mm"))
ZOOM = LensDocument(next(lens for lens in map(lenses.load, lenses.names()) if lens.zooms).at(zoom=0.0, close=0.0))


def spot(lens, height=3.0):
    """Where and at which slope a real meridional ray parallel to the axis leaves the lens."""
    traced = lb.trace(lens, [[0.0, height, -10.0]], [[0.0, 0.02, 1.0]], clip=False)
    assert traced.fate[0] == lb.Fate.PASSED
    return np.concatenate([traced.points[0], traced.directions[0]])


def changed(before, after):
    """(surface, field) of all numbers that differ."""
    return {(i, name) for i, (a, b) in enumerate(zip(before.surfaces, after.surfaces, strict=True))
            for name in ("curvature", "thickness", "semi_diameter", "conic", "aspheric", "glass", "curvature_x")
            if getattr(a, name) != getattr(b, name)}


@pytest.mark.parametrize("quantity, value, name", [
    ("curvature", 0.031, "curvature"), ("thickness", 2.2, "thickness"), ("semi_diameter", 5.0, "semi_diameter"),
    ("conic", -0.4, "conic"), ("r4", 1e-6, "aspheric"), ("r20", -1e-30, "aspheric")])
def test_a_number_changes_alone(quantity, value, name):
    for i in range(6):
        after = cells.with_value(TRIPLET, i, quantity, value)
        assert changed(TRIPLET, after) == {(i, name)}
        assert replace(after.lens, surfaces=TRIPLET.surfaces) == TRIPLET.lens
    same = getattr(TRIPLET.surfaces[2], name) if name != "aspheric" else 0.0
    assert cells.with_value(TRIPLET, 2, quantity, same) is TRIPLET


@pytest.mark.parametrize("wrong", [
    lambda: cells.with_value(TRIPLET, 0, "curvature", nan), lambda: cells.with_value(TRIPLET, 0, "thickness", inf),
    lambda: cells.with_value(TRIPLET, 0, "semi_diameter", 0.0), lambda: cells.with_value(TRIPLET, 0, "r21", 0.1),
    lambda: cells.with_value(TRIPLET, 6, "conic", 0.1), lambda: cells.with_value(TRIPLET, -1, "conic", 0.1),
    lambda: cells.with_value(TRIPLET, 0, "curvature", 1e9), lambda: cells.with_radius(TRIPLET, 0, "abc"),
    lambda: cells.with_radius(TRIPLET, 0, "nan"), lambda: cells.with_glass(TRIPLET, 0, "1.5 x"),
    lambda: cells.with_glass(TRIPLET, 0, Glass(9.0)), lambda: structure.deleted(TRIPLET, range(6)),
    lambda: structure.deleted(TRIPLET, [7]), lambda: structure.scaled(TRIPLET, 0.0),
    lambda: structure.scaled(TRIPLET, 1e12), lambda: elements.flipped(TRIPLET, 0, 0),
    lambda: elements.cemented(TRIPLET, 0), lambda: elements.air_spaced(TRIPLET, 1),
    lambda: structure.split(TRIPLET, 0, 1.5), lambda: structure.moved(TRIPLET, 0, 1, 9),
    lambda: structure.with_stop(TRIPLET, 6), lambda: structure.with_stop_in_gap(TRIPLET, 1, 7.0),
    lambda: structure.inserted(TRIPLET, 0, [Surface(1.0, 1e12, curvature=0.0)])])
def test_what_no_surface_can_have_is_refused(wrong):
    with pytest.raises(EditError) as told:
        wrong()
    assert str(told.value)


def test_a_radius_of_0_or_infinity_is_a_plane_and_a_text_keeps_its_digits():
    for text in ("0", "inf", 0.0, inf):
        assert cells.with_radius(TRIPLET, 1, text).surfaces[1].curvature == 0.0
    assert cells.with_radius(TRIPLET, 1, "-435.76044") == TRIPLET


def test_glasses_are_found_by_name_code_and_numbers_and_an_unknown_one_names_the_nearest():
    assert cells.with_glass(TRIPLET, 0, "n-bk7").surfaces[0].glass.name == "N-BK7"
    assert cells.with_glass(TRIPLET, 0, "517642").surfaces[0].glass.n_d == pytest.approx(1.5168, abs=1e-4)
    assert cells.with_glass(TRIPLET, 0, "1,5168 64,17").surfaces[0].glass == Glass(1.5168, 64.17)
    assert cells.with_glass(TRIPLET, 0, "air").surfaces[0].glass == AIR
    with pytest.raises(EditError, match="did you mean SCHOTT N-BK7"):
        cells.with_glass(TRIPLET, 0, "N-BK77")


# Structure: laws of light


def test_planes_that_bend_no_ray_are_inserted_and_deleted_without_effect():
    for index in range(7):
        more = structure.inserted_plane(TRIPLET, index)
        assert oracle.efl(more.lens) == oracle.efl(TRIPLET.lens)
        assert more.lens.stop.semi_diameter == TRIPLET.lens.stop.semi_diameter
        assert structure.deleted(more, [index]).lens == TRIPLET.lens
    for gap in range(5):
        halved = structure.split(TRIPLET, gap, 0.3)
        assert spot(halved.lens) == pytest.approx(spot(TRIPLET.lens), abs=1e-12)
        assert halved.lens.length == pytest.approx(TRIPLET.lens.length, abs=1e-13)
        assert changed(TRIPLET, structure.deleted(halved, [gap + 1])) <= {(gap, "thickness")}


def test_a_plane_between_equal_media_of_two_names_is_deleted_without_effect():
    """A melt that is named anew on one side of the plane is the same medium: the rest of the lens keeps its place."""
    halved = structure.split(TRIPLET, 0, 0.3)
    before = halved.surfaces[0].glass
    named = cells.with_glass(halved, 1, replace(before, name="MELT 7"))
    assert changed(TRIPLET, structure.deleted(named, [1])) <= {(0, "thickness")}
    assert structure.deleted(named, [1]).lens.length == pytest.approx(TRIPLET.lens.length, abs=1e-13)


def test_the_object_of_a_design_stays_where_a_plane_before_the_lens_is_deleted():
    """The image solve follows: by 1/v = 1/f − 1/u of the lens itself, whose object lies 20 mm farther from it."""
    lens = replace(GAUSS.lens, surfaces=(Surface(20.0, 30.0, curvature=0.0), *GAUSS.surfaces),
                   stop_index=GAUSS.lens.stop_index + 1,
                   system=replace(GAUSS.lens.system, object_distances=(300.0, inf)))
    document = LensDocument(lens, solves=(Solve(len(lens.surfaces) - 1, "image"),))
    after = structure.deleted(document, [0])
    assert after.lens.system.object_distances == (320.0, inf)
    fo = lb.first_order(GAUSS.lens)
    image = fo.rear_principal + 1.0 / (1.0 / fo.efl - 1.0 / (320.0 + fo.front_principal))
    assert after.surfaces[-1].thickness == pytest.approx(image, rel=1e-9)


def test_a_plane_in_a_gap_that_varies_is_deleted_again_where_it_moves_nothing():
    gap = ZOOM.lens.positions.gaps[0]
    plane = structure.inserted_plane(ZOOM, gap + 1)
    again = structure.deleted(plane, [gap + 1])
    assert again.lens.surfaces == ZOOM.lens.surfaces and again.lens.positions == ZOOM.lens.positions
    thick = cells.with_value(plane, gap + 1, "thickness", 0.1)
    with pytest.raises(EditError, match="before surface .* varies"):
        structure.deleted(thick, [gap + 1])


def test_a_group_flipped_twice_is_the_same_and_the_whole_lens_flipped_has_the_focal_length():
    for first, last in ((0, 1), (2, 3), (0, 3), (0, 5)):
        back = elements.flipped(elements.flipped(TRIPLET, first, last), first, last)
        assert back == TRIPLET
    turned = elements.flipped(TRIPLET, 0, 5)
    assert abs(oracle.efl(turned.lens) / oracle.efl(TRIPLET.lens) - 1) < 1e-14
    assert turned.lens.stop_index == 2 and turned.surfaces[5].thickness == TRIPLET.surfaces[5].thickness
    assert turned.surfaces[0].curvature == -TRIPLET.surfaces[5].curvature


def test_surfaces_move_with_their_gaps_and_scaling_scales_every_length():
    there = structure.moved(TRIPLET, 0, 1, 6)
    assert [s.curvature for s in there.surfaces] == [TRIPLET.surfaces[i].curvature for i in (2, 3, 4, 5, 0, 1)]
    assert structure.moved(there, 4, 5, 0) == TRIPLET and structure.moved(TRIPLET, 2, 3, 2) == TRIPLET
    larger = structure.scaled(TRIPLET, 2.0)
    assert abs(oracle.efl(larger.lens) / oracle.efl(TRIPLET.lens) - 2) < 1e-14
    assert structure.scaled(larger, 0.5) == TRIPLET


def test_a_cemented_surface_is_separated_and_cemented_again():
    joint = next(i for i in range(1, len(GAUSS.surfaces) - 1)
                 if GAUSS.surfaces[i - 1].glass.n_d > 1.0 and GAUSS.surfaces[i].glass.n_d > 1.0)
    apart = elements.air_spaced(GAUSS, joint, 0.5)
    assert len(apart.surfaces) == len(GAUSS.surfaces) + 1 and apart.surfaces[joint].glass == AIR
    assert apart.surfaces[joint + 1].curvature == GAUSS.surfaces[joint].curvature
    assert apart.lens.length == pytest.approx(GAUSS.lens.length + 0.5)
    assert elements.cemented(apart, joint).lens == GAUSS.lens
    assert not elements.cemented(apart, joint).findings
    bent = elements.cemented(cells.with_value(apart, joint + 1, "r4", 1e-6), joint)
    assert bent.lens == GAUSS.lens and "aspheric terms" in str(bent.findings[0])
    # In the limit of no gap between equal curvatures the light does not notice the air
    near = elements.air_spaced(GAUSS, joint, 1e-9)
    assert spot(near.lens) == pytest.approx(spot(GAUSS.lens), abs=1e-8)


def test_the_stop_goes_anywhere_and_the_f_number_stays():
    f_number = lb.first_order(TRIPLET.lens).f_number
    for gap, share in ((0, 0.0), (1, 0.5), (3, 0.25), (4, 1.0)):
        there = structure.with_stop_in_gap(TRIPLET, gap, share * TRIPLET.surfaces[gap].thickness)
        assert there.lens.stop_index == gap + 1 and len(there.surfaces) == 7
        assert lb.first_order(there.lens).f_number == pytest.approx(f_number, rel=1e-12)
        assert oracle.efl(there.lens) == pytest.approx(oracle.efl(TRIPLET.lens), rel=1e-14)
    # A stop that was a plane of its own is taken away where it was
    once = structure.with_stop_in_gap(TRIPLET, 1, 3.0)
    again = structure.with_stop_in_gap(once, 4, 1.0)
    assert len(again.surfaces) == 7 and again.lens.stop_index == 4
    gone = structure.deleted(TRIPLET, [3])
    assert gone.lens.stop_index == 3 and [f.kind for f in gone.findings] == [Kind.MOVED_STOP]


def test_a_gap_of_a_zoom_is_edited_at_its_station_alone():
    gap, positions = ZOOM.lens.positions.gaps[0], ZOOM.lens.positions
    wider = cells.with_value(ZOOM, gap, "thickness", positions.thicknesses[0][0][0] + 0.2)
    assert wider.lens.positions.thicknesses[0][0][0] == pytest.approx(positions.thicknesses[0][0][0] + 0.2)
    assert wider.lens.at(zoom=0.0).surfaces == wider.surfaces
    assert wider.lens.at(zoom=1.0).surfaces == ZOOM.lens.at(zoom=1.0).surfaces
    between = replace(ZOOM, lens=ZOOM.lens.at(zoom=0.123))
    with pytest.raises(EditError, match="varies with the zoom"):
        cells.with_value(between, gap, "thickness", 3.0)
    for wrong in (lambda: structure.deleted(ZOOM, [gap]), lambda: structure.split(ZOOM, gap),
                  lambda: cells.with_rule(ZOOM, Solve(gap, "image"))):
        with pytest.raises(EditError, match="varies with zoom or focus"):
            wrong()
    assert structure.inserted_plane(ZOOM, 0).lens.positions.gaps == tuple(g + 1 for g in positions.gaps)


# A lens that cannot be stays a document


@pytest.mark.parametrize("edit, kind, surface", [
    (lambda: cells.with_value(TRIPLET, 1, "thickness", -1.0), Kind.THICKNESS, 1),
    (lambda: cells.with_value(TRIPLET, 0, "thickness", 1.0), Kind.EDGE, 0),
    (lambda: cells.with_radius(TRIPLET, 0, 7.0), Kind.HEMISPHERE, 0),
    (lambda: cells.with_radius(cells.with_radius(TRIPLET, 4, inf), 5, inf), Kind.NO_IMAGE, None),
    (lambda: cells.with_radius(TRIPLET, 5, -5.0), Kind.RAY, 5)])
def test_a_lens_that_cannot_be_stays_a_document_and_says_where(edit, kind, surface):
    assert faults(TRIPLET) == ()
    assert (kind, surface) in [(f.kind, f.surface) for f in faults(edit())]


# As text


def test_a_document_reads_back_to_the_last_bit_and_a_lens_file_is_one_too():
    rich = cells.with_comment(TRIPLET, 2, "flint “F2” = \\ [x]")
    for rule in (Solve(5, "efl", 50.0 / 3.0), Solve(0, "edge", 0.1), Pickup(4, "curvature", 0, -1.0 / 3.0, 1e-7)):
        rich = cells.with_rule(rich, rule)
    rich = cells.with_value(rich, 1, "r6", -1.2345e-9 / 7.0)
    for document in (rich, GAUSS, ZOOM):
        assert from_text(to_text(document)) == document
    assert lenses.FORMATS[0].read(to_text(rich), "x.toml") == rich.lens           # other readers take the lens
    assert "comments, solves, pickups" in str(lost_edits(rich)[0]) and lost_edits(TRIPLET) == ()


@pytest.mark.parametrize("table", [
    '[comments]\n9 = "x"', "[comments]\n1 = 2", '[[solves]]\nsurface = 9\nkind = "efl"\ntarget = 5.0',
    '[[solves]]\nsurface = true\nkind = "efl"', '[[solves]]\nkind = "efl"', "solves = 3",
    '[[pickups]]\nsurface = 1\nquantity = "colour"\nsource = 2', '[[pickups]]\nshape = 1'])
def test_damaged_rules_name_file_and_line(table):
    with pytest.raises(LensFileError, match="mine.toml"):
        from_text(to_text(TRIPLET) + "\n" + table + "\n", "mine.toml")


@pytest.mark.parametrize("stop_index", [4, 5])
def test_blades_turn_with_the_group_of_the_stop_alone(stop_index):
    document = LensDocument(replace(TRIPLET.lens, stop_index=stop_index, blades=5, blade_rotation=0.2))
    turned = elements.flipped(document, 4, 5).lens
    assert (turned.stop_index, turned.blade_rotation) == (9 - stop_index, -0.2)
    assert elements.flipped(document, 0, 1).lens.blade_rotation == 0.2


def test_planes_before_a_lens_leave_its_object_where_it_is():
    lens = TRIPLET.lens
    planes = (Surface(3.0, 9.0, curvature=0.0), Surface(5.0, 9.0, curvature=0.0))
    document = LensDocument(replace(lens, surfaces=(*planes, *lens.surfaces), stop_index=lens.stop_index + 2,
                                    system=replace(lens.system, object_distances=(200.0,))))
    assert structure.deleted(document, [0, 1]).lens.system.object_distances == (208.0,)
    assert structure.deleted(document, [0]).lens.system.object_distances == (203.0,)


@pytest.mark.parametrize("index", [1.0, 1.333])
def test_a_stop_in_a_gap_lets_the_same_beam_pass_also_from_water(index):
    document = LensDocument(replace(TRIPLET.lens, front_index=index))
    for surface in (1, 3):
        moved = structure.with_stop_in_gap(document, surface, 0.3 * document.surfaces[surface].thickness)
        assert lb.first_order(moved.lens).f_number == pytest.approx(lb.first_order(document.lens).f_number, rel=1e-12)


def test_places_tell_where_the_numbers_of_several_edits_are():
    document = TRIPLET
    for edit in (lambda it: structure.inserted_plane(it, 2), lambda it: elements.flipped(it, 0, 1),
                 lambda it: structure.deleted(it, [5]), lambda it: structure.inserted_plane(it, 0)):
        document = edit(document)
    indices = [document.places.of(i, "semi_diameter") for i in range(6)]
    gaps = [document.places.of(i, "thickness") for i in range(6)]
    assert indices.count(None) == 1 and None in gaps and indices != gaps
    for old, new in enumerate(indices):
        if new is not None:
            assert document.surfaces[new].semi_diameter == TRIPLET.surfaces[old].semi_diameter
            assert document.places.undone().of(new, "semi_diameter") == old
    for old, new in enumerate(gaps):
        if new is not None:
            assert document.surfaces[new].thickness == TRIPLET.surfaces[old].thickness
