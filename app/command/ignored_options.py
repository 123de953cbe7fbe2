"""Options of a picture that were given and have no effect, with what to give instead."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from lensbench.app.state.camera_kinds import CAMERA_KINDS, LENS_MODELS
from lensbench.app.state.setting_table import SHAPES
from lensbench.app.state.settings import Settings


class _Need(NamedTuple):
    """When a setting has an effect, and what to do where it has none."""

    has_effect: Callable[[Settings], bool]
    instead: str = ""


def _of_lens(settings: Settings) -> bool:
    return settings.kind.has_lens


def _of_kinds_with(name: str) -> Callable[[Settings], bool]:
    return lambda settings: name in settings.kind.own


_STOP = _Need(lambda settings: settings.kind.has_stop and (not settings.has_lens or settings.has_stop))
_BLADES = _Need(lambda settings: _STOP.has_effect(settings) and not settings.stop_image,
                "leave out --stop-image, which takes the place of blades")
_FOG = _Need(lambda settings: settings.medium != "air", "give --medium too")
_END = _Need(lambda settings: settings.keyframed, "give --end-position too")
_NEEDS = {
    **{name: _Need(_of_kinds_with(name)) for kind in CAMERA_KINDS.values() for name in kind.own},
    "lens_radius": _Need(lambda settings: settings.kind.lens_radius, "the aperture of a lens is --f-number"),
    "f_number": _Need(lambda settings: settings.kind.f_number),
    "focus_distance": _Need(lambda settings: settings.kind.focuses),
    "blades": _BLADES, "blade_rotation": _BLADES, "roundness": _BLADES, "stop_image": _STOP,
    "lens_model": _Need(_of_lens), "dispersion": _Need(_of_lens), "focus_position": _Need(_of_lens),
    "ghost_strength": _Need(lambda settings: settings.ghosts, "give --ghosts too"),
    "ghost_pair": _Need(lambda settings: settings.ghosts, "give --ghosts too"),
    "star_strength": _Need(lambda settings: settings.stars, "give --stars too"),
    "tilt": _Need(_of_lens), "swing": _Need(_of_lens), "rise": _Need(_of_lens), "shift": _Need(_of_lens),
    "film_radius": _Need(_of_lens),
    "immersed": _Need(lambda settings: settings.kind.has_lens and settings.medium == "water", "give --medium water"),
    "degree": _Need(lambda settings: settings.kind.has_lens and LENS_MODELS[settings.lens_model].has_degree,
                    "give --lens-model polynomial"),
    "fov_axis": _Need(lambda settings: "fov_axis" in settings.kind.lists),
    "visibility": _FOG, "fog_light": _FOG, "end_yaw": _END, "end_pitch": _END,
}


def remarks(settings: Settings, given: set[str], options: dict[str, str], lens: str | None) -> Iterator[str]:
    """A line for each option without an effect, and for an aperture that is none.

    given: settings that options name. options: the option of each. lens: the LENS that was named.
    """
    if lens is not None and not settings.kind.has_lens:
        yield f"{lens} has no effect: the camera {settings.camera} has no lens; give --camera lens"
    for name, need in _NEEDS.items():
        if name in given and not need.has_effect(settings):
            yield f"--{options[name]} has no effect on the camera {settings.camera}" + (
                f": {need.instead}" if need.instead else "")
    if settings.kind.panorama:
        across, down = SHAPES[settings.layout]
        if settings.pixels_x * down != settings.pixels_y * across:
            yield (f"the layout {settings.layout} has the shape {across}:{down}: {settings.pixels_x}x"
                   f"{settings.pixels_y} stretches it; give --size {settings.pixels_y * across // down}x"
                   f"{settings.pixels_y}")
    if "f_number" in given and settings.f_number is None and settings.kind.ideal_lens:
        yield "--f-number open makes this camera a pinhole, for an ideal lens has no widest stop: give a number"
