"""Scenes indoors: a room with a window, and a still life of coated, metal and glass balls under studio lamps."""

import math

import numpy as np

from lensbench.core.scenery.builtin.building_parts import box
from lensbench.core.scenery.objects.basic_shapes import Disk, Planar, Rectangle, Sphere
from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Framing, Scene
from lensbench.core.scenery.values import Triple, triple

LEFT, RIGHT, GROUND, TOP, BACK, BEHIND = -1900.0, 2100.0, -1150.0, 1450.0, -5200.0, 1500.0     # mm


def _landscape() -> Image:
    """Hills before an evening sky, layer behind layer."""
    h, w = 192, 288
    y, x = np.mgrid[0:h, 0:w] / h
    height = 1.0 - y
    picture = np.array([0.78, 0.33, 0.12]) * (1 - height[..., None]) + np.array([0.10, 0.20, 0.42]) * height[..., None]
    glow = np.exp(-((x - 1.02) ** 2 + (y - 0.42) ** 2) / 0.03)[..., None]
    picture = picture + glow * np.array([0.35, 0.22, 0.06])
    picture[(x - 1.02) ** 2 + (y - 0.42) ** 2 < 0.0045] = (1.0, 0.82, 0.45)
    for k, (base, rise, waves) in enumerate([(0.46, 0.07, 5.1), (0.36, 0.09, 3.7), (0.24, 0.08, 6.3),
                                             (0.12, 0.07, 4.4)]):
        ridge = base + rise * (np.sin(waves * x + 1.7 * k) + 0.35 * np.sin(2.9 * waves * x + k))
        near = k / 3
        colour = np.array([0.34, 0.20, 0.24]) * (1 - near) + np.array([0.02, 0.045, 0.05]) * near
        picture[height < ridge] = colour
    return Image.of(np.clip(picture, 0.0, 1.0))


def _framed(centre: Triple, wide: float, high: float, frame: Material, inside: Material,
            turn: float = 0.0) -> list[Rectangle]:
    """Something flat and upright in a frame 45 mm wide, turned to the right by an angle."""
    (x, y, z), border, c, s = centre, 45.0, math.cos(turn), math.sin(turn)
    a, b = wide / 2 + border, high / 2 + border
    return [Rectangle((x, y, z), (a * c, 0.0, -a * s), (0.0, b, 0.0), frame),
            Rectangle((x + 6.0 * s, y, z + 6.0 * c), (wide / 2 * c, 0.0, -wide / 2 * s), (0.0, high / 2, 0.0), inside)]


def room() -> Scene:
    """Balls on a table in a sunlit room; a mirror shows the window."""
    wall, white = Material((0.56, 0.55, 0.50)), Material((0.74, 0.73, 0.70))
    accent = Material((0.13, 0.22, 0.23))
    wood = Material((0.34, 0.19, 0.085), pattern=Pattern("checker", (0.27, 0.145, 0.062), columns=26.0, rows=5.0))
    ebony, lacquer = Material((0.045, 0.038, 0.033)), Material((0.045, 0.042, 0.040), "metal")
    mx, mz, hx, hz = (LEFT + RIGHT) / 2, (BACK + BEHIND) / 2, (RIGHT - LEFT) / 2, (BEHIND - BACK) / 2
    my, hy = (GROUND + TOP) / 2, (TOP - GROUND) / 2
    shell = [Rectangle((mx, GROUND, mz), (hx, 0.0, 0.0), (0.0, 0.0, -hz), wood),
             Rectangle((mx, TOP, mz), (hx, 0.0, 0.0), (0.0, 0.0, hz), white),
             Rectangle((mx, my, BACK), (hx, 0.0, 0.0), (0.0, hy, 0.0), accent),
             Rectangle((mx, my, BEHIND), (hx, 0.0, 0.0), (0.0, hy, 0.0), wall),
             Rectangle((LEFT, my, mz), (0.0, 0.0, hz), (0.0, hy, 0.0), wall),
             Rectangle((mx, GROUND + 60.0, BACK + 8.0), (hx, 0.0, 0.0), (0.0, 60.0, 0.0), white)]
    # the right wall round its window
    z0, z1, y0, y1 = -4300.0, -2300.0, -250.0, 1050.0
    middle, half, pane = (y0 + y1) / 2, (y1 - y0) / 2, (z1 - z0) / 2
    shell += [Rectangle((RIGHT, y, z), (0.0, 0.0, dz), (0.0, dy, 0.0), material) for y, z, dy, dz, material in (
        ((GROUND + y0) / 2, mz, (y0 - GROUND) / 2, hz, wall),
        ((TOP + y1) / 2, mz, (TOP - y1) / 2, hz, wall),
        (middle, (BACK + z0) / 2, half, (z0 - BACK) / 2, wall),
        (middle, (z1 + BEHIND) / 2, half, (BEHIND - z1) / 2, wall),
        (middle, (z0 + z1) / 2, half, 28.0, white),
        (420.0, (z0 + z1) / 2, 22.0, pane, white))]
    gold, silver = Material((0.50, 0.33, 0.12)), Material((0.94, 0.94, 0.95), "metal")
    pictures = [
        *_framed((-620.0, 330.0, BACK + 12.0), 1260.0, 840.0, gold,
                 Material((1.0, 1.0, 1.0), pattern=Pattern("image", image=_landscape()))),
        *_framed((840.0, 210.0, BACK + 190.0), 720.0, 1240.0, Material((0.06, 0.05, 0.045)), silver,
                 turn=math.radians(12.0))]
    # a sideboard under the picture, the table before the camera, and the things on them
    sideboard = box(-1450.0, 250.0, GROUND, -420.0, BACK + 20.0, BACK + 480.0, Material((0.22, 0.12, 0.055)))
    table: list[Planar] = [Disk((60.0, -205.0, -1250.0), (0.0, 1.0, 0.0), 560.0, lacquer),
             *box(20.0, 100.0, GROUND, -206.0, -1290.0, -1210.0, ebony)]
    things = (
        Sphere((-95.0, -205.0 + 62.0, -1160.0), 62.0, Material((0.60, 0.045, 0.03), "coat")),
        Sphere((60.0, -205.0 + 78.0, -1300.0), 78.0, Material((0.985, 0.99, 0.99), "glass")),
        Sphere((205.0, -205.0 + 50.0, -1130.0), 50.0, Material((0.93, 0.72, 0.34), "metal")),
        Sphere((-235.0, -205.0 + 33.0, -1300.0), 33.0, Material((0.78, 0.56, 0.04), "coat")),
        Sphere((20.0, -205.0 + 23.0, -1010.0), 23.0, Material((0.05, 0.16, 0.42), "coat")),
        Sphere((-1150.0, -420.0 + 130.0, BACK + 250.0), 130.0, Material((0.66, 0.64, 0.58))),
        Sphere((-820.0, -420.0 + 90.0, BACK + 270.0), 90.0, Material((0.05, 0.20, 0.22), "coat")),
        Sphere((90.0, -420.0 + 110.0, BACK + 250.0), 110.0, Material((17.0, 11.2, 5.6), "lamp")),
        Sphere((-1080.0, 560.0, -3400.0), 150.0, Material((15.0, 11.0, 6.6), "lamp")))
    cord = [Rectangle((-1080.0, 1080.0, -3400.0), (5.0, 0.0, 0.0), (0.0, 371.0, 0.0), Material((0.03, 0.03, 0.03)))]
    daylight = Rectangle((RIGHT + 30.0, middle, (z0 + z1) / 2), (0.0, 0.0, pane), (0.0, half, 0.0),
                         Material((3.0, 3.4, 4.0), "lamp"))
    return Scene("room", sky=Sky((0.5, 0.75, 1.3), (1.3, 1.4, 1.5), (0.35, 0.38, 0.3)),
                 sun=Sun((0.62, 0.17, 0.42), (5.2, 3.9, 2.35), math.radians(0.5)), enclosed=True,
                 plates=tuple([*shell, *pictures, *sideboard, *table, *cord, daylight]), spheres=things,
                 ambient=(0.25, 0.242, 0.222), depth_range=(500.0, 6000.0), exposure=0.3,
                 framings=(Framing("close", (-17.0, -140.0, -1230.0), 260.0),))


TILT = math.radians(2.9)                # the table falls towards the camera, as if that looked down a little
HEIGHT = 186.0                          # mm from the table to the camera
TABLE_RIGHT, TABLE_UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, math.cos(TILT), math.sin(TILT)])
TABLE_AWAY = np.array([0.0, math.sin(TILT), -math.cos(TILT)])


def _place(across: float, away: float, above: float) -> Triple:
    """A point of the table (mm from the foot of the camera) and a height above it, in the world."""
    x, y, z = across * TABLE_RIGHT + away * TABLE_AWAY + (above - HEIGHT) * TABLE_UP
    return (float(x), float(y), float(z))


def _ball(across: float, away: float, radius: float, material: Material) -> Sphere:
    return Sphere(_place(across, away, radius), radius, material)


def _string(left: Triple, right: Triple, sag: float, count: int, seed: int) -> list[Sphere]:
    """Lights on a string between two points of (across, away, above), hanging as a parabola, a little uneven."""
    random = np.random.default_rng(seed)
    lights = []
    for j in range(count):
        u = (j + 0.5 + random.uniform(-0.22, 0.22)) / count
        x, z, y = (np.asarray(left) * (1 - u) + np.asarray(right) * u)
        warm = random.uniform(0.0, 1.0)
        colour = (16.0, 13.0 - 4.0 * warm, 9.0 - 6.0 * warm)
        lights.append(Sphere(_place(x, z + random.uniform(-250.0, 250.0), y - 4.0 * sag * u * (1 - u)
                                    + random.uniform(-25.0, 25.0)),
                             13.0, Material(colour, "light")))
    return lights


def still_life() -> Scene:
    """Glossy, metal and glass balls on a checkered table, with strings of lights far behind."""
    balls = (
        _ball(-78.0, 1278.0, 90.0, Material((0.80, 0.055, 0.022), "coat")),
        _ball(-382.0, 2010.0, 139.0, Material((0.010, 0.27, 0.33), "coat")),
        _ball(-1270.0, 4250.0, 308.0, Material((0.42, 0.42, 0.43))),
        _ball(34.0, 3380.0, 214.0, Material((0.74, 0.71, 0.64))),
        _ball(830.0, 3340.0, 176.0, Material((0.115, 0.072, 0.42), "coat")),
        _ball(282.0, 1660.0, 120.0, Material((0.93, 0.93, 0.94), "metal")),
        _ball(122.0, 990.0, 55.0, Material((0.985, 0.995, 0.99), "glass")),
        _ball(290.0, 1075.0, 38.0, Material((0.22, 0.42, 0.075))),
        _ball(-219.0, 1085.0, 28.5, Material((0.95, 0.60, 0.45), "metal")),
        _ball(34.0, 830.0, 18.5, Material((1.0, 0.76, 0.33), "metal")),
        _ball(-116.0, 630.0, 26.0, Material((0.82, 0.60, 0.022), "coat")),
    )
    lights = [
        *_string((-1900.0, 4700.0, 1120.0), (560.0, 5200.0, 1290.0), 560.0, 15, 3),
        *_string((-160.0, 5500.0, 1330.0), (2350.0, 4800.0, 1060.0), 500.0, 14, 8),
        *_string((-2300.0, 6500.0, 1500.0), (2700.0, 7300.0, 1240.0), 620.0, 16, 5),
    ]
    red = balls[0].centre
    lamps = (
        Disk((-1010.0, 700.0, -640.0), (0.72, -0.56, -0.4), 330.0, Material((47.0, 45.0, 41.6), "lamp")),
        Rectangle.facing((1150.0, 420.0, -800.0), red, 300.0, 520.0, Material((11.0, 11.8, 13.2), "lamp")),
        Rectangle.facing((0.0, 1500.0, -3000.0), (0.0, -100.0, -2600.0), 2400.0, 420.0,
                         Material((18.0, 17.6, 17.0), "lamp")),
    )
    return Scene(
        "still-life",
        sky=Sky(zenith=(0.0, 0.0, 0.0), horizon=(0.070, 0.070, 0.073), ground=(0.05, 0.05, 0.05),
                up=triple(TABLE_UP)),
        floor=Floor(height=-HEIGHT, tile=76.0, light=(0.66, 0.64, 0.61), dark=(0.045, 0.045, 0.048),
                    normal=triple(TABLE_UP), turn=math.radians(9.0), offset=(0.3, 0.15)),
        spheres=(*balls, *lights), plates=lamps, ambient=(0.06, 0.06, 0.064), depth_range=(400.0, 8000.0),
        framings=(Framing("close", triple(np.add(red, (0.0, 0.0, 80.0))), 250.0),))
