"""Ideal lenses with the cardinal points of a real one: thick, thin and pinhole.

Camera frame, mm: the origin is the film's centre, and the camera looks along −z.
"""

import math

from lensbench.cameras.ideal_lens import Gaussian, thin
from lensbench.cameras.rays import CameraError
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order, ray_matrix
from lensbench.optics.prescription import Lens


def ideal_lens(lens: Lens, film_distance: float, focus_distance: float, model: str) -> Gaussian:
    """First-order map of a lens by the model "thick", "thin" or "pinhole"; distances in mm.

    CameraError for a pupil where the model cannot place it.
    """
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
    """Thick lens: a real lens to first order, with its principal planes and pupils.

    The rays start on the entrance pupil where that lies between the first vertex and the film, otherwise on the plane
    of the first vertex, and point to the pupil at infinity, in the scene or behind the camera. The film is in air; the
    exit pupil must not lie on it.
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
