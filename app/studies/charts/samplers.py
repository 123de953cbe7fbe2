"""Samplers for comparison with the default net, and their gain: how many samples of white noise give the same error.

All take the key (pixel, sample, dimension, seed) of the default sampler and fill the same rows. Sources: Roberts 2018
(additive recurrence of the generalised golden ratio); Cools, Kuo and Nuyens 2006 (generating vector of the lattice
sequence); Cranley and Patterson 1976 (a random shift for each pixel).

Pictures have 180 × 120 pixels; patterns are evaluated at points, because a filter would hide the sampler. The error is
the mean square against a converged picture, with light above 4 clipped to 4, over pictures of three seeds.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
from numba import uint32

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.timing import BLOCKS, report_progress, streamed, time_in_turn
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import PIXEL, SAMPLE, SEED, TIME, U0, U1, V0, V1, B, Step, X, Y, rows, stage
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import add_corners, mix, sampling_steps, sobol
from lensbench.core.scenery.objects.basic_shapes import Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Floor, Sun
from lensbench.core.scenery.scene import Scene

_u = np.uint32
DEFAULT, WHITE = "one scrambled net, blue-noise keys (the program's)", "white noise"
_ROWS = np.array([U0, U1, X, Y, V0, V1, TIME])
USED = len(_ROWS)
_ROOT = 1.1127756842787055      # x⁸ = x + 1
_STEPS = np.array([round(2.0**32 * _ROOT**-(d + 1)) % 2**32 for d in range(USED)], np.uint32)
_LATTICE = np.array([1, 182667, 469891, 498753, 110745, 446247, 250185], np.uint32)


@njit(inline="always")
def _seeded(pixel, seed, d):
    """Random number of the pixel for dimension d."""
    return mix(uint32(mix(uint32(pixel + _u(1))) + uint32(seed * _u(0x9E3779B9)) + uint32(_u(d) * _u(0x85EBCA6B))))


@njit(inline="always")
def _shift(lanes, key, d, step):
    """Set dimension d to the step plus a random shift of the pixel, modulo 1."""
    real = lanes.dtype.type
    out = rows(lanes)[_ROWS[d]]
    first, seed, unit = key[PIXEL], key[SEED], real(1 / 16777216)
    for i in range(B):
        number = uint32(_seeded(first + uint32(i), seed, d) + step)
        out[i] = real(np.int32(number >> _u(8))) * unit


@stage
def recurrence(lanes, p, ints, key):
    """Sample k lies k golden steps from a random start of the pixel."""
    for d in range(USED):
        _shift(lanes, key, d, uint32(key[SAMPLE] * _STEPS[d]))


@stage
def lattice(lanes, p, ints, key):
    """Sample k is a point of a rank-1 lattice in van der Corput's order, shifted for each pixel."""
    turned = uint32(0)
    for b in range(32):                 # van der Corput's order
        turned = uint32(turned | uint32((key[SAMPLE] >> _u(b)) & _u(1)) << _u(31 - b))
    for d in range(USED):
        _shift(lanes, key, d, uint32(turned * _LATTICE[d]))


@stage
def scrambled(lanes, p, ints, key):
    """Points of Sobol's sequence, Owen-scrambled for each pixel."""
    real = lanes.dtype.type
    unit = real(1 / 16777216)
    for d in range(USED):
        out = rows(lanes)[_ROWS[d]]
        for i in range(B):
            own = _seeded(key[PIXEL] + uint32(i), key[SEED], 0)
            out[i] = real(np.int32(sobol(key[SAMPLE], d, own) >> _u(8))) * unit


@stage
def white_noise(lanes, p, ints, key):
    """White noise: independent random numbers for all rows of the default samplers. p: width, height (pixels)."""
    real = lanes.dtype.type
    row = rows(lanes)
    u0, u1, x, y, v0, v1, time = row[U0], row[U1], row[X], row[Y], row[V0], row[V1], row[TIME]
    start = mix(uint32(key[SEED] * _u(0x9E3779B9) + key[SAMPLE]))
    unit = real(1 / 16777216)
    step = _u(0x9E3779B9)
    for i in range(B):
        a = mix(uint32(mix(uint32(key[PIXEL] + uint32(i))) + start))
        b = mix(uint32(a + step))
        c = mix(uint32(b + step))
        d = mix(uint32(c + step))
        u0[i] = real(np.int32(a >> _u(8))) * unit
        u1[i] = real(np.int32(b >> _u(8))) * unit
        x[i] = real(np.int32(c >> _u(8))) * unit
        y[i] = real(np.int32(d >> _u(8))) * unit
    for i in range(B):
        e = mix(uint32(mix(uint32(mix(uint32(key[PIXEL] + uint32(i))) + start)) ^ _u(0x68E31DA4)))
        f = mix(uint32(e + step))
        v0[i] = real(np.int32(e >> _u(8))) * unit
        v1[i] = real(np.int32(f >> _u(8))) * unit
        time[i] = real(np.int32(mix(uint32(f + step)) >> _u(8))) * unit
    add_corners(lanes, p, ints, key)


def samplers(film: Film, timed: bool = False) -> dict[str, list[Step]]:
    """Steps of every sampler by its name, the default first. timed: the scene or camera moves."""
    w, h = size = film.pixels_x, film.pixels_y
    corners = Step(add_corners, size)
    return {
        DEFAULT: sampling_steps(w, h, lit=True, timed=timed),
        "Sobol, scrambled for each pixel": [Step(scrambled), corners],
        "rank-1 lattice, shifted": [Step(lattice), corners],
        "additive recurrence, shifted": [Step(recurrence), corners],
        WHITE: [Step(white_noise, size)],
    }


LENS = "pbrt-dgauss-50mm"
FILM = lb.Film(36.0, 24.0, 180, 120)
COUNTS = (4, 16, 64, 256)
SEEDS = 3
BRIGHTEST = 4.0
SHOWN = ("still-life", "night-lights", "focus-ruler", "grid-wall", "room", "fairground")     # scenes of the chart
CONVERGED = 8192                # samples of the reference picture
TINTS = ("vermilion", "blue", "green", "purple", "grey")


def soft_scene() -> tuple[lb.Camera, Scene]:
    """Blur of 5 to 40 pixels, spheres and a coarse checker without its horizon, no small lights."""
    tilt = math.radians(-35.0)
    world = np.eye(4)
    world[1:3, 1:3] = [[math.cos(tilt), -math.sin(tilt)], [math.sin(tilt), math.cos(tilt)]]
    camera = lb.PerspectiveCamera(FILM, fov=0.45, lens_radius=45.0, focus_distance=900.0, world_from_camera=world)
    balls = tuple(Sphere((x, -520.0, z), 80.0, Material(colour)) for x, z, colour in (
        (-160.0, -700.0, (0.8, 0.2, 0.1)), (60.0, -900.0, (0.1, 0.5, 0.5)), (-40.0, -560.0, (0.7, 0.6, 0.2)),
        (220.0, -640.0, (0.3, 0.3, 0.7))))
    return camera, Scene("sampling", sun=Sun((0.4, 0.8, 0.3)), floor=Floor(height=-600.0, tile=160.0),
                         spheres=balls)


def scenes() -> dict[str, tuple[lb.Camera, Scene]]:
    """The soft scene, and built-in ones through a thin lens at f/2."""
    camera = lb.LensCamera(lenses.load(LENS), FILM, 1200.0, 2.0, model="thin")
    return {"soft": soft_scene(), **{name: (camera, lb.builtin_scene(name)) for name in SHOWN}}


def squares(camera: lb.Camera, scene: Scene, counts: tuple[int, ...], steps: dict[str, list],
            converged: int = CONVERGED) -> Iterator[tuple[str, dict[int, float]]]:
    """Mean square error of each sampler after these numbers of samples."""
    truth = np.minimum(lb.render(camera, scene, samples=converged, seed=12345), BRIGHTEST)
    for name, placing in steps.items():
        errors_by_count: dict[int, list[float]] = {count: [] for count in counts}
        for seed in range(SEEDS):
            rendering = lb.Rendering(camera, scene, seed=seed, steps=placing, filtered=False)
            for count in counts:
                rendering.add(count - rendering.samples)
                error = np.minimum(rendering.image(), BRIGHTEST).astype(float) - truth
                errors_by_count[count].append(float((error**2).mean()))
        yield name, {count: float(np.mean(values)) for count, values in errors_by_count.items()}


def gains(errors_by_sampler: dict[str, dict[int, float]]) -> dict[str, dict[int, float]]:
    """Ratio of the samples of white noise, whose mean square error falls as 1 / samples, to those of each sampler."""
    last = max(COUNTS)
    white = errors_by_sampler[WHITE][last] * last
    return {name: {count: white / (error * count) for count, error in errors.items()}
            for name, errors in errors_by_sampler.items()}


def sampling_panels(names: list[str], progress: Callable[[float], bool] = lambda _: True) -> list[Panel]:
    """The panel of each named scene, or of all; progress: receives the finished share, False cancels."""
    costs = {name: time.per_item(BLOCKS * B).least for name, time in time_in_turn(
        {name: streamed(placing, {}) for name, placing in samplers(FILM).items()}, 0.05).items()}
    chosen = {name: what for name, what in scenes().items() if not names or name in names}
    panels = []
    for i, (key, (camera, scene)) in enumerate(chosen.items()):
        errors_by_sampler, steps = {}, samplers(FILM, scene.moves)
        for j, (name, errors) in enumerate(squares(camera, scene, COUNTS, steps)):
            errors_by_sampler[name] = errors
            report_progress(progress, (i + (j + 1) / len(steps)) / len(chosen))
        curves = tuple(
            Curve(name, tint, tuple(gain.items()), {f"gain at {count}, ×": value for count, value in gain.items()}
                  | {"cost, ns": costs[name]})
            for tint, (name, gain) in zip(TINTS, gains(errors_by_sampler).items(), strict=True))
        panels.append(Panel(key, key, "Samples a pixel", "Gain over white noise (×)", curves, ticks=COUNTS))
    return panels
