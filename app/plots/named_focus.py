"""Focus on a thing of the scene by its name: what the picture shows of it is brought into focus, as by a click."""

from dataclasses import replace
from difflib import get_close_matches
from typing import NamedTuple

import numpy as np

from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.focus_plane import focused_at
from lensbench.app.bench.framing import framings
from lensbench.app.plots.pixel_rays import TOUCH, beam
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.core.scenery.objects.shape import Shape, displaced
from lensbench.core.text import cut, excerpt

MOST_NAMES = 12                 # in a message


class Named(NamedTuple):
    """A thing with a name: its middle (3,), mm, world frame; its radius, mm; its shape, None of a framing."""

    middle: np.ndarray
    radius: float
    shape: Shape | None = None


def named_things(settings: Settings) -> dict[str, Named]:
    """What has a name in the scene, at the time of the settings.

    The subject and the other framings, meshes and objects with a name, and all objects by kind and number, such as
    "sphere 2", in the order of the scene.
    """
    scene = cached_scene(settings.scene)
    things = {name: Named(np.array(framing.centre), 0.5 * framing.height)
              for name, framing in framings(settings.scene).items()}
    counts: dict[str, int] = {}
    for thing in scene.objects:
        shape, kind = displaced(thing, settings.moment) if thing.moves else thing, type(thing).__name__.lower()
        counts[kind] = counts.get(kind, 0) + 1
        for name in filter(None, (getattr(thing, "name", ""), f"{kind} {counts[kind]}")):
            things.setdefault(name.lower(), Named(np.asarray(shape.centre, float), float(shape.bounding_radius), shape))
    return things


def focused_on(settings: Settings, name: str) -> tuple[Settings, str]:
    """The settings focused on a thing, and a remark, or ""; SettingsError where there is no such thing in sight."""
    things = named_things(settings)
    if not settings.focuses:
        raise SettingsError("--focus-on: this camera has no focus")
    if name.lower() not in things:
        near = get_close_matches(name.lower(), things, 3, 0.5)
        known = ", ".join(near or list(things)[:MOST_NAMES])
        raise SettingsError(f"--focus-on {excerpt(name)}: the scene names no such thing; " + (
            f"choose one of {cut(known, 400)}" if known else "give its objects a name in the scene file"))
    middle, radius, shape = things[name.lower()]
    rasters, visible = camera(settings).raster_from_point(middle[None])
    if not visible[0]:
        raise SettingsError(f"--focus-on {excerpt(name)}: the picture does not show its middle; turn the camera")
    x, y = (float(value) for value in rasters[0])
    seen = beam(settings, (x, y))
    depth = float(-(np.linalg.inv(settings.present_pose) @ np.append(middle, 1.0))[2])
    if shape is None:
        is_met = abs(seen.ahead - depth) < radius
    else:
        is_met = seen.target is not None and shape.locate(seen.target, TOUCH) is not None
    remark = ""
    if is_met:
        depth = seen.ahead
    elif seen.ahead < depth:
        remark = f"--focus-on {cut(name)}: the {seen.thing} in front of it hides its middle; focused through it"
    focus = focused_at(settings, (x / settings.film.pixels_x, y / settings.film.pixels_y), depth)
    nearest = (readings(settings).nearest_focus or 0.0) * (1.0 + 1e-6)
    if focus.distance < nearest:
        remark = f"--focus-on {cut(name)}: nearer than the lens can focus; focused as near as it can"
    return replace(settings, focus_distance=max(focus.distance, nearest)), remark or (
        f"--focus-on {cut(name)}: {focus.remark}" if focus.remark else "")
