"""Solves meet their targets to 1e-12 in forty digits; pickups follow; a solve without a solution is a finding."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench import lenses
from lensbench.core.optics.finding import Kind
from lensbench.lenses.editing.cells import with_rule, with_value, without_rule
from lensbench.lenses.editing.document import EditError, LensDocument, Pickup, Solve
from lensbench.lenses.editing.elements import air_spaced, cemented, flipped
from lensbench.lenses.editing.structure import deleted, inserted_plane, scaled, split, with_stop, with_stop_in_gap
from tests.lenses.editing import oracle

TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
GAUSS = LensDocument(lenses.load("pbrt-dgauss-50mm"))
NAMES = ("lenshh-cooke-triplet-50", "pbrt-dgauss-50mm", "lv-czj-tessar-50-f28")
EXACT = 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_the_focal_length_is_kept_by_any_curvature_after_every_edit(name):
    document = LensDocument(lenses.load(name))
    last = len(document.surfaces) - 1
    for solved in (last, next(i for i, s in enumerate(document.surfaces) if s.curvature)):
        kept = with_rule(document, Solve(solved, "efl", 60.0))
        assert abs(oracle.efl(kept.lens) / 60 - 1) < EXACT
        other = with_value(kept, 1, "thickness", kept.surfaces[1].thickness * 1.07)
        assert abs(oracle.efl(other.lens) / 60 - 1) < EXACT and not other.findings


@pytest.mark.parametrize("name", NAMES)
def test_the_last_gap_ends_at_the_image_of_an_object_at_infinity(name):
    document = LensDocument(lenses.load(name))
    last = len(document.surfaces) - 1
    kept = with_rule(document, Solve(last, "image"))
    assert abs(oracle.bfl(kept.lens) / kept.surfaces[last].thickness - 1) < EXACT
    bent = with_value(kept, 0, "curvature", document.surfaces[0].curvature * 1.05)
    assert bent.surfaces[last].thickness != kept.surfaces[last].thickness
    assert abs(oracle.bfl(bent.lens) / bent.surfaces[last].thickness - 1) < EXACT


def test_f_number_edge_and_marginal_slope_meet_their_targets():
    kept = TRIPLET
    for rule in (Solve(0, "edge", 1.5), Solve(5, "efl", 50.0), Solve(3, "f-number", 4.5)):
        kept = with_rule(kept, rule)
    assert abs(oracle.edge(*kept.surfaces[:2]) - oracle.mpf("1.5")) < EXACT
    stop = kept.lens.stop
    pupil = 2 * oracle.mpf(stop.semi_diameter) / oracle.bent(kept.lens)[2][3]
    assert abs(oracle.efl(kept.lens) / pupil - oracle.mpf("4.5")) < EXACT
    sloped = with_rule(without_rule(kept, 5, "curvature"), Solve(5, "marginal slope", -0.1))
    y, u, heights = oracle.bent(sloped.lens)
    assert abs(u * oracle.mpf(sloped.lens.stop.semi_diameter) / heights[3] + oracle.mpf("0.1")) < EXACT
    # Before the stop the entrance pupil moves with the curvature too: no linear equation
    before = with_rule(TRIPLET, Solve(1, "marginal slope", -0.02))
    slope = oracle.bent(before.lens, 1)[1] * oracle.mpf(before.lens.stop.semi_diameter)
    assert abs(slope / oracle.bent(before.lens)[2][3] + oracle.mpf("0.02")) < EXACT


def test_a_lens_that_stands_in_water_meets_its_solves_there():
    wet = LensDocument(replace(TRIPLET.lens, front_index=1.333))
    assert oracle.efl(wet.lens) > 1.1 * oracle.efl(TRIPLET.lens)
    for rule in (Solve(5, "efl", 60.0), Solve(5, "image")):
        wet = with_rule(wet, rule)
    assert abs(oracle.efl(wet.lens) / 60 - 1) < EXACT
    assert abs(oracle.bfl(wet.lens) / wet.surfaces[5].thickness - 1) < EXACT
    stopped = with_rule(wet, Solve(3, "f-number", 4.5))
    pupil = 2 * oracle.mpf(stopped.lens.stop.semi_diameter) / oracle.bent(stopped.lens)[2][3]
    assert abs(oracle.efl(stopped.lens) / pupil - oracle.mpf("4.5")) < EXACT
    sloped = with_rule(without_rule(wet, 5, "curvature"), Solve(5, "marginal slope", -0.1))
    y, u, heights = oracle.bent(sloped.lens)
    assert abs(u * oracle.mpf(sloped.lens.stop.semi_diameter) / heights[3] + oracle.mpf("0.1")) < EXACT


def test_pickups_follow_in_chains_and_free_numbers_keep_their_value():
    chain = with_rule(with_rule(TRIPLET, Pickup(4, "curvature", 0, -1.0)), Pickup(5, "curvature", 4, -0.5, 0.001))
    moved = with_value(chain, 0, "curvature", 0.04)
    assert [moved.surfaces[i].curvature for i in (4, 5)] == [-0.04, 0.021]
    with pytest.raises(EditError, match="radius of surface 4 follows from a rule .*surface 0.*remove it first"):
        with_value(chain, 4, "curvature", 0.02)
    free = without_rule(moved, 4, "curvature")
    assert with_value(free, 0, "curvature", 0.05).surfaces[4].curvature == -0.04


def test_rules_that_cannot_be_are_refused_and_those_without_a_solution_are_findings():
    with pytest.raises(EditError, match="in a circle"):
        with_rule(with_rule(TRIPLET, Pickup(4, "curvature", 0)), Pickup(0, "curvature", 4))
    for wrong in (lambda: Solve(0, "height"), lambda: Solve(0, "efl", 0.0), lambda: Solve(0, "efl", float("nan")),
                  lambda: Pickup(2, "curvature", 2), lambda: with_rule(TRIPLET, Solve(9, "efl", 50.0)),
                  lambda: with_rule(TRIPLET, Solve(5, "edge", 1.0)),
                  lambda: with_rule(TRIPLET, Solve(0, "f-number", 4))):
        with pytest.raises(EditError):
            wrong()
    plane = inserted_plane(TRIPLET, 6)                      # air on both sides: it has no power to give
    stuck = with_rule(plane, Solve(6, "efl", 80.0))
    assert stuck.surfaces == plane.surfaces
    assert [(f.kind, f.surface) for f in stuck.findings] == [(Kind.UNSOLVED, 6)]
    two = with_rule(with_rule(TRIPLET, Solve(5, "efl", 50.0)), Solve(4, "efl", 60.0))
    assert [f.kind for f in two.findings] == [Kind.UNSOLVED] and "contradict" in str(two.findings[0])


def test_rules_go_with_their_surfaces_and_scale_with_the_lens():
    kept = with_rule(with_rule(TRIPLET, Solve(5, "efl", 50.0)), Pickup(4, "thickness", 0, 1.0, 0.5))
    grown = inserted_plane(kept, 1)
    assert grown.solves == (Solve(6, "efl", 50.0),) and grown.pickups == (Pickup(5, "thickness", 0, 1.0, 0.5),)
    larger = scaled(kept, 2.0)
    assert larger.solves == (Solve(5, "efl", 100.0),) and larger.pickups[0].offset == 1.0
    assert abs(oracle.efl(larger.lens) / 100 - 1) < EXACT
    gone = deleted(kept, [5])
    assert not gone.solves and any("1 solve or pickup of deleted surfaces" in str(f) for f in gone.findings)
    stopped = with_stop(with_rule(TRIPLET, Solve(3, "f-number", 5.0)), 2)
    assert stopped.solves == (Solve(2, "f-number", 5.0),)


def shapes(document):
    """The numbers that say what light meets."""
    return [(s.curvature, s.thickness, s.semi_diameter, s.glass.n_d) for s in document.surfaces]


def test_rules_change_nothing_where_a_group_is_turned_round_and_go_with_their_gaps():
    rules = (Solve(0, "edge", 2.0), Solve(5, "image"), Pickup(4, "thickness", 0, 1.0, -0.9),
             Pickup(4, "curvature", 0, 0.3), Pickup(3, "curvature", 1, -20.0, 1e-3))
    document = TRIPLET
    for rule in rules:
        document = with_rule(document, rule)
    free = LensDocument(document.lens)
    for first, last in ((0, 1), (4, 5), (0, 3), (0, 5)):
        turned = flipped(document, first, last)
        expected = shapes(flipped(free, first, last))
        expected[5] = (expected[5][0], float(oracle.bfl(turned.lens)), *expected[5][2:])
        assert np.array(shapes(turned)) == pytest.approx(np.array(expected), rel=1e-13, abs=1e-15)
        assert len(turned.rules) == len(rules) and not turned.findings
        assert flipped(turned, first, last).rules == document.rules
    assert flipped(document, 0, 5).rule(4, "thickness") == Solve(4, "edge", 2.0)
    assert flipped(document, 0, 5).rule(5, "thickness") == Solve(5, "image")


def test_a_gap_that_is_divided_or_joined_keeps_its_place_in_spite_of_its_rules():
    ruled = with_rule(with_rule(with_rule(TRIPLET, Solve(0, "edge", 2.0)), Solve(1, "edge", 5.0)), Solve(5, "image"))
    ruled = with_rule(ruled, Pickup(4, "thickness", 2, 3.0))
    free = LensDocument(ruled.lens)
    for edit, kept in ((lambda d: split(d, 0, 0.3), 3), (lambda d: split(d, 2, 0.3), 3),
                       (lambda d: split(d, 5, 0.3), 4), (lambda d: inserted_plane(d, 1), 3),
                       (lambda d: inserted_plane(d, 6), 4), (lambda d: with_stop_in_gap(d, 1, 2.0), 3)):
        made = edit(ruled)
        assert np.array(shapes(made)) == pytest.approx(np.array(shapes(edit(free))), rel=1e-13, abs=1e-13)
        assert len(made.rules) == kept
        assert any("went with them" in str(f) for f in made.findings) == (kept < 4)
    # A plane that bends no ray is taken away, and a rule of the gap before it goes too
    plane = with_rule(split(TRIPLET, 1, 0.3), Solve(1, "edge", 1.0))
    assert shapes(deleted(plane, [2])) == shapes(deleted(LensDocument(plane.lens), [2]))


def test_a_cemented_gap_takes_its_rules_with_it_and_a_separated_element_keeps_its_own():
    joint = next(i for i in range(1, 10) if GAUSS.surfaces[i - 1].glass.n_d > 1.0 and GAUSS.surfaces[i].glass.n_d > 1.0)
    ruled = with_rule(GAUSS, Solve(joint, "edge", float(oracle.edge(*GAUSS.surfaces[joint:joint + 2]))))
    apart = air_spaced(ruled, joint, 0.5)
    assert apart.surfaces[joint].thickness == 0.5
    assert [(s.surface, s.kind) for s in apart.solves] == [(joint + 1, "edge")]
    both = with_rule(apart, Solve(joint, "edge", 0.4))
    closed = cemented(both, joint)
    assert closed.solves == ruled.solves and any("went with them" in str(f) for f in closed.findings)
    assert np.array(shapes(closed)) == pytest.approx(np.array(shapes(ruled)), rel=1e-13, abs=1e-15)


def test_a_conic_that_follows_another_is_the_same_where_one_of_both_is_turned_round():
    document = with_rule(with_value(TRIPLET, 0, "conic", -0.4), Pickup(5, "conic", 0))
    for (first, last), (source, follower) in (((0, 1), (1, 5)), ((4, 5), (0, 4)), ((0, 5), (5, 0))):
        turned = flipped(document, first, last)
        assert turned.surfaces[source].conic == turned.surfaces[follower].conic == -0.4, (first, last)


@pytest.mark.parametrize("rule", [Solve(10, "efl", 30.0), Solve(16, "marginal slope", -0.1), Solve(14, "image", 20.0),
                                  Pickup(15, "thickness", 13, 2.0), Pickup(10, "semi_diameter", 9, 1.1)], ids=str)
def test_rules_of_a_zoom_lens_hold_at_its_wide_end_wherever_it_is_set(rule):
    lens = lenses.load("canon-ef-28-105-f4")
    wide = with_rule(LensDocument(lens.at(zoom=0.0, close=0.0)), rule).lens
    for zoom in (0.3, 1.0):
        tele = with_rule(LensDocument(lens.at(zoom=zoom, close=0.0)), rule).lens
        assert tele == wide.at(zoom=zoom) != wide


def test_a_stop_that_varies_cannot_follow_from_others():
    zoom = LensDocument(lenses.load("canon-ef-28-105-f4").at(zoom=0.0, close=0.0))
    for rule in (Solve(9, "f-number", 5.0), Pickup(9, "semi_diameter", 8)):
        with pytest.raises(EditError, match="the stop varies with zoom or focus"):
            with_rule(zoom, rule)
