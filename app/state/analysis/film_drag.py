"""The focus distance that puts the film elsewhere behind the lens.

The film of a lens with focus groups is fixed: its lens as a whole is taken instead, paraxially. Lengths in mm.
"""

from dataclasses import replace

import lensbench as lb
from lensbench.app.state.build import Setup


def film_z(built: Setup) -> float:
    """Where the film of the lens as a whole is, in the lens frame; LensError for a lens that cannot be focused."""
    whole, nearest = _whole(built.lens)
    return whole.length + lb.film_distance(whole, max(built.focus_distance, nearest))


def focus_at(built: Setup, shift: float) -> float:
    """The focus distance of a film that is shifted by so much along +z; the present one where there is none."""
    try:
        whole, nearest = _whole(built.lens)
        now = lb.film_distance(whole, max(built.focus_distance, nearest))
        film = min(now + shift, lb.film_distance(whole, nearest))
        port = replace(built.port, window=built.port.window + film - now)
        return float(port.true(max(lb.focused_distance(whole, film), nearest)))
    except lb.LensError:
        return float(built.port.true(built.focus_distance))


def _whole(lens: lb.Lens) -> tuple[lb.Lens, float]:
    """The lens without focus groups, and its nearest focus distance."""
    whole = replace(lens.at(close=0.0), positions=None)
    return whole, max(lb.nearest_focus(lens), lb.nearest_focus(whole))
