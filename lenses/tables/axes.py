"""Places of surfaces along axes that break: decentres and tilts of a design file as poses of the surfaces of a lens.

A file places surfaces along a local axis, which decentres and tilts move; a lens has one axis, and poses. Lengths are
in the unit of the file, angles in radians.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, cos, sin

import numpy as np

from lensbench.core.optics.lens_surface import PoseError, SurfacePose, tilts_of
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant

ROUNDING = 1e-9         # of places over their size, and of directions
FARTHEST = 1e6          # units of the file: a decentre is known to a thousandth of one there


class AxesError(ValueError):
    """Axes that no lens with poses has; the message says which surface, and why.

    index: of the surface; the number of surfaces for the image.
    """

    def __init__(self, index: int, message: str):
        super().__init__(message)
        self.index = index


@dataclass(frozen=True, eq=False)
class Break:
    """A decentre and a tilt (3, 3) of the axis, then a way along it.

    tilt_first: the decentre is along the new axes. line: of the file, from 1. number: of the break, by which the
    configurations of the file name it.
    """

    decentre: tuple[float, float, float]
    axes: np.ndarray
    tilt_first: bool = False
    distance: float = 0.0
    line: int | None = None
    number: int = -1


@dataclass(frozen=True, eq=False)
class Place:
    """Where a surface of a file stands: its vertex (3,), and its axes (3, 3), in columns, in those of the object."""

    vertex: np.ndarray
    axes: np.ndarray

    def broken(self, by: Break) -> "Place":
        """The place after a break."""
        turned = self.axes @ by.axes
        way = (turned if by.tilt_first else self.axes) @ np.array(by.decentre)
        return Place(self.vertex + way, turned).along(by.distance)

    def along(self, distance: float) -> "Place":
        """The place further along its axis."""
        return Place(self.vertex + distance * self.axes[:, 2], self.axes)


START = Place(np.zeros(3), np.eye(3))


def intrinsic(about_x: float, about_y: float, about_z: float = 0.0) -> np.ndarray:
    """Axes (3, 3), in columns, after right-handed rotations about x, then the new y, then the new z."""
    ca, sa, cb, sb, cc, sc = (f(angle) for angle in (about_x, about_y, about_z) for f in (cos, sin))
    about = ([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]], [[cb, 0.0, sb], [0.0, 1.0, 0.0], [-sb, 0.0, cb]],
             [[cc, -sc, 0.0], [sc, cc, 0.0], [0.0, 0.0, 1.0]])
    x, y, z = map(np.array, about)
    axes: np.ndarray = x @ y @ z
    return axes


def angles(axes: np.ndarray) -> tuple[float, float, float]:
    """The three rotations of `intrinsic`, radians."""
    return (atan2(-axes[1, 2], axes[2, 2]), asin(max(-1.0, min(1.0, float(axes[0, 2])))),
            atan2(-axes[0, 1], axes[0, 0]))


def in_one_line(frames: Sequence[Place], image: Place, round_: Sequence[bool]) -> tuple[
        float, list[float], list[SurfacePose | None]]:
    """Z of the first vertex on the axis, thicknesses and poses of surfaces in these frames, the image behind them.

    round_: whether each surface is rotationally symmetric, so that a roll changes nothing: it has the one of a cylinder
    or toroid of its body, else none. A body is a run of surfaces with one direction of the axis and one roll, each on
    the axis of the first: it pivots about the first vertex. AxesError for a tilted or decentred image, and tilts that
    no pose has.
    """
    sizes = [float(np.abs(frame.vertex).max()) for frame in (*frames, image)]
    size, whole = max(1e-30, *sizes[:-1]), max(1e-30, *sizes)       # the image may lie at infinity
    if size > FARTHEST:
        i = next(i for i, distance in enumerate(sizes) if distance > FARTHEST)
        raise AxesError(i, f"surface {i} stands {significant(sizes[i])} units of the file from the first: its decentre "
                           "is lost in the rounding of such a number")
    heights: list[float] = []
    poses: list[SurfacePose | None] = []
    body = -1                                           # first surface of the body
    rolls = _rolls(frames, round_, size)
    for i, frame in enumerate(frames):
        straight = np.abs(frame.axes[:, 2] - [0.0, 0.0, 1.0]).max() < ROUNDING
        centred = np.abs(frame.vertex[:2]).max() < ROUNDING * size
        if straight and centred and not rolls[i]:
            heights.append(float(frame.vertex[2]))
            poses.append(None)
            body = -1
            continue
        if body >= 0 and not (_on_axis(frame, frames[body], size) and rolls[i] == rolls[body]):
            body = -1
        body = i if body < 0 else body
        on_axis = float((frame.vertex - frames[body].vertex) @ frames[body].axes[:, 2])
        origin = frames[body].vertex
        if not frames[body].axes[2, 2] > 0.0:
            raise AxesError(i, f"surface {i} is tilted by 90° or more")
        try:
            poses.append(SurfacePose(float(origin[0]), float(origin[1]), *tilts_of(frames[body].axes)[:2], i - body,
                                     rolls[i]))
        except PoseError as error:
            raise AxesError(i, f"surface {i}: {error}") from None
        heights.append(float(origin[2] + on_axis))
    if np.abs(image.axes[:, 2] - [0.0, 0.0, 1.0]).max() > ROUNDING or np.abs(image.vertex[:2]).max() > ROUNDING * whole:
        raise AxesError(len(frames), "the axis does not return to its line before the image: a tilted film is a "
                                     "setting of the camera (lb.FilmPose), and not part of a lens")
    ends = [*heights[1:], float(image.vertex[2])]
    return heights[0], [end - start for start, end in zip(heights, ends, strict=True)], poses


def alike(poses: Sequence[SurfacePose | None], others: Sequence[SurfacePose | None]) -> bool:
    """Whether the poses of surfaces are the same but for rounding."""
    def numbers(pose: SurfacePose | None) -> np.ndarray:
        return np.zeros(6) if pose is None else np.array([pose.decentre_x, pose.decentre_y, pose.tilt_x, pose.tilt_y,
                                                          pose.pivot, pose.roll])

    one, two = (np.array([numbers(pose) for pose in group]) for group in (poses, others))
    return bool(np.abs(one - two).max(initial=0.0) <= 1e2 * ROUNDING * max(1.0, np.abs(one[:, :2]).max(initial=0.0)))


def _on_axis(frame: Place, first: Place, size: float) -> bool:
    """Whether a frame lies on the axis of another one, with the same direction of the axis."""
    way, axis = frame.vertex - first.vertex, first.axes[:, 2]
    return bool(np.abs(way - (way @ axis) * axis).max() <= ROUNDING * size
                and np.abs(frame.axes[:, 2] - axis).max() <= ROUNDING)


def _rolls(frames: Sequence[Place], round_: Sequence[bool], size: float) -> list[float]:
    """The roll of each surface (radians): its own, or of a round one that of a neighbour which is none, on one axis."""
    own = [tilts_of(frame.axes)[2] for frame in frames]
    own = [0.0 if abs(roll) <= ROUNDING else roll for roll in own]
    rolls, first = [0.0] * len(frames), 0
    for i, frame in enumerate(frames):
        if i and not (_on_axis(frame, frames[first], size) and abs(own[i] - own[first]) <= ROUNDING):
            first = i
        if not round_[i]:
            end = next((k for k in range(i, len(frames)) if not (
                _on_axis(frames[k], frames[first], size) and abs(own[k] - own[first]) <= ROUNDING)), len(frames))
            rolls[first:end] = [own[first]] * (end - first)
    return rolls


def axes_at(lens: Lens, i: int) -> np.ndarray:
    """Axes (3, 3), in columns, of surface i."""
    frame = lens.frames[i]
    return np.eye(3) if frame is None else frame.rotation


def body(lens: Lens, i: int) -> tuple[int, int] | None:
    """First and last of the surfaces that move as one with surface i; None if it is centred."""
    frame = lens.frames[i]
    if frame is None:
        return None
    first = last = i
    while first > 0 and lens.frames[first - 1] is frame:
        first -= 1
    while last + 1 < len(lens.surfaces) and lens.frames[last + 1] is frame:
        last += 1
    return first, last


def lead(lens: Lens, i: int) -> float:
    """Distance (mm) of the vertex of surface i behind its centred position, if the surface begins a body; else 0."""
    moved = body(lens, i) if i < len(lens.surfaces) else None
    return float(lens.vertex(i)[2]) - lens.vertices[i] if moved and moved[0] == i else 0.0


def gap_on_axes(lens: Lens, i: int) -> float:
    """Way (mm) behind surface i along its own axis; behind the last of a body back to its first vertex."""
    moved = body(lens, i)
    if moved and moved[1] == i:
        return lens.vertices[moved[0]] - lens.vertices[i]
    return lens.surfaces[i].thickness + lead(lens, i + 1)
