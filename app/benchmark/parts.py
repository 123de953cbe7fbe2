"""The parts of `lensbench bench`: speed on this machine, as ratios within one run where possible.

Timings that are compared run in turn, and the least of many is kept, because other load of the machine can only add
time. Speeds in millions a second, lengths in mm.
"""

import itertools
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench import tone
from lensbench.app.bench.tone import decibels
from lensbench.app.studies.charts.samplers import COUNTS, DEFAULT, WHITE, gains, samplers, scenes, squares
from lensbench.app.studies.timing import BLOCKS, FILM, LENS, even_points, least_times, streamed, time_in_turn
from lensbench.core.cameras.fisheye import PROJECTIONS
from lensbench.core.cameras.lens_settings import MODELS
from lensbench.core.cameras.without_lens import LAYOUTS
from lensbench.core.kernels import block
from lensbench.core.kernels.block import B, L, X
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, run_steps
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.pupils.radial_sampler import POINTS, PupilTable
from lensbench.core.pupils.rim_solver import solve_rims
from lensbench.core.scenery.builtin.library import benchmark_scene, crowded_scene, lamps_scene
from lensbench.core.text import significant
from lensbench.lenses.formats.table import WRITERS
from lensbench.lenses.library.catalogue import path_of

ANAMORPHIC = "lentil-schneider-anamorphic-31-2001"
MANY = 32                       # passes, of which at least one traces small lights


@njit(nogil=True)
def _traced(table, origins, directions, points, after, fate, surface, times):
    for _ in range(times):
        trace_rays(table, True, origins, directions, points, after, fate, surface, None, 0)


def block_against_scalar() -> Iterator[tuple[str, float, str]]:
    """Block tracer against scalar tracer: 512 rays in the first-level cache, 11 surfaces, one thread."""
    lens = lenses.load(LENS)
    distance = lb.first_order(lens).bfl
    rng = np.random.default_rng(1)
    film, rear = rng.uniform(-5.0, 5.0, (2, block.B)), rng.uniform(-6.0, 6.0, (2, block.B))
    directions = np.stack([*(rear - film), np.full(block.B, -distance)], 1)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    rays = dict(zip((block.X, block.Y, block.L, block.M, block.N), (*film, *directions.T), strict=True))
    rays[block.WEIGHT] = np.ones(block.B)
    for real in (np.float32, np.float64):
        origins = np.stack([*film, np.full(block.B, lens.length + distance)], 1).astype(real)
        out = (np.empty((block.B, 3), real), np.empty((block.B, 3), real),
               np.empty(block.B, np.int32), np.empty(block.B, np.int32))
        best = least_times({
            "block": streamed(surface_steps(lens, distance), rays, real),
            "scalar": partial(_traced, surface_table(lens, dtype=real), origins, directions.astype(real), *out, 2)})
        name = np.dtype(real).name
        fast, scalar = BLOCKS * block.B / best["block"] / 1e6, 2 * block.B / best["scalar"] / 1e6
        yield f"block tracer {name}", fast, "Mrays/s"
        yield f"scalar reference {name}", scalar, "Mrays/s"
        yield f"block / scalar {name}", fast / scalar, "×"


def fused() -> Iterator[tuple[str, float, str]]:
    """Whole samples: double Gauss traced in full, ten spheres, floor, sky, sun without shadows, 640 × 360."""
    scene, camera = benchmark_scene(), lb.LensCamera(lenses.load(LENS), FILM, 1200.0)
    steps = [*sampling_steps(FILM.pixels_x, FILM.pixels_y, lit=False), *camera.steps(), *scene.steps(shadows=False)]
    count = -(-FILM.pixels_x * FILM.pixels_y // block.B)
    sums, bench = np.zeros((count, 3 * block.B), np.float32), block.lane_buffer()
    grown = {step.kernel.__name__: Program(steps[:i + 1]) for i, step in enumerate(steps)}
    best = least_times({name: partial(program.expose, sums, bench, 0, count, 0, 2, np.uint32(0))
                  for name, program in grown.items()}, 0.15)
    before = 0.0
    for name, seconds in best.items():
        nanoseconds = seconds / (2 * count * block.B) * 1e9
        yield f"stage {name}", nanoseconds - before, "ns"
        before = nanoseconds
    yield "fused render, one thread", 1e3 / before, "Msamples/s"
    for model in ("trace", "polynomial", "thin", "pinhole"):
        view = lb.LensCamera(lenses.load(LENS), FILM, 1200.0, model=model)
        rendering = lb.Rendering(view, scene, shadows=False)
        seconds = least_times({"add": partial(rendering.add, 8, threads=2)}, 0.5)["add"]
        yield f"fused render, two threads, {model}", FILM.pixels_x * FILM.pixels_y * 8 / seconds / 1e6, "Msamples/s"
    for name in ("still-life", "night-lights"):
        rendering = lb.Rendering(camera, lb.builtin_scene(name))
        rendering.add(4, threads=2)
        seconds = least_times({"add": partial(rendering.add, MANY, threads=2)}, 0.5)["add"]
        yield f"{name} with shadows, two threads", FILM.pixels_x * FILM.pixels_y * MANY / seconds / 1e6, "Msamples/s"


def crowds() -> Iterator[tuple[str, float, str]]:
    """Whole samples of many spheres, and of ten under many lamps, with shadows, one thread, perspective camera."""
    scenes = {f"{count} spheres": crowded_scene(count) for count in (10, 1000, 3000)}
    scenes |= {f"{count} lamps": lamps_scene(count) for count in (16, 50, 200, 1000)}
    best = least_times({name: partial(lb.Rendering(lb.PerspectiveCamera(FILM), scene, light_tracing=False).add, 1,
                                      threads=1) for name, scene in scenes.items()})
    for name, seconds in best.items():
        yield f"{name} with shadows, a sample", 1e9 * seconds / (FILM.pixels_x * FILM.pixels_y), "ns"


def cameras() -> Iterator[tuple[str, float, str]]:
    """Every camera kind in front of still-life without shadows, two threads; each against the perspective camera.

    First without light tracing, then with it. Only some passes trace small lights, so the latter is timed over MANY
    passes.
    """
    lens, scene = lenses.load(LENS), lb.builtin_scene("still-life")
    kinds: dict[str, lb.Camera] = {"perspective": lb.PerspectiveCamera(FILM)}
    kinds["perspective with a lens"] = lb.PerspectiveCamera(FILM, lens_radius=10.0, focus_distance=1200.0)
    kinds["orthographic"] = lb.OrthographicCamera(FILM, 1000.0)
    kinds["orthographic with a lens"] = lb.OrthographicCamera(FILM, 1000.0, 10.0, 1200.0)
    kinds.update({layout: lb.EnvironmentCamera(FILM, layout) for layout in LAYOUTS})
    kinds.update({f"{name} fisheye": lb.FisheyeCamera(FILM, math.pi, name, "diagonal") for name in PROJECTIONS})
    kinds.update({f"lens, {model}": lb.LensCamera(lens, FILM, 1200.0, model=model) for model in MODELS})
    alone: dict[str, Callable[[], object]] = {}
    lit: dict[str, Callable[[], object]] = {}
    for name, camera in kinds.items():
        alone[name] = partial(lb.Rendering(camera, scene, shadows=False, light_tracing=False).add, 4, threads=2)
        rendering = lb.Rendering(camera, scene, shadows=False)
        rendering.add(4, threads=2)
        lit[f"{name}, with small lights"] = partial(rendering.add, MANY, threads=2)
    best = least_times(alone | lit)
    for name, seconds in best.items():
        passes = 4 if name in alone else MANY
        yield f"still-life, no shadows, {name}", FILM.pixels_x * FILM.pixels_y * passes / seconds / 1e6, "Msamples/s"
        if name in alone:
            yield f"{name} / perspective", best["perspective"] / seconds, "×"


def pupil() -> Iterator[tuple[str, float, str]]:
    """Solving the exit-pupil regions of 64 film radii; the share of samples that pass, and the light lost."""
    for name in (LENS, "pbrt-fisheye-10mm"):
        lens = lenses.load(name)
        distance = lb.first_order(lens).bfl
        table = PupilTable.of(lens, distance, 21.6)
        radii = np.linspace(0.0, table.radius, 64)
        tolerance = 2e-4 * lens.surfaces[-1].semi_diameter
        seconds = least_times({"solve": partial(solve_rims, lens, distance, radii, POINTS, tolerance)})["solve"]
        yield f"pupil of 64 radii, {name}", seconds * 1e3, "ms"
        radii = np.linspace(0.0, table.radius, 24)
        exact = lb.exit_pupil(lens, distance, radii, points=1025)
        n = 1 << 16
        uv = even_points(n)
        passing = light = kept = 0.0
        for r, area in zip(radii[:-1], exact.area[:-1], strict=True):
            points, areas = exact.sample(np.tile([r, 0.0], (n, 1)), uv)
            way = np.column_stack([points - [r, 0.0], np.full(n, -distance)])
            passed = lb.trace(lens, [r, 0.0, lens.length + distance], way).fate == lb.Fate.PASSED
            passing += passed.mean() * r
            kept += (areas * passed).mean() * r
            light += area * r
        yield f"samples that pass, {name}", 100.0 * passing / radii[:-1].sum(), "%"
        yield f"light lost, {name}", 100.0 * (1.0 - kept / light), "%"


def setup() -> Iterator[tuple[str, float, str]]:
    """Setting up a camera after its focus has moved: film, exit-pupil regions and stages, one thread."""
    moved = itertools.count()

    def build(lens: lb.Lens) -> None:
        lb.LensCamera(lens, FILM, 1200.0 + 0.01 * next(moved), 4.0).steps()

    works: dict[str, Callable[[], object]] = {
        name: partial(build, lenses.load(name)) for name in (LENS, "pbrt-fisheye-10mm", ANAMORPHIC)}
    for name, seconds in least_times(works).items():
        yield f"camera set up, {name}", seconds * 1e3, "ms"


def sampling() -> Iterator[tuple[str, float, str]]:
    """Number of samples of white noise that give the error of 4, 16, 64 and 256 default samples, as a ratio."""
    for name in ("soft", "still-life"):
        camera, scene = scenes()[name]
        steps = samplers(camera.film)
        ratios = gains(dict(squares(camera, scene, COUNTS, {way: steps[way] for way in (DEFAULT, WHITE)})))
        for count, gain in ratios[DEFAULT].items():
            yield f"gain over white noise at {count}, {name}", gain, "×"


def allocation() -> Iterator[tuple[str, float, str]]:
    """What samples shared out by error win over even ones: variance of tone-mapped values after as many, and in time.

    480 × 320 pixels, camera rays, processor time; the error is that against a picture of 2048 even samples.
    """
    film = lb.Film(36.0, 24.0, 480, 320)
    camera = lb.LensCamera(lenses.load(LENS), film, 1200.0, 2.8)
    for name in ("still-life", "night-lights"):
        scene = lb.builtin_scene(name)
        plain = lb.Rendering(camera, scene, seed=12345, light_tracing=False, adaptive=False)
        plain.add(2048)
        truth = tone.develop(plain.image(), 0.0, "filmic")
        renderings = [lb.Rendering(camera, scene, seed=1, light_tracing=False, adaptive=adaptive)
                      for adaptive in (False, True)]
        seconds = [0.0, 0.0]
        for count in (16, 32, 64, 128, 256):
            variances = []
            for k, rendering in enumerate(renderings):
                start = time.process_time()
                rendering.add(count - rendering.samples, threads=1)
                seconds[k] += time.process_time() - start
                variances.append(((tone.develop(rendering.image(), 0.0, "filmic") - truth) ** 2).mean())
            if count in (64, 256):
                gain = variances[0] / variances[1]
                yield f"variance, even / shared samples, {name}, {count}", gain, "×"
                yield f"the same in as much time, {name}, {count}", gain * seconds[0] / seconds[1], "×"


def light_tracing_errors() -> Iterator[tuple[str, float, str]]:
    """Displayed error of small lights with light tracing against camera rays alone, by samples and by time.

    Root mean square of tone-mapped values (0 to 1, filmic), 240 × 160 pixels, from a picture of 4096 camera samples.
    """
    film = lb.Film(36.0, 24.0, 240, 160)
    camera, night = lb.LensCamera(lenses.load(LENS), film, 1200.0, 2.0), lb.builtin_scene("night-lights")
    away = replace(night, spheres=tuple(o for o in night.spheres if o.material.shines), floor=None,
                   plates=tuple(o for o in night.plates if o.material.shines))
    for name, scene in (("night-lights", night), ("its lights without mirrors", away)):
        plain = lb.Rendering(camera, scene, seed=12345, light_tracing=False)
        plain.add(4096)
        truth = tone.develop(plain.image(), 0.0, "filmic")
        for light_tracing, counts in ((True, (1, 4, 16)), (False, (4, 64, 256))):
            rendering = lb.Rendering(camera, scene, seed=1, light_tracing=light_tracing)
            for count in counts:
                rendering.add(count - rendering.samples)
                error = math.sqrt(((tone.develop(rendering.image(), 0.0, "filmic") - truth) ** 2).mean())
                tracing = "with light tracing" if light_tracing else "of the camera"
                yield f"display error, {name}, {count} {tracing}", error * 1e3, "‰"
        rendering, start = lb.Rendering(camera, scene, seed=2), time.process_time()
        while time.process_time() < start + 3.0:
            rendering.add(4)
        error = math.sqrt(((tone.develop(rendering.image(), 0.0, "filmic") - truth) ** 2).mean())
        yield f"display error, {name}, after 3 s of a core", error * 1e3, "‰"
    for name in ("still-life", "night-lights"):
        both: dict[str, Callable[[], object]] = {}
        for light_tracing in (True, False):
            rendering = lb.Rendering(lb.LensCamera(lenses.load(LENS), FILM, 1200.0, 2.0), lb.builtin_scene(name),
                                     light_tracing=light_tracing)
            rendering.add(4)
            both[str(light_tracing)] = partial(rendering.add, MANY, threads=2)
        best = least_times(both, 1.0)
        yield f"later passes with light tracing / without, {name}", best["True"] / best["False"], "×"


def precision() -> Iterator[tuple[str, float, str]]:
    """Single against double precision on 24 megapixels: the worst ray, and the number of different fates."""
    for name in (LENS, "pbrt-fisheye-10mm"):
        lens, n = lenses.load(name), 200_000
        camera = lb.LensCamera(lens, lb.Film(pixels_x=6000, pixels_y=4000))
        rng = np.random.default_rng(5)
        raster, uv = rng.random((n, 2)) * [6000, 4000], rng.random((n, 2))
        aimed = [block.X, block.Y, block.Z, block.L, block.M, block.N]
        rays = Program(camera.steps()[:2]).run({block.X: raster[:, 0], block.Y: raster[:, 1], block.U0: uv[:, 0],
                                                block.U1: uv[:, 1]}, aimed, n)
        steps = surface_steps(lens, camera.film_distance)
        rows = dict(zip([*aimed, block.WEIGHT], [*rays, np.ones(n)], strict=True))
        outputs = [block.L, block.M, block.N, block.WEIGHT]
        single, double = (Program(steps, real).run(rows, outputs, n).astype(float)
                          for real in (np.float32, np.float64))
        both = (single[3] > 0.0) & (double[3] > 0.0)
        off = np.linalg.norm(np.cross(single[:3].T[both], double[:3].T[both]), axis=1)
        yield f"worst float32 ray at 24 MP, {name}", float(off.max()) * camera.first_order.efl / 0.006, "px"
        yield f"fates that differ in {n:,}, {name}", float(((single[3] > 0.0) != (double[3] > 0.0)).sum()), ""


# Lens files, light fields and meshes


CANDIDATES = 12         # lenses with the most surfaces, of which the slowest is sought

ROUNDS = 5              # of each file: fewer, and one pass of the garbage collector is taken for a slow file

FIRST = """
import sys, time
begin = time.perf_counter()
from lensbench import lenses
loaded = lenses.load(sys.argv[1])
between = time.perf_counter()
lenses.check(loaded)
print(between - begin, time.perf_counter() - between)
"""


def files() -> Iterator[tuple[str, float, str]]:
    """The slowest library lens in each format; the first load and check of a new process."""
    longest = sorted(lenses.describe(), key=lambda card: card.surfaces)[-CANDIDATES:]
    names = [card.name for card in longest]
    with tempfile.TemporaryDirectory() as folder:
        for suffix in WRITERS:
            paths = {name: Path(folder) / f"{name}{suffix}" for name in names}
            for name, path in paths.items():
                lenses.save(lenses.load(name), path)
            runs = time_in_turn({name: partial(lenses.load, path) for name, path in paths.items()}, 0.0, ROUNDS)
            yield f"load the slowest {suffix}", max(run.least for run in runs.values()) * 1e3, "ms"
    runs = time_in_turn({name: partial(lenses.check, lenses.load(name)) for name in names}, 0.0, ROUNDS)
    slowest = max(runs, key=lambda name: runs[name].least)
    yield "check the slowest lens", runs[slowest].least * 1e3, "ms"
    first = [_first(str(path_of(slowest))) for _ in range(3)]
    yield "the imports and the first load of a process", min(first)[0] * 1e3, "ms"
    yield "the first check of a process", min(check for _, check in first) * 1e3, "ms"


def _first(path: str) -> tuple[float, float]:
    """Seconds in which a new process imports what it needs and loads a lens file, and in which it checks that."""
    done = subprocess.run([sys.executable, "-c", FIRST, path], capture_output=True, text=True, check=True)
    load, check = done.stdout.split()
    return float(load), float(check)


LIGHT_FIELD_FILM = lb.Film(36.0, 24.0, 640, 427)
VIEWS, SAMPLES = (9, 9), 16
DISTANCES = (900.0, 1500.0, 2500.0)
EDGE = 40                   # pixels: border that not every view sees


def light_fields() -> Iterator[tuple[str, float, str]]:
    """Still life, 9 × 9 views of 640 × 427 pixels with 16 samples, by a thin lens and by a double Gauss."""
    scene = lb.builtin_scene("still-life")
    for model in ("thin", "trace"):
        def camera(distance: float, model: str = model) -> lb.LensCamera:
            return lb.LensCamera(lenses.load(LENS), LIGHT_FIELD_FILM, distance, 2.8, model=model)

        lb.capture_light_field(camera(1200.0), scene, (1, 1), 1)            # compiles
        begin = perf_counter()
        field = lb.capture_light_field(camera(1200.0), scene, VIEWS, SAMPLES)
        yield f"light field recorded, {model}", perf_counter() - begin, "s"
        seconds = least_times({"refocus": partial(field.refocus, 1500.0)})["refocus"]
        yield f"light field focused again, {model}", 1e3 * seconds, "ms"
        for distance in DISTANCES:
            direct = lb.render(camera(distance), scene, 1024)
            inner = slice(EDGE, -EDGE), slice(EDGE, -EDGE)
            yield f"focused at {significant(distance / 1000.0)} m against a camera focused there, {model}", decibels(
                field.refocus(distance)[inner], direct[inner]), "dB"


def choices() -> Iterator[tuple[str, float, str]]:
    """Choosing the simplest model within half a pixel of the full trace."""
    film, scene = lb.Film(36.0, 24.0, 960, 640), lb.builtin_scene("still-life")
    for name, f_number in ((LENS, 2.8), (LENS, 16.0), ("pbrt-fisheye-10mm", None)):
        lens = lenses.load(name)
        choice = lb.choose_model(lb.LensCamera(lens, film, 1200.0, f_number), scene)
        moved = itertools.count(1)                    # a camera keeps its exit-pupil regions and stages

        def choose(lens=lens, f_number=f_number, moved=moved) -> object:
            return lb.choose_model(lb.LensCamera(lens, film, 1200.0 + 0.01 * next(moved), f_number), scene)

        seconds = least_times({"choose": choose})["choose"]
        yield f"model chosen, {name}, {choice.table[-1].name}", 1e3 * seconds, "ms"


RINGS = 145                 # of the bumpy sphere: 82,944 triangles, some of no area at the poles
NEAREST = 600.0             # mm to where it begins, about
PUPIL_RADIUS = 12.5         # mm: a lens of 50 mm at f/2
TILE = 32                   # pixels of a line of a block


@njit(nogil=True, cache=True)
def _all_blocks(lanes, rays, code, key):
    """Run the steps of a Program over blocks of rays (blocks, 6, B), from X to N."""
    for k in range(rays.shape[0]):
        for row in range(6):
            for i in range(B):
                lanes[(X + row) * block.PITCH + i] = rays[k, row, i]
        run_steps(lanes, code, key)


def meshes() -> Iterator[tuple[str, float, str]]:
    """Rays of a pinhole, through f/2 in focus and out of focus, and scattered, to distance, normal and colour."""
    program = Program(lb.Scene("mesh", meshes=(bumpy_sphere(),)).depth_steps(), np.float32)
    lanes, key = block.lane_buffer(np.float32), np.zeros(block.KEYS, np.uint32)
    works: dict[str, Callable[[], object]] = {
        name: partial(_all_blocks, lanes, rays, program.code, key) for name, rays in _rays().items()}
    for name, seconds in least_times(works).items():
        yield f"mesh of 82,944 triangles, one thread, {name}", FILM.pixels_x * FILM.pixels_y / seconds / 1e6, "Mrays/s"


def bumpy_sphere() -> lb.Mesh:
    """The sphere, 800 mm ahead, with a radius of 250 mm."""
    theta, phi = np.linspace(0.0, np.pi, RINGS)[:, None], np.linspace(0.0, 2.0 * np.pi, 2 * RINGS - 1)[None]
    radius = 250.0 * (1.0 + 0.1 * np.sin(9 * theta) * np.cos(11 * phi))
    away = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta) + 0.0 * phi, np.sin(theta) * np.sin(phi)], -1)
    corner = (np.arange(RINGS - 1)[:, None] * (2 * RINGS - 1) + np.arange(2 * RINGS - 2)).ravel()
    below = corner + 2 * RINGS - 1
    faces = np.concatenate([np.stack([corner, corner + 1, below], 1), np.stack([corner + 1, below + 1, below], 1)])
    return lb.Mesh.of((radius[..., None] * away).reshape(-1, 3) + [0.0, 0.0, -800.0], faces)


def _rays() -> dict[str, np.ndarray]:
    """Rays of each kind (blocks, 6, B) for a picture of FILM, in blocks of 32 × 16 pixels."""
    random = np.random.default_rng(1)
    line, column = np.mgrid[0:FILM.pixels_y, 0:FILM.pixels_x].reshape(2, -1)
    order = np.lexsort((column % TILE, line, column // TILE))
    x, y = (column[order] - FILM.pixels_x / 2) / FILM.pixels_x, (line[order] - FILM.pixels_y / 2) / FILM.pixels_x
    slopes = np.column_stack([0.9 * x, 0.9 * y, np.full(len(x), -1.0)])
    turn, radius = random.uniform(0.0, 2.0 * np.pi, len(x)), np.sqrt(random.random(len(x)))
    lens = PUPIL_RADIUS * np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0.0 * radius])
    inside = np.array([0.0, 0.0, -800.0]) + random.uniform(-300.0, 300.0, slopes.shape)
    begin = random.normal(0.0, 100.0, slopes.shape)
    rays_by_kind = {"pinhole": (np.zeros_like(slopes), slopes), "f/2, in focus": (lens, slopes * NEAREST - lens),
             "f/2, focused at 2 m": (lens, slopes * 2000.0 - lens), "scattered": (begin, inside - begin)}
    rays = {}
    for name, (origins, ways) in rays_by_kind.items():
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        table = np.concatenate([origins, ways], 1).astype(np.float32)
        rays[name] = np.ascontiguousarray(table.reshape(-1, B, L + 3 - X).transpose(0, 2, 1))
    return rays


PARTS = {"tracer": block_against_scalar, "render": fused, "crowds": crowds, "cameras": cameras, "pupil": pupil,
         "setup": setup, "sampling": sampling, "allocation": allocation, "light-tracing": light_tracing_errors,
         "precision": precision}
LONG = ("sampling", "allocation", "light-tracing", "precision", "light-field", "differentials")    # minutes each


def parts() -> dict[str, Callable[[], Iterator[tuple[str, float, str]]]]:
    """All parts by name, in the order in which they run; each gives its figures: name, value and unit."""
    from lensbench.app.benchmark.live import analysis, edits, pixels, with_plots
    from lensbench.app.benchmark.renders import differentials, exposure, ghosts, motion, polynomials
    from lensbench.app.benchmark.window import browser, drag, starts, window

    return {"start": starts, "drag": drag, "window": window, "browser": browser, "plots": with_plots,
            "edit": edits, **PARTS, "meshes": meshes, "models": polynomials, "choice": choices, "pixel": pixels,
            "light-field": light_fields, "motion": motion, "exposure": exposure, "analysis": analysis,
            "differentials": differentials, "files": files, "ghosts": ghosts}
