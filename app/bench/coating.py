"""The coating that T-stop and ghosts of a lens assume: chosen, or by the year of the lens."""

from typing import TYPE_CHECKING, NamedTuple

import lensbench as lb
from lensbench.app.settings.lens_settings import AUTO
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import read_ghost_pair

if TYPE_CHECKING:
    from lensbench.core.rendering.ghost_image import Flare

LAST_UNCOATED, LAST_SINGLE = 1945, 1970         # years: coating became usual, then coating with several layers


class Coating(NamedTuple):
    """A key of COATINGS, and its assumption in words."""

    name: str
    why: str


def coating(settings: Settings, lens: lb.Lens) -> Coating:
    """The coating: as set, else by the year, single-layer if unknown. Surfaces keep a coating of their own."""
    assumed = _assumed(settings, lens)
    own = sum(surface.coating is not None for surface in lens.surfaces)
    return assumed if not own else assumed._replace(why=f"{assumed.why}; {own} of {len(lens.surfaces)} surfaces have a "
                                                    "coating of their own")


def _assumed(settings: Settings, lens: lb.Lens) -> Coating:
    if settings.coating != AUTO:
        return Coating(settings.coating, f"{_loss(settings.coating)}; chosen")
    if lens.year is None:
        return Coating("single-layer", f"{_loss('single-layer')}; assumed, its year is not known")
    name = "uncoated" if lens.year <= LAST_UNCOATED else "single-layer" if lens.year <= LAST_SINGLE else "multi-layer"
    return Coating(name, f"{_loss(name)}; by its year, {lens.year}")


def flare(settings: Settings) -> "Flare | None":
    """The ghosts and stars that the settings ask for, also where the picture can have none, which it says; or None."""
    if not (settings.ghosts or settings.stars):
        return None
    from lensbench.app.bench.build import design, picture_wavelength, published
    from lensbench.core.rendering.ghost_image import Flare

    name = coating(settings, design(settings)).name if settings.has_lens else "uncoated"
    alone = read_ghost_pair(settings.ghost_pair)
    first, _, second = alone.partition("-")
    return Flare(name, settings.ghost_strength if settings.ghosts else 0.0,
                 ((int(first), int(second)),) if alone else (),
                 stars=settings.star_strength if settings.stars else 0.0,
                 wavelength=picture_wavelength(settings, published(settings)) if settings.has_lens else None)


def missing_ghost(settings: Settings) -> str:
    """Why the ghost that is shown alone does not exist in the current lens, in a sentence; "" where it does."""
    if not (settings.ghosts and settings.ghost_pair and settings.has_lens):
        return ""
    from lensbench.app.bench.build import design
    from lensbench.core.optics.ghost_path import no_such_pair

    first, _, second = read_ghost_pair(settings.ghost_pair).partition("-")
    try:
        return no_such_pair(design(settings), ((int(first), int(second)),))
    except (ValueError, OSError):                   # the worker reports a lens that cannot be
        return ""


def _loss(name: str) -> str:
    return {"uncoated": "the reflection of bare glass", "single-layer": "a quarter wave of MgF₂",
            "multi-layer": "three layers on every surface to air"}[name]
