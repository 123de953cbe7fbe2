"""Over the picture: notices in one quiet place, the offer of the first session, a look around in a panorama.

The first line is the newest error, the other the newest note; a notice that is alone may take both.
"""

import math
import os

from imgui_bundle import ImVec2, ImVec4, icons_fontawesome_6 as fa, imgui

from lensbench.app.bench.lens_choice import TRIALS, tried
from lensbench.app.bench.pose import LookAround
from lensbench.app.display.frame import Picture, View
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import two_lines, wrapped_tooltip
from lensbench.app.panels.image.overlays import above_plates, draw_note
from lensbench.app.session.notices import Notice, NoticeKind, Notices
from lensbench.app.settings.settings import Settings
from lensbench.core.text import fixed

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
    if size.x > room.x:             # next to the lens browser of a small window: it would be cut off
        return settings
    left = round(corner.x + max(0.5 * (room.x - size.x), 0.0))
    bottom = above_plates(view.plates, left, left + size.x, corner.y + room.y - 12.0 * pixel, size.y)
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
            imgui.set_item_tooltip("Undo to go back. The Help menu has these too")
            imgui.same_line()
        imgui.push_style_color(imgui.Col_.button, ImVec4(0.0, 0.0, 0.0, 0.0))
        if imgui.button(f"{fa.ICON_FA_XMARK}###No trials"):
            view.offers_trials = False
        imgui.pop_style_color()
        imgui.set_item_tooltip("Hide these; the Help menu keeps them")
    imgui.end_child()
    imgui.pop_style_var(2)
    imgui.pop_style_color()
    return chosen


def look_around(settings: Settings, picture: Picture, view: View, corner: ImVec2, room: ImVec2) -> None:
    """Draw the view into the room of the panel, and turn it by the mouse on the item just submitted."""
    assert view.look is not None
    draw, io, size = imgui.get_window_draw_list(), imgui.get_io(), (room.x, room.y)
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    draw.add_image(imgui.ImTextureRef(picture.around), corner, end)
    view.covered = (corner.x, corner.y, end.x, end.y)
    look = view.look
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        look = look.dragged(io.mouse_delta.x, io.mouse_delta.y, size)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        look = look.zoomed(io.mouse_wheel)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            look = LookAround()
        mouse = imgui.get_mouse_pos()
        position = (mouse.x - corner.x) / max(room.x, 1.0), (mouse.y - corner.y) / max(room.y, 1.0)
        view.links.hover = view.pointed = view.look.raster(position, size, settings.film, settings.layout)
    view.look = look
    theme.small()
    draw_note(draw, ImVec2(corner.x + 14.0 * theme.scale(),
                           end.y - 12.0 * theme.scale() - imgui.get_text_line_height()),
              f"{_compass(look.yaw)} · {_height(look.pitch)} · {fixed(math.degrees(look.fov), 0)}° wide")
    imgui.pop_font()


def _compass(yaw: float) -> str:
    degrees = round(math.degrees(yaw))
    return "ahead" if not degrees else f"{abs(degrees)}° to the {'left' if degrees > 0 else 'right'}"


def _height(pitch: float) -> str:
    degrees = round(math.degrees(pitch))
    return "level" if not degrees else f"{abs(degrees)}° {'up' if degrees > 0 else 'down'}"


ICONS = {NoticeKind.ERROR: fa.ICON_FA_TRIANGLE_EXCLAMATION, NoticeKind.NOTE: fa.ICON_FA_CIRCLE_INFO,
         NoticeKind.DONE: fa.ICON_FA_CHECK}
LIST = "All notices"
LONGEST_FRAME = 0.6             # seconds of a frame that count as reading time: the window at rest draws two a second
LONGEST_PATH = 48               # characters of a path that are shown where the text has no room
WIDEST_LIST, HIGHEST_LIST = 38.0, 20.0          # em


def draw_notices(view: View, corner: ImVec2, room: ImVec2) -> None:
    """Draw them over the picture, whose panel has this upper left corner and this room."""
    notices = view.notices
    if not len(notices):
        return
    pixel, line = theme.scale(), imgui.get_text_line_height()
    shown = [*notices.errors()[:1], *notices.others()[:1]]
    buttons = theme.em(1.7) + (theme.em(3.6) if len(notices) > 1 else 0.0)
    offers = {notice: imgui.calc_text_size(notice.offer[0]).x + theme.em(1.2) for notice in shown if notice.offer}
    inner = room.x - 20.0 * pixel - 2.0 * imgui.get_style().window_padding.x
    width = max(inner - theme.em(1.6) - buttons - max(offers.values(), default=0.0), theme.em(4.0))
    rows = [(notice, text_line) for notice in shown
            for text_line in (two_lines(_fitting(notice, 1.9 * width), width) if len(shown) == 1 else
                              [theme.shortened(_fitting(notice, width), width)])]
    widest = inner                      # of the list; the plate is as wide as its words
    inner = min(inner, max(imgui.calc_text_size(text).x + offers.get(notice, 0.0) for notice, text in rows)
                + theme.em(2.0) + buttons)
    pad = 5.0 * pixel
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 10.0 * pixel, corner.y + 8.0 * pixel))
    imgui.push_style_color(imgui.Col_.child_bg, ImVec4(*theme.colours().popup[:3], 0.94))
    imgui.push_style_var(imgui.StyleVar_.child_rounding, 4.0 * pixel)
    imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(imgui.get_style().window_padding.x, pad))
    size = ImVec2(inner + 2.0 * imgui.get_style().window_padding.x, len(rows) * line + 2.0 * pad)
    flags = imgui.ChildFlags_.always_use_window_padding
    if imgui.begin_child("Messages", size, flags, imgui.WindowFlags_.no_scrollbar):
        top, left = imgui.get_cursor_pos_y(), imgui.get_cursor_pos_x()
        for i, (notice, text) in enumerate(rows):
            imgui.set_cursor_pos(ImVec2(left, top + i * line))
            if not i or rows[i - 1][0] is not notice:
                _icon(notice)
            imgui.set_cursor_pos(ImVec2(left + theme.em(1.6), top + i * line))
            imgui.text_unformatted(text)
            if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip) and text != notice.text:
                wrapped_tooltip([notice.text])
            if not i or rows[i - 1][0] is not notice:
                if notice.offer is not None:
                    imgui.set_cursor_pos(ImVec2(left + inner - buttons - offers[notice], top + i * line))
                    if imgui.small_button(notice.offer[0]):
                        view.requests.add(notice.offer[1])
                imgui.set_cursor_pos(ImVec2(left + inner - theme.em(1.3), top + i * line))
                _dismiss(notices, notice, f"###Dismiss {i}" if i else "###Dismiss")
        if len(notices) > 1:
            imgui.set_cursor_pos(ImVec2(left + inner - theme.em(5.0), top))
            if _flat_button(f"{len(notices)} {fa.ICON_FA_ANGLE_DOWN}###{LIST}"):
                imgui.open_popup(LIST)
            imgui.set_item_tooltip("All notices, the newest first")
        _list(notices, ImVec2(corner.x + room.x - 10.0 * pixel, corner.y + 8.0 * pixel + size.y + 3.0 * pixel), widest)
    imgui.end_child()
    imgui.pop_style_var(2)
    imgui.pop_style_color()
    hovered = imgui.is_mouse_hovering_rect(imgui.get_item_rect_min(), imgui.get_item_rect_max())
    if not hovered and not imgui.is_popup_open(LIST, imgui.PopupFlags_.any_popup):
        notices.pass_time(shown, min(imgui.get_io().delta_time, LONGEST_FRAME))


def _fitting(notice: Notice, room: float) -> str:
    """The text in one line; of a text without room the path that it begins with is cut, as the reason follows it."""
    text = notice.text.replace("\n", " ")
    path, colon, reason = text.partition(": ")
    if imgui.calc_text_size(text).x <= room or os.sep not in path or len(path) <= LONGEST_PATH:
        return text
    return f"{path[:LONGEST_PATH // 3]}…{path[-LONGEST_PATH // 2:]}{colon}{reason}"


def _list(notices: Notices, corner: ImVec2, widest: float) -> None:
    """The popup: errors, then notes, each whole and with its button; all can be dismissed at once."""
    width = min(theme.em(WIDEST_LIST), widest)
    imgui.set_next_window_pos(corner, imgui.Cond_.always, ImVec2(1.0, 0.0))
    area = imgui.get_main_viewport()
    below = area.work_pos.y + area.work_size.y - corner.y - theme.em(0.5)
    highest = max(min(theme.em(HIGHEST_LIST), below), theme.em(6.0))
    imgui.set_next_window_size_constraints(ImVec2(width, 0.0), ImVec2(width, highest))
    imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(theme.em(0.7), theme.em(0.6)))
    shown = imgui.begin_popup(LIST)
    imgui.pop_style_var()
    if not shown:
        return
    close = theme.em(1.8)
    for title, group in (("Errors", notices.errors()), ("Notes", notices.others())):
        if not group:
            continue
        imgui.text_disabled(title)
        for i, notice in enumerate(group):
            _icon(notice)
            imgui.same_line(theme.em(2.2))
            imgui.push_text_wrap_pos(imgui.get_window_width() - close - imgui.get_style().window_padding.x)
            imgui.text_unformatted(notice.text)
            imgui.pop_text_wrap_pos()
            imgui.same_line(imgui.get_window_width() - close - imgui.get_style().scrollbar_size)
            _dismiss(notices, notice, f"###Dismiss {title} {i}")
    imgui.separator()
    if imgui.button("Dismiss all"):
        notices.forget()
    if len(notices) < 2:
        imgui.close_current_popup()
    imgui.end_popup()


def _icon(notice: Notice) -> None:
    ink = theme.colours().warning if notice.kind is NoticeKind.ERROR else theme.colours().dim
    imgui.text_colored(ImVec4(*ink), ICONS[notice.kind])


def _dismiss(notices: Notices, notice: Notice, name: str) -> None:
    if _flat_button(fa.ICON_FA_XMARK + name):
        notices.forget(lambda other: other == notice)
    imgui.set_item_tooltip("Dismiss")


def _flat_button(label: str) -> bool:
    imgui.push_style_color(imgui.Col_.button, ImVec4(0.0, 0.0, 0.0, 0.0))
    clicked = imgui.small_button(label)
    imgui.pop_style_color()
    return clicked
