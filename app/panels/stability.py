"""The panel *Stability*: error curves of the methods of a sweep, and where each method fails.

Errors are on the vertical axis. Both axes are logarithmic unless the sweep is linear; the hard end of the sweep is on
the right. Single precision is dashed; methods that the program relies on are thick; a cross marks a failure.
"""

import math
from dataclasses import dataclass

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, picked
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, dashed_line, pieces, text
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.studies.stability.plots import FAMILIES, method_name, method_names, plotted_errors
from lensbench.app.studies.stability.sweep import Curve, Sweep, quantity_text
from lensbench.app.workers.study_workers import Key, StabilityWorker
from lensbench.core.text import significant

DASH = (5.0, 3.0)               # dashes and gaps of single-precision curves, pixels
LIST = 25.0                     # em: width of the column beside the plot
LAST_POWER = 300.0              # of ten, on an axis: a number holds it


@dataclass
class StabilityState:
    """State of the panel; not part of the settings."""

    family: str = next(iter(FAMILIES))
    title: str = next(iter(next(iter(FAMILIES.values()))))
    method: str = ""            # selected in the list; the plot shows where it fails
    fitted_to: tuple = ()


def stability_panel(worker: StabilityWorker, state: StabilityState) -> None:
    """Draw the selected sweep, and request its measurement if it is not known yet."""
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return
    theme.small()
    gap = theme.em(0.6)
    beside = size.x > theme.em(31.0)
    column = min(theme.em(LIST), 0.5 * size.x) if beside else size.x
    plot_size = ImVec2(size.x - column - gap, size.y) if beside else ImVec2(size.x, 0.5 * size.y)
    corner = imgui.get_cursor_screen_pos()
    left = corner.x + (plot_size.x + gap if beside else 0.0)
    imgui.set_cursor_screen_pos(ImVec2(left, corner.y + (0.0 if beside else plot_size.y + gap)))
    key = _choice(column, state)
    worker.want(key)
    sweep = worker.found.get(key)
    imgui.set_cursor_screen_pos(ImVec2(left, imgui.get_cursor_screen_pos().y))
    if imgui.begin_child("Stability list", ImVec2(column, 0.0)):
        if sweep is None:
            _waiting(worker, key)
        else:
            _methods(sweep, state)
    imgui.end_child()
    if sweep is not None:
        imgui.set_cursor_screen_pos(corner)
        _plot(sweep, plot_size, state)
    imgui.pop_font()


def _choice(room: float, state: StabilityState) -> Key:
    """Combo boxes for the family and the sweep, `room` pixels wide together; the key of the selected sweep."""
    gap, before = imgui.get_style().item_spacing.x, state.title
    family = 0.32 * room
    state.family = picked("Family", state.family, {name: name for name in FAMILIES}, "A family of methods", family)
    if state.title not in FAMILIES[state.family]:
        state.title = next(iter(FAMILIES[state.family]))
    imgui.same_line()
    state.title = picked("Sweep", state.title, {title: title for title in FAMILIES[state.family]},
                         "The quantity that makes the problem harder", room - family - gap)
    if state.title != before:
        state.method = ""
    return state.family, state.title


def _waiting(worker: StabilityWorker, key: Key) -> None:
    """Progress with Cancel, an error, or a button that measures a cancelled sweep."""
    if key in worker.problems:
        paragraph(worker.problems[key])
    elif key == worker.declined:
        if imgui.button("Measure"):
            worker.again(key)
        imgui.set_item_tooltip("Measure this sweep, which was cancelled")
    elif worker.task is not None:
        task_progress(worker.task)


def tints(sweep: Sweep) -> dict[str, theme.Colour]:
    """Colour of each method, by its name without the precision."""
    return dict(zip(method_names(sweep), theme.tints(), strict=False))


def _methods(sweep: Sweep, state: StabilityState) -> None:
    """One row a method: line style, name and where it fails; a click selects the method."""
    colour, tinted, draw = theme.colours(), tints(sweep), imgui.get_window_draw_list()
    pixel, line = theme.scale(), imgui.get_text_line_height_with_spacing()
    for curve in sweep.curves:
        at, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
        if imgui.selectable(f"###{curve.name}", curve.name == state.method, 0, ImVec2(0.0, line - 5.0 * pixel))[0]:
            state.method = "" if curve.name == state.method else curve.name
        if imgui.is_item_hovered():
            _method_tooltip(sweep, curve)
        middle = at.y + 0.5 * imgui.get_text_line_height()
        _stroke(draw, np.array([[at.x, middle], [at.x + 22.0 * pixel, middle]]), curve, tinted[method_name(curve)])
        safe, fails, _ = sweep.words(curve)
        word = "holds" if fails == "never" else f"fails at {fails}"
        wide = imgui.calc_text_size(word).x
        text(draw, ImVec2(at.x + room, at.y), colour.dim if fails == "never" else colour.text, word, right=True)
        text(draw, ImVec2(at.x + 28.0 * pixel, at.y), colour.strong if curve.own else colour.dim,
             theme.shortened(curve.name, room - wide - 36.0 * pixel))
    imgui.spacing()
    paragraph(sweep.note)


def _method_tooltip(sweep: Sweep, curve: Curve) -> None:
    """Tooltip: how far a method is safe, and what it returns beyond."""
    verdict = sweep.verdict(curve)
    safe, fails, returns = sweep.words(curve)
    if not imgui.begin_tooltip():
        return
    imgui.text_unformatted(curve.name + (": the program relies on it" if curve.own else ": for comparison"))
    worst = quantity_text(verdict.worst, sweep.measure_unit)
    imgui.text_disabled(f"safe up to {safe}; largest error up to there {worst}")
    if fails != "never":
        imgui.text_unformatted(f"fails at {fails}: {returns}")
        if curve.own and curve.switch:
            imgui.text_disabled(f"there: {curve.switch}")
    elif returns:
        imgui.text_disabled(f"result where no answer exists: {returns}")
    imgui.end_tooltip()


def _stroke(draw: imgui.ImDrawList, points: np.ndarray, curve: Curve, tint: theme.Colour, strong: bool = False) -> None:
    pixel = theme.scale()
    weight = (2.0 if curve.own else 1.0) + (1.0 if strong else 0.0)
    on, off = (DASH[0] * pixel, DASH[1] * pixel) if curve.name.endswith("float32") else (0.0, 0.0)
    for piece in pieces(points, on, off):
        draw.add_polyline(piece, theme.packed(tint), weight * pixel, imgui.ImDrawFlags_.none)


# The plot


def _across(sweep: Sweep, values) -> np.ndarray:
    """Positions of values on the horizontal axis of the plot, the hard end on the right."""
    place = np.asarray(values, float) if sweep.linear else np.log10(values)
    return place if sweep.rising else -place


def _plot(sweep: Sweep, size: ImVec2, state: StabilityState) -> None:
    x, y = implot.ImAxis_.x1, implot.ImAxis_.y1
    shown = [np.log10(plotted_errors(sweep, curve)) for curve in sweep.curves]
    ends = np.concatenate([*shown, [math.log10(sweep.limit)]])
    low, high = float(np.nanmin(ends)), float(np.nanmax(ends))
    places = _across(sweep, sweep.values)
    margin = 0.03 * (places[-1] - places[0])
    if not implot.begin_plot(f"Stability plot###{state.family} {sweep.title}", size, PLOT_FLAGS):
        return
    implot.setup_axis(x, f"{sweep.axis} ({sweep.unit})" if sweep.unit else sweep.axis, AXIS_FLAGS)
    implot.setup_axis(y, f"{sweep.measure} off by ({sweep.measure_unit})" if sweep.measure_unit
                      else f"{sweep.measure} off by", AXIS_FLAGS)
    once = implot.Cond_.once if state.fitted_to == (size.x, size.y) else implot.Cond_.always
    state.fitted_to = (size.x, size.y)
    implot.setup_axis_limits(x, float(places[0] - margin), float(places[-1] + margin), once)
    implot.setup_axis_limits(y, low - 0.4, high + 0.4, once)
    _ticks(x, float(places[0]), float(places[-1]), size.x - theme.em(5.0), theme.em(3.4), sweep)
    _ticks(y, low, high, size.y - theme.em(3.0), theme.em(1.5))
    plot, draw = PlotMap.current(log=False), implot.get_plot_draw_list()
    implot.push_plot_clip_rect()
    _draw(sweep, shown, places, plot, draw, state.method)
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered():
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            state.fitted_to = ()
        _tell_at(sweep, places, plot)
    implot.end_plot()


def _ticks(axis: int, first: float, last: float, pixels: float, room: float, sweep: Sweep | None = None) -> None:
    """Whole powers of ten, as many as have room; of a linear sweep whole steps of 1, 2 or 5."""
    linear, falling = sweep is not None and sweep.linear, sweep is not None and not sweep.rising
    least = (last - first) * room / max(pixels, 1.0)
    step = max(1.0, math.ceil(least))
    if linear:
        power = 10.0 ** math.floor(math.log10(least))
        step = next(power * m for m in (1.0, 2.0, 5.0, 10.0) if power * m >= least)
    begin = math.floor(first / step) - 2
    marks = [step * k for k in range(begin, math.ceil(last / step) + 3) if linear or abs(step * k) < LAST_POWER]
    values = [-mark if falling else mark for mark in marks]
    labels = [significant(value) if linear else quantity_text(10.0**value, "") for value in values]
    implot.setup_axis_ticks(axis, marks, labels, False)


def _draw(sweep: Sweep, shown: list[np.ndarray], places: np.ndarray, plot: PlotMap, draw: imgui.ImDrawList,
          method: str) -> None:
    colour, tinted, pixel = theme.colours(), tints(sweep), theme.scale()
    level = plot.at(0.0, math.log10(sweep.limit)).y
    dashed_line(draw, ImVec2(plot.left, level), ImVec2(plot.right, level), theme.packed(colour.dim), 1.5, 3.0)
    limit = f"limit {quantity_text(sweep.limit, sweep.measure_unit)}"
    text(draw, ImVec2(plot.left + 4.0 * pixel, level - imgui.get_text_line_height() - 1.0), colour.dim, limit,
         plate=True)
    for curve, errors in zip(sweep.curves, shown, strict=True):
        _stroke(draw, plot.pixels(places, errors), curve, tinted[method_name(curve)], curve.name == method)
    for curve, errors in zip(sweep.curves, shown, strict=True):
        at = sweep.failure(curve)
        if at is None:
            continue
        point = plot.at(float(places[at]), float(errors[at]) if np.isfinite(errors[at]) else math.log10(sweep.limit))
        arm, tint = 4.5 * pixel, theme.packed(tinted[method_name(curve)])
        for up in (-1.0, 1.0):
            draw.add_line(ImVec2(point.x - arm, point.y - up * arm), ImVec2(point.x + arm, point.y + up * arm), tint,
                          2.0 * pixel)
        if curve.name == method:
            _write(sweep, curve, point, plot, draw)


def _write(sweep: Sweep, curve: Curve, point: ImVec2, plot: PlotMap, draw: imgui.ImDrawList) -> None:
    """At the point of failure of the chosen method: what is returned there."""
    colour, pixel = theme.colours(), theme.scale()
    dashed_line(draw, ImVec2(point.x, plot.top), ImVec2(point.x, plot.bottom), theme.packed(colour.faint))
    _, fails, returns = sweep.words(curve)
    words = theme.shortened(f"{fails}: {returns}", plot.right - plot.left - 8.0 * pixel)
    wide = imgui.calc_text_size(words).x
    x = min(max(point.x + 8.0 * pixel, plot.left + 4.0 * pixel), plot.right - wide - 4.0 * pixel)
    text(draw, ImVec2(x, plot.top + 3.0 * pixel), colour.strong, words, plate=True)


def _tell_at(sweep: Sweep, places: np.ndarray, plot: PlotMap) -> None:
    """The errors of all methods at the value nearest to the mouse."""
    at = int(np.argmin(np.abs(places - plot.x_at(imgui.get_mouse_pos().x))))
    if not imgui.begin_tooltip():
        return
    imgui.text_unformatted(f"{sweep.axis} {quantity_text(float(sweep.values[at]), sweep.unit)}")
    for curve, right in ((curve, sweep.right(curve)[at]) for curve in sweep.curves):
        word = curve.returned[at] or quantity_text(float(curve.errors[at]), sweep.measure_unit)
        (imgui.text_disabled if right else imgui.text_unformatted)(f"{curve.name}: {word}")
    imgui.end_tooltip()
