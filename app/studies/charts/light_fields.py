"""Error of refocused light fields against a camera focused at that distance, by number of views.

For even blur, neighbouring views lie at most a pixel apart (`LightField.clear_range`). The chart marks this range, and
draws dots beyond it.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.state.picture.statistics import decibels
from lensbench.app.studies.plotting import AMBER, COLOURS, DIM, look, plot, save, sheet
from lensbench.kernels.figures import significant

VIEWS = (3, 5, 9, 17)
NEARER = tuple(0.25 * k for k in range(1, 11))          # recorded focus distance over the distances tried
RAYS = 1445                     # rays of a pixel over the whole pupil: 17 × 17 × 5
TRUTH = 1024                    # samples a pixel of the reference pictures
BORDER = 10                     # of each side: 1 / BORDER is left out, since not every view sees it


class Curve(NamedTuple):
    """Measured errors of a light field of views × views."""

    views: int
    near: float                 # mm: range in which views lie at most a pixel apart
    far: float
    distances: tuple[float, ...]
    decibels: tuple[float, ...]


def measure(camera: lb.Camera, scene: lb.Scene, views: tuple[int, ...] = VIEWS, seed: int = 0,
            progress: Callable[[float], object] = lambda share: None) -> list[Curve]:
    """Capture light fields at the focus of the camera, and compare their refocused pictures with the camera's pictures.

    All have the same number of rays a pixel. progress: receives the finished share. Raises FocusError and the other
    errors of `lb.capture_light_field`.
    """
    focus: float = camera.focus_distance                # type: ignore[attr-defined]
    fields = []
    for number in views:
        samples = max(round(RAYS / number**2), 1)
        fields.append(lb.capture_light_field(camera, scene, (number, number), samples, seed))
        progress(0.5 * len(fields) / len(views))
    distances = [focus / part for part in NEARER if focus / part >= fields[0].nearest]
    inner = tuple(slice(size // BORDER, size - size // BORDER) for size in (camera.film.pixels_y, camera.film.pixels_x))
    found = np.empty((len(views), len(distances)))
    for j, distance in enumerate(distances):
        refocused = camera.refocused(distance)
        direct = lb.render(refocused, scene, TRUTH, seed + 1)[inner]
        found[:, j] = [decibels(field.refocus(distance)[inner], direct) for field in fields]
        progress(0.5 + 0.5 * (j + 1) / len(distances))
    true = camera.flat_port.true                        # beyond a window into water
    ranges = [field.clear_range for field in fields]
    return [Curve(number, true(near), true(far), tuple(map(true, distances)), tuple(row))
            for number, (near, far), row in zip(views, ranges, found.tolist(), strict=True)]


def draw(curves: list[Curve], focus: float, title: str, conditions: str, path: Path) -> None:
    """Write the chart; ExportError where it cannot be written. focus: focus distance of the capture, mm."""
    colours = [COLOURS[name] for name in ("grey", "sky", "blue", "vermilion", "purple", "green")]
    with look():
        figure = sheet(8.0, 4.8)
        axes = plot(figure.add_subplot(), "Focus distance (m), even in the reciprocal",
                    "Against a camera focused there (dB)", title)
        for k, curve in enumerate(curves):
            colour, x = colours[k % len(colours)], 1e3 / np.array(curve.distances)
            inside = (np.array(curve.distances) >= curve.near) & (np.array(curve.distances) <= curve.far)
            axes.plot(x, curve.decibels, color=colour, linestyle=(0, (1, 2)), linewidth=1.2)
            axes.plot(np.where(inside, x, np.nan), curve.decibels, "o-", color=colour, markersize=3.5,
                      label=f"{curve.views} × {curve.views} views")
            for end in (1e3 / curve.near, 1e3 / curve.far):
                if x.min() < end < x.max():
                    axes.axvline(end, color=colour, linewidth=0.9, linestyle=(0, (4, 3)))
        axes.axvline(1e3 / focus, color=AMBER, linewidth=1.2)
        axes.text(1e3 / focus, 1.0, " recorded", transform=axes.get_xaxis_transform(), color=AMBER, va="top",
                  fontsize=8.5)
        ticks = [d for d in (0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
                 if x.min() <= 1.0 / d <= x.max()]
        axes.set_xticks([1.0 / d for d in ticks], [significant(d) for d in ticks])
        axes.legend(frameon=False, loc="best")
        figure.supxlabel(conditions, color=DIM, fontsize=8.0, x=0.01, ha="left")
        save(figure, path)
