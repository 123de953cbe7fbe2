"""What `lenses.save` accepts opens again; solves and pickups, focus and fields of what is saved."""

import re
from dataclasses import replace
from math import hypot, inf

import pytest
from hypothesis import given, settings, strategies as st

from lensbench import Glass, Lens, Surface, first_order, lenses
from lensbench.core.optics.finding import Kind
from lensbench.core.optics.system import FieldKind, FieldPoint
from lensbench.lenses.editing import cells
from lensbench.lenses.editing.document import LensDocument, Pickup, Solve
from lensbench.lenses.editing.structure import kept_in_focus

TRIPLET = "lenshh-cooke-triplet-50"
SUFFIXES = tuple(lenses.WRITERS)
lengths = st.floats(-1e12, 1e12) | st.floats(-100.0, 100.0)
any_surface = st.builds(
    Surface, lengths, st.floats(1e-12, 1e12) | st.floats(0.1, 50.0), st.builds(Glass, st.floats(1.0, 20.0)),
    curvature=st.floats(-1e9, 1e9) | st.floats(-0.1, 0.1), conic=st.floats(-1e3, 1e3),
    aspheric=st.lists(st.tuples(st.integers(2, 20), st.floats(-1e3, 1e3)), max_size=3, unique_by=lambda term: term[0])
    .map(tuple))


@st.composite
def any_lens(draw):
    """Lenses of any numbers that a Lens takes, some with hundreds of surfaces, or with long texts."""
    table = draw(st.lists(any_surface, min_size=1, max_size=4)) * draw(st.sampled_from((1, 1, 1, 40, 400)))
    words = st.text(max_size=20) | st.sampled_from(("x" * 40_000, "ü" * 1_200_000))
    return Lens(tuple(table), draw(st.integers(0, len(table) - 1)), draw(words), notes=draw(words))


@given(any_lens(), st.sampled_from(SUFFIXES))
@settings(max_examples=150, deadline=None)
def test_what_is_saved_opens_again(tmp_path_factory, lens, suffix):
    path = tmp_path_factory.getbasetemp() / f"odd{suffix}"
    path.unlink(missing_ok=True)
    try:
        lenses.save(lens, path)
    except lenses.LensFileError as error:
        assert "would not open again" in str(error) and not path.exists()
        return
    again = lenses.load(path)
    assert suffix != ".toml" or again == lens


@pytest.mark.parametrize(("lens", "suffix", "reason"), [
    (Lens((Surface(1.0, 5.0, Glass(1.5), curvature=0.01),) * 1000 + (Surface(1.0, 4.0, curvature=0.0),), 1000), ".zmx",
     "surfaces"),
    (Lens((Surface(2e9, 5.0, curvature=0.01),), 0), ".toml", "2×10⁹ mm"),
    (Lens((Surface(1.0, 5.0, curvature=0.01),), 0, notes="x" * 1_100_000), ".toml", "1.1 MB")])
def test_a_lens_that_no_reader_takes_is_refused_with_the_reason(tmp_path, lens, suffix, reason):
    path = tmp_path / f"refused{suffix}"
    path.write_text("the file before")
    with pytest.raises(lenses.LensFileError, match="is not written.*would not open again") as caught:
        lenses.save(lens, path)
    assert reason in str(caught.value) and path.read_text() == "the file before"


def document():
    made = cells.with_rule(LensDocument(lenses.load(TRIPLET), ("front", *[""] * 5)), Solve(5, "efl", 50.0))
    return cells.with_rule(made, Pickup(4, "semi_diameter", 2))


def test_a_document_is_saved_with_its_rules_and_what_loses_them_says_so(tmp_path):
    made = document()
    assert lenses.save(made, tmp_path / "mine.toml") == ()
    assert lenses.load_document(tmp_path / "mine.toml") == made
    lost = lenses.save(made, tmp_path / "mine.zmx")
    assert any("left out: comments, solves, pickups" in str(remark) for remark in lost)
    plain = lenses.load(tmp_path / "mine.toml")
    assert plain == made.lens
    assert [(f.kind, f.surface) for f in plain.findings] == [(Kind.RULE, 5), (Kind.RULE, 4)]
    assert "solves and pickups" in str(lenses.save(plain, tmp_path / "plain.toml")[0])


def test_the_lens_of_an_unnamed_design_has_no_empty_title(tmp_path):
    """A reader that takes the last character of the text in quotes crashed."""
    for name in ("", " ", "'", "Two 'quotes'", "Zoom"):
        lenses.save(replace(lenses.load(TRIPLET), name=name), tmp_path / "a.seq")
        titles = re.findall(r"^TITLE (.*)$", (tmp_path / "a.seq").read_text(), re.MULTILINE)
        assert all(re.fullmatch(r"'[^']*[^' ][^']*'", title) for title in titles) and len(titles) <= 1
        assert lenses.load(tmp_path / "a.seq").name == name.replace("'", " ").replace("  ", " ").strip()


@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".len", ".roa", ".json"])
def test_a_lens_without_fields_is_written_with_those_of_its_film(tmp_path, suffix):
    if suffix not in SUFFIXES:
        pytest.skip("not a format that is written")
    own = replace(lenses.load(TRIPLET), film_size=(36.0, 24.0))
    own = replace(own, system=replace(own.system, fields=()))
    remarks = lenses.save(own, tmp_path / f"own{suffix}")
    assert any(remark.kind is Kind.ASSUMED and "21.63 mm" in str(remark) for remark in remarks)
    system = lenses.load(tmp_path / f"own{suffix}").system
    assert system.field_kind is FieldKind.IMAGE_HEIGHT
    heights = [0.0, 0.35 * hypot(36, 24), 0.5 * hypot(36, 24)]
    assert [point.y for point in system.fields] == pytest.approx(heights[-1:] if suffix == ".len" else heights)
    stated = replace(own, system=replace(own.system, field_kind=FieldKind.ANGLE, fields=(FieldPoint(0.0, 11.0),)))
    assert not any(remark.kind is Kind.ASSUMED for remark in lenses.save(stated, tmp_path / f"stated{suffix}"))
    assert [point.y for point in lenses.load(tmp_path / f"stated{suffix}").system.fields] == [11.0]


def test_an_edited_lens_is_written_in_focus():
    before = lenses.load(TRIPLET)
    bfl = first_order(before).bfl
    before = replace(before, surfaces=(*before.surfaces[:-1], replace(before.surfaces[-1], thickness=bfl - 0.05)))
    edited = cells.with_value(LensDocument(before), 0, "curvature", 1.02 * before.surfaces[0].curvature)
    kept, said = kept_in_focus(before, edited)
    assert abs(first_order(edited.lens).bfl - bfl) > 0.3 and said[0].kind is Kind.BACK_FOCUS
    assert kept.surfaces[-1].thickness == pytest.approx(first_order(edited.lens).bfl - 0.05, abs=1e-9)
    fixed = cells.with_value(edited, len(before.surfaces) - 1, "thickness", 40.0)        # a gap of the user's choice
    assert kept_in_focus(before, fixed) == (fixed, ()) and kept_in_focus(before, LensDocument(before))[1] == ()
    afocal = replace(before, surfaces=tuple(replace(s, curvature=0.0) for s in before.surfaces))
    assert kept_in_focus(before, LensDocument(afocal))[1] == () and inf > bfl
