"""The command `lensbench lenses`: the library, searched, filtered and sorted. Imports no tracer."""

import argparse
import math
from dataclasses import asdict

from lensbench.app.command.output import UsageError, print_json
from lensbench.core.text import excerpt, fixed, significant
from lensbench.lenses.library.catalogue import Card, describe
from lensbench.lenses.library.search import FILMS, ORDERS, SearchError, filtered, searched


def add_lenses_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench lenses`."""
    add = parser.add_argument
    add("--search", default="", metavar="WORDS", help="title, kind, maker, designer, patent, year; the most relevant "
        "lens first")
    add("--kind", default="", metavar="KIND", help='such as macro, "double Gauss", zoom')
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
                         aspheres=True if arguments.asphere else None, film=arguments.format)
    except SearchError as error:
        raise UsageError(str(error)) from None
    if arguments.search.strip():
        matches = searched(matches, arguments.search)
    if arguments.sort or not arguments.search.strip():
        matches = tuple(sorted(matches, key=ORDERS[arguments.sort or "name"]))
    if arguments.json:
        print_json([{**asdict(card), "zooms": card.zooms} for card in matches])
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
