"""Colours of the AOVs (see `lensbench.rendering.aovs`): codes from 0 to 1 for the values of the core.

Screen, PNG and PPM show the codes without exposure and tone curve; an EXR or PFM file holds the values of the core.
"""

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.camera_kinds import LENS_MODELS
from lensbench.app.state.settings import Settings

NOTES = {
    "direction": "(d + 1) / 2 of the ray's direction in the world: right is red, up green, backwards blue",
    "origin": "Where the ray leaves the lens: right is red, up green; blue along the axis, one lens radius for ½",
    "time": "When the sample was taken: black at the opening of the shutter, white at its closing",
    "depth": "Nearness: white at {near:.2g} m, ½ at twice that, black for the sky",
    "weight": "Weight of the samples: white for the unvignetted axis",
    "fate": "Rays from all over the rear opening: white where they arrive, coloured by the surface that ends them",
}


def codes(image: NDArray[np.float32], settings: Settings) -> NDArray[np.float32]:
    """An AOV (h, w, 3) as codes in [0, 1]; nan becomes 0."""
    image = np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0)
    if settings.view == "origin":
        place, radius = _front(settings)
        image = (image - np.array([0.0, 0.0, place], np.float32)) / (2.0 * radius) + 0.5
    elif settings.view == "depth":
        image = image * (nearest(settings) / 1000.0)
    return np.clip(image, 0.0, 1.0)


def nearest(settings: Settings) -> float:
    """The distance (mm) that the AOV “depth” shows as white."""
    from lensbench.app.state.scene_file import cached_scene

    return cached_scene(settings.scene).depth_range[0]


def note(settings: Settings) -> str:
    """The meaning of the colours of the AOV."""
    near = nearest(settings) / 1000.0 if settings.view == "depth" else 0.0
    return NOTES[settings.view].format(near=near)


def _front(settings: Settings) -> tuple[float, float]:
    """Where rays leave the camera along its z (mm), and the radius (mm) of the opening there."""
    from lensbench.app.state.build import setup

    rays_from = LENS_MODELS[settings.lens_model].rays_from if settings.has_lens else ""
    if not rays_from:
        return 0.0, 1.0
    lens_setup = setup(settings)
    if rays_from == "front":
        return -lens_setup.film_z, lens_setup.lens.surfaces[0].semi_diameter
    return lens_setup.first_order.entrance_pupil.z - lens_setup.film_z, lens_setup.first_order.entrance_pupil.radius
