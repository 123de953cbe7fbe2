"""The panel *Ghosts*: images of a light by two reflections, ranked; the section draws the pair under the mouse."""

import math
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.build import coating, design
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, toggles
from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet, analysis, tools
from lensbench.app.plots.comparison import rows_of_b
from lensbench.app.plots.light_plots import ghost_ray, ghosts_figure, raster_of
from lensbench.app.plots.pixel_rays import PointedRay
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings
from lensbench.core.text import significant, true_minus

NAME = "Ghosts"
NARROW = 22.0                   # em: below it the discs have no table beside them
PLOTS = 13.0                    # em: least height of plots and conditions, unless the table has no three rows then
FIELDS = {"axis": "Centre", "middle": "0.7", "corner": "Corner", "outside": "Outside"}
TIPS = {"axis": "A distant light in the middle of the picture", "middle": "0.7 of the angle to the corner, upward",
        "corner": "At the angle of the corner, upward; of a lens without rotational symmetry in the corner, lower left",
        "outside": "1.3 times the angle of the corner: a light outside the picture"}
COLUMNS = {"Pair": "Surfaces that reflect, from the scene", "Bright": "Light on a mm² of the film, in millionths of "
           "the direct light", "Light": "Part of the direct light, in millionths", "Size": "Diameter on the film (mm)",
           "Focus": "Where it is in focus, behind the film (mm), for a light on the axis"}


def ghosts_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the ranked table, and the discs and brightness in the rest of the window; the changed settings."""
    state.choices["field"] = toggles("Light", FIELDS, state.choices.get("field", "corner"), TIPS, 0.0)
    tools(NAME, state)
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
    under = analysis(NAME, settings, state, sheet, ghosts_figure, (state.choices["field"], coated),
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


DRAW: dict[str, Draw] = {NAME: ghosts_panel}
