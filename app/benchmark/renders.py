"""Cost of pictures: camera models, blades and noise, ghosts, motion and pixel footprints."""

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from time import process_time

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import FILM, LENS, idle, least_times, streamed
from lensbench.core.cameras.ray_generation import spread_step
from lensbench.core.kernels import block
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.lens_models.polynomial import DEGREES, Polynomial
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.optics.ghost_path import ghost_pairs
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.rendering.ghost_image import MOST, Flare, GhostImage

NAMES = (LENS, "pbrt-fisheye-10mm")
PIXEL = 0.004               # mm


def polynomials() -> Iterator[tuple[str, float, str]]:
    """Fitted polynomials against the full trace, and the fit: 512 rays in the first-level cache, float32."""
    for name in NAMES:
        lens, distance = lenses.load(name), 1200.0
        film_distance = lb.film_distance(lens, distance)
        table = PupilTable.of(lens, film_distance, 21.6, widened=False)
        rays = _aimed(table)
        fits = {degree: Polynomial.fit(lens, film_distance, table, degree, distance=distance) for degree in DEGREES}
        steps = {"idle": [block.Step(idle, [0.0])], "trace": surface_steps(lens, film_distance),
                 **{str(degree): [fit.step] for degree, fit in fits.items()}}
        best = least_times({label: streamed(stages, rays) for label, stages in steps.items()})
        trace = best["trace"] - best["idle"]
        for degree, fit in fits.items():
            ratio = trace / (best[str(degree)] - best["idle"])
            yield f"trace / polynomial of degree {degree}, {name}", ratio, "×"
            yield f"polynomial of degree {degree}, rms error, {name}", fit.rms / PIXEL, "px of 4 µm"
        seconds = least_times({
            "fit": partial(Polynomial.fit, lens, film_distance, table, 9, distance=distance),
            "both": partial(_with_pupil, lens, film_distance)})
        yield f"fit of degree 9, {name}", 1e3 * seconds["fit"], "ms"
        yield f"fit of degree 9 with its pupil, {name}", 1e3 * seconds["both"], "ms"


def _with_pupil(lens: lb.Lens, film_distance: float) -> Polynomial:
    return Polynomial.fit(lens, film_distance, PupilTable.of(lens, film_distance, 21.6, widened=False), 9)


def _aimed(table: PupilTable) -> dict[int, np.ndarray]:
    """Ray rows of one block of rays that leave the film towards their exit-pupil regions."""
    random = np.random.default_rng(1)
    film = random.uniform(-1.0, 1.0, (2, block.B)) * [[18.0], [12.0]]
    rows = [block.X, block.Y, block.Z, block.L, block.M, block.N, block.WEIGHT]
    u0, u1 = random.random((2, block.B))
    samples = {block.X: film[0], block.Y: film[1], block.U0: u0, block.U1: u1}
    return dict(zip(rows, Program([table.step(1.0)]).run(samples, rows, block.B), strict=True))


SAMPLES = 8
EXPOSURE = lb.Exposure(2.8, 1.0 / 60.0, 1600.0)


def exposure() -> Iterator[tuple[str, float, str]]:
    """Seven rounded blades against a circle, fog against clear air, and the sensor noise of a 960 × 640 picture."""
    scene, lens = lb.builtin_scene("still-life"), lenses.load(LENS)
    bladed = replace(lens, blades=7, roundness=0.3)
    for name in ("trace", "thin"):
        cameras = {label: lb.LensCamera(it, FILM, 1200.0, 2.8, model=name, dispersion=False)
                   for label, it in (("round", lens), ("bladed", bladed))}
        best = least_times({label: partial(lb.Rendering(camera, scene, shadows=False).add, SAMPLES, threads=1)
                            for label, camera in cameras.items()}, 0.4)
        yield f"seven blades / a circle, {name}, still-life without shadows", best["bladed"] / best["round"], "×"
    fog = lb.Medium.fog(20_000.0)
    for words, shadows in (("", True), (" without shadows", False)):
        best = least_times({label: partial(lb.Rendering(lb.PerspectiveCamera(FILM, fov=0.45, medium=medium), scene,
                                                  shadows=shadows).add, SAMPLES, threads=1)
                            for label, medium in (("clear", None), ("fog", fog))}, 0.4)
        yield f"fog / clear air, still-life{words}", best["fog"] / best["clear"], "×"
    sensor = lb.Sensor()
    picture = lb.render(lb.PerspectiveCamera(lb.Film(), fov=0.45), scene, samples=4) * EXPOSURE.brightness
    lux_seconds = EXPOSURE.lux_seconds / EXPOSURE.brightness
    best = least_times({"record": partial(sensor.record, picture, EXPOSURE.iso, lux_seconds)})
    yield "a sensor's noise, 960 × 640, all cores", best["record"] * 1e3, "ms"


PAIRS = 66              # of 12 surfaces that reflect
THREADS = 2
SUN = lb.Scene("sun", sun=lb.Sun((0.14, 0.13, -1.0)))


def ghosts() -> Iterator[tuple[str, float, str]]:
    """In one colour, then dispersed: the first pass, which searches where each ghost enters, and a later one."""
    name = next(name for name in lenses.names() if len(ghost_pairs(lenses.load(name))) == PAIRS)
    for colours, said in ((False, ""), (True, ", dispersed")):
        camera = lb.LensCamera(lenses.load(name), lb.Film(36.0, 20.25, 640, 360), dispersion=colours)
        with ThreadPoolExecutor(THREADS) as pool:
            best = least_times({"first": partial(_first, camera, pool)})
            begun = _first(camera, pool)
            start = process_time()
            begun.add(MOST // 2, pool, THREADS, lambda: True)
            later = (process_time() - start) / (begun.state["ghost_passes"][0] - 1)
        yield f"{PAIRS} ghosts of the sun{said}, {name}, first pass, two threads", 1e3 * best["first"], "ms"
        yield f"{PAIRS} ghosts of the sun{said}, {name}, processor time of a later pass", 1e3 * later, "ms"


def _first(camera: lb.LensCamera, pool: ThreadPoolExecutor) -> GhostImage:
    """The ghosts after one pass."""
    image = GhostImage(camera, SUN, Flare())
    image.add(1, pool, THREADS, lambda: True)
    return image


CRAWL = 1e-4                            # share of the motion: the same picture, so that only the cost of motion differs


def motion() -> Iterator[tuple[str, float, str]]:
    """A camera that pans and rotates, and a scene in motion, each against the same at rest."""
    scene = lb.builtin_scene("still-life")
    lens = lenses.load(LENS)
    kinds = {"full trace": lambda **more: lb.LensCamera(lens, FILM, 1200.0, **more),
             "thin lens": lambda **more: lb.LensCamera(lens, FILM, 1200.0, model="thin", **more),
             "perspective": lambda **more: lb.PerspectiveCamera(FILM, fov=0.45, **more)}
    for name, make in kinds.items():
        for words, shadows in (("", True), (" without shadows", False)):
            for slowly, share in (("", 1.0), (", all but at rest", CRAWL)):
                way = _pan(share)
                yield f"moving / still camera, {name}, still-life{words}{slowly}", _ratio(
                    [(make(world_from_camera=pose), scene) for pose in (way, way.start)], shadows), "×"
    moving = lb.builtin_scene("fairground")
    camera = lb.LensCamera(lens, FILM, 1200.0, shutter_close=1.0 / 60.0)
    rest = replace(moving, spheres=tuple(_at_rest(o) for o in moving.spheres),
                   plates=tuple(_at_rest(o) for o in moving.plates))
    yield "moving / static objects, fairground, 1/60 s", _ratio([(camera, moving), (camera, rest)], True), "×"


def _pan(share: float) -> lb.AnimatedTransform:
    """A share of a motion of 23 mm and 1.1 degrees."""
    start, end = np.eye(4), np.eye(4)
    c, s = np.cos(0.02 * share), np.sin(0.02 * share)
    start[:3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    end[:3, 3] = 20.0 * share, 5.0 * share, -10.0 * share
    return lb.AnimatedTransform(start, end)


def _ratio(pair, shadows: bool) -> float:
    """Time of the first picture over that of the second."""
    blocks = -(-FILM.pixels_x * FILM.pixels_y // block.B)
    bench = block.lane_buffer()
    works: dict[str, Callable[[], object]] = {}
    for name, (camera, scene) in zip(("first", "second"), pair, strict=True):
        timed = camera.moves or scene.moves
        program = Program([*sampling_steps(FILM.pixels_x, FILM.pixels_y, lit=shadows, timed=timed),
                           *camera.steps(timed=timed),
                           *scene.steps(shadows, camera.shutter_open)])
        sums = np.zeros((blocks, 3 * block.B), np.float32)
        works[name] = partial(program.expose, sums, bench, 0, blocks, 0, 1, np.uint32(0))
    best = least_times(works, 0.4)
    return best["first"] / best["second"]


def _at_rest(thing):
    """The object at rest, at its place at 0 s."""
    return replace(thing, velocity=(0.0,) * 3, spin=(0.0,) * 3, pivot=None)


SMALL = lb.Film(36.0, 24.0, 180, 120)


def differentials() -> Iterator[tuple[str, float, str]]:
    """Pictures with and without filter in turn, one thread; their errors at 1 and 1024 samples; set-up of the table."""
    lens = lenses.load(LENS)
    scenes = {name: lb.builtin_scene(name) for name in ("still-life", "grid-wall", "focus-ruler")}
    camera = lb.LensCamera(lens, FILM, 1200.0, dispersion=False)
    for name, scene in scenes.items():
        best = least_times({
            words: partial(lb.Rendering(camera, scene, shadows=False, filtered=words == "filtered").add, 4, threads=1)
            for words in ("plain", "filtered")})
        yield f"filtered / plain, {name} without shadows", best["filtered"] / best["plain"], "×"
    best = least_times({model: partial(spread_step, lb.LensCamera(lens, FILM, 1200.0, model=model), np.float32)
                  for model in ("trace", "thin")})
    for model, seconds in best.items():
        yield f"pixels' spread over the film, {model}", seconds * 1e3, "ms"
    white = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    views: dict[str, tuple[lb.Camera, lb.Scene]] = {"floor to its horizon": (lb.PerspectiveCamera(SMALL), lb.Scene(
        "floor", sky=white, floor=lb.Floor(-100.0, 40.0, (0.9,) * 3, (0.1,) * 3, turn=0.3)))}
    small = lb.LensCamera(lens, SMALL, 1200.0, 8.0, dispersion=False)
    views.update({name: (small, scene) for name, scene in scenes.items()})
    for name, (view, scene) in views.items():
        def taken(samples: int, filtered: bool, seed: int, view=view, scene=scene) -> np.ndarray:
            rendering = lb.Rendering(view, scene, seed, filtered=filtered)
            rendering.add(samples)
            return np.minimum(rendering.image().astype(float), 2.0)

        truth = taken(4096, False, 1)
        for samples in (1, 1024):
            for words, filtered in (("plain", False), ("filtered", True)):
                off = math.sqrt(float(((taken(samples, filtered, 3) - truth) ** 2).mean()))
                yield f"RMSE at {samples}, {words}, {name}", off, ""
