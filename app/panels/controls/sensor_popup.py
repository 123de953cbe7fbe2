"""Popup “Sensor” of the left column: the sensor and its noise. The exposure is on the camera strip."""

from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.state import dial_scales
from lensbench.app.state.setting_table import BITS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.toggles import toggles


def in_use(settings: Settings) -> bool:
    """Whether a sensor records the picture."""
    return settings.noise


def sensor_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
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
