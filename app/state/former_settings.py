"""Settings of earlier versions: fields and words that have other names now.

Up to version 3 the field `model` named both the camera and the model of its lens. Files of those versions still open,
and the command line still takes the words; each conversion comes with a sentence that names the new word. Up to version
4 the focus distance through a window into water counted as in air.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from lensbench.app.state.text_values import format_distance

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings


class Replacement(NamedTuple):
    """The settings that took the place of a former word, and a reason, or ""."""

    settings: dict[str, str]
    reason: str = ""


FIELDS = {"splats": "light_tracing", "wet": "immersed", "focusing": "focus_position"}       # former: present
MODELS = {                              # former values of `model` that changed their name
    "hole": Replacement({"camera": "finite-pinhole"}),
    "bare": Replacement({"camera": "bare-sensor"}),
    "table": Replacement({"camera": "lens", "lens_model": "polynomial"},
                         "the table of rays is not offered any more, a polynomial is faster and more accurate"),
}
NAMES = ("model", *FIELDS)


def model_settings(word: str, cameras: Any, lens_models: Any) -> Replacement | None:
    """The settings for a value of the former `model`, or for one of its present names; None for an unknown word."""
    if word in MODELS:
        return MODELS[word]
    if word in lens_models:
        return Replacement({"camera": "lens", "lens_model": word})
    return Replacement({"camera": word}) if word in cameras else None


def converted(plain: dict[str, Any], cameras: Any, lens_models: Any) -> tuple[dict[str, Any], list[str]]:
    """Plain settings of any version under their present names, with a sentence for each former name in them."""
    now: dict[str, Any] = {}
    notes: list[str] = []
    for name, value in plain.items():
        found = model_settings(value, cameras, lens_models) if name == "model" and isinstance(value, str) else None
        if found is not None:
            now |= found.settings
            words = ", ".join(f'{key} = "{word}"' for key, word in found.settings.items())
            notes.append(f'model = "{value}" is now {words}' + (f": {found.reason}" if found.reason else ""))
        elif name in FIELDS:
            now[FIELDS[name]] = value
            notes.append(f"{name} is now {FIELDS[name]}")
        else:
            now[name] = value
    return now, notes


def true_in_water(settings: "Settings", say: Callable[[str], object]) -> "Settings":
    """Settings of a version before 5, whose focus through a window into water counts as in air, with the true focus."""
    from lensbench.app.state.build import design
    from lensbench.app.state.water_window import port_index, port_of, true_focus

    seen = settings.focus_distance
    if port_index(settings) == 1.0 or not math.isfinite(seen):
        return settings
    try:
        true = true_focus(design(settings), seen, settings) if settings.has_lens else port_of(settings).true(seen)
    except (ValueError, OSError):                       # the lens is not at hand, or does not focus there
        true = port_index(settings) * seen
    say(f"the focus through a window into water is now the true distance: {format_distance(seen)} became "
        f"{format_distance(true)}")
    return replace(settings, focus_distance=float(true))
