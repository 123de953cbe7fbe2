"""Attachments: their power and their shift of the focus in closed form, and what belongs to the lens stays with it."""

from dataclasses import replace
from math import inf

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses.editing.attachments import (
    CROWN, attached_behind, attached_in_front, close_up_lens, front_width, plate, surfaces_of
)
from lensbench.lenses.editing.cells import with_rule
from lensbench.lenses.editing.document import EditError, LensDocument, Solve
from lensbench.lenses.tables.paraxial import focal_length, image_distance

TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))


def test_a_filter_in_front_moves_nothing_and_a_plate_behind_moves_the_image_by_its_glass():
    filtered = attached_in_front(TRIPLET, plate(2.0, front_width(TRIPLET)), "filter")
    assert focal_length(filtered.surfaces) == pytest.approx(focal_length(TRIPLET.surfaces), rel=1e-14)
    assert image_distance(filtered.surfaces, inf) == pytest.approx(image_distance(TRIPLET.surfaces, inf), rel=1e-13)
    assert filtered.lens.stop_index == TRIPLET.lens.stop_index + 2 and filtered.comment(0) == "filter"
    covered = attached_behind(TRIPLET, plate(3.0, 12.0), "cover glass", 5.0)
    shift = 3.0 * (1.0 - 1.0 / CROWN.n_d)
    assert image_distance(covered.surfaces, inf) + 8.0 - shift == pytest.approx(image_distance(TRIPLET.surfaces, inf))


@pytest.mark.parametrize("name", ["canon-ef-28-105-f4", "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"])
def test_a_plate_behind_a_zoom_lens_keeps_its_gap_at_every_zoom(name):
    lens = lenses.load(name)
    last, shift = len(lens.surfaces) - 1, 2.0 * (1.0 - 1.0 / CROWN.n_d)
    document = attached_behind(LensDocument(lens.at(zoom=0.0)), plate(2.0, 20.0), "plate", 3.0)
    assert document.comment(last + 1) == "plate"
    for zoom in (0.0, 0.4, 1.0):
        moved, bare = document.lens.at(zoom=zoom), lens.at(zoom=zoom)
        assert [surface.thickness for surface in moved.surfaces[last:last + 2]] == [3.0, 2.0]
        # The film stands where it stood, but for the shift of the focus by the glass
        assert lb.film_distance(moved, inf) + 5.0 - shift == pytest.approx(lb.film_distance(bare, inf), rel=1e-12)
        if last in lens.positions.gaps:
            assert moved.surfaces[-1].thickness + 5.0 == pytest.approx(bare.surfaces[-1].thickness, rel=1e-12)


@pytest.mark.parametrize("dioptres", [1.0, 4.0, -2.0])
def test_a_close_up_lens_has_its_power_and_brings_its_focus_to_infinity(dioptres):
    made = close_up_lens(dioptres, front_width(TRIPLET))
    assert focal_length(made) == pytest.approx(1000.0 / dioptres, rel=1e-12)
    together = attached_in_front(TRIPLET, made, "close-up lens", 3.0)
    # An object in its front focus: the lens behind sees it at infinity
    front_focus = lb.first_order(lb.Lens(made, 0)).ffl
    distance = image_distance(together.surfaces, -front_focus)
    assert distance == pytest.approx(image_distance(TRIPLET.surfaces, inf), rel=1e-9)


def test_a_reversed_lens_images_as_light_runs_back():
    turned = surfaces_of(TRIPLET.lens, reverse=True)
    assert focal_length(turned) == pytest.approx(focal_length(TRIPLET.surfaces), rel=1e-12)
    pair = attached_in_front(TRIPLET, turned, "reversed lens", 1.0)
    # Two equal lenses face to face: an object in the back focus of the one is imaged into that of the other, 1 : 1
    back = image_distance(TRIPLET.surfaces, inf)
    assert image_distance(pair.surfaces, back) == pytest.approx(back, rel=1e-9)


def test_rules_follow_and_what_cannot_be_attached_is_refused():
    solved = with_rule(TRIPLET, Solve(5, "efl", 50.0))
    stronger = attached_in_front(solved, close_up_lens(2.0, 20.0), "close-up lens")
    assert stronger.solves == (Solve(7, "efl", 50.0),) and focal_length(stronger.surfaces) == pytest.approx(50.0)
    ended = with_rule(TRIPLET, Solve(5, "image"))
    with pytest.raises(EditError, match="follows from a rule"):
        attached_behind(ended, plate(1.0, 9.0), "plate")
    wet = LensDocument(replace(TRIPLET.lens, front_index=1.333))
    for attempt in (lambda: close_up_lens(0.0, 9.0), lambda: close_up_lens(20.0, 40.0), lambda: plate(0.0, 9.0),
                    lambda: attached_in_front(wet, plate(1.0, 9.0), ""), lambda: surfaces_of(wet.lens),
                    lambda: attached_in_front(TRIPLET, plate(1.0, 9.0), "", -1.0),
                    lambda: attached_behind(TRIPLET, plate(1.0, 9.0), "", -1.0),
                    lambda: attached_in_front(TRIPLET, TRIPLET.surfaces[:1], "")):
        with pytest.raises(EditError):
            attempt()
