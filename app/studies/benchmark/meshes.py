"""Rays that meet a mesh, one thread: a part of `lensbench bench`."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import lensbench as lb
from lensbench.app.studies.timing import FILM, least_times
from lensbench.kernels import block
from lensbench.kernels.block import B, L, X
from lensbench.kernels.cache import njit
from lensbench.kernels.program import Program, run_steps

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
    turn, part = random.uniform(0.0, 2.0 * np.pi, len(x)), np.sqrt(random.random(len(x)))
    lens = PUPIL_RADIUS * np.column_stack([part * np.cos(turn), part * np.sin(turn), 0.0 * part])
    inside = np.array([0.0, 0.0, -800.0]) + random.uniform(-300.0, 300.0, slopes.shape)
    begin = random.normal(0.0, 100.0, slopes.shape)
    found = {"pinhole": (np.zeros_like(slopes), slopes), "f/2, in focus": (lens, slopes * NEAREST - lens),
             "f/2, focused at 2 m": (lens, slopes * 2000.0 - lens), "scattered": (begin, inside - begin)}
    rays = {}
    for name, (origins, ways) in found.items():
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        table = np.concatenate([origins, ways], 1).astype(np.float32)
        rays[name] = np.ascontiguousarray(table.reshape(-1, B, L + 3 - X).transpose(0, 2, 1))
    return rays
