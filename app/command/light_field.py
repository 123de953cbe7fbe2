"""The command `lensbench lightfield`: capture the light through each part of the pupil, and refocus it.

Of its sub-commands, `view` shows single views, depth, rays and epipolar images; `array | novel` take pictures with an
array of pinholes and render novel views from these; `chart` compares refocused light fields with focused cameras.
"""

import argparse
import json
import math
import time
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Look, Recording, epipolar, radiance, radiance_over_time, ray
from lensbench.app.bench.tone import depth_picture, ends, with_codes
from lensbench.app.command.lens_options import option, say
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


# Single views, depth, rays and epipolar images


EPIPOLAR_LINES = 8              # rows of an enlarged epipolar image for each view
CELL_PIXELS = 24                # side of a pupil cell in an enlarged picture
ENLARGED = (".png", ".ppm")     # formats to look at; the others hold the recorded numbers


def add_view_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lightfield view`."""
    parser.set_defaults(command=_view)
    parser.add_argument("field", metavar="FILE.npz", help="file written by `capture`")
    kinds = parser.add_mutually_exclusive_group(required=True)
    kinds.add_argument("--at", nargs=2, type=float, metavar=("U", "V"),
                       help="single view nearest to this point of the pupil, in pupil radii: right and up")
    kinds.add_argument("--depth", action="store_true",
                       help="estimated depth: as colours, or in metres for .exr and .pfm")
    kinds.add_argument("--all-in-focus", action="store_true", help="picture with each pixel in focus at its own depth")
    kinds.add_argument("--epipolar", type=int, metavar="ROW",
                       help="epipolar image: this row of the picture in each view of the middle row of the pupil, the "
                            "leftmost view below")
    kinds.add_argument("--pixel", nargs=2, type=int, metavar=("X", "Y"),
                       help="light of a pixel through each cell of the pupil; with --json also the points in mm where "
                            "its rays meet film and pupil")
    kinds.add_argument("--sensor", action="store_true",
                       help="raw picture of a plenoptic camera, and the match of its f-numbers")
    kinds.add_argument("--microlens", nargs=2, type=int, metavar=("X", "Y"),
                       help="picture behind one microlens of a plenoptic camera, counted across and down from 0 0")
    parser.add_argument("--nearest", type=option(read_distance), metavar="DISTANCE",
                        help="nearest depth for --depth and --all-in-focus, such as 0.5m")
    parser.add_argument("--farthest", type=option(read_distance), metavar="DISTANCE",
                        help="farthest depth for --depth and --all-in-focus (default: infinity)")
    parser.add_argument("-o", "--output", metavar="FILE", help=".png, .ppm, .exr or .pfm")
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON")


def _view(arguments: argparse.Namespace) -> int:
    if arguments.output is None and not arguments.json:
        raise UsageError("name a picture by -o FILE, or ask for the numbers with --json")
    path = None if arguments.output is None else checked_picture_path(arguments.output)
    large = path is not None and path.suffix.lower() in ENLARGED
    recording = load_light_field(arguments.field)
    if arguments.depth or arguments.all_in_focus:
        image, figures, settings = _of_depth(arguments, recording, path)
    else:
        for name in ("nearest", "farthest"):
            if getattr(arguments, name) is not None:
                say(f"--{name} has no effect: it is that of --depth and --all-in-focus")
        sensor = arguments.sensor or arguments.microlens is not None
        image, figures = (_of_sensor if sensor else _of_rays)(arguments, recording, large)
        settings = recording.settings
    if path is not None:
        save_picture(path, image, settings)
    if arguments.json:
        print(json.dumps(figures))
    else:
        print(f"{path}: " + ", ".join(f"{name.replace('_', ' ')} {_format(value)}" for name, value in figures.items()
                                      if np.ndim(value) < 2))
    return 0


def _format(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(_format(number) for number in value)
    return significant(value, 4) if isinstance(value, float) else f"{value}"


def _of_depth(arguments: argparse.Namespace, recording: Recording, path: Path | None):
    """Picture, figures and settings of the depth, or of the all-in-focus picture."""
    with progress() as show:
        depth = recording.find_depth(
            arguments.nearest, math.inf if arguments.farthest is None else arguments.farthest, show)
    sure = depth.confidence > 0.5
    far, near = (end / 1000.0 for end in ends(depth))
    near_by = sure & np.isfinite(depth.distance)
    parts = depth.error[near_by] / depth.distance[near_by]
    figures = {"nearest_m": near, "farthest_m": far if math.isfinite(far) else "inf",
               "sure_percent": 100.0 * float(sure.mean()), "median_confidence": float(np.median(depth.confidence)),
               "median_error_percent": 100.0 * float(np.median(parts)) if parts.size else math.nan}
    if arguments.all_in_focus:
        return depth.picture, figures, recording.settings
    return depth_picture(depth, path or Path("depth.exr")), figures, with_codes(recording.settings)


def _of_rays(arguments: argparse.Namespace, recording: Recording, large: bool):
    """Picture and figures of a view, an epipolar image or a pixel; large: enlarge the picture to look at."""
    field, (w, h) = recording.field, (recording.settings.pixels_x, recording.settings.pixels_y)
    across, down = field.views
    if arguments.at is not None:
        spot = np.array(arguments.at)
        if not np.isfinite(spot).all() or np.abs(spot).max() > field.reach:
            raise UsageError(f"--at {significant(spot[0])} {significant(spot[1])}: the recorded cells reach from "
                             f"{significant(-field.reach, 3)} to {significant(field.reach, 3)}, in radii of the pupil")
        j, i = (int(k) for k in np.unravel_index(np.argmin(((field.places - spot) ** 2).sum(-1)), (down, across)))
        covered = field.coverage[j, i].astype(float)
        return field.view(i, j), {
            "view": [i, j], "place": field.places[j, i].tolist(),
            "place_mm": (field.places[j, i] * recording.pupil_radius).tolist(),
            "mean_coverage": float(covered.mean()), "greatest_coverage": float(covered.max())}
    if arguments.epipolar is not None:
        if not 0 <= arguments.epipolar < h:
            raise UsageError(f"--epipolar {arguments.epipolar}: the lines of the views are 0 to {h - 1}")
        line = epipolar(recording, arguments.epipolar, down // 2)[::-1]
        return np.repeat(line, EPIPOLAR_LINES, 0) if large else line, {
            "line": arguments.epipolar, "pupil_row": down // 2, "places": field.places[down // 2, :, 0].tolist()}
    x, y = arguments.pixel
    if not (0 <= x < w and 0 <= y < h):
        raise UsageError(f"--pixel {x} {y}: the pixels of the views are 0 to {w - 1} across and 0 to {h - 1} down")
    radiances = radiance(recording, (x, y))
    rays = [[ray(recording, (x, y), (i, j)) for i in range(across)] for j in range(down)]
    shown = radiances[::-1].repeat(CELL_PIXELS, 0).repeat(CELL_PIXELS, 1) if large else radiances[::-1]
    return shown, {
        "pixel": [x, y], "mean_radiance": radiances.mean((0, 1)).tolist(),
        "coverage": field.coverage[:, :, y, x].astype(float).tolist(), "radiance": radiances.astype(float).tolist(),
        "radiance_over_time": radiance_over_time(recording, (x, y)).astype(float).tolist(),
        "film_mm": [[list(film) for film, _ in row] for row in rays],
        "pupil_mm": [[list(pupil) for _, pupil in row] for row in rays]}


def _of_sensor(arguments: argparse.Namespace, recording: Recording, large: bool):
    """Picture and figures of a plenoptic sensor, or of the pixels behind one of its microlenses."""
    raw, (w, h) = recording.raw, (recording.settings.pixels_x, recording.settings.pixels_y)
    if raw is None:
        raise UsageError("this light field was recorded without microlenses: capture one by --microlenses N")
    of = raw.camera
    figures = {"microlenses": [w, h], "pixels": of.pixels, "f_number": of.microlens_f_number,
               "main_f_number": of.main_f_number, "matched_f_number": of.matched_f_number, "fill": of.fill,
               "used_percent": 100.0 * of.used, "spilled_percent": 100.0 * of.spilled}
    if arguments.sensor:
        return raw.picture, figures
    x, y = arguments.microlens
    if not (0 <= x < w and 0 <= y < h):
        raise UsageError(f"--microlens {x} {y}: they are counted from 0 to {w - 1} across and 0 to {h - 1} down")
    behind = raw.behind(x, y)
    figures = {"microlens": [x, y], **figures, "radiance": behind.astype(float).tolist()}
    return behind.repeat(CELL_PIXELS, 0).repeat(CELL_PIXELS, 1) if large else behind, figures
