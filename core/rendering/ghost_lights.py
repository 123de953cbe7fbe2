"""The lights whose ghosts a picture shows, and the cells of light by which they fall on the film.

Lights: the sun and the small lights of a scene, in or outside the picture; camera frame, mm. What hides a light, and
fog in front of it, dims all its ghosts by the mean of a few hundred rays between light and lens. The sun lies at the
distance of the sky.

Cells: the light between neighbouring rays of a grid, spread over the pixels that it covers; raster points in pixels.
Four rays bound a cell, which lands on the film as two triangles. A cell has the mean light of its corners; a blocked
corner has none. The light of a triangle is spread evenly over the pixels whose middles it covers, or falls on one pixel
where it is smaller than half a pixel. Ghosts cover each other many times, so that light is kept by its edges: what
begins at a pixel of a line, and ends before another one. The sum along the line is then the light of each pixel.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.kernels.block import BLUE, EMITS, GREEN, RED, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.sky import FAR
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.small_lights import SmallLight, light_samples, small_lights

SMALL = 0.5             # pixels: area of a triangle whose light falls on one pixel
LARGEST = 1e6           # pixels: a corner farther out belongs to a ray that grazes, and the cell is left out


@njit(nogil=True, cache=True, error_model="numpy")
def add_cells(edges, landed, cells, across, top, bottom, gain):
    """Add the light of a grid of (cells + 1)² rays, `landed` as of `GhostTracer.trace`, to the rows top … bottom − 1.

    edges: (rows, across + 1, 3) float64, what the light of a pixel has more than that of the pixel before. gain (3,):
    factor on red, green and blue.
    """
    wide = cells + 1
    light = np.zeros(3, np.float32)
    for j in range(cells):
        for i in range(cells):
            a = j * wide + i
            b, c, d = a + 1, a + wide, a + wide + 1
            total = landed[2, a] + landed[2, b] + landed[2, c] + landed[2, d]
            if not total > 0.0:
                continue
            y0, y1, y2, y3 = landed[1, a], landed[1, b], landed[1, c], landed[1, d]
            known = (abs(y0) < LARGEST) & (abs(y1) < LARGEST) & (abs(y2) < LARGEST) & (abs(y3) < LARGEST)
            if known & ((max(max(y0, y1), max(y2, y3)) < top) | (min(min(y0, y1), min(y2, y3)) >= bottom)):
                continue
            for k in range(3):
                r = 2 + k
                light[k] = np.float32(0.125) * gain[k] * (landed[r, a] + landed[r, b] + landed[r, c] + landed[r, d])
            if known & (abs(landed[0, a] + landed[0, b] + landed[0, c] + landed[0, d]) < 4.0 * LARGEST):
                _add_triangle(edges, landed, a, b, d, light, across, top, bottom)
                _add_triangle(edges, landed, a, d, c, light, across, top, bottom)
            else:
                _add_corners(edges, landed, a, b, c, d, gain, across, top, bottom)


@njit(nogil=True, cache=True, error_model="numpy")
def _add_corners(edges, landed, a, b, c, d, gain, across, top, bottom):
    """The light of a cell some of whose rays have no place on the film: each corner's on its own pixel."""
    for corner in (a, b, c, d):
        x, y = landed[0, corner], landed[1, corner]
        if (landed[2, corner] > 0.0) & (x >= 0.0) & (x < across) & (y >= top) & (y < bottom):
            for k in range(3):
                _add_run(edges[int(y) - top], int(x), int(x) + 1, k, np.float32(0.25) * gain[k] * landed[2 + k, corner])


@njit(nogil=True, cache=True, error_model="numpy")
def _add_triangle(edges, landed, a, b, c, light, across, top, bottom):
    x0, y0, x1, y1, x2, y2 = landed[0, a], landed[1, a], landed[0, b], landed[1, b], landed[0, c], landed[1, c]
    area = abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) * 0.5
    if area < SMALL:
        x, y = (x0 + x1 + x2) / 3.0, (y0 + y1 + y2) / 3.0
        if (x >= 0.0) & (x < across) & (y >= top) & (y < bottom):
            for k in range(3):
                _add_run(edges[int(y) - top], int(x), int(x) + 1, k, light[k])
        return
    left, right = min(x0, min(x1, x2)), max(x0, max(x1, x2))
    if (right < 0.0) | (left >= across):
        return

    # Order the corners downwards, and loop over the middles of the rows
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    if y2 < y0:
        x0, y0, x2, y2 = x2, y2, x0, y0
    if y2 < y1:
        x1, y1, x2, y2 = x2, y2, x1, y1
    red, green, blue = light[0] / area, light[1] / area, light[2] / area
    long = (x2 - x0) / (y2 - y0) if y2 > y0 else 0.0
    upper = (x1 - x0) / (y1 - y0) if y1 > y0 else 0.0
    lower = (x2 - x1) / (y2 - y1) if y2 > y1 else 0.0
    first = max(int(math.ceil(max(y0, -1.0) - 0.5)), top)
    last = min(int(math.ceil(min(y2, 1.0 + bottom) - 0.5)), bottom)
    for line in range(first, last):
        y = line + 0.5
        one = x0 + (y - y0) * long
        other = x0 + (y - y0) * upper if y < y1 else x1 + (y - y1) * lower
        begin = max(int(math.ceil(max(min(one, other), -1.0) - 0.5)), 0)
        end = min(int(math.ceil(min(max(one, other), across + 1.0) - 0.5)), across)
        if begin < end:
            row = edges[line - top]
            _add_run(row, begin, end, 0, red)
            _add_run(row, begin, end, 1, green)
            _add_run(row, begin, end, 2, blue)


@njit(nogil=True, cache=True, error_model="numpy", inline="always")
def _add_run(row, begin, end, k, light):
    """Light of a channel from pixel `begin` on, before pixel `end`."""
    row[begin, k] += light
    row[end, k] -= light


@njit(nogil=True, cache=True, error_model="numpy")
def add_lines(sums, edges, first):
    """Add the light that `edges` hold, (rows, across + 1, 3), to sums (pixels, 3) from the pixel `first` on."""
    p = first
    for j in range(edges.shape[0]):
        red, green, blue = 0.0, 0.0, 0.0
        for i in range(edges.shape[1] - 1):
            red, green, blue = red + edges[j, i, 0], green + edges[j, i, 1], blue + edges[j, i, 2]
            # Rounding may leave a little less than nothing behind the last edge
            sums[p, 0] += max(red, 0.0)
            sums[p, 1] += max(green, 0.0)
            sums[p, 2] += max(blue, 0.0)
            p += 1


MOST_LIGHTS = 2000      # the brightest ones at the lens; the others cast no ghosts
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
RAYS = 256              # that find how much of a light the lens sees


class GhostLight(NamedTuple):
    """A light as the entrance of the lens sees it."""

    points: np.ndarray      # (n, 4) points of it: place and 1, or for the sun direction and 0; the first is its middle
    irradiance: np.ndarray  # (3,) on a surface at the first vertex that faces it, radiance × steradian


class GhostLights(NamedTuple):
    """The lights of a scene for ghosts, the brightest first."""

    lights: list[GhostLight]
    left_out: int           # lights beyond MOST_LIGHTS
    left_share: float       # their part of the light at the lens


def ghost_lights(camera: Camera, scene: Scene, front_z: float, reach: float) -> GhostLights:
    """The lights before a lens at rest.

    front_z: of the first vertex (mm, camera frame). reach: radius (mm) of the part of its plane that light enters.
    """
    pose = np.asarray(camera.world_from_camera, float)
    rotation = pose[:3, :3].T / np.linalg.norm(pose[:3, 0]) ** 2
    vertex = np.array([0.0, 0.0, front_z])
    lights: list[GhostLight] = []
    if scene.sun is not None and not scene.enclosed:
        lights += _sun(camera, scene, rotation, vertex, reach)
    small = small_lights(scene.objects, tuple(pose[:3, 3]))
    if small:
        lights += _small(camera, scene, small, pose, vertex, reach)
    lights = [light for light in lights if light.irradiance.max() > 0.0]
    lights.sort(key=lambda light: -float(light.irradiance.sum()))
    total = sum(float(light.irradiance.sum()) for light in lights)
    left = sum(float(light.irradiance.sum()) for light in lights[MOST_LIGHTS:])
    return GhostLights(lights[:MOST_LIGHTS], max(0, len(lights) - MOST_LIGHTS), left / total if total else 0.0)


def _disk(n: int) -> np.ndarray:
    """(n, 2) even points of the unit disk."""
    k = np.arange(n)
    radius, turn = np.sqrt((k + 0.5) / n), 2.0 * math.pi * (k * GOLDEN % 1.0)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])


def _sun(camera: Camera, scene: Scene, rotation: np.ndarray, vertex: np.ndarray, reach: float) -> list[GhostLight]:
    sun = scene.sun
    assert sun is not None
    towards = rotation @ np.asarray(sun.direction, float)
    towards /= np.linalg.norm(towards)
    side = np.cross(towards, [0.0, 1.0, 0.0] if abs(towards[1]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    up = np.cross(side, towards)
    disk = math.tan(sun.angular_radius) * _disk(RAYS)
    directions = towards + disk[:, :1] * side + disk[:, 1:] * up
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    through = vertex + reach * (_disk(RAYS)[::-1] @ np.stack([side, up]))
    steps = [*camera.carried, *scene.depth_steps(camera.shutter_open)]
    inputs = dict(zip((X, Y, Z, L, M, N, WEIGHT), (*through.T, *directions.T, np.ones(RAYS)), strict=True))
    hidden = Program(steps).run(inputs, [GREEN], RAYS)[0] > 0.0
    points = np.column_stack([np.vstack([towards, directions]), np.zeros(RAYS + 1)])
    visible = 1.0 - hidden.mean()
    if camera.medium is not None:
        visible = visible * camera.medium.transmittance(FAR)
    return [GhostLight(points, math.pi * np.asarray(sun.colour, float) * visible)]


def _small(camera: Camera, scene: Scene, small: list[SmallLight], pose: np.ndarray, vertex: np.ndarray, reach: float
           ) -> list[GhostLight]:
    """The small lights with what the lens sees of them, all in one run of the scene's stages."""
    back = np.linalg.inv(pose)
    rotation, shift = back[:3, :3], back[:3, 3]
    samples = light_samples(scene.objects)
    count = 64
    disk = _disk(count)
    origins, directions, marks, areas, spots = [], [], [], [], []
    for light in small:
        centre = rotation @ np.asarray(light.centre) + shift
        towards = centre - vertex
        distance = float(np.linalg.norm(towards))
        towards /= distance
        side = np.cross(towards, [0.0, 1.0, 0.0] if abs(towards[1]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        across = np.stack([side, np.cross(side, towards)])
        if any(light.right):
            axes = np.stack([rotation @ np.asarray(light.right), rotation @ np.asarray(light.up)])
            normal = np.cross(*axes)
            is_round = scene.objects[light.number].round
            area = abs(float(normal @ towards)) * (math.pi if is_round else 4.0)
            points = centre + samples[light][:count, :2].astype(float) @ axes
        else:
            area, points = math.pi * light.radius**2, centre + 0.95 * light.radius * (disk @ across)
        starts = vertex + reach * (disk[::-1] @ across)
        away = points - starts
        origins.append(starts)
        directions.append(away / np.linalg.norm(away, axis=1)[:, None])
        marks.append(2.0 + light.number)
        areas.append(area / distance**2)
        spots.append(np.column_stack([np.vstack([centre, points]), np.ones(count + 1)]))
    n = count * len(small)
    inputs = dict(zip((X, Y, Z, L, M, N, WEIGHT), (*np.concatenate(origins).T, *np.concatenate(directions).T,
                                                  np.ones(n)), strict=True))
    medium = camera.medium
    steps = [*camera.carried, *scene.marking_steps(scene.objects), *([] if medium is None else medium.dimming)]
    met, *colours = Program(steps).run(inputs, [EMITS, RED, GREEN, BLUE], n).reshape(4, len(small), count).astype(float)
    visible = met == np.array(marks)[:, None]
    radiance = np.stack([np.where(visible, np.nan_to_num(colour), 0.0).mean(1) for colour in colours], 1)
    return [GhostLight(spot, area * colour) for spot, area, colour in zip(spots, areas, radiance, strict=True)]
