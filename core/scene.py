"""The scene: objects and light as frozen values, and the stages that they become.

World frame, mm: the built-in scenes are laid out for a camera at the origin
that looks along −z, y up. Colours are linear red, green and blue; radiance is
relative, with 1 the radiance of a white surface under a uniform sky of 1.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.lanes import BLUE, DEPTH, GREEN, RED, B, Step, rows, stage
from lensbench.scenery.floor import floor
from lensbench.scenery.light import daylight
from lensbench.scenery.sky import sky, sky_parameters
from lensbench.scenery.spheres import spheres

Triple = tuple[float, float, float]
REACH = 1e8             # mm: farther than this counts as the sky


class SceneError(ValueError):
    """A scene that cannot be; the message says what to do."""


@dataclass(frozen=True)
class Material:
    """What a surface is made of.

    kind: "matte"; "coat", a clear coat over matte that mirrors the light sources and the sky;
    "metal", a mirror tinted by `colour`; "glass" of index 1.5; "light", which emits the radiance `colour`. gloss: strength of a coat, (0, 1].
    """

    colour: Triple = (0.5, 0.5, 0.5)
    kind: str = "matte"
    gloss: float = 1.0


@dataclass(frozen=True)
class Sphere:
    """A sphere, seen from outside: centre and radius in mm."""

    centre: Triple
    radius: float
    material: Material = Material()


@dataclass(frozen=True)
class Floor:
    """An endless checkered plane, seen from above: `height` along its normal from the world's origin, in mm."""

    height: float = -250.0
    tile: float = 100.0
    light: Triple = (0.75, 0.75, 0.75)
    dark: Triple = (0.08, 0.08, 0.08)
    gloss: float = 0.0
    normal: Triple = (0.0, 1.0, 0.0)
    turn: float = 0.0                   # of the tiles about the normal, radians
    offset: tuple[float, float] = (0.0, 0.0)    # of the tiles, in tiles
    fade: float = 4e-4                  # radians: tiles seen smaller than this show their mean


@dataclass(frozen=True)
class Sun:
    """A distant disk: direction towards it, irradiance on a surface that faces it / π, angular radius (radians)."""

    direction: Triple
    colour: Triple = (2.0, 1.9, 1.7)
    angular_radius: float = math.radians(0.27)


@dataclass(frozen=True)
class Sky:
    """Radiance at the zenith, at the horizon and below it; linear in the sine of the height above the horizon."""

    zenith: Triple = (0.25, 0.45, 0.9)
    horizon: Triple = (0.8, 0.85, 0.9)
    ground: Triple = (0.3, 0.28, 0.25)
    up: Triple = (0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Scene:
    """What the camera looks at, compared by value."""

    name: str
    sky: Sky = Sky()
    sun: Sun | None = None
    floor: Floor | None = None
    spheres: tuple[Sphere, ...] = ()
    depth_range: tuple[float, float] = (400.0, 8000.0)      # mm of interest, for scales and charts

    def steps(self, shadows: bool = True) -> list[Step]:
        """The stages from a world ray (X Y Z, L M N) to RED, GREEN, BLUE, its radiance."""
        light = np.concatenate([self._sky, self._sun])
        return [*self._geometry, Step(daylight, light)]

    def depth_steps(self) -> list[Step]:
        """The stages that leave DEPTH alone: RED = DEPTH in mm, GREEN = 1 where it is below REACH, else 0."""
        return [*self._geometry, Step(depth_picture, np.zeros(1))]

    @cached_property
    def _sky(self) -> np.ndarray:
        return sky_parameters(self.sky.zenith, self.sky.horizon, self.sky.ground, self.sky.up)

    @property
    def _sun(self) -> np.ndarray:
        if self.sun is None:
            return np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        return np.array([*_unit(self.sun.direction), *self.sun.colour])

    @property
    def _geometry(self) -> list[Step]:
        steps = [Step(sky, self._sky)]
        if self.floor is not None:
            steps.append(Step(floor, _floor_parameters(self.floor)))
        if self.spheres:
            steps.append(Step(spheres, np.array([_sphere_parameters(s) for s in self.spheres])))
        return steps


@stage
def depth_picture(lanes, p, key):
    """RED: DEPTH in mm; GREEN: 1 where something was hit; BLUE: 0."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, red, green, blue = row[DEPTH], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        red[i] = depth[i]
        green[i] = real(1) if depth[i] < real(REACH) else real(0)
        blue[i] = real(0)


def _unit(v) -> np.ndarray:
    v = np.asarray(v, np.float64)
    return v / math.sqrt(v @ v)


def _floor_parameters(f: Floor) -> np.ndarray:
    normal = _unit(f.normal)
    along = _unit(np.cross(normal, (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (1.0, 0.0, 0.0)))
    across = np.cross(along, normal)
    c, s = math.cos(f.turn), math.sin(f.turn)
    a, b = (c * along + s * across) / f.tile, (c * across - s * along) / f.tile
    light, dark = np.array(f.light), np.array(f.dark)
    return np.array([*normal, f.height, *a, *b, *f.offset, *(light + dark) / 2, *(light - dark) / 2, f.gloss,
                     f.fade / f.tile])


def _sphere_parameters(s: Sphere) -> list[float]:
    return [*s.centre, s.radius**2, 1.0 / s.radius, *s.material.colour, float(s.material.kind == "light"), 0.0]
