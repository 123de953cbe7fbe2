"""What a file of another format cannot hold of a lens, as findings: reported of everything that its row does not list.

A field that `Lens` or `Surface` gets, and a new kind of surface, is so reported by every writer until its row in the
table of formats names it.
"""

from collections.abc import Collection
from dataclasses import MISSING, Field, fields
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Shape
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import SystemData
from lensbench.core.text import significant

# Sets for the rows of formats. No set is all of `Shape`: no format holds a new member until its set names it
ROTATIONAL = frozenset({Shape.SPHERE, Shape.CONIC, Shape.EVEN_ASPHERE, Shape.ASPHERE})
COMMON = ROTATIONAL | {Shape.CYLINDER, Shape.TOROID}
SYSTEM = frozenset({"aperture", "fields", "wavelengths", "object distance"})

NAMED = frozenset({"name"})                                         # the fields of `Lens` that formats write
TITLED = NAMED | {"notes"}
WORDS = {"stated_efl": "stated focal length", "stated_f_number": "stated f-number", "film_size": "film size",
         "estimates": "what is estimated", "coating": "coatings"}
STOP = frozenset({"blades", "blade_rotation", "roundness", "blade_reach", "stop_image"})
# Fields that every writer writes, or of which it reports what it cannot hold
OF_LENS = frozenset({"surfaces", "stop_index", "positions", "findings", "front_index", "system", *STOP})
OF_SURFACE = frozenset({"curvature", "thickness", "semi_diameter", "glass", "conic", "aspheric", "curvature_x", "pose"})


def lost_fields(lens: Lens, written: Collection[str]) -> list[Finding]:
    """Findings about the fields of a lens and its surfaces that its format does not hold.

    written: the names of those that it holds besides OF_LENS and OF_SURFACE. Shapes, poses, positions and system data
    have findings of their own.
    """
    own = {*OF_LENS, *OF_SURFACE, *written}
    words = [_words(field) for field in fields(lens) if field.name not in own and _is_stated(field, lens)]
    findings = [note(Kind.LEFT_OUT, f"left out: {', '.join(words)}")] if words else []
    for field in {field.name: field for surface in lens.surfaces for field in fields(surface)}.values():
        stating = [i for i, surface in enumerate(lens.surfaces) if field.name not in own and _is_stated(field, surface)]
        if stating:
            findings.append(note(Kind.LEFT_OUT, f"left out: the {_words(field)} of {len(stating)} of "
                                                f"{len(lens.surfaces)} surfaces",
                                 stating[0] if len(stating) == 1 else None))
    if not STOP <= set(written):
        if lens.stop_image is not None:
            findings.append(without_picture(lens))
        elif lens.blades and lens.roundness < 1.0:
            findings.append(note(Kind.STOP, "the blades of the stop are left out: it is written as a circle of equal "
                                            "area", lens.stop_index))
    if lens.front_index != 1.0 and "front_index" not in written:
        findings.append(note(Kind.LEFT_OUT, f"the index {significant(lens.front_index)} before the lens is left out: "
                                            "it is written as in air", index=lens.front_index))
    return findings


def _is_stated(field: Field[Any], owner: Any) -> bool:
    """Whether a lens or surface has another value than the default one; a field without default always counts."""
    return field.default is MISSING or bool(getattr(owner, field.name, field.default) != field.default)


def _words(field: Field[Any]) -> str:
    return WORDS.get(field.name, field.name.replace("_", " "))


def without_picture(lens: Lens) -> Finding:
    """The finding about a picture in the stop, which no other format holds."""
    return note(Kind.STOP, "the picture in the stop is left out: it is written as the circle about it", lens.stop_index)


def lost_poses(lens: Lens) -> list[Finding]:
    """A warning for each tilted or decentred surface, for a format that holds no decentre and no tilt."""
    return [Finding(Kind.SHAPE, i, f"surface {i} is decentred or tilted, which this format cannot hold: it is written "
                                   "in line, and this is another lens")
            for i, surface in enumerate(lens.surfaces) if surface.pose is not None]


def lost_shapes(lens: Lens, shapes: frozenset[Shape], instead: str) -> list[Finding]:
    """A warning for each surface whose shape a format cannot hold. instead: the shape written in its place."""
    forms = [(i, surface.form) for i, surface in enumerate(lens.surfaces)]
    return [Finding(Kind.SHAPE, i, f"surface {i} is {shape.value}, which this format cannot hold: {instead}, and this "
                                   "is another lens") for i, shape in forms if shape not in shapes]


def lost_system(system: SystemData, written: frozenset[str]) -> list[Finding]:
    """The finding about system data of a lens that a format does not hold; written: of the words of SYSTEM."""
    none = SystemData()
    has = {"aperture": system.aperture is not None, "fields": bool(system.fields),
           "wavelengths": bool(system.wavelengths), "object distance": system.object_distances != none.object_distances}
    lost = [word for word, is_stated in has.items() if is_stated and word not in written]
    return [note(Kind.LEFT_OUT, f"left out of its system data: {', '.join(lost)}")] if lost else []
