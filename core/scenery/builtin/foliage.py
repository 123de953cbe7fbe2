"""Foliage against the light: a twig in focus before leaves and gaps of sky that make large discs of blur."""

import math

import numpy as np

from lensbench.core.scenery.builtin.building_parts import tube
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.planar import Rectangle
from lensbench.core.scenery.objects.sphere import Sphere
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Scene

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
    """Focus at 1.2 m on the twig; a fast old lens shows swirl and cat's eyes in the gaps behind."""
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
