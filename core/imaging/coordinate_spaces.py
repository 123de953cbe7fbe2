"""The spaces that a point goes through on its way to a pixel, and the transforms between neighbours.

object   of a thing in the scene, its own frame, mm
world    mm
camera   mm; x right, y up, the camera looks along −z
screen   the shorter side of the film spans [−1, 1], y up; z is 0 on the near plane and 1 on the far plane
NDC      [0, 1]², the origin at the top left of the picture; z as on the screen
raster   pixels, the origin at the top left, pixel centres at +0.5; z as on the screen

Transforms are 4 × 4 matrices named target_from_source, and adjacent names match in
a product: raster_from_camera = raster_from_ndc @ ndc_from_screen @ screen_from_camera. (Shirley and others,
Fundamentals of Computer Graphics, ch. 8, for the matrices; frames as in the project's design.)
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lensbench.imaging.film import Film, film_from_raster
from lensbench.kernels.block import Step

Window = tuple[float, float, float, float]
"""What of the screen falls on the film: left, right, bottom, top."""


def half_extent(film: Film, axis: str) -> float:
    """Half the film along one of its AXES, on the screen: 1 along its shorter side."""
    return film.extent(axis) / film.extent("shorter")


def film_window(film: Film) -> Window:
    """The window that the whole film is: its shorter side spans [−1, 1], whatever the shape of its pixels."""
    x, y = half_extent(film, "horizontal"), half_extent(film, "vertical")
    return -x, x, -y, y


def window_step(film: Film, window: Window) -> Step:
    """The step from raster pixels to the film (mm), imagined so that this window falls on it."""
    left, right, bottom, top = window
    half = min(film.width, film.height) / 2.0
    return Step(film_from_raster, [(right - left) * half / film.pixels_x, -left * half,
                             (top - bottom) * half / film.pixels_y, top * half])


def transform_points(matrix, points) -> np.ndarray:
    """Points (…, 3) carried by one 4 × 4 matrix or by (…, 4, 4), divided by their fourth coordinate."""
    m, p = np.asarray(matrix, float), np.asarray(points, float)[..., None]
    q = m[..., :3, :] @ np.concatenate([p, np.ones_like(p[..., :1, :])], -2)
    return (q / (m[..., 3:, :3] @ p + m[..., 3:, 3:]))[..., 0]


class Intrinsics(NamedTuple):
    """What a projective camera is to computer vision: x right, y down, z forward, (u, v) in raster pixels.

    u = fx X / Z + cx, v = fy Y / Z + cy; of an orthographic camera u = fx X + cx, v = fy Y + cy, with fx and fy in
    pixels per mm.
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
    """One point of the picture in every space; what lies before the camera is the point at a distance along its ray."""

    raster: np.ndarray          # (n, 2) pixels
    ndc: np.ndarray             # (n, 2)
    screen: np.ndarray          # (n, 2)
    film: np.ndarray            # (n, 3) mm, camera frame: where the picture of it falls
    camera: np.ndarray          # (n, 3) mm; NaN where the camera is dark
    world: np.ndarray           # (n, 3) mm
    object: np.ndarray          # (n, 3) mm; that of the world, where no object is named


@dataclass(frozen=True, eq=False)
class Spaces:
    """The matrices of a perspective or orthographic camera.

    scale: screen units per unit of slope, which is 1 / tan(fov / 2), or with perspective=False per mm.
    near, far: distances of the planes that the screen's z tells, mm from the eye; of a perspective far may be math.inf.
    eye: z of the centre of projection in the camera's frame (mm).
    ValueError where 0 < near < far does not hold (an orthographic camera may have near ≤ 0).
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

    def __post_init__(self):
        if not self.near < self.far or not math.isfinite(self.near):
            raise ValueError(f"near {self.near:g} mm and far {self.far:g} mm: the near plane must be the nearer")
        if self.perspective and not self.near > 0.0:
            raise ValueError(f"near {self.near:g} mm: a perspective needs its near plane at more than 0 from the eye")
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
        """The window becomes [0, 1]², and y turns over."""
        left, right, bottom, top = self.window
        across, up = 1.0 / (right - left), 1.0 / (top - bottom)
        return np.array([[across, 0, 0, -left * across], [0, -up, 0, top * up], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    @cached_property
    def screen_from_ndc(self) -> np.ndarray:
        """[0, 1]² becomes the window, and y turns over."""
        left, right, bottom, top = self.window
        return np.array([[right - left, 0, 0, left], [0, bottom - top, 0, top], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    @cached_property
    def screen_from_camera(self) -> np.ndarray:
        """The projection: from the eye, z = −near becomes 0 and z = −far 1."""
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
        """By NDC."""
        return self.raster_from_ndc @ self.ndc_from_screen

    @cached_property
    def screen_from_raster(self) -> np.ndarray:
        """By NDC."""
        return self.screen_from_ndc @ self.ndc_from_raster

    @cached_property
    def raster_from_camera(self) -> np.ndarray:
        """By screen and NDC."""
        return self.raster_from_screen @ self.screen_from_camera

    @cached_property
    def camera_from_raster(self) -> np.ndarray:
        """By NDC and screen; raster z = 0 lies on the near plane."""
        return self.camera_from_screen @ self.screen_from_raster

    @cached_property
    def camera_from_world(self) -> np.ndarray:
        """The inverse of where the camera stands."""
        return np.linalg.inv(self.world_from_camera)

    @cached_property
    def raster_from_world(self) -> np.ndarray:
        """By camera, screen and NDC."""
        return self.raster_from_camera @ self.camera_from_world

    @cached_property
    def world_from_raster(self) -> np.ndarray:
        """By NDC, screen and camera."""
        return self.world_from_camera @ self.camera_from_raster


def depth_resolution(depth, near: float, far: float, dtype=np.float32):
    """The smallest step Δz (mm) that a depth buffer of this type can tell at `depth` (mm), in a perspective near … far.

    One unit in the last place of the screen's z = f (1 − n / d) / (f − n), over its slope f n / ((f − n) d²). A float
    for a float, an array for an array; far may be math.inf. ValueError where 0 < near < far or near ≤ depth ≤ far
    does not hold.
    """
    d = np.asarray(depth, float)
    if not (0.0 < near < far and np.all((near <= d) & (d <= far))):
        raise ValueError(f"near {near:g} mm and far {far:g} mm: they must be positive, with every depth between them")
    squeeze = 1.0 / (1.0 - near / far)
    stored = (squeeze * (1.0 - near / d)).astype(dtype)
    step = np.spacing(stored).astype(float) * d * d / (squeeze * near)
    return step if np.ndim(depth) else float(step)
