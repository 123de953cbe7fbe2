"""Lights in three stages: points of the light, shadows of each kind of occluder, and the sum.

Where spheres and planar shapes alone hide a light, one stage does all of it (`soft_shadows`, `moving_lights`). A sky
shown by a picture, and a scene with meshes, put the parts together as they need them. A0 … A7, as `shadow` reads them,
stay from the first part to the last.
"""

from lensbench.kernels.block import stage
from lensbench.scenery.shading.illumination import count_lit
from lensbench.scenery.shading.moving_lights import sample_moving_lamp, shadow_moving
from lensbench.scenery.shading.soft_shadows import add_light, sample_lamp, sample_sun, shadow


@stage
def sun_rays(lanes, p, ints, key):
    """Sample a point of the sun.  p: sun_parameters."""
    if count_lit(lanes) > 0:
        sample_sun(lanes, p)


@stage
def lamp_rays(lanes, p, ints, key):
    """Sample a point of a lamp.  p, ints: sphere_lamp or planar_lamp."""
    if count_lit(lanes) > 0:
        sample_lamp(lanes, p, ints[0])


@stage
def moving_lamp_rays(lanes, p, ints, key):
    """Sample a point of a moving lamp.  p: its MOTION, then as ints of sphere_lamp or planar_lamp."""
    if count_lit(lanes) > 0:
        sample_moving_lamp(lanes, p, ints[0])


@stage
def shadow_stage(lanes, p, ints, key):
    """Shadows of spheres and planar shapes.  p, ints: occluder_parameters."""
    if count_lit(lanes) > 0:
        shadow(lanes, p, ints)


@stage
def moving_shadows(lanes, p, ints, key):
    """Shadows of moving spheres and planar shapes.  p, ints: moving_occluders."""
    if count_lit(lanes) > 0:
        shadow_moving(lanes, p, ints)


@stage
def add_lit(lanes, p, ints, key):
    """Add the light A7 of the colour p (3)."""
    if count_lit(lanes) > 0:
        add_light(lanes, p)
