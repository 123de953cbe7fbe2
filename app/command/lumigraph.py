"""The commands `lensbench lightfield array | novel`: pictures from an array of pinholes, and novel views."""

import argparse
import math
from dataclasses import replace
from time import perf_counter

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.command.capture_options import prepare_capture, read_views
from lensbench.app.command.lens_options import option
from lensbench.app.command.options import add_picture_options, read_size
from lensbench.app.command.output import UsageError, checked_picture_path, progress
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.session.export import save_picture
from lensbench.app.session.recordings import load_lumigraph, save_lumigraph
from lensbench.app.settings.settings import placed
from lensbench.app.settings.text_values import read_distance
from lensbench.core.text import fixed, significant


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
