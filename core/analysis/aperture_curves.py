"""Curves of a lens as it is stopped down or focused: focus shift, breathing, relative illumination.

Lengths in mm. Foci are measured from the film, positive behind it.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf, isinf, nan

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.axial_curves import RadialBeam, axial_rays, on_axis, paraxial_focus
from lensbench.core.analysis.focus_map import best_places, through_focus
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import Conditions
from lensbench.core.analysis.grids.traced_grid import RayGrid, ray_grid
from lensbench.core.analysis.vignetting import Falloff, falloff
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.pauses import pause
from lensbench.core.optics.depth_of_field import magnification
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.focus import FocusError, film_distance as focus_on, focused, nearest_focus
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import f_number_at_infinity, first_order, stopped_down
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import f_number_text, significant

STOPS = 8               # half stops from the widest, that focus shift takes by default
FREQUENCY = 30.0        # cycles/mm, at which the MTF chooses a focus
PLACES = 81             # of the film, for the MTF
PUPIL = 64              # points across a pupil that is not round
RAYS, REACH = 97, 1.03  # rays of a round one, to beyond the rim of the stop
DISTANCES = 12          # focus distances of breathing, by default
FARTHEST = 100.0        # focal lengths: beyond, breathing changes no more

_Beam = tuple[float, float, Callable[[float, np.ndarray], np.ndarray]]


@dataclass(frozen=True, eq=False)
class FocusShift:
    """Best focus on the axis against the aperture, from `focus_shift`.

    Args:
        f_numbers: (n,) f-numbers, the widest first.
        least_blur: (n,) place of least rms blur, mm behind the film; all wavelengths with their weights.
        best_mtf: (n,) place of the highest white MTF at `frequency`, mm behind the film; NaN where none was found near
            it.
        paraxial: The paraxial focus, the limit of small stops, in the mean of the wavelengths, mm behind the film.
        frequency: Cycles/mm.
        depth: (n,) how far the film may lie from the best place, so that a point of even light becomes the blur
            `limit`, mm.
        limit: Diameter of that blur, mm.
    """

    f_numbers: np.ndarray
    least_blur: np.ndarray
    best_mtf: np.ndarray
    paraxial: float
    frequency: float
    depth: np.ndarray
    limit: float

    @property
    def shift(self) -> np.ndarray:
        """(n,) the place of least blur less that wide open, mm: positive where the focus moves away from the lens."""
        return self.least_blur - self.least_blur[0]


@dataclass(frozen=True, eq=False)
class Breathing:
    """Field of view against the focus distance, from `breathing`; NaN where the lens cannot focus.

    Args:
        distances: (n,) film → object, mm, the farthest first; inf is infinity.
        half_angles: (n,) angle from the axis at which the chief ray of the film's corner leaves for the scene, rad.
        focal_lengths: (n,) of the lens with its groups at that focus, mm; of the section y–z of a lens with cylinders.
        magnifications: (n,) paraxial, of the plane in focus, positive; 0 at infinity; of the same section.
        findings: Distances that the lens cannot be focused on, or at which no chief ray meets the film's corner.
    """

    distances: np.ndarray
    half_angles: np.ndarray
    focal_lengths: np.ndarray
    magnifications: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def change(self) -> np.ndarray:
        """(n,) percent by which the view is wider than at the first distance: the tangents' ratio less 1."""
        tangents = np.tan(self.half_angles)
        return 100.0 * (tangents / tangents[0] - 1.0)


def focus_shift(lens: Lens, film_distance: float, conditions: Conditions, f_numbers: ArrayLike | None = None,
                frequency: float = FREQUENCY, limit: float = 0.03) -> FocusShift:
    """The best focus on the axis as the lens is stopped down.

    Args:
        lens: The lens, wide open and focused.
        film_distance: Last vertex → film, mm.
        conditions: Its wavelengths and object distance.
        f_numbers: (n,) array_like or None. f-numbers in air at the d line, rising; None: half stops from the widest.
        frequency: Cycles/mm at which the MTF chooses a focus.
        limit: Diameter of the blur that counts as sharp, mm, for the depth of focus.
    Raises:
        LensError: For an afocal lens, f-numbers that the lens does not reach, a frequency or limit that is not
            positive, and as `ray_grid`.
    """
    widest = f_number_at_infinity(lens)
    if not widest < inf:
        raise LensError("this lens is afocal: it has no focus to shift")
    if not (0.0 < frequency < inf and 0.0 < limit < inf):
        raise LensError("focus shift needs a positive frequency, and a positive blur as its limit")
    numbers = widest * np.sqrt(2.0) ** np.arange(STOPS + 1) if f_numbers is None else \
        np.atleast_1d(np.asarray(f_numbers, float))
    radial = lens.is_rotationally_symmetric and lens.iris.is_round      # blades come forth when it is stopped down
    wide = axial_rays(lens, film_distance, conditions, np.linspace(0.0, REACH, RAYS)) if radial else None
    shares = np.array(conditions.weights)
    blur, mtf, depth = (np.full(len(numbers), nan) for _ in range(3))
    for i, number in enumerate(numbers):
        pause()
        stopped = stopped_down(lens, float(number))
        share = stopped.stop.semi_diameter / lens.stop.semi_diameter
        known = wide is not None and stopped.iris.is_round and wide.pass_within(share)
        product, square, otf = _round_beam(wide.within(share), shares) if wide is not None and known else \
            _traced_beam(ray_grid(stopped, film_distance, on_axis(conditions), PUPIL), shares)
        # rms blur is least at −mean (offset slope) / mean slope²
        blur[i] = -product / square
        cone = np.sqrt(square)                          # rms slope
        depth[i] = 0.5 * limit / (np.sqrt(2.0) * cone)
        reach = max(3.0 / (frequency * cone * 2.0 * np.sqrt(2.0)), 2.0 * abs(blur[i]))
        places = blur[i] + np.linspace(-0.5 * reach, 0.5 * reach, PLACES)
        mtf[i] = best_places(places, np.abs(otf(frequency, places)).mean(0)[None])[0]
    foci = [paraxial_focus(lens, conditions.object_distance, line) for line in conditions.wavelengths]
    paraxial = float(np.average(foci, weights=conditions.weights)) - film_distance
    return FocusShift(numbers, blur, mtf, paraxial, frequency, depth, limit)


def _round_beam(beams: list[RadialBeam], shares: np.ndarray) -> _Beam:
    """Of a round pupil: mean offset × slope, mean slope², and the white OTF (1, K) at K film positions."""
    product, square = shares @ np.array([beam.moments() for beam in beams])
    return product, square, lambda frequency, places: shares @ np.stack(
        [beam.through_focus(frequency, places)[None] for beam in beams], 1)


def _traced_beam(rays: RayGrid, shares: np.ndarray) -> _Beam:
    """The same of a grid with one field on the axis, for pupils that are not round."""
    weight = shares[:, None, None] * rays.weight[0]
    s, t, m_s, m_t = rays.light[:, 0]
    total = weight.sum()
    return (float((weight * (s * m_s + t * m_t)).sum() / total), float((weight * (m_s**2 + m_t**2)).sum() / total),
            lambda frequency, places: np.einsum("cak,c->ak", through_focus(rays, frequency, places)[0], shares))


def breathing(lens: Lens, film: Film, distances: ArrayLike | None = None, wavelength: float | None = None,
              focusing: Lens | None = None) -> Breathing:
    """How the field of view changes with the focus distance.

    Args:
        lens: The lens at its zoom setting.
        film: The film, whose corner bounds the view. Of a lens without rotational symmetry it is that at +x and +y.
        distances: (n,) array_like or None. Film → object, mm; None: twelve from infinity to the nearest focus.
        wavelength: µm, of the chief rays; None: the primary wavelength of the lens.
        focusing: The lens with the indices that its film is focused for, such as those at the wavelength of its design
            in place of those at the d line; None: `lens`.
    Raises:
        FocusError: Where the lens forms no real image.
    """
    line = lens.system.primary_wavelength if wavelength is None else wavelength
    if distances is None:
        nearest, efl = nearest_focus(focusing or lens), abs(first_order(focusing or lens).efl)
        far = FARTHEST * efl
        near = nearest if lens.has_focus_groups else max(nearest, 10.0 * efl)
        steps = np.geomspace(far, near * (1.0 + 1e-9), DISTANCES - 1) if not isinf(nearest) else np.zeros(0)
        places = np.array([inf, *steps])
    else:
        places = np.atleast_1d(np.asarray(distances, float))
    corner = np.array([[0.0, film.diagonal] if lens.is_rotationally_symmetric else [film.width, film.height]]) / 2.0
    angles, focal, magnified = (np.full(len(places), nan) for _ in range(3))
    refused = []
    for i, distance in enumerate(places):
        pause()
        try:
            there = focused(focusing or lens, float(distance))
            away = focus_on(there, float(distance))
        except FocusError as error:
            refused.append((float(distance), str(error)))
            continue
        if focusing is not None:
            there = lens.at(close=there.positions.close) if there.has_focus_groups and there.positions else lens
        focal[i] = first_order(there, line).efl
        with suppress(LensError):                       # focused on what touches the lens
            magnified[i] = magnification(there, away, float(distance), line)
        angles[i] = np.hypot(*find_chief_rays(there, away, corner, inf, True, line).angles[0])
    findings = tuple(Finding(Kind.FIELD, None, f"no focus at {significant(distance / 1000.0, 3)} m: {why}",
                             figures={"distance": distance}) for distance, why in refused)
    beyond = int((np.isfinite(focal) & np.isnan(angles)).sum())
    if beyond:
        findings += (Finding(Kind.FIELD, None, "no chief ray meets the corner of the film, "
                             f"{significant(0.5 * film.diagonal, 4)} mm from its centre: the view is not known at "
                             f"{beyond} of {len(places)} focus distances", figures={"distances": float(beyond)}),)
    return Breathing(places, angles, focal, magnified, findings)


def relative_illumination(lens: Lens, film_distance: float, film: Film, f_numbers: Sequence[float] | None = None,
                          points: int = 33, wavelength: float = D_LINE) -> tuple[tuple[str, Falloff], ...]:
    """Falloff over the film at several apertures, each split into natural falloff and vignetting.

    Args:
        lens: Rotationally symmetric lens, wide open and focused.
        film_distance: Last vertex → film, mm.
        film: Its half-diagonal ends the curves.
        f_numbers: sequence or None. f-numbers in air, at the d line; None: the widest, and one, two and three stops
            less.
        points: Film radii.
        wavelength: µm, of the light.
    Returns:
        tuple of (str, Falloff). The aperture in words, and its falloff.
    Raises:
        LensError: For an afocal lens, fewer than 2 radii, and as `falloff` and `stopped_down`.
    """
    if points < 2:
        raise LensError(f"{points} film radii: at least 2 are needed")
    widest = f_number_at_infinity(lens)
    if not widest < inf:
        raise LensError("this lens is afocal: it has no f-numbers to compare")
    numbers = widest * np.sqrt(2.0) ** np.arange(4) if f_numbers is None else f_numbers
    radii = np.linspace(0.0, 0.5 * film.diagonal, points)
    curves = []
    for number in numbers:
        pause()
        stopped = stopped_down(lens, float(number))
        curves.append((f_number_text(float(number)), falloff(stopped, film_distance, radii, wavelength)))
    return tuple(curves)
