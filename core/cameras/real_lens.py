"""A camera with a real lens, in as much detail as is wanted: the full trace, a thick or thin lens, or a pinhole."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.film_landing import FilmLanding, ideal_film_landing, landing_step
from lensbench.cameras.ideal_lens import Gaussian, thick, thin
from lensbench.cameras.importance import FilmImportance
from lensbench.cameras.project import film_from_point
from lensbench.cameras.rays import CameraError
from lensbench.imaging.film import Film
from lensbench.imaging.spectrum import WAVELENGTHS
from lensbench.kernels.block import WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.lens_models.polynomial import DEGREES, Polynomial
from lensbench.optics.block_trace import round_stop_steps, trace_steps
from lensbench.optics.focus import METHODS, FocusError, film_distance, focused
from lensbench.optics.glass import D_LINE, GlassError
from lensbench.optics.paraxial import FirstOrder, first_order, ray_matrix, stopped_down
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid_sampler import PupilGrid
from lensbench.pupils.radial_sampler import PupilTable
from lensbench.pupils.region import axis_irradiance
from lensbench.pupils.spectral_grid import SpectralPupilGrid

MODELS = ("auto", "trace", "polynomial", "thick", "thin", "pinhole")


@dataclass(frozen=True, eq=False)
class LensCamera(Camera):
    """A prescription before a film, focused as a whole or by its focus groups (see `focus`).

    The camera's origin is the film's centre, in every model. focus_distance:
    from the film (mm), math.inf allowed; FocusError where the lens cannot come
    so near. The camera's own lens has its groups in their places. f_number, which counts
    at infinity: None is wide open; LensError where it cannot open so far.
    model: "trace" follows every ray through every surface; "polynomial" evaluates a polynomial of this degree
    (3, 5, 7, 9 or 11) that is fitted to the trace, and traces where the stop has blades; "thick" images every
    film point by the lens's principal planes and pupils, which may lie anywhere but on the film (CameraError);
    "thin" puts a thin lens of the same focal length and aperture at the entrance pupil; "pinhole" a hole, which
    passes as much light as that lens. CameraError for these two where the entrance pupil lies at infinity or
    beyond the object. "auto" leaves the choice to what knows the scene, `render` and the bench (see
    `choose_model`); its own rays, and those of a light field, which is focused afterwards, are traced in full.
    dispersion: whether pictures are traced at many wavelengths, or all at the d line; None: where the indices of
    the glasses are known for all that a picture sees. CameraError where it is True and
    they are not. A lens whose front_index is not 1 stands in the medium itself, without a window; its
    f-number is the one that is engraved, for air. focus_method: where the film stands, whatever the model:
    "paraxial", or "real", where the real rays' blur is least at this aperture (see `film_distance`), which
    is beside the focus of an ideal model. Focus, aperture and the ideal models are those of the d line. A lens with a
    cylinder or toroid is traced (CameraError for the other models, and for blades); it is focused between its two foci
    (`section_foci`), and f_number is that of its section y–z.
    """

    lens: Lens
    film: Film
    focus_distance: float = math.inf
    f_number: float | None = None
    model: str = "trace"
    degree: int = 9
    dispersion: bool | None = None
    focus_method: str = "paraxial"

    def __post_init__(self):
        super().__post_init__()
        if self.model not in MODELS:
            raise CameraError(f"camera model {self.model!r}: choose one of {', '.join(MODELS)}")
        if self.focus_method not in METHODS:
            raise CameraError(f"focus method {self.focus_method!r}: choose {' or '.join(METHODS)}")
        if self.model == "polynomial" and self.degree not in DEGREES:
            raise CameraError(f"polynomial degree {self.degree}: choose one of {', '.join(map(str, DEGREES))}")
        if not self.lens.is_rotationally_symmetric and self.model not in ("auto", "trace"):
            raise CameraError(f"the {self.model} model knows rotationally symmetric lenses, and this one has a "
                              "cylinder or toroid: choose the full trace")
        if not self.lens.is_rotationally_symmetric and not self.lens.iris.is_round:
            raise CameraError("a lens with a cylinder or toroid has no blades here: leave its stop round")
        lens = self.lens.at(close=0.0)
        if self.f_number is not None:
            lens = replace(stopped_down(replace(lens, front_index=1.0), self.f_number), front_index=lens.front_index)
        if lens.front_index != 1.0 and self.medium is not None and self.medium.index not in (1.0, lens.front_index):
            raise CameraError(f"this lens stands in a medium of index {lens.front_index:g}, and the camera in one of "
                              f"{self.medium.index:g}: give both the same")
        object.__setattr__(self, "lens", focused(lens, self.focus_distance, self.focus_method))
        if not self.film_distance > 0.0:            # what cannot be focused at all is refused on the way
            raise FocusError(f"this lens forms its image {-self.film_distance:.4g} mm before its last vertex, "
                             "where no film can stand")
        if not self.follows_rays:
            _ = self.gaussian                       # an ideal lens that cannot stand is refused on the way
        if self.dispersion and not self.disperses and missing_dispersion(self.lens):
            raise CameraError(f"no picture in colours: {missing_dispersion(self.lens)}")

    @property
    def follows_rays(self) -> bool:
        """Whether its rays are those of the real lens, traced or fitted, through the exit-pupil regions."""
        return self.model in ("auto", "trace", "polynomial")

    @cached_property
    def disperses(self) -> bool:
        """Whether pictures are traced at many wavelengths."""
        return (self.dispersion is not False and self.follows_rays and not missing_dispersion(self.lens)
                and any(surface.glass.disperses for surface in self.lens.surfaces))

    @cached_property
    def first_order(self) -> FirstOrder:
        """Of the lens as it is stopped down."""
        return first_order(self.lens)

    @cached_property
    def film_distance(self) -> float:
        """From the last vertex to the film (mm)."""
        return film_distance(self.lens, self.focus_distance, self.focus_method)

    @cached_property
    def pupil(self) -> PupilTable | PupilGrid:
        """The exit-pupil regions that the camera samples, for every radius of the film, or all over it."""
        return self._pupil_at(D_LINE)

    def _pupil_at(self, wavelength: float) -> PupilTable | PupilGrid:
        if not self.lens.is_rotationally_symmetric:
            return self._grids.at(wavelength)
        return PupilTable.of(self.lens, self.film_distance, self.film.diagonal / 2.0, wavelength,
                             widened=self.is_traced)

    @cached_property
    def _grids(self) -> SpectralPupilGrid:
        return SpectralPupilGrid(self.lens, self.film_distance, self.film.width / 2.0, self.film.height / 2.0)

    @cached_property
    def axis_irradiance(self) -> float:
        """∫ cos⁴θ dA over the region that the film's centre sees (mm²), less what the stop's blades cover."""
        return self._axis_irradiance_at(D_LINE)

    def _axis_irradiance_at(self, wavelength: float) -> float:
        return axis_irradiance(self.lens, self.film_distance, wavelength)

    @property
    def is_traced(self) -> bool:
        """Whether rays are followed through every surface.

        A polynomial does not give the points where rays meet the blades of a stop.
        """
        return self.follows_rays and (self.model != "polynomial" or not self.lens.iris.is_round)

    @property
    def _pupil_z(self) -> float:
        """Of the entrance pupil, in the camera frame (mm)."""
        return self.first_order.entrance_pupil.z - self.lens.length - self.film_distance

    @cached_property
    def gaussian(self) -> Gaussian:
        """The rays of the ideal models, and of a trace those of the lens's first order."""
        return thick(self.lens, self.film_distance) if self.follows_rays else self.ideal(self.model)

    def ideal(self, model: str) -> Gaussian:
        """The rays of this lens by the model "thick", "thin" or "pinhole"; CameraError where that cannot stand."""
        if model == "thick":
            if abs(self.first_order.exit_pupil.z - self.lens.length - self.film_distance) <= 1e-9 * self.film_distance:
                raise CameraError("the exit pupil of this lens lies on the film: the thick model cannot aim at it")
            return thick(self.lens, self.film_distance)
        if not -self.focus_distance < self._pupil_z < math.inf:
            raise CameraError(f"the entrance pupil of this lens lies at infinity or beyond the object: "
                              f"the {model} model cannot stand there")
        fo = self.first_order
        s_e = self.focus_distance + self._pupil_z
        s_p = s_e - fo.entrance_pupil.z + fo.front_principal
        efl = self.lens.front_index * fo.efl                        # of the scene's side
        behind = efl if math.isinf(s_e) else efl * s_e / (s_p - efl)
        upside_down = ray_matrix(self.lens, 0, self.lens.stop_index)[0] < 0.0       # the stop as it is seen from before
        iris = replace(self.lens.iris, rotation=self.lens.blade_rotation + math.pi * upside_down)
        lens = thin(self._pupil_z, fo.entrance_pupil.radius, behind, s_e, iris)
        return lens._replace(origin_pupil=0.0, slope_pupil=0.0) if model == "pinhole" else lens

    @property
    def pupil_centre(self) -> tuple[float, float]:
        """The U0, U1 of the ray through the middle of the pupil."""
        return (0.0, 0.0) if self.follows_rays else (0.5, 0.5)

    @property
    def has_port(self) -> bool:
        """Whether it looks through a window into a medium of another index: not where the lens stands in it."""
        return super().has_port and self.lens.front_index == 1.0

    @property
    def front(self) -> float:
        """The z of the lens's foremost point in the camera frame (mm): its first vertex, or the rim before it."""
        first = self.lens.surfaces[0]
        return min(0.0, float(first.sag(first.semi_diameter))) - self.lens.length - self.film_distance

    def film_slopes(self, film_xy, directions):
        """In closed form for the ideal models."""
        return None if self.follows_rays else self.gaussian.film_slopes(directions)

    @property
    def aim_distance(self) -> float | None:
        """Rays that are followed aim at exit-pupil regions on the plane of the last vertex."""
        return self.film_distance if self.follows_rays else None

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Aim and trace, or the one step of the ideal lens.

        Each wavelength has its own exit-pupil regions and, with relative weights, is 1 on the axis.
        """
        if wavelength not in self._known_steps:
            self._known_steps[wavelength] = self._new_steps(wavelength)
        return list(self._known_steps[wavelength])

    @cached_property
    def _known_steps(self) -> dict[float, list[Step]]:
        """A picture asks for the same ones several times, and a polynomial is fitted for them."""
        return {}

    def _new_steps(self, wavelength: float) -> list[Step]:
        if self.follows_rays:
            table, normaliser = self._sampled(wavelength)
            if self.is_traced or isinstance(table, PupilGrid):
                return [table.step(normaliser), *trace_steps(self.lens, self.film_distance, wavelength)]
            fit = Polynomial.fit(self.lens, self.film_distance, table, self.degree, wavelength, self.focus_distance)
            return [table.step(normaliser), fit.step]
        return self.gaussian.steps(self.gain)

    def way_back(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """Traced, for a polynomial as well; in closed form for the ideal models."""
        if not self.follows_rays:
            return ideal_film_landing(self.gaussian, self.film_step, self.gain)
        lens = self.lens
        gain = lens.front_index**2 * self.film_distance**2 / self._ray_normaliser(wavelength)
        arriving = landing_step(self.film, gain)
        whole = round_stop_steps(lens, self.film_distance, wavelength, "film")
        first = lens.surfaces[0]
        reach = first.semi_diameter + min(abs(float(first.sag(first.semi_diameter))), first.semi_diameter)
        return FilmLanding([*trace_steps(lens, self.film_distance, wavelength, "film"), arriving], [*whole, arriving],
                       -lens.length - self.film_distance, reach)

    @property
    def gain(self) -> float:
        """Of an ideal model the weight of the ray along the axis."""
        ideal = self.gaussian
        return ideal.cone / self._normaliser(ideal.cone if self.model == "pinhole" else ideal.axis_irradiance, 1.0)

    @property
    def dilution(self) -> float:
        """The square of the index before the lens; a thin lens has it in the place of its imagined film."""
        return 1.0 if self.model in ("thin", "pinhole") else self.lens.front_index**2

    def _ray_normaliser(self, wavelength: float) -> float:
        """What cos⁴θ · area is divided by where rays are followed."""
        on_axis = self.axis_irradiance if wavelength == D_LINE else self._axis_irradiance_at(wavelength)
        return self._normaliser(on_axis, self.film_distance) if on_axis > 0.0 else math.inf

    def _sampled(self, wavelength: float) -> tuple[PupilTable | PupilGrid, float]:
        """The regions that a film point aims into, and what cos⁴θ · area is divided by."""
        return self.pupil if wavelength == D_LINE else self._pupil_at(wavelength), self._ray_normaliser(wavelength)

    def film_from_point(self, points, pupil_uv, wavelength: float = D_LINE):
        """In closed form for the ideal models; through the real lens by Newton's method, to the last digits."""
        if not self.follows_rays:
            return self.gaussian.film_points(points, pupil_uv)
        program = Program(self.camera_steps(wavelength), np.float64)
        return film_from_point(program, points, pupil_uv, self.pupil_centre, self.film.diagonal / 2.0)

    def film_importance(self, origins, directions, wavelength: float = D_LINE) -> FilmImportance:
        """Of a real lens: traced back to the film, which emits z² / normaliser evenly over its area.

        In a medium cos θ dω dA is less by the square of its index, and W more.
        """
        if not self.follows_rays:
            return super().film_importance(origins, directions, wavelength)
        lens, (table, normaliser) = self.lens, self._sampled(wavelength)
        rays = dict(zip((X, Y, Z, L, M, N), (*origins.T, *-directions.T), strict=True))
        back = Program(trace_steps(lens, self.film_distance, wavelength, towards="film"), np.float64).run(
            {**rays, WEIGHT: np.ones(len(origins))}, [X, Y, Z, L, M, N, WEIGHT], len(origins))
        points, cosine = back[:2].T, back[5]
        slope = back[3:5].T / cosine[:, None]
        film, rear = points - back[2][:, None] * slope, points - (back[2] + self.film_distance)[:, None] * slope
        passes = back[6] > 0.0
        area = np.zeros(len(passes))
        area[passes] = table.sampled_area(film[passes], rear[passes])
        with np.errstate(divide="ignore"):
            way = self.film_distance**2 / (area * cosine**3)
        one = np.ones(len(passes)) / self._film_area
        we = one * (lens.front_index**2 * self.film_distance**2 / normaliser)
        return FilmImportance(film, we, one, way, passes & (area > 0.0))


def missing_dispersion(lens: Lens) -> str:
    """Which glass is not known for all the wavelengths that a picture sees, and where it is; "" where they all are."""
    try:
        for wavelength in (wavelength for row in WAVELENGTHS.values() for wavelength in row):
            lens.indices(wavelength)
    except GlassError as error:
        return str(error)
    return ""
