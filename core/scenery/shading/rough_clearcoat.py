"""A rough coat: the lights it mirrors, spread over its facets in closed form."""

import math

import numpy as np
from numba import njit

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    A8,
    A9,
    A10,
    A11,
    BLUE,
    DEPTH,
    GLOSS,
    GREEN,
    NX,
    NY,
    NZ,
    OX,
    OY,
    OZ,
    PIXEL_SIDE,
    PIXEL_SPREAD,
    PUPIL_RADIUS,
    PUPIL_SPREAD,
    RED,
    SB,
    SG,
    SR,
    TB,
    TG,
    TR,
    B,
    L,
    M,
    N,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.scenery.intersect.planar import plate_frame
from lensbench.scenery.shading.clearcoat import SHARP
from lensbench.scenery.shading.illumination import F0

SKY = 12                # numbers of sky_parameters
HIGHLIGHT = 7               # numbers per light: centre, area of its disk / π, radiance (3)
FLATTEST, FARTHEST = 0.1, 0.9       # cosine of the ray through the middle over the sample's, at the least; and how much
                                    # longer or shorter it may be, over the length
WIDEST = 1.0            # slope², how far a sample's part reaches at the most: half a right angle
DARK = 1e9              # of lobe widths²: from there on nothing is seen of a light, and single numbers soon overflow


def rough_clearcoat_parameters(sky, lights) -> np.ndarray:
    """What `rough_clearcoat` reads: sky_parameters, then every light as a disk that faces the surface."""
    return np.concatenate([sky, highlight_parameters(lights)])


def highlight_parameters(lights) -> np.ndarray:
    """What `rough_lights` reads."""
    packed = [np.zeros(0)]
    for light in lights:
        if not hasattr(light, "right"):
            size = light.radius**2
        else:
            _, a, b, _, disk = plate_frame(light)
            size = math.sqrt((a @ a) * (b @ b)) * (1.0 if disk else 4.0 / math.pi)
        packed.append(np.array([*light.centre, size, *light.material.colour]))
    return np.concatenate(packed)


@stage
def rough_clearcoat(lanes, p, key):
    """Add what coats of a gloss below 1 mirror of the lights, and of the sky as if they were smooth.

    The slopes of the facets are spread as 1 / (π α² (1 + tan² / α²)²) (Trowbridge, Reitz), α = 1 − gloss. A light of
    solid angle Ω is mirrored by slopes of the area Ω / (4 cos θ cos³ δ), with δ the tilt of the facet half way; that
    area widens α, so that a large light never gets brighter than itself. p: rough_clearcoat_parameters.
    """
    if rough_open(lanes, p) == 0:
        return
    rough_lights(lanes, p[SKY:])
    rough_close(lanes)


@njit(inline="always")
def lobe_mean(real, place2, reach2, width2):
    """1 / (1 + x² / w²)² on average over all places from x − h to x + h: a / b · √(c / d), as a, b, c, d.

    place2, reach2, width2: x², h² and w², in whatever unit. A sine of spherical caps,
    J = (1 − q / √(q² + 4 w² h²)) / 2 with q = w² + x² − h², is that lobe where h is small and a box where w is; its
    integral over x is π/2 h² / (w k), k² = 1 + t (3/4 + (π² / 64) t) / (1 + t / 4) within a hundredth, t = h² / w².
    """
    q = width2 + place2 - reach2
    root = math.sqrt(q * q + real(4) * width2 * reach2)
    outside, most = q > real(0), width2 * (width2 + real(0.25) * reach2)
    return (real(2) * width2 * width2 if outside else real(0.5) * width2 * (root - q),
            root * (root + q if outside else reach2),
            most + reach2 * (real(0.75) * width2 + real(math.pi**2 / 64) * reach2), most)


@stage
def rough_open(lanes, p):
    """The points that mirror, A0 A1 A2, and what they mirror of the sky, A3 A4 A5. Returns how many there are.

    They are those of the rays through the middles of the parts of the pupil that samples stand for: until rough_close
    L, M, N are the directions of these, A6 A7 A8 those of the samples.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, gloss, nx, ny, nz = row[DEPTH], row[GLOSS], row[NX], row[NY], row[NZ]
    hx, hy, hz, r, g, b = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    many = np.int32(0)
    for i in range(B):
        many = np.int32(many + np.int32((gloss[i] > real(0)) & (gloss[i] < real(SHARP))))
    if many == 0:
        return many
    disk, fan, ox, oy, oz = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[OX], row[OY], row[OZ]
    kept_x, kept_y, kept_z = row[A6], row[A7], row[A8]
    for i in range(B):
        ux, uy, uz, vx, vy, vz, t = nx[i], ny[i], nz[i], dx[i], dy[i], dz[i], depth[i]
        kept_x[i], kept_y[i], kept_z[i] = vx, vy, vz
        view = -(vx * ux + vy * uy + vz * uz)
        # the ray through the middle, and where it meets the plane; where that is over the horizon, the ray itself
        wx, wy, wz = vx - fan[i] * ox[i], vy - fan[i] * oy[i], vz - fan[i] * oz[i]
        size = real(1) / math.sqrt(wx * wx + wy * wy + wz * wz)
        wx, wy, wz = wx * size, wy * size, wz * size
        fall = -(wx * ux + wy * uy + wz * uz)
        aside = disk[i] + t * fan[i]
        sx, sy, sz = aside * ox[i], aside * oy[i], aside * oz[i]
        more = -(sx * ux + sy * uy + sz * uz) / fall
        steep = (fall > real(FLATTEST) * view) & (abs(more) < real(FARTHEST) * t)
        hx[i] = x[i] + t * vx + (more * wx - sx if steep else real(0))
        hy[i] = y[i] + t * vy + (more * wy - sy if steep else real(0))
        hz[i] = z[i] + t * vz + (more * wz - sz if steep else real(0))
        dx[i], dy[i], dz[i] = wx if steep else vx, wy if steep else vy, wz if steep else vz
    for i in range(B):
        view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        edge = real(1) - (view if view > real(0) else real(0))
        edge2 = edge * edge
        f = real(F0) + real(1 - F0) * edge2 * edge2 * edge
        mx, my, mz = dx[i] + real(2) * view * nx[i], dy[i] + real(2) * view * ny[i], dz[i] + real(2) * view * nz[i]
        up = p[9] * mx + p[10] * my + p[11] * mz
        above = up >= real(0)
        r[i] = f * (p[3] + up * (p[0] - p[3]) if above else p[6])
        g[i] = f * (p[4] + up * (p[1] - p[4]) if above else p[7])
        b[i] = f * (p[5] + up * (p[2] - p[5]) if above else p[8])
    return many


@stage
def rough_lights(lanes, p):
    """Add lights to A3 A4 A5, each on average over the part of pupil and pixel.  p: HIGHLIGHT numbers for each."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, gloss, nx, ny, nz, depth = (row[L], row[M], row[N], row[GLOSS], row[NX], row[NY], row[NZ], row[DEPTH])
    hx, hy, hz, r, g, b, ax, ay, az = (row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A9], row[A10],
                                       row[A11])
    disk, fan, foot, spread = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    for i in range(B):
        # across, in the plane
        a, c, e = dy[i] * nz[i] - dz[i] * ny[i], dz[i] * nx[i] - dx[i] * nz[i], dx[i] * ny[i] - dy[i] * nx[i]
        size = real(1) / math.sqrt(a * a + c * c + e * e + real(1e-20))
        ax[i], ay[i], az[i] = a * size, c * size, e * size
    for s in range(0, p.size, HIGHLIGHT):
        cx, cy, cz, size, er, eg, eb = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6]
        for i in range(B):
            alpha = real(1) - gloss[i]
            qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
            d2 = qx * qx + qy * qy + qz * qz
            inverse = real(1) / math.sqrt(d2)
            qx, qy, qz = qx * inverse, qy * inverse, qz * inverse
            slant = qx * nx[i] + qy * ny[i] + qz * nz[i]
            view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
            kx, ky, kz = qx - dx[i], qy - dy[i], qz - dz[i]
            k2 = kx * kx + ky * ky + kz * kz
            long = math.sqrt(k2)                            # twice cos θ
            per = real(1) / (slant + view)                  # times `long`: 1 / cos δ
            per2 = per * per
            area = real(0.5) * size * inverse * inverse * k2 * per2 * per       # of slopes, over π
            # the slope, across and along, and how far the part reaches across; along, less by the cosine
            across = (qx * ax[i] + qy * ay[i] + qz * az[i]) * per
            across2 = across * across
            along2 = k2 * per2 - real(1) - across2
            pupil, pixel = inverse * (disk[i] + depth[i] * fan[i]) + fan[i], (
                inverse * (foot[i] + depth[i] * spread[i]) + spread[i])
            reach2 = (pupil * pupil + real(1 / 3) * pixel * pixel) * per2
            # all in widths of the lobe, which no number outgrows at grazing incidence
            narrow = real(1) / (alpha * alpha + area)
            reach2 = (reach2 if reach2 < real(WIDEST) else real(WIDEST)) * narrow
            deep = real(1) + reach2 * view * view
            low = deep + (along2 if along2 > real(0) else real(0)) * narrow
            edge = real(1) - real(0.5) * long
            edge2 = edge * edge
            f = real(F0) + real(1 - F0) * edge2 * edge2 * edge
            top, bottom, more, most = lobe_mean(real, across2 * narrow * deep, real(0.75) * reach2 * deep, low)
            share = f * area * narrow * real(0.5) * k2 * per * top * deep * deep * math.sqrt(more / (most * deep)) / (
                bottom * low * low * (view if view > slant else slant))
            share = share if (slant > real(0)) & (view > real(0)) & (low < real(DARK)) else real(0)
            r[i] += share * er
            g[i] += share * eg
            b[i] += share * eb


@stage
def rough_close(lanes):
    """What is mirrored goes to the path; an albedo under a coat gets what the coat lets in."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, gloss, nx, ny, nz = row[L], row[M], row[N], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, tr, tg, tb, sr, sg, sb = (row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB],
                                                row[SR], row[SG], row[SB])
    r, g, b, kept_x, kept_y, kept_z = row[A3], row[A4], row[A5], row[A6], row[A7], row[A8]
    for i in range(B):
        dx[i], dy[i], dz[i] = kept_x[i], kept_y[i], kept_z[i]
        coated = (gloss[i] > real(0)) & (gloss[i] < real(SHARP))
        sr[i] += tr[i] * r[i] if coated else real(0)
        sg[i] += tg[i] * g[i] if coated else real(0)
        sb[i] += tb[i] * b[i] if coated else real(0)
        view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        edge = real(1) - (view if view > real(0) else real(0))
        edge2 = edge * edge
        under = real(1 - F0) * (real(1) - edge2 * edge2 * edge) if coated else real(1)
        red[i], green[i], blue[i] = red[i] * under, green[i] * under, blue[i] * under
