"""A lens and its film seen from above: turned by a quarter about the axis, so that the section x–z takes that of y–z.

Lens frame, mm: what lies at +x before lies at +y after.
"""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.settings import Settings
from lensbench.optics.stop_image import StopImage
from lensbench.optics.surface_pose import Frame, SurfacePose, tilts_of

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])     # +x becomes +y


def quarter_turned(lens: lb.Lens) -> lb.Lens:
    """The lens turned so that +x becomes +y; itself where it is rotationally symmetric."""
    if lens.is_rotationally_symmetric and lens.stop_image is None and not lens.blades:
        return lens
    return _quarter_turned(lens)


@lru_cache(maxsize=16)
def _quarter_turned(lens: lb.Lens) -> lb.Lens:
    image = lens.stop_image
    return replace(lens, surfaces=tuple(_turned(surface) for surface in lens.surfaces),
                   blade_rotation=lens.blade_rotation + 0.5 * math.pi if lens.blades else lens.blade_rotation,
                   stop_image=None if image is None else _turned_image(image))


def _turned(surface: lb.Surface) -> lb.Surface:
    pose = surface.pose
    if pose is not None:
        # The quarter turn of the place in its new coordinates: the shape is turned by itself
        tilt_x, tilt_y, roll = tilts_of(QUARTER @ Frame.of(pose, 0.0).rotation @ QUARTER.T)
        pose = SurfacePose(-pose.decentre_y or 0.0, pose.decentre_x, tilt_x, tilt_y, pose.pivot, roll)
    if surface.curvature_x is None:
        return surface if pose is None else replace(surface, pose=pose)
    return replace(surface, curvature=surface.curvature_x, curvature_x=surface.curvature, pose=pose)


def _turned_image(image: StopImage) -> StopImage:
    texels = np.frombuffer(image.texels, np.float32).reshape(image.side, image.side)
    return replace(image, texels=np.ascontiguousarray(np.rot90(texels)).tobytes())


def has_two_sections(settings: Settings, lens: lb.Lens | None) -> bool:
    """Whether the section from above differs from that from the side: of a lens without symmetry, or its film."""
    if lens is None:
        return False
    pose = settings.film_pose
    return not lens.is_rotationally_symmetric or pose.is_tilted or bool(pose.rise or pose.shift)
