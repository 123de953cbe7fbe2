"""The exit-pupil region of a film point: the part of the rear plane that passes its light.

Drawn upright, the film point above the axis; x and y in mm on the plane of the
last vertex.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.build import Bench, bench_of
from lensbench.app.bench.focus_plane import seen_from
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, paragraph
from lensbench.app.drawing.dial import dial
from lensbench.app.drawing.plot_painter import Drawn, draw_plot, drawn_map
from lensbench.app.plots.exit_pupil import BoxSamples, Region, box_samples, region, turn
from lensbench.app.plots.pixel_rays import Pointed, PointedRay, ray_through, rear_place
from lensbench.app.plots.plot import DASHED, Axis, Curve, Label, Patch, Plot, Points
from lensbench.app.settings.dial_scales import radius_scale
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_area
from lensbench.core.text import fixed, true_minus

FIELDS = (("axis", 0.0), ("0.7", 0.7), ("full", 1.0))   # parts of the illuminated film
UPWARDS = "Film points up the picture, in the section y–z"
NAME = "Exit pupil"
MARGIN = 1.16                   # of the plot about what it shows
STEPS = 8                       # of a plot's size, in which its limits change
SMALL = 0.5                     # of the clear aperture, which is not shown whole with regions that together are smaller
BOX = "bounding box (as pbrt)"
DENSITY = 10.0                  # pixels between samples that are drawn
SAME = 0.004                    # of the lit radius: tolerance within which a film point takes the colour of a field


@dataclass
class PupilState:
    """State of the panel between frames. box: the bounding box and its samples are drawn."""

    box: bool = False
    drawn: Drawn = field(default_factory=Drawn)


def exit_pupil_panel(settings: Settings, film_radius: float, state: PupilState, links: Pointed | None = None,
                     other: Settings | None = None) -> float:
    """Draw the panel in the rest of the window; returns film_radius (mm), changed by its dial.

    links: what the mouse points at in all panels; the film point of its pixel takes precedence. The ray through the
    point under the mouse is set there. other: the settings A, while they are compared.
    """
    links = links if links is not None else Pointed()
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return film_radius
    if not settings.has_lens:
        paragraph("This camera has no lens and no exit pupil")
        return film_radius
    if not settings.has_stop:
        paragraph("A pinhole has no exit pupil: all light goes through a point")
        return film_radius
    try:
        lens_setup = bench_of(settings)
        corner, reach = 0.5 * lens_setup.film.diagonal, lit_radius(lens_setup)
        if size.y > theme.em(14):
            film_radius = dial("Film radius", min(film_radius, corner), radius_scale(corner, 0.7 * reach),
                               "Distance of the film point from the axis")
        raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
        bench, film_point = (lens_setup, (0.0, film_radius)) if raster is None else seen_from(settings, raster)
        shown, azimuth = math.hypot(*film_point), math.atan2(film_point[1], film_point[0])
        fields = [region(lens_setup.lens, lens_setup.film_distance, share * reach) for _, share in FIELDS]
        pointed = region(bench.lens, bench.film_distance, shown, azimuth)
        samples = box_samples(bench.lens, bench.film_distance, shown, azimuth)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return film_radius
    pointer = "" if raster is None else "Pinned" if links.pinned is not None else "Mouse"
    _words(pointed, samples, pointer, links.surfaces, settings.follows_lens, reach)
    _box_switch(state)
    if raster is None and not lens_setup.lens.is_rotationally_symmetric:
        theme.small()
        imgui.text_colored(theme.colours().dim, UPWARDS)
        imgui.pop_font()
        imgui.set_item_tooltip("This lens has no rotational symmetry: film points to the side have other regions "
                               "than those above it, which are shown. Pictures follow the true ones all over the film")
    ghost = _ghost(other, shown, azimuth)
    crossed = rear_place(settings, raster, links.ray) if links.ray is not None else None
    rear = _plot(lens_setup, fields, pointed, samples, reach, links.surfaces, crossed, ghost, state)
    if rear is not None:
        x, y = rear @ turn(lens_setup.lens, film_point)
        ray = ray_through(settings, film_point, (float(x), float(y)), bench)
        links.point_at_ray(ray)
        _tooltip(rear, ray)
    return film_radius


def _ghost(other: Settings | None, film_radius: float, azimuth: float) -> Region | None:
    """The region of the settings A for the same film point, on the plane of its own last vertex."""
    if other is None or not (other.has_lens and other.has_stop):
        return None
    try:
        built = bench_of(other)
        of_a = region(built.lens, built.film_distance, film_radius, azimuth)
    except (ValueError, OSError):               # A has no region to compare with
        return None
    return of_a if len(of_a.outline) else None


def shown_box(rear: float, regions: Sequence[Region], pointed: Region,
              ghost: np.ndarray | None = None) -> tuple[float, float, float, float]:
    """x0, y0, x1, y1 (mm) about the regions and the rear clear aperture; without this for regions that are small.

    ghost: outline (n, 2) of the region of A, or None.
    """
    near = pointed.box if ghost is None else (*np.minimum(pointed.box[:2], ghost.min(axis=0)).tolist(),
                                              *np.maximum(pointed.box[2:], ghost.max(axis=0)).tolist())
    boxes = [near, *(one.box for one in regions if one.area > 0.0)] if pointed.area > 0.0 else \
        [one.box for one in regions if one.area > 0.0]
    low, high = (end(np.array(boxes or [(0.0,) * 4])[:, part], 0) for end, part in (
        (np.min, slice(0, 2)), (np.max, slice(2, 4))))
    if not pointed.area > 0.0 or (high - low).max() > 2.0 * SMALL * rear:
        low, high = np.minimum(low, -rear), np.maximum(high, rear)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _rested(box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """The box with a margin, in steps of its own size, so that a plot is fitted again only after a notable change."""
    x, y = 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])
    half = 0.5 * MARGIN * max(box[2] - box[0], box[3] - box[1], 1e-9)
    step = 2.0 ** round(math.log2(half)) / STEPS
    x, y, half = round(x / step) * step, round(y / step) * step, math.ceil(half / step) * step
    return x - half, y - half, x + half, y + half


def _plot(lens_setup: Bench, fields: list[Region], pointed: Region, samples: BoxSamples, reach: float,
          lit: tuple[int, ...], crossed: np.ndarray | None, ghost: Region | None,
          state: PupilState) -> np.ndarray | None:
    """Draw the plot; returns the point (2,) under the mouse, upright, in mm, if there is one.

    lit: indices of the surfaces whose blocked samples are marked. crossed: the point of the ray that the mouse points
    at in any panel. ghost: the region of A, or None.
    """
    size, rear = imgui.get_content_region_avail(), lens_setup.lens.surfaces[-1].semi_diameter
    if size.y < 40.0:
        return None
    drawn = drawn_map(NAME, state.drawn)
    dense = 0.0 if drawn is None else (drawn.right - drawn.left) / max(drawn.x1 - drawn.x0, 1e-9) / theme.scale()
    count = 0
    if pointed.area > 0.0 and (state.box or lit):
        x0, y0, x1, y1 = pointed.box
        count = min(int((x1 - x0) * (y1 - y0) * (dense / DENSITY) ** 2), len(samples.points))
    plot = pupil_plot(rear, tuple(fields), pointed, samples, reach, lit if count else (), count, ghost)
    theme.small()
    over = () if crossed is None else (Points("", crossed[:1], crossed[1:], "chart1", "ring", size=5.0),)
    under = draw_plot(NAME, plot, size, state.drawn, over=over)
    imgui.pop_font()
    return None if under is None or imgui.is_mouse_down(imgui.MouseButton_.left) else np.array([under.x, under.y])


@lru_cache(maxsize=4)
def pupil_plot(rear: float, fields: tuple[Region, ...], pointed: Region, samples: BoxSamples, reach: float,
               lit: tuple[int, ...], count: int, ghost: Region | None) -> Plot:
    """The rear clear aperture, the regions of three fields, and the chosen one, filled, with the first `count` samples.

    The chosen region has the tint of its field if it is one of them. reach: of light on the film (mm).
    """
    turn = np.linspace(0.0, 2.0 * math.pi, 97)
    layers: list = [Curve("", rear * np.cos(turn), rear * np.sin(turn), "faint", weight=1.0)]
    own = next((f"field{i}" for i, (_, share) in enumerate(FIELDS) if abs(pointed.film_radius - share * reach)
                <= SAME * reach), "strong")
    if pointed.area > 0.0:
        layers.append(Patch(pointed.outline, own, 0.22))
    for i, ((name, _), of) in enumerate(zip(FIELDS, fields, strict=True)):
        if of.area > 0.0:
            lowest, rightmost = np.argmin(of.outline[:, 1]), np.argmax(of.outline[:, 0])
            x, y = of.outline[lowest if name == "axis" else rightmost]
            layers += [_outline(of.outline, f"field{i}", 1.0),
                       Label(x, y, name, f"field{i}", "below" if name == "axis" else "right", free=True)]
    layers.append(Label(-0.71 * rear, -0.71 * rear, "clear aperture", "dim", "left below", free=True))
    if pointed.area > 0.0:
        layers.append(_outline(pointed.outline, own, 2.0))
    if count:
        layers += _samples(pointed, samples, count, lit)
    if ghost is not None:
        x, y = ghost.outline[np.argmin(ghost.outline[:, 0])]
        layers += [_outline(ghost.outline, "chart4", 1.5), Label(x, y, "A", "chart4", "left", free=True)]
    x0, y0, x1, y1 = _rested(shown_box(rear, fields, pointed, None if ghost is None else ghost.outline))
    return Plot(Axis("x (mm)", x0, x1), Axis("y (mm)", y0, y1), tuple(layers), equal=True)


def _outline(outline: np.ndarray, tint: str, weight: float) -> Curve:
    """A closed line through points (n, 2); its ends overlap, so that no notch is seen."""
    return Curve.through("", np.concatenate([outline, outline[:2]]), tint, weight=weight)


def _samples(pointed: Region, samples: BoxSamples, count: int, lit: tuple[int, ...]) -> list:
    """The bounding box of the region, which pbrt samples, and its samples: dots pass, crosses do not."""
    x0, y0, x1, y1 = pointed.box
    points, blocked_by = samples.points[:count], samples.blocked_by[:count]
    marked = np.isin(blocked_by, lit)
    kinds = ((blocked_by < 0, "strong", "square", 0.75), ((blocked_by >= 0) & ~marked, "dead", "cross", 2.0),
             (marked, "warning", "cross", 2.5))
    return [Curve("", np.array([x0, x1, x1, x0, x0]), np.array([y0, y0, y1, y1, y0]), "text", DASHED, 1.0),
            *(Points(tint, points[chosen, 0], points[chosen, 1], tint, shape, size=size)
              for chosen, tint, shape, size in kinds)]


def _words(pointed: Region, samples: BoxSamples, pointer: str, lit: tuple[int, ...], traced: bool,
           reach: float) -> None:
    """One line above the plot: area, share of samples that pass, and the film point if the mouse or a pin sets it.

    pointer: which of the two, or "". lit: indices of surfaces whose share of the blocked samples is written instead.
    """
    where = f"{pointer} at {fixed(pointed.film_radius, 1)} mm:  " if pointer else ""
    if pointed.area <= 0.0:
        beyond = f"light beyond {fixed(reach, 1)} mm"
        what = f"no {beyond}" if pointer else f"No {beyond} off the axis"
    elif lit:
        names = " and ".join(map(str, lit))
        share = float(np.isin(samples.blocked_by, lit).mean())
        what = f"surface{'s' if len(lit) > 1 else ''} {names}: {fixed(100.0 * share, 0)} % blocked"
        what = what if where else what[0].upper() + what[1:]
    else:
        verb = "passes" if pointer else "of the box passes"
        what = f"{format_area(pointed.area)},  {fixed(100.0 * samples.rate, 0)} % {verb}"
    theme.small()
    imgui.text_colored(theme.colours().text, where + what)
    imgui.pop_font()
    imgui.set_item_tooltip("Area of the exit-pupil region on the plane of the last vertex, and how many of the samples "
                           "in its bounding box, which pbrt takes, reach the scene"
                           + ("; the region is that of the real lens" if not traced else ""))


def _box_switch(state: PupilState) -> None:
    """The switch of the box: under the words, or after them where there is room."""
    theme.small()
    width = imgui.calc_text_size(BOX).x + imgui.get_frame_height() + theme.em(0.8)
    if imgui.get_item_rect_max().x + theme.em(1.0) + width < imgui.get_cursor_screen_pos().x \
            + imgui.get_content_region_avail().x:
        imgui.same_line(0.0, theme.em(1.0))
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(1.0, 0.0))
    state.box = check_box(BOX, state.box)
    imgui.pop_style_var()
    imgui.pop_font()
    imgui.set_item_tooltip("The bounding box of the region, in which pbrt takes its samples: dots reach the scene, "
                           "crosses are vignetted")


def _tooltip(point: np.ndarray, ray: PointedRay) -> None:
    """Tooltip: whether light passes at the point under the mouse, and where it comes from."""
    if imgui.begin_tooltip():
        imgui.text_unformatted(true_minus(f"x {fixed(point[0], 2)}, y {fixed(point[1], 2)} mm"))
        imgui.text_disabled(f"Light passes here, {ray.end}" if ray.surface < 0 else f"The ray {ray.end}")
        imgui.end_tooltip()
