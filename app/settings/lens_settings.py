"""The settings of the lens itself, the first fields of Settings. Imports no optics: the help of commands is quick."""

from dataclasses import dataclass

from lensbench.app.settings.setting import LENGTH, NOTHING, setting
from lensbench.app.settings.text_values import read_length

AUTO = "auto"
COATINGS = {AUTO: "By year", "uncoated": "None", "single-layer": "Single-layer", "multi-layer": "Multi-layer"}


@dataclass(frozen=True)
class LensSettings:
    """Which lens, how large, and its coating."""

    lens: str = setting("pbrt-dgauss-50mm")             # a library name, or a path
    edited: str = setting("")       # the text of the edited lens (`lenses.editing`), instead of that of `lens`
    focal_length: float | None = setting(
        None, unit="mm", bounds=LENGTH, none="designed", read=read_length, metavar="LENGTH",
        help="scale the whole prescription to this focal length (of a zoom its shortest), such as 35mm")
    coating: str = setting("auto", choices=COATINGS, restarts=NOTHING, figures=True,
                           help="of the surfaces to air, for T-stop and ghosts: uncoated, single-layer (MgF2, about "
                           "1.3%% lost a surface), multi-layer (three layers, 0.3%%), or auto, by the year of the "
                           "lens: coated after 1945")
