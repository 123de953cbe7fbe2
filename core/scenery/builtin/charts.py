"""Charts: a luminous wall with a grid, a test chart of edges and stars, a focus ruler, and uniform white everywhere."""

import math
from typing import Any

import numpy as np

from lensbench.core.scenery.builtin.building_parts import lettering
from lensbench.core.scenery.objects.basic_shapes import Disk, Planar, Rectangle
from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import Triple, triple

DISTANCE = 1200.0       # mm from the film
CELL, LINE = 50.0, 2.0  # mm
CELLS = 160


def grid_wall() -> Scene:
    """A flat bright wall (radiance 0.8) with a line every 50 mm and nine stars: distortion and curvature of field."""
    half = CELLS * CELL / 2 + LINE / 2
    white, ink = (0.8, 0.8, 0.8), (0.03, 0.03, 0.03)
    wall = Rectangle((0.0, 0.0, -DISTANCE), (half, 0.0, 0.0), (0.0, half, 0.0),
                     Material(white, "light", pattern=Pattern("grid", ink, CELLS, CELLS, LINE)))
    places = [(x * 350.0, y * 200.0) for x in (-1, 0, 1) for y in (-1, 0, 1)]
    stars = tuple(Disk((x, y, -DISTANCE + 0.2), (0.0, 0.0, 1.0), 42.0,
                       Material(white, "light", pattern=Pattern("star", ink, 24.0))) for x, y in places)
    return Scene("grid-wall", sky=Sky((0.8,) * 3, (0.8,) * 3, (0.8,) * 3), plates=(wall, *stars),
                 depth_range=(600.0, 2400.0))


def white_wall() -> Scene:
    """White from every direction (radiance 1): the picture is the falloff of the lens."""
    return Scene("white-wall", sky=Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))


# The test chart: slanted edges and Siemens stars from the centre to the corners

CHART_DISTANCE = 2000.0       # mm
WIDE, HIGH = 2400.0, 1600.0
SLANT = math.radians(5.0)       # of the edges (ISO 12233)
WHITE, BLACK, GREY = (0.80, 0.80, 0.80), (0.04, 0.04, 0.04), (0.18, 0.18, 0.18)
STEPS = 12              # patches of the grey scale


def _square(x: float, y: float, side: float) -> Rectangle:
    """A dark square turned by SLANT, in front of the chart."""
    c, s = math.cos(SLANT) * side / 2.0, math.sin(SLANT) * side / 2.0
    return Rectangle((x, y, -CHART_DISTANCE + 1.0), (c, s, 0.0), (-s, c, 0.0), Material(BLACK))


def _star(x: float, y: float, radius: float) -> list[Planar]:
    """A Siemens star of 36 pairs of sectors, with a quarter grey rim."""
    pattern = Pattern("star", BLACK, columns=36.0)
    return [Disk((x, y, -CHART_DISTANCE + 1.0), (0.0, 0.0, 1.0), 1.08 * radius, Material(GREY)),
            Disk((x, y, -CHART_DISTANCE + 2.0), (0.0, 0.0, 1.0), radius, Material(WHITE, pattern=pattern))]


def resolution_chart() -> Scene:
    """Slanted edges and Siemens stars from the centre to the corners; its frame fills a film of 3 : 2."""
    things: list[Planar] = [Rectangle((0.0, 0.0, -CHART_DISTANCE), (WIDE, 0.0, 0.0), (0.0, HIGH, 0.0), Material(WHITE))]
    for x, y in ((0.0, 0.0), (-640.0, 400.0), (640.0, 400.0), (-640.0, -400.0), (640.0, -400.0)):
        things += _star(x, y, 120.0 if (x, y) == (0.0, 0.0) else 100.0)
    things += [_square(x, y, 110.0) for x, y in (
        (-300.0, 0.0), (300.0, 0.0), (0.0, 250.0), (0.0, -250.0), (-340.0, 300.0), (340.0, 300.0), (-340.0, -300.0),
        (340.0, -300.0), (-640.0, 0.0), (640.0, 0.0))]
    # A grey scale in steps of half a stop below the centre, and bars of finer and finer lines above it
    for k in range(STEPS):
        level = 0.8 * 2.0 ** (-k / 2.0)
        things.append(Rectangle((-220.0 + 40.0 * k, -430.0, -CHART_DISTANCE + 1.0), (19.0, 0.0, 0.0), (0.0, 26.0, 0.0),
                                Material((level, level, level))))
    x = -240.0
    for pairs_per_mm in (0.05, 0.1, 0.2, 0.4, 0.8):
        pattern = Pattern("checker", BLACK, columns=2.0 * round(80.0 * pairs_per_mm), rows=1.0)
        things.append(Rectangle((x + 45.0, 430.0, -CHART_DISTANCE + 1.0), (40.0, 0.0, 0.0), (0.0, 30.0, 0.0),
                                Material(WHITE, pattern=pattern)))
        x += 97.0
    frame = [Rectangle((0.0, s * 520.0, -CHART_DISTANCE + 1.0), (790.0, 0.0, 0.0), (0.0, 2.0, 0.0), Material(BLACK))
             for s in (-1.0, 1.0)]
    frame += [Rectangle((s * 788.0, 0.0, -CHART_DISTANCE + 1.0), (2.0, 0.0, 0.0), (0.0, 520.0, 0.0), Material(BLACK))
              for s in (-1.0, 1.0)]
    return Scene("test-chart", sky=Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3), plates=(*things, *frame),
                 depth_range=(1000.0, 4000.0), subject=(CHART_DISTANCE - 5.0, 1052.0))


# The focus ruler: a tilted ruler and Siemens stars at marked distances from the film

PAPER, INK = (0.82, 0.81, 0.78), (0.02, 0.02, 0.022)
RED: Triple = (0.62, 0.05, 0.03)
NEAR, FAR = 600.0, 2400.0               # mm from the film, the ends of the ruler
GROUND = -420.0                         # mm, the floor below the camera


def _printed(ink: np.ndarray) -> Material:
    """Paper with ink where the array is 1."""
    ink = ink[..., None]
    return Material((1.0, 1.0, 1.0), pattern=Pattern("image", image=Image.of(
        np.asarray(PAPER) * (1 - ink) + np.asarray(INK) * ink)))


def _scale() -> np.ndarray:
    """The print of the ruler, one texel a millimetre of distance: ticks every 10, 50 and 100 mm, figures every 100."""
    length, width = int(FAR - NEAR), 96
    ink = np.zeros((width, length), np.float32)
    for d in range(10, length, 10):
        tall = 34 if d % 100 == 0 else 24 if d % 50 == 0 else 14
        thick = 4 if d % 100 == 0 else 2
        ink[:tall, d - thick // 2:d + thick // 2] = 1.0
        ink[width - tall:, d - thick // 2:d + thick // 2] = 1.0
    for d in range(100, length, 100):
        # the foot of a figure is at its tick as seen from the camera; drawn high, since foreshortened
        figure = np.kron(lettering(f"{(NEAR + d) / 1000:.1f}"), np.ones((9, 2), np.float32))
        figure = np.rot90(figure, -1)
        h, w = figure.shape
        ink[(width - h) // 2:(width - h) // 2 + h, d - w // 2:d - w // 2 + w] = figure
    return ink


def _card(x: float, y: float, distance: float) -> list[Any]:
    """A star on a card at a distance (mm) from the film, seen from there at the slopes x, y; its figure below it."""
    size = 0.042 * distance
    cx, cy = x * distance, y * distance
    print_ = np.pad(lettering(f"{distance / 1000:g} m", 4), ((6, 6), (6, 6)))
    label = 0.26 * size
    wide = label * print_.shape[1] / print_.shape[0]
    ahead = 1.5e-4 * distance                                       # the print stands a little before its card
    dark = Material((0.05, 0.05, 0.055))
    card = Rectangle((cx, cy - 0.3 * size, -distance - ahead), (1.14 * size, 0.0, 0.0), (0.0, 1.44 * size, 0.0),
                     Material(PAPER))
    edge = Rectangle((cx, cy - 0.3 * size, -distance - 2 * ahead), (1.19 * size, 0.0, 0.0), (0.0, 1.49 * size, 0.0),
                     dark)
    star = Disk((cx, cy, -distance), (0.0, 0.0, 1.0), size, Material(PAPER, pattern=Pattern("star", INK, columns=18.0)))
    hub = Disk((cx, cy, -distance + ahead), (0.0, 0.0, 1.0), 0.07 * size, Material(RED))
    plate = Rectangle((cx, cy - 1.36 * size, -distance), (wide, 0.0, 0.0), (0.0, label, 0.0), _printed(print_))
    foot = cy - 1.74 * size
    post = Rectangle((cx, (foot + GROUND) / 2, -distance - 3 * ahead), (0.006 * distance, 0.0, 0.0),
                     (0.0, (foot - GROUND) / 2, 0.0), dark)
    return [card, edge, star, hub, plate, post]


def focus_ruler() -> Scene:
    """A ruler and Siemens stars with their distances along the axis, in metres from the world's origin."""
    start, end = np.array([0.0, -0.235 * NEAR, -NEAR]), np.array([0.0, 0.115 * FAR, -FAR])
    middle, half = (start + end) / 2, (end - start) / 2
    ruler = Rectangle(triple(middle), triple(half), (-62.0, 0.0, 0.0),
                      _printed(_scale()))
    stars = [(-0.262, -0.10, 700.0), (0.262, -0.10, 900.0), (-0.14, -0.03, 1050.0), (0.14, -0.03, 1200.0),
             (-0.262, 0.065, 1500.0), (0.262, 0.065, 2000.0), (-0.14, 0.15, 3000.0), (0.14, 0.15, 5000.0)]
    cards = [plate for x, y, distance in stars for plate in _card(x, y, distance)]
    edge = Rectangle((0.0, -0.218 * 1200.0, -1200.0), (500.0, 0.0, 0.0), (0.0, 14.0, 0.0),
                     Material((0.80, 0.62, 0.20), pattern=Pattern("ruler", INK, columns=14.0, line=0.35)))
    return Scene("focus-ruler", sky=Sky((0.05, 0.06, 0.075), (0.16, 0.17, 0.185), (0.05, 0.05, 0.05)),
                 sun=Sun((-0.5, 0.75, 0.8), (1.12, 1.07, 0.99), 0.07), ambient=(0.17, 0.17, 0.176),
                 floor=Floor(GROUND, 300.0, (0.20, 0.135, 0.085), (0.165, 0.108, 0.066), turn=0.5),
                 plates=(ruler, *cards, edge), depth_range=(500.0, 5000.0))
