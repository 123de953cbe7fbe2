"""Options of a picture that were given and have no effect, with what to give instead."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from lensbench.app.bench.exposure import has_triangle
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
from lensbench.app.settings.setting_table import SHAPES
from lensbench.app.settings.settings import Settings


class _Need(NamedTuple):
    """When a setting has an effect, and what to do where it has none."""

    has_effect: Callable[[Settings], bool]
    instead: str = ""


def _of_lens(settings: Settings) -> bool:
    return settings.kind.has_lens


def _of_kinds_with(name: str) -> Callable[[Settings], bool]:
    return lambda settings: name in settings.kind.own


def _exposes(settings: Settings) -> bool:
    return settings.exposing == "triangle" and has_triangle(settings)


def _meters_iso(settings: Settings) -> bool:
    return settings.exposing == "automatic" and has_triangle(settings)


def _moves(settings: Settings) -> bool:
    return settings.keyframed or cached_scene(settings.scene).moves


_NO_F_NUMBER = "the exposure triangle needs an f-number, and it has none"
_METERED = {"iso": "--exposing automatic chooses the ISO",
            "shutter": "--exposing automatic makes up for the time; give --exposing triangle"}
_STOP = _Need(lambda settings: settings.has_stop)
_BLADES = _Need(lambda settings: _STOP.has_effect(settings) and not settings.stop_image,
                "leave out --stop-image, which takes the place of blades")
_SHAPE = _Need(lambda settings: _BLADES.has_effect(settings) and bool(settings.blades), "give --blades too")
_FOG = _Need(lambda settings: settings.medium != "air", "give --medium too")
_SENSOR = _Need(lambda settings: settings.noise, "give --noise too")
_MOTION = _Need(_moves, "nothing moves; give --end-position, or a scene that moves")
_END = _Need(lambda settings: settings.keyframed, "give --end-position too")
_NEEDS = {
    **{name: _Need(_of_kinds_with(name)) for kind in CAMERA_KINDS.values() for name in kind.own},
    "lens_radius": _Need(lambda settings: settings.kind.lens_radius, "the aperture of a lens is --f-number"),
    "f_number": _Need(lambda settings: settings.has_f_number),
    "focus_distance": _Need(lambda settings: settings.kind.focuses),
    "blades": _BLADES, "blade_rotation": _SHAPE, "roundness": _SHAPE, "stop_image": _STOP,
    "lens_model": _Need(_of_lens), "dispersion": _Need(_of_lens), "focal_length": _Need(_of_lens),
    "focus_position": _Need(lambda settings: settings.follows_lens),
    "ghost_strength": _Need(lambda settings: settings.ghosts, "give --ghosts too"),
    "ghost_pair": _Need(lambda settings: settings.ghosts, "give --ghosts too"),
    "star_strength": _Need(lambda settings: settings.stars, "give --stars too"),
    "tilt": _Need(_of_lens), "swing": _Need(_of_lens), "rise": _Need(_of_lens), "shift": _Need(_of_lens),
    "film_radius": _Need(_of_lens),
    "immersed": _Need(lambda settings: settings.kind.has_lens and settings.medium == "water", "give --medium water"),
    "degree": _Need(lambda settings: settings.kind.has_lens and LENS_MODELS[settings.lens_model].has_degree,
                    "give --lens-model polynomial"),
    "fov_axis": _Need(lambda settings: "fov_axis" in settings.kind.lists),
    "visibility": _FOG, "fog_light": _FOG, "end_yaw": _END, "end_pitch": _END,
}
# Of a picture that a command renders; a window or another program may take the exposure and movement that are set
_RENDERED = {
    "exposing": _Need(lambda settings: settings.exposing != "triangle" or has_triangle(settings), _NO_F_NUMBER),
    "iso": _Need(lambda settings: _exposes(settings) or settings.noise and not _meters_iso(settings),
                 "give --exposing triangle too"),
    "metering": _Need(lambda settings: settings.exposing == "automatic", "give --exposing automatic too"),
    "full_well": _SENSOR, "quantum_efficiency": _SENSOR, "read_noise": _SENSOR, "bits": _SENSOR,
    "shutter": _Need(lambda settings: (_exposes(settings) or settings.noise and _meters_iso(settings)
                                       or _moves(settings)),
                     "nothing moves; give --exposing triangle for its light"),
    "shutter_ramp": _MOTION, "readout": _MOTION, "readout_direction": _MOTION, "moment": _MOTION, "duration": _MOTION,
    "coating": _Need(lambda settings: settings.ghosts, "give --ghosts too"),
}
# Of a picture, and not of a quantity of its samples
_DEVELOPED = ("ghosts", "ghost_strength", "ghost_pair", "stars", "star_strength", "exposure", "exposing", "metering",
              "iso", "noise", "full_well", "quantum_efficiency", "read_noise", "bits", "tone")
# Of the developed picture alone, and not of a file of linear light: those of the sensor, and those that a render until
# some noise of the developed picture needs in any case
_RECORDED = ("noise", "full_well", "quantum_efficiency", "read_noise", "bits")
_TONED = ("exposure", "exposing", "metering", "iso", "tone")
LINEAR = (".exr", ".pfm")
# What an ideal lens model lacks, for the settings that need it
_WITH_LENS_MODEL = {**dict.fromkeys(("f_number", "blades", "blade_rotation", "roundness", "stop_image"), "has no stop"),
                    "focus_position": "has one focus"}


def remarks(settings: Settings, options_named: set[str], options: dict[str, str], lens: str | None,
            rendered: bool, linear: str | None = None, until_noise: bool = False) -> Iterator[str]:
    """A line for each option without an effect, and for an aperture that is none.

    given: settings that options name. options: the option of each. lens: the LENS that was named.
    rendered: the command renders a picture. linear: its file, where that holds linear light. until_noise: the noise
    of the developed picture ends the render.
    """
    if lens is not None and not settings.kind.has_lens:
        yield f"{lens} has no effect: the camera {settings.camera} has no lens; give --camera lens"
    coded = [name for name in _DEVELOPED if rendered and settings.sample_view and name in options_named
             and getattr(settings, name) is not False]
    for name in coded:
        yield f"--{options[name]} has no effect on the view {settings.view}: give --view picture"
    if linear is not None and not settings.sample_view:
        coded = [name for name in (_RECORDED if until_noise else _TONED + _RECORDED)
                 if name in options_named and getattr(settings, name) is not False]
        if "shutter" in options_named and not until_noise and not _moves(settings):
            coded.append("shutter")
        for name in coded:
            yield f"--{options[name]} has no effect on {linear}: it holds linear light as floats"
    for name, need in (_NEEDS | _RENDERED if rendered else _NEEDS).items():
        if name in coded:
            continue
        if name in options_named and not need.has_effect(settings):
            instead = need.instead
            if name in _METERED and settings.exposing != "plain":
                instead = _METERED[name] if _meters_iso(settings) else _NO_F_NUMBER
            if need is _SHAPE and settings.stop_image:
                instead = _BLADES.instead
            if settings.has_lens and name in _WITH_LENS_MODEL and not settings.follows_lens:
                instead = f"the lens model {settings.lens_model} " + _WITH_LENS_MODEL[name]
            yield f"--{options[name]} has no effect on the camera {settings.camera}" + (
                f": {instead}" if instead else "")
    if settings.kind.panorama:
        across, down = SHAPES[settings.layout]
        if settings.pixels_x * down != settings.pixels_y * across:
            yield (f"the layout {settings.layout} has the shape {across}:{down}: {settings.pixels_x}x"
                   f"{settings.pixels_y} stretches it; give --size {settings.pixels_y * across // down}x"
                   f"{settings.pixels_y}")
    if "f_number" in options_named and settings.f_number is None and settings.kind.ideal_lens:
        yield "--f-number open makes this camera a pinhole (an ideal lens has no maximum aperture): give a number"
