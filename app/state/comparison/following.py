"""The settings A while they are locked to B: every dial that is turned in B turns in A as well.

What B takes with another lens or another camera is its own: A keeps its lens, and the film, focus and place that
belong to it.
"""

from dataclasses import fields, replace

from lensbench.app.state.constraints import constrained
from lensbench.app.state.settings import Settings

OWN = ("lens", "edited", "camera", "lens_model", "degree", "focal_length")        # a change of these leaves A as it is
NEVER = ("compare", "wipe", "overlay", "limit")                         # these are of the window, not of a picture


def followed(a: Settings, before: Settings, after: Settings) -> Settings:
    """A after B has changed from `before` to `after`, within the range of A's own lens.

    A lens that opens less far opens as far as it can, and one that focuses less near focuses as near as it can. Where A
    cannot take a change at all, it stays as it was.
    """
    changed = {field.name: getattr(after, field.name) for field in fields(Settings)
               if getattr(after, field.name) != getattr(before, field.name)}
    if any(name in changed for name in OWN):
        return a
    for name in NEVER:
        changed.pop(name, None)
    if not changed:
        return a
    try:
        return constrained(replace(a, **changed).checked())
    except (ValueError, OSError):
        return a
