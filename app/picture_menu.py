"""How large the picture is, how many samples it gets, and how it is developed: a menu of the render's tools."""

from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app import theme
from lensbench.app.reach import with_longer_side
from lensbench.app.settings import TONES, Settings

LONGER_SIDES = (480, 640, 960, 1280, 1920, 2880)
SAMPLES = (16, 64, 256, 1024, 4096)
KEEP = imgui.SelectableFlags_.no_auto_close_popups


def picture_menu(settings: Settings) -> Settings:
    """Draw the menu into the popup that is open; the settings as chosen."""
    chosen = settings
    for i, longer in enumerate(LONGER_SIDES):
        _label("Pixels" if i == 0 else "", i % 3 == 0, i % 3, 6.0)
        sized = with_longer_side(settings, longer)
        same = (sized.pixels_x, sized.pixels_y) == (settings.pixels_x, settings.pixels_y)
        if _choice(f"{sized.pixels_x} × {sized.pixels_y}", same, 5.6):
            chosen = sized
    imgui.separator()
    for i, samples in enumerate(SAMPLES):
        _label("Samples", i == 0, i, 3.0)
        if _choice(f"{samples}", samples == settings.samples, 2.6):
            chosen = replace(settings, samples=samples)
    imgui.separator()
    for i, (key, name) in enumerate(TONES.items()):
        _label("Tone", i == 0, i, 4.6)
        if _choice(f"{name}###{key}", key == settings.tone, 4.2):
            chosen = replace(settings, tone=key)
    return chosen


def _label(text: str, first: bool, column: int, width: float) -> None:
    """Begin a row with its label, or go on in its next column."""
    if first:
        imgui.text_disabled(text)
    imgui.same_line(theme.em(5.0 + column * width))


def _choice(label: str, chosen: bool, width: float) -> bool:
    return imgui.selectable(label, chosen, KEEP, ImVec2(theme.em(width), 0.0))[0]
