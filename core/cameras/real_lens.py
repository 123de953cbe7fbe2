"""Camera with a real lens: the full trace, a fitted polynomial, or an ideal lens of the same first order."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Any, Self

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmImportance, FilmLanding
from lensbench.core.cameras.ideal_lens import Gaussian, posed_film_points, posed_steps
from lensbench.core.cameras.lens_settings import (
    FOLLOWING, check_medium, check_room, check_settings, focus_of_film, has_dispersion, ideal_lens, missing_dispersion,
    thick
)
from lensbench.core.cameras.real_lens_projection import (
    BEYOND, FilmRegions, Regions, foremost, starting_points, traced_importance, traced_landing
)
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.film import UPRIGHT, Film, FilmPose
from lensbench.core.imaging.spectrum import PICTURE
from lensbench.core.kernels.block import Step
from lensbench.core.kernels.program import Program
from lensbench.core.lens_models.polynomial import Polynomial
from lensbench.core.optics.axis_contrast import D_LIGHT
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.focus import FocusError, film_distance, focused, nearest_focus
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.paraxial import FirstOrder, first_order, stopped_down
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.film_grid_sampler import PupilGrid
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.pupils.region import axis_irradiance
from lensbench.core.text import significant


@dataclass(frozen=True, eq=False)
class LensCamera(Camera):
    """Lens prescription in front of a film, focused as a whole or by its focus groups.

    The camera's origin is the centre of the film, with every model. Its attribute `lens` is the prescription
    stopped down and focused. Focus, aperture and the ideal models are those of the d line.

    Args:
        lens: Prescription. A lens whose front_index is not 1 is immersed in the medium, without a window; its f-number
            is that in air, as engraved. A lens with a cylinder or toroid is traced; it is focused between its two foci
            (`section_foci`), and its f-number is that of the section y–z. A lens with tilted or decentred surfaces is
            traced, too; its f-number, first-order data and paraxial focus are those of the centred lens.
        film: Size (mm) and pixels.
        focus_distance: Distance (mm) from the film to the plane in focus; math.inf is allowed.
        f_number: f-number N in air, focused at infinity; None: wide open.
        model: "trace": every ray through every surface. "polynomial": a polynomial fitted to the trace, and the trace
            itself for a stop with blades or a picture. "thick": the principal planes and pupils of the lens. "thin": a
            thin lens of the same focal length and aperture at the entrance pupil. "pinhole": a hole at the entrance
            pupil that passes as much light. "auto": `render` chooses for its scene (see `choose_model`); rays of this
            camera itself and light fields are traced.
        degree: Degree of the polynomial: 3, 5, 7, 9 or 11.
        dispersion: Whether pictures are traced at many wavelengths rather than the d line; None: where the indices of
            all glasses are known at these wavelengths.
        focus_method: Position of the film, for every model: "paraxial", "real" for the least blur of real rays at this
            aperture, or "contrast" for the best contrast in the colours of the picture (see `film_distance`). At the
            latter two an ideal model is out of focus.
        film_distance: Keyword, instead of a focus distance: where the film stands, in mm behind the last vertex. The
            lens stays as it is, and `focus_distance` becomes the plane that is then in focus, math.inf where there is
            none.
        film_at: The same as a field, which `dataclasses.replace` changes; None where a focus distance is given.
        film_pose: Tilt, swing, rise, shift and curvature of the film; flat and centred by default. Focus distance and
            film distance are those on the axis of the lens, of the plane in which the film's middle lies.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        FocusError: A focus distance that the lens cannot reach.
        LensError: An f-number to which the lens cannot open.
        CameraError: An unknown model, degree or focus method; for a lens without rotational symmetry a model other than
            the trace; surfaces so far decentred that the film's centre is dark; dispersion with unknown indices;
            "thick" with the exit pupil on the film; "thin" or "pinhole" with the entrance pupil at infinity or beyond
            the object.
    """

    lens: Lens
    film: Film
    focus_distance: float = math.inf
    f_number: float | None = None
    model: str = "trace"
    degree: int = 9
    dispersion: bool | None = None
    focus_method: str = "paraxial"
    film_at: float | None = None
    film_pose: FilmPose = UPRIGHT

    def __post_init__(self) -> None:
        super().__post_init__()
        check_settings(self.lens, self.model, self.degree, self.weights, self.focus_method, self.film_at)
        lens = self.lens.at(close=0.0)
        if self.f_number is not None:
            lens = stopped_down(lens, self.f_number)
        check_medium(lens, self.medium)
        if self.film_at is None:
            object.__setattr__(self, "lens", focused(lens, self.focus_distance, self.focus_method))
        else:
            object.__setattr__(self, "lens", lens)
            object.__setattr__(self, "focus_distance", focus_of_film(lens, self.film_at, self.focus_distance))
        if not self.film_distance > 0.0:            # evaluated here, so that a lens without focus raises
            behind, reason = first_order(self.lens).bfl, ""
            if self.focus_method != "paraxial" and self.film_at is None and 0.0 < behind < math.inf:
                reason = (f": by real rays at this aperture; its paraxial focus lies {significant(behind, 4)} mm "
                          "behind it. Stop down, focus paraxially, or add missing aspheric coefficients")
            raise FocusError(f"this lens forms its image {significant(-self.film_distance, 4)} mm before its "
                             f"last vertex, where there is no room for a film{reason}")
        if not self.film_pose.is_upright:
            check_room(self.film_pose, self.film, self.film_distance)
        if not self.lens.is_centred and not self.axis_irradiance > 0.0:
            raise CameraError("no light reaches the film's centre through tilted or decentred surfaces: tilt or "
                              "decentre them less, or enlarge their rims")
        if not self.follows_rays:
            _ = self.gaussian                       # evaluated here, so that an impossible ideal lens raises
        if self.dispersion and not self.disperses and missing_dispersion(self.lens):
            raise CameraError(f"no dispersion: {missing_dispersion(self.lens)}")

    @property
    def follows_rays(self) -> bool:
        """Whether rays follow the real lens, traced or fitted, through its exit-pupil regions."""
        return self.model in FOLLOWING

    @cached_property
    def disperses(self) -> bool:
        """Whether pictures are traced at many wavelengths."""
        return self.dispersion is not False and self.follows_rays and has_dispersion(self.lens)

    @cached_property
    def first_order(self) -> FirstOrder:
        """First-order properties of the stopped-down lens."""
        return first_order(self.lens, D_LINE)

    @cached_property
    def film_distance(self) -> float:
        """Distance (mm) from the last vertex to the film."""
        if self.film_at is not None:
            return self.film_at
        return film_distance(self.lens, self.focus_distance, self.focus_method, PICTURE if self.disperses else D_LIGHT)

    @cached_property
    def pupil(self) -> Regions:
        """Exit-pupil regions that the camera samples: by film radius, or over a film grid for an unsymmetric lens.

        Of a tilted or shifted film by radius and distance.
        """
        return self._regions.at(D_LINE)

    @cached_property
    def _regions(self) -> FilmRegions:
        return FilmRegions(self.lens, self.film, self.film_distance, self.film_pose, self.is_traced)

    @cached_property
    def axis_irradiance(self) -> float:
        """∫ cos⁴θ dA (mm²) over the region that the film's centre sees through the stop's blades."""
        return axis_irradiance(self.lens, self.film_distance, D_LINE)

    @property
    def is_traced(self) -> bool:
        """Whether rays are traced through every surface.

        A polynomial does not give the points where rays meet the blades of a stop, or the picture in it.
        """
        return self.follows_rays and (self.model != "polynomial" or not self.lens.iris.is_round)

    @cached_property
    def gaussian(self) -> Gaussian:
        """First-order map of the model; the thick lens for traced and fitted rays."""
        return thick(self.lens, self.film_distance) if self.follows_rays else self.ideal(self.model)

    def ideal(self, model: str) -> Gaussian:
        """First-order map of this lens by an ideal model, "thick", "thin" or "pinhole"; CameraError for a pupil it
        cannot place.
        """
        return ideal_lens(self.lens, self.film_distance, self.focus_distance, model)

    @cached_property
    def with_open_stop(self) -> Self:
        """The camera without a picture in its stop; see `Camera.with_open_stop`."""
        if self.lens.stop_image is None:
            return self
        made = replace(self, lens=self.lens.with_open_stop)
        vars(made)["_regions"] = self._regions          # solved for the circle of the stop
        return made

    @property
    def stage_centre(self) -> tuple[float, float]:
        """U0, U1 of the central ray: the samplers of exit-pupil regions take an angle and a squared radius."""
        return (0.0, 0.0) if self.follows_rays else (0.5, 0.5)

    def stage_uv(self, film_xy: np.ndarray, pupil_uv: np.ndarray) -> np.ndarray:
        """Angle and squared radius of pupil samples in an exit-pupil region; see `Camera.stage_uv`."""
        return self._regions.stage_uv(film_xy, pupil_uv) if self.follows_rays else pupil_uv

    @property
    def has_port(self) -> bool:
        """Whether the camera looks through a window into a medium of another index around the lens in air."""
        return super().has_port and self.lens.front_index == 1.0

    @property
    def front(self) -> float:
        """Coordinate z (mm, camera frame) of the lens's foremost point: its first vertex, or glass or rim before it."""
        return foremost(self.lens) - self.lens.length - self.film_distance

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
        """Derivatives in closed form for the ideal models; see `Camera.film_slopes`."""
        return None if self.follows_rays or not self.film_pose.is_upright else self.gaussian.film_slopes(directions)

    @property
    def aim_distance(self) -> float | None:
        """Distance (mm) to the plane of the last vertex, with the exit-pupil regions; None for the ideal models."""
        return self.film_distance if self.follows_rays else None

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps that aim and trace, or the step of the ideal lens; see `Camera.camera_steps`.

        Each wavelength has its own exit-pupil regions and, with relative weights, weight 1 on the axis.
        """
        if wavelength not in self._known_steps:
            self._known_steps[wavelength] = self._new_steps(wavelength)
        return list(self._known_steps[wavelength])

    @cached_property
    def _known_steps(self) -> dict[float, list[Step]]:
        """Steps by wavelength: a picture needs them several times, and a polynomial takes long to fit."""
        return {}

    def _new_steps(self, wavelength: float) -> list[Step]:
        if not self.follows_rays:
            if self.film_pose.is_upright:
                return self._weighted_gaussian.steps(self._weighted_gain)
            return posed_steps(self.gaussian, self.film_pose, self._weighted_gain, self.weights != "radiance")
        table, normaliser = self._sampled(wavelength)
        if self.is_traced or isinstance(table, PupilGrid):
            return [table.step(normaliser), *self.lens_steps(wavelength)]
        # The D line decides for a picture of all colours: near the limit, the regions of some only are irregular
        fitted = replace(self._fitted(table, wavelength), irregular=self._fitted(self.pupil, D_LINE).irregular)
        fit = Polynomial.fit(self.lens, self.film_distance, fitted, self.degree, wavelength, self.focus_distance)
        return [table.step(normaliser), fit.step]

    def _fitted(self, regions: Regions, wavelength: float) -> PupilTable:
        """The regions that a polynomial is fitted to: those of rays that start at z = 0, as of a centred film."""
        if isinstance(regions, PupilTable):
            return regions
        return PupilTable.of(self.lens, self.film_distance, self._regions.reach, wavelength, widened=False)

    def lens_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps of the full trace from an aimed ray to the ray in front of the lens; see `Camera.lens_steps`."""
        return trace_steps(self.lens, self.film_distance, wavelength)

    @property
    def traced_lens(self) -> Lens | None:
        """Lens whose surfaces the rays are traced through, or None."""
        return self.lens if self.is_traced else None

    @property
    def geometric_f_number(self) -> float:
        """f-number of the stopped-down lens at infinity."""
        return self.first_order.f_number

    @property
    def nearest_focus(self) -> float:
        """Shortest distance (mm) from the film at which the lens can be focused by the focus method."""
        return nearest_focus(self.lens, self.focus_method)

    def refocused(self, focus_distance: float) -> Self:
        """The camera at another focus_distance (mm), also one that was placed by its film distance."""
        return replace(self, focus_distance=focus_distance, film_at=None)

    def film_landing(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """Film landing by the trace, for a polynomial as well; in closed form for the ideal models.

        None for an ideal model with a tilted, shifted or curved film.
        """
        if not self.follows_rays:
            return super().film_landing(wavelength) if self.film_pose.is_upright else None
        gain = self.lens.front_index**2 * self.film_distance**2 / self._ray_normaliser(wavelength)
        return traced_landing(self.lens, self.film, self.film_distance, self.film_pose, gain, wavelength)

    @property
    def gain(self) -> float:
        """Weight of the axial ray of an ideal model."""
        ideal = self.gaussian
        return ideal.cone / self._normaliser(ideal.cone if self.model == "pinhole" else ideal.axis_irradiance, 1.0)

    @property
    def dilution(self) -> float:
        """Squared index in front of the lens; 1 for a thin lens, whose film position already accounts for the index."""
        return 1.0 if self.model in ("thin", "pinhole") else self.lens.front_index**2

    def _ray_normaliser(self, wavelength: float) -> float:
        """Divisor of cos⁴θ · area for rays that follow the lens."""
        on_axis = self.axis_irradiance if wavelength == D_LINE else axis_irradiance(
            self.lens, self.film_distance, wavelength)
        return self._normaliser(on_axis, self.film_distance) if on_axis > 0.0 else math.inf

    def _sampled(self, wavelength: float) -> tuple[Regions, float]:
        """Exit-pupil regions to aim at, and the divisor of cos⁴θ · area."""
        return (self.pupil if wavelength == D_LINE else self._regions.at(wavelength)), self._ray_normaliser(wavelength)

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray, wavelength: float = D_LINE
                       ) -> tuple[np.ndarray, np.ndarray]:
        """Projection in closed form for the ideal models, by Newton's method to rounding through the real lens."""
        if not self.follows_rays:
            if self.film_pose.is_upright:
                return self.gaussian.film_points(points, pupil_uv)
            return posed_film_points(self.gaussian, self.film_pose, points, pupil_uv)
        return self._film_by_newton(self.camera_steps(wavelength), points, pupil_uv)

    def _newton_start(self, points: np.ndarray) -> np.ndarray | None:
        """For a tilted or shifted film: where the central rays of a centred one meet it."""
        if self.film_pose.is_upright or not self.follows_rays:
            return None
        centred = Program(replace(self, film_pose=UPRIGHT).camera_steps(), np.float64)
        start = starting_points(centred, points, self.stage_centre, BEYOND * self._regions.reach)
        landed = self.film_pose.film_points(start, -self.gaussian.approach_film * start)
        farthest = self.film.diagonal / 2.0
        with np.errstate(invalid="ignore"):
            shrunk = np.minimum(1.0, farthest / np.maximum(np.hypot(landed[:, 0], landed[:, 1]), 1e-30))
        return np.asarray(landed * shrunk[:, None])

    def film_importance(self, origins: np.ndarray, directions: np.ndarray, wavelength: float = D_LINE
                       ) -> FilmImportance:
        """Importance of rays traced back to the film, which emits z² / normaliser evenly; see `Camera.film_importance`.

        In a medium, cos θ dω dA is smaller and W larger by the squared index. CameraError with a tilted, shifted or
        curved film behind another model than the full trace.
        """
        if not self.follows_rays:
            if not self.film_pose.is_upright:
                raise CameraError("importance with a tilted or shifted film is known for the traced lens alone: choose "
                                  "the full trace")
            return super().film_importance(origins, directions, wavelength)
        regions, normaliser = self._sampled(wavelength)
        gain = self.lens.front_index**2 * self.film_distance**2 / normaliser
        return traced_importance(self.lens, self.film_distance, self.film_pose, self._film_area, regions, gain,
                                 origins, directions, wavelength)


def _taking_film_distance(init: Callable[..., None]) -> Callable[..., None]:
    """`LensCamera.__init__` with the keyword film_distance, which a field cannot have beside the property."""
    @wraps(init)
    def __init__(self: LensCamera, *arguments: Any, film_distance: float | None = None, **named: Any) -> None:    # noqa: N807
        if film_distance is not None:
            named["film_at"] = film_distance
        init(self, *arguments, **named)

    return __init__


LensCamera.__init__ = _taking_film_distance(LensCamera.__init__)        # type: ignore[method-assign]
