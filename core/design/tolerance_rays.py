"""The rays by which copies of a lens with errors of manufacture are judged, and the tables of these copies.

Lengths in mm, angles in radians, lens frame; focused at infinity. Fields lie along y on both sides of the axis, since a
decentred element images them differently. Rays are those that pass the clear apertures of the nominal lens, the same
for all copies. The contrast of the design is its MTF by diffraction; a copy changes it by as much as its spots, times
the limit of diffraction on the axis, change theirs.

A copy has numbers of its own in the table of the scalar tracer. An element, a piece of glass or cemented pieces, is
tilted and decentred as one body.
"""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import conditions
from lensbench.core.analysis.grids.traced_grid import ray_grid
from lensbench.core.analysis.transfer_function import mtf
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.kernels.pauses import due, pause
from lensbench.core.optics.focus import film_distance
from lensbench.core.optics.lens_surface import Frame, LensError, SurfacePose
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, surface_table, trace, trace_ray
from lensbench.core.optics.surfaces import AFTER, AXES, BEFORE, CURVATURE, PLACE, VERTEX, SurfaceTable
from lensbench.core.text import significant

FIELDS = (0.0, 0.7, -0.7, 1.0, -1.0)    # of the largest image height
WIDEST = math.radians(89.0)     # of a field: its beam comes from in front of the lens
WIDE = 61                       # points across the beam of a field, of the search for its edge
RINGS, ARMS = 10, 20            # of its rays
HALVINGS = 30                   # of the way to the edge
POINTS = 64                     # across the pupil, of the design's diffraction
TRIES = 16                      # shorter heights, for a film larger than the image circle
ROUNDS = 3                      # of tries, each from a sixteenth of the height before
CHUNK = 25                      # copies that a thread traces at a time


class Judge:
    """The rays of a lens, by which all of its copies are judged: see `tolerances.sensitivities` for the arguments."""

    def __init__(self, lens: Lens, film: Film | None, frequencies: ArrayLike | None,
                 wavelengths: str | Sequence[Any] | None = None) -> None:
        if not lens.is_rotationally_symmetric:
            raise LensError(f"tolerances are computed for rotationally symmetric lenses: this one has {lens.asymmetry}")
        design = conditions(lens, film, (0.0,), wavelengths, math.inf)
        self.lens, self.wavelengths = lens, design.wavelengths
        self.weights = np.array(design.weights) / sum(design.weights)
        behind = film_distance(lens, math.inf)
        if not behind > 0.0:
            raise LensError("tolerances are judged on the film: the image of infinity lies "
                            f"{significant(-behind, 4)} mm before the last surface, where none fits")
        self.film_z = lens.length + behind
        fo = first_order(lens)
        width, height = lens.film_size or (36.0, 24.0)
        half = 0.5 * (film.diagonal if film is not None else math.hypot(width, height))
        self.height, rays = _rays(lens, behind, half)
        self.origins, self.directions, self.areas, self.fields = rays
        self.image_heights = self._image_heights(design.primary_wavelength)
        self.frequencies = np.asarray((10.0, 20.0, 30.0, 40.0, 60.0) if frequencies is None else frequencies, float)
        if not (self.frequencies.ndim == 1 and self.frequencies.size and np.isfinite(self.frequencies).all()
                and (self.frequencies > 0.0).all()):
            raise LensError("frequencies must be positive numbers of cycles / mm")
        u = np.minimum(1e-3 * design.wavelengths[design.primary] * fo.f_number * self.frequencies, 1.0)
        self.limits = 2.0 / math.pi * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
        self.ends, self.kinds = bodies(lens), surface_table(lens).kinds
        self.diffraction: np.ndarray | float = 0.0      # the design's contrast less that of its spots
        focus, _, contrast = self.judged(*built(self, [], np.zeros((1, 0))))
        places = conditions(lens, film, [self.image_heights[f] for f in (0, 1, 3)], wavelengths, math.inf)
        waves = mtf(ray_grid(lens, behind + float(focus[0]), places, POINTS), self.frequencies).white_modulus
        self.diffraction = np.nan_to_num(waves[[0, 1, 1, 2, 2]].transpose(0, 2, 1) - contrast[0])

    def _image_heights(self, wavelength: float) -> tuple[float, ...]:
        """Where the middles of the fields' beams meet the film, mm: a fisheye images them far nearer than f tan θ."""
        rays = trace(self.lens, self.origins, self.directions, wavelength, clip=False, forward=True)
        away = (self.film_z - rays.points[:, 2]) / rays.directions[:, 2]
        y = rays.points[:, 1] + away * rays.directions[:, 1]
        return 0.0, *(float(np.nanmean(y[self.fields == f])) for f in range(1, len(FIELDS)))

    def judged(self, tables: np.ndarray, posed: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Focus (copies,), spots (copies, fields) and contrast (copies, fields, n, 2), on two threads."""
        count = len(tables)
        focus, spots = np.empty(count), np.empty((count, len(FIELDS)))
        contrast = np.empty((count, len(FIELDS), len(self.frequencies), 2))

        paused = due()

        def judge_chunk(first: int) -> None:
            pause(paused)
            chunk = slice(first, first + CHUNK)
            out = np.empty((len(tables[chunk]), len(self.wavelengths), len(self.origins), 4))
            trace_copies(self.kinds, posed[chunk], tables[chunk], self.film_z, self.origins, self.directions, out)
            judge_copies(out, self.fields, self.areas, self.weights, self.frequencies, self.limits, focus[chunk],
                         spots[chunk], contrast[chunk])

        with ThreadPoolExecutor(2) as pool:
            list(pool.map(judge_chunk, range(0, count, CHUNK)))
        lit = np.isfinite(spots)[..., None, None]
        return focus, spots, np.where(lit, np.clip(contrast + self.diffraction, 0.0, 1.0), 0.0)


def _rays(lens: Lens, behind: float, half: float) -> tuple[float, tuple[np.ndarray, ...]]:
    """Image height (mm) up to `half` that light reaches; origins, directions (n, 3), areas and fields (n,).

    behind: last vertex → film, mm.
    """
    for trial in range(ROUNDS * TRIES):
        height = half * TRIES ** -(trial // TRIES) * (1.0 - trial % TRIES / TRIES)
        chief = find_chief_rays(lens, behind, np.array([[0.0, share * height] for share in FIELDS]), by_image=True)
        beams: list[tuple[np.ndarray, ...]] = []
        for angle, share in reversed([*zip(chief.angles[:, 1].tolist(), FIELDS, strict=True)]):
            beam = _beam(lens, math.copysign(angle, share))
            if beam is None:                            # the outermost first
                break
            beams.insert(0, beam)
        else:
            fields = np.repeat(np.arange(len(beams)), [len(beam[0]) for beam in beams])
            return height, (*map(np.concatenate, zip(*beams, strict=True)), fields)
    raise LensError("hardly a ray passes this lens")


def _beam(lens: Lens, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Parallel rays that pass: rings of Gauss's rule on arms from the centroid of the beam to its edge.

    Origins and directions (n, 3), and areas (n,) of sum 1. None for a beam that hardly a ray passes, or a NaN angle.
    """
    if not abs(angle) < WIDEST:
        return None
    direction = np.array([0.0, math.sin(angle), math.cos(angle)])       # a ray that rises has its image at y > 0
    first = lens.surfaces[0].semi_diameter
    low, high = np.array([-1.2 * first] * 2), np.array([1.2 * first] * 2)
    # Points of the plane through the vertex: a steep ray that meets the rim crosses it far outside
    depth = float(lens.surfaces[0].sag(0.0, first)) * math.tan(angle)
    if math.isfinite(depth):
        low[1], high[1] = low[1] - max(depth, 0.0), high[1] - min(depth, 0.0)
    before = (-lens.length - 2.0 * first) / direction[2]

    def origins(places: np.ndarray) -> np.ndarray:
        return np.column_stack([places, np.zeros(len(places))]) + direction * before

    def passes(places: np.ndarray) -> np.ndarray:
        return np.asarray(trace(lens, origins(places), direction, forward=True).fate == Fate.PASSED)

    for least in (1, 20):                               # the beam of a fisheye fills little of its front
        x, y = np.meshgrid(*(np.linspace(a, b, WIDE) for a, b in zip(low, high, strict=True)))
        places = np.stack([x.ravel(), y.ravel()], 1)
        places = places[passes(places)]
        if len(places) < least:
            return None
        pitch = (high - low) / (WIDE - 1)
        low, high = places.min(0) - 0.5 * pitch, places.max(0) + 0.5 * pitch
    turns = 2.0 * math.pi * (np.arange(ARMS) + 0.5) / ARMS
    arms, middle = np.stack([np.cos(turns), np.sin(turns)], 1) * (high - low), places.mean(0)
    inside, outside = np.zeros(ARMS), np.ones(ARMS)
    for _ in range(HALVINGS):
        between = 0.5 * (inside + outside)
        passed = passes(middle + between[:, None] * arms)
        inside, outside = np.where(passed, between, inside), np.where(passed, outside, between)
    squares, shares = gauss_rule(RINGS)
    reach = np.sqrt(squares)[:, None] * inside
    areas = (shares[:, None] * inside**2).ravel()
    starts = origins((middle + reach[..., None] * arms).reshape(-1, 2))
    return starts, np.repeat(direction[None], len(starts), 0), areas / areas.sum()


def built(judge: Judge, errors: list[tuple[str, int, float]], drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tables of copies with errors (copies, errors), in their own units, and which surfaces are tilted or decentred."""
    tables = copies_of(judge.lens, judge.wavelengths, len(drawn))
    poses = np.zeros((len(drawn), len(judge.ends), POSE))
    body = {int(first): k for k, (first, _) in enumerate(judge.ends)}
    change: dict[str, Callable[[np.ndarray, int, np.ndarray], None]] = {
        "radius": change_radius, "thickness": change_gap, "index": change_index}
    tilted: set[tuple[str, int]] = set()
    for k, (kind, surface, _) in enumerate(errors):
        if kind in change:
            change[kind](tables, surface, drawn[:, k])
            continue
        axis = (DX, AROUND_Y) if (kind, surface) in tilted else (DY, AROUND_X)       # in the plane of the fields first
        tilted.add((kind, surface))
        poses[:, body[surface], axis[kind == "tilt"]] = drawn[:, k]
    return tables, set_poses(tables, judge.ends, poses)


# Of a pose: decentre (mm), and tilt about x, then y (radians), at the element's front vertex
DX, DY, AROUND_X, AROUND_Y = range(4)
POSE = 4


def elements(lens: Lens) -> list[tuple[int, int]]:
    """First and last surface of each piece of glass, or cemented group, from the scene to the film."""
    surfaces, first = [], None
    for i, surface in enumerate(lens.surfaces):
        if surface.glass.n_d > 1.0 and first is None:
            first = i
        elif surface.glass.n_d <= 1.0 and first is not None:
            surfaces.append((first, i))
            first = None
    return surfaces


def bodies(lens: Lens) -> np.ndarray:
    """First and last surface (n, 2) of each body, in order: the elements, and every surface between them by itself."""
    inside = {i: pair for pair in elements(lens) for i in range(pair[0], pair[1] + 1)}
    return np.array(sorted({inside.get(i, (i, i)) for i in range(len(lens.surfaces))}), np.int64)


def copies_of(lens: Lens, wavelengths: tuple[float, ...], count: int) -> np.ndarray:
    """Numbers (count, wavelengths, surfaces, columns) of equal copies, to be changed; wavelengths in µm."""
    tables = np.stack([surface_table(lens, wavelength).numbers for wavelength in wavelengths])
    return np.repeat(tables[None], count, 0)


def change_radius(tables: np.ndarray, surface: int, share: np.ndarray) -> None:
    """Radii longer by a part (copies,) of themselves."""
    tables[:, :, surface, CURVATURE] /= 1.0 + share[:, None]


def change_gap(tables: np.ndarray, surface: int, length: np.ndarray) -> None:
    """Gaps behind a surface longer by a length (copies,) in mm; all behind it moves."""
    tables[:, :, surface + 1:, VERTEX] += length[:, None, None]


def change_index(tables: np.ndarray, surface: int, change: np.ndarray) -> None:
    """Indices behind a surface higher by a number (copies,), at every wavelength."""
    tables[:, :, surface, AFTER] += change[:, None]
    if surface + 1 < tables.shape[2]:
        tables[:, :, surface + 1, BEFORE] += change[:, None]


def set_poses(tables: np.ndarray, ends: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Tilt and decentre the bodies of copies; → whether each surface of a copy is, (copies, surfaces).

    ends (bodies, 2): see `bodies`. poses (copies, bodies, POSE): about the front vertex of a body in its copy.
    """
    posed = np.zeros((len(tables), tables.shape[2]), np.bool_)
    for copy, body in zip(*np.nonzero(poses.any(2)), strict=True):
        dx, dy, about_x, about_y = poses[copy, body].tolist()
        first, last = ends[body].tolist()
        vertices = tables[copy, 0, first:last + 1, VERTEX].tolist()
        frame = Frame.of(SurfacePose(dx, dy, about_x, about_y), vertices[0])
        for i, z in enumerate(vertices, start=first):
            posed[copy, i] = True
            tables[copy, :, i, PLACE:AXES] = frame.at(z)
            tables[copy, :, i, AXES:AXES + 9] = frame.rotation.ravel()
    return posed


@njit(cache=True, nogil=True, error_model="numpy")
def trace_copies(kinds, posed, tables, film_z, origins, directions, out):
    """Rays through copies, to the plane z = film_z, without clear apertures.

    kinds (surfaces,); posed (copies, surfaces); tables (copies, wavelengths, surfaces, columns); origins, directions
    (rays, 3). out (copies, wavelengths, rays, 4): x, y and slopes dx/dz, dy/dz; NaN for a ray that is lost.
    """
    for copy in range(tables.shape[0]):
        for colour in range(tables.shape[1]):
            table = SurfaceTable(kinds, posed[copy], tables[copy, colour])
            for ray in range(origins.shape[0]):
                x, y, z, l, m, n, fate, _ = trace_ray(
                    table, False, origins[ray, 0], origins[ray, 1], origins[ray, 2], directions[ray, 0],
                    directions[ray, 1], directions[ray, 2], None, 0, 1)
                if fate == 0:
                    out[copy, colour, ray, 0] = x + (film_z - z) * l / n
                    out[copy, colour, ray, 1] = y + (film_z - z) * m / n
                    out[copy, colour, ray, 2], out[copy, colour, ray, 3] = l / n, m / n
                else:
                    out[copy, colour, ray] = math.nan


@njit(cache=True, nogil=True, error_model="numpy")
def judge_copies(out, fields, areas, weights, frequencies, limits, focus, spots, contrast):
    """Refocus copies and read their spots and contrast.

    out: of `trace_copies`. fields, areas (rays,): the field of each ray, and the part of its beam; weights
    (wavelengths,). frequencies, limits (n,): cycles / mm, and the factor of diffraction. Into focus (copies,): shift of
    the film (mm) of the least spot of the first field; spots (copies, fields): rms radius (mm), NaN without a ray;
    contrast (copies, fields, n, 2): of detail along x, then y, geometrical times the limit; 0 without a ray.
    """
    copies, colours, rays = out.shape[0], out.shape[1], out.shape[2]
    count = spots.shape[1]
    for copy in range(copies):
        # Means of each field over all colours
        total, mean = np.zeros(count), np.zeros((count, 4))
        for colour in range(colours):
            for ray in range(rays):
                if out[copy, colour, ray, 0] == out[copy, colour, ray, 0]:
                    f, w = fields[ray], weights[colour] * areas[ray]
                    total[f] += w
                    for k in range(4):
                        mean[f, k] += w * out[copy, colour, ray, k]
        for f in range(count):
            for k in range(4):
                mean[f, k] /= total[f]
        # The film: offsets p + t s of the first field are least in squares
        ps, ss = 0.0, 0.0
        for colour in range(colours):
            for ray in range(rays):
                f = fields[ray]
                if f == 0 and out[copy, colour, ray, 0] == out[copy, colour, ray, 0]:
                    w = weights[colour] * areas[ray] / total[f]
                    for k in range(2):
                        p, s = out[copy, colour, ray, k] - mean[f, k], out[copy, colour, ray, k + 2] - mean[f, k + 2]
                        ps += w * p * s
                        ss += w * s * s
        t = -ps / ss if ss > 0.0 else 0.0
        focus[copy] = t
        real, imaginary = np.zeros((count, frequencies.size, 2)), np.zeros((count, frequencies.size, 2))
        square = np.zeros(count)
        for colour in range(colours):
            for ray in range(rays):
                if not out[copy, colour, ray, 0] == out[copy, colour, ray, 0]:
                    continue
                f, w = fields[ray], weights[colour] * areas[ray]
                for k in range(2):
                    offset = (out[copy, colour, ray, k] - mean[f, k]
                              + t * (out[copy, colour, ray, k + 2] - mean[f, k + 2]))
                    square[f] += w * offset * offset
                    for j in range(frequencies.size):
                        phase = 2.0 * math.pi * frequencies[j] * offset
                        real[f, j, k] += w * math.cos(phase)
                        imaginary[f, j, k] += w * math.sin(phase)
        for f in range(count):
            lit = total[f] > 0.0
            spots[copy, f] = math.sqrt(square[f] / total[f]) if lit else math.nan
            for j in range(frequencies.size):
                for k in range(2):
                    modulation = math.hypot(real[f, j, k], imaginary[f, j, k]) / total[f] if lit else 0.0
                    contrast[copy, f, j, k] = limits[j] * modulation
