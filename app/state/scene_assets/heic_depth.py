"""Photographs in HEIC files that carry their depth map as an auxiliary picture, as iPhones write portraits.

pillow-heif is an optional part (`pip install lensbench[heic]`), imported when the first such file is read. It turns the
picture and its map upright. References: ITU-T H.265, annex G.14.2.3, depth representation information; Apple,
AVDepthData: disparities are in 1/m.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.depth_levels import grey_levels
from lensbench.app.state.scene_assets.phone_photograph import PhonePhotograph, stated_fov
from lensbench.app.state.scene_assets.table_values import within
from lensbench.app.state.scene_assets.texture import image_of
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.lenses.picture_file import MOST_PIXELS
from lensbench.scenery.photograph import reduced

INVERSE_DISTANCE, DISPARITY = 0, 1      # meanings of a map, by depth_representation_type
FARTHEST = 100_000.0                    # mm: where a disparity is that of infinity
SAME_SHAPE = 0.02                       # of the ratio of the sides: map and picture show the same view


def is_heic(head: bytes) -> bool:
    """Whether a file begins as those of the HEIF family."""
    return head[4:8] == b"ftyp"


def read_heic_photograph(path: Path, name: str) -> PhonePhotograph:
    """The photograph and the depth map of a HEIC file; SceneError in one line, which calls the file `name`."""
    what = f"photograph {excerpt(name)}"
    try:
        import pillow_heif
    except ImportError as error:
        raise lb.SceneError(f"{what} is a HEIC file, which needs pillow-heif: pip install lensbench[heic]") from error
    try:
        found = pillow_heif.open_heif(path)
        maps = found.info.get("depth_images")
        if not maps:
            raise lb.SceneError(f"{what} carries no depth map: take it as a portrait, or name a map as depth")
        if max(math.prod(found.size), math.prod(maps[0].size)) > MOST_PIXELS or min(*found.size, *maps[0].size) < 2:
            raise lb.SceneError(f"{what} has {found.size[0]} × {found.size[1]} pixels")
        picture, coded = found.to_pillow(), maps[0].to_pillow()
    except (OSError, ValueError, EOFError, RuntimeError, SyntaxError, MemoryError) as error:
        if isinstance(error, lb.SceneError):
            raise
        raise lb.SceneError(f"{what}: its picture or its depth map cannot be read") from error
    levels: Any = reduced(within(what, grey_levels, coded))
    part = levels / (65535.0 if levels.dtype == np.uint16 else 255.0)
    if abs(picture.width * part.shape[0] / (picture.height * part.shape[1]) - 1.0) > SAME_SHAPE:
        raise lb.SceneError(f"{what}: its depth map, {part.shape[1]} × {part.shape[0]}, has another shape than its "
                            f"picture, {picture.width} × {picture.height}")
    away = _distances(maps[0].info.get("metadata") or {}, part, what)
    fov = stated_fov(picture.getexif(), picture.size, picture.width)
    return PhonePhotograph(image_of(picture), away, False, fov)


def _distances(meaning: dict[str, Any], part: np.ndarray, what: str) -> np.ndarray:
    """Distances (mm) of a map whose values lie in [0, 1], 1 the nearest."""
    kind = meaning.get("representation_type")
    if kind == DISPARITY and "d_min" in meaning and "d_max" in meaning:
        low, high = float(meaning["d_min"]), float(meaning["d_max"])
    elif kind == INVERSE_DISTANCE and meaning.get("z_near") and meaning.get("z_far"):
        low, high = 1.0 / float(meaning["z_far"]), 1.0 / float(meaning["z_near"])
    else:
        raise lb.SceneError(f"{what}: its depth map does not state its distances: save it as PNG, and name it as depth "
                            "with near and far")
    if not (math.isfinite(low) and math.isfinite(high) and high > max(low, 1000.0 / FARTHEST)):
        raise lb.SceneError(f"{what}: its depth map goes from {significant(low, 3)} to {significant(high, 3)} /m")
    return 1000.0 / np.maximum(low + part * (high - low), 1000.0 / FARTHEST)
