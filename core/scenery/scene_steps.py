"""Stages of a scene: intersection of rays, reflection by clear coats, and illumination.

`scene` is a `Scene` throughout; its file imports this one.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import BLUE, DEPTH, GREEN, RED, B, Packed, Step, join, rows, stage
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.scenery.families import FAMILIES, intersection_steps, shadow_steps
from lensbench.core.scenery.intersect.block_bounds import beam
from lensbench.core.scenery.intersect.moving_objects import after, moving, moving_parameters
from lensbench.core.scenery.intersect.pictured import is_large, pictured_floor_step
from lensbench.core.scenery.intersect.sky import (
    SKY_DISTANCE, UP, floor, floor_parameters, sky_parameters, sky_step, sun_disk, sun_disk_parameters
)
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.objects.surroundings import ImageSky, Sky
from lensbench.core.scenery.shading.bounces import (
    INNER, bounce_pupil_part, diffuse_bend, diffuse_end, diffuse_leave, diffuse_sky, solid_bend, solid_leave,
    specular_bounce
)
from lensbench.core.scenery.shading.clearcoat import clearcoat_step
from lensbench.core.scenery.shading.illumination import (
    ambient, begin_path, daylight, finish_path, gather_emission, moving_sky_occluders, open_light, rise, sky_occluders
)
from lensbench.core.scenery.shading.image_sky_light import add_tinted, sky_cells, sky_rays_step
from lensbench.core.scenery.shading.many_lamps import MANY_LAMPS, has_a_share, many_lamp_steps
from lensbench.core.scenery.shading.meshes import gradient_rays
from lensbench.core.scenery.shading.participating_medium import Medium
from lensbench.core.scenery.shading.rough_clearcoat import image_rough_clearcoat_step, rough_clearcoat_step
from lensbench.core.scenery.shading.soft_shadows import (
    add_lit, all_occluders, lamp_parameters, lamp_rays, point_parameters, shadows as shadow_stage, sun_parameters,
    sun_rays
)
from lensbench.core.scenery.small_lights import ExcludedLight
from lensbench.core.scenery.surface_codes import BENDS, DARK, LAMP, SHARP, SHINES, SMALL_LIGHT
from lensbench.core.scenery.values import unit

Scene = Any
MOST_KEPT, NEWEST = 32 << 20, 4         # bytes that the stages of scenes seen before hold; lists of one picture
MOST_SHORT, SHORT_NEWEST = 8 << 20, 2   # the same of stages that find depths and marks alone
BOUNCES = 3             # specular bounces of a path
SOLID_BOUNCES = 7       # where a mesh of glass takes two for each time that it is crossed
MOST_HIGHLIGHTS = 64    # lights that a rough coat reflects: those that are brightest from the origin
HIGHLIGHT_RADIUS = math.radians(1.5)    # least radius of the sun in mirrors and coats, its light unchanged


@byte_cache(MOST_KEPT, 16, NEWEST)
def radiance_steps(scene: Scene, shadows: bool, opening: float, excluded: ExcludedLight | None,
                   medium: Medium | None) -> tuple[Step, ...]:
    """Stages from a ray to its radiance, cached: a slider asks for the same ones again and again."""
    opening, fog = opening if scene.moves else 0.0, [] if medium is None else medium.steps
    excluded = excluded or ExcludedLight(scene.objects, frozenset(), scene.objects)
    mirrors = any(o.material.kind in ("metal", "glass") for o in scene.objects)
    bounce = shadows and scene.diffuse_bounce
    occluders = shadows and any(not o.material.shines for o in scene.objects)

    # Without mirrors, coats, lamps, fog and shadows one stage does all
    if not (mirrors or _glosses(scene) or _lamps(scene) or occluders or fog or bounce or (
            shadows and _lights_by_picture(scene))):
        sunlight = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0] if scene.sun is None else [
            *unit(scene.sun.direction), *scene.sun.colour]
        return (*_intersection(scene, opening, shapes=excluded.first),
                Step(daylight, np.concatenate([_surround(scene), scene.ambient, sunlight])))

    # What the camera's ray meets, its reflections by coats, and the light on it
    light = _light(scene, shadows, opening)
    emission = [BENDS if j in excluded.bends else _emits(o) for j, o in enumerate(excluded.first)]
    steps = [Step(begin_path), *_intersection(scene, opening, shapes=excluded.first, emission=emission), *fog,
             *_coats(scene, False, shadows, opening), Step(gather_emission),
             *(_light(scene, shadows, opening, sky_too=False) if bounce else light)]
    if not (mirrors or bounce):
        return (*steps, Step(finish_path))

    # Rounds of a path that goes on: by mirrors and glass, the first one from matte surfaces too
    lamp = LAMP if bounce else SHINES
    emission = [SMALL_LIGHT if o != other and o.material.pattern is None else lamp if o.material.shines else DARK
                for o, other in zip(scene.objects, excluded.later, strict=True)]
    surround = np.concatenate([_surround(scene, shadows), np.multiply(scene.ambient, not scene.enclosed)])
    met = _intersection(scene, opening, reflected=True, emission=emission, specular=excluded.later)
    solids = any(o.material.kind == "glass" and FAMILIES[o.family].hollow for o in scene.objects)
    onward = [*([Step(solid_bend)] if solids else []), *([Step(bounce_pupil_part)] if is_rough(scene) else []),
              Step(specular_bounce, [INNER]), *([Step(solid_leave)] if solids else [])]
    count = (SOLID_BOUNCES if solids else BOUNCES) if mirrors else 1
    for k in range(count):
        coats = _coats(scene, k == count - 1, shadows, opening)
        if bounce and k == 0:
            steps += [Step(diffuse_bend), *_gated(onward), Step(diffuse_leave),
                      *_gated([*met, Step(diffuse_sky, surround), *fog, *coats, Step(gather_emission),
                               Step(diffuse_end), *light])]
        else:
            steps += _gated([*onward, *met, *fog, *coats, Step(gather_emission), *light])
    return (*steps, Step(finish_path))


def _gated(steps: Sequence[Step]) -> list[Step]:
    """The steps, each skipped where no path of a block goes on."""
    return [step._replace(gated=True) for step in steps]


@byte_cache(MOST_SHORT, 16, SHORT_NEWEST)
def marking_steps(scene: Scene, shapes: tuple[Shape, ...]) -> tuple[Step, ...]:
    """Stages that mark which of these still shapes a ray meets; see `Scene.marking_steps`."""
    emission = [SMALL_LIGHT + j if o.material.shines else -SMALL_LIGHT - j for j, o in enumerate(shapes)]
    return tuple(_intersection(scene, 0.0, shapes=shapes, emission=emission))


@byte_cache(MOST_SHORT, 16, SHORT_NEWEST)
def depth_steps(scene: Scene, opening: float) -> tuple[Step, ...]:
    """Stages that find the depth only; see `Scene.depth_steps`."""
    return (*_intersection(scene, opening if scene.moves else 0.0), Step(depth_picture))


def is_rough(scene: Scene) -> bool:
    """Whether any coat reflects lights roughly."""
    return any(gloss < SHARP for gloss in _glosses(scene))


@stage
def depth_picture(lanes, p, ints, key):
    """RED: DEPTH in mm; GREEN: 1 where something was hit; BLUE: 0."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, red, green, blue = row[DEPTH], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        red[i] = depth[i]
        green[i] = real(1) if depth[i] < real(SKY_DISTANCE) else real(0)
        blue[i] = real(0)


def _intersection(scene: Scene, opening: float, reflected: bool = False, shapes: tuple[Shape, ...] | None = None,
                  emission: Sequence[float] | None = None,
                  specular: tuple[Shape, ...] | None = None) -> list[Step]:
    """Stages that find the nearest surface; `reflected`: the sun's disk is at least HIGHLIGHT_RADIUS.

    shapes: instead of the scene's objects; emission: EMITS of each, by default whether it shines; specular: the
    shapes as paths see them that are not DIRECT.
    """
    shapes = scene.objects if shapes is None else shapes
    emission = [_emits(o) for o in shapes] if emission is None else emission
    still = [one for one in zip(shapes, emission, shapes if specular is None else specular, strict=True)
             if not one[0].moves]
    steps = [sky_step(scene.sky)]
    if scene.sun is not None:
        radius = scene.sun.angular_radius
        steps.append(Step(sun_disk, sun_disk_parameters(scene.sun,
                                                        max(radius, HIGHLIGHT_RADIUS) if reflected else radius)))
    if scene.floor is not None:
        pictured = scene.floor.image is not None
        steps.append(pictured_floor_step(scene.floor) if pictured else Step(floor, floor_parameters(scene.floor)))
    if any(not is_large(o) for o, _, _ in still) or scene.moves:
        steps.append(Step(beam))
    steps += intersection_steps(still)
    if scene.moves:
        steps.append(Step(moving, *moving_parameters([o for o in scene.objects if o.moves], opening)))
    return steps


def _coats(scene: Scene, last: bool, shadows: bool, opening: float) -> list[Step]:
    """Stages of the clear coats; in the last round of a path metal reflects as they do.

    shadows: rough coats reflect samples of a picture of the sky, and not the nearest sky of three colours.
    """
    steps = []
    around, sun = sky_parameters(_gradient(scene)), scene.sun
    if scene.enclosed:                          # coats reflect the ambient light instead of the sky
        around, sun = np.array([*scene.ambient * 3, 0.0, 1.0, 0.0]), None
    ground = None if scene.floor is None else floor_parameters(scene.floor)
    lights = [o for o in scene.objects if o.material.shines and o.material.pattern is None]
    if last or any(g >= SHARP for g in _glosses(scene)) or any(o.material.kind == "glass" for o in scene.objects):
        disk = None if sun is None else sun_disk_parameters(sun, max(sun.angular_radius, HIGHLIGHT_RADIUS))
        mirrored = [o for o in lights if o.family == "planar" or (o.family == "sphere" and o.material.kind == "lamp")]
        picture = scene.sky if isinstance(scene.sky, ImageSky) and not scene.enclosed else None
        steps.append(clearcoat_step(around, picture, ground, _floor_light(scene), disk, mirrored, opening, last))
    if is_rough(scene):
        if shadows and _lights_by_picture(scene):
            steps.append(image_rough_clearcoat_step(scene.sky, ground, _floor_light(scene)))
            around = around * 0.0
        brightest = sorted(lights, key=_brightness, reverse=True)[:MOST_HIGHLIGHTS]
        steps.append(rough_clearcoat_step(around, brightest, opening))
    return steps


def _light(scene: Scene, shadows: bool, opening: float, sky_too: bool = True) -> list[Step]:
    """Stages of the light that falls on an albedo: sky, sun and lamps.

    sky_too: False leaves out ambient light and a sky of three colours, which a diffuse bounce meets.
    """
    around, lamps = np.concatenate([_surround(scene, shadows), scene.ambient]), _lamps(scene)
    shade = shadow_steps(scene.objects) if shadows else []
    occluders = all_occluders([o for o in scene.objects if o.family in ("sphere", "planar")], opening)
    between = [Step(shadow_stage, *occluders)] if shadows and occluders.parameters.size else []

    # Sky and ambient light
    steps = []
    if not shadows:
        steps.append(Step(open_light, np.concatenate([around, *(point_parameters(o) for o in lamps if not o.moves)])))
    elif sky_too:
        steps += _sky_between(scene, around, opening, shade)
    if shadows and _lights_by_picture(scene):
        steps += [sky_rays_step(scene.sky), *between, *shade, Step(add_tinted)]

    # Sun
    if scene.sun is not None:
        steps += [Step(sun_rays, sun_parameters(scene.sun)), *between, *shade, Step(add_lit, scene.sun.colour)]

    # Lamps, each by itself or by shares; without shadows the still ones have been added with the sky
    shared = [o for o in lamps if has_a_share(o)] if shadows else []
    if sum(any(o.material.colour) for o in shared) > MANY_LAMPS:
        steps += many_lamp_steps(shared, occluders, shade)
        lamps = [o for o in lamps if not has_a_share(o)]
    for o in lamps if shadows else [o for o in lamps if o.moves]:
        own_rays = FAMILIES[o.family].lamp
        rays = Step(lamp_rays, *lamp_parameters(o, opening)) if own_rays is None else own_rays(o)
        own_shade = shade if own_rays is None else shadow_steps(scene.objects, o)
        steps += [rays, *between, *own_shade, Step(add_lit, o.material.colour)]
    return [step._replace(lights=True) for step in steps]


def _sky_between(scene: Scene, around: np.ndarray, opening: float, shade: Sequence[Step]) -> list[Step]:
    """Stages of the light of sky and ambient light that spheres and meshes leave, planar shapes left out.

    around: parameters of the sky and the ambient radiance; shade: stages of the shadows of meshes: with any, a ray for
    each sample instead of a closed form.
    """
    balls = [o for o in scene.objects if o.family == "sphere" and not o.material.shines]
    if not shade:
        return [Step(ambient, *after(join(Packed(around), sky_occluders([o for o in balls if not o.moves])),
                                     moving_sky_occluders([o for o in balls if o.moves], opening)))]
    if not around[:UP].any() and not any(scene.ambient):
        return []
    occluders = all_occluders(balls, opening)
    between = [Step(shadow_stage, *occluders)] if occluders.parameters.size else []
    return [Step(gradient_rays, around), *between, *shade, Step(add_tinted)]


def _floor_light(scene: Scene) -> np.ndarray:
    """Irradiance / π on the floor below the middle of the near spheres, for its mirror image in coats."""
    if scene.floor is None:
        return np.zeros(3)
    normal = unit(scene.floor.normal)
    near = [s.centre for s in scene.spheres if not s.material.shines and math.dist(s.centre, (0, 0, 0)) < 3000.0]
    middle = np.mean(near, 0) if near else np.array([0.0, 0.0, -1000.0])
    point = middle + (scene.floor.height - middle @ normal) * normal
    around = _surround(scene)
    up = float(normal @ unit(_gradient(scene).up))
    zenith, horizon, below = around[0:3], around[3:6], around[6:9]
    total = np.asarray(scene.ambient) + horizon * (1 + up) / 2 + below * (1 - up) / 2
    total = total + rise.py_func(float, up) * (zenith - horizon)
    if scene.sun is not None:
        total = total + np.asarray(scene.sun.colour) * max(0.0, float(normal @ unit(scene.sun.direction)))
    for light in (o for o in _lamps(scene) if not o.moves):
        to = np.asarray(light.centre) - point
        distance = math.sqrt(to @ to)
        slant = max(0.0, float(to @ normal)) / distance
        size = light.silhouette(to / distance) / math.pi
        total = total + np.asarray(light.material.colour) * slant * size / distance**2
    return total


def _emits(shape: Shape) -> float:
    """EMITS of a shape by its material alone."""
    return SHINES if shape.material.shines else DARK


def _lamps(scene: Scene) -> list[Shape]:
    return [o for o in scene.objects if o.material.kind == "lamp"]


def _glosses(scene: Scene) -> set[float]:
    """The gloss of every coat."""
    glosses = {o.material.gloss for o in scene.objects if o.material.kind == "coat"}
    return glosses | ({scene.floor.gloss} if scene.floor is not None and scene.floor.gloss > 0.0 else set())


def _surround(scene: Scene, shadows: bool = False) -> np.ndarray:
    """The sky as a light: black where the scene is enclosed, or where samples of its picture light the scene."""
    dark = scene.enclosed or (shadows and isinstance(scene.sky, ImageSky))
    return sky_parameters(_gradient(scene)) * (0.0 if dark else 1.0)


def _gradient(scene: Scene) -> Sky:
    """The sky, or the sky of three colours that is nearest to its picture."""
    return scene.sky.gradient if isinstance(scene.sky, ImageSky) else scene.sky


def _lights_by_picture(scene: Scene) -> bool:
    return isinstance(scene.sky, ImageSky) and not scene.enclosed and sky_cells(scene.sky).flux > 0.0


def _brightness(light: Shape) -> float:
    """Of a light seen from the origin: its radiance times its greatest solid angle."""
    return sum(light.material.colour) * light.area / max(math.hypot(*light.centre), 1.0) ** 2
