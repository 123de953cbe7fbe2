"""The coating that the T-stop of a lens assumes: chosen, or by the year of the lens."""

from typing import TYPE_CHECKING, NamedTuple

import lensbench as lb
from lensbench.app.state.lens_settings import AUTO
from lensbench.kernels.figures import significant
from lensbench.optics.transmission import COATINGS

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings

LAST_UNCOATED, LAST_SINGLE = 1945, 1970         # years: coating became usual, then coating with several layers


class Coating(NamedTuple):
    """A key of COATINGS, and its assumption in words."""

    name: str
    why: str


def coating(settings: "Settings", lens: lb.Lens) -> Coating:
    """The coating of these settings; by default that of the year of the lens, and single-layer where none is known."""
    if settings.coating != AUTO:
        return Coating(settings.coating, f"{_loss(settings.coating)}; chosen")
    if lens.year is None:
        return Coating("single-layer", f"{_loss('single-layer')}; assumed, its year is not known")
    name = "uncoated" if lens.year <= LAST_UNCOATED else "single-layer" if lens.year <= LAST_SINGLE else "multi-layer"
    return Coating(name, f"{_loss(name)}; by its year, {lens.year}")


def _loss(name: str) -> str:
    part = COATINGS[name]
    return "the reflection of bare glass" if part is None else f"{significant(100.0 * part)} % lost a surface to air"
