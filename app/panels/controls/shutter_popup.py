"""Motion, a popup of the left column: the shutter, two keyframes of the camera with a scrub bar, a rolling shutter."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui
from imgui_bundle import icons_fontawesome_6 as fa

from lensbench.app.state import time_scales
from lensbench.app.state.settings import READOUT_DIRECTIONS, Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import ring
from lensbench.app.widgets.toggles import toggles

DEFAULT = Settings()
ARROWS = {"down": fa.ICON_FA_ARROW_DOWN, "up": fa.ICON_FA_ARROW_UP, "left": fa.ICON_FA_ARROW_LEFT,
          "right": fa.ICON_FA_ARROW_RIGHT}


def in_use(settings: Settings) -> bool:
    """Whether anything is set here that can be seen in the picture."""
    return settings.keyframed


def motion_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the settings as they have been set."""
    shutter = ring("Shutter", settings.shutter, time_scales.shutter_scale(DEFAULT.shutter),
                   "How long each line of the film is exposed, t: what moves meanwhile blurs")
    settings = replace(settings, shutter=shutter)
    settings = _keyframes(settings)
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))

    # The way in which the shutter opens and the film is read
    readout = ring("Read-out", settings.readout, time_scales.readout_scale(),
                   "Of a rolling shutter: from the first line of the picture to the last, in ms. 0: all at once")
    settings = replace(settings, readout=readout)
    direction = toggles("Lines", ARROWS, settings.readout_direction, {
        key: f"{name}: the order in which the lines of the upright picture are exposed"
        for key, name in READOUT_DIRECTIONS.items()})
    settings = replace(settings, readout_direction=direction)
    ramp = ring("Opening and closing", settings.shutter_ramp, time_scales.part_scale(),
                "What part of the shutter time it takes to open, and again to close. 0 %: at once")
    return replace(settings, shutter_ramp=ramp)


def _scrubbed(settings: Settings) -> Settings:
    """The scrub bar, and how long it is."""
    moment = ring("Time", settings.moment, time_scales.moment_scale(settings.duration),
                  "When the shutter opens, in s. At the ends of the bar stand the camera's two keyframes:\n"
                  "moving it in the picture changes the nearer one")
    settings = replace(settings, moment=moment)
    duration = ring("Duration", settings.duration, time_scales.duration_scale(),
                    "How long the bar is, in s: from the first keyframe to the second")
    if duration != settings.duration:
        settings = replace(settings, duration=duration, moment=settings.moment * duration / settings.duration)
    return settings


def _keyframes(settings: Settings) -> Settings:
    """The camera's two keyframes: set and cleared by a button, run through by the scrub bar."""
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))
    if settings.moves:
        settings = _scrubbed(settings)
    if settings.end_position is None:
        if imgui.button("Move the camera", ImVec2(-1.0, 0.0)):
            settings = replace(settings, end_position=settings.position, end_yaw=settings.yaw,
                               end_pitch=settings.pitch, moment=settings.duration)
        imgui.set_item_tooltip("Make the camera's place the first of two keyframes. The scrub bar then stands at the "
                               "second:\nmove the camera in the picture to where it shall end")
        return settings
    if imgui.button("Stand still", ImVec2(-1.0, 0.0)):
        plain = Settings()
        settings = replace(settings, end_position=None, end_yaw=plain.end_yaw, end_pitch=plain.end_pitch,
                           moment=plain.moment)
    imgui.set_item_tooltip("Forget the second keyframe: the camera stands at the first")
    return settings
