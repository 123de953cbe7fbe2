"""The edited lens in the settings: its text, its size, its zoom, and what the cells say."""

from dataclasses import replace

import pytest

from lensbench import lenses
from lensbench.app.bench.build import design, published
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.session import lens_cells
from lensbench.app.session.edited_lens import document_of, edited, original, reverted, save_document, with_document
from lensbench.app.session.states import History, load_settings, save_settings
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.prescription import CURVATURE
from lensbench.lenses.editing.cells import with_comment, with_rule, with_value
from lensbench.lenses.editing.document import EditError, Pickup, Solve
from tests.lenses.samples import DATA

TRIPLET = replace(Settings(), lens="lenshh-cooke-triplet-50", f_number=None)


def thicker(settings, value=6.5):
    return edited(settings, lambda d: with_value(d, 1, "thickness", value))[0]


def test_an_edit_changes_the_lens_of_everything_and_back_again_is_no_edit():
    there = thicker(TRIPLET)
    assert there.edited and design(there).surfaces[1].thickness == 6.5 == published(there).surfaces[1].thickness
    assert thicker(there, original(TRIPLET).surfaces[1].thickness) == TRIPLET == reverted(there)
    assert edited(TRIPLET, lambda d: d) == (TRIPLET, ())
    assert there.optics != TRIPLET.optics and there.picture != TRIPLET.picture
    assert with_lens(there, "pbrt-dgauss-50mm").edited == ""


def test_a_settings_file_and_a_picture_carry_the_edited_lens(tmp_path):
    there = thicker(TRIPLET)
    save_settings(tmp_path / "a.toml", there)
    assert load_settings(tmp_path / "a.toml") == there == Settings.from_dict(there.to_dict())


def test_a_scaled_lens_is_edited_at_its_size_and_a_zoom_at_its_position():
    scaled = replace(TRIPLET, focal_length=100.0)
    wider = thicker(scaled, 13.0)
    assert wider.focal_length is None and design(wider).surfaces[1].thickness == 13.0
    assert design(wider).surfaces[0].curvature == design(scaled).surfaces[0].curvature
    zoom = replace(Settings(), lens=next(card.name for card in lenses.describe() if card.zooms), zoom=1.0)
    gap = design(zoom).positions.gaps[0]
    tele = edited(zoom, lambda d: with_value(d, gap, "thickness", 0.9 * d.surfaces[gap].thickness))[0]
    assert tele.zoom == 1.0 and design(tele).surfaces[gap].thickness == 0.9 * design(zoom).surfaces[gap].thickness
    assert design(replace(tele, zoom=0.0)).surfaces == design(replace(zoom, zoom=0.0)).surfaces


def test_rules_are_kept_by_the_settings_and_findings_with_them():
    solved = edited(TRIPLET, lambda d: with_rule(d, Solve(5, "efl", 50.0)))[0]
    assert document_of(solved).solves == (Solve(5, "efl", 50.0),)
    again = with_document(solved, document_of(solved))
    assert again == solved                                  # settling a settled lens changes no bit


@pytest.mark.parametrize("zoom", [0.0, 0.5, 1.0])
def test_the_table_and_the_picture_of_a_zoom_lens_with_a_solve_agree(zoom):
    """The table was solved for the wide end, the picture for the zoom that was set: two radii of one surface."""
    settings = replace(Settings(), lens="canon-ef-28-105-f4", f_number=None, zoom=zoom)
    for rule in (Solve(10, "efl", 30.0), Pickup(15, "thickness", 13, 2.0)):
        solved = edited(settings, lambda d, rule=rule: with_rule(d, rule))[0]
        assert design(solved).surfaces == document_of(solved).surfaces != design(settings).surfaces


def test_a_saved_document_is_the_lens_and_a_format_that_loses_something_is_not(tmp_path):
    there = edited(thicker(TRIPLET), lambda d: with_comment(d, 0, "front"))[0]
    there = edited(there, lambda d: with_value(d, 5, "thickness", 41.0))[0]
    saved, lost = save_document(there, tmp_path / "mine.toml")
    assert saved.edited == "" and lost == () and document_of(saved) == document_of(there)
    kept, lost = save_document(there, tmp_path / "mine.zmx")
    assert kept is there and "comments" in str(lost[-1])


def test_edits_outlive_the_file_of_their_lens(tmp_path):
    lenses.save(lenses.load(TRIPLET.lens), tmp_path / "here.toml")
    there = thicker(replace(TRIPLET, lens=str(tmp_path / "here.toml")))
    gone = thicker(replace(there, lens=str(tmp_path / "gone.toml")), 7.0)
    assert document_of(gone).surfaces[1].thickness == 7.0


def test_an_edited_lens_keeps_what_its_reader_assumed_and_its_saving_says_so(tmp_path):
    phone = replace(Settings(), lens=str(DATA / "phone.json"))
    there = thicker(phone, 0.9 * original(phone).surfaces[1].thickness)
    assert published(phone).findings and published(there).findings == published(phone).findings
    _, remarks = save_document(there, tmp_path / "mine.toml")
    assert "coc is read as" in str(remarks[-1]) and "phone.json" in str(remarks[-1])


def test_a_lens_without_edits_is_saved_with_its_solves(tmp_path):
    lenses.save(document_of(edited(TRIPLET, lambda d: with_rule(d, Solve(5, "efl", 50.0)))[0]), tmp_path / "mine.toml")
    unedited = replace(TRIPLET, lens=str(tmp_path / "mine.toml"))
    assert save_document(unedited, tmp_path / "copy.toml") == (unedited, ())
    assert lenses.load_document(tmp_path / "copy.toml") == lenses.load_document(tmp_path / "mine.toml")
    twice = replace(unedited, focal_length=100.0)
    assert save_document(twice, tmp_path / "twice.toml") == (twice, ())
    assert lenses.load_document(tmp_path / "twice.toml").solves[0].target == pytest.approx(100.0, rel=1e-3)


@pytest.mark.parametrize("text, radius", [("22,5", 22.5), ("-1e3", -1000.0), ("−7.5 mm", -7.5), ("inf", 0.0),
                                          ("0", 0.0), ("plane", 0.0), ("∞", 0.0)])
def test_radii_are_read_as_people_type_them(text, radius):
    assert lens_cells.typed(text, CURVATURE) == (1.0 / radius if radius else 0.0)


def test_a_cell_shows_what_it_reads_and_says_what_to_type():
    document = original(TRIPLET)
    for surface in document.surfaces:
        for quantity in ("curvature", "thickness", "semi_diameter", "conic"):
            assert lens_cells.typed(lens_cells.whole(surface, quantity), quantity) == getattr(surface, quantity)
    for text, quantity in (("abc", "curvature"), ("1.5.2", "thickness"), ("1e-9", "curvature")):
        with pytest.raises(EditError, match="type a"):
            lens_cells.typed(text, quantity)
    assert lens_cells.scrubbed(document.surfaces[0], "semi_diameter", 8.0, -1e6) > 0.0


def test_a_parted_history_keeps_two_quick_edits_apart():
    history = History(TRIPLET)
    history.edit(thicker(TRIPLET), False, 1.0)
    history.part()
    history.edit(thicker(TRIPLET, 7.0), False, 1.1)
    assert history.undo() == thicker(TRIPLET) and history.undo() == TRIPLET and history.undo() == TRIPLET
