"""The scene: a frozen value, and the stages that render it.

World frame, mm: the built-in scenes are laid out for a camera at the origin that looks along −z, y up. Colours are
linear red, green and blue; radiance is relative, with 1 the radiance of a white surface under a uniform sky of 1.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import BLUE, GREEN, RED, TIME, V0, V1, WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.lazy import called, hashed_once
from lensbench.core.scenery import scene_steps
from lensbench.core.scenery.families import FAMILIES
from lensbench.core.scenery.objects.basic_shapes import Planar, Sphere
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.shape import Shape, rest_frame
from lensbench.core.scenery.objects.surroundings import Floor, ImageSky, Sky, Sun
from lensbench.core.scenery.shading.participating_medium import Medium
from lensbench.core.scenery.small_lights import ExcludedLight
from lensbench.core.scenery.values import FRAMING_NAMES, SceneError, Triple, check, unit
from lensbench.core.text import cut


class Framing(NamedTuple):
    """What a camera is framed and focused on: mm, world frame. height: what fills the shorter side of the film."""

    name: str
    centre: Triple
    height: float


@hashed_once
@dataclass(frozen=True)
class Scene:
    """Scene in front of the camera: shapes, lights and surroundings. Compared by value; lengths in mm, world frame.

    Args:
        name: Shown to the user.
        sky: Radiance of all directions that meet nothing.
        sun: Distant disk of light.
        floor: Endless checkered plane.
        spheres: Spheres, at rest or moving.
        plates: Planar shapes, at rest or moving.
        ambient: (r, g, b). Radiance from all directions in addition to the sky's, as between walls.
        enclosed: True: the sky is visible, but lights nothing and is not reflected by coats.
        depth_range: (near, far). Distances of interest from the origin, mm, for scales and charts.
        meshes: Triangle meshes, at rest.
        diffuse_bounce: True: matte surfaces light each other, by one bounce and with noise; the sky lights what it
            sees, past all shapes, and `ambient` the surfaces at which the bounce ends.
        subject: (distance, height), optional. What a camera is framed and focused on: its distance from the origin
            along −z, and the height that fills the shorter side of the film, mm.
        framings: Other things to be framed, such as a head, by name; one called "subject" is the subject.
        exposure: Stops by which a picture of the scene is to be brightened when the scene is chosen; radiance is
            not changed.
        summary: What it shows, in a line.
        notes: What its reader assumed or changed, a sentence each; not compared.
    Raises:
        SceneError: If a number is not finite, or the subject or a framing has no positive distance and height.
    """

    name: str = "scene"
    sky: Sky | ImageSky = Sky()
    sun: Sun | None = None
    floor: Floor | None = None
    spheres: tuple[Sphere, ...] = ()
    plates: tuple[Planar, ...] = ()
    ambient: Triple = (0.0, 0.0, 0.0)
    enclosed: bool = False
    depth_range: tuple[float, float] = (400.0, 8000.0)
    meshes: tuple[Mesh, ...] = ()
    diffuse_bounce: bool = False
    subject: tuple[float, float] | None = None
    framings: tuple[Framing, ...] = ()
    exposure: float = 0.0
    summary: str = ""
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        for family in FAMILIES.values():
            shapes = tuple(getattr(self, family.field))
            for shape in shapes:
                if not isinstance(shape, family.kind):
                    raise SceneError(f"{family.field} of a scene: {type(shape).__name__} is none of them")
            object.__setattr__(self, family.field, shapes)
        check(self)
        if self.subject is not None and not min(self.subject) > 0.0:
            raise SceneError("the distance and the height of the subject must be positive")
        for framing in self.framings:
            if framing.name not in FRAMING_NAMES:
                raise SceneError(f"no framing is called {cut(framing.name)}: choose one of {', '.join(FRAMING_NAMES)}")
            if not (0.0 < framing.height < math.inf and all(map(math.isfinite, framing.centre))):
                raise SceneError(f"framing {cut(framing.name)}: its centre must be finite and its height positive")

    def _repr_html_(self) -> str:
        """A small picture from the origin and figures, for a notebook."""
        return called("app.notebook.cards", "scene_card", self)

    @property
    def objects(self) -> tuple[Shape, ...]:
        """All shapes: spheres, then planar ones, then meshes."""
        return tuple(shape for family in FAMILIES.values() for shape in getattr(self, family.field))

    @cached_property
    def moves(self) -> bool:
        """Whether any shape moves: the stages then read TIME."""
        return any(o.moves for o in self.objects)

    @property
    def is_patterned(self) -> bool:
        """Whether anything has a pattern, whose look depends on the size of a pixel."""
        return self.floor is not None or any(o.material.pattern is not None for o in self.objects)

    @property
    def is_rough(self) -> bool:
        """Whether any coat reflects lights roughly: its highlights are averaged over what a sample represents."""
        return scene_steps.is_rough(self)

    def steps(self, shadows: bool = True, opening: float = 0.0, excluded: ExcludedLight | None = None,
              medium: Medium | None = None) -> list[Step]:
        """Stages from a world ray (X Y Z, L M N) to its radiance RED, GREEN, BLUE.

        Args:
            shadows: False omits shadows and occlusion; True reads V0, V1, a point of each light.
            opening: Time in seconds at which TIME is 0, if something moves.
            excluded: Light that the ray does not see, because it is traced from the light.
            medium: What fills the scene; clear air has no stage.

        Notes:
            A patterned scene also reads PIXEL_SIDE and PIXEL_SPREAD; zeros show each pattern at a point.
        """
        return list(scene_steps.radiance_steps(self, shadows, opening, excluded, medium))

    def marking_steps(self, shapes: tuple[Shape, ...]) -> list[Step]:
        """Stages that mark which shape a ray meets, with its radiance or albedo.

        EMITS is 2 + the index of the shape if it shines and −2 − its index if not; 1 is the sky, 0 the floor.

        Args:
            shapes: Shapes of the scene, all at rest.
        """
        return list(scene_steps.marking_steps(self, shapes))

    def depth_steps(self, opening: float = 0.0) -> list[Step]:
        """Stages that find the depth alone: RED is DEPTH in mm, GREEN is 1 where a surface is met and 0 at the sky.

        Args:
            opening: Time in seconds at which TIME is 0.
        """
        return list(scene_steps.depth_steps(self, opening))

    def distance(self, origins: ArrayLike, directions: ArrayLike, time: float = 0.0) -> np.ndarray:
        """Distance to the nearest surface, in double precision.

        Args:
            origins, directions: array_like, shape (n, 3). Points in mm and unit vectors, world frame.
            time: Seconds.
        Returns:
            ndarray, shape (n,). mm; inf where the ray meets the sky.
        """
        o, d = np.atleast_2d(np.asarray(origins, np.float64)), np.atleast_2d(np.asarray(directions, np.float64))
        nearest = np.full(len(o), math.inf)
        with np.errstate(all="ignore"):
            for t in self._distances(o, d, time):
                nearest = np.where((t > 0.0) & (t < nearest), t, nearest)
        return nearest

    def radiance(self, origins: Any, directions: ArrayLike | None = None, times: ArrayLike = 0.0, samples: int = 16,
                 seed: int = 0, shadows: bool = True) -> np.ndarray:
        """Radiance that arrives along rays of one's own, by the stages of pictures in double precision.

        Patterns are seen at a point, not averaged over a pixel, and lights of every size are met by the rays.

        Args:
            origins: array_like, shape (n, 3), or Rays. Points in mm, world frame; or the rays of
                `Camera.generate_rays`, with their directions and times. Their weights are not applied; blocked rays, of
                weight 0, are black.
            directions: array_like, shape (n, 3). Of any length but 0, world frame.
            times: float or array_like, shape (n,). Seconds; matter where something moves.
            samples: Points on each light that a ray's soft shadows are averaged over.
            seed: Of these points.
            shadows: Whether light is hidden by objects.
        Returns:
            ndarray, shape (n, 3). Linear red, green and blue; the value of a pixel is the mean of weight × radiance.
        Raises:
            ValueError: Arrays of other shapes, numbers that are not finite, directions of length 0, or fewer than one
                sample.
        """
        lit = None
        if directions is None:
            try:
                origins, directions, weights, times = origins
            except (TypeError, ValueError):
                raise ValueError("radiance takes origins and directions (n, 3), or the rays of a camera") from None
            lit = np.asarray(weights) > 0.0
        o, d = np.atleast_2d(np.asarray(origins, float)), np.atleast_2d(np.asarray(directions, float))
        if o.shape != d.shape or o.shape[1:] != (3,):
            raise ValueError(f"origins {o.shape} and directions {d.shape} must both be (n, 3)")
        if lit is not None:
            o, d = np.where(lit[:, None], o, 0.0), np.where(lit[:, None], d, [0.0, 0.0, -1.0])
        length = np.linalg.norm(d, axis=1)
        if not (np.isfinite(o).all() and np.isfinite(d).all() and (length > 0.0).all()):
            raise ValueError("rays must be finite, with no direction of length 0")
        if samples < 1:
            raise ValueError(f"{samples} samples: at least 1 is needed")
        n = len(o)
        seconds, (l, m, n_) = np.broadcast_to(np.asarray(times, float), (n,)), (d / length[:, None]).T
        program, random = Program(self.steps(shadows), np.float64), np.random.default_rng(seed)
        total = np.zeros((n, 3))
        for _ in range(samples):
            light = random.random((2, n))
            inputs = {X: o[:, 0], Y: o[:, 1], Z: o[:, 2], L: l, M: m, N: n_, TIME: seconds, WEIGHT: np.ones(n),
                     V0: light[0], V1: light[1]}
            total += program.run(inputs, [RED, GREEN, BLUE], n).T
        mean = total / samples
        return mean if lit is None else np.where(lit[:, None], mean, 0.0)

    def _distances(self, o: np.ndarray, d: np.ndarray, time: float) -> Iterator[np.ndarray]:
        """Distance to each surface; nan where the ray misses it."""
        if self.floor is not None:
            normal = unit(self.floor.normal)
            yield np.where(d @ normal < 0.0, (self.floor.height - o @ normal) / (d @ normal), math.nan)
        for shape in self.objects:
            yield shape.distance(*rest_frame(o, d, shape, time))
