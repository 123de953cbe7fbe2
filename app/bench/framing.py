"""Where a camera stands: before what it is framed on, with this in focus.

One rule for a chosen lens, scene, format and framing, and for the keys that reset the camera. Lengths in mm. A camera
keeps its direction and is moved until the thing stands in the middle of the picture, as high as its framing states.
"""

import math
from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import design
from lensbench.app.bench.constraints import MARGIN, constrained, full_view
from lensbench.app.bench.pose import at_home
from lensbench.app.bench.water_window import true_focus
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene
from lensbench.app.settings.setting_table import FRAMINGS
from lensbench.app.settings.settings import Settings, placed
from lensbench.app.settings.text_values import format_distance
from lensbench.core.kernels.cache import resumable
from lensbench.core.scenery.scene import Framing

PLACE, SIZE = "focus", "framing"        # what can be locked: focus with the camera's place; the size of the subject
SUBJECT_DISTANCE = 1200.0       # from the home of the camera, of scenes that state no subject
FRAME = 520.0                   # of the scene at the subject, along the shorter side of the film
CLOSER, WIDER = 0.5, 2.0        # of its height, of framings that a scene does not state
NEAREST = 250.0                 # a shorter distance would put a wide lens into the subject
CLOSE = 0.99                    # of the wanted distance: a nearer camera is stated
SEEN = 0.02                     # of the focus distance: a smaller movement of the camera is not said
ROOM = 150.0                    # kept free behind the camera
WIDEST = math.radians(150.0)    # a camera without a lens that sees more is not moved, but stands at home


def framings(scene: str) -> dict[str, Framing]:
    """What a scene can be framed on, from the nearest to the whole, by the names of FRAMINGS.

    The subject is the one that the scene states. Of a scene file that does not, it is the object in the middle of the
    home view; where there is none, a point at 1.2 m.
    """
    try:
        of_scene = cached_scene(scene)
    except (SceneFileError, OSError):           # the worker reports it
        return {"subject": Framing("subject", (0.0, 0.0, -SUBJECT_DISTANCE), FRAME)}
    named = {framing.name: framing for framing in of_scene.framings}
    if "subject" not in named:
        distance, height = of_scene.subject or _in_the_middle(scene, of_scene)
        named["subject"] = Framing("subject", (0.0, 0.0, -distance), height)
    subject = named["subject"]
    if "head" not in named:
        named.setdefault("close", Framing("close", subject.centre, CLOSER * subject.height))
    named.setdefault("whole-scene", Framing("whole-scene", subject.centre, WIDER * subject.height))
    return {name: named[name] for name in FRAMINGS if name in named}


def _in_the_middle(name: str, scene: lb.Scene) -> tuple[float, float]:
    """Distance and height (mm) of the subject of a scene that states none."""
    distance = SUBJECT_DISTANCE
    if name not in lb.SCENES:
        met = float(scene.distance([[0.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]])[0])
        distance = met if math.isfinite(met) else distance
    return distance, FRAME * distance / SUBJECT_DISTANCE


def framing_of(settings: Settings) -> Framing:
    """What the camera is framed on: the framing of the settings, or the subject of a scene that has no such one."""
    offered = framings(settings.scene)
    return offered.get(settings.framing, offered["subject"])


@resumable
def with_scene(settings: Settings, scene: str, locked: Collection[str] = ()) -> Settings:
    """The settings with a scene (a built-in name or a path) as it opens: framed on its subject, focused and exposed.

    locked: as for `with_lens`; with PLACE the camera keeps its focus distance and stands where the subject is in focus.
    A lens that cannot be read leaves the camera at the origin: the worker reports it.
    """
    chosen = replace(at_home(settings), scene=scene, framing="subject")
    if settings.exposing == "plain":
        chosen = replace(chosen, exposure=scene_exposure(scene))
    if PLACE in locked:
        return _standing(chosen, chosen.focus_distance) if math.isfinite(chosen.focus_distance) else chosen
    try:
        return constrained(framed(chosen))
    except (ValueError, OSError):
        return chosen


@resumable
def with_framing(settings: Settings, framing: str) -> Settings:
    """The settings with the camera moved along its direction until it is framed so; an unread lens leaves it."""
    try:
        return constrained(framed(replace(settings, framing=framing)))
    except (ValueError, OSError):
        return settings


def scene_exposure(scene: str) -> float:
    """Stops by which pictures of a scene are brightened when it is chosen."""
    try:
        return cached_scene(scene).exposure
    except (SceneFileError, OSError):
        return 0.0


def framed(settings: Settings, locked: Collection[str] = ()) -> Settings:
    """The camera moved along its direction until its framing fills the picture, and focused there.

    With PLACE locked, and between two keyframes, it stays. Errors of loading its lens.
    """
    if PLACE in locked or settings.keyframed:
        return settings
    stand = _stand(settings, framing_of(settings).height)
    return settings if stand is None else _standing(settings, stand.distance)


def _standing(settings: Settings, distance: float) -> Settings:
    """The camera at a distance (mm) before what it is framed on, along its direction, and focused there."""
    x, y, z = (float(value) for value in np.add(framing_of(settings).centre, distance * _back(settings)))
    return replace(settings, position=(x, y, z), focus_distance=distance)


def _back(settings: Settings) -> np.ndarray:
    """The unit vector (3,) from what the camera looks at to the camera."""
    return placed((0.0, 0.0, 0.0), settings.yaw, settings.pitch)[:3, 2]


def frame_height(settings: Settings) -> float | None:
    """Height (mm) of the scene in focus that fills the shorter side of the film; None where nothing is framed."""
    if not math.isfinite(settings.focus_distance):
        return None
    low, high = min(settings.film.width, settings.film.height), 1e9
    for _ in range(45):                                 # the distance grows with the height, up to life size
        height = math.sqrt(low * high)
        stand = _stand(settings, height, is_free=True)
        if stand is None:
            return None
        low, high = (height, high) if stand.framed < settings.focus_distance else (low, height)
    return height


def resized(settings: Settings, height: float) -> Settings:
    """The camera moved along its direction until what is in focus is seen as high (mm) again, and stays in focus.

    For a lens, format or field of view that has changed. As near as the lens focuses. Errors of loading its lens.
    """
    stand = _stand(settings, height, is_free=True)
    if stand is None or settings.keyframed or not math.isfinite(settings.focus_distance):
        return settings
    moved = (stand.distance - settings.focus_distance) * _back(settings)
    x, y, z = (float(value) for value in np.add(settings.position, moved))
    return constrained(replace(settings, position=(x, y, z), focus_distance=stand.distance))


def moved_text(before: Settings, after: Settings) -> str:
    """How far the camera was moved along its direction, in a sentence; "" where nobody would see that it was."""
    back = float(np.subtract(after.position, before.position) @ _back(after))
    if abs(back) < max(SEEN * after.focus_distance, 1.0) or not math.isfinite(after.focus_distance):
        return ""
    return f"Camera moved {'back' if back > 0.0 else 'forward'} {format_distance(abs(back))}"


def in_the_way(settings: Settings) -> str:
    """What keeps a camera that was placed before the subject from framing it, in a sentence; "" where nothing does."""
    try:
        stand = _stand(settings, framing_of(settings).height) if settings.has_lens else None
    except (ValueError, OSError):                   # the worker reports it
        return ""
    if stand is None or settings.position != _standing(settings, stand.distance).position \
            or not stand.distance < CLOSE * stand.framed:
        return ""
    return (f"An object of the scene stands in the way: the camera is {format_distance(stand.distance)} from the "
            f"subject, which this lens would frame from {format_distance(stand.framed)}")


class _Stand(NamedTuple):
    """Distance of the camera from what it is framed on, and the one from which it would be framed (mm)."""

    distance: float
    framed: float


def _stand(settings: Settings, height: float, is_free: bool = False) -> _Stand | None:
    """Where a height (mm) fills the shorter side; None for a lens that cannot focus. LensFileError, OSError.

    is_free: take nothing of the scene to stand in the way.
    """
    if not settings.has_lens:
        distance = _without_lens(settings, height)
        return _Stand(distance, distance)
    try:
        lens = design(settings)
        fo, nearest_seen = lb.first_order(lens), lb.nearest_focus(lens)
    except lb.LensError:
        return None
    if not (math.isfinite(fo.efl) and fo.efl > 0.0 and math.isfinite(nearest_seen)):
        return None
    magnification = min(settings.film.width, settings.film.height) / height
    wanted = _distance(lens, magnification)
    if lens.has_focus_groups and wanted > nearest_seen * MARGIN:            # whose focal length changes with the focus
        near = lb.focused(lens, wanted)
        wanted = _distance(near, magnification)
    nearest = true_focus(lens, nearest_seen, settings)
    wanted = true_focus(lens, wanted, settings) if wanted > nearest_seen else wanted
    best = wanted if is_free else max(wanted, NEAREST)
    free = math.inf if is_free else _free(settings)
    return _Stand(max(min(best, free), nearest * MARGIN), best)


def _without_lens(settings: Settings, height: float) -> float:
    """Distance (mm) from which a camera without a lens sees a height; that of its home where it is no matter of it."""
    fov = full_view(settings)[0] if settings.kind.has_view else math.pi
    if fov > WIDEST:
        return max(-framing_of(settings).centre[2], NEAREST)
    return max(0.5 * height / math.tan(0.5 * fov), NEAREST)


def _distance(lens: lb.Lens, magnification: float) -> float:
    """Distance (mm) from the film of an object of this magnification, which may lie in a medium."""
    fo, n = lb.first_order(lens), lens.front_index
    return (fo.efl * (1.0 + n + magnification + n / magnification) + lens.length + fo.rear_principal
            - fo.front_principal)


def _free(settings: Settings) -> float:
    """Free distance (mm) back from what the camera is framed on, inf for any."""
    centre, back = framing_of(settings).centre, _back(settings)
    try:
        scene = cached_scene(settings.scene)
    except (SceneFileError, OSError):
        return math.inf
    # A stated place may lie within the subject, which is not in its own way
    stated = scene.subject is not None or settings.framing in {framing.name for framing in scene.framings}
    own = max(0.5 * framing_of(settings).height, 1.0) if stated else 1.0
    return max(_wall(scene, centre, tuple(back), own) - ROOM, NEAREST)


@lru_cache(maxsize=8)
def _wall(scene: lb.Scene, point: tuple[float, ...], back: tuple[float, ...], own: float) -> float:
    """Distance (mm) from a point to the next object along a unit vector, beyond `own`; the same for every lens."""
    return own + float(scene.distance([np.add(point, own * np.array(back))], [back])[0])
