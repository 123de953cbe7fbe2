"""The scene: objects and light as frozen values, and the stages that they become.

World frame, mm: the built-in scenes are laid out for a camera at the origin
that looks along −z, y up. Colours are linear red, green and blue; radiance is
relative, with 1 the radiance of a white surface under a uniform sky of 1.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np

from lensbench.lanes import BLUE, DEPTH, GREEN, RED, B, Step, rows, stage
from lensbench.scenery.bounce import bounce
from lensbench.scenery.coat import SHARP, coat, coat_parameters
from lensbench.scenery.floor import floor, floor_parameters
from lensbench.scenery.light import RISE0, RISE1, RISE2, RISE4, ambient, begin, daylight, finish, settle
from lensbench.scenery.plates import plate_frame, plate_parameters, plates
from lensbench.scenery.shadows import caster_parameters, lamp, lamp_parameters, sun
from lensbench.scenery.sheen import sheen, sheen_parameters
from lensbench.scenery.sky import sky, sky_parameters, sun_disk
from lensbench.scenery.spheres import sphere_parameters, spheres

Triple = tuple[float, float, float]
REACH = 1e8             # mm: farther than this counts as the sky
BOUNCES = 3             # how often a path goes on at metal or glass
GLEAMS = 64             # lights that a rough coat mirrors: those that are brightest from the origin
GLEAM_RADIUS = math.radians(1.5)        # the sun in mirrors and coats is no smaller, its light the same
MATERIALS = ("matte", "coat", "metal", "glass", "light", "lamp")
PATTERNS = ("checker", "grid", "star", "ruler", "image")


class SceneError(ValueError):
    """A scene that cannot be; the message says what to do."""


def _check(value, positive: Sequence[str] = ()) -> None:
    """Refuse numbers that are not finite, and lengths that are not positive."""
    for f in fields(value):
        numbers = getattr(value, f.name)
        for x in numbers if isinstance(numbers, tuple) else (numbers,):
            if isinstance(x, float | int) and not math.isfinite(x):
                raise SceneError(f"{f.name} of a {type(value).__name__.lower()} is {x}: it must be a finite number")
        if f.name in positive and not numbers > 0:
            raise SceneError(f"{f.name} of a {type(value).__name__.lower()} is {numbers:g}: it must be positive")


@dataclass(frozen=True)
class Image:
    """A picture on a surface: `data` holds height × width × 3 linear float32, the top row first; at least 2 × 2."""

    width: int
    height: int
    data: bytes

    def __post_init__(self):
        if self.width < 2 or self.height < 2 or len(self.data) != self.width * self.height * 12:
            raise SceneError(f"an image of {self.width} × {self.height} needs at least 2 × 2 texels of 12 bytes")

    @classmethod
    def of(cls, values: np.ndarray) -> "Image":
        """From an array (height, width, 3) of linear colours."""
        return cls(values.shape[1], values.shape[0], np.ascontiguousarray(values, np.float32).tobytes())

    @property
    def values(self) -> np.ndarray:
        """(height, width, 3) float32."""
        return np.frombuffer(self.data, np.float32).reshape(self.height, self.width, 3)


@dataclass(frozen=True)
class Pattern:
    """Where a rectangle or disk shows `colour` in place of its material's own.

    "checker" of columns × rows; "grid" of columns × rows cells with lines `line` mm wide; "star" (Siemens) of
    `columns` pairs of sectors; "ruler": millimetre ticks `line` mm wide along the lower edge, the longest `columns`
    mm long; "image": the image, times the material's colour.
    """

    kind: str
    colour: Triple = (0.02, 0.02, 0.02)
    columns: float = 8.0
    rows: float = 8.0
    line: float = 1.0
    image: Image | None = None

    def __post_init__(self):
        _check(self, ("columns", "rows", "line"))
        if self.kind not in PATTERNS:
            raise SceneError(f"pattern {self.kind!r}: choose one of {', '.join(PATTERNS)}")
        if (self.kind == "image") != (self.image is not None):
            raise SceneError("a pattern has an image if and only if its kind is image")


@dataclass(frozen=True)
class Material:
    """What a surface is made of.

    kind: "matte"; "coat", a clear coat over matte that mirrors the lamps, the sky and the floor, sharply at gloss 1,
    over facets whose slopes are 1 − gloss wide below it; "metal", a mirror tinted by `colour` (polished stone where
    that is dark); "glass" of index 1.5; "light", which emits the radiance `colour` but is too small to light its
    surroundings; "lamp", which also lights them.
    """

    colour: Triple = (0.5, 0.5, 0.5)
    kind: str = "matte"
    gloss: float = 1.0
    pattern: Pattern | None = None

    def __post_init__(self):
        _check(self, ("gloss",))
        if self.kind not in MATERIALS:
            raise SceneError(f"material {self.kind!r}: choose one of {', '.join(MATERIALS)}")
        if self.gloss > 1.0:
            raise SceneError(f"gloss {self.gloss:g}: it must lie between 0 and 1")
        if min(self.colour) < 0.0:
            raise SceneError(f"colour {self.colour}: no part of it can be negative")
        if not self.shines and max(self.colour) > 1.0:
            raise SceneError(f"colour {self.colour}: a surface cannot give back more light than it gets")

    @property
    def shines(self) -> bool:
        """Whether it emits."""
        return self.kind in ("light", "lamp")


@dataclass(frozen=True)
class Sphere:
    """A sphere, seen from outside: centre and radius in mm."""

    centre: Triple
    radius: float
    material: Material = Material()

    def __post_init__(self):
        _check(self, ("radius",))
        if self.material.pattern is not None:
            raise SceneError("a sphere has no pattern: give it to a rectangle or a disk")


@dataclass(frozen=True)
class Rectangle:
    """A rectangle, seen from both sides: its centre and its two half-axes, at right angles, in mm."""

    centre: Triple
    right: Triple
    up: Triple
    material: Material = Material()
    round = False

    def __post_init__(self):
        _check(self)
        a, b = np.asarray(self.right), np.asarray(self.up)
        if not (a @ a > 0.0 and b @ b > 0.0):
            raise SceneError("the half-axes of a rectangle cannot be zero")
        if abs(a @ b) > 1e-6 * math.sqrt((a @ a) * (b @ b)):
            raise SceneError("the half-axes of a rectangle must be at right angles")

    @classmethod
    def facing(cls, centre: Triple, target: Triple, width: float, height: float,
               material: Material = Material()) -> "Rectangle":    # noqa: B008  (frozen)
        """Its front turned towards a point, its upper edge level."""
        right, up = _across(np.subtract(target, centre))
        return cls(centre, _triple(right * width / 2), _triple(up * height / 2), material)


@dataclass(frozen=True)
class Disk:
    """A round plate, seen from both sides: centre, direction of its axis, radius in mm."""

    centre: Triple
    normal: Triple
    radius: float
    material: Material = Material()
    round = True

    def __post_init__(self):
        _check(self, ("radius",))
        if not np.any(self.normal):
            raise SceneError("the normal of a disk cannot be zero")

    @property
    def right(self) -> Triple:
        """Half-axis to the right (mm), level."""
        return _triple(_across(self.normal)[0] * self.radius)

    @property
    def up(self) -> Triple:
        """Half-axis upwards (mm)."""
        return _triple(_across(self.normal)[1] * self.radius)


Plate = Rectangle | Disk


@dataclass(frozen=True)
class Floor:
    """An endless checkered plane, seen from above: `height` along its normal from the world's origin, in mm."""

    height: float = -250.0
    tile: float = 100.0
    light: Triple = (0.75, 0.75, 0.75)
    dark: Triple = (0.08, 0.08, 0.08)
    gloss: float = 0.0                  # 0: matte
    normal: Triple = (0.0, 1.0, 0.0)
    turn: float = 0.0                   # of the tiles about the normal, radians
    offset: tuple[float, float] = (0.0, 0.0)    # of the tiles, in tiles
    fade: float = 4e-4                  # radians: tiles seen smaller than this show their mean

    def __post_init__(self):
        _check(self, ("tile",))
        if not 0.0 <= self.gloss <= 1.0:
            raise SceneError(f"gloss {self.gloss:g}: it must lie between 0 and 1")
        if not np.any(self.normal):
            raise SceneError("the normal of a floor cannot be zero")
        if min(*self.light, *self.dark) < 0.0 or max(*self.light, *self.dark) > 1.0:
            raise SceneError("the colours of a floor must lie between 0 and 1")


@dataclass(frozen=True)
class Sun:
    """A distant disk: direction towards it, irradiance on a surface that faces it / π, angular radius (radians)."""

    direction: Triple
    colour: Triple = (2.0, 1.9, 1.7)
    angular_radius: float = math.radians(0.27)

    def __post_init__(self):
        _check(self, ("angular_radius",))
        if not np.any(self.direction):
            raise SceneError("the direction of the sun cannot be zero")
        if self.angular_radius > 1.0:
            raise SceneError(f"angular radius of the sun {self.angular_radius:g}: at most 1 radian")
        if min(self.colour) < 0.0:
            raise SceneError(f"colour {self.colour}: no part of it can be negative")


@dataclass(frozen=True)
class Sky:
    """Radiance at the zenith, at the horizon and below it; linear in the sine of the height above the horizon."""

    zenith: Triple = (0.25, 0.45, 0.9)
    horizon: Triple = (0.8, 0.85, 0.9)
    ground: Triple = (0.3, 0.28, 0.25)
    up: Triple = (0.0, 1.0, 0.0)

    def __post_init__(self):
        _check(self)
        if min(*self.zenith, *self.horizon, *self.ground) < 0.0:
            raise SceneError("the colours of a sky cannot be negative")
        if not np.any(self.up):
            raise SceneError("the up direction of a sky cannot be zero")


@dataclass(frozen=True)
class Scene:
    """What the camera looks at, compared by value."""

    name: str
    sky: Sky = Sky()
    sun: Sun | None = None
    floor: Floor | None = None
    spheres: tuple[Sphere, ...] = ()
    plates: tuple[Plate, ...] = ()
    ambient: Triple = (0.0, 0.0, 0.0)       # radiance from everywhere on top of the sky's, as between walls
    enclosed: bool = False                  # the sky is only seen: it lights nothing, and no coat mirrors it
    depth_range: tuple[float, float] = (400.0, 8000.0)      # mm of interest, for scales and charts

    def __post_init__(self):
        _check(self)

    def steps(self, shadows: bool = True) -> list[Step]:
        """The stages from a world ray (X Y Z, L M N), with V0 V1 for the lights, to RED, GREEN, BLUE, its radiance.

        shadows=False leaves shadows and occlusion out. A scene without metal or glass has no step for them.
        """
        mirrors = any(o.material.kind in ("metal", "glass") for o in self._objects)
        casters = any(not o.material.shines for o in self._objects)
        if not (mirrors or self._glosses or self._lamps or (shadows and casters)):
            return [*self._geometry(), Step(daylight, np.concatenate([self._surround, self.ambient, self._sun]))]
        light = self._light(shadows)
        steps = [Step(begin, np.zeros(1)), *self._geometry(), *self._coats(last=False), Step(settle, np.zeros(1)),
                 *light]
        for k in range(BOUNCES if mirrors else 0):
            onward = [Step(bounce, np.zeros(1)), *self._geometry(gleam=True), *self._coats(last=k == BOUNCES - 1),
                      Step(settle, np.zeros(1)), *light]
            steps += [step._replace(gated=True) for step in onward]
        return [*steps, Step(finish, np.zeros(1))]

    def depth_steps(self) -> list[Step]:
        """The stages that leave DEPTH alone: RED = DEPTH in mm, GREEN = 1 where it is below REACH, else 0."""
        return [*self._geometry(), Step(depth_picture, np.zeros(1))]

    def distance(self, origins, directions) -> np.ndarray:
        """Distance (n,) in mm to the nearest object along rays (n, 3), unit directions, in double; inf: the sky."""
        o, d = np.atleast_2d(np.asarray(origins, np.float64)), np.atleast_2d(np.asarray(directions, np.float64))
        nearest = np.full(len(o), math.inf)
        with np.errstate(all="ignore"):
            for t in self._distances(o, d):
                nearest = np.where((t > 0.0) & (t < nearest), t, nearest)
        return nearest

    def _distances(self, o, d) -> Iterator[np.ndarray]:
        """Distance to each object; nan where the ray misses it."""
        if self.floor is not None:
            normal = np.asarray(self.floor.normal) / math.dist(self.floor.normal, (0, 0, 0))
            yield np.where(d @ normal < 0.0, (self.floor.height - o @ normal) / (d @ normal), math.nan)
        for s in self.spheres:
            to = o - np.asarray(s.centre)
            half = np.sum(to * d, 1)
            yield -half - np.sqrt(half**2 - np.sum(to * to, 1) + s.radius**2)
        for plate in self.plates:
            centre, a, b, normal, disk = plate_frame(plate)
            t = ((centre - o) @ normal) / (d @ normal)
            q = o + t[:, None] * d - centre
            u, v = q @ a / (a @ a), q @ b / (b @ b)
            yield np.where((u**2 + v**2 <= 1.0) if disk else (abs(u) <= 1.0) & (abs(v) <= 1.0), t, math.nan)

    @property
    def _objects(self) -> tuple[Sphere | Plate, ...]:
        return (*self.spheres, *self.plates)

    @property
    def _lamps(self) -> list[Sphere | Plate]:
        return [o for o in self._objects if o.material.kind == "lamp"]

    @property
    def _glosses(self) -> set[float]:
        """The gloss of every coat."""
        glosses = {o.material.gloss for o in self._objects if o.material.kind == "coat"}
        return glosses | ({self.floor.gloss} if self.floor is not None and self.floor.gloss > 0.0 else set())

    @property
    def _sky(self) -> np.ndarray:
        return sky_parameters(self.sky)

    @property
    def _surround(self) -> np.ndarray:
        """The sky as far as it gives light: black where the scene is enclosed."""
        return self._sky * 0.0 if self.enclosed else self._sky

    @property
    def _mirrored(self) -> np.ndarray:
        """What a coat mirrors where nothing else is: the sky, or the ambient light where the scene is enclosed."""
        return np.array([*self.ambient * 3, 0.0, 1.0, 0.0]) if self.enclosed else self._sky

    @property
    def _sun(self) -> np.ndarray:
        """Direction and irradiance / π."""
        if self.sun is None:
            return np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        return np.array([*_unit(self.sun.direction), *self.sun.colour])

    def _sun_disk(self, radius: float) -> np.ndarray:
        """Direction, chord², radiance of the sun as a disk of this angular radius."""
        assert self.sun is not None
        colour = np.asarray(self.sun.colour) / math.sin(radius) ** 2
        return np.array([*_unit(self.sun.direction), (2.0 * math.sin(radius / 2)) ** 2, *colour])

    def _geometry(self, gleam: bool = False) -> list[Step]:
        """What a ray meets; with `gleam` the sun's disk is as large as it is seen in mirrors."""
        steps = [Step(sky, self._sky)]
        if self.sun is not None:
            radius = self.sun.angular_radius
            steps.append(Step(sun_disk, self._sun_disk(max(radius, GLEAM_RADIUS) if gleam else radius)))
        if self.floor is not None:
            steps.append(Step(floor, floor_parameters(self.floor)))
        if self.spheres:
            steps.append(Step(spheres, sphere_parameters(self.spheres)))
        if self.plates:
            steps.append(Step(plates, plate_parameters(self.plates)))
        return steps

    def _coats(self, last: bool) -> list[Step]:
        """What coats mirror; on the last round of a path metal is mirrored so as well."""
        steps = []
        if last or any(g >= SHARP for g in self._glosses) or any(o.material.kind == "glass" for o in self._objects):
            disk = None if self.sun is None or self.enclosed else self._sun_disk(max(self.sun.angular_radius, GLEAM_RADIUS))
            ground = None if self.floor is None else floor_parameters(self.floor)
            steps.append(Step(coat, coat_parameters(
                self._mirrored, ground, self._floor_light(), disk, [o for o in self.plates if o.material.shines],
                [o for o in self.spheres if o.material.kind == "lamp"], last)))
        if any(g < SHARP for g in self._glosses):
            lights = [o for o in self._objects if o.material.shines and o.material.pattern is None]
            lights = sorted(lights, key=_brightness, reverse=True)[:GLEAMS]
            steps.append(Step(sheen, sheen_parameters(self._mirrored, lights)))
        return steps

    def _light(self, shadows: bool) -> list[Step]:
        """What falls on an albedo: sky, sun and lamps."""
        holding = np.array([[*s.centre, s.radius**2 * (0.4 if s.material.kind == "glass" else 1.0)]
                            for s in self.spheres if shadows and not s.material.shines]).ravel()
        casters = caster_parameters(self) if shadows else np.zeros(1)
        steps = [Step(ambient, np.concatenate([self._surround, self.ambient, holding]))]
        if self.sun is not None:
            right, up = _across(self.sun.direction)
            size = math.tan(self.sun.angular_radius)
            steps.append(Step(sun, np.concatenate([self._sun[:3], right * size, up * size, self._sun[3:], casters])))
        steps += [Step(lamp, np.concatenate([lamp_parameters(o), casters])) for o in self._lamps]
        return steps

    def _floor_light(self) -> np.ndarray:
        """Irradiance / π on the floor below the middle of the near spheres, for its mirror image in coats."""
        if self.floor is None:
            return np.zeros(3)
        normal = _unit(self.floor.normal)
        near = [s.centre for s in self.spheres if not s.material.shines and math.dist(s.centre, (0, 0, 0)) < 3000.0]
        middle = np.mean(near, 0) if near else np.array([0.0, 0.0, -1000.0])
        here = middle + (self.floor.height - middle @ normal) * normal
        around = self._surround
        up = float(normal @ self._sky[9:12])
        zenith, horizon, below = around[0:3], around[3:6], around[6:9]
        rise = RISE0 + up * (RISE1 + up * (RISE2 + up * up * RISE4))
        total = np.asarray(self.ambient) + horizon * (1 + up) / 2 + below * (1 - up) / 2 + rise * (zenith - horizon)
        total = total + self._sun[3:] * max(0.0, float(normal @ self._sun[:3]))
        for light in self._lamps:
            to = np.asarray(light.centre) - here
            d2 = to @ to
            slant = max(0.0, float(to @ normal)) / math.sqrt(d2)
            if isinstance(light, Sphere):
                size = light.radius**2
            else:
                _, a, b, axis, disk = plate_frame(light)
                size = (1.0 if disk else 4.0 / math.pi) * math.sqrt((a @ a) * (b @ b) / d2) * abs(axis @ to)
            total = total + np.asarray(light.material.colour) * slant * size / d2
        return total


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


def _brightness(light: Sphere | Plate) -> float:
    """Of a light seen from the origin, as its radiance times its solid angle."""
    size = light.radius**2 if isinstance(light, Sphere) else math.hypot(*light.right) * math.hypot(*light.up)
    return sum(light.material.colour) * size / max(math.hypot(*light.centre), 1.0) ** 2


def _triple(v) -> Triple:
    return (float(v[0]), float(v[1]), float(v[2]))


def _across(direction) -> tuple[np.ndarray, np.ndarray]:
    """Two unit axes across a direction, so that right × up is along it; right is level where that can be."""
    axis = _unit(direction)
    right = _unit(np.cross((0.0, 1.0, 0.0) if abs(axis[1]) < 0.999 else (0.0, 0.0, -1.0), axis))
    return right, np.cross(axis, right)
