"""Photographs with a depth map for scene files."""

import math
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.depth_levels import (
    check_equal,
    endless,
    filled,
    grey_levels,
    unmeasured,
)
from lensbench.app.state.scene_assets.phone_depth import read_phone_photograph
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.radiance_hdr import HdrError
from lensbench.app.state.scene_assets.sky_picture import EXR, read_exr
from lensbench.app.state.scene_assets.table_values import Say, within
from lensbench.app.state.scene_assets.texture import MOST_BYTES, read_texture
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.lenses.picture_file import PictureFileError, read_picture_file
from lensbench.lenses.regular_file import open_regular
from lensbench.scenery.photograph import photograph_scene, reduced

MOST_AWAY = 1e8 / 4.0       # mm: a mesh reaches 100 km, and what has no end lies four times behind all others
MEANINGS = ("distance", "disparity")


def read_photograph(image: str, depth: str, folder: Path, fov: float, meaning: str, near: float | None,
                    far: float | None, fill: str, holes: bool, say: Say) -> lb.Scene:
    """The scene of a photograph and its depth map, in the folder of the scene file; SceneError in one line.

    meaning: "distance", the map grows with the distance, or "disparity", with its inverse, as phones store it. near,
    far (mm): the least and the greatest distance of the map; None: an EXR map in metres. fov: radians, across. holes:
    whether pixels without a distance are looked for. say receives a sentence for each kind that was replaced.
    """
    if meaning not in MEANINGS:
        raise lb.SceneError(f"depth_is {excerpt(meaning)}: choose one of {', '.join(MEANINGS)}")
    levels = _levels(depth, folder)
    metric = near is None or far is None
    if metric and (meaning == "disparity" or levels.dtype.kind != "f"):
        raise lb.SceneError("near and far are missing: the distances of the least and greatest distance of the map")
    if near is not None and far is not None and not 0.0 < near < far:
        raise lb.SceneError("near must be positive and less than far")
    if far is not None and far > MOST_AWAY:
        raise lb.SceneError(f"far is {significant(far / 1e6)} km: write at most {significant(MOST_AWAY / 1e6)} km, at "
                            "which all that lies behind looks the same")
    away = within(f"depth map {excerpt(depth)}", _distances, levels, meaning, None if metric else (near, far), holes,
                  lambda text: say(f"depth map {excerpt(depth)}: {text}"))
    return photograph_scene(read_texture(image, folder).values, away, fov, fill=fill, name=Path(image).stem)


def _distances(levels: np.ndarray, meaning: str, ends: tuple[float, float] | None, holes: bool, say: Say
               ) -> np.ndarray:
    """Distances (mm) of the levels of a map, reduced. ends: the least and the greatest of them; None: levels in m."""
    disparity = meaning == "disparity"
    hole = unmeasured(levels, disparity) if holes or levels.dtype.kind == "f" else np.zeros(levels.shape, bool)
    doubtful = ends is not None or levels.max(where=~hole, initial=0) > MOST_AWAY / 1000.0
    beyond = np.zeros(levels.shape, bool) if disparity else endless(levels, hole, holes and bool(doubtful))
    known = ~(hole | beyond)
    if not known.any():
        raise lb.SceneError("no pixel of it holds a distance")
    low, high = (float(f(where=known, initial=levels[known][0])) for f in (levels.min, levels.max))
    shares = [100.0 * float(part.mean()) for part in (hole, beyond)]
    levels, hole, beyond = reduced(levels), reduced(hole), reduced(beyond)
    if ends is None and high * 1000.0 > MOST_AWAY:
        raise lb.SceneError(f"it reaches {significant(high / 1000.0)} km as metres, more than "
                            f"{significant(MOST_AWAY / 1e6)} km: give near and far, its least and greatest distance")
    if ends is None:
        away = levels.astype(np.float64) * 1000.0
    elif not (math.isfinite(high) and high > low):
        raise lb.SceneError("it has one value only")
    else:
        near, far = ends
        part = np.clip((levels.astype(np.float64) - low) / (high - low), 0.0, 1.0)
        away = 1.0 / (1.0 / far + part * (1.0 / near - 1.0 / far)) if disparity else near + part * (far - near)
    if shares[0]:
        say(f"{significant(shares[0], 2)} % of the pixels hold no distance (0, negative or NaN) and take the one of a "
            "neighbour; if 0 is a distance, write holes = false")
    if shares[1]:
        say(f"{significant(shares[1], 2)} % of the pixels have the level of what has no end, far above all others, and "
            "are laid behind them")
    return filled(np.where(beyond, np.inf, away), hole)


def own_depth_scene(image: str, folder: Path, fov: float | None, fill: str) -> lb.Scene:
    """The scene of a phone's photograph that carries its depth map; SceneError in one line.

    fov: radians across the upright photograph; None: as its focal length on 35 mm film says.
    """
    found = read_phone_photograph(image, folder)
    fov = fov or found.fov
    if fov is None:
        raise lb.SceneError(f"photograph {excerpt(image)} does not state its focal length on 35 mm film: give fov, the "
                            "angle across it")
    away = found.away
    if found.radial and 0.0 < fov < math.pi:            # along the ray, not along the axis
        rows, columns = away.shape
        half = math.tan(fov / 2.0)
        x, y = ((2.0 * np.arange(n) + 1.0) / n - 1.0 for n in (columns, rows))
        away = away / np.sqrt(1.0 + (half * x) ** 2 + ((half * rows / columns) * y[:, None]) ** 2)
    return photograph_scene(found.picture.values, away, fov, fill=fill, name=Path(image).stem)


def _levels(name: str, folder: Path) -> np.ndarray:
    """The numbers (h, w) of a depth map; SceneError where they cannot be read, or are colours."""
    path = asset_path(name, folder, "depth map", MOST_BYTES)
    try:
        with open_regular(path) as file:
            is_exr = file.read(4) == EXR
        if not is_exr:
            return grey_levels(read_picture_file(path, real=True))
        channels = read_exr(path, (("Z",), ("Y",), ("R", "G", "B"), ("R",)))
        for other in channels[1:]:
            check_equal(channels[0], other, 0.0)
        return channels[0]
    except (HdrError, PictureFileError, lb.SceneError, OSError, MemoryError) as error:
        raise lb.SceneError(f"depth map {excerpt(name)}: {getattr(error, 'strerror', None) or error}") from error
