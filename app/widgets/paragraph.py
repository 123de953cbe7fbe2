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


def two_lines(text: str, width: float) -> list[str]:
    """The text in at most two lines of this width (pixels), broken at a space if it can be; the second is cut."""
    text = text.replace("\n", " ")
    if imgui.calc_text_size(text).x <= width:
        return [text]
    first = text
    while " " in first and imgui.calc_text_size(first).x > width:
        first = first.rsplit(" ", 1)[0]
    if imgui.calc_text_size(first).x > width:           # a word longer than a line
        first = theme.shortened(first, width)
        return [first]
    return [first, theme.shortened(text[len(first):].strip(), width)]
