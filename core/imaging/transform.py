"""Where a camera stands: rigid transforms as 4 × 4 matrices, named target_from_source.

World and camera share handedness and units (mm): x right, y up, the camera
looks along −z.
"""

import numpy as np

from lensbench.kernels.block import B, L, M, N, Step, X, Y, Z, rows, stage

RIGID = 1e-6            # how far axes may be from perpendicular and of length 1: what a file's digits leave


class TransformError(ValueError):
    """A transform that cannot place a camera; the message says what is wrong with it."""


def checked_affine(matrix) -> np.ndarray:
    """The (4, 4) matrix, or a TransformError: not finite, not affine, singular or mirrored."""
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


def checked_rigid(matrix) -> np.ndarray:
    """The (4, 4) matrix, or a TransformError: not finite, not affine, singular, mirrored or not rigid."""
    m = checked_affine(matrix)
    if np.abs(m[:3, :3].T @ m[:3, :3] - np.eye(3)).max() > RIGID:
        raise TransformError("this transform stretches or shears: its axes must be perpendicular and of length 1")
    return m


@stage
def transform_rays(lanes, p, key):
    """Carry the ray by the 3 × 4 matrix p, which is rigid."""
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    a, b, c, d = p[0], p[1], p[2], p[3]
    e, f, g, h = p[4], p[5], p[6], p[7]
    q, r, s, t = p[8], p[9], p[10], p[11]
    for i in range(B):
        px, py, pz, dx, dy, dz = x[i], y[i], z[i], l[i], m[i], n[i]
        x[i] = a * px + b * py + c * pz + d
        y[i] = e * px + f * py + g * pz + h
        z[i] = q * px + r * py + s * pz + t
        l[i] = a * dx + b * dy + c * dz
        m[i] = e * dx + f * dy + g * dz
        n[i] = q * dx + r * dy + s * dz


def transform_steps(world_from_camera: np.ndarray) -> list[Step]:
    """The step from camera to world; none where they are the same."""
    if np.array_equal(world_from_camera, np.eye(4)):
        return []
    return [Step(transform_rays, world_from_camera[:3])]


def look_at(eye, target, up=(0.0, 1.0, 0.0)) -> np.ndarray:
    """world_from_camera (4, 4) of a camera at `eye` (mm) that looks at `target`, `up` upright in its picture.

    TransformError where the target is the eye, or up is zero or points along the view.
    """
    eye, target, up = (np.asarray(point, float) for point in (eye, target, up))
    if any(point.shape != (3,) or not np.isfinite(point).all() for point in (eye, target, up)):
        raise TransformError("look_at needs three points, each of three finite numbers")
    back, length = eye - target, float(np.linalg.norm(up))
    distance = float(np.linalg.norm(back))
    if distance == 0.0:
        raise TransformError("the camera stands where it looks at: move its eye or its target")
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
