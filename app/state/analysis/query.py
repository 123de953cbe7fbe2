"""What an analysis of the window is about: the lens of the settings, focused and stopped down, and its object.

The fields run from the film's centre to its corner. The object lies at the focus distance. A query is a hashable
value: equal queries have equal figures.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.analysis.grids.chief_rays import find_chief_rays
from lensbench.analysis.grids.field_conditions import FIELDS, Conditions, conditions, white_light
from lensbench.analysis.grids.grid_trace import ray_grid
from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.app.state.build import Setup, is_in_colour, published, setup
from lensbench.app.state.camera_facts import LENS_MODELS
from lensbench.app.state.geometry.ray_fans import lit_radius
from lensbench.app.state.settings import Settings
from lensbench.app.state.text_values import format_distance
from lensbench.imaging.spectrum import WHITES
from lensbench.kernels.figures import fixed, significant
from lensbench.lenses.paraxial import is_d_line
from lensbench.optics.finding import Finding, Kind, note

EDGE = 0.98                     # of the radius of light: the last field is not quite dark
CLOSER = 100                    # steps in which a height with a chief ray is sought
CENTRE = 1e-7                   # of the largest height: a field that counts as the film's centre, but has a direction
OWN = "own"
NO_LENS = "This camera has no lens to analyse. Choose one with a lens in the left column"


@dataclass(frozen=True)
class Query:
    """A lens in front of its film, and the distance from its first vertex to the object (mm, inf).

    setup: with the lens at the primary wavelength of its design alone. lens: the same, focused and stopped down, with
    the dispersion of its glasses; where a glass is not known at the d line, that of `setup`, and `alone` says so.
    model: name of the ideal model that the picture is taken with, or "". posed: whether its film is out of line.
    heights: of the film, or points (x, y) of it (mm), for figures of a few fields; () leaves them the choice.
    wavelengths: µm and weights, the middle one primary; () are those of the lens. white: the name of these weights, one
    of WHITES; OWN for a user's wavelengths, "" for figures of single ones.
    """

    setup: Setup
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
        """For figures of single wavelengths: those of the lens, else F, d and C, in place of white light."""
        return self if self.white == OWN else replace(self, wavelengths=(), white="")

    @property
    def largest_height(self) -> float:
        """The last field (mm), as `largest_height`."""
        return largest_height(self.setup)

    def conditions(self, fields: int = FIELDS) -> Conditions:
        """So many fields from the film's centre to the largest height; wavelengths of the query."""
        return _conditions(self, self.parts(*np.linspace(0.0, 1.0, fields).tolist()))

    def parts(self, *parts: float) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
        """Image heights (mm) at these parts of the largest; of a lens without rotational symmetry points (x, y).

        The latter lie on the way to the lower left corner of the picture, also the first, whose sagittal and tangential
        directions are those of the others.
        """
        largest = self.largest_height
        if self.lens.is_rotationally_symmetric:
            return tuple(part * largest for part in parts)
        film = self.setup.film
        x, y = (largest * side / film.diagonal for side in (film.width, film.height))
        return tuple((max(part, CENTRE) * x, max(part, CENTRE) * y) for part in parts)

    def few(self, *parts: float) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
        """The chosen `heights`; without any, those at these parts of the largest."""
        return self.heights or self.parts(*parts)

    def grid(self, points: int, heights: tuple[float, ...] | tuple[tuple[float, float], ...] | None = None) -> RayGrid:
        """Rays with `points` across the pupil, of the fields that all analyses share, or of those at these heights.

        heights: of the film, or points (x, y) of it, mm. LensError where there are no rays.
        """
        given = self.conditions() if heights is None else _conditions(self, heights)
        return ray_grid(self.lens, self.setup.film_distance, given, points)

    @property
    def primary_alone(self) -> str:
        """The primary wavelength, of a figure that takes no other, in words."""
        return f"{fixed(1000.0 * self.conditions().primary_wavelength, 0)} nm alone"

    def words(self, rays: RayGrid | None = None, *more: str) -> str:
        """The conditions in one line. more: what the analysis adds, such as its reference."""
        given = self.conditions() if rays is None else rays.conditions
        lines = ", ".join(fixed(1000.0 * line, 0) for line in given.wavelengths)
        seen = "" if self.setup.port.index == 1.0 else " as seen through the window"
        weighted = ""
        if len(given.wavelengths) > 1 and self.white in WHITES:
            name = "fdc" if self.white == "lens" and not self.lens.system.wavelengths else self.white
            weighted = f", weighted {WHITES[name]}"
        film = "film by the least blur" if self.setup.focusing.method == "real" else "film at the paraxial focus"
        parts = [f"object {format_distance(self.focus_distance)}{seen}", f"{lines} nm{weighted}", film]
        parts += [each for each in more if each != f"{lines} nm alone"]
        if rays is not None:
            parts.append(f"{rays.opd.shape[-1]} × {rays.opd.shape[-1]} rays")
        return " · ".join(parts)

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
            said.append(f"{lost} of {launched} rays through the stop are lost at other rims "
                        f"({significant(100.0 * lost / launched, 2)} %)")
        corner = 0.5 * self.setup.film.diagonal
        if self.largest_height < corner and not self.heights:
            where = f"{significant(self.largest_height, 3)} mm from the centre: the film's corner, at " \
                    f"{significant(corner, 3)} mm,"
            said.append(f"the fields end at the edge of light, {where} is dark" if lit_radius(self.setup) < corner else
                        f"the fields end {where} has light beside the middle of the stop alone")
        if not (self.lens.is_rotationally_symmetric or self.heights):
            said.append("the fields run to the lower left corner of the picture: in other directions a lens with "
                        f"{self.lens.asymmetry} draws otherwise")
        if self.model:
            said.append(f"figures of the traced lens; the picture is taken with the model “{self.model}”")
        if self.posed:
            said.append("figures of a flat film in line; the film of the picture is tilted, shifted or curved")
        if self.setup.reason:
            said.append(self.setup.reason)
        return (*said, *(finding.message for finding in findings))


def largest_height(built: Setup) -> float:
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
    found = known(below)
    return float(below[np.argmax(found)]) if found.any() else height


def query(settings: Settings) -> Query:
    """The query of these settings; ValueError or OSError, with the reason, where there is nothing to analyse."""
    if not settings.has_lens:
        raise ValueError(NO_LENS)
    built = setup(settings)
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
    """The lens `built` of a setup with the glasses of `lens`; `built` itself, and why, where one is not known."""
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
    given = conditions(query.lens, query.setup.film, fields, query.wavelengths or None, query.object_distance)
    if query.alone:
        others = tuple(finding for finding in given.findings if finding.kind is not Kind.GLASS)
        given = replace(given, findings=(*others, note(Kind.GLASS, query.alone)))
    if query.white == OWN or len({query.lens.indices(line) for line in given.wavelengths}) > 1:
        return given
    # Without dispersion all wavelengths have the same rays: one is enough
    return replace(given, wavelengths=(given.primary_wavelength,), weights=(1.0,), primary=0)
