"""The automatic model: which one a picture is taken with, and how that is said.

In the window a choice is made beside the picture: after its first pass, which is that of the choice before where only
focus, aperture or field of view have moved since, and of the full trace otherwise. Where another model is chosen, the
picture begins anew with it.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

from lensbench.app.state.settings import Settings

if TYPE_CHECKING:
    from lensbench.analysis.model_choice import Choice


class Chosen(NamedTuple):
    """A choice, and the settings that it was made for."""

    choice: "Choice"
    of: Settings


def choice_key(settings: Settings) -> Settings:
    """What a choice depends on: everything else is set to its default."""
    return settings.picture.plain("yaw", "pitch", "end_yaw", "end_pitch", "seed", "view", "visibility", "fog_light")


def is_automatic(settings: Settings) -> bool:
    """Whether the picture of these settings is taken with a model that has to be chosen: not a view of its samples."""
    return settings.model == "auto" and not settings.sample_view


def judged(settings: Settings, camera: Any, scene: Any, before: Chosen | None) -> Chosen:
    """The choice for these settings; one that was made just before, for the same lens, gives way reluctantly."""
    import lensbench as lb

    of = choice_key(settings)
    previous = before.choice if before is not None and before.of.lens == of.lens else None
    return Chosen(lb.choose_model(camera, scene, previous=previous), of)


def provisional(settings: Settings, camera: Any, before: Chosen | None) -> Any:
    """The camera for the first pass of a picture whose choice is not made yet; see the module."""
    from dataclasses import replace

    if before is not None and before.choice.model != "pinhole":
        of = choice_key(settings)
        moved = {name: getattr(before.of, name) for name in ("focus_distance", "f_number", "crop")}
        if replace(of, **moved) == before.of:
            try:
                return before.choice.applied(camera)
            except ValueError:                  # it cannot stand before this object
                pass
    return replace(camera, model="trace")


def record(choice: "Choice") -> dict[str, Any]:
    """A choice as plain values, for a picture's metadata and for JSON."""
    return {"model": choice.model, "degree": choice.degree or None, "error_px": choice.error_px,
            "error_stops": choice.error_stops, "refused": choice.reason or None}


def headline(choice: "Choice", speeds: tuple[float, float] | None) -> list[str]:
    """In a few words each: the choice, its error, what it saves, and why the next simpler model was refused.

    speeds: ns that a ray takes by this model and by the full trace.
    """
    words = [f"Auto: {choice.name}"]
    if choice.model != "trace":
        words.append(f"off by {choice.error_px:.2g} px")
        if speeds is not None:
            saved = speeds[1] - speeds[0]
            words.append(f"{saved:.0f} ns a ray saved ({speeds[1] / speeds[0]:.2g} ×)" if saved >= 0.5 else
                         "no faster than the full trace here")
    if choice.reason:
        words.append(f"not {choice.reason}")
    return words


def tale(choice: "Choice", speeds: tuple[float, float] | None) -> str:
    """The whole story, a line for each model that was looked at."""
    lines = ["The simplest model whose picture is within half a pixel and 0.05 stops of the full trace,",
             "at all the scene's depths: where light falls, how far it is blurred, how bright it is.", ""]
    for rung in choice.table[:-1]:
        lines.append(f"{rung.name[0].upper()}{rung.name[1:]}: {rung.worst}")
    last = choice.table[-1]
    lines.append(f"{last.name[0].upper()}{last.name[1:]}: chosen" + (
        "" if last.model == "trace" else f", off by {last.error_px:.2g} px and {last.error_stops:.2g} stops"))
    if speeds is not None and last.model != "trace":
        lines += ["", f"A ray takes {speeds[0]:.0f} ns; traced in full it would take {speeds[1]:.0f} ns"]
    return "\n".join(lines)
