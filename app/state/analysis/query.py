"""What an analysis of the window is about: the lens of the settings, focused and stopped down, and its object.

The fields run from the film's centre to its corner. The object lies at the focus distance. A query is a hashable
value: equal queries have equal figures.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.analysis.field_conditions import FIELDS, Conditions, conditions
from lensbench.analysis.grid_trace import ray_grid
from lensbench.analysis.traced_grid import RayGrid
from lensbench.app.state.build import Setup, setup
from lensbench.app.state.camera_kinds import LENS_MODELS
from lensbench.app.state.geometry.ray_fans import lit_radius
from lensbench.app.state.settings import Settings
from lensbench.app.state.text_values import format_distance
from lensbench.kernels.figures import fixed, significant
from lensbench.optics.finding import Kind

EDGE = 0.98                     # of the radius of light: the last field is not quite dark
NO_LENS = "This camera has no lens to analyse. Choose one with a lens in the left column"


@dataclass(frozen=True)
class Query:
    """A lens in front of its film, and the distance from its first vertex to the object (mm, inf).

    model: name of the ideal model that the picture is taken with, or "". posed: whether its film is out of line.
    """

    setup: Setup
    object_distance: float
    focus_distance: float
    model: str = ""
    posed: bool = False

    @property
    def lens(self) -> lb.Lens:
        """The lens, focused and stopped down."""
        return self.setup.lens

    @property
    def largest_height(self) -> float:
        """The last field (mm): the film's corner, or just within the edge of light of a smaller image circle."""
        corner = 0.5 * self.setup.film.diagonal
        lit = lit_radius(self.setup)
        return corner if lit >= corner or lit <= 0.0 else EDGE * lit

    def conditions(self, fields: int = FIELDS) -> Conditions:
        """So many fields from the film's centre to the largest height; wavelengths of the lens."""
        return _conditions(self.setup, self.object_distance, self.parts(*np.linspace(0.0, 1.0, fields).tolist()))

    def parts(self, *parts: float) -> tuple[float, ...]:
        """Image heights (mm) at these parts of the largest."""
        return tuple(part * self.largest_height for part in parts)

    def grid(self, points: int, heights: tuple[float, ...] | tuple[tuple[float, float], ...] | None = None) -> RayGrid:
        """Rays with `points` across the pupil, of the fields that all analyses share, or of those at these heights.

        heights: of the film, or points (x, y) of it, mm. LensError where there are no rays.
        """
        given = self.conditions() if heights is None else _conditions(self.setup, self.object_distance, heights)
        return ray_grid(self.lens, self.setup.film_distance, given, points)

    def words(self, rays: RayGrid | None = None, *more: str) -> str:
        """The conditions in one line. more: what the analysis adds, such as its reference."""
        given = self.conditions() if rays is None else rays.conditions
        lines = ", ".join(fixed(1000.0 * line, 0) for line in given.wavelengths)
        parts = [f"object {format_distance(self.focus_distance)}", f"{lines} nm", *more]
        if rays is not None:
            parts.append(f"{rays.opd.shape[-1]} × {rays.opd.shape[-1]} rays")
        return " · ".join(parts)

    def remarks(self, rays: RayGrid) -> tuple[str, ...]:
        """What the rays leave out, and what the picture does otherwise."""
        said = [str(finding.message) for finding in rays.findings if finding.kind is not Kind.ASSUMED]
        lost, launched = int(rays.lost.sum()), int(rays.launched.sum())
        if lost:
            said.append(f"{lost} of {launched} rays through the stop are lost at other rims "
                        f"({fixed(100.0 * lost / launched, 0)} %)")
        corner = 0.5 * self.setup.film.diagonal
        if self.largest_height < corner:
            said.append(f"the fields end at the edge of light, {significant(self.largest_height, 3)} mm from the "
                        f"centre: the film's corner, at {significant(corner, 3)} mm, is dark")
        if self.model:
            said.append(f"figures of the traced lens; the picture is taken with the model “{self.model}”")
        if self.posed:
            said.append("figures of a film in line; the film of the picture is tilted or shifted")
        if self.setup.reason:
            said.append(self.setup.reason)
        return tuple(said)


def query(settings: Settings) -> Query:
    """The query of these settings; ValueError or OSError, with the reason, where there is nothing to analyse."""
    if not settings.has_lens:
        raise ValueError(NO_LENS)
    built = setup(settings)
    distance = settings.focus_distance - built.film_z if math.isfinite(settings.focus_distance) else math.inf
    if not distance > 0.0:
        raise ValueError("The plane in focus lies within the lens: there is no object to analyse. Focus farther away")
    model = LENS_MODELS[settings.lens_model]
    return Query(built, distance, settings.focus_distance, "" if model.follows_lens else model.title,
                 not settings.film_pose.is_upright)


@lru_cache(maxsize=64)
def _conditions(built: Setup, object_distance: float,
                fields: tuple[float, ...] | tuple[tuple[float, float], ...]) -> Conditions:
    given = conditions(built.lens, built.film, fields=fields, object_distance=object_distance)
    if all(finding.kind is not Kind.GLASS for finding in given.findings):
        return given
    # Without dispersion all wavelengths have the same rays: one is enough
    return replace(given, wavelengths=(given.primary_wavelength,), weights=(1.0,), primary=0)
