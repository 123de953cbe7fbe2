"""The panels *Point spread*, *Bokeh* and *Ghosts*: pictures of points of light.

Ghosts are ranked in a table; the section draws the pair of reflections under the mouse.
"""

import math
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.build import coating, design
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, number, paragraph, same_row_if_room, toggles
from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet, analysis, tools
from lensbench.app.plots.comparison import rows_of_b
from lensbench.app.plots.light_plots import Ripple, bokeh_figure, ghost_ray, ghosts_figure, raster_of, ripple_surface
from lensbench.app.plots.pixel_rays import Place, PointedRay, beam, film_place
from lensbench.app.plots.point_plots import encircled_figure, line_spread_figure, psf_figure, seen_point_figure
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings
from lensbench.core.text import significant, true_minus

BOKEH = "Bokeh"
VIEWS = {"linear": "Linear", "log": "Log"}
TIPS = {"linear": "Light as the film receives it", "log": "Four decades of light: faint edges and rings show"}
PERIOD, HEIGHT = 0.8, 100.0     # mm and nm, of a ripple at first


def bokeh_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the gallery in the rest of the window."""
    choices = state.choices
    choices["view"] = toggles("View", VIEWS, choices.get("view", "linear"), TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["rings"] = check_box("Ripple", choices.get("rings", False))
    imgui.set_item_tooltip("Onion rings: a ripple that the tool left on one surface")
    ripple = _ripple(settings, choices) if choices["rings"] and settings.has_lens else None
    tools(BOKEH, state)
    analysis(BOKEH, settings, state, sheet, bokeh_figure, (choices["view"], ripple),
             (16, 48) if ripple is None else (64, 160))


def _ripple(settings: Settings, choices: dict) -> Ripple | None:
    """Three numbers that describe the ripple; None where the lens cannot be read."""
    try:
        lens = design(settings)
    except (ValueError, OSError):
        return None
    last = len(lens.surfaces) - 1
    if choices.get("lens") != settings.lens:
        choices["lens"], choices["surface"] = settings.lens, ripple_surface(lens)
    surface = number("Surface", float(choices["surface"]), (0.0, float(last)), 0.05, "%.0f",
                     "Number of the surface, from 0; at first the largest asphere", 3.0)
    same_row_if_room(7.5)
    choices["period"] = number("Period", choices.get("period", PERIOD), (0.05, 10.0), 0.005, "%.2f mm",
                               "Distance from ring to ring on the surface")
    same_row_if_room(7.5)
    choices["height"] = number("Height", choices.get("height", HEIGHT), (0.0, 1000.0), 1.0, "%.0f nm",
                               "From trough to crest")
    choices["surface"] = min(round(surface), last)
    return Ripple(choices["surface"], round(choices["period"], 4), round(1e-6 * choices["height"], 12))


POINT_SPREAD = "Point spread"
POINTS = 32, 128                # across the pupil, coarse and refined
KINDS = {"picture": "Picture", "energy": "Energy", "line": "Line"}
KIND_TIPS = {"picture": "The image of a point of light, in all wavelengths",
             "energy": "The part of its light within a circle, over the radius of the circle",
             "line": "Light across the image of a thin line"}
FIELDS = {"axis": "Axis", "middle": "0.7", "full": "Edge", "pixel": "Pixel"}
FIELD_TIPS = {"axis": "The film's centre", "middle": "0.7 of the way to the corner",
              "full": "The film's corner, or the edge of light",
              "pixel": "The pixel that was under the mouse last, or the pinned one: the picture of a point of what it "
                       "shows"}
NO_PIXEL = "Point at the picture: this panel shows how a point of what the pixel shows is drawn. I, or Alt+click, " \
           "pins the pixel"
NO_LIGHT = "No light reaches this pixel"


def point_spread_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the picture or the curves in the rest of the window."""
    choices = state.choices
    choices["kind"] = toggles("Kind", KINDS, choices.get("kind", "picture"), KIND_TIPS, 0.0)
    if choices["kind"] != "picture":
        tools(POINT_SPREAD, state)
        make = encircled_figure if choices["kind"] == "energy" else line_spread_figure
        analysis(POINT_SPREAD, settings, state, sheet, make, (), (24, 96))
        return
    same_row_if_room(10.5)
    choices["field"] = toggles("Field", FIELDS, choices.get("field", "axis"), FIELD_TIPS, 0.0)
    same_row_if_room(6.5)
    choices["view"] = toggles("View", VIEWS, choices.get("view", "log"), TIPS, 0.0)
    same_row_if_room(6.0)
    choices["averaged"] = check_box("Averaged", choices.get("averaged", False))
    imgui.set_item_tooltip("Average the light over a pixel of the film")
    tools(POINT_SPREAD, state)
    shown = choices["view"], choices["averaged"]
    if choices["field"] != "pixel" or not settings.has_lens:
        analysis(POINT_SPREAD, settings, state, sheet, psf_figure, (choices["field"], *shown), POINTS)
        return
    arguments, state.reason = _seen(settings, state, sheet)
    if arguments is None:
        state.figure = None
        paragraph(state.reason)
    else:
        analysis(POINT_SPREAD, settings, state, sheet, seen_point_figure, (*arguments, *shown), POINTS)


def _seen(settings: Settings, state: AnalysisState, sheet: Sheet) -> tuple[tuple[Place, float] | None, str]:
    """The film point (mm) of the pixel that is followed and the distance of what it shows (mm), or why there is none.

    The last pixel stays when the mouse leaves the picture.
    """
    film = settings.film
    raster = sheet.links.pixel(film.pixels_x, film.pixels_y)
    if raster is not None:
        state.choices["at"] = raster[0] / film.pixels_x, raster[1] / film.pixels_y
    position = state.choices.get("at")
    if position is None:
        return None, NO_PIXEL
    raster = position[0] * film.pixels_x, position[1] * film.pixels_y
    try:
        ahead = beam(settings, raster).ahead
    except (ValueError, OSError) as error:
        return None, str(error)
    return (None, NO_LIGHT) if math.isnan(ahead) else ((film_place(settings, raster), ahead), "")


GHOSTS = "Ghosts"
NARROW = 22.0                   # em: below it the discs have no table
PLOTS = 13.0                    # em: least height of plots and conditions, unless the table has no three rows then
LIGHTS = {"axis": "Centre", "middle": "0.7", "corner": "Corner", "outside": "Outside"}
LIGHT_TIPS = {
    "axis": "A distant light in the middle of the picture", "middle": "0.7 of the angle to the corner, upward",
    "corner": "At the angle of the corner, upward; of a lens without rotational symmetry in the corner, lower left",
    "outside": "1.3 times the angle of the corner: a light outside the picture"}
COLUMNS = {"Pair": "Surfaces that reflect, from the scene", "Bright": "Light on a mm² of the film, in millionths of "
           "the direct light", "Light": "Part of the direct light, in millionths", "Size": "Diameter on the film (mm)",
           "Focus": "Where it is in focus, behind the film (mm), for a light on the axis"}


def ghosts_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the ranked table, and the discs and brightness in the rest of the window; the changed settings."""
    state.choices["field"] = toggles("Light", LIGHTS, state.choices.get("field", "corner"), LIGHT_TIPS, 0.0)
    tools(GHOSTS, state)
    try:
        coated = coating(settings, design(settings)).name if settings.has_lens else "uncoated"
    except (ValueError, OSError):
        coated = "uncoated"                                 # `analysis` says why there is no lens
    settings = _alone(settings, state)
    room, line = imgui.get_content_region_avail(), imgui.get_text_line_height_with_spacing()
    size = ImVec2(0.0, max(min(0.42 * room.y, room.y - theme.em(PLOTS)), 3.5 * line))
    kept = state.choices.get("kept")
    chosen = _table(state, size) if state.figure is not None else None
    if settings.ghost_pair and state.choices.get("kept") != kept:
        settings = replace(settings, ghost_pair=state.choices["kept"])
    under = analysis(GHOSTS, settings, state, sheet, ghosts_figure, (state.choices["field"], coated),
                     columns=1 if room.x < theme.em(NARROW) else None)
    if state.figure is None:
        return settings
    if under is not None and under.column == 1:
        rank = round(under.x) - 1
        lit = [row[0] for row in rows_of_b(state.figure.table) if row[2] > 0.0]
        chosen = lit[rank] if 0 <= rank < len(lit) else chosen
    if state.choices.get("kept") not in {row[0] for row in rows_of_b(state.figure.table)}:
        state.choices["kept"] = ""                          # another lens
    chosen = chosen or state.choices["kept"]
    if chosen:
        _show(settings, state, sheet, chosen)
    return settings


def _alone(settings: Settings, state: AnalysisState) -> Settings:
    """The box that shows the kept ghost alone in the picture, where the picture has ghosts."""
    if not settings.ghosts:
        return settings
    kept = settings.ghost_pair or state.choices.get("kept") or ""
    imgui.begin_disabled(not kept)
    alone = check_box("Alone in the picture", bool(settings.ghost_pair))
    imgui.end_disabled()
    imgui.set_item_tooltip(f"The picture shows no ghost but that of surfaces {kept.replace('-', ' and ')}" if kept else
                           "The picture shows no other ghost than the one that is clicked in the table")
    if alone != bool(settings.ghost_pair):
        return replace(settings, ghost_pair=kept if alone else "")
    return settings


def _table(state: AnalysisState, size: ImVec2) -> str | None:
    """The ranked pairs; the one under the mouse. A click keeps one shown, or no longer."""
    assert state.figure is not None
    hovered = None
    flags = (imgui.TableFlags_.scroll_y | imgui.TableFlags_.sizing_stretch_same | imgui.TableFlags_.row_bg)
    if not imgui.begin_table("ghosts", len(COLUMNS), flags, size):
        return None
    theme.small()
    imgui.table_setup_scroll_freeze(0, 1)
    for title in COLUMNS:
        imgui.table_setup_column(title)
    imgui.table_next_row(imgui.TableRowFlags_.headers)
    for title, tip in COLUMNS.items():
        imgui.table_next_column()
        imgui.text_disabled(title)
        imgui.set_item_tooltip(tip)
    for pair, bright, share, size, _, _, focus, *_ in rows_of_b(state.figure.table):
        if not share > 0.0:
            continue
        imgui.table_next_row()
        imgui.table_next_column()
        kept = state.choices.get("kept") == pair
        if imgui.selectable(pair.replace("-", " · "), kept, imgui.SelectableFlags_.span_all_columns)[0]:
            state.choices["kept"] = "" if kept else pair
        if imgui.is_item_hovered():
            hovered = pair
        far = "∞" if math.isinf(focus) else "–" if math.isnan(focus) else true_minus(significant(focus, 3))
        parts = significant(1e6 * bright, 2) if math.isfinite(bright) else "∞"
        for text in (parts, significant(1e6 * share, 2), significant(size, 3), far):
            imgui.table_next_column()
            imgui.text_unformatted(text)
    imgui.pop_font()
    imgui.end_table()
    return hovered


def _show(settings: Settings, state: AnalysisState, sheet: Sheet, pair: str) -> None:
    """Light the surfaces of a pair, and draw its ray; the picture marks where a light of this field has the ghost."""
    first, second = map(int, pair.split("-"))
    try:
        path = ghost_ray(query(settings), state.choices["field"], (first, second))
    except (ValueError, OSError):                           # a pair of the lens before, too
        return
    sheet.links.point_at_surfaces((first, second))
    if path is None:
        return
    sheet.links.point_at_ray(PointedRay(path, -1, f"ghost of surfaces {first} and {second}", None,
                                        raster_of(settings, path)))


DRAW: dict[str, Draw] = {POINT_SPREAD: point_spread_panel, BOKEH: bokeh_panel, GHOSTS: ghosts_panel}
