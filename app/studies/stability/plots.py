"""The atlas as files: one plot for each stress, and an index of them all."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lensbench.app.files.export import replacing
from lensbench.app.studies.plotting import COLOURS, DIM, FAINT, PAPER, look, plot, save, sheet
from lensbench.app.studies.stability.known_failures import table
from lensbench.app.studies.stability.sweep import Curve, Stress, said

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE = (8.0, 4.2)                       # inches
INDEX, DOMAINS = "index.md", "models-domains"
TINTS = ("vermilion", "purple", "blue", "green", "olive", "sky", "black", "grey")


def colours(stress: Stress) -> dict[str, str]:
    """The colour of each method: single and double precision share one."""
    return dict(zip(order(stress), (COLOURS[tint] for tint in TINTS), strict=False))


def order(stress: Stress) -> list[str]:
    """The methods without their precisions, each once."""
    return list(dict.fromkeys(base(curve) for curve in stress.curves))


def base(curve: Curve) -> str:
    """A method without its precision."""
    return curve.name.rpartition(", float")[0] or curve.name


def drawn(stress: Stress, curve: Curve) -> np.ndarray:
    """The errors as a logarithmic axis shows them: an exact answer at the bottom."""
    return np.maximum(curve.errors, floor(stress))


def floor(stress: Stress) -> float:
    """A little below all errors that are not zero (of the measure's unit)."""
    small = [curve.errors[curve.errors > 0.0].min(initial=stress.limit) for curve in stress.curves]
    return 0.5 * max(float(min(small)), 1e-18)


def file_name(family: str, stress: Stress, suffix: str) -> str:
    """Such as intersection-radius-of-a-sphere.svg."""
    return "-".join(re.findall("[a-z0-9]+", f"{family} {stress.title}".lower().replace("'", ""))) + suffix


def save_plot(stress: Stress, path: Path) -> None:
    """Curves of error, the limit, a cross where a method fails; ExportError where it cannot be written."""
    with look():
        figure = sheet(*SIZE)
        axes = figure.add_subplot()
        plot(axes, _axis(stress.axis, stress.unit), _axis(stress.measure + " off by", stress.measure_unit),
             stress.title, log=(not stress.linear, True))
        _draw(axes, stress)
        figure.legend(loc="outside right upper", frameon=False, fontsize=8.0, labelcolor=DIM, handlelength=2.6)
        save(figure, path)


def _axis(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _draw(axes: "Axes", stress: Stress) -> None:
    from matplotlib.patheffects import withStroke

    tints = colours(stress)
    for curve in stress.curves:
        at, y = stress.failure(curve), drawn(stress, curve)
        safe, fails, returns = stress.words(curve)
        label = curve.name + (f"\n   fails at {fails}" if at is not None else "\n   holds")
        axes.plot(stress.values, y, color=tints[base(curve)], linewidth=1.8 if curve.own else 1.0, label=label,
                  linestyle=(0, (4, 2)) if curve.name.endswith("float32") else "-")
        if at is not None:
            level = y[at] if np.isfinite(y[at]) else stress.limit
            axes.plot(stress.values[at], level, "x", color=tints[base(curve)], markersize=7.0, markeredgewidth=1.8)
    axes.axhline(stress.limit, color=FAINT, linewidth=1.0, linestyle=":")
    axes.annotate(f"limit {said(stress.limit, stress.measure_unit)}", (0.01, stress.limit), (0, 3),
                  xycoords=("axes fraction", "data"), textcoords="offset points", color=DIM, fontsize=8.0,
                  path_effects=[withStroke(linewidth=3.0, foreground=PAPER)])
    if not stress.rising:
        axes.invert_xaxis()


def save_index(found: list[tuple[str, Stress]], folder: Path, suffix: str, domains: str = "") -> None:
    """index.md: for each stress its plot, its table and what it shows; the maps of models; known failures."""
    lines = ["# The stability atlas", "",
             "Written by `lensbench stability -o FOLDER`. Every method against the stress that breaks it, which grows "
             "to the right. The curves are the worst error at each value, dashed in single precision, thick (bold in "
             "the tables) where the program relies on the method. A cross marks where it fails: its error first "
             "exceeds the limit there, or it has no answer although there is one.", ""]
    family = ""
    for name, stress in found:
        if name != family:
            family = name
            lines += [f"## {family}", ""]
        lines += [f"### {stress.title}", "", f"![{stress.title}]({file_name(family, stress, suffix)})", "", stress.note,
                  f"Limit: {said(stress.limit, stress.measure_unit)}, {stress.why}.", "",
                  "| method | safe up to | fails at | returns there |", "|---|---|---|---|"]
        for curve in stress.curves:
            safe, fails, returns = stress.words(curve)
            method = f"**{curve.name}**" if curve.own else curve.name
            switch = f"; {curve.switch}" if curve.own and curve.switch and fails != "never" else ""
            lines.append(f"| {method} | {safe} | {fails} | {returns}{switch} |")
        lines.append("")
    if domains:
        lines += ["## Domains of the models", "", "The simplest model that will do, for each lens over its field and "
                  "stops: what Auto chooses there.", "", f"![domains of the models]({domains})", ""]
    lines += ["## Known failures of other systems", "", *table(), ""]
    with replacing(folder / INDEX) as part:
        part.write_text("\n".join(lines), encoding="utf-8")
