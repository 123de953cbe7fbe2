"""The focus distance that puts the film elsewhere behind the lens."""

from dataclasses import replace

import lensbench as lb
from lensbench.app.state.analysis.query import Query


def focus_at(query: Query, shift: float) -> float:
    """The focus distance (mm) of a film that is shifted by so much (mm along +z); the present one where there is none.

    The film of a lens with focus groups is fixed: its lens as a whole is taken instead, paraxially.
    """
    lens = query.setup.lens
    whole = replace(lens.at(close=0.0), positions=None)
    try:
        nearest = max(lb.nearest_focus(lens), lb.nearest_focus(whole))
        now = lb.film_distance(whole, max(query.focus_distance, nearest))
        farthest_film = lb.film_distance(whole, nearest)
        return float(max(lb.focused_distance(whole, min(now + shift, farthest_film)), nearest))
    except lb.LensError:
        return query.focus_distance
