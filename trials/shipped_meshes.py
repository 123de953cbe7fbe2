"""The meshes of the shipped scenes: `python -m trials.shipped_meshes [FOLDER]` writes them as GLB files.

Surfaces of revolution, rounded boxes and height fields, in mm, y up; normals are the means of neighbouring triangles.
"""

import io
import json
import struct
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

SHIPPED = Path(__file__).parents[1] / "app" / "scenes" / "shipped"


class Part(NamedTuple):
    """One look. paint: a linear colour, or the sRGB codes (h, w, 3) of a texture; coat: its gloss, 0 without one."""

    points: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    paint: Sequence[float] | np.ndarray
    coat: float = 0.0

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: Sequence[float] = (0.0, 0.0, 0.0),
              size: float = 1.0) -> "Part":
        """Scaled, turned about x, y and z (degrees), and moved."""
        points = size * self.points
        for angle, (j, k) in zip(np.radians(turn), ((1, 2), (2, 0), (0, 1)), strict=True):
            a, b = points[:, j].copy(), points[:, k].copy()
            points[:, j], points[:, k] = a * np.cos(angle) - b * np.sin(angle), a * np.sin(angle) + b * np.cos(angle)
        return self._replace(points=points + (x, y, z))


# Shapes

def sheet(points: np.ndarray, paint: Sequence[float] | np.ndarray, coat: float = 0.0) -> Part:
    """A grid of points (rows, columns, 3) as a surface."""
    rows, columns = points.shape[:2]
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    a = i * columns + j
    faces = np.stack([a, a + 1, a + columns + 1, a, a + columns + 1, a + columns], -1).reshape(-1, 3)
    v, u = np.meshgrid(np.linspace(1.0, 0.0, rows), np.linspace(0.0, 1.0, columns), indexing="ij")
    return Part(points.reshape(-1, 3), faces, np.stack([u, v], -1).reshape(-1, 2), paint, coat)


def revolved(profile: Sequence[tuple[float, float]], paint: Sequence[float] | np.ndarray, coat: float = 0.0,
             count: int = 60, lobes: tuple[float, int] = (0.0, 1), fine: int = 1) -> Part:
    """A profile of (radius, height) from the top, turned about y; lobes: their part of the radius, and number."""
    turns = np.radians(np.linspace(0.0, 360.0, count + 1))
    line = np.asarray(profile, float)
    knots, steps = np.arange(len(line)), np.linspace(0, len(line) - 1, fine * (len(line) - 1) + 1)
    radius, height = (np.interp(steps, knots, line[:, k]) for k in (0, 1))
    wavy = radius[:, None] * (1.0 + lobes[0] * np.cos(lobes[1] * turns))
    points = np.stack(np.broadcast_arrays(wavy * np.sin(turns), height[:, None], wavy * np.cos(turns)), -1)
    return sheet(points, paint, coat)


def box(size: Sequence[float], radius: float, paint: Sequence[float] | np.ndarray, coat: float = 0.0,
        count: int = 8) -> list[Part]:
    """Six sides of a box about the origin with edges of a radius."""
    half, sides = np.asarray(size, float) / 2.0, []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            across, up = (axis + 1) % 3, (axis + 2) % 3
            line = [np.r_[-half[k], np.linspace(radius - half[k], half[k] - radius, 3), half[k]] for k in (across, up)]
            knots = np.r_[np.linspace(0.0, 1.0, count + 1), 2.0, np.linspace(3.0, 4.0, count + 1)]
            line = [np.interp(knots, np.arange(5), values) for values in line]
            b, a = np.meshgrid(line[1], line[0][::int(sign)], indexing="ij")
            cube = np.empty((*a.shape, 3))
            cube[..., axis], cube[..., across], cube[..., up] = sign * half[axis], a, b
            inner = np.clip(cube, radius - half, half - radius)
            away = cube - inner
            sides.append(sheet(inner + radius * away / np.linalg.norm(away, axis=-1, keepdims=True), paint, coat))
    return sides


def noise(height: int, width: int, size: float, seed: int, stretch: float = 1.0) -> np.ndarray:
    """Smooth noise of unit deviation that repeats; size: of its waves in pixels, `stretch` times as long down."""
    f = np.hypot(np.fft.fftfreq(height)[:, None] * size * stretch, np.fft.rfftfreq(width)[None] * size)
    spectrum = np.fft.rfft2(np.random.default_rng(seed).normal(size=(height, width))) * np.exp(-4.0 * f**2)
    spectrum[0, 0] = 0.0
    waves = np.fft.irfft2(spectrum, s=(height, width))
    return waves / waves.std()


def mixed(colours: Sequence[Sequence[float]], amount: np.ndarray) -> np.ndarray:
    """sRGB codes between two colours."""
    low, high = np.asarray(colours, float)
    return np.clip(low + np.clip(amount, 0.0, 1.0)[..., None] * (high - low), 0, 255).astype(np.uint8)


# Things

def apple(seed: int) -> list[Part]:
    """An apple with its stalk, 74 mm wide, standing on y = 0."""
    t = np.linspace(0.0, np.pi, 41)
    rho = 36.0 * (1.0 - 0.62 * np.exp(-(t / 0.42) ** 2) - 0.30 * np.exp(-((np.pi - t) / 0.36) ** 2)
                  + 0.06 * np.exp(-((t - 0.9) / 0.5) ** 2))
    streaks = 0.5 + 0.35 * noise(192, 384, 9.0, seed, 9.0) + 0.35 * noise(192, 384, 120.0, seed + 1)
    green = np.exp(-(np.linspace(0.0, 1.0, 192)[:, None] / 0.16) ** 2)
    skin = mixed(((128, 12, 16), (214, 96, 40)), streaks - 0.25 + green)
    specks = (noise(192, 384, 3.0, seed + 2) > 2.6)[..., None]
    skin = np.where(specks, (224, 176, 120), skin).astype(np.uint8)
    body = revolved(np.stack([rho * np.sin(t), rho * np.cos(t)], -1).tolist(), skin, 0.93, lobes=(0.025, 5))
    stalk = revolved([(0.1, 22.0), (2.2, 21.5), (1.5, 12.0), (1.3, 2.0), (0.1, 0.0)], (0.09, 0.05, 0.025), count=10)
    return [body.moved(y=27.5), stalk.moved(0.0, 39.0, turn=(14.0, 0.0, -9.0))]


def lemon(seed: int) -> Part:
    """A lemon that lies along x, 84 mm long, on y = 0."""
    t = np.linspace(0.0, np.pi, 57)
    radius = 27.0 * np.sin(t) ** 0.85 * (1.0 - 0.10 * np.cos(t)) + 0.02
    height = 35.0 * np.cos(t) + 7.0 * np.sign(np.cos(t)) * np.exp(-(np.sin(t) / 0.22) ** 2)
    part = revolved(np.stack([radius, height], -1).tolist(), mixed(((236, 176, 12), (250, 214, 60)),
                    0.5 + 0.3 * noise(64, 128, 20.0, seed)), 0.72, count=112)
    dents = noise(57, 112, 2.6, seed)
    dents = np.concatenate([dents, dents[:, :1]], 1).reshape(-1, 1)
    across = part.points * (1.0, 0.0, 1.0)
    return part._replace(points=part.points + 0.010 * dents * across).moved(y=27.0, turn=(0.0, 20.0, 90.0))


BOTTLE = [(0.0, 0.0), (30.0, 0.0), (36.0, 2.0), (37.0, 8.0), (37.0, 180.0), (36.0, 192.0), (32.0, 206.0), (22.0, 222.0),
          (15.5, 236.0), (14.2, 250.0), (14.0, 288.0), (15.6, 290.0), (15.6, 300.0), (13.0, 302.0), (10.0, 300.0),
          (9.6, 250.0), (11.5, 234.0), (18.5, 219.0), (28.5, 204.0), (32.8, 191.0), (34.0, 180.0), (34.0, 10.0),
          (30.0, 6.0), (0.0, 12.0)]


def bottle() -> list[Part]:
    """A bottle as one closed wall of glass, 302 mm high."""
    return [revolved(BOTTLE[::-1], (1.0, 1.0, 1.0), fine=3)]


def camera() -> list[Part]:
    """A rangefinder camera, 138 mm wide, whose lens looks along +z; it stands on y = 0."""
    chrome, black, brass = (0.52, 0.51, 0.49), (0.012, 0.012, 0.013), (0.50, 0.36, 0.13)
    grain = 0.5 + 0.25 * noise(192, 384, 4.0, 1)
    leather = mixed(((14, 13, 12), (58, 54, 50)), grain)
    parts = [side.moved(y=37.0) for side in box((134.0, 46.0, 30.0), 14.0, leather, 0.55)]
    parts += [side.moved(y=7.5) for side in box((136.0, 15.0, 32.0), 7.0, chrome, 0.72)]
    parts += [side.moved(y=66.0) for side in box((136.0, 18.0, 32.0), 7.0, chrome, 0.72)]
    parts += [side.moved(6.0, 76.0, -1.0) for side in box((66.0, 14.0, 25.0), 5.0, chrome, 0.72)]

    def turned(profile: Sequence[tuple[float, float]], paint: Sequence[float], coat: float, x: float, y: float,
               z: float, up: bool = False) -> None:
        part = revolved(profile, paint, coat, 48)
        parts.append(part.moved(x, y, z) if up else part.moved(x, y, z, turn=(90.0, 0.0, 0.0)))

    for x, radius, high in ((-48.0, 11.0, 8.0), (52.0, 9.5, 7.0), (-27.0, 4.0, 6.0)):
        dial = [(0.0, high), (radius - 1.0, high), (radius, high - 1.0), (radius, 0.0)]
        turned(dial, chrome, 0.8, x, 74.5, 0.0, True)
    rings = [(21.0, 46.0), (24.5, 46.0), (25.5, 44.5), (25.5, 36.0), (24.0, 35.5), (24.0, 34.5), (27.5, 34.0),
             (27.5, 24.0), (26.0, 23.5), (26.0, 21.5), (29.0, 21.0), (29.0, 10.0), (27.5, 9.0), (27.5, 4.0),
             (31.0, 3.5), (31.0, 0.0)]
    turned(rings, black, 0.78, 0.0, 35.0, 14.0)
    turned([(29.2, 20.0), (29.4, 19.5), (29.4, 16.5), (29.2, 16.0)], chrome, 0.8, 0.0, 35.0, 14.0)
    turned([(18.0, 33.0), (19.0, 38.0), (20.0, 41.5), (21.2, 45.8)], black, 0.6, 0.0, 35.0, 14.0)
    turned([(33.0, 0.0), (33.0, 2.0), (30.0, 2.6)][::-1], chrome, 0.8, 0.0, 35.0, 14.0)
    for x, wide in ((-14.0, 9.0), (24.0, 15.0)):           # windows of the finder
        parts += [side.moved(x, 76.0, 11.4) for side in box((wide, 8.5, 1.6), 0.6, (0.02, 0.022, 0.03), 1.0, 2)]
    turned([(0.0, 2.0), (2.2, 2.0), (2.6, 0.0)], brass, 0.8, -48.0, 50.0, 14.5)
    return parts


def cloth() -> list[Part]:
    """A linen napkin with folds and a woven stripe, 420 × 330 mm, on y = 0."""
    v, u = np.meshgrid(np.linspace(-1.0, 1.0, 80), np.linspace(-1.0, 1.0, 110), indexing="ij")
    bent = u + 0.16 * np.sin(2.3 * v + 0.4)
    fold = sum(h * np.exp(-((bent - c - s * v) / w) ** 2) for c, s, w, h in (
        (-0.62, 0.25, 0.085, 21.0), (-0.18, -0.30, 0.060, 15.0), (0.10, 0.22, 0.075, 19.0), (0.55, -0.12, 0.100, 24.0),
        (0.83, 0.10, 0.055, 13.0)))
    rim = 1.0 + 0.05 * np.sin(5.0 * u + 2.0 * v) + 0.04 * np.sin(7.0 * v)
    height = 1.5 + fold * (0.75 + 0.25 * np.sin(3.0 * v)) + 1.6 * noise(80, 110, 18.0, 3)
    points = np.stack([210.0 * (u - 0.02 * fold / 10.0) * rim, np.maximum(height, 0.8), 165.0 * v * rim], -1)
    y, x = np.mgrid[0:480, 0:600]
    weave = 0.80 + 0.04 * np.sin(0.5 * np.pi * x) + 0.06 * (
        noise(480, 600, 2.6, 4, 8.0) + noise(480, 600, 2.6, 5, 0.125))
    stripe = (np.abs(np.abs(y - 240) - 185) < 17) | (np.abs(np.abs(y - 240) - 155) < 4)
    linen = np.clip(weave[..., None] * np.where(stripe[..., None], (88, 110, 140), (250, 244, 230)), 0, 255)
    return [sheet(points[::-1], linen.astype(np.uint8))]


def wood() -> np.ndarray:
    """sRGB codes (h, w, 3) of planks of oak with their grain along x."""
    planks = []
    for k in range(4):
        rings = noise(160, 1280, 150.0, 10 + k, 0.10) * 2.2 + noise(160, 1280, 500.0, 20 + k, 0.12) * 3.0
        grain = 0.5 + 0.28 * np.sin(3.2 * rings) + 0.22 * noise(160, 1280, 60.0, 30 + k, 0.03)
        plank = mixed(((70, 40, 21), (150, 98, 56)), grain) * np.random.default_rng(k).uniform(0.82, 1.05)
        plank[:3] *= 0.25
        planks.append(plank)
    return np.clip(np.concatenate(planks), 0, 255).astype(np.uint8)


def mushroom(seed: int, open_: float) -> list[Part]:
    """A fly agaric 80 mm high on y = 0; open_: from 0, a bud, to 1."""
    t = np.linspace(0.0, 0.5 * np.pi, 25)
    wide, high = 18.0 + 20.0 * open_, 22.0 - 6.0 * open_
    top = [(float(wide * np.sin(a)), float(80.0 - high + high * np.cos(a))) for a in t]
    under = [(wide * s, 80.0 - high - 3.0 * (1.0 - s)) for s in (0.985, 0.93, 0.7, 0.4, 0.15)]
    v = np.linspace(0.0, 1.0, 256)[:, None]
    skin = np.broadcast_to(mixed(((168, 16, 8), (222, 84, 20)), v**3 + 0.15 * noise(256, 512, 60.0, seed)),
                           (256, 512, 3))
    warts = (noise(256, 512, 26.0, seed + 1, 0.7) > 1.25) & (v < 0.97)
    cap = revolved(top, np.where(warts[..., None], (238, 228, 204), skin).astype(np.uint8), 0.86)
    bumps = np.repeat(warts[np.linspace(0, 255, 25).astype(int)][:, np.linspace(0, 511, 61).astype(int)].reshape(-1, 1),
                      3, 1)
    cap = cap._replace(points=cap.points + np.where(bumps, 1.1, 0.0) * (cap.points - (0.0, 60.0, 0.0)) / wide)
    gills = mixed(((196, 184, 156), (240, 232, 212)), np.broadcast_to(np.arange(256) % 4 > 1, (8, 256)).astype(float))
    stem = [(5.0, 79.0 - high), (5.5, 50.0), (12.0, 47.0), (13.0, 42.0), (7.0, 46.0), (6.5, 30.0), (8.5, 12.0),
            (11.0, 4.0), (9.0, -8.0)]
    return [cap, revolved(under, gills), revolved(stem, (0.74, 0.69, 0.56), fine=4, lobes=(0.05, 4))]


def moss() -> list[Part]:
    """Ground of moss and leaves, 1.4 m wide and 1 m deep, with the top of its hill at the origin."""
    rows, columns = 100, 140
    z, x = np.meshgrid(np.linspace(-700.0, 300.0, rows), np.linspace(-700.0, 700.0, columns), indexing="ij")
    tufts = 8.0 * noise(rows, columns, 15.0, 1) + 3.5 * np.abs(noise(rows, columns, 4.0, 2))
    height = -70.0 * (1.0 - np.exp(-(x**2 + z**2) / 4.0e5)) + tufts - 8.0
    green = 0.5 + 0.25 * noise(400, 560, 4.0, 4) + 0.30 * noise(400, 560, 60.0, 5)
    earth = noise(400, 560, 30.0, 6) > 1.15
    leaf = mixed(((62, 34, 14), (150, 92, 40)), 0.5 + 0.3 * noise(400, 560, 9.0, 7))
    colours = np.where(earth[..., None], leaf, mixed(((16, 24, 5), (104, 118, 30)), green)).astype(np.uint8)
    # Blades, densest about the mushrooms
    rng, count = np.random.default_rng(8), 6000
    spots = rng.normal(0.0, (150.0, 110.0), (count, 2)) + (20.0, 10.0)
    i = np.clip(((spots[:, 1] + 700.0) / 1000.0 * (rows - 1)).astype(int), 0, rows - 1)
    j = np.clip(((spots[:, 0] + 700.0) / 1400.0 * (columns - 1)).astype(int), 0, columns - 1)
    foot = np.stack([spots[:, 0], height[i, j] - 2.0, spots[:, 1]], -1)
    turn, size = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(7.0, 19.0, count)
    across = 1.1 * np.stack([np.cos(turn), 0.0 * turn, np.sin(turn)], -1)
    lean = 0.6 * rng.normal(size=(2, count))
    tip = foot + size[:, None] * np.stack([lean[0], np.ones(count), lean[1]], -1)
    points, ones = np.stack([foot - across, foot + across, tip], 1), np.arange(3 * count).reshape(-1, 3)
    groups = np.array_split(rng.permutation(count), 3)
    greens = (0.10, 0.16, 0.02), (0.20, 0.25, 0.04), (0.05, 0.10, 0.015)
    blades = [Part(points[group].reshape(-1, 3), ones[:len(group)], np.zeros((3 * len(group), 2)), green_)
              for group, green_ in zip(groups, greens, strict=True)]
    return [sheet(np.stack([x, height, z], -1), colours), *blades]


def sweep() -> list[Part]:
    """A paper that hangs behind and lies in front, 3 m wide, with the things on y = 0."""
    turn = np.linspace(0.0, 0.5 * np.pi, 24)
    lying = [(700.0, 0.0), *zip((-500.0 - 300.0 * np.sin(turn)).tolist(), (300.0 - 300.0 * np.cos(turn)).tolist(),
                                strict=True), (-800.0, 2000.0)]
    z, y = np.array(lying)[::-1].T
    return [sheet(np.stack(np.broadcast_arrays(np.linspace(-1500.0, 1500.0, 2), y[:, None], z[:, None]), -1),
                  (0.62, 0.62, 0.63))]


def balloon(colours: Sequence[Sequence[int]]) -> list[Part]:
    """A hot-air balloon 22 m high above the floor of its basket at y = 0; in metres."""
    t = np.linspace(0.0, 1.0, 41)
    lower = np.maximum(np.cos(0.5 * np.pi * np.clip((t - 0.42) / 0.58, 0.0, 1.0)), 0.0)
    radius = np.where(t < 0.42, 8.2 * np.sqrt(np.maximum(1.0 - (1.0 - t / 0.42) ** 2, 0.0)), 1.27 + 6.93 * lower**1.15)
    row, column = np.mgrid[0:128, 0:384]
    band = (column // 16 + np.where((row > 44) & (row < 70), column // 8 + row // 9, 0)) % len(colours)
    cloth_ = np.asarray(colours, np.uint8)[band]
    parts = [revolved(np.stack([radius, 22.0 - 17.6 * t], -1).tolist(), cloth_, 0.6, 96, (0.012, 24))]
    parts += [side.moved(y=0.7) for side in box((1.5, 1.3, 1.5), 0.12, (0.16, 0.08, 0.035), count=2)]
    return parts + [revolved([(0.025, 3.3), (0.025, 0.0)], (0.05, 0.05, 0.05), count=6).moved(
        0.68 * x, 1.3, 0.68 * z, turn=(8.0 * z, 0.0, -8.0 * x)) for x in (-1, 1) for z in (-1, 1)]


# Files

def normals(part: Part) -> np.ndarray:
    """Of each point, by the areas of the triangles around its position."""
    _, same = np.unique(np.round(part.points, 3), axis=0, return_inverse=True)
    a, b, c = (part.points[part.faces[:, k]] for k in range(3))
    sums = np.zeros((same.max() + 1, 3))
    for k in range(3):
        np.add.at(sums, same.ravel()[part.faces[:, k]], np.cross(b - a, c - a))
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    return sums[same.ravel()]


def write_glb(path: Path, parts: Sequence[Part], unit: float = 1e-3) -> None:
    """Write parts in units of so many metres, with whole numbers for their coordinates."""
    blob, views, accessors, primitives, materials, images = bytearray(), [], [], [], [], []
    low = np.min([part.points.min(0) for part in parts], 0)
    side = float(np.max([part.points.max(0) for part in parts], 0).max() - low.min()) or 1.0

    def view(data: bytes, **more: int) -> int:
        blob.extend(b"\0" * (-len(blob) % 4))
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data), **more})
        blob.extend(data)
        return len(views) - 1

    def accessor(values: np.ndarray, kind: str, code: int, stride: int = 0) -> int:
        padded = values
        if stride:
            padded = np.zeros((len(values), stride // values.itemsize), values.dtype)
            padded[:, :values.shape[1]] = values
        bounded = kind == "VEC3" and code == 5123
        bounds = {"min": values.min(0).tolist(), "max": values.max(0).tolist()} if bounded else {}
        accessors.append({"bufferView": view(padded.tobytes(), **({"byteStride": stride} if stride else {})),
                          "componentType": code, "normalized": kind != "SCALAR", "count": len(values), "type": kind,
                          **bounds})
        return len(accessors) - 1

    for part in parts:
        paint: dict = {"metallicFactor": 0}
        attributes = {"POSITION": accessor(np.round((part.points - low) / side * 65535).astype("<u2"), "VEC3", 5123, 8),
                      "NORMAL": accessor(np.round(normals(part) * 127).astype("i1"), "VEC3", 5120, 4)}
        if isinstance(part.paint, np.ndarray):
            jpeg = io.BytesIO()
            Image.fromarray(part.paint).save(jpeg, "JPEG", quality=74, optimize=True)
            if jpeg.getvalue() not in images:
                images.append(jpeg.getvalue())
            paint["baseColorTexture"] = {"index": images.index(jpeg.getvalue())}
            uv = np.stack([part.uv[:, 0], 1.0 - part.uv[:, 1]], 1)
            attributes["TEXCOORD_0"] = accessor(np.round(uv * 65535).astype("<u2"), "VEC2", 5123, 4)
        else:
            paint["baseColorFactor"] = [*map(float, part.paint), 1.0]
        material: dict = {"pbrMetallicRoughness": paint}
        if part.coat:
            material["extensions"] = {"KHR_materials_clearcoat": {
                "clearcoatFactor": 1, "clearcoatRoughnessFactor": round(1.0 - part.coat, 3)}}
        if material not in materials:
            materials.append(material)
        primitives.append({"attributes": attributes, "material": materials.index(material),
                           "indices": accessor(part.faces.astype("<u2").ravel(), "SCALAR", 5123)})
    pictures = [{"bufferView": view(image), "mimeType": "image/jpeg"} for image in images]
    tree = {"asset": {"version": "2.0", "generator": "trials/shipped_meshes.py of lensbench"},
            "extensionsUsed": ["KHR_mesh_quantization", "KHR_materials_clearcoat"],
            "extensionsRequired": ["KHR_mesh_quantization"], "buffers": [{"byteLength": len(blob)}],
            "bufferViews": views, "accessors": accessors, "images": pictures, "materials": materials,
            "textures": [{"source": k} for k in range(len(images))], "meshes": [{"primitives": primitives}],
            "nodes": [{"mesh": 0, "scale": [side * unit] * 3, "translation": (low * unit).tolist()}],
            "scenes": [{"nodes": [0]}], "scene": 0}
    text = json.dumps({key: value for key, value in tree.items() if value}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    blob.extend(b"\0" * (-len(blob) % 4))
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)) + struct.pack("<I4s", len(text), b"JSON")
    path.write_bytes(head + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob)
    print(f"{path.name}: {sum(len(part.faces) for part in parts)} triangles, {path.stat().st_size} bytes")


def main(folder: Path = SHIPPED) -> None:
    """Write all of them into a folder."""
    fruit = [part.moved(*place) for place, parts in (
        ((0.0, 0.0, 0.0), apple(1)), ((-78.0, 0.0, -38.0), [part.moved(turn=(0.0, 80.0, 0.0)) for part in apple(7)]),
        ((62.0, 0.0, 34.0), [lemon(3)])) for part in parts]
    write_glb(folder / "fruit.glb", fruit)
    write_glb(folder / "bottle.glb", bottle())
    write_glb(folder / "camera.glb", camera())
    write_glb(folder / "cloth.glb", cloth())
    write_glb(folder / "sweep.glb", sweep())
    Image.fromarray(wood()).save(folder / "wood.jpg", quality=78, optimize=True)
    agarics = [part.moved(x, y, z, turn, size) for x, y, z, turn, size, seed, open_ in (
        (-12.0, 0.0, 0.0, (4.0, 0.0, 5.0), 1.0, 1, 1.0), (62.0, -8.0, -46.0, (-3.0, 90.0, -6.0), 0.8, 5, 0.6),
        (34.0, -4.0, 36.0, (6.0, 40.0, -10.0), 0.5, 9, 0.0)) for part in mushroom(seed, open_)]
    write_glb(folder / "mushrooms.glb", [*moss(), *agarics])
    write_glb(folder / "balloon-red.glb", balloon(((176, 28, 22), (236, 188, 60), (30, 52, 110))), 1.0)
    write_glb(folder / "balloon-blue.glb", balloon(((28, 84, 140), (236, 232, 220))), 1.0)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
