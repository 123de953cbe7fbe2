"""Popup “Sensor” of the left column: the exposure triangle with its EV, and the sensor with its noise."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.state import dial_scales
from lensbench.app.state.exposure import AppliedExposure, exposure_text
from lensbench.app.state.settings import BITS, EXPOSURES, METERINGS, Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.toggles import toggles

DEFAULT = Settings()
EXPOSURE_TIPS = {
    "plain": "The light as it is: neither stop nor time nor ISO changes how bright the picture is",
    "triangle": "As in a camera: a longer time, a wider stop and a higher ISO brighten the picture",
    "automatic": "The ISO follows the picture, at the f-number and time that are set",
}
METERING_TIPS = {
    "mean": "The mean of the picture becomes a middle grey",
    "highlights": "All but a thousandth of the picture stays below white",
}


def in_use(settings: Settings) -> bool:
    """Whether exposure or sensor change the picture."""
    return settings.exposing != "plain" or settings.noise


def sensor_popup(settings: Settings, found: AppliedExposure | None) -> Settings:
    """Draw the popup's content; the changed settings. found: the exposure of the picture."""
    settings = replace(settings, exposing=toggles("Mode", EXPOSURES, settings.exposing, EXPOSURE_TIPS))
    if settings.exposing == "automatic":
        settings = replace(settings, metering=toggles("Meter", METERINGS, settings.metering, METERING_TIPS))
    if found is not None:
        theme.small()
        imgui.text_disabled(exposure_text(found))
        imgui.pop_font()
        imgui.set_item_tooltip("Exposure value, log2 N²/t with the working f-number; the equivalent at ISO 100;\n"
                               "and the exposure H of a white wall under an even sky of 1000 cd/m²")
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))
    shutter = dial("Shutter", settings.shutter, dial_scales.shutter_scale(DEFAULT.shutter),
                   "Exposure time t, in s; the same setting as under Motion")
    settings = replace(settings, shutter=shutter)
    automatic = settings.exposing == "automatic" and found is not None
    iso = found.iso if automatic and found is not None else settings.iso
    turned = dial("ISO", iso, dial_scales.iso_scale(), "Speed: the gain behind the sensor, of signal and noise alike")
    if turned != iso:
        settings = replace(settings, iso=turned, exposing="triangle" if automatic else settings.exposing)

    # The sensor
    settings = replace(settings, noise=check_box("Sensor with noise", settings.noise))
    imgui.set_item_tooltip("Photons become electrons at random, a full well clips,\n"
                           "reading adds noise, and the converter rounds")
    return _sensor(settings) if settings.noise else settings


def _sensor(settings: Settings) -> Settings:
    well = dial("Full well", settings.full_well, dial_scales.full_well_scale(),
                "Electrons that a pixel holds, filled at ISO 100 by what is white")
    efficiency = dial("Quantum efficiency", settings.quantum_efficiency, dial_scales.part_scale(1.0, 0.5),
                      "Part of the photons that become electrons. For the same full well, fewer of them\n"
                      "mean a larger pixel, and not more noise")
    noise = dial("Read noise", settings.read_noise, dial_scales.read_noise_scale(),
                 "Noise of reading a pixel, electrons rms")
    settings = replace(settings, full_well=well, quantum_efficiency=max(efficiency, 0.01), read_noise=noise)
    tip = "Bits of the analogue-to-digital converter"
    return replace(settings, bits=toggles("Bits", {bits: f"{bits}" for bits in BITS}, settings.bits,
                                          dict.fromkeys(BITS, tip)))
