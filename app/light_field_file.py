"""Light fields on disk: numpy's .npz, an archive of plain arrays that every scientific program reads.

In it: `light` (views down, views across, 3, h, w) and `coverage` (down, across, h, w) as recorded, `reach`, `fill`, and
`settings`, the JSON text that exported pictures carry too; from these the camera is made again. Not compressed:
noise does not shrink, and a light field is opened as fast as the disk gives it.
"""

import json
import zipfile
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.export import ExportError, replacing
from lensbench.app.optics import camera
from lensbench.app.settings import Settings

SUFFIX = ".npz"
ARRAYS = ("light", "coverage", "reach", "settings")


def save_light_field(path: str | Path, field: lb.LightField, settings: Settings) -> None:
    """Write a light field and the settings that it was captured with; ExportError where that cannot be."""
    path = checked_suffix(path)
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, light=field.light, coverage=field.coverage, reach=field.reach, fill=field.fill,
                 settings=np.array(json.dumps(settings.to_dict(), allow_nan=False)))


def checked_suffix(path: str | Path) -> Path:
    """The path of a light field; ExportError for another suffix."""
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise ExportError(f"{path}: light fields are written as {SUFFIX}")
    return path


def load_light_field(path: str | Path) -> tuple[lb.LightField, Settings]:
    """Read what save_light_field wrote. ExportError: not there, not a light field, cut short; what loading its lens
    raises where that is gone.
    """
    path = Path(path)
    try:
        if not zipfile.is_zipfile(path) and path.is_file():
            raise ExportError(f"{path}: this is no light field, or one that was cut short")
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile) or set(ARRAYS) - set(archive.files):
                raise ExportError(f"{path}: this is no light field of lensbench")
            light, coverage, reach, text = (archive[name] for name in ARRAYS)
            fill = float(archive["fill"]) if "fill" in archive.files else 1.0           # as older files have it
    except ExportError:
        raise
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror or error}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise ExportError(f"{path}: this light field is cut short or damaged ({error})") from error
    try:
        settings = Settings.from_dict(json.loads(str(text)))
    except (ValueError, TypeError) as error:
        raise ExportError(f"{path}: {error}") from error
    film = settings.film
    if (light.dtype not in (np.float16, np.float32) or coverage.dtype != light.dtype or light.ndim != 5
            or light.shape[2:] != (3, film.pixels_y, film.pixels_x)
            or coverage.shape != (*light.shape[:2], *light.shape[3:]) or not float(reach) > 0.0
            or not 0.0 <= fill <= 1.0):
        raise ExportError(f"{path}: the views of this light field are not those of its settings")
    return lb.LightField(camera(settings), float(reach), light, coverage, fill), settings
