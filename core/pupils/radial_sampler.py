"""Radial sampler: the exit-pupil regions of many film radii, cut into triangles of equal area for a camera to sample.

For rotationally symmetric lenses: regions rotate with the film point, and are symmetric about the meridian, so the
table holds the upper halves of the regions of film points (+r, 0). Lens frame, mm.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, ALIVE, LOST, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, gather, rows, stage
)
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.block_trace import ClearanceTracer, clearance_tracer, clearances
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.irregular_regions import enclose_irregular_regions
from lensbench.core.pupils.rim_solver import (
    ROUGH, find_interior_points, paraxial_centre_ratio, project_rear_rim, rear_rim, region_scale, solve_rims
)


@njit(cache=True, error_model="numpy", nogil=True)
def equal_areas(rims, sectors):
    """Corners (rings, sectors + 1, 2) at equal areas about 0 along the chords of rims (rings, points, 2)."""
    rings, points, _ = rims.shape
    corners, area = np.zeros((rings, sectors + 1, 2)), np.zeros(points)
    for ring in range(rings):
        rim = rims[ring]
        for i in range(1, points):
            area[i] = area[i - 1] + rim[i - 1, 0] * rim[i, 1] - rim[i, 0] * rim[i - 1, 1]
        if area[points - 1] > 0.0:
            i = 0
            for k in range(sectors + 1):
                target = area[points - 1] * k / sectors
                while i < points - 2 and area[i + 1] <= target:
                    i += 1
                share = (target - area[i]) / (area[i + 1] - area[i]) if area[i + 1] > area[i] else 0.0
                share = min(max(share, 0.0), 1.0)
                for axis in range(2):
                    corners[ring, k, axis] = rim[i, axis] * (1.0 - share) + rim[i + 1, axis] * share
    return corners


RINGS, SECTORS = 64, 32         # film radii, and triangles in half a region
POINTS = 41                     # solved points on the upper half of each rim
TOLERANCE = 2e-4                # of the rims, relative to the region's scale
GRID = 4096                     # numbers for a coordinate of the table's corners: two of them fit one float32 exactly
CELLS = GRID - 2                # cells across the corners: even, so that the meridian, y = 0, is a whole number of them
SEARCH_RADII, SEARCHES = 24, 3  # film radii in one search for the end of the light, and searches
NEARLY = 0.95                   # share of the radius where the light ends
STEADY = 0.015                  # in half widths: coarseness up to which the centres need no course
SPREAD = 1.004                  # size of the sampled region over the solved one, to cover what lies between points

# Parameters of `aim_radial`, then its two tables: every corner, ring by ring, with x + GRID · y in cells as one number,
# and every ring's offset
(FILM_DISTANCE,         # mm
 RING_SCALE,            # rings per unit of 1 − √(1 − r / end)
 INVERSE_END,           # 1 / end, 1/mm
 DARK_BEYOND,           # film radius (mm) beyond which no light falls
 GAIN,                  # 1 / normaliser
 COURSE,                # c₀, c₁ and c₂ of the course
 CELL,                  # size of a cell (mm)
 ORIGIN,                # coordinate of the first cell (mm)
 CORNERS) = 0, 1, 2, 3, 4, 5, 8, 9, 10
RING_CORNERS = SECTORS + 1
OFFSETS = CORNERS + RINGS * RING_CORNERS


@dataclass(frozen=True, eq=False)
class PupilTable:
    """Exit-pupil regions of RINGS film radii, each cut into 2 SECTORS triangles of equal area.

    Ring k lies where 1 − √(1 − r / end) is k / (RINGS − 1) of its value on the last ring: rings crowd towards the film
    radius `end` where the light ends, for a region shrinks there as a square root. film_distance, radius (of the last
    ring), end, dark_beyond (no light falls): mm. outline: (RINGS, SECTORS + 1, 2) corners in the upper half, in mm from
    the region's centre at x = (c₀ + c₁ t + c₂ t²) r + offset, t = (r / end)², c the `course`, which is 0 unless the
    regions of a small stop move by much of their size. irregular: whether some outline has dark parts; see
    `irregular_regions`.
    """

    film_distance: float
    radius: float
    end: float
    dark_beyond: float
    outline: np.ndarray
    course: np.ndarray
    offsets: np.ndarray
    irregular: bool = False

    @classmethod
    def of(cls, lens: Lens, film_distance: float, film_radius: float, wavelength: float = D_LINE,
           widened: bool = True) -> "PupilTable":
        """Table for film radii 0 … film_radius (mm), or to the end of the light; wavelength in µm.

        widened: larger than the regions by SPREAD, for a camera that traces its samples; otherwise of equal area.
        """
        tolerance = TOLERANCE * region_scale(lens, film_distance, wavelength)
        by = clearance_tracer(lens, film_distance, wavelength)
        film_radius = max(film_radius, 1e-30)           # a film of size 0 still needs distinct rings
        rim, middle = rear_rim(lens, film_distance), paraxial_centre_ratio(lens, film_distance, wavelength)
        dark = _dark_beyond(film_radius, film_distance, rim, middle, by)
        end = 4.0 * film_radius
        if 0.0 < dark < math.inf:                       # spread the rings up to the end of the light
            film_radius = end = dark
        radii = _ring_radii(film_radius, end)
        centres, rims = solve_rims(lens, film_distance, radii, POINTS, tolerance, wavelength,
                                   project_rear_rim(radii, *rim), by)
        centres, rims, irregular = enclose_irregular_regions(film_distance, radii, centres, rims, by)
        course, offsets = _course(radii, end, dark, centres, rims)
        outline = equal_areas(_widened(offsets, rims), SECTORS) if widened else _filled(rims)
        return cls(film_distance, film_radius, end, dark, outline, course, offsets, irregular)

    def ring(self, film_radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inner ring (n,), below RINGS − 1, of film radii (n,) in mm, and the share (n,) of the next ring."""
        ring_number = (1.0 - np.sqrt(np.maximum(1.0 - film_radius / self.end, 0.0))) * self.scale
        inner = np.minimum(ring_number.astype(int), RINGS - 2)
        return inner, ring_number - inner

    def centre(self, film_radius: np.ndarray) -> np.ndarray:
        """Centre (n,) x in mm of the regions of film points (r, 0), with r in film_radius (n,) mm."""
        inner, f = self.ring(film_radius)
        return (_course_at(self.course, film_radius, self.end)
                + self.offsets[inner] * (1.0 - f) + self.offsets[inner + 1] * f)

    @property
    def coarseness(self) -> float:
        """Largest meridional error of regions between two rings, in half widths, up to NEARLY of the light's end."""
        return _coarseness(_ring_radii(self.radius, self.end), self.dark_beyond, self.offsets, self.outline)

    @property
    def scale(self) -> float:
        """Rings per unit of 1 − √(1 − r / end)."""
        return (RINGS - 1) / (1.0 - math.sqrt(1.0 - self.radius / self.end))

    def sampled_area(self, film_xy: np.ndarray, rear_xy: np.ndarray) -> np.ndarray:
        """Area (n,) in mm² over which the samples of film points (n, 2) are spread, from their density at rear points
        (n, 2) mm.

        That of the triangle there times the number of triangles; 0 beyond dark_beyond.
        """
        # Corners of each film point's triangles, and its rear point, both from the region's centre
        r = np.hypot(film_xy[:, 0], film_xy[:, 1])
        inner, f = self.ring(r)
        size, cells = self._grid
        corners = cells[inner] + f[:, None, None] * (cells[inner + 1] - cells[inner])
        corners = corners * (2.0 * size / CELLS) - size
        off = r > 1e-6
        cosine, sine = np.where(off, film_xy.T / np.where(off, r, 1.0), [[1.0], [0.0]])
        x = rear_xy[:, 0] * cosine + rear_xy[:, 1] * sine - self.centre(r)
        y = np.abs(rear_xy[:, 1] * cosine - rear_xy[:, 0] * sine)
        # Last corner, counter-clockwise, before the rear point
        beyond = corners[..., 0] * y[:, None] - corners[..., 1] * x[:, None] >= 0.0
        k = np.clip(beyond.sum(1) - 1, 0, SECTORS - 1)
        i = np.arange(len(k))
        (ax, ay), (bx, by) = corners[i, k].T, corners[i, k + 1].T
        return np.where(r <= self.dark_beyond, SECTORS * np.maximum(ax * by - bx * ay, 0.0), 0.0)

    @property
    def _grid(self) -> tuple[float, np.ndarray]:
        """Largest coordinate of the corners (mm), and the corners as whole cells of 2 · that / CELLS."""
        size = max(float(np.abs(self.outline).max()), 1e-30)
        return size, np.round((self.outline / size + 1.0) * (0.5 * CELLS))

    def step(self, normaliser: float) -> Step:
        """Step that aims from the film into the region; WEIGHT becomes cos⁴θ · area / normaliser."""
        size, cells = self._grid
        p = np.empty(OFFSETS + RINGS)
        p[FILM_DISTANCE], p[RING_SCALE], p[INVERSE_END] = self.film_distance, self.scale, 1.0 / self.end
        p[DARK_BEYOND], p[GAIN] = self.dark_beyond, 1.0 / normaliser
        p[COURSE:CELL] = self.course
        p[CELL], p[ORIGIN] = 2.0 * size / CELLS, -size
        p[CORNERS:OFFSETS] = (cells[:, :, 0] + GRID * cells[:, :, 1]).ravel()
        p[OFFSETS:] = self.offsets
        return Step(aim_radial, p)


def _dark_beyond(film_radius: float, film_distance: float, rim: tuple[np.ndarray, np.ndarray, float], middle: float,
                 by: ClearanceTracer) -> float:
    """Film radius (mm) beyond which no light falls; inf where light reaches film_radius, 0 where there is none.

    rim: `rear_rim` of the lens; middle: its `paraxial_centre_ratio`.
    """
    corner, zero, level = np.full(B, film_radius), np.zeros(B), np.empty(B)
    low, high = project_rear_rim(corner[:1], *rim)
    heights = low + (high - low) * (np.arange(B) + 0.5) / B         # one block of rays is mostly enough to find light
    clearances(corner, zero, zero, heights, zero, film_distance, level, by, ROUGH)
    if (level <= 1.0).any():
        return math.inf
    inner, outer = 0.0, film_radius
    for _ in range(SEARCHES):
        between = np.linspace(inner, outer, SEARCH_RADII)
        low, high = project_rear_rim(between, *rim)
        _, level = find_interior_points(between, film_distance, low, high, middle * between, by)
        last = int(np.max(np.flatnonzero(level < 1.0), initial=-1))
        if last < 0:
            return 0.0
        if between[last] == film_radius:
            return math.inf
        inner, outer = between[last], between[min(last + 1, SEARCH_RADII - 1)]
    return float(outer)


def _ring_radii(radius: float, end: float) -> np.ndarray:
    """Film radii (RINGS,) 0 … radius in mm, denser towards `end`."""
    last = 1.0 - math.sqrt(1.0 - radius / end)
    return end * (1.0 - (1.0 - np.linspace(0.0, last, RINGS)) ** 2)


def _course(radii: np.ndarray, end: float, dark: float, centres: np.ndarray,
            rims: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Course of the regions' centres across the film, 0 if they need none, and the offsets (RINGS,) from it.

    A least-squares fit in units of the regions' half widths. Dark rings repeat the offset of the last lit one.
    """
    half = 0.5 * (rims[:, 0, 0] - rims[:, -1, 0])
    lit = half > 0.0
    dark_from = int(np.max(np.flatnonzero(lit), initial=-1)) + 1
    centres[dark_from:] = centres[dark_from - 1] if dark_from else 0.0
    if _coarseness(radii, dark, centres, rims) <= STEADY:
        return np.zeros(3), centres
    t, weight = (radii[lit] / end) ** 2, 1.0 / half[lit]
    terms = np.stack([t**0, t, t * t], 1) * radii[lit, None]
    course = np.linalg.lstsq(terms * weight[:, None], centres[lit] * weight, rcond=None)[0]
    offsets = centres - _course_at(course, radii, end)
    offsets[dark_from:] = offsets[dark_from - 1]
    return course, offsets


def _course_at(course: np.ndarray, radii: np.ndarray, end: float) -> np.ndarray:
    """Course (n,) in mm at film radii (n,)."""
    t = (radii / end) ** 2
    return radii * (course[0] + t * (course[1] + t * course[2]))


def _coarseness(radii: np.ndarray, dark: float, offsets: np.ndarray, rims: np.ndarray) -> float:
    """`PupilTable.coarseness` of rims whose first and last points are their ends along the meridian."""
    ends = offsets[:, None] + rims[:, [0, -1], 0]
    half, off = 0.5 * (ends[1:-1, 0] - ends[1:-1, 1]), np.abs(np.diff(ends, 2, axis=0)).max(1) / 8.0
    counts = (half > 0.0) & (radii[1:-1] < NEARLY * dark)
    return float(np.max(off[counts] / half[counts], initial=0.0))


def _widened(offsets: np.ndarray, rims: np.ndarray) -> np.ndarray:
    """Rims enlarged by SPREAD, and drawn out along the meridian by the error of linear interpolation between rings."""
    off, ends = np.zeros(len(offsets)), offsets[:, None] + rims[:, [0, -1], 0]
    off[1:-1] = np.abs(np.diff(ends, 2, axis=0)).max(1) / 8.0       # error of a chord of a parabola
    off = np.maximum(np.maximum(off, np.roll(off, 1)), np.roll(off, -1))
    off[rims[:, 0, 0] <= rims[:, -1, 0]] = 0.0          # an empty region stays empty
    widened = rims * SPREAD
    side = np.sign(np.argmax(rims[:, :, 1], 1)[:, None] - np.arange(rims.shape[1]))     # of the topmost point
    widened[:, :, 0] += side * off[:, None]
    return widened


@njit(cache=True, error_model="numpy", nogil=True)
def _filled(rims):
    """Corners at equal areas, enlarged so that the triangles have the area of the regions rather than of the chords."""
    corners = equal_areas(rims, SECTORS)
    for ring in range(rims.shape[0]):
        rim, corner, area, chords = rims[ring], corners[ring], 0.0, 0.0
        angle, r2 = math.atan2(rim[0, 1], rim[0, 0]), rim[0, 0] ** 2 + rim[0, 1] ** 2
        for i in range(1, rim.shape[0]):
            before, r2_before = angle, r2
            angle, r2 = math.atan2(rim[i, 1], rim[i, 0]), rim[i, 0] ** 2 + rim[i, 1] ** 2
            area += 0.5 * (r2 + r2_before) * (angle - before)
        for k in range(SECTORS):
            chords += corner[k, 0] * corner[k + 1, 1] - corner[k + 1, 0] * corner[k, 1]
        if chords > 0.0:
            corner *= math.sqrt(area / chords)
    return corners


@stage(inlined=True)
def skip_if_dark(lanes, key):
    """Skip all further steps where no lane has any weight."""
    weight, alive = rows(lanes)[WEIGHT], np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > lanes.dtype.type(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)


@stage
def aim_radial(lanes, p, ints, key):
    """Aim from a film point X, Y (mm, Z = 0) into its exit-pupil region: L, M, N and WEIGHT. p: see FILM_DISTANCE.

    WEIGHT holds the exact area of the sampled triangle, so that interpolation and grid leave no error in the picture.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1], row[WEIGHT]
    ring, between, turn, corner = row[A0], row[A1], row[A2], row[A3]
    inner0, inner1, outer0, outer1 = row[A4], row[A5], row[A6], row[A7]
    centre0, centre1 = row[A8], row[A9]
    distance, scale, dark, gain = p[FILM_DISTANCE], p[RING_SCALE], p[DARK_BEYOND], p[GAIN]
    inverse_end = p[INVERSE_END]
    cell, origin, c0, c1, c2 = p[CELL], p[ORIGIN], p[COURSE], p[COURSE + 1], p[COURSE + 2]
    last = real(RINGS - 1.001)
    # Ring and sector of each lane
    for i in range(B):
        r = math.sqrt(x[i] * x[i] + y[i] * y[i])
        left = real(1) - r * inverse_end
        k = (real(1) - math.sqrt(left if left > real(0) else real(0))) * scale
        k = k if k < last else last
        s = u[i] * real(2 * SECTORS)
        t = s - real(SECTORS) if s >= real(SECTORS) else s
        ring[i] = np.floor(k)
        between[i] = k - np.floor(k)
        turn[i] = t
        corner[i] = np.floor(k) * real(RING_CORNERS) + np.floor(t)
        weight[i] = gain if r <= dark else real(0)
    # Look up the triangle's two corners and the centre, on the inner and on the outer ring
    gather(inner0, p[CORNERS:], corner)
    gather(inner1, p[CORNERS + 1:], corner)
    gather(outer0, p[CORNERS + RING_CORNERS:], corner)
    gather(outer1, p[CORNERS + RING_CORNERS + 1:], corner)
    gather(centre0, p[OFFSETS:], ring)
    gather(centre1, p[OFFSETS + 1:], ring)
    unit = real(1 / GRID)
    for i in range(B):
        # Unpack the corners, and interpolate between the rings
        f = between[i]
        e = real(1) - f
        y0, y1, y2, y3 = (np.floor(inner0[i] * unit), np.floor(inner1[i] * unit),
                          np.floor(outer0[i] * unit), np.floor(outer1[i] * unit))
        x0, x1, x2, x3 = (inner0[i] - y0 * real(GRID), inner1[i] - y1 * real(GRID),
                          outer0[i] - y2 * real(GRID), outer1[i] - y3 * real(GRID))
        ax, bx = (e * x0 + f * x2) * cell + origin, (e * x1 + f * x3) * cell + origin
        ay, by = (e * y0 + f * y2) * cell + origin, (e * y1 + f * y3) * cell + origin
        # Choose a point (a, b) of the triangle, in the frame of the meridian
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        r2 = x[i] * x[i] + y[i] * y[i]
        r, t = math.sqrt(r2), r2 * inverse_end * inverse_end
        middle = e * centre0[i] + f * centre1[i] + r * (c0 + t * (c1 + t * c2))
        a = middle + reach * (h * ax + g * bx)
        b = reach * (h * ay + g * by)
        b = -b if u[i] >= real(0.5) else b
        # Rotate it with the film point; on the axis all azimuths are the same
        off = r2 > real(1e-12)
        inverse = real(1) / (r if off else real(1))
        cosine, sine = x[i] * inverse if off else real(1), y[i] * inverse
        dx, dy = a * cosine - b * sine - x[i], a * sine + b * cosine - y[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i], n[i] = dx * size, dy * size, -distance * size
        # Weight by cos⁴θ and the area of all triangles; rounding may invert the last triangles of a region
        cosine2 = distance * size
        cosine2 = cosine2 * cosine2
        area = ax * by - bx * ay
        weight[i] *= cosine2 * cosine2 * real(SECTORS) * (area if area > real(0) else real(0))
        z[i] = real(0)
    skip_if_dark(lanes, key)
