"""The command `lensbench tolerances LENS`: what each error of manufacture costs, and the spread of a production run."""

import argparse
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lensbench.app.command.errors import UsageError
from lensbench.app.command.output import checked_chart_path
from lensbench.kernels.figures import significant

if TYPE_CHECKING:
    from lensbench.analysis.manufacture import Production, Sensitivity

SHOWN = 12                      # of the costliest errors
CHARTED = 12                    # frequencies of a chart


class _Error(NamedTuple):
    """The option of one kind of error; unit: the value of `Tolerances` that 1 is."""

    default: float
    metavar: str
    unit: float
    what: str


ERRORS = {
    "radius": _Error(0.1, "PERCENT", 0.01, "of every radius of curvature"),
    "thickness": _Error(0.02, "MM", 1.0, "of every thickness and gap"),
    "index": _Error(0.0005, "N", 1.0, "of every glass"),
    "decentre": _Error(0.01, "MM", 1.0, "of every element, across the axis"),
    "tilt": _Error(1.0, "ARCMIN", math.radians(1.0 / 60.0), "of every element, about its front vertex"),
}


def add_tolerance_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench tolerances`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.state.text_values import read_extent

    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    parser.add_argument("--f-number", type=float, metavar="N", help="stop down to this f-number; wide open by default")
    parser.add_argument("--image-height", type=option(read_extent), metavar="MM",
                        help="largest image height; by default to the corner of the lens's film, or its light's edge")
    for name, each in ERRORS.items():
        parser.add_argument(f"--{name}", type=float, default=each.default, metavar=each.metavar,
                            help=f"tolerance {each.what}; {significant(each.default)} by default, 0 for none")
    parser.add_argument("--copies", type=int, default=1000, metavar="N", help="of the Monte Carlo run; 1000 by default")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of its random numbers")
    parser.add_argument("-o", "--output", metavar="FILE", help="chart of the contrast of the copies: .svg or .png")
    parser.add_argument("--json", action="store_true", help="print JSON: all errors, and the percentiles")


def tolerances(arguments: argparse.Namespace) -> int:
    """Print the costliest errors of a lens and the contrast of its copies; draw a chart of it."""
    import lensbench as lb
    from lensbench import lenses

    if arguments.seed < 0:
        raise UsageError(f"--seed {arguments.seed}: it must be a whole number from 0")
    path = checked_chart_path(arguments.output, figures=False)
    within = lb.analysis.Tolerances(**{name: _tolerance(name, getattr(arguments, name)) for name in ERRORS})
    lens = lenses.load(arguments.lens)
    if arguments.f_number is not None:
        lens = lb.stopped_down(lens, arguments.f_number)
    film = None
    if arguments.image_height is not None:
        if not arguments.image_height > 0.0:
            raise UsageError("--image-height 0: it must be more than 0")
        side = math.sqrt(2.0) * arguments.image_height
        film = lb.Film(side, side, 1, 1)
    costs = lb.analysis.sensitivities(lens, film, within, wavelengths="picture")
    run = lb.analysis.production(lens, film, within, arguments.copies, arguments.seed, wavelengths="picture")
    if arguments.json:
        print(json.dumps(_plain(costs, run), indent=2))
    else:
        _print(costs, run)
    if path is not None:
        top = float(run.frequencies[-1])
        run = lb.analysis.production(lens, film, within, arguments.copies, arguments.seed,
                                     [top * (k + 1) / CHARTED for k in range(CHARTED)])
        draw(run, path, lens.name)
        print(f"wrote {path}", file=sys.stderr)
    return 0


def _tolerance(name: str, value: float) -> float:
    """A tolerance as `Tolerances` takes it; UsageError, in the unit of the option, for one out of range."""
    from lensbench.analysis.manufacture import LARGEST

    unit, metavar = ERRORS[name].unit, ERRORS[name].metavar
    if not 0.0 <= value * unit < LARGEST:
        raise UsageError(f"--{name} {significant(value)}: the tolerance of {name} must be from 0 to less than "
                         f"{significant(LARGEST / unit, 4)} {metavar}")
    return value * unit


def _plain(costs: "tuple[Sensitivity, ...]", run: "Production") -> dict[str, object]:
    errors = [asdict(each) | ({} if each.spot == each.spot else {"spot": None}) for each in costs]
    return {"errors": errors, "image_heights_mm": run.fields,
            "frequencies_per_mm": run.frequencies.tolist(), "nominal_contrast": run.nominal.tolist(),
            "percentiles": {name: row.tolist() for name, row in zip(("5", "50", "95"), run.band(), strict=True)},
            "nominal_spots_mm": run.nominal_spots.tolist(), "copies": len(run.spots)}


def _print(costs: "tuple[Sensitivity, ...]", run: "Production") -> None:
    from lensbench.app.state.tolerance_text import amount, error_name
    from lensbench.kernels.figures import fixed

    print(f"{'Error':26} {'within':>12}  {'spot':>10}  {'contrast':>9}")
    for each in costs[:SHOWN]:
        spot = fixed(1000.0 * each.spot, 3, signed=True) if each.spot == each.spot else "dark"
        print(f"{error_name(each.kind, each.surface):26} {amount(each.kind, each.tolerance):>12}  "
              f"{spot:>7} µm  {fixed(100.0 * each.contrast, 2, signed=True):>6} %")
    if len(costs) > SHOWN:
        print(f"and {len(costs) - SHOWN} smaller ones (--json prints all)")
    band, middle = run.band(), len(run.frequencies) // 2
    print(f"\n{len(run.spots)} copies, contrast at {fixed(run.frequencies[middle], 0)} cycles/mm: designed, and the "
          "5th, 50th and 95th percentile.\nEach is focused at infinity, where its spot on the axis is smallest")
    for k in (0, 1, 3):
        for j, name in ((0, "sagittal"), (1, "tangential")):
            row = "  ".join(fixed(100.0 * value, 1).rjust(5) for value in (
                run.nominal[k, middle, j], *band[:, k, middle, j]))
            print(f"image height {fixed(run.fields[k], 1):>5} mm  {name:10}  {row} %")


def draw(run: "Production", path: Path, title: str) -> None:
    """A chart of the contrast of the copies over frequency, one part for each image height; ExportError."""
    from lensbench.app.studies.plotting import COLOURS, look, plot, save, sheet
    from lensbench.kernels.figures import fixed

    band = run.band()
    with look():
        figure = sheet(10.5, 3.8)
        for place, k in enumerate((0, 1, 3)):
            axes = plot(figure.add_subplot(1, 3, place + 1), "Cycles / mm", "Contrast" if place == 0 else "",
                        f"{title}, {fixed(run.fields[k], 1)} mm" if place == 0 else f"{fixed(run.fields[k], 1)} mm")
            for j, name, colour in ((0, "sagittal", COLOURS["blue"]), (1, "tangential", COLOURS["vermilion"])):
                axes.fill_between(run.frequencies, band[0, k, :, j], band[2, k, :, j], color=colour, alpha=0.2,
                                  linewidth=0.0)
                axes.plot(run.frequencies, band[1, k, :, j], color=colour, label=f"{name}, median and 5 to 95 %")
                axes.plot(run.frequencies, run.nominal[k, :, j], color=colour, linestyle=":", label="as designed")
            axes.set_ylim(0.0, 1.0)
            if place == 2:
                axes.legend(fontsize=7, frameon=False)
        save(figure, path)
