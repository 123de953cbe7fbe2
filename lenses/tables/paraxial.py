"""Paraxial figures of a list of surfaces, and a count of its faults.

Lengths in mm, in the lens frame. Readers use them before there is a lens: to choose between two
readings of one table, to find the stop and to place zoom stations. `lensbench.core.optics.paraxial` has the same
figures for a lens.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import inf, sqrt
from typing import Any

from lensbench.core.optics.glass import D_LINE, Glass, GlassError
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import SystemData

ROUNDING = 1e-4         # µm: 0.5876 and 0.58756 are the d line
FAR = 1e8               # mm or units of a file: an object beyond it is at infinity


def axial_heights(surfaces: Sequence[Surface]) -> list[float]:
    """Heights (mm) at each surface of the paraxial d-line ray that enters parallel to the axis at height 1."""
    return ray(surfaces)[0]


def focal_length(surfaces: Sequence[Any], wavelength: float = D_LINE, front_index: float = 1.0) -> float:
    """Paraxial focal length behind the system, in the unit of the surfaces or rows; inf for an afocal one.

    wavelength: µm. front_index: before the first surface.
    """
    slope = ray(surfaces, wavelength=wavelength, front_index=front_index)[1]
    return -1.0 / slope if slope else inf


def image_distance(surfaces: Sequence[Surface], distance: float, wavelength: float = D_LINE,
                   front_index: float = 1.0) -> float:
    """Last vertex → paraxial image (mm) of the axis point `distance` mm before the first vertex (or inf).

    wavelength: µm. front_index: before the first surface.
    """
    start = (distance, 1.0) if abs(distance) < 1.0 else (1.0, 1.0 / distance)
    heights, slope = ray(surfaces, *start, wavelength, front_index)
    return -heights[-1] / slope if slope else inf


def object_distance(surfaces: Sequence[Surface]) -> float:
    """First vertex → object (mm, positive before it) whose paraxial d-line image lies at the end of the last gap."""
    on_film = []                        # of height 1 in front of the lens, and of slope 1
    for start in ((1.0, 0.0), (0.0, 1.0)):
        heights, slope = ray(surfaces, *start)
        on_film.append(heights[-1] + surfaces[-1].thickness * slope)
    return -on_film[1] / on_film[0] if on_film[0] else inf


def f_number(surfaces: Sequence[Any], stop_index: int, wavelength: float = D_LINE,
             front_index: float = 1.0) -> float:
    """Focal length over the entrance-pupil diameter given by the stop alone; inf for an afocal system."""
    height = ray(surfaces, wavelength=wavelength, front_index=front_index)[0][stop_index]
    radius: float = surfaces[stop_index].semi_diameter
    return abs(focal_length(surfaces, wavelength, front_index) * height) / (2.0 * radius)


def ray(surfaces: Sequence[Any], height: float = 1.0, slope: float = 0.0, wavelength: float = D_LINE,
        front_index: float = 1.0) -> tuple[list[float], float]:
    """Heights of a paraxial ray at the surfaces of a lens or the rows of a file, and the slope behind them.

    wavelength: µm. front_index: before the first surface, in which the ray has `slope`. GlassError: a glass is not
    known there.
    """
    n, heights = front_index, []
    for surface in surfaces:
        heights.append(height)
        after = index_of(surface.glass, wavelength)
        slope = (n * slope - height * surface.vertex_curvature * (after - n)) / after
        height += slope * surface.thickness
        n = after
    return heights, slope


def index_of(glass: Glass, wavelength: float) -> float:
    """Index of a glass: n_d as stated at the d line, and that of its dispersion elsewhere (µm)."""
    return glass.n_d if wavelength == D_LINE else glass.index(wavelength)


def reference_wavelength(surfaces: Sequence[Any], system: SystemData) -> float:
    """The primary wavelength of the system data (µm); the d line if a glass is not known at the primary one."""
    try:
        for surface in surfaces:
            index_of(surface.glass, system.primary_wavelength)
    except GlassError:
        return D_LINE
    return system.primary_wavelength


def at_reference(lens: Lens) -> tuple[Lens, float]:
    """The lens as its reference wavelength sees it, without dispersion, and that wavelength (µm).

    At the d line it is the lens itself. Its figures at any wavelength are those of the lens at the reference.
    """
    known = lens.known.get(("at reference", D_LINE))
    if known is None:
        wavelength, variant = lens.reference_wavelength, None
        if not is_d_line(wavelength):
            variant = replace(lens, surfaces=tuple(
                replace(surface, glass=Glass(surface.glass.index(wavelength), None, surface.glass.name))
                for surface in lens.surfaces))
        known = lens.known["at reference", D_LINE] = variant, wavelength
    return known[0] or lens, known[1]


def is_d_line(wavelength: float) -> bool:
    """Whether a wavelength (µm) is the d line, or its rounding in a file."""
    return abs(wavelength - D_LINE) < ROUNDING


def count_faults(surfaces: Sequence[Surface]) -> int:
    """Number of faults: elements without thickness, surfaces that cross, no positive power."""
    count = 0 if 0.0 < focal_length(surfaces) < inf else 1
    for front, back in zip(surfaces, surfaces[1:], strict=False):
        rim = min(front.semi_diameter, back.semi_diameter)
        edge = front.thickness + sag(back.curvature, rim) - sag(front.curvature, rim)
        in_glass = front.glass.n_d > 1.0
        count += (front.thickness < 0.0) + (in_glass and front.thickness == 0.0) + (edge < -0.01 * rim)
    return count


def sag(c: float, height: float) -> float:
    """Sag of a sphere (mm) at a height; that of its equator for heights beyond."""
    return c * height * height / (1.0 + sqrt(max(0.0, 1.0 - c * height * c * height)))
