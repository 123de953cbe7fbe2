"""Every format to every other, on the whole library: the same lens to the last digit, or a finding for each loss."""

import re
from dataclasses import dataclass, replace
from enum import Enum
from itertools import product

import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import Glass, Lens, Surface, lenses
from lensbench.core.optics.lens_surface import Shape, SurfacePose
from lensbench.lenses import FORMATS, READERS, WRITERS, Kind, Severity
from lensbench.lenses.editing.elements import body_at
from lensbench.lenses.file_error import RowError
from lensbench.lenses.glass import catalogue, media
from lensbench.lenses.glass.media import code
from lensbench.lenses.tables.text import is_number
from tests.lenses.samples import plain_words
from tests.library import CLASSICS

WORDS = ("name", "kind", "year", "source", "notes", "stated_efl", "stated_f_number")
EXACT = [row.suffix for row in FORMATS if row.write and Shape.CONIC in row.shapes]
SHAPES = {Shape.SPHERE: {}, Shape.CONIC: {"conic": -0.5}, Shape.EVEN_ASPHERE: {"aspheric": ((4, 1e-6),)},
          Shape.ASPHERE: {"aspheric": ((3, 1e-5),)}, Shape.CYLINDER: {"curvature_x": 0.0},
          Shape.TOROID: {"curvature_x": 0.03}}                  # the fields of a surface of each shape


def through(lens, suffix):
    """The lens after a file of this format, and what the writer said."""
    text, remarks = WRITERS[suffix](lens)
    return READERS[suffix](text, f"lens{suffix}"), remarks


def geometry(lens):
    """Surfaces with the index at the d line instead of the glass."""
    return [replace(s, glass=Glass(s.glass.n_d)) for s in lens.surfaces], lens.stop_index


LABELS = {"stated_efl": "focal length", "stated_f_number": "f-number"}


def unnamed_losses(lens, other, remarks):
    """Differences between two lenses without a finding of that kind about that surface."""
    about = set()
    for remark in remarks:
        listed = re.match(r"surfaces ([0-9, ]+):", remark.message)      # one finding about several of them
        numbers = [int(number) for number in listed[1].split(",")] if listed else [remark.surface]
        about |= {(remark.kind, number) for number in numbers}
    whole = {kind for kind, _ in about}
    lost = []
    left = list(other.surfaces)
    if len(left) == len(lens.surfaces) + 1 and Kind.STOP in whole:     # pbrt's stop, a plane of its own
        del left[other.stop_index]
    elif other.stop_index != lens.stop_index and Kind.STOP not in whole:
        lost.append("stop")
    if len(left) != len(lens.surfaces):
        lost.append("surfaces")
    for i, (a, b) in enumerate(zip(lens.surfaces, left, strict=False)):
        if a.glass != b.glass and not {(Kind.GLASS, i), (Kind.GLASS, None)} & about:
            lost.append(f"glass of surface {i}")
        moved = len(left) < len(other.surfaces)
        same = abs(a.curvature - b.curvature) <= 2.0**-52 * abs(a.curvature)      # pbrt's radii are read as floats
        if (not same or replace(b, glass=a.glass, thickness=a.thickness if moved else b.thickness,
                                curvature=a.curvature) != a) and (Kind.SHAPE, i) not in about:
            lost.append(f"shape of surface {i}")
    if abs(other.length - lens.length) > 1e-9 * lens.length and Kind.STOP not in whole:
        lost.append("length")
    if other.positions != lens.positions and Kind.POSITION not in whole:
        lost.append("positions")
    texts = " ".join(str(remark) for remark in remarks if remark.kind in (Kind.LEFT_OUT, Kind.TEXT))
    return lost + [word for word in WORDS if getattr(other, word) != getattr(lens, word)
                   and LABELS.get(word, word) not in texts]


@pytest.mark.slow
@pytest.mark.parametrize("first", WRITERS)
def test_every_loss_from_any_format_to_any_other_has_its_finding(first):
    for name in CLASSICS:
        lens, _ = through(lenses.load(name), first)
        for second in WRITERS:
            read, remarks = through(lens, second)
            assert not unnamed_losses(lens, read, remarks), (name, first, second, remarks)
            if second in EXACT and not any(remark.kind is Kind.SHAPE for remark in remarks):
                assert geometry(read) == geometry(lens), (name, first, second, remarks)


@pytest.mark.slow
@pytest.mark.parametrize(("first", "second"), list(product(EXACT, EXACT)))
def test_a_lens_that_goes_through_two_formats_and_back_is_the_same_lens(first, second):
    for name in ("lenshh-cooke-triplet-50", "lib-us10281683", "lv-nikon-z-58f095-noct"):
        lens, _ = through(lenses.load(name), first)
        read, remarks = through(through(lens, second)[0], first)
        assert geometry(read) == geometry(lens), (name, remarks)


@pytest.mark.parametrize("suffix", [suffix for suffix in WRITERS if suffix != ".toml"])
def test_provenance_that_only_toml_holds_is_reported_as_left_out(suffix):
    lens = replace(lenses.load("lenshh-cooke-triplet-50"), maker="M", designer="D", patent="P", film_size=(36.0, 24.0),
                   estimates="all rims")
    told = " ".join(map(str, WRITERS[suffix](lens)[1]))
    assert all(word in told for word in ("maker", "designer", "patent", "film size", "what is estimated"))


@pytest.mark.parametrize("suffix", [".toml", ".seq", ".json", ".roa"])
@pytest.mark.parametrize("maker", catalogue.MAKERS)
def test_catalogue_glasses_of_every_maker_and_formula_come_back(suffix, maker):
    same = [entry for entry in catalogue.entries() if entry.maker == maker and entry.n_d and entry.v_d]
    for entry in same[::29]:
        lens = replace(lenses.load("lenshh-cooke-triplet-50"), name="", notes="", source="", kind="")
        glass = entry.make()
        lens = replace(lens, surfaces=(replace(lens.surfaces[0], glass=glass), *lens.surfaces[1:]))
        read, remarks = through(lens, suffix)
        # A name that one maker gives to two glasses is not unique, and a writer says so
        assert read.surfaces[0].glass == glass or any(
            remark.kind is Kind.GLASS and remark.surface == 0 for remark in remarks), entry


indices = st.lists(st.integers(1_450_000, 1_900_000), min_size=4, max_size=6).map(lambda ns: sorted(ns, reverse=True))


@pytest.mark.slow
@given(st.lists(st.integers(3400, 9000), min_size=6, max_size=6, unique=True), indices, plain_words)
@settings(max_examples=60)
@pytest.mark.parametrize("suffix", WRITERS)
def test_a_glass_given_by_a_table_comes_back_or_its_loss_is_reported(suffix, wavelengths, ns, name):
    points = [(wavelength / 1e4, n / 1e6) for wavelength, n in zip(sorted(wavelengths), ns, strict=False)]
    try:
        glass = media.tabulated(name, points)
    except RowError:                                    # the cubic through steps of a glass can fall below 1
        return
    lens = Lens((Surface(5.0, 10.0, glass, curvature=0.02), Surface(90.0, 9.0, curvature=0.0)), 1)
    read, remarks = through(lens, suffix)
    kept = read.surfaces == lens.surfaces
    assert kept or any(remark.kind is Kind.GLASS and remark.surface in (0, None) for remark in remarks)
    if suffix in (".toml", ".roa") or (suffix == ".seq" and len(name) > 1 and not is_number(name) and not code(name)):
        assert kept, remarks


@pytest.mark.parametrize("shape", Shape)
@pytest.mark.parametrize("row", [row for row in FORMATS if row.write], ids=lambda row: row.name)
def test_a_format_holds_the_shapes_of_its_row_and_reports_the_others(row, shape):
    surface = Surface(5.0, 10.0, Glass(1.5), curvature=0.02, **SHAPES[shape])
    assert surface.form is shape
    read, remarks = through(Lens((surface, Surface(90.0, 9.0, curvature=0.0)), 1), row.suffix)
    kept = replace(read.surfaces[0], glass=surface.glass, curvature=surface.curvature) == surface
    told = any(remark.kind is Kind.SHAPE and remark.severity is Severity.WARNING and remark.surface == 0
               for remark in remarks)
    assert told == (shape not in row.shapes) and (kept or told)


@pytest.mark.parametrize("suffix", [suffix for suffix in WRITERS if suffix != ".toml"])
def test_a_toroid_is_kept_or_reported_as_another_lens(suffix):
    rod = Surface(5.0, 10.0, Glass(1.5, 60.0), curvature=0.02, curvature_x=0.0)
    toroid = Surface(5.0, 10.0, Glass(1.5, 60.0), curvature=0.02, curvature_x=0.03)
    for surface in (rod, toroid):
        lens = replace(lenses.load("pbrt-dgauss-50mm"), surfaces=(surface, Surface(90.0, 9.0, curvature=0.0)),
                       stop_index=1)
        read, remarks = through(lens, suffix)
        told = any(remark.kind is Kind.SHAPE and remark.severity is Severity.WARNING and remark.surface == 0
                   for remark in remarks)
        assert read.surfaces == lens.surfaces or told
        exact = suffix not in (".dat", ".txt") and (surface is rod or suffix in (".zmx", ".seq"))
        assert told != exact
        if suffix in (".json", ".roa", ".len") and surface is toroid:
            assert any(finding.kind is Kind.SHAPE and finding.surface == 0 for finding in read.findings)


def test_a_pose_is_kept_to_the_last_bit_or_its_loss_is_named():
    bent = [SurfacePose(0.3, -0.5, 0.05, 0.021), SurfacePose(0.3, -0.5, 0.05, 0.021, pivot=1)]
    lens = lenses.load("lenshh-cooke-triplet-50")
    lens = replace(lens, surfaces=(*lens.surfaces[:2], *(replace(s, pose=pose) for s, pose in zip(
        lens.surfaces[2:4], bent, strict=True)), *lens.surfaces[4:]))
    for row in FORMATS:
        if row.write is None:
            continue
        read, remarks = through(lens, row.suffix)
        named = [remark.surface for remark in remarks if "decentred or tilted" in remark.message]
        if row.suffix == ".toml":
            assert [s.pose for s in read.surfaces] == [s.pose for s in lens.surfaces]
        if row.has_poses:                               # the same rays
            expected, kept = (lb.trace(variant, [[0.5, 0.3, -5.0], [-1.0, 2.0, -5.0]], [0.02, -0.03, 1.0], clip=False)
                              for variant in (lens, read))
            assert kept.points == pytest.approx(expected.points, abs=1e-9)
            assert kept.directions == pytest.approx(expected.directions, abs=1e-11)
            assert read.length == pytest.approx(lens.length, abs=1e-9)
            assert body_at(read, 3) == (2, 3)
        if not row.has_poses:
            assert read.is_centred and named == [2, 3], row.suffix
        else:
            assert not read.is_centred and not named, row.suffix


@dataclass(frozen=True)
class NumberedLens(Lens):
    """A lens with a field that no format knows."""

    serial_number: str = ""


@dataclass(frozen=True, init=False)
class PaintedSurface(Surface):
    """A surface with a field that no format knows."""

    edge_paint: str = ""

    def __init__(self, *values, edge_paint="", **named):
        super().__init__(*values, **named)
        object.__setattr__(self, "edge_paint", edge_paint)


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_new_field_of_a_lens_or_surface_is_reported_until_a_format_lists_it(tmp_path, suffix):
    surfaces = (PaintedSurface(5.0, 10.0, Glass(1.5, 60.0), curvature=0.02, edge_paint="black"),
                Surface(90.0, 9.0, curvature=0.0))
    remarks = " ".join(map(str, lenses.save(NumberedLens(surfaces, 1, serial_number="7"), tmp_path / f"a{suffix}")))
    assert "serial number" in remarks and "the edge paint of 1 of 2 surfaces" in remarks
    plain = " ".join(map(str, lenses.save(NumberedLens(surfaces[1:], 0), tmp_path / f"a{suffix}")))
    assert "serial number" not in plain and "edge paint" not in plain


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_new_kind_of_surface_is_reported_until_a_format_lists_it(tmp_path, suffix, monkeypatch):
    monkeypatch.setattr(Surface, "form", Enum("Grown", {"SPLINE": "a spline"}).SPLINE)
    lens = Lens((Surface(5.0, 10.0, Glass(1.5, 60.0), curvature=0.02), Surface(90.0, 9.0, curvature=0.0)), 1)
    remarks = [remark for remark in lenses.save(lens, tmp_path / f"a{suffix}") if "is a spline" in str(remark)]
    assert [remark.surface for remark in remarks] == [0, 1]
    assert all(remark.severity is Severity.WARNING for remark in remarks)
