"""Drawing of the section: a sketch on imgui's draw list, through a view.

Geometry in pixels is cached as long as neither lens nor view changes. Line
weights and lengths in pixels hold at a scale of 1, and are scaled to the screen.

The view of the section: millimetres to pixels, fitted, panned and zoomed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import floor, log10

import numpy as np
from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench.app.bench.ray_fans import Fan
from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import simplified
from lensbench.app.drawing.recorded import FrameMemo
from lensbench.app.plots.section import Sketch, elements
from lensbench.core.text import significant

MARGIN = 1.16               # of the tallest part, above and below
LEFT, RIGHT = 0.16, 0.16    # of the width, kept for the rays that come in and for the names next to the film
MOST_NAMES = 0.3            # of the width, at most, that these names get
ZOOM_STEP = 1.15
MIN_SCALE, MAX_SCALE = 1e-3, 1e5


@dataclass(frozen=True)
class View:
    """Pixels per mm, and where the first vertex lies in the panel (pixels from its upper left corner)."""

    scale: float
    x: float
    y: float

    def to_screen(self, corner: ImVec2, z: float, y: float) -> ImVec2:
        """A point (z, y) of the lens frame on the screen; corner: of the panel."""
        return ImVec2(corner.x + self.x + z * self.scale, corner.y + self.y - y * self.scale)

    def to_lens(self, corner: ImVec2, point: ImVec2) -> tuple[float, float]:
        """The inverse: (z, y) in mm."""
        return (point.x - corner.x - self.x) / self.scale, (corner.y + self.y - point.y) / self.scale

    def moved(self, dx: float, dy: float) -> "View":
        """Panned by pixels."""
        return replace(self, x=self.x + dx, y=self.y + dy)

    def zoomed(self, steps: float, x: float, y: float) -> "View":
        """Zoomed about the point at x, y (pixels in the panel)."""
        scale = min(max(self.scale * ZOOM_STEP**steps, MIN_SCALE), MAX_SCALE)
        factor = scale / self.scale
        return View(scale, x + factor * (self.x - x), y + factor * (self.y - y))


def fitted(width: float, height: float, z0: float, z1: float, half_height: float, label: float,
           names: float = 0.0) -> View:
    """All from z0 to z1 and ±half_height in a panel of this size.

    label: pixels below that the row of signs needs. names: pixels that the names behind z1 need.
    """
    width, height = max(width, 1.0), max(height - label, 1.0)
    length = max(z1 - z0, 1e-6)
    right = max(RIGHT * width, min(names, MOST_NAMES * width))
    scale = min(((1.0 - LEFT) * width - right) / length, height / (2.0 * MARGIN * max(half_height, 1e-6)))
    scale = min(max(scale, MIN_SCALE), MAX_SCALE)
    spare = width - length * scale
    # Spare room goes to the incoming rays for the most part
    return View(scale, min(0.6 * spare, spare - right) - z0 * scale, 0.5 * height + 0.15 * label)


def round_length(most: float) -> float:
    """The longest of 1, 2, 5 × 10ⁿ that is no longer than this."""
    decade = 10.0 ** floor(log10(most))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= most * (1.0 + 1e-9))


LIVE_ALPHA, DEAD_ALPHA = 0.55, 0.45
CROSS = 3.0
NARROW = 20.0                   # em: a narrower section has short names
SWITCHES = 13.0, 2.0            # em: width and height of the switches in the upper left corner
Box = tuple[float, float, float, float]     # left, top, right, bottom (pixels)
BESIDE = 10.0                   # pixels at a scale of 1, from the film to the names of the fields
OPEN = imgui.ImDrawFlags_.none


@dataclass(frozen=True)
class Canvas:
    """Drawing area of a section: corner and size of its panel (pixels), and the view."""

    x: float
    y: float
    width: float
    height: float
    view: View
    memo: FrameMemo = field(default_factory=FrameMemo, compare=False)   # of the panel: geometry in pixels

    @property
    def corner(self) -> ImVec2:
        """Upper left."""
        return ImVec2(self.x, self.y)

    def at(self, z: float, y: float) -> ImVec2:
        """Screen position of a point (z, y) of the lens frame."""
        return self.view.to_screen(self.corner, z, y)

    def points(self, points: np.ndarray) -> list[ImVec2]:
        """Screen positions of points (…, 2), z and y, in one row, clipped so that a strong zoom remains drawable."""
        return [ImVec2(x, y) for x, y in self.pixels(points).reshape(-1, 2).tolist()]

    def curve(self, points: np.ndarray) -> list[ImVec2]:
        """The same for a curve, without points that the eye would not miss."""
        return [ImVec2(x, y) for x, y in simplified(self.pixels(points)).tolist()]

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """The same as an array (…, 2)."""
        xy = np.asarray(points) * [self.view.scale, -self.view.scale] + [self.x + self.view.x, self.y + self.view.y]
        return np.minimum(np.maximum(xy, -1e6), 1e6)


def _glass(sketch: Sketch, canvas: Canvas) -> list[tuple[lb.Glass, list[ImVec2], list[ImVec2]]]:
    """Each element's glass, the corners of its strips, four each, and its outline, in pixels."""
    lens, glasses = sketch.lens, sketch.glasses
    return [] if lens is None else canvas.memo.of((lens, glasses, canvas), lambda: [
        (glasses[e.front], canvas.points(e.strips), canvas.curve(e.outline))
        for e in elements(lens)])


def ray_paths(fan: Fan, canvas: Canvas) -> list[list[ImVec2]]:
    """The rays of a fan in pixels, the first stretch cut at the left edge of the panel."""
    return canvas.memo.of((fan, canvas), lambda: _paths_in_pixels(fan, canvas))


def _paths_in_pixels(fan: Fan, canvas: Canvas) -> list[list[ImVec2]]:
    paths = [within(ray.path, canvas) for ray in fan.rays]
    points = canvas.points(np.concatenate(paths)) if paths else []
    ends = np.cumsum([0, *map(len, paths)]).tolist()
    return [points[a:b] for a, b in pairwise(ends)]


def within(path: np.ndarray, canvas: Canvas) -> np.ndarray:
    """A path (n, 2) of (z, y) whose first stretch is cut at the left edge of the panel."""
    left = canvas.view.to_lens(canvas.corner, ImVec2(canvas.x - 2.0, 0.0))[0]
    if len(path) > 1 and path[0][0] < left < path[1][0]:
        t = (left - path[0][0]) / (path[1][0] - path[0][0])
        path = np.vstack([path[0] + t * (path[1] - path[0]), path[1:]])
    return path


def field_colours() -> tuple[tuple[theme.Colour, theme.Colour], ...]:
    """Line and text colours of the axis, the 0.7 field and the full field."""
    c = theme.colours()
    return (c.field0, c.field0_text), (c.field1, c.field1_text), (c.field2, c.field2_text)


def draw_axis(draw: imgui.ImDrawList, canvas: Canvas) -> None:
    """A chain line along the axis."""
    colour, pixel = theme.packed(theme.colours().faint, 0.8), theme.scale()
    x, y = canvas.x, floor(canvas.at(0.0, 0.0).y)
    while x < canvas.x + canvas.width:
        for length, gap in ((8.0, 3.0), (1.5, 3.0)):
            draw.add_line(ImVec2(x, y + 0.5), ImVec2(x + length * pixel, y + 0.5), colour, pixel)
            x += (length + gap) * pixel


def draw_glass(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas) -> None:
    """The fill of every element, dim if the rays are those of an ideal lens."""
    if sketch.lens is None:
        return
    colour, alpha = theme.colours(), 0.45 if sketch.ideal else 1.0
    draw.push_draw_flag(imgui.ImDrawFlags_.aa_fill, False)             # otherwise the seams of the strips show
    for glass, strips, _ in _glass(sketch, canvas):
        fill = theme.packed(colour.glass(glass.n_d, glass.v_d if glass.v_d is not None else 60.0), alpha)
        for k in range(0, len(strips), 4):
            draw.add_quad_filled(*strips[k:k + 4], fill)
    draw.pop_draw_flag()


def draw_outlines(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas) -> None:
    """Surfaces, shoulders and edges of the glass, or the stroke of an ideal thin lens."""
    colour, pixel = theme.colours(), theme.scale()
    line = theme.packed(colour.glass_outline, 0.4 if sketch.ideal else 0.85)
    if sketch.lens is not None:
        for _, _, outline in _glass(sketch, canvas):
            draw.add_polyline(outline, line, 1.2 * pixel, imgui.ImDrawFlags_.closed)
        return
    line = theme.packed(colour.glass_outline)
    tops = [canvas.at(0.0, sign * sketch.glass_radius) for sign in (1.0, -1.0)]
    draw.add_line(*tops, line, 1.4 * pixel)
    for top, down in zip(tops, (1.0, -1.0), strict=True):
        for side in (-1.0, 1.0):
            draw.add_line(top, ImVec2(top.x + 4.0 * side * pixel, top.y + 5.0 * down * pixel), line, 1.4 * pixel)


def draw_rays(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, dead: bool, strength: float = 1.0) -> None:
    """All fans: first the lost rays, grey, to their crosses, then those that arrive; the chief rays last.

    strength: factor of their opacity, below 1 where a pixel's rays are shown over them.
    """
    colour, pixel = theme.colours(), theme.scale()
    if dead:
        line = theme.packed(colour.dead, DEAD_ALPHA * strength)
        for fan in sketch.fans:
            for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
                if ray.kind == "dead":
                    draw.add_polyline(path, line, pixel, OPEN)
                    draw_cross(draw, path[-1], theme.packed(colour.dead, 0.9 * strength))
    for kind, alpha, weight in (("", LIVE_ALPHA, 1.0), ("marginal", 0.85, 1.0), ("chief", 1.0, 1.6)):
        for fan, (tint, _) in zip(sketch.fans, field_colours(), strict=True):
            line = theme.packed(tint, alpha * strength)
            for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
                if ray.kind != kind:
                    continue
                if sketch.ideal:                            # may run back between its principal planes: no joins
                    for a, b in zip(path, path[1:], strict=False):
                        draw.add_line(a, b, line, weight * pixel)
                else:
                    draw.add_polyline(path, line, weight * pixel, OPEN)


def draw_cross(draw: imgui.ImDrawList, point: ImVec2, colour: int) -> None:
    """The end of a lost ray."""
    arm = CROSS * theme.scale()
    draw.add_line(ImVec2(point.x - arm, point.y - arm), ImVec2(point.x + arm, point.y + arm), colour, theme.scale())
    draw.add_line(ImVec2(point.x - arm, point.y + arm), ImVec2(point.x + arm, point.y - arm), colour, theme.scale())


def draw_stop(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, signs: list[tuple[float, float, float]],
              taken: Sequence[Box] = ()) -> None:
    """Two blades, from the edge of the opening outward past the glass, and their name where it touches nothing.

    signs: left, right and lower edge of each name in the row below the lens. taken: boxes of what else lies over the
    drawing (pixels).
    """
    if sketch.stop_radius is None:
        return
    colour, pixel = theme.packed(theme.colours().strong), theme.scale()
    outer = max(1.12 * (sketch.open_radius or sketch.stop_radius), 1.08 * sketch.near_stop)
    x = floor(canvas.at(sketch.on_stop(outer, outer)[0], 0.0).x)
    ring = 4.0 * pixel
    for sign in (1.0, -1.0):
        if not sketch.stop_is_centred:
            inner = canvas.at(*sketch.on_stop(sign * sketch.stop_radius, outer))
            draw.add_line(inner, canvas.at(*sketch.on_stop(sign * outer, outer)), colour, 2.0 * pixel)
            continue
        edge, end = canvas.at(0.0, sign * sketch.stop_radius).y, canvas.at(0.0, sign * outer).y
        start = edge - sign * ring
        draw.add_rect_filled(ImVec2(x - pixel, min(start, end)), ImVec2(x + pixel, max(start, end)), colour)
    if sketch.lens is not None:
        size = imgui.calc_text_size("Stop")
        left, line, row = x - 0.5 * size.x, size.y, max((edge for *_, edge in signs), default=canvas.y)
        upper, lower = (canvas.at(*sketch.on_stop(sign * outer, outer)).y for sign in (1.0, -1.0))
        edges = [canvas.at(*sketch.on_stop(sign * sketch.stop_radius, sketch.stop_radius)) for sign in (1.0, -1.0)]
        boxes = [(canvas.x, canvas.y, canvas.x + theme.em(SWITCHES[0]), canvas.y + theme.em(SWITCHES[1])), *taken,
                 *((start, edge - line, end, edge) for start, end, edge in signs),
                 *((edge.x - ring, edge.y - ring, edge.x + ring, edge.y + ring) for edge in edges)]
        ends = [start for start, *_ in signs] + [end for _, end, _ in signs] or [x]
        corners = [(left, upper - line - pixel), (left, lower + pixel), (left, row + pixel),
                   (min(ends) - size.x - 6.0 * pixel, row - line), (max(ends) + 6.0 * pixel, row - line),
                   *((x + way * 10.0 * pixel - (size.x if way < 0 else 0.0), y)
                     for y in (canvas.y + pixel, canvas.y + canvas.height - line - pixel) for way in (1, -1))]
        inside = canvas.y - 0.2 * line, canvas.y + canvas.height - line
        free = (corner for corner in corners if inside[0] <= corner[1] <= inside[1] and not any(
            corner[0] < x1 + pixel and x0 < corner[0] + size.x + pixel and corner[1] < y1 and y0 < corner[1] + line
            for x0, y0, x1, y1 in boxes))
        place = next(free, (left, max(corners[0][1], canvas.y)))
        draw.add_text(ImVec2(floor(place[0]), floor(place[1])), theme.packed(theme.colours().text), "Stop")


def draw_stop_handles(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, lit: bool) -> None:
    """A ring on either edge of the opening."""
    if sketch.stop_radius is None:
        return
    colour, pixel = theme.colours(), theme.scale()
    for sign in (1.0, -1.0):
        point = canvas.at(*sketch.on_stop(sign * sketch.stop_radius, sketch.stop_radius))
        point = ImVec2(floor(point.x), point.y)
        draw.add_circle_filled(point, 3.5 * pixel, theme.packed(colour.amber if lit else colour.well))
        draw.add_circle(point, 3.5 * pixel, theme.packed(colour.amber), 0, 1.6 * pixel)


def draw_film(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, lit: bool, movable: bool,
              centred: bool = True, switch: float = 0.0) -> None:
    """The film with its handle below, and the names of the fields next to their images.

    centred: False for a film that is drawn elsewhere, where the plane of focus and film distance is only faint.
    switch: width (pixels) of the switch in the upper right corner, 0 for none, below which the names begin.
    """
    colour, pixel = theme.colours(), theme.scale()
    x = floor(canvas.at(sketch.film_z, 0.0).x)
    top, bottom = canvas.at(0.0, sketch.film_height).y, canvas.at(0.0, -sketch.film_height).y
    draw.add_rect_filled(ImVec2(x - pixel, top), ImVec2(x + 1.5 * pixel, bottom),
                         theme.packed(colour.strong, 1.0 if centred else 0.25))
    line = imgui.get_text_line_height()
    if movable:
        corner, size = film_handle(sketch, canvas)
        end = ImVec2(corner.x + size.x, corner.y + size.y)
        draw.add_rect_filled(corner, end, theme.packed(colour.amber_text if lit else colour.amber), 2.5 * pixel)
        for y in (0.38, 0.62):
            y = floor(corner.y + y * size.y)
            draw.add_line(ImVec2(corner.x + 3.0 * pixel, y + 0.5), ImVec2(end.x - 3.0 * pixel, y + 0.5),
                          theme.packed(colour.well), pixel)
    # Names from the top down, moved apart if they would touch; left of the film if there is no room at its right
    names = field_names(sketch, canvas.width < theme.em(NARROW))
    widest = max(imgui.calc_text_size(name).x for name in names)
    before = x + widest + BESIDE * pixel > canvas.x + canvas.width
    free = canvas.y - line
    if switch and canvas.width - switch < x + (0.0 if before else widest) + BESIDE * pixel - canvas.x:
        free = canvas.y + theme.em(SWITCHES[1])

    def named(y: float, name: str, tint: theme.Colour) -> None:
        if not before:
            draw.add_text(ImVec2(x + BESIDE * pixel, floor(y)), theme.packed(tint), name)
            return
        left = x - 9.0 * pixel - imgui.calc_text_size(name).x
        draw.add_rect_filled(ImVec2(left - 3.0 * pixel, floor(y) + pixel), ImVec2(x - 5.0 * pixel, floor(y) + line),
                             theme.packed(colour.well, 0.8), 2.0 * pixel)
        draw.add_text(ImVec2(floor(left), floor(y)), theme.packed(tint), name)

    for fan, name, (_, text) in sorted(zip(sketch.fans, names, field_colours(), strict=True),
                                       key=lambda pair: -pair[0].height):
        y = canvas.at(0.0, fan.height).y - (0.5 * line if fan.height else 1.0 * line)
        y = max(y, free)
        free = y + line
        named(y, name, text)
    if movable:
        named(max(corner.y + 0.5 * (size.y - line), free), "Film", colour.amber_text)


def field_names(sketch: Sketch, short: bool = False) -> list[str]:
    """The names of the fields, in the order of their fans; short: "full" and "0.7", for a narrow panel."""
    names = [fan.name.removesuffix(" field") if short else fan.name for fan in sketch.fans]
    return [f"{name}, dark" if fan.dark else name for name, fan in zip(names, sketch.fans, strict=True)]


def film_handle(sketch: Sketch, canvas: Canvas) -> tuple[ImVec2, ImVec2]:
    """Corner and size of the film's handle: at the film's lower end, or at the panel's edge if that lies outside."""
    pixel = theme.scale()
    size = ImVec2(9.0 * pixel, 12.0 * pixel)
    x = floor(canvas.at(sketch.film_z, 0.0).x)
    y = min(canvas.at(0.0, -sketch.film_height).y, canvas.y + canvas.height - size.y - pixel)
    return ImVec2(x - floor(0.5 * size.x), floor(max(y - 2.0 * pixel, canvas.y))), size


def draw_region(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, low: float, high: float, height: float) -> None:
    """The extent of the exit-pupil region of a film point on the rear plane, with its cone of light."""
    colour, pixel = theme.packed(theme.colours().strong), theme.scale()
    film, faint = canvas.at(sketch.film_z, height), theme.packed(theme.colours().text, 0.5)
    ends = [canvas.at(sketch.rear_z, y) for y in (high, low)]
    for end in ends:
        dashed(draw, end, film, faint)
        draw.add_line(ImVec2(end.x - 4.0 * pixel, end.y), ImVec2(end.x + 4.0 * pixel, end.y), colour, 1.5 * pixel)
    draw.add_line(*ends, colour, 1.5 * pixel)


def dashed(draw: imgui.ImDrawList, a: ImVec2, b: ImVec2, colour: int) -> None:
    """A dashed line."""
    pixel = theme.scale()
    length = max(float(np.hypot(b.x - a.x, b.y - a.y)), 1e-6)
    count = min(int(length / (7.0 * pixel)), 400)
    for k in range(count):
        s, t = 7.0 * pixel * k / length, (7.0 * k + 4.0) * pixel / length
        draw.add_line(ImVec2(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)),
                      ImVec2(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)), colour, pixel)


def draw_scale_bar(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas,
                   signs: list[tuple[float, float, float]]) -> None:
    """A round length in the lower right corner, or left of the film if that is there; the lower left, if signs are.

    signs: left and right end and lower edge of the row of signs (pixels), each.
    """
    colour, pixel = theme.colours(), theme.scale()
    length = round_length(max(60.0 * pixel / canvas.view.scale, 1e-9))
    width = length * canvas.view.scale
    text = f"{significant(length)} mm" if length < 1000.0 else f"{significant(length / 1000.0)} m"
    right, y = floor(canvas.x + canvas.width - 14.0 * pixel), floor(canvas.y + canvas.height - 9.0 * pixel)
    film, lowest = canvas.at(sketch.film_z, -sketch.film_height)
    name = imgui.calc_text_size("Film").x + 16.0 * pixel
    if lowest > y - 3.0 * imgui.get_text_line_height() and film - name < right and film + name > right - width:
        right = floor(film - name - 6.0 * pixel)
    size = imgui.calc_text_size(text)
    half = 0.5 * (max(width, size.x) - width) + 4.0 * pixel
    if any(low > y - size.y and right_end > right - width - half and left < right + half
           for left, right_end, low in signs):
        right = floor(canvas.x + 14.0 * pixel + width)
    line = theme.packed(colour.dim)
    draw.add_line(ImVec2(right - width, y + 0.5), ImVec2(right, y + 0.5), line, pixel)
    for x in (right - width, right):
        draw.add_line(ImVec2(x, y - 3.0 * pixel), ImVec2(x, y + 3.5 * pixel), line, pixel)
    draw.add_text(ImVec2(floor(right - 0.5 * (width + size.x)), floor(y - size.y - 2.0 * pixel)), line, text)
