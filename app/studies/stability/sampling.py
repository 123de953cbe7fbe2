"""Errors of pupil samples: regions drawn too small or too large, and differentials at the edge of the pupil."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.samplers import white_noise
from lensbench.app.studies.stability.pupils import FilmPoint, passing, sampled
from lensbench.app.studies.stability.sweep import LOST, Sweep, curve
from lensbench.app.studies.timing import even_points
from lensbench.core.kernels.block import PITCH, U0, U1, B, Step, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sample_pixels
from lensbench.core.pupils.radial_sampler import PupilTable

LENS = "pbrt-dgauss-50mm"
FIELD = 18.0                    # mm: film radius at which the region is a cat's eye
REACH = 22.0                    # mm: half the film diagonal
SAMPLES = 64                    # samples of each of B pixels
EVEN = 1 << 14                  # even points of the unit square, for figures without noise
NOISE = 0.05                    # share of the light
RAYS = 24                       # rays at the edge of the pupil


@lru_cache(maxsize=2)
def _region(radius: float) -> tuple[FilmPoint, PupilTable]:
    """Film point at this radius (mm), and its region table at the true size."""
    lens = lenses.load(LENS)
    film_distance = lb.film_distance(lens, math.inf)
    return (FilmPoint(lens, film_distance, (radius, 0.0), REACH),
            PupilTable.of(lens, film_distance, REACH, widened=False))


def _light(radius: float, size: float, uv: np.ndarray, turn: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Light of each sample (n, 2) in mm², from a region drawn `size` times as wide; and which samples pass.

    turn: direction of an edge through the middle of the region, behind which it is dark; None: an even scene.
    """
    point, table = _region(radius)
    points, area = sampled(point, replace(table, outline=table.outline * size))(uv)
    passed = passing(point, points)
    if turn is not None:
        middle = np.array([table.centre(np.array([radius]))[0], 0.0])
        passed_light = passed & ((points - middle) @ [math.cos(turn), math.sin(turn)] > 0.0)
    else:
        passed_light = passed
    return area * passed_light, passed


def lost_light() -> Sweep:
    """Regions drawn too small."""
    values = np.geomspace(1e-4, 0.3, 15)

    def lost(radius: float, less: float) -> float:
        whole, inner = (_light(radius, size, even_points(EVEN), None)[0].mean() for size in (1.03, 1.0 - less))
        return abs(1.0 - float(inner / whole))

    curves = [curve(name, [lost(radius, less) for less in values], True, "regions are drawn 1.004 × as wide")
              for name, radius in (("on the axis", 0.0), ("cat's eye", FIELD))]
    return Sweep("A region drawn too small", "Part of its width that is left out", "", values, "Light", "", 0.01,
                  "a hundredth: a step that can be visible in an even sky", tuple(curves),
                  "Light that is not sampled is a bias, which no number of samples removes.")


@lru_cache(maxsize=2)
def _numbers(kernel) -> np.ndarray:
    """Places in the pupil (SAMPLES, B, 2) of B pixels."""
    program = Program([Step(kernel, [B, 1])], np.float64)
    film, lanes = np.zeros((1, 3 * B)), lane_buffer(np.float64)
    samples = np.empty((SAMPLES, B, 2))
    for k in range(SAMPLES):
        program.expose(film, lanes, 0, 1, k, 1, np.uint32(1))
        for j, row in enumerate((U0, U1)):
            samples[k, :, j] = lanes[row * PITCH:row * PITCH + B]
    return samples


def noise(radius: float) -> Sweep:
    """Regions drawn too large."""
    passing_part = np.geomspace(0.98, 0.02, 14)
    turn = 0.4

    def rms(kernel, size: float, edge: float | None) -> float:
        numbers = _numbers(kernel)
        truth = _light(radius, 1.02, even_points(1 << 16), edge)[0].mean()
        light = _light(radius, size, numbers.reshape(-1, 2), edge)[0].reshape(SAMPLES, B).mean(0)
        return float(np.sqrt(((light / truth - 1.0) ** 2).mean()))

    curves = [curve(f"{name}, {scene}", [rms(kernel, 1.0 / math.sqrt(share), edge) for share in passing_part],
                    kernel is sample_pixels, "a region of its own for every film point: 98 in 100 pass")
              for scene, edge in (("even scene", None), ("an edge across the pupil", turn))
              for name, kernel in (("scrambled net", sample_pixels), ("white noise", white_noise))]
    where = "on the axis" if radius == 0.0 else "of a cat's eye"
    return Sweep(f"Noise against what passes, {where}", "Part of the samples that pass", "", passing_part,
                  f"Light of {SAMPLES} samples", "", NOISE, "a twentieth of the light", tuple(curves),
                  "Blocked samples have a cost: they add noise even to an even sky.")


def differentials() -> Sweep:
    """Rays that approach the edge of the pupil."""
    values = np.geomspace(0.1, 1e-12, 23)
    camera = lb.LensCamera(lenses.load(LENS), lb.Film(36.0, 24.0, 960, 640), math.inf)
    turn = (np.arange(RAYS) + 0.37) / RAYS
    raster = np.tile([960.0 * (0.5 - 12.0 / 36.0), 640.0 * (0.5 + 6.0 / 24.0)], (RAYS, 1))
    edge = _edge(camera, raster, turn)
    own: dict[str, list[float | str]] = {"at the same place of the pupil, float64": [],
                                         "at the same place of the pupil, float32": []}
    neighbour: list[float | str] = []
    for left in values:
        uv = _pupil_uv(turn, edge * (1.0 - left))
        truth = _slopes(camera, raster, uv)
        for name, real in zip(own, (np.float64, np.float32), strict=True):
            _, dx, _ = camera.generate_ray_differentials(raster, uv, dtype=real)
            lit = np.isfinite(truth).all(1) & (camera.generate_rays(raster, uv, dtype=real).weights > 0.0)
            off = np.linalg.norm(dx.directions - truth, axis=1)[lit] / np.linalg.norm(truth, axis=1)[lit]
            own[name].append(float(off.max()) if off.size and np.isfinite(off).all() else "NaN" if off.size else LOST)
        rays, next_rays = (camera.generate_rays(raster + [step, 0.0], uv) for step in (0.0, 1.0))
        if (next_rays.weights[rays.weights > 0.0] > 0.0).all():
            off = np.linalg.norm(next_rays.directions - rays.directions - truth, axis=1) / np.linalg.norm(truth, axis=1)
            neighbour.append(float(off[rays.weights > 0.0].max()))
        else:
            neighbour.append(LOST)
    curves = [curve("the next pixel's ray", neighbour), *(curve(name, errors, True) for name, errors in own.items())]
    return Sweep("Differentials at the edge of the pupil", "Part of the way to the rim that is left", "", values,
                  "Change of direction a pixel", "", 0.01, "a hundredth of a pixel's footprint", tuple(curves),
                  "The ray of the next pixel with the same random numbers passes another point of the pupil, and at "
                  "the rim it is blocked. The program also tries neighbours on the other side, and nearer ones.")


def _edge(camera: lb.LensCamera, raster: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Largest share of the pupil's area, from its centre, at which rays in these directions still pass, by halving."""
    low, high = np.zeros(len(turn)), np.ones(len(turn))
    for _ in range(50):
        middle = 0.5 * (low + high)
        passed = camera.generate_rays(raster, _pupil_uv(turn, middle)).weights > 0.0
        low, high = np.where(passed, middle, low), np.where(passed, high, middle)
    return low


def _pupil_uv(turn: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Pupil samples (n, 2) in directions (n,), as parts of a turn, on rings that enclose shares (n,) of the area."""
    way = np.stack([np.cos(2.0 * math.pi * turn), np.sin(2.0 * math.pi * turn)], 1)
    return 0.5 + 0.5 * np.sqrt(share)[:, None] * way / np.abs(way).max(1)[:, None]


def _slopes(camera: lb.LensCamera, raster: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Reference differentials (n, 3) by the scalar tracer without rims: change a pixel, through the same rear point."""
    lens, end = camera.lens, camera.lens.length + camera.film_distance
    rays = camera.generate_rays(raster, uv)
    back = lb.trace(lens, rays.origins + [0.0, 0.0, end], -rays.directions, clip=False, forward=True)
    rear = back.points + ((lens.length - back.points[:, 2]) / back.directions[:, 2])[:, None] * back.directions

    def directions(step: float) -> np.ndarray:
        film = np.column_stack([(0.5 - (raster[:, 0] + step) / 960.0) * 36.0, (raster[:, 1] / 640.0 - 0.5) * 24.0,
                                np.full(len(raster), end)])
        return lb.trace(lens, film, rear - film, clip=False, forward=False).directions

    step = 0.5
    near, far = ((directions(k * step) - directions(-k * step)) / (2.0 * k * step) for k in (1, 2))
    return (4.0 * near - far) / 3.0


SWEEPS: dict[str, Callable[[], Sweep]] = {
    "A region drawn too small": lost_light, "Noise against what passes, on the axis": lambda: noise(0.0),
    "Noise against what passes, of a cat's eye": lambda: noise(FIELD),
    "Differentials at the edge of the pupil": differentials}
