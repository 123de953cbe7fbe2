"""Light fields on disk: numpy's .npz, an archive of plain arrays that every scientific program reads.

Arrays: `light` (views down, views across, 3, h, w) and `coverage` (down, across, h, w) as recorded, `reach`, `fill`,
and `settings`, the JSON text of exported pictures, from which the camera is built. With separate
moments of the exposure also `moments` (n, views down, views across, 3, h, w). A plenoptic camera has instead `raw`, the
raw picture (h, w, 3), `white`, its white picture (h, w), `behind`, the number of pixels behind each microlens, and
`microlenses`, their f-number. Not compressed: noise does not shrink, and reading is as fast as the disk.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.files.export import ExportError
from lensbench.app.files.npz import load_arrays, save_arrays
from lensbench.app.state.build import camera
from lensbench.app.state.light_field_query import Recording
from lensbench.app.state.settings import Settings

VIEWS = ("light", "coverage", "reach")
SENSOR = ("raw", "white", "behind", "microlenses")
OPTIONAL = ("fill", "moments")


def save_light_field(path: str | Path, recording: Recording) -> None:
    """Write a recording; ExportError if it cannot be written."""
    raw, field = recording.raw, recording.field
    if raw is None:
        moments = {} if field.moments is None else {"moments": field.moments}
        save_arrays(path, recording.settings, light=field.light, coverage=field.coverage, reach=field.reach,
                    fill=field.fill, **moments)
    else:
        save_arrays(path, recording.settings, raw=raw.picture, white=raw.white, behind=raw.camera.pixels,
                    microlenses=raw.camera.microlens_f_number)


def load_light_field(path: str | Path, say: Callable[[str], object] = lambda text: None) -> Recording:
    """Read a file of save_light_field; ExportError if it is missing, incomplete or no light field; or lens errors.

    `say` receives a sentence if the settings have names of an earlier version.
    """
    found, settings = load_arrays(Path(path), "light field", "capture", _wanted, say)
    recording = _of_sensor(found, settings) if "raw" in found else _of_views(found, settings)
    if recording is None:
        raise ExportError(f"{path}: the views of this light field are not those of its settings")
    return recording


def _wanted(names: set[str]) -> tuple[str, ...]:
    known = SENSOR if "raw" in names else VIEWS
    if set(known) - names:
        return ()
    return (*known, *(name for name in OPTIONAL if name in names))


def _of_views(found: dict[str, np.ndarray], settings: Settings) -> Recording | None:
    """The recording of these arrays; None if their shapes or types do not fit together."""
    light, coverage, reach, film = found["light"], found["coverage"], float(found["reach"]), settings.film
    fill, moments = float(found.get("fill", 1.0)), found.get("moments")         # older files have none
    if (light.dtype not in (np.float16, np.float32) or coverage.dtype != light.dtype or light.ndim != 5
            or light.shape[2:] != (3, film.pixels_y, film.pixels_x)
            or coverage.shape != (*light.shape[:2], *light.shape[3:]) or not reach > 0.0 or not 0.0 <= fill <= 1.0
            or moments is not None and (moments.dtype != light.dtype or moments.shape[1:] != light.shape)):
        return None
    return Recording(lb.LightField(camera(settings), reach, light, coverage, fill, moments=moments), settings)


def _of_sensor(found: dict[str, np.ndarray], settings: Settings) -> Recording | None:
    """The recording of these arrays; None if their shapes or types do not fit together."""
    plenoptic = lb.PlenopticCamera(camera(settings), int(found["behind"]), float(found["microlenses"]))
    raw, white = found["raw"], found["white"]
    if raw.dtype != np.float32 or raw.shape != (*plenoptic.sensor[::-1], 3) or white.shape != raw.shape[:2]:
        return None
    picture = lb.RawPicture(plenoptic, raw, white)
    return Recording(picture.decoded(), settings, picture)
