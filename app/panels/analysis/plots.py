"""The analysis panels that show one plot with a few choices: a table of them, and those that need more."""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from imgui_bundle import imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.focus_plane import focus_at
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, number, paragraph, same_row_if_room, toggles
from lensbench.app.drawing.plot_painter import Grip
from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet, analysis, point_at_ray, tools
from lensbench.app.plots.aperture_plots import (
    Stack, axial_figure, breathing_figure, focus_shift_figure, illumination_figure, stack_figure
)
from lensbench.app.plots.field_plots import SHOWN, depth_figure, field_figure
from lensbench.app.plots.light_plots import star_figure
from lensbench.app.plots.plot import Bars, Figure
from lensbench.app.plots.point_plots import mtf_field_figure, mtf_frequency_figure, mtf_map_figure
from lensbench.app.plots.query import query
from lensbench.app.plots.ray_plots import fans_figure, grid_figure, seidel_figure, wavefront_figure
from lensbench.app.plots.spots import COLUMNS, spots_figure
from lensbench.app.plots.tolerance_plots import SHARES, copies_figure, cost_figure, pictures_figure, with_copy
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.design.tolerances import LARGEST, Tolerances
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.text import fixed, significant, true_minus


@dataclass(frozen=True)
class Choice:
    """Buttons of which one is on. options: key, and the button's name and tooltip. start: the key that is on at first;
    None for the first one.
    """

    name: str
    options: dict[Any, tuple[str, str]]
    start: Any = None

    def drawn(self, state: AnalysisState, indent: float = 0.0) -> Any:
        """Draw the buttons; the key of the one that is on, also kept in the choices of the panel."""
        names, tips = ({key: words[i] for key, words in self.options.items()} for i in (0, 1))
        key = state.choices.get(self.name, self.start or next(iter(names)))
        state.choices[self.name] = toggles(self.name, names, key, tips, indent)
        return state.choices[self.name]


def _open(settings: Settings) -> Settings:
    """The settings with the stop wide open."""
    return replace(settings, f_number=None)


@dataclass(frozen=True)
class Plain:
    """A panel of choices and one figure.

    heading: instead of choices. options: of `make`, from the settings and the keys that are on. points: as `Job` takes
    them. adapted: the settings whose figure is shown.
    """

    make: Callable[..., Figure]
    choices: tuple[Choice, ...] = ()
    heading: str = ""
    options: Callable[..., tuple] = lambda settings, *keys: keys
    points: tuple[int, int] = (16, 32)
    adapted: Callable[[Settings], Settings] = lambda settings: settings


FANS = Choice("Kind", {
    "ray": ("Rays", "Where rays meet the film against their heights in the stop, from the primary chief ray"),
    "opd": ("Path difference", "Optical path difference (OPD) on the reference sphere against the height in the stop, "
                               "in wavelengths")})
OVER = Choice("Over", {
    "field": ("Field", "Contrast of 10 and 30 line pairs per mm over the image height; saved numbers\n"
                       "also hold 20 and 40"),
    "frequency": ("Frequency", "Contrast on the axis, at 0.7 and at the full field over the frequency")})
METHOD = Choice("By", {"diffraction": ("Waves", "With diffraction, from the wavefront in the exit pupil"),
                       "geometric": ("Rays", "From the rays alone, without diffraction")})
FREQUENCY = Choice("lp/mm", {value: (fixed(value, 0), f"{fixed(value, 0)} line pairs per mm")
                             for value in (10.0, 20.0, 30.0, 40.0)}, start=30.0)
WAY = Choice("Way", {"both": ("S + T", "The mean of the sagittal and the tangential contrast"),
                     "sagittal": ("S", "Lines towards the centre"), "tangential": ("T", "Lines about the centre")})
SIDE = Choice("Side", {
    "focus": ("Focus", "Film positions side by side: nearer to the lens at the left, farther at the right"),
    "colour": ("Colours", "The wavelengths side by side, on the film")})
REFERENCE = Choice("Reference", {
    "chief": ("Chief ray", "Sizes are measured from the chief ray of the primary wavelength"),
    "centroid": ("Centroid", "Sizes are measured from the centroid of the light of all wavelengths")})
SHIFT = Choice("Kind", {
    "shift": ("Focus shift", "The best focus over the f-number; the film is as the lens is focused wide open"),
    "breathing": ("Breathing", "How much wider the picture gets as the lens is focused nearer")})
CURVES = {"curvature": ("Curvature", "Where sagittal and tangential lines are in focus, from the film: field curvature "
                                     "and astigmatism"),
          "distortion": ("Distortion", "Image heights against an ideal projection"),
          "grid": ("Grid", "Distortion as the image of a square grid; the ideal one is faint"),
          "colour": ("Colour", "Image heights of other wavelengths against the primary one")}
SIDE_BY_SIDE = {"curves": ("Over the field", "Field curvature, distortion and lateral colour side by side"),
                "grid": CURVES["grid"]}
WIDE = 46.0                     # em, from which on all field curves are side by side

PLAIN = {
    "On the axis": Plain(axial_figure, heading="Spherical aberration and colour"),
    # What is sharp is what the read-outs call so
    "Depth of field": Plain(depth_figure, heading="Sharp over the field",
                            options=lambda settings: (blur_limit(settings) if settings.has_lens else None,)),
    "Illumination": Plain(illumination_figure, heading="Relative illumination", adapted=_open),
    "Sunstar": Plain(star_figure, (Choice("Field", {
        "axis": ("Centre", "A light in the middle of the picture"),
        "middle": ("0.7", "A light 0.7 of the way to the corner, above the centre of the film")}),)),
    "Wavefront": Plain(wavefront_figure, (
        Choice("Field", {"axis": ("Axis", "On the axis"), "middle": ("0.7", "At 0.7 of the largest image height"),
                         "full": ("Full", "At the largest image height")}),
        Choice("Order", {"noll": ("Noll", "Zernike polynomials in Noll's order, each with an rms of 1"),
                         "fringe": ("Fringe", "Zernike polynomials in the fringe order, each 1 at the edge of the "
                                              "pupil")})), points=(24, 64)),
}


def plain_panel(name: str, settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the choices of a panel of the table, and its figure in the rest of the window."""
    panel = PLAIN[name]
    keys = _row(name, state, *panel.choices, heading=panel.heading)
    analysis(name, settings, state, sheet, panel.make, panel.options(settings, *keys), panel.points,
             adapted=panel.adapted)


def _row(name: str, state: AnalysisState, *choices: Choice, heading: str = "") -> tuple:
    """The row of choices, or a heading, with the button of the menu; the keys that are on."""
    if heading:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(heading)
    keys = []
    for i, choice in enumerate(choices):
        if i:
            imgui.same_line(0.0, 12.0)
        keys.append(choice.drawn(state))
    tools(name, state)
    return tuple(keys)


def fans_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Ray fans, in as many rows as the height has room for; the ray under the cursor is shown by all panels."""
    name = "Ray fans"
    kind, = _row(name, state, FANS)
    rows = min(max(round(imgui.get_content_region_avail().y / theme.em(7.0)), 2), 6)
    point_at_ray(settings, state, sheet, analysis(name, settings, state, sheet, fans_figure, (kind, rows)))


def field_curves_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """One of the field curves, or all of them side by side where there is room."""
    name, shown = "Field curves", state.choices.get("Shown", "curvature")
    wide = imgui.get_content_region_avail().x >= theme.em(WIDE)
    if wide:
        state.choices["Shown"] = "grid" if shown == "grid" else "curves"
    elif shown == "curves":
        state.choices["Shown"] = "curvature"
    key, = _row(name, state, Choice("Shown", SIDE_BY_SIDE if wide else CURVES))
    if key == "grid":
        analysis(name, settings, state, sheet, grid_figure)
    else:
        analysis(name, settings, state, sheet, field_figure, (SHOWN if wide else (key,),))


def focus_shift_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """The best focus against the aperture, or the field of view against the focus."""
    name = "Focus shift"
    kind, = _row(name, state, SHIFT)
    if kind == "breathing":
        analysis(name, settings, state, sheet, breathing_figure)
        return
    f_number = readings(settings).f_number if settings.has_lens else None
    analysis(name, settings, state, sheet, focus_shift_figure, (f_number,), adapted=_open)


def mtf_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """The contrast over the field, or over the frequency."""
    over, method = _row("MTF", state, OVER, METHOD)
    make, points = (mtf_field_figure, (16, 64)) if over == "field" else (mtf_frequency_figure, (32, 128))
    analysis("MTF", settings, state, sheet, make, (method,), points)


def mtf_map_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """The contrast over field and focus; returns the settings with the dragged focus.

    While the film is dragged the map stays that of the object at which the drag began.
    """
    choices = state.choices
    frequency = FREQUENCY.drawn(state, 3.2)
    same_row_if_room(7.0)
    way = WAY.drawn(state)
    line = _line(settings, state)
    tools("MTF map", state)
    before: Settings | None = choices.get("before")     # the settings at which a drag began
    shift = choices.get("shift", 0.0) if before is not None else 0.0
    begun = settings if before is None else replace(settings, focus_distance=before.focus_distance)
    grip = Grip(shift, "film", f"{format_distance(settings.focus_distance)}: drag to focus")
    analysis("MTF map", begun, state, sheet, mtf_map_figure, (frequency, way, line), grip=grip)
    if not grip.held or not settings.focuses:
        choices["before"] = None
        return settings
    if before is None:
        choices["before"] = settings
    if grip.at == shift:
        return settings
    choices["shift"] = grip.at
    return replace(settings, focus_distance=focus_at(query(begun).bench, grip.at))


def _line(settings: Settings, state: AnalysisState) -> float | None:
    """The wavelength (µm) that the user chooses among those of the lens; None: all of them, or the only one."""
    lines: tuple[float, ...] = ()
    with suppress(ValueError, OSError):                 # the panel says why there is no map
        lines = query(settings).lines.conditions().wavelengths
    if len(lines) < 2:
        return None
    names = {line: fixed(1000.0 * line, 0) for line in lines}
    options: dict[Any, tuple[str, str]] = {None: ("White", "All wavelengths with their weights")}
    options |= {line: (name, f"{name} nm alone") for line, name in names.items()}
    if state.choices.get("Line") not in options:
        state.choices["Line"] = None
    same_row_if_room(4.0 + 2.6 * len(lines))
    return Choice("Line", options).drawn(state)


def seidel_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """The share of each surface; the one under the cursor is lit in all panels."""
    _row("Seidel", state, heading="Share of each surface")
    under = analysis("Seidel", settings, state, sheet, seidel_figure)
    if under is None or state.figure is None:
        return
    surface, count = round(under.x), sum(isinstance(layer, Bars) and layer.surface is not None
                                         for layer in under.plot.layers)
    if 0 <= surface < count and abs(under.x - surface) < 0.5:
        sheet.links.point_at_surfaces((surface,))


def sensor_stack_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """The glass before a sensor and an adapter, and what they do."""
    name, stack = "Sensor stack", state.choices.get("stack", Stack())
    thickness = number("Glass", stack.thickness, (0.0, 10.0), 0.02, "%.2f mm",
                       "Thickness of the glass before the sensor")
    same_row_if_room(7.0)
    index = number("Index", stack.refractive_index, (1.0, 2.2), 0.002, "%.3f", "Index of this glass")
    same_row_if_room(9.5)
    error = number("Adapter", stack.adapter_error, (-1.0, 1.0), 0.002, "%+.3f mm",
                   "By which an adapter is too long (+) or too short (−)", 5.6)
    stack = state.choices["stack"] = Stack(round(thickness, 4), round(index, 5), round(error, 5))
    tools(name, state)
    analysis(name, settings, state, sheet, stack_figure, (stack,))


def spots_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """The spots, in as many rows as the height has room for; the ray under the cursor is shown by all panels."""
    side = SIDE.drawn(state)
    imgui.same_line(0.0, 12.0)
    reference = REFERENCE.drawn(state)
    same_row_if_room(6.0)                             # with room for the menu
    blur = state.choices["blur"] = check_box("Blur", state.choices.get("blur", False))
    imgui.set_item_tooltip("Behind the rays: the light as the picture of the point has it, without diffraction.\n"
                           "Each cell is as bright as its brightest point")
    tools("Spots", state)
    room = imgui.get_content_region_avail()
    rows = min(max(round((COLUMNS if side == "focus" else 3) * 0.85 * room.y / max(room.x, 1.0)), 2), 8)
    under = analysis("Spots", settings, state, sheet, spots_figure, (side, reference, rows, blur))
    point_at_ray(settings, state, sheet, under)


TOLERANCES = "Tolerances"
SHOW = Choice("Show", {
    "costs": ("Costs", "Growth of the spot and loss of contrast by each error alone, the costliest first"),
    "copies": ("Copies", "Contrast of 1,000 copies with all errors drawn at random: median, 5th and 95th percentile"),
    "pictures": ("Pictures", "A star at three image heights through the design and five copies, from a good one to a "
                             "poor one")})
FIGURES: dict[str, tuple[Callable[..., Figure], tuple[int, int]]] = {
    "costs": (cost_figure, (1, 1)), "copies": (copies_figure, (100, 1000)), "pictures": (pictures_figure, (1, 1))}
# Of each tolerance: the unit, its size in that of `Tolerances`, and what it is of
UNITS = {"radius": ("%", 0.01, "of every radius of curvature"), "thickness": ("mm", 1.0, "of every thickness and gap"),
         "index": ("", 1.0, "of every glass"), "decentre": ("mm", 1.0, "of every element across the axis"),
         "tilt": ("′", math.radians(1.0 / 60.0), "of every element about its front vertex, in minutes of arc")}


def tolerances_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the costs, the copies or their pictures in the rest of the window; settings with the copy that is taken."""
    choices = state.choices
    kind = SHOW.drawn(state)
    imgui.same_line(0.0, 12.0)
    choices["within"] = _edited(choices.get("within", Tolerances()), choices)
    tools(TOLERANCES, state)
    taken = settings
    if kind == "pictures" and state.figure is not None:
        taken = _take(settings, choices["within"])
    make, points = FIGURES[kind]
    analysis(TOLERANCES, settings, state, sheet, make, (choices["within"],), points)
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


DRAW: dict[str, Draw] = {name: partial(plain_panel, name) for name in PLAIN} | {
    "Spots": spots_panel, "Ray fans": fans_panel, "Field curves": field_curves_panel, "MTF": mtf_panel,
    "MTF map": mtf_map_panel, "Seidel": seidel_panel, "Focus shift": focus_shift_panel,
    "Sensor stack": sensor_stack_panel, TOLERANCES: tolerances_panel}
