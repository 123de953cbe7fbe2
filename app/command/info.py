"""The commands `lensbench info LENS`, what is known of a lens, `check FILE…`, and the lists `lenses` and `scenes`.

`info` prints provenance, first-order data, glasses, estimates and the result of the check. `check` prints suspicious
values in lens files. Its exit status: 0 without warnings, 1 with warnings, 2 if a file holds no lens. Notes about
assumptions of the reader do not change the status. The import of this module loads no tracer.
"""

import argparse
import math
import sys
from dataclasses import asdict, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from lensbench.app.command.lens_options import add_close_option, add_lens_options
from lensbench.app.command.output import UsageError, print_json
from lensbench.core.text import escaped, excerpt, f_number_text, fixed, significant
from lensbench.lenses.library.catalogue import USES, Card, describe
from lensbench.lenses.library.search import FILMS, ORDERS, SearchError, filtered, searched

if TYPE_CHECKING:
    from lensbench.core.optics.prescription import Lens

PIXELS = 960                            # across a picture, for intrinsics: as the bench has it
WIDTH = 46              # of the labels
# Figures of `lensbench info` that follow from what is estimated, by a word of the estimates; and their labels
ESTIMATED = {"close position": ("nearest_focus",), "stop": ("f_number", "t_number"), "year": ("year",)}
LABELS = {"Nearest focus, from the film": "nearest_focus", "f-number": "f_number", "T-number": "t_number",
          "year": "year"}
CLEAN, FOUND, NO_LENS = 0, 1, 2


def add_info_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench info`."""
    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    add_lens_options(parser)
    add_close_option(parser)
    parser.add_argument("--json", action="store_true", help="print JSON: lengths in mm, angles in degrees")


def info(arguments: argparse.Namespace) -> int:
    """Print what is known of a lens, as text or JSON."""
    import lensbench as lb
    from lensbench.app.bench.build import coating, design, picture_wavelength, published
    from lensbench.app.bench.lens_choice import USUAL, own_film
    from lensbench.app.bench.zoom import positioned, station_lines, stations
    from lensbench.app.settings.camera_facts import AUTO
    from lensbench.app.settings.settings import Settings
    from lensbench.app.settings.text_values import format_distance
    from lensbench.lenses.tables.paraxial import is_d_line

    settings = replace(Settings(), lens=arguments.lens, focal_length=arguments.focal_length).checked()
    lens = published(settings)
    card, seen_at = lens_card(lens), picture_wavelength(settings, lens)
    lens = positioned(design(settings), arguments)
    if getattr(arguments, "f_number", None) is not None:
        lens = lb.stopped_down(lens, arguments.f_number)
    assumed = coating(replace(Settings(), coating=arguments.coating or AUTO), lens)
    film = own_film(settings.lens, lens) if settings.focal_length is None else USUAL
    data = {**_lens_data(lens, assumed.name, film), "picture_wavelength": seen_at, **card, "coating": assumed.name,
            "positions": stations(lens)}
    if arguments.json:
        print_json({"units": {"length": "mm", "angle": "degrees"}, **data})
        return 0
    far = "" if data["focus_distance"] is None else ", focused at infinity"
    rows = [(label, text(data[key]) if data[key] is not None else "not known") for key, label, text in (
        ("efl", "Effective focal length", _mm),
        *([("efl_across", "  across, in the section x–z", _mm)] if data["efl_across"] is not None else []),
        ("stated_efl", "  as published", lambda length: f"{significant(length)} mm"),
        ("f_number", "f-number", lambda number: f_number_text(number, 2) + far),
        *([("working_f_number", "Working f-number", lambda number: f"{f_number_text(number, 2)}, focused at "
            f"{format_distance(data['focus_distance'])}")] if data["working_f_number"] is not None else []),
        ("t_number", "T-number", lambda number: f"{f_number_text(number, 2, 'T/')}{far}, {assumed.name}: "
         f"{assumed.why}"),
        ("bfl", "Back focus", _mm),
        *([("bfl_across", "  across, in the section x–z", _mm)] if data["bfl_across"] is not None else []),
        ("ffl", "Front focus", _mm),
        ("front_principal", "Front principal plane, from the first vertex", _mm),
        ("rear_principal", "Rear principal plane, from the last vertex", _mm))]
    rows += [(label, f"{_mm(data[key]['z'])}, radius {_mm(data[key]['radius'])}") for key, label in (
        ("entrance_pupil", "Entrance pupil, from the first vertex"),
        ("exit_pupil", "Exit pupil, from the first vertex"))]
    view = data["field_of_view"]
    rows += [("Petzval radius", f"{fixed(data['petzval_radius'], 1)} mm"),
             ("Nearest focus, from the film", f"none: {data['no_focus']}" if data["nearest_focus"] is None
              else f"{fixed(data['nearest_focus'] / 1000.0, 3)} m"),
             ("Field of view, h × v, diagonal", f"none: {data['no_focus']}" if view is None else
              f"{_degrees(view['horizontal'])} × {_degrees(view['vertical'])}, {_degrees(view['diagonal'])} on "
              f"{significant(film[0])} × {significant(film[1])} mm{'' if film == lens.film_size else ' (assumed)'}")]
    if data["intrinsics"]:
        pixels = data["intrinsics"]
        rows.append((f"Intrinsics at {pixels['width']} × {pixels['height']} pixels of that film",
                     f"fx {fixed(pixels['fx'], 2)}, fy {fixed(pixels['fy'], 2)}, cx {fixed(pixels['cx'], 2)}, cy "
                     f"{fixed(pixels['cy'], 2)}, focused at infinity"))
    if not is_d_line(data["wavelength"]):
        rows.insert(0, ("Numbers at the primary wavelength", f"{significant(1000.0 * data['wavelength'])} nm"
                        + (", its pictures too" if seen_at is not None else "")))
    if data["out_of_line"]:
        which = ", ".join(map(str, data["out_of_line"]))
        rows.insert(0, ("Tilted or decentred", f"surfaces {which}; focal lengths, pupils and f-number are those of the "
                                               "centred lens"))
    year = f"{data['year']}{star(card, 'year')}" if data["year"] else ""
    print(escaped(", ".join(word for word in (data["name"] or arguments.lens, data["kind"], year) if word)))
    print("\n".join(map(escaped, [
        *card_lines(card, data["source"]),
        *(f"{label:{WIDTH}}{text}{star(card, label)}" for label, text in rows),
        *station_lines(data["positions"]), *glass_lines(card)])))
    print("".join(f"Found: {finding}\n" for finding in data["findings"]), end="")
    return 0


def _degrees(angle: float | None) -> str:
    """An angle in degrees to a tenth."""
    return "not known" if angle is None else f"{fixed(angle, 1)}°"


def _mm(length: float) -> str:
    """A length in mm to the micrometre."""
    return f"{fixed(length, 3)} mm"


def _lens_data(lens, coating: str, film_size: tuple[float, float]) -> dict[str, Any]:
    """What `lensbench info` prints, in mm and degrees. film_size: for field of view and intrinsics."""
    import lensbench as lb
    from lensbench.lenses.tables.paraxial import at_reference

    lens, wavelength = at_reference(lens)
    fo, at_infinity = lb.first_order(lens, wavelength), lens.at(close=0.0)      # an f-number counts at infinity
    nearest, no_focus = None, ""
    try:
        nearest = lb.nearest_focus(lens)
    except lb.FocusError as error:                      # the other figures stand
        no_focus = str(error)
    across = None if len(lens.sections) == 1 else lb.first_order(lens.section("x"), wavelength)
    squeeze = fo.efl / across.efl if across and math.isfinite(fo.efl) and math.isfinite(across.efl) else 1.0
    film = lb.Film(film_size[0] * abs(squeeze), film_size[1])   # as wide as what a lens with cylinders squeezes into it
    return {
        "name": lens.name, "kind": lens.kind, "year": lens.year, "source": lens.source,
        "stated_efl": lens.stated_efl, "stated_f_number": lens.stated_f_number,
        "surfaces": len(lens.surfaces), "stop_index": lens.stop_index, "length": lens.length,
        "wavelength": wavelength, "efl": fo.efl, "bfl": fo.bfl, "ffl": fo.ffl,
        "f_number": lb.first_order(at_infinity, wavelength).f_number, **_close_focus(lens),
        "efl_across": across and across.efl, "bfl_across": across and across.bfl,
        "t_number": lb.t_number(at_infinity, coating, wavelength),
        "transmission": lb.transmission(lens, wavelength, coating),
        "front_principal": fo.front_principal, "rear_principal": fo.rear_principal,
        "entrance_pupil": {"z": fo.entrance_pupil.z, "radius": fo.entrance_pupil.radius},
        "exit_pupil": {"z": fo.exit_pupil.z, "radius": fo.exit_pupil.radius},
        "petzval_radius": fo.petzval_radius, "stop_radius": fo.stop_radius,
        "nearest_focus": nearest, "no_focus": no_focus,
        "out_of_line": [i for i, surface in enumerate(lens.surfaces) if surface.pose is not None],
        "film": film_size,
        "field_of_view": None if nearest is None else _field_of_view(at_infinity, film, wavelength),
        "intrinsics": _intrinsics(lens, film),
        "findings": [str(finding) for finding in lens.findings],
    }


def _field_of_view(lens, film, wavelength: float) -> dict[str, float | None]:
    """Degrees across, down, diagonal at infinity: by rays, in the lit part; 2 atan(h / 2f) with cylinders; or None."""
    import lensbench as lb
    from lensbench.app.bench.readouts import traced_angles

    axes = ("horizontal", "vertical", "diagonal")
    if lens.is_rotationally_symmetric:
        angles = traced_angles(lens, film.width, film.height, wavelength, "paraxial")
        return {axis: None if angle is None else math.degrees(angle) for axis, angle in zip(axes, angles, strict=True)}
    efl = lens.front_index * abs(lb.first_order(lens, wavelength).efl)
    return {axis: math.degrees(lb.field_of_view(efl, film, axis)) for axis in axes}


def _close_focus(lens) -> dict[str, float | None]:
    """Plane in focus (mm from the film) and working f-number of focus groups off infinity; else None for both."""
    import lensbench as lb

    readings: dict[str, float | None] = {"focus_distance": None, "working_f_number": None}
    if not (lens.has_focus_groups and lens.positions.close):
        return readings
    at_infinity = lens.at(close=0.0)
    try:
        film_distance = (lb.film_distance(at_infinity, math.inf) + lens.surfaces[-1].thickness
                         - at_infinity.surfaces[-1].thickness)
        return {"focus_distance": lb.focused_distance(lens, film_distance),
                "working_f_number": lb.working_f_number(lens, film_distance)}
    except lb.LensError:
        return readings


def _intrinsics(lens, film) -> dict[str, float] | None:
    """Focal length and principal point in pixels, PIXELS across, at infinity; None without image or symmetry."""
    import lensbench as lb

    if not lens.is_rotationally_symmetric:
        return None
    film = replace(film, pixels_x=PIXELS, pixels_y=round(PIXELS * film.height / film.width))
    try:
        intrinsics = lb.LensCamera(lens, film).intrinsics
    except (lb.FocusError, lb.CameraError):
        return None
    return {"width": film.pixels_x, "height": film.pixels_y, **intrinsics._asdict()}


# The card of a lens


def lens_card(lens: "Lens") -> dict[str, Any]:
    """Provenance, counts, glasses and findings of a lens as read, for JSON; lengths in mm.

    lens: at any position, wide open: a lens that is stopped down contradicts its stated f-number. `glasses` has a row
    for each medium other than air, with the surface before it; `estimated` the keys of the values that follow from
    `estimates`; `system` the system data, `designed` the same in words; `check` the findings of `lenses.check`.
    """
    from lensbench import lenses
    from lensbench.lenses.tables.counts import counts
    from lensbench.lenses.tables.system_text import system_rows

    return {"maker": lens.maker, "designer": lens.designer, "patent": lens.patent, "film_size": lens.film_size,
            "notes": lens.notes, **asdict(counts(lens)), "estimates": lens.estimates,
            "system": asdict(lens.system), "designed": dict(system_rows(lens.system)),
            "estimated": [key for word, keys in ESTIMATED.items() if word in lens.estimates for key in keys],
            "glasses": [{"surface": i, "name": front.glass.name, "n_d": front.glass.n_d, "v_d": front.glass.v_d,
                         "thickness": front.thickness, "semi_diameter": max(front.semi_diameter, back.semi_diameter)}
                        for i, (front, back) in enumerate(pairwise(lens.surfaces)) if front.glass.n_d != 1.0],
            "check": [asdict(finding) for finding in lenses.check(lens)]}


def card_lines(card: dict[str, Any], source: str) -> list[str]:
    """Lines for people: provenance first, what is not known left out."""
    film = card["film_size"]
    rows = [("Maker", card["maker"]), ("Designer", card["designer"]), ("Patent", card["patent"]),
            ("Source", source if source != card["patent"] else ""),
            ("Made for", f"{significant(film[0])} × {significant(film[1])} mm" if film else ""),
            *card["designed"].items(), ("Elements", _elements(card)),
            ("Estimated (marked *)", card["estimates"]), ("Notes", card["notes"]), ("Check", _check(card["check"]))]
    return [f"{label:{WIDTH}}{text}" for label, text in rows if text]


def star(card: dict[str, Any], label: str) -> str:
    """A star behind a figure that follows from what is estimated, by its label; "" behind others."""
    return "*" if LABELS.get(label) in card["estimated"] else ""


def _elements(card: dict[str, Any]) -> str:
    def some(count: int, what: str) -> str:
        return f"{count} {what}{'' if count == 1 else 's'}"

    text = f"{card['elements']} in {some(card['groups'], 'group')}"
    more = [some(card[key], what) for key, what in (("aspheres", "asphere"), ("focus_groups", "focus group"))
            if card[key]]
    return ", ".join([text, *more])


def _check(findings: list[dict[str, Any]]) -> str:
    """The result of the check: the gravest finding, and the number of the others."""
    doubts = [finding for finding in findings if finding["severity"] == "warning"]
    if not findings:
        return "nothing found"
    first = (doubts or findings)[0]
    surface = "" if first["surface"] is None else f"surface {first['surface']}: "
    others = len(findings) - 1
    return f"{'' if doubts else 'no doubts; '}{surface}{first['message']}" + (
        f" (and {others} more: `lensbench check`)" if others else "")


def glass_lines(card: dict[str, Any]) -> list[str]:
    """A table of the glasses; the name of a glass is that of the source."""
    if not card["glasses"]:
        return []
    rows = [("Glass behind surface", "n_d", "V_d", "Thickness", "Diameter", "")]
    rows += [(str(glass["surface"]), fixed(glass["n_d"], 5), fixed(glass["v_d"], 2) if glass["v_d"] else "not known",
              fixed(glass["thickness"], 2), fixed(2.0 * glass["semi_diameter"], 1) + ("*" if "rims" in card["estimates"]
                                                                                       else ""),
              glass["name"]) for glass in card["glasses"]]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    return ["  ".join([text.rjust(width) for text, width in zip(row[:5], widths, strict=True)] + [row[5]]).rstrip()
            for row in rows]


# The check of lens files


def add_check_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench check`."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="a lens file, or a lens of the library")
    parser.add_argument("--json", action="store_true", help="print JSON: a list of files, each with its findings")


def check(arguments: argparse.Namespace) -> int:
    """Check every file, even after an error, and return the highest of their exit codes."""
    reports = [_report(name) for name in arguments.files]
    if arguments.json:
        print_json(reports)
    else:
        for report in reports:
            _print(report)
    return max(_code(report) for report in reports)


def _report(name: str) -> dict[str, Any]:
    """The findings of one file, or the reason why it holds no lens."""
    import lensbench as lb
    from lensbench import lenses

    try:
        lens = lenses.load(name)
    except (lenses.LensFileError, lb.LensError) as error:
        return {"file": name, "error": " ".join(str(error).split()), "findings": []}
    return {"file": name, "error": None, "findings": [asdict(finding) for finding in lenses.check(lens)]}


def _code(report: dict[str, Any]) -> int:
    if report["error"] is not None:
        return NO_LENS
    return FOUND if any(finding["severity"] == "warning" for finding in report["findings"]) else CLEAN


def _print(report: dict[str, Any]) -> None:
    """Print a line for the file, then causes, findings and notes, each with its kind, place and message."""
    if report["error"] is not None:
        print(f"lensbench: {report['error']}", file=sys.stderr)
        return
    findings = report["findings"]
    if not findings:
        print(f"{report['file']}: nothing found")
        return
    print(f"{report['file']}: {len(findings)} finding{'s' if len(findings) > 1 else ''}")
    width = max(len(finding["kind"]) for finding in findings)
    causes = [finding for finding in findings if finding["change"] is not None]
    for heading, group in (
            (f"Probable cause{'s, the most probable first' if len(causes) > 1 else ''}", causes),
            ("Findings", [f for f in findings if f["change"] is None and f["severity"] == "warning"]),
            ("Notes", [f for f in findings if f["change"] is None and f["severity"] == "note"])):
        if group and len(group) < len(findings):
            print(f" {heading}")
        for finding in group:
            surface = "" if finding["surface"] is None else f"surface {finding['surface']}"
            print(f"  {finding['kind']:{width}}  {surface:11}  {finding['message']}")
            if finding["proposal"]:
                print(f"  {'':{width}}  {'':11}  Proposal: {finding['proposal']}")


# The library, searched, filtered and sorted


def add_lenses_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lenses`."""
    add = parser.add_argument
    add("--search", default="", metavar="WORDS", help="title, kind, maker, designer, patent, year; the most relevant "
        "lens first")
    add("--kind", default="", metavar="KIND", help='such as macro, "double Gauss", zoom')
    add("--use", default="", metavar="USE", help=f"good for {', '.join(USES)}: rules on focal length and f-number")
    add("--maker", default="", metavar="MAKER", help="such as nikon")
    add("--faster", type=_number, metavar="N", help="f/N or faster")
    add("--focal", type=_range, metavar="MM", help="focal length, 85 or 85-135; zooms whose range meets it")
    add("--year", type=_range, metavar="YEARS", help="of the design: 1931, 1950-1970, -1930 or 1990-; leaves out "
        "lenses of unknown year")
    add("--format", default="", metavar="FILM", help=f"made for {', '.join(FILMS)}, or width x height in mm; "
        "leaves out lenses of unknown film")
    either = parser.add_mutually_exclusive_group()
    either.add_argument("--zoom", action="store_true", help="zoom lenses only")
    either.add_argument("--prime", action="store_true", help="lenses of one focal length only")
    add("--asphere", action="store_true", help="lenses with an aspheric surface only")
    add("--sort", choices=tuple(ORDERS), help="order; by default relevance with --search, else name")
    add("--json", action="store_true", help="print JSON: lengths in mm")


def _number(text: str) -> float:
    try:
        value = float(text.strip().lower().removeprefix("f/").removesuffix("mm"))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{excerpt(text)} is not a positive number")
    return value


def _range(text: str) -> tuple[float, float]:
    """Two ends from "85-135", "85", "-1930" or "1990-"."""
    low, dash, high = text.replace("–", "-").strip().removesuffix("mm").partition("-")
    if not low.strip() and not high.strip():
        raise argparse.ArgumentTypeError(f"{excerpt(text)} is not a range such as 85-135")
    ends = (_number(low) if low.strip() else 0.0, _number(high) if high.strip() else math.inf if dash else _number(low))
    if ends[0] > ends[1]:
        raise argparse.ArgumentTypeError(f"{excerpt(text)}: the first number must be the smaller one")
    return ends


def lenses(arguments: argparse.Namespace) -> int:
    """Print the lenses that pass all filters; what has no lens of its own is an error."""
    cards = describe()
    focal = arguments.focal
    if focal is not None and focal[0] == focal[1]:          # an engraved 50 mm may be 51.6 mm
        focal = (0.95 * focal[0], 1.05 * focal[1])
    try:
        matches = filtered(cards, kind=arguments.kind, maker=arguments.maker, fastest=arguments.faster, focal=focal,
                         years=arguments.year, zooms=True if arguments.zoom else False if arguments.prime else None,
                         aspheres=True if arguments.asphere else None, film=arguments.format, use=arguments.use)
    except SearchError as error:
        raise UsageError(str(error)) from None
    if arguments.search.strip():
        matches = searched(matches, arguments.search)
    if arguments.sort or not arguments.search.strip():
        matches = tuple(sorted(matches, key=ORDERS[arguments.sort or "name"]))
    if arguments.json:
        print_json([{**asdict(card), "zooms": card.zooms, "uses": card.uses} for card in matches])
    elif matches:
        _print_table(matches)
    else:
        print(f"No lens of the {len(cards)} passes all of these filters")
    return 0


def _print_table(cards: tuple[Card, ...]) -> None:
    table = [("Name", "EFL", "f/", "Year", "Kind", "Title")]
    table += [(card.name, _focal_lengths(card), significant(card.f_number, 3) if card.f_number else "",
               str(card.year or ""), card.kind, card.title) for card in cards]
    widths = [max(len(row[column]) for row in table) for column in range(5)]
    for row in table:
        numbers = "  ".join(text.rjust(width) for text, width in zip(row[1:4], widths[1:4], strict=True))
        print(f"{row[0]:{widths[0]}}  {numbers}  {row[4]:{widths[4]}}  {row[5]}")


def _focal_lengths(card: Card) -> str:
    return "–".join(fixed(length, 1) for length in (card.efl, card.tele_efl) if length)


def add_scenes_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench scenes`."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def scenes(arguments: argparse.Namespace) -> int:
    """List the built-in scenes, a line each; as JSON with the framings that `--framing` takes."""
    import lensbench as lb
    from lensbench.app.bench.framing import framings
    from lensbench.core.scenery.builtin.library import scene_summary

    rows = [{"name": name, "summary": scene_summary(name), "framings": list(framings(name))} for name in lb.SCENES]
    if arguments.json:
        print_json(rows)
        return 0
    for row in rows:
        print(f"{row['name']:<14}{row['summary']}")
    return 0
