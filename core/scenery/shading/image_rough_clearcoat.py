"""Rough clear coats below a sky that a picture shows: the picture, spread over the facets of the coat.

The facets are those of `rough_clearcoat`, slopes distributed as by Trowbridge and Reitz with α = 1 − gloss, and hide
each other as Smith has it. A sample takes two directions: one that a facet mirrors, which is visible from the camera,
and one of a bright place of the picture. Both are weighted by the balance heuristic (Veach), so that neither a wide
lobe nor a small sun makes noise that the other does not take away.
"""

import math

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, FINISH, NX, NY, NZ, SB, SG, SR, TB, TG, TR, V0, V1, B, L, M, N, Step,
    offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect import sky as ground
from lensbench.core.scenery.intersect.image_sky import IMAGE_SKY, image_sky_step, look_up_sky
from lensbench.core.scenery.shading.illumination import F0, schlick_edge
from lensbench.core.scenery.shading.image_sky_light import (
    CELL_INTEGERS, COSINE, SINE, SKY_LIGHT, sky_density, sky_directions, sky_rays_step
)
from lensbench.core.scenery.shading.rough_clearcoat import smith_sum
from lensbench.core.scenery.surface_codes import is_rough_coat

# CELLS: numbers of `sky_rays`, PICTURE: of `look_up_sky`, then the unit normal of the floor, its height, its radiance
CELLS, PICTURE, NORMAL, HEIGHT, RADIANCE, ROUGH_SKY = offsets(SKY_LIGHT, IMAGE_SKY, 3, 1, 3)
SKY_INTEGERS = 4        # of `look_up_sky`, after those of the cells; then whether there is a floor


def image_rough_clearcoat_step(sky, floor: np.ndarray | None, floor_light: np.ndarray) -> Step:
    """The stage of rough coats for an `ImageSky`.

    floor: floor_parameters or None; floor_light: irradiance / π on it (3).
    """
    cells, picture = sky_rays_step(sky), image_sky_step(sky)
    below = {} if floor is None else {NORMAL: floor[ground.NORMAL:ground.NORMAL + 3], HEIGHT: floor[ground.HEIGHT],
                                      RADIANCE: floor[ground.COLOUR:ground.COLOUR + 3] * floor_light}
    return Step(image_rough_clearcoat, pack(ROUGH_SKY, {CELLS: cells.parameters, PICTURE: picture.parameters, **below}),
                [*cells.integers, *picture.integers, floor is not None], kept=(cells.kept, picture.kept))


@njit(inline="always")
def reflectance(real, cosine):
    """Schlick's reflectance of a facet."""
    return real(F0) + real(1 - F0) * schlick_edge(real, cosine)


@njit(inline="always")
def shown(real, alpha2, cosine):
    """Part of the facets at a cosine of incidence that others do not hide."""
    return real(2) * cosine / smith_sum(real, alpha2, cosine)


@njit(inline="always")
def facet_density(real, alpha2, tilt, view):
    """Density per solid angle of the mirrored direction; tilt: cosine between facet and surface, view: of the ray."""
    spread = real(1) + (alpha2 - real(1)) * tilt * tilt
    return alpha2 * shown(real, alpha2, view) / (real(4 * math.pi) * spread * spread * view)


@stage
def image_rough_clearcoat(lanes, p, ints, key):
    """Add what coats of a gloss below 1 reflect of the picture and of the floor.  p, ints: as packed above."""
    real = lanes.dtype.type
    row = rows(lanes)
    finish, many = row[FINISH], np.int32(0)
    for i in range(B):
        many = np.int32(many + np.int32(is_rough_coat(real, finish[i])))
    if many == 0:
        return
    dx, dy, dz, nx, ny, nz = row[L], row[M], row[N], row[NX], row[NY], row[NZ]
    hx, hy, hz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    r, g, b, share = row[A8], row[A9], row[A10], row[A7]
    tr, tg, tb, sr, sg, sb, v0, v1 = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB], row[V0], row[V1]
    has_floor = ints[CELL_INTEGERS + SKY_INTEGERS] != 0
    (ux, uy, uz), height, (er, eg, eb) = vector(p, NORMAL), p[HEIGHT], vector(p, RADIANCE)

    # A bright place of the picture, where the floor does not hide it
    sky_directions(lanes, p, ints)
    sky_density(lanes, ints, p[CELLS + COSINE], p[CELLS + SINE], row[A6])
    chance = row[A6]
    for i in range(B):
        view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        slant = wx[i] * nx[i] + wy[i] * ny[i] + wz[i] * nz[i]
        kx, ky, kz = wx[i] - dx[i], wy[i] - dy[i], wz[i] - dz[i]
        size = math.sqrt(kx * kx + ky * ky + kz * kz)           # twice the cosine at the facet
        alpha = real(1) - finish[i]
        alpha2 = alpha * alpha
        density = facet_density(real, alpha2, (slant + view) / size, view)
        up, over = ux * wx[i] + uy * wy[i] + uz * wz[i], ux * hx[i] + uy * hy[i] + uz * hz[i] - height
        hidden = has_floor & (up < real(0)) & (over > real(0))
        met = is_rough_coat(real, finish[i]) & (view > real(0)) & (slant > real(0)) & (size > real(0))
        part = reflectance(real, real(0.5) * size) * density * shown(real, alpha2, slant)
        part *= real(math.pi) * chance[i] / (chance[i] + density)       # r, g, b hold the flux over π
        part = part if met & ~hidden else real(0)
        sr[i] += tr[i] * part * r[i] if part > real(0) else real(0)
        sg[i] += tg[i] * part * g[i] if part > real(0) else real(0)
        sb[i] += tb[i] * part * b[i] if part > real(0) else real(0)

    # A facet of those that the ray sees (Dupuy and Benyoub 2023), in the frame of the surface and the ray
    for i in range(B):
        view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        tx, ty, tz = -dx[i] - view * nx[i], -dy[i] - view * ny[i], -dz[i] - view * nz[i]
        level = math.sqrt(tx * tx + ty * ty + tz * tz)
        steep = level > real(1e-6)
        kx, ky, kz = (real(0), nz[i], -ny[i]) if abs(nx[i]) > real(0.7) else (-nz[i], real(0), nx[i])
        size = real(1) / (level if steep else math.sqrt(kx * kx + ky * ky + kz * kz) + real(1e-20))
        tx, ty, tz = ((tx if steep else kx) * size, (ty if steep else ky) * size, (tz if steep else kz) * size)
        bx, by, bz = ny[i] * tz - nz[i] * ty, nz[i] * tx - nx[i] * tz, nx[i] * ty - ny[i] * tx
        alpha = real(1) - finish[i]
        alpha2 = alpha * alpha
        size = real(1) / math.sqrt(alpha2 * level * level + view * view)
        sx, sz = alpha * level * size, view * size              # the ray where the facets are a half sphere
        sine, versine = sine_versine(real, v1[i])
        cz = (real(1) - v0[i]) * (real(1) + sz) - sz
        round_ = math.sqrt(max(real(1) - cz * cz, real(0)))
        fx, fy, fz = alpha * (round_ * (real(1) - versine) + sx), alpha * round_ * sine, max(cz + sz, real(0))
        size = real(1) / math.sqrt(fx * fx + fy * fy + fz * fz + real(1e-20))
        fx, fy, fz = fx * size, fy * size, fz * size
        facing = fx * level + fz * view if steep else fz
        kx, ky, kz = fx * tx + fy * bx + fz * nx[i], fx * ty + fy * by + fz * ny[i], fx * tz + fy * bz + fz * nz[i]
        wx[i], wy[i], wz[i] = (dx[i] + real(2) * facing * kx, dy[i] + real(2) * facing * ky,
                               dz[i] + real(2) * facing * kz)
        slant = wx[i] * nx[i] + wy[i] * ny[i] + wz[i] * nz[i]
        met = is_rough_coat(real, finish[i]) & (view > real(0)) & (slant > real(0)) & (facing > real(0))
        part = reflectance(real, facing) * shown(real, alpha2, slant)
        share[i] = part if met else real(0)
        r[i] = facet_density(real, alpha2, fz, view)
    sky_density(lanes, ints, p[CELLS + COSINE], p[CELLS + SINE], chance)
    for i in range(B):
        up, over = ux * wx[i] + uy * wy[i] + uz * wz[i], ux * hx[i] + uy * hy[i] + uz * hz[i] - height
        hidden = has_floor & (up < real(0)) & (over > real(0))
        part = share[i] if share[i] > real(0) else real(0)
        fallen = part if hidden else real(0)
        sr[i] += tr[i] * fallen * er
        sg[i] += tg[i] * fallen * eg
        sb[i] += tb[i] * fallen * eb
        share[i] = real(0) if hidden else part * r[i] / (r[i] + chance[i])
    look_up_sky(lanes, p[PICTURE:], ints[CELL_INTEGERS:], wx, wy, wz, r, g, b)
    for i in range(B):
        part = share[i] if share[i] > real(0) else real(0)
        sr[i] += tr[i] * part * r[i]
        sg[i] += tg[i] * part * g[i]
        sb[i] += tb[i] * part * b[i]
