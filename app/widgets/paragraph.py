"""Text over as many lines as it needs, in a panel or a popup."""

from imgui_bundle import imgui

from lensbench.app.widgets import theme


def paragraph(text: str, strong: bool = False) -> None:
    """Text wrapped at the edge of the window; dim, or strong."""
    imgui.push_text_wrap_pos(0.0)
    (imgui.text_unformatted if strong else imgui.text_disabled)(text)
    imgui.pop_text_wrap_pos()


def small_note(text: str) -> None:
    """A dim paragraph in small text."""
    theme.small()
    paragraph(text)
    imgui.pop_font()
