"""Light fields: a picture through every part of the pupil, taken once, focused afterwards.

A ray is named by two points: (s, t), where it meets the film, in raster pixels, and (u, v), where it comes through the
pupil, in radii of the paraxial exit pupil. A grid of square cells, the same for every film point, covers the pupil;
each cell has a picture of its own, a *view*. The *coverage* is the share of a cell's light that arrives, times cos⁴θ,
for every pixel.

Refocusing is shift-and-add: to first order the ray that meets the new film at x and the pupil at a meets the old film
at k x + σ a (from the two cameras' Gaussian maps), so every view is shifted by σ a, and all are added.

References:
    Ng, Levoy, Brédif, Duval, Horowitz and Hanrahan, "Light field photography with a hand-held plenoptic camera", 2005:
    shift-and-add. Ng, "Fourier slice photography", 2005: the slice of the spectrum.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.lightfields.refocus_kernel import reached, recorded_share, rescaled, shift_and_add, spectral_gain
from lensbench.core.text import significant

SUBCELLS = 16           # across and down a cell, to find the share of the cell that a round aperture takes
CLEAR = 1.0             # pixels between neighbouring views, above which blur separates into dots
SPREAD = np.array([0.7548776662466927, 0.5698402909980532])        # 1/ρ and 1/ρ², ρ³ = ρ + 1: multiples fill a square
FINER = 2               # recorded pixels for one of the picture, across and down
CENTRE_PART = 24        # the picture's sides over those of its centre, where coverage is averaged


# Views (n, 2) of an aperture, weights (n,), shifts or first places (n, 2), shift across a cell (2,), scale
_Reading = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]


class LightFieldError(ValueError):
    """An invalid light field; the message says what to do."""


def require_focus(camera: Camera) -> None:
    """LightFieldError for a camera that does not focus, such as a hole of finite size."""
    if getattr(camera, "focus_distance", None) is None:
        raise LightFieldError("this camera has no lens that focuses: record a light field through a lens")


def require_film_in_line(camera: Camera) -> None:
    """LightFieldError for a camera whose film is tilted, shifted or curved."""
    if not camera.film_pose.is_upright:
        raise LightFieldError("light fields are recorded on a flat, centred film: set tilt, swing, rise and shift to "
                              "0, and leave out the curvature")


@dataclass(frozen=True, eq=False)
class LightField:
    """A light field, from `capture_light_field` or `RawPicture.decoded`.

    Args:
        camera: The camera that captured.
        reach: Half side of the grid of cells, in radii of the paraxial exit pupil.
        light: (views down, views across, 3, h, w) float16 or float32: linear radiance × coverage. The first row of
            views is the lowest in the pupil, the first row of pixels the top.
        coverage: (views down, views across, h, w), of the same type: share of a cell's light that arrives, times cos⁴θ.
        fill: Side of the part of a pixel that a view's samples fill, about the pixel's middle; pixels.
        aside: (views down, views across, 2) offset of each view's pixel grid, to the right and down; pixels. None:
            those of `spread_offsets`.
        moments: (n, views down, views across, 3, h, w) light of equal parts of the exposure in turn, whose mean is
            `light`; None: not kept apart.
        wide: The same light with finer pixels and a margin about the picture, which `refocus` sums; None: only these
            pixels.
        margined: The same with that margin and pixels of this size, whose middle `light` is; None without `wide`.
    Raises:
        LightFieldError: For a camera that does not focus.
    """

    camera: Camera
    reach: float
    light: np.ndarray
    coverage: np.ndarray
    fill: float = 1.0
    aside: np.ndarray | None = None
    moments: np.ndarray | None = None
    wide: "LightField | None" = None
    margined: "LightField | None" = None

    def __post_init__(self) -> None:
        require_focus(self.camera)

    @cached_property
    def instants(self) -> "tuple[LightField, ...]":
        """The light field of each moment; where none were kept apart, only itself."""
        if self.moments is None:
            return (self,)
        wide, margined = ((None,) * len(self.moments) if field is None else field.instants
                          for field in (self.wide, self.margined))
        return tuple(replace(self, light=light, moments=None, wide=finer, margined=wider)
                     for light, finer, wider in zip(self.moments, wide, margined, strict=True))

    @property
    def nbytes(self) -> int:
        """Memory in bytes."""
        if self.wide is not None and self.margined is not None:
            return self.wide.nbytes + self.margined.nbytes
        return sum(a.nbytes for a in (self.light, self.coverage, self.moments) if a is not None)

    @property
    def views(self) -> tuple[int, int]:
        """Number of views across and down."""
        return self.light.shape[1], self.light.shape[0]

    @property
    def places(self) -> np.ndarray:
        """(views down, views across, 2) middles of the cells in radii of the pupil; the first row is the lowest."""
        across, down = self.views
        u = ((np.arange(across) + 0.5) / across * 2.0 - 1.0) * self.reach
        v = ((np.arange(down) + 0.5) / down * 2.0 - 1.0) * self.reach
        return np.stack(np.meshgrid(u, v), -1)

    @cached_property
    def offsets(self) -> np.ndarray:
        """(views down, views across, 2) offset of each view's pixel grid, to the right and down; pixels."""
        return spread_offsets(*self.views) if self.aside is None else self.aside

    def view(self, across: int, down: int) -> np.ndarray:
        """The picture through one cell of the pupil, across from the left and down from the lowest row.

        float32 (h, w, 3), linear RGB; 0 where the cell passes no light.
        """
        covered = self.coverage[down, across].astype(np.float32)
        light = self.light[down, across].astype(np.float32)
        radiance = np.divide(light, covered, np.zeros_like(light), where=covered > 0.0)
        return np.ascontiguousarray(radiance.transpose(1, 2, 0))

    def refocus(self, distance: float, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0),
                coarse: bool = False) -> np.ndarray:
        """The picture focused at another distance.

        Args:
            distance: Focus distance in mm, measured as the capturing camera measures its own; below `nearest` it is
                `nearest`.
            f_number: Of a round part of the recorded aperture; None: the whole.
            view: Centre (u, v) of that part, in radii of the pupil, to the right and up.
            coarse: In a quarter of the time, without the finer pixels of a recording.
        Returns:
            ndarray. float32 (h, w, 3), linear RGB, relative weights, nowhere negative. Where only some views saw what a
                pixel needs (`recorded`), it is the mean of these, and black where none did.
        Raises:
            LightFieldError: For an aperture that was not recorded.
        """
        h, w = self.light.shape[3:]
        if coarse and self.margined is not None:
            return _middle_of(self.margined.refocus(distance, f_number, view), h, w)
        if self.wide is not None:
            wide = self.wide.refocus(distance, f_number, view)
            wide = wide[_picture_part(wide.shape[0], h), _picture_part(wide.shape[1], w)]
            wide = wide[::FINER] + wide[1::FINER]                       # far faster than a mean over two axes
            return (wide[:, ::FINER] + wide[:, 1::FINER]) * np.float32(1 / FINER**2)
        used, weights, begins, step, scale = self._reading(distance, f_number, view)
        return shift_and_add(self.light, used, begins, scale, weights, step, self.fill,
                             1.0 / self._white(used, weights))

    def recorded(self, distance: float, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)
                 ) -> np.ndarray:
        """How much of the light that `refocus` asks for was recorded: by distance the margin is too narrow.

        distance, f_number, view: as for `refocus`. float32 (h, w), from 0 to 1: the part of the aperture whose views
        saw what the pixel needs.
        """
        whole = self.wide or self
        _, weights, begins, _, scale = whole._reading(distance, f_number, view)
        beside, inside = reached(begins, scale, *whole.light.shape[3:])
        if self.wide is not None:               # the mean of a product of rows and columns is that of their means
            beside, inside = (line[:, _picture_part(line.shape[1], own)].reshape(-1, own, FINER).mean(-1)
                              for line, own in zip((beside, inside), self.light.shape[3:], strict=True))
        return recorded_share(beside, inside, weights)

    def _reading(self, distance: float, f_number: float | None, view: tuple[float, float]) -> _Reading:
        """`_shifts_and_weights`, with the place in each view (n, 2) that the picture's first pixel reads."""
        used, weights, shifts, step, scale = self._shifts_and_weights(distance, f_number, view)
        return used, weights, shifts + (1.0 - scale) * (self._middle - 0.5), step, scale

    def slice(self, distance: float, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)
              ) -> np.ndarray:
        """The picture of `refocus` as a plane slice of the light field's spectrum: slow, an independent check.

        distance, f_number, view: as for `refocus`. float32 (h, w, 3), linear RGB, relative weights. Each frequency is
        the sum of the views' spectra with the phases of their shifts, the spectrum over (u, v, s, t) where fu = σ fs
        and fv = σ ft (Ng, "Fourier slice photography", 2005). Views repeat beyond their edges.
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

    def _shifts_and_weights(self, distance: float, f_number: float | None, view: tuple[float, float]) -> _Reading:
        """Views (n, 2) of an aperture, weights (n,), shifts (n, 2), the shift across a cell (2,), pixels, and k."""
        shares = self.shares(f_number, view)
        scale, shear = self.shear(max(distance, self.nearest))
        taken = (shares > 0.0) & self._lit
        taken = taken if taken.any() else shares > 0.0
        used = np.argwhere(taken)
        return used, shares[taken], self.shifts(shear)[used[:, 0], used[:, 1]], self._step(shear), scale

    def shifts(self, shear: float) -> np.ndarray:
        """Shifts (views down, views across, 2) of all views for a shear σ (mm): pixels to the right and down, with
        their offsets.
        """
        return shear * self.places * self._pixels - self.offsets

    def _step(self, shear: float) -> np.ndarray:
        """Shift between neighbouring views, pixels across and down."""
        return 2.0 * self.reach * shear * self._pixels / self.views

    def stacked(self, shear: float) -> np.ndarray:
        """The sum of all views shifted by a shear σ (mm): float32 (h, w, 3), light × number of views, in the recorded
        scale.
        """
        if self.margined is not None:
            return _middle_of(self.margined.stacked(shear), *self.light.shape[3:])
        used = np.argwhere(self._lit)
        return shift_and_add(self.light, used, self.shifts(shear)[self._lit], 1.0, np.ones(len(used)),
                             self._step(shear), self.fill)

    @cached_property
    def _pixels(self) -> np.ndarray:
        """Pixels per mm of film, to the right and down; the film's x runs to the left."""
        across, _, down, _ = self.camera.film_step.parameters
        return np.array([-1.0 / across, 1.0 / down])

    @cached_property
    def _middle(self) -> np.ndarray:
        """Where the axis meets the film, in raster pixels across and down."""
        across, middle, down, low = self.camera.film_step.parameters
        return np.array([middle / across, low / down])

    def _white(self, used: np.ndarray, weights: np.ndarray) -> float:
        """The sum of these views on the axis where it sees radiance 1 everywhere."""
        return max(float(self._on_axis[used[:, 0], used[:, 1]] @ weights), 1e-30)

    def shear(self, distance: float) -> tuple[float, float]:
        """Scale and shear (k, σ) of a focus distance (mm), measured as the camera measures its own.

        The ray by a in the pupil to the film point x (mm) at this focus met the recording film at k x + σ a (mm).
        """
        return _shear(self.camera.gaussian, self.camera.refocused(distance).gaussian)

    def shares(self, f_number: float | None = None, view: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """Share of each cell that an aperture takes, (views down, views across), from 0 to 1; f_number, view as for
        `refocus`.

        LightFieldError for an aperture that was not recorded.
        """
        if not all(map(math.isfinite, view)):
            raise LightFieldError("a view is two finite numbers, in radii of the pupil")
        if f_number is None and tuple(view) == (0.0, 0.0):
            return np.ones(self.places.shape[:2])
        off = math.hypot(*view)
        if f_number is None:
            radius = max(1.0 - off, 0.0)
        elif not (math.isfinite(f_number) and f_number > 0.0):
            raise LightFieldError(f"f-number {significant(f_number)}: it must be a positive number")
        elif f_number < self.f_number * (1.0 - 1e-9):
            raise LightFieldError(f"f/{significant(f_number)} was not recorded: this light field was captured at "
                                  f"f/{significant(self.f_number, 3)}")
        else:
            radius = self.pupil_f_number / f_number
        if off + radius > self.reach * math.sqrt(2.0) + 1e-9:
            raise LightFieldError(f"an aperture about ({significant(view[0])}, {significant(view[1])}) leaves what was "
                                  f"recorded: the pupil "
                                  f"reaches from −1 to 1, and this aperture's radius is {significant(radius, 3)}")
        size = 2.0 * self.reach / np.array(self.views)
        fine = (np.arange(SUBCELLS) + 0.5) / SUBCELLS - 0.5
        x = (self.places[..., 0, None] + fine * size[0] - view[0])[..., None, :]
        y = (self.places[..., 1, None] + fine * size[1] - view[1])[..., :, None]
        shares = (x**2 + y**2 <= radius**2).mean((-2, -1))
        if not shares.any():                    # smaller than a subcell: take the cell that contains it
            nearest = np.argmin(((self.places - view) ** 2).sum(-1))
            shares.flat[nearest] = 1.0
        return shares

    @cached_property
    def f_number(self) -> float:
        """F-number of the recorded aperture, that of a circle of as much area for blades."""
        return self.camera.geometric_f_number

    @cached_property
    def pupil_f_number(self) -> float:
        """F-number of a round aperture of the recorded pupil's radius, lower than `f_number` behind blades."""
        return self.f_number * self.camera.gaussian.iris.equivalent_radius

    @cached_property
    def nearest(self) -> float:
        """Nearest focus distance, mm."""
        return self.camera.nearest_focus

    def apart(self, distance: float) -> float:
        """Shift between neighbouring views at a focus distance (mm), in pixels of the axis on which it is larger."""
        return float(np.abs(self._step(self.shear(distance)[1])).max())

    @cached_property
    def clear_range(self) -> tuple[float, float]:
        """Nearest and farthest focus distance (mm) at which neighbouring views are at most CLEAR pixels apart.

        Beyond this range the shift between views is larger than the blur of a view, so that what should be
        sharp appears as a grid of dots.
        """
        return self._limit(self.nearest), self._limit(math.inf)

    def _limit(self, end: float) -> float:
        """Focus distance between the recorded one and this end where views are CLEAR pixels apart, or the end."""
        if self.apart(end) <= CLEAR:
            return end
        inner, outer = 1.0 / self.camera.focus_distance, 1.0 / end     # type: ignore[attr-defined]
        for _ in range(60):
            middle = 0.5 * (inner + outer)
            inner, outer = (middle, outer) if self.apart(1.0 / middle) <= CLEAR else (inner, middle)
        return 1.0 / inner

    @cached_property
    def _lit(self) -> np.ndarray:
        """(views down, views across) whether a cell passes any light."""
        return np.asarray(self.coverage.any((2, 3)))

    @cached_property
    def _on_axis(self) -> np.ndarray:
        """(views down, views across) coverage on the axis."""
        fine = (np.stack(np.meshgrid(*2 * [np.arange(SUBCELLS) + 0.5]), -1).reshape(-1, 2) / SUBCELLS - 0.5)
        return axis_coverage(self.camera, self.coverage,
                             self.places[:, :, None] + fine * (2.0 * self.reach / np.array(self.views)))


def _picture_part(size: int, own: int) -> slice:
    """Of `size` pixels of the wide recording in a row, those of the picture's `own`."""
    first = (size - FINER * own) // 2
    return slice(first, first + FINER * own)


def _middle_of(picture: np.ndarray, h: int, w: int) -> np.ndarray:
    """The middle (h, w, 3) of a picture with a margin."""
    y, x = (picture.shape[0] - h) // 2, (picture.shape[1] - w) // 2
    return np.ascontiguousarray(picture[y:y + h, x:x + w])


def centre_coverage(coverage: np.ndarray) -> np.ndarray:
    """Mean near the film's centre of coverages (…, h, w)."""
    h, w = coverage.shape[-2:]
    y, x = max(h // CENTRE_PART, 1), max(w // CENTRE_PART, 1)
    near = coverage[..., (h - y) // 2:(h + y + 1) // 2, (w - x) // 2:(w + x + 1) // 2]
    return np.asarray(near.astype(float).mean((-2, -1)))


def axis_coverage(camera: Camera, coverage: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Coverages (…) on the axis, from those (…, h, w) of the film: means near its centre, times the ratio of their
    cos⁴θ.

    A window may put the centre off the axis. places: (…, n, 2) where light comes through the pupil, in its radii.
    """
    near = centre_coverage(coverage)
    if camera.window is None:
        return near
    (across, middle, down, low), lens = camera.film_step.parameters, camera.gaussian
    centre = np.array([middle - 0.5 * camera.film.pixels_x * across, 0.5 * camera.film.pixels_y * down - low])
    lit = (places**2).sum(-1) <= 1.0
    of_axis, of_centre = (((1.0 + ((lens.approach_film * film + lens.approach_pupil * places) ** 2).sum(-1)) ** -2.0
                           * lit).sum(-1) for film in (0.0, centre))
    return near * np.divide(of_axis, of_centre, np.ones_like(of_axis), where=of_centre > 0.0)


def spread_offsets(across: int, down: int) -> np.ndarray:
    """(down, across, 2) offsets of the views' pixel grids, evenly spread over [−½, ½)² pixels."""
    k = np.arange(across * down)[:, None]
    return ((k * SPREAD + 0.5) % 1.0 - 0.5).reshape(down, across, 2)


def _shear(before: Gaussian, after: Gaussian) -> tuple[float, float]:
    """(k, σ) of `LightField.shear`, from the maps of film and pupil to rays before and after."""
    def rays(lens: Gaussian, z: float) -> np.ndarray:
        away = lens.z - z
        return np.array([[lens.origin_film + away * lens.slope_film, lens.origin_pupil + away * lens.slope_pupil],
                         [lens.slope_film, lens.slope_pupil]])

    (a, b), (c, d) = np.linalg.solve(rays(before, before.z), rays(after, before.z))
    scale = float(a - b * c / d)
    return 1.0 if abs(scale - 1.0) < 1e-9 else scale, float(b / d)

