"""The command `lensbench improve LENS`: damped least squares on radii, thicknesses or single numbers of a lens."""

import argparse
import json
import sys
from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING

from lensbench.app.command.errors import UsageError
from lensbench.app.command.output import checked_lens_path
from lensbench.kernels.figures import significant

if TYPE_CHECKING:
    from lensbench.app.studies.improvement.improve import Step
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
                        help="largest image height that counts; by default that of the lens's image circle")
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
    """Improve a lens, print the spot of each step and the changed numbers, and write the lens."""
    from lensbench.app.state.lens_choice import image_circle
    from lensbench.app.state.lens_edit.cells import glass_text, whole
    from lensbench.app.state.lens_edit.editing import document_named
    from lensbench.app.studies.improvement.improve import improved
    from lensbench.app.studies.improvement.merit import FIELDS, Merit, MeritError, amount, back_focus, goal_of, left_out
    from lensbench.app.studies.improvement.substitution import substituted
    from lensbench.lenses.editing.document import value_of

    path = checked_lens_path(arguments.output)
    document = document_named(arguments.lens)
    height = arguments.image_height
    if height is None:
        circle = image_circle(arguments.lens, document.lens)
        height = 0.5 * circle if circle is not None else 0.35 * (document.lens.stated_efl or 50.0)
    try:
        goal = goal_of(document, height, arguments.merit)
    except MeritError as error:
        raise UsageError(f"{arguments.lens}: {error}") from error
    if arguments.back_focus:
        goal = replace(goal, back_focus=back_focus(document.lens))
    for name in ("edge", "centre"):
        if getattr(arguments, name) is not None:
            goal = replace(goal, **{name: getattr(arguments, name)})
    cells = vary(document, arguments.vary)
    steps: list[Step] = []
    try:
        weights = Merit(document.lens, goal).beams.weights
        for said in left_out(document.lens, goal):
            print(said, file=sys.stderr)
        dark = [share for share, row in zip(FIELDS, weights, strict=True) if not row.any()]
        if dark:
            print(f"No light arrives at {' and '.join(map(significant, dark))} of the largest field angle, "
                  f"{significant(degrees(goal.field), 3)}°: not counted", file=sys.stderr)
        maker = None if arguments.glasses in (None, "all") else arguments.glasses.upper()
        for step in improved(document, cells, goal) if arguments.glasses is None else substituted(
                document, cells, goal, maker):
            if steps and step.number == steps[-1].number:
                continue
            steps.append(step)
            if not arguments.json:
                print(f"step {step.number:2}  {amount(step.rms, goal.aim)}", flush=True)
    except MeritError as error:
        raise UsageError(f"{arguments.lens}: {error}") from error
    after = steps[-1].document
    numbers = [{"surface": i, "quantity": quantity, "before": value_of(document.surfaces[i], quantity),
                "after": value_of(after.surfaces[i], quantity)} for i, quantity in cells]
    glasses = [{"surface": i, "before": glass_text(before.glass), "after": glass_text(now.glass)}
               for i, (before, now) in enumerate(zip(document.surfaces, after.surfaces, strict=True))
               if before.glass != now.glass]
    if arguments.json:
        name = "wave_errors_mm" if goal.aim == "wavefront" else "spots_mm"
        print(json.dumps({"image_height_mm": height, name: [step.rms for step in steps], "numbers": numbers,
                          "glasses": glasses}, indent=2))
    else:
        for each in glasses:
            print(f"surface {each['surface']:2}  glass          {each['before']} -> {each['after']}")
        for i, quantity in cells:
            name = {"curvature": "radius", "curvature_x": "radius x–z"}.get(quantity, quantity)
            print(f"surface {i:2}  {name:14}  {whole(document.surfaces[i], quantity)[:12]} -> "
                  f"{whole(after.surfaces[i], quantity)[:12]}")
    if path is not None:
        from lensbench.app.command.lens_files import print_remarks
        from lensbench.lenses import save
        from lensbench.lenses.editing.structure import kept_in_focus

        after, moved = kept_in_focus(document.lens, after)
        print_remarks((*moved, *save(after, path)), sys.stderr)
    return 0


def vary(document: "LensDocument", text: str) -> tuple[tuple[int, str], ...]:
    """The cells that --vary names; UsageError for a word that names none."""
    from lensbench.app.studies.improvement.improve import radii
    from lensbench.lenses.editing.document import QUANTITIES

    gaps = tuple((i, "thickness") for i in range(len(document.surfaces) - 1)
                 if document.rule(i, "thickness") is None)
    known = {"radii": radii(document), "thicknesses": gaps, "all": (*radii(document), *gaps)}
    if text in known:
        return known[text]
    cells = []
    for word in text.split(","):
        place, _, name = word.strip().partition(".")
        quantity = WORDS.get(name, name)
        if not place.isdecimal() or int(place) >= len(document.surfaces) or quantity not in QUANTITIES:
            raise UsageError(f"--vary {word.strip()}: write radii, thicknesses, all, or numbers such as 0.radius, "
                                f"1.thickness, 3.conic, 3.r4 of surfaces 0 to {len(document.surfaces) - 1}")
        cells.append((int(place), quantity))
    return tuple(dict.fromkeys(cells))
