"""A clear coat: what it mirrors of the lights, the sky and the floor, without noise.

Other objects are not mirrored. A coat of gloss 1, and glass, shows the lights
sharply; a lesser gloss spreads them over facets whose slopes have the width
α = 1 − gloss, in closed form, so that a lamp far away is a long streak on wet ground.
"""

import math

import numpy as np

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
    BLUE,
    DEPTH,
    GLASS,
    GLOSS,
    GREEN,
    METAL,
    NX,
    NY,
    NZ,
    PIXEL_SIDE,
    PIXEL_SPREAD,
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
from lensbench.scenery.shading.illumination import F0
from lensbench.scenery.shading.pattern_filter import filtered_contrast, footprint_stretch

SHARP = 0.999           # gloss from which a coat shows lights sharply
PANEL, BULB = 16, 7       # numbers per plate and per sphere that shine
LIGHTS = 46             # numbers before them


def clearcoat_parameters(sky, floor, floor_light, sun, panels, bulbs, last) -> np.ndarray:
    """What `clearcoat` reads.

    sky: sky_parameters; floor: floor_parameters or None, with floor_light, the irradiance / π on it (3); sun:
    direction, chord², radiance (7) or None; panels, bulbs: plates and spheres that shine; last: a path ends here, and
    metal mirrors as a coat does.
    """
    packed = [np.array([float(last), float(floor is not None), float(sun is not None), len(panels)]), sky]
    packed.append(np.zeros(20) if floor is None else floor)
    packed.append(np.asarray(floor_light, np.float64))
    packed.append(np.zeros(7) if sun is None else sun)
    return np.concatenate([*packed, reflected_parameters(panels, bulbs)])


def reflected_parameters(panels, bulbs) -> np.ndarray:
    """What `sharp_lights` reads: PANEL numbers for each plate that shines, BULB for each sphere."""
    packed = [np.zeros(0)]
    for plate in panels:
        centre, a, b, normal, disk = plate_frame(plate)
        packed.append(np.array([*centre, *normal, *(a / (a @ a)), *(b / (b @ b)), disk, *plate.material.colour]))
    for s in bulbs:
        packed.append(np.array([*s.centre, s.radius**2, *s.material.colour]))
    return np.concatenate(packed)


@stage
def clearcoat(lanes, p, key):
    """Add what sharp coats and glass mirror; an albedo under a coat gets what the coat lets in.

    p: clearcoat_parameters.
    """
    if sharp_open(lanes, p) == 0:
        return
    sharp_lights(lanes, p[LIGHTS:], int(p[3]))
    sharp_close(lanes, p)


@stage
def sharp_open(lanes, p):
    """The ray that a coat mirrors, A0 … A5, what it meets of sky, floor and sun, A6 A7 A8, and how far off, A9.

    Returns how many lanes of the block mirror anything; 0: nothing is done.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, gloss, nx, ny, nz = row[DEPTH], row[GLOSS], row[NX], row[NY], row[NZ]
    hx, hy, hz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    r, g, b, near = row[A6], row[A7], row[A8], row[A9]
    last, tiled, sunny = p[0] > real(0), p[1] > real(0), p[2] > real(0)
    many = np.int32(0)
    for i in range(B):
        many = np.int32(many + np.int32((gloss[i] >= real(SHARP)) & ((gloss[i] < real(METAL)) | last |
                                                                     (gloss[i] >= real(GLASS)))))
    if many == 0:
        return many
    # the mirrored ray, and the sky where it goes
    k = 4
    zr, zg, zb, er, eg, eb = p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], p[k + 5]
    gr, gg, gb, ux, uy, uz = p[k + 6], p[k + 7], p[k + 8], p[k + 9], p[k + 10], p[k + 11]
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        c = real(-2) * (dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        mx, my, mz = dx[i] + c * nx[i], dy[i] + c * ny[i], dz[i] + c * nz[i]
        up = ux * mx + uy * my + uz * mz
        above = up >= real(0)
        wx[i], wy[i], wz[i], near[i] = mx, my, mz, real(math.inf)
        r[i] = er + up * (zr - er) if above else gr
        g[i] = eg + up * (zg - eg) if above else gg
        b[i] = eb + up * (zb - eb) if above else gb
    k = 16
    if tiled:
        ux, uy, uz, height = p[k], p[k + 1], p[k + 2], p[k + 3]
        ax, ay, az, bx, by, bz = p[k + 4], p[k + 5], p[k + 6], p[k + 7], p[k + 8], p[k + 9]
        a0, b0, per = p[k + 10], p[k + 11], p[k + 19]
        tile, foot, spread = real(1) / per, row[PIXEL_SIDE], row[PIXEL_SPREAD]
        fr, fg, fb, qr, qg, qb = p[k + 12], p[k + 13], p[k + 14], p[k + 15], p[k + 16], p[k + 17]
        er, eg, eb = p[k + 20], p[k + 21], p[k + 22]
        for i in range(B):
            steep = real(1) / (ux * wx[i] + uy * wy[i] + uz * wz[i])
            t = (height - (ux * hx[i] + uy * hy[i] + uz * hz[i])) * steep
            hit = (t > real(0)) & (steep < real(0))
            px, py, pz = hx[i] + t * wx[i], hy[i] + t * wy[i], hz[i] + t * wz[i]
            at_a, at_b = a0 + ax * px + ay * py + az * pz, b0 + bx * px + by * py + bz * pz
            odd = np.floor(at_a) + np.floor(at_b)
            wide = abs(foot[i] + (t + depth[i]) * spread[i]) * per
            wide_a = wide * footprint_stretch(real, (ax * wx[i] + ay * wy[i] + az * wz[i]) * tile, steep)
            wide_b = wide * footprint_stretch(real, (bx * wx[i] + by * wy[i] + bz * wz[i]) * tile, steep)
            side = (real(4) * (odd * real(0.5) - np.floor(odd * real(0.5))) - real(1)) * filtered_contrast(
                real, abs(at_a - np.floor(at_a + real(0.5))), wide_a) * filtered_contrast(
                real, abs(at_b - np.floor(at_b + real(0.5))), wide_b)
            near[i] = t if hit else near[i]
            r[i] = er * (fr + side * qr) if hit else r[i]
            g[i] = eg * (fg + side * qg) if hit else g[i]
            b[i] = eb * (fb + side * qb) if hit else b[i]
    k = 39
    if sunny:
        ux, uy, uz, chord2, er, eg, eb = p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], p[k + 5], p[k + 6]
        for i in range(B):
            ax, ay, az = wx[i] - ux, wy[i] - uy, wz[i] - uz
            hit = (ax * ax + ay * ay + az * az < chord2) & (near[i] == real(math.inf))
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]
    return many


@stage
def sharp_lights(lanes, p, panels):
    """Offer lights to the mirrored ray where they are nearer.  p: reflected_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    r, g, b, near = row[A6], row[A7], row[A8], row[A9]
    end = PANEL * panels
    for s in range(0, end, PANEL):
        cx, cy, cz, ux, uy, uz = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5]
        ax, ay, az, bx, by, bz, disk = p[s + 6], p[s + 7], p[s + 8], p[s + 9], p[s + 10], p[s + 11], p[s + 12]
        er, eg, eb = p[s + 13], p[s + 14], p[s + 15]
        for i in range(B):
            ox, oy, oz = hx[i] - cx, hy[i] - cy, hz[i] - cz
            t = -(ox * ux + oy * uy + oz * uz) / (wx[i] * ux + wy[i] * uy + wz[i] * uz)
            qx, qy, qz = ox + t * wx[i], oy + t * wy[i], oz + t * wz[i]
            qa, qb = qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz
            a2, b2 = qa * qa, qb * qb
            most = a2 if a2 > b2 else b2
            hit = (most + disk * (a2 + b2 - most) <= real(1)) & (t > real(0)) & (t < near[i])
            near[i] = t if hit else near[i]
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]
    for s in range(end, p.size, BULB):
        cx, cy, cz, r2, er, eg, eb = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6]
        for i in range(B):
            ax, ay, az = cx - hx[i], cy - hy[i], cz - hz[i]
            along = ax * wx[i] + ay * wy[i] + az * wz[i]
            ox, oy, oz = ax - along * wx[i], ay - along * wy[i], az - along * wz[i]
            hit = (ox * ox + oy * oy + oz * oz < r2) & (along > real(0)) & (along < near[i])
            near[i] = along if hit else near[i]
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]


@stage
def sharp_close(lanes, p):
    """As much of what is mirrored as Fresnel's reflectance (Schlick 1994)."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, gloss, nx, ny, nz = row[L], row[M], row[N], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, tr, tg, tb, sr, sg, sb = (row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB],
                                                row[SR], row[SG], row[SB])
    r, g, b = row[A6], row[A7], row[A8]
    last = p[0] > real(0)
    for i in range(B):
        cosine = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        edge = real(1) - (cosine if cosine > real(0) else real(0))
        edge2 = edge * edge
        edge5 = edge2 * edge2 * edge
        f = real(F0) + real(1 - F0) * edge5
        metal = (gloss[i] >= real(METAL)) & (gloss[i] < real(GLASS))
        coated = (gloss[i] >= real(SHARP)) & (gloss[i] < real(METAL))
        ends = metal & last
        f = f if coated | (gloss[i] >= real(GLASS)) else real(0)
        sr[i] += tr[i] * r[i] * (red[i] + (real(1) - red[i]) * edge5 if ends else f)
        sg[i] += tg[i] * g[i] * (green[i] + (real(1) - green[i]) * edge5 if ends else f)
        sb[i] += tb[i] * b[i] * (blue[i] + (real(1) - blue[i]) * edge5 if ends else f)
        under = real(1) - f if coated else real(1)
        red[i], green[i], blue[i] = red[i] * under, green[i] * under, blue[i] * under
