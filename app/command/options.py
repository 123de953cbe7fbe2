"""What people write on the command line, with its units, and the Settings that follow from it.

Each `read_…` takes a text and returns a number in the units of the core (mm,
radians, stops), or raises a ValueError that says what to type.
"""

import argparse
import math
import re
from collections.abc import Callable
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from lensbench.app.state.build import design
from lensbench.app.state.constraints import (
    constrained,
    ends_of_view,
    full_view,
    with_field_of_view,
    with_film,
    with_layout,
    with_model,
)
from lensbench.app.state.figures import colours
from lensbench.app.state.scales import read_angle, read_distance, read_exposure, read_f_number, read_length
from lensbench.app.state.sensor_scales import read_electrons, read_iso
from lensbench.app.state.settings import (
    BITS,
    DISPERSIONS,
    EXPOSURES,
    FOCUS_POSITIONS,
    FOV_AXES,
    LAYOUTS,
    MEDIUMS,
    METERINGS,
    MODELS,
    PROJECTIONS,
    READOUT_DIRECTIONS,
    TONES,
    VIEWS,
    Settings,
    SettingsError,
)
from lensbench.app.state.time_scales import read_light, read_time
from lensbench.app.state.zoom import asked_zoom, read_close, read_zoom
from lensbench.lens_models.polynomial import DEGREES

NAMED = (                       # options of their fields' names
    "focal_length", "degree", "fov_axis", "projection", "layout", "scene_width", "lens_radius", "hole_distance",
    "hole_diameter", "position", "yaw", "pitch", "end_position", "end_yaw", "end_pitch", "duration", "moment",
    "shutter", "shutter_ramp", "readout", "readout_direction", "medium", "visibility", "fog_light", "wet", "blades",
    "blade_rotation", "roundness", "exposing", "metering", "iso", "noise", "full_well", "quantum_efficiency",
    "read_noise", "dispersion", "focusing", "splats", "samples", "seed", "view", "exposure", "tone")
PICTURES = (".png", ".exr", ".ppm")      # that carry their settings


def read_size(text: str) -> tuple[int, int]:
    """“960x640” in pixels across and down."""
    match = re.fullmatch(r"\s*(\d{1,9})\s*[x×]\s*(\d{1,9})\s*", text.lower())
    if match is None:
        raise ValueError(f"“{text}”: type pixels across and down, such as 960x640")
    return int(match[1]), int(match[2])


def read_film(text: str) -> tuple[float, float]:
    """“36x24” in mm, or the beginning of a format's name, such as “aps-c”, “6x7” or “full frame”."""
    from lensbench import FORMATS

    plain = {_plain(name): size for name, size in FORMATS.items()}
    found = [size for name, size in plain.items() if _plain(text) and name.startswith(_plain(text))]
    if len(found) == 1:
        return found[0]
    match = re.fullmatch(r"\s*(\d+\.?\d*)\s*[x×]\s*(\d+\.?\d*)\s*(?:mm)?\s*", text.lower())
    if match is not None:
        return float(match[1]), float(match[2])
    near = get_close_matches(_plain(text), plain, n=3, cutoff=0.3)
    names = [name for name in FORMATS if not near or _plain(name) in near]
    raise ValueError(f"“{text}”: type a size in mm such as 36x24, or a format: {', '.join(names)}")


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", name.lower()).replace("×", "x")


def read_aperture(text: str) -> float | None:
    """“2.8”, “f/2.8”, or “open” for as wide as the lens goes (None)."""
    return None if text.strip().lower() in ("open", "wide", "wide open") else read_f_number(text)


def read_position(text: str) -> tuple[float, float, float]:
    """“0,0.2,-1.5m”: x, y, z in the world, metres where no unit is given."""
    parts = text.split(",")
    if len(parts) != 3:
        raise ValueError(f"“{text}”: type three distances with commas, such as 0,20cm,-1.5m")
    x, y, z = (read_distance(part) for part in parts)
    return x, y, z


def read_part(text: str) -> float:
    """“25%”, “0.25”."""
    match = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(%?)\s*", text)
    if match is None:
        raise ValueError(f"“{text}”: type a part such as 25%")
    return float(match[1]) / (100.0 if match[2] else 1.0)


def read_count(text: str) -> int:
    """A whole number of at least 1."""
    if not re.fullmatch(r"\s*\d{1,9}\s*", text) or int(text) < 1:
        raise ValueError(f"“{text}”: type a whole number of at least 1")
    return int(text)


def read_whole(text: str) -> int:
    """A whole number of at least 0."""
    if not re.fullmatch(r"\s*\d{1,9}\s*", text):
        raise ValueError(f"“{text}”: type a whole number of at least 0")
    return int(text)


def read_seed(text: str) -> int:
    """A whole number from 0 to 2³² − 1."""
    if not re.fullmatch(r"\s*\d{1,10}\s*", text) or int(text) >= 1 << 32:
        raise ValueError(f"“{text}”: type a whole number from 0 to {(1 << 32) - 1}")
    return int(text)


def option(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """A reader for argparse, whose message reaches the user."""
    def convert(text: str) -> Any:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return convert


def add_zoom_option(parser: argparse.ArgumentParser) -> None:
    """The option that turns the zoom."""
    parser.add_argument("--zoom", type=option(read_zoom), metavar="ZOOM",
                        help="of a zoom lens: from 0 (wide) to 1 (tele), or a focal length such as 105mm")


def add_close_option(parser: argparse.ArgumentParser) -> None:
    """The option that moves the focus groups themselves, for commands that know no focus distance."""
    parser.add_argument("--close", type=option(read_close), metavar="CLOSE",
                        help="of a lens that focuses by groups: from 0 (infinity) to 1 (their nearest position)")


def add_lens_options(parser: argparse.ArgumentParser) -> None:
    """The options that change the lens itself."""
    add_zoom_option(parser)
    parser.add_argument("--focal-length", type=option(read_length), metavar="LENGTH",
                        help="scale the whole prescription to this focal length (of a zoom its shortest), such as 35mm")
    parser.add_argument("--f-number", type=option(read_aperture), metavar="N", default=argparse.SUPPRESS,
                        help="aperture, such as 2.8 or f/2.8; “open” for as wide as the lens goes")


def add_picture_options(parser: argparse.ArgumentParser) -> None:
    """The options of `view` and `render`."""
    add_lens_options(parser)
    add = parser.add_argument
    add("--settings", metavar="FILE", help="begin with the settings of this TOML file or exported "
        "picture; other options change them")
    add("--focus", type=option(read_distance), metavar="DISTANCE",
        help="from the film to the object in focus: 1.2m, 120cm, inf; metres where no unit is given")
    add("--focusing", choices=FOCUS_POSITIONS, help="where the film stands for that behind a real lens: paraxially, "
        "at the least blur of all rays (real), or there only where it is half a pixel sharper (auto)")
    add("--scene", metavar="SCENE", help="a built-in scene, or a scene file (.toml)")
    add("--model", choices=MODELS, help="how the lens forms the picture: auto (the simplest that will do, by default), "
        + ", ".join(f"{key} ({name[0].lower() + name[1:]})" for key, name in MODELS.items() if key != "auto"))
    add("--degree", type=int, choices=DEGREES, help="of the polynomial model")
    add("--dispersion", choices=DISPERSIONS, help="colour errors of the lens: traced where its glasses are known "
        "(auto), on (an error where they are not), or off")
    add("--splats", action=argparse.BooleanOptionalAction, default=None,
        help="trace small lights from their own side, so that their blur is smooth at once (by default), or not")
    add("--film", type=option(read_film), metavar="FILM",
        help="width x height in mm, such as 36x24, or a format's name, such as aps-c")
    add("--size", type=option(read_size), metavar="WxH",
        help="pixels across and down; without --film, the film is cut to their shape")
    add("--fov", type=option(read_angle), metavar="ANGLE",
        help="field of view along the shorter side, such as 30deg: turns the zoom, crops the film, or sets the "
             "perspective or the fisheye camera")
    add("--fov-axis", choices=FOV_AXES, help="the side of the film along which a perspective or fisheye camera has it")
    add("--projection", choices=PROJECTIONS, help="of the ideal fisheye: what an angle from the axis is on the film")
    add("--layout", choices=LAYOUTS, help="of the panorama")
    add("--scene-width", type=option(read_distance), metavar="DISTANCE",
        help="of scene across the film of the orthographic camera, such as 1.5m")
    add("--lens-radius", type=option(read_length), metavar="LENGTH",
        help="of the orthographic camera: how wide its rays part, for a depth of field; 0 for parallel ones")
    add("--position", type=option(read_position), metavar="X,Y,Z",
        help="of the camera, such as 0,20cm,1m, or with = where it begins with a minus")
    add("--yaw", type=option(read_angle), metavar="ANGLE", help="turn the camera to the left")
    add("--pitch", type=option(read_angle), metavar="ANGLE", help="turn the camera up")
    add("--end-position", type=option(read_position), metavar="X,Y,Z",
        help="of a second keyframe: the camera moves there from --position in --duration")
    add("--end-yaw", type=option(read_angle), metavar="ANGLE", help="of the second keyframe")
    add("--end-pitch", type=option(read_angle), metavar="ANGLE", help="of the second keyframe")
    add("--duration", type=option(read_time), metavar="TIME", help="from the first keyframe to the second, such as 2s")
    add("--moment", type=option(read_time), metavar="TIME", help="when the shutter opens, after the first keyframe")
    add("--shutter", type=option(read_time), metavar="TIME", help="for how long it is open, such as 1/125 or 20ms")
    add("--shutter-ramp", type=option(read_part), metavar="PART",
        help="of the shutter time in which it opens, and in which it closes: 0 to 50%%")
    add("--readout", type=option(read_time), metavar="TIME",
        help="of a rolling shutter, from the first line of the picture to the last, such as 20ms")
    add("--readout-direction", choices=READOUT_DIRECTIONS, help="in which the lines of a rolling shutter open")
    add("--samples", type=option(read_count), metavar="N", help="samples a pixel, where the render stops")
    add("--seed", type=option(read_seed), metavar="N", help="of the noise")
    add("--view", choices=VIEWS, help="what is shown: the picture, or what its samples are")
    add("--hole-distance", type=option(read_length), metavar="LENGTH", help="of the pinhole: film distance, as 50mm")
    add("--hole-diameter", type=option(read_length), metavar="LENGTH",
        help="of the pinhole, such as 0.3mm; the sharpest by default")
    add("--medium", choices=MEDIUMS, help="what lies before the camera")
    add("--visibility", type=option(read_distance), metavar="DISTANCE", help="of fog or water, such as 10m")
    add("--fog-light", type=option(read_light), metavar="L", help="radiance that fog or water scatters into the view")
    add("--wet", action="store_true", default=None, help="the lens stands in the water itself, without a flat window")
    add("--blades", type=option(read_whole), metavar="N", help="of the stop's iris, 0 for a circle")
    add("--blade-rotation", type=option(read_angle), metavar="ANGLE", help="turn of these blades")
    add("--roundness", type=option(read_part), metavar="PART", help="of these blades: 0%% straight, 100%% a circle")
    add("--exposing", choices=EXPOSURES, help="what makes the picture bright: the light as it is (plain), f-number, "
        "shutter and ISO (triangle), or those with the ISO that a meter chooses (automatic)")
    add("--metering", choices=METERINGS, help="of the automatic exposure")
    add("--iso", type=option(read_iso), metavar="ISO", help="speed, such as 400")
    add("--noise", action="store_true", default=None, help="have a sensor record the picture, with its noise")
    add("--full-well", type=option(read_electrons), metavar="N", help="electrons that a pixel of it holds")
    add("--quantum-efficiency", type=option(read_part), metavar="PART", help="electrons a photon, such as 50%%")
    add("--read-noise", type=option(read_electrons), metavar="N", help="electrons rms")
    add("--sensor-bits", type=option(read_count), metavar="N", help="of the sensor's converter: " + ", ".join(
        str(bits) for bits in BITS))
    add("--exposure", type=option(read_exposure), metavar="STOPS", help="such as +1 or -0.5")
    add("--tone", choices=TONES, help="tone curve of the developed picture")


def settings_from(arguments: argparse.Namespace) -> Settings:
    """The Settings that the options describe, checked.

    They start from a file of settings, or from an exported picture where one is given in place of the lens, else
    from the bench's own; an aperture or a focus distance that nobody asked for gives
    way to what the lens can do. SettingsError, LensError, LensFileError, ExportError.
    """
    lens = arguments.lens
    if arguments.settings is not None:
        from lensbench.app.files.settings_file import load_settings
        settings = load_settings(arguments.settings)
        if lens is not None:
            settings = constrained(replace(settings, lens=_name_or_file(lens), focal_length=arguments.focal_length))
    elif lens is not None and Path(lens).suffix.lower() in PICTURES:
        from lensbench.app.files.export import read_settings
        settings = read_settings(lens)
    else:
        opened = with_model(replace(Settings(), focal_length=arguments.focal_length), arguments.model or "auto")
        settings = constrained(replace(opened, lens=_name_or_file(lens or opened.lens)).checked())
    asked = {name: getattr(arguments, option) for name, option in (
        ("model", "model"), ("focus_distance", "focus"), ("bits", "sensor_bits"), *((name, name) for name in NAMED))
        if getattr(arguments, option) is not None}
    if arguments.scene is not None:
        asked["scene"] = _name_or_file(arguments.scene)
    if "f_number" in arguments:
        asked["f_number"] = arguments.f_number
    model, layout = asked.pop("model", settings.model), settings.layout
    settings = with_model(replace(settings, **asked), model)
    if settings.layout != layout:
        settings = with_layout(settings, settings.layout)
    settings = _shaped(settings, arguments.film, arguments.size)
    framed = _framed(_zoomed(settings, arguments.zoom), arguments.fov, arguments.zoom is not None)
    if framed.zoom != settings.zoom:                # aperture and focus that nobody asked for give way
        framed = replace(constrained(framed), **{name: asked[name] for name in ("f_number", "focus_distance")
                                                  if name in asked})
    settings = framed
    if arguments.dispersion == "on" and not colours(settings).possible:
        raise SettingsError(f"dispersion on: {colours(settings).why}")
    if settings.model == "perspective" and arguments.focus is None:     # its focal length follows from film and view
        settings = constrained(settings)
    return settings.checked()


def _name_or_file(text: str) -> str:
    """A name as it is; a file by its whole path, so that an exported picture finds it again from anywhere."""
    path = Path(text)
    return str(path.resolve()) if path.suffix and path.is_file() else text


def _shaped(settings: Settings, film: tuple[float, float] | None, size: tuple[int, int] | None) -> Settings:
    """With the film and the pixels that are asked for; of one alone, the other takes its shape."""
    if size is not None:
        settings = replace(settings, pixels_x=size[0], pixels_y=size[1])
    if film is not None and size is None and min(film) > 0.0:
        return with_film(settings, *film)
    if settings.model == "environment":
        return settings
    if film is not None:
        return replace(settings, film_width=film[0], film_height=film[1])
    if size is not None and min(size) > 0:
        shape, width, height = size[0] / size[1], settings.film_width, settings.film_height
        return replace(settings, film_width=min(width, height * shape), film_height=min(height, width / shape))
    return settings


def _zoomed(settings: Settings, asked: tuple[str, float] | None) -> Settings:
    """With the zoom that is asked for."""
    if asked is None:
        return settings
    if settings.lensless:
        raise SettingsError(f"--zoom: the model {settings.model} has no lens to zoom: take another --model")
    return replace(settings, zoom=asked_zoom(design(replace(settings, zoom=0.0)), asked) or 0.0)


def _framed(settings: Settings, fov: float | None, keep_zoom: bool) -> Settings:
    """With the field of view that is asked for: by zoom or a crop of the film, or the perspective camera's own."""
    if fov is None:
        return settings
    if settings.model in ("orthographic", "environment"):
        raise SettingsError(f"--fov: {MODELS[settings.model].lower()} cameras have no field of view to be set"
                            + (": give --scene-width" if settings.model == "orthographic" else ""))
    whole = full_view(settings)[0] if keep_zoom else ends_of_view(settings)[1]
    if not settings.lensless and 0.0 < whole < fov:
        raise SettingsError(f"field of view {math.degrees(fov):.1f}°: this film behind this lens sees "
                            f"{math.degrees(whole):.1f}° along its shorter side: take a larger --film or a shorter "
                            "--focal-length")
    if settings.model == "fisheye":
        return with_field_of_view(settings, fov).checked()
    return with_field_of_view(replace(settings, fov=fov).checked(), fov, keep_zoom)
