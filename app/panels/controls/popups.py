"""Popups of the left column: colour, film, focus, medium, sensor, motion and stop."""

import math
from contextlib import suppress
from dataclasses import replace

from imgui_bundle import ImVec2, icons_fontawesome_6 as fa, imgui

from lensbench.app.bench.build import bench_of, design, focus_text
from lensbench.app.bench.focus_plane import sentence
from lensbench.app.bench.readouts import colours
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, one_of, small_note, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.settings import dial_scales
from lensbench.app.settings.setting_table import BITS, DISPERSIONS, FOCUS_POSITIONS, MEDIUMS, READOUT_DIRECTIONS
from lensbench.app.settings.settings import Settings
from lensbench.core.imaging.film import least_radius
from lensbench.core.text import significant, true_minus

DISPERSION_TIPS = {
    "auto": "With dispersion where there is data for the glasses, otherwise at the d line",
    "on": "With dispersion. A lens without dispersion data sets this back to automatic",
    "off": "Everything at the d line: no colour errors, and three times as fast",
}


def can_disperse(settings: Settings) -> bool:
    """Whether dispersion is possible: a real lens whose glasses are known."""
    try:
        return colours(settings).possible
    except (ValueError, OSError):
        return False


def dispersion_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    settings = replace(settings, dispersion=one_of("Dispersion", DISPERSIONS, DISPERSION_TIPS, settings.dispersion))
    small_note(colours(settings).why)
    return settings


def film_dials_in_use(settings: Settings) -> bool:
    """Whether the film is tilted, shifted or curved."""
    return not settings.film_pose.is_upright


def film_dials(settings: Settings) -> Settings:
    """Draw the dials, buttons that set them, and what is in focus; the changed settings."""
    most = float(significant(0.5 * max(settings.film_width, settings.film_height), 2))
    lean, move = dial_scales.lean_scale(), dial_scales.move_scale(most)
    settings = replace(
        settings,
        tilt=dial("Tilt", settings.tilt, lean, "The top of the film goes back, so that near ground comes into focus.\n"
                                               "A lens tilted down does the same"),
        swing=dial("Swing", settings.swing, lean, "The right side of the film, seen from behind, goes back,\n"
                                                  "so that what is near at the left comes into focus"),
        rise=dial("Rise", settings.rise, move, "The lens stands higher than the film: the picture shows what is "
                                               "higher,\nand upright lines stay parallel"),
        shift=dial("Shift", settings.shift, move, "The lens stands to the right of the film: the picture shows more of "
                                                  "the right"))
    settings = _curvature(settings)
    imgui.begin_disabled(not film_dials_in_use(settings))
    if imgui.button("Centre"):
        settings = settings.plain("tilt", "swing", "rise", "shift", "film_radius")
    imgui.set_item_tooltip("All four to 0, and a flat film")
    imgui.end_disabled()
    imgui.same_line()
    with suppress(ValueError, OSError):
        petzval = bench_of(settings).first_order.petzval_radius
        imgui.begin_disabled(not abs(petzval) > _least(settings))
        if imgui.button("Petzval"):
            settings = replace(settings, film_radius=petzval if math.isfinite(petzval) else None)
        imgui.set_item_tooltip("The film takes the Petzval curvature of the lens, on which it is sharp without "
                               "astigmatism:\n" + (f"radius {true_minus(significant(petzval, 3))} mm"
                                                   if math.isfinite(petzval) else "flat"))
        imgui.end_disabled()
    small_note(sentence(settings))
    return settings


def _least(settings: Settings) -> float:
    """The smallest radius (mm) to which this film can be curved."""
    return least_radius(settings.film.width, settings.film.height)


def _curvature(settings: Settings) -> Settings:
    """The dial of the film's curvature."""
    before = settings.film_pose.curvature
    scale = dial_scales.curvature_scale(_least(settings))
    after = dial("Curvature", before, scale, "Radius of a film that is curved as a sphere; with a minus its sides come "
                                             "nearer to the lens,\nas the sharp image of most lenses does")
    return settings if after == before else replace(settings, film_radius=1.0 / after if after else None)


FOCUS_TIPS = {
    "auto": "Automatic: the best contrast of lines of 30 lp/mm on the axis, in the colours of the picture and at the\n"
            "current aperture; the paraxial focus where that is as good",
    "real": "The position of least rms blur on the axis for all rays of the current aperture",
    "paraxial": "The limit of small stops, in closed form: the distance engraved on a lens",
}


def focus_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    if settings.follows_lens:
        settings = replace(settings, focus_position=one_of("Focus", FOCUS_POSITIONS, FOCUS_TIPS,
                                                           settings.focus_position))
        try:
            small_note(focus_text(bench_of(settings).focusing))
        except (ValueError, OSError) as error:
            small_note(str(error))
    try:
        design(settings)
    except (ValueError, OSError):               # a notice says why
        return settings
    return film_dials(settings)


CLEAREST_WATER = 65_000.0       # mm of visibility: in pure water a little more
MEDIUM_TIPS = {"air": "Clear air: light goes through it unchanged",
        "fog": "Fog: light is scattered out of the view and into it, by Beer and Lambert's law",
        "water": "Water: it also absorbs, red most of all, and refracts before the camera"}
FRONTS = {False: "Flat window", True: "Immersed"}
FRONT_TIPS = {False: "The camera looks through a flat window: angles are smaller in the water by its index",
              True: "The lens itself is in the water: its front surface bends light less than in air"}


def medium_in_use(settings: Settings) -> bool:
    """Whether the medium is other than clear air."""
    return settings.medium != "air"


def air_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    names = {key: name for key, name in MEDIUMS.items() if key != "water" or settings.kind.under_water}
    medium = toggles("Medium", names, settings.medium, MEDIUM_TIPS, 3.6)
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


def sensor_in_use(settings: Settings) -> bool:
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


DEFAULT = Settings()
ARROWS = {"down": fa.ICON_FA_ARROW_DOWN, "up": fa.ICON_FA_ARROW_UP, "left": fa.ICON_FA_ARROW_LEFT,
          "right": fa.ICON_FA_ARROW_RIGHT}


def shutter_in_use(settings: Settings) -> bool:
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
