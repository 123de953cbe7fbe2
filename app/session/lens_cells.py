"""Cells of the surface table: their texts, what a typed text means, and the step of a drag.

Lengths in mm. A cell is a quantity of a surface (`lenses.editing.document`); a radius sets its curvature.
"""

import re
from math import degrees, radians

from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Shape, Surface
from lensbench.core.optics.prescription import CONIC, CURVATURE, CURVATURE_X, POSE, SEMI_DIAMETER, THICKNESS, value_of
from lensbench.core.text import INFINITE, cut, significant, true_minus
from lensbench.lenses.editing.document import EditError, LensDocument, words
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.rows import curvature, radius_text
from lensbench.lenses.tables.text import plain_number

PLANES = ("", "inf", "infinity", "∞", "plane", "flat")
ANGLES = ("tilt_x", "tilt_y", "roll")           # radians, in degrees in their cells
TILT = 0.0005                                   # radians of a pixel's drag
BEND, GAP, RIM, CONE, SAG = 0.002, 0.002, 0.005, 0.01, 0.0005      # of a pixel's drag, in semi-diameters


def shown(surface: Surface, quantity: str) -> str:
    """The text of a cell, with six digits."""
    value = value_of(surface, quantity)
    if quantity in (CURVATURE, CURVATURE_X):
        return INFINITE if value == 0.0 else true_minus(significant(1.0 / value))
    if quantity == CONIC and value == 0.0:
        return ""
    return true_minus(significant(degrees(value) if quantity in ANGLES else value))


def whole(surface: Surface, quantity: str) -> str:
    """The text of a cell with all its digits, to be edited."""
    value = value_of(surface, quantity)
    if quantity in (CURVATURE, CURVATURE_X):
        text = radius_text(value)
    else:
        text = repr(round(degrees(value), 12) if quantity in ANGLES else value)
    return text.removesuffix(".0")


def typed(text: str, quantity: str) -> float:
    """The number of a quantity that a text means; a curvature for a radius. EditError says what to type."""
    word = text.strip().replace("−", "-").replace("\u00a0", "").lower()
    if quantity in (CURVATURE, CURVATURE_X):
        try:
            return curvature("inf" if word.lstrip("+-") in PLANES else plain_number(re.sub(r"\s*mm$", "", word)))
        except RowError:
            raise EditError(f"“{cut(text.strip())}”: type a radius such as 22.5, or inf for a plane") from None
    try:
        number = float(plain_number(re.sub(r"\s*(mm|°|deg)$", "", word)) or "0")
        return radians(number) if quantity in ANGLES else number
    except ValueError:
        raise EditError(f"“{cut(text.strip())}”: type a {words(quantity)} such as 1.5") from None


def step(surface: Surface, quantity: str) -> float:
    """By how much a drag of one pixel changes a quantity: about as much as one sees, for any size of lens."""
    size = surface.semi_diameter
    if quantity in (CURVATURE, CURVATURE_X):
        return BEND / size
    if quantity == THICKNESS:
        return GAP * size
    if quantity == SEMI_DIAMETER:
        return RIM * size
    if quantity == CONIC:
        return CONE
    if quantity in POSE:
        return TILT if quantity in ANGLES else GAP * size
    return SAG * size ** (1 - int(quantity[1:]))


def scrubbed(surface: Surface, quantity: str, value: float, pixels: float) -> float:
    """A quantity after a drag by so many pixels, from `value`.

    To the right a radius gets longer, so that its curvature falls towards a plane; a plane is left for a concave or
    convex surface by either side. A rim stays positive.
    """
    moved = step(surface, quantity) * pixels
    if quantity in (CURVATURE, CURVATURE_X):
        moved = -moved if value >= 0.0 else moved
    after = value + moved
    return max(after, 0.01 * value) if quantity == SEMI_DIAMETER else after


def glass_text(glass: Glass) -> str:
    """A medium in a cell: its name, n_d and V_d, or nothing for air."""
    if glass.n_d == 1.0 and not glass.name:
        return ""
    if glass.name:
        return glass.name
    return f"{significant(glass.n_d, 5)}" + (f"  {significant(glass.v_d, 3)}" if glass.v_d else "")


def pose_text(surface: Surface) -> str:
    """The place of a tilted or decentred surface: “0.3 0.5 mm  2° 0°”, its decentres, tilts and roll; "" if centred."""
    pose, texts = surface.pose, []
    if pose is None:
        return ""
    if pose.decentre_x or pose.decentre_y:
        texts.append(f"{significant(pose.decentre_x, 3)} {significant(pose.decentre_y, 3)} mm")
    if pose.tilt_x or pose.tilt_y:
        texts.append(f"{significant(degrees(pose.tilt_x), 3)}° {significant(degrees(pose.tilt_y), 3)}°")
    if pose.roll:
        texts.append(f"roll {significant(degrees(pose.roll), 3)}°")
    return true_minus("  ".join(texts))


def asphere_text(surface: Surface) -> str:
    """The powers of an asphere: “r⁴ … r¹²”; “cylinder” or “toroid”."""
    if surface.curvature_x is not None:
        return "cylinder" if surface.form is Shape.CYLINDER else "toroid"
    raised = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
    powers = [f"r{str(power).translate(raised)}" for power, _ in surface.aspheric]
    return " ".join(powers if len(powers) < 3 else (powers[0], "…", powers[-1]))


def rule_mark(document: LensDocument, surface: int, quantity: str) -> str:
    """A letter for a number that follows from others: S for a solve, P for a pickup."""
    rule = document.rule(surface, quantity)
    return "" if rule is None else "S" if hasattr(rule, "kind") else "P"


def tooltip(document: LensDocument, surface: int, quantity: str) -> list[str]:
    """What a cell holds, with all digits, and what it follows from."""
    row = document.surfaces[surface]
    name = words(quantity)
    lines = [f"{name[0].upper()}{name[1:]} of surface {surface}: {true_minus(whole(row, quantity))}"
             + ("" if quantity == CONIC or quantity.startswith("r") else "°" if quantity in ANGLES else " mm")]
    if quantity == CURVATURE and row.curvature:
        lines.append(f"Curvature {true_minus(significant(row.curvature))} /mm")
    rule = document.rule(surface, quantity)
    if rule is not None:
        lines.append(f"Follows: {rule}")
    return lines

