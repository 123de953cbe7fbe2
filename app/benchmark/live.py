"""Time of live answers: analyses, the pixel under the mouse, edits and open plots.

Both take turns in one window, so that other load of the machine affects both equally.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from resource import RUSAGE_SELF, getrusage

import numpy as np
from imgui_bundle import hello_imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.plots.exit_pupil import box_samples
from lensbench.app.plots.pixel_rays import film_place, pixel_fan
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.session.edited_lens import edited
from lensbench.app.settings.settings import Settings
from lensbench.app.studies.timing import least_times
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.session import Session
from lensbench.app.window.window import parameters, show, without_display
from lensbench.core.analysis.grids.traced_grid import ray_grid
from lensbench.lenses.editing.cells import with_radius

LENS = "lib-tronnier-1953"      # six lenses, glasses with dispersion


def analysis() -> Iterator[tuple[str, float, str]]:
    """The ray grid, each plot from it, all of them, the MTF map and the PSFs; 32 points across the pupil."""
    lens = lenses.load(LENS)
    away = lb.film_distance(lens, math.inf)
    of = lb.analysis
    wide, nine = of.conditions(lens, lb.Film()), of.conditions(lens, lb.Film(), 9)
    grid = of.ray_grid(lens, away, wide)
    fine = of.ray_grid(lb.stopped_down(lens, 5.6), away, nine, 64)

    def anew(make: Callable[[], object]) -> Callable[[], object]:
        """The work with a grid that is not kept."""
        def work() -> object:
            ray_grid.cache_clear()
            return make()
        return work

    plots: dict[str, Callable[[], object]] = {
        "spots": lambda: of.spots(grid),
        "ray and OPD fans": lambda: of.ray_fans(grid),
        "wavefronts with 37 Zernike terms": lambda: of.wavefronts(grid),
        "field curves": lambda: of.field_curves(lens, away, wide),
        "longitudinal aberration": lambda: of.longitudinal_aberration(lens, away, wide),
        "chromatic focal shift": lambda: of.chromatic_focal_shift(replace(lens), away, wide),  # a lens keeps its own
        "MTF at four frequencies": lambda: of.mtf(grid),
    }
    grids: dict[str, Callable[[], object]] = {
        "ray grid, 12 fields, 3 colours": anew(lambda: of.ray_grid(lens, away, wide)),
        "MTF map 64 × 64, 3 colours, with its rays": anew(lambda: of.mtf_map(lens, away, wide)),
        "the same coarse, 32 fields, 16 points": anew(lambda: of.mtf_map(lens, away, wide, fields=32, pupil=16)),
    }
    rest: dict[str, Callable[[], object]] = {
        "PSF 256², 9 fields, 3 colours": lambda: of.psf(fine),
        "focus shift, 9 apertures": anew(lambda: of.focus_shift(lens, away, wide)),
    }
    best = least_times({**plots, **grids, **rest}, 0.2)
    for name, seconds in best.items():
        yield name, 1e3 * seconds, "ms"
    yield "ray grid and the seven plots", 1e3 * (sum(best[name] for name in plots) + best[next(iter(grids))]), "ms"


HOVERS = 60
LENSES = ("pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "lentil-schneider-anamorphic-31-2001")


def pixels() -> Iterator[tuple[str, float, str]]:
    """User CPU time of everything that the panels compute for a pixel: fan, region, beam, spot and figures."""
    for name in LENSES:
        settings = replace(Settings(), lens=name, f_number=None)
        built = bench_of(settings)
        spent = []
        for i in range(HOVERS + 5):
            raster, before = (300.5 + 5 * i, 200.5 + 3 * i), getrusage(RUSAGE_SELF).ru_utime
            pixel_fan(settings, raster)
            pixel_readings(settings, raster)
            x, y = film_place(settings, raster)
            box_samples(built.lens, built.film_distance, math.hypot(x, y), math.atan2(y, x))
            spent.append(getrusage(RUSAGE_SELF).ru_utime - before)
        yield f"pixel under the mouse, user CPU time, {name}", 1e3 * float(np.mean(spent[5:])), "ms"


DRIVEN_WINDOW_SIZE = (1280, 720)
SMALL = Settings(pixels_x=640, pixels_y=360, film_width=32.0, film_height=18.0, samples=100_000)


class DrivenSession(Session):
    """A session whose dials are moved by a script instead of the panel."""

    move: Callable[[Settings], Settings] | None = None
    moved = worked = 0.0

    def begin(self) -> None:
        """Begin a frame with the scripted settings."""
        super().begin()
        if self.move is not None:
            self.moved, self.worked = time.perf_counter(), time.process_time()
            self.edited, self.move = self.move(self.edited), None
            self.hurry()

    @property
    def current(self) -> bool:
        """Whether the picture on the screen belongs to the current settings."""
        update = self.presenter.update
        return update is not None and update.generation == self.worker.generation


def run(settings: Settings, watch: Callable[[DrivenSession], bool], idle: bool = False,
         size: tuple[int, int] = DRIVEN_WINDOW_SIZE, layout: str | None = None) -> None:
    """Show the window until `watch`, called after each frame, returns True; idle: slow down at rest as usual.

    layout: a name of LAYOUTS; None is the usual one.
    """
    without_display()
    session = DrivenSession(settings, remember=False, threads=2)
    if layout is not None:
        session.layout = layout
    runner = parameters(session, size)
    if not idle:
        runner.fps_idling.enable_idling = False
        runner.fps_idling.fps_max = 0.0

    def after() -> None:
        if watch(session):
            runner.app_shall_exit = True

    runner.callbacks.after_swap = after
    show(runner)


def focused(settings: Settings, turn: int) -> Settings:
    """Settings whose focus has been moved `turn` times."""
    return replace(settings, focus_distance=800.0 + 37.0 * turn)


LAYOUT, PLOTS_SIZE = "Designer", (1920, 1080)
TURNS, MOVES = 4, 6             # of each kind of window, and moves in one of them
SETTLE = 8                     # frames until panels have opened or closed
PLOTS_REST = 5                        # frames between two moves of the dial


def first_pictures() -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Seconds from a move of the focus to the first pass, and to its picture on screen, with all plots and without."""
    pictures: tuple[list[tuple[float, float]], list[tuple[float, float]]] = ([], [])
    plots: list[hello_imgui.DockableWindow] = []
    rest, moves, turn = [SETTLE], [0], [0]

    def watch(session: DrivenSession) -> bool:
        if not plots:
            if session.settled(1):
                plots.extend(dockable for dockable in hello_imgui.get_runner_params().docking_params.dockable_windows
                             if dockable.label in PANELS and dockable.is_visible)
            return False
        if session.moved and session.current:
            pictures[turn[0] % 2].append((session.worker.first_seconds, time.perf_counter() - session.moved))
            session.moved, rest[0], moves[0] = 0.0, PLOTS_REST, moves[0] + 1
            if moves[0] == MOVES:
                turn[0], moves[0], rest[0] = turn[0] + 1, 0, SETTLE
                for plot in plots:
                    plot.is_visible = turn[0] % 2 == 0
        elif not session.moved and session.move is None and session.current:
            rest[0] -= 1
            if rest[0] <= 0:
                session.move = partial(focused, turn=MOVES * turn[0] + moves[0])
        return turn[0] == 2 * TURNS

    run(SMALL, watch, size=PLOTS_SIZE, layout=LAYOUT)
    return pictures


def with_plots() -> Iterator[tuple[str, float, str]]:
    """From a dial to the first picture with the plots of the Designer layout, over that without plots."""
    among, alone = (1e3 * np.median(seconds, 0) for seconds in first_pictures())
    for k, name in enumerate(("end of the first pass", "first picture on the screen")):
        yield f"dial to {name}, no plots, median", float(alone[k]), "ms"
        yield f"dial to {name}, plots of {LAYOUT}, median", float(among[k]), "ms"
        yield f"dial to {name}, with plots over without", float(among[k] / alone[k]), "×"


SURFACE, RADIUS = 1, 150.0      # of the double Gauss; its radius there is near this
EDITS, EDIT_REST = 24, 5             # edits one by one, and frames between two of them
HELD = 3.0                      # seconds of a radius that is dragged


def with_turn(settings: Settings, turn: int) -> Settings:
    """Settings whose lens has a radius of its own for each turn, 0.2 mm apart."""
    return edited(settings, lambda document: with_radius(document, SURFACE, RADIUS + 0.2 * turn))[0]


def edits() -> Iterator[tuple[str, float, str]]:
    """In a window of full HD, and in one of the usual size, on whose drawing less of the time goes."""
    for size in (PLOTS_SIZE, DRIVEN_WINDOW_SIZE):
        yield from _edits_in(size)


def _edits_in(size: tuple[int, int]) -> Iterator[tuple[str, float, str]]:
    """One by one, with the plots of the Designer layout; then as fast as pictures and plots follow. size: pixels."""
    pictures: list[float] = []
    plots: list[float] = []
    rest, turn, edits_done, began, shown, frames = [EDIT_REST], [0], [0], [0.0], [0.0], [0]

    def watch(session: DrivenSession) -> bool:
        now = time.perf_counter()
        if not began[0]:
            began[0] = now if session.settled(1) else 0.0
            return False
        if session.moved:
            shown[0] = shown[0] or (now - session.moved if session.current else 0.0)
            frames[0] += 1                          # the first one draws the plots of the settings before
            if frames[0] > 1 and shown[0] and not session.analyses.worker.is_late:
                if turn[0] <= EDITS:
                    pictures.append(shown[0])
                    plots.append(now - session.moved)
                edits_done[0] += turn[0] > EDITS
                began[0] = now if turn[0] == EDITS else began[0]
                session.moved, shown[0], rest[0], frames[0] = 0.0, 0.0, EDIT_REST, 0
        else:
            rest[0] -= 1
        if not session.moved and session.move is None and (rest[0] <= 0 or turn[0] >= EDITS):
            turn[0] += 1
            session.move = partial(with_turn, turn=turn[0])
        return turn[0] > EDITS and now - began[0] > HELD

    run(SMALL, watch, size=size, layout=LAYOUT)
    window = f"plots of {LAYOUT}, {size[0]} × {size[1]}"
    yield f"radius edited to picture, {window}, median", 1e3 * float(np.median(pictures)), "ms"
    yield f"radius edited to all {window}, median", 1e3 * float(np.median(plots)), "ms"
    yield f"radius edited again as soon as picture and {window} follow", edits_done[0] / HELD, "/s"
