"""The scene: a frozen value, and the stages that it becomes.

World frame, mm: the built-in scenes are laid out for a camera at the origin
that looks along −z, y up. Colours are linear red, green and blue; radiance is
relative, with 1 the radiance of a white surface under a uniform sky of 1.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lensbench.kernels.block import BLUE, DEPTH, GREEN, RED, B, Step, rows, stage
from lensbench.scenery.intersect.block_bounds import beam
from lensbench.scenery.intersect.floor import floor, floor_parameters
from lensbench.scenery.intersect.moving_objects import displaced, motion_parameters, moving, moving_parameters
from lensbench.scenery.intersect.planar import plate_frame, plate_parameters, plates
from lensbench.scenery.intersect.sky import sky, sky_parameters, sun_disk
from lensbench.scenery.intersect.spheres import sphere_parameters, spheres
from lensbench.scenery.objects import Floor, Plate, Sky, Sphere, Sun, Triple, across, check, unit
from lensbench.scenery.shading.clearcoat import SHARP, clearcoat, clearcoat_parameters
from lensbench.scenery.shading.illumination import (
    BENDS,
    RISE0,
    RISE1,
    RISE2,
    RISE4,
    SMALL,
    ambient,
    begin_path,
    daylight,
    finish_path,
    gather_emission,
    open_light,
)
from lensbench.scenery.shading.moving_clearcoat import (
    moving_clearcoat,
    moving_highlights,
    moving_reflected,
    moving_rough_clearcoat,
)
from lensbench.scenery.shading.moving_lights import (
    after,
    moving_ambient,
    moving_lamp,
    moving_occluders,
    moving_sky_occluders,
    moving_sun,
)
from lensbench.scenery.shading.participating_medium import Medium
from lensbench.scenery.shading.rough_clearcoat import rough_clearcoat, rough_clearcoat_parameters
from lensbench.scenery.shading.soft_shadows import lamp, lamp_parameters, occluder_parameters, point_parameters, sun
from lensbench.scenery.shading.specular_bounce import bounce_pupil_part, specular_bounce
from lensbench.scenery.small_lights import ExcludedLight

SKY_DISTANCE = 1e8             # mm: farther than this counts as the sky
BOUNCES = 3             # how often a path goes on at metal or glass
MOST_HIGHLIGHTS = 64             # lights that a rough coat mirrors: those that are brightest from the origin
HIGHLIGHT_RADIUS = math.radians(1.5)        # the sun in mirrors and coats is no smaller, its light the same


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
        check(self)

    @property
    def moves(self) -> bool:
        """Whether anything in it moves: its stages then read TIME."""
        return any(o.moves for o in self.objects)

    @property
    def is_patterned(self) -> bool:
        """Whether anything in it has a pattern, which looks different from where a pixel is larger."""
        return self.floor is not None or any(plate.material.pattern is not None for plate in self.plates)

    @property
    def is_rough(self) -> bool:
        """Whether any coat mirrors lights roughly: its gleams are averaged over what a sample stands for."""
        return any(gloss < SHARP for gloss in self._glosses)

    def steps(self, shadows: bool = True, opening: float = 0.0, excluded: ExcludedLight | None = None,
              medium: Medium | None = None) -> list[Step]:
        """The stages from a world ray (X Y Z, L M N), with V0 V1 for the lights, to RED, GREEN, BLUE, its radiance.

        shadows=False leaves shadows and occlusion out. A scene without metal or glass has no step for them. Where
        something moves, TIME is in seconds since `opening` (s). Where it is patterned, PIXEL_SIDE and PIXEL_SPREAD tell
        the size of a pixel; zeros show the patterns as they are at a point. taken: light that the ray does not see.
        medium: what all is seen through; clear air has no step.
        """
        fog = None if medium is None or medium.is_clear else replace(medium, index=1.0)
        return list(_steps(self, shadows, opening if self.moves else 0.0, excluded, fog))

    def marking_steps(self, objects: tuple[Sphere | Plate, ...]) -> list[Step]:
        """The stages that tell which of these objects, which do not move, a ray meets, with its radiance or albedo.

        EMITS is 2 + its number where it shines, −2 − that where it does not; 1 is the sky, 0 the floor.
        """
        return list(_marking_steps(self, objects))

    def depth_steps(self, opening: float = 0.0) -> list[Step]:
        """The stages that leave DEPTH alone: RED = DEPTH in mm, GREEN = 1 where it is below REACH, else 0."""
        return list(_depth_steps(self, opening if self.moves else 0.0))

    def distance(self, origins, directions, time: float = 0.0) -> np.ndarray:
        """Distance (n,) in mm to the nearest object along rays (n, 3), unit directions, in double; inf: the sky.

        time: seconds.
        """
        o, d = np.atleast_2d(np.asarray(origins, np.float64)), np.atleast_2d(np.asarray(directions, np.float64))
        nearest = np.full(len(o), math.inf)
        with np.errstate(all="ignore"):
            for t in self._distances(o, d, time):
                nearest = np.where((t > 0.0) & (t < nearest), t, nearest)
        return nearest

    def _distances(self, world_o, world_d, time: float) -> Iterator[np.ndarray]:
        """Distance to each object; nan where the ray misses it."""
        o, d = world_o, world_d
        if self.floor is not None:
            normal = np.asarray(self.floor.normal) / math.dist(self.floor.normal, (0, 0, 0))
            yield np.where(d @ normal < 0.0, (self.floor.height - o @ normal) / (d @ normal), math.nan)
        for s in self.spheres:
            o, d = _carried_back(world_o, world_d, s, time)
            to = o - np.asarray(s.centre)
            half = np.sum(to * d, 1)
            yield -half - np.sqrt(half**2 - np.sum(to * to, 1) + s.radius**2)
        for plate in self.plates:
            o, d = _carried_back(world_o, world_d, plate, time)
            centre, a, b, normal, disk = plate_frame(plate)
            t = ((centre - o) @ normal) / (d @ normal)
            q = o + t[:, None] * d - centre
            u, v = q @ a / (a @ a), q @ b / (b @ b)
            yield np.where((u**2 + v**2 <= 1.0) if disk else (abs(u) <= 1.0) & (abs(v) <= 1.0), t, math.nan)

    @property
    def objects(self) -> tuple[Sphere | Plate, ...]:
        """Spheres, then plates."""
        return (*self.spheres, *self.plates)

    @property
    def _lamps(self) -> list[Sphere | Plate]:
        return [o for o in self.objects if o.material.kind == "lamp"]

    @property
    def _glosses(self) -> set[float]:
        """The gloss of every coat."""
        glosses = {o.material.gloss for o in self.objects if o.material.kind == "coat"}
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
        return np.array([*unit(self.sun.direction), *self.sun.colour])

    def _sun_disk(self, radius: float) -> np.ndarray:
        """Direction, chord², radiance of the sun as a disk of this angular radius."""
        assert self.sun is not None
        colour = np.asarray(self.sun.colour) / math.sin(radius) ** 2
        return np.array([*unit(self.sun.direction), (2.0 * math.sin(radius / 2)) ** 2, *colour])

    def _geometry(self, opening: float, highlight: bool = False, things: tuple[Sphere | Plate, ...] | None = None,
                  glows: Sequence[float] | None = None, bent: tuple[Sphere | Plate, ...] | None = None) -> list[Step]:
        """What a ray meets; with `gleam` the sun's disk is as large as it is seen in mirrors.

        things: in place of the scene's objects; glows: the EMITS of each, by default whether it shines; bent: how they
        look where the path is SPECULAR.
        """
        things = self.objects if things is None else things
        shine = [float(o.material.shines) for o in things] if glows is None else glows
        known = [seen for seen in zip(things, shine, things if bent is None else bent, strict=True)
                 if not seen[0].moves]
        balls, flat = ([seen for seen in known if isinstance(seen[0], Sphere) == ball] for ball in (True, False))
        steps = [Step(sky, self._sky)]
        if self.sun is not None:
            radius = self.sun.angular_radius
            steps.append(Step(sun_disk, self._sun_disk(max(radius, HIGHLIGHT_RADIUS) if highlight else radius)))
        if self.floor is not None:
            steps.append(Step(floor, floor_parameters(self.floor)))
        if balls or flat or self.moves:
            steps.append(Step(beam, np.zeros(1)))
        if balls:
            steps.append(Step(spheres, sphere_parameters(*list(zip(*balls, strict=True))[:2])))
        if flat:
            steps.append(Step(plates, plate_parameters(*zip(*flat, strict=True))))
        if self.moves:
            steps.append(Step(moving, moving_parameters(_in_motion(self.objects), opening)))
        return steps

    def _coats(self, last: bool, opening: float) -> list[Step]:
        """What coats mirror; on the last round of a path metal is mirrored so as well."""
        steps = []
        if last or any(g >= SHARP for g in self._glosses) or any(o.material.kind == "glass" for o in self.objects):
            disk = None
            if self.sun is not None and not self.enclosed:
                disk = self._sun_disk(max(self.sun.angular_radius, HIGHLIGHT_RADIUS))
            ground = None if self.floor is None else floor_parameters(self.floor)
            panels = [o for o in self.plates if o.material.shines and o.material.pattern is None]
            bulbs = [o for o in self.spheres if o.material.kind == "lamp"]
            numbers = clearcoat_parameters(self._mirrored, ground, self._floor_light(), disk, _still(panels),
                                            _still(bulbs), last)
            moved = moving_reflected(_in_motion([*bulbs, *panels]), opening)
            steps.append(Step(moving_clearcoat, after(numbers, moved)) if moved.size else Step(clearcoat, numbers))
        if self.is_rough:
            lights = [o for o in self.objects if o.material.shines and o.material.pattern is None]
            lights = sorted(lights, key=_brightness, reverse=True)[:MOST_HIGHLIGHTS]
            numbers = rough_clearcoat_parameters(self._mirrored, _still(lights))
            moved = moving_highlights(_in_motion(lights), opening)
            steps.append(Step(moving_rough_clearcoat, after(numbers, moved)) if moved.size
                         else Step(rough_clearcoat, numbers))
        return steps

    def _light(self, shadows: bool, opening: float) -> list[Step]:
        """What falls on an albedo: sky, sun and lamps."""
        def share(ball: Sphere) -> float:
            return 0.4 if ball.material.kind == "glass" else 1.0

        balls = [s for s in self.spheres if shadows and not s.material.shines]
        holding = np.array([[*s.centre, s.radius**2 * share(s)] for s in _still(balls)]).ravel()
        occluders, carried = np.zeros(1), np.zeros(0)
        if shadows:
            occluders = occluder_parameters(_still(self.spheres), _still(self.plates))
            carried = moving_occluders(_in_motion(self.objects), opening)
        around = np.concatenate([self._surround, self.ambient, holding])
        if not shadows:
            around = np.concatenate([around, *(point_parameters(o) for o in _still(self._lamps))])
            steps = [Step(open_light, around)]
        elif _in_motion(balls):
            steps = [Step(moving_ambient, after(around, moving_sky_occluders(_in_motion(balls), opening, share)))]
        else:
            steps = [Step(ambient, around)]
        if self.sun is not None:
            right, up = across(self.sun.direction)
            size = math.tan(self.sun.angular_radius)
            shining = np.concatenate([self._sun[:3], right * size, up * size, self._sun[3:], occluders])
            steps.append(Step(moving_sun, after(shining, carried)) if carried.size else Step(sun, shining))
        for o in self._lamps if shadows else _in_motion(self._lamps):
            here = displaced(o, opening)
            shining = np.concatenate([lamp_parameters(here), occluders])
            if o.moves or carried.size:
                steps.append(Step(moving_lamp, np.concatenate([motion_parameters([here], opening),
                                                               after(shining, carried)])))
            else:
                steps.append(Step(lamp, shining))
        return steps

    def _floor_light(self) -> np.ndarray:
        """Irradiance / π on the floor below the middle of the near spheres, for its mirror image in coats."""
        if self.floor is None:
            return np.zeros(3)
        normal = unit(self.floor.normal)
        near = [s.centre for s in self.spheres if not s.material.shines and math.dist(s.centre, (0, 0, 0)) < 3000.0]
        middle = np.mean(near, 0) if near else np.array([0.0, 0.0, -1000.0])
        here = middle + (self.floor.height - middle @ normal) * normal
        around = self._surround
        up = float(normal @ self._sky[9:12])
        zenith, horizon, below = around[0:3], around[3:6], around[6:9]
        rise = RISE0 + up * (RISE1 + up * (RISE2 + up * up * RISE4))
        total = np.asarray(self.ambient) + horizon * (1 + up) / 2 + below * (1 - up) / 2 + rise * (zenith - horizon)
        total = total + self._sun[3:] * max(0.0, float(normal @ self._sun[:3]))
        for light in _still(self._lamps):
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
        green[i] = real(1) if depth[i] < real(SKY_DISTANCE) else real(0)
        blue[i] = real(0)


@lru_cache(maxsize=16)
def _steps(scene: Scene, shadows: bool, opening: float, excluded: ExcludedLight | None,
           medium: Medium | None) -> tuple[Step, ...]:
    """The stages of a scene, kept: a slider asks for the same ones again and again."""
    excluded = excluded or ExcludedLight(scene.objects, frozenset(), scene.objects)
    mirrors = any(o.material.kind in ("metal", "glass") for o in scene.objects)
    occluders = any(not o.material.shines for o in scene.objects)
    if not (mirrors or scene._glosses or scene._lamps or (shadows and occluders) or medium):
        return (*scene._geometry(opening, things=excluded.first),
                Step(daylight, np.concatenate([scene._surround, scene.ambient, scene._sun])))
    light, fog = scene._light(shadows, opening), [] if medium is None else medium.steps
    glows = [BENDS if j in excluded.bends else float(o.material.shines) for j, o in enumerate(excluded.first)]
    steps = [Step(begin_path, np.zeros(1)), *scene._geometry(opening, things=excluded.first, glows=glows), *fog,
             *scene._coats(False, opening), Step(gather_emission, np.zeros(1)), *light]
    if mirrors:
        glows = [SMALL if o != other and o.material.pattern is None else float(o.material.shines)
                 for o, other in zip(scene.objects, excluded.later, strict=True)]
        part = [Step(bounce_pupil_part, np.zeros(1))] if scene.is_rough else []
        met = scene._geometry(opening, highlight=True, glows=glows, bent=excluded.later)
        for k in range(BOUNCES):
            onward = [*part, Step(specular_bounce, np.zeros(1)), *met, *fog, *scene._coats(k == BOUNCES - 1, opening),
                      Step(gather_emission, np.zeros(1)), *light]
            steps += [step._replace(gated=True) for step in onward]
    return (*steps, Step(finish_path, np.zeros(1)))


@lru_cache(maxsize=16)
def _marking_steps(scene: Scene, objects: tuple[Sphere | Plate, ...]) -> tuple[Step, ...]:
    return tuple(scene._geometry(0.0, things=objects, glows=[_mark(j, o) for j, o in enumerate(objects)]))


@lru_cache(maxsize=16)
def _depth_steps(scene: Scene, opening: float) -> tuple[Step, ...]:
    return (*scene._geometry(opening), Step(depth_picture, np.zeros(1)))


def _brightness(light: Sphere | Plate) -> float:
    """Of a light seen from the origin, as its radiance times its solid angle."""
    size = light.radius**2 if isinstance(light, Sphere) else math.hypot(*light.right) * math.hypot(*light.up)
    return sum(light.material.colour) * size / max(math.hypot(*light.centre), 1.0) ** 2


def _mark(number: int, thing: Sphere | Plate) -> float:
    """The EMITS that tells which thing it is."""
    return 2.0 + number if thing.material.shines else -2.0 - number


def _still(things):
    return [o for o in things if not o.moves]


def _in_motion(things):
    return [o for o in things if o.moves]


def _carried_back(origins, directions, thing, time: float):
    """Rays (n, 3) at a time (s) in the frame where a thing is as it was at 0 s."""
    if not thing.moves or time == 0.0:
        return origins, directions
    spin = np.asarray(thing.spin) * time
    angle = math.sqrt(spin @ spin)
    x, y, z = spin / angle if angle > 0.0 else spin
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k
    pivot = np.asarray(thing.centre if thing.pivot is None else thing.pivot)
    return (origins - pivot - np.multiply(thing.velocity, time)) @ turn + pivot, directions @ turn
