"""Read-outs: every figure of the settings that a panel shows.

Pure functions of Settings, cached by value: asking again in every frame costs almost nothing. Lengths in mm, angles
in radians. Object distances are measured from the film, as engraved on a lens; those of the perspective camera, which
has no lens of its own, from its centre of projection.
"""

import json
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import VISIBLE, FocusPosition, bench_of, coating, design, picture_wavelength, published
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.bench.water_window import nearest_in_focus, true_focus
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.cameras.lens_settings import missing_dispersion
from lensbench.core.pupils.outline_solver import Aim, edge_of_light
from lensbench.core.text import fixed, significant

SOFT = ". First order alone: aberrations blur even what is in focus beyond the limit, see Blur in focus"
SEEN = f"{fixed(VISIBLE[0], 2)} to {fixed(VISIBLE[1], 2)} µm"
AIR = FlatPort()                # no window
NARROW = 0.97                   # of the film's diagonal: a smaller image circle is reported


@dataclass(frozen=True)
class Readings:
    """The read-outs; None where a figure has no meaning for the camera.

    fov_…: by chief rays of the real lens, with its distortion, at infinity; 2 atan(h / 2f) for an ideal one.
    wavelength: of the focal lengths, the widest f-number, the pupils and the Airy disk (µm), the primary one of the
    design.
    f_number: in air, focused at infinity. widest_f_number: the same with the stop fully open. working_f_number: of the
    cone of light on the film, at the current focus. reason: why the lens cannot follow the settings, or "".
    """

    efl: float | None = None
    bfl: float | None = None
    ffl: float | None = None
    f_number: float | None = None
    widest_f_number: float | None = None
    working_f_number: float | None = None
    t_number: float | None = None
    fov_horizontal: float | None = None
    fov_vertical: float | None = None
    fov_diagonal: float | None = None
    equivalent: float | None = None
    limit: float | None = None
    near_limit: float | None = None
    far_limit: float | None = None
    hyperfocal: float | None = None
    magnification: float | None = None
    film_distance: float | None = None
    nearest_focus: float | None = None
    entrance_pupil: float | None = None         # diameters
    exit_pupil: float | None = None
    airy: float | None = None                   # diameter of the first dark ring
    wavelength: float = lb.D_LINE
    across: float | None = None                 # focal length of the section x–z of a lens with cylinders
    foci: tuple[float, float] | None = None     # of its sections x–z and y–z, mm behind the film
    focusing: FocusPosition = FocusPosition("paraxial")
    reason: str = ""

    @property
    def soft(self) -> bool:
        """Whether aberrations blur even a point in focus on the axis beyond the limit."""
        return (self.focusing.blur or 0.0) > (self.limit or math.inf) and self.near_limit is not None


def blur_limit(settings: Settings) -> float:
    """The circle of confusion (mm) up to which a point counts as sharp."""
    return settings.pixel_pitch if settings.limit == "pixel" else settings.film.diagonal / 1500.0


class Colours(NamedTuple):
    """Dispersion: whether it is possible, whether pictures are traced with it, and the reason in a sentence."""

    possible: bool
    used: bool
    why: str


def colours(settings: Settings) -> Colours:
    """The dispersion of the lens under these settings; ValueError or OSError if the lens cannot be loaded."""
    if not settings.has_lens:
        return Colours(False, False, "Only the real lens disperses: this camera is an ideal one, at the d line")
    lens = published(settings)
    wavelength = picture_wavelength(settings, lens)
    alone = "At the d line alone" if wavelength is None else \
        f"At {significant(1000.0 * wavelength)} nm alone, the primary wavelength of the design"
    if not settings.follows_lens:
        return Colours(False, False, f"{alone}: only the real lens disperses, this model is an ideal one")
    if not any(surface.glass.disperses for surface in lens.surfaces):
        return Colours(False, False, f"{alone}: no dispersion data for the glasses of this lens")
    if wavelength is not None and not VISIBLE[0] <= wavelength <= VISIBLE[1]:
        return Colours(False, False, f"{alone}, outside what a colour picture sees, {SEEN}")
    missing = missing_dispersion(lens)
    if missing:
        return Colours(False, False, f"{alone}: {missing}, and a picture sees {SEEN}")
    if settings.dispersion == "off":
        return Colours(True, False, f"{alone}: dispersion is turned off")
    return Colours(True, True, "Traced at 24 wavelengths, eight for each of red, green and blue: lateral and "
                               "longitudinal colour show. A sample takes three times as long"
                               + (". The automatic model does so where they amount to half a pixel"
                                  if settings.is_automatic else ""))


def lens_readings(settings: Settings) -> Readings:
    """The read-outs of a camera with a lens."""
    return _of_lens(design(settings), settings)


@lru_cache(maxsize=64)
def _of_lens(lens: lb.Lens, settings: Settings) -> Readings:
    lens_setup = bench_of(settings)
    film, limit, port = lens_setup.film, blur_limit(settings), lens_setup.port
    wavelength = lens.reference_wavelength
    designed = lb.first_order(lens, wavelength)
    fo = lb.first_order(lens_setup.lens, wavelength)              # focused and stopped down
    area = 2.0 * lens_setup.lens.iris.equivalent_radius             # of a circle of as much area as the blades leave
    plain = replace(
        angles(film, lens.front_index * designed.efl, _across(lens, wavelength, lens.front_index), port),
        wavelength=wavelength,
        efl=_finite(designed.efl), bfl=_finite(designed.bfl), ffl=_finite(designed.ffl), limit=limit,
        widest_f_number=_finite(lb.f_number_at_infinity(lens, wavelength)),
        film_distance=lens_setup.film_distance, focusing=lens_setup.focusing,
        entrance_pupil=_finite(area * fo.entrance_pupil.radius), exit_pupil=_finite(area * fo.exit_pupil.radius),
        reason=lens_setup.reason,
    )
    if not 0.0 < lens_setup.first_order.efl < math.inf:
        return plain
    if settings.follows_lens and lens.is_rotationally_symmetric:
        across, down, diagonal = (angle if angle is None else 2.0 * port.seen_angle(0.5 * angle)
                                  for angle in traced_angles(lens, film.width, film.height, wavelength,
                                                             lens_setup.focusing.method))
        plain = replace(plain, fov_horizontal=across, fov_vertical=down, fov_diagonal=diagonal)
    focused, behind = lens_setup.lens, lens_setup.film_distance
    nearest = lb.nearest_focus(focused)
    focus = lens_setup.focus_distance                   # the nearest one where that of the settings was refused
    if len(lens.sections) > 1:
        foci = lb.section_foci(focused, focus, behind)
        plain = replace(plain, across=_across(lens, wavelength), foci=(foci[0] - behind, foci[1] - behind))
    plain = replace(plain, nearest_focus=nearest_in_focus(focused, settings))
    near = far = math.nan
    try:
        plain = replace(plain, magnification=lb.magnification(focused, behind, focus))
        near, far = lb.thick_depth_of_field(focused, behind, focus, limit)
    except lb.LensError:                                # focused on what touches the lens
        pass
    if not settings.has_stop:
        return replace(plain, f_number=None)
    working = lb.working_f_number(focused, behind)
    return replace(
        plain, f_number=lens_setup.f_number, working_f_number=_finite(working), airy=airy_diameter(working, wavelength),
        t_number=lb.t_number(focused.at(close=0.0), coating(settings, lens).name, wavelength),
        near_limit=_known(port.true(near)), far_limit=_known(port.true(far)),
        hyperfocal=true_focus(focused, max(lb.thick_hyperfocal(focused, limit), nearest), settings),
    )


def _across(lens: lb.Lens, wavelength: float, index: float = 1.0) -> float | None:
    """Focal length (mm) of the section x–z of a lens with cylinders at a wavelength (µm), times index; else None."""
    return None if len(lens.sections) == 1 else _finite(index * lb.first_order(lens.section("x"), wavelength).efl)


def angles(film: lb.Film, efl: float, across_efl: float | None = None, port: FlatPort = AIR) -> Readings:
    """Fields of view at infinity, 2 atan(h / 2f), and the focal length with the same diagonal field on full frame.

    efl: on the side of the scene, f; in water it is longer by the index. across_efl: the same (mm) of the section
    x–z of a lens with cylinders, which squeezes the picture; the film then counts as wide as the unsqueezed picture.
    port: the window into water, which narrows the fields.
    """
    if not (math.isfinite(efl) and efl > 0.0):
        return Readings()
    if across_efl is not None and across_efl > 0.0:
        film = replace(film, width=film.width * efl / across_efl)
    across, down, diagonal = (2.0 * port.seen_angle(0.5 * lb.field_of_view(efl, film, axis))
                              for axis in ("horizontal", "vertical", "diagonal"))
    return Readings(fov_horizontal=across, fov_vertical=down, fov_diagonal=diagonal,
                    equivalent=lb.equivalent(0.5 * film.diagonal / math.tan(0.5 * diagonal), film).focal_length)


@lru_cache(maxsize=64)
def traced_angles(lens: lb.Lens, width: float, height: float, wavelength: float,
                  method: str) -> tuple[float | None, ...]:
    """Fields of view (radians) of a film (mm) at infinity: twice the angles of chief rays, with all distortion.

    To the sides, the top and the corner of the film, or to the edge of a smaller image circle. None where no light
    through the middle of the stop gets there. method: of focusing.
    """
    try:
        film_distance = lb.film_distance(lens, math.inf, method)
    except lb.LensError:
        return (None,) * 3
    corner = np.array([0.5 * width, 0.5 * height])
    reach = float(edge_of_light(Aim(lens, film_distance), corner[None], 1.0)[0][0]) * math.hypot(*corner)
    radii = np.minimum([corner[0], corner[1], math.hypot(*corner)], reach)
    rays = find_chief_rays(lens, film_distance, np.column_stack([0.0 * radii, radii]), by_image=True,
                           wavelength=wavelength)
    return tuple(float(angle) if math.isfinite(angle) else None for angle in 2.0 * np.abs(rays.angles[:, 1]))


def airy_diameter(working_f_number: float, wavelength: float = lb.D_LINE) -> float | None:
    """Diameter (mm) of the first dark ring of a point, 2.44 λ N; λ in µm."""
    return _finite(2.44 * wavelength * 1e-3 * working_f_number)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def intrinsics(of: lb.Camera) -> str | None:
    """Focal length and principal point in pixels, and the pose, as JSON; None for a camera that is not projective."""
    try:
        values = of.intrinsics
    except lb.CameraError:
        return None
    film = of.film
    pose = np.reshape(of.placement(0.0, np.array([[film.pixels_x / 2.0, film.pixels_y / 2.0]])), (4, 4))
    return json.dumps({
        "width": film.pixels_x, "height": film.pixels_y, "fx": values.fx, "fy": values.fy, "cx": values.cx,
        "cy": values.cy, "K": values.matrix.tolist(), "world_from_camera": pose.tolist(),
        "units": "pixels per mm, mm" if of.gaussian.slope_film == 0.0 else "pixels, mm",     # of an orthographic camera
        "convention": "K: x right, y down, z forward; world_from_camera: x right, y up, looks along -z",
    }, indent=2)


# The image circle on the film


def lit(settings: Settings) -> float:
    """Radius (mm) to which light reaches the film: to its corner for a camera without a lens."""
    corner = 0.5 * settings.film.diagonal
    if not settings.has_lens:
        return corner
    try:
        return lit_radius(bench_of(settings))
    except (ValueError, OSError):
        return corner


def dark_corners(settings: Settings) -> str:
    """Reason for dark corners, or ""; an ideal lens lights any film."""
    if not settings.follows_lens:
        return ""
    reach, diagonal = 2.0 * lit(settings), settings.film.diagonal
    if reach == 0.0:                                    # the read-outs say why there is no image
        return ""
    share = _towards_the_corner(settings)
    if share is not None:
        return f"Light ends at {fixed(100.0 * share, 0)} % of the film's diagonal" if share < NARROW else ""
    if settings.film_pose.rise or settings.film_pose.shift:
        return _dark_shifted(settings)
    if reach >= NARROW * diagonal:
        return ""
    return f"Image circle ø {fixed(reach, 1)} mm, film diagonal {fixed(diagonal, 1)} mm"


def _dark_shifted(settings: Settings) -> str:
    """Reason for dark corners of a film that is shifted across the axis, or ""."""
    pose, film = settings.film_pose, settings.film
    away, half = np.array([abs(pose.shift), abs(pose.rise)]), 0.5 * np.array([film.width, film.height])
    far, near = float(np.hypot(*(away + half))), float(np.hypot(*np.maximum(away - half, 0.0)))
    try:
        reach = lit_radius(bench_of(settings), far)
    except (ValueError, OSError):
        return ""
    if near >= reach:
        return f"No light: the film is shifted beyond the image circle, ø {fixed(2.0 * reach, 1)} mm"
    if reach >= NARROW * far:
        return ""
    return f"Image circle ø {fixed(2.0 * reach, 1)} mm, and the film is shifted out to ø {fixed(2.0 * far, 1)} mm"


def _towards_the_corner(settings: Settings) -> float | None:
    """Part of the way to the film's corner that light reaches, for a lens without rotational symmetry; else None."""
    try:
        lens_setup = bench_of(settings)
    except (ValueError, OSError):
        return None
    if lens_setup.lens.is_rotationally_symmetric:
        return None
    return _lit_part(lens_setup.lens, lens_setup.film_distance, lens_setup.film.width, lens_setup.film.height)


@lru_cache(maxsize=16)
def _lit_part(lens: lb.Lens, film_distance: float, width: float, height: float) -> float:
    return float(edge_of_light(Aim(lens, film_distance), np.array([[0.5 * width, 0.5 * height]]), 1.0)[0][0])
