"""The coordinate spaces of a point on its way to a pixel, and the transforms between neighbours.

    object   frame of an object in the scene, mm
    world    mm
    camera   mm; x right, y up, the camera looks along −z
    screen   the shorter side of the film spans [−1, 1], y up; z is 0 on the near plane and 1 on the far plane
    NDC      [0, 1]², the origin at the top left of the picture; z as on the screen
    raster   pixels, the origin at the top left, pixel centres at +0.5; z as on the screen

Transforms are 4 × 4 matrices named target_from_source, and adjacent names match in a product: raster_from_camera =
raster_from_ndc @ ndc_from_screen @ screen_from_camera. (Shirley and others, Fundamentals of Computer Graphics, ch. 8.)
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from lensbench.core.imaging.film import Film, film_from_raster
from lensbench.core.kernels.block import Step
from lensbench.core.text import significant

Window = tuple[float, float, float, float]
"""Part of the screen that falls on the film: left, right, bottom, top."""


def half_extent(film: Film, axis: str) -> float:
    """Half the film along one of its AXES, in screen units: 1 along its shorter side."""
    return film.extent(axis) / film.extent("shorter")


def film_window(film: Film) -> Window:
    """The window of the whole film: its shorter side spans [−1, 1], whatever the shape of its pixels."""
    x, y = half_extent(film, "horizontal"), half_extent(film, "vertical")
    return -x, x, -y, y


def window_step(film: Film, window: Window) -> Step:
    """The step from raster pixels to a film (mm, camera frame) on which this window falls."""
    left, right, bottom, top = window
    half = min(film.width, film.height) / 2.0
    return Step(film_from_raster, [(right - left) * half / film.pixels_x, -left * half,
                             (top - bottom) * half / film.pixels_y, top * half])


def transform_points(matrix: ArrayLike, points: ArrayLike) -> np.ndarray:
    """Points (…, 3) transformed by one 4 × 4 matrix or by (…, 4, 4), divided by their fourth coordinate."""
    m, p = np.asarray(matrix, float), np.asarray(points, float)[..., None]
    q = m[..., :3, :] @ np.concatenate([p, np.ones_like(p[..., :1, :])], -2)
    return (q / (m[..., 3:, :3] @ p + m[..., 3:, 3:]))[..., 0]


class Intrinsics(NamedTuple):
    """A projective camera in the convention of computer vision: x right, y down, z forward, (u, v) in raster pixels.

    u = fx X / Z + cx, v = fy Y / Z + cy. For an orthographic camera u = fx X + cx, v = fy Y + cy.

    Attributes:
        fx, fy: Focal lengths in pixels; for an orthographic camera pixels per mm.
        cx, cy: Principal point in raster pixels.
    """

    fx: float
    fy: float
    cx: float
    cy: float

    @property
    def matrix(self) -> np.ndarray:
        """K, (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


class Places(NamedTuple):
    """Points of the picture in every space; the point in front of the camera is the one at a distance along the ray.

    Attributes:
        raster: (n, 2) ndarray. Pixels.
        ndc, screen: (n, 2) ndarray. Without z.
        film: (n, 3) ndarray. Point on the film (mm, camera frame).
        camera, world: (n, 3) ndarray. mm; NaN where no light passes.
        object: (n, 3) ndarray. mm; in the world frame if no object is given.
    """

    raster: np.ndarray
    ndc: np.ndarray
    screen: np.ndarray
    film: np.ndarray
    camera: np.ndarray
    world: np.ndarray
    object: np.ndarray


@dataclass(frozen=True, eq=False)
class Spaces:
    """The matrices of a perspective or orthographic camera.

    Source: Shirley and others, Fundamentals of Computer Graphics, ch. 8.

    Args:
        pixels_x, pixels_y: Of the picture.
        window: (float, float, float, float). Left, right, bottom and top of the part of the screen that falls on the
            film.
        scale: Screen units per unit of slope, 1 / tan(fov / 2); for an orthographic camera per mm.
        near, far: Distances of the planes with screen z 0 and 1 from the eye (mm). far may be math.inf for a
            perspective; near may be ≤ 0 for an orthographic camera.
        perspective: Whether it is a perspective.
        eye: z of the centre of projection in the camera frame (mm).
        world_from_camera: (4, 4) ndarray. Pose of the camera.
    Raises:
        ValueError: If 0 < near < far does not hold.
    """

    pixels_x: int
    pixels_y: int
    window: Window
    scale: float
    near: float
    far: float
    perspective: bool = True
    eye: float = 0.0
    world_from_camera: np.ndarray = field(default_factory=lambda: np.eye(4))

    def __post_init__(self) -> None:
        if not self.near < self.far or not math.isfinite(self.near):
            raise ValueError(f"near {significant(self.near)} mm and far {significant(self.far)} mm: the near plane "
                             f"must be the nearer")
        if self.perspective and not self.near > 0.0:
            raise ValueError(f"near {significant(self.near)} mm: a perspective needs its near plane at more than 0 "
                             f"from the eye")
        if not self.perspective and math.isinf(self.far):
            raise ValueError("an orthographic camera needs a far plane at a finite distance")

    @cached_property
    def raster_from_ndc(self) -> np.ndarray:
        """From [0, 1]² to pixels."""
        return np.diag([float(self.pixels_x), float(self.pixels_y), 1.0, 1.0])

    @cached_property
    def ndc_from_raster(self) -> np.ndarray:
        """From pixels to [0, 1]²."""
        return np.diag([1.0 / self.pixels_x, 1.0 / self.pixels_y, 1.0, 1.0])

    @cached_property
    def ndc_from_screen(self) -> np.ndarray:
        """From the window to [0, 1]², with y inverted."""
        left, right, bottom, top = self.window
        across, up = 1.0 / (right - left), 1.0 / (top - bottom)
        return np.array([[across, 0, 0, -left * across], [0, -up, 0, top * up], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    @cached_property
    def screen_from_ndc(self) -> np.ndarray:
        """From [0, 1]² to the window, with y inverted."""
        left, right, bottom, top = self.window
        return np.array([[right - left, 0, 0, left], [0, bottom - top, 0, top], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    @cached_property
    def screen_from_camera(self) -> np.ndarray:
        """The projection from the eye: z = −near becomes 0 and z = −far 1."""
        s, n, f, e = self.scale, self.near, self.far, self.eye
        if self.perspective:
            a = 1.0 / (1.0 - n / f)
            return np.array([[s, 0, 0, 0], [0, s, 0, 0], [0, 0, -a, a * (e - n)], [0, 0, -1, e]])
        return np.array([[s, 0, 0, 0], [0, s, 0, 0], [0, 0, -1 / (f - n), (e - n) / (f - n)], [0, 0, 0, 1.0]])

    @cached_property
    def camera_from_screen(self) -> np.ndarray:
        """The inverse of the projection."""
        s, n, f, e = self.scale, self.near, self.far, self.eye
        if self.perspective:
            a = 1 / f - 1 / n
            return np.array([[1 / s, 0, 0, 0], [0, 1 / s, 0, 0], [0, 0, e * a, e / n - 1], [0, 0, a, 1 / n]])
        return np.array([[1 / s, 0, 0, 0], [0, 1 / s, 0, 0], [0, 0, n - f, e - n], [0, 0, 0, 1.0]])

    @cached_property
    def raster_from_screen(self) -> np.ndarray:
        """From the screen to raster pixels."""
        return self.raster_from_ndc @ self.ndc_from_screen

    @cached_property
    def screen_from_raster(self) -> np.ndarray:
        """From raster pixels to the screen."""
        return self.screen_from_ndc @ self.ndc_from_raster

    @cached_property
    def raster_from_camera(self) -> np.ndarray:
        """From the camera frame to raster pixels."""
        return self.raster_from_screen @ self.screen_from_camera

    @cached_property
    def camera_from_raster(self) -> np.ndarray:
        """From raster pixels to the camera frame; raster z = 0 lies on the near plane."""
        return self.camera_from_screen @ self.screen_from_raster

    @cached_property
    def camera_from_world(self) -> np.ndarray:
        """The inverse of the camera's pose."""
        return np.linalg.inv(self.world_from_camera)

    @cached_property
    def raster_from_world(self) -> np.ndarray:
        """From the world frame to raster pixels."""
        return self.raster_from_camera @ self.camera_from_world

    @cached_property
    def world_from_raster(self) -> np.ndarray:
        """From raster pixels to the world frame."""
        return self.world_from_camera @ self.camera_from_raster


def depth_resolution(depth: ArrayLike, near: float, far: float, dtype: DTypeLike = np.float32) -> Any:
    """Smallest step Δz that a depth buffer resolves in a perspective.

    It is one unit in the last place of z = f (1 − n / d) / (f − n), over its slope f n / ((f − n) d²).

    Args:
        depth: float or array_like. d, distance from the eye along the axis (mm).
        near, far: n and f, distances of the planes (mm); far may be math.inf.
        dtype: dtype. Floating-point type of the buffer.
    Returns:
        float or ndarray. Steps in mm.
    Raises:
        ValueError: If 0 < near < far or near ≤ depth ≤ far does not hold.
    """
    d = np.asarray(depth, float)
    if not (0.0 < near < far and np.all((near <= d) & (d <= far))):
        raise ValueError(f"near {significant(near)} mm and far {significant(far)} mm: they must be positive, with "
                         f"every depth between them")
    squeeze = 1.0 / (1.0 - near / far)
    stored = (squeeze * (1.0 - near / d)).astype(dtype)
    step = np.spacing(stored).astype(float) * d * d / (squeeze * near)
    return step if np.ndim(depth) else float(step)
