"""The circle of confusion of every pixel, for the overlays: from the depth map by the thin lens's formula.

With s measured from the front principal plane and u = 1/s the diameter is
c = A f |u_focus − u| / (1 − f u_focus), A the diameter of the entrance pupil: linear in u.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

from lensbench.app.state.build import setup
from lensbench.app.state.figures import blur_limit, readings
from lensbench.app.state.file_stamp import Stamp, file_stamp
from lensbench.app.state.settings import Settings


@dataclass(frozen=True)
class Blur:
    """CoC in pixels = gain |focus − 1/(depth − offset)|; sharp: the diameter up to which a pixel counts as in focus."""

    gain: float = 0.0           # pixels · mm
    focus: float = 0.0          # 1/mm
    offset: float = 0.0         # mm from the film to the front principal plane
    sharp: float = 1.5          # pixels

    @classmethod
    def of(cls, settings: Settings) -> "Blur":
        """The blur of these settings; zero where nothing is blurred, or where there is no lens."""
        try:
            return _blur(settings.optics, file_stamp(settings.lens))
        except (ValueError, OSError, ZeroDivisionError):
            return cls()


@lru_cache(maxsize=16)
def _blur(settings: Settings, lens: Stamp) -> Blur:
    if not (settings.has_stop and settings.kind.f_number):
        return Blur()
    pitch, sharp = settings.film.pitch, blur_limit(settings)
    if settings.kind.ideal_lens:
        offset, efl, f_number = 0.0, readings(settings).efl or 50.0, settings.f_number or math.inf
    else:
        lens_setup = setup(settings)
        offset, efl, f_number = lens_setup.principal_offset, lens_setup.first_order.efl, lens_setup.first_order.f_number
    focus = 1.0 / max(settings.focus_distance - offset, 1.01 * abs(efl))
    return Blur(efl * efl / f_number / (1.0 - efl * focus) / pitch, focus, offset, sharp / pitch)
