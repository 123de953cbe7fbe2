"""The analysis panels that show one plot with a few choices."""

from contextlib import suppress
from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.focus_plane import focus_at
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import beside, check_box, number, toggles
from lensbench.app.drawing.plot_painter import Grip
from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, point_at_ray, tools
from lensbench.app.plots.aberration_plots import seidel_figure, wavefront_figure
from lensbench.app.plots.aperture_plots import axial_figure, breathing_figure, focus_shift_figure, illumination_figure
from lensbench.app.plots.bokeh_plots import star_figure
from lensbench.app.plots.field_plots import SHOWN, depth_figure, field_figure
from lensbench.app.plots.mtf_plots import mtf_field_figure, mtf_frequency_figure, mtf_map_figure
from lensbench.app.plots.plot import Bars
from lensbench.app.plots.query import query
from lensbench.app.plots.ray_plots import fans_figure, grid_figure
from lensbench.app.plots.spots import COLUMNS, spots_figure
from lensbench.app.plots.stack_plots import Stack, stack_figure
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import fixed

ON_THE_AXIS = "On the axis"


def axial_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw both plots in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Spherical aberration and colour")
    tools(ON_THE_AXIS, state)
    analysis(ON_THE_AXIS, settings, state, sheet, axial_figure)


DEPTH_OF_FIELD_NAME = "Depth of field"


def depth_of_field_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the limits over the field in the rest of the window; sharp is what the read-outs call so."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Sharp over the field")
    tools(DEPTH_OF_FIELD_NAME, state)
    limit = blur_limit(settings) if settings.has_lens else None
    analysis(DEPTH_OF_FIELD_NAME, settings, state, sheet, depth_figure, (limit,))


FANS_NAME = "Ray fans"
FANS_KINDS = {"ray": "Rays", "opd": "Path difference"}
FANS_TIPS = {"ray": "Where rays meet the film against their heights in the stop, from the primary chief ray",
        "opd": "Optical path difference (OPD) on the reference sphere against the height in the stop, in wavelengths"}


def fans_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the fans in the rest of the window."""
    state.choices["kind"] = toggles("Kind", FANS_KINDS, state.choices.get("kind", "ray"), FANS_TIPS, 0.0)
    tools(FANS_NAME, state)
    rows = min(max(round(imgui.get_content_region_avail().y / theme.em(7.0)), 2), 6)
    point_at_ray(settings, state, sheet, analysis(FANS_NAME, settings, state, sheet, fans_figure,
                                                  (state.choices["kind"], rows)))


FIELD_CURVES_NAME = "Field curves"
WIDE = 46.0                     # em, from which on all plots are side by side
NAMES = {"curvature": "Curvature", "distortion": "Distortion", "grid": "Grid", "colour": "Colour"}
BESIDE = {"curves": "Over the field", "grid": "Grid"}
FIELD_CURVES_TIPS = {
        "curvature": "Where sagittal and tangential lines are in focus, from the film: field curvature and astigmatism",
        "distortion": "Image heights against an ideal projection",
        "grid": "Distortion as the image of a square grid; the ideal one is faint",
        "colour": "Image heights of other wavelengths against the primary one",
        "curves": "Field curvature, distortion and lateral colour side by side"}


def field_curves_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    shown = state.choices.get("shown", "curvature")
    if imgui.get_content_region_avail().x < theme.em(WIDE):
        shown = toggles("Shown", NAMES, shown, FIELD_CURVES_TIPS, 0.0)
        plots: tuple[str, ...] = (shown,)
    else:
        side = toggles("Shown", BESIDE, shown if shown in BESIDE else "curves", FIELD_CURVES_TIPS, 0.0)
        shown = side if side == "grid" else "curvature" if shown == "grid" else shown
        plots = SHOWN
    state.choices["shown"] = shown
    tools(FIELD_CURVES_NAME, state)
    if shown == "grid":
        analysis(FIELD_CURVES_NAME, settings, state, sheet, grid_figure)
    else:
        analysis(FIELD_CURVES_NAME, settings, state, sheet, field_figure, (plots,))


FOCUS_SHIFT_NAME = "Focus shift"
FOCUS_SHIFT_KINDS = {"shift": "Focus shift", "breathing": "Breathing"}
FOCUS_SHIFT_TIPS = {"shift": "The best focus over the f-number; the film is as the lens is focused wide open",
        "breathing": "How much wider the picture gets as the lens is focused nearer"}


def focus_shift_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the best focus against the aperture, or the field of view against the focus, in the rest of the window."""
    kind = state.choices.get("kind", "shift")
    state.choices["kind"] = toggles("Kind", FOCUS_SHIFT_KINDS, kind, FOCUS_SHIFT_TIPS, 0.0)
    tools(FOCUS_SHIFT_NAME, state)
    if state.choices["kind"] == "breathing":
        analysis(FOCUS_SHIFT_NAME, settings, state, sheet, breathing_figure)
        return
    number = readings(settings).f_number if settings.has_lens else None
    analysis(FOCUS_SHIFT_NAME, settings, state, sheet, focus_shift_figure, (number,),
             adapted=lambda settings: replace(settings, f_number=None))


ILLUMINATION_NAME = "Illumination"


def illumination_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Relative illumination")
    tools(ILLUMINATION_NAME, state)
    analysis(ILLUMINATION_NAME, settings, state, sheet, illumination_figure,
             adapted=lambda settings: replace(settings, f_number=None))


MTF_NAME = "MTF"
MTF_KINDS = {"field": "Field", "frequency": "Frequency"}
KIND_TIPS = {"field": "Contrast of 10, 20, 30 and 40 line pairs per mm over the image height",
             "frequency": "Contrast on the axis, at 0.7 and at the full field over the frequency"}
METHODS = {"diffraction": "Waves", "geometric": "Rays"}
METHOD_TIPS = {"diffraction": "With diffraction, from the wavefront in the exit pupil",
               "geometric": "From the rays alone, without diffraction"}


def mtf_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    choices = state.choices
    choices["kind"] = toggles("Over", MTF_KINDS, choices.get("kind", "field"), KIND_TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["method"] = toggles("By", METHODS, choices.get("method", "diffraction"), METHOD_TIPS, 0.0)
    tools(MTF_NAME, state)
    make, points = (mtf_field_figure, (16, 64)) if choices["kind"] == "field" else (mtf_frequency_figure, (32, 128))
    analysis(MTF_NAME, settings, state, sheet, make, (choices["method"],), points)


MTF_MAP_NAME = "MTF map"
FREQUENCIES = {10.0: "10", 20.0: "20", 30.0: "30", 40.0: "40"}
WAYS = {"both": "S + T", "sagittal": "S", "tangential": "T"}
WAY_TIPS = {"both": "The mean of the sagittal and the tangential contrast", "sagittal": "Lines towards the centre",
            "tangential": "Lines about the centre"}


def mtf_map_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the map in the rest of the window; returns the settings with the dragged focus.

    While the film is dragged the map stays that of the object at which the drag began.
    """
    choices = state.choices
    choices["frequency"] = toggles("lp/mm", FREQUENCIES, choices.get("frequency", 30.0),
                                   {key: f"{name} line pairs per mm" for key, name in FREQUENCIES.items()}, 3.2)
    beside(7.0)
    choices["way"] = toggles("Way", WAYS, choices.get("way", "both"), WAY_TIPS, 0.0)
    line = _line(settings, choices.get("line"))
    choices["line"] = line
    tools(MTF_MAP_NAME, state)
    held: Settings | None = choices.get("held")
    shift = choices.get("shift", 0.0) if held is not None else 0.0
    begun = settings if held is None else replace(settings, focus_distance=held.focus_distance)
    grip = Grip(shift, "film", f"{format_distance(settings.focus_distance)}: drag to focus")
    analysis(MTF_MAP_NAME, begun, state, sheet, mtf_map_figure, (choices["frequency"], choices["way"], line), grip=grip)
    if not grip.held or not settings.focuses:
        choices["held"] = None
        return settings
    if held is None:
        choices["held"] = settings
    if grip.at == shift:
        return settings
    choices["shift"] = grip.at
    return replace(settings, focus_distance=focus_at(query(begun).setup, grip.at))


def _line(settings: Settings, chosen: float | None) -> float | None:
    """The wavelength (µm) that the user chooses among those of the lens; None: all of them, or the only one."""
    lines: tuple[float, ...] = ()
    with suppress(ValueError, OSError):                 # the panel says why there is no map
        lines = query(settings).lines.conditions().wavelengths
    if len(lines) < 2:
        return None
    names: dict[float | None, str] = {None: "White"} | {line: fixed(1000.0 * line, 0) for line in lines}
    tips: dict[float | None, str] = {None: "All wavelengths with their weights"} | {
        line: f"{name} nm alone" for line, name in names.items() if line is not None}
    beside(4.0 + 2.6 * len(lines))
    return toggles("Line", names, chosen if chosen in names else None, tips, 0.0)


SEIDEL_NAME = "Seidel"


def seidel_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the bars in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Share of each surface")
    tools(SEIDEL_NAME, state)
    under = analysis(SEIDEL_NAME, settings, state, sheet, seidel_figure)
    if under is None or state.figure is None:
        return
    surface, count = round(under.x), sum(isinstance(each, Bars) and each.surface is not None
                                         for each in under.plot.layers)
    if 0 <= surface < count and abs(under.x - surface) < 0.5:
        sheet.links.point_at_surfaces((surface,))


SENSOR_STACK_NAME = "Sensor stack"


def sensor_stack_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw three numbers and the curves in the rest of the window."""
    held: Stack = state.choices.get("stack", Stack())
    thickness = number("Glass", held.thickness, (0.0, 10.0), 0.02, "%.2f mm",
                       "Thickness of the glass before the sensor")
    beside(7.0)
    index = number("Index", held.refractive_index, (1.0, 2.2), 0.002, "%.3f", "Index of this glass")
    beside(9.5)
    error = number("Adapter", held.adapter_error, (-1.0, 1.0), 0.002, "%+.3f mm",
                   "By which an adapter is too long (+) or too short (−)", 5.6)
    state.choices["stack"] = Stack(round(thickness, 4), round(index, 5), round(error, 5))
    tools(SENSOR_STACK_NAME, state)
    analysis(SENSOR_STACK_NAME, settings, state, sheet, stack_figure, (state.choices["stack"],))


SPOTS_NAME = "Spots"
SIDE = {"focus": "Focus", "colour": "Colours"}
SIDE_TIPS = {"focus": "Positions of the film side by side: nearer to the lens at the left, farther at the right",
             "colour": "The wavelengths side by side, on the film"}
REFERENCE = {"chief": "Chief ray", "centroid": "Centroid"}
REFERENCE_TIPS = {"chief": "Sizes are measured from the chief ray of the primary wavelength",
                  "centroid": "Sizes are measured from the centroid of the light of all wavelengths"}


def spots_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the spots in the rest of the window."""
    choices = state.choices
    choices["columns"] = toggles("Side", SIDE, choices.get("columns", "focus"), SIDE_TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["reference"] = toggles("Reference", REFERENCE, choices.get("reference", "chief"), REFERENCE_TIPS, 0.0)
    beside(6.0)                             # with room for the menu
    choices["blur"] = check_box("Blur", choices.get("blur", False))
    imgui.set_item_tooltip("Behind the rays: the light as the picture of the point has it, without diffraction.\n"
                           "Each cell is as bright as its brightest place")
    tools(SPOTS_NAME, state)
    room = imgui.get_content_region_avail()
    columns = COLUMNS if choices["columns"] == "focus" else 3
    rows = min(max(round(columns * 0.85 * room.y / max(room.x, 1.0)), 2), 8)
    point_at_ray(settings, state, sheet, analysis(SPOTS_NAME, settings, state, sheet, spots_figure,
                                                  (choices["columns"], choices["reference"], rows, choices["blur"])))


SUNSTAR_NAME = "Sunstar"
SUNSTAR_FIELDS = {"axis": "Centre", "middle": "0.7"}
SUNSTAR_TIPS = {"axis": "A light in the middle of the picture",
                "middle": "A light 0.7 of the way to the corner, above the centre of the film"}


def sunstar_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the star in the rest of the window."""
    state.choices["field"] = toggles("Field", SUNSTAR_FIELDS, state.choices.get("field", "axis"), SUNSTAR_TIPS, 0.0)
    tools(SUNSTAR_NAME, state)
    analysis(SUNSTAR_NAME, settings, state, sheet, star_figure, (state.choices["field"],))


WAVEFRONT_NAME = "Wavefront"
WAVEFRONT_FIELDS = {"axis": "Axis", "middle": "0.7", "full": "Full"}
WAVEFRONT_TIPS = {"axis": "On the axis", "middle": "At 0.7 of the largest image height",
                  "full": "At the largest image height"}

ORDERS = {"noll": "Noll", "fringe": "Fringe"}
ORDER_TIPS = {"noll": "Zernike polynomials in Noll's order, each with an rms of 1",
              "fringe": "Zernike polynomials in the fringe order, each 1 at the edge of the pupil"}


def wavefront_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw map and bars in the rest of the window."""
    state.choices["field"] = toggles("Field", WAVEFRONT_FIELDS, state.choices.get("field", "axis"), WAVEFRONT_TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    state.choices["order"] = toggles("Order", ORDERS, state.choices.get("order", "noll"), ORDER_TIPS, 0.0)
    tools(WAVEFRONT_NAME, state)
    analysis(WAVEFRONT_NAME, settings, state, sheet, wavefront_figure,
             (state.choices["field"], state.choices["order"]), (24, 64))
