"""The focus ruler: a tilted ruler and Siemens stars at marked distances from the film."""

import numpy as np

from lensbench.scene import Disk, Floor, Image, Material, Pattern, Rectangle, Scene, Sky, Sun, Triple
from lensbench.scenery.lettering import lettering

PAPER, INK = (0.82, 0.81, 0.78), (0.02, 0.02, 0.022)
RED: Triple = (0.62, 0.05, 0.03)
NEAR, FAR = 600.0, 2400.0               # mm from the film, the ends of the ruler


def _printed(ink: np.ndarray, ink_colour: Triple = INK) -> Material:
    """Paper with ink where the array is 1."""
    ink = ink[..., None]
    return Material((1.0, 1.0, 1.0), pattern=Pattern("image", image=Image.of(
        np.asarray(PAPER) * (1 - ink) + np.asarray(ink_colour) * ink)))


def _scale() -> np.ndarray:
    """The print of the ruler, one texel a millimetre of distance: ticks every 10, 50 and 100 mm, figures every 100."""
    length, width = int(FAR - NEAR), 96
    ink = np.zeros((width, length), np.float32)
    for d in range(10, length, 10):
        tall = 40 if d % 100 == 0 else 30 if d % 50 == 0 else 18
        thick = 3 if d % 100 == 0 else 2
        ink[:tall, d - 1:d - 1 + thick] = 1.0
        ink[width - tall // 3:, d - 1:d - 1 + thick] = 1.0
    for d in range(100, length, 100):
        # figures are read from the camera: their tops point along the ruler, away from it
        figure = np.rot90(lettering(f"{(NEAR + d) / 1000:.1f}", 2), 1)
        h, w = figure.shape
        top = 64 - h // 2
        ink[top - 14:top - 14 + h, d - 1 - w - 2:d - 3] = figure
    return ink


def _star(x: float, y: float, distance: float) -> list:
    """A star on a card at a distance (mm) from the film, seen from there at the slopes x, y; its figure below it."""
    size = 0.046 * distance
    centre = (x * distance, y * distance, -distance)
    text = f"{distance / 1000:g} m"
    print_ = np.pad(lettering(text, 4), ((6, 6), (6, 6)))
    label = 0.022 * distance
    wide = label * print_.shape[1] / print_.shape[0]
    ahead = 1e-3 * distance                                       # the print stands a little before its card
    card = Rectangle((centre[0], centre[1] - 0.35 * size, -distance - ahead), (1.16 * size, 0.0, 0.0),
                     (0.0, 1.58 * size, 0.0), Material(PAPER))
    star = Disk(centre, (0.0, 0.0, 1.0), size, Material(PAPER, pattern=Pattern("star", INK, columns=18.0)))
    hub = Disk((centre[0], centre[1], -distance + ahead), (0.0, 0.0, 1.0), 0.07 * size, Material(RED))
    plate = Rectangle((centre[0], centre[1] - 1.42 * size, -distance), (wide, 0.0, 0.0), (0.0, label, 0.0),
                      _printed(print_))
    post = Rectangle((centre[0], centre[1] - 1.9 * size - 600.0, -distance - 2 * ahead), (0.012 * distance, 0.0, 0.0),
                     (0.0, 600.0, 0.0), Material((0.12, 0.12, 0.13)))
    return [card, star, hub, plate, post]


def focus_ruler() -> Scene:
    """The ruler's figures and the stars' labels are metres from the film, along the axis."""
    start, end = np.array([0.0, -0.205 * NEAR, -NEAR]), np.array([0.0, 0.135 * FAR, -FAR])
    middle, half = (start + end) / 2, (end - start) / 2
    ruler = Rectangle(tuple(float(v) for v in middle), tuple(float(v) for v in half), (-62.0, 0.0, 0.0),
                      _printed(_scale()))
    stars = [(-0.265, -0.085, 700.0), (0.265, -0.085, 900.0), (-0.15, 0.0, 1050.0), (0.155, 0.015, 1200.0),
             (-0.27, 0.105, 1500.0), (0.275, 0.11, 2000.0), (-0.145, 0.17, 3000.0), (0.15, 0.175, 5000.0)]
    cards = [plate for x, y, distance in stars for plate in _star(x, y, distance)]
    edge = Rectangle((0.0, -0.222 * 1200.0, -1200.0), (500.0, 0.0, 0.0), (0.0, 14.0, 0.0),
                     Material((0.85, 0.74, 0.36), pattern=Pattern("ruler", INK, columns=14.0, line=0.35)))
    return Scene("focus-ruler", sky=Sky((0.28, 0.31, 0.36), (0.50, 0.51, 0.52), (0.22, 0.22, 0.22)),
                 sun=Sun((-0.45, 0.8, 0.75), (0.62, 0.60, 0.56), 0.06),
                 floor=Floor(-330.0, 400.0, (0.30, 0.31, 0.32), (0.27, 0.28, 0.29)),
                 plates=(ruler, *cards, edge), depth_range=(500.0, 5000.0))
