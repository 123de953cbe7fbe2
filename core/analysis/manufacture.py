"""Tolerances of a lens: what each error of manufacture costs, and what a production run looks like.

Lengths in mm, angles in radians. The lens is focused at infinity; every copy is refocused on the axis, as a camera or
an assembler does. Fields lie along y on both sides of the axis, since a decentred element images them differently. Rays
are those that pass the rims of the nominal lens, the same for all copies. The contrast of the design is its MTF by
diffraction; a copy changes it by as much as its spots, times the limit of diffraction on the axis, change theirs.

One copy of a production run as a lens of its own, to be traced, focused and photographed like any other.
"""

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import conditions
from lensbench.core.analysis.grids.traced_grid import ray_grid
from lensbench.core.analysis.perturbed_copies import (
    AROUND_X, AROUND_Y, DX, DY, POSE, bodies, change_gap, change_index, change_radius, copies_of, elements,
    judge_copies, set_poses, trace_copies
)
from lensbench.core.analysis.transfer_function import mtf
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.pauses import due, pause
from lensbench.core.optics.focus import film_distance
from lensbench.core.optics.glass import D_LINE, MODEL_RANGE, Glass
from lensbench.core.optics.lens_surface import LensError, SurfacePose
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, surface_table, trace
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
MOST_COPIES = 100_000
LARGEST = 0.5                   # of a tolerance, in its own unit


@dataclass(frozen=True)
class Tolerances:
    """Largest errors of manufacture; drawn from a normal distribution whose 2 σ they are, cut there.

    Parameters
    ----------
    radius : float
        Of every radius of curvature between two media, as a part of it.
    thickness : float
        Of every thickness and air gap, mm.
    index : float
        Of every glass.
    decentre : float
        Of every element, or cemented group, across the axis: mm in x and in y.
    tilt : float
        Of every element about its front vertex: radians about x and about y.

    Raises
    ------
    LensError
        For a negative number, or one that is not finite.
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

    Parameters
    ----------
    kind : str
        "radius", "thickness", "index", "decentre" or "tilt".
    surface : int
        The surface, or the first one of the element, from 0.
    tolerance : float
        The error: a part of the radius, mm, or radians.
    spot : float
        Growth of the rms spot (mm, mean over the fields) at the worse of both signs; NaN where no light of a field
        arrives with this error, which then comes first.
    contrast : float
        Change of the mean contrast at the middle frequency there; negative for a loss.
    """

    kind: str
    surface: int
    tolerance: float
    spot: float
    contrast: float


@dataclass(frozen=True, eq=False)
class Production:
    """A Monte Carlo run of copies.

    Parameters
    ----------
    fields : tuple of float
        Image heights (mm) along y.
    frequencies : (n,) array
        Cycles / mm.
    nominal : (fields, n, 2) array
        Contrast of the lens as designed, for detail across the field (sagittal), then along it (tangential): its MTF
        by diffraction, or that of its rays where `ray_grid` finds no light at that image height.
    contrast : (copies, fields, n, 2) array
        That of the copies.
    nominal_spots, spots : (fields,) and (copies, fields) arrays
        rms radii (mm); NaN, with a contrast of 0, where no light of the field arrives.
    nominal_film, film : float and (copies,) array
        Where the film stands (mm) behind the first vertex of the design and of each copy: the best
        focus, as `best_focus` defines it, of the run's rays.
    drawn : (copies, errors) array
        The errors, in the units of Tolerances, by `names`.
    names : tuple of (str, int)
        Kind and surface of each error.
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

    def band(self, percentiles=(5.0, 50.0, 95.0)) -> np.ndarray:
        """Percentiles of the contrast over the copies.

        Parameters
        ----------
        percentiles : sequence of float
            p numbers from 0 to 100.

        Returns
        -------
        (p, fields, n, 2) array
        """
        return np.percentile(self.contrast, percentiles, axis=0)


class Judge:
    """The rays of a lens, by which all of its copies are judged: see `sensitivities` for the arguments."""

    def __init__(self, lens: Lens, film: Film | None, frequencies, wavelengths=None):
        if not lens.is_rotationally_symmetric:
            raise LensError(f"tolerances are computed for rotationally symmetric lenses: this one has {lens.asymmetry}")
        given = conditions(lens, film, (0.0,), wavelengths, math.inf)
        self.lens, self.wavelengths = lens, given.wavelengths
        self.weights = np.array(given.weights) / sum(given.weights)
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
        self.image_heights = self._image_heights(given.primary_wavelength)
        self.frequencies = np.asarray((10.0, 20.0, 30.0, 40.0, 60.0) if frequencies is None else frequencies, float)
        if not (self.frequencies.ndim == 1 and self.frequencies.size and np.isfinite(self.frequencies).all()
                and (self.frequencies > 0.0).all()):
            raise LensError("frequencies must be positive numbers of cycles / mm")
        u = np.minimum(1e-3 * given.wavelengths[given.primary] * fo.f_number * self.frequencies, 1.0)
        self.limits = 2.0 / math.pi * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
        self.ends, self.kinds = bodies(lens), surface_table(lens).kinds
        self.diffraction: np.ndarray | float = 0.0      # the design's contrast less that of its spots
        focus, _, contrast = self.judged(*_built(self, [], np.zeros((1, 0))))
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

        def part(first: int) -> None:
            pause(paused)
            here = slice(first, first + CHUNK)
            out = np.empty((len(tables[here]), len(self.wavelengths), len(self.origins), 4))
            trace_copies(self.kinds, posed[here], tables[here], self.film_z, self.origins, self.directions, out)
            judge_copies(out, self.fields, self.areas, self.weights, self.frequencies, self.limits, focus[here],
                         spots[here], contrast[here])

        with ThreadPoolExecutor(2) as pool:
            list(pool.map(part, range(0, count, CHUNK)))
        lit = np.isfinite(spots)[..., None, None]
        return focus, spots, np.where(lit, np.clip(contrast + self.diffraction, 0.0, 1.0), 0.0)


def _rays(lens: Lens, behind: float, half: float) -> tuple[float, tuple[np.ndarray, ...]]:
    """Image height (mm) up to `half` that light reaches; origins, directions (n, 3), areas and fields (n,).

    behind: last vertex → film, mm.
    """
    for part in range(ROUNDS * TRIES):
        height = half * TRIES ** -(part // TRIES) * (1.0 - part % TRIES / TRIES)
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
    """Parallel rays that pass the rims: rings of Gauss's rule on arms from the centroid of the beam to its edge.

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

    def origins(at: np.ndarray) -> np.ndarray:
        return np.column_stack([at, np.zeros(len(at))]) + direction * before

    def passes(at: np.ndarray) -> np.ndarray:
        return np.asarray(trace(lens, origins(at), direction, forward=True).fate == Fate.PASSED)

    for least in (1, 20):                               # the beam of a fisheye fills little of its front
        x, y = np.meshgrid(*(np.linspace(a, b, WIDE) for a, b in zip(low, high, strict=True)))
        at = np.stack([x.ravel(), y.ravel()], 1)
        at = at[passes(at)]
        if len(at) < least:
            return None
        pitch = (high - low) / (WIDE - 1)
        low, high = at.min(0) - 0.5 * pitch, at.max(0) + 0.5 * pitch
    turns = 2.0 * math.pi * (np.arange(ARMS) + 0.5) / ARMS
    arms, middle = np.stack([np.cos(turns), np.sin(turns)], 1) * (high - low), at.mean(0)
    inside, outside = np.zeros(ARMS), np.ones(ARMS)
    for _ in range(HALVINGS):
        between = 0.5 * (inside + outside)
        passed = passes(middle + between[:, None] * arms)
        inside, outside = np.where(passed, between, inside), np.where(passed, outside, between)
    nodes, parts = np.polynomial.legendre.leggauss(RINGS)               # in the square of the radius
    reach = np.sqrt(0.5 + 0.5 * nodes)[:, None] * inside
    areas = (parts[:, None] * inside**2).ravel()
    found = origins((middle + reach[..., None] * arms).reshape(-1, 2))
    return found, np.repeat(direction[None], len(found), 0), areas / areas.sum()


def _errors(lens: Lens, within: Tolerances) -> list[tuple[str, int, float]]:
    """Kind, surface and tolerance of every error; decentre and tilt of an element once for each axis."""
    found: list[tuple[str, int, float]] = []
    before = lens.front_index
    for i, surface in enumerate(lens.surfaces):
        if surface.glass.n_d != before and surface.curvature != 0.0:
            found.append(("radius", i, within.radius))
        before = surface.glass.n_d
    found += [("thickness", i, within.thickness) for i in range(len(lens.surfaces) - 1)]
    found += [("index", i, within.index) for i, s in enumerate(lens.surfaces[:-1]) if s.glass.n_d > 1.0]
    for kind, tolerance in (("decentre", within.decentre), ("tilt", within.tilt)):
        found += [(kind, first, tolerance) for first, _ in elements(lens) for _ in range(2)]
    return [error for error in found if error[2] > 0.0]


def _built(judge: Judge, errors: list[tuple[str, int, float]], drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tables of copies with errors (copies, errors), in their own units, and which surfaces are out of line."""
    tables = copies_of(judge.lens, judge.wavelengths, len(drawn))
    poses = np.zeros((len(drawn), len(judge.ends), POSE))
    body = {int(first): k for k, (first, _) in enumerate(judge.ends)}
    change: dict[str, Callable[[np.ndarray, int, np.ndarray], None]] = {
        "radius": change_radius, "thickness": change_gap, "index": change_index}
    seen: set[tuple[str, int]] = set()
    for k, (kind, surface, _) in enumerate(errors):
        if kind in change:
            change[kind](tables, surface, drawn[:, k])
            continue
        axis = (DX, AROUND_Y) if (kind, surface) in seen else (DY, AROUND_X)       # in the plane of the fields first
        seen.add((kind, surface))
        poses[:, body[surface], axis[kind == "tilt"]] = drawn[:, k]
    return tables, set_poses(tables, judge.ends, poses)


def sensitivities(lens: Lens, film: Film | None = None, tolerances: Tolerances | None = None,
                  frequencies=None, wavelengths=None) -> tuple[Sensitivity, ...]:
    """What each error of a lens costs by itself, the costliest first.

    Parameters
    ----------
    lens : Lens
        Rotationally symmetric, stopped down as it is used; decentres and tilts lie in the plane of the fields.
    film : Film or None
        Its half-diagonal is the largest image height, or less where no light reaches it; None: `lens.film_size`, else
        36 × 24 mm.
    tolerances : Tolerances or None
        The errors; None: the defaults of the class.
    frequencies : (n,) array_like or None
        Cycles / mm; the middle one counts. None: 10 to 60.
    wavelengths : None, str or sequence
        As for `conditions`.

    Returns
    -------
    tuple of Sensitivity

    Raises
    ------
    LensError
        For a lens with a cylinder or toroid, or one that hardly a ray passes.
    """
    judge = Judge(lens, film, frequencies, wavelengths)
    every = _errors(lens, tolerances or Tolerances())
    errors = [e for k, e in enumerate(every) if e not in every[:k]]        # one axis of each decentre and tilt
    drawn = np.zeros((2 * len(errors) + 1, len(errors)))
    for k, (_, _, tolerance) in enumerate(errors):
        drawn[2 * k + 1, k], drawn[2 * k + 2, k] = tolerance, -tolerance
    _, spots, contrast = judge.judged(*_built(judge, errors, drawn))
    middle = len(judge.frequencies) // 2
    size, seen = spots.mean(1), contrast[:, :, middle].mean((1, 2))
    found = []
    for k, (kind, surface, tolerance) in enumerate(errors):
        worse = max((2 * k + 1, 2 * k + 2), key=lambda row: (math.isnan(size[row]), size[row]))
        found.append(Sensitivity(kind, surface, tolerance, float(size[worse] - size[0]),
                                 float(seen[worse] - seen[0])))
    return tuple(sorted(found, key=lambda each: -each.spot if each.spot == each.spot else -math.inf))


def production(lens: Lens, film: Film | None = None, tolerances: Tolerances | None = None, copies: int = 1000,
               seed: int = 0, frequencies=None, wavelengths=None) -> Production:
    """Copies of a lens with errors drawn at random, each refocused.

    Parameters
    ----------
    lens, film, tolerances, frequencies, wavelengths
        As for `sensitivities`; decentres and tilts lie in both planes.
    copies : int
        Number of copies, 1 to 100,000.
    seed : int
        Of the random numbers: the same seed draws the same copies.

    Returns
    -------
    Production

    Raises
    ------
    LensError
        As `sensitivities`, and for another number of copies.
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
    design, spots, contrast = judge.judged(*_built(judge, errors, np.zeros((1, len(errors)))))
    focus, made, seen = judge.judged(*_built(judge, errors, drawn))
    return Production(judge.image_heights, judge.frequencies, contrast[0], seen, spots[0],
                      made, judge.film_z + float(design[0]), judge.film_z + focus, drawn,
                      tuple((kind, surface) for kind, surface, _ in errors))


LINES = 25              # wavelengths at which a changed glass is listed


def manufactured(lens: Lens, run: Production, copy: int) -> Lens:
    """A copy of a production run, with its errors of radius, thickness, index, decentre and tilt.

    Parameters
    ----------
    lens : Lens
        That of the run.
    run : Production
        As `production` gives it.
    copy : int
        Number of the copy, from 0.

    Returns
    -------
    Lens
        Focused as a whole: at the positions of its groups that `lens` has. A changed glass is a table of 25 indices,
        within 1e-6 of the exact ones.

    Raises
    ------
    LensError
        For a copy that the run does not have, or a run of another lens.
    """
    if not 0 <= copy < len(run.drawn):
        raise LensError(f"copy {copy}: this run has the copies 0 to {len(run.drawn) - 1}")
    if any(surface >= len(lens.surfaces) for _, surface in run.names):
        raise LensError("the production run belongs to another lens, with more surfaces")
    surfaces, last = list(lens.surfaces), dict(elements(lens))
    poses: dict[int, dict[str, list[float]]] = {}
    for (kind, i), error in zip(run.names, run.drawn[copy].tolist(), strict=True):
        here = surfaces[i]
        if kind == "radius":
            surfaces[i] = replace(here, curvature=here.curvature / (1.0 + error))
        elif kind == "thickness":
            surfaces[i] = replace(here, thickness=here.thickness + error)
        elif kind == "index":
            surfaces[i] = replace(here, glass=_changed(here.glass, error))
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
