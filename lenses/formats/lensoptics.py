"""Lens files of polynomial optics (.fx), as lensoptics and lentil keep their lenses: one surface a line.

    # comment, also // comment; #!scale 0.5 scales the lengths that follow
    # radius  thickness        medium  n_d      V_d    housing  options
    48.5      4.0              abbe    1.62041  60.3   10
    -120.25   1.5/2.5/3.5      air                     10
    10000     2.0              iris                    6
    -60.0     3.5              N-SF2   1.64769  33.8   9        #!aspheric=0,1e-5,-2e-8,0,0
    70.0      30.0             cx_air                  9

Lengths in mm. Thickness and medium lie behind the surface; the last thickness is the back focus. Three thicknesses with
strokes are those of a zoom: wide, middle, tele; the middle one is the mean where there are two. The medium is air, iris
(the aperture stop, a plane in the medium before it), or any other name followed by n_d and V_d. cx_ before it makes the
surface a cylinder, curved in the section x–z. The housing is the radius of the rim. #!aspheric has the conic and the
coefficients of r⁴, r⁶, r⁸ and r¹⁰.
"""

import re
from math import inf

from lensbench.core.optics.finding import Kind
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.prescription import Lens
from lensbench.lenses.file_error import RowError, located, not_understood
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.stations import Station
from lensbench.lenses.tables.text import check_lines, file_curvature, file_number

STOP, CYLINDER = "iris", "cx_"
LARGEST_PLANE = 1e4     # mm: a radius from here on is how these files write a plane


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    check_lines(text, path)
    design = Design(path, [Row(None, thickness=inf)])
    scale, gaps = 1.0, dict[int, list[float]]()
    for line, content in enumerate(text.split("\n"), start=1):
        with located(path, line, f"surface {len(design.rows) - 1}: "):
            if scaling := re.match(r"\s*#!scale\s+(\S+)", content):
                scale = file_number(scaling[1], "#!scale")
                continue
            if content.lstrip().startswith("#!"):
                raise RowError(not_understood(content.split()[0]))
            plain = re.sub(r"//.*|#(?!!).*", "", content).strip()
            if not plain or plain.startswith("#"):
                if not design.name and len(design.rows) == 1:
                    design.name = content.strip(" \t#/")[:200]
                continue
            row, thicknesses = _row(design, line, plain, scale)
        if len(set(thicknesses)) > 1:
            gaps[len(design.rows)] = thicknesses
        design.add(row)
    design.add(Row(None))
    if any(row.curvature_x is not None for row in design.rows):
        design.found(Kind.CONVENTION, "a medium that begins with cx_ makes a cylinder: curved in the section x–z")
    if scale != 1.0 and any(row.aspheric for row in design.rows):
        design.found(Kind.CONVENTION, "#!scale is assumed to scale the aspheric surfaces as a whole, with their "
                                      "coefficients")
    if gaps:
        names = ("wide", "middle", "tele")
        design.stations = [Station({row: values[k] for row, values in gaps.items()}, name=names[k]) for k in range(3)]
    return design.lens()


def _row(design: Design, line: int, content: str, scale: float) -> tuple[Row, list[float]]:
    """The surface of a line, and its thicknesses: wide, middle, tele. RowError: invalid."""
    content, _, options = content.partition("#!")
    words = re.sub(r"\s*/\s*", "/", content).split()
    if len(words) < 4:
        raise RowError("a surface needs its radius, thickness, medium and housing radius")
    thicknesses = [file_number(word.rstrip("."), "thickness") * scale for word in words[1].split("/")]
    if len(thicknesses) > 3:
        raise RowError(f"{len(thicknesses)} thicknesses: a zoom has three, wide, middle and tele")
    if len(thicknesses) == 2:
        thicknesses = [thicknesses[0], sum(thicknesses) / 2.0, thicknesses[1]]
    medium, values = words[2], words[3:]
    is_cylinder = medium.lower().startswith(CYLINDER)
    medium = medium[len(CYLINDER):] if is_cylinder else medium
    row = Row(line, thickness=thicknesses[0], is_stop=medium.lower() == STOP)
    if row.is_stop:
        row.glass = design.rows[-1].glass
    elif medium.lower() != "air":
        row.glass, values = _glass(medium, values)
    if not values:
        raise RowError("the housing radius is missing")
    row.semi_diameter = file_number(values[0], "housing radius") * scale
    if not row.semi_diameter > 0.0:
        raise RowError(f"the housing radius is {values[0][:20]}: it must be positive")
    if len(values) > 1:
        raise RowError(not_understood(values[1]))
    radius = file_number(words[0], "radius", infinite=True)
    if abs(radius) < LARGEST_PLANE and not row.is_stop:
        c = file_curvature(words[0]) / scale
        row.curvature, row.curvature_x = (0.0, c) if is_cylinder else (c, None)
    terms = re.fullmatch(r"aspheric\s*=\s*(.*)", options.strip())
    if terms:
        numbers = [file_number(word.strip(), "#!aspheric") for word in terms[1].split(",")]
        row.conic = numbers[0]
        row.aspheric = {4 + 2 * i: a * scale ** (-3 - 2 * i) for i, a in enumerate(numbers[1:]) if a}
        if len(numbers) > 5:
            raise RowError(f"#!aspheric has {len(numbers)} values: a conic and four coefficients are read")
    elif options:
        raise RowError(not_understood(f"#!{options.split('=')[0]}"))
    return row, thicknesses * 3 if len(thicknesses) == 1 else thicknesses


def _glass(medium: str, values: list[str]) -> tuple[Glass, list[str]]:
    """The glass, with its name unless that is only “abbe”, and the values that follow its numbers."""
    if len(values) < 3:
        raise RowError(f"the medium {medium[:20]} needs n_d, V_d and the housing radius")
    n_d, v_d = file_number(values[0], "n_d"), file_number(values[1], "V_d")
    if n_d == 1.0:
        return AIR, values[2:]
    return media.stated("" if medium.lower() == "abbe" else medium, n_d, v_d), values[2:]
