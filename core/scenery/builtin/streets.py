"""Streets: in the blue hour, a bicycle before lit windows and signs; at night, lights behind a crystal ball."""

import numpy as np

from lensbench.core.scenery.builtin.building_parts import BEAM, bicycle, lettering
from lensbench.core.scenery.objects.basic_shapes import Disk, Rectangle, Sphere
from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Framing, Scene
from lensbench.core.scenery.values import Triple, triple

GROUND = -640.0         # mm: the camera is low, as on one knee
RISE = GROUND + 1500.0  # of what hangs
BICYCLE = 4600.0        # its distance
HALF = 4200.0           # of the street, from front to front
TEXELS = 12             # of a window and the wall around it, along a side


def _front(bays: int, floors: int, seed: int) -> tuple[Image, Image]:
    """Radiance and albedo of a front: windows, some lit, a shop below, and bricks."""
    random = np.random.default_rng(seed)
    height, width = (floors + 1) * TEXELS, bays * TEXELS
    brick = np.array([[0.34, 0.20, 0.15], [0.42, 0.36, 0.28], [0.28, 0.27, 0.27], [0.45, 0.30, 0.20]])[seed % 4]
    albedo = brick * (0.85 + 0.15 * random.random((height, width, 1)))
    shine = np.zeros((height, width, 3))
    for line in range(floors):
        for bay in range(bays):
            top, left = line * TEXELS + 3, bay * TEXELS + 3
            albedo[top - 1:top + 8, left - 1:left + 7] = 0.5                # the frame
            albedo[top:top + 7, left:left + 6] = 0.03
            if random.random() < 0.42:
                warm = random.random()
                glow = (warm * np.array([1.5, 0.85, 0.36]) + (1.0 - warm) * np.array([1.05, 0.95, 0.72])) * (
                    random.uniform(0.5, 1.5))
                shine[top:top + 7, left:left + 6] = glow
                if random.random() < 0.5:                                   # a blind, or curtains
                    shine[top:top + random.integers(2, 5), left:left + 6] *= 0.4
                else:
                    shine[top:top + 7, [left, left + 5]] *= 0.3
            shine[top:top + 7, left + 3] *= 0.2
    # The shop: panes of light above a dark base, under an awning
    base = floors * TEXELS
    colour = [np.array([2.4, 1.7, 0.9]), np.array([1.5, 2.1, 2.3]), np.array([2.3, 1.2, 0.8])][seed % 3]
    albedo[base:] = 0.06
    albedo[base:base + 2] = [0.35, 0.06, 0.05] if seed % 2 else [0.05, 0.20, 0.12]
    for bay in range(bays):
        left = bay * TEXELS
        shine[base + 3:base + 10, left + 1:left + 11] = 0.55 * colour * (0.6 + 0.4 * random.random((7, 10, 1)))
    return Image.of(shine), Image.of(albedo)


def _house(side: float, near: float, far: float, bays: int, floors: int, seed: int) -> list[Mesh]:
    """A house on one side of the street: its front, and the walls that rise above or project beyond its neighbours."""
    shine, albedo = _front(bays, floors, seed)
    top, x = GROUND + 3400.0 + 2900.0 * floors, side * HALF
    # The corner of the picture at 0, 0 is at the left of the front for someone who looks at it
    z0, z1 = (-near, -far) if side < 0.0 else (-far, -near)
    front = np.array([[x, GROUND, z0], [x, GROUND, z1], [x, top, z1], [x, top, z0]])
    uv, faces = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    glow = Material((1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=shine))
    lit = front - [side * 6.0, 0.0, 0.0]
    dark = shine.values.max(2) == 0.0
    wall = Material((1.0, 1.0, 1.0), pattern=Pattern("image", image=albedo))
    plain = Material((0.16, 0.14, 0.13))
    deep = x + side * 7000.0
    end = np.array([[x, GROUND, -near], [deep, GROUND, -near], [deep, top, -near], [x, top, -near]])
    roof = np.array([[x, top, -near], [deep, top + 2600.0, -near], [deep, top + 2600.0, -far], [x, top, -far]])
    meshes = [Mesh.of(front, faces, wall, uv=uv, name="front"), Mesh.of(end, faces, plain, name="wall"),
             Mesh.of(roof, faces, Material((0.10, 0.07, 0.065)), name="roof")]
    # Only the panes shine: a quad for each run of bright texels in a row
    quads, places = [], []
    rows, columns = dark.shape
    for row in range(rows):
        edges = np.flatnonzero(np.diff(np.concatenate([[1], dark[row], [1]]).astype(int)))
        for left, right in zip(edges[::2], edges[1::2], strict=True):
            u0, u1, v0, v1 = left / columns, right / columns, 1.0 - (row + 1) / rows, 1.0 - row / rows
            for u, v in ((u0, v0), (u1, v0), (u1, v1), (u0, v1)):
                quads.append(lit[0] + u * (lit[1] - lit[0]) + v * (lit[3] - lit[0]))
                places.append((u, v))
    k = 4 * np.arange(len(quads) // 4)[:, None]
    panes = np.concatenate([k + [0, 1, 2], k + [0, 2, 3]])
    return [*meshes, Mesh.of(np.array(quads), panes, glow, uv=np.array(places), name="windows")]


def _sign(text: str, x: float, y: float, z: float, high: float, colour: Triple) -> Rectangle:
    """A luminous sign across the pavement, seen along the street."""
    dots = np.pad(lettering(text), 1)
    width = high * dots.shape[1] / dots.shape[0]
    image = Image.of(np.kron(dots, np.ones((4, 4)))[..., None] * np.asarray(colour) + np.asarray(colour) * 0.015)
    return Rectangle((x, y + RISE, z), (width / 2.0, 0.0, 0.0), (0.0, high / 2.0, 0.0),
                     Material((1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=image)))


def dusk_street() -> Scene:
    """A bicycle in the blue hour; windows, signs, lamps and their reflections go on to 60 m."""
    random = np.random.default_rng(8)
    houses: list[Mesh] = []
    for side, seed in ((-1.0, 1), (1.0, 2)):
        near = 3000.0
        for _ in range(7):
            bays, floors = int(random.integers(3, 6)), int(random.integers(2, 5))
            houses += _house(side, near, near + 1900.0 * bays, bays, floors, seed)
            near, seed = near + 1900.0 * bays, seed + 5
    signs = [_sign(text, x, y, -z, high, colour) for text, x, y, z, high, colour in (
        ("24", -3300.0, 900.0, 8200.0, 620.0, (9.0, 1.0, 1.6)),
        ("50.2", 3200.0, 1250.0, 11000.0, 520.0, (1.0, 6.5, 8.0)),
        ("1.4", -3300.0, 1500.0, 17000.0, 760.0, (8.0, 5.2, 0.9)),
        ("85", 3250.0, 1500.0, 21000.0, 900.0, (2.0, 8.0, 2.4)),
        ("35m", -3200.0, 2000.0, 29000.0, 1100.0, (4.6, 1.6, 9.0)))]
    posts, lights = [], []
    for z in (1500.0, 6000.0, 12500.0, 19000.0, 27000.0, 37000.0, 50000.0):
        for side in (-1.0, 1.0):
            x = side * 2750.0
            posts.append(Rectangle((x, RISE + 150.0, -z), (45.0, 0.0, 0.0), (0.0, 1650.0, 0.0),
                                   Material((0.03, 0.03, 0.035))))
            kind, colour = ("lamp", (95.0, 62.0, 30.0)) if z < 15000.0 else ("light", (40.0, 26.0, 12.0))
            lights.append(Sphere((x, RISE + 1890.0, -z), 130.0, Material(colour, kind)))
    for z in (15000.0, 24000.0, 33000.0, 46000.0):
        for dx in (-620.0, 620.0):
            lights.append(Sphere((-1150.0 + dx, RISE - 850.0, -z), 75.0, Material((30.0, 28.0, 23.0), "light")))
            lights.append(Sphere((1250.0 + dx, RISE - 800.0, -z - 3000.0), 70.0, Material((22.0, 1.2, 0.5), "light")))
    turn, stand = -0.55, np.array([60.0, GROUND, -BICYCLE])
    front = stand + [BEAM[0] * np.cos(turn), BEAM[1], -BEAM[0] * np.sin(turn)]
    lights.append(Sphere(triple(front), 40.0, Material((16.0, 13.0, 8.0), "light")))
    ridden = bicycle(turn, stand, Material((0.62, 0.035, 0.03), "coat", gloss=0.97))
    water = Material((0.30, 0.31, 0.34), "metal")
    puddle = [Disk((x, GROUND + 1.0, -BICYCLE + z), (0.0, 1.0, 0.0), radius, water) for x, z, radius in (
        (-250.0, 60.0, 420.0), (180.0, 330.0, 330.0), (420.0, -60.0, 400.0), (-640.0, -140.0, 250.0),
        (760.0, 260.0, 190.0), (0.0, -420.0, 470.0), (-180.0, 420.0, 210.0),
        (-1500.0, -1800.0, 500.0), (1300.0, -2600.0, 700.0))]
    return Scene("dusk-street", sky=Sky((0.02, 0.05, 0.19), (0.17, 0.17, 0.30), (0.02, 0.02, 0.03)),
                 floor=Floor(GROUND, 480.0, (0.17, 0.16, 0.16), (0.14, 0.135, 0.135), gloss=0.94),
                 spheres=tuple(lights), plates=(*signs, *posts, *puddle), meshes=(*houses, *ridden),
                 ambient=(0.02, 0.022, 0.035), depth_range=(2000.0, 70e3), subject=(BICYCLE, 1560.0), exposure=1.0)


def low_sun() -> Scene:
    """The sun stands low over a wet street, among small bright lamps: they have stars at f/16, and the sun ghosts."""
    houses: list[Mesh] = []
    for side, near, bays, seed in ((-1.0, 3000.0, 5, 1), (-1.0, 12500.0, 4, 6), (-1.0, 20100.0, 5, 11),
                                   (1.0, 7000.0, 3, 2)):
        houses += _house(side, near, near + 1900.0 * bays, bays, 2, seed)
    posts, lamps = [], []
    for z in (6500.0, 9500.0, 14000.0, 20000.0, 28000.0, 38000.0):
        for x in (-2450.0, 2450.0):
            posts.append(Rectangle((x, GROUND + 1300.0, -z), (35.0, 0.0, 0.0), (0.0, 1300.0, 0.0),
                                   Material((0.03, 0.03, 0.035))))
            lamps.append(Sphere((x, GROUND + 2640.0, -z), 22.0, Material((2600.0, 1900.0, 1050.0), "light")))
    ridden = bicycle(-0.55, np.array([60.0, GROUND, -BICYCLE]), Material((0.03, 0.16, 0.40), "coat", gloss=0.97))
    return Scene("low-sun", sun=Sun((0.105, 0.10, -1.0), (1.7, 0.95, 0.42)),
                 sky=Sky((0.01, 0.05, 0.22), (0.34, 0.15, 0.07), (0.05, 0.04, 0.04)),
                 floor=Floor(GROUND, 480.0, (0.17, 0.16, 0.16), (0.14, 0.135, 0.135), gloss=0.94),
                 spheres=tuple(lamps), plates=tuple(posts), meshes=(*houses, *ridden),
                 ambient=(0.07, 0.07, 0.09), depth_range=(2000.0, 70e3), subject=(BICYCLE, 1560.0))


STREET = -1350.0        # mm, the street below the camera
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
    bottom = STREET * 1e-3
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
    """A crystal ball before the lights of a city; f/2 shows the cat's eyes."""
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
                 floor=Floor(STREET, 600.0, (0.030, 0.030, 0.034), (0.020, 0.020, 0.023), gloss=0.955),
                 spheres=(ball, *lights), plates=(*skyline, *table, *shops), ambient=(0.02, 0.018, 0.02),
                 depth_range=(800.0, 100e3), exposure=1.7,
                 framings=(Framing("close", ball.centre, 270.0), Framing("whole-scene", (0.0, 150.0, -1210.0), 1400.0)))
