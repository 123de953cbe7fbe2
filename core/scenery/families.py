"""Families of shapes: the stages that intersect, hide and light with the shapes of each, one row a family.

Spheres and planar shapes also hide and mirror each other in stages that read the numbers of both (`soft_shadows`,
`clearcoat`, `moving_objects`). A family without a part there casts its shadows by stages of its own, is not mirrored by
sharp coats, and stays at rest, as meshes do. A new family is its file in `objects/`, its stages, and a row here.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from lensbench.core.kernels.block import Step
from lensbench.core.scenery.intersect.meshes import mesh_steps
from lensbench.core.scenery.intersect.pictured import is_large, pictured_step
from lensbench.core.scenery.intersect.planar import plain_planar, planar, planar_parameters
from lensbench.core.scenery.intersect.spheres import sphere_parameters, spheres
from lensbench.core.scenery.objects.basic_shapes import Planar, Sphere
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.shading.meshes import mesh_lamp_step, mesh_shadow_steps

Seen = Sequence[tuple[Shape, float, Shape]]     # a shape, its EMITS, and the shape as paths see it that are not DIRECT


@dataclass(frozen=True)
class Family:
    """Shapes that the same stages read.

    field: the field of `Scene` that holds them, all of the class `kind`. intersection: stages that find shapes at rest,
    behind `beam`. shadows: stages of the shadows of its own shapes, given also a lamp among them that hides its own
    light, or None; None where `soft_shadows` has them. lamp: stage of a lamp that has rays of its
    own; None where `soft_shadows.lamp_rays` samples it. hollow: a ray through a shape of glass meets it twice.
    """

    field: str
    kind: type
    intersection: Callable[[Seen], list[Step]]
    shadows: Callable[[tuple[Any, ...], Shape | None], tuple[Step, ...]] | None = None
    lamp: Callable[[Shape], Step] | None = None
    hollow: bool = False


def _spheres(shapes: Seen) -> list[Step]:
    return [Step(spheres, *sphere_parameters(*list(zip(*shapes, strict=True))[:2]))]


def _planar(shapes: Seen) -> list[Step]:
    plain = all(shape.material.pattern is None for shape, _, _ in shapes)
    return [Step(plain_planar if plain else planar, *planar_parameters(*zip(*shapes, strict=True)))]


def _meshes(shapes: Seen) -> list[Step]:
    return mesh_steps(*list(zip(*shapes, strict=True))[:2])


FAMILIES = {        # by `Shape.family`, in the order of `Scene.objects`
    "sphere": Family("spheres", Sphere, _spheres),
    "planar": Family("plates", Planar, _planar),
    "mesh": Family("meshes", Mesh, _meshes, mesh_shadow_steps, mesh_lamp_step, hollow=True),
}


def by_field(shapes: Iterable[Shape]) -> dict[str, tuple[Shape, ...]]:
    """Shapes by the field of `Scene` that holds them."""
    shapes = tuple(shapes)
    return {family.field: tuple(o for o in shapes if o.family == name) for name, family in FAMILIES.items()}


def intersection_steps(shapes: Seen) -> list[Step]:
    """Stages that find the nearest of shapes at rest; those with an image of their own stage follow the planar ones."""
    steps = []
    for name, family in FAMILIES.items():
        own = [one for one in shapes if one[0].family == name and not is_large(one[0])]
        steps += family.intersection(own) if own else []
        if name == "planar":
            steps += [pictured_step(o, emits) for o, emits, _ in shapes if is_large(o)]
    return steps


def shadow_steps(shapes: Sequence[Shape], lamp: Shape | None = None) -> list[Step]:
    """Stages of the shadows that families cast by stages of their own. lamp: a shape that hides its own light."""
    return [step for name, family in FAMILIES.items() if family.shadows is not None
            for step in family.shadows(tuple(o for o in shapes if o.family == name), lamp)]
