"""Distortion: where the real chief rays fall, against where a projection without error has them.

The chief ray of a film point runs through the middle of the stop. It is followed from the film to the
plane that the film is focused on (or to infinity), and the ideal image of what it meets there is compared with the
film point: at f tan θ, and for a film nearer than infinity focus by the paraxial magnification. A fisheye is
measured against the projection of fisheyes that it follows best. Lengths in mm, angles in radians.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.cameras.fisheye import PROJECTIONS, image_height
from lensbench.imaging.film import Film
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.scalar_trace import trace
from lensbench.pupils.region import exit_pupil

RECTILINEAR = "rectilinear"
KINDS = ("none", "barrel", "pincushion", "moustache")
SLIGHT = 0.05           # percent: below it there is none
POINTS = 33             # of the rims that the search begins from
STEPS = 12              # of the secant rule
DENSE = 65              # film radii of a grid


@dataclass(frozen=True, eq=False)
class Distortion:
    """At film radii (n,) mm: the angle (rad) at which the chief ray leaves for the scene, and the ideal radius (mm).

    NaN where no light falls. projection: what is ideal, "rectilinear" or one of a fisheye's; focal_length: its scale.
    """

    projection: str
    focal_length: float
    radii: np.ndarray
    angles: np.ndarray
    ideal: np.ndarray

    @property
    def percent(self) -> np.ndarray:
        """(n,) of the ideal radius: negative where the image is too small (barrel), positive where it is too large."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.radii > 0.0, 100.0 * (self.radii / self.ideal - 1.0), 0.0)

    @property
    def rms(self) -> float:
        """Of the radial errors (mm); inf where some angle has no ideal image."""
        error = (self.radii - self.ideal)[~np.isnan(self.angles)]
        return float(np.sqrt((error**2).mean())) if np.isfinite(error).all() and error.size else math.inf

    @property
    def kind(self) -> str:
        """One of KINDS: straight lines bulge outwards, or inwards, or first the one and then the other."""
        percent = self.percent[np.isfinite(self.percent)]
        if not percent.size or np.abs(percent).max() < SLIGHT:
            return "none"
        low, high = percent.min(), percent.max()
        if low < -SLIGHT and high > SLIGHT or abs(percent[-1]) < 0.5 * max(-low, high):
            return "moustache"
        return "barrel" if -low > high else "pincushion"

    def displaced(self, points) -> np.ndarray:
        """Where the lens puts ideal film points (…, 2), in mm from the axis: NaN beyond the greatest radius."""
        points = np.asarray(points, float)
        r = np.hypot(points[..., 0], points[..., 1])
        known = np.isfinite(self.ideal)
        order = np.argsort(self.ideal[known])
        at = np.interp(r, np.append(0.0, self.ideal[known][order]), np.append(0.0, self.radii[known][order]),
                       right=math.nan)
        with np.errstate(invalid="ignore"):
            return points * np.where(r > 0.0, at / np.where(r > 0.0, r, 1.0), 1.0)[..., None]


def distortion(lens: Lens, film_distance: float, film_radii, projection: str = RECTILINEAR,
               wavelength: float = D_LINE) -> Distortion:
    """The distortion of a lens with its film `film_distance` mm behind the last vertex, at film radii (n,) mm.

    Objects stand where the film is focused, or at infinity where it is nearer to the lens than the rear focus.
    projection: "rectilinear", one of a FisheyeCamera's, or "best", that of all five with the least rms error.
    LensError for one that is none, and for an afocal lens.
    """
    if projection not in (RECTILINEAR, *PROJECTIONS, "best"):
        raise LensError(f"projection {projection!r}: choose one of {', '.join((RECTILINEAR, *PROJECTIONS, 'best'))}")
    fo = first_order(lens, wavelength)
    if math.isinf(fo.efl):
        raise LensError("an afocal lens has no focal length to measure its distortion by")
    radii = np.atleast_1d(np.asarray(film_radii, float))
    points, ways = chief_rays(lens, film_distance, radii, wavelength)
    angles = np.arctan2(-ways[:, 0], -ways[:, 2]) + 0.0          # no −0
    extension = film_distance - fo.bfl
    far = extension < 1e-9 * fo.efl
    # Of a paraxial chief ray, height on the film over the tangent at the entrance pupil: f where that is the rear focus
    n = lens.front_index
    away = 0.0 if math.isinf(fo.entrance_pupil.z) else fo.entrance_pupil.z - fo.ffl
    scale = n * fo.efl + away * extension / fo.efl

    def against(name: str) -> Distortion:
        if name == RECTILINEAR:
            with np.errstate(invalid="ignore"):
                if far:
                    ideal = np.where(angles < 0.5 * math.pi, scale * np.tan(angles), math.inf)
                else:
                    away = (fo.ffl - n * fo.efl**2 / extension - points[:, 2]) / ways[:, 2]
                    ideal = -(points[:, 0] + away * ways[:, 0]) * extension / fo.efl
                    ideal = np.where(away > 0.0, ideal, math.inf)
            return Distortion(name, scale, radii, angles, np.where(np.isnan(angles), math.nan, ideal))
        return Distortion(name, scale, radii, angles, scale * image_height(name, angles))

    if projection != "best":
        return against(projection)
    return min((against(name) for name in (RECTILINEAR, *PROJECTIONS)), key=lambda found: found.rms)


def distortion_grid(lens: Lens, film_distance: float, film: Film, lines: int = 9, projection: str = RECTILINEAR,
                    wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
    """Crossings of a grid over the film: ideal and real, (rows, columns, 2) each, in mm from the axis.

    `lines` along the film's shorter side, as far apart along the longer one. NaN where no light falls.
    """
    if lines < 2:
        raise LensError(f"a grid of {lines} lines: at least 2 are needed")
    gap = min(film.width, film.height) / (lines - 1)
    across, down = (max(2, round(side / gap) + 1) for side in (film.width, film.height))
    x, y = (np.linspace(-side / 2.0, side / 2.0, count)
            for side, count in ((film.width, across), (film.height, down)))
    ideal = np.stack(np.meshgrid(x, y), -1)
    radii = np.linspace(0.0, 0.75 * film.diagonal, DENSE)       # pincushion may put a corner beyond the film's
    return ideal, distortion(lens, film_distance, radii, projection, wavelength).displaced(ideal)


def chief_rays(lens: Lens, film_distance: float, film_radii, wavelength: float = D_LINE):
    """The rays from film points (r, 0) through the middle of the stop: where they leave the first surface, and how.

    Points and unit directions (n, 3), lens frame. They ignore rims, and are NaN where no light falls. By the secant
    rule along the meridian, from the middle of each exit-pupil region.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    pupil = exit_pupil(lens, film_distance, radii, wavelength, points=POINTS)
    left, right = pupil.bounds[:, 0], pupil.bounds[:, 2]
    film = np.column_stack([radii, 0.0 * radii, np.full(len(radii), lens.length + film_distance)])

    def traced(aim):
        ways = np.column_stack([aim, 0.0 * aim, np.full(len(aim), lens.length)]) - film
        ways = np.where(np.isfinite(ways), ways, [0.0, 0.0, -1.0])
        return trace(lens, film, ways, wavelength, clip=False, record=True)

    def off(found):
        return found.paths[:, len(lens.surfaces) - lens.stop_index, 0]

    before, aim = 0.5 * (left + right) - 0.05 * (right - left), 0.5 * (left + right)
    was, now = off(traced(before)), off(traced(aim))
    for _ in range(STEPS):
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -now * (aim - before) / (now - was)
        step = np.where(np.isfinite(step), step, 0.0)
        if np.abs(step).max(initial=0.0) < 1e-13 * lens.stop.semi_diameter:
            break
        before, was, aim = aim, now, aim + step
        now = off(traced(aim))
    found = traced(aim)
    lost = (found.fate != 0) | ~(right > left) | ~(np.abs(now) < 1e-6 * lens.stop.semi_diameter)
    return (np.where(lost[:, None], math.nan, rays) for rays in (found.points, found.directions))
