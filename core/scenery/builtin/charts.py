"""Flat charts: a luminous wall with a grid, a test chart of edges and stars, and uniform white everywhere."""

import math

from lensbench.core.scenery.objects.material import Material, Pattern
from lensbench.core.scenery.objects.planar import Disk, Planar, Rectangle
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene

DISTANCE = 1200.0       # mm from the film
CELL, LINE = 50.0, 2.0  # mm
CELLS = 160


def grid_wall() -> Scene:
    """A flat wall square to the axis, radiance 0.8, lines every 50 mm, one through the axis; nine stars."""
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
    """Radiance 1 from every direction: the picture is the falloff of the lens."""
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
    """Focus at 2 m; the frame of the chart fills a film of 3 : 2."""
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
