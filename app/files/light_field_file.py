"""Light fields on disk: numpy's .npz, an archive of plain arrays that every scientific program reads.

Arrays: `light` (views down, views across, 3, h, w) and `coverage` (down, across, h, w) as recorded, with finer pixels
and a margin about the picture (`LightField.wide`) or, without these, with the picture's own; `reach`, `fill`, and
`settings`, the JSON text of exported pictures, from which the camera is built. With separate moments of the exposure
also `moments` (n, views down, views across, 3, h, w). A plenoptic camera has instead `raw`, the raw picture (h, w, 3),
`white`, its white picture (h, w), `behind`, the number of pixels behind each microlens, and `microlenses`, their
f-number. Not compressed: noise does not shrink, and reading is as fast as the disk.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.files.export import ExportError
from lensbench.app.files.npz import ArrayHeader, load_arrays, save_arrays
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.light_field_query import Recording
from lensbench.app.state.settings import Settings
from lensbench.kernels.figures import significant
from lensbench.lightfields.light_field import FINER, WIDEST, of_wide, widened

VIEWS = {"light", "coverage", "reach"}
SENSOR = {"raw", "white", "behind", "microlenses"}
OPTIONAL = {"fill", "moments"}


def save_light_field(path: str | Path, recording: Recording) -> None:
    """Write a recording; ExportError if it cannot be written."""
    raw, field = recording.raw, recording.field
    if raw is None:
        field = field.wide or field
        moments = {} if field.moments is None else {"moments": field.moments}
        save_arrays(path, recording.settings, light=field.light, coverage=field.coverage, reach=field.reach,
                    fill=field.fill, **moments)
    else:
        save_arrays(path, recording.settings, raw=raw.picture, white=raw.white, behind=raw.camera.pixels,
                    microlenses=raw.camera.microlens_f_number)


def load_light_field(path: str | Path) -> Recording:
    """Read a file of save_light_field; ExportError if it is missing, incomplete or no light field; or lens errors."""
    found, settings = load_arrays(Path(path), "light field", "lightfield capture", _wanted, _fit)
    try:
        return _of_sensor(found, settings) if "raw" in found else _of_views(found, settings)
    except lb.LightFieldError as error:
        raise ExportError(f"{path}: {error}") from error


def _wanted(names: set[str]) -> set[str]:
    known = SENSOR if "raw" in names else VIEWS
    if known - names:
        return set()
    return known | (OPTIONAL & names if known is VIEWS else set())


def _fit(headers: Mapping[str, ArrayHeader], settings: Settings) -> bool:
    """Whether arrays of these headers are a recording by these settings."""
    picture = (settings.pixels_y, settings.pixels_x)
    if "raw" in headers:
        raw, white = headers["raw"], headers["white"]
        return (raw.kind == white.kind == "<f4" and len(raw.shape) == 3 and raw.shape[2] == 3
                and white.shape == raw.shape[:2] and raw.shape[0] % picture[0] == 0 == raw.shape[1] % picture[1]
                and raw.shape[0] // picture[0] == raw.shape[1] // picture[1]
                and headers["behind"].kind == "<i8" and not headers["behind"].shape
                and headers["microlenses"].kind == "<f8" and not headers["microlenses"].shape)
    light, coverage, moments = headers["light"], headers["coverage"], headers.get("moments")
    numbers = [header for name, header in headers.items() if name in ("reach", "fill")]
    return (light.kind in ("<f2", "<f4") and coverage.kind == light.kind and len(light.shape) == 5
            and min(light.shape[:2]) > 0 and light.shape[2] == 3
            and (light.shape[3:] == picture or _margin(light.shape, picture) is not None)
            and coverage.shape == (*light.shape[:2], *light.shape[3:])
            and all(header.kind == "<f8" and not header.shape for header in numbers)
            and (moments is None or moments.kind == light.kind and moments.shape[1:] == light.shape
                 and moments.shape[0] > 0))


def _of_views(found: dict[str, np.ndarray], settings: Settings) -> Recording:
    """The recording of these arrays; LightFieldError for numbers out of range."""
    reach, fill = float(found["reach"]), float(found.get("fill", 1.0))         # older files have no `fill`
    if not 0.0 < reach < 100.0 or fill > 1.0:
        raise lb.LightFieldError(f"reach {significant(reach)} and fill {significant(fill)}: this recording is damaged")
    of = camera(settings)
    margin = _margin(found["light"].shape, (settings.pixels_y, settings.pixels_x))
    field = lb.LightField(of if margin is None else widened(of, margin), reach, found["light"], found["coverage"], fill,
                          moments=found.get("moments"))
    return Recording(field if margin is None else of_wide(of, field), settings)


def _margin(shape: tuple[int, ...], picture: tuple[int, int]) -> tuple[int, int] | None:
    """Pixels across and down by which views of this shape surround a picture (h, w); None for other pixels."""
    (down, y), (across, x) = (divmod(size - FINER * inner, 2 * FINER)
                              for size, inner in zip(shape[3:], picture, strict=True))
    most = [size // WIDEST for size in picture]
    return (across, down) if x == y == 0 and 0 <= down <= most[0] and 0 <= across <= most[1] else None


def _of_sensor(found: dict[str, np.ndarray], settings: Settings) -> Recording:
    """The recording of these arrays; LightFieldError for numbers out of range."""
    raw, behind = found["raw"], int(found["behind"])
    if behind * settings.pixels_y != raw.shape[0]:
        raise lb.LightFieldError(f"{behind} pixels behind each microlens: this picture has others")
    plenoptic = lb.PlenopticCamera(camera(settings), behind, float(found["microlenses"]))
    picture = lb.RawPicture(plenoptic, raw, found["white"])
    return Recording(picture.decoded(), settings, picture)
