"""The exit-pupil region of a film point: the part of the rear plane that passes its light.

Drawn upright, the film point above the axis; x and y in mm on the plane of the
last vertex.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.bench.build import Setup, setup
from lensbench.app.bench.focus_plane import seen_from
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, paragraph
from lensbench.app.drawing.dial import dial
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, dashed_line, polyline, simplified, text
from lensbench.app.drawing.recorded import FrameMemo, Recorded
from lensbench.app.panels.lens_section.draw import round_length
from lensbench.app.plots.exit_pupil import BoxSamples, Region, box_samples, region, turn
from lensbench.app.plots.pixel_rays import Pointed, PointedRay, ray_through, rear_place
from lensbench.app.settings.dial_scales import radius_scale
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_area
from lensbench.core.text import fixed, significant, true_minus

FIELDS = (("axis", 0.0), ("0.7", 0.7), ("full", 1.0))   # parts of the illuminated film
UPWARDS = "Film points up the picture, in the section y–z"
MARGIN = 1.16                   # of the plot about what it shows
SMALL = 0.2                     # of all that could be shown: a smaller region fills the plot
BOX = "bounding box (as pbrt)"
DENSITY = 10.0                  # pixels between samples that are drawn
SAME = 0.004                    # of the lit radius: tolerance within which a film point takes the colour of a field


@dataclass
class PupilState:
    """State of the panel between frames: limits and shape of its plot."""

    fitted_to: tuple = ()
    fit: bool = False
    span: float = 20.0          # mm shown across
    shape: tuple[int, int] = (1, 1)     # pixels
    box: bool = False           # the bounding box and its samples are drawn
    memo: FrameMemo = field(default_factory=FrameMemo)     # outlines and samples in pixels
    drawing: Recorded = field(default_factory=Recorded)


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
        lens_setup = setup(settings)
        corner, reach = 0.5 * lens_setup.film.diagonal, lit_radius(lens_setup)
        if size.y > theme.em(14):
            film_radius = dial("Film radius", min(film_radius, corner), radius_scale(corner, 0.7 * reach),
                               "Distance of the film point from the axis")
        raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
        here, at = (lens_setup, (0.0, film_radius)) if raster is None else seen_from(settings, raster)
        shown, azimuth = math.hypot(*at), math.atan2(at[1], at[0])
        fields = [region(lens_setup.lens, lens_setup.film_distance, part * reach) for _, part in FIELDS]
        seen = region(here.lens, here.film_distance, shown, azimuth)
        samples = box_samples(here.lens, here.film_distance, shown, azimuth)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return film_radius
    pointer = "" if raster is None else "Pinned" if links.pinned is not None else "Mouse"
    _words(seen, samples, pointer, links.surfaces, settings.follows_lens, reach)
    _box_switch(state)
    if raster is None and not lens_setup.lens.is_rotationally_symmetric:
        theme.small()
        imgui.text_colored(theme.colours().dim, UPWARDS)
        imgui.pop_font()
        imgui.set_item_tooltip("This lens has no rotational symmetry: film points beside the axis have other regions "
                               "than those above it, which are shown. Pictures follow the true ones all over the film")
    ghost = _ghost(other, shown, azimuth)
    crossed = rear_place(settings, raster, links.ray) if links.ray is not None else None
    rear = _plot(lens_setup, fields, seen, samples, reach, links.surfaces, crossed, ghost, state)
    if rear is not None:
        x, y = rear @ turn(lens_setup.lens, at)
        ray = ray_through(settings, at, (float(x), float(y)), here)
        links.point_at_ray(ray)
        _tooltip(rear, ray)
    return film_radius


def _plot(lens_setup: Setup, fields: list[Region], seen: Region, samples: BoxSamples, reach: float,
          lit: tuple[int, ...], crossed: np.ndarray | None, ghost: np.ndarray | None,
          state: PupilState) -> np.ndarray | None:
    """Draw the plot; returns the point (2,) under the mouse, upright, in mm, if there is one.

    lit: indices of the surfaces whose blocked samples are marked. crossed: the point of the ray that the mouse points
    at in any panel. ghost: outline (n, 2) of the region of A, or None.
    """
    corner, size = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    if size.y < 40.0:
        return None
    pointed = None
    rear = lens_setup.lens.surfaces[-1].semi_diameter
    shown = shown_box(rear, fields, seen, ghost)
    key = (rear, lens_setup.lens.length, size.x, size.y, state.shape, coarse(shown, rear))
    refit = state.fit or state.fitted_to != key
    state.fitted_to, state.fit = key, False
    roomy = size.x > theme.em(11) and size.y > theme.em(9)
    theme.small()
    if implot.begin_plot("Exit pupil plot", size, PLOT_FLAGS | implot.Flags_.equal):
        implot.setup_axes("x (mm)" if roomy else "", "y (mm)" if roomy else "", AXIS_FLAGS, AXIS_FLAGS)
        condition = implot.Cond_.always if refit else implot.Cond_.once
        x0, x1, y0, y1 = _limits(shown, *state.shape)
        implot.setup_axes_limits(x0, x1, y0, y1, condition)
        if refit:
            state.span = x1 - x0
        for axis in (implot.ImAxis_.x1, implot.ImAxis_.y1):
            implot.setup_axis_ticks(axis, *_ticks(state.span, rear), False)
        plot = PlotMap.current(log=False)
        state.span = plot.x1 - plot.x0
        state.shape = (round(plot.right - plot.left), round(plot.bottom - plot.top))
        draw = implot.get_plot_draw_list()
        implot.push_plot_clip_rect()
        state.drawing.draw(draw, (plot, rear, *fields, seen, samples, reach, lit, state.box),
                           partial(_draw, plot=plot, rear=rear, fields=fields, seen=seen, samples=samples, reach=reach,
                                   lit=lit, state=state))
        if ghost is not None:
            polyline(draw, plot.pixels(*ghost.T), theme.packed(theme.compared()), 1.5, closed=True)
            text(draw, plot.at(*ghost[int(np.argmin(ghost[:, 0]))]), theme.compared(), "A ", right=True)
        if crossed is not None:
            draw.add_circle(plot.at(*crossed), 5.0 * theme.scale(), theme.packed(theme.pointed()), 0,
                            2.0 * theme.scale())
        implot.pop_plot_clip_rect()
        if implot.is_plot_hovered():
            state.fit = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
            mouse = imgui.get_mouse_pos()
            y = plot.y0 + (plot.bottom - mouse.y) / max(plot.bottom - plot.top, 1e-6) * (plot.y1 - plot.y0)
            if not imgui.is_mouse_down(imgui.MouseButton_.left):
                pointed = np.array([plot.x_at(mouse.x), y])
        implot.end_plot()
    imgui.pop_font()
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    return pointed


def _ghost(other: Settings | None, film_radius: float, azimuth: float) -> np.ndarray | None:
    """Outline (n, 2) of the region of the settings A for the same film point, on the plane of its own last vertex."""
    if other is None or not (other.has_lens and other.has_stop):
        return None
    try:
        built = setup(other)
        outline = region(built.lens, built.film_distance, film_radius, azimuth).outline
    except (ValueError, OSError):               # A has no region to compare with
        return None
    return outline if len(outline) else None


def shown_box(rear: float, regions: list[Region], seen: Region,
              ghost: np.ndarray | None = None) -> tuple[float, float, float, float]:
    """x0, y0, x1, y1 (mm) about the regions and the rear rim; about the seen region, and that of A, where it is small.

    ghost: outline (n, 2) of the region of A, or None.
    """
    near = seen.box if ghost is None else (*np.minimum(seen.box[:2], ghost.min(axis=0)).tolist(),
                                           *np.maximum(seen.box[2:], ghost.max(axis=0)).tolist())
    boxes = [near, *(one.box for one in regions if one.area > 0.0)] if seen.area > 0.0 else \
        [one.box for one in regions if one.area > 0.0]
    x0, y0, x1, y1 = -rear, -rear, rear, rear
    for box in boxes:
        x0, y0, x1, y1 = min(x0, box[0]), min(y0, box[1]), max(x1, box[2]), max(y1, box[3])
    size = max(near[2] - near[0], near[3] - near[1])
    if not seen.area > 0.0 or size > SMALL * max(x1 - x0, y1 - y0):
        return x0, y0, x1, y1
    half, x, y = 0.8 * size, 0.5 * (near[0] + near[2]), 0.5 * (near[1] + near[3])
    return x - half, y - half, x + half, y + half


def coarse(box: tuple[float, float, float, float], rear: float) -> tuple[int, ...]:
    """The box in steps of its own size, so that a plot is fitted again only after a notable change."""
    step = 2.0 ** round(math.log2(max(box[2] - box[0], box[3] - box[1], 1e-9 * rear))) / 4.0
    return tuple(round(edge / step) for edge in box)


def _limits(box: tuple[float, float, float, float], width: int, height: int) -> tuple[float, float, float, float]:
    """x0, x1, y0, y1 (mm) of the plot about this box, in the aspect ratio of the plot."""
    x, y = 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])
    mm = MARGIN * max((box[2] - box[0]) / max(width, 1), (box[3] - box[1]) / max(height, 1))       # per pixel
    return x - 0.5 * width * mm, x + 0.5 * width * mm, y - 0.5 * height * mm, y + 0.5 * height * mm


@lru_cache(maxsize=16)
def _ticks(span: float, rear: float) -> tuple[list[float], list[str]]:
    """Round steps, about five across the plot, up to three times the rear rim."""
    step = max(round_length(max(span, 1e-6) / 4.0), 0.002 * rear)
    count = math.ceil(3.0 * rear / step)
    values = [i * step for i in range(-count, count + 1)]
    return values, [true_minus(significant(value)) for value in values]


def _draw(draw: imgui.ImDrawList, plot: PlotMap, rear: float, fields: list[Region], seen: Region,
          samples: BoxSamples, reach: float, lit: tuple[int, ...], state: PupilState) -> None:
    colour, pixel = theme.colours(), theme.scale()
    state.memo.begin_frame()                            # one that is drawn anew
    turn = np.linspace(0.0, 2.0 * math.pi, 97)[:-1]
    polyline(draw, plot.pixels(rear * np.cos(turn), rear * np.sin(turn)), theme.packed(colour.faint), 1.0, closed=True)
    at = plot.at(-0.71 * rear, -0.71 * rear)
    name = imgui.calc_text_size("rear rim")
    text(draw, ImVec2(max(at.x - name.x, plot.left + 3.0 * pixel), at.y + pixel), colour.dim, "rear rim")

    # The chosen region, filled, in the colour of its field if it is one of them
    own = colour.strong
    tints = ((colour.field0, colour.field0_text), (colour.field1, colour.field1_text),
             (colour.field2, colour.field2_text))
    for (_, part), pair in zip(FIELDS, tints, strict=True):
        if abs(seen.film_radius - part * reach) <= SAME * reach:
            own = pair[0]
    if seen.area > 0.0:
        outline = state.memo.of((seen, plot), lambda: _outline(seen, plot))
        draw.add_convex_poly_filled(outline, theme.packed(own, 0.22))
    drawn = []
    for (name_, _), (tint, tint_text), one in zip(FIELDS, tints, fields, strict=True):
        if one.area > 0.0:
            its_outline = state.memo.of((one, plot), partial(_outline, one, plot))
            draw.add_polyline(its_outline, theme.packed(tint), pixel, imgui.ImDrawFlags_.closed)
            drawn.append((name_, one, tint_text))
    if seen.area > 0.0:
        draw.add_polyline(outline, theme.packed(own), 2.0 * pixel, imgui.ImDrawFlags_.closed)
        if state.box or lit:
            _draw_samples(draw, plot, seen, samples, lit, state)
    outlines = np.concatenate([plot.pixels(*one.outline.T) for _, one, _ in drawn]
                              + [plot.pixels(rear * np.cos(turn), rear * np.sin(turn))])
    taken: list[tuple[float, float, float, float]] = []
    for name_, one, ink in drawn:
        _name(draw, plot, name_, one, ink, outlines, taken)


def _draw_samples(draw: imgui.ImDrawList, plot: PlotMap, seen: Region, samples: BoxSamples, lit: tuple[int, ...],
                  state: PupilState) -> None:
    """The bounding box of the region, which pbrt samples, and its samples: dots pass, crosses do not."""
    colour, pixel = theme.colours(), theme.scale()
    x0, y0, x1, y1 = seen.box
    a, b = plot.at(x0, y1), plot.at(x1, y0)
    line = theme.packed(colour.text, 0.8)
    for p, q in ((a, ImVec2(b.x, a.y)), (ImVec2(b.x, a.y), b), (b, ImVec2(a.x, b.y)), (ImVec2(a.x, b.y), a)):
        dashed_line(draw, p, q, line, 4.0, 3.0)
    shown = min(int(abs(b.x - a.x) * abs(b.y - a.y) / (DENSITY * pixel) ** 2), len(samples.points))
    dots, crosses = state.memo.of((samples, shown, plot), lambda: _marks(samples, shown, plot, pixel))
    dot, cross, marked = theme.packed(colour.strong, 0.75), theme.packed(colour.dead, 0.9), theme.packed(colour.warning)
    for corners in dots:
        draw.add_rect_filled(*corners, dot)
    for surface, *ends in crosses:
        draw.add_line(*ends, marked if surface in lit else cross, (2.0 if surface in lit else 1.0) * pixel)


def _outline(field: Region, plot: PlotMap) -> list[ImVec2]:
    """A region's outline, in pixels."""
    return [ImVec2(x, y) for x, y in simplified(plot.pixels(*field.outline.T)).tolist()]


def _marks(samples: BoxSamples, shown: int, plot: PlotMap, pixel: float) -> tuple[list, list]:
    """For the first samples: corners of dots for those that pass; for the others the surface that ends them and the
    ends of the arms of their crosses.
    """
    points, radius, arm = plot.pixels(*samples.points[:shown].T).tolist(), 0.75 * pixel, 2.0 * pixel
    dots, crosses = [], []
    for (x, y), surface in zip(points, samples.blocked_by[:shown].tolist(), strict=True):
        if surface < 0:
            dots.append((ImVec2(x - radius, y - radius), ImVec2(x + radius, y + radius)))
        else:
            crosses += [(surface, ImVec2(x - arm, y - slope * arm), ImVec2(x + arm, y + slope * arm))
                        for slope in (1.0, -1.0)]
    return dots, crosses


def _name(draw: imgui.ImDrawList, plot: PlotMap, name: str, field: Region, colour: theme.Colour,
          outlines: np.ndarray, taken: list[tuple[float, float, float, float]]) -> None:
    """The name beside its region, at the first place around it where it touches no outline and no other name.

    outlines: points (n, 2) of all of them, pixels. taken: left, top, right and bottom of the names before; that of
    this one is added.
    """
    pixel, size = theme.scale(), imgui.calc_text_size(name)
    x0, y0, x1, y1 = field.box
    widest = plot.at(x1, float(field.outline[int(np.argmax(field.outline[:, 0])), 1]))
    below, above = plot.at(0.5 * (x0 + x1), y0), plot.at(0.5 * (x0 + x1), y1)
    gap = 4.0 * pixel
    places = [(widest.x + gap, widest.y + part * size.y) for part in (-0.5, -1.2, 0.2, -2.2, 1.2, 2.2, -3.2)]
    places += [(below.x - 0.5 * size.x, below.y + 0.5 * gap), (above.x - 0.5 * size.x, above.y - size.y - 0.5 * gap)]
    if name == "axis":
        places = [places[-2], places[-1], *places[:-2]]

    def clear(x: float, y: float) -> bool:
        box = (x - pixel, y + pixel, x + size.x + pixel, y + size.y - pixel)
        if box[0] < plot.left or box[2] > plot.right or box[1] < plot.top or box[3] > plot.bottom:
            return False
        if any(box[0] < r and box[2] > l and box[1] < b and box[3] > t for l, t, r, b in taken):
            return False
        return not ((outlines > box[:2]) & (outlines < box[2:])).all(axis=1).any()

    x, y = next((place for place in places if clear(*place)), places[0])
    taken.append((x, y, x + size.x, y + size.y))
    text(draw, ImVec2(x, y), colour, name)


def _words(seen: Region, samples: BoxSamples, pointer: str, lit: tuple[int, ...], traced: bool, reach: float) -> None:
    """One line above the plot: area, share of samples that pass, and the film point if the mouse or a pin sets it.

    pointer: which of the two, or "". lit: indices of surfaces whose share of the blocked samples is written instead.
    """
    where = f"{pointer} at {fixed(seen.film_radius, 1)} mm:  " if pointer else ""
    if seen.area <= 0.0:
        beyond = f"light beyond {fixed(reach, 1)} mm"
        what = f"no {beyond}" if pointer else f"No {beyond} off the axis"
    elif lit:
        names = " and ".join(map(str, lit))
        share = float(np.isin(samples.blocked_by, lit).mean())
        what = f"surface{'s' if len(lit) > 1 else ''} {names}: {fixed(100.0 * share, 0)} % blocked"
        what = what if where else what[0].upper() + what[1:]
    else:
        part = "passes" if pointer else "of the box passes"
        what = f"{format_area(seen.area)},  {fixed(100.0 * samples.rate, 0)} % {part}"
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


def _tooltip(at: np.ndarray, ray: PointedRay) -> None:
    """Tooltip: whether light passes at the point under the mouse, and where it comes from."""
    if imgui.begin_tooltip():
        imgui.text_unformatted(true_minus(f"x {fixed(at[0], 2)}, y {fixed(at[1], 2)} mm"))
        imgui.text_disabled(f"Light passes here, {ray.end}" if ray.surface < 0 else f"The ray {ray.end}")
        imgui.end_tooltip()
