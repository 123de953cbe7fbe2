"""Intersection of a ray with a sphere or with the plane of a planar shape, for cameras, shadows and coats.

Rays are o + t d with a unit direction d. Written without branches, for one lane.
"""

from lensbench.kernels.cache import njit


@njit(inline="always")
def closest_approach(cx, cy, cz, dx, dy, dz):
    """Distance along a ray to the point nearest to a centre at c from its origin, and the square of that miss."""
    along = cx * dx + cy * dy + cz * dz
    ox, oy, oz = cx - along * dx, cy - along * dy, cz - along * dz
    return along, ox * ox + oy * oy + oz * oz


@njit(inline="always")
def plane_point(ox, oy, oz, dx, dy, dz, ux, uy, uz, ax, ay, az, bx, by, bz):
    """Distance to the plane through the centre, at −o from the ray's origin, with the normal u; and u, v there.

    a, b: the half-axes over the squares of their lengths.
    """
    t = -(ox * ux + oy * uy + oz * uz) / (dx * ux + dy * uy + dz * uz)
    qx, qy, qz = ox + t * dx, oy + t * dy, oz + t * dz
    return t, qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz


@njit(inline="always")
def inside_edge(real, u, v, disk):
    """Whether a point at u, v half-axes lies on a rectangle (disk = 0) or an ellipse (disk = 1)."""
    u2, v2 = u * u, v * v
    most = u2 if u2 > v2 else v2
    return most + disk * (u2 + v2 - most) <= real(1)
