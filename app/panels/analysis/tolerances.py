"""The panel *Tolerances*: what each error of manufacture costs, the contrast of a thousand copies, and five of them."""

import math
from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet, analysis, tools
from lensbench.app.plots.plot import Figure
from lensbench.app.plots.tolerance_plots import SHARES, copies_figure, cost_figure, pictures_figure, with_copy
from lensbench.app.settings.settings import Settings
from lensbench.core.design.tolerances import LARGEST, Tolerances
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.text import significant, true_minus

NAME = "Tolerances"
KINDS = {"costs": "Costs", "copies": "Copies", "pictures": "Pictures"}
TIPS = {"costs": "Growth of the spot and loss of contrast by each error alone, the costliest first",
        "copies": "Contrast of 1,000 copies with all errors drawn at random: median, 5th and 95th percentile",
        "pictures": "A star at three image heights through the design and five copies, from a good one to a poor one"}
FIGURES: dict[str, tuple[Callable[..., Figure], tuple[int, int]]] = {
    "costs": (cost_figure, (1, 1)), "copies": (copies_figure, (100, 1000)), "pictures": (pictures_figure, (1, 1))}
# Of each tolerance: the unit, its size in that of `Tolerances`, and what it is of
UNITS = {"radius": ("%", 0.01, "of every radius of curvature"), "thickness": ("mm", 1.0, "of every thickness and gap"),
         "index": ("", 1.0, "of every glass"), "decentre": ("mm", 1.0, "of every element across the axis"),
         "tilt": ("′", math.radians(1.0 / 60.0), "of every element about its front vertex, in minutes of arc")}


def tolerances_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the costs, the copies or their pictures in the rest of the window; settings with the copy that is taken."""
    choices = state.choices
    choices["kind"] = toggles("Show", KINDS, choices.get("kind", "costs"), TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["within"] = _edited(choices.get("within", Tolerances()), choices)
    tools(NAME, state)
    taken = settings
    if choices["kind"] == "pictures" and state.figure is not None:
        taken = _take(settings, choices["within"])
    make, points = FIGURES[choices["kind"]]
    analysis(NAME, settings, state, sheet, make, (choices["within"],), points)
    return taken


def _take(settings: Settings, within: Tolerances) -> Settings:
    """A button whose popup offers the five copies: the settings with the lens of the one that is chosen."""
    if imgui.button("Take a copy…"):
        imgui.open_popup("Take a copy")
    imgui.set_item_tooltip("Replace the lens by one of the five copies, to see its picture (undo to go back)")
    if imgui.begin_popup("Take a copy"):
        imgui.text_disabled("Percentile of contrast")
        for number, name in enumerate(SHARES):
            if imgui.menu_item(f"{name}###{number}", "", False)[0]:
                settings = with_copy(settings, within, number)
        imgui.end_popup()
    return settings


def _edited(within: Tolerances, choices: dict) -> Tolerances:
    """A button whose popup holds the five tolerances; those that it leaves."""
    if imgui.button("Errors…"):
        imgui.open_popup("Errors of manufacture")
    imgui.set_item_tooltip("The tolerances: the largest errors, 2 σ of what is drawn")
    if not imgui.begin_popup("Errors of manufacture"):
        return within
    for name, (unit, size, what) in UNITS.items():
        imgui.set_next_item_width(theme.em(5.0))
        changed, value = imgui.input_double(f"{name.capitalize()} {unit}###{name}", getattr(within, name) / size, 0.0,
                                            0.0, "%.5g")
        imgui.set_item_tooltip(f"Tolerance {what}; 0 for none")
        if changed:
            try:
                within, choices["refused"] = replace(within, **{name: value * size}), ""
            except LensError:
                refused = " ".join((name.capitalize(), true_minus(significant(value)), unit)).strip()
                choices["refused"] = f"{refused}: type a number from 0 to below {significant(LARGEST / size)}"
    if choices.get("refused"):
        imgui.push_style_color(imgui.Col_.text, theme.colours().warning)
        paragraph(choices["refused"], strong=True)
        imgui.pop_style_color()
    if imgui.button("Usual values"):
        within, choices["refused"] = Tolerances(), ""
    imgui.end_popup()
    return within


DRAW: dict[str, Draw] = {NAME: tolerances_panel}
