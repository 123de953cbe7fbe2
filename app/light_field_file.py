"""Light fields on disk: numpy's .npz, an archive of plain arrays that every scientific program reads.

In it: `light` (views down, views across, 3, h, w) and `coverage` (down, across, h, w) as recorded, `reach`, `fill`, and
`settings`, the JSON text that exported pictures carry too; from these the camera is made again. Of a plenoptic camera
the sensor's picture `raw` (h, w, 3) and its `white` (h, w), the number of pixels behind each microlens, `behind`, and
the f-number of those, `microlenses`. Not compressed: noise does not shrink, and a light field is opened as fast as
the disk gives it.
"""

import json
import zipfile
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.export import ExportError, replacing
from lensbench.app.light_field_look import Recording
from lensbench.app.optics import camera
from lensbench.app.settings import Settings

SUFFIX = ".npz"
VIEWS = ("light", "coverage", "reach", "settings")
SENSOR = ("raw", "white", "behind", "microlenses", "settings")


def save_light_field(path: str | Path, recording: Recording) -> None:
    """Write what was recorded; ExportError where that cannot be."""
    path, raw, field = checked_suffix(path), recording.raw, recording.field
    text = np.array(json.dumps(recording.settings.to_dict(), allow_nan=False))
    with replacing(path) as part, part.open("wb") as file:
        if raw is None:
            np.savez(file, light=field.light, coverage=field.coverage, reach=field.reach, fill=field.fill,
                     settings=text)
        else:
            np.savez(file, raw=raw.picture, white=raw.white, behind=raw.camera.pixels,
                     microlenses=raw.camera.microlens_f_number, settings=text)


def checked_suffix(path: str | Path) -> Path:
    """The path of a light field; ExportError for another suffix."""
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise ExportError(f"{path}: light fields are written as {SUFFIX}")
    return path


def load_light_field(path: str | Path) -> Recording:
    """Read what save_light_field wrote. ExportError: not there, not a light field, cut short; what loading its lens
    raises where that is gone.
    """
    path = Path(path)
    try:
        if not zipfile.is_zipfile(path) and path.is_file():
            raise ExportError(f"{path}: this is no light field, or one that was cut short")
        with np.load(path, allow_pickle=False) as archive:
            names = set(archive.files) if isinstance(archive, np.lib.npyio.NpzFile) else set()
            known = SENSOR if "raw" in names else VIEWS
            if set(known) - names:
                raise ExportError(f"{path}: this is no light field of lensbench")
            found = {name: archive[name] for name in known}
            fill = float(archive["fill"]) if "fill" in names else 1.0           # as older files have it
    except ExportError:
        raise
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror or error}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise ExportError(f"{path}: this light field is cut short or damaged ({error})") from error
    try:
        settings = Settings.from_dict(json.loads(str(found["settings"])))
    except (ValueError, TypeError) as error:
        raise ExportError(f"{path}: {error}") from error
    recording = _of_sensor(found, settings) if "raw" in found else _of_views(found, fill, settings)
    if recording is None:
        raise ExportError(f"{path}: the views of this light field are not those of its settings")
    return recording


def _of_views(found: dict[str, np.ndarray], fill: float, settings: Settings) -> Recording | None:
    """None where the arrays do not belong together."""
    light, coverage, reach, film = found["light"], found["coverage"], float(found["reach"]), settings.film
    if (light.dtype not in (np.float16, np.float32) or coverage.dtype != light.dtype or light.ndim != 5
            or light.shape[2:] != (3, film.pixels_y, film.pixels_x)
            or coverage.shape != (*light.shape[:2], *light.shape[3:]) or not reach > 0.0 or not 0.0 <= fill <= 1.0):
        return None
    return Recording(lb.LightField(camera(settings), reach, light, coverage, fill), settings)


def _of_sensor(found: dict[str, np.ndarray], settings: Settings) -> Recording | None:
    """None where the arrays do not belong together."""
    plenoptic = lb.PlenopticCamera(camera(settings), int(found["behind"]), float(found["microlenses"]))
    raw, white = found["raw"], found["white"]
    if raw.dtype != np.float32 or raw.shape != (*plenoptic.sensor[::-1], 3) or white.shape != raw.shape[:2]:
        return None
    picture = lb.RawPicture(plenoptic, raw, white)
    return Recording(picture.decoded(), settings, picture)
