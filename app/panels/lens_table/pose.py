"""The cell of a surface's place: decentre, tilt and roll of the surface, of its element, or of the selected group."""

from imgui_bundle import imgui

from lensbench.app.panels.lens_table.cell import cell_item, number_cell
from lensbench.app.panels.lens_table.state import LensTableState
from lensbench.app.state.lens_edit import cells
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.marked import radio
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.editing.elements import element_at
from lensbench.lenses.editing.poses import body_at
from lensbench.optics.surface_numbers import POSE

POPUP = "Out of line"
LABELS = {"decentre_x": "Decentre x (mm)", "decentre_y": "Decentre y (mm)", "tilt_x": "Tilt about x (°)",
          "tilt_y": "Tilt about y (°)", "roll": "Roll (°)"}
ABOUT = {"decentre_x": "To the right, as the picture shows it", "decentre_y": "Upwards",
         "tilt_x": "Positive takes the upper rim towards the film",
         "tilt_y": "Positive takes the rim at +x towards the scene",
         "roll": "About its own axis, before the tilts; counterclockwise as the camera looks.\nIt turns cylinders, "
                 "toroids, and blades or a picture in the stop; a round surface stays as it is"}


def pose_cell(settings: Settings, document: LensDocument, i: int, state: LensTableState) -> Settings:
    """Draw the cell; a click opens the five numbers, and what they move."""
    pressed, hovered = cell_item(f"{i} pose", cells.pose_text(document.surfaces[i]), state, (i, "pose"), right=False)
    if hovered:
        imgui.set_item_tooltip("Click to decentre, tilt or roll the surface, its element or the selected group")
    name = f"{POPUP} {i}"
    if pressed:
        selected = (state.first, state.last) if state.first < state.last and state.selected(i) else None
        state.body = selected or body_at(document.lens, i)
        imgui.open_popup(name)
    imgui.set_next_window_size(imgui.ImVec2(theme.em(18.0), 0.0))
    if not imgui.begin_popup(name):
        return settings
    body = state.body if state.body is not None and state.body[1] < len(document.surfaces) else (i, i)
    group = [(state.first, state.last)] if state.first < state.last else []
    for choice in dict.fromkeys([(i, i), element_at(document.lens, i), body_at(document.lens, i), *group, body]):
        title = f"Surface {i}" if choice == (i, i) else f"Surfaces {choice[0]} to {choice[1]} as one"
        if radio(title, choice == body):
            state.body = body = choice
        if choice != (i, i):
            imgui.set_item_tooltip(f"They turn about the vertex of surface {choice[0]}; all surfaces behind them stay")
    for quantity in POSE:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(LABELS[quantity])
        imgui.set_item_tooltip(ABOUT[quantity])
        imgui.same_line(theme.em(9.0))
        settings = number_cell(settings, document, (body[0], quantity), state, body=body)
    imgui.end_popup()
    return settings
