"""The camera strip above the picture: mode, f-number, time, ISO, exposure correction and the meter, always there.

Each value answers the wheel by third stops; a click opens its dial.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, ImVec4, imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.exposure import METERED, MODES, AppliedExposure, exposure_text, mode_of, with_mode
from lensbench.app.display.frame import View
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import explain, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.settings import dial_scales
from lensbench.app.settings.dial_scales import Scale
from lensbench.app.settings.setting_table import METERINGS
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_exposure
from lensbench.core.kernels.cache import NotCompiledError
from lensbench.core.text import fixed

DEFAULT = Settings()
METER = 3.0                     # stops to either side
METER_WIDTH = 8.5               # em
NARROW_METER = 4.0              # em: of a meter without its figure
METERING_TIPS = {
    "mean": "The mean of the picture becomes a middle grey",
    "highlights": "All but a thousandth of the picture stays below white",
}


@dataclass(frozen=True)
class Value:
    """One value of the strip: name, dial, current value, setter, tooltip; follows: the meter or nothing sets it."""

    name: str
    scale: Scale
    value: float
    taken: Callable[[Settings, float], Settings]
    tip: str
    follows: bool = False
    idle: bool = False          # it does not change the brightness in this mode


def strip_height() -> float:
    """Height of the strip in pixels."""
    return round(theme.em(1.75))


def camera_strip(settings: Settings, view: View, applied: AppliedExposure | None, off: float | None) -> Settings:
    """Draw the strip in the rest of the line; returns the settings after its changes.

    found: the exposure of the picture. off: stops by which the picture is brighter than the meter would have it.
    NotCompiledError: its values need a kernel that is not compiled yet; the strip keeps its room.
    """
    corner, width, height = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x, strip_height()
    mode = mode_of(settings, view.program)
    try:
        values = strip_values(settings, mode, applied)
    except NotCompiledError:
        _go_below(corner, height)
        raise
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 8.0 * theme.scale(),
                                       corner.y + round(0.5 * (height - imgui.get_frame_height()))))
    imgui.push_style_color(imgui.Col_.button, ImVec4(0.0, 0.0, 0.0, 0.0))
    chosen = _modes(mode, width)
    if chosen != mode:
        view.program = chosen if chosen in METERED else ""
        settings = with_mode(settings, chosen)
    imgui.same_line(0.0, theme.em(0.7))
    for value in values:
        settings = _shown(settings, value)
        imgui.same_line(0.0, theme.em(0.15))
    right = corner.x + width - theme.em(0.7)
    wide = min(theme.em(METER_WIDTH), right - imgui.get_cursor_screen_pos().x)
    if wide > theme.em(NARROW_METER):
        settings = _meter(settings, mode, applied, off, ImVec2(right - wide, corner.y), ImVec2(wide, height))
    imgui.pop_style_color()
    _go_below(corner, height)
    return settings


def _go_below(corner: ImVec2, height: float) -> None:
    """Move the cursor below the strip."""
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    imgui.dummy(ImVec2(0.0, 0.0))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))


def _modes(mode: str, width: float) -> str:
    """The modes as a row of letters, or as a list where there is little room."""
    names = {key: key for key in ("P", "A", "S", "M")}
    names = {"off": MODES["off"][0], **names, "I": MODES["I"][0]}
    tips = {key: f"{title}: {tip[0].lower()}{tip[1:]}" if key != "off" else tip for key, (title, tip) in MODES.items()}
    if width > theme.em(44.0):
        return toggles("Mode", names, mode, tips, 0.0)
    if imgui.button(f"{MODES[mode][0] if mode in ('off', 'I') else mode}###Mode list"):
        imgui.open_popup("Modes")
    explain(tips[mode])
    lower = imgui.get_item_rect_min().x, imgui.get_item_rect_max().y
    imgui.set_next_window_pos(ImVec2(*lower), imgui.Cond_.appearing)
    if imgui.begin_popup("Modes"):
        for key, (title, _) in MODES.items():
            letter = key if key in names and key not in ("off", "I") else " "
            if imgui.selectable(f"{letter}  {title}###Mode {key}", key == mode)[0]:
                mode = key
            imgui.set_item_tooltip(tips[key])
        imgui.end_popup()
    return mode


def strip_values(settings: Settings, mode: str, applied: AppliedExposure | None) -> list[Value]:
    """The values of the strip in a mode; found: the exposure of the picture."""
    got, off = readings(settings), mode == "off"
    values = []
    if settings.has_f_number and not (settings.f_number is None and got.f_number is None):
        widest = got.widest_f_number or 1.0
        shown = settings.f_number if settings.f_number is not None else widest

        def aperture(current: Settings, value: float) -> Settings:
            return replace(current, f_number=None if current.has_lens and value <= widest else value)

        values.append(Value("f-number", dial_scales.aperture_scale(widest, max(DEFAULT.f_number or widest, widest)),
                            shown, aperture, "f-number N: focal length over the diameter of the entrance pupil",
                            mode in ("P", "S")))
    triangle = applied is None or applied.triangle is not None

    def time(current: Settings, value: float) -> Settings:
        return replace(current, shutter=value)

    def iso(current: Settings, value: float) -> Settings:
        return replace(current, iso=value, exposing="triangle" if current.exposing == "automatic" else current.exposing)

    values.append(Value("Time", dial_scales.shutter_scale(DEFAULT.shutter), settings.shutter, time,
                        "Exposure time t: what moves blurs; it brightens the picture in the modes P A S M",
                        mode in ("P", "A"), off))
    if triangle:
        automatic = mode == "I" and applied is not None
        values.append(Value("ISO", dial_scales.iso_scale(), applied.iso if automatic and applied else settings.iso, iso,
                            "Speed: the gain after the sensor, for signal and noise", automatic, off))

    def correction(current: Settings, value: float) -> Settings:
        return replace(current, exposure=value)

    values.append(Value("Correction", dial_scales.exposure_scale(), settings.exposure, correction,
                        "Exposure correction: stops by which the picture is brightened, over the mode's choice"))
    return values


def _shown(settings: Settings, value: Value) -> Settings:
    """One value as a flat button; the wheel steps it, a click opens its dial."""
    colour = theme.colours()
    text = format_exposure(value.value) if value.name == "Correction" else value.scale.format(value.value)
    ink = colour.dim if value.idle or value.follows else colour.strong
    imgui.push_style_color(imgui.Col_.text, ImVec4(*ink))
    if imgui.button(f"{text}###Strip {value.name}"):
        imgui.open_popup(f"Dial {value.name}")
    imgui.pop_style_color()
    notes = ["Click for its dial, wheel for the next third stop"]
    if value.follows:
        notes = ["The meter sets it in this mode; setting it by hand changes to M"]
    elif value.idle:
        notes.append("In the mode “As it is” it does not change the brightness")
    explain("\n".join([value.tip, *notes]))
    turned = value.value
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        wheel = imgui.get_io().mouse_wheel
        if wheel:
            turned = value.scale.stepped(value.value, int(math.copysign(max(1.0, abs(wheel)), wheel)))
    lower = imgui.get_item_rect_min().x, imgui.get_item_rect_max().y + 3.0 * theme.scale()
    imgui.set_next_window_pos(ImVec2(*lower), imgui.Cond_.appearing)
    imgui.set_next_window_size(ImVec2(theme.em(18.0), 0.0))
    if imgui.begin_popup(f"Dial {value.name}"):
        turned = dial(f"{value.name}", value.value, value.scale, value.tip)
        imgui.end_popup()
    return value.taken(settings, turned) if turned != value.value else settings


def _meter(settings: Settings, mode: str, applied: AppliedExposure | None, off: float | None, corner: ImVec2,
           size: ImVec2) -> Settings:
    """The needle on a scale of ±METER stops; a click opens the choice of the metering."""
    colour, pixel, draw = theme.colours(), theme.scale(), imgui.get_window_draw_list()
    wide, height = size.x, size.y
    imgui.set_cursor_screen_pos(corner)
    if imgui.invisible_button("Meter", ImVec2(wide, height)):
        imgui.open_popup("Metering")
    lines = ["Meter: exposure of the picture relative to the metered exposure, in stops"]
    if applied is not None:
        lines.append(exposure_text(applied))
    if off is not None and mode in METERED and abs(off - settings.exposure) > 0.3:
        lines.append("The range of f-numbers or times ends before the meter's choice")
    explain("\n".join(lines))
    ev = f"EV {fixed(applied.triangle.ev100, 1)}" if applied is not None and applied.triangle is not None else ""
    theme.small()
    room = imgui.calc_text_size("EV −10.0").x + theme.em(0.4) if wide >= theme.em(METER_WIDTH) else 0.0
    if room:
        line = imgui.get_text_line_height()
        draw.add_text(ImVec2(round(corner.x), round(corner.y + 0.5 * (height - line))), theme.packed(colour.dim),
                      ev.replace("-", "−"))
    imgui.pop_font()
    left, right = corner.x + room + theme.em(0.3), corner.x + wide - theme.em(0.3)
    base = round(corner.y + 0.72 * height)
    for i in range(int(-3 * METER), int(3 * METER) + 1):
        x = round(left + (i / 3.0 + METER) / (2.0 * METER) * (right - left))
        tall = 0.34 if i == 0 else 0.24 if i % 3 == 0 else 0.1
        draw.add_rect_filled(ImVec2(x, base - round(tall * height)), ImVec2(x + max(pixel, 1.0), base),
                             theme.packed(colour.text if i % 3 == 0 else colour.faint))
    if off is not None and math.isfinite(off):
        x = left + (min(max(off, -METER), METER) + METER) / (2.0 * METER) * (right - left)
        draw.add_triangle_filled(ImVec2(x, base + pixel), ImVec2(x - 4.0 * pixel, base + 6.0 * pixel),
                                 ImVec2(x + 4.0 * pixel, base + 6.0 * pixel), theme.packed(colour.strong))
    imgui.set_next_window_pos(ImVec2(corner.x + wide, corner.y + height), imgui.Cond_.appearing, ImVec2(1.0, 0.0))
    if imgui.begin_popup("Metering"):
        settings = replace(settings, metering=toggles("Meter", METERINGS, settings.metering, METERING_TIPS))
        imgui.end_popup()
    return settings
