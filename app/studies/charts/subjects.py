"""The charts of `lensbench chart`: lenses before films, camera models, and the panels of other subjects. Lengths in mm.

Of camera models: cost of a ray, in ns on one thread and measured at run time, against its error relative to the traced
lens. *Streamed*: one block of rays in the first-level cache, again and again, from the film point and the pupil sample
to the ray in front of the lens. *Fused*: whole samples as in the renderer, from random numbers to the colour on the
film. All models of a lens are timed in turn.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import design
from lensbench.app.bench.zoom import asked_zoom
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.studies.charts.curves import Chart, Mark, Panel
from lensbench.app.studies.charts.ladder import Model, ladder
from lensbench.app.studies.charts.methods import focus_panel, image_panel, pupil_panels
from lensbench.app.studies.charts.peers import peer_marks
from lensbench.app.studies.charts.samplers import sampling_panels, scenes as sampling_scenes
from lensbench.app.studies.charts.truth import Error, Truth
from lensbench.app.studies.timing import BLOCKS, Time, idle, report_progress, streamed, time_in_turn
from lensbench.core.kernels import block
from lensbench.core.kernels.block import U0, U1, B, Step, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.scenery.builtin.library import benchmark_scene
from lensbench.core.text import fixed, significant
from lensbench.lenses.library.catalogue import one_of_each_kind

PIXELS = (6000, 4000)
FILM = (36.0, 24.0)
AWAY = 50.0                     # default focus distance, in focal lengths from the film
DARK = 0.1                      # share of the light on the axis at which the film ends


@dataclass(frozen=True)
class Subject:
    """One lens in front of its film. key: its name or path; title: its name in words."""

    key: str
    title: str
    camera: lb.LensCamera


def subjects(arguments: argparse.Namespace) -> tuple[list[Subject], list[str]]:
    """The requested lenses, or a library lens of each kind; and a line for each lens that is left out, with the reason.

    Of several lenses, each is limited to its widest stop and to its nearest focus. A single lens raises the errors of a
    camera: ValueError, OSError.
    """
    if len(arguments.lens) == 1:
        return [subject(arguments.lens[0], arguments, exactly=True)], []
    lenses, left_out = [], []
    for name in arguments.lens or one_of_each_kind():
        try:
            lenses.append(subject(name, arguments, exactly=False))
        except (ValueError, OSError) as error:
            if arguments.lens:
                raise
            left_out.append(f"{name}: {error}")
    return lenses, left_out


def subject(name: str, arguments: argparse.Namespace, exactly: bool) -> Subject:
    """A lens with the settings of the arguments; exactly: an error instead of the nearest possible setting."""
    lens = design(replace(Settings(), lens=name, focal_length=arguments.focal_length).checked())
    lens = lens.at(zoom=asked_zoom(lens, arguments.zoom), close=0.0)
    efl, f_number = abs(lb.first_order(lens).efl), getattr(arguments, "f_number", None)
    focus = arguments.focus
    if focus is None or not exactly:
        focus = max(AWAY * efl if focus is None else focus, 1.02 * lb.nearest_focus(lens))
    if f_number is not None and not exactly:
        f_number = max(f_number, lb.first_order(lens).f_number)
    width, height = (arguments.film or FILM)[:2]
    pixels = arguments.size or PIXELS
    camera = lb.LensCamera(lens, lb.Film(width, height, *pixels), focus, f_number)
    if arguments.film is None:
        camera = replace(camera, film=_lit(camera, pixels))
    return Subject(name, lens.name or name, camera)


def _lit(camera: lb.LensCamera, pixels: tuple[int, int]) -> lb.Film:
    """The film reduced to the part that the lens lights."""
    film, radii = camera.film, 0.5 * camera.film.diagonal * np.geomspace(0.02, 1.0, 160)
    if not camera.lens.is_rotationally_symmetric:
        return film
    dark = np.flatnonzero(lb.falloff(camera.lens, camera.film_distance, radii).total < DARK)
    if not dark.size:
        return film
    share = radii[max(dark[0] - 1, 0)] / radii[-1]
    digits = 1 - math.floor(math.log10(share * film.width))
    width = round(share * film.width, digits)
    return lb.Film(width, width * film.height / film.width, *pixels)


def share_of(progress: Callable[[float], bool], i: int, n: int) -> Callable[[float], bool]:
    """The progress of the i-th of n pieces of work, as the share of all of them."""
    return lambda share: progress((i + share) / n)


# Camera models


STREAMED, FUSED = "Cost, streamed (ns a ray)", "Cost, fused in the renderer (ns a sample)"
ERROR = "Error, rms (pixels)"
ALSO = ((FUSED, "fused, ns", "its spread, %"),)
FUSED_PIXELS = (320, 180)             # pixels of the film on which whole samples are timed
SCALAR = 1024                   # rays in one piece of work of the scalar tracer
LOST = 0.005                    # share of the rays that a model may lose at the rims
SECONDS = 0.06                  # s: for the timings of each model


def charts(subjects: list[Subject], progress: Callable[[float], bool] = lambda _: True,
           peers: Sequence[str] = ()) -> list[Chart]:
    """The chart of each lens, with these other programs; StoppedError where `progress` returns False."""
    return [chart(subject, share_of(progress, i, len(subjects)), peers=peers) for i, subject in enumerate(subjects)]


def chart(subject: Subject, progress: Callable[[float], bool] = lambda _: True, seconds: float = SECONDS,
          in_the_renderer: bool = True, peers: Sequence[str] = ()) -> Chart:
    """The chart of a lens, `seconds` a model, with whole samples if `in_the_renderer`; LensError without light."""
    camera = subject.camera
    models, truth = ladder(camera), Truth(camera)
    if truth.rays == 0:
        raise lb.LensError(f"{subject.title}: no ray reaches this film: open the stop, or use a smaller film")
    errors: dict[str, Error] = {}
    for i, model in enumerate(models):
        if not model.why:
            errors[model.name] = truth.error(model)
        report_progress(progress, 0.3 * (i + 1) / len(models))
    alive = [model for model in models if not model.why]
    stream = _streamed(camera, alive, seconds)
    report_progress(progress, 0.6)
    fused = _fused(camera, alive, seconds) if in_the_renderer else {}
    report_progress(progress, 1.0)
    marks = [_mark(model, truth, errors.get(model.name), stream, fused) for model in models]
    scalar = stream["scalar"]
    marks.append(Mark("scalar reference", "scalar", scalar.least, 0.0, scalar.spread, 0.0,
                      figures=_figures(Error(*[0.0] * 7), scalar, None)))
    if peers:
        marks += peer_marks(peers, truth)
    note = (f"Of a streamed ray by table, polynomial or trace, {significant(stream['aim'].least, 2)} ns are for "
            f"aiming into the exit-pupil region; the scalar reference has its rays aimed")
    return Chart(subject.key, subject.title, STREAMED, ERROR, tuple(marks), conditions(camera, truth), (note,),
                 ALSO if in_the_renderer else ())


def conditions(camera: lb.LensCamera, truth: Truth) -> str:
    """One line with the conditions that apply to all marks of a chart."""
    film, focus = camera.film, camera.focus_distance
    focused = "infinity" if math.isinf(focus) else f"{significant(focus / 1000.0, 3)} m"
    return (f"f/{significant(lb.first_order(camera.lens.at(close=0.0)).f_number, 3)}, focused at {focused}; "
            f"film {significant(film.width, 3)} × {significant(film.height, 3)} mm, {film.pixels_x} × "
            f"{film.pixels_y} pixels of "
            f"{significant(1000.0 * film.pitch, 3)} µm; {truth.rays} rays, objects in focus, at half the distance "
            f"and far away")


def _mark(model: Model, truth: Truth, error: Error | None, stream: dict[str, Time], fused: dict[str, Time]) -> Mark:
    why, widest = model.why, truth.widest
    if error is None:
        return Mark(model.name, model.kind, why=why)
    if not model.aim and widest >= 0.5 * math.pi:
        why = f"the lens sees {fixed(math.degrees(widest), 0)}° off the axis; the model {model.name} ends at 90°"
    elif error.lost > LOST:
        why = f"loses {significant(100.0 * error.lost, 2)} % of the rays that the lens passes"
    time = stream[model.name]
    return Mark(model.name, model.kind, time.least, error.rms, time.spread, error.worst, why,
                _figures(error, time, fused.get(model.name)))


def _figures(error: Error, stream: Time, fused: Time | None) -> dict[str, float]:
    figures = {"streamed, ns": stream.least, "spread, %": stream.spread}
    if fused is not None:
        figures |= {"fused, ns": fused.least, "its spread, %": fused.spread}
    return figures | {"rms, px": error.rms, "p99, px": error.p99, "worst, px": error.worst, "in focus, px": error.focus,
                    "light rms, stops": error.stops_rms, "light worst, stops": error.stops_worst,
                    "lost, %": 100.0 * error.lost}


def _streamed(camera: lb.LensCamera, models: list[Model], seconds: float) -> dict[str, Time]:
    """Cost (ns) of a ray by each model, by aiming alone, and by the scalar tracer."""
    random = np.random.default_rng(1)
    x, y, u0, u1 = random.random((4, B))
    film = camera.film
    samples = {X: (x - 0.5) * film.width, Y: (y - 0.5) * film.height, U0: u0, U1: u1}
    works: dict[str, Callable[[], object]] = {
        f"idle {real.__name__}": streamed([Step(idle, [0.0])], samples, real) for real in (np.float32, np.float64)}
    aim = next(list(model.aim) for model in models if model.aim)
    works["aim"] = streamed(aim, samples)
    works |= {model.name: streamed(model.steps, samples, model.real) for model in models}
    counts = dict.fromkeys(works, BLOCKS * B) | {"scalar": SCALAR}
    works["scalar"] = _scalar(camera, aim)
    times = {name: time.per_item(counts[name]) for name, time in time_in_turn(works, seconds).items()}
    empty = {real: times[f"idle {real.__name__}"].least for real in (np.float32, np.float64)}
    reals = {model.name: model.real for model in models}
    return {name: time if name == "scalar" else time.without(empty[reals.get(name, np.float32)])
            for name, time in times.items()}


def _scalar(camera: lb.LensCamera, aim: list[Step]) -> Callable[[], None]:
    """A piece of work: the scalar tracer in double precision, on rays of the camera from its film."""
    lens, away, random = camera.lens, camera.film_distance, np.random.default_rng(2)
    x, y, u0, u1 = random.random((4, SCALAR))
    x, y = (x - 0.5) * camera.film.width, (y - 0.5) * camera.film.height
    way = Program(aim, np.float64).run({X: x, Y: y, U0: u0, U1: u1}, [block.L, block.M, block.N], SCALAR)
    origins = np.column_stack([x, y, np.full(SCALAR, lens.length + away)])
    return partial(trace_rays, surface_table(lens), True, origins, np.ascontiguousarray(way.T), np.empty((SCALAR, 3)),
                   np.empty((SCALAR, 3)), np.empty(SCALAR, np.int32), np.empty(SCALAR, np.int32), None, -1)


def _fused(camera: lb.LensCamera, models: list[Model], seconds: float) -> dict[str, Time]:
    """Cost (ns) of a whole sample by each model, in the benchmark scene without shadows."""
    film = lb.Film(camera.film.width, camera.film.height, *FUSED_PIXELS)
    blocks = -(-film.pixels_x * film.pixels_y // B)
    before = [*sampling_steps(film.pixels_x, film.pixels_y, lit=False), film.step]
    after = benchmark_scene().steps(shadows=False)
    works: dict[str, Callable[[], object]] = {}
    for model in models:
        program = Program([*before, *model.steps, *after], model.real)
        works[model.name] = partial(program.expose, np.zeros((blocks, 3 * B), model.real),
                                    block.lane_buffer(model.real), 0,
                                    blocks, 0, 1, np.uint32(0))
    return {name: time.per_item(blocks * B) for name, time in time_in_turn(works, seconds).items()}


# Pupils, focusing, pictures and samplers


TITLES = {"pupil": "Exit-pupil regions: cost and error",
          "focus": "Focusing: cost and excess blur",
          "image": "Whole pictures: error against time",
          "sampler": "Samples that white noise needs for the same error"}
LENSES = ("pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-fisheye-10mm")
FOCUS_LENSES = (*LENSES, "lentil-takumar-1969")
IMAGE_SCENES = ("still-life", "focus-ruler", "night-lights")
IMAGE_FOCUS = 1200.0            # mm: the middle of the built-in scenes
PER_LENS = ("pupil", "focus")


def panels(arguments: argparse.Namespace, progress: Callable[[float], bool]) -> list[Panel]:
    """The panels asked for; StoppedError where `progress` returns False; ValueError, OSError of the readers."""
    if arguments.of in PER_LENS:
        names = arguments.lens or (LENSES if arguments.of == "pupil" else FOCUS_LENSES)
        lenses, _ = subjects(argparse.Namespace(**{**vars(arguments), "lens": names}))
        made = [_of_lens(arguments.of, lens, share_of(progress, i, len(lenses))) for i, lens in enumerate(lenses)]
        if arguments.of == "pupil":                     # first row: light of all lenses; second: samples
            return [panel for row in zip(*made, strict=True) for panel in row]
        return [panel for row in made for panel in row]
    if arguments.of == "sampler":
        return sampling_panels(_known(arguments.scene or [], list(sampling_scenes())), progress)
    names = _known(arguments.scene or list(IMAGE_SCENES), list(lb.SCENES))
    focus = IMAGE_FOCUS if arguments.focus is None else arguments.focus
    changed = {"lens": arguments.lens or [LENSES[0]], "focus": focus}
    lenses, _ = subjects(argparse.Namespace(**{**vars(arguments), **changed}))
    pairs = [(lens, name) for lens in lenses for name in names]
    return [_of_scene(lens, name, share_of(progress, i, len(pairs)), len(lenses) > 1)
            for i, (lens, name) in enumerate(pairs)]


def _of_lens(of: str, subject: Subject, progress: Callable[[float], bool]) -> list[Panel]:
    if of == "pupil":
        return pupil_panels(subject.key, subject.camera, progress)
    return [focus_panel(subject.key, subject.camera.lens, progress)]


def _of_scene(subject: Subject, name: str, progress: Callable[[float], bool], several: bool) -> Panel:
    panel = image_panel(f"{subject.key}, {name}", subject.camera, lb.builtin_scene(name), progress)
    return replace(panel, title=f"{name}, {subject.title}") if several else panel


def _known(names: list[str], all_names: list[str]) -> list[str]:
    """The names; SettingsError with a list of all names if one is unknown."""
    for name in names:
        if name not in all_names:
            raise SettingsError(f"no scene “{name}”: choose of {', '.join(all_names)}")
    return names
