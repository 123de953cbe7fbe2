"""Popup “Motion” of the left column: the shutter, two keyframes of the camera with a scrub bar, a rolling shutter."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui
from imgui_bundle import icons_fontawesome_6 as fa

from lensbench.app.state import dial_scales
from lensbench.app.state.setting_table import READOUT_DIRECTIONS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.toggles import toggles

DEFAULT = Settings()
ARROWS = {"down": fa.ICON_FA_ARROW_DOWN, "up": fa.ICON_FA_ARROW_UP, "left": fa.ICON_FA_ARROW_LEFT,
          "right": fa.ICON_FA_ARROW_RIGHT}


def in_use(settings: Settings) -> bool:
    """Whether the camera moves."""
    return settings.keyframed


def motion_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    shutter = dial("Shutter", settings.shutter, dial_scales.shutter_scale(DEFAULT.shutter),
                   "Exposure time t of each row of the film: moving objects blur")
    settings = replace(settings, shutter=shutter)
    settings = _keyframes(settings)
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))

    # Rolling shutter
    readout = dial("Read-out", settings.readout, dial_scales.readout_scale(),
                   "Rolling shutter: time from the first row of the picture to the last, in ms. 0: all at once")
    settings = replace(settings, readout=readout)
    direction = toggles("Order", ARROWS, settings.readout_direction, {
        key: f"{name}: the order in which the rows of the upright picture are exposed"
        for key, name in READOUT_DIRECTIONS.items()})
    settings = replace(settings, readout_direction=direction)
    ramp = dial("Opening and closing", settings.shutter_ramp, dial_scales.part_scale(),
                "Part of the shutter time that it takes to open, and again to close. 0 %: at once")
    return replace(settings, shutter_ramp=ramp)


def _scrubbed(settings: Settings) -> Settings:
    """The scrub bar, and its duration."""
    moment = dial("Time", settings.moment, dial_scales.moment_scale(settings.duration),
                  "When the shutter opens, in s. The ends of the bar are the two keyframes of the camera:\n"
                  "moving the camera in the picture changes the nearer one")
    settings = replace(settings, moment=moment)
    duration = dial("Duration", settings.duration, dial_scales.duration_scale(),
                    "Time from the first keyframe to the second, in s")
    if duration != settings.duration:
        settings = replace(settings, duration=duration, moment=settings.moment * duration / settings.duration)
    return settings


def _keyframes(settings: Settings) -> Settings:
    """The two keyframes of the camera: buttons that set and clear them, and the scrub bar."""
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))
    if settings.moves:
        settings = _scrubbed(settings)
    if settings.end_position is None:
        if imgui.button("Move the camera", ImVec2(-1.0, 0.0)):
            settings = replace(settings, end_position=settings.position, end_yaw=settings.yaw,
                               end_pitch=settings.pitch, moment=settings.duration)
        imgui.set_item_tooltip("Make the camera's pose the first of two keyframes. The scrub bar then moves to the "
                               "second:\nmove the camera in the picture to the place where its motion ends")
        return settings
    if imgui.button("Remove the motion", ImVec2(-1.0, 0.0)):
        plain = Settings()
        settings = replace(settings, end_position=None, end_yaw=plain.end_yaw, end_pitch=plain.end_pitch,
                           moment=plain.moment)
    imgui.set_item_tooltip("Remove the second keyframe: the camera stays at the first")
    return settings
