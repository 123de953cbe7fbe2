"""The commands of a designer: `lensbench improve LENS`, by least squares on radii, thicknesses or single numbers; and
`lensbench tolerances LENS`, what errors of manufacture cost, and the spread of a production run.
"""

import argparse
import json
import math
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lensbench.app.command.output import UsageError, checked_chart_path, checked_lens_path
from lensbench.core.text import significant

if TYPE_CHECKING:
    from lensbench.core.design.improve import Step
    from lensbench.core.design.tolerances import Production, Sensitivity
    from lensbench.lenses.editing.document import LensDocument


WORDS = {"radius": "curvature", "semi-diameter": "semi_diameter"}       # of --vary, for a quantity


def add_improve_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench improve`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.settings.text_values import read_extent

    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    parser.add_argument("-o", "--output", metavar="FILE", help="the improved lens, in the format of the suffix")
    parser.add_argument("--vary", metavar="CELLS", default="radii",
                        help="what may change: radii (by default), thicknesses, all, or single numbers such as "
                             "0.radius,1.thickness,3.conic,3.r4")
    parser.add_argument("--image-height", type=option(read_extent), metavar="MM",
                        help="largest image height that counts; by default the fields that the lens states, else that "
                             "of its image circle")
    parser.add_argument("--back-focus", action="store_true", help="hold the back focus as well as the focal length")
    parser.add_argument("--merit", choices=("spot", "wavefront"), default="spot",
                        help="what is to fall over fields and colours: the rms radius of the spots (by default), or "
                             "the rms wave error")
    parser.add_argument("--glasses", nargs="?", const="all", metavar="MAKER",
                        help="also try other glasses, of all catalogues or of one maker such as schott")
    parser.add_argument("--edge", type=option(read_extent), metavar="MM",
                        help="least thickness of elements at their edges")
    parser.add_argument("--centre", type=option(read_extent), metavar="MM",
                        help="least thickness of elements at their centre")
    parser.add_argument("--json", action="store_true", help="print JSON: the spot of each step, and the numbers")


def improve(arguments: argparse.Namespace) -> int:
    """Improve a lens, print each step and the changed numbers, and write it; Ctrl-C keeps the best lens so far."""
    from lensbench.app.bench.lens_choice import image_circle
    from lensbench.app.command.output import stop_signals
    from lensbench.app.session.edited_lens import document_named, improved
    from lensbench.app.session.lens_cells import glass_text, whole
    from lensbench.core.design.improve import ending
    from lensbench.core.design.merit import amount
    from lensbench.core.design.standard_goal import goal_of
    from lensbench.core.optics.glass import GlassError
    from lensbench.core.optics.lens_surface import LensError
    from lensbench.core.optics.prescription import value_of
    from lensbench.lenses.glass.catalogue import replacements

    path = checked_lens_path(arguments.output)
    document = document_named(arguments.lens)
    height = arguments.image_height
    if height is None and not document.lens.system.fields:
        circle = image_circle(arguments.lens, document.lens)
        height = 0.5 * circle if circle is not None else 0.35 * (document.lens.stated_efl or 50.0)
    steps: list[Step] = []

    def progress(step: "Step") -> None:
        steps.append(step)
        if not arguments.json:
            print(f"step {step.number:2}  {amount(step.rms, goal.aim)}", flush=True)

    try:
        goal = goal_of(document.lens, height, arguments.merit, arguments.back_focus, arguments.edge, arguments.centre)
        cells = vary(document, arguments.vary)
        glasses = None if arguments.glasses is None else replacements(
            None if arguments.glasses == "all" else arguments.glasses.upper())
        for remark in goal.left_out:
            print(remark, file=sys.stderr)
        if not arguments.json:
            print("\n".join(f"judged   {words}" for words in goal.judged))
        with stop_signals(True) as asked:
            done = improved(document, cells, goal, glasses, progress, lambda: bool(asked))
    except (LensError, GlassError) as error:
        raise UsageError(f"{arguments.lens}: {error}") from error
    after = replace(document, lens=done.lens)
    numbers = [{"surface": i, "quantity": quantity, "before": value_of(document.surfaces[i], quantity),
                "after": value_of(after.surfaces[i], quantity)} for i, quantity in cells]
    follow = [(i, quantity) for i, quantity in ((after.lens.stop_index, "semi_diameter"),
                                                (len(after.surfaces) - 1, "thickness"))
              if value_of(document.surfaces[i], quantity) != value_of(after.surfaces[i], quantity)]
    swapped = [{"surface": i, "before": glass_text(before.glass), "after": glass_text(now.glass)}
               for i, (before, now) in enumerate(zip(document.surfaces, after.surfaces, strict=True))
               if before.glass != now.glass]
    positions = [{"zoom": position.zoom, "close": position.close, "before_mm": before, "after_mm": now}
                 for position, before, now in zip(goal.positions, done.start.by_position, done.end.by_position,
                                                  strict=True)]
    if arguments.json:
        name = "wave_errors_mm" if goal.aim == "wavefront" else "spots_mm"
        print(json.dumps({"image_height_mm": height, "judged": goal.judged, name: [step.rms for step in steps],
                          "ended": done.ended, "light": done.end.light / done.start.light, "positions": positions,
                          "numbers": numbers, "glasses": swapped}, indent=2))
    else:
        print(f"{ending(done)}: {amount(done.start.rms, goal.aim)} -> {amount(done.end.rms, goal.aim)}")
        for position, before, now in zip(goal.positions, done.start.by_position, done.end.by_position, strict=True):
            if len(positions) > 1:
                print(f"{position.words:24} {amount(before, goal.aim)} -> {amount(now, goal.aim)}")
        for swap in swapped:
            print(f"surface {swap['surface']:2}  glass          {swap['before']} -> {swap['after']}")
        for i, quantity in [*cells, *follow]:
            name = {"curvature": "radius", "curvature_x": "radius x–z"}.get(quantity, quantity)
            print(f"surface {i:2}  {name:14}  {whole(document.surfaces[i], quantity)[:12]} -> "
                  f"{whole(after.surfaces[i], quantity)[:12]}")
    if path is not None:
        from lensbench.app.command.lens_files import print_remarks
        from lensbench.lenses import save

        print_remarks(save(after, path), sys.stderr)
    return 0


def vary(document: "LensDocument", text: str) -> tuple[tuple[int, str], ...]:
    """The cells that --vary names; UsageError for a word that names none."""
    from lensbench.app.session.edited_lens import free_cells
    from lensbench.core.design.improve import VARIED
    from lensbench.core.optics.prescription import QUANTITIES

    if text in VARIED:
        return free_cells(document, text)
    cells = []
    for word in text.split(","):
        index, _, name = word.strip().partition(".")
        quantity = WORDS.get(name, name)
        if not index.isdecimal() or int(index) >= len(document.surfaces) or quantity not in QUANTITIES:
            raise UsageError(f"--vary {word.strip()}: write radii, thicknesses, all, or numbers such as 0.radius, "
                                f"1.thickness, 3.conic, 3.r4 of surfaces 0 to {len(document.surfaces) - 1}")
        cells.append((int(index), quantity))
    return tuple(dict.fromkeys(cells))


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


def add_tolerances_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench tolerances`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.settings.text_values import read_extent

    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    parser.add_argument("--f-number", type=float, metavar="N", help="stop down to this f-number; wide open by default")
    parser.add_argument("--image-height", type=option(read_extent), metavar="MM",
                        help="largest image height; by default to the corner of the lens's film, or its light's edge")
    for name, error in ERRORS.items():
        parser.add_argument(f"--{name}", type=float, default=error.default, metavar=error.metavar,
                            help=f"tolerance {error.what}; {significant(error.default)} by default, 0 for none")
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
    within = lb.tolerances.Tolerances(**{name: _tolerance(name, getattr(arguments, name)) for name in ERRORS})
    lens = lenses.load(arguments.lens)
    if arguments.f_number is not None:
        lens = lb.stopped_down(lens, arguments.f_number)
    film = None
    if arguments.image_height is not None:
        if not arguments.image_height > 0.0:
            raise UsageError("--image-height 0: it must be more than 0")
        side = math.sqrt(2.0) * arguments.image_height
        film = lb.Film(side, side, 1, 1)
    costs = lb.tolerances.sensitivities(lens, film, within, wavelengths="picture")
    run = lb.tolerances.production(lens, film, within, arguments.copies, arguments.seed, wavelengths="picture")
    if arguments.json:
        print(json.dumps(_plain(costs, run), indent=2))
    else:
        _print(costs, run)
    if path is not None:
        top = float(run.frequencies[-1])
        run = lb.tolerances.production(lens, film, within, arguments.copies, arguments.seed,
                                     [top * (k + 1) / CHARTED for k in range(CHARTED)])
        draw(run, path, lens.name)
        print(f"wrote {path}", file=sys.stderr)
    return 0


def _tolerance(name: str, value: float) -> float:
    """A tolerance as `Tolerances` takes it; UsageError, in the unit of the option, for one out of range."""
    from lensbench.core.design.tolerances import LARGEST

    unit, metavar = ERRORS[name].unit, ERRORS[name].metavar
    if not 0.0 <= value * unit < LARGEST:
        raise UsageError(f"--{name} {significant(value)}: the tolerance of {name} must be from 0 to less than "
                         f"{significant(LARGEST / unit, 4)} {metavar}")
    return value * unit


def _plain(costs: "tuple[Sensitivity, ...]", run: "Production") -> dict[str, object]:
    errors = [asdict(cost) | ({} if cost.spot == cost.spot else {"spot": None}) for cost in costs]
    return {"errors": errors, "image_heights_mm": run.fields,
            "frequencies_per_mm": run.frequencies.tolist(), "nominal_contrast": run.nominal.tolist(),
            "percentiles": {name: row.tolist() for name, row in zip(("5", "50", "95"), run.band(), strict=True)},
            "nominal_spots_mm": run.nominal_spots.tolist(), "copies": len(run.spots)}


def _print(costs: "tuple[Sensitivity, ...]", run: "Production") -> None:
    from lensbench.app.plots.tolerance_plots import amount, error_name
    from lensbench.core.text import fixed

    print(f"{'Error':26} {'within':>12}  {'spot':>10}  {'contrast':>9}")
    for cost in costs[:SHOWN]:
        spot = fixed(1000.0 * cost.spot, 3, signed=True) if cost.spot == cost.spot else "dark"
        print(f"{error_name(cost.kind, cost.surface):26} {amount(cost.kind, cost.tolerance):>12}  "
              f"{spot:>7} µm  {fixed(100.0 * cost.contrast, 2, signed=True):>6} %")
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
    from lensbench.app.drawing.sheet import COLOURS, look, plot, save, sheet
    from lensbench.core.text import fixed

    band = run.band()
    with look():
        figure = sheet(10.5, 3.8)
        for column, k in enumerate((0, 1, 3)):
            axes = plot(figure.add_subplot(1, 3, column + 1), "Cycles / mm", "Contrast" if column == 0 else "",
                        f"{title}, {fixed(run.fields[k], 1)} mm" if column == 0 else f"{fixed(run.fields[k], 1)} mm")
            for j, name, colour in ((0, "sagittal", COLOURS["blue"]), (1, "tangential", COLOURS["vermilion"])):
                axes.fill_between(run.frequencies, band[0, k, :, j], band[2, k, :, j], color=colour, alpha=0.2,
                                  linewidth=0.0)
                axes.plot(run.frequencies, band[1, k, :, j], color=colour, label=f"{name}, median and 5 to 95 %")
                axes.plot(run.frequencies, run.nominal[k, :, j], color=colour, linestyle=":", label="as designed")
            axes.set_ylim(0.0, 1.0)
            if column == 2:
                axes.legend(fontsize=7, frameon=False)
        save(figure, path)
