"""Rows of choices that go on in the next line where a panel is narrow."""

from imgui_bundle import imgui

from lensbench.app.widgets import theme

GAP = 0.75                      # em between groups
KEPT = 1.9                      # em at the right, for the button of the panel's menu


def beside(width: float) -> None:
    """Put the next group into the row of the last item if `width` em of it fit there, else into a new row."""
    right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x - theme.em(KEPT)
    if imgui.get_item_rect_max().x + theme.em(GAP + width) <= right:
        imgui.same_line(0.0, theme.em(GAP))
