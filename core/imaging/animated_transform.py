"""Transforms that change with time: a place, a turn and a scale, each on its own way.

A matrix M is taken apart by the polar decomposition M = R S, a rotation R after
a stretch S that is symmetric and positive. Between two matrices the place and
S change in proportion to the time and R along the shortest arc at constant speed
(slerp: Shoemake 1985; with the polar decomposition: Shoemake and Duff 1992).
Quaternions are (w, x, y, z), of length 1. Lengths in mm, times in seconds.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.imaging.transform import RIGID, TransformError, checked_affine, transform_steps
from lensbench.kernels.block import TIME, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.rotation import sine_versine


def polar_decomposition(matrix) -> tuple[np.ndarray, np.ndarray]:
    """(3, 3) of positive determinant as R S: the rotation nearest to it, and a symmetric positive stretch.

    R by Newton's iteration, R ← (g R + R⁻ᵀ / g) / 2 with g = (|R⁻¹| / |R|)^½, which converges from every such matrix
    (Higham 1986).
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


def quaternion(rotation) -> np.ndarray:
    """Of a rotation matrix (3, 3); w ≥ 0. The largest of the four parts is found first, so that no digits are lost."""
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


def quaternion_product(p, q) -> np.ndarray:
    """The rotation q, then p."""
    w, v = p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([w, *v])


def rotation_matrix(q) -> np.ndarray:
    """(…, 3, 3) of unit quaternions (…, 4)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows_ = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, -1) for row in rows_], -2)


def shortest_arc(p, q) -> tuple[np.ndarray, float]:
    """The shortest turn from p to q: its unit axis, in the frame that p turns, and its angle in [0, π] (radians).

    Half a turn goes about either end of its axis, always the same; no turn has the axis (0, 0, 0).
    """
    turn = quaternion_product(np.asarray(p, float) * (1, -1, -1, -1), np.asarray(q, float))
    turn = -turn if turn[0] < 0.0 else turn
    length = math.sqrt(turn[1:] @ turn[1:])
    return turn[1:] / length if length > 0.0 else np.zeros(3), 2.0 * math.atan2(length, turn[0])


def slerp(p, q, part) -> np.ndarray:
    """(…, 4): from p to q along the shortest arc at constant speed, `part` of the way.

    As p turned by a part of its angle: no quotient by the sine of an angle that may be 0.
    """
    axis, angle = shortest_arc(p, q)
    half = 0.5 * angle * np.asarray(part, float)
    c, s = np.cos(half)[..., None], np.sin(half)[..., None]
    p = np.asarray(p, float)
    return c * p + s * quaternion_product(p, np.array([0.0, *axis]))


@dataclass(frozen=True, eq=False)
class AnimatedTransform:
    """From one matrix (4, 4) at start_time to another at end_time (seconds); constant before and after.

    Compared by value. TransformError for matrices that are not finite and affine, or
    singular, or mirrored, and for an end that is not after the start.
    """

    start: np.ndarray
    end: np.ndarray
    start_time: float = 0.0
    end_time: float = 1.0

    def __post_init__(self):
        for name in ("start", "end"):
            matrix = checked_affine(getattr(self, name)) + 0.0              # −0 is 0
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        for name in ("start_time", "end_time"):
            object.__setattr__(self, name, float(getattr(self, name)) + 0.0)
        if not (math.isfinite(self.start_time) and math.isfinite(self.end_time)):
            raise TransformError("the times of an animated transform must be finite numbers of seconds")
        if not self.start_time < self.end_time:
            raise TransformError(f"an animated transform ends at {self.end_time:g} s: "
                                 f"it must end after it starts, at {self.start_time:g} s")

    @cached_property
    def _value(self) -> tuple:
        return self.start.tobytes(), self.end.tobytes(), self.start_time, self.end_time

    def __eq__(self, other):
        """Equal matrices at equal times."""
        return self._value == other._value if isinstance(other, AnimatedTransform) else NotImplemented

    def __hash__(self):
        """Of its value."""
        return hash(self._value)

    @cached_property
    def parts(self) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
        """Translation (3,) mm, rotation as a quaternion (4,), and stretch (3, 3), at the start and at the end."""
        both = []
        for matrix in (self.start, self.end):
            r, s = polar_decomposition(matrix[:3, :3])
            both.append((matrix[:3, 3], quaternion(r), s))
        return tuple(both)

    @property
    def is_static(self) -> bool:
        """Whether both matrices are the same."""
        return bool(np.array_equal(self.start, self.end))

    def changes_between(self, first: float, last: float) -> bool:
        """Whether it is not one matrix from `first` to `last` (seconds)."""
        return not self.is_static and max(first, self.start_time) < min(last, self.end_time)

    def at(self, seconds) -> np.ndarray:
        """(4, 4), or (n, 4, 4) for n times: the two matrices themselves, digit by digit, at their times and beyond."""
        when = np.asarray(seconds, float)
        part = np.clip((when - self.start_time) / (self.end_time - self.start_time), 0.0, 1.0)
        (place0, turn0, stretch0), (place1, turn1, stretch1) = self.parts
        f = part[..., None]
        matrix = np.zeros((*part.shape, 4, 4))
        matrix[..., :3, :3] = rotation_matrix(slerp(turn0, turn1, part)) @ (
            stretch0 + f[..., None] * (stretch1 - stretch0))
        matrix[..., :3, 3] = place0 + f * (place1 - place0)
        matrix[..., 3, 3] = 1.0
        early, late = (part <= 0.0)[..., None, None], (part >= 1.0)[..., None, None]
        return np.where(early, self.start, np.where(late, self.end, matrix))

    @cached_property
    def scales(self) -> tuple[float, float]:
        """How much it enlarges at the start and at the end, in all directions alike; a TransformError otherwise."""
        both = []
        for _, _, s in self.parts:
            both.append(float(np.trace(s)) / 3.0)
            if np.abs(s - both[-1] * np.eye(3)).max() > RIGID * both[-1]:
                raise TransformError("this transform stretches or shears: its axes must be perpendicular and of "
                                     "one length")
        return both[0], both[1]

    def scale_at(self, seconds) -> np.ndarray:
        """How much it enlarges at these times (s)."""
        return np.interp(seconds, (self.start_time, self.end_time), self.scales)

    def steps(self, first: float, last: float) -> list[Step]:
        """What carries rays by it at their TIME, in seconds since `first`; no ray is later than `last`.

        Where it is one matrix all the while, it costs what that matrix costs. TransformError where it stretches.
        """
        if self.changes_between(first, last):
            return [self._step(first)]
        matrix = self.at(first)
        if abs(self.scale_at(first) - 1.0) < RIGID:
            return transform_steps(matrix)
        return [AnimatedTransform(matrix, matrix)._step(first)]

    def _step(self, begin: float) -> Step:
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
def transform_moving_rays(lanes, p, key):
    """Carry the ray from the camera to the world as they are to each other at its TIME (s).

    The rotation R₀ exp(α [a]) is R₀ + sin α R₀ [a] + (1 − cos α) R₀ [a]², α in proportion to the time.
    p: R₀ (9), R₀ [a] (9), R₀ [a]² (9), first place and the way from it (6, mm), first scale and its change, greatest
    α in turns, part of the way per second and at TIME = 0.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, time = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TIME]
    a, b, c, d, e, f, g, h, k = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]
    sa, sb, sc, sd, se, sf, sg, sh, sk = p[9], p[10], p[11], p[12], p[13], p[14], p[15], p[16], p[17]
    va, vb, vc, vd, ve, vf, vg, vh, vk = p[18], p[19], p[20], p[21], p[22], p[23], p[24], p[25], p[26]
    x0, y0, z0, x1, y1, z1 = p[27], p[28], p[29], p[30], p[31], p[32]
    size, growth, turns, rate, first = p[33], p[34], p[35], p[36], p[37]
    for i in range(B):
        part = time[i] * rate + first
        part = part if part > real(0) else real(0)
        part = part if part < real(1) else real(1)
        s, v = sine_versine(real, part * turns)
        scale = size + part * growth
        px, py, pz, dx, dy, dz = x[i] * scale, y[i] * scale, z[i] * scale, l[i], m[i], n[i]
        ra, rb, rc = a + s * sa + v * va, b + s * sb + v * vb, c + s * sc + v * vc
        rd, re, rf = d + s * sd + v * vd, e + s * se + v * ve, f + s * sf + v * vf
        rg, rh, rk = g + s * sg + v * vg, h + s * sh + v * vh, k + s * sk + v * vk
        x[i] = ra * px + rb * py + rc * pz + (x0 + part * x1)
        y[i] = rd * px + re * py + rf * pz + (y0 + part * y1)
        z[i] = rg * px + rh * py + rk * pz + (z0 + part * z1)
        l[i] = ra * dx + rb * dy + rc * dz
        m[i] = rd * dx + re * dy + rf * dz
        n[i] = rg * dx + rh * dy + rk * dz
