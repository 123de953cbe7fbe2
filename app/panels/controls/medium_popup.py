"""Air, a popup of the left column: fog or water before the camera."""

from dataclasses import replace

from lensbench.app.state import time_scales
from lensbench.app.state.settings import MEDIUMS, Settings
from lensbench.app.widgets.dial import ring
from lensbench.app.widgets.toggles import toggles

CLEAREST_WATER = 65_000.0       # mm of visibility: in pure water it is a little more
TIPS = {"air": "Clear air: light goes through it unchanged",
        "fog": "Fog: light is scattered out of the view and into it, by Beer and Lambert's law",
        "water": "Water: it also absorbs, red most of all, and refracts before the camera"}
FRONTS = {False: "Flat window", True: "Lens in it"}
FRONT_TIPS = {False: "The camera looks through a flat window: angles are smaller in the water by its index",
              True: "The lens stands in the water itself: its front surface bends light less than in air"}


def in_use(settings: Settings) -> bool:
    """Whether there is anything but clear air."""
    return settings.medium != "air"


def air_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the settings as they have been set."""
    names = {key: name for key, name in MEDIUMS.items() if key != "water" or settings.model != "environment"}
    medium = toggles("Before", names, settings.medium, TIPS, 3.6)
    if medium != settings.medium:
        settings = replace(settings, medium=medium)
        if medium == "water":
            settings = replace(settings, visibility=min(settings.visibility, CLEAREST_WATER))
    if settings.medium == "air":
        return settings
    scale = time_scales.visibility_scale(CLEAREST_WATER if settings.medium == "water" else 1e6)
    visibility = ring("Visibility", settings.visibility, scale,
                      "How far one sees: there a black thing has a fiftieth of its contrast, in metres")
    light = ring("Its light", settings.fog_light, time_scales.light_scale(),
                 "Radiance that it scatters into the view; 1 is that of a white wall under an even sky")
    settings = replace(settings, visibility=visibility, fog_light=light)
    if settings.medium == "water" and not settings.lensless:
        settings = replace(settings, wet=toggles("Front", FRONTS, settings.wet, FRONT_TIPS, 3.6))
    return settings
