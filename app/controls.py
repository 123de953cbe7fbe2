"""The left column: what stands before the film, and the rings that turn.

Every control returns other settings; what a new lens cannot do gives way, the
rest is kept.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app import scale, theme
from lensbench.app.reach import (
    SMALLEST_CROP,
    field_of_view,
    full_view,
    with_field_of_view,
    with_film,
    within_reach,
)
from lensbench.app.readings import readings
from lensbench.app.ring import ring
from lensbench.app.settings import MODELS, Settings

DEFAULT = Settings()
RINGS = 5
FILM_SIDES = (0.1, 1000.0)      # mm, of a custom film
PERSPECTIVE_FOV = (math.radians(5.0), math.radians(120.0))
MODEL_TIPS = {
    "trace": "Every ray is refracted at every surface",
    "polynomial": "A polynomial of degree 9, fitted to the real lens as it stands: within a fraction of a pixel, "
                  "in less than half of the time",
    "thin": "An ideal lens of the same focal length and stop: no aberrations, no vignetting",
    "pinhole": "The same view, with everything in focus",
    "perspective": "No prescription: an ideal lens with a field of view of its own",
}


@dataclass
class Chooser:
    """What the lists remember while they are open; and what they ask of the window."""

    search: str = ""
    film: tuple[float, float] = (36.0, 24.0)
    requests: set[str] = field(default_factory=set)         # open lens, open scene


def controls_panel(settings: Settings, chooser: Chooser) -> Settings:
    """Draw the controls into the current window; the settings as they have been set."""
    settings = _lens(settings, chooser)
    settings = _scene(settings, chooser)
    settings = _film(settings, chooser)
    settings = _model(settings)
    # The rings stand as far apart as there is room for
    ring_height = imgui.get_text_line_height() + theme.em(2.6)
    free = imgui.get_content_region_avail().y - RINGS * ring_height - theme.em(0.3)
    gap = min(max(free / (2.0 * RINGS + 1.0), theme.scale()), theme.em(0.45))
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(imgui.get_style().item_spacing.x, gap))
    imgui.dummy(ImVec2(0.0, theme.em(0.3)))
    settings = _rings(settings)
    imgui.pop_style_var()
    return settings


# The lists


def _combo(label: str, value: str, tooltip: str, content: Callable[[], None], width: float = 0.0,
           used: bool = True) -> None:
    """A labelled list: the label dim at the left, a small angle at the right of the value.

    width: the least of the opened list, in em. used: or the value stands dim, too.
    """
    colour = theme.colours()
    imgui.align_text_to_frame_padding()
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour.dim))
    imgui.text_unformatted(label)
    imgui.pop_style_color()
    imgui.same_line(theme.em(3.45) + imgui.get_style().window_padding.x)
    imgui.set_next_item_width(-1.0)
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    if width:
        imgui.set_next_window_size_constraints(ImVec2(theme.em(width), 0.0), ImVec2(theme.em(40.0), theme.em(31.0)))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.text if used else colour.dim)))
    opened = imgui.begin_combo(f"##{label}", _shortened(value, room - theme.em(2.2)),
                               imgui.ComboFlags_.no_arrow_button | imgui.ComboFlags_.height_largest)
    imgui.pop_style_color()
    if opened:
        content()
        imgui.end_combo()
    else:
        imgui.set_item_tooltip(tooltip)
    icon = icons_fontawesome_6.ICON_FA_ANGLE_DOWN
    theme.small()
    size = imgui.calc_text_size(icon)
    imgui.get_window_draw_list().add_text(
        ImVec2(corner.x + room - size.x - theme.em(0.6), corner.y + 0.5 * (imgui.get_frame_height() - size.y)),
        theme.packed(colour.dim), icon)
    imgui.pop_font()


def _shortened(text: str, room: float) -> str:
    """The text with as much of its end left out as does not fit."""
    if imgui.calc_text_size(text).x <= room:
        return text
    while text and imgui.calc_text_size(text + "…").x > room:
        text = text[:-1]
    return text.rstrip() + "…"


@lru_cache(maxsize=1)
def _cards() -> tuple[lenses.Card, ...]:
    """The library, from the widest lens to the longest."""
    return tuple(sorted(lenses.describe(), key=lambda card: (card.efl or math.inf, card.f_number or math.inf)))


def _plain_title(card: lenses.Card) -> str:
    """The title without the focal length and the f-number, which stand in columns of their own."""
    return re.sub(r"(\s+at)?\s+[\d.–]+\s*mm\b|\s+f/[\d.]+", "", card.title).strip(" ,")


def lens_title(name: str) -> str:
    """What a lens is called: the title of a library lens, the name of a file."""
    return next((card.title for card in _cards() if card.name == name), Path(name).stem)


def _lens(settings: Settings, chooser: Chooser) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        if imgui.is_window_appearing():
            chooser.search = ""
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1.0)
        _, chooser.search = imgui.input_text_with_hint("##Search", "Search by name, kind, year or patent",
                                                       chooser.search)
        words = chooser.search.lower().split()
        found = [card for card in _cards() if all(
            word in f"{card.title} {card.kind} {card.year} {card.source} {card.name}".lower() for word in words)]
        height = min(len(found) + 0.3, 19.3) * imgui.get_text_line_height_with_spacing()
        if imgui.begin_child("Lenses", ImVec2(0.0, height)):
            for card in found:
                if _card(card, card.name == settings.lens):
                    chosen = replace(settings, lens=card.name, focal_length=None)
                    imgui.close_current_popup()
        imgui.end_child()
        if not found:
            imgui.text_disabled("No lens of that name")
        imgui.separator()
        if imgui.selectable("Open…", False)[0]:
            chooser.requests.add("open lens")
            imgui.close_current_popup()

    used = settings.model != "perspective"
    tip = "The lens: a design of the library, or a file of your own\nA file can also be dropped on the window"
    _combo("Lens", lens_title(settings.lens), tip if used else f"{tip}\nThe perspective camera has none: a lens that "
           "is chosen here is traced", content, 25.0, used)
    if chosen == settings:
        return settings
    if chosen.model == "perspective":
        chosen = replace(chosen, model="trace")
    return within_reach(chosen)


def _card(card: lenses.Card, selected: bool) -> bool:
    """A line of the list: title, focal length, f-number."""
    clicked = imgui.selectable(f"{_plain_title(card)}###{card.name}", selected)[0]
    if selected and imgui.is_window_appearing():
        imgui.set_scroll_here_y()
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip) and imgui.begin_tooltip():
        imgui.push_text_wrap_pos(theme.em(24.0))
        imgui.text_unformatted(card.title)
        theme.small()
        about = ", ".join(str(part) for part in (card.kind, card.year, card.source) if part)
        imgui.text_disabled(about)
        if card.notes:
            imgui.text_disabled(card.notes)
        imgui.pop_font()
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()
    right = imgui.get_window_width() - theme.em(0.6)
    draw = imgui.get_window_draw_list()
    y = round(0.5 * (imgui.get_item_rect_min().y + imgui.get_item_rect_max().y - imgui.get_text_line_height()))
    left = imgui.get_window_pos().x
    dim = theme.packed(theme.colours().dim)
    f_number = f"f/{card.f_number:.3g}" if card.f_number else ""
    draw.add_text(ImVec2(round(left + right - theme.em(2.6)), y), dim, f_number)
    efl = f"{card.efl:.0f} mm" if card.efl else ""
    draw.add_text(ImVec2(round(left + right - theme.em(3.3) - imgui.calc_text_size(efl).x), y), dim, efl)
    return clicked


def scene_title(name: str) -> str:
    """What a scene is called: the name of a built-in one in words, or of a file."""
    return name.replace("-", " ").capitalize() if name in lb.SCENES else Path(name).stem


def _scene(settings: Settings, chooser: Chooser) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        for name in lb.SCENES:
            if imgui.selectable(scene_title(name), name == settings.scene)[0]:
                # A scene is laid out for a camera at the origin
                chosen = replace(settings, scene=name, position=DEFAULT.position, yaw=DEFAULT.yaw, pitch=DEFAULT.pitch)
        imgui.separator()
        if imgui.selectable("Open…", False)[0]:
            chooser.requests.add("open scene")

    _combo("Scene", scene_title(settings.scene), "What the camera looks at", content)
    return chosen


def film_title(width: float, height: float) -> str:
    """The name of a film format, or its size."""
    for name, size in lb.FORMATS.items():
        if math.isclose(size[0], width) and math.isclose(size[1], height):
            return name
    return f"{width:g} × {height:g} mm"


def _film(settings: Settings, chooser: Chooser) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        if imgui.is_window_appearing():
            chooser.film = (settings.film_width, settings.film_height)
        for name, (width, height) in lb.FORMATS.items():
            if imgui.selectable(name, name == film_title(settings.film_width, settings.film_height))[0]:
                chosen = with_film(settings, width, height)
        imgui.separator()
        imgui.align_text_to_frame_padding()
        imgui.text_disabled("Custom")
        imgui.same_line()
        width, height = chooser.film
        imgui.set_next_item_width(theme.em(3.6))
        _, width = imgui.input_double("×##Film width", width, 0.0, 0.0, "%.4g")
        imgui.same_line()
        imgui.set_next_item_width(theme.em(3.6))
        _, height = imgui.input_double("mm##Film height", height, 0.0, 0.0, "%.4g")
        chooser.film = (width, height)
        imgui.same_line()
        possible = all(FILM_SIDES[0] <= side <= FILM_SIDES[1] for side in (width, height))
        imgui.begin_disabled(not possible)
        if imgui.button("Set"):
            chosen = with_film(settings, width, height)
            imgui.close_current_popup()
        imgui.end_disabled()
        if not possible:
            imgui.text_colored(imgui.ImVec4(*theme.colours().warning),
                               f"A side measures {FILM_SIDES[0]:g} to {FILM_SIDES[1]:g} mm")

    _combo("Film", film_title(settings.film_width, settings.film_height), "The film's size", content)
    return chosen if chosen == settings else within_reach(chosen)


def _model(settings: Settings) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        for key, name in MODELS.items():
            if imgui.selectable(name, key == settings.model)[0]:
                chosen = replace(settings, model=key)
            imgui.set_item_tooltip(MODEL_TIPS[key])

    _combo("Model", MODELS[settings.model], "How the camera forms the picture", content)
    return chosen if chosen == settings else within_reach(chosen)


# The rings


def _rings(settings: Settings) -> Settings:
    figures = readings(settings)

    # Focus
    nearest = figures.nearest_focus if figures.nearest_focus is not None else full_view(settings)[1]
    zone = None
    if figures.near_limit is not None and figures.far_limit is not None:
        zone = (figures.near_limit, figures.far_limit if figures.far_limit > 0.0 else math.inf)
    distance = ring("Focus distance", settings.focus_distance,
                    scale.focus_scale(nearest * 1.0001, max(DEFAULT.focus_distance, nearest * 1.0001)),
                    "Distance from the film to what is in focus, s; the amber zone is the depth of field", zone)
    settings = replace(settings, focus_distance=distance)

    # Aperture: wide open is where the ring ends
    widest = figures.widest_f_number or 1.0
    shown = settings.f_number if settings.f_number is not None else widest
    f_number = ring("Aperture", shown, scale.aperture_scale(widest, max(DEFAULT.f_number or widest, widest)),
                    "f-number N: focal length over the diameter of the entrance pupil")
    if f_number != shown:
        settings = replace(settings, f_number=None if f_number <= widest and settings.model != "perspective"
                           else f_number)

    # Field of view and focal length
    view, efl = full_view(settings)
    if settings.model == "perspective":
        fov_scale = scale.fov_scale(*PERSPECTIVE_FOV, DEFAULT.fov)
        tip = "Field of view along the shorter side"
    else:
        fov_scale = scale.fov_scale(2.0 * math.atan(SMALLEST_CROP * math.tan(0.5 * view)), view, view)
        tip = "Field of view along the shorter side: a smaller one uses less of the film"
    fov = field_of_view(settings)
    turned = ring("Field of view", fov, fov_scale, tip)
    if turned != fov:
        settings = with_field_of_view(settings, turned)
        if settings.model == "perspective":         # whose focal length follows
            settings = within_reach(settings)
    if settings.model != "perspective":
        designed = readings(replace(settings, focal_length=None)).efl or efl
        length = ring("Focal length", efl, _focal_lengths(designed),
                      "Focal length f: scales the whole prescription, stop and rims included")
        if length != efl:
            scaled = None if math.isclose(length, designed, rel_tol=1e-9) else length
            settings = within_reach(replace(settings, focal_length=scaled))

    exposure = ring("Exposure", settings.exposure, scale.exposure_scale(),
                    "Stops by which the picture is brightened; the stop itself does not change its brightness")
    return replace(settings, exposure=exposure)


def _focal_lengths(designed: float) -> scale.Scale:
    """A ring of two octaves and a half to either side of what the lens was designed for."""
    return scale.focal_length_scale(designed / 6.0, designed * 6.0, designed)
