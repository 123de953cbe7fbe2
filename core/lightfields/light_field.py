"""Light fields: a picture through every part of the pupil, taken once, focused afterwards.

A ray is named by two planes: (s, t), where it meets the film, in pixels of the raster, and (u, v), by where
it comes through the pupil, in radii of the paraxial exit pupil. The pupil is covered by a grid of
square cells, the same for every film point; each cell has a picture of its own, a *view*. A lens of glass passes
parts of some cells only: how much of a cell's light arrives, times cos⁴θ, is its *coverage*, which is known for every
pixel and never guessed.

To focus at another distance is to shear: to first order the ray that meets the new film at x and the pupil at a meets
the old one at k x + σ a (from the two cameras' Gaussian maps), so every view is shifted by σ a and all are added up.
(Ng et al. 2005 for the shear, Ng 2005 for the slice of the spectrum.)
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.ideal_lens import Gaussian
from lensbench.cameras.real_lens import LensCamera
from lensbench.imaging.film import Film
from lensbench.lightfields.refocus_kernel import rescaled, shift_and_add, spectral_gain
from lensbench.optics.focus import nearest_focus

SHARE = 16              # cells are cut into SHARE² to find how much of one a round aperture takes
CLEAR = 1.0             # pixels that neighbouring views may lie apart before the blur between them falls into dots
SPREAD = np.array([0.7548776662466927, 0.5698402909980532])        # 1/ρ and 1/ρ² of ρ³ = ρ + 1: multiples fill a square
NEAR = 24               # part of the picture's sides that counts as its centre


class LightFieldError(ValueError):
    """A light field that cannot be; the message says what to do."""


def light_field_bytes(film: Film, views: tuple[int, int] = (9, 9), dtype=np.float16, moments: int = 1) -> int:
    """What a light field of so many views across and down will take: three colours and the coverage of every pixel.

    And three colours more for each of the moments, where there are several.
    """
    numbers = 4 + (3 * moments if moments > 1 else 0)
    return views[0] * views[1] * film.pixels_x * film.pixels_y * numbers * np.dtype(dtype).itemsize


@dataclass(frozen=True, eq=False)
class LightField:
    """What `capture_light_field` recorded.

    light: (views down, views across, 3, h, w), linear radiance times coverage; coverage: (down, across, h, w); both
    float16 or float32. A view's place (u, v): x to the right and y up in the pupil. reach: the grid's
    half side, in radii of the paraxial exit pupil. fill: the part of a pixel's side over which each
    view's samples lie, about its middle. aside: (down, across, 2) by what part of a pixel each view's grid lies aside,
    to the right and down; None: as `spread_offsets` has it. moments: (n, down, across, 3, h, w) the light of equal
    parts of the exposure one after the other, whose mean `light` is; None where they were not kept apart.
    """

    camera: Camera
    reach: float
    light: np.ndarray
    coverage: np.ndarray
    fill: float = 1.0
    aside: np.ndarray | None = None
    moments: np.ndarray | None = None

    @cached_property
    def instants(self) -> "tuple[LightField, ...]":
        """The light field of each moment that was kept apart; itself alone where none were."""
        if self.moments is None:
            return (self,)
        return tuple(replace(self, light=light, moments=None) for light in self.moments)

    @property
    def views(self) -> tuple[int, int]:
        """Across and down."""
        return self.light.shape[1], self.light.shape[0]

    @property
    def places(self) -> np.ndarray:
        """(down, across, 2) the cells' middles in the pupil, in its radii; the first row is the lowest."""
        across, down = self.views
        u = ((np.arange(across) + 0.5) / across * 2.0 - 1.0) * self.reach
        v = ((np.arange(down) + 0.5) / down * 2.0 - 1.0) * self.reach
        return np.stack(np.meshgrid(u, v), -1)

    @cached_property
    def offsets(self) -> np.ndarray:
        """(down, across, 2) `aside`, told."""
        return spread_offsets(*self.views) if self.aside is None else self.aside

    def view(self, across: int, down: int) -> np.ndarray:
        """One view: float32 (h, w, 3), the radiance where light came; 0 where the cell passes none."""
        covered = self.coverage[down, across].astype(np.float32)
        light = self.light[down, across].astype(np.float32)
        radiance = np.divide(light, covered, np.zeros_like(light), where=covered > 0.0)
        return np.ascontiguousarray(radiance.transpose(1, 2, 0))

    def refocus(self, distance: float, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)):
        """The picture focused at another distance: float32 (h, w, 3), linear, its weights relative.

        distance: mm, measured as the camera that captured measures its own; one that is out of `nearest` is taken for
        that. f_number: None is the whole recorded aperture; a round part of it otherwise, about `view`, in radii of the
        pupil. LightFieldError for an aperture that was not recorded.
        """
        used, weights, shifts, step, scale = self._shifts_and_weights(distance, f_number, view)
        begins = shifts + (1.0 - scale) * (self._middle - 0.5)
        return shift_and_add(self.light, used, begins, scale, weights, step, self.fill,
                             1.0 / self._white(used, weights))

    def slice(self, distance: float, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)):
        """The same picture by way of the light field's spectrum, of which it is a plane slice: slow, and a check.

        Each frequency of the picture is the sum of the views' spectra with the phases of their shifts, which is the
        spectrum over (u, v, s, t) where fu = σ fs and fv = σ ft. Beyond a view's edge its other edge follows.
        """
        used, weights, shifts, step, scale = self._shifts_and_weights(distance, f_number, view)
        h, w = self.light.shape[3:]
        across, down = np.fft.rfftfreq(w), np.fft.fftfreq(h)
        total = np.zeros((3, h, len(across)), complex)
        for (j, i), weight, (x, y) in zip(used, weights, shifts, strict=True):
            phase = np.exp(2j * math.pi * x * across) * np.exp(2j * math.pi * y * down)[:, None]
            total += weight * phase * np.fft.rfft2(self.light[j, i].astype(np.float32))
        total *= (spectral_gain(across, step[0], self.fill) * spectral_gain(down, step[1], self.fill)[:, None]
                  / self._white(used, weights))
        picture = np.fft.irfft2(total, (h, w)).astype(np.float32)
        picture = picture if scale == 1.0 else rescaled(picture, scale, self._middle)
        return np.ascontiguousarray(picture.transpose(1, 2, 0))

    def _shifts_and_weights(self, distance: float, f_number: float | None, view: tuple[float, float]):
        """Which views (n, 2) an aperture takes, their weights, their shifts and that across a cell (pixels), and k."""
        shares = self.shares(f_number, view)
        scale, shear = self.shear(max(distance, self.nearest))
        taken = (shares > 0.0) & self._lit
        taken = taken if taken.any() else shares > 0.0
        used = np.argwhere(taken)
        return used, shares[taken], self.shifts(shear)[used[:, 0], used[:, 1]], self._step(shear), scale

    def shifts(self, shear: float) -> np.ndarray:
        """(down, across, 2) by how many pixels each view is read aside for this σ, to the right and down."""
        return shear * self.places * self._pixels - self.offsets

    def _step(self, shear: float) -> np.ndarray:
        """Pixels across and down that lie between neighbouring views."""
        return 2.0 * self.reach * shear * self._pixels / self.views

    def stacked(self, shear: float) -> np.ndarray:
        """(h, w, 3) float32 the sum of all views read aside for this σ, in the picture's recorded scale."""
        used = np.argwhere(self._lit)
        return shift_and_add(self.light, used, self.shifts(shear)[self._lit], 1.0, np.ones(len(used)),
                             self._step(shear), self.fill)

    @cached_property
    def _pixels(self) -> np.ndarray:
        """Pixels to the right and down for each mm of the film, whose x runs to the left."""
        across, _, down, _ = self.camera.film_step.parameters
        return np.array([-1.0 / across, 1.0 / down])

    @cached_property
    def _middle(self) -> np.ndarray:
        """Where the axis meets the film, in raster pixels across and down."""
        across, middle, down, low = self.camera.film_step.parameters
        return np.array([middle / across, low / down])

    def _white(self, used: np.ndarray, weights: np.ndarray) -> float:
        """What these views add up to where the film's centre sees nothing but radiance 1."""
        return max(float(self._on_axis[used[:, 0], used[:, 1]] @ weights), 1e-30)

    def shear(self, distance: float) -> tuple[float, float]:
        """(k, σ): the ray by the pupil's a and the film's x at this focus met the recording film at k x + σ a, mm."""
        there = replace(self.camera, focus_distance=distance)          # type: ignore[call-arg]
        before, after = self.camera.gaussian, there.gaussian
        return _shear(before, after)

    def shares(self, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """(down, across) how much of each cell an aperture takes, 0 … 1. LightFieldError: as `refocus`."""
        if not all(map(math.isfinite, view)):
            raise LightFieldError("a view is two finite numbers, in radii of the pupil")
        if f_number is None and tuple(view) == (0.0, 0.0):
            return np.ones(self.places.shape[:2])
        off = math.hypot(*view)
        if f_number is None:
            radius = max(1.0 - off, 0.0)
        elif not (math.isfinite(f_number) and f_number > 0.0):
            raise LightFieldError(f"f-number {f_number:g}: it must be a positive number")
        elif f_number < self.f_number * (1.0 - 1e-9):
            raise LightFieldError(f"f/{f_number:g} was not recorded: this light field was captured at "
                                  f"f/{self.f_number:.3g}")
        else:
            radius = self.f_number / f_number
        if off + radius > self.reach * math.sqrt(2.0) + 1e-9:
            raise LightFieldError(f"an aperture about ({view[0]:g}, {view[1]:g}) leaves what was recorded: the pupil "
                                  f"reaches from −1 to 1, and this aperture's radius is {radius:.3g}")
        size = 2.0 * self.reach / np.array(self.views)
        fine = (np.arange(SHARE) + 0.5) / SHARE - 0.5
        x = (self.places[..., 0, None] + fine * size[0] - view[0])[..., None, :]
        y = (self.places[..., 1, None] + fine * size[1] - view[1])[..., :, None]
        shares = (x**2 + y**2 <= radius**2).mean((-2, -1))
        if not shares.any():                    # smaller than a part of a cell: the cell it lies in, alone
            nearest = np.argmin(((self.places - view) ** 2).sum(-1))
            shares.flat[nearest] = 1.0
        return shares

    @cached_property
    def f_number(self) -> float:
        """Of the recorded aperture, as the camera counts it."""
        if isinstance(self.camera, LensCamera):
            return self.camera.first_order.f_number
        return 0.5 / abs(self.camera.gaussian.approach_pupil)

    @cached_property
    def nearest(self) -> float:
        """The nearest distance that can be focused (mm)."""
        return nearest_focus(self.camera.lens) if isinstance(self.camera, LensCamera) else 1e-3

    def apart(self, distance: float) -> float:
        """How far neighbouring views lie from each other when focused at a distance, in pixels."""
        film, (across, down) = self.camera.film, self.views
        shear = abs(self.shear(distance)[1]) * 2.0 * self.reach
        return max(shear / across * film.pixels_x / film.width, shear / down * film.pixels_y / film.height)

    @cached_property
    def clear_range(self) -> tuple[float, float]:
        """Nearest and farthest focus (mm) at which neighbouring views lie at most CLEAR pixels apart.

        What is farther away than that from the recorded focus is blurred into dots rather than disks where it
        should be sharp, for each view is then sharper than the step to the next.
        """
        return self._limit(self.nearest), self._limit(math.inf)

    def _limit(self, end: float) -> float:
        """The distance between the recorded focus and this end where views are CLEAR pixels apart, or the end."""
        if self.apart(end) <= CLEAR:
            return end
        inner, outer = 1.0 / self.camera.focus_distance, 1.0 / end     # type: ignore[attr-defined]
        for _ in range(60):
            middle = 0.5 * (inner + outer)
            inner, outer = (middle, outer) if self.apart(1.0 / middle) <= CLEAR else (inner, middle)
        return 1.0 / inner

    @cached_property
    def _lit(self) -> np.ndarray:
        """(down, across) which cells pass any light."""
        return np.asarray(self.coverage.any((2, 3)))

    @cached_property
    def _on_axis(self) -> np.ndarray:
        """(down, across) coverage of the cells seen from about the film's centre."""
        return middle_of(self.coverage)


def middle_of(coverage: np.ndarray) -> np.ndarray:
    """The mean about the film's centre of coverages (…, h, w)."""
    h, w = coverage.shape[-2:]
    y, x = max(h // NEAR, 1), max(w // NEAR, 1)
    near = coverage[..., (h - y) // 2:(h + y + 1) // 2, (w - x) // 2:(w + x + 1) // 2]
    return np.asarray(near.astype(float).mean((-2, -1)))


def spread_offsets(across: int, down: int) -> np.ndarray:
    """(down, across, 2) by what part of a pixel each view's grid lies aside, evenly spread over [−½, ½)²."""
    k = np.arange(across * down)[:, None]
    return ((k * SPREAD + 0.5) % 1.0 - 0.5).reshape(down, across, 2)


def _shear(before: Gaussian, after: Gaussian) -> tuple[float, float]:
    """(k, σ) of `LightField.shear` from the two maps of film and pupil to rays."""
    def rays(lens: Gaussian, z: float) -> np.ndarray:
        away = lens.z - z
        return np.array([[lens.origin_film + away * lens.slope_film, lens.origin_pupil + away * lens.slope_pupil],
                         [lens.slope_film, lens.slope_pupil]])

    (a, b), (c, d) = np.linalg.solve(rays(before, before.z), rays(after, before.z))
    scale = float(a - b * c / d)
    return 1.0 if abs(scale - 1.0) < 1e-9 else scale, float(b / d)

