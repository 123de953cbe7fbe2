"""Cost of lens files, light fields and meshes."""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count
from pathlib import Path
from time import perf_counter

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.tone import decibels
from lensbench.app.studies.timing import FILM, LENS, least_times, time_in_turn
from lensbench.core.kernels import block
from lensbench.core.kernels.block import B, L, X
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, run_steps
from lensbench.core.text import significant
from lensbench.lenses.formats.table import WRITERS
from lensbench.lenses.library.catalogue import path_of

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
        moved = count(1)                    # a camera keeps its exit-pupil regions and stages

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
