"""What is in focus: the plane of sharp focus of a tilted film or lens, and the focus that a click asks for.

Lengths in mm, camera frame unless said otherwise. Through a real lens whose film or whose elements are tilted or
decentred, a click is focused by traced beams of its film point: narrow ones where the film lies at the paraxial focus,
those of the open stop, at their least blur, where it lies there or as far from there as the best contrast.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Bench, bench_of
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.bench.water_window import port_index, port_of
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_angle, format_distance, format_length
from lensbench.core.analysis.focus_wedge import beams
from lensbench.core.imaging.film import UPRIGHT
from lensbench.core.text import true_minus

POINTS = 33                             # along a curved film in the section
LEAST_LEAN = math.radians(0.005)        # of the plane of sharp focus: less is 0.00°, by the rounding of traced beams
Place = tuple[float, float]
ENOUGH = 1e-7                   # of the nearness of what is pointed at
STEPS, LEAST_SLOPE = 30, 0.2    # of the secant rule, and of its secants
UNSHARP = 0.1                   # pixels of blur at an end of the focus, from which on a remark says so
BEYOND = "It lies beyond the farthest focus here"
TOO_NEAR = "It lies nearer than the nearest focus here"
UNLIT = "No light here: focused as at the middle"


def film_position(settings: Settings, raster: Place) -> tuple[float, float, float]:
    """The film point of a raster point, lens frame from the film's middle: upside down on the film."""
    film = settings.film
    x, y = (0.5 - raster[0] / film.pixels_x) * film.width, (raster[1] / film.pixels_y - 0.5) * film.height
    if settings.film_pose.is_upright:
        return x, y, 0.0
    x, y, z = settings.film_pose.points(np.array([(x, y)]))[0].tolist()
    return x, y, z


def seen_from(settings: Settings, raster: Place) -> tuple[Bench, Place]:
    """The lens in front of the film point of a raster point: with that point's own film distance, and its x, y."""
    built, (x, y, z) = bench_of(settings), film_position(settings, raster)
    return (replace(built, film_distance=built.film_distance + z) if z else built), (x, y)


def leans(settings: Settings) -> bool:
    """Whether the plane of sharp focus may be tilted: that of a tilted film, or a tilted or decentred lens."""
    return settings.film_pose.is_tilted or lens_leans(settings)


def lens_leans(settings: Settings) -> bool:
    """Whether elements of the lens are decentred or tilted."""
    try:
        return settings.has_lens and not bench_of(settings).lens.is_centred
    except (ValueError, OSError):
        return False


def sharp_focus(settings: Settings) -> "lb.analysis.SharpFocus | None":
    """The plane of sharp focus, its wedge and its lines; None where all is centred, or nothing is in focus."""
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
        made = made.refocused(bench_of(settings).focus_distance)
    return lb.analysis.sharp_focus(made, blur_limit(settings))


@dataclass(frozen=True)
class InSection:
    """What the section y–z shows of a tilted film or lens. Lens frame (z, y), mm; (z, x) of the section x–z.

    film: points along it (n, 2). planes: by name, a point and a unit direction. points: by name, where a line crosses
    the section.
    """

    film: np.ndarray
    planes: dict[str, tuple[np.ndarray, np.ndarray]]
    points: dict[str, np.ndarray]


def in_section(settings: Settings, above: bool = False) -> InSection | None:
    """What the section y–z shows, or x–z where `above`; None where film and lens are centred."""
    if not settings.has_lens or settings.film_pose.is_upright and not lens_leans(settings):
        return None
    return _in_section(settings.optics, file_stamp(settings.lens), above)


@lru_cache(maxsize=16)
def _in_section(settings: Settings, lens: Stamp, above: bool) -> InSection:
    film_z, film, pose = bench_of(settings).film_z, settings.film, settings.film_pose
    up, aside = (0, 1) if above else (1, 0)
    side, turn = (film.width, pose.tilt) if above else (film.height, pose.swing)
    half = 0.5 * (side if turn == 0.0 else film.diagonal)
    along = np.linspace(-half, half, POINTS if pose.is_curved else 2)
    film_points = np.zeros((len(along), 2))
    film_points[:, up] = along
    with np.errstate(invalid="ignore"):
        shown = pose.points(film_points)
    focus, planes, points = sharp_focus(settings), {}, {}
    if focus is not None:
        for name, plane in (("sharp", focus.plane), ("near", focus.near), ("far", focus.far)):
            if plane is not None:
                point, way = plane.crossing("xz" if above else "yz")
                if np.isfinite(point).all():
                    planes[name] = np.array([point[1] + film_z, point[0]]), np.array([way[1], way[0]])
        for name, line in (("Hinge line", focus.hinge), ("Scheimpflug line", focus.scheimpflug)):
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
        focus = sharp_focus(settings)
    except (ValueError, OSError) as error:
        return str(error)
    lean = 0.0 if focus is None or focus.plane is None else math.acos(min(abs(float(focus.plane.normal[2])), 1.0))
    if focus is None or focus.hinge is None or focus.plane is not None and lean < LEAST_LEAN:
        shifted = "The film is shifted: what" if settings.rise or settings.shift else "What"
        return f"{shifted} is in focus is a plane across the axis"
    if focus.plane is None:
        return "The plane of sharp focus lies at infinity"
    across = abs(float(focus.plane.normal[2])) > 1e-6
    away = -focus.plane.offset / float(focus.plane.normal[2]) if across else math.inf
    crosses = f"crosses the axis at {format_distance(away)}" if 0.0 < away < 1e8 else "does not cross the axis ahead"
    x, y = focus.hinge.point[:2]
    sides = [f"{format_length(abs(v))} {word}" for v, word in (
        (x, "to the right" if x > 0.0 else "to the left"), (y, "above" if y > 0.0 else "below")) if abs(v) > 0.05]
    return true_minus(f"The plane of sharp focus is tilted by {format_angle(lean)} and {crosses}. It turns about the "
                      f"hinge line when the focus changes, {' and '.join(sides)} the lens")


# A click


class ClickFocus(NamedTuple):
    """distance: of the focus (mm), inf allowed. remark: why that does not make the point sharp; "" where it does."""

    distance: float
    remark: str = ""


def focused_at(settings: Settings, share: Place, depth: float) -> ClickFocus:
    """The focus at which what lies `depth` mm before the film is sharp at a part of the picture.

    share: of its width and height, from the top left. Beyond a window into water, depth and focus are true distances.
    """
    if port_index(settings) != 1.0:                     # off the axis, water shows things nearer still than on it
        port, efl = (bench_of(settings).port, bench_of(settings).first_order.efl) if settings.has_lens else \
            (port_of(settings), readings(settings).efl or math.inf)
        film_xy = (share[0] - 0.5) * settings.film.width, (share[1] - 0.5) * settings.film.height
        port_there = replace(port, index=port.stretch(math.hypot(*film_xy) / efl))
        focus = focused_at(replace(settings, medium="air"), share, port_there.apparent(depth))
        return focus._replace(distance=port.true(focus.distance))
    bent = settings.film_pose.is_tilted or settings.film_pose.is_curved
    if not (bent or lens_leans(settings)):
        return ClickFocus(depth)
    raster = share[0] * settings.film.pixels_x, share[1] * settings.film.pixels_y
    try:
        return _traced(settings, raster, depth) if settings.follows_lens else _of_ideal_lens(settings, raster, depth)
    except lb.LensError:
        return ClickFocus(math.inf, BEYOND)


def depth_nearness(settings: Settings, rasters: np.ndarray) -> np.ndarray:
    """One over the distance (n,), mm, of what is in focus at raster points (n, 2): along the axis from the film.

    By traced beams, of an ideal lens in closed form; NaN without light.
    """
    own, film = bench_of(settings), np.array([film_position(settings, (x, y)) for x, y in rasters.tolist()])
    if not settings.follows_lens:
        return np.array([1.0 / (lb.focused_distance(own.lens, own.film_distance + z) - z) for z in film[:, 2].tolist()])
    whole = own.focusing.method != "paraxial"
    return beams(own.lens, own.film_distance, film - [0.0, 0.0, own.focusing.shift], whole).depth_nearness


def _of_ideal_lens(settings: Settings, raster: Place, depth: float) -> ClickFocus:
    """The focus of an ideal lens, in closed form: its film point lies before or behind the film's middle."""
    at_middle, (there, _) = bench_of(settings), seen_from(settings, raster)
    at_depth = lb.film_distance(at_middle.lens, depth)
    distance = lb.focused_distance(at_middle.lens, at_depth - (there.film_distance - at_middle.film_distance))
    return ClickFocus(distance, BEYOND if math.isinf(distance) and math.isfinite(depth) else "")


def _traced(settings: Settings, raster: Place, depth: float) -> ClickFocus:
    """The focus distance by beams of the film point, which are traced for every trial."""
    at_middle = bench_of(settings)
    method = at_middle.focusing.method

    def excess(nearness: float) -> float:
        """How much nearer (1/mm) than the depth the beam has its focus, for a focus distance of 1 / nearness."""
        trial = replace(settings, focus_distance=1.0 / nearness if nearness > 0.0 else math.inf, focus_position=method)
        return float(depth_nearness(trial, np.array([raster]))[0]) - 1.0 / depth

    nearest = 1.0 / (lb.nearest_focus(at_middle.lens) * (1.0 + 1e-6))
    slack = UNSHARP * settings.film.pitch * at_middle.f_number / at_middle.at_infinity.efl**2
    enough = max(ENOUGH / depth, 1e-3 * ENOUGH * nearest)

    # The secant rule from the depth itself: the film point's focus changes nearly as much as that of the middle
    before, nearness = math.nan, min(1.0 / depth, nearest)
    was = math.nan
    for _ in range(STEPS):
        off = excess(nearness)
        if math.isnan(off):
            return ClickFocus(depth, UNLIT)
        if nearness == 0.0 and off >= 0.0:
            return ClickFocus(math.inf, BEYOND if off > slack else "")
        if nearness == nearest and off <= 0.0:
            return ClickFocus(1.0 / nearest, TOO_NEAR if off < -slack else "")
        if abs(off) <= enough:
            break
        slope = (off - was) / (nearness - before)
        before, was = nearness, off
        nearness = min(max(nearness - (off / slope if slope > LEAST_SLOPE else off), 0.0), nearest)
    return ClickFocus(1.0 / nearness if nearness > 0.0 else math.inf)


# The focus distance that puts the film elsewhere: a lens with focus groups is moved as a whole, paraxially


def film_z(built: Bench) -> float:
    """Where the film of the lens as a whole is, in the lens frame; LensError for a lens that cannot be focused."""
    whole, nearest = _whole(built.lens)
    return whole.length + lb.film_distance(whole, max(built.focus_distance, nearest))


def focus_at(built: Bench, shift: float) -> float:
    """The focus distance of a film that is shifted by so much along +z; the current one where there is none."""
    try:
        whole, nearest = _whole(built.lens)
        now = lb.film_distance(whole, max(built.focus_distance, nearest))
        film = min(now + shift, lb.film_distance(whole, nearest))
        port = replace(built.port, window=built.port.window + film - now)
        return float(port.true(max(lb.focused_distance(whole, film), nearest)))
    except lb.LensError:
        return float(built.port.true(built.focus_distance))


def _whole(lens: lb.Lens) -> tuple[lb.Lens, float]:
    """The lens without focus groups, and its nearest focus distance."""
    whole = replace(lens.at(close=0.0), positions=None)
    return whole, max(lb.nearest_focus(lens), lb.nearest_focus(whole))
