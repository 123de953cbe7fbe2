"""What the words and letters of the read-outs and plots mean, in plain sentences."""

from dataclasses import dataclass


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
        Term("Exit-pupil region", "", "The part of the rear opening that sends light to one point of the film. In "
             "the middle of the film it is round; towards the corners the rims of the glasses cut it to a cat's "
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
        Term("Vignetting", "", "What the rims of the glasses take away from the corners. Stopping down cures it."),
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
        Term("Colours", "", "Glass bends blue more than red. The picture is traced at 24 wavelengths where the "
             "glasses are known, else at one."),
        Term("Samples", "", "Rays through each pixel so far. More of them make the picture smoother."),
        Term("MTF", "", "How much contrast of fine lines is left, from 0 to 1, by the number of line pairs a "
             "millimetre."),
        Term("Bokeh", "", "The look of what is out of focus."),
        Term("Distortion", "", "Straight lines bend: outwards like a barrel (−) or inwards like a cushion (+)."),
    ),
}
