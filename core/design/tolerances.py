"""Tolerances of a lens: what each error of manufacture costs, and what a production run looks like.

    costs = lb.tolerances.sensitivities(lens, film)
    run = lb.tolerances.production(lens, film, lb.tolerances.Tolerances(decentre=0.02), copies=500)
    lens_as_built = lb.tolerances.manufactured(lens, run, 7)

Lengths in mm, angles in radians. Every copy of a lens focused at infinity is refocused on the axis, by the rays of
`tolerance_rays`. It can be had as a lens of its own, and as pictures of a star in every field.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.design.tolerance_rays import Judge, built, elements
from lensbench.core.imaging.film import Film
from lensbench.core.optics.glass import D_LINE, MODEL_RANGE, Glass
from lensbench.core.optics.lens_surface import LensError, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import trace
from lensbench.core.text import significant

MOST_COPIES = 100_000
LARGEST = 0.5                   # of a tolerance, in its own unit


@dataclass(frozen=True)
class Tolerances:
    """Largest errors of manufacture; drawn from a normal distribution whose 2 σ they are, cut there.

    Args:
        radius: Of every radius of curvature between two media, as a part of it.
        thickness: Of every thickness and air gap, mm.
        index: Of every glass.
        decentre: Of every element, or cemented group, across the axis: mm in x and in y.
        tilt: Of every element about its front vertex: radians about x and about y.
    Raises:
        LensError: For a negative number, or one that is not finite.
    """

    radius: float = 0.001
    thickness: float = 0.02
    index: float = 0.0005
    decentre: float = 0.01
    tilt: float = math.radians(1.0 / 60.0)

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(value) and 0.0 <= value < LARGEST):
                raise LensError(f"tolerance of {name} {significant(value)}: it must lie from 0 to {LARGEST}")


@dataclass(frozen=True)
class Sensitivity:
    """What one error costs.

    Args:
        kind: "radius", "thickness", "index", "decentre" or "tilt".
        surface: The surface, or the first one of the element, from 0.
        tolerance: The error: a part of the radius, mm, or radians.
        spot: Growth of the rms spot (mm, mean over the fields) at the worse of both signs; NaN where no light of a
            field arrives with this error, which then comes first.
        contrast: Change of the mean contrast at the middle frequency there; negative for a loss.
    """

    kind: str
    surface: int
    tolerance: float
    spot: float
    contrast: float


@dataclass(frozen=True, eq=False)
class Production:
    """A Monte Carlo run of copies.

    Args:
        fields: Image heights (mm) along y.
        frequencies: (n,) array. Cycles / mm.
        nominal: (fields, n, 2) array. Contrast of the lens as designed, for detail across the field (sagittal), then
            along it (tangential): its MTF by diffraction, or that of its rays where `ray_grid` finds no light at that
            image height.
        contrast: (copies, fields, n, 2) array. That of the copies.
        nominal_spots, spots: (fields,) and (copies, fields) arrays. rms radii (mm); NaN, with a contrast of 0, where no
            light of the field arrives.
        nominal_film, film: float and (copies,) array. Where the film stands (mm) behind the first vertex of the design
            and of each copy: the best focus, as `best_focus` defines it, of the run's rays.
        drawn: (copies, errors) array. The errors, in the units of Tolerances, by `names`.
        names: tuple of (str, int). Kind and surface of each error.
    """

    fields: tuple[float, ...]
    frequencies: np.ndarray
    nominal: np.ndarray
    contrast: np.ndarray
    nominal_spots: np.ndarray
    spots: np.ndarray
    nominal_film: float
    film: np.ndarray
    drawn: np.ndarray
    names: tuple[tuple[str, int], ...]

    def band(self, percentiles: Sequence[float] = (5.0, 50.0, 95.0)) -> np.ndarray:
        """Percentiles (p, fields, n, 2) of the contrast over the copies; percentiles: p numbers from 0 to 100."""
        return np.percentile(self.contrast, percentiles, axis=0)


def _errors(lens: Lens, within: Tolerances) -> list[tuple[str, int, float]]:
    """Kind, surface and tolerance of every error; decentre and tilt of an element once for each axis."""
    errors: list[tuple[str, int, float]] = []
    before = lens.front_index
    for i, surface in enumerate(lens.surfaces):
        if surface.glass.n_d != before and surface.curvature != 0.0:
            errors.append(("radius", i, within.radius))
        before = surface.glass.n_d
    errors += [("thickness", i, within.thickness) for i in range(len(lens.surfaces) - 1)]
    errors += [("index", i, within.index) for i, s in enumerate(lens.surfaces[:-1]) if s.glass.n_d > 1.0]
    for kind, tolerance in (("decentre", within.decentre), ("tilt", within.tilt)):
        errors += [(kind, first, tolerance) for first, _ in elements(lens) for _ in range(2)]
    return [error for error in errors if error[2] > 0.0]


def sensitivities(lens: Lens, film: Film | None = None, tolerances: Tolerances | None = None,
                  frequencies: ArrayLike | None = None, wavelengths: str | Sequence[Any] | None = None
                 ) -> tuple[Sensitivity, ...]:
    """What each error of a lens costs by itself, the costliest first.

    Args:
        lens: Rotationally symmetric, stopped down as it is used; decentres and tilts lie in the plane of the fields.
        film: Its half-diagonal is the largest image height, or less where no light reaches it; None: `lens.film_size`,
            else 36 × 24 mm.
        tolerances: The errors; None: the defaults of the class.
        frequencies: (n,) array_like or None. Cycles / mm; the middle one counts. None: 10 to 60.
        wavelengths: None, str or sequence. As for `conditions`.
    Returns:
        One for each error, its numbers as the class documents them.
    Raises:
        LensError: For a lens with a cylinder or toroid, or one that hardly a ray passes.
    """
    judge = Judge(lens, film, frequencies, wavelengths)
    every = _errors(lens, tolerances or Tolerances())
    errors = [e for k, e in enumerate(every) if e not in every[:k]]        # one axis of each decentre and tilt
    drawn = np.zeros((2 * len(errors) + 1, len(errors)))
    for k, (_, _, tolerance) in enumerate(errors):
        drawn[2 * k + 1, k], drawn[2 * k + 2, k] = tolerance, -tolerance
    _, spots, contrast = judge.judged(*built(judge, errors, drawn))
    middle = len(judge.frequencies) // 2
    size, contrasts = spots.mean(1), contrast[:, :, middle].mean((1, 2))
    rows = []
    for k, (kind, surface, tolerance) in enumerate(errors):
        worse = max((2 * k + 1, 2 * k + 2), key=lambda row: (math.isnan(size[row]), size[row]))
        rows.append(Sensitivity(kind, surface, tolerance, float(size[worse] - size[0]),
                                float(contrasts[worse] - contrasts[0])))
    return tuple(sorted(rows, key=lambda row: -row.spot if row.spot == row.spot else -math.inf))


def production(lens: Lens, film: Film | None = None, tolerances: Tolerances | None = None, copies: int = 1000,
               seed: int = 0, frequencies: ArrayLike | None = None, wavelengths: str | Sequence[Any] | None = None
              ) -> Production:
    """Copies of a lens with errors drawn at random, each refocused.

    Args:
        lens, film, tolerances, frequencies, wavelengths: As for `sensitivities`; decentres and tilts lie in both
            planes.
        copies: Number of copies, 1 to 100,000.
        seed: Of the random numbers: the same seed draws the same copies.
    Raises:
        LensError: As `sensitivities`, and for another number of copies.
    """
    if not 1 <= copies <= MOST_COPIES:
        raise LensError(f"{copies} copies: there must be 1 to {MOST_COPIES}")
    judge = Judge(lens, film, frequencies, wavelengths)
    errors = _errors(lens, tolerances or Tolerances())
    random = np.random.default_rng(seed)
    drawn = random.standard_normal((copies, len(errors)))
    while (beyond := np.abs(drawn) > 2.0).any():
        drawn[beyond] = random.standard_normal(int(beyond.sum()))
    drawn *= 0.5 * np.array([tolerance for _, _, tolerance in errors])
    design, spots, contrast = judge.judged(*built(judge, errors, np.zeros((1, len(errors)))))
    focus, made, contrasts = judge.judged(*built(judge, errors, drawn))
    return Production(judge.image_heights, judge.frequencies, contrast[0], contrasts, spots[0],
                      made, judge.film_z + float(design[0]), judge.film_z + focus, drawn,
                      tuple((kind, surface) for kind, surface, _ in errors))


LINES = 25              # wavelengths at which a changed glass is listed


def manufactured(lens: Lens, run: Production, copy: int) -> Lens:
    """A copy of a production run, with its errors of radius, thickness, index, decentre and tilt.

    Args:
        lens: That of the run.
        run: As `production` gives it.
        copy: Number of the copy, from 0.
    Returns:
        Focused as a whole: at the positions of its groups that `lens` has. A changed glass is a table of 25 indices,
            within 1e-6 of the exact ones.
    Raises:
        LensError: For a copy that the run does not have, or a run of another lens.
    """
    if not 0 <= copy < len(run.drawn):
        raise LensError(f"copy {copy}: this run has the copies 0 to {len(run.drawn) - 1}")
    if any(surface >= len(lens.surfaces) for _, surface in run.names):
        raise LensError("the production run belongs to another lens, with more surfaces")
    surfaces, last = list(lens.surfaces), dict(elements(lens))
    poses: dict[int, dict[str, list[float]]] = {}
    for (kind, i), error in zip(run.names, run.drawn[copy].tolist(), strict=True):
        old = surfaces[i]
        if kind == "radius":
            surfaces[i] = replace(old, curvature=old.curvature / (1.0 + error))
        elif kind == "thickness":
            surfaces[i] = replace(old, thickness=old.thickness + error)
        elif kind == "index":
            surfaces[i] = replace(old, glass=_changed(old.glass, error))
        else:
            poses.setdefault(i, {}).setdefault(kind, []).append(error)
    for first, errors in poses.items():
        (dy, dx), (about_x, about_y) = (errors.get(kind, (0.0, 0.0)) for kind in ("decentre", "tilt"))
        for i in range(first, last[first] + 1):
            surfaces[i] = replace(surfaces[i], pose=SurfacePose(dx, dy, about_x, about_y, i - first))
    return replace(lens, surfaces=tuple(surfaces), positions=None)


def _changed(glass: Glass, change: float) -> Glass:
    """The glass with an index that is higher by a number at every wavelength."""
    if not glass.disperses:
        return replace(glass, n_d=glass.n_d + change, name="")
    low, high = glass.wavelengths or MODEL_RANGE
    if low < D_LINE < high:
        low, high = max(low, MODEL_RANGE[0]), min(high, MODEL_RANGE[1])
    lines = np.clip(np.linspace(low**-2, high**-2, LINES) ** -0.5, low, high).tolist()      # even for the cubic in λ⁻²
    return Glass(glass.n_d + change, glass.v_d, "", "table",
                 tuple((line, glass.index(line) + change) for line in lines))


PAIRS = 36              # of sectors
PART = 36               # windows along the diagonal of the film
SIDE, FINE = 96, 4      # pixels of a picture; of each, points of the star that are averaged, along a side


def star_pictures(lens: Lens, run: Production, copies: Sequence[int], film: Film | None = None,
                  wavelengths: str | Sequence[Any] | None = None) -> tuple[np.ndarray, float]:
    """Pictures of a star in every field, through the design and through copies of it.

    Args:
        lens: That of the run.
        run: As `production` gives it for `film`.
        copies: Numbers of the copies, from 0.
        film, wavelengths: As for `production`.
    Returns:
        (1 + copies, fields, SIDE, SIDE) array, float. The design first; 0 black to 1 white, row 0 at the bottom (y of
            the lens frame points up). Then the width of a picture on the film, mm.
    Raises:
        LensError: As `production`, and for copies that the run does not have.
    """
    judge = Judge(lens, film, None, wavelengths)
    width = 2.0 * judge.height / PART
    beams = [_points(judge, lens, run.nominal_film)]
    beams += [_points(judge, manufactured(lens, run, copy), run.film[copy]) for copy in copies]
    fine, star = width / (SIDE * FINE), np.fft.rfft2(_star(2 * SIDE * FINE))
    pictures = np.empty((len(beams), len(run.fields), SIDE, SIDE))
    for row, points in enumerate(beams):
        for field in range(len(run.fields)):
            of_field = judge.fields == field
            weights = np.outer(judge.weights, judge.areas[of_field]).ravel()
            pictures[row, field] = _folded(star, points[:, of_field].reshape(-1, 2), weights, fine)
    return pictures, width


def _points(judge: Judge, lens: Lens, film_z: float) -> np.ndarray:
    """Where the rays of a run land (wavelengths, rays, 2), mm."""
    points = []
    for wavelength in judge.wavelengths:
        rays = trace(lens, judge.origins, judge.directions, wavelength, clip=False, forward=True)
        away = (film_z - rays.points[:, 2:]) / rays.directions[:, 2:]
        points.append(rays.points[:, :2] + away * rays.directions[:, :2])
    return np.array(points)


def _star(side: int) -> np.ndarray:
    """A star (side, side) of 0 and 1 about the middle."""
    offsets = np.arange(side) - 0.5 * (side - 1)
    return (np.floor(np.arctan2(offsets[:, None], offsets[None]) * (PAIRS / np.pi)) % 2.0).astype(float)


def _folded(star: np.ndarray, points: np.ndarray, weights: np.ndarray, fine: float) -> np.ndarray:
    """The star, given by its transform, with each of its points spread over a spot about its middle."""
    side = 2 * SIDE * FINE
    known = np.isfinite(points).all(1)
    points, weights = points[known], weights[known] / weights[known].sum()
    places = (points - weights @ points) / fine
    low = np.floor(places).astype(int)
    (fx, fy), spot = (places - low).T, np.zeros((side, side))
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        shares = np.where(dx, fx, 1.0 - fx) * np.where(dy, fy, 1.0 - fy)
        np.add.at(spot, ((low[:, 1] + dy) % side, (low[:, 0] + dx) % side), weights * shares)
    picture = np.fft.irfft2(star * np.fft.rfft2(spot), (side, side))
    edge = SIDE * FINE // 2
    middle = picture[edge:side - edge, edge:side - edge]
    return np.clip(middle.reshape(SIDE, FINE, SIDE, FINE).mean((1, 3)), 0.0, 1.0)
