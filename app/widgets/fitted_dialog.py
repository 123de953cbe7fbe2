"""A modal dialog in the middle of the window, as large as its content."""

from imgui_bundle import ImVec2, imgui


def begin_fitted_dialog(title: str) -> bool:
    """Open and begin the dialog; False while it is not drawn. `imgui.end_popup` ends it after True."""
    if not imgui.is_popup_open(title):
        imgui.open_popup(title)
    imgui.set_next_window_pos(imgui.get_main_viewport().get_center(), imgui.Cond_.always, ImVec2(0.5, 0.5))
    return imgui.begin_popup_modal(title, None, imgui.WindowFlags_.no_saved_settings
                                   | imgui.WindowFlags_.always_auto_resize)[0]
