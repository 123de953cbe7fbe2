"""A number in a small field: dragged sideways, or typed after a double click."""

from imgui_bundle import imgui

from lensbench.app.widgets import theme


def number(label: str, value: float, bounds: tuple[float, float], step: float, form: str, tip: str,
           width: float = 4.6) -> float:
    """Draw a field after its dim label; returns the value, within its bounds.

    bounds: least and greatest value. step: change per pixel. form: printf format with the unit. width: in em.
    """
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(label)
    imgui.same_line(0.0, theme.em(0.4))
    imgui.set_next_item_width(theme.em(width))
    _, value = imgui.drag_float(f"###{label}", value, step, *bounds, form, imgui.SliderFlags_.always_clamp)
    imgui.set_item_tooltip(f"{tip}\nDrag sideways, Alt for fine steps; double-click to type")
    return float(value)
