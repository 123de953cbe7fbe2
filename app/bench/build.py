"""The lens and the camera of the settings; only this module zooms, stops down and focuses a lens.

Lengths in mm. Every read-out is a function of the lens or camera built here; `camera_kinds` lists all cameras.

The film lies at the paraxial focus, at the position of least blur of all rays, or at that of best contrast. The setting
"auto" takes the last, and the paraxial focus, the limit of small stops, where the contrast there is as good.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.water_window import port_before, seen_by_rays, seen_focus
from lensbench.app.scenes.asset_files import Stamp, file_stamp, keeps_last_good
from lensbench.app.settings.camera_facts import AUTO
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import read_ghost_pair
from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.cameras.lens_settings import has_dispersion
from lensbench.core.imaging.spectrum import PICTURE, WAVELENGTHS
from lensbench.core.kernels.block import BLUE, RED
from lensbench.core.optics.axis_contrast import D_LIGHT, Light, axis_contrast
from lensbench.core.optics.focus import contrast_shift
from lensbench.core.scenery.shading.participating_medium import WATER_INDEX
from lensbench.core.text import excerpt, fixed, significant
from lensbench.lenses.stop_picture import read_picture
from lensbench.lenses.tables.paraxial import at_reference, is_d_line

if TYPE_CHECKING:
    from lensbench.core.rendering.ghost_image import Flare
    from lensbench.lenses.editing.document import LensDocument

VISIBLE = WAVELENGTHS[BLUE][0], WAVELENGTHS[RED][-1]    # µm, of pictures with dispersion
ENOUGH = 0.01                   # of contrast: a smaller gain does not move the film
RESOLVED = 0.2                  # contrast of lines that a lens shows: a soft one is focused by its least blur
POSITIONS = {"contrast": "for the best contrast", "real": "by the least blur", "paraxial": "paraxially"}


class FocusPosition(NamedTuple):
    """Method by which a lens is focused, as in `lb.film_distance`: "paraxial", "real" (least blur) or "contrast".

    blur: diameter (mm, 2√2 × rms) of an axis point in focus, by real rays; None where it is not known. contrasts: of
    30 lp/mm on the axis at each of POSITIONS, in their order. shift: of the film behind that of the least blur (mm).
    """

    method: str
    blur: float | None = None
    contrasts: tuple[float, ...] = ()
    shift: float = 0.0


@dataclass(frozen=True)
class Bench:
    """What stands on the bench: the lens in front of its film, stopped down and focused, with its film distance (mm).

    first_order: of this focused lens. at_infinity: of the same lens focused at infinity, for which the focal length is
    defined. f_number: that in air, focused at infinity. port: the flat window into water before the lens.
    focus_distance: that of the settings as the lens sees it, through this window. refused: the lens cannot be focused
    so, and is at its nearest focus. reason: why f-number or focus differs from the settings, or ""; the lens is then
    wide open, or at its nearest focus.
    """

    lens: lb.Lens
    first_order: lb.FirstOrder
    at_infinity: lb.FirstOrder
    f_number: float
    film: lb.Film
    film_distance: float
    focusing: FocusPosition
    port: FlatPort
    focus_distance: float
    refused: bool = False
    reason: str = ""

    @property
    def film_z(self) -> float:
        """The film plane in the lens frame (mm)."""
        return self.lens.length + self.film_distance

    @property
    def principal_offset(self) -> float:
        """From the front principal plane to the film (mm), where engraved distances begin."""
        return self.film_z - self.first_order.front_principal


@keeps_last_good(64)
def _load(lens: str, stamp: Stamp) -> lb.Lens:
    return lenses.load(lens).at(zoom=0.0, close=0.0)


@lru_cache(maxsize=64)
def document_of_text(text: str, name: str) -> "LensDocument":
    """The document of an edited lens's text; name: of the original lens, or its file. LensFileError or OSError."""
    from lensbench.lenses.editing.document import from_text

    return from_text(text, folder=Path(name).parent if Path(name).suffix else None)


@lru_cache(maxsize=64)
def _edited(text: str, name: str, stamp: Stamp) -> lb.Lens:
    """The lens of a document's text, with what the reader of its file assumed: the text does not hold that."""
    lens = document_of_text(text, name).lens.at(zoom=0.0, close=0.0)
    try:
        assumed = _load(name, stamp).findings
    except (ValueError, OSError):                       # the edits outlive their file
        return lens
    return replace(lens, findings=(*assumed, *(f for f in lens.findings if f not in assumed)))


def prescription(settings: Settings) -> lb.Lens:
    """The lens as its file, or the user's edits of it, state it: wide open, in its first positions, not scaled."""
    stamp = file_stamp(settings.lens)
    lens = _edited(settings.edited, settings.lens, stamp) if settings.edited else _load(settings.lens, stamp)
    return lens if lens.stop_image is None else _with_current_picture(lens)


def own_picture(settings: Settings) -> str:
    """The file of the picture that the lens itself has in its stop; "" for none."""
    if not settings.has_lens:
        return ""
    try:
        image = prescription(settings).stop_image
    except (ValueError, OSError):
        return ""
    return "" if image is None else image.file


def _with_current_picture(lens: lb.Lens) -> lb.Lens:
    """The lens with the picture in its stop as its file is now; as it was read where it cannot be read any more."""
    image = lens.stop_image
    if image is None or not image.file:
        return lens
    try:
        now = stop_picture(image.file)
    except SettingsError:
        return lens
    return lens if now == image else _pictured(lens, replace(now, name=image.name))


@lru_cache(maxsize=8)
def _pictured(lens: lb.Lens, image: lb.StopImage) -> lb.Lens:
    return replace(lens, stop_image=image)


def design(settings: Settings) -> lb.Lens:
    """The lens of `published` at the primary wavelength of its design, as plots and the film's position see it."""
    return at_reference(published(settings))[0]


def picture_wavelength(settings: Settings, lens: lb.Lens) -> float | None:
    """The wavelength (µm) of pictures through a lens that was designed for another one than the d line.

    It is the primary one of its design. None for a lens whose pictures are those of the d line, or of the visible
    spectrum: where its primary wavelength is visible, its dispersion known and not turned off.
    """
    wavelength = lens.reference_wavelength
    if is_d_line(wavelength):
        return None
    return None if settings.follows_lens and is_in_colour(settings, lens) else wavelength


def is_in_colour(settings: "Settings", lens: lb.Lens) -> bool:
    """Whether a picture through the lens itself shows its colour errors; an ideal model of it never does."""
    return (settings.dispersion != "off" and VISIBLE[0] <= lens.reference_wavelength <=
            VISIBLE[1] and has_dispersion(lens))


def wavelength_remark(settings: Settings) -> str:
    """What a user should know of the wavelength of these pictures; "" for the d line and the visible spectrum."""
    wavelength = picture_wavelength(settings, published(settings)) if settings.has_lens else None
    return "" if wavelength is None else (f"its pictures and numbers are for {significant(1000.0 * wavelength)} "
                                          "nm alone, the primary wavelength of its design")


def published(settings: Settings) -> lb.Lens:
    """The lens wide open with its glasses, scaled to the chosen focal length (for a zoom, its shortest), then zoomed.

    LensError if the settings zoom a lens that cannot zoom, SettingsError for a picture in the stop that cannot be read.
    """
    lens = prescription(settings)
    if settings.stop_image:
        lens = replace(lens, blades=0, stop_image=stop_picture(settings.stop_image))
    elif settings.blades is not None:
        lens = replace(lens, blades=settings.blades, blade_rotation=settings.blade_rotation,
                       roundness=settings.roundness, blade_reach=math.inf, stop_image=None)
    if settings.medium == "water" and settings.immersed:
        lens = replace(lens, front_index=WATER_INDEX)
    if settings.focal_length is not None:
        efl = lb.first_order(lens).efl
        lens = lens.scaled(settings.focal_length / efl)
    return lens.at(zoom=settings.zoom)


def bench_of(settings: Settings) -> Bench:
    """The lens of the settings in front of its film; ValueError or OSError if the lens cannot be loaded or built."""
    return _bench(design(settings), settings.optics)


@lru_cache(maxsize=64)
def _bench(lens: lb.Lens, settings: Settings) -> Bench:
    reasons = []
    if settings.f_number is not None:
        try:
            lens = lb.stopped_down(lens, settings.f_number)
        except lb.LensError as error:
            reasons.append(str(error))
    at_infinity, f_number = lb.first_order(lens), lb.f_number_at_infinity(lens)
    position, refused = FocusPosition("paraxial"), False
    try:
        distance, position = _focus(lens, settings)
        lens = lb.focused(lens, distance, position.method)
        film_distance = lb.film_distance(lens, distance, position.method, picture_light(settings, lens))
    except lb.LensError as error:
        reasons.append(str(error))
        refused = True
        lens, film_distance, distance = _at_nearest(lens, settings.focus_distance)
    return Bench(lens, lb.first_order(lens), at_infinity, f_number, settings.film, film_distance, position,
                 port_before(lens, film_distance, settings), distance, refused, "; ".join(reasons))


def _focus(lens: lb.Lens, settings: Settings) -> tuple[float, FocusPosition]:
    """The focus distance (mm) as the lens sees it, and the position of the film; LensError where there is none."""
    distance = seen_focus(lens, settings)
    position = focusing(lens, settings, distance)
    if position.method != "paraxial":
        try:
            by_rays = seen_by_rays(lens, settings, distance)
            away = lb.film_distance(lb.focused(lens, by_rays, "real"), by_rays, "real")
            if away > 0.0 or settings.focus_position == "real":
                return by_rays, position
            # The lens has no room for the film of its least blur
        except lb.LensError:                            # rays focus no nearer
            pass
        return distance, focusing(lens, replace(settings, focus_position="paraxial"), distance)
    return distance, position


def _at_nearest(lens: lb.Lens, distance: float) -> tuple[lb.Lens, float, float]:
    """The lens at its nearest focus, its film distance, that focus; some film distance where it cannot focus at all."""
    try:
        nearest = lb.nearest_focus(lens)
        lens = lb.focused(lens, nearest)
        return lens, lb.film_distance(lens, nearest), nearest
    except lb.LensError:
        return lens, max(lens.length, lens.surfaces[-1].semi_diameter), distance


def focusing(lens: lb.Lens, settings: Settings, distance: float) -> FocusPosition:
    """The position of the film behind a lens that is stopped down already, for a focus distance (mm) as it sees it.

    It is the paraxial focus for ideal models, and where the whole bundle cannot be focused so near.
    """
    if not settings.follows_lens:
        return FocusPosition("paraxial")
    return _compared(lens, distance, settings.focus_position, picture_light(settings, lens))


def picture_light(settings: Settings, lens: lb.Lens) -> Light:
    """Wavelengths (µm) and weights of pictures through a lens: those with dispersion, or the d line."""
    return PICTURE if settings.dispersion != "off" and settings.follows_lens and has_dispersion(lens) else D_LIGHT


@lru_cache(maxsize=64)
def _compared(lens: lb.Lens, distance: float, asked: str, light: Light) -> FocusPosition:
    try:
        shift, lens_at = contrast_shift(lens, distance, light), {
            method: lb.focused(lens, distance, method) for method in POSITIONS}
        films = {method: lb.film_distance(lens, distance, method, light) for method in POSITIONS}
        contrasts = {method: float(axis_contrast(lens_at[method], np.array([film]),
                                                 distance - lens_at[method].length - film, light)[0])
                     for method, film in films.items()}
        gain = contrasts["contrast"] - contrasts["paraxial"]
        method = asked if asked != "auto" else "paraxial" if gain <= ENOUGH else \
            "contrast" if contrasts["contrast"] >= RESOLVED else "real"
        blur = float(lb.real_circle_of_confusion(lens_at[method], films[method], [distance])[0][0])
    except lb.LensError:
        return FocusPosition("paraxial")
    if not all(map(math.isfinite, (blur, films["real"], contrasts["paraxial"]))):
        return FocusPosition("paraxial")
    return FocusPosition(method, blur, tuple(contrasts.values()), shift if method == "contrast" else 0.0)


def focus_text(position: FocusPosition) -> str:
    """The position and its reason in a sentence or two."""
    if not position.contrasts:
        return "Paraxial focus: the limit of small stops, the only focus of an ideal model"
    contrasts = dict(zip(POSITIONS, position.contrasts, strict=True))
    own = contrasts.pop(position.method)
    others = ", ".join(f"{fixed(100.0 * value, 0)} % {POSITIONS[name]}" for name, value in contrasts.items())
    return (f"Focused {POSITIONS[position.method]}: lines of 30 lp/mm on the axis have {fixed(100.0 * own, 0)} % "
            f"contrast; {others}. They differ by spherical aberration, which grows with the aperture, and by colour")


def lens_camera(settings: Settings) -> lb.LensCamera:
    """A camera with the lens or its ideal model, in focus at the primary wavelength; focus groups as for the d line."""
    lens, bench = published(settings), bench_of(settings)
    # A focus that cannot be: the camera refuses it, or here its window
    distance = seen_focus(lens, settings) if bench.refused else bench.focus_distance
    focus: dict[str, Any] = {"focus_distance": distance}
    if picture_wavelength(settings, lens) is not None:
        lens = design(settings)
    elif not (is_d_line(lens.reference_wavelength) or lens.has_focus_groups or bench.reason):
        focus = {"film_distance": bench.film_distance}          # the camera itself would focus the d line
    return lb.LensCamera(lens, settings.film, **focus, f_number=settings.f_number, model=settings.lens_model,
                         degree=settings.degree, focus_method=bench.focusing.method,
                         dispersion={"auto": None, "on": True, "off": False}[settings.dispersion],
                         film_pose=settings.film_pose,
                         **place_and_shutter(settings))


def place_and_shutter(settings: Settings) -> dict[str, Any]:
    """The arguments common to all cameras: pose, shutter, and the medium in front."""
    return {"world_from_camera": settings.placement, "shutter_open": settings.moment,
            "shutter_close": settings.moment + settings.shutter,
            "shutter_ramp": settings.shutter_ramp * settings.shutter, "readout": settings.readout,
            "readout_direction": settings.readout_direction, "medium": medium(settings)}


def medium(settings: Settings) -> lb.Medium | None:
    """The medium in front of the camera; None for clear air."""
    if settings.medium == "air":
        return None
    kind = lb.Medium.water if settings.medium == "water" else lb.Medium.fog
    return kind(settings.visibility, (settings.fog_light,) * 3)


# The picture in the stop


def stop_picture(path: str) -> lb.StopImage:
    """The picture of a file, read once for each change; SettingsError if unreadable, too large or dark."""
    return _read_picture(path, file_stamp(path))


def with_readable_stop(settings: Settings, say: Callable[[str], object]) -> Settings:
    """The settings without a picture in the stop that cannot be read; `say` receives a sentence on it."""
    if settings.stop_image:
        try:
            stop_picture(settings.stop_image)
        except SettingsError as error:
            say(f"{error}; the stop opens without it")
            return replace(settings, stop_image="")
    return settings


def stop_picture_path(settings: Settings, text: str) -> str:
    """The path of a typed picture, from the lens file's folder or the current one; SettingsError names both."""
    lens = Path(settings.lens)
    folders = ([lens.resolve().parent] if settings.has_lens and lens.suffix and lens.is_file() else []) + [Path.cwd()]
    paths = [(folder / Path(text.strip()).expanduser()).resolve() for folder in folders]
    for path in paths:
        if path.is_file():
            return str(path)
    named = " and ".join(dict.fromkeys(str(path.parent) for path in paths))
    raise SettingsError(f"there is no picture {excerpt(Path(text.strip()).name)} in {named}")


@keeps_last_good(8)
def _read_picture(path: str, _stamp: Stamp) -> lb.StopImage:
    try:
        return read_picture(path)
    except lb.StopImageError as error:
        raise SettingsError(str(error)) from error


# The coating that T-stop and ghosts assume: chosen, or by the year of the lens

LAST_UNCOATED, LAST_SINGLE = 1945, 1970         # years: coating became usual, then coating with several layers


class Coating(NamedTuple):
    """A key of COATINGS, and its assumption in words."""

    name: str
    why: str


def coating(settings: Settings, lens: lb.Lens) -> Coating:
    """The coating: as set, else by the year, single-layer if unknown. Surfaces keep a coating of their own."""
    assumed = _assumed(settings, lens)
    own = sum(surface.coating is not None for surface in lens.surfaces)
    return assumed if not own else assumed._replace(why=f"{assumed.why}; {own} of {len(lens.surfaces)} surfaces have a "
                                                    "coating of their own")


def _assumed(settings: Settings, lens: lb.Lens) -> Coating:
    if settings.coating != AUTO:
        return Coating(settings.coating, f"{_loss(settings.coating)}; chosen")
    if lens.year is None:
        return Coating("single-layer", f"{_loss('single-layer')}; assumed, its year is not known")
    name = "uncoated" if lens.year <= LAST_UNCOATED else "single-layer" if lens.year <= LAST_SINGLE else "multi-layer"
    return Coating(name, f"{_loss(name)}; by its year, {lens.year}")


def flare(settings: Settings) -> "Flare | None":
    """The ghosts and stars that the settings ask for, also where the picture can have none, which it says; or None."""
    if not (settings.ghosts or settings.stars):
        return None
    from lensbench.core.rendering.ghost_image import Flare

    name = coating(settings, design(settings)).name if settings.has_lens else "uncoated"
    return Flare(name, settings.ghost_strength if settings.ghosts else 0.0, _ghosts_alone(settings),
                 stars=settings.star_strength if settings.stars else 0.0,
                 wavelength=picture_wavelength(settings, published(settings)) if settings.has_lens else None)


def missing_ghost(settings: Settings) -> str:
    """Why the ghost that is shown alone does not exist in the current lens, in a sentence; "" where it does."""
    if not (settings.ghosts and settings.ghost_pair and settings.has_lens):
        return ""
    from lensbench.core.optics.ghost_path import no_such_pair

    try:
        return no_such_pair(design(settings), _ghosts_alone(settings))
    except (ValueError, OSError):                   # the worker reports a lens that cannot be
        return ""


def _ghosts_alone(settings: Settings) -> tuple[tuple[int, int], ...]:
    """The surfaces of the ghost that is shown alone; () for all ghosts."""
    first, _, second = read_ghost_pair(settings.ghost_pair).partition("-")
    return ((int(first), int(second)),) if second else ()


def _loss(name: str) -> str:
    return {"uncoated": "the reflection of bare glass", "single-layer": "a quarter wave of MgF₂",
            "multi-layer": "three layers on every surface to air"}[name]
