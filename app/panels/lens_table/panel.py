"""The surface table: every number of the lens, to type or to drag; what cannot be is marked where it is.

Everything else of the window follows within a frame. Arrow keys go from cell to cell, Enter types, Ctrl with an arrow
key steps the number; a right click has solves and pickups, and the edits of rows.
"""

from functools import partial

from imgui_bundle import icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, wrapped_tooltip
from lensbench.app.panels.lens_table.cell import Entry, LensTableState, cell_item, number_cell, tab_step, text_entry
from lensbench.app.panels.lens_table.dialogs import attach_dialog, paste_dialog, pose_cell, progress
from lensbench.app.panels.lens_table.glass import POPUP, glass_popup
from lensbench.app.panels.lens_table.menu import cell_menu, has_keyboard, keys, row_menu, toolbar
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.session import lens_cells
from lensbench.app.session.edited_lens import document_of, faults_of
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.prescription import CONIC, CURVATURE, CURVATURE_X, SEMI_DIAMETER, THICKNESS
from lensbench.core.text import RAISED, fixed
from lensbench.lenses.editing.cells import with_comment
from lensbench.lenses.editing.document import LensDocument

COLUMNS = (("row", "#", 3.0), (CURVATURE, "Radius", 4.7), (THICKNESS, "Thickness", 4.7), ("glass", "Glass", 5.0),
           (SEMI_DIAMETER, "Semi-ø", 4.2), (CONIC, "Conic", 3.8), ("asphere", "Asphere", 4.2),
           ("pose", "Tilt, decentre", 7.0), ("comment", "Comment", 9.0))      # widths in em
MARKED = {Kind.HEMISPHERE: SEMI_DIAMETER, Kind.EDGE: THICKNESS, Kind.CROSSING: THICKNESS, Kind.THICKNESS: THICKNESS,
          Kind.RAY: CURVATURE}
ASPHERE = "Asphere"


def lens_table_panel(settings: Settings, state: LensTableState, links: Pointed | None = None) -> Settings:
    """Draw the table into the current window; returns the settings, changed or not.

    links: what the mouse points at in all panels; the row under the mouse is lit in the section, and the other way.
    """
    state.parted = False
    state.follow(settings)
    if not settings.has_lens:
        paragraph("This camera has no lens")
        return settings
    try:
        document = document_of(settings)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return settings
    last = len(document.surfaces) - 1
    state.first, state.last = min(state.first, last), min(state.last, last)
    findings = faults_of(document) if settings.edited else ()
    settings = toolbar(settings, document, state)
    _fault_line(settings, findings, state)
    state.keyed = has_keyboard(state)
    settings = _table(settings, document, findings, state, links)
    settings = keys(settings, document, state)
    settings = attach_dialog(settings, state)
    return paste_dialog(settings, state)


def move_cell(state: LensTableState, rows: int) -> bool:
    """Move the keyboard's cell by an arrow key or Tab; whether it moved."""
    io, key = imgui.get_io(), imgui.Key
    if not state.keyed or state.focused is None or io.key_ctrl or io.key_alt:
        return False
    names = [name for name, _, _ in COLUMNS]
    row, column = state.focused[0], names.index(state.focused[1]) if state.focused[1] in names else 1
    for pressed, down, right in ((key.up_arrow, -1, 0), (key.down_arrow, 1, 0), (key.left_arrow, 0, -1),
                                 (key.right_arrow, 0, 1)):
        if imgui.is_key_pressed(pressed):
            row, column = row + down, column + right
    column, state.tabbed = column + (state.tabbed or tab_step()), 0
    row, column = min(max(row, 0), rows - 1), min(max(column, 0), len(names) - 1)
    if (row, names[column]) == state.focused:
        return False
    state.focused = row, names[column]
    state.select(row)
    return True


def _fault_line(settings: Settings, findings: tuple[Finding, ...], state: LensTableState) -> None:
    """Why the latest edit was refused, or the first fault of the lens, in one line; all of them in its tooltip."""
    lines = [state.problem] if state.problem else [str(finding) for finding in findings]
    said = progress(settings, state)
    if state.problem or not state.worker.running and lines:
        said = ""
    if not said and not lines:
        imgui.new_line()
        return
    imgui.same_line(0.0, theme.em(0.8))
    room = imgui.get_content_region_avail().x
    if room < theme.em(8.0):
        imgui.new_line()
        room = imgui.get_content_region_avail().x
    imgui.align_text_to_frame_padding()
    if said:
        imgui.text_unformatted(theme.shortened(said, room))
        return
    more = f" (+{len(lines) - 1})" if len(lines) > 1 else ""
    text = theme.shortened(f"{fa.ICON_FA_TRIANGLE_EXCLAMATION}  {lines[0]}", room - imgui.calc_text_size(more).x)
    imgui.text_colored(imgui.ImVec4(*theme.colours().warning), text + more)
    if imgui.is_item_hovered():
        wrapped_tooltip(lines)


def _table(settings: Settings, document: LensDocument, findings: tuple[Finding, ...], state: LensTableState,
           links: Pointed | None) -> Settings:
    flags = (imgui.TableFlags_.scroll_x | imgui.TableFlags_.scroll_y | imgui.TableFlags_.borders_inner_h
             | imgui.TableFlags_.resizable | imgui.TableFlags_.no_saved_settings)
    if not imgui.begin_table("Surfaces", len(COLUMNS), flags):
        return settings
    imgui.table_setup_scroll_freeze(1, 1)
    for _, title, width in COLUMNS:
        kind = imgui.TableColumnFlags_.width_fixed
        imgui.table_setup_column(title, kind, theme.em(width))
    imgui.table_headers_row()
    faulty = {(f.surface, MARKED[f.kind]): f for f in findings if f.surface is not None and f.kind in MARKED}
    wrong = {f.surface for f in findings if f.surface is not None}
    moved = move_cell(state, len(document.surfaces))
    opened = False
    pointed: int | None = None
    for i in range(len(document.surfaces)):
        imgui.table_next_row()
        if links is not None and i in links.surfaces:
            imgui.table_set_bg_color(imgui.TableBgTarget_.row_bg0, theme.packed(theme.colours().frame_active))
        elif state.selected(i):
            imgui.table_set_bg_color(imgui.TableBgTarget_.row_bg0, theme.packed(theme.colours().frame))
        for quantity, _, _ in COLUMNS:
            imgui.table_next_column()
            settings, opens = _cell(settings, document, i, quantity, state, (i, quantity) in faulty, i in wrong)
            opened = opened or opens
            if imgui.is_item_hovered():
                pointed = i
            if moved and state.focused == (i, quantity):
                imgui.set_scroll_here_y()
    imgui.end_table()
    if links is not None and pointed is not None:
        links.point_at_surfaces((pointed,))
    if opened:
        state.search, state.problem = "", ""
        imgui.open_popup(POPUP)
    return glass_popup(settings, document, state)


def _cell(settings: Settings, document: LensDocument, i: int, quantity: str, state: LensTableState, faulty: bool,
          wrong: bool) -> tuple[Settings, bool]:
    """One cell; the settings, and whether the popup of glasses opens."""
    opens = False
    surface = document.surfaces[i]
    if quantity == "row":
        stop = f"{fa.ICON_FA_CIRCLE_STOP} " if i == document.lens.stop_index else ""
        warn = f"{fa.ICON_FA_TRIANGLE_EXCLAMATION} " if wrong else ""
        _, hovered = cell_item(f"{i} row", f"{warn or stop}{i}", state, (i, "row"), faulty=wrong, dim=not stop)
        if hovered:
            imgui.set_item_tooltip("The aperture stop" if stop else
                                   "Click selects, Shift+click selects up to here, right click edits")
    elif quantity == "glass":
        text = lens_cells.glass_text(surface.glass)
        pressed, hovered = cell_item(f"{i} glass", text, state, (i, "glass"), right=False)
        if hovered and surface.glass.n_d > 1.0:
            abbe = f", V_d {fixed(surface.glass.v_d, 2)}" if surface.glass.v_d else ""
            imgui.set_item_tooltip(f"{surface.glass.name or 'Glass'}: n_d {fixed(surface.glass.n_d, 5)}{abbe}")
        if pressed:
            state.glass_of, opens = i, True
    elif quantity == "comment":
        settings = _comment(settings, document, i, state)
    elif quantity == "asphere":
        settings = _asphere(settings, document, i, state)
    elif quantity == "pose":
        settings = pose_cell(settings, document, i, state)
    else:
        settings = number_cell(settings, document, (i, quantity), state, faulty)
    if quantity not in ("asphere", "pose") and imgui.begin_popup_context_item(f"menu {i} {quantity}"):
        if quantity in (CURVATURE, THICKNESS, SEMI_DIAMETER, CONIC):
            settings = cell_menu(settings, document, quantity, state)
            imgui.separator()
        settings = row_menu(settings, document, state)
        imgui.end_popup()
    return settings, opens


def _comment(settings: Settings, document: LensDocument, i: int, state: LensTableState) -> Settings:
    cell = (i, "comment")
    if state.entry is not None and state.entry.cell == cell:
        text = text_entry(state)
        if text is not None:
            settings = state.apply(settings, partial(with_comment, surface=i, comment=text))
            state.entry = None
        return settings
    pressed, _ = cell_item(f"{i} comment", document.comment(i), state, cell, right=False, dim=True)
    if pressed:
        state.entry = Entry(cell, document.comment(i))
    return settings


def _asphere(settings: Settings, document: LensDocument, i: int, state: LensTableState) -> Settings:
    """The cell of an asphere, cylinder or toroid: a click opens its coefficients, and its radius across."""
    surface = document.surfaces[i]
    toroid = surface.curvature_x is not None
    pressed, hovered = cell_item(f"{i} asphere", lens_cells.asphere_text(surface), state, (i, "asphere"), right=False)
    if hovered:
        what = "radius of the section x–z" if toroid else "coefficients, or the radius of a cylinder or toroid"
        imgui.set_item_tooltip(f"Click for the {what}")
    name = f"{ASPHERE} {i}"
    if pressed:
        imgui.open_popup(name)
    titles = (f"Surface {i}: coefficients of r^p, mm^(1 − p)", f"Surface {i}: section x–z of a cylinder or toroid")
    width = max(imgui.calc_text_size(title).x for title in titles) + 2.0 * imgui.get_style().window_padding.x
    imgui.set_next_window_size(imgui.ImVec2(max(width, theme.em(16.0)), 0.0))
    if imgui.begin_popup(name):
        powers = [power for power, _ in surface.aspheric]
        shown = sorted({4, 6, 8, 10, *powers, min((powers or [8])[-1] + 2, 20)})
        if not toroid:
            imgui.text_disabled(titles[0])
            for power in shown:
                imgui.align_text_to_frame_padding()
                imgui.text_disabled("r" + f"{power}".translate(RAISED))
                imgui.same_line(theme.em(4.5))
                settings = number_cell(settings, document, (i, f"r{power}"), state)
        if toroid or not (surface.aspheric or surface.conic):
            imgui.text_disabled(titles[1])
            imgui.align_text_to_frame_padding()
            imgui.text_disabled("Radius")
            imgui.set_item_tooltip("A radius other than that of the section y–z, in the column Radius, makes the\n"
                                   "surface a cylinder (one of them is a plane) or a toroid")
            imgui.same_line(theme.em(4.5))
            settings = number_cell(settings, document, (i, CURVATURE_X), state)
        imgui.end_popup()
    return settings
