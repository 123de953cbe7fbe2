"""A small section of a lens, to scale: its glass, its stop and its axis."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench import lenses
from lensbench.app.state.section_geometry import elements
from lensbench.app.widgets import theme

STRIPS = 2                      # neighbouring strips of an element that become one
OUTLINE = 3                     # of the points of an outline every so many


@dataclass(frozen=True, eq=False)
class Drawing:
    """Shapes in mm, lens frame: quads (n, 4, 2) with the numbers of their glasses, and outlines (m, 2) each."""

    glasses: tuple[lb.Glass, ...]
    quads: NDArray[np.float64]
    glass_of: tuple[int, ...]
    outlines: tuple[NDArray[np.float64], ...]
    stop: tuple[float, float]                   # z and semi-diameter
    ends: tuple[float, float]                   # z
    radius: float


@lru_cache(maxsize=512)
def drawing(name: str) -> Drawing:
    """The drawing of a library lens; what `lenses.load` raises."""
    return drawing_of(lenses.load(name))


def drawing_of(lens: lb.Lens) -> Drawing:
    """The drawing of a lens."""
    found = elements(lens)
    quads: list[NDArray[np.float64]] = []
    glass_of: list[int] = []
    for i, element in enumerate(found):
        strips = element.strips
        for first in range(0, len(strips), STRIPS):         # each from its first's lower edge to its last's upper edge
            last = min(first + STRIPS, len(strips)) - 1
            quads.append(np.array([strips[first][0], strips[last][1], strips[last][2], strips[first][3]]))
            glass_of.append(i)
    outlines = tuple(element.outline[::OUTLINE] for element in found)
    edge = [outline[:, 0] for outline in outlines] or [np.array([0.0, lens.length])]
    return Drawing(tuple(element.glass for element in found), np.array(quads).reshape(-1, 4, 2), tuple(glass_of),
                   outlines, (lens.vertices[lens.stop_index], lens.stop.semi_diameter),
                   (min(0.0, *(float(z.min()) for z in edge)), max(lens.length, *(float(z.max()) for z in edge))),
                   max(surface.semi_diameter for surface in lens.surfaces))


def draw_section(draw: imgui.ImDrawList, of: Drawing, upper: ImVec2, lower: ImVec2) -> None:
    """Draw it between two corners, as large as fits, with equal axes."""
    colour, pixel = theme.colours(), theme.scale()
    width, height = lower.x - upper.x, lower.y - upper.y
    length = of.ends[1] - of.ends[0]
    scale = min(0.92 * width / max(length, 1e-9), 0.46 * height / max(of.radius, 1e-9))
    middle = np.array([0.5 * (upper.x + lower.x) - 0.5 * scale * (of.ends[0] + of.ends[1]),
                       round(0.5 * (upper.y + lower.y)) + 0.5])
    factor = np.array([scale, -scale])

    axis = theme.packed(colour.faint, 0.55)
    draw.add_line(ImVec2(upper.x, middle[1]), ImVec2(lower.x, middle[1]), axis, pixel)
    fills = [theme.packed(colour.glass(glass.n_d, glass.v_d if glass.v_d is not None else 60.0))
             for glass in of.glasses]
    draw.push_draw_flag(imgui.ImDrawFlags_.aa_fill, False)              # otherwise the seams of the strips show
    for which, (a, b, c, d) in zip(of.glass_of, (of.quads * factor + middle).tolist(), strict=True):
        draw.add_quad_filled(ImVec2(*a), ImVec2(*b), ImVec2(*c), ImVec2(*d), fills[which])
    draw.pop_draw_flag()
    line = theme.packed(colour.glass_outline, 0.85)
    for outline in of.outlines:
        points = [ImVec2(x, y) for x, y in (outline * factor + middle).tolist()]
        draw.add_polyline(points, line, pixel, imgui.ImDrawFlags_.closed)
    z, radius = of.stop
    ink, x = theme.packed(colour.text), float(middle[0]) + scale * z
    for sign in (-1.0, 1.0):
        near, far = (middle[1] + sign * scale * end for end in (radius, max(1.15 * radius, radius + 2.0 / scale)))
        draw.add_line(ImVec2(x, float(near)), ImVec2(x, float(far)), ink, 1.5 * pixel)
