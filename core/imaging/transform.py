"""Rigid transforms as 4 × 4 matrices, named target_from_source.

World and camera share handedness and units (mm): x right, y up; the camera
looks along −z.
"""

import numpy as np

from lensbench.kernels.block import B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.cache import njit

RIGID = 1e-6            # tolerance of perpendicular axes of length 1, for matrices from files of few digits

ROTATION, TRANSLATION = 0, 9        # parameters of `transform_rays`


class TransformError(ValueError):
    """A transform that is no valid pose of a camera; the message says why."""


def checked_affine(matrix) -> np.ndarray:
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


def checked_rigid(matrix) -> np.ndarray:
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


def look_at(eye, target, up=(0.0, 1.0, 0.0)) -> np.ndarray:
    """Pose of a camera that looks at a point.

    Parameters
    ----------
    eye : (3,) array_like
        Position of the camera (mm, world frame).
    target : (3,) array_like
        Point in the middle of the picture (mm, world frame).
    up : (3,) array_like
        Direction that is upright in the picture, of any length (world frame).

    Returns
    -------
    (4, 4) ndarray
        world_from_camera, a rigid transform in mm.

    Raises
    ------
    TransformError
        If the target is the eye, if `up` is zero or parallel to the view, or for points that are not finite.
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
