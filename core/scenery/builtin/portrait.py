"""A portrait: a bust of glazed clay by the window of an evening room, with lamps far behind it."""

import numpy as np

from lensbench.core.scenery.objects.basic_shapes import Rectangle, Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.surroundings import Floor, Sky
from lensbench.core.scenery.scene import Scene

PLACE = (15.0, 25.0, -1290.0)       # mm: middle of the head
HEAD = np.array([76.0, 112.0, 96.0])    # half-axes: ear to ear, top to chin, nose to nape


def _hill(a: np.ndarray, e: np.ndarray, top: tuple[float, float], wide: float, high: float, size: float) -> np.ndarray:
    """A soft hill (or hollow) at an azimuth and elevation (radians), as a part of the radius."""
    return size * np.exp(-((a - top[0]) / wide) ** 2 - ((e - top[1]) / high) ** 2)


def _rise(x: np.ndarray, width: float) -> np.ndarray:
    """0 below x = 0, 1 above it, soft over a width."""
    return 0.5 + 0.5 * np.tanh(x / width)


def _grid_faces(rows: int, columns: int) -> np.ndarray:
    """Triangles of a grid that closes from the last column to the first, anticlockwise from outside."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    return np.concatenate([np.stack([a, b, a + columns], -1).reshape(-1, 3),
                           np.stack([b, b + columns, a + columns], -1).reshape(-1, 3)])


def _normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    corners = faces.T.ravel()
    return np.stack([np.bincount(corners, np.tile(normal[:, k], 3), len(points)) for k in range(3)], -1)


def _skull(a: np.ndarray, e: np.ndarray) -> np.ndarray:
    """The radius of the head without hair in directions of azimuth 0 ahead and elevation (radians), about 1."""
    x, y, z = np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)
    radius = 1.0 + 0.06 * np.exp(-(x**2 + (y - 0.55) ** 2 + (z + 0.75) ** 2) / 0.81)       # the back of the head
    radius -= 0.16 * np.clip(-y, 0.0, 1.0) ** 1.5 * np.clip(0.25 - z, 0.0, 1.0)            # towards the nape
    radius -= 0.06 * np.clip(-y - 0.15, 0.0, 1.0) * np.abs(x)                              # narrow jaw
    radius += _hill(a, e, (0.0, 0.15), 0.13, 0.08, 0.016) + _hill(a, e, (0.0, -0.84), 0.30, 0.15, 0.095)    # brow, chin
    radius += _hill(a, e, (0.0, -0.58), 0.42, 0.22, 0.045)                                  # behind the lips
    for s in (-1.0, 1.0):
        side, tilt = s * a, e + 0.10 * (s * a - 0.36)                   # eyes and brows fall a little outwards
        radius += _hill(side, tilt, (0.36, 0.185), 0.25, 0.065, 0.034)                     # brow
        radius += _hill(side, tilt, (0.36, 0.235), 0.23, 0.018, 0.009)                     # its hair
        radius += _hill(side, tilt, (0.35, 0.045), 0.16, 0.095, -0.070)                    # eye socket
        radius += _hill(side, e, (0.155, 0.05), 0.07, 0.10, -0.034)                        # inner corner
        radius += _hill(side, tilt, (0.36, 0.030), 0.105, 0.062, 0.056)                    # eyeball
        across = np.exp(-((side - 0.36) / 0.115) ** 4)
        arch = (side - 0.36) ** 2
        for line, width, size in ((0.088 - 1.6 * arch, 0.012, -0.016), (0.058 - 2.6 * arch, 0.013, 0.013),
                                  (0.036 - 2.6 * arch, 0.008, -0.013), (-0.020 + 1.6 * arch, 0.010, 0.007),
                                  (-0.052 + 1.2 * arch, 0.014, -0.007)):       # lids, their edges and creases
            radius += size * across * np.exp(-((tilt - line) / width) ** 2)
        radius += _hill(side, e, (0.60, -0.13), 0.22, 0.12, 0.030)                         # cheekbone
        radius += _hill(side, e, (0.50, -0.48), 0.16, 0.17, -0.020)                        # hollow below it
        radius += _hill(side, e, (0.125, -0.355), 0.050, 0.050, 0.062)                     # wing of the nose
        radius += _hill(side, e, (0.058, -0.425), 0.030, 0.018, -0.035)                    # nostril
        radius += _hill(side, e + 0.75 * (side - 0.25), (0.25, -0.455), 0.034, 0.100, -0.012)   # to the mouth
        radius += _hill(side, e, (0.285, -0.590), 0.040, 0.028, -0.016)                    # corner of the mouth
        ear = np.hypot((side - 1.62) / 0.115, (e + 0.02) / 0.25)                           # a shell with a rim
        radius += 0.085 * _rise(1.0 - ear, 0.10) - 0.060 * _rise(0.62 - ear, 0.12)
        radius += _hill(side, e, (1.60, -0.22), 0.06, 0.06, 0.020)                         # its lobe
    # Nose: a ridge that grows to the tip and ends below it
    down = np.clip((0.17 - e) / 0.53, 0.0, 1.0)
    ridge = (0.012 + 0.185 * down**1.25) * np.exp(-(a / (0.060 + 0.035 * down**2)) ** 2)
    radius += ridge * _rise(e + 0.405, 0.022) * _rise(0.24 - e, 0.06) + _hill(a, e, (0.0, -0.335), 0.060, 0.050, 0.030)
    # Mouth: two lips about a line that rises to its corners
    smile = e - 0.16 * a**2
    radius += _hill(a, smile, (0.0, -0.545), 0.215, 0.036, 0.026) + _hill(a, smile, (0.0, -0.638), 0.180, 0.036, 0.036)
    radius += _hill(a, smile, (0.0, -0.590), 0.250, 0.011, -0.032) + _hill(a, e, (0.0, -0.485), 0.022, 0.045, -0.010)
    radius += _hill(a, e, (0.0, -0.725), 0.16, 0.034, -0.022)                               # above the chin
    return radius


def _head(material: Material) -> Mesh:
    """The head, turned a little to the right: an ellipsoid with hills and hollows."""
    rows, columns = 340, 300
    e = np.linspace(0.5 * np.pi - 1e-3, 1e-3 - 0.5 * np.pi, rows)[:, None]
    even = 2.0 * np.pi * (np.arange(columns)[None] / columns - 0.5)
    a = even - 0.45 * np.sin(even)                                              # denser in the face
    d = np.stack([np.cos(e) * np.sin(a), np.sin(e) + 0.0 * a, np.cos(e) * np.cos(a)], -1)
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    radius = _skull(a, e)
    # Hair: a cap of locks that part at the side and fall over each other
    line = y - 0.34 - (0.26 + 0.25 * np.abs(x)) * np.clip(z, 0.0, 1.0) + 0.9 * np.clip(-z, 0.0, 1.0)
    line += 0.020 * np.sin(17.0 * a + 3.0 * np.sin(5.0 * a))
    lock = np.sin(15.0 * a + 5.0 * np.sin(3.2 * e + 1.3 * a)) + 0.45 * np.sin(41.0 * a + 9.0 * np.sin(4.0 * e + a))
    radius += _rise(line, 0.035) * (0.058 + 0.013 * lock * np.cos(e))
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
    fine = np.linspace(0.0, len(heights) - 1.0, 150)
    indices = np.arange(len(heights))
    heights, wide, deep = (np.interp(fine, indices, values) for values in (heights, wide, deep))
    kernel = np.hanning(19) / np.hanning(19).sum()
    heights, wide, deep = (np.convolve(np.pad(values, 9, mode="edge"), kernel, "valid")
                           for values in (heights, wide, deep))
    phi = 2.0 * np.pi * np.arange(240) / 240
    # A gown that crosses in front, thick at its hem and with folds that hang from the shoulders
    away = (phi + np.pi) % (2.0 * np.pi) - np.pi
    hem = -150.0 - 95.0 * np.exp(-(away / 0.55) ** 2) - 12.0 * np.sin(away)
    below = hem - heights[:, None]
    folds = np.sin(7.0 * away + 0.030 * heights[:, None]) * np.sin(3.0 * away - 0.021 * heights[:, None] + 1.0)
    cloth = 5.0 + 3.0 * np.exp(-(below / 9.0) ** 2) + 6.0 * folds * np.clip(below / 60.0, 0.0, 1.0)
    cloth *= _rise(below, 9.0)
    cloth *= np.clip(wide[:, None] / 80.0, 0.0, 1.0)
    points = np.stack(np.broadcast_arrays((wide[:, None] + cloth) * np.sin(phi), heights[:, None],
                                          (deep[:, None] + cloth) * np.cos(phi) - 12.0), -1).reshape(-1, 3) + PLACE
    faces = _grid_faces(len(fine), 240)
    return Mesh.of(points, faces, material, normals=_normals(points, faces), name="bust")


def portrait() -> Scene:
    """Focus at 1.2 m on the nearer eye; 85 mm and f/1.4 dissolve the lamps behind."""
    clay = Material((0.76, 0.52, 0.385), "coat", gloss=0.72)
    random = np.random.default_rng(4)
    lights = []
    for _ in range(70):
        away = float(np.exp(random.uniform(np.log(4200.0), np.log(16000.0))))
        x, y = away * random.uniform(-0.42, 0.42), away * random.uniform(-0.10, 0.24)
        warm = np.array([13.0, 7.4, 2.6]) if random.random() < 0.7 else np.array([5.0, 7.0, 11.0])
        red, green, blue = (float(c) for c in warm * random.uniform(0.5, 1.4))
        lights.append(Sphere((x, y, -away), 2.4e-3 * away, Material((red, green, blue), "light")))
    base = PLACE[1] - 384.0
    window = Rectangle.facing((-1500.0, 800.0, -1150.0), PLACE, 800.0, 1200.0, Material((7.0, 7.4, 8.4), "lamp"))
    fire = Rectangle.facing((1300.0, 100.0, -2300.0), PLACE, 500.0, 700.0, Material((11.0, 5.6, 2.2), "lamp"))
    wall = Rectangle((0.0, 600.0, -17000.0), (9000.0, 0.0, 0.0), (0.0, 3600.0, 0.0), Material((0.16, 0.12, 0.10)))
    return Scene("portrait", sky=Sky((0.05, 0.06, 0.09), (0.10, 0.09, 0.09), (0.05, 0.04, 0.035)),
                 floor=Floor(base, 420.0, (0.20, 0.13, 0.08), (0.15, 0.095, 0.055)), spheres=tuple(lights),
                 plates=(window, fire, wall), meshes=(_head(clay), _torso(clay)), ambient=(0.03, 0.03, 0.035),
                 depth_range=(700.0, 17e3))
