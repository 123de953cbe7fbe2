"""The automatic lens model: its choice for a picture, and texts that describe the choice.

The window chooses the model in the background, after the first pass of the picture. That pass uses the previous
choice if only focus, aperture or field of view have changed since, and the full trace otherwise. A different choice
restarts the picture.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

from lensbench.app.settings.settings import Settings
from lensbench.core.text import fixed, significant

if TYPE_CHECKING:
    from lensbench.core.analysis.model_choice import Choice, Rung


class Chosen(NamedTuple):
    """A choice of model, and the settings that it depends on."""

    choice: "Choice"
    of: Settings


def choice_key(settings: Settings) -> Settings:
    """The settings that a choice depends on; everything else is at its default."""
    return settings.picture.plain("yaw", "pitch", "end_yaw", "end_pitch", "seed", "view", "visibility", "fog_light")


def is_automatic(settings: Settings) -> bool:
    """Whether the picture of these settings needs a choice of model; views of its samples do not."""
    return settings.is_automatic and not settings.sample_view


def choose(settings: Settings, camera: Any, scene: Any, before: Chosen | None) -> Chosen:
    """The choice for these settings; the previous one of the same lens is kept unless another is clearly better."""
    import lensbench as lb

    of = choice_key(settings)
    previous = before.choice if before is not None and before.of.lens == of.lens else None
    return Chosen(lb.choose_model(camera, scene, previous=previous), of)


def provisional(settings: Settings, camera: Any, before: Chosen | None) -> Any:
    """The camera for the first pass of a picture, before the choice; see the module docstring."""
    from dataclasses import replace

    if before is not None and before.choice.model != "pinhole":
        of = choice_key(settings)
        moved = {name: getattr(before.of, name) for name in ("focus_distance", "f_number", "crop")}
        if replace(of, **moved) == before.of:
            try:
                return before.choice.applied(camera)
            except ValueError:                  # invalid for this focus distance
                pass
    return replace(camera, model="trace")


def record(choice: "Choice") -> dict[str, Any]:
    """A choice as plain values, for the metadata of a picture and for JSON."""
    return {"model": choice.model, "degree": choice.degree or None, "error_px": choice.error_px,
            "error_stops": choice.error_stops, "refused": choice.reason or None}


def choice_summary(choice: "Choice", speeds: tuple[float, float] | None) -> list[str]:
    """The choice, its error, the time saved, why not a simpler model. speeds: ns a ray by it and in full."""
    words = [f"Auto: {choice.name}"]
    if choice.model != "trace":
        words.append(f"off by {significant(choice.error_px, 2)} px")
        if speeds is not None:
            saved = speeds[1] - speeds[0]
            words.append(f"{fixed(saved, 0)} ns a ray saved "
                         f"({significant(speeds[1] / speeds[0], 2)} ×)" if saved >= 0.5 else
                         "no faster than the full trace here")
    if choice.reason:
        refused = choice.table[-2]
        words.append(f"kept, as {refused.name} is near the limit: {refused.worst}" if _near_limit(refused) else
                     f"not {choice.reason}")
    return words


def _near_limit(rung: "Rung") -> bool:
    """Whether a refused model is within the tolerances, but not by enough to replace the one before."""
    from lensbench.core.analysis.model_choice import KEEP, TOLERANCE_PX, TOLERANCE_STOPS

    errors = rung.error_px / TOLERANCE_PX, rung.error_stops / TOLERANCE_STOPS
    return KEEP < max(errors) <= 1.0


def choice_details(choice: "Choice", speeds: tuple[float, float] | None) -> str:
    """Full description of the choice, with a line for each compared model."""
    lines = ["The simplest model whose picture is within half a pixel and 0.05 stops of the full trace,",
             "at all the scene's depths: where light falls, how far it is blurred, how bright it is.", ""]
    for rung in choice.table[:-1]:
        kept = ", near the limit: the model before is kept" if _near_limit(rung) else ""
        lines.append(f"{rung.name[0].upper()}{rung.name[1:]}: {rung.worst}{kept}")
    last = choice.table[-1]
    lines.append(f"{last.name[0].upper()}{last.name[1:]}: chosen" + (
        "" if last.model == "trace" else f", off by {significant(last.error_px, 2)} px and "
                                         f"{significant(last.error_stops, 2)} stops"))
    if speeds is not None and last.model != "trace":
        lines += ["", f"A ray takes {fixed(speeds[0], 0)} ns; traced in full it would take {fixed(speeds[1], 0)} ns"]
    return "\n".join(lines)
