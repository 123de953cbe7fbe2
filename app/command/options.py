"""The command-line options of a picture and of a capture, and the Settings that follow from them.

Most options are those of single settings: their names, values and help texts are in the fields of Settings.
"""

import argparse
import re
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from lensbench.app.bench.build import design, missing_ghost, stop_picture
from lensbench.app.bench.camera_kinds import MAKERS
from lensbench.app.bench.constraints import (
    beyond_view, constrained, full_view, with_camera, with_field_of_view, with_film, with_layout
)
from lensbench.app.bench.exposure import has_triangle
from lensbench.app.bench.framing import framed, framings, scene_exposure
from lensbench.app.bench.lens_choice import APERTURE, FILM, FOCUS, with_lens
from lensbench.app.bench.readouts import colours
from lensbench.app.bench.zoom import asked_zoom
from lensbench.app.command.lens_options import add_lens_options, add_setting, dest, option, say
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.bodies import Body, bodies_named
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS, LensSettings
from lensbench.app.settings.setting import SettingsError, spec
from lensbench.app.settings.setting_table import SHAPES
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_angle, read_angle
from lensbench.core.text import cut

MOST_VIEWS = 999


def read_size(text: str) -> tuple[int, int]:
    """“960x640” in pixels across and down."""
    match = re.fullmatch(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", text.lower())
    if match is None or not (int(match[1]) and int(match[2])):
        raise ValueError(f"“{cut(text)}”: type pixels across and down, at least 1 each, such as 960x640")
    return int(match[1]), int(match[2])


def read_film(text: str) -> "tuple[float, float] | Body":
    """“36x24” in mm, the beginning of a format's name, such as “aps-c” or “6x7”, or a camera, such as “Sony A7 IV”."""
    from lensbench import FORMATS

    plain = {_plain(name): size for name, size in FORMATS.items()}
    sizes = [size for name, size in plain.items() if _plain(text) and name.startswith(_plain(text))]
    if len(sizes) == 1:
        return sizes[0]
    match = re.fullmatch(r"\s*(\d+\.?\d*)\s*[x×]\s*(\d+\.?\d*)\s*(?:mm)?\s*", text.lower())
    if match is not None:
        return float(match[1]), float(match[2])
    bodies = bodies_named(text) if text.strip() else ()
    if len(bodies) == 1:
        return bodies[0]
    near = get_close_matches(_plain(text), plain, n=3, cutoff=0.3)
    names = [body.name for body in bodies[:6]] or [name for name in FORMATS if not near or _plain(name) in near]
    raise ValueError(f"“{cut(text)}”: type a size in mm such as 36x24, a camera such as “Sony A7 IV”, or a format: "
                     f"{', '.join(names)}")


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", name.lower()).replace("×", "x")


def add_picture_options(parser: argparse.ArgumentParser) -> None:
    """The options of every command that renders a picture."""
    add_lens_options(parser)
    add = parser.add_argument
    add("--settings", metavar="FILE", help="begin with the settings of this TOML file or exported picture; other "
        "options change them")
    add("--scene", metavar="SCENE", help="a built-in scene, or a scene file (.toml)")
    add("--film", type=option(read_film), metavar="FILM",
        help="width x height in mm, such as 36x24, a format's name, such as aps-c, or a camera's, such as “Sony "
             "A7 IV”; by default the film that the lens was made for, and 36x24 with --focal-length")
    add("--size", type=option(read_size), metavar="WxH",
        help="pixels across and down; without --film, the film is cut to their shape")
    add("--fov", type=option(read_angle), metavar="ANGLE",
        help="field of view along the shorter side, such as 30deg, of a lens without its distortion: zooms the lens, "
             "crops the film, or sets the view of a camera without a lens")
    add("--focus-on", metavar="NAME", help="focus on a thing of the scene: its subject, a framing, an object with a "
        "name, or one by kind and number such as “sphere 2”")
    of_lens = fields(LensSettings)
    for field in fields(Settings):
        if spec(field).help and field not in of_lens:
            add_setting(parser, field)


def settings_from(arguments: argparse.Namespace) -> Settings:
    """The Settings that the options describe, checked.

    They start from a settings file, or from an exported picture given instead of the lens, else from the lens at its
    best (see `lens_choice`), of which the options lock what they name; an aperture or a focus distance that they do
    not name is limited to the range of the lens. SettingsError,
    LensError, LensFileError, ExportError.
    """
    from lensbench.app.session.states import carries_settings, load_settings, read_state

    lens, locked, is_placed = arguments.lens, _locked(arguments), arguments.framing is not None
    camera = arguments.camera or ("lens" if arguments.lens_model is not None else None)
    if arguments.settings is not None:
        settings = load_settings(arguments.settings)
        if lens is not None:
            settings = constrained(replace(settings, lens=_name_or_file(lens), edited="",
                                           focal_length=arguments.focal_length))
    elif lens is not None and carries_settings(lens):
        settings = read_state(lens)
    else:
        opened = with_camera(replace(Settings(), focal_length=arguments.focal_length,
                                     lens_model=arguments.lens_model or Settings.lens_model,
                                     medium=arguments.medium or Settings.medium,        # which the framing depends on
                                     immersed=bool(arguments.immersed)), camera or "lens")
        scene = _name_or_file(arguments.scene or opened.scene)
        opened = replace(opened, scene=scene, framing=arguments.framing or opened.framing,
                         exposure=scene_exposure(scene) if arguments.exposing in (None, "plain") else 0.0).checked()
        if lens is not None and opened.has_lens and arguments.focal_length is None:
            own = design(replace(opened, lens=_name_or_file(lens), zoom=0.0))
            zoom = asked_zoom(own, arguments.zoom) or 0.0
            settings = with_lens(opened, _name_or_file(lens), locked, zoom)
            is_placed = is_placed or bool(arguments.film or arguments.fov)
        else:
            settings = constrained(replace(opened, lens=_name_or_file(lens or opened.lens)))
            if arguments.scene is not None and arguments.focal_length is None:
                settings = constrained(framed(settings, locked))
    asked = {field.name: getattr(arguments, dest(field)) for field in fields(Settings)
             if spec(field).help and getattr(arguments, dest(field)) is not None}
    if arguments.scene is not None:
        asked["scene"] = _name_or_file(arguments.scene)
    if asked.get("stop_image"):
        asked["stop_image"] = str(Path(asked["stop_image"]).resolve())
        stop_picture(asked["stop_image"])               # raises if it cannot be read
    if "f_number" in arguments:
        asked["f_number"] = arguments.f_number
    asked.pop("camera", None)
    layout = settings.layout
    settings = with_camera(replace(settings, **asked), camera or settings.camera)
    if settings.layout != layout:
        settings = with_layout(settings, settings.layout)
    settings = _shaped(settings, arguments.film and arguments.film[:2], arguments.size)
    if isinstance(arguments.film, Body):
        settings = replace(settings, body=arguments.film.name)
    viewed = _viewed(_zoomed(settings, arguments.zoom), arguments.fov, arguments.zoom is not None)
    if viewed.zoom != settings.zoom:                # limit what no option names
        limited = ("f_number", "focus_distance", "film_radius")
        viewed = replace(constrained(viewed), **{name: asked[name] for name in limited if name in asked})
    if arguments.framing is not None and arguments.framing not in (offered := framings(viewed.scene)):
        raise SettingsError(f"--framing {arguments.framing}: this scene has {', '.join(offered)}")
    if arguments.framing is not None and FOCUS in locked:
        raise SettingsError("--framing moves the camera and its focus: leave out --focus, --position and its angles")
    settings = framed(viewed.checked(), locked) if is_placed else viewed
    if arguments.dispersion == "on" and not colours(settings).possible:
        raise SettingsError(f"dispersion on: {colours(settings).why}")
    if not settings.has_lens and arguments.focus is None:  # its nearest focus follows from film and view
        settings = constrained(settings.checked())
    settings = settings.checked()                       # errors come alone, before remarks
    if not settings.has_lens:
        MAKERS[settings.camera].camera(settings)
    if arguments.ghost_pair and (why := missing_ghost(settings)):
        raise SettingsError(f"--ghost-pair {arguments.ghost_pair}: {why}")
    if arguments.focus_on is not None:
        from lensbench.app.plots.named_focus import focused_on

        if arguments.focus is not None:
            raise SettingsError("--focus-on and --focus: give one of them")
        settings, remark = focused_on(settings, arguments.focus_on)
        if remark:
            say(remark)
    named = {field.name: spec(field).option or field.name.replace("_", "-") for field in fields(Settings)}
    unnamed = arguments.settings is not None or lens is None or carries_settings(lens)
    rendered = "until_noise" in arguments
    linear = arguments.output if rendered and Path(arguments.output).suffix.lower() in LINEAR else None
    for remark in remarks(settings, set(asked) | ({"camera"} if arguments.camera else set()), named,
                          None if unnamed else lens, rendered, linear,
                          rendered and arguments.until_noise is not None):
        say(remark)
    return settings


def _locked(arguments: argparse.Namespace) -> set[str]:
    """What the options name, so that the lens at its best leaves it."""
    placing = ("focus", "position", "yaw", "pitch", "end_position")
    named = {FILM: arguments.film is not None, APERTURE: "f_number" in arguments,
             FOCUS: any(getattr(arguments, name) is not None for name in placing)}
    return {name for name, is_given in named.items() if is_given}


def _name_or_file(text: str) -> str:
    """A name unchanged; a file by its absolute path, so that an exported picture finds it again from anywhere."""
    path = Path(text)
    return str(path.resolve()) if path.suffix and path.is_file() else text


def _shaped(settings: Settings, film: tuple[float, float] | None, size: tuple[int, int] | None) -> Settings:
    """The settings with the film and the pixels of the options; one that is missing takes the shape of the other."""
    if size is not None:
        settings = replace(settings, pixels_x=size[0], pixels_y=size[1])
    if film is not None and size is None and min(film) > 0.0:
        return with_film(settings, *film)
    if settings.kind.panorama:
        return settings
    if film is not None:
        return replace(settings, film_width=film[0], film_height=film[1])
    if size is not None:
        shape, width, height = size[0] / size[1], settings.film_width, settings.film_height
        return replace(settings, film_width=min(width, height * shape), film_height=min(height, width / shape))
    return settings


def _zoomed(settings: Settings, asked: tuple[str, float] | None) -> Settings:
    """The settings with the zoom of the option."""
    if asked is None:
        return settings
    if not settings.has_lens:
        raise SettingsError(f"--zoom: the camera {settings.camera} has no lens to zoom: choose another --camera")
    return replace(settings, zoom=asked_zoom(design(replace(settings, zoom=0.0)), asked) or 0.0)


def _viewed(settings: Settings, fov: float | None, keep_zoom: bool) -> Settings:
    """The settings with the field of view of the option: by zoom, by a crop of the film, or the camera's own."""
    if fov is None:
        return settings
    if not settings.has_lens:
        if not settings.kind.has_view:
            instead = settings.kind.without_view
            raise SettingsError(f"--fov: the camera {settings.camera} has no field of view to be set"
                                + (f": {instead}" if instead else ""))
        return with_field_of_view(settings, fov).checked()
    settings = replace(settings, fov=fov).checked()
    problem = beyond_view(settings, fov, keep_zoom)
    if problem:
        instead = ("a larger --film or a shorter --focal-length" if fov > full_view(settings)[0] else
                   "a smaller --film or a longer --focal-length")
        raise SettingsError(f"field of view {format_angle(fov)}: {problem}: take {instead}")
    return with_field_of_view(settings, fov, keep_zoom)


# Light fields


def read_views(text: str) -> tuple[int, int]:
    """Views across and down, from a text such as “9x9”; ValueError for other texts."""
    match = re.fullmatch(r"\s*(\d{1,3})\s*[x×]\s*(\d{1,3})\s*", text.lower())
    if match is None or not (int(match[1]) and int(match[2])):
        raise ValueError(f"“{text}”: type views across and down, 1 to {MOST_VIEWS}, such as 9x9")
    return int(match[1]), int(match[2])


def prepare_capture(arguments: argparse.Namespace) -> tuple[Settings, Path]:
    """Settings of a capture, without what it does not record, which is named; and its file, which can be written."""
    from lensbench.app.session.export import check_writable
    from lensbench.app.session.recordings import checked_suffix

    settings = settings_from(arguments)
    report_scene(settings.scene)
    if arguments.samples is None and arguments.settings is None:
        settings = replace(settings, samples=16)
    path = checked_suffix(arguments.output)
    check_writable(path)
    added = " and ".join(name for name in ("ghosts", "stars") if getattr(settings, name))
    if added:
        say(f"{added} are left out: a light field records direct light alone")
    if settings.sample_view:
        say(f"the view {settings.view} is left out: a light field records light")
    return replace(settings, ghosts=False, stars=False, view="picture"), path


def report_scene(name_or_path: str) -> None:
    """Print what the reader of a scene file changed or assumed."""
    for note in cached_scene(name_or_path).notes:
        say(f"{name_or_path}: {note}")


# Options that were given and have no effect, with what to give instead


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
