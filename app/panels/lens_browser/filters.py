"""The head of the lens browser: search, parts, filters and order."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from imgui_bundle import icons_fontawesome_6, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import picked, toggles
from lensbench.app.session.lens_shelf import ANY, ERAS, FORMATS, LENGTHS, ORDERS, SPEEDS, Shelf, kinds, makers
from lensbench.lenses import Card

fa = icons_fontawesome_6
PARTS = {"all": "All", "favourites": fa.ICON_FA_STAR, "recent": "Recent"}
PART_TIPS = {"all": "The whole library", "favourites": "Favourites: the lenses with a star",
             "recent": "The lenses that were used last, the newest first"}


def search(shelf: Shelf, focus: bool) -> Shelf:
    """Draw the search and the parts; the changed shelf. focus: text is typed there from now on."""
    parts = theme.em(8.4)
    if focus:
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(imgui.get_content_region_avail().x - parts)
    _, text = imgui.input_text_with_hint("##Search lenses", "Search name, maker, kind, patent, year", shelf.search,
                                         imgui.InputTextFlags_.auto_select_all)
    imgui.same_line(0.0, theme.em(0.4))
    part = toggles("Lenses", PARTS, shelf.part, PART_TIPS, indent=0.0)
    return replace(shelf, search=text, part=part)


def filters(shelf: Shelf, cards: Sequence[Card], shown: int) -> Shelf:
    """Draw the filters, the order and the number of lenses shown."""
    gap = theme.em(0.35)
    width = (imgui.get_content_region_avail().x - 5.0 * gap) / 6.0
    changed: dict[str, Any] = {}
    choices = (("kind", "Kind", kinds(cards), "The kind of design"),
               ("era", "Era", list(ERAS), "The year of the design"),
               ("maker", "Maker", makers(cards), "Who sold the lens, else whose patent it is"),
               ("length", "Length", list(LENGTHS), "Focal length; a zoom where its range meets this one"),
               ("speed", "Speed", list(SPEEDS), "The f-number wide open"),
               ("film", "Format", list(FORMATS), "The film that the lens was made for"))
    for i, (name, label, values, tip) in enumerate(choices):
        if i:
            imgui.same_line(0.0, gap)
        value = getattr(shelf, name)
        changed[name] = picked(label, value, {ANY: "Any"} | {text: text for text in values}, tip, width,
                               text=value or label, colour=theme.colours().strong if value else theme.colours().dim)

    changed["zooms"] = _toggle("Zoom", shelf.zooms, "Zoom lenses only")
    imgui.same_line(0.0, gap)
    changed["aspheric"] = _toggle("Asphere", shelf.aspheric, "Lenses with an aspheric surface only")
    imgui.same_line(0.0, theme.em(1.0))
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Sort")
    imgui.same_line(0.0, theme.em(0.5))
    names = {key: title for key, (title, _) in ORDERS.items()}
    changed["order"] = picked("Sort", shelf.order, names, "The order; a search sorts by relevance", theme.em(8.0))
    shelf = replace(shelf, **changed)
    if shelf.is_filtered:
        imgui.same_line(0.0, gap)
        if imgui.button("Clear"):
            shelf = shelf.without_filters()
        imgui.set_item_tooltip("Remove all filters")
    count = f"{shown} of {len(cards)}"
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(count).x)
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(count)
    return shelf


def _toggle(label: str, on: bool, tip: str) -> bool:
    colour = theme.colours()
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame_active if on else colour.frame)))
    clicked = imgui.button(label)
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tip)
    return on != clicked
