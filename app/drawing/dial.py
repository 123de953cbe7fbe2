"""The dial, an engraved scale: one widget for focus, aperture, exposure and every other continuous setting.

A drag turns it continuously (with Shift at a tenth of the speed), a click and the
wheel go to the engraved stops if the scale has them, ctrl-click or Enter takes a
typed value, a double click resets. The widget is one imgui item named by its label.

One dial of a window may have the keyboard: Tab and the arrows up and down pass it on, the arrows left and right turn it
(with Shift at a tenth of the step, Page Up and Down by a full stop), Escape and any click let go.
"""

import math
from contextvars import ContextVar
from dataclasses import dataclass, field, replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import beside
from lensbench.app.drawing.recorded import Recorded
from lensbench.app.settings.dial_scales import Scale, figures_that_fit

DRAG_THRESHOLD = 3.0            # pixels at a scale of 1, before a press becomes a drag
GRAB = 7.0                      # pixels at a scale of 1: closer to the index line a press does not move it
FINE = 0.1                      # of the mouse's movement, or of a step, with Shift
STOP = 3                        # steps of Page Up and Down: third stops


@dataclass(frozen=True)
class Grip:
    """A press on a dial: the last x of the mouse (pixels), the dial's u under it, and whether it has moved."""

    item: int
    u: float
    x: float
    start: float
    dragged: bool = False
    jumped: bool = False


@dataclass(frozen=True)
class Entry:
    """The text that a user types into a dial."""

    item: int
    text: str
    fresh: bool = True
    error: str = ""


@dataclass
class DialState:
    """State of the dials of one window: the press, the text entry, and the engraved scales by dial."""

    grip: Grip | None = None
    entry: Entry | None = None
    known: int = 0              # the dial that was turned while the mouse is on it: it shows no tooltip
    keyed: int = 0              # the dial that has the keyboard
    scrolls: bool = False       # and whether it is to be brought into sight
    drawn: list[int] = field(default_factory=list)      # the dials of this frame, and of the one before
    order: list[int] = field(default_factory=list)
    engravings: dict[int, Recorded] = field(default_factory=dict)

    def take_keyboard(self) -> None:
        """Give the keyboard to the first dial, or take it from the one that has it."""
        self.keyed, self.scrolls = 0 if self.keyed else next(iter(self.order), 0), True
        if self.keyed:
            imgui.set_window_focus(None)

    def steer(self) -> bool:
        """Pass the keyboard on, before the dials of a frame; whether one of them has it in this frame."""
        self.order, self.drawn = self.drawn, []
        if self.keyed not in self.order or any(imgui.is_mouse_clicked(button) for button in range(3)):
            self.keyed = 0
        if not self.keyed or self.entry is not None or imgui.is_popup_open("", imgui.PopupFlags_.any_popup):
            return bool(self.keyed)
        key, io, pressed = imgui.Key, imgui.get_io(), imgui.is_key_pressed
        if pressed(key.escape):
            self.keyed = 0
            return True
        tab = pressed(key.tab) and not io.key_ctrl
        step = (int(pressed(key.down_arrow) or tab and not io.key_shift)
                - int(pressed(key.up_arrow) or tab and io.key_shift))
        if step:
            self.keyed = self.order[(self.order.index(self.keyed) + step) % len(self.order)]
            self.scrolls = True
        return True


# Current like imgui's context: each window sets its state before it draws
_state: ContextVar[DialState] = ContextVar("dials")


def use_dials(state: DialState) -> None:
    """Draw the dials with this state from now on; call it for each window before the first dial."""
    _state.set(state)


def dial(label: str, value: float, scale: Scale, tooltip: str = "", zone: tuple[float, float] | None = None
         ) -> float:
    """Draw the dial over the rest of the row and return its value, changed or not.

    zone: the nearest and farthest value in focus, drawn as an amber zone.
    """
    state = _state.get()
    imgui.push_id(label)
    pixel = theme.scale()
    width = max(imgui.get_content_region_avail().x, 8.0 * pixel)
    corner = imgui.get_cursor_screen_pos()
    line, bar = imgui.get_text_line_height(), ImVec2(width, round(theme.em(2.2)))
    top = corner.y + line + round(theme.em(0.2))
    margin = min(round(theme.em(0.72)), 0.2 * width)        # from the bar's ends to u = 0 and 1
    item = imgui.get_id(label)

    # The bar is the item; the line above it holds the label, and the value or its entry
    imgui.set_cursor_screen_pos(ImVec2(corner.x, top))
    imgui.invisible_button(label, bar, imgui.ButtonFlags_.enable_nav)
    hovered = imgui.is_item_hovered()
    focused = state.keyed == item or imgui.is_item_focused() and imgui.get_io().nav_visible
    state.drawn.append(item)
    if state.keyed == item and state.scrolls:
        imgui.set_scroll_here_y()
        state.scrolls = False
    value = _turned(state, item, value, scale, corner.x + margin, max(width - 2.0 * margin, 1.0))
    value = _keyed(state, item, value, scale, focused)
    active = imgui.is_item_active()
    if active:
        state.known = item
    elif not hovered and state.known == item:
        state.known = 0
    silent = state.known == item or state.entry is not None
    if tooltip and not silent and imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        _explain(tooltip, scale)
    after = imgui.get_cursor_screen_pos()

    text_at = ImVec2(corner.x, corner.y)
    draw, colour = imgui.get_window_draw_list(), theme.colours()
    draw.add_text(text_at, theme.packed(colour.dim), label)
    _draw_bar(state, item, draw, ImVec2(corner.x, top), bar, margin, value, scale, zone, hovered or active, focused)
    if state.entry is not None and state.entry.item == item:
        value = _typed(state, value, scale, corner, width)
    else:
        text = scale.format(value)
        strong = colour.amber_text if scale.amber else colour.strong
        draw.add_text(ImVec2(corner.x + width - imgui.calc_text_size(text).x, corner.y), theme.packed(strong), text)

    imgui.set_cursor_screen_pos(ImVec2(corner.x, after.y))
    imgui.dummy(ImVec2(width, round(theme.em(0.2))))
    imgui.pop_id()
    return value


def _explain(tooltip: str, scale: Scale) -> None:
    lines = ["Drag to turn, Shift for fine steps, Ctrl-click to type"]
    if scale.snaps:
        lines[0] = "Click or wheel for the engraved stops, drag for any value, Ctrl-click to type"
    if scale.reset is not None:
        lines.append(f"Double click: back to {scale.format(scale.reset)}")
    beside([tooltip, *lines], 24.0)
    if imgui.begin_tooltip():
        imgui.push_text_wrap_pos(theme.em(24))
        imgui.text_unformatted(tooltip)
        theme.small()
        for text in lines:
            imgui.text_disabled(text)
        imgui.pop_font()
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def _turned(state: DialState, item: int, value: float, scale: Scale, left: float, length: float) -> float:
    """The value after this frame's mouse, on the item just submitted."""
    io, pixel = imgui.get_io(), theme.scale()
    mouse = imgui.get_mouse_pos().x
    under = (mouse - left) / length

    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        state.grip = None
        return value if scale.reset is None or io.key_ctrl else scale.reset
    if imgui.is_item_activated() and imgui.is_mouse_clicked(imgui.MouseButton_.left):
        if io.key_ctrl:
            state.entry = Entry(item, _plain(scale.format(value)))
            return value
        on_index = abs(scale.to_unit(value) - under) * length <= GRAB * pixel
        state.grip = Grip(item, scale.to_unit(value) if on_index else under, mouse, mouse, jumped=not on_index)
        return value if on_index else scale.snapped(scale.from_unit(under))

    grip = state.grip
    if grip is not None and grip.item == item:
        # The frame of the release may bring the last movement too; a mouse that left the window has no position
        dragged = imgui.is_mouse_pos_valid() and (grip.dragged or abs(mouse - grip.start) >= DRAG_THRESHOLD * pixel)
        if dragged and (mouse != grip.x or not grip.dragged):
            u = grip.u + (mouse - grip.x) / length * (FINE if io.key_shift else 1.0)
            grip = state.grip = replace(grip, u=u, x=mouse, dragged=True)
            value = scale.from_unit(u)
        if not imgui.is_item_active():
            state.grip = None
            if not grip.dragged and not grip.jumped and scale.snaps:
                return scale.snapped(scale.from_unit(under))
        return value

    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel != 0.0:
            return scale.stepped(value, int(math.copysign(max(1.0, abs(io.mouse_wheel)), io.mouse_wheel)))
    return value


def _keyed(state: DialState, item: int, value: float, scale: Scale, focused: bool) -> float:
    """The value after this frame's keys, while the dial has the keyboard focus."""
    if not focused or state.entry is not None:
        return value
    keys, fine = imgui.Key, imgui.get_io().key_shift
    for key, step in ((keys.left_arrow, -1), (keys.right_arrow, 1), (keys.page_down, -STOP), (keys.page_up, STOP)):
        imgui.internal.set_key_owner(key, item)
        if imgui.internal.is_key_pressed(key, imgui.InputFlags_.repeat, item):
            return scale.finely(value, FINE * step) if fine else scale.stepped(value, step)
    if imgui.is_key_pressed(imgui.Key.enter, False):
        state.entry = Entry(item, _plain(scale.format(value)))
    return value


def _plain(text: str) -> str:
    return text.replace("−", "-").replace("∞", "inf")


def _typed(state: DialState, value: float, scale: Scale, corner: ImVec2, width: float) -> float:
    """The text entry over the value. Enter sets the value, Escape or a click elsewhere cancels."""
    entry = state.entry
    assert entry is not None
    field = min(theme.em(7.0), width)
    padding = imgui.get_style().frame_padding
    imgui.set_cursor_screen_pos(ImVec2(corner.x + width - field, corner.y - padding.y))
    imgui.set_next_item_width(field)
    if entry.fresh:
        imgui.set_keyboard_focus_here()
    flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
    entered, text = imgui.input_text("##entry", entry.text, flags)
    state.entry = replace(entry, text=text, fresh=False, error="" if text != entry.text else entry.error)
    if entered:
        try:
            if text.strip() != _plain(scale.format(value)):         # which is rounded
                value = scale.parse(text)
            state.entry = None
        except ValueError as error:
            state.entry = Entry(entry.item, text, True, str(error))
    elif not entry.fresh and imgui.is_item_deactivated():
        state.entry = None
    if state.entry is not None and state.entry.error:
        _complain(state.entry.error, corner)
    return value


def _complain(error: str, corner: ImVec2) -> None:
    """The error of a typed value, over the dial and over every tooltip; within the window."""
    pad, wrap = theme.em(0.55), theme.em(24.0)
    size = imgui.calc_text_size(error, wrap_width=wrap)
    viewport = imgui.get_main_viewport()
    x = min(corner.x, viewport.pos.x + viewport.size.x - size.x - 2.0 * pad)
    y = max(corner.y - size.y - 2.0 * pad - theme.em(0.4), viewport.pos.y)
    draw, colour = imgui.get_foreground_draw_list(), theme.colours()
    upper, lower = ImVec2(x, y), ImVec2(x + size.x + 2.0 * pad, y + size.y + 2.0 * pad)
    draw.add_rect_filled(upper, lower, theme.packed(colour.popup), 4.0 * theme.scale())
    draw.add_rect(upper, lower, theme.packed(colour.warning), 4.0 * theme.scale())
    draw.add_text(imgui.get_font(), imgui.get_font_size(), ImVec2(x + pad, y + pad), theme.packed(colour.warning),
                  error, wrap_width=wrap)


def _fitting(scale: Scale, length: float, font_size: float) -> tuple[tuple[float, str], ...]:
    """The figures that do not touch, measured in the current font."""
    widths = tuple(imgui.calc_text_size(text).x for _, text in scale.figures)
    return figures_that_fit(scale, length, widths, 0.3 * font_size)


def _ticks(scale: Scale, left: float, length: float, apart: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Whole pixels of the long ticks, which may have figures, and of the short ones, `apart` from all others."""
    def column(of: float) -> float:
        return math.floor(left + scale.to_unit(of) * length)

    long = [column(figure) for figure, _ in scale.figures]
    taken = list(long)
    for minor in scale.minor:
        x = column(minor)
        if all(abs(x - other) >= apart for other in taken):
            taken.append(x)
    return tuple(long), tuple(taken[len(long):])


def _engrave(draw: imgui.ImDrawList, corner: ImVec2, size: ImVec2, margin: float, scale: Scale) -> None:
    """Ticks and figures, in the current font."""
    colour, pixel, end = theme.colours(), theme.scale(), ImVec2(corner.x + size.x, corner.y + size.y)
    left, length, apart = corner.x + margin, max(size.x - 2.0 * margin, 1.0), 3.5 * pixel
    weight = _weight(pixel)
    long, short = _ticks(scale, left, length, apart)
    for ticks, height, ink in ((long, 0.265, colour.text), (short, 0.15, colour.dim)):
        bottom, ink_packed = corner.y + round(height * size.y), theme.packed(ink, 0.85)
        for x in ticks:
            draw.add_rect_filled(ImVec2(x, corner.y), ImVec2(x + weight, bottom), ink_packed)
    for figure, text in _fitting(scale, length, imgui.get_font_size()):
        extent = imgui.calc_text_size(text)
        x = math.floor(left + scale.to_unit(figure) * length)
        x = min(max(x + 0.5 * weight - 0.5 * extent.x, corner.x + 2.0 * pixel), end.x - extent.x - 2.0 * pixel)
        draw.add_text(ImVec2(math.floor(x + 0.5), math.floor(end.y - extent.y - 0.09 * size.y)),
                      theme.packed(colour.text, 0.9), text)


def _weight(pixel: float) -> float:
    """Of ticks, in whole pixels: a tick on half a pixel is grey."""
    return max(1.0, math.floor(pixel))


def _draw_bar(state: DialState, item: int, draw: imgui.ImDrawList, corner: ImVec2, size: ImVec2, margin: float,
              value: float, scale: Scale, zone: tuple[float, float] | None, lit: bool, focused: bool) -> None:
    """Background, zone, ticks, figures, and the triangle with its index line."""
    colour, pixel = theme.colours(), theme.scale()
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    length = max(size.x - 2.0 * margin, 1.0)
    rounding = imgui.get_style().frame_rounding
    weight = _weight(pixel)

    def column(of: float) -> float:
        return math.floor(corner.x + margin + scale.to_unit(of) * length)

    draw.add_rect_filled(corner, end, theme.packed(colour.frame_hovered if lit else colour.frame), rounding)
    if focused:
        draw.add_rect(ImVec2(corner.x - pixel, corner.y - pixel), ImVec2(end.x + pixel, end.y + pixel),
                      theme.packed(colour.strong), rounding, 1.5 * pixel)
    if zone is not None:
        near, far = (min(max(edge, scale.low), scale.high) for edge in zone)
        near_x, far_x = column(near), column(far)
        middle, half = 0.5 * (near_x + far_x), max(0.5 * (far_x - near_x), 1.5 * pixel)
        draw.add_rect_filled(ImVec2(middle - half, corner.y), ImVec2(middle + half, end.y),
                             theme.packed(colour.amber, 0.32))

    theme.small()
    engraving = state.engravings.setdefault(item, Recorded())
    engraving.draw(draw, (scale, corner.x, corner.y, size.x, size.y, margin),
                   lambda into: _engrave(into, corner, size, margin, scale))
    imgui.pop_font()

    # The triangle hangs from the upper edge, with the index line below it
    mark = theme.packed(colour.amber if scale.amber else colour.strong)
    x, half, depth = column(value) + 0.5 * weight, 5.0 * pixel, 7.0 * pixel
    y = corner.y - pixel
    line = max(2.0, round(2.0 * pixel)) if weight > 1.0 else 2.0
    index = math.floor(x - 0.5 * line + 0.5)
    draw.add_rect_filled(ImVec2(index, y + 0.5 * depth), ImVec2(index + line, corner.y + round(0.5 * size.y)), mark)
    x = index + 0.5 * line
    draw.add_triangle_filled(ImVec2(x - half, y), ImVec2(x + half, y), ImVec2(x, y + depth), mark)
