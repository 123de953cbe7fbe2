"""Lumigraphs on disk: numpy's .npz, as light fields are.

In it: `pictures` (down, across, 3, h, w) and `nearness` (down, across, h, w) as recorded, `spacing` and `distance` in
mm, and `settings`, the JSON text that exported pictures carry too; from these the middle pinhole is made again.
"""

import json
import zipfile
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.export import ExportError, replacing
from lensbench.app.light_field_file import checked_suffix
from lensbench.app.optics import camera
from lensbench.app.settings import Settings

ARRAYS = ("pictures", "nearness", "spacing", "distance", "settings")


def save_lumigraph(path: str | Path, lumigraph: lb.Lumigraph, settings: Settings) -> None:
    """Write a lumigraph and the settings that it was captured with; ExportError where that cannot be."""
    path = checked_suffix(path)
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, pictures=lumigraph.pictures, nearness=lumigraph.nearness, spacing=lumigraph.spacing,
                 distance=lumigraph.distance, settings=np.array(json.dumps(settings.to_dict(), allow_nan=False)))


def load_lumigraph(path: str | Path) -> tuple[lb.Lumigraph, Settings]:
    """Read what save_lumigraph wrote. ExportError: not there, not a lumigraph, cut short; what loading its lens
    raises where that is gone.
    """
    path = Path(path)
    try:
        if not zipfile.is_zipfile(path) and path.is_file():
            raise ExportError(f"{path}: this is no lumigraph, or one that was cut short")
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile) or set(ARRAYS) - set(archive.files):
                raise ExportError(f"{path}: this is no lumigraph; lensbench lightfield array records one")
            pictures, nearness, spacing, distance, text = (archive[name] for name in ARRAYS)
            settings = Settings.from_dict(json.loads(str(text)))
    except ExportError:
        raise
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror or error}") from error
    except (ValueError, TypeError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise ExportError(f"{path}: this lumigraph is cut short or damaged ({error})") from error
    film = settings.film
    if (pictures.dtype != np.float16 or nearness.dtype != np.float16 or pictures.ndim != 5
            or pictures.shape[2:] != (3, film.pixels_y, film.pixels_x)
            or nearness.shape != (*pictures.shape[:2], *pictures.shape[3:])
            or not float(spacing) > 0.0 or not float(distance) > 0.0):
        raise ExportError(f"{path}: the pictures of this lumigraph are not those of its settings")
    middle = lb.lumigraph_pinhole(camera(settings))
    return lb.Lumigraph(middle, float(spacing), float(distance), pictures, nearness), settings
