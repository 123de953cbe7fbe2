"""Camera models: cost of a ray against its error relative to the traced lens.

Cost in ns a ray on one thread, measured at run time. *Streamed*: one block of rays in the first-level cache, again and
again, from the film point and the pupil sample to the ray in front of the lens. *Fused*: whole samples as in the
renderer, from random numbers to the colour on the film. All models of a lens are timed in turn.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

import lensbench as lb
from lensbench.app.studies.charts.curves import Chart, Mark
from lensbench.app.studies.charts.ladder import Model, ladder
from lensbench.app.studies.charts.panels import Subject, share_of
from lensbench.app.studies.charts.peers import peer_marks
from lensbench.app.studies.charts.truth import Error, Truth
from lensbench.app.studies.timing import BLOCKS, Time, idle, report_progress, streamed, time_in_turn
from lensbench.core.kernels import block
from lensbench.core.kernels.block import U0, U1, B, Step, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.scenery.builtin.library import benchmark_scene
from lensbench.core.text import fixed, significant

STREAMED, FUSED = "Cost, streamed (ns a ray)", "Cost, fused in the renderer (ns a sample)"
ERROR = "Error, rms (pixels)"
ALSO = ((FUSED, "fused, ns", "its spread, %"),)
PIXELS = (320, 180)             # pixels of the film on which whole samples are timed
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
    film = lb.Film(camera.film.width, camera.film.height, *PIXELS)
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
