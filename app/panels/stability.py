"""The panel *Stability*: error curves of the methods of a sweep, and where each method fails.

Errors are on the vertical axis. Both axes are logarithmic unless the sweep is linear; the hard end of the sweep is on
the right. Single precision is dashed; methods that the program relies on are thick; a cross marks a failure.
"""

from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, picked
from lensbench.app.drawing.plot_axes import TINY, pieces, text
from lensbench.app.drawing.plot_layers import colour_of
from lensbench.app.drawing.plot_painter import Drawn, draw_plot
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.plots.plot import DASHED, DOTTED, SOLID, Axis, Curve, Plot, Points
from lensbench.app.studies.stability.plots import FAMILIES, method_name, method_names, plotted_errors
from lensbench.app.studies.stability.sweep import Curve as SweepCurve, Sweep, quantity_text
from lensbench.app.workers.study_workers import Key, StabilityWorker

LIST = 25.0                     # em: width of the column next to the plot
LARGEST = 1e290                 # end of an axis: a number holds also what the wheel shows beyond
MARGIN = 0.03                   # of the horizontal axis, beyond the values


@dataclass
class StabilityState:
    """State of the panel; not part of the settings."""

    family: str = next(iter(FAMILIES))
    title: str = next(iter(next(iter(FAMILIES.values()))))
    method: str = ""            # selected in the list; the plot shows where it fails
    drawn: Drawn = field(default_factory=Drawn)


def stability_panel(worker: StabilityWorker, state: StabilityState) -> None:
    """Draw the selected sweep, and request its measurement if it is not known yet."""
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return
    theme.small()
    gap = theme.em(0.6)
    wide = size.x > theme.em(31.0)
    column = min(theme.em(LIST), 0.5 * size.x) if wide else size.x
    plot_size = ImVec2(size.x - column - gap, size.y) if wide else ImVec2(size.x, 0.5 * size.y)
    corner = imgui.get_cursor_screen_pos()
    left = corner.x + (plot_size.x + gap if wide else 0.0)
    imgui.set_cursor_screen_pos(ImVec2(left, corner.y + (0.0 if wide else plot_size.y + gap)))
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
        draw_plot("Stability plot", sweep_plot(sweep, state.method), plot_size, state.drawn)
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


def _tints(sweep: Sweep) -> dict[str, str]:
    """Tint of each method, by its name without the precision."""
    return {name: f"chart{i}" for i, name in enumerate(method_names(sweep))}


def _methods(sweep: Sweep, state: StabilityState) -> None:
    """One row a method: line style, name and where it fails; a click selects the method."""
    colour, tinted, draw = theme.colours(), _tints(sweep), imgui.get_window_draw_list()
    pixel, line = theme.scale(), imgui.get_text_line_height_with_spacing()
    for curve in sweep.curves:
        corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
        if imgui.selectable(f"###{curve.name}", curve.name == state.method, 0, ImVec2(0.0, line - 5.0 * pixel))[0]:
            state.method = "" if curve.name == state.method else curve.name
        if imgui.is_item_hovered():
            _method_tooltip(sweep, curve)
        middle = corner.y + 0.5 * imgui.get_text_line_height()
        for piece in pieces(np.array([[corner.x, middle], [corner.x + 22.0 * pixel, middle]]),
                            *(length * pixel for length in _dash(curve))):
            draw.add_polyline(piece, theme.packed(colour_of(tinted[method_name(curve)])),
                              (2.0 if curve.own else 1.0) * pixel, imgui.ImDrawFlags_.none)
        safe, fails, _ = sweep.words(curve)
        word = "holds" if fails == "never" else f"fails at {fails}"
        wide = imgui.calc_text_size(word).x
        text(draw, ImVec2(corner.x + room, corner.y), colour.dim if fails == "never" else colour.text, word, right=True)
        text(draw, ImVec2(corner.x + 28.0 * pixel, corner.y), colour.strong if curve.own else colour.dim,
             theme.shortened(curve.name, room - wide - 36.0 * pixel))
    imgui.spacing()
    paragraph(sweep.note)


def _method_tooltip(sweep: Sweep, curve: SweepCurve) -> None:
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


def _dash(curve: SweepCurve) -> tuple[float, float]:
    return DASHED if curve.name.endswith("float32") else SOLID


# The plot


@lru_cache(maxsize=4)
def sweep_plot(sweep: Sweep, method: str) -> Plot:
    """The errors of all methods, the hard end on the right. method: the one that shows where it fails; "" for none."""
    shown = [plotted_errors(sweep, curve) for curve in sweep.curves]
    errors = np.concatenate([*shown, [sweep.limit]])
    low, high = 0.4 * float(np.nanmin(errors)), min(2.5 * float(np.nanmax(errors)), LARGEST)
    tints = _tints(sweep)
    layers: list = [Curve.straight(_ends(sweep), (sweep.limit,) * 2, dash=DOTTED,
                                   tag=f"limit {quantity_text(sweep.limit, sweep.measure_unit)}")]
    for curve, y in zip(sweep.curves, shown, strict=True):
        layers.append(Curve(curve.name, sweep.values, y, tints[method_name(curve)], _dash(curve),
                            (2.0 if curve.own else 1.0) + (1.0 if curve.name == method else 0.0)))
    for curve, y in zip(sweep.curves, shown, strict=True):
        failure = sweep.failure(curve)
        if failure is not None:
            x = float(sweep.values[failure])
            layers.append(Points("", np.array([x]), np.array([y[failure] if np.isfinite(y[failure]) else sweep.limit]),
                                 tints[method_name(curve)], "cross", size=4.5))
            if curve.name == method:                    # what is returned there
                _, fails, returns = sweep.words(curve)
                layers.append(Curve.straight((x, x), (low, high), "strong", DASHED, tag=f"{fails}: {returns}"))
    return Plot(Axis(_label(sweep.axis, sweep.unit), *_ends(sweep), not sweep.linear, falling=not sweep.rising),
                Axis(_label(f"{sweep.measure} off by", sweep.measure_unit), low, high, True), tuple(layers),
                words=partial(_words, sweep))


def _label(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _ends(sweep: Sweep) -> tuple[float, float]:
    """The ends of the horizontal axis, a little beyond the values."""
    low, high = float(sweep.values.min()), float(sweep.values.max())
    if sweep.linear:
        return low - MARGIN * (high - low), high + MARGIN * (high - low)
    return low * (low / high) ** MARGIN, high * (high / low) ** MARGIN


def _words(sweep: Sweep, x: float, _: float) -> str:
    """The errors of all methods at the value nearest to a place."""
    away = sweep.values - x if sweep.linear else np.log(sweep.values / max(x, TINY))
    row = int(np.argmin(np.abs(away)))
    lines = [f"{sweep.axis} {quantity_text(float(sweep.values[row]), sweep.unit)}"]
    return "\n".join(lines + [f"{curve.name}   " + (
        curve.returned[row] or quantity_text(float(curve.errors[row]), sweep.measure_unit)) for curve in sweep.curves])
