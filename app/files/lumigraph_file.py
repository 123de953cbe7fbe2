"""Lumigraphs on disk: numpy's .npz, as light fields are.

Arrays: `pictures` (down, across, 3, h, w) and `nearness` (down, across, h, w) as recorded, `spacing` and `distance` in
mm, and `settings`, the JSON text of exported pictures, from which the middle pinhole is built.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.files.export import ExportError
from lensbench.app.files.npz import ArrayHeader, load_arrays, save_arrays
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.settings import Settings

ARRAYS = ("pictures", "nearness", "spacing", "distance")


def save_lumigraph(path: str | Path, lumigraph: lb.Lumigraph, settings: Settings) -> None:
    """Write a lumigraph and the settings of its capture; ExportError if they cannot be written."""
    save_arrays(path, settings, pictures=lumigraph.pictures, nearness=lumigraph.nearness, spacing=lumigraph.spacing,
                distance=lumigraph.distance)


def load_lumigraph(path: str | Path) -> tuple[lb.Lumigraph, Settings]:
    """Read a file of save_lumigraph. ExportError: missing, no lumigraph, incomplete; and errors of its lens file."""
    found, settings = load_arrays(Path(path), "lumigraph", "lightfield array",
                                  lambda names: set() if set(ARRAYS) - names else set(ARRAYS), _fit)
    pictures, nearness, spacing, distance = (found[name] for name in ARRAYS)
    if not min(float(spacing), float(distance)) > 0.0:
        raise ExportError(f"{path}: this lumigraph is damaged: its distances must be positive")
    middle = lb.lumigraph_pinhole(camera(settings))
    texels = np.empty((*nearness.shape, 4), np.float16)
    texels[..., :3], texels[..., 3] = np.moveaxis(pictures, 2, -1), nearness
    return lb.Lumigraph(middle, float(spacing), float(distance), texels), settings


def _fit(headers: Mapping[str, ArrayHeader], settings: Settings) -> bool:
    """Whether arrays of these headers are a lumigraph by these settings."""
    pictures, nearness = headers["pictures"], headers["nearness"]
    picture = (settings.pixels_y, settings.pixels_x)
    return (pictures.kind == nearness.kind == "<f2" and len(pictures.shape) == 5 and min(pictures.shape[:2]) > 0
            and pictures.shape[2:] == (3, *picture) and nearness.shape == (*pictures.shape[:2], *picture)
            and all(headers[name].kind == "<f8" and not headers[name].shape for name in ("spacing", "distance")))
