"""Facts of the camera kinds and of the models of a real lens: what they have, and which dials set them.

The setting `camera` is a key of CAMERA_KINDS; where the camera has a lens, the setting `lens_model` is a key of
LENS_MODELS. `camera_kinds` holds the makers and read-outs of each kind.

The settings of the lens itself are the first fields of Settings. Nothing here imports optics, so that the help of
commands is quick.
"""

from dataclasses import dataclass

from lensbench.app.settings.setting import LENGTH, NOTHING, setting
from lensbench.app.settings.text_values import read_length


@dataclass(frozen=True)
class CameraKind:
    """Facts of one kind of camera; `camera_kinds` holds its maker and its read-outs.

    dials, lists: names of the dials and of the lists that the left column shows for it. has_view: it has a field of
    view of its own, which a lens has not: its film is cropped, or it zooms.
    has_lens: it uses the prescription. ideal_lens: it has an ideal thin lens at its centre of projection. focuses: its
    pictures have a plane in focus. has_stop: it has an iris with blades. f_number, lens_radius: the setting of that
    name opens it. own: settings without an effect on kinds that do not name them here. panorama: it sees all
    directions, in the shape of a layout and not of the film. bounded: it sees a part of the scene, with a left and a
    right end. under_water: it can look through a window into water. film_lengths: settings (mm) that grow with the film
    where the picture is to stay the same. without_view: what to set instead of a field of view, for messages.
    measured_from: what object distances count from, in words.
    """

    title: str
    tooltip: str
    dials: tuple[str, ...] = ()
    lists: tuple[str, ...] = ()
    has_view: bool = False
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
        "Lens", "A camera with a lens, by one of its models",
        dials=("focus", "aperture", "crop or zoom", "focal length"), has_lens=True, focuses=True, has_stop=True,
        f_number=True),
    "perspective": CameraKind(
        "Perspective, no lens", "No prescription: an ideal thin lens with a field of view of its own",
        dials=("focus", "aperture", "perspective view"), lists=("fov_axis",), has_view=True, ideal_lens=True,
        focuses=True, has_stop=True, f_number=True, measured_from="the lens"),
    "orthographic": CameraKind(
        "Orthographic", "No prescription: parallel rays, objects keep their size at any distance",
        dials=("scene width", "focus", "lens radius"), focuses=True,
        has_stop=True, lens_radius=True, own=("scene_width",), without_view="give --scene-width",
        measured_from="the camera"),
    "fisheye": CameraKind(
        "Ideal fisheye", "No prescription: the angle from the axis becomes a length on the film, by one of four rules",
        dials=("fisheye view",), lists=("projection", "fov_axis"), has_view=True, own=("projection",)),
    "environment": CameraKind(
        "Panorama", "No prescription: every direction from one point, in one picture",
        own=("layout",), panorama=True, bounded=False, under_water=False),
    "finite-pinhole": CameraKind(
        "Pinhole of finite size",
        "No lens: rays run straight through a hole; the smaller it is the sharper, until diffraction blurs",
        dials=("film distance", "hole"), has_view=True, own=("hole_distance", "hole_diameter"),
        film_lengths=("hole_distance",)),
    "bare-sensor": CameraKind(
        "Bare sensor, no lens", "No lens: each point of the sensor sees the whole scene, and no picture forms",
        bounded=False),
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


AUTO = "auto"
COATINGS = {AUTO: "By year", "uncoated": "None", "single-layer": "Single-layer", "multi-layer": "Multi-layer"}


@dataclass(frozen=True)
class LensSettings:
    """Which lens, how large, and its coating."""

    lens: str = setting("pbrt-dgauss-50mm")             # a library name, or a path
    edited: str = setting("")       # the text of the edited lens (`lenses.editing`), instead of that of `lens`
    focal_length: float | None = setting(
        None, unit="mm", bounds=LENGTH, none="designed", read=read_length, metavar="LENGTH",
        help="scale the whole prescription to this focal length (of a zoom its shortest), such as 35mm")
    coating: str = setting("auto", choices=COATINGS, restarts=NOTHING, figures=True,
                           help="of the surfaces to air, for T-stop and ghosts: uncoated, single-layer (MgF2, about "
                           "1.3%% lost a surface), multi-layer (three layers, 0.3%%), or auto, by the year of the "
                           "lens: coated after 1945")
