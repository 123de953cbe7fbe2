"""The reference A and the current picture B: labels that distinguish them, the wipe's line, the difference's scale.

Their colours do not follow the theme, because the pictures below do not.
"""

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.tone import Difference
from lensbench.app.display.frame import Box, Pinned
from lensbench.app.drawing import theme
from lensbench.app.panels.controls.controls import lens_name, scene_title
from lensbench.app.panels.image.overlays import SCALE_STEPS, draw_colour_scale, draw_note
from lensbench.app.session.lens_shelf import format_name
from lensbench.app.settings.setting_table import LAYOUTS, TONES, VIEWS
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import (
    format_angle, format_distance, format_duration, format_exposure, format_f_number, format_length, format_time
)
from lensbench.core.text import significant

UNSAID = ("samples", "compare", "wipe", "overlay", "limit", "position", "yaw", "pitch",
          "end_position", "end_yaw", "end_pitch")


def draw_pinned(draw: imgui.ImDrawList, pinned: Pinned, upper: ImVec2, lower: ImVec2,
                clip: tuple[ImVec2, ImVec2]) -> None:
    """A's picture, as far as it lies within `clip`."""
    draw.push_clip_rect(*clip, True)
    draw.add_image(imgui.ImTextureRef(pinned.texture), upper, lower)
    draw.pop_clip_rect()


def draw_plate(draw: imgui.ImDrawList, name: str, own: Settings, other: Settings, samples: int, corner: ImVec2,
               room: float, right: bool = False) -> None:
    """The name of a picture, and how its settings differ from the other's, in lines no wider than `room` pixels.

    right: `corner` is the text's right end.
    """
    theme.small()
    lines = plate_lines(f"{name}   {differences(own, other)[0]}", f"{samples} samples", room,
                        lambda text: imgui.calc_text_size(text).x)
    text = "\n".join(theme.shortened(line, room) for line in lines)
    draw_note(draw, ImVec2(corner.x - right * imgui.calc_text_size(text).x, corner.y), text)
    imgui.pop_font()


def plate_lines(text: str, samples: str, room: float, width: Callable[[str], float]) -> list[str]:
    """The text of a plate, broken at its commas where it is wider than `room`; a part that is wider alone stays whole.

    width: of a text, in the unit of `room`.
    """
    lines: list[str] = []
    for piece in text.split(", "):
        joined = f"{lines[-1]}, {piece}" if lines else piece
        if lines and width(joined) <= room:
            lines[-1] = joined
        else:
            lines.append(piece)
    joined = f"{lines[-1]}   {samples}"
    return [*lines[:-1], joined] if width(joined) <= room else [*lines, samples]


def differences(a: Settings, b: Settings) -> tuple[str, str]:
    """The differences between two settings, each in a few words."""
    from lensbench.app.bench.camera_kinds import readings

    def angle(settings: Settings) -> str:
        return format_angle(readings(settings).fov_diagonal or 0.0)

    descriptions = (
        (("lens", "edited"), lens_name), (("scene",), lambda s: scene_title(s.scene)),
        (("film_width", "film_height", "body"), format_name),
        (("camera", "lens_model"), lambda s: s.camera_title), (("crop", "fov", "fisheye_fov", "fov_axis"), angle),
        (("projection",), lambda s: s.projection), (("layout",), lambda s: LAYOUTS[s.layout]),
        (("scene_width",), lambda s: format_distance(s.scene_width)),
        (("shutter",), lambda s: format_time(s.shutter)), (("readout",), lambda s: format_duration(s.readout)),
        (("focal_length",), lambda s: format_length(readings(s).efl or 0.0)),
        (("f_number",), lambda s: format_f_number(readings(s).f_number or 0.0)),
        (("focus_distance",), lambda s: format_distance(s.focus_distance)),
        (("view",), lambda s: VIEWS[s.view]),
        (("pixels_x", "pixels_y"), lambda s: f"{s.pixels_x} × {s.pixels_y}"),
        (("exposure",), lambda s: format_exposure(s.exposure)), (("tone",), lambda s: TONES[s.tone]),
        (("seed",), lambda s: f"seed {s.seed}"),
    )
    chosen = [text for names, text in descriptions if any(getattr(a, name) != getattr(b, name) for name in names)]
    described = {name for names, _ in descriptions for name in names}
    others = [f.name for f in fields(Settings) if f.name not in described and f.name not in UNSAID
              and getattr(a, f.name) != getattr(b, f.name)]
    first, second = (", ".join([text(settings) for text in chosen] + [_plainly(name, settings) for name in others])
                     for settings in (a, b))
    if not chosen and not others and not np.array_equal(a.present_pose, b.present_pose):
        first, second = "another place", "here"
    return first or "the same settings", second or "the same settings"


def _plainly(name: str, settings: Settings) -> str:
    """A setting by the name of its field."""
    value = getattr(settings, name)
    words = "as designed" if value is None else significant(value) if isinstance(value, float) else f"{value}"
    return f"{name.replace('_', ' ')} {words}"


def wiped(settings: Settings, upper: ImVec2, lower: ImVec2, corner: ImVec2, room: ImVec2) -> Settings:
    """The line of the wipe over a picture, after the picture's item; returns the settings with its dragged place."""
    pixel = theme.scale()
    x = upper.x + settings.wipe * (lower.x - upper.x)
    half = 6.0 * pixel
    top, bottom = max(upper.y, corner.y), min(lower.y, corner.y + room.y)
    imgui.set_cursor_screen_pos(ImVec2(x - half, top))
    imgui.invisible_button("Wipe", ImVec2(2.0 * half, max(bottom - top, 1.0)))
    hot = imgui.is_item_hovered() or imgui.is_item_active()
    if hot:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        if not imgui.is_item_active():
            imgui.set_item_tooltip("A at the left, B at the right: drag. Double click: the middle")
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        settings = replace(settings, wipe=0.5)
    elif imgui.is_item_active() and imgui.get_io().mouse_delta.x:
        fraction = (imgui.get_mouse_pos().x - upper.x) / max(lower.x - upper.x, 1.0)
        settings = replace(settings, wipe=min(max(fraction, 0.0), 1.0))
    draw = imgui.get_window_draw_list()
    x = round(upper.x + settings.wipe * (lower.x - upper.x))
    draw.add_rect_filled(ImVec2(x - 2.0 * pixel, top), ImVec2(x + 2.0 * pixel, bottom), theme.packed((0, 0, 0, 0.35)))
    draw.add_rect_filled(ImVec2(x - 0.5 * pixel, top), ImVec2(x + pixel, bottom), theme.packed((1, 1, 1, 0.95)))
    y, size = 0.5 * (top + bottom), (7.0 if hot else 5.0) * pixel
    for sign in (-1.0, 1.0):
        tip, base = x + sign * (size + 4.0 * pixel), x + sign * 4.0 * pixel
        draw.add_triangle_filled(ImVec2(tip, y), ImVec2(base, y - size), ImVec2(base, y + size),
                                 theme.packed((1, 1, 1, 0.95)))
    return settings


def draw_scale(draw: imgui.ImDrawList, difference: Difference, corner: ImVec2) -> Box:
    """Legend of the difference, with RMS and maximum, as `draw_colour_scale` draws it."""
    title = "No difference" if difference.largest == 0.0 else \
        f"|B − A|, linear light   RMS {significant(difference.rms, 3)}   maximum {significant(difference.largest, 3)}"
    shares = ((i + 0.5) / SCALE_STEPS for i in range(SCALE_STEPS))
    codes = (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1.0 / 2.4) - 0.055 for x in shares)
    return draw_colour_scale(draw, corner, title, [(code, code, code) for code in codes], {
        fraction: significant(fraction * difference.scale, 3) for fraction in (0.0, 0.25, 0.5, 0.75, 1.0)})
