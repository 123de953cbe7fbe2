"""Curves on the axis: longitudinal aberration against pupil height, chromatic focal shift against wavelength.

Lengths in mm. Foci are measured from the film, positive behind it. One fan of rays of a meridian, from the axis to the
edge of the stop, gives the whole beam of a rotationally symmetric lens; its inner part that of a smaller stop.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isinf, nan, pi, sqrt

import numpy as np

from lensbench.core.analysis.aberrations import check_symmetry
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_beams import LANDED, OFFSET_T, OPD, PUPIL_T, SHARE, SLOPE_T, FieldBeams
from lensbench.core.analysis.grids.field_conditions import Conditions
from lensbench.core.analysis.grids.traced_grid import check_traceable
from lensbench.core.analysis.spot_diagram import pupil_by_height
from lensbench.core.analysis.transfer_function import FAST, cosine_of_turns
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.optics.glass import GlassError
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import FieldKind

NODES = 129             # of the inner part of a fan, evenly over the height in the stop
GAUSS = 20              # points along x and along y in the common part of two shifted pupils


@dataclass(frozen=True, eq=False)
class AxialRays:
    """Rays of one meridian above the axis in C wavelengths and at K heights, from `axial_rays`.

    conditions: with the field on the axis alone. heights: (K,) in the stop over its radius, from 0 at even steps, of
    rays towards the middle of the film in the primary wavelength. entries: (K,) distance from the axis in the entrance
    pupil, mm. reach: object point → entrance pupil, mm. rows: (C, 9, K), as LANDED of `field_beams`. victim: (C, K)
    index of the surface that blocks a ray, −1 for a ray that passes, −2 for one that is not traced.
    """

    conditions: Conditions
    heights: np.ndarray
    entries: np.ndarray
    reach: float
    rows: np.ndarray
    victim: np.ndarray

    def pass_within(self, share: float) -> bool:
        """Whether rays of all heights in the stop up to `share` of its radius are known, and no rim ends one."""
        within = self.rows[:, SHARE] <= share * share * (1.0 - 1e-9)
        known = np.isfinite(self.rows).all(1) & np.isfinite(self.entries)
        beyond = (self.rows[:, SHARE] >= share * share).any(1, keepdims=True)
        return bool((known & beyond).all() and (self.victim[within] == -1).all())

    def within(self, share: float) -> "list[RadialBeam]":
        """The beam of a stop with `share` of the radius, in each wavelength, where `pass_within` holds."""
        made = np.empty((len(self.rows), len(self._curves[0]), NODES))
        for curves, rows, out in zip(self._curves, self.rows, made, strict=True):
            _inner_part(curves, rows[SHARE], share * share, out)
        return [RadialBeam(line, *rows) for line, rows in zip(self.conditions.wavelengths, made, strict=True)]

    @cached_property
    def _curves(self) -> np.ndarray:
        """(C, 6, K) fields of a RadialBeam at the heights of these rays."""
        square = self.entries**2
        light = square if isinf(self.reach) else square / (1.0 + square / self.reach**2)
        side = np.sign(self.rows[:, PUPIL_T, -1:])      # rays from above the axis run downwards, past a real pupil
        pupil = side * self.rows[:, PUPIL_T]
        root = np.sqrt(np.maximum(np.gradient(light, pupil[self.conditions.primary]**2, edge_order=2), 0.0))
        rows = np.broadcast_to(np.stack([light, root]), (len(pupil), 2, len(light)))
        return np.stack([pupil, self.rows[:, OPD], side * self.rows[:, OFFSET_T], side * self.rows[:, SLOPE_T],
                         rows[:, 0], rows[:, 1]], 1)


@dataclass(frozen=True, eq=False)
class RadialBeam:
    """The beam of a round pupil in one wavelength (µm), at NODES heights from the axis to the edge.

    pupil, opd, offset, slope: (n,) as in RayGrid, along the pupil coordinate. light: (n,) within this height: the
    square of the beam's radius, or what a near Lambertian point sends into it. root: (n,) square root of the derivative
    of the light by the squared pupil coordinate.
    """

    wavelength: float
    pupil: np.ndarray
    opd: np.ndarray
    offset: np.ndarray
    slope: np.ndarray
    light: np.ndarray
    root: np.ndarray

    def moments(self) -> tuple[float, float]:
        """Means over the light of offset × slope (mm) and of slope²."""
        # Simpson's rule over the index; the middle of every two steps is a node
        light = np.gradient(self.light)
        light[::2] *= 2.0
        light[1::2] *= 4.0
        light[[0, -1]] *= 0.5
        light /= light.sum()
        return float(light @ (self.offset * self.slope)), float(light @ self.slope**2)

    def through_focus(self, frequency: float, shifts: np.ndarray) -> np.ndarray:
        """(K,) OTF, which is real, at one frequency (cycles/mm) for a film shifted by even steps (K,), mm along +z."""
        line = 1e-3 * self.wavelength
        out = np.zeros(len(shifts))
        _radial_transfer(self.pupil, self.opd / line, self.offset / line, self.root, 0.5 * line * frequency,
                         *gauss_rule(GAUSS), shifts[0] / line, (shifts[1] - shifts[0]) / line, out)
        return out / (pi * self.light[-1])


def on_axis(conditions: Conditions) -> Conditions:
    """The same conditions with one field, on the axis."""
    return replace(conditions, field_kind=FieldKind.REAL_IMAGE_HEIGHT, fields=((0.0, 0.0),))


def axial_rays(lens: Lens, film_distance: float, conditions: Conditions, heights: np.ndarray) -> AxialRays:
    """Rays of one meridian at even heights (K,) in the stop over its radius, from 0; conditions as for `ray_grid`."""
    axis = on_axis(conditions)
    check_traceable(lens, film_distance, axis)
    line, distance = axis.primary_wavelength, axis.object_distance
    chief = find_chief_rays(lens, film_distance, np.zeros((1, 2)), distance, True, line)
    beams = FieldBeams.of(lens, film_distance, chief, distance, line)
    points = len(heights)
    pupil = pupil_by_height(beams, 1, heights)
    on_stop = np.einsum("kfq,fk->fq", beams.on_stop(np.zeros((1, points)), pupil), beams.axes[:, 1])
    # One step of Newton's method: even to 1e-8
    pupil = pupil + (heights - on_stop) / np.gradient(on_stop[0], pupil[0])
    places, _ = beams.towards_scene(np.zeros((1, points)), pupil)
    entries = places[0] @ beams.axes[0, 1]
    of_field = np.zeros(points, int)
    starts = beams.starts(of_field, places[0])
    rows = np.empty((len(axis.wavelengths), LANDED, points))
    victim = np.full((len(rows), points), -2, np.int16)
    known = np.isfinite(entries)
    for c, colour in enumerate(axis.wavelengths):
        landed, ended = beams.forward(colour, of_field, starts)
        rows[c], victim[c, known] = np.where(known, landed, nan), ended[known]
    return AxialRays(axis, heights, np.abs(entries), float(beams.reaches[0]), rows, victim)


@njit(cache=True, nogil=True, error_model="numpy")
def _inner_part(rows, squares, square, out):
    """Rows (m, n) at even positions (m, k) from 0 to where rising squares (n,) reach `square`, by cubics."""
    first = min(max(np.searchsorted(squares, square) - 2, 0), squares.size - 4)
    end = 0.0
    for k in range(4):
        product = 1.0
        for q in range(4):
            if q != k:
                there = sqrt(squares[first + q])
                product *= (sqrt(square) - there) / (sqrt(squares[first + k]) - there)
        end += product * (first + k)
    count = out.shape[1]
    for a in range(count):
        index = end * a / (count - 1.0)
        i = min(max(int(index) - 1, 0), rows.shape[1] - 4)
        x = index - i
        before, own = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0, 0.5 * x * (x - 2.0) * (x - 3.0)
        after, beyond = -0.5 * x * (x - 1.0) * (x - 3.0), x * (x - 1.0) * (x - 2.0) / 6.0
        for m in range(rows.shape[0]):
            out[m, a] = (before * rows[m, i] + own * rows[m, i + 1] + after * rows[m, i + 2]
                         + beyond * rows[m, i + 3])


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def _radial_transfer(pupil, w, slope, root, half, node, weight, first, step, out):
    """Integral (K,) over the common part of a round pupil and itself, half × 2 apart, for K film positions.

    pupil: (n,) radii, rising. w, slope, root: (n,) path difference in wavelengths, its change by the radius, and the
    square root of the light. node, weight: of Gauss's rule on 0 … 1. first, step: of the film, in wavelengths. A
    quarter of the common part counts four times.
    """
    n, q = pupil.size, node.size
    edge = pupil[n - 1]
    if half >= edge:
        return
    before, now, turn, size = np.empty(q * q), np.empty(q * q), np.empty(q * q), np.empty(q * q)
    for i in range(q):
        x = node[i] * (edge - half)
        tall = sqrt(max(edge * edge - (x + half) ** 2, 0.0))
        for j in range(q):
            y = node[j] * tall
            phase, light, cosine = 0.0, 1.0, 0.0
            for sign in (1.0, -1.0):
                r2 = (x + sign * half) ** 2 + y * y
                r = sqrt(r2)
                k = min(int(r / edge * (n - 1)), n - 2)
                while k > 0 and pupil[k] > r:
                    k -= 1
                while k < n - 2 and pupil[k + 1] < r:
                    k += 1
                gap = pupil[k + 1] - pupil[k]
                share = (r - pupil[k]) / gap
                rest = 1.0 - share
                wave = ((1.0 + 2.0 * share) * rest * rest * w[k] + share * share * (3.0 - 2.0 * share) * w[k + 1]
                        + gap * share * rest * (rest * slope[k] - share * slope[k + 1]))
                phase += sign * wave
                cosine -= sign * sqrt(1.0 - r2)
                light *= rest * root[k] + share * root[k + 1]
            a = i * q + j
            size[a] = 4.0 * light * weight[i] * weight[j] * (edge - half) * tall
            angle = phase + first * cosine
            angle -= np.floor(angle + 0.5)
            now[a] = cosine_of_turns(angle * angle)
            angle = phase + (first - step) * cosine
            angle -= np.floor(angle + 0.5)
            before[a] = cosine_of_turns(angle * angle)
            angle = step * cosine
            angle -= np.floor(angle + 0.5)
            turn[a] = 2.0 * cosine_of_turns(angle * angle)
    # From place to place every angle grows by the same: cos (k + 1) φ = 2 cos φ cos k φ − cos (k − 1) φ
    for k in range(out.size):
        total = 0.0
        for a in range(q * q):
            total += size[a] * now[a]
            after = turn[a] * now[a] - before[a]
            before[a] = now[a]
            now[a] = after
        out[k] = total


HEIGHTS, COLOURS = 33, 61
VIOLET, RED = 0.4, 0.7          # µm, ends of the visible spectrum


@dataclass(frozen=True, eq=False)
class Longitudinal:
    """Where axial rays cross the axis, from `longitudinal_aberration`.

    Args:
        conditions: As given.
        heights: (K,) heights in the stop over its radius, 0 to 1; 0 is the paraxial limit.
        foci: (C, K) crossing, mm behind the film; NaN for a ray that a rim ends.
    """

    conditions: Conditions
    heights: np.ndarray
    foci: np.ndarray


@dataclass(frozen=True, eq=False)
class FocalShift:
    """Paraxial focus against wavelength, from `chromatic_focal_shift`.

    Args:
        wavelengths: (n,) µm.
        foci: (n,) paraxial focus, mm behind the film; NaN where a glass is not known.
    """

    wavelengths: np.ndarray
    foci: np.ndarray


def longitudinal_aberration(lens: Lens, film_distance: float, conditions: Conditions,
                            points: int = HEIGHTS) -> Longitudinal:
    """Spherical aberration along the axis, in each wavelength.

    Args:
        lens: Rotationally symmetric lens, focused.
        film_distance: Last vertex → film, mm.
        conditions: Its wavelengths and object distance.
        points: Heights, at least 2.
    Raises:
        LensError: For a lens without rotational symmetry, fewer than 2 heights, where no ray off the axis passes, and
            as `ray_grid`.
    """
    check_symmetry(lens)
    if points < 2:
        raise LensError(f"{points} heights: at least 2 are needed")
    rays = axial_rays(lens, film_distance, conditions, np.linspace(0.0, 1.0, points))
    if not (rays.victim[:, 1:] == -1).any():
        raise LensError("surfaces block all rays of the axis point but the one along the axis")
    with np.errstate(divide="ignore", invalid="ignore"):
        foci = np.where(rays.victim == -1, -rays.rows[:, OFFSET_T] / rays.rows[:, SLOPE_T], nan)
    foci[:, 0] = [paraxial_focus(lens, conditions.object_distance, line) - film_distance
                  for line in conditions.wavelengths]
    return Longitudinal(conditions, rays.heights, foci)


def chromatic_focal_shift(lens: Lens, film_distance: float, conditions: Conditions,
                          points: int = COLOURS) -> FocalShift:
    """The paraxial focus against wavelength, over the visible spectrum and the wavelengths of the conditions.

    Args:
        lens: Focused lens; of a cylinder or toroid the section y–z counts.
        film_distance: Last vertex → film, mm.
        conditions: Its wavelengths and object distance.
        points: Wavelengths, at least 2.
    Raises:
        LensError: For fewer than 2 wavelengths.
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
