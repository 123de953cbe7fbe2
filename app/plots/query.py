"""What an analysis of the window is about: the lens of the settings, its object, and fields and wavelengths of a user.

The fields run from the film's centre to its corner. The object lies at the focus distance. A query is a hashable
value: equal queries have equal figures.

Figures mark what each surface ends while it is under the mouse: rays that meet the stop within its clear aperture and
that another surface ends are its victims. A layer of a figure that has a `surface` is drawn only then.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import POSITIONS, Bench, bench_of, is_in_colour, published
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.plots.plot import Curve, Figure, Label, Plot, Points
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import (
    FIELDS, Conditions, conditions, wanted_chief_rays, white_light
)
from lensbench.core.analysis.grids.traced_grid import RayGrid, ray_grid
from lensbench.core.imaging.spectrum import WHITES
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.system import FieldKind
from lensbench.core.text import fixed, significant
from lensbench.lenses.tables.paraxial import is_d_line

EDGE = 0.98                     # of the radius of light: the last field is not quite dark
CLOSER = 100                    # steps in which a height with a chief ray is sought
CENTRE = 1e-7                   # of the largest height: a field that counts as the film's centre, but has a direction
OWN = "own"
NO_LENS = "This camera has no lens to analyse. Choose one with a lens in the left column"


@dataclass(frozen=True)
class Query:
    """A lens in front of its film, and the distance from its first vertex to the object (mm, inf).

    bench: with the lens at the primary wavelength of its design alone. lens: the same, focused and stopped down, with
    the dispersion of its glasses; where a glass is not known at the d line, that of `bench`, and `alone` says so.
    model: name of the ideal model of the picture, or "". posed: whether its film is tilted, shifted or curved.
    heights: of the film, or points (x, y) of it (mm), for figures of a few fields; () leaves them the choice.
    wavelengths: µm and weights, the middle one primary; () are those of the lens. white: the name of these weights, one
    of WHITES; OWN for a user's wavelengths, "" for figures of single ones.
    """

    bench: Bench
    lens: lb.Lens
    object_distance: float
    focus_distance: float
    model: str = ""
    posed: bool = False
    alone: str = ""
    heights: tuple[float, ...] | tuple[tuple[float, float], ...] = ()
    wavelengths: tuple[tuple[float, float], ...] = ()
    white: str = "lens"

    @property
    def lines(self) -> "Query":
        """For figures of single wavelengths: those of the lens, else F, d and C, instead of white light."""
        return self if self.white == OWN else replace(self, wavelengths=(), white="")

    @property
    def largest_height(self) -> float:
        """The last field (mm), as `largest_height`."""
        return largest_height(self.bench)

    def conditions(self, fields: int = FIELDS) -> Conditions:
        """So many fields from the film's centre to the largest height; wavelengths of the query."""
        return _conditions(self, self.parts(*np.linspace(0.0, 1.0, fields).tolist()))

    def parts(self, *shares: float) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
        """Image heights (mm) at these parts of the largest; of a lens without rotational symmetry points (x, y).

        The latter lie on the way to the lower left corner of the picture, also the first, whose sagittal and tangential
        directions are those of the others.
        """
        largest = self.largest_height
        if self.lens.is_rotationally_symmetric:
            return tuple(share * largest for share in shares)
        film = self.bench.film
        x, y = (largest * side / film.diagonal for side in (film.width, film.height))
        return tuple((max(share, CENTRE) * x, max(share, CENTRE) * y) for share in shares)

    def few(self, *shares: float) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
        """The chosen `heights`; without any, those at these parts of the largest."""
        return self.heights or self.parts(*shares)

    def grid(self, points: int, heights: tuple[float, ...] | tuple[tuple[float, float], ...] | None = None) -> RayGrid:
        """Rays with `points` across the pupil, of the fields that all analyses share, or of those at these heights.

        heights: of the film, or points (x, y) of it, mm. LensError where there are no rays.
        """
        fields = self.conditions() if heights is None else _conditions(self, heights)
        return ray_grid(self.lens, self.bench.film_distance, fields, points)

    @property
    def primary_alone(self) -> str:
        """The primary wavelength, of a figure that takes no other, in words."""
        return f"{fixed(1000.0 * self.conditions().primary_wavelength, 0)} nm alone"

    def words(self, rays: RayGrid | None = None, *more: str) -> str:
        """The conditions in one line. more: what the analysis adds, such as its reference."""
        used = self.conditions() if rays is None else rays.conditions
        lines = ", ".join(fixed(1000.0 * line, 0) for line in used.wavelengths)
        through = "" if self.bench.port.index == 1.0 else " as seen through the window"
        weighted = ""
        if len(used.wavelengths) > 1 and self.white in WHITES:
            name = "fdc" if self.white == "lens" and not self.lens.system.wavelengths else self.white
            weighted = f", weighted {WHITES[name]}"
        film = f"focused {POSITIONS[self.bench.focusing.method]}"
        words = [f"object {format_distance(self.focus_distance)}{through}", f"{lines} nm{weighted}", film]
        words += [word for word in more if word != f"{lines} nm alone"]
        if rays is not None:
            words.append(f"{rays.opd.shape[-1]} × {rays.opd.shape[-1]} rays")
        return " · ".join(words)

    @property
    def open_stop(self) -> tuple[str, ...]:
        """What a figure leaves out that takes the stop as its circle."""
        return () if self.lens.stop_image is None else ("the picture in the stop is left out: the stop counts as its "
                                                        "circle",)

    def remarks(self, rays: RayGrid, findings: Iterable[Finding] = ()) -> tuple[str, ...]:
        """What the rays leave out, what the picture does otherwise, and what was found in a figure of these rays."""
        said = [str(finding.message) for finding in rays.findings if finding.kind is not Kind.ASSUMED]
        lost, launched = int(rays.lost.sum()), int(rays.launched.sum())
        if lost:
            said.append(f"{lost} of {launched} rays through the stop are vignetted "
                        f"({significant(100.0 * lost / launched, 2)} %)")
        corner = 0.5 * self.bench.film.diagonal
        if self.largest_height < corner and not self.heights:
            where = f"{significant(self.largest_height, 3)} mm from the centre: the film's corner, at " \
                    f"{significant(corner, 3)} mm,"
            said.append(f"the fields end at the edge of light, {where} is dark" if lit_radius(self.bench) < corner else
                        f"the fields end {where} has light next to the middle of the stop alone")
        if not (self.lens.is_rotationally_symmetric or self.heights):
            said.append("the fields run to the lower left corner of the picture: in other directions a lens with "
                        f"{self.lens.asymmetry} draws otherwise")
        if self.model:
            said.append(f"numbers of the traced lens; the picture uses the model “{self.model}”")
        if self.posed:
            said.append("numbers for a flat, centred film; the film of the picture is tilted, shifted or curved")
        if self.bench.reason:
            said.append(self.bench.reason)
        return (*said, *(finding.message for finding in findings))


def largest_height(built: Bench) -> float:
    """Half the film's diagonal (mm), or just within the edge of light of a smaller image circle.

    A field has a ray through the middle of the stop, which the last sliver of light before the edge may not have.
    """
    corner, lit = 0.5 * built.film.diagonal, lit_radius(built)
    height = corner if lit >= corner or lit <= 0.0 else EDGE * lit
    return _with_chief_ray(built.lens, built.film_distance, height) if built.lens.is_rotationally_symmetric else height


@lru_cache(maxsize=64)
def _with_chief_ray(lens: lb.Lens, film_distance: float, height: float) -> float:
    """The height (mm) itself, or the greatest below it at which a ray through the middle of the stop meets the film."""
    def known(heights: np.ndarray) -> np.ndarray:
        rays = find_chief_rays(lens, film_distance, np.column_stack([0.0 * heights, heights]), by_image=True)
        return np.asarray(np.isfinite(rays.images).all(1))

    if known(np.array([height]))[0]:
        return height
    below = height * np.linspace(1.0, 0.0, CLOSER, endpoint=False)[1:]
    reached = known(below)
    return float(below[np.argmax(reached)]) if reached.any() else height


def query(settings: Settings) -> Query:
    """The query of these settings; ValueError or OSError, with the reason, where there is nothing to analyse."""
    if not settings.has_lens:
        raise ValueError(NO_LENS)
    built = bench_of(settings)
    distance = built.focus_distance - built.film_z if math.isfinite(built.focus_distance) else math.inf
    if not distance > 0.0:
        raise ValueError("The plane in focus lies within the lens: there is no object to analyse. Focus farther away")
    model = LENS_MODELS[settings.lens_model]
    lens, alone = _with_dispersion(published(settings), built.lens)
    white = "lens" if alone else settings.white
    wavelengths = () if alone else white_light(lens, white)
    if white == "picture" and wavelengths and not is_in_colour(settings, lens):
        wavelengths = ((lens.reference_wavelength, 1.0),)
    return Query(built, lens, distance, built.focus_distance, "" if model.follows_lens else model.title,
                 not settings.film_pose.is_upright, alone, wavelengths=wavelengths, white=white)


def _with_dispersion(lens: lb.Lens, built: lb.Lens) -> tuple[lb.Lens, str]:
    """The lens `built` of a bench with the glasses of `lens`; `built` itself, and why, where one is not known."""
    wavelength = lens.reference_wavelength
    if is_d_line(wavelength):
        return built, ""
    try:
        lens.indices()
    except lb.GlassError as error:
        return built, f"figures at {significant(1000.0 * wavelength)} nm alone: {error}"
    return _with_glasses(lens, built), ""


@lru_cache(maxsize=16)
def _with_glasses(lens: lb.Lens, built: lb.Lens) -> lb.Lens:
    return replace(built, surfaces=tuple(replace(there, glass=surface.glass) for there, surface in zip(
        built.surfaces, lens.surfaces, strict=True)))


@lru_cache(maxsize=64)
def _conditions(query: Query, fields: tuple[float, ...] | tuple[tuple[float, float], ...]) -> Conditions:
    made = conditions(query.lens, query.bench.film, fields, query.wavelengths or None, query.object_distance)
    if query.alone:
        others = tuple(finding for finding in made.findings if finding.kind is not Kind.GLASS)
        made = replace(made, findings=(*others, note(Kind.GLASS, query.alone)))
    if query.white == OWN or len({query.lens.indices(line) for line in made.wavelengths}) > 1:
        return made
    # Without dispersion all wavelengths have the same rays: one is enough
    return replace(made, wavelengths=(made.primary_wavelength,), weights=(1.0,), primary=0)


UNITS = {"deg": "°", "°": "°", "mm": "mm"}      # of fields; without one they are parts of the largest
DESIGN = "design"                       # the fields that the lens file states
MOST_FIELDS, MOST_COLOURS = 8, 12
NANOMETRES = 100.0                      # a smaller number is one of micrometres
STEEPEST = 90.0                         # degrees, of a field of an object plane at a finite distance


class OwnFields(NamedTuple):
    """Field points in the unit "°", "mm" (image heights) or "" (parts of the largest); none: those of the design."""

    values: tuple[float, ...] = ()
    unit: str = ""


def read_fields(text: str) -> OwnFields:
    """From "0,0.7,1", "0,14,20deg", "0,10,21.6mm" or "design"; ValueError with the reason."""
    if text.strip().lower() == DESIGN:
        return OwnFields()
    words, unit = [word.strip() for word in text.split(",")], ""
    named = {UNITS[name] for word in words for name in UNITS if word.endswith(name)}
    if len(named) > 1:
        raise ValueError(f"{text!r}: give all fields in one unit")
    if named:
        unit = named.pop()
        words = [word.removesuffix("deg").removesuffix("°").removesuffix("mm").strip() for word in words]
    values = _numbers(text, words)
    if not 1 <= len(values) <= MOST_FIELDS or min(values) < 0.0 or not unit and max(values) > 1.0:
        raise ValueError(f"{text!r}: give 1 to {MOST_FIELDS} fields from 0: parts of the largest up to 1, such as "
                         "0,0.7,1, angles such as 0,14,20deg, image heights such as 0,10,21.6mm, or the word design")
    return OwnFields(values, unit)


def read_wavelengths(text: str) -> tuple[tuple[float, float], ...]:
    """Wavelengths (µm) and weights, from nanometres such as "486.1,587.6:2,656.3"; ValueError with the reason."""
    pairs = [word.partition(":") for word in text.split(",")]
    lines = _numbers(text, [line for line, _, _ in pairs])
    weights = _numbers(text, [weight if colon else "1" for _, colon, weight in pairs])
    if len(lines) > MOST_COLOURS:
        raise ValueError(f"{len(lines)} wavelengths: give 1 to {MOST_COLOURS}")
    if min(lines) <= 0.0 or min(weights) < 0.0 or not max(weights) > 0.0:
        raise ValueError(f"{text!r}: wavelengths must be positive, weights must not be negative, and one positive")
    if min(lines) < NANOMETRES:
        raise ValueError(f"{text!r}: give wavelengths in nanometres, such as 587.6")
    if len(set(lines)) < len(lines):
        raise ValueError(f"{text!r}: a wavelength is given twice")
    return tuple((round(line / 1000.0, 9), weight) for line, weight in zip(lines, weights, strict=True))


def with_own(query: Query, fields: OwnFields | None, wavelengths: tuple[tuple[float, float], ...] | None) -> Query:
    """The query with these fields and wavelengths (µm, weight); None keeps those of the query.

    LensError where the lens has no such field, and where its glasses are not known at such wavelengths.
    """
    if wavelengths is not None:
        if query.alone:
            raise lb.LensError(query.alone)
        query = replace(query, wavelengths=wavelengths, white=OWN)
    return query if fields is None else replace(query, heights=_heights(query, fields))


def _heights(query: Query, fields: OwnFields) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
    """Image heights, or points (x, y) of the film (mm)."""
    if fields.values and not fields.unit:
        return query.parts(*fields.values)
    if fields.unit == "mm":
        return fields.values
    system, used = query.lens.system, query.conditions()
    if fields.values:
        kind, points = FieldKind.ANGLE, tuple((0.0, field) for field in fields.values)
        if math.isfinite(query.object_distance) and max(fields.values) >= STEEPEST:
            raise lb.LensError(f"a field of {significant(max(fields.values))}° lies outside every object plane: it "
                               "needs --focus inf")
    elif system.fields:
        kind, points = system.field_kind, tuple((field.x, field.y) for field in system.fields)
    else:
        raise lb.LensError("the file of this lens states no fields")
    asked = Conditions(kind, points, used.wavelengths, used.weights, used.primary, query.object_distance)
    aims, by_image = wanted_chief_rays(query.lens, asked)
    images = find_chief_rays(query.lens, query.bench.film_distance, aims, query.object_distance, by_image,
                             used.primary_wavelength).images
    for (x, y), image in zip(points, images, strict=True):
        if not np.isfinite(image).all():
            unit = "°" if kind is FieldKind.ANGLE else " mm"
            raise lb.LensError(f"field {significant(math.hypot(x, y), 4)}{unit}: no ray through the middle of the stop "
                               "reaches the film from there")
    if any(x for x, _ in points):
        return tuple((float(x), float(y)) for x, y in images)
    return tuple(float(math.hypot(x, y)) for x, y in images)


def _numbers(text: str, words: list[str]) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        raise ValueError(f"{text!r}: give numbers, separated by commas") from None
    if not all(map(math.isfinite, values)):
        raise ValueError(f"{text!r}: give finite numbers")
    return values


# What each surface ends

HEIGHT = "Image height (mm)"    # the axis over which a surface has a line
POINTS = 16                     # across the pupil, of the rays whose ends are counted
WEIGHT = 5.0                    # of the line along the fields that a surface vignettes, pixels


def victims(rays: RayGrid) -> dict[int, np.ndarray]:
    """The surfaces that end rays within the stop, and (F,) the part of the rays of each field that they end."""
    c = rays.conditions.primary
    within, ends = rays.stop_share[:, c] <= 1.0, rays.victim[:, c]
    launched = np.maximum(within.sum((1, 2)), 1)
    surfaces = np.unique(ends[within & (ends >= 0)]).tolist()
    return {int(surface): (within & (ends == surface)).sum((1, 2)) / launched for surface in surfaces}


def with_rims(query: Query, figure: Figure) -> Figure:
    """The figure with a line for each surface, in plots over the image height: along the fields whose rays it ends."""
    try:
        rays = query.lines.grid(POINTS)
    except LensError:               # no light
        return figure
    heights, ended = rays.image_heights, victims(rays)
    ends = np.concatenate([heights[:1], 0.5 * (heights[1:] + heights[:-1]), heights[-1:]])

    def marked(plot: Plot) -> Plot:
        if HEIGHT not in (plot.x.label, plot.y.label):
            return plot
        lines = []
        for surface, shares in ended.items():
            cut = np.flatnonzero(shares > 0.0)
            along = np.stack([ends[cut], ends[cut + 1], np.full(cut.size, np.nan)], 1).ravel()
            across = np.full(along.size, plot.y.low if plot.x.label == HEIGHT else plot.x.low)
            x, y = (along, across) if plot.x.label == HEIGHT else (across, along)
            lines.append(Curve("", x, y, "dead", weight=WEIGHT, surface=surface))
        return replace(plot, layers=(*plot.layers, *lines))

    return replace(figure, rows=tuple(tuple(marked(plot) for plot in row) for row in figure.rows))


def with_shares(rays: RayGrid, plot: Plot) -> Plot:
    """The plot of a few fields with the part of their rays that a surface ends, in words at its lower left."""
    labels = []
    for surface, shares in victims(rays).items():
        percents = " · ".join(fixed(100.0 * share, 0) for share in shares)
        which = "the rays" if len(shares) == 1 else "the rays of each field"
        labels.append(Label(plot.x.low, plot.y.low, f"surface {surface} ends {percents} % of {which}", "dead",
                            "right above", surface))
    return replace(plot, layers=(*plot.layers, *labels))


def ends_within_stop(rays: RayGrid, f: int, c: int) -> np.ndarray:
    """(N, N) the surface that ends each ray of a field and wavelength; −1 where none does, or the stop would anyway."""
    ends = rays.victim[f, c]
    return np.where((rays.stop_share[f, c] <= 1.0) | (ends == rays.lens.stop_index), ends, -1)


def ended_marks(x: np.ndarray, y: np.ndarray, ends: np.ndarray) -> list[Points]:
    """Marks at x and y of rays that surfaces `ends` end, all of one shape; a layer for each surface, none for −1."""
    known = np.isfinite(x) & np.isfinite(y) & (ends >= 0)
    return [Points("", x[known & (ends == surface)], y[known & (ends == surface)], "dead", "diamond",
                   surface=int(surface)) for surface in np.unique(ends[known])]
