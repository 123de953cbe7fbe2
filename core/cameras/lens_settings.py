"""Settings of a camera with a real lens: the lens models, and the checks of settings that exclude each other.

Lengths in mm. Each check raises an error whose message says what to choose instead.
"""

import math

from lensbench.cameras.rays import CameraError
from lensbench.imaging.film import Film
from lensbench.imaging.film_pose import FilmPose
from lensbench.kernels.figures import significant
from lensbench.lens_models.polynomial import DEGREES
from lensbench.optics.focus import METHODS, FocusError, focused_distance
from lensbench.optics.prescription import Lens
from lensbench.scenery.shading.participating_medium import Medium

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
        raise CameraError(f"focus method {focus_method!r}: choose {' or '.join(METHODS)}")
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
    """CameraError for a film out of line that reaches beyond the last vertex of the lens."""
    nearest = film_distance + float(pose.extent(film.width, film.height)[:, 2].min())
    if not nearest > 0.0:
        raise CameraError(f"the film out of line reaches {significant(-nearest, 3)} mm beyond the last vertex of the "
                          "lens: tilt or curve it less, or choose a smaller film")


def focus_of_film(lens: Lens, film_at: float, focus_distance: float) -> float:
    """Distance (mm) from a film, `film_at` behind the last vertex, to the plane in focus; inf where there is none.

    FocusError where a finite focus_distance says otherwise.
    """
    try:
        found = focused_distance(lens, film_at)
    except FocusError:
        found = math.inf                            # the film lies before the rear focus: nothing is in focus
    if math.isfinite(focus_distance) and not math.isclose(focus_distance, found, rel_tol=1e-9):
        raise FocusError(f"film distance {significant(film_at)} mm focuses at {significant(found)} mm, and not at "
                         f"{significant(focus_distance)} mm: give one of the two")
    return found
