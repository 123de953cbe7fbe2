"""Objects, materials and light as frozen values.

World frame, mm. Colours are linear red, green and blue; radiance is relative,
with 1 the radiance of a white surface under a uniform sky of 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

Triple = tuple[float, float, float]
MATERIALS = ("matte", "coat", "metal", "glass", "light", "lamp")
PATTERNS = ("checker", "grid", "star", "ruler", "image")


class SceneError(ValueError):
    """A scene that cannot be; the message says what to do."""


def check(value, positive: Sequence[str] = ()) -> None:
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
        check(self, ("columns", "rows", "line"))
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
    surroundings; "lamp", which also lights them. Coats mirror no patterns.
    """

    colour: Triple = (0.5, 0.5, 0.5)
    kind: str = "matte"
    gloss: float = 1.0
    pattern: Pattern | None = None

    def __post_init__(self):
        check(self, ("gloss",))
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


@dataclass(frozen=True, kw_only=True)
class Moving:
    """How a thing moves: it stands as its other fields say at the time 0 s, and moves so before and after.

    velocity: mm/s, in the world. spin: an axis times the rate in radians a second, right-handed, about the point
    `pivot`, which moves along; None: about its own centre.
    """

    velocity: Triple = (0.0, 0.0, 0.0)
    spin: Triple = (0.0, 0.0, 0.0)
    pivot: Triple | None = None

    @property
    def moves(self) -> bool:
        """Whether it is ever anywhere else."""
        return any(self.velocity) or any(self.spin)


@dataclass(frozen=True)
class Sphere(Moving):
    """A sphere, seen from outside: centre and radius in mm."""

    centre: Triple
    radius: float
    material: Material = Material()

    def __post_init__(self):
        check(self, ("radius",))
        if self.material.pattern is not None:
            raise SceneError("a sphere has no pattern: give it to a rectangle or a disk")


@dataclass(frozen=True)
class Rectangle(Moving):
    """A rectangle, seen from both sides: its centre and its two half-axes, at right angles, in mm."""

    centre: Triple
    right: Triple
    up: Triple
    material: Material = Material()
    round = False

    def __post_init__(self):
        check(self)
        a, b = np.asarray(self.right), np.asarray(self.up)
        if not (a @ a > 0.0 and b @ b > 0.0):
            raise SceneError("the half-axes of a rectangle cannot be zero")
        if abs(a @ b) > 1e-6 * math.sqrt((a @ a) * (b @ b)):
            raise SceneError("the half-axes of a rectangle must be at right angles")

    @classmethod
    def facing(cls, centre: Triple, target: Triple, width: float, height: float,
               material: Material = Material()) -> "Rectangle":    # noqa: B008  (frozen)
        """Its front turned towards a point, its upper edge level."""
        right, up = across(np.subtract(target, centre))
        return cls(centre, triple(right * width / 2), triple(up * height / 2), material)


@dataclass(frozen=True)
class Disk(Moving):
    """A round plate, seen from both sides: centre, direction of its axis, radius in mm."""

    centre: Triple
    normal: Triple
    radius: float
    material: Material = Material()
    round = True

    def __post_init__(self):
        check(self, ("radius",))
        if not np.any(self.normal):
            raise SceneError("the normal of a disk cannot be zero")

    @property
    def right(self) -> Triple:
        """Half-axis to the right (mm), level."""
        return triple(across(self.normal)[0] * self.radius)

    @property
    def up(self) -> Triple:
        """Half-axis upwards (mm)."""
        return triple(across(self.normal)[1] * self.radius)


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

    def __post_init__(self):
        check(self, ("tile",))
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
        check(self, ("angular_radius",))
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
        check(self)
        if min(*self.zenith, *self.horizon, *self.ground) < 0.0:
            raise SceneError("the colours of a sky cannot be negative")
        if not np.any(self.up):
            raise SceneError("the up direction of a sky cannot be zero")


def unit(v) -> np.ndarray:
    """The vector at the length 1."""
    v = np.asarray(v, np.float64)
    return v / math.sqrt(v @ v)


def triple(v) -> Triple:
    """An array of three as a value."""
    return (float(v[0]), float(v[1]), float(v[2]))


def across(direction) -> tuple[np.ndarray, np.ndarray]:
    """Two unit axes across a direction, so that right × up is along it; right is level where that can be."""
    axis = unit(direction)
    right = unit(np.cross((0.0, 1.0, 0.0) if abs(axis[1]) < 0.999 else (0.0, 0.0, -1.0), axis))
    return right, np.cross(axis, right)
