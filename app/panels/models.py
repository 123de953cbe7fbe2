"""The panel *Models*: what each model of the current lens costs a ray, and how far it is from the traced lens.

Errors in pixels of the film as it is set, or in stops; costs in ns a ray, measured on this machine. A click on a
model takes the picture with it.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.plot_painter import Drawn, draw_plot, drawn_map
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.plots.plot import DASHED, Axis, Curve, Label, Plot, Points
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
FLOOR = 1e-5                    # pixels and stops: a smaller error counts as none
SHAPES = {"pinhole": "circle", "thin": "triangle", "thick": "square", "polynomial": "diamond", "trace": "hexagon",
          "table": "cross", "scalar": "plus"}
NAME = "Models"


@dataclass
class ModelsState:
    """Choice of the plotted error, and its drawing; not part of the settings."""

    shown: str = "rms"          # a key of ERRORS
    key: tuple[Any, ...] = ()   # what the plot is made of
    plot: Plot | None = None
    drawn: Drawn = field(default_factory=Drawn)


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
    return _plotted(settings, chart, chosen, worker.of == charted(settings), state)


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


def models_plot(chart: Chart, shown: str, current: str, fresh: bool) -> Plot:
    """Error over cost: the front, the tolerance, and each model as a mark with its name.

    shown: a key of ERRORS. current: the name of the model that the picture is taken with, which has a ring. fresh:
    whether the chart is of the settings in use.
    """
    label = ERRORS[shown][2]
    marks = _marks(chart, shown)
    x, y = np.array([mark.cost for mark in marks]), np.array([max(mark.error, FLOOR) for mark in marks])
    costs, top = x if marks else np.ones(1), 4.0 * max(1.0, *y)
    front = replace(chart, marks=tuple(marks)).front
    layers: list = [
        Curve.straight((1e-9, 1e9), (TOLERANCE[shown],) * 2, dash=DASHED),
        Curve.through("", np.array([(mark.cost, max(mark.error, FLOOR)) for mark in front]).reshape(-1, 2), "faint",
                      weight=2.0)]
    for mark, cost, error in zip(marks, x, y, strict=True):
        point = np.array([cost]), np.array([error])
        layers.append(Points("", *point, _tint(mark), SHAPES[mark.kind], ghost=not fresh, size=4.5))
        layers.append(Label(cost, error, mark.name, "strong" if mark.name == current else _tint(mark), free=True))
        if mark.name == current:
            layers.append(Points("", *point, "strong", "ring", size=8.5))
    return Plot(Axis("Cost (ns a ray)", 0.6 * float(costs.min()), 2.2 * float(costs.max()), log=True),
                Axis(label, 0.2 * FLOOR, top, log=True), tuple(layers))


def _marks(chart: Chart, shown: str) -> list[Mark]:
    """The marks with a value of this error (a key of ERRORS), which becomes their error."""
    column = ERRORS[shown][1]
    return [replace(mark, error=mark.figures[column]) for mark in chart.marks
            if math.isfinite(mark.figures.get(column, math.nan))]


def _plotted(settings: Settings, chart: Chart, chosen: tuple[str, int] | None, fresh: bool,
             state: ModelsState) -> Settings:
    """The plot, its marks to click; the settings with the model that was clicked."""
    key = chart, state.shown, _present(settings, chosen), fresh
    if state.plot is None or state.key != key:
        state.key, state.plot = key, models_plot(*key)
    refused = [mark for mark in chart.marks if mark.why]
    theme.small()
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    below = imgui.get_text_line_height_with_spacing() if refused else 0.0
    draw_plot(NAME, state.plot, ImVec2(room.x, room.y - below), state.drawn)
    if refused and below:
        imgui.text_disabled(f"{len(refused)} not possible here")
        imgui.set_item_tooltip("\n".join(f"{mark.name}: {mark.why}" for mark in refused))
    imgui.pop_font()
    shown = drawn_map(NAME, state.drawn)
    if shown is not None:
        half, names = 7.0 * theme.scale(), state.drawn.words[f"{NAME} 0 0"]
        for mark in _marks(chart, state.shown):
            point = shown.at(mark.cost, max(mark.error, FLOOR))
            boxes = [(point.x - half, point.y - half, point.x + half, point.y + half)]
            settings = _clicked(settings, mark, boxes + ([names[mark.name]] if mark.name in names else []))
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


def _tint(mark: Mark) -> str:
    """The tint of a family: ideal lenses, polynomials, traces, and what serves for comparison."""
    return "faint" if mark.why else {"polynomial": "field2_text", "trace": "field1_text", "table": "dim",
                                        "scalar": "dim"}.get(mark.kind, "field0_text")


def _clicked(settings: Settings, mark: Mark, boxes: list[tuple[float, float, float, float]]) -> Settings:
    """The settings with the model of a mark where it, or its name, was clicked; its numbers under the mouse.

    boxes: left, top, right and bottom of the mark, and of its name, in pixels.
    """
    usable = _model(mark)
    for i, (left, top, right, bottom) in enumerate(boxes):
        imgui.set_cursor_screen_pos(ImVec2(left, top))
        pressed = imgui.invisible_button(f"{mark.name}###Model {mark.name}{' name' if i else ''}",
                                         ImVec2(right - left, bottom - top))
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
