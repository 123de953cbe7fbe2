"""The command `lensbench lightfield view`: single views, depth, rays and epipolar images of a light field."""

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from lensbench.app.bench.false_colours import depth_picture, ends, with_codes
from lensbench.app.bench.light_field_query import Recording, epipolar, radiance, radiance_over_time, ray
from lensbench.app.command.lens_options import option, say
from lensbench.app.command.output import UsageError, checked_picture_path, progress
from lensbench.app.session.export import save_picture
from lensbench.app.session.recordings import load_light_field
from lensbench.app.settings.text_values import read_distance
from lensbench.core.text import significant

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
