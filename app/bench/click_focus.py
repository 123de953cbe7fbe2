"""The focus distance that makes sharp what a click in the picture points at.

Lengths in mm. A real lens whose film or whose elements are out of line is focused by traced beams of the film point:
narrow ones where the film lies at the paraxial focus, those of the open stop where it lies at the least blur.

The focus distance that puts the film elsewhere behind the lens.

The film of a lens with focus groups is fixed: its lens as a whole is taken instead, paraxially. Lengths in mm.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Setup, setup
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.view_camera import Place, lens_leans, seen_from
from lensbench.app.bench.water_window import port_index, port_of
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.depth_over_field import beams

ENOUGH = 1e-7                   # of the nearness of what is pointed at
STEPS, LEAST_SLOPE = 30, 0.2    # of the secant rule, and of its secants
UNSHARP = 0.1                   # pixels of blur at an end of the focus, from which on a remark says so
BEYOND = "It lies beyond the farthest focus here"
TOO_NEAR = "It lies nearer than the nearest focus here"
UNLIT = "No light here: focused as at the middle"


class ClickFocus(NamedTuple):
    """distance: of the focus (mm), inf allowed. remark: why that does not make the place sharp; "" where it does."""

    distance: float
    remark: str = ""


def focused_at(settings: Settings, part: Place, depth: float) -> ClickFocus:
    """The focus at which what lies `depth` mm before the film is sharp at a part of the picture.

    part: of its width and height, from the top left. Beyond a window into water, depth and focus are true distances.
    """
    if port_index(settings) != 1.0:                     # off the axis, water shows things nearer still than on it
        port, efl = (setup(settings).port, setup(settings).first_order.efl) if settings.has_lens else \
            (port_of(settings), readings(settings).efl or math.inf)
        at = (part[0] - 0.5) * settings.film.width, (part[1] - 0.5) * settings.film.height
        here = replace(port, index=port.stretch(math.hypot(*at) / efl))
        found = focused_at(replace(settings, medium="air"), part, here.apparent(depth))
        return found._replace(distance=port.true(found.distance))
    bent = settings.film_pose.is_tilted or settings.film_pose.is_curved
    if not (bent or lens_leans(settings)):
        return ClickFocus(depth)
    raster = part[0] * settings.film.pixels_x, part[1] * settings.film.pixels_y
    try:
        return _traced(settings, raster, depth) if settings.follows_lens else _in_line(settings, raster, depth)
    except lb.LensError:
        return ClickFocus(math.inf, BEYOND)


def _in_line(settings: Settings, raster: Place, depth: float) -> ClickFocus:
    """The focus of an ideal lens, in closed form: its film point lies before or behind the film's middle."""
    at_middle, (here, _) = setup(settings), seen_from(settings, raster)
    at_depth = lb.film_distance(at_middle.lens, depth)
    found = lb.focused_distance(at_middle.lens, at_depth - (here.film_distance - at_middle.film_distance))
    return ClickFocus(found, BEYOND if math.isinf(found) and math.isfinite(depth) else "")


def _traced(settings: Settings, raster: Place, depth: float) -> ClickFocus:
    """The focus distance by beams of the film point, which are traced for every trial."""
    at_middle = setup(settings)
    method = at_middle.focusing.method

    def excess(nearness: float) -> float:
        """How much nearer (1/mm) than the depth the beam has its focus, for a focus distance of 1 / nearness."""
        trial = replace(settings, focus_distance=1.0 / nearness if nearness > 0.0 else math.inf, focus_position=method)
        here, (x, y) = seen_from(trial, raster)
        film_distance = setup(trial).film_distance
        film = np.array([[x, y, here.film_distance - film_distance]])
        return float(beams(here.lens, film_distance, film, method == "real").depth_nearness[0]) - 1.0 / depth

    nearest = 1.0 / (lb.nearest_focus(at_middle.lens) * (1.0 + 1e-6))
    slack = UNSHARP * settings.film.pitch * at_middle.f_number / at_middle.at_infinity.efl**2
    enough = max(ENOUGH / depth, 1e-3 * ENOUGH * nearest)

    # The secant rule from the depth itself: the film point's focus changes nearly as much as that of the middle
    before, here = math.nan, min(1.0 / depth, nearest)
    was = math.nan
    for _ in range(STEPS):
        off = excess(here)
        if math.isnan(off):
            return ClickFocus(depth, UNLIT)
        if here == 0.0 and off >= 0.0:
            return ClickFocus(math.inf, BEYOND if off > slack else "")
        if here == nearest and off <= 0.0:
            return ClickFocus(1.0 / nearest, TOO_NEAR if off < -slack else "")
        if abs(off) <= enough:
            break
        slope = (off - was) / (here - before)
        before, was = here, off
        here = min(max(here - (off / slope if slope > LEAST_SLOPE else off), 0.0), nearest)
    return ClickFocus(1.0 / here if here > 0.0 else math.inf)


def film_z(built: Setup) -> float:
    """Where the film of the lens as a whole is, in the lens frame; LensError for a lens that cannot be focused."""
    whole, nearest = _whole(built.lens)
    return whole.length + lb.film_distance(whole, max(built.focus_distance, nearest))


def focus_at(built: Setup, shift: float) -> float:
    """The focus distance of a film that is shifted by so much along +z; the present one where there is none."""
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
