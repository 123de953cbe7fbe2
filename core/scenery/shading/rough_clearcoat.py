"""Rough clear coats: what they reflect, spread over their facets: slopes distributed as by Trowbridge and Reitz.

The slopes have the density 1 / (π α² (1 + tan² / α²)²), α = 1 − gloss; at grazing incidence facets hide each other as
Smith has it. Lights are reflected in closed form, each lane those of its TIME. Of a picture of the sky a sample takes
two directions: one that a facet mirrors, which is visible from the camera, and one of a bright place of the picture.
Both are weighted by the balance heuristic (Veach), so that neither a wide lobe nor a small sun makes noise that the
other does not take away.
"""

import math
from collections.abc import Iterable

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, BLUE, DEPTH, FINISH, GREEN, NX, NY, NZ, OX, OY, OZ, PIXEL_SIDE,
    PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD, RED, SB, SG, SR, TB, TG, TR, V0, V1, B, L, M, N, Packed, Step, X, Y, Z,
    offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect import sky as ground
from lensbench.core.scenery.intersect.moving_objects import (
    COUNT, LENGTH, MOTION, after, enter_rest_frame, keep_world, leave_rest_frame, motion_of, moving_groups
)
from lensbench.core.scenery.intersect.sky import (
    IMAGE_SKY, SKY, SKY_INTEGERS, gradient, image_sky_parameters, look_up_sky, sky_radiance
)
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.objects.surroundings import ImageSky
from lensbench.core.scenery.shading.illumination import F0, schlick_edge
from lensbench.core.scenery.shading.image_sky_light import (
    CELL_INTEGERS, COSINE, SINE, SKY_LIGHT, sky_density, sky_rays, sky_rays_step
)
from lensbench.core.scenery.surface_codes import is_rough_coat

CENTRE, FACING_AREA, COLOUR, HIGHLIGHT = offsets(3, 1, 3)       # FACING_AREA: of the light as a disk, over π (mm²)
# Rows of what `rough_lights` knows of each coated lane. POINT, and its frame: ACROSS, ALONG, NORMAL;
# ACROSS_WAY, ALONG_WAY: of the ray's direction; VIEW: cosine of incidence; ALPHA2: width² of the lobe; HIDDEN:
# `smith_sum` of the ray over 2; PUPIL, PIXEL: half-widths of the part of the pupil and of the pixel at the surface, the
# latter over √3, and their growth per mm; SUM: what the lane reflects. Then, of one light: slopes² and half-width² in
# widths of the lobe, and two factors of its brightness
(POINT, ACROSS, ALONG, NORMAL, ACROSS_WAY, ALONG_WAY, VIEW, ALPHA2, HIDDEN, PUPIL, PUPIL_FAN, PIXEL, PIXEL_FAN, SUM,
 ACROSS2, ALONG2, REACH2, NUMERATOR, DENOMINATOR, KNOWN) = offsets(
    3, 3, 3, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 3, 1, 1, 1, 1, 1)
PART = 128              # lanes at a time, whose rows the first-level cache holds
REGISTER = 16           # lanes of the widest vector register
FLATTEST, FARTHEST = 0.1, 0.9       # ray through the middle: least cosine over the sample's, greatest change of length
WIDEST = 1.0            # slope²: greatest half-width of a sample's part, half a right angle
DARK = 1e8              # of lobe widths²: beyond, a light is black, and single precision soon overflows
STRAIGHT2 = 1e-10       # sin² of incidence: below, the plane of incidence is a matter of rounding


def rough_clearcoat_step(sky: np.ndarray, lights: Iterable[Shape], opening: float) -> Step:
    """The stage `rough_clearcoat`. sky: sky_parameters; opening: seconds at TIME 0."""
    lights = list(lights)
    still = np.concatenate([sky, highlight_parameters(o for o in lights if not o.moves)])
    moved = moving_groups([o for o in lights if o.moves], opening,
                          lambda spheres, planar: Packed(highlight_parameters([*spheres, *planar])))
    return Step(rough_clearcoat, *after(Packed(still), moved))


def highlight_parameters(lights: Iterable[Shape]) -> np.ndarray:
    """Parameters of `rough_lights`: every light as a disk that faces the surface."""
    return np.concatenate([np.zeros(0), *(pack(HIGHLIGHT, {CENTRE: o.centre, FACING_AREA: o.area / math.pi,
                                                           COLOUR: o.material.colour}) for o in lights)])


@stage
def rough_clearcoat(lanes, p, ints, key):
    """Add what coats of a gloss below 1 reflect of the lights, and of the sky as if they were smooth.

    A light of solid angle Ω is reflected by slopes of the area Ω / (4 cos θ cos³ δ), with δ the tilt of the facet half
    way; that area widens α, so that a large light is never brighter than itself. p, ints: rough_clearcoat_step.
    """
    if rough_open(lanes, p) == 0:
        return
    s, k = ints[0], 1
    rough_lights(lanes, p[SKY:s])
    if s < p.size:
        keep_world(lanes, A0, L, True)
        while s < p.size:
            end = s + ints[k + LENGTH]
            enter_rest_frame(lanes, motion_of(p, s), A0, L, True)
            rough_lights(lanes, p[s + MOTION:end])
            s, k = end, k + ints[k + COUNT]
        leave_rest_frame(lanes, A0, L, True)
    rough_close(lanes)


@njit(inline="always")
def smith_sum(real, alpha2, cosine):
    """2 cos θ over the part of the facets that others do not hide at this angle of incidence (Smith 1967)."""
    return cosine + math.sqrt(alpha2 + (real(1) - alpha2) * cosine * cosine)


@njit(inline="always")
def lobe_mean(real, place2, reach2, width2):
    """Mean of 1 / (1 + x² / w²)² from x − h to x + h as a, b, c, d of a / b · √(c / d).

    place2, reach2, width2: x², h² and w², in any one unit. A sine of spherical caps,
    J = (1 − q / √(q² + 4 w² h²)) / 2 with q = w² + x² − h², is that lobe for small h and a box for small w; its
    integral over x is π/2 h² / (w k), k² = 1 + t (3/4 + (π² / 64) t) / (1 + t / 4) within a hundredth, t = h² / w².
    """
    q = width2 + place2 - reach2
    long = math.sqrt(q * q + real(4) * width2 * reach2)
    outside, most = q > real(0), width2 * (width2 + real(0.25) * reach2)
    return (real(2) * width2 * width2 if outside else real(0.5) * width2 * (long - q),
            long * (long + q if outside else reach2),
            most + reach2 * (real(0.75) * width2 + real(math.pi**2 / 64) * reach2), most)


@njit(inline="always")
def reflectance(real, cosine):
    """Schlick's reflectance of a facet."""
    edge = real(1) - (cosine if cosine > real(0) else real(0))
    edge2 = edge * edge
    return real(F0) + real(1 - F0) * edge2 * edge2 * edge


@stage(inlined=True)
def count_rough(lanes):
    """How many lanes have a rough coat."""
    real = lanes.dtype.type
    finish, count = rows(lanes)[FINISH], np.int32(0)
    for i in range(B):
        count = np.int32(count + np.int32(is_rough_coat(real, finish[i])))
    return count


@stage
def rough_open(lanes, p):
    """Points that reflect, A0 A1 A2, and what they reflect of the sky, A3 A4 A5. Returns how many there are.

    The points lie on the rays through the middles of the parts of the pupil that the samples represent. Until
    `rough_close`, L M N are the directions of these rays and A6 A7 A8 those of the samples.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, nx, ny, nz = row[DEPTH], row[NX], row[NY], row[NZ]
    hx, hy, hz, r, g, b = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    count = count_rough(lanes)
    if count == 0:
        return count
    disk, fan, ox, oy, oz = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[OX], row[OY], row[OZ]
    kept_x, kept_y, kept_z = row[A6], row[A7], row[A8]
    for i in range(B):
        ux, uy, uz, vx, vy, vz, t = nx[i], ny[i], nz[i], dx[i], dy[i], dz[i], depth[i]
        kept_x[i], kept_y[i], kept_z[i] = vx, vy, vz
        view = -(vx * ux + vy * uy + vz * uz)
        # The ray through the middle, and where it meets the plane; beyond the horizon, the sample's own ray
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

    # Reflect the sky as a smooth coat does
    colours = gradient(p, 0)
    for i in range(B):
        view = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        f = reflectance(real, view)
        mx, my, mz = dx[i] + real(2) * view * nx[i], dy[i] + real(2) * view * ny[i], dz[i] + real(2) * view * nz[i]
        er, eg, eb = sky_radiance(real, colours, mx, my, mz)
        r[i], g[i], b[i] = f * er, f * eg, f * eb
    return count


@stage(allocates=True)
def rough_lights(lanes, p):
    """Add lights to A3 A4 A5, each averaged over the part of pupil and pixel.  p: highlight_parameters.

    Each light takes two short loops over PART lanes: of one long chain of operations the processor would have only one
    under way.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    known, which = np.empty(KNOWN * PART, real), np.empty(B, np.int32)
    count = coated_lanes(lanes, which)
    r, g, b = row[A3], row[A4], row[A5]
    for start in range(0, count, PART):
        n = min(PART, count - start)
        know(lanes, which[start:], known, n)
        for s in range(0, p.size, HIGHLIGHT):
            aim_highlight(known, n, vector(p, s + CENTRE), p[s + FACING_AREA])
            add_highlight(known, n, vector(p, s + COLOUR))
        for i in range(n):
            k = which[start + i]
            r[k], g[k], b[k] = known[SUM * PART + i], known[(SUM + 1) * PART + i], known[(SUM + 2) * PART + i]


@njit(inline="always")
def aim_highlight(known, n, centre, size):
    """What n lanes know of a light before it is averaged over pupil and pixel: rows ACROSS2 to DENOMINATOR.

    centre: of the light, mm; size: its FACING_AREA. In the frame of a lane the ray has the direction (ACROSS_WAY,
    ALONG_WAY, -VIEW), and the slopes of the facets that mirror the light to it are across / fall and along / fall.
    """
    real = known.dtype.type
    cx, cy, cz = centre
    for i in range(n):
        view, alpha2 = known[VIEW * PART + i], known[ALPHA2 * PART + i]
        qx, qy, qz = (cx - known[POINT * PART + i], cy - known[(POINT + 1) * PART + i],
                      cz - known[(POINT + 2) * PART + i])
        across = (qx * known[ACROSS * PART + i] + qy * known[(ACROSS + 1) * PART + i]
                  + qz * known[(ACROSS + 2) * PART + i])
        along = (qx * known[ALONG * PART + i] + qy * known[(ALONG + 1) * PART + i]
                 + qz * known[(ALONG + 2) * PART + i])
        height = (qx * known[NORMAL * PART + i] + qy * known[(NORMAL + 1) * PART + i]
                  + qz * known[(NORMAL + 2) * PART + i])
        inverse = real(1) / math.sqrt(across * across + along * along + height * height)
        slant = height * inverse
        across = across * inverse - known[ACROSS_WAY * PART + i]
        along = along * inverse - known[ALONG_WAY * PART + i]
        fall = slant + view
        across2, along2, fall2 = across * across, along * along, fall * fall
        k2 = across2 + along2 + fall2                   # (2 cos θ)²
        pupil = inverse * known[PUPIL * PART + i] + known[PUPIL_FAN * PART + i]
        pixel = inverse * known[PIXEL * PART + i] + known[PIXEL_FAN * PART + i]
        reach2 = pupil * pupil + pixel * pixel
        reach2 = reach2 if reach2 < real(WIDEST) * fall2 else real(WIDEST) * fall2
        # The light takes an area of the slopes; all in widths of the lobe, which no number overflows at grazing angles
        taken = real(0.5) * size * inverse * inverse * k2           # times fall³: that area, over π
        unit = real(1) / (alpha2 * fall2 * fall + taken)
        narrow = unit * fall
        f = reflectance(real, real(0.5) * math.sqrt(k2))
        known[ACROSS2 * PART + i], known[ALONG2 * PART + i] = across2 * narrow, along2 * narrow
        known[REACH2 * PART + i] = reach2 * narrow
        known[NUMERATOR * PART + i] = f * taken * unit * k2 * slant if (slant > real(0)) & (view > real(0)) else real(0)
        # Of the facets that mirror the light, those that neither the ray nor the light misses
        known[DENOMINATOR * PART + i] = fall * known[HIDDEN * PART + i] * smith_sum(real, alpha2, slant)


@njit(inline="always")
def add_highlight(known, n, colour):
    """Add a light of that colour to the SUM of each of n lanes, after `aim_highlight`."""
    real = known.dtype.type
    er, eg, eb = colour
    for i in range(n):
        view, reach2 = known[VIEW * PART + i], known[REACH2 * PART + i]
        deep = real(1) + reach2 * view * view           # along, the part is shorter by the cosine
        low = deep + known[ALONG2 * PART + i]
        top, bottom, more, most = lobe_mean(real, known[ACROSS2 * PART + i] * deep, real(0.75) * reach2 * deep, low)
        bright = top * deep * deep * (math.sqrt(more) / math.sqrt(most * deep))     # faster than the root of the ratio
        share = known[NUMERATOR * PART + i] * bright / (known[DENOMINATOR * PART + i] * bottom * low * low)
        share = share if (known[NUMERATOR * PART + i] > real(0)) & (low < real(DARK)) else real(0)
        known[SUM * PART + i] += share * er
        known[(SUM + 1) * PART + i] += share * eg
        known[(SUM + 2) * PART + i] += share * eb


@stage
def coated_lanes(lanes, which):
    """Put the numbers of the lanes with a rough coat into `which`; returns how many there are.

    They are filled up to whole registers by copies of the last one.
    """
    real = lanes.dtype.type
    finish, n = rows(lanes)[FINISH], 0
    for i in range(B):
        which[n] = i
        n += 1 if is_rough_coat(real, finish[i]) else 0
    last = which[n - 1]
    while n % REGISTER:
        which[n] = last
        n += 1
    return n


@stage
def know(lanes, which, known, n):
    """Copy what `rough_lights` reads of n lanes to KNOWN rows of PART."""
    real = lanes.dtype.type
    row = rows(lanes)
    for i in range(n):
        k = which[i]
        t, alpha = row[DEPTH, k], real(1) - row[FINISH, k]
        dx, dy, dz, nx, ny, nz = row[L, k], row[M, k], row[N, k], row[NX, k], row[NY, k], row[NZ, k]
        # Across the plane of incidence, along it and up; of a ray straight down, any two directions across
        ax, ay, az = dy * nz - dz * ny, dz * nx - dx * nz, dx * ny - dy * nx
        straight, upright = ax * ax + ay * ay + az * az < real(STRAIGHT2), nx * nx < real(0.5)
        ax = (real(0) if upright else nz) if straight else ax
        ay = (-nz if upright else real(0)) if straight else ay
        az = (ny if upright else -nx) if straight else az
        size = real(1) / math.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax * size, ay * size, az * size
        lean = ax * nx + ay * ny + az * nz              # by rounding, of a ray almost straight down
        ax, ay, az = ax - lean * nx, ay - lean * ny, az - lean * nz
        size = real(1) / math.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax * size, ay * size, az * size
        bx, by, bz = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
        known[ACROSS * PART + i], known[(ACROSS + 1) * PART + i], known[(ACROSS + 2) * PART + i] = ax, ay, az
        known[ALONG * PART + i], known[(ALONG + 1) * PART + i], known[(ALONG + 2) * PART + i] = bx, by, bz
        known[NORMAL * PART + i], known[(NORMAL + 1) * PART + i], known[(NORMAL + 2) * PART + i] = nx, ny, nz
        known[POINT * PART + i], known[(POINT + 1) * PART + i], known[(POINT + 2) * PART + i] = (
            row[A0, k], row[A1, k], row[A2, k])
        known[ACROSS_WAY * PART + i] = dx * ax + dy * ay + dz * az
        known[ALONG_WAY * PART + i] = dx * bx + dy * by + dz * bz
        view = -(dx * nx + dy * ny + dz * nz)
        known[VIEW * PART + i], known[ALPHA2 * PART + i] = view, alpha * alpha
        known[HIDDEN * PART + i] = real(0.5) * smith_sum(real, alpha * alpha, view)
        fan, spread = row[PUPIL_SPREAD, k], real(math.sqrt(1 / 3)) * row[PIXEL_SPREAD, k]
        known[PUPIL * PART + i], known[PUPIL_FAN * PART + i] = row[PUPIL_RADIUS, k] + t * fan, fan
        known[PIXEL * PART + i] = real(math.sqrt(1 / 3)) * row[PIXEL_SIDE, k] + t * spread
        known[PIXEL_FAN * PART + i] = spread
        known[SUM * PART + i], known[(SUM + 1) * PART + i], known[(SUM + 2) * PART + i] = (
            row[A3, k], row[A4, k], row[A5, k])


@stage
def rough_close(lanes):
    """Add what is reflected to the path; an albedo under a coat gets what the coat transmits."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, finish, nx, ny, nz = row[L], row[M], row[N], row[FINISH], row[NX], row[NY], row[NZ]
    red, green, blue, tr, tg, tb, sr, sg, sb = (row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB],
                                                row[SR], row[SG], row[SB])
    r, g, b, kept_x, kept_y, kept_z = row[A3], row[A4], row[A5], row[A6], row[A7], row[A8]
    for i in range(B):
        dx[i], dy[i], dz[i] = kept_x[i], kept_y[i], kept_z[i]
        coated = is_rough_coat(real, finish[i])
        sr[i] += tr[i] * r[i] if coated else real(0)
        sg[i] += tg[i] * g[i] if coated else real(0)
        sb[i] += tb[i] * b[i] if coated else real(0)
        edge5 = schlick_edge(real, -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i]))
        under = real(1 - F0) * (real(1) - edge5) if coated else real(1)
        red[i], green[i], blue[i] = red[i] * under, green[i] * under, blue[i] * under


# CELLS: numbers of `sky_rays`, PICTURE: of `look_up_sky`, then the unit normal of the floor, its height, its radiance
CELLS, PICTURE, FLOOR_NORMAL, HEIGHT, RADIANCE, ROUGH_SKY = offsets(SKY_LIGHT, IMAGE_SKY, 3, 1, 3)
HAS_FLOOR = CELL_INTEGERS + SKY_INTEGERS        # integer after those of the cells and of the picture


def image_rough_clearcoat_step(sky: ImageSky, floor: np.ndarray | None, floor_light: np.ndarray) -> Step:
    """The stage `image_rough_clearcoat`.

    floor: floor_parameters or None; floor_light: irradiance / π on it (3).
    """
    cells, picture = sky_rays_step(sky), image_sky_parameters(sky)
    below = {} if floor is None else {FLOOR_NORMAL: floor[ground.NORMAL:ground.NORMAL + 3],
                                      HEIGHT: floor[ground.HEIGHT],
                                      RADIANCE: floor[ground.COLOUR:ground.COLOUR + 3] * floor_light}
    return Step(image_rough_clearcoat, pack(ROUGH_SKY, {CELLS: cells.parameters, PICTURE: picture.parameters, **below}),
                np.concatenate([cells.integers, picture.integers, [floor is not None]]),
                kept=(cells.kept, sky.image.values))


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
    if count_rough(lanes) > 0:
        _mirror_bright_place(lanes, p, ints, key)
        _mirror_facet(lanes, p, ints)


@stage
def _mirror_bright_place(lanes, p, ints, key):
    """Add what the facets mirror of a bright place of the picture, not hidden by the floor, and leave the points."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, nx, ny, nz, finish = row[L], row[M], row[N], row[NX], row[NY], row[NZ], row[FINISH]
    hx, hy, hz, wx, wy, wz, chance = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6]
    r, g, b, tr, tg, tb, sr, sg, sb = (row[A8], row[A9], row[A10], row[TR], row[TG], row[TB], row[SR], row[SG], row[SB])
    has_floor, (ux, uy, uz), height = ints[HAS_FLOOR] != 0, vector(p, FLOOR_NORMAL), p[HEIGHT]
    sky_rays(lanes, p, ints, key)
    sky_density(lanes, ints, p[CELLS + COSINE], p[CELLS + SINE], chance)
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
        mirrored = reflectance(real, real(0.5) * size) * density * shown(real, alpha2, slant)
        mirrored *= real(math.pi) * chance[i] / (chance[i] + density)       # r, g, b hold the flux over π
        mirrored = mirrored if met & ~hidden else real(0)
        sr[i] += tr[i] * mirrored * r[i] if mirrored > real(0) else real(0)
        sg[i] += tg[i] * mirrored * g[i] if mirrored > real(0) else real(0)
        sb[i] += tb[i] * mirrored * b[i] if mirrored > real(0) else real(0)


@stage
def _mirror_facet(lanes, p, ints):
    """Add what a facet mirrors of picture and floor, one of those that the ray sees (Dupuy and Benyoub 2023)."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, nx, ny, nz, finish = row[L], row[M], row[N], row[NX], row[NY], row[NZ], row[FINISH]
    hx, hy, hz, wx, wy, wz, chance = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6]
    r, g, b, share, v0, v1 = row[A8], row[A9], row[A10], row[A7], row[V0], row[V1]
    tr, tg, tb, sr, sg, sb = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB]
    has_floor = ints[HAS_FLOOR] != 0
    (ux, uy, uz), height, (er, eg, eb) = vector(p, FLOOR_NORMAL), p[HEIGHT], vector(p, RADIANCE)

    # In the frame of the surface and the ray
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
        mirrored = reflectance(real, facing) * shown(real, alpha2, slant)
        share[i] = mirrored if met else real(0)
        r[i] = facet_density(real, alpha2, fz, view)

    # The floor, and the picture beside it
    sky_density(lanes, ints, p[CELLS + COSINE], p[CELLS + SINE], chance)
    for i in range(B):
        up, over = ux * wx[i] + uy * wy[i] + uz * wz[i], ux * hx[i] + uy * hy[i] + uz * hz[i] - height
        hidden = has_floor & (up < real(0)) & (over > real(0))
        mirrored = share[i] if share[i] > real(0) else real(0)
        fallen = mirrored if hidden else real(0)
        sr[i] += tr[i] * fallen * er
        sg[i] += tg[i] * fallen * eg
        sb[i] += tb[i] * fallen * eb
        share[i] = real(0) if hidden else mirrored * r[i] / (r[i] + chance[i])
    look_up_sky(lanes, p[PICTURE:], ints[CELL_INTEGERS:], wx, wy, wz, r, g, b)
    for i in range(B):
        mirrored = share[i] if share[i] > real(0) else real(0)
        sr[i] += tr[i] * mirrored * r[i]
        sg[i] += tg[i] * mirrored * g[i]
        sb[i] += tb[i] * mirrored * b[i]
