"""The still life: coated, metal and glass balls on a checkered table, under studio lamps."""

import math

import numpy as np

from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.planar import Disk, Rectangle
from lensbench.core.scenery.objects.sphere import Sphere
from lensbench.core.scenery.objects.surroundings import Floor, Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import Triple, triple

TILT = math.radians(2.9)                # the table falls towards the camera, as if that looked down a little
HEIGHT = 186.0                          # mm from the table to the camera
RIGHT, UP, AWAY = np.array([1.0, 0.0, 0.0]), np.array([0.0, math.cos(TILT), math.sin(TILT)]), np.array(
    [0.0, math.sin(TILT), -math.cos(TILT)])


def _place(across: float, away: float, above: float) -> Triple:
    """A point of the table (mm from the foot of the camera) and a height above it, in the world."""
    x, y, z = across * RIGHT + away * AWAY + (above - HEIGHT) * UP
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
    """Focus at 1.2 m on the red ball."""
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
                up=triple(UP)),
        floor=Floor(height=-HEIGHT, tile=76.0, light=(0.66, 0.64, 0.61), dark=(0.045, 0.045, 0.048),
                    normal=triple(UP), turn=math.radians(9.0), offset=(0.3, 0.15)),
        spheres=(*balls, *lights), plates=lamps, ambient=(0.06, 0.06, 0.064), depth_range=(400.0, 8000.0))
