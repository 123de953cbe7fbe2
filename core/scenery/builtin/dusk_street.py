"""A street in the blue hour: a bicycle before lit windows, signs and lamps along a wet road."""

import numpy as np

from lensbench.core.scenery.builtin.building_parts import BEAM, bicycle, lettering
from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.planar import Disk, Rectangle
from lensbench.core.scenery.objects.sphere import Sphere
from lensbench.core.scenery.objects.surroundings import Floor, Sky
from lensbench.core.scenery.scene import Scene
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
    """The bicycle stands in focus; windows, signs, lamps and their reflections go on to 60 m."""
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
                 ambient=(0.02, 0.022, 0.035), depth_range=(2000.0, 70e3), subject=(BICYCLE, 1560.0))
