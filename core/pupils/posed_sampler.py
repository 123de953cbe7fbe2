"""Sampler behind a tilted, shifted or curved film: exit-pupil regions of film points at other distances from the lens.

Behind a rotationally symmetric lens, regions depend on the film point's distance from the axis and along it. A few
radial tables (`PupilTable`), each for one film distance, cover the film; the sampler interpolates between the two next
to a film point, at radii of one direction from the exit pupil. Lens frame, mm; z = 0 is the plane of the upright film.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lensbench.core.imaging.film import NUMBERS, FilmPose, film_normal, place_on_film
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, DEPTH, NX, NY, NZ, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z,
    gather, rows, stage
)
from lensbench.core.pupils.radial_sampler import CELLS, GRID, RING_CORNERS, RINGS, SECTORS, PupilTable, skip_if_dark

FINENESS = 0.04                 # largest step of the film distance between two tables, as a part of it
MOST_SLICES = 9

# Parameters of `aim_from_posed_film`, behind the numbers of the pose; then its tables, slice by slice: FIELDS numbers,
# the offsets of the rings, the corners as in `aim_radial`
(FILM_DISTANCE,         # of z = 0 (mm)
 GAIN,                  # 1 / normaliser
 NARROWING,             # 1 / distance of the exit pupil from z = 0 (1/mm): the radius of one direction grows so with z
 FIRST, PER_STEP,       # z of the first slice (mm), and slices per mm
 LAST,                  # largest slice below the last one
 CELL, ORIGIN,          # size of a cell of the corners, and coordinate of the first (mm)
 OF_SLICES) = range(NUMBERS, NUMBERS + 9)
# Fields of a slice: z (mm), 1 / end (1/mm), rings as in `aim_radial`, the radius of the last light, the course
SLICE_Z, INVERSE_END, RING_SCALE, DARK_BEYOND, COURSE, FIELDS = 0, 1, 2, 3, 4, 7


@dataclass(frozen=True, eq=False)
class PosedPupil:
    """Exit-pupil regions of the points of a posed film.

    film_distance: last vertex → z = 0 (mm). places: z (slices,) of the tables (mm), evenly spaced. narrowing: 1 /
    (distance of the exit pupil from z = 0), 1/mm.
    """

    film_distance: float
    pose: FilmPose
    places: np.ndarray
    tables: tuple[PupilTable, ...]
    narrowing: float

    @classmethod
    def of(cls, table: Callable[[float, float], PupilTable], film_distance: float, exit_pupil: float, pose: FilmPose,
           extent: np.ndarray) -> "PosedPupil":
        """Tables (made of a film distance and radius, mm) for a film with these points (n, 3), camera frame (mm), its
        extent.

        exit_pupil: its distance (mm) before z = 0, or inf.
        """
        low, high = float(extent[:, 2].min()), float(extent[:, 2].max())
        count = min(2 + math.ceil((high - low) / (FINENESS * (film_distance + low))), MOST_SLICES)
        if high - low < 1e-12 * film_distance:
            low, high, count = low - 1e-6 * film_distance, high + 1e-6 * film_distance, 2
        places = np.linspace(low, high, count)
        narrowing = 1.0 / exit_pupil if exit_pupil else 0.0
        if not min(1.0 + narrowing * low, 1.0 + narrowing * high) > 0.1:       # the exit pupil lies at the film
            narrowing = 0.0
        radius = float(np.hypot(extent[:, 0], extent[:, 1]).max())
        radii = radius * (1.0 + narrowing * places)
        radii *= radius / radii.min()
        return cls(film_distance, pose, places, tuple(table(film_distance + z, r)
                                                      for z, r in zip(places.tolist(), radii.tolist(), strict=True)),
                   narrowing)

    def step(self, normaliser: float) -> Step:
        """Step that aims from the posed film; WEIGHT becomes cos³θ · cos φ · area · (distances)² / normaliser.

        θ is measured from the axis, φ from the film's normal; the ray starts at z = 0.
        """
        (size, cells), count = self._grid, len(self.tables)
        p = np.empty(OF_SLICES + count * (FIELDS + RINGS + RINGS * RING_CORNERS))
        p[:NUMBERS] = self.pose.numbers
        p[FILM_DISTANCE], p[GAIN], p[NARROWING] = self.film_distance, 1.0 / normaliser, self.narrowing
        p[FIRST] = self.places[0]
        p[PER_STEP], p[LAST] = (count - 1) / (self.places[-1] - self.places[0]), count - 2
        p[CELL], p[ORIGIN] = 2.0 * size / CELLS, -size
        fields = p[OF_SLICES:OF_SLICES + count * FIELDS].reshape(count, FIELDS)
        for row, z, table in zip(fields, self.places, self.tables, strict=True):
            row[:COURSE] = z, 1.0 / table.end, table.scale, min(table.dark_beyond, 1e30)
            row[COURSE:] = table.course
        offsets = OF_SLICES + count * FIELDS
        corners = offsets + count * RINGS
        p[offsets:corners] = np.concatenate([table.offsets for table in self.tables])
        p[corners:] = (cells[..., 0] + GRID * cells[..., 1]).ravel()
        return Step(aim_from_posed_film, p, [offsets, corners])

    @property
    def _grid(self) -> tuple[float, np.ndarray]:
        """Largest coordinate of all corners (mm), and the corners as whole cells of 2 · that / CELLS."""
        outlines = np.stack([table.outline for table in self.tables])
        size = max(float(np.abs(outlines).max()), 1e-30)
        return size, np.round((outlines / size + 1.0) * (0.5 * CELLS))

    def sampled_area(self, film_xy: np.ndarray, rear_xy: np.ndarray) -> np.ndarray:
        """Area (n,) in mm² over which samples are spread, at rear points, for film points (n, 2): see `PupilTable`."""
        points = self.pose.points(film_xy)
        r = np.hypot(points[:, 0], points[:, 1])
        spacing = self.places[1] - self.places[0]
        slice_number = np.clip((points[:, 2] - self.places[0]) / spacing, 0.0, len(self.places) - 1.001)
        inner = slice_number.astype(int)
        corners, centre = np.zeros((len(r), RING_CORNERS, 2)), np.zeros(len(r))
        shares = np.stack([1.0 - (slice_number - inner), slice_number - inner])
        radii = np.stack([r * (1.0 + self.narrowing * self.places[inner + side]) / (1.0 + self.narrowing * points[:, 2])
                          for side in (0, 1)])
        lit = np.stack([radii[side] <= np.array([table.dark_beyond for table in self.tables])[inner + side]
                        for side in (0, 1)])
        shares = np.where(lit.all(0), shares, lit)
        size, cells = self._grid
        outlines = cells * (2.0 * size / CELLS) - size
        for k, table in enumerate(self.tables):
            for side in (0, 1):
                of_slice = inner + side == k
                if not of_slice.any():
                    continue
                ring, f = table.ring(radii[side, of_slice])
                outline = outlines[k, ring] + f[:, None, None] * (outlines[k, ring + 1] - outlines[k, ring])
                corners[of_slice] += shares[side, of_slice, None, None] * outline
                centre[of_slice] += shares[side, of_slice] * table.centre(radii[side, of_slice])
        off = r > 1e-6
        cosine, sine = np.where(off, points[:, :2].T / np.where(off, r, 1.0), [[1.0], [0.0]])
        x = rear_xy[:, 0] * cosine + rear_xy[:, 1] * sine - centre
        y = np.abs(rear_xy[:, 1] * cosine - rear_xy[:, 0] * sine)
        beyond = corners[..., 0] * y[:, None] - corners[..., 1] * x[:, None] >= 0.0
        k = np.clip(beyond.sum(1) - 1, 0, SECTORS - 1)
        i = np.arange(len(k))
        (ax, ay), (bx, by) = corners[i, k].T, corners[i, k + 1].T
        return np.where(lit.any(0), SECTORS * np.maximum(ax * by - bx * ay, 0.0), 0.0)


# Scratch rows. Those of a hit serve too: a ray that has not left the camera has met nothing
PART, LOWER, TURN, CORNER, RING, BETWEEN = A0, A1, A2, A3, A4, A5
CORNER_AX, CORNER_BX, CORNER_AY, CORNER_BY, MIDDLE, RADIUS, SHARE = L, M, N, NX, NY, NZ, DEPTH


@stage
def aim_from_posed_film(lanes, p, ints, key):
    """Aim from a film point X, Y of the film's frame into its exit-pupil region: the ray at z = 0, and WEIGHT.

    p: the pose, then FILM_DISTANCE and following. ints: offsets of the rings' offsets and of the corners in p.
    """
    _place_film_point(lanes, p)
    for side in range(2):
        _add_slice(lanes, p, ints, side)
    _aim(lanes, p)
    skip_if_dark(lanes, key)


@stage(inlined=True)
def _place_film_point(lanes, p):
    """X, Y, Z: the film point. LOWER: the slice before it, PART: share of the way to the next. TURN: the sector."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, u, weight = row[X], row[Y], row[Z], row[U0], row[WEIGHT]
    share, lower, turn = row[PART], row[LOWER], row[TURN]
    ax, bx, ay, by, middle = row[CORNER_AX], row[CORNER_BX], row[CORNER_AY], row[CORNER_BY], row[MIDDLE]
    first, per_step, last_slice = p[FIRST], p[PER_STEP], p[LAST]
    for i in range(B):
        x[i], y[i], z[i] = place_on_film(p, x[i], y[i])
        k = (z[i] - first) * per_step
        k = k if k > real(0) else real(0)
        lower[i] = np.floor(k) if np.floor(k) < last_slice else last_slice
        k = k - lower[i]
        share[i] = k if k < real(1) else real(1)
        s = u[i] * real(2 * SECTORS)
        turn[i] = s - real(SECTORS) if s >= real(SECTORS) else s
        weight[i] = real(0)
        ax[i], bx[i], ay[i], by[i], middle[i] = real(0), real(0), real(0), real(0), real(0)


@stage(inlined=True)
def _add_slice(lanes, p, ints, side):
    """Add the slice before the film point (side 0) or behind it (1) to corners, MIDDLE and WEIGHT by its share."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, weight, slice_share, lower = row[X], row[Y], row[Z], row[WEIGHT], row[PART], row[LOWER]
    turn, corner, ring, between = row[TURN], row[CORNER], row[RING], row[BETWEEN]
    inner0, inner1, outer0, outer1, centre0, centre1 = row[A6], row[A7], row[A8], row[A9], row[A10], row[A11]
    ax, bx, ay, by = row[CORNER_AX], row[CORNER_BX], row[CORNER_AY], row[CORNER_BY]
    middle, radius, share = row[MIDDLE], row[RADIUS], row[SHARE]
    narrowing, cell, origin, offsets, corners = p[NARROWING], p[CELL], p[ORIGIN], ints[0], ints[1]
    last, unit = real(RINGS - 1.001), real(1 / GRID)
    # Ring of this slice, at the radius of one direction from the exit pupil
    for i in range(B):
        corner[i] = (lower[i] + real(side)) * real(FIELDS)
    gather(inner0, p[OF_SLICES + SLICE_Z:], corner)
    gather(inner1, p[OF_SLICES + INVERSE_END:], corner)
    gather(outer0, p[OF_SLICES + RING_SCALE:], corner)
    gather(outer1, p[OF_SLICES + DARK_BEYOND:], corner)
    for i in range(B):
        r = math.sqrt(x[i] * x[i] + y[i] * y[i])
        r = r * (real(1) + narrowing * inner0[i]) / (real(1) + narrowing * z[i])
        radius[i] = r
        left = real(1) - r * inner1[i]
        k = (real(1) - math.sqrt(left if left > real(0) else real(0))) * outer0[i]
        k = k if k < last else last
        ring[i], between[i] = np.floor(k), k - np.floor(k)
        share[i] = slice_share[i] if side == 1 else real(1) - slice_share[i]
        share[i] = share[i] if r <= outer1[i] else real(0)
        weight[i] += share[i]
        centre0[i] = r * inner1[i]
    # Course of the centre
    gather(inner0, p[OF_SLICES + COURSE:], corner)
    gather(inner1, p[OF_SLICES + COURSE + 1:], corner)
    gather(outer0, p[OF_SLICES + COURSE + 2:], corner)
    for i in range(B):
        t = centre0[i] * centre0[i]
        middle[i] += share[i] * radius[i] * (inner0[i] + t * (inner1[i] + t * outer0[i]))
        ring[i] += (lower[i] + real(side)) * real(RINGS)
        corner[i] = ring[i] * real(RING_CORNERS) + np.floor(turn[i])
    # The triangle's two corners and the centre, between the rings
    gather(inner0, p[corners:], corner)
    gather(inner1, p[corners + 1:], corner)
    gather(outer0, p[corners + RING_CORNERS:], corner)
    gather(outer1, p[corners + RING_CORNERS + 1:], corner)
    gather(centre0, p[offsets:], ring)
    gather(centre1, p[offsets + 1:], ring)
    for i in range(B):
        f = between[i] * share[i]
        e = share[i] - f
        y0, y1, y2, y3 = (np.floor(inner0[i] * unit), np.floor(inner1[i] * unit),
                          np.floor(outer0[i] * unit), np.floor(outer1[i] * unit))
        x0, x1, x2, x3 = (inner0[i] - y0 * real(GRID), inner1[i] - y1 * real(GRID),
                          outer0[i] - y2 * real(GRID), outer1[i] - y3 * real(GRID))
        ax[i] += (e * x0 + f * x2) * cell + share[i] * origin
        bx[i] += (e * x1 + f * x3) * cell + share[i] * origin
        ay[i] += (e * y0 + f * y2) * cell + share[i] * origin
        by[i] += (e * y1 + f * y3) * cell + share[i] * origin
        middle[i] += e * centre0[i] + f * centre1[i]


@stage(inlined=True)
def _aim(lanes, p):
    """L, M, N: from the film point to the pupil sample in the triangle; WEIGHT; and the start of the ray at z = 0."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1], row[WEIGHT]
    ax, bx, ay, by = row[CORNER_AX], row[CORNER_BX], row[CORNER_AY], row[CORNER_BY]
    turn, middle = row[TURN], row[MIDDLE]
    distance0, gain = p[FILM_DISTANCE], p[GAIN]
    for i in range(B):
        # Where one slice is dark, the other serves alone
        whole = real(1) / weight[i] if weight[i] > real(0) else real(0)
        cax, cbx, cay, cby = ax[i] * whole, bx[i] * whole, ay[i] * whole, by[i] * whole
        # Choose a point (a, b) of the triangle, in the frame of the meridian
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        a = middle[i] * whole + reach * (h * cax + g * cbx)
        b = reach * (h * cay + g * cby)
        b = -b if u[i] >= real(0.5) else b
        # Rotate it with the film point
        r2 = x[i] * x[i] + y[i] * y[i]
        off = r2 > real(1e-12)
        inverse = real(1) / (math.sqrt(r2) if off else real(1))
        cosine, sine = x[i] * inverse if off else real(1), y[i] * inverse
        distance = distance0 + z[i]
        dx, dy = a * cosine - b * sine - x[i], a * sine + b * cosine - y[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i], n[i] = dx * size, dy * size, -distance * size
        # Weight by the angles to the axis and to the film's normal, and by the area of all triangles
        fx, fy, fz = film_normal(p, x[i], y[i], z[i])
        axial, facing = distance * size, -(l[i] * fx + m[i] * fy + n[i] * fz)
        nearer = distance0 / distance
        area = cax * cby - cbx * cay
        dense = gain * axial * axial * axial * nearer * nearer * real(SECTORS) * (area if area > real(0) else real(0))
        weight[i] = dense * (facing if facing > real(0) else real(0)) if weight[i] > real(0) else real(0)
        # Start the ray at z = 0
        back = z[i] / n[i]
        x[i] -= back * l[i]
        y[i] -= back * m[i]
        z[i] = real(0)
