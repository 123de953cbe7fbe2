"""Charts: a luminous wall with a grid, and uniform white everywhere."""

from lensbench.core.scenery.objects.material import Material, Pattern
from lensbench.core.scenery.objects.planar import Disk, Rectangle
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
