"""A film or a lens out of line: what it brings into focus, and the place of each of its points.

Lengths in mm, camera frame unless said otherwise.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Setup, setup
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.scenes.file_cache import Stamp, file_stamp
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_angle, format_distance, format_length
from lensbench.core.imaging.film import UPRIGHT
from lensbench.core.text import true_minus

POINTS = 33                             # along a curved film in the section
LEAST_LEAN = math.radians(0.005)        # of the plane of sharp focus: less is 0.00°, by the rounding of traced beams
Place = tuple[float, float]


def seen_from(settings: Settings, raster: Place) -> tuple[Setup, Place]:
    """The lens in front of the film point of a raster point: with that point's own film distance, and its x, y."""
    film, built = settings.film, setup(settings)
    at = (0.5 - raster[0] / film.pixels_x) * film.width, (raster[1] / film.pixels_y - 0.5) * film.height
    if settings.film_pose.is_upright:
        return built, at
    x, y, z = settings.film_pose.points(np.array([at]))[0].tolist()
    return replace(built, film_distance=built.film_distance + z), (x, y)


def leans(settings: Settings) -> bool:
    """Whether the plane of sharp focus may lie askew to the axis: of a tilted film, or a lens out of line."""
    return settings.film_pose.is_tilted or lens_leans(settings)


def lens_leans(settings: Settings) -> bool:
    """Whether elements of the lens are decentred or tilted."""
    try:
        return settings.has_lens and not setup(settings).lens.is_in_line
    except (ValueError, OSError):
        return False


def sharp_focus(settings: Settings) -> "lb.analysis.SharpFocus | None":
    """The plane of sharp focus, its wedge and its lines; None where all is in line, or nothing is in focus."""
    if settings.film_pose.is_upright and not lens_leans(settings) or not settings.focuses:
        return None
    try:
        return _sharp(settings.optics, file_stamp(settings.lens))
    except (ValueError, OSError):
        return None


@lru_cache(maxsize=16)
def _sharp(settings: Settings, lens: Stamp) -> "lb.analysis.SharpFocus":
    made = camera(settings)
    assert isinstance(made, lb.LensCamera)
    if made.film_at is not None:            # placed for another wavelength than the d line, by which the plane is found
        made = made.refocused(setup(settings).focus_distance)
    return lb.analysis.sharp_focus(made, blur_limit(settings))


@dataclass(frozen=True)
class InSection:
    """What the section y–z shows of a film, or a lens, out of line. Lens frame (z, y), mm; (z, x) of the section x–z.

    film: points along it (n, 2). planes: by name, a point and a unit direction. points: by name, where a line crosses
    the section.
    """

    film: np.ndarray
    planes: dict[str, tuple[np.ndarray, np.ndarray]]
    points: dict[str, np.ndarray]


def in_section(settings: Settings, above: bool = False) -> InSection | None:
    """The film, the plane of sharp focus, its wedge, hinge and Scheimpflug line in the section; None in line.

    above: in the section x–z, and not in y–z.
    """
    if not settings.has_lens or settings.film_pose.is_upright and not lens_leans(settings):
        return None
    return _in_section(settings.optics, file_stamp(settings.lens), above)


@lru_cache(maxsize=16)
def _in_section(settings: Settings, lens: Stamp, above: bool) -> InSection:
    film_z, film, pose = setup(settings).film_z, settings.film, settings.film_pose
    up, aside = (0, 1) if above else (1, 0)
    side, turn = (film.width, pose.tilt) if above else (film.height, pose.swing)
    half = 0.5 * (side if turn == 0.0 else film.diagonal)
    along = np.linspace(-half, half, POINTS if pose.is_curved else 2)
    at = np.zeros((len(along), 2))
    at[:, up] = along
    with np.errstate(invalid="ignore"):
        shown = pose.points(at)
    found, planes, points = sharp_focus(settings), {}, {}
    if found is not None:
        for name, plane in (("sharp", found.plane), ("near", found.near), ("far", found.far)):
            if plane is not None:
                point, way = plane.crossing("xz" if above else "yz")
                if np.isfinite(point).all():
                    planes[name] = np.array([point[1] + film_z, point[0]]), np.array([way[1], way[0]])
        for name, line in (("Hinge line", found.hinge), ("Scheimpflug line", found.scheimpflug)):
            if line is not None and abs(line.direction[aside]) > 1e-9:
                crossed = line.point - line.point[aside] / line.direction[aside] * line.direction
                points[name] = np.array([crossed[2] + film_z, crossed[up]])
    return InSection(np.stack([shown[:, 2] + film_z, shown[:, up]], 1), planes, points)


def sentence(settings: Settings) -> str:
    """What the film brings into focus, in a sentence or two."""
    if settings.film_pose == UPRIGHT and not lens_leans(settings):
        return "The film is flat, centred and perpendicular to the axis of the lens"
    if settings.film_pose.is_curved:
        towards = "towards the lens" if settings.film_pose.radius < 0.0 else "away from the lens"
        curved = f"The sides of the film are curved {towards}"
        flat = replace(settings, film_radius=None)
        return curved if flat.film_pose.is_upright and not lens_leans(settings) else f"{curved}. {sentence(flat)}"
    try:
        found = sharp_focus(settings)
    except (ValueError, OSError) as error:
        return str(error)
    lean = 0.0 if found is None or found.plane is None else math.acos(min(abs(float(found.plane.normal[2])), 1.0))
    if found is None or found.hinge is None or found.plane is not None and lean < LEAST_LEAN:
        shifted = "The film is shifted: what" if settings.rise or settings.shift else "What"
        return f"{shifted} is in focus is a plane across the axis"
    if found.plane is None:
        return "The plane of sharp focus lies at infinity"
    across = abs(float(found.plane.normal[2])) > 1e-6
    away = -found.plane.offset / float(found.plane.normal[2]) if across else math.inf
    crosses = f"crosses the axis at {format_distance(away)}" if 0.0 < away < 1e8 else "does not cross the axis ahead"
    x, y = found.hinge.point[:2]
    sides = [f"{format_length(abs(v))} {word}" for v, word in (
        (x, "to the right" if x > 0.0 else "to the left"), (y, "above" if y > 0.0 else "below")) if abs(v) > 0.05]
    return true_minus(f"The plane of sharp focus is tilted by {format_angle(lean)} and {crosses}. It turns about the "
                      f"hinge line when the focus changes, {' and '.join(sides)} the lens")
