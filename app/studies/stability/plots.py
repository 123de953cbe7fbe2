"""All families of stability sweeps, their plots and index, and known failures of other systems."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lensbench.app.drawing.sheet import COLOURS, DIM, FAINT, PAPER, look, plot, save, sheet
from lensbench.app.session.export import replacing
from lensbench.app.studies.stability import (
    closed_forms, focusing, intersection, models, orientation, pupils, refraction, sampling
)
from lensbench.app.studies.stability.sweep import Curve, Sweep, quantity_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class KnownFailure:
    """One known failure of another system.

    id: thread of a project, or the subject. fails: what goes wrong there. ours: what this program does; "" if the
    failure does not apply, for its `reason`. test: file and function under tests/ that shows it.
    """

    id: str
    fails: str
    ours: str = ""
    test: str = ""
    reason: str = ""


def known_failures() -> tuple[KnownFailure, ...]:
    """All collected failures."""
    text = files("lensbench.app.studies.stability").joinpath("known_failures.toml").read_text(encoding="utf-8")
    return tuple(KnownFailure(**row) for row in tomllib.loads(text)["failure"])


def table() -> list[str]:
    """The known failures as lines of a Markdown table."""
    rows = [(failure.id, failure.fails, failure.ours or f"does not apply: {failure.reason}",
             f"`{failure.test.partition('::')[0]}`" if failure.test else "") for failure in known_failures()]
    return ["| where | what fails there | here | test |", "|---|---|---|---|",
            *(f"| {' | '.join(row)} |" for row in rows)]


FAMILIES: dict[str, dict[str, Callable[[], Sweep]]] = {
    "Intersection": intersection.SWEEPS,
    "Refraction": refraction.SWEEPS,
    "Focusing": focusing.SWEEPS,
    "Pupil": pupils.SWEEPS,
    "Models": models.SWEEPS,
    "Sampling": sampling.SWEEPS,
    "Closed forms": closed_forms.SWEEPS,
    "Orientation": orientation.SWEEPS,
}


SIZE = (8.0, 4.2)                       # inches
INDEX, DOMAINS = "index.md", "models-domains"
TINTS = ("vermilion", "purple", "blue", "green", "olive", "sky", "black", "grey")


def colours(sweep: Sweep) -> dict[str, str]:
    """Colour of each method; single and double precision share one."""
    return dict(zip(method_names(sweep), (COLOURS[tint] for tint in TINTS), strict=False))


def method_names(sweep: Sweep) -> list[str]:
    """Names of the methods without their precision, each once."""
    return list(dict.fromkeys(method_name(curve) for curve in sweep.curves))


def method_name(curve: Curve) -> str:
    """Name of a method without its precision."""
    return curve.name.rpartition(", float")[0] or curve.name


def plotted_errors(sweep: Sweep, curve: Curve) -> np.ndarray:
    """Errors for a logarithmic axis: an exact result lies at the bottom."""
    return np.maximum(curve.errors, lowest_error(sweep))


def lowest_error(sweep: Sweep) -> float:
    """A value a little below all errors that are not zero, in the unit of the measure."""
    small = [curve.errors[curve.errors > 0.0].min(initial=sweep.limit) for curve in sweep.curves]
    return 0.5 * max(float(min(small)), 1e-18)


def file_name(family: str, sweep: Sweep, suffix: str) -> str:
    """Name of a plot file, such as intersection-radius-of-a-sphere.svg."""
    return "-".join(re.findall("[a-z0-9]+", f"{family} {sweep.title}".lower().replace("'", ""))) + suffix


def save_plot(sweep: Sweep, path: Path) -> None:
    """Write the error curves, the limit, and a cross where a method fails; ExportError where it cannot be written."""
    with look():
        figure = sheet(*SIZE)
        axes = figure.add_subplot()
        plot(axes, _axis(sweep.axis, sweep.unit), _axis(sweep.measure + " off by", sweep.measure_unit),
             sweep.title, log=(not sweep.linear, True))
        _draw(axes, sweep)
        figure.legend(loc="outside right upper", frameon=False, fontsize=8.0, labelcolor=DIM, handlelength=2.6)
        save(figure, path)


def _axis(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _draw(axes: "Axes", sweep: Sweep) -> None:
    from matplotlib.patheffects import withStroke

    tints = colours(sweep)
    for curve in sweep.curves:
        failure, y = sweep.failure(curve), plotted_errors(sweep, curve)
        safe, fails, returns = sweep.words(curve)
        label = curve.name + (f"\n   fails at {fails}" if failure is not None else "\n   holds")
        axes.plot(sweep.values, y, color=tints[method_name(curve)], linewidth=1.8 if curve.own else 1.0, label=label,
                  linestyle=(0, (4, 2)) if curve.name.endswith("float32") else "-")
        if failure is not None:
            level = y[failure] if np.isfinite(y[failure]) else sweep.limit
            axes.plot(sweep.values[failure], level, "x", color=tints[method_name(curve)], markersize=7.0,
                      markeredgewidth=1.8)
    axes.axhline(sweep.limit, color=FAINT, linewidth=1.0, linestyle=":")
    axes.annotate(f"limit {quantity_text(sweep.limit, sweep.measure_unit)}", (0.01, sweep.limit), (0, 3),
                  xycoords=("axes fraction", "data"), textcoords="offset points", color=DIM, fontsize=8.0,
                  path_effects=[withStroke(linewidth=3.0, foreground=PAPER)])
    if not sweep.rising:
        axes.invert_xaxis()


def save_index(sweeps: list[tuple[str, Sweep]], folder: Path, suffix: str, domains: str = "") -> None:
    """Write index.md: plot, table and note of each sweep, the maps of models, and the known failures."""
    lines = ["# Stability sweeps", "",
             "Written by `lensbench stability -o FOLDER`. Each sweep makes a problem harder from left to right. The "
             "curves show the worst error of each method at each value: dashed in single precision, thick (bold in the"
             " tables) if the program relies on the method. A cross marks the first value at which the error exceeds "
             "the limit, or at which the method gives no answer although one exists.", ""]
    family = ""
    for name, sweep in sweeps:
        if name != family:
            family = name
            lines += [f"## {family}", ""]
        lines += [f"### {sweep.title}", "", f"![{sweep.title}]({file_name(family, sweep, suffix)})", "", sweep.note,
                  f"Limit: {quantity_text(sweep.limit, sweep.measure_unit)}, {sweep.why}.", "",
                  "| method | safe up to | fails at | returns there |", "|---|---|---|---|"]
        for curve in sweep.curves:
            safe, fails, returns = sweep.words(curve)
            method = f"**{curve.name}**" if curve.own else curve.name
            switch = f"; {curve.switch}" if curve.own and curve.switch and fails != "never" else ""
            lines.append(f"| {method} | {safe} | {fails} | {returns}{switch} |")
        lines.append("")
    if domains:
        lines += ["## Domains of the models", "",
                  "The simplest model that is accurate enough, for each lens over its field and stops: the model that "
                  "Auto chooses there.", "", f"![domains of the models]({domains})", ""]
    lines += ["## Known failures of other systems", "", *table(), ""]
    with replacing(folder / INDEX) as partial_file:
        partial_file.write_text("\n".join(lines), encoding="utf-8")
