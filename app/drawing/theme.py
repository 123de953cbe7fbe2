"""Colours, sizes and the font of the window, dark and light.

The greys are neutral so that nothing around a picture tints it; amber means
*in focus*, everywhere and only. Colours are (red, green, blue, alpha) from 0 to
1, lengths are in units of the font's size (`em`) so that they follow the
screen's scale.
"""

from dataclasses import dataclass
from functools import lru_cache

from imgui_bundle import ImVec2, ImVec4, hello_imgui, imgui, implot

Colour = tuple[float, float, float, float]

FONT_SIZE = 15.0            # pixels at a scale of 1
SMALL = 0.855               # of small text, relative to FONT_SIZE


def _grey_or_colour(code: str, alpha: float = 1.0) -> Colour:
    return int(code[0:2], 16) / 255.0, int(code[2:4], 16) / 255.0, int(code[4:6], 16) / 255.0, alpha


@dataclass(frozen=True)
class Palette:
    """One theme: every colour that a panel may use, by its purpose."""

    dark: bool
    ground: Colour              # menu, tab bar, the surround of the picture
    panel: Colour
    well: Colour                # behind plots
    frame: Colour
    frame_hovered: Colour
    frame_active: Colour
    splitter: Colour
    popup: Colour
    text: Colour
    dim: Colour
    faint: Colour               # for lines only
    strong: Colour
    amber: Colour               # lines in focus
    amber_text: Colour
    field0: Colour              # axis, 0.7 field, full field
    field1: Colour
    field2: Colour
    field0_text: Colour
    field1_text: Colour
    field2_text: Colour
    dead: Colour                # rays that do not reach the film
    glass_outline: Colour
    grid: Colour
    warning: Colour             # text of an error

    def glass(self, n_d: float, v_d: float) -> Colour:
        """The fill of a lens element: the denser the deeper, the more dispersive the warmer."""
        t = min(max((n_d - 1.45) / 0.45, 0.0), 1.0)
        if self.dark:
            light, deep, alpha = (0.60, 0.74, 0.86), (0.30, 0.52, 0.78), 0.20 + 0.26 * t
        else:
            light, deep, alpha = (0.62, 0.76, 0.90), (0.33, 0.55, 0.82), 0.42 + 0.33 * t
        flint = 0.62 * min(max((46.0 - v_d) / 26.0, 0.0), 1.0)
        red, green, blue = ((1.0 - flint) * ((1.0 - t) * a + t * b) + flint * warm
                            for a, b, warm in zip(light, deep, (0.78, 0.66, 0.55), strict=True))
        return red, green, blue, alpha


_c = _grey_or_colour

DARK = Palette(
    dark=True, ground=_c("1c1c1c"), panel=_c("242424"), well=_c("1e1e1e"),
    frame=_c("333333"), frame_hovered=_c("3d3d3d"), frame_active=_c("474747"), splitter=_c("161616"),
    popup=_c("2b2b2b"),
    text=_c("d6d6d6"), dim=_c("969696"), faint=_c("6e6e6e"), strong=_c("f2f2f2"),
    amber=_c("e8a33d"), amber_text=_c("f0b357"),
    field0=_c("56b4e9"), field1=_c("009e73"), field2=_c("d55e00"),
    field0_text=_c("56b4e9"), field1_text=_c("22b98d"), field2_text=_c("ee7a24"),
    dead=_c("8a8a8a"), glass_outline=_c("a9bccb"), grid=(1.0, 1.0, 1.0, 0.085), warning=_c("ff9d8a"),
)

LIGHT = Palette(
    dark=False, ground=_c("c6c6c6"), panel=_c("dedede"), well=_c("e8e8e8"),
    frame=_c("cccccc"), frame_hovered=_c("c0c0c0"), frame_active=_c("b4b4b4"), splitter=_c("b4b4b4"),
    popup=_c("ececec"),
    text=_c("262626"), dim=_c("5a5a5a"), faint=_c("8a8a8a"), strong=_c("0c0c0c"),
    amber=_c("b36b00"), amber_text=_c("8a5200"),
    field0=_c("0072b2"), field1=_c("007f5c"), field2=_c("c25200"),
    field0_text=_c("0072b2"), field1_text=_c("00694c"), field2_text=_c("a84700"),
    dead=_c("7a7a7a"), glass_outline=_c("5b7386"), grid=(0.0, 0.0, 0.0, 0.10), warning=_c("a01c00"),
)

# For the curves of a chart, distinct also for the colour-blind, in the order of the charts in files; without amber
_TINTS = {True: tuple(map(_c, ("ee7a24", "cc79a7", "56b4e9", "22b98d", "b9b53a", "a3d4f2", "f2f2f2", "969696"))),
          False: tuple(map(_c, ("c25200", "a34d7d", "0072b2", "007f5c", "6d6a10", "2f8cc0", "0c0c0c", "6e6e6e")))}

# Over the picture, in either theme: nearer and farther than the focus
NEARER, FARTHER = DARK.field0, _c("cc79a7")

def palette(dark: bool) -> Palette:
    """The palette of a theme."""
    return DARK if dark else LIGHT


def colours() -> Palette:
    """The palette of the theme in use: of the window's imgui style, which alone remembers it."""
    return palette(imgui.get_style().color_(imgui.Col_.text).x > 0.5)


def compared() -> Colour:
    """The colour of A in the panels of B: ghosted curves, outlines and figures."""
    return tints()[4]


def pointed() -> Colour:
    """The colour of the one ray that the mouse points at, in every panel."""
    return tints()[1]


def tints() -> tuple[Colour, ...]:
    """Eight colours for the curves of a chart."""
    return _TINTS[colours().dark]


def choose(dark: bool) -> None:
    """Restyle the open window, dark or light."""
    colour_imgui(palette(dark))
    if implot.get_current_context() is not None:
        colour_implot()


def em(x: float) -> float:
    """A length in em, in pixels of this screen."""
    return x * imgui.get_font_size()


def scale() -> float:
    """The scale of this screen, or the one that was chosen: for line weights and pixel lengths in draw lists."""
    return hello_imgui.dpi_window_size_factor() * imgui.get_style().font_scale_main


def choose_scale(factor: float, dark: bool) -> None:
    """Draw the open window this many times as large as on a screen of 96 dpi; 0: as its screen asks for."""
    style = imgui.get_style()
    style.font_scale_main = factor / hello_imgui.dpi_window_size_factor() if factor else 1.0
    style_imgui(dark)
    style.scale_all_sizes(hello_imgui.dpi_window_size_factor())
    style_implot()


def look() -> tuple[bool, float, float]:
    """What every drawing depends on: whether the theme is dark, the scale of the screen, and the size of the font."""
    return colours().dark, scale(), imgui.get_font_size()


@lru_cache(maxsize=1024)
def packed(colour: Colour, alpha: float = 1.0) -> int:
    """A colour for draw lists, with its alpha multiplied."""
    parts = (*colour[:3], colour[3] * alpha)
    red, green, blue, opacity = (int(min(max(channel, 0.0), 1.0) * 255.0 + 0.5) for channel in parts)
    return red | green << 8 | blue << 16 | opacity << 24


def shortened(text: str, room: float) -> str:
    """The text, cut at its end if it does not fit."""
    if imgui.calc_text_size(text).x <= room:
        return text
    while text and imgui.calc_text_size(text + "…").x > room:
        text = text[:-1]
    return text.rstrip() + "…"


def small() -> None:
    """Begin small text; end it with imgui.pop_font(). Around a plot, not inside."""
    imgui.push_font(None, imgui.get_style().font_size_base * SMALL)


def load_font() -> None:
    """Roboto with the icons of Font Awesome 6, and Inconsolata for what both lack, such as ⁶ and ₂; imgui has all."""
    parameters = hello_imgui.FontLoadingParams()
    hello_imgui.load_font("fonts/Roboto/Roboto-Regular.ttf", FONT_SIZE, parameters)
    for name in ("Font_Awesome_6_Free-Solid-900.otf", "Inconsolata-Medium.ttf"):
        added = hello_imgui.FontLoadingParams()
        added.merge_to_last_font = True
        hello_imgui.load_font(f"fonts/{name}", FONT_SIZE, added)


def style_imgui(dark: bool) -> None:
    """Sizes, at the scale that was chosen, and colours of imgui; hello_imgui scales them to the screen afterwards."""
    style = imgui.get_style()
    style.window_padding = ImVec2(10, 8)
    style.frame_padding = ImVec2(7, 3)
    style.item_spacing = ImVec2(8, 5)
    style.item_inner_spacing = ImVec2(6, 4)
    style.cell_padding = ImVec2(4, 2)
    style.scrollbar_size = 10
    style.window_rounding = style.child_rounding = 0
    style.frame_rounding = style.tab_rounding = style.grab_rounding = 3
    style.popup_rounding = 4
    style.scrollbar_rounding = 3
    style.window_border_size = style.child_border_size = style.frame_border_size = 0
    style.popup_border_size = 1
    style.tab_border_size = style.tab_bar_border_size = style.tab_bar_overline_size = 0
    style.docking_separator_size = 3
    style.separator_text_border_size = 1
    style.hover_delay_normal = style.hover_delay_short = 0.45
    style.hover_stationary_delay = 0.0
    style.window_menu_button_position = imgui.Dir.none
    style.disabled_alpha = 0.45
    style.anti_aliased_lines = style.anti_aliased_fill = True
    style.scale_all_sizes(style.font_scale_main)
    colour_imgui(palette(dark))


def colour_imgui(c: Palette) -> None:
    """The colours of imgui's own items.

    A window has no ground of its own: the screen is cleared to the colour of the panels, which costs a processor that
    draws less than to fill them again and again. What floats above others has to fill itself.
    """
    style, col = imgui.get_style(), imgui.Col_
    clear: Colour = (0.0, 0.0, 0.0, 0.0)
    veil = (0.0, 0.0, 0.0, 0.45) if c.dark else (0.0, 0.0, 0.0, 0.25)
    table = {
        col.text: c.text, col.text_disabled: c.dim, col.window_bg: clear, col.child_bg: clear, col.popup_bg: c.popup,
        col.border: c.splitter, col.border_shadow: clear,
        col.frame_bg: c.frame, col.frame_bg_hovered: c.frame_hovered, col.frame_bg_active: c.frame_active,
        col.title_bg: c.ground, col.title_bg_active: c.ground, col.title_bg_collapsed: c.ground,
        col.menu_bar_bg: c.ground,
        col.scrollbar_bg: clear, col.scrollbar_grab: c.frame_hovered,
        col.scrollbar_grab_hovered: c.frame_active, col.scrollbar_grab_active: c.faint,
        col.check_mark: c.strong, col.checkbox_selected_bg: c.frame_active,
        col.slider_grab: c.dim, col.slider_grab_active: c.strong,
        col.button: c.frame, col.button_hovered: c.frame_hovered, col.button_active: c.frame_active,
        col.header: c.frame, col.header_hovered: c.frame_hovered, col.header_active: c.frame_active,
        col.separator: c.frame_hovered, col.separator_hovered: c.faint, col.separator_active: c.dim,
        col.resize_grip: clear, col.resize_grip_hovered: c.faint, col.resize_grip_active: c.dim,
        col.input_text_cursor: c.strong,
        col.tab: c.ground, col.tab_hovered: c.frame_hovered, col.tab_selected: c.panel,
        col.tab_selected_overline: clear,
        col.tab_dimmed: c.ground, col.tab_dimmed_selected: c.panel, col.tab_dimmed_selected_overline: clear,
        col.docking_preview: (*c.dim[:3], 0.4), col.docking_empty_bg: c.ground,
        col.plot_lines: c.text, col.plot_lines_hovered: c.strong, col.plot_histogram: c.dim,
        col.plot_histogram_hovered: c.text,
        col.table_header_bg: c.frame, col.table_border_strong: c.frame, col.table_border_light: c.frame,
        col.table_row_bg: clear, col.table_row_bg_alt: clear,
        col.text_link: c.strong, col.text_selected_bg: (*c.dim[:3], 0.4), col.tree_lines: c.faint,
        col.drag_drop_target: c.dim, col.drag_drop_target_bg: clear, col.unsaved_marker: c.dim,
        col.nav_cursor: c.dim, col.nav_windowing_highlight: c.dim,
        col.nav_windowing_dim_bg: veil, col.modal_window_dim_bg: veil,
    }
    for index, colour in table.items():
        style.set_color_(index, ImVec4(*colour))
    if hello_imgui.is_using_hello_imgui():
        hello_imgui.get_runner_params().imgui_window_params.background_color = ImVec4(*c.panel)


def style_implot() -> None:
    """Sizes and colours of implot, at the scale in use."""
    style, pixel = implot.get_style(), scale()
    style.plot_border_size = 0
    style.major_tick_len = style.minor_tick_len = ImVec2(0, 0)
    style.major_grid_size = style.minor_grid_size = ImVec2(pixel, pixel)
    style.minor_alpha = 0.45
    style.plot_padding = ImVec2(2 * pixel, 4 * pixel)
    style.label_padding = ImVec2(4 * pixel, 3 * pixel)
    style.plot_min_size = ImVec2(40 * pixel, 40 * pixel)
    colour_implot()


def colour_implot() -> None:
    """The colours of plots."""
    c, style = colours(), implot.get_style()
    col = implot.Col_
    clear: Colour = (0.0, 0.0, 0.0, 0.0)
    table = {
        col.frame_bg: clear, col.plot_bg: c.well, col.plot_border: clear,
        col.legend_bg: c.popup, col.legend_border: clear, col.legend_text: c.text, col.title_text: c.text,
        col.inlay_text: c.text, col.axis_text: c.dim, col.axis_grid: c.grid, col.axis_tick: c.grid,
        col.axis_bg: clear, col.axis_bg_hovered: clear, col.axis_bg_active: clear,
        col.selection: c.dim, col.crosshairs: c.faint,
    }
    for index, colour in table.items():
        style.set_color_(index, ImVec4(*colour))
