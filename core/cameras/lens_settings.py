"""Settings of a camera with a real lens: ideal models, checks of settings, dispersion. Lengths in mm, camera frame."""

import math
from functools import lru_cache

from lensbench.core.cameras.ideal_lens import Gaussian, thin
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.film import Film, FilmPose
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.lens_models.polynomial import DEGREES
from lensbench.core.optics.focus import METHODS, FocusError, focused_distance
from lensbench.core.optics.glass import D_LINE, Glass, GlassError
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.scenery.shading.participating_medium import Medium
from lensbench.core.text import significant


def ideal_lens(lens: Lens, film_distance: float, focus_distance: float, model: str) -> Gaussian:
    """First-order map (mm) by the model "thick", "thin" or "pinhole"; CameraError for a pupil without a place."""
    fo = first_order(lens, D_LINE)
    if model == "thick":
        if abs(fo.exit_pupil.z - lens.length - film_distance) <= 1e-9 * film_distance:
            raise CameraError("the exit pupil of this lens lies on the film: the thick model cannot aim at it")
        return thick(lens, film_distance)
    pupil_z = fo.entrance_pupil.z - lens.length - film_distance
    if not -focus_distance < pupil_z < math.inf:
        raise CameraError(f"the entrance pupil of this lens lies at infinity or beyond the object: "
                          f"the {model} model has no place there")
    to_pupil = focus_distance + pupil_z
    to_principal = to_pupil - fo.entrance_pupil.z + fo.front_principal
    efl = lens.front_index * fo.efl                             # on the scene's side
    behind = efl if math.isinf(to_pupil) else efl * to_pupil / (to_principal - efl)
    upside_down = ray_matrix(lens, 0, lens.stop_index)[0] < 0.0         # image of the stop, from the front
    iris = lens.iris.upside_down if upside_down else lens.iris
    ideal = thin(pupil_z, fo.entrance_pupil.radius, behind, to_pupil, iris)
    return ideal._replace(origin_pupil=0.0, slope_pupil=0.0) if model == "pinhole" else ideal


def thick(lens: Lens, film_distance: float) -> Gaussian:
    """Thick lens: a real lens to first order, with its principal planes and pupils; the exit pupil not on the film.

    The rays start on the entrance pupil where that lies between the first vertex and the film, otherwise on the plane
    of the first vertex, and point to the pupil.
    """
    fo, film = first_order(lens, D_LINE), lens.length + film_distance
    # Slopes dy/dz on the film's side towards the exit pupil, which may be an inverted image of the stop
    _, _, c, d = ray_matrix(lens, lens.stop_index, len(lens.surfaces))
    if math.isinf(fo.exit_pupil.z):
        film_aims, pupil_aims = 0.0, c * fo.stop_radius
    else:
        away = fo.exit_pupil.z - film
        film_aims, pupil_aims = -1.0 / away, math.copysign(fo.exit_pupil.radius, d) / away
    # Transfer to the last vertex, by the inverse matrix to the first vertex, and on to the plane where rays start
    a, b, c, d = ray_matrix(lens, 0, len(lens.surfaces))
    within = 0.0 <= fo.entrance_pupil.z <= film
    start = fo.entrance_pupil.z if within else 0.0
    rays = []
    for height, slope in ((1.0, film_aims), (0.0, pupil_aims)):
        height -= film_distance * slope
        height, slope = d * height - b * slope, a * slope - c * height
        slope /= lens.front_index
        rays.append((height + start * slope, -slope))
    (origin_film, slope_film), (origin_pupil, slope_pupil) = rays
    if within:
        origin_film = 0.0                               # exactly: all film points share the entrance pupil
    return Gaussian(start - film, origin_film, origin_pupil, slope_film, slope_pupil, -film_aims, -pupil_aims,
                    lens.iris)


def has_dispersion(lens: Lens) -> bool:
    """Whether any glass disperses, and the indices of all are known at the wavelengths of pictures."""
    return any(surface.glass.disperses for surface in lens.surfaces) and not missing_dispersion(lens)


def missing_dispersion(lens: Lens) -> str:
    """Message that names a glass whose index is unknown at some wavelength of pictures; "" where all are known."""
    return _missing_index(tuple(surface.glass for surface in lens.surfaces))


@lru_cache(maxsize=64)
def _missing_index(glasses: tuple[Glass, ...]) -> str:
    """`missing_dispersion` of a lens of these glasses: the same wherever it is focused and stopped down."""
    try:
        for wavelength in (wavelength for row in WAVELENGTHS.values() for wavelength in row):
            for glass in glasses:
                glass.index(wavelength)
    except GlassError as error:
        return str(error)
    return ""


FOLLOWING = ("auto", "trace", "polynomial")     # models whose rays follow the real lens
MODELS = (*FOLLOWING, "thick", "thin", "pinhole")


def check_settings(lens: Lens, model: str, degree: int, weights: str, focus_method: str, film_at: float | None) -> None:
    """CameraError or FocusError for settings of `LensCamera` that are invalid at any focus."""
    if film_at is not None and not (math.isfinite(film_at) and film_at > 0.0):
        raise FocusError(f"film distance {significant(film_at)} mm: it must be a positive number, from the last vertex "
                         "to the film")
    if model not in MODELS:
        raise CameraError(f"camera model {model!r}: choose one of {', '.join(MODELS)}")
    if weights == "radiance" and model in FOLLOWING:
        raise CameraError(f"weights {weights!r} are for ideal cameras, whose pupil is the same for every film point: "
                          "choose relative or physical weights, or the model thick, thin or pinhole")
    if focus_method not in METHODS:
        raise CameraError(f"focus method {focus_method!r}: choose one of {', '.join(METHODS)}")
    if model == "polynomial" and degree not in DEGREES:
        raise CameraError(f"polynomial degree {degree}: choose one of {', '.join(map(str, DEGREES))}")
    if not lens.is_rotationally_symmetric and model not in ("auto", "trace"):
        raise CameraError(f"the {model} model needs a rotationally symmetric lens, and this one has {lens.asymmetry}: "
                          "choose the full trace")


def check_medium(lens: Lens, medium: Medium | None) -> None:
    """CameraError for a lens immersed in another medium than the scene's."""
    if lens.front_index != 1.0 and medium is not None and medium.index not in (1.0, lens.front_index):
        raise CameraError(f"this lens is immersed in a medium of index {significant(lens.front_index)}, and the camera "
                          f"in one of {significant(medium.index)}: give both the same")


def check_room(pose: FilmPose, film: Film, film_distance: float) -> None:
    """CameraError for a tilted or curved film that reaches beyond the last vertex of the lens."""
    nearest = film_distance + float(pose.extent(film.width, film.height)[:, 2].min())
    if not nearest > 0.0:
        raise CameraError(f"the tilted film reaches {significant(-nearest, 3)} mm beyond the last vertex of the "
                          "lens: tilt or curve it less, or choose a smaller film")


def focus_of_film(lens: Lens, film_at: float, focus_distance: float) -> float:
    """Distance (mm) from a film, `film_at` behind the last vertex, to the plane in focus, inf for none.

    FocusError where a finite focus_distance contradicts it.
    """
    try:
        in_focus = focused_distance(lens, film_at)
    except FocusError:
        in_focus = math.inf                            # the film lies before the rear focus: nothing is in focus
    if math.isfinite(focus_distance) and not math.isclose(focus_distance, in_focus, rel_tol=1e-9):
        raise FocusError(f"film distance {significant(film_at)} mm focuses at {significant(in_focus)} mm, and not at "
                         f"{significant(focus_distance)} mm: give one of the two")
    return in_focus
