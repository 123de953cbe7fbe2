"""Rays through many copies of a lens whose numbers differ a little, with elements that are decentred and tilted.

Lengths in mm, angles in radians, lens frame. A copy has numbers of its own in the table of the scalar tracer. Its
elements have poses: a piece of glass, or pieces that are cemented, moves as one body. Surfaces in line pay nothing for
it.
"""

import math

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.lens_surface import Frame, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import surface_table, trace_ray
from lensbench.core.optics.surfaces import AFTER, AXES, BEFORE, CURVATURE, PLACE, VERTEX, SurfaceTable

# Of a pose: decentre (mm), and tilt about x, then y (radians), at the element's front vertex
DX, DY, AROUND_X, AROUND_Y = range(4)
POSE = 4


def elements(lens: Lens) -> list[tuple[int, int]]:
    """First and last surface of each piece of glass, or cemented group, from the scene to the film."""
    found, first = [], None
    for i, surface in enumerate(lens.surfaces):
        if surface.glass.n_d > 1.0 and first is None:
            first = i
        elif surface.glass.n_d <= 1.0 and first is not None:
            found.append((first, i))
            first = None
    return found


def bodies(lens: Lens) -> np.ndarray:
    """First and last surface (n, 2) of each body, in order: the elements, and every surface between them by itself."""
    inside = {i: pair for pair in elements(lens) for i in range(pair[0], pair[1] + 1)}
    return np.array(sorted({inside.get(i, (i, i)) for i in range(len(lens.surfaces))}), np.int64)


def copies_of(lens: Lens, wavelengths: tuple[float, ...], count: int) -> np.ndarray:
    """Numbers (count, wavelengths, surfaces, columns) of equal copies, to be changed; wavelengths in µm."""
    tables = np.stack([surface_table(lens, wavelength).numbers for wavelength in wavelengths])
    return np.repeat(tables[None], count, 0)


def change_radius(tables: np.ndarray, surface: int, part: np.ndarray) -> None:
    """Radii longer by a part (copies,) of themselves."""
    tables[:, :, surface, CURVATURE] /= 1.0 + part[:, None]


def change_gap(tables: np.ndarray, surface: int, length: np.ndarray) -> None:
    """Gaps behind a surface longer by a length (copies,) in mm; all behind it moves."""
    tables[:, :, surface + 1:, VERTEX] += length[:, None, None]


def change_index(tables: np.ndarray, surface: int, change: np.ndarray) -> None:
    """Indices behind a surface higher by a number (copies,), at every wavelength."""
    tables[:, :, surface, AFTER] += change[:, None]
    if surface + 1 < tables.shape[2]:
        tables[:, :, surface + 1, BEFORE] += change[:, None]


def set_poses(tables: np.ndarray, ends: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Put the bodies of copies out of line; → whether each surface of a copy is, (copies, surfaces).

    ends (bodies, 2): see `bodies`. poses (copies, bodies, POSE): each about the front vertex of its body, which stands
    where the gaps of the copy put it.
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
    """Rays through copies, to the plane z = film_z.

    kinds (surfaces,). posed (copies, surfaces): whether a surface is out of line. tables (copies, wavelengths,
    surfaces, columns): numbers. origins, directions (rays, 3). out (copies, wavelengths, rays, 4): x, y, and the slopes
    dx/dz, dy/dz; NaN for a lost ray. Rims end no ray.
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

    out: of `trace_copies`, as at the film. fields (rays,): the number of each ray's field; areas (rays,): the part of
    its beam for which it stands. weights (wavelengths,).
    frequencies (n,) in cycles / mm; limits (n,): the factor of diffraction. focus (copies,): the shift of the film (mm)
    at which the spot of the first field, on the axis, is least. spots (copies, fields): rms radius (mm), NaN for a
    field of which no ray arrives. contrast (copies, fields, n, 2): of detail along x, then y; geometrical, times the
    limit; 0 for such a field.
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
                    at = (out[copy, colour, ray, k] - mean[f, k]
                          + t * (out[copy, colour, ray, k + 2] - mean[f, k + 2]))
                    square[f] += w * at * at
                    for j in range(frequencies.size):
                        phase = 2.0 * math.pi * frequencies[j] * at
                        real[f, j, k] += w * math.cos(phase)
                        imaginary[f, j, k] += w * math.sin(phase)
        for f in range(count):
            lit = total[f] > 0.0
            spots[copy, f] = math.sqrt(square[f] / total[f]) if lit else math.nan
            for j in range(frequencies.size):
                for k in range(2):
                    seen = math.hypot(real[f, j, k], imaginary[f, j, k]) / total[f] if lit else 0.0
                    contrast[copy, f, j, k] = limits[j] * seen
