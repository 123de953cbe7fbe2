"""The flat window between a camera in air and water: focus distances as they are, and as the lens sees them.

Lengths in mm, from the film; of a camera without a lens, from its centre of projection. The focus distance of the
settings is the true one; a lens is focused on the distance at which it sees what is there.
"""

import math
from typing import TYPE_CHECKING

import lensbench as lb
from lensbench.cameras.flat_port import FlatPort
from lensbench.cameras.traced_light import foremost
from lensbench.kernels.figures import significant
from lensbench.kernels.root_finding import find_root
from lensbench.scenery.shading.participating_medium import WATER_INDEX

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings

SEEN_ALIKE = 1e-10              # of a distance: error of the focus through a window


def port_index(settings: "Settings") -> float:
    """The index of the water behind the flat window of the camera; 1 without a window."""
    return WATER_INDEX if settings.medium == "water" and not (settings.has_lens and settings.immersed) else 1.0


def port_before(lens: lb.Lens, film_distance: float, settings: "Settings") -> FlatPort:
    """The window before a focused lens; distances from the film."""
    return FlatPort(lens.length + film_distance - foremost(lens), port_index(settings))


def nearest_in_focus(lens: lb.Lens, settings: "Settings") -> float:
    """The nearest focus distance (mm) of a lens, through its window; LensError as `lb.nearest_focus`."""
    return true_focus(lens, lb.nearest_focus(lens), settings)


def true_focus(lens: lb.Lens, seen: float, settings: "Settings") -> float:
    """The distance (mm) beyond the window of what a lens is focused on that it sees at a distance."""
    if port_index(settings) == 1.0 or not math.isfinite(seen):
        return seen
    there = lb.focused(lens, seen)
    return float(port_before(there, lb.film_distance(there, seen), settings).true(seen))


def seen_focus(lens: lb.Lens, settings: "Settings") -> float:
    """The focus distance (mm) of the settings as the lens sees it, through its window, which moves with the film.

    FocusError, with distances beyond the window, where that is nearer than the lens can focus.
    """
    wanted = settings.focus_distance
    if port_index(settings) == 1.0 or not math.isfinite(wanted):
        return wanted

    def excess(seen: float) -> float:
        return true_focus(lens, seen, settings) - wanted

    nearest = lb.nearest_focus(lens)
    if excess(nearest) > 0.0:
        raise lb.FocusError(f"focus at {significant(wanted / 1000.0, 6)} m: through the window, the nearest distance "
                            f"of this lens is {significant(nearest_in_focus(lens, settings) / 1000.0, 4)} m from the "
                            "film")
    return find_root(excess, nearest, wanted, SEEN_ALIKE * wanted)


def port_of(settings: "Settings") -> FlatPort:
    """The window into water of a camera without a lens, which touches its centre of projection."""
    return FlatPort(0.0, port_index(settings))
