"""The lights whose ghosts a picture shows: the sun and the small lights of a scene, in or outside the picture.

Camera frame, mm. What hides a light, and fog in front of it, dims all its ghosts by the mean of a few hundred rays
between light and lens. The sun lies at the distance of the sky.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.kernels.block import BLUE, EMITS, GREEN, RED, WEIGHT, L, M, N, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.scenery.intersect.sky import FAR
from lensbench.scenery.scene import Scene
from lensbench.scenery.small_lights import SmallLight, light_samples, small_lights

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
    place = np.asarray(camera.world_from_camera, float)
    rotation = place[:3, :3].T / np.linalg.norm(place[:3, 0]) ** 2
    vertex = np.array([0.0, 0.0, front_z])
    found: list[GhostLight] = []
    if scene.sun is not None and not scene.enclosed:
        found += _sun(camera, scene, rotation, vertex, reach)
    small = small_lights(scene.objects, tuple(place[:3, 3]))
    if small:
        found += _small(camera, scene, small, place, vertex, reach)
    found = [light for light in found if light.irradiance.max() > 0.0]
    found.sort(key=lambda light: -float(light.irradiance.sum()))
    total = sum(float(light.irradiance.sum()) for light in found)
    left = sum(float(light.irradiance.sum()) for light in found[MOST_LIGHTS:])
    return GhostLights(found[:MOST_LIGHTS], max(0, len(found) - MOST_LIGHTS), left / total if total else 0.0)


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
    given = dict(zip((X, Y, Z, L, M, N, WEIGHT), (*through.T, *directions.T, np.ones(RAYS)), strict=True))
    hidden = Program(steps).run(given, [GREEN], RAYS)[0] > 0.0
    points = np.column_stack([np.vstack([towards, directions]), np.zeros(RAYS + 1)])
    visible = 1.0 - hidden.mean()
    if camera.medium is not None:
        visible = visible * camera.medium.transmittance(FAR)
    return [GhostLight(points, math.pi * np.asarray(sun.colour, float) * visible)]


def _small(camera: Camera, scene: Scene, small: list[SmallLight], place: np.ndarray, vertex: np.ndarray, reach: float
           ) -> list[GhostLight]:
    """The small lights with what the lens sees of them, all in one run of the scene's stages."""
    back = np.linalg.inv(place)
    rotation, shift = back[:3, :3], back[:3, 3]
    samples = light_samples(scene.objects)
    each = 64
    disk = _disk(each)
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
            points = centre + samples[light][:each, :2].astype(float) @ axes
        else:
            area, points = math.pi * light.radius**2, centre + 0.95 * light.radius * (disk @ across)
        starts = vertex + reach * (disk[::-1] @ across)
        away = points - starts
        origins.append(starts)
        directions.append(away / np.linalg.norm(away, axis=1)[:, None])
        marks.append(2.0 + light.number)
        areas.append(area / distance**2)
        spots.append(np.column_stack([np.vstack([centre, points]), np.ones(each + 1)]))
    n = each * len(small)
    given = dict(zip((X, Y, Z, L, M, N, WEIGHT), (*np.concatenate(origins).T, *np.concatenate(directions).T,
                                                  np.ones(n)), strict=True))
    medium = camera.medium
    steps = [*camera.carried, *scene.marking_steps(scene.objects), *([] if medium is None else medium.dimming)]
    met, *seen = Program(steps).run(given, [EMITS, RED, GREEN, BLUE], n).reshape(4, len(small), each).astype(float)
    visible = met == np.array(marks)[:, None]
    radiance = np.stack([np.where(visible, np.nan_to_num(colour), 0.0).mean(1) for colour in seen], 1)
    return [GhostLight(spot, area * colour) for spot, area, colour in zip(spots, areas, radiance, strict=True)]
