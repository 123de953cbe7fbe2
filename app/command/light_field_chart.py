"""The command `lensbench lightfield chart`: comparison of refocused light fields with focused cameras."""

import argparse
import time

from lensbench.kernels.figures import fixed, significant


def add_field_chart_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lightfield chart`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.command.options import add_picture_options

    parser.set_defaults(command=_chart)
    parser.add_argument("lens", nargs="?", metavar="LENS", help="a lens of the library, or a lens file")
    add_picture_options(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help=".svg or .png: the chart; .json: its figures")
    parser.add_argument("--views", type=option(read_numbers), default=None, metavar="N,N…",
                        help="views across and down of each light field (3,5,9,17); each light field has the same "
                             "number of rays")
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


def read_numbers(text: str) -> tuple[int, ...]:
    """“3,5,9”: numbers of views across."""
    try:
        numbers = tuple(int(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if not numbers or not all(1 <= number <= 99 for number in numbers):
        raise ValueError(f"“{text}”: type whole numbers from 1 to 99 with commas, such as 3,5,9,17")
    return numbers


def _chart(arguments: argparse.Namespace) -> int:
    from lensbench.app.command.options import settings_from
    from lensbench.app.command.output import checked_chart_path, is_json, print_json, progress, save_json
    from lensbench.app.state.camera_kinds import camera
    from lensbench.app.state.scene_file import cached_scene
    from lensbench.app.studies.charts.light_fields import VIEWS, draw, measure
    from lensbench.app.studies.timing import machine

    settings = settings_from(arguments)
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
