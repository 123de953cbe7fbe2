"""The command `lensbench analyse`: figures of a lens as a sheet, and their numbers."""

import argparse
import math
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import lensbench as lb
from lensbench.app.command.lens_options import LENS_HELP, add_lens_options, add_setting, option
from lensbench.app.command.options import add_picture_options, read_film, read_size, settings_from
from lensbench.app.command.output import UsageError, print_json, progress, save_json
from lensbench.app.drawing.sheet import write_figures
from lensbench.app.plots.aperture_plots import Stack
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.light_plots import Ripple, ripple_surface
from lensbench.app.plots.point_plots import FINEST
from lensbench.app.plots.query import query, read_fields, read_wavelengths, with_own
from lensbench.app.session.export import check_writable
from lensbench.app.session.states import carries_settings
from lensbench.app.settings.camera_facts import AUTO
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import read_distance
from lensbench.core.analysis.lens_defects import check_ripple_surface
from lensbench.core.imaging.spectrum import WHITES
from lensbench.core.text import significant

SHEETS = (".pdf", ".svg", ".png", ".csv", ".json")
POINTS = 64
MOST_LINES = 2000.0     # lp/mm
OF_FEW = {"frequencies": ("mtf", "mtf-map", "mtf-frequency"), "stack": ("stack",), "ripple": ("bokeh",),
          "coating": ("ghosts",)}         # analyses


def add_analyse_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench analyse`."""
    add = parser.add_argument
    add("lens", nargs="?", metavar="LENS", help=LENS_HELP)
    add("--what", metavar="NAMES", help="analyses, separated by commas (default: all); --what list names them")
    add("-o", "--output", metavar="FILE", help=f"the sheet ({', '.join(SHEETS[:3])}) or its numbers (.csv, .json)")
    add_lens_options(parser)
    add_setting(parser, next(field for field in fields(Settings) if field.name == "stop_image"))
    add("--focus", type=option(read_distance), metavar="DISTANCE",
        help="distance from the film to the plane in focus (default: infinity, or that of a picture with settings)")
    add("--film", type=option(read_film), metavar="FILM",
        help="width x height in mm, or the name of a format (default: the film that the lens was made for)")
    add("--size", type=option(read_size), metavar="WxH", help="pixels across and down, for the size of a pixel")
    add("--fields", type=option(read_fields), metavar="FIELDS",
        help="fields of spots, fans, wavefront and other plots of a few fields: parts of the largest (0,0.7,1), "
             "angles (0,14,20deg), image heights (0,10,21.6mm), or “design” for those that the lens file states")
    add("--wavelengths", type=option(read_wavelengths), metavar="NM",
        help="wavelengths in nm, the middle one primary, with weights if you like, such as 486.1,587.6:2,656.3 "
             "(default: --white)")
    add("--white", choices=WHITES,
        help="weights of the wavelengths in white light: by their luminance in a picture (picture, by default), "
             "photopic vision (photopic), as the lens file states them (lens), or F, d and C equally (fdc)")
    add("--frequencies", type=option(_read_frequencies), metavar="LP/MM",
        help="one to four frequencies of the analysis “mtf” (10,20,30,40); the first is that of “mtf-map” (30)")
    add("--points", type=int, default=POINTS, metavar="N", help=f"points across the pupil ({POINTS})")
    add("--stack", type=option(lambda text: _numbers(text, 1, 3)), metavar="MM[,INDEX[,ADAPTER]]",
        help="glass before the sensor of the analysis “stack”: thickness, index, and by how many mm an adapter is too "
             "long (2,1.52,0)")
    add("--ripple", type=option(_read_ripple), metavar="SURFACE,MM,NM",
        help="onion rings in the analysis “bokeh”: number of the surface from 0, or “asphere” for the largest asphere; "
             "distance from ring to ring, height of the ripple")
    add("--json", action="store_true", help="print the numbers as JSON")


def analyse(arguments: argparse.Namespace) -> int:
    """Compute the figures, print their conditions and remarks, and write the file if one is given."""
    if arguments.what == "list":
        print("\n".join(f"{name:14}{analysis.shows}" for name, analysis in ANALYSES.items()))
        return 0
    if arguments.lens is None:
        raise UsageError("which LENS? Name one of the library, or a file (see lensbench analyse --help)")
    names = list(ANALYSES) if arguments.what is None else [name.strip() for name in arguments.what.split(",")]
    unknown = [name for name in names if name not in ANALYSES]
    if unknown:
        raise UsageError(f"--what {unknown[0]!r}: choose from {', '.join(ANALYSES)}")
    if not 8 <= arguments.points <= 512:
        raise UsageError(f"--points {arguments.points}: choose 8 to 512 points across the pupil")
    path = None if arguments.output is None else Path(arguments.output)
    if path is not None:
        if path.suffix.lower() not in SHEETS:
            raise UsageError(f"{path}: a sheet is written as {', '.join(SHEETS)}: choose one of these suffixes")
        check_writable(path)
    settings = _settings(arguments)
    asked = query(replace(settings, white=arguments.white or settings.white))
    if asked.bench.reason:                              # an aperture or a focus that this lens does not reach
        raise UsageError(asked.bench.reason)
    asked = with_own(asked, arguments.fields, arguments.wavelengths)
    few = tuple(name for name, analysis in ANALYSES.items() if analysis.few)
    for word, chosen in {"fields": few, **OF_FEW}.items():
        unmoved = [name for name in names if name not in chosen]
        if getattr(arguments, word) is not None and unmoved and (word == "fields" or len(unmoved) == len(names)):
            print(f"--{word} has no effect on {', '.join(unmoved)}: it is that of {', '.join(chosen)}",
                  file=sys.stderr)
    figures, left_out = {}, {}
    with progress() as show:
        for i, name in enumerate(names):
            show(i / len(names))
            try:
                more = {key: value for key, value in _options(name, arguments, asked.lens).items() if value is not None}
                figures[name] = ANALYSES[name].figure(asked, arguments.points, **more)
            except lb.LensError as error:
                left_out[name] = str(error)
    if not figures:
        raise UsageError("no plot of this lens is possible: " + "; ".join(dict.fromkeys(left_out.values())))
    for name, why in left_out.items():
        print(f"Left out: {name}: {why}", file=sys.stderr)
    title = asked.lens.name or arguments.lens
    data = {"lens": title, "left_out": left_out,
            "analyses": {name: _plain(figure) for name, figure in figures.items()}}
    if path is not None:
        if path.suffix.lower() == ".json":
            save_json(path, data)
        else:
            write_figures(list(figures.values()), path, title)
    if arguments.json:
        print_json(data)
        return 0
    for figure in figures.values():
        print("\n  ".join((f"{figure.title}: {figure.conditions}", *figure.remarks)))
    if path is not None:
        print(f"{path}: written")
    return 0


def _options(name: str, arguments: argparse.Namespace, lens: Any) -> dict[str, Any]:
    """What the options of the command change of one analysis."""
    if name == "stack" and arguments.stack is not None:
        return {"stack": Stack(*arguments.stack)}
    if name == "bokeh" and arguments.ripple is not None:
        surface, period, height = arguments.ripple
        if surface is None:
            surface = ripple_surface(lens)
        try:
            check_ripple_surface(lens, surface)
        except lb.LensError as error:
            raise UsageError(f"--{error}") from None
        return {"ripple": Ripple(int(surface), period, 1e-6 * height)}
    if arguments.frequencies is not None:
        if name == "mtf":
            return {"frequencies": arguments.frequencies}
        if name == "mtf-map":
            return {"frequency": arguments.frequencies[0]}
        if name == "mtf-frequency":
            return {"finest": max(FINEST, *arguments.frequencies)}
    if name == "ghosts" and arguments.coating not in (None, AUTO):
        return {"coating": arguments.coating}
    return {}


def _read_frequencies(text: str) -> tuple[float, ...]:
    """Cycles a millimetre, rising."""
    values = _numbers(text, 1, 4)
    if not 0.0 < min(values) or max(values) > MOST_LINES:
        raise UsageError(f"{text!r}: give frequencies above 0 and up to {significant(MOST_LINES)} lp/mm")
    return values


def _read_ripple(text: str) -> tuple[float | None, float, float]:
    """Number of the surface, None for the largest asphere; period (mm) and height (nm)."""
    surface, comma, sizes = text.partition(",")
    if surface.strip() == "asphere" and comma:
        period, height = _numbers(sizes, 2, 2)
        return None, period, height
    chosen, period, height = _numbers(text, 3, 3)
    return chosen, period, height


def _numbers(text: str, fewest: int, most: int) -> tuple[float, ...]:
    parts = text.split(",")
    try:
        values = tuple(float(number) for number in parts)
    except ValueError:
        values = ()
    if not fewest <= len(values) <= most or not all(map(math.isfinite, values)):
        raise UsageError(f"{text!r}: give {fewest if fewest == most else f'{fewest} to {most}'} numbers, separated by "
                         "commas")
    return values


def _settings(arguments: argparse.Namespace) -> Any:
    """The settings of the lens in front of its film, as a picture of the same options has them."""
    pictures = argparse.ArgumentParser()
    pictures.add_argument("lens")
    add_picture_options(pictures)
    whole = pictures.parse_args([arguments.lens])       # the options of a picture, at their defaults
    vars(whole).update({name: value for name, value in vars(arguments).items()
                        if name in vars(whole) or name == "f_number"})
    if arguments.focus is None and not carries_settings(arguments.lens):
        whole.focus = math.inf
    return replace(settings_from(whole), lens_model="trace")


def _plain(figure: Any) -> dict[str, Any]:
    """A figure for JSON: its words, and its numbers as columns."""
    head, rows = figure.table.head, figure.table.rows
    return {"title": figure.title, "conditions": figure.conditions, "remarks": list(figure.remarks),
            "columns": {name: [value if isinstance(value, str) else float(value) for value in column]
                        for name, column in zip(head, zip(*rows, strict=True), strict=True)}}
