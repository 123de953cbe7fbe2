"""Photographs with a depth map for scene files."""

import math
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.phone_depth import read_phone_photograph
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.radiance_hdr import HdrError
from lensbench.app.state.scene_assets.sky_picture import EXR, read_exr
from lensbench.app.state.scene_assets.texture import FORMATS, read_texture
from lensbench.kernels.quotation import excerpt
from lensbench.scenery.photograph import photograph_scene

MOST_BYTES = 512 << 20
MEANINGS = ("distance", "disparity")


def read_photograph(image: str, depth: str, folder: Path, fov: float, meaning: str, near: float | None,
                    far: float | None, fill: str) -> lb.Scene:
    """The scene of a photograph and its depth map, in the folder of the scene file; SceneError in one line.

    meaning: "distance", the map grows with the distance, or "disparity", with its inverse, as phones store it. near,
    far (mm): the least and the greatest distance of the map; None: an EXR map in metres. fov: radians, across.
    """
    if meaning not in MEANINGS:
        raise lb.SceneError(f"depth_is {excerpt(meaning)}: choose one of {', '.join(MEANINGS)}")
    levels = _levels(depth, folder)
    if near is None or far is None:
        if meaning == "disparity" or levels.dtype.kind != "f":
            raise lb.SceneError("near and far are missing: the distances of the least and greatest distance of the map")
        away = levels.astype(np.float64) * 1000.0
    else:
        if not 0.0 < near < far:
            raise lb.SceneError("near must be positive and less than far")
        low, high = float(np.nanmin(levels)), float(np.nanmax(levels))
        if not (math.isfinite(low) and math.isfinite(high) and high > low):
            raise lb.SceneError(f"depth map {excerpt(depth)} has one value only")
        part = (levels.astype(np.float64) - low) / (high - low)
        away = near + part * (far - near)
        if meaning == "disparity":
            away = 1.0 / (1.0 / far + part * (1.0 / near - 1.0 / far))
    picture = read_texture(image, folder).values
    return photograph_scene(picture, away, fov, fill=fill, name=Path(image).stem)


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
    """The numbers (h, w) of a depth map: of its first channel."""
    from PIL import Image as Picture

    path = asset_path(name, folder, "depth map", MOST_BYTES)
    with path.open("rb") as file:
        head = file.read(4)
    try:
        if head == EXR:
            return read_exr(path, (("Z",), ("Y",), ("R",)))[..., 0]
        with Picture.open(path, formats=FORMATS) as picture:
            if picture.mode in ("RGB", "RGBA", "P"):
                found: Any = np.asarray(picture.convert("RGB"))[..., 0]
            else:
                found = np.asarray(picture)
    except (HdrError, OSError, SyntaxError, ValueError, MemoryError, Picture.DecompressionBombError) as error:
        raise lb.SceneError(f"depth map {excerpt(name)} is not a picture that can be read ({', '.join(FORMATS)}, "
                            "OpenEXR)") from error
    return found[..., 0] if found.ndim == 3 else found
