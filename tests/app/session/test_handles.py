"""Each handle of the section changes just its numbers, by what its name says."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.plots.section import quarter_turned, surface_curves
from lensbench.app.session.lens_handles import Handle, HandleKind, body_of, dragged, handle_at, label, pose_handles
from lensbench.lenses.editing.cells import with_rule, with_value
from lensbench.lenses.editing.document import EditError, LensDocument, Solve

TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
GAUSS = LensDocument(lenses.load("pbrt-dgauss-50mm"))
FIELDS = ("curvature", "thickness", "semi_diameter", "conic", "aspheric", "glass", "curvature_x", "pose")


def changed(before, after):
    return {(i, name) for i, (a, b) in enumerate(zip(before.surfaces, after.surfaces, strict=True))
            for name in FIELDS if getattr(a, name) != getattr(b, name)}


def at(kind, first, last=None, height=0.0, y=0.0):
    return Handle(kind, first, first if last is None else last, 0.0, y, height)


def test_a_vertex_and_a_group_move_between_neighbours_that_stay():
    for handle, gaps in ((at(HandleKind.VERTEX, 2), {1, 2}), (at(HandleKind.GROUP, 2, 3), {1, 3}),
                         (at(HandleKind.GROUP, 2, 5), {1, 5}), (at(HandleKind.GROUP, 0, 1), {1})):
        after = dragged(TRIPLET, handle, 0.25, 9.0)
        assert changed(TRIPLET, after) == {(gap, "thickness") for gap in gaps}
        shift = 0.0 if handle.first else -0.25          # the frame begins at the first vertex
        for i, (a, b) in enumerate(zip(TRIPLET.lens.vertices, after.lens.vertices, strict=True)):
            assert b - a == pytest.approx(0.25 + shift if handle.first <= i <= handle.last else shift, abs=1e-13)


def test_a_gap_carries_what_lies_behind_and_a_rim_changes_alone():
    after = dragged(TRIPLET, at(HandleKind.GAP, 1), 0.5, 0.0)
    assert changed(TRIPLET, after) == {(1, "thickness")} and after.surfaces[1].thickness == 6.50755
    for y, dy in ((8.0, 0.5), (-8.0, -0.5)):
        wider = dragged(TRIPLET, at(HandleKind.RIM, 0, y=y), 3.0, dy)
        assert changed(TRIPLET, wider) == {(0, "semi_diameter")}
        assert wider.surfaces[0].semi_diameter == pytest.approx(TRIPLET.surfaces[0].semi_diameter + 0.5)
    assert dragged(TRIPLET, at(HandleKind.RIM, 0, y=8.0), 0.0, -99.0).surfaces[0].semi_diameter > 0.0


@pytest.mark.parametrize("conic, r4", [(0.0, 0.0), (-2.0, 0.0), (0.8, 0.0), (-0.5, 3e-6)])
def test_a_curvature_follows_until_the_surface_passes_through_the_mouse(conic, r4):
    document = with_value(with_value(TRIPLET, 0, "conic", conic), 0, "r4", r4)
    for dz in (-3.5, -0.2, 0.3):
        after = dragged(document, at(HandleKind.CURVE, 0, height=6.0), dz, 0.0)
        assert changed(document, after) == {(0, "curvature")}
        assert float(after.surfaces[0].sag(0.0, 6.0)) == pytest.approx(
            float(document.surfaces[0].sag(0.0, 6.0)) + dz, abs=1e-12)


@pytest.mark.parametrize("document, front", [(TRIPLET, 0), (TRIPLET, 2), (GAUSS, 0), (GAUSS, 2)])
def test_bending_keeps_the_power_of_the_element(document, front):
    def power(doc):
        """1 / focal length of the element alone between its own media, by a ray of the core."""
        before = doc.surfaces[front - 1].glass if front else lb.AIR
        alone = lb.Lens((replace(doc.surfaces[front]), replace(doc.surfaces[front + 1])), 0, front_index=before.n_d)
        return 1.0 / lb.first_order(alone).efl

    for dz in (-0.4, 0.3):
        after = dragged(document, at(HandleKind.BEND, front, front + 1), dz, 0.0)
        assert changed(document, after) == {(front, "curvature"), (front + 1, "curvature")}
        assert power(after) == pytest.approx(power(document), rel=1e-12)
        assert after.surfaces[front].curvature - document.surfaces[front].curvature == pytest.approx(
            2.0 * dz / document.surfaces[front].semi_diameter**2)


def test_handles_are_found_where_they_are_drawn():
    lens = TRIPLET.lens
    assert handle_at(lens, lens.vertices[2] + 0.1, 0.05, 0.3).kind is HandleKind.VERTEX
    rim = surface_curves(lens)[4][-1]
    assert handle_at(lens, *rim, 0.3) == Handle(HandleKind.RIM, 4, 4, *map(float, rim))
    curve = handle_at(lens, lens.vertices[0] + float(lens.surfaces[0].sag(0.0, 5.0)), -5.0, 0.2)
    assert (curve.kind, curve.first, curve.height) == (HandleKind.CURVE, 0, 5.0)
    assert handle_at(lens, lens.vertices[1] + 3.0, 0.0, 0.2).kind is HandleKind.GAP
    inside = lens.vertices[0] + 1.5
    group = handle_at(lens, inside, 0.5, 0.1)
    assert (group.kind, group.first, group.last) == (HandleKind.GROUP, 0, 1)
    assert handle_at(lens, inside, 0.5, 0.1, (0, 3)).last == 3 and handle_at(lens, inside, 0.5, 0.1, (2, 3)).last == 1
    assert handle_at(lens, inside, 0.5, 0.1, bend=True).kind is HandleKind.BEND
    assert handle_at(lens, -20.0, 3.0, 0.5) is None
    for kind in HandleKind:
        assert all(label(TRIPLET, at(kind, 0, 1)))


@pytest.mark.parametrize("above", [False, True])
@pytest.mark.parametrize("body", [(0, 1), (4, 4), (2, 5)])
def test_a_body_is_decentred_and_tilted_under_the_mouse(body, above):
    def drawn(document):
        return quarter_turned(document.lens) if above else document.lens

    def tops(document):
        return np.array([curve[-1] for curve in surface_curves(drawn(document))])

    start = dragged(TRIPLET, Handle(HandleKind.TILT, *body, 0.0, 0.0, 10.0, not above), 0.3, 0.0)   # the other way
    start = dragged(start, Handle(HandleKind.DECENTRE, *body, 0.0, 0.0, 0.0, not above), 0.0, 0.2)
    decentre, tilt = pose_handles(drawn(start), body, 0.4, 99.0, above)
    assert min(decentre.y, tilt.y) > tops(start)[body[0]:body[1] + 1, 1].max()
    assert tilt.z - decentre.z == pytest.approx(1.2) and tilt.y == decentre.y
    assert pose_handles(drawn(start), body, 0.4, 3.0, above)[0].y == 3.0
    numbers = {(i, "pose") for i in range(body[0], body[1] + 1)}
    for handle, quantity in ((decentre, "decentre_y"), (tilt, "tilt_x")):
        quantity = {"decentre_y": "decentre_x", "tilt_x": "tilt_y"}[quantity] if above else quantity
        after = dragged(start, handle, 0.25, 0.125)
        assert changed(start, after) == numbers
        for i, _ in numbers:
            one, two = start.surfaces[i].pose, after.surfaces[i].pose
            assert {name for name in ("decentre_x", "decentre_y", "tilt_x", "tilt_y", "pivot")
                    if getattr(one, name) != getattr(two, name)} == {quantity}
        moved, chosen = tops(after) - tops(start), slice(body[0], body[1] + 1)
        others = np.delete(moved, range(body[0], body[1] + 1), 0)
        assert np.abs(others).max() == 0.0
        if handle is decentre:
            assert moved[chosen] == pytest.approx(np.tile([0.0, 0.125], (len(numbers), 1)), abs=0.002)
        else:                       # the point of the body beside the handle moves as the mouse, about the pivot
            arm = tops(start)[body[0], 1] - drawn(start).vertex(body[0])[1]
            assert moved[body[0], 0] == pytest.approx(0.25 * arm / tilt.height, rel=0.03) and moved[body[0], 0] > 0.0
            assert drawn(after).vertex(body[0]) == pytest.approx(drawn(start).vertex(body[0]), abs=1e-12)
        assert label(after, handle)[0].split()[0] in ("Decentre", "Tilt") and label(after, handle)[1][-1] in "m°"
    assert body_of(TRIPLET.lens, at(HandleKind.VERTEX, 4)) == (4, 4)
    assert body_of(start.lens, at(HandleKind.RIM, body[1])) == body
    with pytest.raises(EditError, match="tilt"):
        dragged(start, tilt, 2.0 * tilt.height, 0.0)


def test_from_above_a_cylinder_has_no_handle_of_its_curvature():
    lens = replace(TRIPLET.lens, surfaces=(replace(TRIPLET.surfaces[0], curvature_x=0.0), *TRIPLET.surfaces[1:]))
    z, y = lens.vertices[0] + float(lens.surfaces[0].sag(0.0, 5.0)), 5.0
    assert handle_at(lens, z, y, 0.2).kind is HandleKind.CURVE
    assert handle_at(quarter_turned(lens), 0.0, y, 0.2, above=True).kind is not HandleKind.CURVE
    assert handle_at(quarter_turned(lens), 0.0, y, 0.2).kind is HandleKind.CURVE


def test_a_number_that_follows_from_a_rule_holds_its_handle_and_nothing_moves_halfway():
    held = with_rule(TRIPLET, Solve(2, "edge", 2.0))
    with pytest.raises(EditError, match="thickness of surface 2 follows from a rule"):
        dragged(held, at(HandleKind.VERTEX, 2), 0.1, 0.0)
    assert np.isfinite(held.lens.length)
