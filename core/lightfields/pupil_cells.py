"""Cells of the pupil: the grid of squares through which a light field records its views.

Places in the pupil are in radii of the paraxial exit pupil, u to the right and v up; camera frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.lightfields.light_field import LightFieldError, require_film_in_line, require_focus
from lensbench.core.pupils.film_grid import SECTORS
from lensbench.core.pupils.film_grid_sampler import PupilGrid
from lensbench.core.pupils.posed_sampler import PosedPupil
from lensbench.core.pupils.radial_sampler import PupilTable

FILM_POINTS = 33        # along each axis of the film, from which the reach of a pupil is found

# Parameters of `aim_at_cell` and `gaussian_through_cell`: the corner and sides of a cell, in the pupil's radii, then
LEFT, LOW, WIDTH, HEIGHT = range(4)
# of `aim_at_cell`, the slope by the film point and by the place in the pupil;
APPROACH_FILM, APPROACH_PUPIL = range(4, 6)
# of `gaussian_through_cell`, the numbers of `Gaussian`
(GAUSS_Z, GAUSS_ORIGIN_FILM, GAUSS_ORIGIN_PUPIL, GAUSS_SLOPE_FILM, GAUSS_SLOPE_PUPIL, GAUSS_APPROACH_FILM,
 GAUSS_APPROACH_PUPIL) = range(4, 11)


class Cell(NamedTuple):
    """The box of a cell of the pupil that light can come through."""

    corner: tuple[float, float]     # left and low, in the pupil's radii
    sides: tuple[float, float]
    share: float                    # of the whole cell's area


def lit_cell(reach: float, views: tuple[int, int], view: tuple[int, int]) -> Cell:
    """The box of the cell at this place (across, down) that lies within the circle of radius `reach`."""
    sides = [2.0 * reach / number for number in views]
    low = [-reach + k * side for k, side in zip(view, sides, strict=True)]
    high = [a + side for a, side in zip(low, sides, strict=True)]
    nearest = [max(a, -b, 0.0) for a, b in zip(low, high, strict=True)]
    for axis in (0, 1):
        half = math.sqrt(max(reach**2 - nearest[1 - axis] ** 2, 0.0))
        low[axis], high[axis] = max(low[axis], -half), min(high[axis], half)
    width, height = (max(b - a, 0.0) for a, b in zip(low, high, strict=True))
    return Cell((low[0], low[1]), (width, height), width * height / (sides[0] * sides[1]))


def pupil_reach(camera: Camera) -> float:
    """The largest radius from which light comes to any film point, in radii of the paraxial exit pupil.

    LightFieldError for a camera without an aperture or a focus, or whose film points share no bladed pupil.
    """
    lens = camera.gaussian
    require_film_in_line(camera)
    if camera.weights == "radiance":
        raise LightFieldError("light fields know the weights relative and physical: leave out weights=\"radiance\"")
    if lens.is_hole:
        if lens.slope_film == 0.0:
            raise LightFieldError("parallel rays see each point from one side alone: give the orthographic camera a "
                                  "lens radius and a finite focus distance")
        raise LightFieldError("a pinhole sees from one place alone: record a light field through a lens")
    require_focus(camera)
    if not camera.follows_rays:
        if not lens.iris.is_round and lens.origin_film != 0.0:
            raise LightFieldError("without a pupil that all film points share, the ideal models record a light field "
                                  "through a round stop alone: choose the full trace, or no blades")
        return 1.0
    regions = camera.pupil
    assert not isinstance(regions, PosedPupil)                  # the film is centred
    film, slopes = (_radial_rims(regions, camera.film.diagonal / 2.0) if isinstance(regions, PupilTable)
                    else _grid_rims(regions))
    return float(np.hypot(*(slopes - lens.approach_film * film)).max() / abs(lens.approach_pupil))


def _radial_rims(table: PupilTable, farthest: float) -> tuple[np.ndarray, np.ndarray]:
    """Film points (2, n, 1) along a radius of a symmetric lens, and slopes (2, n, m) from them to the pupil's rim."""
    radii = farthest * np.linspace(0.0, 1.0, FILM_POINTS)
    radii = radii[radii <= table.radius]
    ring, inner = table.ring(radii)
    rim = table.outline[ring + np.rint(inner).astype(int)]
    film = np.stack([radii, np.zeros_like(radii)])[..., None]
    to = np.stack([rim[..., 0] + (table.centre(radii) - radii)[:, None], rim[..., 1]])
    return film, to / table.film_distance


def _grid_rims(grid: PupilGrid) -> tuple[np.ndarray, np.ndarray]:
    """Film points (2, n) of the quadrants that the grid knows, and slopes (2, n) to the rim."""
    low = 0.0 if len(grid.nodes.edge) == 1 else -1.0
    x, y, turn = (axis.ravel() for axis in np.meshgrid(
        grid.half_width * np.linspace(low, 1.0, FILM_POINTS), grid.half_height * np.linspace(low, 1.0, FILM_POINTS),
        (np.arange(4 * SECTORS) + 0.5) / (4 * SECTORS)))
    l, m, n, weight = Program([grid.step(1.0)], np.float64).run(
        {X: x, Y: y, U0: turn, U1: np.full_like(turn, 1.0)}, [L, M, N, WEIGHT], len(turn))
    lit = weight > 0.0
    return np.stack([x, y])[:, lit], np.stack([l, m])[:, lit] / -n[lit]


def cell_steps(camera: Camera, cell: Cell, wavelength: float) -> list[Step]:
    """The stages from the film point X, Y and U0, U1 of a cell to the ray; WEIGHT: cos⁴θ where light comes."""
    lens, box = camera.gaussian, [*cell.corner, *cell.sides]
    if camera.follows_rays:
        aim = Step(aim_at_cell, [*box, lens.approach_film, lens.approach_pupil])
        return [aim, *camera.lens_steps(wavelength)]
    return [Step(gaussian_through_cell, [*box, *lens[:-1]]), *lens.iris.blocking(lens.origin_pupil)]


@stage
def sample_disk(lanes, p, ints, key):
    """U0, U1: from the unit square to its inscribed disk, uniformly."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v = row[U0], row[U1]
    for i in range(B):
        a, b = concentric_disk(real, u[i], v[i])
        u[i], v[i] = real(0.5) + real(0.5) * a, real(0.5) + real(0.5) * b


@stage
def aim_at_cell(lanes, p, ints, key):
    """L, M, N: from the film point X, Y (Z = 0) towards a place of the cell, by U0, U1; WEIGHT: cos⁴θ."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[U0], row[U1]
    left, low, width, height = p[LEFT], p[LOW], p[WIDTH], p[HEIGHT]
    film, pupil = p[APPROACH_FILM], p[APPROACH_PUPIL]
    for i in range(B):
        dx, dy = x[i] * film + (left + u[i] * width) * pupil, y[i] * film + (low + v[i] * height) * pupil
        cos2 = real(1) / (dx * dx + dy * dy + real(1))
        size = math.sqrt(cos2)
        l[i], m[i], n[i] = dx * size, dy * size, -size
        z[i] = real(0)
        weight[i] = cos2 * cos2


@stage
def gaussian_through_cell(lanes, p, ints, key):
    """X … N: the ray of an ideal lens (`Gaussian`) by a place of the cell, by U0, U1; WEIGHT: cos⁴θ, 0 off the disk."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[U0], row[U1]
    left, low, width, height = p[LEFT], p[LOW], p[WIDTH], p[HEIGHT]
    plane, origin_film, origin_pupil = p[GAUSS_Z], p[GAUSS_ORIGIN_FILM], p[GAUSS_ORIGIN_PUPIL]
    slope_film, slope_pupil = p[GAUSS_SLOPE_FILM], p[GAUSS_SLOPE_PUPIL]
    approach_film, approach_pupil = p[GAUSS_APPROACH_FILM], p[GAUSS_APPROACH_PUPIL]
    for i in range(B):
        # Place in the pupil, and the direction on the scene's side
        a, b = left + u[i] * width, low + v[i] * height
        dx, dy = x[i] * slope_film + a * slope_pupil, y[i] * slope_film + b * slope_pupil
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size

        # cos⁴ of the angle on the film's side
        ex, ey = x[i] * approach_film + a * approach_pupil, y[i] * approach_film + b * approach_pupil
        cos2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = cos2 * cos2 if a * a + b * b <= real(1) else real(0)
        x[i], y[i], z[i] = x[i] * origin_film + a * origin_pupil, y[i] * origin_film + b * origin_pupil, plane
