"""A lens or a scene at its best: a lens on its own film, wide open, before the subject; and the first pictures to try.

Lengths in mm. Each of the three can be locked; it then stays as it was, within the range of the lens. The result
depends on the lens and on what is locked, not on the lens before.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of, design
from lensbench.app.bench.camera_kinds import unfit
from lensbench.app.bench.constraints import MARGIN, constrained, with_camera, with_film
from lensbench.app.bench.pose import at_home
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.bench.water_window import true_focus
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene
from lensbench.app.settings.settings import Settings, placed
from lensbench.app.settings.text_values import format_distance
from lensbench.core.kernels.cache import resumable
from lensbench.core.optics.system import FieldKind

FILM, APERTURE, FOCUS = "film", "aperture", "focus"     # what can be locked; FOCUS is the camera's place too
LOCKS = (FILM, APERTURE, FOCUS)

SUBJECT_DISTANCE = 1200.0       # from the home of the camera, of scenes that state no subject
FRAME = 520.0                   # of the scene at the subject, along the shorter side of the film
NEAREST = 250.0                 # a shorter distance would put a wide lens into the subject
CLOSE = 0.99                    # of the wanted distance: a nearer camera is said
ROOM = 150.0                    # kept free behind the camera
COVERED = 0.92                  # of a film's diagonal that an image circle must reach: corners may be dark
USUAL = (36.0, 24.0)
STEEPEST = math.radians(60.0)   # a steeper stated field gives no image height without knowing the projection


@resumable
def with_lens(settings: Settings, lens: str, locked: Collection[str] = (), zoom: float = 0.0) -> Settings:
    """The settings with a lens (a library name or a path) at its best, within its range.

    A camera without a lens becomes one with a lens; the model becomes “auto” where the lens cannot have the current
    one. zoom: from 0 (wide) to 1 (tele). locked: those of LOCKS that stay: the film with its crop, movements and
    curvature; the f-number; the focus distance with the position of the camera, which a camera between two keyframes
    keeps in any case. LensFileError, LensError or OSError if the lens cannot be read.
    """
    if not settings.has_lens:
        settings = with_camera(settings, "lens")
    chosen = replace(settings, lens=lens, edited="", focal_length=None, zoom=zoom, ghost_pair="")
    if unfit(chosen, chosen.lens_model):
        chosen = replace(chosen, lens_model="auto")
    if FILM not in locked:
        chosen = with_film(replace(chosen, crop=1.0, tilt=0.0, swing=0.0, rise=0.0, shift=0.0, film_radius=None),
                           *own_film(lens, design(replace(chosen, zoom=0.0))))
    if APERTURE not in locked:
        chosen = replace(chosen, f_number=None)
    if FOCUS not in locked and not chosen.keyframed:
        chosen = _before_subject(chosen)
    return constrained(chosen)


@lru_cache(maxsize=64)
def own_film(name: str, lens: lb.Lens) -> tuple[float, float]:
    """Width, height (mm) of a lens's film: stated, else the largest format in its image circle, else 4 : 3 in it."""
    if lens.film_size is not None:
        return lens.film_size
    circle = image_circle(name, lens)
    if circle is None:
        return USUAL
    return covered_format(circle)


def covered_format(circle: float) -> tuple[float, float]:
    """The largest usual film (width, height) under an image circle (mm); a 4 : 3 sensor if none is so small."""
    covered = [size for size in lb.FORMATS.values() if COVERED * math.hypot(*size) <= circle]
    if not covered:
        return (float(f"{0.8 * circle:.3g}"), float(f"{0.6 * circle:.3g}"))
    return max(covered, key=lambda size: math.hypot(*size))


def image_circle(name: str, lens: lb.Lens) -> float | None:
    """Diameter (mm) that a lens covers: of the library, else stated, else where light ends within 36 × 24 mm."""
    card = lenses.card(name)
    if card is not None and card.image_circle is not None:
        return card.image_circle
    stated = _stated_circle(lens)
    if stated is not None:
        return stated
    usual = replace(Settings(), lens=name, f_number=None, focus_distance=math.inf, focus_position="paraxial",
                    film_width=USUAL[0], film_height=USUAL[1])
    try:
        return 2.0 * lit_radius(bench_of(usual)) or None       # 0: no light reaches the film
    except (ValueError, OSError):
        return None


def _stated_circle(lens: lb.Lens) -> float | None:
    """Twice the largest image height of the system data (mm); None where none is stated, or none follows."""
    system = lens.system
    field = system.largest_field
    if not field > 0.0:
        return None
    if system.field_kind in (FieldKind.IMAGE_HEIGHT, FieldKind.REAL_IMAGE_HEIGHT):
        return 2.0 * field
    efl = lens.front_index * abs(lb.first_order(lens).efl)
    if system.field_kind is FieldKind.ANGLE and math.isfinite(efl) and math.radians(field) < STEEPEST \
            and all(math.isinf(distance) for distance in system.object_distances):
        return 2.0 * efl * math.tan(math.radians(field))
    return None


@resumable
def with_scene(settings: Settings, scene: str, locked: Collection[str] = ()) -> Settings:
    """The settings with a scene (a built-in name or a path) as it opens: framed on its subject and focused there.

    locked: as for `with_lens`; with "focus", and without a lens, the camera stands at the origin and keeps its focus
    distance. So does a lens that cannot be read: the worker reports it.
    """
    chosen = at_home(replace(settings, scene=scene))
    if FOCUS in locked or not chosen.has_lens:
        return chosen
    try:
        return constrained(_before_subject(chosen))
    except (ValueError, OSError):
        return chosen


def _stated_subject(scene: str) -> tuple[float, float] | None:
    """Distance and height (mm) of the subject that a scene states; None where it states none or cannot be read."""
    try:
        return cached_scene(scene).subject
    except (SceneFileError, OSError):           # the worker reports it
        return None


def subject_distance(scene: str) -> float:
    """Distance (mm) of the subject from the camera's home, the origin, along its home direction −z.

    As the scene states it. Of a scene file that does not, it is the object in the middle of the home view; where there
    is none, 1.2 m.
    """
    if (stated := _stated_subject(scene)) is not None:
        return stated[0]
    if scene in lb.SCENES:
        return SUBJECT_DISTANCE
    try:
        distance = float(cached_scene(scene).distance([[0.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]])[0])
    except (SceneFileError, OSError):
        return SUBJECT_DISTANCE
    return distance if math.isfinite(distance) else SUBJECT_DISTANCE


def subject_height(scene: str) -> float:
    """Height (mm) at the subject that fills the shorter side of the film: as stated, or by its distance."""
    stated = _stated_subject(scene)
    return stated[1] if stated is not None else FRAME * subject_distance(scene) / SUBJECT_DISTANCE


def _before_subject(settings: Settings) -> Settings:
    """The camera moved along its direction until the subject stands framed before it, and focused there."""
    stand = _place(settings)
    return settings if stand is None else replace(settings, position=stand.position, focus_distance=stand.distance)


def in_the_way(settings: Settings) -> str:
    """What keeps a camera that was placed before the subject from framing it, in a sentence; "" where nothing does."""
    try:
        stand = _place(settings) if settings.has_lens else None
    except (ValueError, OSError):                   # the worker reports it
        return ""
    if stand is None or settings.position != stand.position or not stand.distance < CLOSE * stand.framed:
        return ""
    return (f"An object of the scene stands in the way: the camera is {format_distance(stand.distance)} from the "
            f"subject, which this lens would frame from {format_distance(stand.framed)}")


class _Place(NamedTuple):
    """A place of the camera before the subject: its distances there, and where it would frame the subject (mm)."""

    position: tuple[float, float, float]
    distance: float
    framed: float


def _place(settings: Settings) -> _Place | None:
    """The place for the camera's direction; None for a lens that cannot focus. LensFileError, OSError."""
    try:
        lens = design(settings)
        fo, nearest_seen = lb.first_order(lens), lb.nearest_focus(lens)
    except lb.LensError:
        return None
    if not (math.isfinite(fo.efl) and fo.efl > 0.0 and math.isfinite(nearest_seen)):
        return None
    subject = subject_distance(settings.scene)
    magnification = min(settings.film.width, settings.film.height) / subject_height(settings.scene)
    framed = _framed(fo, lens.length, magnification)
    if lens.has_focus_groups and framed > nearest_seen * MARGIN:            # whose focal length changes with the focus
        near = lb.focused(lens, framed)
        framed = _framed(lb.first_order(near), near.length, magnification)
    nearest = true_focus(lens, nearest_seen, settings)
    framed = true_focus(lens, framed, settings) if framed > nearest_seen else framed
    back = placed((0.0, 0.0, 0.0), settings.yaw, settings.pitch)[:3, 2]
    point = np.array([0.0, 0.0, -subject])
    best, nearest = max(framed, NEAREST), nearest * MARGIN
    stated = _stated_subject(settings.scene)
    own = max(0.5 * stated[1], 1.0) if stated is not None else 1.0      # mm: a stated place may lie within the subject
    distance = max(min(best, _free(settings.scene, point, back, own)), nearest)
    x, y, z = (float(value) for value in point + distance * back)
    return _Place((x, y, z), distance, best)


def _framed(fo: lb.FirstOrder, length: float, magnification: float) -> float:
    """Distance (mm) from the film of an object of this magnification, for a lens of this first order."""
    return fo.efl * (2.0 + magnification + 1.0 / magnification) + length + fo.rear_principal - fo.front_principal


def _free(scene: str, point: np.ndarray, back: np.ndarray, own: float) -> float:
    """Free distance (mm) back from a point, inf for any; own: how far (mm) what stands at the point reaches."""
    try:
        return max(_wall(cached_scene(scene), tuple(point), tuple(back), own) - ROOM, NEAREST)
    except (SceneFileError, OSError):
        return math.inf


@lru_cache(maxsize=8)
def _wall(scene: lb.Scene, point: tuple[float, ...], back: tuple[float, ...], own: float) -> float:
    """Distance (mm) from a point to the next object along a unit vector, beyond `own`; the same for every lens."""
    return own + float(scene.distance([np.add(point, own * np.array(back))], [back])[0])


@dataclass(frozen=True)
class Trial:
    """One picture. about: what to look at and what to turn next. f_number None: wide open."""

    title: str
    about: str
    lens: str
    scene: str
    f_number: float | None = None
    blades: int | None = None


TRIALS = (
    Trial("Swirl", "A Biotar of 1927, wide open. Its clear apertures cut the blur at the edge to cat's eyes that "
          "turn about the middle. Turn Aperture towards f/4: the swirl goes", "lentil-zeiss-biotar-1927", "foliage"),
    Trial("Fisheye", "180° on one picture, by the real rays of a design of 1964. Move the mouse to the edge of the "
          "circle: the section shows where its rays enter", "lib-miyamoto-fisheye-1964", "room"),
    Trial("Hexagon bokeh", "Six straight blades at f/2: lights out of focus are images of the stop. Turn Aperture, "
          "focus on a light by a click, or set the blades by the button Stop", "canon-rf-l-usm-85-f12", "night-lights",
          2.0, 6),
)


@resumable
def tried(settings: Settings, trial: Trial) -> Settings:
    """The settings of a trial, with the pixels and the samples of these. LensFileError, LensError, OSError."""
    plain = replace(Settings(), scene=trial.scene, samples=settings.samples, pixels_x=settings.pixels_x,
                    pixels_y=settings.pixels_y)
    return constrained(replace(with_lens(plain, trial.lens), f_number=trial.f_number, blades=trial.blades))
