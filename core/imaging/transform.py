"""Transforms as 4 × 4 matrices, named target_from_source: rigid ones, and those that change with time.

World and camera share handedness and units (mm): x right, y up; the camera looks along −z. Between two matrices the
translation and the symmetric stretch S of the polar decomposition M = R S change linearly with time, and the rotation R
along the shortest arc at constant speed (slerp: Shoemake 1985; polar: Shoemake and Duff 1992). Quaternions are (w, x,
y, z), of length 1. Times in seconds.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import TIME, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.text import significant

RIGID = 1e-6            # tolerance of perpendicular axes of length 1, for matrices from files of few digits

ROTATION, TRANSLATION = 0, 9        # parameters of `transform_rays`


class TransformError(ValueError):
    """A transform that is no valid pose of a camera; the message says why."""


def checked_affine(matrix: ArrayLike) -> np.ndarray:
    """The matrix (4, 4) in float64; TransformError if it is not finite and affine, or is singular or mirrored."""
    m = np.array(matrix, float)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise TransformError("a transform must be a 4 × 4 matrix of finite numbers")
    if not np.array_equal(m[3], [0.0, 0.0, 0.0, 1.0]):
        raise TransformError("the last row of a transform must be 0 0 0 1")
    volume = float(np.linalg.det(m[:3, :3]))
    if abs(volume) < 1e-12:
        raise TransformError("this transform is singular: its axes lie in one plane")
    if volume < 0.0:
        raise TransformError("this transform mirrors: swap or negate one of its axes")
    return m


def checked_rigid(matrix: ArrayLike) -> np.ndarray:
    """The matrix (4, 4) in float64; TransformError if it is no rigid transform."""
    m = checked_affine(matrix)
    if np.abs(m[:3, :3].T @ m[:3, :3] - np.eye(3)).max() > RIGID:
        raise TransformError("this transform stretches or shears: its axes must be perpendicular and of length 1")
    return m


@njit(inline="always")
def matrix_at(p, first):
    """The 3 × 3 matrix at p[first …], row by row, as nine numbers."""
    return (p[first], p[first + 1], p[first + 2], p[first + 3], p[first + 4], p[first + 5],
            p[first + 6], p[first + 7], p[first + 8])


@stage
def transform_rays(lanes, p, ints, key):
    """The ray transformed by a rigid matrix. p: ROTATION, 3 × 3 row by row, then TRANSLATION (mm)."""
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = matrix_at(p, ROTATION)
    tx, ty, tz = p[TRANSLATION], p[TRANSLATION + 1], p[TRANSLATION + 2]
    for i in range(B):
        px, py, pz, dx, dy, dz = x[i], y[i], z[i], l[i], m[i], n[i]
        x[i] = r00 * px + r01 * py + r02 * pz + tx
        y[i] = r10 * px + r11 * py + r12 * pz + ty
        z[i] = r20 * px + r21 * py + r22 * pz + tz
        l[i] = r00 * dx + r01 * dy + r02 * dz
        m[i] = r10 * dx + r11 * dy + r12 * dz
        n[i] = r20 * dx + r21 * dy + r22 * dz


def transform_steps(world_from_camera: np.ndarray) -> list[Step]:
    """The step from the camera to the world frame; none for the identity."""
    if np.array_equal(world_from_camera, np.eye(4)):
        return []
    return [Step(transform_rays, np.concatenate([world_from_camera[:3, :3].ravel(), world_from_camera[:3, 3]]))]


def look_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 1.0, 0.0)) -> np.ndarray:
    """Pose of a camera that looks at a point.

    Args:
        eye: (3,) array_like. Position of the camera (mm, world frame).
        target: (3,) array_like. Point in the middle of the picture (mm, world frame).
        up: (3,) array_like. Direction that is upright in the picture, of any length (world frame).
    Returns:
        (4, 4) ndarray. world_from_camera, a rigid transform in mm.
    Raises:
        TransformError: If the target is the eye, if `up` is zero or parallel to the view, or for points that are not
            finite.
    """
    eye, target, up = (np.asarray(point, float) for point in (eye, target, up))
    if any(point.shape != (3,) or not np.isfinite(point).all() for point in (eye, target, up)):
        raise TransformError("look_at needs three points, each of three finite numbers")
    back, length = eye - target, float(np.linalg.norm(up))
    distance = float(np.linalg.norm(back))
    if distance == 0.0:
        raise TransformError("the eye and the target of the camera are the same point: move one of them")
    if length == 0.0:
        raise TransformError("the up direction is zero: give it a length")
    back = back / distance
    right = np.cross(up / length, back)
    sine = float(np.linalg.norm(right))
    if sine < 1e-9:
        raise TransformError("the camera looks along its up direction: choose another one")
    right = right / sine
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = right, np.cross(back, right), back, eye
    return m


# Parameters of `transform_moving_rays`: R₀, R₀ [a] and R₀ [a]² (3 × 3 each); translation at the start and its change
# (mm); scale at the start and its change; angle of the whole rotation (turns); part of the motion per second and at
# TIME = 0
ANIMATED_ROTATION, ROTATION_A, ROTATION_A2, START, SHIFT = 0, 9, 18, 27, 30
SCALE, GROWTH, TURNS, RATE, BEGIN = range(33, 38)


def polar_decomposition(matrix: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Rotation R, the nearest one, and symmetric positive stretch S of a matrix R S (3, 3) of positive determinant.

    By Newton's iteration R ← (g R + R⁻ᵀ / g) / 2 with g = (|R⁻¹| / |R|)^½, which always converges (Higham 1986).
    """
    m = np.asarray(matrix, float)
    r = m
    for _ in range(100):
        inverse = np.linalg.inv(r).T
        g = math.sqrt(np.linalg.norm(inverse) / np.linalg.norm(r))
        following = 0.5 * (g * r + inverse / g)
        done = np.abs(following - r).max() < 1e-15
        r = following
        if done:
            break
    s = r.T @ m
    return r, 0.5 * (s + s.T)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Quaternion (w, x, y, z), w ≥ 0, of a rotation matrix (3, 3); its largest part first, without cancellation."""
    m = np.asarray(rotation, float)
    trace = np.trace(m)
    k = int(np.argmax([trace, *np.diagonal(m)]))
    if k == 0:
        q = np.array([1.0 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        a, b, c = ((k - 1 + j) % 3 for j in range(3))
        q = np.zeros(4)
        q[0] = m[c, b] - m[b, c]
        q[1 + a] = 1.0 + m[a, a] - m[b, b] - m[c, c]
        q[1 + b], q[1 + c] = m[b, a] + m[a, b], m[c, a] + m[a, c]
    q /= np.linalg.norm(q)
    return -q if q[0] < 0.0 else q


def quaternion_product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Quaternion of the rotation q followed by p."""
    w, v = p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([w, *v])


def rotation_matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrices (…, 3, 3) of unit quaternions (…, 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows_ = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, -1) for row in rows_], -2)


def shortest_arc(p: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, float]:
    """Axis and angle in [0, π] of the shortest rotation from p to q, in the frame that p rotates; (0, 0, 0) for equal
    ones.
    """
    rotation = quaternion_product(np.asarray(p, float) * (1, -1, -1, -1), np.asarray(q, float))
    rotation = -rotation if rotation[0] < 0.0 else rotation
    length = math.sqrt(rotation[1:] @ rotation[1:])
    return rotation[1:] / length if length > 0.0 else np.zeros(3), 2.0 * math.atan2(length, rotation[0])


def slerp(p: np.ndarray, q: np.ndarray, fraction: ArrayLike) -> np.ndarray:
    """Quaternions (…, 4) at the parts (…) of the shortest arc from p to q, at constant speed: p turned by part of the
    angle.
    """
    axis, angle = shortest_arc(p, q)
    half = 0.5 * angle * np.asarray(fraction, float)
    c, s = np.cos(half)[..., None], np.sin(half)[..., None]
    p = np.asarray(p, float)
    return c * p + s * quaternion_product(p, np.array([0.0, *axis]))


@dataclass(frozen=True, eq=False)
class AnimatedTransform:
    """A transform that moves from one matrix to another, and is constant before and after; compared by value.

    Source: Shoemake and Duff 1992.

    Args:
        start, end: (4, 4) array_like. Affine matrices at the two times, target_from_source, in mm.
        start_time, end_time: Seconds; the end after the start.
    Raises:
        TransformError: For matrices that are not finite and affine, or are singular or mirrored, and for other times.
    """

    start: np.ndarray
    end: np.ndarray
    start_time: float = 0.0
    end_time: float = 1.0

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            matrix = checked_affine(getattr(self, name)) + 0.0              # −0 is 0
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        for name in ("start_time", "end_time"):
            object.__setattr__(self, name, float(getattr(self, name)) + 0.0)
        if not (math.isfinite(self.start_time) and math.isfinite(self.end_time)):
            raise TransformError("the times of an animated transform must be finite numbers of seconds")
        if not self.start_time < self.end_time:
            raise TransformError(f"an animated transform ends at {significant(self.end_time)} s: "
                                 f"it must end after it starts, at {significant(self.start_time)} s")

    @cached_property
    def _value(self) -> tuple[Any, ...]:
        return self.start.tobytes(), self.end.tobytes(), self.start_time, self.end_time

    def __eq__(self, other: object) -> bool:
        """Whether matrices and times are equal."""
        return self._value == other._value if isinstance(other, AnimatedTransform) else NotImplemented

    def __hash__(self) -> int:
        """Hash of matrices and times."""
        return hash(self._value)

    @cached_property
    def parts(self) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
        """Translation (3,) mm, quaternion (4,) of the rotation, and stretch (3, 3), at the start and at the end."""
        both = []
        for matrix in (self.start, self.end):
            r, s = polar_decomposition(matrix[:3, :3])
            both.append((matrix[:3, 3], quaternion(r), s))
        return tuple(both)

    @property
    def is_static(self) -> bool:
        """Whether both matrices are equal."""
        return bool(np.array_equal(self.start, self.end))

    def changes_between(self, first: float, last: float) -> bool:
        """Whether the matrix changes between the times first and last (s)."""
        return not self.is_static and max(first, self.start_time) < min(last, self.end_time)

    def at(self, seconds: ArrayLike) -> np.ndarray:
        """Matrix (4, 4), or (n, 4, 4), at given seconds, world from object (mm); `start` before start_time, `end` after
        end_time.
        """
        when = np.asarray(seconds, float)
        fraction = np.clip((when - self.start_time) / (self.end_time - self.start_time), 0.0, 1.0)
        (place0, turn0, stretch0), (place1, turn1, stretch1) = self.parts
        f = fraction[..., None]
        matrix = np.zeros((*fraction.shape, 4, 4))
        matrix[..., :3, :3] = rotation_matrix(slerp(turn0, turn1, fraction)) @ (
            stretch0 + f[..., None] * (stretch1 - stretch0))
        matrix[..., :3, 3] = place0 + f * (place1 - place0)
        matrix[..., 3, 3] = 1.0
        early, late = (fraction <= 0.0)[..., None, None], (fraction >= 1.0)[..., None, None]
        return np.where(early, self.start, np.where(late, self.end, matrix))

    @cached_property
    def scales(self) -> tuple[float, float]:
        """Uniform scale at the start and at the end; TransformError if a stretch is not uniform."""
        both = []
        for _, _, s in self.parts:
            both.append(float(np.trace(s)) / 3.0)
            if np.abs(s - both[-1] * np.eye(3)).max() > RIGID * both[-1]:
                raise TransformError("this transform stretches or shears: its axes must be perpendicular and of "
                                     "one length")
        return both[0], both[1]

    def scale_at(self, seconds: ArrayLike) -> np.ndarray:
        """Uniform scale, a factor or (n,), at given seconds, linear between the keyframes."""
        return np.interp(np.asarray(seconds, float), (self.start_time, self.end_time), self.scales)

    def steps(self, first: float, last: float) -> list[Step]:
        """Steps that transform rays at their TIME, from the time first (s), at which it is 0, to last (s); none for the
        identity.

        A constant matrix costs no more than a static one. TransformError for a stretch that is not uniform.
        """
        if self.changes_between(first, last):
            return [self._step(first)]
        matrix = self.at(first)
        if abs(self.scale_at(first) - 1.0) < RIGID:
            return transform_steps(matrix)
        return [AnimatedTransform(matrix, matrix)._step(first)]

    def _step(self, begin: float) -> Step:
        """The step for TIME in seconds since `begin`."""
        (place0, turn0, _), (place1, turn1, _) = self.parts
        scale0, scale1 = self.scales
        axis, angle = shortest_arc(turn0, turn1)
        x, y, z = axis
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        first = rotation_matrix(turn0)
        rate = 1.0 / (self.end_time - self.start_time)
        return Step(transform_moving_rays, np.concatenate([
            first.ravel(), (first @ across).ravel(), (first @ across @ across).ravel(), place0, place1 - place0,
            [scale0, scale1 - scale0, angle / (2.0 * math.pi), rate, (begin - self.start_time) * rate]]))


@stage
def transform_moving_rays(lanes, p, ints, key):
    """The ray transformed by the matrix at its TIME (s). p: ROTATION … BEGIN.

    The rotation R₀ exp(α [a]) is R₀ + sin α R₀ [a] + (1 − cos α) R₀ [a]² (Rodrigues), α linear in time.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, time = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TIME]
    r, ra, raa = matrix_at(p, ANIMATED_ROTATION), matrix_at(p, ROTATION_A), matrix_at(p, ROTATION_A2)
    x0, y0, z0 = p[START], p[START + 1], p[START + 2]
    x1, y1, z1 = p[SHIFT], p[SHIFT + 1], p[SHIFT + 2]
    size, growth, turns, rate, begin = p[SCALE], p[GROWTH], p[TURNS], p[RATE], p[BEGIN]
    for i in range(B):
        # Part of the motion at TIME
        fraction = time[i] * rate + begin
        fraction = fraction if fraction > real(0) else real(0)
        fraction = fraction if fraction < real(1) else real(1)

        # Rotation at TIME
        s, v = sine_versine(real, fraction * turns)
        r00, r01, r02 = r[0] + s * ra[0] + v * raa[0], r[1] + s * ra[1] + v * raa[1], r[2] + s * ra[2] + v * raa[2]
        r10, r11, r12 = r[3] + s * ra[3] + v * raa[3], r[4] + s * ra[4] + v * raa[4], r[5] + s * ra[5] + v * raa[5]
        r20, r21, r22 = r[6] + s * ra[6] + v * raa[6], r[7] + s * ra[7] + v * raa[7], r[8] + s * ra[8] + v * raa[8]

        # Transform the ray
        scale = size + fraction * growth
        px, py, pz, dx, dy, dz = x[i] * scale, y[i] * scale, z[i] * scale, l[i], m[i], n[i]
        x[i] = r00 * px + r01 * py + r02 * pz + (x0 + fraction * x1)
        y[i] = r10 * px + r11 * py + r12 * pz + (y0 + fraction * y1)
        z[i] = r20 * px + r21 * py + r22 * pz + (z0 + fraction * z1)
        l[i] = r00 * dx + r01 * dy + r02 * dz
        m[i] = r10 * dx + r11 * dy + r12 * dz
        n[i] = r20 * dx + r21 * dy + r22 * dz
