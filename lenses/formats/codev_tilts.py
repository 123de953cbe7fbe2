"""Decentres and tilts of CODE V surfaces.

XDE, YDE and ZDE are lengths of the file; ADE and BDE turn about x and y, left-handed, and CDE about z, right-handed, in
degrees. The decentre comes first, then ADE, BDE and CDE, each about an axis that the ones before have turned.
"""

from dataclasses import dataclass, field
from math import radians

from lensbench.lenses.axes import Break, intrinsic
from lensbench.lenses.design import Design
from lensbench.lenses.file_error import LensFileError

KEYS = ("XDE", "YDE", "ZDE", "ADE", "BDE", "CDE")
KINDS = ("DAR", "REV")      # of this surface alone; undone behind it. Without: for all surfaces from here on


@dataclass
class Tilt:
    """The commands of a surface. line: of the first one."""

    line: int
    values: dict[str, float] = field(default_factory=dict)
    kind: str = ""


def place(design: Design, index: int, tilt: Tilt) -> None:
    """Give a row of the design its decentre and tilt; LensFileError for object and image."""
    x, y, z, a, b, c = (tilt.values.get(key, 0.0) for key in KEYS)
    if not any((x, y, z, a, b, c)):
        return
    if index in (0, len(design.rows) - 1):
        raise LensFileError(design.path, tilt.line, f"S{index}: a tilt or decentre of the object or of the image is "
                                                    "not traced")
    row, axes = design.rows[index], intrinsic(-radians(a), -radians(b), radians(c))
    if tilt.kind == "DAR":
        row.aside = Break((x, y, z), axes, line=tilt.line)
    elif tilt.kind == "REV":
        row.behind = Break((-x, -y, -z), axes.T, True, line=tilt.line)
    else:
        row.breaks.append(Break((x, y, z), axes, line=tilt.line))
