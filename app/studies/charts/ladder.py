"""Camera models of one lens, from the simplest to the full trace: their render steps, or why a model is impossible.

The steps run from the film point X, Y and the pupil sample U0, U1 to the ray in front of the lens; camera frame, mm.

Among them is a table of rays with linear interpolation, for comparison: polynomials are faster and more accurate. The
table has film radii, and points on the plane of the last vertex: along the meridian, relative to the middle of the
pupil region at that radius, and across it (one half, by symmetry). Each entry is the direction in which objects in
focus are seen, and the point of the ray nearest to the entrance pupil.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, B, L, M, N, Step, X, Y, Z, gather, rows, stage
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.lens_models.polynomial import DEGREES, Polynomial
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import scene_side_origin
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.radial_sampler import PupilTable

RADII, ALONG, ACROSS = 64, 24, 12           # nodes of the table
NODES = RADII * ALONG * ACROSS

# Parameters of `interpolate`: −film distance (mm), film radii per mm, drift, nodes along and across per mm, z of the
# centre (mm), 1 / distance from it to objects in focus (1/mm); then the tables of the direction, x, y, z, and the point
NEGATIVE_DISTANCE, PER_RADIUS, DRIFT, PER_ALONG, PER_ACROSS, CENTRE_Z, NEARNESS, TABLES = range(8)


def ray_table_step(lens: Lens, film_distance: float, table: PupilTable, wavelength: float = D_LINE,
              distance: float = math.inf) -> Step:
    """The step from an aimed ray at the film to the ray in front of the lens, for the regions of a pupil table.

    film_distance: last vertex → film; distance: film → object in focus (mm). LensError for a lens without rotational
    symmetry.
    """
    if not lens.is_rotationally_symmetric:
        raise LensError(f"a table of rays needs rotational symmetry, and this lens has {lens.asymmetry}")
    away = film_distance
    film, reach, drift = np.linspace(0.0, table.radius, RADII), *_box(table)
    r, u, v = (grid.ravel() for grid in np.meshgrid(
        film, np.linspace(-reach, reach, ALONG), np.linspace(0.0, reach, ACROSS), indexing="ij"))
    x, y = u + drift * r - r, v
    size = 1.0 / np.sqrt(x * x + y * y + away * away)
    samples = {X: r, L: x * size, M: y * size, N: -away * size}
    ray = Program(trace_steps(lens, away, wavelength, blades=False), np.float64).run(samples, [X, Y, Z, L, M, N], NODES)

    # Point nearest to the pupil, and direction from there to objects in focus
    centre = scene_side_origin(lens, wavelength) - lens.length - away
    point, direction = ray[:3], ray[3:]
    point[2] -= centre
    point -= (point * direction).sum(0) * direction
    near = 1.0 / (distance + centre)
    entries = np.concatenate([direction + near * point, point]).reshape(6, RADII, ALONG, ACROSS)
    _fill(entries)
    p = np.empty(TABLES + 6 * NODES)
    p[NEGATIVE_DISTANCE], p[PER_RADIUS], p[DRIFT] = -away, (RADII - 1) / table.radius, drift
    p[PER_ALONG], p[PER_ACROSS] = 0.5 * (ALONG - 1) / reach, (ACROSS - 1) / reach
    p[CENTRE_Z], p[NEARNESS] = centre, near
    p[TABLES:] = entries.ravel()
    return Step(interpolate, p)


def _box(table: PupilTable) -> tuple[float, float]:
    """Extent of the regions from the line along which their middles move (mm), and that movement per mm of film."""
    film = table.radius * np.linspace(0.0, 1.0, 33)
    ring, _ = table.ring(film)
    centres = table.centre(film)
    drift = float(centres @ film / (film @ film))
    rims = np.maximum(np.abs(table.outline[ring]).max((1, 2)), np.abs(table.outline[ring + 1]).max((1, 2)))
    return float((np.abs(centres - drift * film) + rims).max()), drift


@njit(cache=True, error_model="numpy", nogil=True)
def _fill(entries):
    """Fill entries (6, RADII, ALONG, ACROSS) without a ray with means of neighbours, outwards; 0 in a dark radius."""
    for k in range(RADII):
        known = np.ones((ALONG, ACROSS), np.bool_)
        for i in range(ALONG):
            for j in range(ACROSS):
                for q in range(6):
                    known[i, j] &= math.isfinite(entries[q, k, i, j])
        any_known = known.any()
        while not known.all():
            before = known.copy()
            for i in range(ALONG):
                for j in range(ACROSS):
                    if before[i, j]:
                        continue
                    count = 0
                    total = np.zeros(6)
                    for a in range(max(i - 1, 0), min(i + 2, ALONG)):
                        for b in range(max(j - 1, 0), min(j + 2, ACROSS)):
                            if before[a, b]:
                                count += 1
                                for q in range(6):
                                    total[q] += entries[q, k, a, b]
                    if count or not any_known:
                        known[i, j] = True
                        for q in range(6):
                            entries[q, k, i, j] = total[q] / max(count, 1)


@stage
def interpolate(lanes, p, ints, key):
    """Replace the ray at the film by the ray in front of the lens.

    p: −film distance, radii of the table per mm, movement of the middle, places along and across per mm, z of the
    centre, 1 / distance from it, then the six tables.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    node, f, g, h = row[A0], row[A1], row[A2], row[A3]
    cosine, sine, side, limit, share = row[A4], row[A5], row[A6], row[A7], row[A8]
    behind, per_radius, drift = p[NEGATIVE_DISTANCE], p[PER_RADIUS], p[DRIFT]
    per_along, per_across, centre, near = p[PER_ALONG], p[PER_ACROSS], p[CENTRE_Z], p[NEARNESS]
    table = p[TABLES:]
    # Node below each ray, in the frame of the meridian; clear the sums
    last_r, last_u, last_v = real(RADII - 1.001), real(ALONG - 1.001), real(ACROSS - 1.001)
    for i in range(B):
        r2 = x[i] * x[i] + y[i] * y[i]
        off = r2 > real(1e-12)
        inverse = real(1) / math.sqrt(r2 if off else real(1))
        c, s = x[i] * inverse if off else real(1), y[i] * inverse
        r = r2 * inverse
        t = behind / n[i]
        a, b = x[i] + l[i] * t, y[i] + m[i] * t
        a, b = a * c + b * s - drift * r, b * c - a * s
        side[i] = real(1) if b >= real(0) else real(-1)
        k, u, v = r * per_radius, a * per_along + real(0.5 * (ALONG - 1)), abs(b) * per_across
        k = k if k < last_r else last_r
        u = u if u < last_u else last_u
        u = u if u > real(0) else real(0)
        v = v if v < last_v else last_v
        node[i] = (np.floor(k) * real(ALONG) + np.floor(u)) * real(ACROSS) + np.floor(v)
        f[i], g[i], h[i] = k - np.floor(k), u - np.floor(u), v - np.floor(v)
        cosine[i], sine[i] = c, s
        x[i], y[i], z[i], l[i], m[i], n[i] = real(0), real(0), real(0), real(0), real(0), real(0)
    # Add up the eight nodes around it by their shares
    for corner in range(8):
        beyond, along, across = real(corner // 4), real(corner // 2 % 2), real(corner % 2)
        cell = (corner // 4 * ALONG + corner // 2 % 2) * ACROSS + corner % 2
        for i in range(B):
            share[i] = ((beyond * f[i] + (real(1) - beyond) * (real(1) - f[i]))
                        * (along * g[i] + (real(1) - along) * (real(1) - g[i]))
                        * (across * h[i] + (real(1) - across) * (real(1) - h[i])))
        gather(limit, table[cell:], node)
        for i in range(B):
            l[i] += share[i] * limit[i]
        gather(limit, table[NODES + cell:], node)
        for i in range(B):
            m[i] += share[i] * limit[i]
        gather(limit, table[2 * NODES + cell:], node)
        for i in range(B):
            n[i] += share[i] * limit[i]
        gather(limit, table[3 * NODES + cell:], node)
        for i in range(B):
            x[i] += share[i] * limit[i]
        gather(limit, table[4 * NODES + cell:], node)
        for i in range(B):
            y[i] += share[i] * limit[i]
        gather(limit, table[5 * NODES + cell:], node)
        for i in range(B):
            z[i] += share[i] * limit[i]
    # Direction from the point to objects in focus, rotated back with the film point
    for i in range(B):
        c, s = cosine[i], sine[i]
        dx, dy, dz = l[i] - near * x[i], (m[i] - near * y[i]) * side[i], n[i] - near * z[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + dz * dz)
        px, py = x[i], y[i] * side[i]
        l[i], m[i], n[i] = (dx * c - dy * s) * size, (dx * s + dy * c) * size, dz * size
        x[i], y[i], z[i] = px * c - py * s, px * s + py * c, z[i] + centre


IDEAL = {"pinhole": "pinhole", "thin": "thin lens", "thick": "thick lens"}


@dataclass(frozen=True, eq=False)
class Model:
    """One model of a lens: steps from the film into the pupil (`aim`, none for an ideal model) and through the lens.

    model, degree: as for a LensCamera; "" and 0 if it has none. why: reason why the model is impossible, "" if it is
    possible.
    """

    name: str
    kind: str
    model: str = ""
    degree: int = 0
    aim: tuple[Step, ...] = ()
    lens: tuple[Step, ...] = ()
    real: Any = np.float32
    why: str = ""

    @property
    def steps(self) -> list[Step]:
        """All steps of the camera after that of the film."""
        return [*self.aim, *self.lens]


def ladder(camera: lb.LensCamera) -> list[Model]:
    """Every model of the lens of a camera with its current settings, the simplest first."""
    models = [_ideal(camera, kind, name) for kind, name in IDEAL.items()]
    try:
        table = _regions(camera)
        aim = (table.step(camera.axis_irradiance),)
        models += [_polynomial(camera, table, aim, degree) for degree in DEGREES]
        through = ray_table_step(camera.lens, camera.film_distance, table, distance=camera.focus_distance)
        models.append(Model("table", "table", aim=aim, lens=(through,)))
    except ValueError as error:
        models += [Model(f"degree {degree}", "polynomial", "polynomial", degree, why=str(error)) for degree in DEGREES]
        models.append(Model("table", "table", why=str(error)))
    aimed, *lens = replace(camera, model="trace").camera_steps()
    models += [Model(f"trace, {name}", "trace", "trace" if real is np.float32 else "", 0, (aimed,), tuple(lens), real)
              for name, real in (("float32", np.float32), ("float64", np.float64))]
    return models


def _ideal(camera: lb.LensCamera, kind: str, name: str) -> Model:
    try:
        return Model(name, kind, kind, lens=tuple(replace(camera, model=kind).camera_steps()))
    except ValueError as error:
        return Model(name, kind, kind, why=str(error))


def _regions(camera: lb.LensCamera) -> PupilTable:
    """Exit-pupil regions of a camera with a polynomial; ValueError if its lens has no polynomial or table."""
    if not camera.lens.iris.is_round:
        raise lb.LensError("the stop has blades; a polynomial or table does not give the place of rays in the stop")
    fitted = replace(camera, model="polynomial")
    return PupilTable.of(fitted.lens, fitted.film_distance, fitted.film.diagonal / 2.0, widened=False)


def _polynomial(camera: lb.LensCamera, table: PupilTable, aim: tuple[Step, ...], degree: int) -> Model:
    name = f"degree {degree}"
    try:
        fit = Polynomial.fit(camera.lens, camera.film_distance, table, degree, distance=camera.focus_distance)
        return Model(name, "polynomial", "polynomial", degree, aim, (fit.step,))
    except ValueError as error:
        return Model(name, "polynomial", "polynomial", degree, why=str(error))
