"""The farthest surfaces: an endless checkered floor, the sky, and the sun's disk.

A sky of three colours has the radiance horizon + m (zenith − horizon) along a unit direction whose component along `up`
is m ≥ 0, and `ground` below the horizon. A sky shown by an equirectangular picture (`ImageSky`) has at a direction d
the place u = ½ + atan2(x, −z) / 2π from the left and v = atan2(√(x² + z²), y) / π from the top, both in the frame of
the picture.
"""

import math

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import (
    A0, A1, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, PIXEL_SIDE, PIXEL_SPREAD, RED, B, L, M, N, Packed, Step, X,
    Y, Z, offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.scenery.intersect.texture import checker_contrast, footprint_stretch, parity
from lensbench.core.scenery.objects.surroundings import Floor, ImageSky, Sky, Sun
from lensbench.core.scenery.values import cross, unit

# AXIS_A, AXIS_B: unit axes along the tiles over the tile's edge (1/mm); SHIFT in tiles; COLOUR: mean of the two
# colours; HALF_DIFFERENCE: of the light colour and the dark; PER_TILE: 1 / the tile's edge (1/mm)
NORMAL, HEIGHT, AXIS_A, AXIS_B, SHIFT, COLOUR, HALF_DIFFERENCE, OWN_FINISH, PER_TILE, FLOOR = offsets(
    3, 1, 3, 3, 2, 3, 3, 1, 1)


def floor_axes(floor: Floor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit normal, and the two unit axes along the tiles."""
    normal = np.asarray(floor.normal, np.float64)
    normal = normal / math.sqrt(normal @ normal)
    along = cross(normal, (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (1.0, 0.0, 0.0))
    along /= math.sqrt(along @ along)
    across = cross(along, normal)
    c, s = math.cos(floor.turn), math.sin(floor.turn)
    return normal, c * along + s * across, c * across - s * along


def floor_parameters(floor: Floor) -> np.ndarray:
    """Parameters of the stage `floor`."""
    normal, a, b = floor_axes(floor)
    light, dark = np.array(floor.light), np.array(floor.dark)
    if floor.image is not None:
        light = dark = floor.image.mean
    return pack(FLOOR, {NORMAL: normal, HEIGHT: floor.height, AXIS_A: a / floor.tile, AXIS_B: b / floor.tile,
                        SHIFT: floor.offset, COLOUR: (light + dark) / 2, HALF_DIFFERENCE: (light - dark) / 2,
                        OWN_FINISH: floor.gloss, PER_TILE: 1.0 / floor.tile})


@njit(inline="always")
def tile_side(real, hx, hy, hz, dx, dy, dz, steep, wide, a_axis, b_axis, a0, b0, tile):
    """Colour of the floor at a point h seen along d, from −1 (dark) to 1 (light), averaged over the footprint.

    steep: 1 / (normal · d); wide: side of the pixel there, in tiles.
    """
    ax, ay, az = a_axis
    bx, by, bz = b_axis
    a, b = a0 + ax * hx + ay * hy + az * hz, b0 + bx * hx + by * hy + bz * hz
    wide_a = wide * footprint_stretch(real, (ax * dx + ay * dy + az * dz) * tile, steep)
    wide_b = wide * footprint_stretch(real, (bx * dx + by * dy + bz * dz) * tile, steep)
    odd = parity(real, np.floor(a) + np.floor(b))
    return (real(4) * odd - real(1)) * checker_contrast(real, a, b, wide_a, wide_b)


@stage(inlined=True)
def meet_floor(lanes, p):
    """Record the floor, but its colour, where it is the nearest surface. Returns how many rays meet it.

    A0: its distance, 0 for the other rays; A1: 1 / (normal · ray). p: floor_parameters.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    (ux, uy, uz), height, own_finish, met, slant = vector(p, NORMAL), p[HEIGHT], p[OWN_FINISH], row[A0], row[A1]
    count = np.int32(0)
    for i in range(B):
        steep = real(1) / (ux * dx[i] + uy * dy[i] + uz * dz[i])
        t = (height - (ux * x[i] + uy * y[i] + uz * z[i])) * steep
        hit = (t > real(0)) & (t < depth[i]) & (steep < real(0))
        met[i], slant[i] = t if hit else real(0), steep
        count = np.int32(count + np.int32(hit))
    if count == 0:
        return count
    for i in range(B):
        hit = met[i] > real(0)
        depth[i] = met[i] if hit else depth[i]
        emits[i] = real(0) if hit else emits[i]
        finish[i] = own_finish if hit else finish[i]
        nx[i], ny[i], nz[i] = ux if hit else nx[i], uy if hit else ny[i], uz if hit else nz[i]
    return count


@stage
def floor(lanes, p, ints, key):
    """Intersect rays with the floor, visible from above only; the nearest surface stays.  p: floor_parameters."""
    if meet_floor(lanes, p) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    red, green, blue, side, spread = row[RED], row[GREEN], row[BLUE], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    a_axis, b_axis, a0, b0, per = vector(p, AXIS_A), vector(p, AXIS_B), p[SHIFT], p[SHIFT + 1], p[PER_TILE]
    (mr, mg, mb), (hr, hg, hb) = vector(p, COLOUR), vector(p, HALF_DIFFERENCE)
    tile, met, slant = real(1) / per, row[A0], row[A1]
    for i in range(B):
        t, steep = met[i], slant[i]
        hit = t > real(0)
        hx, hy, hz = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        wide = abs(side[i] + t * spread[i]) * per
        light = tile_side(real, hx, hy, hz, dx[i], dy[i], dz[i], steep, wide, a_axis, b_axis, a0, b0, tile)
        red[i] = mr + light * hr if hit else red[i]
        green[i] = mg + light * hg if hit else green[i]
        blue[i] = mb + light * hb if hit else blue[i]


FAR = 1e9               # mm: DEPTH of the sky
SKY_DISTANCE = 1e8      # mm: what is farther counts as the sky
ZENITH, HORIZON, GROUND, UP, SKY = offsets(3, 3, 3, 3)
DIRECTION, CHORD2, RADIANCE, SUN_DISK = offsets(3, 1, 3)


def sky_parameters(sky: Sky) -> np.ndarray:
    """Radiances and unit up direction of a `Sky`."""
    return pack(SKY, {ZENITH: sky.zenith, HORIZON: sky.horizon, GROUND: sky.ground, UP: unit(sky.up)})


def sun_disk_parameters(sun: Sun, radius: float) -> np.ndarray:
    """Direction, squared chord and radiance of a `Sun` shown as a disk of this angular radius (radians)."""
    return pack(SUN_DISK, {DIRECTION: unit(sun.direction), CHORD2: (2.0 * math.sin(radius / 2)) ** 2,
                           RADIANCE: np.asarray(sun.colour) / math.sin(radius) ** 2})


@njit(inline="always")
def gradient(p, k):
    """Coefficients of the sky at p[k …]: radiance at the horizon, its change to the zenith, ground, up; 3 each."""
    (zr, zg, zb), (r, g, b) = vector(p, k + ZENITH), vector(p, k + HORIZON)
    return (r, g, b), (zr - r, zg - g, zb - b), vector(p, k + GROUND), vector(p, k + UP)


@njit(inline="always")
def sky_radiance(real, colours, x, y, z):
    """Radiance along a unit direction, from the coefficients of `gradient`."""
    (r, g, b), (dr, dg, db), (gr, gg, gb), (ux, uy, uz) = colours
    up = ux * x + uy * y + uz * z
    above = up >= real(0)
    return r + up * dr if above else gr, g + up * dg if above else gg, b + up * db if above else gb


@stage
def gradient_sky(lanes, p, ints, key):
    """Begin the intersection of rays: each sees the sky.  p: sky_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, red, green, blue = row[L], row[M], row[N], row[RED], row[GREEN], row[BLUE]
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    colours = gradient(p, 0)
    for i in range(B):          # one loop: a second one for the colours costs 3 % of a picture of spheres
        depth[i], emits[i], finish[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
        red[i], green[i], blue[i] = sky_radiance(real, colours, dx[i], dy[i], dz[i])


@stage
def sun_disk(lanes, p, ints, key):
    """Draw the sun on the sky, directly after the sky.  p: sun_disk_parameters.

    The squared chord |d − s|² = (2 sin α/2)² is exact in float32 where the cosine of so small an angle α is not.
    """
    row = rows(lanes)
    dx, dy, dz, red, green, blue = row[L], row[M], row[N], row[RED], row[GREEN], row[BLUE]
    (sx, sy, sz), chord2, (r, g, b) = vector(p, DIRECTION), p[CHORD2], vector(p, RADIANCE)
    for i in range(B):
        ax, ay, az = dx[i] - sx, dy[i] - sy, dz[i] - sz
        on_disk = ax * ax + ay * ay + az * az < chord2
        red[i] = r if on_disk else red[i]
        green[i] = g if on_disk else green[i]
        blue[i] = b if on_disk else blue[i]


# COSINE, SINE: of the turn. Integers: place and count of the texels, texels across and down
COSINE, SINE, BRIGHTNESS, IMAGE_SKY = offsets(1, 1, 1)
PLACE, COUNT, ACROSS, DOWN, SKY_INTEGERS = range(5)
_ATAN = (0.99999933, -0.33329856, 0.19946536, -0.13908534, 0.09642004, -0.05590983, 0.02186123, -0.00405406)


def sky_step(sky: Sky | ImageSky) -> Step:
    """The stage that begins the intersection of rays, below either kind of sky."""
    if isinstance(sky, ImageSky):
        return Step(image_sky, *image_sky_parameters(sky), kept=(sky.image.values,))
    return Step(gradient_sky, sky_parameters(sky))


def image_sky_parameters(sky: ImageSky) -> Packed:
    """Parameters of `look_up_sky`; who packs them keeps `sky.image.values` alive."""
    values = sky.image.values
    return Packed(pack(IMAGE_SKY, {COSINE: math.cos(sky.turn), SINE: math.sin(sky.turn), BRIGHTNESS: sky.brightness}),
                  [address(values), values.size, sky.image.width, sky.image.height])


@njit(inline="always")
def half_turn(real, y, x):
    """atan2(y, x) / π for y ≥ 0, in [0, 1], to 1e-8 (Abramowitz and Stegun 4.4.49)."""
    a, b = abs(x), y
    small, big = (a, b) if a < b else (b, a)
    low = small / (big + real(1e-30))
    q = low * low
    total = real(_ATAN[7])
    for k in range(6, -1, -1):
        total = total * q + real(_ATAN[k])
    angle = low * total * real(1 / math.pi)
    angle = real(0.5) - angle if b > a else angle
    return real(1) - angle if x < real(0) else angle


@njit(inline="always")
def sky_place(real, x, y, z, cosine, sine):
    """Place u, v of a direction in the picture, both in [0, 1]."""
    a, c = cosine * x - sine * z, sine * x + cosine * z
    turn = half_turn(real, abs(a), -c) * real(0.5)
    return real(0.5) + (turn if a > real(0) else -turn), half_turn(real, math.sqrt(a * a + c * c), y)


@stage
def look_up_sky(lanes, p, ints, x, y, z, r, g, b):
    """Radiance r, g, b of the picture along x, y, z (rows), bilinear between texels.  p, ints: image_sky_parameters."""
    real = lanes.dtype.type
    texels = borrowed(ints[PLACE], ints[COUNT], np.float32)
    across, down = real(ints[ACROSS]), real(ints[DOWN])
    wide, tall, right = np.uint64(ints[ACROSS]), np.uint64(ints[DOWN]), np.uint64(3)
    one, two = np.uint64(1), np.uint64(2)
    cosine, sine, brightness = p[COSINE], p[SINE], p[BRIGHTNESS]
    for i in range(B):
        u, v = sky_place(real, x[i], y[i], z[i], cosine, sine)
        x_, y_ = u * across - real(0.5), v * down - real(0.5)
        x_ = x_ if x_ >= real(0) else x_ + across
        y_ = y_ if y_ > real(0) else real(0)
        y_ = y_ if y_ < down - real(1) else down - real(1)
        r[i], g[i] = x_, y_
    for i in range(B):
        x_, y_ = r[i], g[i]
        x_ = x_ if x_ == x_ else real(0)                # a lane without a direction
        y_ = y_ if y_ == y_ else real(0)
        column, line = np.uint64(np.uint32(x_)), np.uint64(np.uint32(y_))
        s, t = x_ - real(np.uint32(column)), y_ - real(np.uint32(line))
        column = column if column < wide else wide - one
        beside = column + one if column + one < wide else np.uint64(0)
        below = line + one if line + one < tall else line
        k, m = (line * wide + column) * right, (line * wide + beside) * right
        q, w = (below * wide + column) * right, (below * wide + beside) * right
        e, f, h, j = (real(1) - s) * (real(1) - t), s * (real(1) - t), (real(1) - s) * t, s * t
        r[i] = brightness * (e * real(texels[k]) + f * real(texels[m]) + h * real(texels[q]) + j * real(texels[w]))
        g[i] = brightness * (e * real(texels[k + one]) + f * real(texels[m + one]) + h * real(texels[q + one])
                             + j * real(texels[w + one]))
        b[i] = brightness * (e * real(texels[k + two]) + f * real(texels[m + two]) + h * real(texels[q + two])
                             + j * real(texels[w + two]))


@stage
def image_sky(lanes, p, ints, key):
    """Begin the intersection of rays: each sees the picture of the sky.  p, ints: image_sky_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    for i in range(B):
        depth[i], emits[i], finish[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
    look_up_sky(lanes, p, ints, row[L], row[M], row[N], row[RED], row[GREEN], row[BLUE])
