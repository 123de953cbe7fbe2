"""The panel *Models*: what each model of the present lens costs a ray, and how far it is from the traced lens.

Errors in pixels of the film as it is set, or in stops; costs in ns a ray, measured on this machine. A click on a
model takes the picture with it.
"""

import math
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, dashed_line, log_ticks, text
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.studies.charts.curves import Chart, Mark
from lensbench.app.workers.study_workers import ChartWorker, charted
from lensbench.core.text import fixed, significant

TOLERANCE = {"rms": 0.5, "worst": 0.5, "light": 0.05}       # of the automatic model: pixels, stops
ERRORS = {"rms": ("RMS", "rms, px", "Error, rms (px)"), "worst": ("Worst ray", "worst, px", "Error, worst ray (px)"),
          "light": ("Light", "light worst, stops", "Light, worst (stops)")}
ERROR_TIPS = {"rms": "Root mean square over the whole film and pupil, in pixels",
              "worst": "Of the worst ray, in pixels",
              "light": "Brightness against the axis, in stops, where it is farthest off"}
FLOOR = 1e-5


@dataclass
class ModelsState:
    """Choice of the plotted error; not part of the settings."""

    shown: str = "rms"          # a key of ERRORS


def models_panel(settings: Settings, worker: ChartWorker, state: ModelsState,
                 chosen: tuple[str, int] | None = None) -> Settings:
    """Draw the chart; return the settings, with the model that was clicked.

    chosen: the automatic model's choice.
    """
    if not settings.has_lens:
        paragraph("This camera has no lens. Choose one with a lens in the left column to chart its models.")
        return settings
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return settings
    worker.want(settings)
    state.shown = toggles("Error", {key: names[0] for key, names in ERRORS.items()}, state.shown, ERROR_TIPS)
    _tools(settings, worker)
    chart = worker.chart
    if worker.task is not None:
        task_progress(worker.task)
    if chart is None:
        if worker.problem and worker.of == charted(settings):
            paragraph(worker.problem)
        elif worker.task is None:
            paragraph("Leave the settings unchanged for a moment, or press the arrow above: the chart then shows each "
                      "model of this lens by its cost and its error.")
        return settings
    return _plotted(settings, chart, state.shown, chosen, worker.of == charted(settings))


def _tools(settings: Settings, worker: ChartWorker) -> None:
    """At the right of the row: measure again."""
    width = theme.em(1.75)
    imgui.same_line(imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x - width)
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
    if imgui.button(icons_fontawesome_6.ICON_FA_ROTATE_RIGHT + "###Measure again", ImVec2(width, 0.0)):
        worker.again(charted(settings))
    imgui.pop_style_color()
    imgui.set_item_tooltip("Measure again")


# The plot


def _plotted(settings: Settings, chart: Chart, shown: str, chosen: tuple[str, int] | None, fresh: bool) -> Settings:
    """The plot, its marks to click."""
    _, figure, label = ERRORS[shown]
    marks = [replace(mark, error=mark.figures[figure]) for mark in chart.marks
             if figure in mark.figures and math.isfinite(mark.figures[figure])]
    refused = [mark for mark in chart.marks if mark.why]
    theme.small()
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    below = imgui.get_text_line_height_with_spacing() if refused else 0.0
    plot = None
    if room.y - below > 40.0 and implot.begin_plot("Models plot", ImVec2(room.x, room.y - below), PLOT_FLAGS):
        _set_axes(room, marks, label)
        plot = PlotMap.current(log=True)
        implot.push_plot_clip_rect()
        places = _draw(plot, replace(chart, marks=tuple(marks)), TOLERANCE[shown], _present(settings, chosen),
                       1.0 if fresh else 0.45)
        implot.pop_plot_clip_rect()
        implot.end_plot()
    if refused and below:
        imgui.text_disabled(f"{len(refused)} not possible here")
        imgui.set_item_tooltip("\n".join(f"{mark.name}: {mark.why}" for mark in refused))
    imgui.pop_font()
    if plot is not None:
        for mark, boxes in places:
            settings = _clicked(settings, mark, boxes)
        imgui.set_cursor_screen_pos(corner)
        imgui.dummy(room)
    return settings


def _present(settings: Settings, chosen: tuple[str, int] | None) -> str:
    """The name in the chart of the model that the picture is taken with."""
    model, degree = settings.lens_model, settings.degree
    if settings.is_automatic:
        if chosen is None:
            return ""
        model, degree = chosen
    return {"trace": "trace, float32", "polynomial": f"degree {degree}", "thin": "thin lens",
            "thick": "thick lens"}.get(model, model)


def _model(mark: Mark) -> tuple[str, int] | None:
    """The model and degree of a mark that a picture can be taken with."""
    if mark.kind not in LENS_MODELS or mark.name == "trace, float64" or mark.why:
        return None
    return mark.kind, int(mark.name.split()[-1]) if mark.kind == "polynomial" else 0


def _set_axes(room: ImVec2, marks: list[Mark], label: str) -> None:
    roomy = room.x > theme.em(13) and room.y > theme.em(10)
    costs = [mark.cost for mark in marks] or [1.0]
    errors = [max(mark.error, FLOOR) for mark in marks] or [1.0]
    ends = ((0.6 * min(costs), 2.2 * max(costs)), (0.2 * FLOOR, 4.0 * max(1.0, *errors)))
    line = imgui.get_text_line_height()
    for axis, (low, high), name, length, space in (
            (implot.ImAxis_.x1, ends[0], "Cost (ns a ray)", 0.85 * room.x, 2.0 * line),
            (implot.ImAxis_.y1, ends[1], label, 0.8 * room.y, 1.6 * line)):
        implot.setup_axis(axis, name if roomy else None, AXIS_FLAGS | implot.AxisFlags_.lock)
        implot.setup_axis_scale(axis, implot.Scale_.log10)
        implot.setup_axis_limits(axis, low, high, implot.Cond_.always)
        values = [value for value in log_ticks(low, high, length, space)[0] if 0.99 * FLOOR < value < high]
        labels = [fixed(value, 5).rstrip("0").rstrip(".") for value in values]
        if axis == implot.ImAxis_.x1 and values and imgui.calc_text_size(labels[-1]).x > \
                2.0 * length * math.log(high / values[-1]) / math.log(high / low):
            values.pop()                                        # its label would be cut off at the end
        implot.setup_axis_ticks(axis, values, labels[:len(values)], False)


def _draw(plot: PlotMap, chart: Chart, tolerance: float, present: str,
          alpha: float) -> list[tuple[Mark, list[tuple[ImVec2, ImVec2]]]]:
    """Front, tolerance, marks and names; each mark with the boxes that a click on it may hit."""
    colour, draw, pixel = theme.colours(), implot.get_plot_draw_list(), theme.scale()
    y = plot.at(1.0, tolerance).y
    dashed_line(draw, ImVec2(plot.left, y), ImVec2(plot.right, y), theme.packed(colour.dim, 0.8))
    ahead = [plot.at(mark.cost, max(mark.error, FLOOR)) for mark in chart.front]
    draw.add_polyline(ahead, theme.packed(colour.faint, 0.6 * alpha), 3.0 * pixel, imgui.ImDrawFlags_.none)
    at = {mark.name: plot.at(mark.cost, max(mark.error, FLOOR)) for mark in chart.marks}
    half = 7.0 * pixel
    taken = [(p.x - half, p.y - half, p.x + half, p.y + half) for p in at.values()]
    found = []
    for mark in chart.marks:
        place, tint = at[mark.name], theme.packed(_tint(mark), alpha)
        _shape(draw, mark, place, 4.5 * pixel, tint)
        if mark.name == present:
            draw.add_circle(place, 8.5 * pixel, theme.packed(colour.strong), 0, 1.6 * pixel)
        boxes = [(ImVec2(place.x - half, place.y - half), ImVec2(place.x + half, place.y + half))]
        corner = _free(plot, place, mark.name, taken)
        if corner is not None:
            extent = imgui.calc_text_size(mark.name)
            text(draw, corner, colour.strong if mark.name == present else _tint(mark), mark.name, plate=True)
            boxes.append((corner, ImVec2(corner.x + extent.x, corner.y + extent.y)))
            taken.append((corner.x, corner.y, corner.x + extent.x, corner.y + extent.y))
        found.append((mark, boxes))
    return found


def _tint(mark: Mark) -> theme.Colour:
    """The colour of a family: ideal lenses, polynomials, traces, and what serves for comparison."""
    colour = theme.colours()
    return {"polynomial": colour.field2_text, "trace": colour.field1_text, "table": colour.dim,
            "scalar": colour.dim}.get(mark.kind, colour.field0_text) if not mark.why else colour.faint


def _shape(draw: imgui.ImDrawList, mark: Mark, at: ImVec2, size: float, tint: int) -> None:
    """Circle, triangle, square, diamond or hexagon; a cross for what serves for comparison."""
    if mark.kind in ("table", "scalar"):
        turn = 0.0 if mark.kind == "scalar" else 0.25 * math.pi
        for angle in (turn, turn + 0.5 * math.pi):
            dx, dy = size * math.cos(angle), size * math.sin(angle)
            draw.add_line(ImVec2(at.x - dx, at.y - dy), ImVec2(at.x + dx, at.y + dy), tint, 2.0 * theme.scale())
        return
    sides, turn = {"pinhole": (0, 0.0), "thin": (3, -0.5 * math.pi), "thick": (4, 0.25 * math.pi),
                   "polynomial": (4, 0.0), "trace": (6, 0.0)}[mark.kind]
    if not sides:
        draw.add_circle_filled(at, 0.9 * size, tint)
        return
    corners = [ImVec2(at.x + 1.15 * size * math.cos(turn + 2.0 * math.pi * i / sides),
                      at.y + 1.15 * size * math.sin(turn + 2.0 * math.pi * i / sides)) for i in range(sides)]
    draw.add_convex_poly_filled(corners, tint)


def _free(plot: PlotMap, at: ImVec2, name: str, taken: list[tuple[float, float, float, float]]) -> ImVec2 | None:
    """The upper left corner for a name beside its mark, where it touches nothing."""
    width, height = imgui.calc_text_size(name)
    for reach in (9.0, 13.0, 18.0, 26.0):
        away = reach * theme.scale()
        for x, y in ((at.x + away, at.y - 0.5 * height), (at.x - away - width, at.y - 0.5 * height),
                     (at.x + 0.6 * away, at.y - away - 0.5 * height), (at.x + 0.6 * away, at.y + away - 0.5 * height),
                     (at.x - 0.6 * away - width, at.y - away - 0.5 * height),
                     (at.x - 0.6 * away - width, at.y + away - 0.5 * height),
                     (at.x - 0.5 * width, at.y - away - height), (at.x - 0.5 * width, at.y + away),
                     (plot.right - width, at.y - away - height), (plot.right - width, at.y + away)):
            inside = (x >= plot.left and x + width <= plot.right and y >= plot.top and y + height <= plot.bottom
                      and x <= at.x + away)             # not at the right border, away from its mark
            if inside and not any(x < x1 and x + width > x0 and y < y1 and y + height > y0 for x0, y0, x1, y1 in taken):
                return ImVec2(x, y)
    return None


def _clicked(settings: Settings, mark: Mark, boxes: list[tuple[ImVec2, ImVec2]]) -> Settings:
    """The settings with the model of a mark where it, or its name, was clicked; its figures under the mouse."""
    usable = _model(mark)
    for i, (low, high) in enumerate(boxes):
        imgui.set_cursor_screen_pos(low)
        pressed = imgui.invisible_button(f"{mark.name}###Model {mark.name}{' name' if i else ''}",
                                         ImVec2(max(high.x - low.x, 1.0), max(high.y - low.y, 1.0)))
        if imgui.is_item_hovered():
            imgui.set_mouse_cursor(imgui.MouseCursor_.hand if usable else imgui.MouseCursor_.arrow)
            imgui.set_tooltip(_mark_tooltip(mark, usable is not None))
        if pressed and usable is not None:
            model, degree = usable
            return replace(settings, lens_model=model, degree=degree or settings.degree)
    return settings


def _mark_tooltip(mark: Mark, usable: bool) -> str:
    figures = mark.figures
    lines = [mark.name, f"{fixed(figures['streamed, ns'], 2)} ns a ray; median run "
                        f"{fixed(figures['spread, %'], 0)} % slower"]
    if mark.kind == "scalar":
        lines.append("The reference for the errors of all other models")
    else:
        lines += [f"rms {_digits(figures['rms, px'])} px, 99 % within {_digits(figures['p99, px'])} px, "
                  f"worst {_digits(figures['worst, px'])} px",
                  f"light within {_digits(figures['light worst, stops'])} stops"]
    lines.append(mark.why or ("Click to render with this model" if usable else
                              "For comparison only: pictures cannot use it"))
    return "\n".join(lines)


def _digits(value: float) -> str:
    return significant(value, 3) if value >= FLOOR else "0.00001"
