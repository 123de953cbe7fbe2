"""Lumigraphs: pictures by an array of pinholes in one plane, from which views from other places are put together.

The pinholes stand on the plane (u, v), in mm, x to the right and y up; each of them sees the same window of
the plane (s, t) before them, whose pixels are the same for all but for a part of one. A ray is named by where it meets
both planes. What a new view sees along it is interpolated linearly between the four nearest pinholes, and in each by
cubics between its pixels: straight lines would blur. Where the ray's surface is at a depth z, and (s, t) at D, the
pinhole at u sees it not at s but at s + (u₀ − u)(D/z − 1), by similar triangles: with depths known, neighbours agree,
and nothing is seen double.
(Levoy and Hanrahan 1996; Gortler, Grzeszczuk, Szeliski and Cohen 1996 for the depths.)
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.cameras.camera import Camera
from lensbench.cameras.perspective import PerspectiveCamera
from lensbench.capture import TOP, checked_views
from lensbench.halves import half_float
from lensbench.lightfield import LightFieldError, spread_offsets
from lensbench.render import depth_map, render
from lensbench.scene import Scene
from lensbench.spaces import transformed, window_of

PARTS = 2.0             # steps along a ray for each pixel by which its picture moves
MOST_STEPS = 1024
MOST_RAYS = 8           # of a pixel, across and down
GHOST = 0.5             # pixels by which neighbours may disagree before one of them is said to be hidden
NOTHING, MIDDLE = np.zeros((1, 1, 1, 1), np.float32), np.zeros((1, 1, 2))
TOWARDS = 1e-6          # the least cosine of a ray with the way to the (s, t) plane


class NovelView(NamedTuple):
    """What a camera sees by a lumigraph."""

    picture: np.ndarray         # float32 (h, w, 3), linear; 0 where nothing was recorded
    covered: np.ndarray         # (h, w) bool: which pixels were recorded


@dataclass(frozen=True, eq=False)
class Lumigraph:
    """What `capture_lumigraph` recorded.

    camera: the pinhole in the array's middle. spacing: mm between neighbours, distance: mm to the plane (s, t).
    pictures: (down, across, 3, h, w) float16, linear radiance, the lowest row of pinholes first; nearness: (down,
    across, h, w) float16, 1 / depth before the pinholes' plane, 1/m, 0 where only sky is seen.
    """

    camera: PerspectiveCamera
    spacing: float
    distance: float
    pictures: np.ndarray
    nearness: np.ndarray

    @property
    def views(self) -> tuple[int, int]:
        """Pinholes across and down."""
        return self.pictures.shape[1], self.pictures.shape[0]

    @property
    def places(self) -> np.ndarray:
        """(down, across, 2) mm from the middle, where the pinholes stand."""
        across, down = self.views
        return np.stack(np.meshgrid(self.spacing * (np.arange(across) - 0.5 * (across - 1)),
                                    self.spacing * (np.arange(down) - 0.5 * (down - 1))), -1)

    @cached_property
    def offsets(self) -> np.ndarray:
        """(down, across, 2) by what part of a pixel each pinhole's grid lies aside, to the right and down."""
        return spread_offsets(*self.views)

    @cached_property
    def raster(self) -> np.ndarray:
        """Of the plane (s, t): mm a pixel across and down, then the pixels where the axis meets it."""
        across, middle, down, low = self.camera.film_step.parameters
        scale = self.distance / self.camera.film_distance
        return np.array([across * scale, down * scale, middle / across, low / down])

    def seen_by(self, camera: Camera, surface="recorded") -> NovelView:
        """What a camera anywhere sees through the middle of its pupil: a ray for each pixel, or each that was recorded.

        surface: where things are taken to be. "recorded": where each pinhole saw them; None: all on
        the plane (s, t), no depth correction; a number: on a plane at this distance from the pinholes (mm); an array
        (h, w): at these depths (mm, inf is sky), as the middle of the array sees them. A ray is covered
        where it comes through the array, points to what its pinholes saw, and the light on it was free to go on to
        them: a camera behind the array, or before it with nothing between. LightFieldError for another surface,
        CameraError for a camera that is not projective.
        """
        h, w = camera.film.pixels_y, camera.film.pixels_x
        many = self._rays(camera)
        y, x = ((np.arange(size * many) + 0.5) / many for size in (h, w))
        points = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
        rays = camera.generate_rays(points, np.broadcast_to(camera.pupil_centre, points.shape), 0.5)
        planes, begins = self._planes(rays.origins, rays.directions)
        planes[~(rays.weights > 0.0)] = math.nan
        near = self._nearness(surface)
        picture, covered = np.zeros((len(planes), 3), np.float32), np.zeros(len(planes), np.bool_)
        threads = os.cpu_count() or 1
        ends = np.linspace(0, len(planes), threads + 1).astype(int)

        def see(k: int) -> None:
            here = slice(ends[k], ends[k + 1])
            ratio = self._ratio(planes[here], begins[here], surface, near)
            known = near if near is not None and near.ndim == 4 else NOTHING
            _blend(planes[here], ratio, self.pictures.view(np.uint16), known, self._array, self.offsets, self.raster,
                   picture[here], covered[here])

        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(see, range(threads)))
        whole = np.asarray(covered.reshape(h, many, w, many).all((1, 3)))
        mean = picture.reshape(h, many, w, many, 3).mean((1, 3))
        return NovelView(np.where(whole[..., None], mean, np.float32(0)), whole)

    def _rays(self, camera: Camera) -> int:
        """How many rays for each pixel, across and down: where its pixels are coarser than those recorded."""
        def pixel(one: Camera) -> float:
            return abs(one.gaussian.slope_film) * one.film_step.parameters[0]

        return min(max(round(pixel(camera) / pixel(self.camera)), 1), MOST_RAYS)

    def _ratio(self, planes: np.ndarray, begins: np.ndarray, surface, near: np.ndarray | None) -> np.ndarray:
        """D / depth of what rays meet, (n,)."""
        if near is None:
            return np.full(len(planes), 1.0 if surface is None else self.distance / float(surface))
        own = near.ndim == 4
        tables = near if own else near[None, None]
        places, offsets = (self._array, self.offsets) if own else (np.array([0.0, 0.0, self.spacing]), MIDDLE)
        ratio = np.empty(len(planes))
        _meet(planes, begins, tables, places, offsets, self.raster, float(tables.max()), float(tables.min()), ratio)
        return ratio

    @property
    def _array(self) -> np.ndarray:
        """The first pinhole's place (2), and the spacing; mm."""
        return np.array([*self.places[0, 0], self.spacing])

    def _planes(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of rays of the world: (n, 4) u, v, s, t in mm, NaN for those that never meet both planes; where they begin.

        The beginnings (n,) as D / depth before the pinholes, inf behind them.
        """
        back = np.linalg.inv(self.camera.placement())
        o, d = transformed(back, origins), directions @ back[:3, :3].T
        d = d / np.linalg.norm(d, axis=1)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = d[:, :2] / np.where(d[:, 2] < -TOWARDS, -d[:, 2], math.nan)[:, None]
            uv = o[:, :2] + o[:, 2:] * slope
            begins = np.where(o[:, 2] < 0.0, -self.distance / o[:, 2], math.inf)
        return np.concatenate([uv, uv + self.distance * slope], 1), begins

    def _nearness(self, surface) -> np.ndarray | None:
        """D / depth of every pixel of every pinhole, or of the middle's; None for a plane."""
        if isinstance(surface, str):
            if surface != "recorded":
                raise LightFieldError(f"surface {surface!r}: a distance, depths of the middle's pixels, or recorded")
            return self.nearness.astype(np.float32) * np.float32(1e-3 * self.distance)
        if surface is None or np.ndim(surface) == 0:
            if surface is not None and not float(surface) > 0.0:
                raise LightFieldError(f"a surface at {float(surface):g} mm: its distance must be positive")
            return None
        depths = np.asarray(surface, np.float32)
        if depths.shape != self.pictures.shape[3:] or not (depths > 0.0).all():
            h, w = self.pictures.shape[3:]
            raise LightFieldError(f"depths of the shape {depths.shape}: they must be {h} × {w} positive numbers")
        return np.float32(self.distance) / depths


def lumigraph_pinhole(camera: Camera) -> PerspectiveCamera:
    """The pinhole that sees what a perspective camera does, from the middle of its pupil; with the camera's shutter.

    LightFieldError for cameras that move, or have no one place that all their film points look through; CameraError
    for those that are not projective.
    """
    lens, film = camera.gaussian, camera.film
    if camera.moves:
        raise LightFieldError("the camera moves: hold it still to record an array about it")
    if lens.slope_film == 0.0 or camera.has_port:
        raise LightFieldError("a lumigraph is recorded by pinholes in air: this camera looks through no one place")
    place = camera.placement() @ np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0],
                                           [0.0, 0.0, 1.0, lens.z + lens.origin_film / lens.slope_film],
                                           [0.0, 0.0, 0.0, 1.0]])
    fov = 2.0 * math.atan(0.5 * min(film.width, film.height) * abs(lens.slope_film))
    return PerspectiveCamera(film, fov, window=camera.window or window_of(film), world_from_camera=place,
                             shutter_open=camera.shutter_open, shutter_close=camera.shutter_close,
                             shutter_ramp=camera.shutter_ramp, readout=camera.readout,
                             readout_direction=camera.readout_direction, medium=camera.medium)


def array_camera(middle: PerspectiveCamera, place, distance: float, aside=(0.0, 0.0)) -> PerspectiveCamera:
    """The pinhole at a place (2, mm) of the array about `middle`, its window shifted to the same of (s, t).

    aside: but for so many pixels to the right and down.
    """
    half = distance * math.tan(middle.fov / 2.0)
    x, y = -place[0] / half, -place[1] / half
    left, right, bottom, top = middle.window or window_of(middle.film)
    x += aside[0] * (right - left) / middle.film.pixels_x
    y -= aside[1] * (top - bottom) / middle.film.pixels_y
    moved = np.eye(4)
    moved[:2, 3] = place
    window = (left + x, right + x, bottom + y, top + y)
    return replace(middle, world_from_camera=middle.placement() @ moved, window=window)


def capture_lumigraph(camera: Camera, scene: Scene, views: tuple[int, int] = (9, 9), spacing: float = 5.0,
                      distance: float | None = None, samples: int = 16, seed: int = 0,
                      told: Callable[[float], bool] = lambda share: True) -> Lumigraph:
    """Record pictures and depths by an array of pinholes about the middle of a camera's pupil.

    spacing: mm between neighbours; distance: mm from them to the plane (s, t) that they all see the same window
    of, by default where the camera is focused. samples: for each pixel of each. told: as of `capture_light_field`.
    LightFieldError for numbers that cannot be, more memory than there is, and a capture that was given up.
    """
    middle = lumigraph_pinhole(camera)
    if distance is None:
        eye = np.linalg.inv(camera.placement()) @ middle.placement()
        distance = getattr(camera, "focus_distance", math.inf) + float(eye[2, 3])
    if not (math.isfinite(spacing) and spacing > 0.0):
        raise LightFieldError(f"{spacing:g} mm between the pinholes: it must be a positive number")
    if not (math.isfinite(distance) and distance > 0.0):
        raise LightFieldError(f"a plane at {distance:g} mm: the pinholes need one at a finite distance before them")
    across, down = checked_views(camera.film, views, samples, np.float16)
    h, w = camera.film.pixels_y, camera.film.pixels_x
    blank = np.zeros((down, across, 3, h, w), np.float16)
    made = Lumigraph(middle, spacing, distance, blank, np.zeros((down, across, h, w), np.float16))
    for number, (j, i) in enumerate(np.ndindex(down, across), 1):
        one = array_camera(middle, made.places[j, i], distance, made.offsets[j, i])
        made.pictures[j, i] = np.minimum(render(one, scene, samples, seed + number), TOP).transpose(2, 0, 1)
        made.nearness[j, i] = 1e3 / depth_map(one, scene)
        if not told(number / (across * down)):
            raise LightFieldError("the capture was given up")
    return made


@njit(inline="always")
def _pixel(near, j, i, s, t, offsets, raster):
    """D / depth of the pixel of a pinhole that (s, t) lies in; NaN beside its picture."""
    x = math.floor(s / raster[0] + raster[2] - offsets[j, i, 0])
    y = math.floor(raster[3] - t / raster[1] - offsets[j, i, 1])
    if not (0 <= x < near.shape[3] and 0 <= y < near.shape[2]):
        return math.nan
    return near[j, i, int(y), int(x)]


@njit(nogil=True, cache=True, error_model="numpy")
def _meet(planes, begins, near, array, offsets, raster, most, least, out):
    """D / depth where rays meet what the pinhole nearest to each has seen; at the last depth where they never do.

    Along a ray from near to far, as far as it moves by 1 / PARTS of a pixel in the pinhole's picture: it has met the
    surface where it comes to lie behind it, but not where the surface comes before it all at once.
    """
    down, across = near.shape[0], near.shape[1]
    for k in range(len(planes)):
        u, v, s, t = planes[k]
        if not (math.isfinite(u) and math.isfinite(s)):
            out[k] = 1.0
            continue
        i = int(min(max(math.floor((u - array[0]) / array[2] + 0.5), 0), across - 1))
        j = int(min(max(math.floor((v - array[1]) / array[2] + 0.5), 0), down - 1))
        du, dv = u - (array[0] + i * array[2]), v - (array[1] + j * array[2])
        high = min(most, begins[k]) * 1.001
        moves = max(abs(du) / raster[0], abs(dv) / raster[1]) * (high - least)
        steps = int(min(math.ceil(moves * PARTS), MOST_STEPS)) + 2
        step = (least * 0.999 - high) / steps
        before, found = math.nan, math.nan
        for m in range(steps + 1):
            q = high + m * step
            surface = _pixel(near, j, i, s + du * (q - 1.0), t + dv * (q - 1.0), offsets, raster)
            if surface == surface:
                found = surface
                if q <= surface <= q - 2.0 * step or (before == before and before > 0.0 and q <= surface
                                                      and surface - (q - step) <= GHOST * raster[0] / array[2]):
                    break
            before = q - surface
        out[k] = found if found == found else 1.0


@njit(inline="always")
def _cubic(f, taps):
    """Catmull and Rom's: what the pixels at −1, 0, 1 and 2 count at f in [0, 1)."""
    half, g = np.float32(0.5), np.float32(1) - f
    taps[0], taps[3] = -half * f * g * g, -half * f * f * g
    taps[1] = np.float32(1) + f * f * (np.float32(1.5) * f - np.float32(2.5))
    taps[2] = np.float32(1) + g * g * (np.float32(1.5) * g - np.float32(2.5))


@njit(nogil=True, cache=True, error_model="numpy")
def _blend(planes, ratio, pictures, near, array, offsets, raster, out, covered):
    """Of the four pinholes about each ray those that see its surface, each by cubics between its pixels there."""
    down, across, _, h, w = pictures.shape
    knows = near.shape[3] == w
    ghost = GHOST * raster[0] / array[2]
    sums, part = np.zeros(3, np.float32), np.zeros(3, np.float32)
    across_taps, down_taps = np.zeros(4, np.float32), np.zeros(4, np.float32)
    for k in range(len(planes)):
        a, b = (planes[k, 0] - array[0]) / array[2], (planes[k, 1] - array[1]) / array[2]
        s, t, q = planes[k, 2], planes[k, 3], ratio[k]
        if not (-1e-6 <= a <= across - 1 + 1e-6 and -1e-6 <= b <= down - 1 + 1e-6):
            continue
        left, low = min(max(math.floor(a), 0), max(across - 2, 0)), min(max(math.floor(b), 0), max(down - 2, 0))
        total = 0.0
        sums[:] = 0.0
        # first those that see the surface, by pixels that do; where none does, all
        for hidden_too in (False, True):
            if total > 0.0:
                break
            for corner in range(4):
                i, j = int(left) + corner % 2, int(low) + corner // 2
                if i >= across or j >= down:
                    continue
                weight = (1.0 - abs(a - i)) * (1.0 - abs(b - j))
                if weight <= 1e-6:
                    continue
                ps = s + (a - i) * array[2] * (q - 1.0)
                pt = t + (b - j) * array[2] * (q - 1.0)
                x = ps / raster[0] + raster[2] - 0.5 - offsets[j, i, 0]
                y = raster[3] - pt / raster[1] - 0.5 - offsets[j, i, 1]
                if not (-0.5 <= x <= w - 0.5 and -0.5 <= y <= h - 0.5):
                    continue
                if knows and not hidden_too and _pixel(near, j, i, ps, pt, offsets, raster) > q + ghost:
                    continue
                x0, y0 = int(math.floor(x)), int(math.floor(y))
                _cubic(np.float32(x - x0), across_taps)
                _cubic(np.float32(y - y0), down_taps)
                taken = np.float32(0)
                part[:] = 0.0
                for m in range(4):
                    row = min(max(y0 + m - 1, 0), h - 1)
                    for n in range(4):
                        column = min(max(x0 + n - 1, 0), w - 1)
                        if knows and not hidden_too and abs(near[j, i, row, column] - q) > ghost:
                            continue
                        tap = down_taps[m] * across_taps[n]
                        taken += tap
                        for c in range(3):
                            part[c] += tap * half_float(pictures[j, i, c, row, column])
                if taken < np.float32(0.3):
                    continue
                share = np.float32(weight) / taken
                for c in range(3):
                    sums[c] += share * part[c]
                total += weight
        if total > 0.0:
            covered[k] = True
            for c in range(3):
                out[k, c] = sums[c] / np.float32(total)
