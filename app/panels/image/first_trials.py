"""The offer of the first session: three pictures to begin with, at the lower edge of the picture."""

from imgui_bundle import ImVec2, ImVec4, imgui
from imgui_bundle import icons_fontawesome_6 as fa

from lensbench.app.display.frame import View
from lensbench.app.state.settings import Settings
from lensbench.app.state.trials import TRIALS, tried
from lensbench.app.widgets import theme

LABEL = "Try this"


def draw_trials(settings: Settings, view: View, corner: ImVec2, room: ImVec2) -> Settings:
    """Draw the offer over the picture, whose panel has this corner and room; returns the settings that were chosen."""
    if not view.offers_trials:
        return settings
    pixel, style = theme.scale(), imgui.get_style()
    texts = [trial.title for trial in TRIALS]
    inner = (sum(imgui.calc_text_size(text).x + 2.0 * style.frame_padding.x for text in (*texts, fa.ICON_FA_XMARK))
             + (len(texts) + 1) * style.item_spacing.x)
    label = imgui.calc_text_size(LABEL).x + style.item_spacing.x
    if inner + label + 40.0 * pixel <= room.x:
        inner += label
    else:
        label = 0.0
    size = ImVec2(inner + 2.0 * style.window_padding.x, imgui.get_frame_height() + 10.0 * pixel)
    if size.x > room.x:             # beside the lens browser of a small window: it would be cut off
        return settings
    left, bottom = round(corner.x + max(0.5 * (room.x - size.x), 0.0)), corner.y + room.y - 12.0 * pixel
    for x0, y0, x1, y1 in sorted(view.plates, key=lambda plate: -plate[3]):        # the lowest first
        if x0 < left + size.x and left < x1 and y0 < bottom and bottom - size.y < y1:
            bottom = y0 - 6.0 * pixel
    imgui.set_cursor_screen_pos(ImVec2(left, round(bottom - size.y)))
    imgui.push_style_color(imgui.Col_.child_bg, ImVec4(*theme.colours().popup[:3], 0.94))
    imgui.push_style_var(imgui.StyleVar_.child_rounding, 4.0 * pixel)
    imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(style.window_padding.x, 5.0 * pixel))
    chosen = settings
    if imgui.begin_child("Trials", size, imgui.ChildFlags_.always_use_window_padding, imgui.WindowFlags_.no_scrollbar):
        if label:
            imgui.align_text_to_frame_padding()
            imgui.text_disabled(LABEL)
            imgui.same_line()
        for trial in TRIALS:
            if imgui.button(trial.title):
                chosen = tried(settings, trial)
                view.say(trial.about, lens=trial.lens, change=True)
            imgui.set_item_tooltip("Undo brings the present picture back; Help has these too")
            imgui.same_line()
        imgui.push_style_color(imgui.Col_.button, ImVec4(0.0, 0.0, 0.0, 0.0))
        if imgui.button(f"{fa.ICON_FA_XMARK}###No trials"):
            view.offers_trials = False
        imgui.pop_style_color()
        imgui.set_item_tooltip("Offer these in the Help menu alone")
    imgui.end_child()
    imgui.pop_style_var(2)
    imgui.pop_style_color()
    return chosen
