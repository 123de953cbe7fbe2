"""Scenes outdoors: foliage against the light, and a toy fairground in the evening sun, which moves."""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from lensbench.core.scenery.builtin.building_parts import bar, box, ring, spokes, tube
from lensbench.core.scenery.objects.basic_shapes import Disk, Rectangle, Sphere
from lensbench.core.scenery.objects.material import Material, Pattern
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.shape import Shape, by_family
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Framing, Scene
from lensbench.core.scenery.values import Triple, across, triple, unit

FOCUS = 1200.0          # mm: the twig
CORNERS = 14            # of a leaf: six along its middle, four along each edge
EDGES = np.repeat([1.0, 0.72], [6, 8])[:, None]     # light that passes: most along the middle


def _leaves(count: int, centres: np.ndarray, sizes: np.ndarray, random: np.random.Generator
            ) -> tuple[np.ndarray, np.ndarray]:
    """Corners (14 n, 3) and triangles (16 n, 3) of n pointed leaves, folded along the middle and bent."""
    along = np.array([0.0, 0.12, 0.32, 0.55, 0.78, 1.0])
    across = np.array([0.0, 0.17, 0.27, 0.25, 0.14, 0.0])
    fold, bend = 0.12, -0.18
    middle = np.stack([along, bend * along**2, 0.0 * along], -1)
    right = middle + np.stack([0.0 * along, fold * across / 0.3, across], -1)
    left = right * [1.0, 1.0, -1.0]
    one = np.concatenate([middle, right[1:5], left[1:5]])
    faces = [[0, 6, 1], [4, 9, 5], [0, 1, 10], [4, 5, 13]]
    for k in range(1, 4):
        faces += [[k, 5 + k, 6 + k], [k, 6 + k, k + 1], [k, 10 + k, 9 + k], [k, k + 1, 10 + k]]
    rows = np.array(faces)
    frames = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    frames[:, :, 1] = np.abs(frames[:, :, 1]) * [0.6, 1.0, 0.6]             # rather level, as leaves lie
    points = np.einsum("nij,kj->nki", frames, one) * sizes[:, None, None] + centres[:, None]
    return points.reshape(-1, 3), (rows + CORNERS * np.arange(count)[:, None, None]).reshape(-1, 3)


def _crown(count: int, low: tuple[float, float, float], high: tuple[float, float, float], size: float, glow: float,
           seed: int, name: str) -> list[Mesh]:
    """Leaves in a box: those that the sun shines through, and those in the shade of others."""
    random = np.random.default_rng(seed)
    meshes = []
    for fraction, shining in ((0.45, True), (0.55, False)):
        n = int(count * fraction)
        centres = random.uniform(low, high, (n, 3))
        points, faces = _leaves(n, centres, size * random.uniform(0.6, 1.3, n), random)
        tint = np.array([0.55, 0.85, 0.10]) * (1.0 - 0.5 * random.random((n, 1)))
        tint += random.random((n, 1)) * [0.5, 0.1, 0.0]
        colours = np.repeat(tint * random.uniform(0.4, 1.0, (n, 1)), CORNERS, 0) * np.tile(EDGES, (n, 1))
        material = Material((glow, glow, glow), "light") if shining else Material((0.30, 0.42, 0.16))
        meshes.append(Mesh.of(points, faces, material, colours=colours if shining else None, name=name))
    return meshes


def foliage() -> Scene:
    """A twig before a wood; a fast old lens shows swirl and cat's eyes in the gaps behind."""
    random = np.random.default_rng(21)
    # The twig: leaves along a bow from the lower left to the upper right, and its stem
    t = np.linspace(0.0, 1.0, 22)
    bow = np.column_stack([-330.0 + 620.0 * t, -150.0 + 210.0 * np.sin(1.7 * t), -FOCUS - 60.0 * np.sin(6.0 * t)])
    points, faces = _leaves(len(t), bow, random.uniform(65.0, 105.0, len(t)), random)
    greens = random.uniform([0.30, 0.55, 0.05], [0.55, 0.95, 0.12], (len(t), 3))
    tint = np.repeat(greens, CORNERS, 0) * np.tile(EDGES, (len(t), 1))
    twig = [Mesh.of(points, faces, Material((0.95, 0.95, 0.95), "light"), colours=tint, name="twig")]
    twig.append(tube(bow, 2.6, Material((0.10, 0.06, 0.035))))
    crowns = [*_crown(260, (-1500.0, -500.0, -3200.0), (1500.0, 900.0, -2300.0), 130.0, 0.9, 1, "bush"),
              *_crown(1500, (-4200.0, -700.0, -8500.0), (4200.0, 2600.0, -5000.0), 240.0, 0.75, 2, "tree"),
              *_crown(2600, (-11000.0, -900.0, -22000.0), (11000.0, 7000.0, -13000.0), 520.0, 0.6, 3, "wood")]
    trunks = [tube(np.array([[x, -900.0, -z], [x + lean, 6500.0, -z]]), radius, Material((0.07, 0.05, 0.035)))
              for x, z, lean, radius in ((-2300.0, 7200.0, 260.0, 150.0), (1500.0, 8400.0, -200.0, 190.0),
                                         (3900.0, 13000.0, 150.0, 260.0), (-6200.0, 15000.0, -350.0, 300.0))]
    # Glints of the sun between the leaves and on wet ones
    glints = []
    for _ in range(110):
        away = float(np.exp(random.uniform(math.log(2600.0), math.log(20000.0))))
        x, y = away * random.uniform(-0.45, 0.45), away * random.uniform(-0.16, 0.36)
        warm = random.uniform(0.5, 1.0)
        glints.append(Sphere((x, y, -away), 1.6e-3 * away, Material((30.0, 27.0 * warm + 3.0, 24.0 * warm), "light")))
    glow = Rectangle((0.0, 3000.0, -26000.0), (26000.0, 0.0, 0.0), (0.0, 9000.0, 0.0),
                     Material((1.5, 1.6, 1.05), "light"))
    return Scene("foliage", sky=Sky((0.5, 0.7, 1.0), (1.6, 1.6, 1.3), (0.10, 0.12, 0.05)),
                 sun=Sun((0.25, 0.75, -0.6), (3.0, 2.7, 2.1)),
                 floor=Floor(-900.0, 900.0, (0.16, 0.20, 0.07), (0.10, 0.13, 0.05)), spheres=tuple(glints),
                 plates=(glow,), meshes=(*twig, *crowns, *trunks), depth_range=(600.0, 25e3))


GROUND = -150.0         # mm, the boards below the camera
RED, CREAM, TEAL = (0.62, 0.05, 0.035), (0.80, 0.70, 0.50), (0.02, 0.30, 0.32)
YELLOW, BLUE, ROSE = (0.85, 0.55, 0.05), (0.05, 0.12, 0.45), (0.70, 0.22, 0.25)
WARM = (15.0, 9.5, 4.2)

Things = list[Shape]


def _moving(things: Iterable[Shape], velocity: Triple = (0.0, 0.0, 0.0), spin: Triple = (0.0, 0.0, 0.0),
            pivot: Triple | None = None) -> Things:
    return [replace(thing, velocity=velocity, spin=spin, pivot=pivot) for thing in things]


def _big_wheel() -> Things:
    """Two rims with cabins and bulbs between them, a turn in six seconds; its legs stand still."""
    centre, axis, radius = np.array([215.0, 190.0, -2250.0]), unit((-0.45, 0.0, 1.0)), 285.0
    right, up = across(axis)
    steel, paint = Material((0.55, 0.55, 0.56)), Material((0.72, 0.70, 0.66))
    turning: Things = []
    for side in (-38.0, 38.0):
        middle = triple(centre + side * axis)
        turning += ring(middle, triple(axis), radius, 32, 9.0, paint)
        turning += ring(middle, triple(axis), 0.55 * radius, 16, 5.0, paint)
        turning += spokes(middle, triple(axis), 0.0, radius, 16, 4.0, [steel])
    colours = [RED, YELLOW, TEAL, CREAM, BLUE, ROSE, TEAL, YELLOW]
    for k in range(16):
        angle = 2.0 * math.pi * (k + 0.5) / 16
        out = math.cos(angle) * right + math.sin(angle) * up
        if k % 2:
            turning.append(Sphere(triple(centre + radius * out), 27.0, Material(colours[k // 2], "coat")))
        turning.append(Sphere(triple(centre + (radius + 12.0) * out + 44.0 * axis), 6.5, Material(WARM, "light")))
        turning.append(Sphere(triple(centre + 0.55 * radius * out + 44.0 * axis), 4.5, Material(WARM, "light")))
    turning.append(Disk(triple(centre + 40.0 * axis), triple(axis), 24.0, Material(
        RED, pattern=Pattern("star", CREAM, columns=8.0))))
    legs: Things = []
    for side in (-52.0, 52.0):
        for foot in (-150.0, 150.0):
            top, down = centre + side * axis, centre + side * axis + foot * right
            legs.append(bar(triple(top), (float(down[0]), GROUND, float(down[2])), 13.0, (0.0, 0.0, 0.0),
                            Material((0.16, 0.20, 0.24))))
    return _moving(turning, spin=triple(axis * 1.05), pivot=triple(centre)) + legs


def _tram() -> Things:
    """A tram of 0.4 m on its rails, at 0.6 m/s to the right."""
    left, near, far, length = -470.0, -1560.0, -1680.0, 420.0
    floor, sill, roof = GROUND + 26.0, GROUND + 78.0, GROUND + 132.0
    x0, x1, velocity = left, left + length, (600.0, 0.0, 0.0)
    body: Things = [
        *box(x0, x1, floor, sill, far, near, Material(RED, "coat")),
        *box(x0, x1, sill, roof, far, near, Material(CREAM)),
        *box(x0 - 8.0, x1 + 8.0, roof, roof + 9.0, far - 6.0, near + 6.0, Material((0.10, 0.12, 0.11))),
        *box(x0 + 60.0, x1 - 60.0, roof + 9.0, roof + 24.0, far + 30.0, near - 30.0, Material((0.30, 0.31, 0.30)))]
    for k in range(6):
        middle = x0 + length * (k + 0.5) / 6.0
        body.append(Rectangle((middle, (sill + roof) / 2.0, near + 1.0), (25.0, 0.0, 0.0), (0.0, 17.0, 0.0),
                              Material((0.035, 0.05, 0.065), "coat")))
    body.append(Rectangle(((x0 + x1) / 2.0, sill - 4.0, near + 1.0), (length / 2.0, 0.0, 0.0), (0.0, 2.2, 0.0),
                          Material((0.85, 0.66, 0.25))))
    body.append(Sphere((x1 + 4.0, floor + 20.0, (near + far) / 2.0), 9.0, Material((18.0, 15.0, 10.0), "light")))
    body.append(Sphere((x0 - 3.0, floor + 20.0, near - 20.0), 5.0, Material((12.0, 0.6, 0.3), "light")))
    moving = _moving(body, velocity)
    wheel = Material((0.62, 0.60, 0.56), pattern=Pattern("star", (0.05, 0.05, 0.055), columns=7.0))
    for x in (x0 + 62.0, x0 + 132.0, x1 - 132.0, x1 - 62.0):
        moving += _moving([Disk((x, GROUND + 27.0, near + 2.0), (0.0, 0.0, 1.0), 24.0, wheel)], velocity,
                          (0.0, 0.0, -velocity[0] / 24.0))
    steel = Material((0.42, 0.41, 0.40))
    rails: Things = [Rectangle((0.0, GROUND + 2.5, z), (4000.0, 0.0, 0.0), (0.0, 0.0, 3.0), steel)
                     for z in (near - 12.0, far + 12.0)]
    return moving + rails


def _pinwheel(centre: Triple, radius: float, rate: float, colours: list[Triple], axis: Triple) -> Things:
    """A paper windmill on a stick: `rate` turns a second."""
    blades = spokes(centre, axis, 0.10 * radius, radius, 8, 0.62 * radius, [Material(c) for c in colours], 0.45)
    head: Things = [*blades, Sphere(triple(np.add(centre, 8.0 * unit(axis))), 0.12 * radius,
                                    Material((0.95, 0.75, 0.38), "metal"))]
    back = np.subtract(centre, 12.0 * unit(axis))
    stick = bar(triple(back), (float(back[0]), GROUND, float(back[2])), 6.5, (0.0, 0.0, 0.0),
                Material((0.80, 0.77, 0.70)))
    return [*_moving(head, spin=triple(unit(axis) * 2.0 * math.pi * rate), pivot=centre), stick]


def _posts() -> Things:
    """Striped posts, as upright as a rolling shutter lets them be, and strings of bulbs between them."""
    stripes = Material((0.82, 0.80, 0.74), pattern=Pattern("checker", RED, columns=1.0, rows=14.0))
    places = [-1080.0, -720.0, -360.0, 0.0, 360.0, 720.0, 1080.0]
    top, away = GROUND + 420.0, -1900.0
    things: Things = []
    for x in places:
        things.append(Rectangle((x, (GROUND + top) / 2.0, away), (9.0, 0.0, 0.0), (0.0, (top - GROUND) / 2.0, 0.0),
                                stripes))
        things.append(Sphere((x, top + 15.0, away), 15.0, Material((0.80, 0.62, 0.22), "metal")))
    random = np.random.default_rng(4)
    for x0, x1 in zip(places[:-1], places[1:], strict=True):
        for k in range(7):
            u = (k + 0.5) / 7.0
            warm = random.uniform(0.8, 1.2)
            things.append(Sphere((x0 + u * (x1 - x0), top - 4.0 * 75.0 * u * (1.0 - u), away + 10.0), 5.0,
                                 Material(triple(np.array(WARM) * warm), "light")))
    return things


def _apples() -> Things:
    """Candied apples on sticks, and a steel ball that rolls among them."""
    things: Things = []
    for x, z, radius, colour in ((28.0, -1190.0, 46.0, (0.58, 0.02, 0.012)), (136.0, -1110.0, 39.0, (0.24, 0.38, 0.02)),
                                 (232.0, -1280.0, 47.0, (0.62, 0.16, 0.01))):
        things.append(Sphere((x, GROUND + radius, z), radius, Material(colour, "coat")))
        foot = (x + 3.0, GROUND + 1.9 * radius, z)
        things.append(bar(foot, (x + 14.0, GROUND + 2.0 * radius + 62.0, z - 6.0), 6.0, (0.0, 0.0, 0.0),
                          Material((0.72, 0.56, 0.34))))
    ball = Sphere((-20.0, GROUND + 22.0, -960.0), 22.0, Material((0.93, 0.93, 0.94), "metal"))
    return [*things, *_moving([ball], velocity=(260.0, 0.0, -25.0))]


def fairground() -> Scene:
    """Apples, a tram and wheels: 1/125 to 1/30 s shows their motion, a read-out of 1/40 s bends the pinwheels."""
    things = [
        *_big_wheel(), *_tram(), *_posts(), *_apples(),
        *_pinwheel((-205.0, 42.0, -1150.0), 84.0, 4.0, [RED, CREAM], (0.25, 0.05, 1.0)),
        *_pinwheel((-330.0, 5.0, -1370.0), 66.0, -2.7, [TEAL, YELLOW], (0.1, 0.0, 1.0)),
        *_pinwheel((330.0, 15.0, -1330.0), 62.0, 3.3, [BLUE, ROSE, CREAM, YELLOW], (-0.3, 0.0, 1.0))]
    spheres, planar = by_family(things)
    return Scene(
        "fairground", sky=Sky((0.03, 0.09, 0.30), (0.34, 0.38, 0.46), (0.16, 0.13, 0.11)),
        sun=Sun((-0.66, 0.40, 0.50), (2.3, 1.45, 0.74), math.radians(1.0)),
        floor=Floor(GROUND, 58.0, (0.34, 0.235, 0.15), (0.26, 0.175, 0.11), turn=math.radians(45.0)),
        spheres=tuple(spheres), plates=tuple(planar),
        ambient=(0.05, 0.05, 0.06), depth_range=(700.0, 8000.0),
        framings=(Framing("close", (130.0, GROUND + 45.0, -1150.0), 270.0),))
