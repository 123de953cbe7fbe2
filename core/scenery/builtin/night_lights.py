"""Night lights: a wet street seen past a crystal ball, lights from 1 to 100 m."""

import numpy as np

from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.planar import Disk, Rectangle
from lensbench.core.scenery.objects.sphere import Sphere
from lensbench.core.scenery.objects.surroundings import Floor, Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import Triple

GROUND = -1350.0        # mm, the street below the camera
SODIUM, WHITE, TAIL = (17.0, 8.6, 2.2), (16.0, 15.0, 12.5), (14.0, 0.8, 0.35)
NEON = ((13.0, 1.2, 3.4), (1.0, 9.0, 12.5), (2.2, 11.0, 3.4), (14.0, 6.0, 1.0), (5.0, 2.2, 14.0), (12.0, 10.5, 8.0))


def _light(x: float, y: float, away: float, colour: Triple, size: float = 3.1e-3) -> Sphere:
    """A light at (x, y) and a distance in metres; its radius is that distance times `size`, in mm."""
    return Sphere((x * 1e3, y * 1e3, -away * 1e3), max(12.0, size * away * 1e3), Material(colour, "light"))


def _windows(columns: int, lines: int, share: float, seed: int) -> Image:
    """The lit windows of a building front: radiance, dark between."""
    random = np.random.default_rng(seed)
    lit = random.random((lines, columns)) < share
    warm = random.random((lines, columns, 1))
    glow = (np.array([5.0, 3.0, 1.3]) * warm + np.array([2.6, 2.9, 3.3]) * (1 - warm)) * lit[..., None]
    glow *= random.uniform(0.25, 1.0, (lines, columns, 1))
    front = np.zeros((lines * 4, columns * 4, 3))
    for dy in (1, 2):
        for dx in (1, 2):
            front[dy::4, dx::4] = glow
    return Image.of(front + np.array([0.004, 0.0045, 0.007]))


def _building(left: float, right: float, top: float, away: float, columns: int, lines: int, seed: int) -> Rectangle:
    """A front between two places across (m), from the ground to a height (m), at a distance (m)."""
    bottom = GROUND * 1e-3
    image = Pattern("image", image=_windows(columns, lines, 0.26, seed))
    return Rectangle(((left + right) * 500.0, (top + bottom) * 500.0, -away * 1e3), ((right - left) * 500.0, 0.0, 0.0),
                     (0.0, (top - bottom) * 500.0, 0.0), Material((1.0, 1.0, 1.0), "light", pattern=image))


def _shop_window(colour: Triple, columns: int, lines: int) -> Material:
    """Lit panes in dark bars, brightest where the lamps hang."""
    pane = 12
    glow = np.linspace(1.0, 0.35, lines * pane)[:, None, None] * np.ones((1, columns * pane, 1)) * np.array(colour)
    glow[::pane] = glow[:, ::pane] = glow[-1] = glow[:, -1] = 0.01
    return Material((1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(glow)))


def night_lights() -> Scene:
    """Focus at 1.2 m on the crystal ball; f/2 shows the cat's eyes."""
    random = np.random.default_rng(11)
    lights = []
    # street lamps along both kerbs
    for away in (7.0, 10.5, 15.0, 21.0, 29.0, 40.0, 56.0, 78.0, 100.0):
        for side in (-1.0, 1.0):
            lights.append(_light(side * 4.6 - 0.5, 2.35, away, SODIUM, 3.6e-3))
    # traffic: headlights towards the camera on the left, tail lights on the right
    for away in (13.0, 19.0, 24.0, 33.0, 47.0, 62.0, 85.0):
        x = -2.1 + random.uniform(-0.25, 0.25)
        lights += [_light(x + dx, -0.72, away, WHITE, 2.6e-3) for dx in (-0.62, 0.62)]
    for away in (9.0, 14.0, 20.0, 28.0, 38.0, 53.0, 72.0):
        x = 1.5 + random.uniform(-0.25, 0.25)
        lights += [_light(x + dx, -0.62, away, TAIL, 2.8e-3) for dx in (-0.6, 0.6)]
    # signals over the crossings
    lights += [_light(x, 1.55, away, colour) for x, away, colour in (
        (2.7, 16.0, (1.0, 13.0, 4.5)), (-3.4, 17.0, (1.0, 13.0, 4.5)), (2.4, 34.0, (14.0, 1.2, 0.5)),
        (-2.9, 35.0, (14.0, 1.2, 0.5)), (0.2, 58.0, (14.0, 7.5, 0.8)))]
    # shop signs and windows, thicker far down the street
    for _ in range(64):
        away = float(np.exp(random.uniform(np.log(4.5), np.log(95.0))))
        side = random.choice((-1.0, 1.0))
        x = side * (min(6.2, 0.42 * away) + random.uniform(-0.5, 0.6) * min(1.0, away / 9.0))
        y = random.uniform(-0.75, 1.9 if away > 9.0 else 0.9)
        lights.append(_light(x, y, away, NEON[random.integers(len(NEON))], random.uniform(2.0e-3, 3.4e-3)))
    # fairy lights on a railing near by
    for j in range(16):
        x = -1.25 + 0.062 * j * (1.0 + 0.3 * random.random())
        lights.append(_light(x, 0.30 - 0.10 * np.sin(0.2 * j) + random.uniform(-0.02, 0.02), 2.6 + 0.1 * j,
                             (15.0, 9.0, 3.6), 2.2e-3))
    skyline = (
        _building(-46.0, -27.0, 19.0, 108.0, 12, 18, 1), _building(-26.0, -15.0, 27.0, 112.0, 8, 24, 2),
        _building(-14.0, -3.0, 14.0, 105.0, 8, 12, 3), _building(4.0, 13.0, 22.0, 110.0, 7, 20, 4),
        _building(14.0, 29.0, 16.0, 106.0, 11, 14, 5), _building(30.0, 47.0, 25.0, 113.0, 12, 22, 6))
    # a round table of polished black stone: a mirror of four percent, and of all at grazing incidence
    table = (Disk((60.0, -128.0, -1120.0), (0.0, 1.0, 0.0), 430.0, Material((0.04, 0.04, 0.044), "metal")),
             Disk((60.0, -133.0, -1120.0), (0.0, 1.0, 0.0), 436.0, Material((0.42, 0.30, 0.16), "metal")))
    ball = Sphere((105.0, -128.0 + 104.0, -1210.0), 104.0, Material((0.99, 0.99, 0.99), "glass"))
    # two shop windows to the sides, seen in the ball's rim; only a fisheye sees them at first hand
    shops = (Rectangle.facing((-2300.0, 150.0, -1500.0), ball.centre, 760.0, 1100.0,
                              _shop_window((9.0, 5.2, 2.4), 3, 4)),
             Rectangle.facing((2300.0, 100.0, -1300.0), ball.centre, 640.0, 1100.0,
                              _shop_window((1.6, 4.2, 7.5), 2, 5)))
    return Scene("night-lights", sky=Sky((0.002, 0.004, 0.013), (0.020, 0.018, 0.034), (0.003, 0.003, 0.005)),
                 floor=Floor(GROUND, 600.0, (0.030, 0.030, 0.034), (0.020, 0.020, 0.023), gloss=0.955),
                 spheres=(ball, *lights), plates=(*skyline, *table, *shops), ambient=(0.02, 0.018, 0.02),
                 depth_range=(800.0, 100e3))
