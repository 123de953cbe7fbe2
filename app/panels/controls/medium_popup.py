"""Popup “Air” of the left column: fog or water before the camera."""

from dataclasses import replace

from lensbench.app.state import dial_scales
from lensbench.app.state.setting_table import MEDIUMS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.toggles import toggles

CLEAREST_WATER = 65_000.0       # mm of visibility: in pure water a little more
TIPS = {"air": "Clear air: light goes through it unchanged",
        "fog": "Fog: light is scattered out of the view and into it, by Beer and Lambert's law",
        "water": "Water: it also absorbs, red most of all, and refracts before the camera"}
FRONTS = {False: "Flat window", True: "Immersed"}
FRONT_TIPS = {False: "The camera looks through a flat window: angles are smaller in the water by its index",
              True: "The lens itself is in the water: its front surface bends light less than in air"}


def in_use(settings: Settings) -> bool:
    """Whether the medium is other than clear air."""
    return settings.medium != "air"


def air_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    names = {key: name for key, name in MEDIUMS.items() if key != "water" or settings.kind.under_water}
    medium = toggles("Medium", names, settings.medium, TIPS, 3.6)
    if medium != settings.medium:
        settings = replace(settings, medium=medium)
        if medium == "water":
            settings = replace(settings, visibility=min(settings.visibility, CLEAREST_WATER))
    if settings.medium == "air":
        return settings
    scale = dial_scales.visibility_scale(CLEAREST_WATER if settings.medium == "water" else 1e6)
    visibility = dial("Visibility", settings.visibility, scale,
                      "Distance at which a black object has a fiftieth of its contrast, in metres")
    light = dial("Scattered light", settings.fog_light, dial_scales.light_scale(),
                 "Radiance that the medium scatters into the view; 1 is that of a white wall under an even sky")
    settings = replace(settings, visibility=visibility, fog_light=light)
    if settings.medium == "water" and settings.has_lens:
        settings = replace(settings, immersed=toggles("Front", FRONTS, settings.immersed, FRONT_TIPS, 3.6))
    return settings
