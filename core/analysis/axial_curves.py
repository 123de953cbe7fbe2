"""Curves on the axis: longitudinal aberration against pupil height, chromatic focal shift against wavelength.

Lengths in mm. Foci are measured from the film, positive behind it.
"""

from dataclasses import dataclass
from math import inf, isinf, nan

import numpy as np

from lensbench.analysis.aberrations import check_symmetry
from lensbench.analysis.axial_rays import axial_rays
from lensbench.analysis.grids.field_beams import OFFSET_T, SLOPE_T
from lensbench.analysis.grids.field_conditions import Conditions
from lensbench.optics.glass import GlassError
from lensbench.optics.lens_surface import LensError
from lensbench.optics.paraxial import first_order, ray_matrix
from lensbench.optics.prescription import Lens

HEIGHTS, COLOURS = 33, 61
VIOLET, RED = 0.4, 0.7          # µm, ends of the visible spectrum


@dataclass(frozen=True, eq=False)
class Longitudinal:
    """Where axial rays cross the axis, from `longitudinal_aberration`.

    Parameters
    ----------
    conditions
        As given.
    heights
        (K,) heights in the stop over its radius, 0 to 1; 0 is the paraxial limit.
    foci
        (C, K) crossing, mm behind the film; NaN for a ray that a rim ends.
    """

    conditions: Conditions
    heights: np.ndarray
    foci: np.ndarray


@dataclass(frozen=True, eq=False)
class FocalShift:
    """Paraxial focus against wavelength, from `chromatic_focal_shift`.

    Parameters
    ----------
    wavelengths
        (n,) µm.
    foci
        (n,) paraxial focus, mm behind the film; NaN where a glass is not known.
    """

    wavelengths: np.ndarray
    foci: np.ndarray


def longitudinal_aberration(lens: Lens, film_distance: float, conditions: Conditions,
                            points: int = HEIGHTS) -> Longitudinal:
    """Spherical aberration along the axis, in each wavelength.

    Parameters
    ----------
    lens : Lens
        Rotationally symmetric lens, focused.
    film_distance : float
        Last vertex → film, mm.
    conditions : Conditions
        Its wavelengths and object distance.
    points : int
        Heights, at least 2.

    Returns
    -------
    Longitudinal

    Raises
    ------
    LensError
        For a lens without rotational symmetry, fewer than 2 heights, where no ray off the axis passes, and as
        `ray_grid`.
    """
    check_symmetry(lens)
    if points < 2:
        raise LensError(f"{points} heights: at least 2 are needed")
    rays = axial_rays(lens, film_distance, conditions, np.linspace(0.0, 1.0, points))
    if not (rays.victim[:, 1:] == -1).any():
        raise LensError("rims end all rays of the axis point but the one along the axis")
    with np.errstate(divide="ignore", invalid="ignore"):
        foci = np.where(rays.victim == -1, -rays.rows[:, OFFSET_T] / rays.rows[:, SLOPE_T], nan)
    foci[:, 0] = [paraxial_focus(lens, conditions.object_distance, line) - film_distance
                  for line in conditions.wavelengths]
    return Longitudinal(conditions, rays.heights, foci)


def chromatic_focal_shift(lens: Lens, film_distance: float, conditions: Conditions,
                          points: int = COLOURS) -> FocalShift:
    """The paraxial focus against wavelength, over the visible spectrum and the wavelengths of the conditions.

    Parameters
    ----------
    lens : Lens
        Focused lens; of a cylinder or toroid the section y–z counts.
    film_distance : float
        Last vertex → film, mm.
    conditions : Conditions
        Its wavelengths and object distance.
    points : int
        Wavelengths, at least 2.

    Returns
    -------
    FocalShift

    Raises
    ------
    LensError
        For fewer than 2 wavelengths.
    """
    if points < 2:
        raise LensError(f"{points} wavelengths: at least 2 are needed")
    lines = np.linspace(min(VIOLET, *conditions.wavelengths), max(RED, *conditions.wavelengths), points)
    foci = np.full(points, nan)
    for i, line in enumerate(lines):
        try:
            foci[i] = paraxial_focus(lens, conditions.object_distance, float(line)) - film_distance
        except GlassError:
            continue
    return FocalShift(lines, foci)


def paraxial_focus(lens: Lens, object_distance: float, wavelength: float) -> float:
    """Last vertex → paraxial image of the axis point (mm); inf for an image at infinity."""
    fo = first_order(lens, wavelength)
    if isinf(object_distance):
        return fo.bfl
    if isinf(fo.efl):                                   # an afocal lens images with one magnification everywhere
        a, b, _, d = ray_matrix(lens, 0, len(lens.surfaces), wavelength)
        return -(a * object_distance + lens.front_index * b) / (lens.front_index * d)
    away = fo.ffl + object_distance                     # of the object before the front focus
    return fo.bfl + lens.front_index * fo.efl**2 / away if away else inf
