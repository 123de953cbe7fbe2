"""The flat window between a camera in air and water: focus distances as they are, and as the lens sees them.

Lengths in mm, from the film; of a camera without a lens, from its centre of projection. The focus distance of the
settings is the true one; a lens is focused on the distance at which it sees what is there.
"""

import math

import lensbench as lb
from lensbench.app.settings.settings import Settings
from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.cameras.real_lens_projection import foremost
from lensbench.core.kernels.numeric import find_root
from lensbench.core.scenery.shading.participating_medium import WATER_INDEX
from lensbench.core.text import significant

SEEN_ALIKE = 1e-10              # of a distance: error of the focus through a window
STEPS = 30                      # of a search, each of which leaves a third of the error or less


def port_index(settings: Settings) -> float:
    """The index of the water behind the flat window of the camera; 1 without a window."""
    return WATER_INDEX if settings.medium == "water" and not (settings.has_lens and settings.immersed) else 1.0


def port_before(lens: lb.Lens, film_distance: float, settings: Settings) -> FlatPort:
    """The window before a focused lens; distances from the film. None leaves them as they are, to the bit."""
    index = port_index(settings)
    return FlatPort(lens.length + film_distance - foremost(lens), index) if index != 1.0 else FlatPort()


def nearest_in_focus(lens: lb.Lens, settings: Settings) -> float:
    """The nearest focus distance (mm) of a lens, through its window; LensError as `lb.nearest_focus`."""
    return true_focus(lens, lb.nearest_focus(lens), settings)


def true_focus(lens: lb.Lens, apparent: float, settings: Settings, method: str = "paraxial") -> float:
    """The true distance (mm) of what a lens sees at a distance through its window; errors as of `lb.focused`."""
    if port_index(settings) == 1.0 or not math.isfinite(apparent):
        return apparent
    there = lb.focused(lens, apparent, method)
    return float(port_before(there, lb.film_distance(there, apparent, method), settings).true(apparent))


def seen_focus(lens: lb.Lens, settings: Settings) -> float:
    """The focus distance (mm) as a lens, focused paraxially, sees it through its window; FocusError if too near."""
    focus = settings.focus_distance
    if port_index(settings) == 1.0 or not math.isfinite(focus):
        return focus

    def excess(apparent: float) -> float:                   # the window moves with the film
        return true_focus(lens, apparent, settings) - focus

    nearest = lb.nearest_focus(lens)
    if excess(nearest) > 0.0 or not excess(focus) >= 0.0:
        raise lb.FocusError(f"focus at {significant(focus / 1000.0, 6)} m: through the window, the nearest distance "
                            f"of this lens is {significant(nearest_in_focus(lens, settings) / 1000.0, 4)} m from the "
                            "film")
    return find_root(excess, nearest, focus, SEEN_ALIKE * focus)


def seen_by_rays(lens: lb.Lens, settings: Settings, apparent: float) -> float:
    """The same of a lens that is focused by all its rays, from the distance that it sees when focused paraxially.

    Its film, and so the window, and its groups stand a little elsewhere. FocusError where rays focus no nearer.
    """
    if port_index(settings) == 1.0 or not math.isfinite(apparent):
        return apparent
    for _ in range(STEPS):
        off = settings.focus_distance - true_focus(lens, apparent, settings, "real")
        apparent += off / port_index(settings)
        if abs(off) <= SEEN_ALIKE * apparent:
            break
    return apparent


def port_of(settings: Settings) -> FlatPort:
    """The window into water of a camera without a lens, which touches its centre of projection."""
    return FlatPort(0.0, port_index(settings))
