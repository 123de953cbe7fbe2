"""Moving the camera by hand: orbit, pan, dolly, and a look from inside a panorama. Lengths in mm, angles in radians."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene
from lensbench.app.settings.settings import Settings

STEEPEST = math.radians(85.0)
FARTHEST = 5000.0               # mm: a farther pivot would make every movement too large
NEAREST = 50.0
CLEARANCE = 10.0                # mm above the floor
BISECTIONS = 30                 # of an orbit that ends at the floor


def pivot_distance(settings: Settings) -> float:
    """Distance (mm) from the camera to the pivot of an orbit: the focus distance, within limits."""
    return min(max(settings.focus_distance, NEAREST), FARTHEST)


def orbited(settings: Settings, left: float, up: float) -> Settings:
    """The camera turned about the pivot to its left and up (radians), above the floor: the scene seems to turn back."""
    settings = at_keyframe(settings)
    turned = _turned(settings, left, up)
    if not _is_above_floor(settings) or _is_above_floor(turned):
        return turned
    free, taken = 0.0, 1.0
    for _ in range(BISECTIONS):
        share = 0.5 * (free + taken)
        free, taken = (share, taken) if _is_above_floor(_turned(settings, share * left, share * up)) else (free, share)
    return _turned(settings, free * left, free * up)


def _turned(settings: Settings, left: float, up: float) -> Settings:
    distance, late = pivot_distance(settings), _late(settings)
    frame, yaw, pitch = _pose(settings)
    pivot = frame[:3, 3] - distance * frame[:3, 2]
    pitch = min(max(pitch - up, -STEEPEST), STEEPEST)
    yaw = math.remainder(yaw - left, 2.0 * math.pi)
    turned = replace(settings, end_yaw=yaw, end_pitch=pitch) if late else replace(settings, yaw=yaw, pitch=pitch)
    return _moved(turned, pivot + distance * _pose(turned)[0][:3, 2])


def panned(settings: Settings, right: float, up: float) -> Settings:
    """The camera moved across the view by these lengths (mm); not below the floor."""
    settings = at_keyframe(settings)
    frame = _pose(settings)[0]
    return _moved(settings, _above_floor(settings, frame[:3, 3] + right * frame[:3, 0] + up * frame[:3, 1]))


def dollied(settings: Settings, forward: float) -> Settings:
    """The camera moved along the view by a length (mm); not below the floor."""
    settings = at_keyframe(settings)
    frame = _pose(settings)[0]
    return _moved(settings, _above_floor(settings, frame[:3, 3] - forward * frame[:3, 2]))


def at_home(settings: Settings) -> Settings:
    """The camera at its default position and direction, without keyframes; lens, film and focus are kept."""
    home = Settings()
    return replace(settings, position=home.position, yaw=home.yaw, pitch=home.pitch, end_position=home.end_position,
                   end_yaw=home.end_yaw, end_pitch=home.end_pitch, moment=home.moment)


def at_keyframe(settings: Settings) -> Settings:
    """The moment at the nearer of two keyframes: the mouse moves the camera only there."""
    if not settings.keyframed:
        return settings
    return replace(settings, moment=settings.duration if _late(settings) else 0.0)


def _late(settings: Settings) -> bool:
    """Whether the second keyframe is the nearer one in time."""
    return settings.keyframed and settings.moment > 0.5 * settings.duration


def _pose(settings: Settings) -> tuple[np.ndarray, float, float]:
    """Pose (4, 4), yaw and pitch (radians) of the nearer keyframe."""
    if settings.end_position is None or not _late(settings):
        return settings.world_from_camera, settings.yaw, settings.pitch
    end = replace(settings, position=settings.end_position, yaw=settings.end_yaw, pitch=settings.end_pitch)
    return end.world_from_camera, end.yaw, end.pitch


def _moved(settings: Settings, position: np.ndarray) -> Settings:
    x, y, z = (float(value) for value in position)
    return replace(settings, end_position=(x, y, z)) if _late(settings) else replace(settings, position=(x, y, z))


def _height(settings: Settings, position: np.ndarray) -> tuple[float, np.ndarray]:
    """Height (mm) of a point over the floor, inf without one, and the floor's unit normal (3,)."""
    try:
        floor = cached_scene(settings.scene).floor
    except (SceneFileError, OSError):           # the worker reports it
        floor = None
    if floor is None:
        return math.inf, np.zeros(3)
    normal = np.asarray(floor.normal, float)
    normal = normal / np.linalg.norm(normal)
    return float(normal @ position) - floor.height, normal


def _is_above_floor(settings: Settings) -> bool:
    return _height(settings, _pose(settings)[0][:3, 3])[0] >= CLEARANCE - 1e-6


def _above_floor(settings: Settings, position: np.ndarray) -> np.ndarray:
    """The position, raised above the floor; as it is for a camera that stands below the floor already."""
    height, normal = _height(settings, position)
    if height >= CLEARANCE or not _is_above_floor(settings):
        return position
    return position + (CLEARANCE - height) * normal


NARROWEST, WIDEST = math.radians(10.0), math.radians(130.0)
STEEPEST_LOOK = math.radians(90.0)


@dataclass(frozen=True)
class LookAround:
    """yaw to the left, pitch up, fov: the angle along the longer side of the view."""

    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = math.radians(90.0)

    def reach(self, size: tuple[float, float]) -> tuple[float, float]:
        """Tangents of half the angles across and down of a view of this size."""
        most = math.tan(0.5 * self.fov) / max(*size, 1e-6)
        return size[0] * most, size[1] * most

    @property
    def axes(self) -> NDArray[np.float64]:
        """Right, up and back of the view as columns (3, 3)."""
        cy, sy, cp, sp = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array([[cy, sy * sp, sy * cp], [0.0, cp, -sp], [-sy, cy * sp, cy * cp]])

    def dragged(self, x: float, y: float, size: tuple[float, float]) -> "LookAround":
        """The look after a drag by x to the right and y down (pixels): what was in the middle goes with the mouse."""
        across, down = self.reach(size)
        yaw = math.remainder(self.yaw + math.atan(2.0 * x * across / max(size[0], 1.0)), 2.0 * math.pi)
        pitch = self.pitch + math.atan(2.0 * y * down / max(size[1], 1.0))
        return replace(self, yaw=yaw, pitch=min(max(pitch, -STEEPEST_LOOK), STEEPEST_LOOK))

    def zoomed(self, steps: float) -> "LookAround":
        """The look after so many clicks of the wheel: narrower for positive ones."""
        return replace(self, fov=min(max(self.fov * 0.92**steps, NARROWEST), WIDEST))

    def raster(self, share: tuple[float, float], size: tuple[float, float], film: lb.Film, layout: str,
               ) -> tuple[float, float]:
        """The raster point of the panorama at a place of the view, in parts of its width and height."""
        across, down = self.reach(size)
        direction = self.axes @ [(2.0 * share[0] - 1.0) * across, (1.0 - 2.0 * share[1]) * down, -1.0]
        (x, y), = lb.EnvironmentCamera(film, layout=layout).film_from_point(direction[None], None)[0]
        return float((0.5 - x / film.width) * film.pixels_x), float((0.5 + y / film.height) * film.pixels_y)
