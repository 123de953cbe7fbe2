"""The frame that all analysis panels share: the figure or the reason for none, its conditions, and its menu."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.display.small_textures import MapPictures
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, wrapped_tooltip
from lensbench.app.drawing.plot_painter import Drawn, Grip, Under, draw_figure
from lensbench.app.plots.comparison import with_ghost
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.plots.plot import Figure
from lensbench.app.plots.query import query
from lensbench.app.plots.spots import nearest_ray, pointed_ray
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.analysis_worker import AnalysisWorker, Answer, Job
from lensbench.core.imaging.spectrum import WHITES

SAVES = {Request.SAVE_PLOT_CSV: "Save as CSV…", Request.SAVE_PLOT_SVG: "Save as SVG…",
         Request.SAVE_PLOT_PNG: "Save as PNG…"}
LOW = 11.0              # em: below this height a figure gives legend and second line to its plots


@dataclass
class AnalysisState:
    """State of one analysis panel between frames; its choices are not part of the settings."""

    choices: dict[str, Any] = field(default_factory=dict)
    drawn: Drawn = field(default_factory=lambda: Drawn(MapPictures()))
    figure: Figure | None = None            # as shown last; None: the panel says why there is none
    reason: str = ""                        # why there is none
    job: Callable[[Settings], Job] | None = None            # what the panel asks for, from the settings
    merged: tuple[Answer, Answer, Figure] | None = None     # of B, of A, and the figure of both

    def forget(self) -> None:
        """Drop figure and drawing of a panel that is not shown; its choices stay."""
        self.figure = self.job = self.merged = None
        self.drawn.forget()


@dataclass
class Sheet:
    """What all analysis panels of a window share: the worker, the requests, and the figure that is to be saved.

    links: what the mouse points at in all panels. other: the settings A, while they are compared. white: the light of
    analyses that a menu has just chosen, one of WHITES; "" for none.
    """

    worker: AnalysisWorker
    requests: set[Request]
    links: Pointed
    saving: Figure | None = None
    other: Settings | None = None
    white: str = ""


Draw = Callable[[Settings, AnalysisState, Sheet], Settings | None]


def analysis(name: str, settings: Settings, state: AnalysisState, sheet: Sheet, make: Callable[..., Figure],
             options: tuple = (), points: tuple[int, int] = (16, 32), grip: Grip | None = None,
             adapted: Callable[[Settings], Settings] = lambda settings: settings,
             columns: int | None = None) -> Under | None:
    """Draw the figure of an analysis in the rest of the window; what is under the cursor.

    make, options, points: as `Job` takes them. grip: a line that is dragged through the first plot. adapted: the
    settings whose figure is wanted, from those of the window, and from those of A. columns: of plots that are drawn,
    None for all; a file holds all of them.
    """
    state.figure, state.reason = None, ""
    state.job = lambda other: Job(make, query(adapted(other)), options, points)
    try:
        job = state.job(settings)
    except (ValueError, OSError) as error:
        state.reason = str(error)
        paragraph(state.reason)
        return None
    answer = sheet.worker.want(name, job)
    if answer is None:
        imgui.text_disabled("Tracing…")
        return None
    if answer.figure is None:
        state.reason = sentence(answer.message)
        paragraph(state.reason)
        return None
    figure = answer.figure
    if sheet.other is not None:
        figure = _with_other(name, figure, answer, state, sheet, adapted)
    state.figure = figure
    theme.small()
    size = imgui.get_content_region_avail()
    line, low = imgui.get_text_line_height_with_spacing(), size.y < theme.em(LOW)
    below = line * (2.0 if figure.remarks and not low else 1.0)
    drawn = replace(figure, rows=tuple(row[:columns] for row in figure.rows))
    under = draw_figure(name, drawn, ImVec2(size.x, max(size.y - below, 1.0)), state.drawn, grip,
                        sheet.links.surfaces, named=not low)
    _conditions(figure, size.x, low)
    imgui.pop_font()
    _menu(name, figure, sheet, settings.white)
    return under


def _with_other(name: str, figure: Figure, answer: Answer, state: AnalysisState, sheet: Sheet,
                adapted: Callable[[Settings], Settings]) -> Figure:
    """The figure with that of the settings A behind it; alone until the latter is there."""
    assert sheet.other is not None
    try:
        asked = query(adapted(sheet.other))
    except (ValueError, OSError) as error:
        return with_ghost(figure, None, "no lens", str(error))
    other = sheet.worker.want(f"{name} A", replace(answer.job, query=asked))
    if other is None:
        return figure
    if state.merged is None or state.merged[:2] != (answer, other):
        state.merged = answer, other, with_ghost(figure, other.figure, asked.lens.name, other.message)
    return state.merged[2]


def point_at_ray(settings: Settings, state: AnalysisState, sheet: Sheet, under: Under | None) -> None:
    """Let all panels show the ray of the mark or of the fan's point under the cursor, if there is one."""
    key = nearest_ray(under.plot, under.x, under.y) if under is not None and state.figure is not None else None
    if key is not None and state.figure is not None:
        with suppress(ValueError, OSError):             # a lens without rays; the figure is of the one before
            sheet.links.point_at_ray(pointed_ray(settings, state.figure.points, key))


def sentence(words: str) -> str:
    """The words with a capital first letter."""
    return words[:1].upper() + words[1:]


def tools(name: str, state: AnalysisState) -> None:
    """At the right of a row of choices: a button that opens the menu of the panel."""
    if state.figure is None:
        return
    width = theme.em(1.75)
    imgui.same_line(imgui.get_cursor_pos_x() + max(imgui.get_content_region_avail().x - width, 0.0))
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
    if imgui.button(f"{icons_fontawesome_6.ICON_FA_ELLIPSIS}###{name} menu", ImVec2(width, 0.0)):
        imgui.open_popup(f"{name} data")
    imgui.pop_style_color()
    imgui.set_item_tooltip("Copy or save this plot; also by a right click")


def _conditions(figure: Figure, width: float, low: bool) -> None:
    """Conditions and remarks below the figure, whole in a tooltip; in one line of a `low` panel."""
    conditions, remarks = figure.conditions.split(" · "), [sentence(remark) for remark in figure.remarks]
    if low and remarks:
        _line([*conditions, *remarks], width)
        return
    _line(conditions, width)
    if remarks:
        _line(remarks, width)


def _line(parts: list[str], width: float) -> None:
    """The whole parts for which one line has room; all of them below each other in its tooltip."""
    line = " · ".join(parts)
    if imgui.calc_text_size(line).x > width:
        shown: list[str] = []
        for part in parts:
            if imgui.calc_text_size(" · ".join([*shown, part, "…"])).x <= width:
                shown.append(part)
        line = " · ".join([*shown, "…"]) if shown else ""
    imgui.text_disabled(line or theme.shortened(parts[0], width))
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        wrapped_tooltip(parts)


def _menu(name: str, figure: Figure, sheet: Sheet, white: str) -> None:
    """The menu of a right click: copy the numbers, save numbers or figure, weight the wavelengths of white light."""
    if imgui.is_window_hovered(imgui.HoveredFlags_.child_windows) and imgui.is_mouse_released(
            imgui.MouseButton_.right) and imgui.get_mouse_drag_delta(imgui.MouseButton_.right, 4.0).x == 0.0:
        imgui.open_popup(f"{name} data")
    if imgui.begin_popup(f"{name} data"):
        if imgui.menu_item("Copy data", "", False)[0]:
            imgui.set_clipboard_text(figure.table.text("\t"))
        for request, words in SAVES.items():
            if imgui.menu_item(words, "", False)[0]:
                sheet.saving = figure
                sheet.requests.add(request)
        imgui.separator()
        if imgui.begin_menu("Weight wavelengths"):
            for choice, words in WHITES.items():
                if imgui.menu_item(sentence(words), "", choice == white)[0]:
                    sheet.white = choice
            imgui.end_menu()
        imgui.set_item_tooltip("White light of spots, MTF, point spread, bokeh, depth of field, focus shift and sensor "
                               "stack.\nPlots of single wavelengths keep those of the lens, else F, d and C")
        imgui.end_popup()
