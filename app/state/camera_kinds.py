"""The table of camera kinds, and the table of the models of a real lens.

The setting `camera` is a key of CAMERA_KINDS; where the camera has a lens, the setting `lens_model` is a key of
LENS_MODELS. A new kind of camera is one row here. Makers and read-outs longer than a line are in `ideal_cameras`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import lensbench as lb
from lensbench.app.state import ideal_cameras as ideal
from lensbench.app.state.build import design, lens_camera, place_and_shutter
from lensbench.app.state.figures import Readings, lens_readings

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings


@dataclass(frozen=True)
class CameraKind:
    """One kind of camera: its names, its maker and its properties.

    readings: its read-outs; by default the angles that it sees. dials, lists: names of the dials and of the lists that
    the left column shows for it.
    view: its own field of view (radians) and the focal length (mm) that this is seen with; with_view: settings with
    another one; None for a kind that has no field of view, and for a lens, whose film is cropped or which zooms.
    has_lens: it uses the prescription. ideal_lens: it has an ideal thin lens at its centre of projection. focuses: its
    pictures have a plane in focus. has_stop: it has an iris with blades. f_number, lens_radius: the setting of that
    name opens it. own: settings without an effect on kinds that do not name them here. panorama: it sees all
    directions, in the shape of a layout and not of the film. bounded: it sees a part of the scene, with a left and a
    right end. under_water: it can look through a window into water. film_lengths: settings (mm) that grow with the film
    where the picture is to stay the same. without_view: what to set instead of a field of view, for messages.
    reason: why it has no other read-outs, for `seen_readings`. measured_from: what object distances count from, in
    words.
    """

    title: str
    tooltip: str
    maker: Callable[["Settings"], lb.Camera]
    readings: Callable[["Settings"], Readings] = ideal.seen_readings
    dials: tuple[str, ...] = ()
    lists: tuple[str, ...] = ()
    view: Callable[["Settings"], tuple[float, float]] | None = None
    with_view: Callable[["Settings", float], "Settings"] | None = None
    has_lens: bool = False
    ideal_lens: bool = False
    focuses: bool = False
    has_stop: bool = False
    f_number: bool = False
    lens_radius: bool = False
    own: tuple[str, ...] = ()
    panorama: bool = False
    bounded: bool = True
    under_water: bool = True
    film_lengths: tuple[str, ...] = ()
    without_view: str = ""
    reason: str = ""
    measured_from: str = "the film"


@dataclass(frozen=True)
class LensModel:
    """One way to model a real lens, in the order from `auto` to the simplest.

    follows_lens: its rays are those of the real lens, traced or fitted; else of an ideal lens with the same cardinal
    points. has_stop: it has an aperture, hence a plane in focus. rays_from: where its rays leave the lens in the view
    “origin”: "front" (the first surface), "pupil" (the entrance pupil), or "" where that view has no meaning.
    has_fates: rays end at surfaces of the lens, as the view “fate” shows. has_degree: it is a polynomial of the
    setting `degree`. automatic: it selects the simplest of the others that is accurate enough. any_lens: of a lens
    without rotational symmetry too.
    """

    title: str
    tooltip: str
    follows_lens: bool
    has_stop: bool = True
    rays_from: str = ""
    has_fates: bool = False
    has_degree: bool = False
    automatic: bool = False
    any_lens: bool = False


CAMERA_KINDS = {
    "lens": CameraKind(
        "Lens", "A camera with a lens, by one of its models", lens_camera, lens_readings,
        dials=("focus", "aperture", "crop or zoom", "focal length"), has_lens=True, focuses=True, has_stop=True,
        f_number=True),
    "perspective": CameraKind(
        "Perspective, no lens", "No prescription: an ideal thin lens with a field of view of its own",
        ideal.perspective, ideal.perspective_readings, dials=("focus", "aperture", "perspective view"),
        lists=("fov_axis",), view=ideal.perspective_view, with_view=ideal.perspective_with_view, ideal_lens=True,
        focuses=True, has_stop=True, f_number=True, measured_from="the lens"),
    "orthographic": CameraKind(
        "Orthographic", "No prescription: parallel rays, objects keep their size at any distance",
        ideal.orthographic, ideal.orthographic_readings, dials=("scene width", "focus", "lens radius"), focuses=True,
        has_stop=True, lens_radius=True, own=("scene_width",), without_view="give --scene-width",
        measured_from="the camera"),
    "fisheye": CameraKind(
        "Ideal fisheye", "No prescription: the angle from the axis becomes a length on the film, by one of four rules",
        ideal.fisheye, ideal.fisheye_readings, dials=("fisheye view",), lists=("projection", "fov_axis"),
        view=ideal.fisheye_view, with_view=ideal.fisheye_with_view, own=("projection",)),
    "environment": CameraKind(
        "Panorama", "No prescription: every direction from one point, in one picture", ideal.environment,
        ideal.environment_readings, own=("layout",), panorama=True, bounded=False, under_water=False),
    "finite-pinhole": CameraKind(
        "Pinhole of finite size",
        "No lens: rays run straight through a hole; the smaller it is the sharper, until diffraction blurs",
        ideal.finite_pinhole, ideal.finite_pinhole_readings, dials=("film distance", "hole"),
        view=ideal.finite_pinhole_view, with_view=ideal.finite_pinhole_with_view,
        own=("hole_distance", "hole_diameter"), film_lengths=("hole_distance",)),
    "bare-sensor": CameraKind(
        "Bare sensor, no lens", "No lens: each point of the sensor sees the whole scene, and no picture forms",
        lambda settings: lb.BareSensor(settings.film, **place_and_shutter(settings)), bounded=False,
        reason="Without a lens each point of the film gets light from the whole scene: no picture forms"),
}

LENS_MODELS = {
    "auto": LensModel(
        "Automatic", "The simplest of the next five that is within half a pixel and 0.05 stops of the full trace,\n"
        "for this scene, film, focus and aperture. The bar at the bottom names it, and the reason",
        follows_lens=True, rays_from="front", has_fates=True, automatic=True, any_lens=True),
    "trace": LensModel("Full lens trace", "Every ray is refracted at every surface", follows_lens=True,
                       rays_from="front", has_fates=True, any_lens=True),
    "polynomial": LensModel(
        "Fitted polynomial", "A polynomial, fitted to the real lens at this focus and aperture: of degree 9 within a "
        "fraction of a pixel,\nin less than half of the time", follows_lens=True, has_degree=True),
    "thick": LensModel(
        "Thick lens", "An ideal lens with the principal planes and pupils of the real one: no aberrations",
        follows_lens=False),
    "thin": LensModel(
        "Thin lens", "An ideal lens of the same focal length and stop: no aberrations, no vignetting",
        follows_lens=False, rays_from="pupil"),
    "pinhole": LensModel("Pinhole", "The same view, with everything in focus", follows_lens=False, has_stop=False),
}
CAMERAS = {name: kind.title for name, kind in CAMERA_KINDS.items()}         # titles, for lists
MODEL_TITLES = {name: model.title for name, model in LENS_MODELS.items()}


def unfit(settings: "Settings", model: str) -> str:
    """Why the lens of these settings cannot have this model, a key of LENS_MODELS, in a sentence; "" where it can."""
    if LENS_MODELS[model].any_lens:
        return ""
    try:
        asymmetry = design(settings).asymmetry
    except (ValueError, OSError):                   # the worker reports it
        return ""
    return f"Of a lens with rotational symmetry alone: this one has {asymmetry}" if asymmetry else ""
