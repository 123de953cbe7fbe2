"""The command `lensbench improve LENS`: least squares on radii, thicknesses or single numbers of a lens."""

import argparse
import json
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from lensbench.app.command.errors import UsageError
from lensbench.app.command.output import checked_lens_path

if TYPE_CHECKING:
    from lensbench.design.improve import Step
    from lensbench.lenses.editing.document import LensDocument

WORDS = {"radius": "curvature", "semi-diameter": "semi_diameter"}       # of --vary, for a quantity


def add_improve_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench improve`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.state.text_values import read_extent

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
                        help="least thickness of elements at their rims")
    parser.add_argument("--centre", type=option(read_extent), metavar="MM",
                        help="least thickness of elements at their centre")
    parser.add_argument("--json", action="store_true", help="print JSON: the spot of each step, and the numbers")


def improve(arguments: argparse.Namespace) -> int:
    """Improve a lens, print the spot of each step and the changed numbers, and write the lens.

    Ctrl-C ends it; the best lens so far is kept.
    """
    from lensbench.app.command.stop_signals import stop_signals
    from lensbench.app.state.lens_choice import image_circle
    from lensbench.app.state.lens_edit.cells import glass_text, whole
    from lensbench.app.state.lens_edit.editing import document_named
    from lensbench.app.state.lens_edit.improving import improved
    from lensbench.design.improve import ending
    from lensbench.design.merit import amount
    from lensbench.design.standard_goal import goal_of
    from lensbench.lenses.glass_catalogue import replacements
    from lensbench.optics.glass import GlassError
    from lensbench.optics.lens_surface import LensError
    from lensbench.optics.surface_numbers import value_of

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
            print("\n".join(f"judged   {each}" for each in goal.judged))
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
        for each in swapped:
            print(f"surface {each['surface']:2}  glass          {each['before']} -> {each['after']}")
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
    from lensbench.app.state.lens_edit.improving import free_cells
    from lensbench.design.improve import VARIED
    from lensbench.optics.surface_numbers import QUANTITIES

    if text in VARIED:
        return free_cells(document, text)
    cells = []
    for word in text.split(","):
        place, _, name = word.strip().partition(".")
        quantity = WORDS.get(name, name)
        if not place.isdecimal() or int(place) >= len(document.surfaces) or quantity not in QUANTITIES:
            raise UsageError(f"--vary {word.strip()}: write radii, thicknesses, all, or numbers such as 0.radius, "
                                f"1.thickness, 3.conic, 3.r4 of surfaces 0 to {len(document.surfaces) - 1}")
        cells.append((int(place), quantity))
    return tuple(dict.fromkeys(cells))
