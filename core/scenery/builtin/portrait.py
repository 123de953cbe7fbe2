"""A portrait: a bust of plaster by the window of an evening room, with lamps far behind it."""

import numpy as np

from lensbench.scenery.objects import Floor, Material, Mesh, Rectangle, Sky, Sphere, Triple
from lensbench.scenery.scene import Scene

PLACE = (15.0, 25.0, -1290.0)       # mm: middle of the head
HEAD = np.array([76.0, 112.0, 96.0])    # half-axes: ear to ear, top to chin, nose to nape


def _bump(d: np.ndarray, at: Triple, width: float, height: float) -> np.ndarray:
    """A soft hill (or hollow) about a direction, as a part of the radius."""
    centre = np.asarray(at) / np.linalg.norm(at)
    return height * np.exp(-np.sum((d - centre) ** 2, -1) / width**2)


def _grid_faces(rows: int, columns: int) -> np.ndarray:
    """Triangles of a grid that closes from the last column to the first, anticlockwise from outside."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    return np.concatenate([np.stack([a, b, a + columns], -1).reshape(-1, 3),
                           np.stack([b, b + columns, a + columns], -1).reshape(-1, 3)])


def _normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    found = np.zeros(points.shape)
    for k in range(3):
        np.add.at(found, faces[:, k], normal)
    return found


def _head(material: Material) -> Mesh:
    """The head, turned a little to the right: an ellipsoid with hills and hollows."""
    rows, columns = 160, 240
    theta = np.linspace(1e-3, np.pi - 1e-3, rows)[:, None]
    phi = 2.0 * np.pi * np.arange(columns)[None] / columns
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi, np.sin(theta) * np.cos(phi)], -1)
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    radius = 1.0 + _bump(d, (0.0, 0.55, -0.75), 0.9, 0.06)                      # the back of the head
    radius += _bump(d, (0.0, -0.80, 0.55), 0.34, 0.10)                          # chin
    radius -= 0.16 * np.clip(-y, 0.0, 1.0) ** 1.5 * np.clip(-z + 0.25, 0.0, 1.0)   # towards the nape
    radius -= 0.10 * np.clip(-y - 0.1, 0.0, 1.0) * np.abs(x)                    # narrow jaw
    for s in (-1.0, 1.0):
        radius += _bump(d, (0.40 * s, 0.22, 0.88), 0.17, 0.045)                 # brow
        radius -= _bump(d, (0.36 * s, 0.06, 0.90), 0.15, 0.085)                 # eye socket
        radius += _bump(d, (0.35 * s, 0.055, 0.92), 0.075, 0.050)               # eyeball
        radius += _bump(d, (0.58 * s, -0.16, 0.76), 0.24, 0.040)                # cheek
        radius += _bump(d, (0.985 * s, -0.03, -0.10), 0.12, 0.085)              # ear
        radius -= _bump(d, (0.99 * s, -0.02, -0.03), 0.055, 0.060)
        radius += _bump(d, (0.105 * s, -0.245, 0.96), 0.060, 0.050)             # side of the nose
    for k, height in zip(np.linspace(0.0, 1.0, 7), np.linspace(0.02, 0.165, 7), strict=True):
        radius += _bump(d, (0.0, 0.16 - 0.36 * k, 0.97), 0.078, 0.62 * height)  # bridge and tip of the nose
    radius += _bump(d, (0.0, -0.42, 0.88), 0.11, 0.045) + _bump(d, (0.0, -0.56, 0.80), 0.12, 0.045)     # lips
    for k in np.linspace(-1.0, 1.0, 7):
        radius -= _bump(d, (0.17 * k, -0.487 + 0.012 * k * k, 0.86), 0.034, 0.028)                      # mouth
    # Hair: a cap with waves, parted at the side
    front = np.clip(z, 0.0, 1.0)
    line = y - 0.30 - (0.30 + 0.25 * np.abs(x)) * front + 0.9 * np.clip(-z, 0.0, 1.0)
    hair = 1.0 / (1.0 + np.exp(-line / 0.03))
    radius += hair * (0.06 + 0.014 * np.sin(26.0 * phi + 7.0 * np.sin(4.0 * theta)) * np.sin(theta))
    points = (radius[..., None] * d * HEAD).reshape(-1, 3)
    turn = np.radians(24.0)
    c, s = np.cos(turn), np.sin(turn)
    points = points @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]]) + PLACE
    faces = _grid_faces(rows, columns)
    return Mesh.of(points, faces, material, normals=_normals(points, faces), name="bust")


def _torso(material: Material) -> Mesh:
    """Neck and shoulders: rings from below the chin to a round cut."""
    heights = np.array([-50.0, -85.0, -115.0, -140.0, -165.0, -190.0, -225.0, -270.0, -320.0, -360.0, -380.0, -384.0])
    wide = np.array([52.0, 50.0, 52.0, 62.0, 102.0, 150.0, 186.0, 200.0, 186.0, 140.0, 84.0, 0.5])
    deep = np.array([50.0, 50.0, 51.0, 56.0, 66.0, 78.0, 90.0, 96.0, 92.0, 78.0, 60.0, 0.5])
    fine = np.linspace(0.0, len(heights) - 1.0, 90)
    at = np.arange(len(heights))
    heights, wide, deep = (np.interp(fine, at, values) for values in (heights, wide, deep))
    kernel = np.hanning(11) / np.hanning(11).sum()
    wide, deep = (np.convolve(np.pad(values, 5, mode="edge"), kernel, "valid") for values in (wide, deep))
    phi = 2.0 * np.pi * np.arange(160) / 160
    points = np.stack(np.broadcast_arrays(wide[:, None] * np.sin(phi), heights[:, None],
                                          deep[:, None] * np.cos(phi) - 12.0), -1).reshape(-1, 3) + PLACE
    faces = _grid_faces(len(fine), 160)
    return Mesh.of(points, faces, material, normals=_normals(points, faces), name="bust")


def portrait() -> Scene:
    """Focus at 1.2 m on the nearer eye; 85 mm and f/1.4 dissolve the lamps behind."""
    plaster = Material((0.80, 0.745, 0.68))
    random = np.random.default_rng(4)
    lights = []
    for _ in range(70):
        away = float(np.exp(random.uniform(np.log(4200.0), np.log(16000.0))))
        x, y = away * random.uniform(-0.42, 0.42), away * random.uniform(-0.10, 0.24)
        warm = np.array([13.0, 7.4, 2.6]) if random.random() < 0.7 else np.array([5.0, 7.0, 11.0])
        red, green, blue = (float(c) for c in warm * random.uniform(0.5, 1.4))
        lights.append(Sphere((x, y, -away), 2.4e-3 * away, Material((red, green, blue), "light")))
    base = PLACE[1] - 384.0
    window = Rectangle.facing((-1500.0, 700.0, -900.0), PLACE, 900.0, 1300.0, Material((7.0, 7.4, 8.4), "lamp"))
    fire = Rectangle.facing((1300.0, 100.0, -2300.0), PLACE, 500.0, 700.0, Material((11.0, 5.6, 2.2), "lamp"))
    wall = Rectangle((0.0, 600.0, -17000.0), (9000.0, 0.0, 0.0), (0.0, 3600.0, 0.0), Material((0.16, 0.12, 0.10)))
    return Scene("portrait", sky=Sky((0.05, 0.06, 0.09), (0.10, 0.09, 0.09), (0.05, 0.04, 0.035)),
                 floor=Floor(base, 420.0, (0.20, 0.13, 0.08), (0.15, 0.095, 0.055)), spheres=tuple(lights),
                 plates=(window, fire, wall), meshes=(_head(plaster), _torso(plaster)), ambient=(0.03, 0.03, 0.035),
                 depth_range=(700.0, 17e3))
