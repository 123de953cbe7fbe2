"""Light of many lamps at rest: a sample takes PICKS of them, chosen by an estimate of their light, instead of all.

The lit lanes of a block are grouped: those of a chunk of neighbouring pixels, halved where they lie at two depths. In
each group a lamp weighs what it would give without shadows, estimated from a box around the points and the mean of
their normals. A sample takes lamps at PICKS even steps of the cumulative weights: V0 sets where the steps begin, and
its rest the point of the lamp. What a lamp gives is divided by how often it is taken, so that the mean over V0 is the
sum of all lamps, whatever they weigh; a lamp with a large share is taken several times.
"""

import math
from collections.abc import Sequence

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, BLUE, DEPTH, GREEN, H0, H1, H2, H3, H4, H5, H6, H7, H8, NX, NY,
    NZ, RED, V0, V1, B, Packed, Step, gather, join, offsets, rows, stage
)
from lensbench.core.kernels.sampling import STRIP_WIDTH, concentric_disk
from lensbench.core.scenery.intersect.block_bounds import widen
from lensbench.core.scenery.intersect.spheres import sphere_tree
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.shading.illumination import met_points
from lensbench.core.scenery.shading.image_sky_light import add_tinted
from lensbench.core.scenery.shading.soft_shadows import shadows, sphere_point

WIDE, HIGH = 8, 4       # pixels of a chunk, in a strip of the film of full width
CHUNKS = B // (WIDE * HIGH)
GROUPS = 2 * CHUNKS
DEEP = 1.1              # greatest depth of a chunk over its least, from which on it is halved
STEPS = 8.0             # of a millimetre: bounds are found of integers, as in `block_bounds`
FINE = 1024.0           # steps of a component of a normal
MOST = 1 << 30
# A group: middle and half-widths of the box around its points, mm, and the mean of their normals
BOX_MIDDLE, BOX_HALF, NORMAL, GROUP = offsets(3, 3, 3)


@stage
def group_lanes(lanes, groups, counts):
    """Find the points A0 A1 A2 and the group A11 of each lane, and bound the groups; counts: lit lanes of each."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, nx, ny, nz, red, green, blue = row[DEPTH], row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    hx, hy, hz, number = row[A0], row[A1], row[A2], row[A11]
    met_points(lanes)
    most, least, step, fine = np.int32(MOST), np.int32(-MOST), real(STEPS), real(FINE)
    for c in range(CHUNKS):
        first = c // (STRIP_WIDTH // WIDE) * (HIGH * STRIP_WIDTH) + c % (STRIP_WIDTH // WIDE) * WIDE

        # Halve the lit lanes by depth
        near, far = most, np.int32(0)
        for k in range(HIGH):
            for e in range(WIDE):
                i = first + k * STRIP_WIDTH + e
                inside = red[i] + green[i] + blue[i] > real(0)
                t = np.int32(depth[i] * step if inside else real(0))
                near, far = min(near, t if inside else most), max(far, t)
        halved = real(far) > real(DEEP) * real(near)
        cut = math.sqrt(real(near) * real(far)) / step if halved else real(math.inf)
        counts[2 * c + 1] = 0

        # Bound each half
        for side in range(2 if halved else 1):
            x0, x1, y0, y1, z0, z1 = most, least, most, least, most, least
            sx, sy, sz, lit = np.int32(0), np.int32(0), np.int32(0), np.int32(0)
            for k in range(HIGH):
                for e in range(WIDE):
                    i = first + k * STRIP_WIDTH + e
                    beyond = depth[i] > cut
                    inside = (red[i] + green[i] + blue[i] > real(0)) & (beyond == (side == 1))
                    x0, x1 = widen(real, x0, x1, hx[i] * step, inside)
                    y0, y1 = widen(real, y0, y1, hy[i] * step, inside)
                    z0, z1 = widen(real, z0, z1, hz[i] * step, inside)
                    sx = np.int32(sx + np.int32(nx[i] * fine if inside else real(0)))
                    sy = np.int32(sy + np.int32(ny[i] * fine if inside else real(0)))
                    sz = np.int32(sz + np.int32(nz[i] * fine if inside else real(0)))
                    lit = np.int32(lit + np.int32(inside))
                    number[i] = real(2 * c + 1) if beyond else real(2 * c)
            g = 2 * c + side
            counts[g] = lit
            box, half = groups[g * GROUP:], real(0.5) / step
            per = real(1) / (fine * real(max(lit, np.int32(1))))
            box[BOX_MIDDLE], box[BOX_HALF] = (real(x0) + real(x1)) * half, (real(x1) - real(x0)) * half
            box[BOX_MIDDLE + 1], box[BOX_HALF + 1] = (real(y0) + real(y1)) * half, (real(y1) - real(y0)) * half
            box[BOX_MIDDLE + 2], box[BOX_HALF + 2] = (real(z0) + real(z1)) * half, (real(z1) - real(z0)) * half
            box[NORMAL], box[NORMAL + 1], box[NORMAL + 2] = real(sx) * per, real(sy) * per, real(sz) * per


MANY_LAMPS = 48         # lamps of which a sample takes all: about here both ways have the same noise in equal time
PICKS = 4               # lamps that a sample takes of more
LEAST = 0.05            # least cosine in a weight: the lamp may shine on some point of the group
BLUNT = 0.2             # least distance² in a weight over the square of the half-diagonal of the group's box

# The table of lamps, each column as long as there are lamps. AREA: largest silhouette / π, mm²; POWER: that times the
# mean radiance; RADIUS: of a sphere around the lamp. FACING, HALF_A, HALF_B: normal and half-axes of a planar lamp, 0
# of a sphere; FLAT: AREA over that of the parallelogram of the half-axes, 1 of a disk; BALL: radius² of a sphere, 0
# of a planar lamp
AREA, POWER, RADIUS, MIDDLE, FACING, HALF_A, HALF_B, FLAT, BALL, RADIANCE, COLUMNS = offsets(
    1, 1, 1, 3, 3, 3, 3, 1, 1, 3)
COUNT, SPHERES, LAMP_INTEGERS = range(3)        # integers: how many lamps, and how many of them are spheres


def has_a_share(lamp: Shape) -> bool:
    """Whether `many_lamps` reads the numbers of a lamp, which stands still."""
    return not lamp.moves and lamp.family in ("sphere", "planar")


def many_lamp_steps(lamps: Sequence[Shape], occluders: Packed, shade: Sequence[Step]) -> list[Step]:
    """Stages of the light of many lamps that have a share.

    occluders: all_occluders; shade: stages of the shadows of other shapes. Without these one stage does all, and
    finds the shares of the lamps once for all PICKS.
    """
    table = _table([o for o in lamps if any(o.material.colour)])
    if not shade:
        return [Step(many_lamps, *join(table, occluders))]
    return [step for pick in range(PICKS) for step in (
        Step(many_lamp_rays, *join(table, Packed(np.zeros(0), [pick]))), Step(shadows, *occluders), *shade,
        Step(add_tinted))]


def _table(lamps: Sequence[Shape]) -> Packed:
    """The table of lamps, neighbours in space next to each other: even steps then take lamps from everywhere."""
    lamps = [lamps[entry.members[0]] for entry in sphere_tree(np.array([o.centre for o in lamps])) if not entry.below]
    table = np.zeros((COLUMNS, len(lamps)))
    for j, o in enumerate(lamps):
        table[AREA, j], table[RADIUS, j] = o.area / math.pi, o.bounding_radius
        table[POWER, j] = table[AREA, j] * np.mean(o.material.colour)
        table[MIDDLE:MIDDLE + 3, j], table[RADIANCE:RADIANCE + 3, j] = o.centre, o.material.colour
        if o.family == "sphere":
            table[BALL, j] = o.bounding_radius**2
            continue
        a, b = np.asarray(o.half_axes)
        normal = np.cross(a, b)
        size = np.linalg.norm(normal)
        # Exactly 1 of a disk: what is greater marks a rectangle, and the quotient is rounded
        table[FACING:FACING + 3, j], table[FLAT, j] = normal / size, 1.0 if o.round else table[AREA, j] / size
        table[HALF_A:HALF_A + 3, j], table[HALF_B:HALF_B + 3, j] = a, b
    return Packed(table.ravel(), [len(lamps), sum(o.family == "sphere" for o in lamps)])


@stage
def many_lamps(lanes, p, ints, key):
    """Add the light of many lamps.

    p, ints: their table, then all_occluders.
    """
    count, balls = ints[COUNT], ints[SPHERES]
    shares = lamp_shares(lanes, p, count)
    for pick in range(PICKS):
        choose_lamps(lanes, shares, count, pick)
        sample_lamps(lanes, p, count, balls)
        shadows(lanes, p[COLUMNS * count:], ints[LAMP_INTEGERS:], key)
        add_tinted(lanes, p, ints, key)


@stage
def many_lamp_rays(lanes, p, ints, key):
    """Sample one of the PICKS lamps: A0 … A7 as `shadow` reads them, radiance A8 A9 A10.

    p: the table of lamps. ints: its own, then which of the PICKS.
    """
    shares = lamp_shares(lanes, p, ints[COUNT])
    choose_lamps(lanes, shares, ints[COUNT], ints[LAMP_INTEGERS])
    sample_lamps(lanes, p, ints[COUNT], ints[SPHERES])


@stage(allocates=True)
def lamp_shares(lanes, p, count):
    """Group the lanes; cumulative weights of the lamps in each group, GROUPS × (0, then `count`).

    A group without lit lanes has zeros.
    """
    real = lanes.dtype.type
    groups, counts = np.empty(GROUPS * GROUP, real), np.empty(GROUPS, np.int32)
    group_lanes(lanes, groups, counts)
    pitch = count + 1
    shares = np.zeros(GROUPS * pitch, real)
    area, power, radius = p[AREA * count:], p[POWER * count:], p[RADIUS * count:]
    cx, cy, cz = p[MIDDLE * count:], p[(MIDDLE + 1) * count:], p[(MIDDLE + 2) * count:]
    ux, uy, uz = p[FACING * count:], p[(FACING + 1) * count:], p[(FACING + 2) * count:]
    for g in range(GROUPS):
        if counts[g] == 0:
            continue
        box, own = groups[g * GROUP:], shares[g * pitch + 1:(g + 1) * pitch]
        mx, my, mz = box[BOX_MIDDLE], box[BOX_MIDDLE + 1], box[BOX_MIDDLE + 2]
        hx, hy, hz = box[BOX_HALF], box[BOX_HALF + 1], box[BOX_HALF + 2]
        nx, ny, nz = box[NORMAL], box[NORMAL + 1], box[NORMAL + 2]
        half2 = hx * hx + hy * hy + hz * hz
        half, floor, loose = math.sqrt(half2), real(BLUNT) * half2, real(1) - math.sqrt(nx * nx + ny * ny + nz * nz)
        for j in range(count):
            qx, qy, qz = cx[j] - mx, cy[j] - my, cz[j] - mz
            per = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz + real(1e-12))
            wider = (half + radius[j]) * per                        # cosines may be greater for other points
            cosine = (nx * qx + ny * qy + nz * qz) * per + loose + wider
            facing = abs(ux[j] * qx + uy[j] * qy + uz[j] * qz) * per + wider
            planar = ux[j] * ux[j] + uy[j] * uy[j] + uz[j] * uz[j] > real(0.5)
            facing = facing if planar else real(1)
            cosine = min(max(cosine, real(LEAST)), real(1)) * min(max(facing, real(LEAST)), real(1))
            ax, ay, az = max(abs(qx) - hx, real(0)), max(abs(qy) - hy, real(0)), max(abs(qz) - hz, real(0))
            own[j] = power[j] * cosine / max(ax * ax + ay * ay + az * az, max(area[j], floor))

    # Add up the weights of four groups at a time
    for g in range(0, GROUPS, 4):
        if counts[g] + counts[g + 1] + counts[g + 2] + counts[g + 3] == 0:
            continue
        a, b = shares[g * pitch:(g + 1) * pitch], shares[(g + 1) * pitch:(g + 2) * pitch]
        c, d = shares[(g + 2) * pitch:(g + 3) * pitch], shares[(g + 3) * pitch:(g + 4) * pitch]
        at_a, at_b, at_c, at_d = real(0), real(0), real(0), real(0)
        for j in range(1, pitch):
            at_a, at_b, at_c, at_d = at_a + a[j], at_b + b[j], at_c + c[j], at_d + d[j]
            a[j], b[j], c[j], d[j] = at_a, at_b, at_c, at_d
    return shares


@stage
def choose_lamps(lanes, shares, count, pick):
    """Choose a lamp for each lane: H8 its number, A7 the rest of V0, A8 what its light is multiplied by."""
    real = lanes.dtype.type
    row = rows(lanes)
    v0, group, number, rest, worth = row[V0], row[A11], row[H8], row[A7], row[A8]
    pitch = np.uint64(count + 1)
    for i in range(B):
        first = np.uint64(np.int64(group[i])) * pitch
        per = shares[first + pitch - np.uint64(1)] * real(1 / PICKS)
        u = (real(pick) + v0[i]) * per
        index, size = first, pitch - np.uint64(1)
        while size > np.uint64(1):
            half = size >> np.uint64(1)
            index += half if shares[index + half] <= u else np.uint64(0)
            size -= half
        below = shares[index]
        wide = shares[index + np.uint64(1)] - below
        inside = wide > real(0)                 # not in a group without lit lanes
        share = (u - below) / wide if inside else real(0.5)
        number[i], worth[i] = real(np.int32(index - first)), per / wide if inside else real(0)
        rest[i] = share if share < real(1) else real(1)


@stage
def sample_lamps(lanes, p, count, balls):
    """Sample a point of each lane's lamp: A0 … A7 as `shadow` reads them, its radiance A8 A9 A10."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, v1 = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[V1]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    number, rest, worth, disk_x, disk_y = row[H8], row[A7], row[A8], row[A9], row[A10]
    ax, ay, az, bx, by, bz, r2, flat = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7]
    gather(wx, p[MIDDLE * count:], number)
    gather(wy, p[(MIDDLE + 1) * count:], number)
    gather(wz, p[(MIDDLE + 2) * count:], number)
    gather(r2, p[BALL * count:], number)
    for i in range(B):
        disk_x[i], disk_y[i] = concentric_disk(real, rest[i], v1[i])

    # Planar lamps: L cos θ cos θ′ A / (π d²)
    if balls < count:
        gather(ax, p[HALF_A * count:], number)
        gather(ay, p[(HALF_A + 1) * count:], number)
        gather(az, p[(HALF_A + 2) * count:], number)
        gather(bx, p[HALF_B * count:], number)
        gather(by, p[(HALF_B + 1) * count:], number)
        gather(bz, p[(HALF_B + 2) * count:], number)
        gather(flat, p[FLAT * count:], number)
        for i in range(B):
            square = flat[i] > real(1)
            s = real(2) * rest[i] - real(1) if square else disk_x[i]
            t = real(2) * v1[i] - real(1) if square else disk_y[i]
            qx, qy, qz = (wx[i] + s * ax[i] + t * bx[i] - hx[i], wy[i] + s * ay[i] + t * by[i] - hy[i],
                          wz[i] + s * az[i] + t * bz[i] - hz[i])
            ux, uy, uz = ay[i] * bz[i] - az[i] * by[i], az[i] * bx[i] - ax[i] * bz[i], ax[i] * by[i] - ay[i] * bx[i]
            d2 = qx * qx + qy * qy + qz * qz
            size = real(1) / math.sqrt(d2)
            qx, qy, qz = qx * size, qy * size, qz * size
            slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
            arriving = slant * abs(ux * qx + uy * qy + uz * qz) * flat[i] / d2
            ax[i], ay[i], az[i], bx[i], by[i] = qx, qy, qz, d2 * size, arriving if arriving > real(0) else real(0)

    # Spheres: L cos θ · 2 (1 − cos θm)
    if balls > 0:
        for i in range(B):
            px, py, pz, reach, cap = sphere_point(real, disk_x[i], disk_y[i], wx[i] - hx[i], wy[i] - hy[i],
                                                  wz[i] - hz[i], r2[i])
            slant = nx[i] * px + ny[i] * py + nz[i] * pz
            wx[i], wy[i], wz[i], far[i] = px, py, pz, reach
            light[i] = real(2) * cap * (slant if slant > real(0) else real(0))
    if balls < count:
        for i in range(B):
            ball = r2[i] > real(0)
            wx[i], wy[i], wz[i] = wx[i] if ball else ax[i], wy[i] if ball else ay[i], wz[i] if ball else az[i]
            far[i], light[i] = far[i] if ball else bx[i], light[i] if ball else by[i]
    for i in range(B):
        light[i] *= worth[i]
    gather(row[A8], p[RADIANCE * count:], number)
    gather(row[A9], p[(RADIANCE + 1) * count:], number)
    gather(row[A10], p[(RADIANCE + 2) * count:], number)
