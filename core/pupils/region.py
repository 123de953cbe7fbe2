"""Exit-pupil region: the part of the plane of the last vertex from which a film point receives light."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import unit_table
from lensbench.core.optics.block_trace import clearance_tracer
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, trace
from lensbench.core.pupils.irregular_regions import IrregularRegion, irregular_regions
from lensbench.core.pupils.outline_solver import solve_outlines
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.pupils.rim_solver import solve_rims
from lensbench.core.text import significant

_OUTLINE = 1024          # points on the region of a lens without rotational symmetry
_RINGS = 512             # heights on the axis's region, traced to the stop to find where its blades begin
_BISECTIONS = 20         # of a rim with blades: to 1e-6 of the region's size


@dataclass(frozen=True, eq=False)
class ExitPupil:
    """Exit-pupil regions of a lens for film points (+r, 0), on the plane of the last vertex. Lens frame, mm.

    The region of a film point at another azimuth is rotated with it. The stop counts as the circle around its blades;
    `open_region` accounts for the blades.

    Args:
        lens: The lens.
        film_distance: Distance (mm) from the last vertex to the film.
        film_radii: (n,) array. Distances r (mm) of the film points from the axis.
        centres: (n,) array. x (mm) of the points on the meridian from which the rims are measured.
        rims: (n, m, 2) array. Points (mm) on the upper half of each rim, from its centre; 0 where no light passes. A
            region that is not star-shaped, as at the edge of the light of some lenses, has the convex outline around
            all of it.
        irregular: What such regions measure, by index; `area` and `cos4_area` are those of the light, not of the
            outline.
    """

    lens: Lens
    film_distance: float
    film_radii: np.ndarray
    centres: np.ndarray
    rims: np.ndarray
    irregular: dict[int, IrregularRegion] = field(default_factory=dict)

    def boundary(self, i: int) -> np.ndarray:
        """Rim of region i: points (2 m − 2, 2), mm, counter-clockwise from the farthest in +x."""
        half = self.rims[i] + [self.centres[i], 0.0]
        return np.concatenate([half, half[-2:0:-1] * [1.0, -1.0]])

    @property
    def area(self) -> np.ndarray:
        """Areas (n,) in mm²: ∫ r²/2 over all directions, by the trapezium rule."""
        total = _around((self.rims**2).sum(2), _turns(self.rims))
        for k, region in self.irregular.items():
            total[k] = region.area
        return total

    @property
    def cos4_area(self) -> np.ndarray:
        """Integrals (n,) ∫ cos⁴θ dA in mm², θ at the film point; over film_distance², the irradiance of radiance 1.

        By Gauss's rule along each radius of the region and the trapezium rule around it.
        """
        total, z2 = np.zeros(len(self.rims)), self.film_distance**2
        from_film = np.stack([self.centres - self.film_radii, 0.0 * self.centres], 1)[:, None, :]
        r2, turns = (self.rims**2).sum(2), _turns(self.rims)
        for t, w in zip(*gauss_rule(12), strict=True):
            cos2 = z2 / (z2 + ((t * self.rims + from_film)**2).sum(2))
            total += w * _around(2.0 * t * r2 * cos2**2, turns)
        for k, region in self.irregular.items():
            total[k] = region.cos4_area
        return total

    @property
    def bounds(self) -> np.ndarray:
        """Bounding boxes (n, 4) x0, y0, x1, y1 in mm: those that pbrt samples."""
        tops = np.array([_peak(rim[:, 1]) for rim in self.rims])
        left, right = (np.array([_peak(sign * rim[:, 0]) for rim in self.rims]) for sign in (-1.0, 1.0))
        return np.stack([self.centres - left, -tops, self.centres + right, tops], 1)

    @cached_property
    def _table(self) -> "PupilTable":
        return PupilTable.of(self.lens, self.film_distance, float(self.film_radii.max()))

    def sample(self, film_xy: ArrayLike, uv: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Points of the regions of any film points, as a LensCamera samples them.

        The map keeps equal areas equal. The sampled region is a hair larger than the true one.

        Args:
            film_xy: (n, 2) array. Film points (mm).
            uv: (n, 2) array. Pupil samples in [0, 1]².
        Returns:
            points: (n, 2) array. Points (mm) on the plane of the last vertex.
            areas: (n,) array. Areas (mm²) of the sampled regions.
        Raises:
            LensError: Film points farther from the axis than the largest of film_radii.
            ValueError: Samples outside the unit square.
        """
        film_xy, uv = np.asarray(film_xy, float), unit_table(uv, np.float64)
        if not (np.hypot(film_xy[:, 0], film_xy[:, 1]) <= self.film_radii.max() * (1.0 + 1e-9)).all():
            raise LensError(f"this pupil is solved for film points up to {significant(self.film_radii.max())} mm "
                            f"from the axis")
        n = len(film_xy)
        x, y, l, m, n_, weight = Program([self._table.step(1.0)], np.float64).run(
            {X: film_xy[:, 0], Y: film_xy[:, 1], U0: uv[:, 0], U1: uv[:, 1], WEIGHT: np.ones(n)},
            [X, Y, L, M, N, WEIGHT], n)
        along = self.film_distance / -n_
        return np.stack([x + along * l, y + along * m], 1), weight / n_**4


def _turns(rims: np.ndarray) -> np.ndarray:
    """Angles (n, m − 1) between the points of the upper halves."""
    return np.diff(np.arctan2(rims[..., 1], rims[..., 0]))


def _around(radial: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """∫ radial dθ (n,) over the upper halves: for radial (n, m) = 2 ∫ f r dr, the integral of f over whole regions."""
    return ((radial[:, 1:] + radial[:, :-1]) * 0.5 * turns).sum(1)


def _peak(values: np.ndarray) -> float:
    """Maximum of a curve sampled at equal steps: that of the parabola through its three highest neighbours."""
    i = int(np.argmax(values))
    if not 0 < i < len(values) - 1:
        return float(values[i])
    before, middle, after = values[i - 1:i + 2]
    bend = before - 2.0 * middle + after
    return float(middle - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(middle)


def exit_pupil(lens: Lens, film_distance: float, film_radii: ArrayLike, wavelength: float = D_LINE,
               points: int = 257) -> ExitPupil:
    """Exit-pupil regions of a rotationally symmetric lens, to 1e-10 of its rear semi-diameter; irregular ones to 1e-3.

    Pieces that no ray of the search meets are left out: up to a few hundredths of a region near the end of the light.

    Args:
        lens: The lens, focused.
        film_distance: Distance (mm) from the last vertex to the film.
        film_radii: float or (n,) array. Distances (mm) of the film points from the axis.
        wavelength: Wavelength of the light (µm).
        points: Number of points on the upper half of each rim.
    Raises:
        LensError: Negative film radii, a film that is not behind the lens, or a lens without rotational symmetry.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    if not (np.isfinite(radii).all() and (radii >= 0.0).all() and math.isfinite(film_distance) and film_distance > 0.0):
        raise LensError("the exit pupil needs film radii of at least 0 mm and a film behind the lens")
    tolerance = 1e-10 * lens.surfaces[-1].semi_diameter
    by = clearance_tracer(lens, film_distance, wavelength)
    centres, rims = solve_rims(lens, film_distance, radii, points, tolerance, wavelength, by=by)
    irregular = irregular_regions(lens, film_distance, radii, centres, rims, by)
    for k, region in irregular.items():
        centres[k], rims[k] = region.centre, region.rim
    return ExitPupil(lens, film_distance, radii, centres, rims, irregular)


def axis_irradiance(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> float:
    """∫ cos⁴θ dA (mm²) over the region that the axis point of the film sees through the stop's blades or its picture.

    On the axis a ray keeps its azimuth: along each, the region ends where the ray meets the blades in the stop.
    """
    if not lens.is_rotationally_symmetric:
        if lens.stop_image is not None:
            return _weighed_area(lens, film_distance, wavelength)
        return _cos4_area(open_region(lens, film_distance, (0.0, 0.0), wavelength), film_distance)
    pupil = exit_pupil(lens, film_distance, [0.0], wavelength)
    if lens.iris.is_round or not pupil.area[0] > 0.0:
        return float(pupil.cos4_area[0])
    rim, z2 = pupil.rims[0, 0, 0], film_distance**2
    height = np.linspace(0.0, rim * (1.0 - 1e-9), _RINGS)
    film = np.array([0.0, 0.0, lens.length + film_distance])
    rays = np.column_stack([height, 0.0 * height, np.full(_RINGS, lens.length)]) - film
    met = trace(lens, film, rays, wavelength, clip=False, record=True).paths
    assert met is not None
    at_stop = np.abs(met[:, len(lens.surfaces) - lens.stop_index, 0]) / lens.stop.semi_diameter
    within = np.pi * z2 * height**2 / (z2 + height**2)          # closed form for the disk of this radius
    return lens.iris.mean(lambda r: np.interp(r, at_stop, within))


def _weighed_area(lens: Lens, film_distance: float, wavelength: float) -> float:
    """∫ cos⁴θ dA (mm²) over the region of the film's axis point, times the transmission of the picture in the stop."""
    outline = open_region(lens, film_distance, (0.0, 0.0), wavelength)
    if not len(outline):
        return 0.0
    middle = outline.mean(0)
    edge = outline - middle
    after = np.roll(edge, -1, 0)
    doubled = edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0]
    # Rings of equal areas about the middle of the region, by the middle of each triangle's side
    rings = np.sqrt((np.arange(_RINGS // 2) + 0.5) / (_RINGS // 2))[:, None, None]
    points = (middle + rings * 0.5 * (edge + after)).reshape(-1, 2)
    film = np.array([0.0, 0.0, lens.length + film_distance])
    rays = np.column_stack([points, np.full(len(points), lens.length)]) - film
    met = trace(lens.with_open_stop, film, rays, wavelength, record=True)
    assert met.paths is not None
    on_stop = lens.in_frame_of(lens.stop_index, met.paths[:, len(lens.surfaces) - lens.stop_index])
    share = lens.iris.transmission(*(on_stop[:, :2] / lens.stop.semi_diameter).T)
    cos2 = film_distance**2 / (film_distance**2 + (points**2).sum(1))
    light = np.where(met.fate == Fate.PASSED, share * cos2**2, 0.0).reshape(len(rings), -1)
    return float((light.mean(0) * 0.5 * doubled).sum())


def _cos4_area(outline: np.ndarray, film_distance: float) -> float:
    """∫ cos⁴θ dA (mm²) over a region seen from the film's axis point, by Gauss's rule in triangles."""
    if not len(outline):
        return 0.0
    nodes, weights = gauss_rule(8)
    after = np.roll(outline, -1, 0)
    twice = outline[:, 0] * after[:, 1] - outline[:, 1] * after[:, 0]
    total = 0.0
    for s, ws in zip(nodes, weights, strict=True):              # from the centre outwards
        for t, wt in zip(nodes, weights, strict=True):          # along the chord
            x, y = (s * (outline + t * (after - outline))).T
            cos2 = film_distance**2 / (film_distance**2 + x * x + y * y)
            total += ws * wt * float((s * twice * cos2**2).sum())
    return total


def _outline(lens: Lens, film_distance: float, film_xy: np.ndarray, wavelength: float) -> np.ndarray:
    """Outline (m, 2) of the region that a film point sees through a round stop; empty where no light passes."""
    if not lens.is_rotationally_symmetric:
        centre, rim = solve_outlines(lens, film_distance, [film_xy], _OUTLINE, 1e-8 * lens.stop.semi_diameter,
                                     wavelength)
        return np.asarray(centre[0] + rim[0] if rim.any() else np.zeros((0, 2)))
    r = math.hypot(*film_xy)
    pupil = exit_pupil(lens, film_distance, [r], wavelength)
    if not pupil.area[0] > 0.0:
        return np.zeros((0, 2))
    cosine, sine = film_xy / r if r > 0.0 else (1.0, 0.0)
    return np.asarray(pupil.boundary(0) @ np.array([[cosine, sine], [-sine, cosine]]))


def open_region(lens: Lens, film_distance: float, film_xy: ArrayLike, wavelength: float = D_LINE) -> np.ndarray:
    """Region that a film point sees through the stop's blades, on the plane of the last vertex.

    With a round stop it is the exit-pupil region; a picture in the stop counts as its circle. For lenses of any
    symmetry, to 1e-6 of the region's size.

    Args:
        lens: The lens, focused.
        film_distance: Distance (mm) from the last vertex to the film.
        film_xy: (2,) array. Film point (mm).
        wavelength: Wavelength of the light (µm).
    Returns:
        (m, 2) array. Outline (mm), counter-clockwise; empty where no light passes.
    Raises:
        LensError: A film that is not behind the lens.
    """
    film_xy, lens = np.asarray(film_xy, float), lens.with_open_stop
    rim = _outline(lens, film_distance, film_xy, wavelength)
    if lens.iris.is_round or not len(rim):
        return rim
    film = np.array([*film_xy, lens.length + film_distance])

    def passing(points: np.ndarray) -> np.ndarray:
        """Whether rays through these points (n, 2) of the rear plane pass the lens and its blades."""
        directions = np.column_stack([points, np.full(len(points), lens.length)]) - film
        return trace(lens, film, directions, wavelength).fate == Fate.PASSED

    # Bisect from the centre of the points that pass to the rim
    middle = rim.mean(0)
    share = np.sqrt((np.arange(12) + 0.5) / 12.0)[:, None, None]
    places = (middle + share * (rim[::8] - middle)).reshape(-1, 2)
    inside = places[passing(places)]
    if not len(inside):
        return np.zeros((0, 2))
    middle = inside.mean(0)
    low, high = np.zeros(len(rim)), np.ones(len(rim))
    for _ in range(_BISECTIONS):
        half = 0.5 * (low + high)
        passed = passing(middle + half[:, None] * (rim - middle))
        low, high = np.where(passed, half, low), np.where(passed, high, half)
    return middle + low[:, None] * (rim - middle)
