"""Tilts and decentres as numbers of an edited lens: bodies move as one, rows keep pivots, the way back is exact."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses.editing import elements, structure
from lensbench.lenses.editing.document import EditError, LensDocument, from_text, to_text
from lensbench.lenses.editing.elements import body_at, with_pose

START = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
BENT = with_pose(with_pose(START, 2, 3, "decentre_y", 0.5), 2, 3, "tilt_x", 0.02)


def test_an_element_moves_as_one_body_and_back_to_the_same_bits():
    pose = lb.SurfacePose(decentre_y=0.5, tilt_x=0.02)
    assert [s.pose for s in BENT.surfaces] == [None, None, pose, replace(pose, pivot=1), None, None]
    assert body_at(BENT.lens, 3) == (2, 3) and body_at(START.lens, 3) == (2, 3) and body_at(BENT.lens, 5) == (4, 5)
    assert with_pose(with_pose(BENT, 2, 3, "decentre_y", 0.0), 2, 3, "tilt_x", 0.0).lens == START.lens
    assert from_text(to_text(BENT)).lens.surfaces == BENT.surfaces


@pytest.mark.parametrize(("edit", "body"), [
    (lambda d: structure.inserted_plane(d, 0), (3, 4)), (lambda d: structure.deleted(d, [0]), (1, 2)),
    (lambda d: structure.split(d, 2), (2, 4)), (lambda d: structure.moved(d, 2, 3, 6), (4, 5)),
    (lambda d: elements.flipped(d, 2, 3), (2, 3))])
def test_edits_of_rows_keep_a_body_together(edit, body):
    after = edit(BENT)
    assert body_at(after.lens, body[0]) == body == body_at(after.lens, body[1])
    assert [i for i, s in enumerate(after.surfaces) if s.pose] == list(range(body[0], body[1] + 1))


def test_an_element_of_a_tilted_group_is_turned_round_with_the_group_alone():
    with pytest.raises(EditError, match="surface 4 is tilted about the vertex of surface 2: turn both"):
        elements.flipped(with_pose(START, 2, 5, "tilt_x", 0.02), 4, 5)
    turned = elements.flipped(with_pose(START, 2, 5, "decentre_y", 0.5), 4, 5).lens       # no tilt: any pivot will do
    assert [turned.vertex(i)[1] for i in range(6)] == [0.0, 0.0, 0.5, 0.5, 0.5, 0.5]


def test_a_deleted_pivot_is_said():
    after = structure.deleted(BENT, [2])
    assert after.surfaces[2].pose.pivot == 0
    assert any("pivots about its own vertex" in f.message for f in after.findings)


@pytest.mark.parametrize(("arguments", "said"), [
    ((2, 3, "tilt_x", 1.6), "tilt about x: tilt_x 91.67° of a surface|must lie from −60°"),
    ((2, 3, "decentre_x", float("nan")), "must lie from −10 m"), ((2, 9, "tilt_x", 0.0), "surfaces 2 to 9"),
    ((2, 3, "radius", 1.0), "choose one of decentre_x")])
def test_what_cannot_be_is_refused(arguments, said):
    with pytest.raises(EditError, match=said):
        with_pose(START, *arguments)
