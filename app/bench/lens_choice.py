"""A lens at its best: on its own film, wide open, before the subject; and the first pictures to try.

Lengths in mm. Each of the three can be locked; it then stays as it was, within the range of the lens. The result
depends on the lens and on what is locked, not on the lens before.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import lru_cache

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of, design
from lensbench.app.bench.camera_kinds import unfit
from lensbench.app.bench.constraints import constrained, with_camera, with_film
from lensbench.app.bench.framing import PLACE, SIZE, frame_height, framed, resized, with_scene
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.cache import resumable
from lensbench.core.optics.system import FieldKind

FILM, APERTURE, FOCUS = "film", "aperture", PLACE       # what can be locked; FOCUS is the camera's place too
LOCKS = (FILM, APERTURE, FOCUS, SIZE)

COVERED = 0.92                  # of a film's diagonal that an image circle must reach: corners may be dark
USUAL = (36.0, 24.0)
STEEPEST = math.radians(60.0)   # a steeper stated field gives no image height without knowing the projection


@resumable
def with_lens(settings: Settings, lens: str, locked: Collection[str] = (), zoom: float = 0.0) -> Settings:
    """The settings with a lens (a library name or a path) at its best, within its range.

    A camera without a lens becomes one with a lens; the model becomes “auto” where the lens cannot have the current
    one. zoom: from 0 (wide) to 1 (tele). locked: those of LOCKS that stay: the film with its crop, movements and
    curvature; the f-number; the focus distance with the position of the camera, which a camera between two keyframes
    keeps in any case; SIZE: how large the current picture shows what it is focused on. LensFileError, LensError or
    OSError if the lens cannot be read.
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
    height = frame_height(settings) if SIZE in locked and FOCUS not in locked else None
    return constrained(framed(chosen, locked)) if height is None else resized(chosen, height)


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
          "focus on a light by a click, or set the blades by the button Flare", "canon-rf-l-usm-85-f12", "night-lights",
          2.0, 6),
)


@resumable
def tried(settings: Settings, trial: Trial) -> Settings:
    """The settings of a trial, with the pixels and the samples of these. LensFileError, LensError, OSError."""
    plain = replace(with_scene(Settings(), trial.scene), samples=settings.samples, pixels_x=settings.pixels_x,
                    pixels_y=settings.pixels_y)
    return constrained(replace(with_lens(plain, trial.lens), f_number=trial.f_number, blades=trial.blades))
