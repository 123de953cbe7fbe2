"""Checked surfaces from the rows of a lens table: numbers, curvatures from radii, and the stop.

Lengths in mm. Every reader uses these functions, so that the same mistake gives the same message in every format.

Toroids of other programs' files: three shapes share two curvatures, and lensbench traces the biconic one.

    biconic         z = A / (1 + √(1 − c_x² x² − c_y² y²)), A = c_x x² + c_y y²
    torus           the arc of the section y–z, turned about an axis along y
    torus about x   the arc of the section x–z, turned about an axis along x
    arcs            the sum of the arcs of both sections

They agree in both sections, and everywhere where one of them is straight: a cylinder.
"""

from collections.abc import Sequence
from decimal import Context, Decimal
from math import cos, inf, isinf, pi, sin, sqrt

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.text import significant
from lensbench.lenses.file_error import RowError, number
from lensbench.lenses.tables.paraxial import axial_heights, sag

SMALLEST_RADIUS = 1e-6      # mm
SMALLEST_RIM, LARGEST = 1e-9, 1e9       # mm: largest length in a lens, so that its powers stay finite
HIGHEST_INDEX = 6.0         # germanium has 4
WIDEST_STOP = 20.0          # × the largest other rim: a stop that limits light is never so wide
HIGHEST_TERM = 1e200         # mm: largest aspheric term at the rim


def curvature(radius: object) -> float:
    """Curvature in 1/mm, correctly rounded from the digits of the radius; 0 and inf are a plane."""
    size = number(radius, "radius", infinite=True)
    if size == 0.0 or isinf(size):
        return 0.0
    if abs(size) < SMALLEST_RADIUS:
        raise RowError(f"radius is {significant(size)} mm: it must be at least {significant(SMALLEST_RADIUS)} mm (0 or "
                       f"inf: a plane)")
    return float(1 / Decimal(radius)) if isinstance(radius, str | Decimal) else 1.0 / size


def radius_text(c: float) -> str:
    """Shortest decimal radius (mm) that `curvature` converts to exactly c; "inf" for a plane."""
    if c == 0.0:
        return "inf"
    for digits in range(1, 28):
        radius = Context(prec=digits).create_decimal(1 / Decimal(c))
        text = f"{radius:f}" if abs(radius.adjusted()) < 12 else f"{radius:e}"
        if float(1 / Decimal(text)) == c:
            break
    return text if "." in text or "e" in text else f"{text}.0"


def surface(radius: object, thickness: object, n_d: object, semi_diameter: object,
            v_d: object = None, glass: str = "") -> Surface:
    """A surface from the values of its row; v_d 0 or None: unknown dispersion. RowError: an invalid value."""
    n = number(n_d, "index n_d")
    if n < 1.0:
        raise RowError(f"index n_d is {significant(n)}: it must be at least 1 (air)")
    abbe = None if v_d is None else number(v_d, "Abbe number V_d") or None
    if abbe is not None and abbe < 0.0:
        raise RowError(f"Abbe number V_d is {significant(abbe)}: it must be positive, or 0 where it is not known")
    rim = number(semi_diameter, "semi-diameter")
    if rim <= 0.0:
        raise RowError(f"semi-diameter is {significant(rim)} mm: it must be positive")
    made = Surface(number(thickness, "thickness"), rim, Glass(n, abbe, glass), curvature=curvature(radius))
    check_sizes(made)
    return made


def check_sizes(surface: Surface) -> None:
    """Raise RowError for a surface (mm) whose sizes can only be a mistake of the file."""
    for name, c in (("radius", surface.curvature), ("radius of the section x–z", surface.curvature_x or 0.0)):
        if abs(c) > 1.0 / SMALLEST_RADIUS:
            raise RowError(f"{name} is {significant(1.0 / c)} mm: it must be at least {significant(SMALLEST_RADIUS)} "
                           f"mm (0 or inf: a plane)")
    if surface.glass.n_d > HIGHEST_INDEX:
        raise RowError(f"index n_d is {significant(surface.glass.n_d)}: no lens is made of more than "
                       f"{significant(HIGHEST_INDEX)}")
    if not SMALLEST_RIM <= surface.semi_diameter <= LARGEST:
        raise RowError(f"semi-diameter is {significant(surface.semi_diameter)} mm: it must lie between "
                       f"{significant(SMALLEST_RIM)} and {significant(LARGEST)} mm")
    if abs(surface.thickness) > LARGEST:
        raise RowError(f"thickness is {significant(surface.thickness)} mm: no lens has gaps of more than "
                       f"{significant(LARGEST)} mm")
    for power, a in surface.aspheric:
        if abs(a) * surface.semi_diameter ** power > HIGHEST_TERM:
            raise RowError(f"the aspheric coefficient of r^{power} is {significant(a)}: it would raise the edge by "
                           f"more than {significant(HIGHEST_TERM)} mm")


def stop_of(surfaces: tuple[Surface, ...], marked: list[int]) -> tuple[int, tuple[Finding, ...]]:
    """Index of the aperture stop, from the surfaces marked as stops, and the assumption made.

    Findings also name a stop that cannot limit the light, and thicknesses that only a mirror explains.
    """
    index, assumed = _stop_of(surfaces, marked)
    rim, widest = surfaces[index].semi_diameter, widest_other(surfaces, index)
    if rim > WIDEST_STOP * widest:
        assumed += (Finding(Kind.STOP_SIZE, index, f"the stop's semi-diameter, {significant(rim)} mm, is that of no "
                                                   f"stop: the largest of the other surfaces is {significant(widest)} "
                                                   "mm. Correct the diameter of the stop",
                            figures={"semi_diameter": rim, "widest": widest}),)
    folded = next((i for i, s in enumerate(surfaces[:-1]) if s.thickness < 0.0 and (s.glass.n_d > 1.0 or (
        i > 0 and surfaces[i - 1].glass.n_d > 1.0 and surfaces[i + 1].glass.n_d > 1.0))), None)
    if folded is not None:
        assumed += (Finding(Kind.THICKNESS, folded, f"the thickness behind surface {folded}, "
                                                    f"{significant(surfaces[folded].thickness)} mm, is negative, as "
                                                    "behind a mirror: tables with mirrors are not traced"),)
    return index, assumed


def widest_other(surfaces: Sequence[Surface], index: int) -> float:
    """The largest semi-diameter (mm) of all surfaces but one; inf where there are no others."""
    return max((s.semi_diameter for i, s in enumerate(surfaces) if i != index), default=inf)


def _stop_of(surfaces: tuple[Surface, ...], marked: list[int]) -> tuple[int, tuple[Finding, ...]]:
    if len(marked) == 1:
        return marked[0], ()
    if not marked:
        index = min(range(len(surfaces)), key=lambda i: surfaces[i].semi_diameter)
        size = surfaces[index].semi_diameter
        return index, (Finding(Kind.NO_STOP, None, f"no stop is marked: the smallest clear aperture limits, surface "
                                                   f"{index} (semi-diameter {significant(size)} mm)",
                               figures={"semi_diameter": size}),)
    heights = axial_heights(surfaces)
    index = max(marked, key=lambda i: abs(heights[i]) / surfaces[i].semi_diameter)
    return index, (note(Kind.STOP, f"{len(marked)} stops are marked, surfaces {', '.join(map(str, marked))}: "
                                   f"surface {index} limits the light and is the stop", index),)


TOROIDS = {"torus": "a torus", "torus about x": "a torus", "arcs": "the sum of two arcs"}
POINTS = 24


def toroid_finding(kind: str, surface: Surface, i: int) -> Finding | None:
    """The finding about surface i (mm) if its file means another toroid than the biconic one, else None."""
    if kind not in TOROIDS or not surface.curvature or not surface.curvature_x:
        return None
    away = _departure(kind, surface)
    return note(Kind.SHAPE, f"surface {i}: {TOROIDS[kind]} in the file, it is traced as the biconic toroid of the same "
                            f"two curvatures, {significant(away, 2)} mm from it at the edge", i, departure=away)


def _departure(kind: str, surface: Surface) -> float:
    """Largest distance (mm) along the axis between this kind of toroid and the biconic one, around the rim."""
    worst, h = 0.0, surface.semi_diameter
    for i in range(POINTS + 1):
        x, y = h * sin(0.5 * pi * i / POINTS), h * cos(0.5 * pi * i / POINTS)
        worst = max(worst, abs(_toroid_sag(kind, surface, x, y) - _toroid_sag("biconic", surface, x, y)))
    return worst


def _toroid_sag(kind: str, surface: Surface, x: float, y: float) -> float:
    """Sag (mm) of a toroid; that of its equator for heights beyond."""
    across, c = surface.curvature_x or 0.0, surface.curvature
    if kind == "biconic":
        return (across * x * x + c * y * y) / (1.0 + sqrt(max(0.0, 1.0 - (across * x) ** 2 - (c * y) ** 2)))
    if kind == "arcs":
        return sag(across, x) + sag(c, y)
    if kind == "torus about x":
        x, y, across, c = y, x, c, across
    profile = sag(c, y)
    reach = 1.0 - across * profile                      # of the axis, in its radius: 0 where the surface meets it
    return profile + (sag(across / reach, x) if reach else 0.0)
