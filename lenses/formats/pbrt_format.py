"""pbrt's lens files (.dat): rows of radius, gap, index and *diameter*, from the scene to the film.

    # radius  thickness  index  diameter
    29.475    3.76       1.67   25.2
    …
    0         4.5        1      17.1

Lengths in mm, unless a comment says metres or centimetres. Radius 0 is a plane:
with air on both sides the aperture stop. pbrt gives the gap *after* each
surface; older files, with a column "axpos", give the gap *before* it. Some files
have the old header and the new gaps: the reader takes the reading that gives a lens
with fewer faults.
"""

import re
from dataclasses import replace

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.file_error import LensFileError, RowError, located, number
from lensbench.lenses.tables.paraxial import count_faults, sag
from lensbench.lenses.tables.rows import radius_text, stop_of, surface

COLUMNS = "radius, thickness, index, diameter"
FLAT_RADIUS = "1e6"     # mm: a plane that refracts; radius 0 would be a stop to pbrt
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
UNITS = {"mm": "mm|millimet(re|er)s?", "cm": "cm|centimet(re|er)s?", "m": "m|met(re|er)s?"}


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    comments, rows, lines = _split(text, path)
    findings = []
    unit = _unit(comments)
    if unit != "mm":
        findings.append(note(Kind.UNIT, f"lengths are in {unit}, as a comment states, and were converted to mm",
                             unit=MM[unit]))
        for row in rows:
            row[0], row[1], row[3] = row[0] * MM[unit], row[1] * MM[unit], row[3] * MM[unit]

    # The gap after or before the surface: whichever makes a lens
    old_header = any("axpos" in comment.lower() for comment in comments)
    surfaces = _surfaces(rows, lines, path)
    if len(rows) > 1 and (old_header or rows[0][1] == 0.0):
        gaps = [row[1] for row in rows[1:]] + [0.0]
        shifted = _surfaces([[r, gap, n, d] for (r, _, n, d), gap in zip(rows, gaps, strict=True)], lines, path)
        new, old = count_faults(surfaces), count_faults(shifted)
        if old < new or (old == new and old_header and rows[0][1] == 0.0 != rows[-1][1]):
            surfaces = shifted
            findings.append(note(Kind.CONVENTION, "its gaps are those before their surfaces: the older convention of "
                                                  "pbrt"))
        elif old_header:
            findings.append(note(Kind.CONVENTION, "the header states axpos, the older convention, but only gaps after "
                                                  "their surfaces make a sound lens: they are read as such"))

    # A plane between air and air is the stop
    media = [1.0, *(s.glass.n_d for s in surfaces)]
    marked = [i for i, row in enumerate(rows) if row[0] == 0.0 and media[i] == media[i + 1] == 1.0]
    for i, row in enumerate(rows):
        if row[0] == 0.0 and i not in marked:
            findings.append(note(Kind.CONVENTION, f"surface {i} has radius 0 next to glass: read as a plane, where "
                                                  "pbrt would see a stop", i))
    stop_index, assumed = stop_of(surfaces, marked)
    texts = [comment for comment in comments if not re.search(r"radius|\baxpos\b", comment, re.IGNORECASE)]
    return Lens(surfaces, stop_index, name=texts[0] if texts else "", notes="; ".join(texts[1:]),
                findings=(*findings, *assumed))


def _split(text: str, path: str) -> tuple[list[str], list[list[float]], list[int]]:
    """Comments, rows of four numbers (mm), and the line of each row."""
    comments, rows, lines = list[str](), list[list[float]](), list[int]()
    for line, content in enumerate(text.split("\n"), start=1):
        values, _, comment = content.partition("#")
        if comment.strip(" \t\"#"):
            comments.append(" ".join(comment.strip(" \t\"#").split()))
        words = values.split()
        if not words:
            continue
        if len(words) != 4:
            count = f"{len(words)} value{'s' if len(words) > 1 else ''}"
            raise LensFileError(path, line, f"a row has four columns ({COLUMNS}), this one has {count}")
        with located(path, line, f"surface {len(rows)}: "):
            rows.append([number(word, name) for word, name in zip(words, COLUMNS.split(", "), strict=True)])
        lines.append(line)
    if not rows:
        raise LensFileError(path, None, f"there are no surfaces: a row has four columns ({COLUMNS})")
    return comments, rows, lines


def _plane_stop(lens: Lens) -> tuple[list[Surface], int | None, list[Finding]]:
    """Surfaces with the stop as a plane in air, the only stop of pbrt, and its index (None: not possible)."""
    surfaces, i, stop = list(lens.surfaces), lens.stop_index, lens.stop
    air_before = i == 0 or surfaces[i - 1].glass.n_d == 1.0
    air_after = stop.glass.n_d == 1.0
    if air_before and air_after and stop.curvature == 0.0:
        return surfaces, i, []
    depth = sag(stop.curvature, stop.semi_diameter)
    moved = [note(Kind.STOP, f"the stop is at surface {i}: written as a plane of its own, through its edge or "
                             "vertex", i)]
    if air_after:
        gap = max(depth, 0.0)
        surfaces[i] = replace(stop, thickness=gap)
        surfaces.insert(i + 1, Surface(stop.thickness - gap, stop.semi_diameter, curvature=0.0))
        return surfaces, i + 1, moved
    if air_before:
        gap = max(-depth, 0.0)
        if i > 0:
            surfaces[i - 1] = replace(surfaces[i - 1], thickness=surfaces[i - 1].thickness - gap)
        surfaces.insert(i, Surface(gap, stop.semi_diameter, curvature=0.0))
        return surfaces, i, moved
    return surfaces, None, [Finding(Kind.STOP, i, f"the stop is the cemented surface {i}, which pbrt cannot mark: the "
                                                  "smallest rim limits")]


def _unit(comments: list[str]) -> str:
    """Unit of length in the comments: "in metres", "units: m", "(cm)"; mm if one says mm, or none names a unit."""
    for unit, words in UNITS.items():
        named = re.compile(rf"\b(in|units?:?)\s+({words})\b|\(({words})\)", re.IGNORECASE)
        if any(named.search(comment) for comment in comments):
            return unit
    return "mm"


def _surfaces(rows: list[list[float]], lines: list[int], path: str) -> tuple[Surface, ...]:
    made = []
    for i, ((radius, gap, index, diameter), line) in enumerate(zip(rows, lines, strict=True)):
        if radius == 0.0 and index == 0.0:              # how older files write the air behind a stop
            index = 1.0
        with located(path, line, f"surface {i}: "):
            if diameter <= 0.0:
                raise RowError(f"diameter is {significant(diameter)}: it must be positive")
            made.append(surface(repr(radius), gap, index, diameter / 2.0))
    return tuple(made)


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .dat file, and findings about what it cannot hold, other than shapes."""
    remarks: list[Finding] = []
    comments = [lens.name, lens.kind, str(lens.year or ""), lens.source, lens.notes]
    lines = [f"# {' '.join(comment.split())}" for comment in comments if comment.strip()]
    lines.append("#" + "".join(f"{name:>21}" for name in COLUMNS.split(", ")) + "   (mm)")
    surfaces, stop_index, moved = _plane_stop(lens)
    remarks += moved
    added = len(surfaces) > len(lens.surfaces)
    for i, s in enumerate(surfaces):
        radius = radius_text(s.curvature)
        if i == stop_index:
            radius = "0"
        elif s.curvature == 0.0:
            radius = FLAT_RADIUS
            remarks.append(note(Kind.SHAPE, f"a plane, row {i}, is written with a radius of 1 km: a radius of 0 is "
                                            "pbrt's stop", i - (added and i > lens.stop_index)))
        cells = (radius, repr(s.thickness), repr(s.glass.n_d), repr(2.0 * s.semi_diameter))
        lines.append("  " + " ".join(f"{cell:>20}" for cell in cells))
    if any(s.glass.v_d is not None or s.glass.disperses for s in lens.surfaces):
        remarks.append(note(Kind.GLASS, "Abbe numbers are left out: pbrt's files have one index, at the d line"))
    if any(s.glass.name for s in lens.surfaces):
        remarks.append(note(Kind.GLASS, "names of glasses are left out"))
    if lens.name or lens.kind or lens.year or lens.source or lens.notes:
        remarks.append(note(Kind.TEXT, "name, kind, year, source and notes are written as comments"))
    return "\n".join([*lines, ""]), remarks
