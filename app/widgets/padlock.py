"""A padlock beside a dial or list: another lens leaves what it locks as it is."""

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.widgets import theme

LEAVES = {"film": "this film", "aperture": "this f-number",
          "focus": "this focus distance, and the camera where it stands"}
TAKES = {"film": "takes the film that it was made for", "aperture": "opens wide",
         "focus": "moves the camera, so that the subject stands framed and in focus"}


def padlock(name: str, locked: set[str], corner: ImVec2) -> None:
    """Draw the padlock with its upper left corner there, beside an item that has been drawn; a click changes `locked`.

    name: "film", "aperture" or "focus".
    """
    colour, is_locked, here = theme.colours(), name in locked, imgui.get_cursor_screen_pos()
    line = imgui.get_text_line_height()
    imgui.set_cursor_screen_pos(corner)
    if imgui.invisible_button(f"Lock {name}", ImVec2(theme.em(1.0), line)):
        locked ^= {name}
    ink = colour.text if imgui.is_item_hovered() else colour.strong if is_locked else colour.faint
    imgui.set_item_tooltip(f"Locked: another lens leaves {LEAVES[name]}" if is_locked else
                           f"Another lens {TAKES[name]}. Click to keep {LEAVES[name]} instead")
    theme.small()
    icon = icons_fontawesome_6.ICON_FA_LOCK if is_locked else icons_fontawesome_6.ICON_FA_LOCK_OPEN
    size = imgui.calc_text_size(icon)
    imgui.get_window_draw_list().add_text(
        ImVec2(round(corner.x + 0.5 * (theme.em(1.0) - size.x)), round(corner.y + 0.5 * (line - size.y))),
        theme.packed(ink), icon)
    imgui.pop_font()
    imgui.set_cursor_screen_pos(here)
