"""The command `lensbench lightfield`: capture the light through each part of the pupil, and refocus it.

Its sub-commands `array | novel` take pictures with an array of pinholes and render novel views from these; `chart`
compares refocused light fields with focused cameras.
"""

import argparse
import math
import time
from dataclasses import replace
from time import perf_counter

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Look, Recording
from lensbench.app.command.lens_options import option
from lensbench.app.command.light_field_slices import add_view_options
from lensbench.app.command.options import (
    add_picture_options, prepare_capture, read_size, read_views, report_scene, settings_from
)
from lensbench.app.command.output import (
    UsageError, checked_chart_path, checked_picture_path, is_json, print_json, progress, save_json
)
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.session.export import save_picture
from lensbench.app.session.recordings import load_light_field, load_lumigraph, save_light_field, save_lumigraph
from lensbench.app.settings.settings import Settings, placed
from lensbench.app.settings.text_values import read_aperture, read_count, read_distance
from lensbench.app.studies.charts.methods import VIEWS, draw, measure
from lensbench.app.studies.timing import machine
from lensbench.app.workers.render_job import prepare
from lensbench.core.text import fixed, significant


def add_field_chart_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lightfield chart`."""
    parser.set_defaults(command=_chart)
    parser.add_argument("lens", nargs="?", metavar="LENS", help="a lens of the library, or a lens file")
    add_picture_options(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help=".svg or .png: the chart; .json: its numbers")
    parser.add_argument("--views", type=option(read_numbers), default=None, metavar="N,N…",
                        help="views across and down of each light field (3,5,9,17); each light field has the same "
                             "number of rays")
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON")


def read_numbers(text: str) -> tuple[int, ...]:
    """“3,5,9”: numbers of views across."""
    try:
        numbers = tuple(int(number) for number in text.split(","))
    except ValueError:
        numbers = ()
    if not numbers or not all(1 <= number <= 99 for number in numbers):
        raise ValueError(f"“{text}”: type whole numbers from 1 to 99 with commas, such as 3,5,9,17")
    return numbers


def _chart(arguments: argparse.Namespace) -> int:
    settings = settings_from(arguments)
    report_scene(settings.scene)
    path = checked_chart_path(arguments.output)
    with progress() as show:
        curves = measure(camera(settings), cached_scene(settings.scene), arguments.views or VIEWS, settings.seed, show)
    data = {"machine": machine(), "date": time.strftime("%Y-%m-%d"), "lens": settings.lens,
            "model": settings.lens_model, "scene": settings.scene, "focus mm": settings.focus_distance,
            "f-number": settings.f_number, "pixels": [settings.pixels_x, settings.pixels_y],
            "fields": [curve._asdict() for curve in curves]}
    if arguments.json:
        print_json(data)
    else:
        print("decibels against a camera focused at:")
        print("views   " + " ".join(f"{significant(distance / 1000.0, 3):>7} m" for distance in curves[0].distances))
        for curve in curves:
            ends = (f"a pixel apart at {significant(curve.near / 1000.0, 3)} m and "
                    f"{significant(curve.far / 1000.0, 3)} m")
            figures = " ".join(f"{fixed(value, 1):>9}" for value in curve.decibels)
            print(f"{curve.views:2} × {curve.views:2} {figures}  {ends}")
    if path is None:
        return 0
    if is_json(path):
        save_json(path, data)
        return 0
    title = (f"Light fields focused afterwards: {settings.scene}, recorded at "
             f"{significant(settings.focus_distance / 1000.0)} m")
    draw(curves, settings.focus_distance, title,
         f"{settings.lens}, {settings.lens_model} model, {settings.pixels_x} × {settings.pixels_y} pixels, as many "
         "rays for each field. Dashed: where neighbouring views lie a pixel apart; dotted beyond.", path)
    return 0


def add_lightfield_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lightfield`."""
    kinds = parser.add_subparsers(metavar="capture | refocus | view | array | novel | chart", required=True)
    capture = kinds.add_parser("capture", help="Record a light field through a lens.")
    capture.set_defaults(command=_capture)
    capture.add_argument("lens", nargs="?", metavar="LENS", help="a lens of the library, or a lens file")
    add_picture_options(capture)
    capture.add_argument("-o", "--output", required=True, metavar="FILE.npz")
    kinds_of_views = capture.add_mutually_exclusive_group()
    kinds_of_views.add_argument("--views", type=option(read_views), default=(9, 9), metavar="NxM",
                                help="views across and down the pupil (9x9); --samples counts for each pixel of each")
    kinds_of_views.add_argument("--microlenses", type=option(read_count), metavar="N",
                                help="capture with a plenoptic camera: --size counts microlenses, each with N x N "
                                     "pixels")
    capture.add_argument("--microlens-f-number", type=option(read_aperture), metavar="N",
                         help="focal length of the microlenses over their side (default: matches the lens)")
    capture.add_argument("--moments", type=option(read_count), default=1, metavar="N",
                         help="number of equal parts of the exposure that are stored separately (1)")
    refocus = kinds.add_parser("refocus", help="Refocus a light field: a picture at any focus distance.")
    refocus.set_defaults(command=_refocus)
    refocus.add_argument("field", metavar="FILE.npz", help="file written by `capture`")
    refocus.add_argument("-o", "--output", required=True, metavar="FILE", help=".png, .ppm, .exr or .pfm")
    refocus.add_argument("--focus", type=option(read_distance), metavar="DISTANCE",
                         help="distance from the film to the plane in focus (default: as recorded)")
    refocus.add_argument("--f-number", type=option(read_aperture), metavar="N",
                         help="f-number of the synthetic aperture (default: the recorded one)")
    refocus.add_argument("--view", type=option(read_place), default=(0.0, 0.0), metavar="U,V",
                         help="centre of that aperture in pupil radii, such as 0.5,0 or --view=-0.5,0")
    refocus.add_argument("--moment", type=option(read_count), metavar="K",
                         help="number of a stored moment, from 1 (default: the whole exposure)")
    add_view_options(kinds.add_parser("view", help="Contents of a light field: single views, depth, rays, epipolar "
                                                   "images."))
    add_lumigraph_options(kinds)
    add_field_chart_options(kinds.add_parser("chart", help="Compare refocused light fields with focused cameras."))


def read_place(text: str) -> tuple[float, float]:
    """“0.5,0”: a point of the pupil, in its radii."""
    parts = text.split(",")
    try:
        u, v = (float(number) for number in parts)
    except ValueError:
        raise ValueError(f"“{text}”: type two numbers with a comma, in radii of the pupil, such as 0.5,0") from None
    return u, v


def _capture(arguments: argparse.Namespace) -> int:
    if arguments.microlens_f_number is not None and not arguments.microlenses:
        raise UsageError("--microlens-f-number goes with --microlenses N")
    if arguments.moments > 1 and arguments.microlenses:
        raise UsageError("--moments N goes with --views: the sensor of a plenoptic camera adds up its exposure")
    settings, path = prepare_capture(arguments)
    begin = perf_counter()
    recording = _by_microlenses(arguments, settings) if arguments.microlenses else _by_lens(arguments, settings)
    save_light_field(path, recording)
    near, far = recording.clear_range
    print(f"{path}: {fixed(perf_counter() - begin, 1)} s; can be focused without gaps from "
          f"{_metres(near)} to {_metres(far)}")
    return 0


def _by_lens(arguments: argparse.Namespace, settings: Settings) -> Recording:
    camera, scene = prepare(settings)
    size = lb.recording_bytes(camera, arguments.views, moments=arguments.moments)
    print(f"{arguments.views[0]} × {arguments.views[1]} views of {settings.pixels_x} × {settings.pixels_y} pixels: "
          f"{fixed(size / 1e6, 0, grouped=True)} MB of memory")
    with progress() as show:
        return Recording(lb.capture_light_field(camera, scene, arguments.views, settings.samples, settings.seed,
                                                progress=show, moments=arguments.moments), settings)


def _by_microlenses(arguments: argparse.Namespace, settings: Settings) -> Recording:
    camera, scene = prepare(settings)
    plenoptic = lb.PlenopticCamera(camera, arguments.microlenses, arguments.microlens_f_number)
    across, down = plenoptic.sensor
    print(f"{settings.pixels_x} × {settings.pixels_y} microlenses of "
          f"f/{significant(plenoptic.microlens_f_number, 3)} (f/"
          f"{significant(plenoptic.matched_f_number, 3)} matches), {across} × {down} pixels: "
          f"{fixed(100.0 * plenoptic.used, 0)} % of "
          f"them used, {fixed(100.0 * plenoptic.spilled, 0)} % of the light spilled")
    with progress() as show:
        raw = plenoptic.expose(scene, settings.samples, settings.seed, progress=show)
    return Recording(raw.decoded(), settings, raw)


def _refocus(arguments: argparse.Namespace) -> int:
    path = checked_picture_path(arguments.output)
    recording = load_light_field(arguments.field)
    field, settings = recording.field, recording.settings
    focus = settings.focus_distance if arguments.focus is None else arguments.focus
    replace(settings, focus_distance=focus).checked()
    distance = max(focus, recording.nearest)
    if arguments.moment is not None:
        if arguments.moment > len(field.instants):
            raise UsageError(f"--moment {arguments.moment}: this light field holds {len(field.instants)}")
        field = field.instants[arguments.moment - 1]
    picture = field.refocus(recording.seen(distance), arguments.f_number, arguments.view)
    save_picture(path, picture, replace(settings, focus_distance=distance,
                                        f_number=arguments.f_number or settings.f_number))
    note = "" if distance == focus else f", the nearest distance instead of {significant(focus / 1000.0, 4)} m"
    near, far = recording.clear_range
    unknown = recording.unknown(Look("focus", distance, arguments.f_number, arguments.view))
    if unknown > 0.0:
        note += f"; {significant(100.0 * unknown, 2)} % of the picture lies beyond what all views recorded"
    if not near <= distance <= far:
        note += (f"; outside {_metres(near)} to {_metres(far)} neighbouring views differ by more than a "
                 "pixel: record more views")
    print(f"{path}: focused at {significant(distance / 1000.0, 4)} m{note}")
    return 0


def _metres(distance: float) -> str:
    """A distance (mm) in metres, or infinity."""
    return "infinity" if math.isinf(distance) else f"{significant(distance / 1000.0, 3)} m"


# An array of pinholes


def add_lumigraph_options(kinds) -> None:
    """Add the commands `array` and `novel` to `lensbench lightfield`."""
    array = kinds.add_parser("array", help="Record a lumigraph: pictures and depths from an array of pinholes.")
    array.set_defaults(command=_array)
    array.add_argument("lens", nargs="?", metavar="LENS", help="a lens of the library, or a lens file: the array "
                       "is centred on its entrance pupil")
    add_picture_options(array)
    array.add_argument("-o", "--output", required=True, metavar="FILE.npz")
    array.add_argument("--views", type=option(read_views), default=(9, 9), metavar="NxM",
                       help="pinholes across and down (9x9); --samples counts for each pixel of each of them")
    array.add_argument("--spacing", type=option(read_distance), default=5.0, metavar="DISTANCE",
                       help="distance between neighbouring pinholes (5mm)")
    array.add_argument("--plane", type=option(read_distance), metavar="DISTANCE",
                       help="distance from the pinholes to the plane of which all see the same part (default: the "
                            "focus distance of the camera)")
    novel = kinds.add_parser("novel", help="Render a novel view from a lumigraph: a camera between the pinholes or "
                                           "before them.")
    novel.set_defaults(command=_novel)
    novel.add_argument("lumigraph", metavar="FILE.npz", help="file written by `array`")
    novel.add_argument("-o", "--output", required=True, metavar="FILE", help=".png, .ppm, .exr or .pfm")
    novel.add_argument("--at", nargs=3, type=float, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "Z"),
                       help="position of the camera, mm from the centre of the array: right, up, back; Z = −20 is 20 "
                            "mm before it")
    novel.add_argument("--turn", nargs=2, type=float, default=(0.0, 0.0), metavar=("LEFT", "UP"),
                       help="direction of view, degrees from straight ahead")
    novel.add_argument("--flat", action="store_true", help="no depth correction: all objects on the plane")
    novel.add_argument("--surface", type=option(read_distance), metavar="DISTANCE",
                       help="all objects on a plane at this distance from the pinholes, instead of the recorded depths")
    novel.add_argument("--size", type=option(read_size), metavar="WxH",
                       help="pixels (default: half of the recorded ones, because a novel view is blurred by a part of "
                            "a recorded pixel)")


def _array(arguments: argparse.Namespace) -> int:
    settings, path = prepare_capture(arguments)
    across, down = arguments.views
    size = lb.light_field_bytes(settings.film, arguments.views)
    print(f"{across} × {down} pinholes of {settings.pixels_x} × {settings.pixels_y} pixels: "
          f"{fixed(size / 1e6, 0, grouped=True)} MB")
    begin = perf_counter()
    with progress() as show:
        made = lb.capture_lumigraph(camera(settings), cached_scene(settings.scene), arguments.views, arguments.spacing,
                                    arguments.plane, settings.samples, settings.seed, progress=show)
    save_lumigraph(path, made, settings)
    print(f"{path}: {fixed(perf_counter() - begin, 1)} s; the pinholes are {significant(made.spacing)} mm apart over "
          f"{significant(made.spacing * (across - 1))} × {significant(made.spacing * (down - 1))} mm, and share "
          f"a plane at {significant(made.distance / 1000.0, 4)} m")
    return 0


def _novel(arguments: argparse.Namespace) -> int:
    if arguments.flat and arguments.surface is not None:
        raise UsageError("--flat and --surface: choose one of them")
    for name in ("at", "turn"):
        if not all(map(math.isfinite, getattr(arguments, name))):
            raise UsageError(f"--{name} {' '.join(map(significant, getattr(arguments, name)))}: type finite numbers")
    path = checked_picture_path(arguments.output)
    made, settings = load_lumigraph(arguments.lumigraph)
    film = made.camera.film
    across, down = arguments.size or (max(film.pixels_x // 2, 1), max(film.pixels_y // 2, 1))
    pose = placed(arguments.at, *map(math.radians, arguments.turn))
    camera = replace(made.camera, film=replace(film, pixels_x=across, pixels_y=down),
                     world_from_camera=made.camera.placement() @ pose)
    surface = "recorded" if arguments.surface is None else arguments.surface
    view = made.seen_by(camera, None if arguments.flat else surface)
    save_picture(path, view.picture, replace(settings, pixels_x=across, pixels_y=down))
    share = float(view.covered.mean())
    note = "the whole view was recorded" if share == 1.0 else (
        f"{fixed(100.0 * share, 0)} % of the view was recorded, the rest is black: move nearer to the array's middle")
    print(f"{path}: {across} × {down} pixels; {note}")
    return 0
