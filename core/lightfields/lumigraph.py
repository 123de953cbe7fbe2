"""Lumigraphs: pictures by an array of pinholes in one plane, from which novel views are put together.

The pinholes lie on the plane (u, v), in mm, x to the right and y up; each sees the same window of the plane (s, t)
before them, its grid of pixels shifted by a part of a pixel. A novel view interpolates linearly between the four
nearest pinholes, and by cubics between the pixels of each. Where the surface is at a depth z, and (s, t) at D, the
pinhole at u sees it at s + (u₀ − u)(D/z − 1), by similar triangles: with known depths, neighbours agree, and nothing is
seen double.

References:
    Levoy and Hanrahan, "Light field rendering", 1996. Gortler, Grzeszczuk, Szeliski and Cohen, "The Lumigraph", 1996:
    the correction by depth.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_cameras import PerspectiveCamera
from lensbench.core.imaging.coordinate_spaces import film_window, transform_points
from lensbench.core.kernels.arrays import as_bits, scale_of
from lensbench.core.lightfields.capture import HIGHEST, checked_views
from lensbench.core.lightfields.light_field import LightFieldError, require_film_in_line, spread_offsets
from lensbench.core.lightfields.novel_view_kernel import Pinholes, Surface, render_rows
from lensbench.core.rendering.aovs import depth_map
from lensbench.core.rendering.progressive import Rendering
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import significant

MOST_RAYS = 8           # per pixel, across and down
BAND = 16               # rows of a picture that a thread takes at a time
NOTHING, NO_RAYS, MIDDLE = np.zeros(0, np.float32), np.zeros((0, 6)), np.zeros((1, 1, 2))


class NovelView(NamedTuple):
    """Picture of a lumigraph from another camera, from `Lumigraph.seen_by`.

    Args:
        picture: (h, w, 3) array. float32, linear red, green and blue; 0 where nothing was recorded.
        covered: (h, w) array of bool. Whether the pixel was recorded.
    """

    picture: np.ndarray
    covered: np.ndarray


@dataclass(frozen=True, eq=False)
class Lumigraph:
    """Pictures and depths by an array of pinholes, from `capture_lumigraph`.

    Args:
        camera: The pinhole in the array's middle.
        spacing: Distance between neighbouring pinholes, mm.
        distance: Distance from the pinholes to the plane (s, t), mm.
        texels: (down, across, h, w, 4) float16, the lowest row of pinholes first, the top row of pixels first: linear
            RGB, radiance × cos⁴θ from the array's axis, and nearness, 1 / depth (1/m) before the pinholes' plane, 0
            where only sky is seen.
    """

    camera: PerspectiveCamera
    spacing: float
    distance: float
    texels: np.ndarray

    @property
    def views(self) -> tuple[int, int]:
        """Number of pinholes across and down."""
        return self.texels.shape[1], self.texels.shape[0]

    @property
    def pictures(self) -> np.ndarray:
        """(down, across, 3, h, w) light of the texels."""
        return self.texels[..., :3].transpose(0, 1, 4, 2, 3)

    @property
    def nearness(self) -> np.ndarray:
        """(down, across, h, w) nearness of the texels, 1/m."""
        return self.texels[..., 3]

    @property
    def places(self) -> np.ndarray:
        """(down, across, 2) places of the pinholes from the array's middle, to the right and up; mm."""
        across, down = self.views
        return np.stack(np.meshgrid(self.spacing * (np.arange(across) - 0.5 * (across - 1)),
                                    self.spacing * (np.arange(down) - 0.5 * (down - 1))), -1)

    @cached_property
    def offsets(self) -> np.ndarray:
        """(down, across, 2) offset of each pinhole's pixel grid, to the right and down; pixels."""
        return spread_offsets(*self.views)

    @cached_property
    def raster(self) -> np.ndarray:
        """(4,) of the plane (s, t): mm per pixel across and down, then the raster point where the axis meets it."""
        across, middle, down, low = self.camera.film_step.parameters
        scale = self.distance / self.camera.film_distance
        return np.array([across * scale, down * scale, middle / across, low / down])

    def seen_by(self, camera: Camera, surface: Any = "recorded") -> NovelView:
        """Picture that a camera at any position sees through the middle of its pupil (Gortler and others 1996).

        A ray is covered where it crosses the array, points to what the array's pinholes saw, and its light was free
        to reach them: the camera lies behind the array, or before the array with nothing between. A pixel takes one
        ray, or several where it is coarser than those recorded. Its light falls off as cos⁴θ on the film's side of the
        camera's own axis, and not at all with weights="radiance".

        Args:
            camera: A projective camera; its world_from_camera places it relative to the array.
            surface: Surface of the scene. "recorded": the depths that each pinhole recorded; None: the plane (s, t),
                without correction by depth; a number: a plane at this distance from the pinholes, mm; an array (h, w):
                the depth for each pixel of the array's middle, mm, inf for sky.
        Raises:
            LightFieldError: For any other surface.
            CameraError: For a camera that is not projective.
        """
        h, w = camera.film.pixels_y, camera.film.pixels_x
        side, own = self._rays(camera), isinstance(surface, str)
        known, by = self._surface(surface)
        lines = self._lines(camera)
        traced = NO_RAYS if lines is not None else self._traced(camera, side)
        falloff = self._falloff(camera, lines)
        lines = np.zeros((6, 3)) if lines is None else lines
        picture, covered = np.zeros((h, w, 3), np.float32), np.zeros((h, w), np.bool_)
        texels = as_bits(self.texels).reshape(-1)

        def see(first: int) -> None:
            render_rows(lines, traced, side, self._pinholes, texels, by, known, own, picture, covered, first,
                 min(first + BAND, h))

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(see, range(0, h, BAND)))
        picture *= np.where(covered, falloff, np.float32(0.0))[..., None]
        return NovelView(picture, covered)

    def _falloff(self, camera: Camera, lines: np.ndarray | None) -> np.ndarray:
        """(h, w) float32 cos⁴θ of a camera's pixels over that with which the array recorded their rays; lines: of
        `_lines`.
        """
        h, w = camera.film.pixels_y, camera.film.pixels_x
        x, y = np.arange(w) + 0.5, np.arange(h)[:, None] + 0.5
        ways = (self._traced(camera, 1)[:, 3:].T.reshape(3, h, w) if lines is None else
                [a * x + b * y + c for a, b, c in lines[3:]])
        across, middle, down, low = camera.film_step.parameters
        film_x, film_y, film_z = middle - x * across, y * down - low, 0.0
        if not camera.film_pose.is_upright:
            film_x, film_y, film_z = np.moveaxis(
                camera.film_pose.points(np.stack(np.broadcast_arrays(film_x, film_y), -1)), -1, 0)
        slope = 0.0 if camera.weights == "radiance" else camera.gaussian.approach_film
        slope = slope / (1.0 - slope * film_z)
        own = 1.0 + (slope * film_x) ** 2 + (slope * film_y) ** 2       # 1 / cos²θ
        with np.errstate(divide="ignore", invalid="ignore"):
            recorded = 1.0 + (ways[0] / ways[2]) ** 2 + (ways[1] / ways[2]) ** 2
        return ((recorded / own) ** 2).astype(np.float32)

    def _rays(self, camera: Camera) -> int:
        """Rays per pixel, across and down: several where the camera's pixels are coarser than those recorded."""
        def pixel(one: Camera) -> float:
            return abs(one.gaussian.slope_film) * one.film_step.parameters[0]

        return min(max(round(pixel(camera) / pixel(self.camera)), 1), MOST_RAYS)

    def _lines(self, camera: Camera) -> np.ndarray | None:
        """(6, 3) origins and directions, in the array's frame, of rays linear in the raster's x, y and 1; None if they
        are not.
        """
        lens = camera.gaussian
        if camera.moves or camera.has_port or camera.follows_rays or not camera.film_pose.is_upright:
            return None
        across, middle, down, low = camera.film_step.parameters
        film = np.array([[-across, 0.0, middle], [0.0, down, -low]])
        ahead = np.array([[0.0, 0.0, 1.0]])
        there = np.linalg.inv(self.camera.placement()) @ camera.placement()
        origins = there[:3, :3] @ np.concatenate([lens.origin_film * film, lens.z * ahead]) + there[:3, 3:] * ahead
        return np.concatenate([origins, there[:3, :3] @ np.concatenate([lens.slope_film * film, -ahead])])

    def _traced(self, camera: Camera, side: int) -> np.ndarray:
        """(n, 6) origins and directions of side² rays per pixel, in the array's frame; NaN for blocked rays."""
        y, x = ((np.arange(size * side) + 0.5) / side for size in (camera.film.pixels_y, camera.film.pixels_x))
        points = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
        rays = camera.with_open_stop.generate_rays(points, np.broadcast_to(camera.pupil_centre, points.shape), 0.5)
        array_from_world = np.linalg.inv(self.camera.placement())
        local_rays = np.concatenate([transform_points(array_from_world, rays.origins),
                                     rays.directions @ array_from_world[:3, :3].T], 1)
        local_rays[~(rays.weights > 0.0)] = math.nan
        return local_rays

    @cached_property
    def _pinholes(self) -> Pinholes:
        """The array, for the kernels."""
        return Pinholes.of(self.places[0, 0], self.spacing, self.raster, self.distance, self.offsets, self._pixels)

    @cached_property
    def _own(self) -> Surface:
        """The depths that each pinhole recorded, for the kernels."""
        bits, scale = as_bits(self.texels), 1e-3 * self.distance
        ends = np.array([bits[..., 3].max(), bits[..., 3].min()]).view(np.float16)      # half floats order as integers
        nearest, farthest = (scale * ends.astype(float)).tolist()
        return Surface(bits.reshape(-1), 4, 3, scale * float(scale_of(bits)), nearest, farthest)

    @property
    def _pixels(self) -> tuple[int, int]:
        """Pixels of a pinhole's picture across and down."""
        return self.texels.shape[3], self.texels.shape[2]

    def _surface(self, surface: Any) -> tuple[Surface, Pinholes]:
        """The surface of the scene, and the pinholes whose pixels describe it; see `seen_by`."""
        if isinstance(surface, str):
            if surface != "recorded":
                raise LightFieldError(f"surface {surface!r}: a distance, depths of the middle's pixels, or recorded")
            return self._own, self._pinholes
        if surface is None or np.ndim(surface) == 0:
            if surface is not None and not float(surface) > 0.0:
                raise LightFieldError(f"a surface at {significant(float(surface))} mm: its distance must be positive")
            flat = 1.0 if surface is None else self.distance / float(surface)
            return Surface(NOTHING, 1, 0, 1.0, flat, flat), self._pinholes
        depths = np.asarray(surface, np.float32)
        if depths.shape != self.texels.shape[2:4] or not (depths > 0.0).all():
            h, w = self.texels.shape[2:4]
            raise LightFieldError(f"depths of the shape {depths.shape}: they must be {h} × {w} positive numbers")
        near = np.float32(self.distance) / depths
        middle = Pinholes.of((0.0, 0.0), self.spacing, self.raster, self.distance, MIDDLE, self._pixels)
        return Surface(near.reshape(-1), 1, 0, 1.0, float(near.max()), float(near.min())), middle


def lumigraph_pinhole(camera: Camera) -> PerspectiveCamera:
    """The pinhole that sees what a camera sees, from the middle of the camera's pupil, with the camera's shutter.

    Args:
        camera: A projective camera that does not move.
    Returns:
        With the lens radius 0.
    Raises:
        LightFieldError: For cameras that move, look through a flat window into water, have no one point of view, or a
            tilted, shifted or curved film.
        CameraError: For a camera that is not projective.
    """
    lens, film = camera.gaussian, camera.film
    require_film_in_line(camera)
    if camera.moves:
        raise LightFieldError("the camera moves while the shutter is open, so that its array has no single position: "
                              "hold it still, or record a light field by the lens")
    if camera.has_port:
        raise LightFieldError("through a flat window into water no pinhole sees straight, so that views cannot be put "
                              "together: record the array in air, or a light field by the lens")
    if lens.slope_film == 0.0:
        raise LightFieldError("a lumigraph is recorded by pinholes: this camera does not look through a single point")
    pose = camera.placement() @ np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0],
                                           [0.0, 0.0, 1.0, lens.z + lens.origin_film / lens.slope_film],
                                           [0.0, 0.0, 0.0, 1.0]])
    fov = 2.0 * math.atan(0.5 * min(film.width, film.height) * abs(lens.slope_film))
    return PerspectiveCamera(film, fov, window=camera.window or film_window(film), world_from_camera=pose,
                             shutter_open=camera.shutter_open, shutter_close=camera.shutter_close,
                             shutter_ramp=camera.shutter_ramp, readout=camera.readout,
                             readout_direction=camera.readout_direction, medium=camera.medium)


def array_camera(middle: PerspectiveCamera, place: Any, distance: float, aside: Any = (0.0, 0.0)) -> PerspectiveCamera:
    """A pinhole of an array, its window shifted so that all pinholes see the same window of the plane (s, t).

    Args:
        middle: The pinhole in the array's middle.
        place: (x, y) in the array, mm, to the right and up.
        distance: Distance to the plane (s, t), mm.
        aside: Offset of the pixel grid, to the right and down; pixels.
    """
    half = distance * math.tan(middle.fov / 2.0)
    x, y = -place[0] / half, -place[1] / half
    left, right, bottom, top = middle.window or film_window(middle.film)
    x += aside[0] * (right - left) / middle.film.pixels_x
    y -= aside[1] * (top - bottom) / middle.film.pixels_y
    moved = np.eye(4)
    moved[:2, 3] = place
    window = (left + x, right + x, bottom + y, top + y)
    return replace(middle, world_from_camera=middle.placement() @ moved, window=window)


def capture_lumigraph(camera: Camera, scene: Scene, views: tuple[int, int] = (9, 9), spacing: float = 5.0,
                      distance: float | None = None, samples: int = 16, seed: int = 0,
                      progress: Callable[[float], bool] = lambda share: True) -> Lumigraph:
    """A lumigraph: pictures and depths by an array of pinholes about the middle of a camera's pupil.

    Source: Levoy and Hanrahan 1996.

    Args:
        camera: A projective camera that does not move; its film is that of each pinhole.
        scene: The scene, world frame, mm.
        views: Pinholes across and down.
        spacing: Distance between neighbouring pinholes, mm.
        distance: Distance from the pinholes to the plane (s, t), mm; None: where the camera is focused.
        samples: Samples per pixel of each pinhole.
        seed: Sampler seed.
        progress: Called with the share done, 0 to 1; return False to cancel.
    Raises:
        LightFieldError: For invalid numbers, cameras that `lumigraph_pinhole` refuses, too little memory, and when
            `progress` cancels.
        CameraError: For a camera that is not projective.
    """
    middle = lumigraph_pinhole(camera)
    if distance is None:
        eye = np.linalg.inv(camera.placement()) @ middle.placement()
        distance = getattr(camera, "focus_distance", math.inf) + float(eye[2, 3])
    if not (math.isfinite(spacing) and spacing > 0.0):
        raise LightFieldError(f"{significant(spacing)} mm between the pinholes: it must be a positive number")
    if not (math.isfinite(distance) and distance > 0.0):
        raise LightFieldError(f"a plane at {significant(distance)} mm: the pinholes need one at a finite distance "
                              f"before them")
    across, down = checked_views(camera.film, views, samples, np.float16)
    h, w = camera.film.pixels_y, camera.film.pixels_x
    made = Lumigraph(middle, spacing, distance, np.zeros((down, across, h, w, 4), np.float16))
    for number, (j, i) in enumerate(np.ndindex(down, across), 1):
        one = array_camera(middle, made.places[j, i], distance, made.offsets[j, i])
        rendering = Rendering(one, scene, seed + number)
        rendering.add(samples)
        made.pictures[j, i] = np.minimum(rendering.image(), HIGHEST).transpose(2, 0, 1)
        made.nearness[j, i] = 1e3 / depth_map(one, scene)
        if not progress(number / (across * down)):
            raise LightFieldError("the capture was cancelled")
    return made
