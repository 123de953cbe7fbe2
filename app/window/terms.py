"""What the words and letters of the read-outs and plots mean, in plain sentences.

The window *What the terms mean*, behind the “?” of the menu bar.
"""

from dataclasses import dataclass

from imgui_bundle import ImVec2, ImVec4, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.window.dialogs import centre_next


@dataclass(frozen=True)
class Term:
    """A word, its letters in the read-outs, and its meaning."""

    name: str
    symbol: str
    meaning: str


TERMS: dict[str, tuple[Term, ...]] = {
    "Points of a lens": (
        Term("Focal points", "F  F′", "Light from a star gathers at F′, behind the lens. F is the same point for "
             "light that comes from the side of the film."),
        Term("Principal planes", "P  P′", "A thick lens bends light as if it were one thin lens that lies at P for "
             "the scene and at P′ for the film. Object distances are measured from P, image distances from P′."),
        Term("Pupils", "E  E′", "The stop as the scene sees it through the front glasses (E, entrance pupil), and "
             "as the film sees it through the rear glasses (E′, exit pupil). E is the point of the perspective: "
             "turn a camera about it, and near and far things do not shift against each other."),
        Term("Stop", "", "The iris: the opening that limits the light. Its blades give lights out of focus their "
             "shape."),
        Term("Exit-pupil region", "", "The part of the rear element that sends light to one point of the film. In "
             "the middle of the film it is round; towards the corners the edges of the glasses cut it to a cat's "
             "eye."),
        Term("Marginal and chief ray", "", "The marginal ray goes from the axis through the edge of the stop; the "
             "chief ray from the edge of the field through the middle of the stop."),
    ),
    "Size and distance": (
        Term("Focal length", "f, EFL", "The distance from P′ to F′. Twice the focal length shows things twice as "
             "large and half as much of the scene."),
        Term("Back focal length", "BFL", "The distance from the last glass to F′: the room for mirror and shutter."),
        Term("35 mm equivalent", "", "The focal length that sees as much on a film of 36 × 24 mm."),
        Term("Field of view", "", "The angle that the picture sees, across, up and along its diagonal."),
        Term("Magnification", "m", "Size of a thing on the film to its real size. 1 : 10 makes 10 cm to 1 cm."),
        Term("Focus distance", "", "From the film to the plane that is sharp."),
        Term("Nearest focus", "", "The shortest focus distance that the lens can be set to."),
        Term("Film distance", "", "From the last glass to the film. Focusing nearer moves the lens away from the "
             "film."),
    ),
    "Light": (
        Term("f-number", "N, f/2.8", "Focal length divided by the diameter of the entrance pupil. A step from f/2 "
             "to f/2.8, or from f/4 to f/5.6, halves the light."),
        Term("Working f-number", "", "The f-number that the film really gets at this focus. Close up the lens is "
             "farther from the film, and the picture is darker."),
        Term("Equivalent f-number", "", "The f-number that blurs as much on a film of 36 × 24 mm, with the "
             "equivalent focal length."),
        Term("T-stop", "T", "The f-number of a perfect lens that is as bright. Glass reflects some light at every "
             "surface, so that T is a little larger than N; film makers set T-stops."),
        Term("Exposure value", "EV", "Aperture and time in one number: one EV more is half the light."),
        Term("Stop of light", "", "A factor of two in light: an exposure correction of +1 EV doubles it."),
        Term("ISO", "", "How much the signal is amplified, noise included."),
        Term("Natural falloff", "cos⁴", "Light that comes to the film at an angle is spread over more area: corners "
             "are darker even with a perfect lens."),
        Term("Vignetting", "", "What the edges of the glasses block towards the corners. Stopping down cures it."),
    ),
    "Sharpness": (
        Term("Circle of confusion", "CoC", "A point out of focus becomes a disc on the film; the CoC is its "
             "diameter. Below a limit, 0.029 mm on 36 × 24 mm, the eye takes it for a point."),
        Term("Depth of field", "", "The distances at which the CoC stays below the limit."),
        Term("Hyperfocal distance", "", "Focused here, everything from half this distance to infinity is sharp "
             "enough."),
        Term("Airy disk", "", "The smallest spot that light allows: it spreads at the edge of the stop. It grows "
             "with the f-number, which is why f/22 is soft."),
        Term("Blur in focus", "", "What the lens's own errors leave of a point in focus."),
        Term("Colours", "", "Glass bends blue more than red. The picture is traced at 24 wavelengths where "
             "dispersion data exist, else at one."),
        Term("Samples", "", "Rays through each pixel so far. More of them make the picture smoother."),
        Term("MTF", "", "How much contrast of fine lines is left, from 0 to 1, by the number of line pairs a "
             "millimetre."),
        Term("Bokeh", "", "The look of what is out of focus."),
        Term("Distortion", "", "Straight lines bend: outwards like a barrel (−) or inwards like a cushion (+)."),
    ),
}


NAME = "What the terms mean"
WIDTH, HIGHEST = 38.0, 40.0     # em


class Terms:
    """State between frames."""

    def __init__(self) -> None:
        self._opens, self._query = False, ""

    def open(self) -> None:
        """Show it from the next `draw` on."""
        self._opens = True

    def draw(self) -> None:
        """Call it in every frame."""
        begins, self._opens = self._opens, False
        if begins:
            self._query = ""
            imgui.open_popup(NAME)
        centre_next(WIDTH)
        area = imgui.get_main_viewport().work_size
        height = min(theme.em(HIGHEST), 0.9 * area.y)
        imgui.set_next_window_size(ImVec2(min(theme.em(WIDTH), 0.95 * area.x), height))
        shown, _ = imgui.begin_popup_modal(NAME, True, imgui.WindowFlags_.no_saved_settings
                                           | imgui.WindowFlags_.no_resize)
        if not shown:
            return
        if begins:
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1.0)
        _, self._query = imgui.input_text_with_hint("##Term", "A word or a letter, such as CoC", self._query)
        imgui.begin_child("Terms")
        count = sum(_group(title, self._query) for title in TERMS)
        if not count:
            imgui.text_disabled("No such term")
        imgui.end_child()
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()


def _group(title: str, query: str) -> int:
    """Draw the terms of a group that hold the query; returns how many."""
    text = query.casefold().strip()
    terms = [term for term in TERMS[title] if text in f"{term.name} {term.symbol}".casefold()
             or len(text) > 2 and text in term.meaning.casefold()]
    if not terms:
        return 0
    colour = theme.colours()
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))
    imgui.text_disabled(title)
    for term in terms:
        imgui.text_colored(ImVec4(*colour.strong), term.name)
        if term.symbol:
            imgui.same_line()
            imgui.text_disabled(term.symbol)
        paragraph(term.meaning, True)
        imgui.dummy(ImVec2(0.0, theme.em(0.15)))
    return len(terms)
