"""The merit function of an improvement: spots or wave errors over fields and colours, and what must not change.

Lengths in mm, angles in radians, lens frame. Rays come from infinity and are aimed at points of the stop, so that every
lens is judged by the light that its stop passes; those that a rim of the first lens ends do not count. The film lies
where the sum of all squares is least: defocus is no fault.
"""

from dataclasses import dataclass, replace
from math import atan, degrees, inf, isfinite, sqrt

import numpy as np

from lensbench.analysis.grids.chief_rays import find_chief_rays
from lensbench.app.studies.improvement.wave_errors import wave_errors
from lensbench.kernels.figures import fixed, significant
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.paraxial import FAR, focal_length, image_distance
from lensbench.optics.glass import C_LINE, D_LINE, F_LINE, GlassError
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import surface_table, trace_rays
from lensbench.optics.surfaces import SurfaceTable

FIELDS = (0.0, 0.7, 1.0)        # of the largest field angle
STEEP = 0.6                     # radians: from here on rays are aimed about the real chief ray
WIDEST = 1.5                    # radians: the largest field angle that rays are aimed at
HEIGHTS = 32                    # image heights among which the edge of a smaller image circle is found
RINGS, ARMS = 4, 5              # of rays over half of the pupil; the other half mirrors it
AIMING = 3                      # Newton steps that bring a ray to its point of the stop
HELD = 0.05                     # mm of spot radius that a 1 % change of a held length counts as
THIN = 1.0                      # mm of spot radius that 1 mm of missing thickness counts as
AIMS = ("spot", "wavefront")


class MeritError(ValueError):
    """A lens whose spots cannot be judged; the message says why."""


@dataclass(frozen=True)
class Goal:
    """What an improvement aims at.

    Parameters
    ----------
    field : float
        Largest field angle (radians), from 0 to WIDEST.
    focal_length, back_focus : float or None
        Lengths (mm) that are held; None lets them go.
    edge, centre : float
        Least thickness (mm) of elements at their rims and at their centre; air gaps stay above 0.
    colours : tuple of float
        Wavelengths (µm); those that a glass is not known at are left out.
    aim : str
        "spot" for the rms radius of the spots, "wavefront" for the rms wave error; one of AIMS.
    focal_length_x : float or None
        As `focal_length`, of the section x–z of a lens with a cylinder or toroid.
    """

    field: float
    focal_length: float | None = None
    back_focus: float | None = None
    edge: float = 0.5
    centre: float = 0.8
    colours: tuple[float, ...] = (F_LINE, D_LINE, C_LINE)
    aim: str = "spot"
    focal_length_x: float | None = None


@dataclass(frozen=True)
class Beams:
    """Rays in front of the lens, by field and ray; the same ones for every colour.

    origins, directions: (fields, rays, 3). weights: (fields, rays), 0 for rays that a rim ends.
    """

    origins: np.ndarray
    directions: np.ndarray
    weights: np.ndarray


class Merit:
    """The merit of lenses near a first one.

    start: MeritError where no ray passes it, or it throws no image.
    """

    def __init__(self, start: Lens, goal: Goal):
        if not 0.0 <= goal.field <= WIDEST:
            raise MeritError(f"field angle {significant(goal.field, 3)}: it must lie from 0 to {WIDEST} radians")
        self.goal = goal
        self.colours = tuple(w for w in goal.colours if _known(start, w)) or (D_LINE,)
        fo = first_order(start)
        if not (isfinite(fo.efl) and isfinite(fo.entrance_pupil.radius) and isfinite(fo.entrance_pupil.z)):
            raise MeritError("the lens is afocal or telecentric: its spots cannot be judged")
        if goal.aim not in AIMS:
            raise MeritError(f"aim {goal.aim!r}: choose one of {', '.join(AIMS)}")
        # A wave error counts as the spot that it makes where it is defocus: 4 √6 N times as large
        self._scale = 4.0 * sqrt(6.0) * abs(fo.f_number) if goal.aim == "wavefront" else 1.0
        if not start.is_in_line:
            raise MeritError("the merit knows lenses in line alone: set the decentres and tilts of this one to 0")
        self.beams = self._passing(start, self.aimed(start))
        if np.count_nonzero(self.beams.weights[0]) < 3:
            raise MeritError("hardly a ray passes the lens: open a rim or move an element first")

    def aimed(self, lens: Lens) -> Beams:
        """Rays at the same points of the stop for this lens; weights of the beams before, if there are any."""
        radii = np.sqrt((np.arange(RINGS) + 0.5) / RINGS)
        angles = -0.5 * np.pi + np.pi * (np.arange(ARMS) + 0.5) / ARMS
        points = np.stack([np.outer(radii, np.cos(angles)).ravel(), np.outer(radii, np.sin(angles)).ravel()], 1)
        points = np.vstack([[0.0, 0.0], points]) * lens.stop.semi_diameter
        pupil = first_order(lens).entrance_pupil
        part = replace(lens, surfaces=lens.surfaces[:lens.stop_index + 1], positions=None)
        table = surface_table(part)
        scale = pupil.radius / lens.stop.semi_diameter * (np.sign(_forward(lens)) or 1.0)
        start_z = min(0.0, pupil.z) - 2.0 * lens.length - 1.0
        slopes = np.repeat(np.tan(np.array(FIELDS) * self.goal.field), len(points))
        directions = np.column_stack([np.zeros(len(slopes)), slopes, np.ones(len(slopes))])
        directions /= np.hypot(1.0, slopes)[:, None]
        wanted = np.tile(points, (len(FIELDS), 1))
        at = wanted * scale
        at[:, 1] += np.repeat(self._entries(lens, pupil.z, start_z), len(points))
        # Newton, ray by ray: the map from the pupil to the stop is nearly a scaling
        step = 1e-4 * pupil.radius
        for _ in range(AIMING):
            hit, by_x, by_y = np.split(_hits(table, np.concatenate([at, at + [step, 0.0], at + [0.0, step]]),
                                             np.tile(directions, (3, 1)), start_z), 3)
            by_x, by_y, missing = (by_x - hit) / step, (by_y - hit) / step, wanted - hit
            with np.errstate(all="ignore"):
                move = np.stack([missing[:, 0] * by_y[:, 1] - missing[:, 1] * by_y[:, 0],
                                 missing[:, 1] * by_x[:, 0] - missing[:, 0] * by_x[:, 1]], 1) / (
                    by_x[:, 0] * by_y[:, 1] - by_x[:, 1] * by_y[:, 0])[:, None]
            at = at + np.where(np.isfinite(move), move, 0.0)
        origins = np.column_stack([at, np.full(len(at), start_z)])
        shape = (len(FIELDS), len(points), 3)
        weights = self.beams.weights if hasattr(self, "beams") else np.ones((len(FIELDS), len(points)))
        return Beams(origins.reshape(shape), directions.reshape(shape), weights)

    def _entries(self, lens: Lens, pupil_z: float, start_z: float) -> np.ndarray:
        """Y (mm) of each field's chief ray at start_z: of the paraxial one, and of the real one of a steep field."""
        angles = np.array(FIELDS) * self.goal.field
        entries = (start_z - pupil_z) * np.tan(angles)
        if self.goal.field > STEEP:             # the pupil has wandered: Newton's steps would miss the lens
            real = find_chief_rays(lens, back_focus(lens), np.column_stack([0.0 * angles, angles]))
            x_y_z, slope = real.points, real.directions[:, 1] / real.directions[:, 2]
            there = x_y_z[:, 1] + (start_z - x_y_z[:, 2]) * slope
            entries = np.where(np.isfinite(there), there, entries)
        return entries

    def _passing(self, lens: Lens, beams: Beams) -> Beams:
        """The beams without the rays that a rim of this lens ends."""
        fate = _traced(surface_table(lens), beams.origins.reshape(-1, 3), beams.directions.reshape(-1, 3), True)[2]
        alive = (fate == 0).reshape(beams.weights.shape)
        weights = np.where(alive, 1.0, 0.0)
        weights[:, 1:] *= 2.0                                   # mirrored
        return replace(beams, weights=weights)

    def residuals(self, lens: Lens) -> np.ndarray:
        """The residuals (mm, weighted), whose sum of squares is the merit; inf where a ray is lost.

        Of spots, each pair is the way of a ray from the centre of its spot in x and y, over all colours of its field;
        their rms is that of the spot radius over the fields. The penalties come last.
        """
        beams = self.aimed(lens)
        if self.goal.aim == "wavefront":
            errors = wave_errors(lens, self.colours, beams.origins, beams.directions, beams.weights)
        else:
            errors = self._spot_errors(lens, beams)
        if errors is None:
            return np.full(1, inf)
        return np.concatenate([self._scale * errors, self._penalties(lens, self.goal)])

    def _spot_errors(self, lens: Lens, beams: Beams) -> np.ndarray | None:
        """The ways (mm, weighted) of the rays from the centres of their spots at the best film; None if one is lost."""
        last, used = lens.length, beams.weights > 0.0
        shifts, slopes = [], []                                 # by colour: of the rays of all fields
        for colour in self.colours:
            table = surface_table(lens, colour)
            points, after, fate = _traced(table, beams.origins[used], beams.directions[used], False)
            if fate.any():
                return None
            slope = after[:, :2] / after[:, 2:]
            shifts.append(points[:, :2] + (last - points[:, 2:]) * slope)
            slopes.append(slope)
        rows = []
        for values in (np.stack(shifts), np.stack(slopes)):     # (colours, rays, 2)
            centred = []
            for field, weight in zip(_by_field(values, used), _by_field(beams.weights[used], used), strict=True):
                if not weight.size:
                    continue
                total = weight.sum() * len(self.colours)
                centre = (weight[:, None] * field).sum((0, 1)) / total
                centre[0] = 0.0                                 # the mirrored half balances x
                share = np.sqrt(weight / total / len(FIELDS))
                centred.append((share[:, None] * (field - centre)).ravel())
            rows.append(np.concatenate(centred))
        shift, slope = rows
        film = -float(shift @ slope) / float(slope @ slope)
        return shift + film * slope

    def _penalties(self, lens: Lens, goal: Goal) -> np.ndarray:
        """Residuals of what is held and of what must not be thinner."""
        found = []
        if goal.focal_length is not None:
            held = focal_length(lens.surfaces, front_index=lens.front_index)
            found.append(100.0 * HELD * (held / goal.focal_length - 1.0))
        if goal.focal_length_x is not None:
            found.append(100.0 * HELD * (_focal_length_x(lens) / goal.focal_length_x - 1.0))
        if goal.back_focus is not None:
            found.append(100.0 * HELD * (back_focus(lens) / goal.back_focus - 1.0))
        for front, back in zip(lens.surfaces, lens.surfaces[1:], strict=False):
            in_glass = front.glass.n_d > 1.0
            edge = front.thickness + _sag(back) - _sag(front) if in_glass else front.thickness + _sag(
                back, front.semi_diameter) - _sag(front, back.semi_diameter)
            least = goal.edge if in_glass else 0.0
            found.append(THIN * max(0.0, least - edge) if isfinite(edge) else THIN)
            found.append(THIN * max(0.0, (goal.centre if in_glass else 0.0) - front.thickness))
        return np.array(found)

    def rms(self, lens: Lens) -> float:
        """RMS (mm) of the aim over the fields and colours, at the best film; inf where a ray is lost."""
        residuals = self.residuals(lens)
        count = len(self._penalties(lens, self.goal))
        return float(np.linalg.norm(residuals[:-count or None])) / self._scale if isfinite(residuals[0]) else inf


def goal_of(document: LensDocument, image_height: float, aim: str = "spot") -> Goal:
    """The goal that keeps focal length and thinnest edges of a lens, over an image of this height (mm)."""
    lens = document.lens
    efl = focal_length(document.surfaces, front_index=lens.front_index)
    if not (isfinite(efl) and efl > 0.0):
        raise MeritError("the lens throws no image: it cannot be improved before it does")
    elements = [(front, back) for front, back in zip(document.surfaces, document.surfaces[1:], strict=False)
                if front.glass.n_d > 1.0]
    edges = [front.thickness + _sag(back) - _sag(front) for front, back in elements]
    edge = max(0.0, min([0.5, *(e for e in edges if isfinite(e))]))
    centre = min([0.8, *(max(0.0, front.thickness) for front, _ in elements)])
    across = _focal_length_x(lens) if len(lens.sections) > 1 else inf
    return Goal(min(_field_angle(lens, image_height, efl), WIDEST), efl, None, edge, centre, aim=aim,
                focal_length_x=across if isfinite(across) else None)


def left_out(lens: Lens, goal: Goal) -> list[str]:
    """What the merit does not see of a lens, in sentences."""
    found = []
    if goal.field == WIDEST:
        found.append(f"The fields end at {significant(degrees(WIDEST), 3)}°: steeper light is not judged")
    if len(lens.sections) > 1:
        found.append("The fields lie along y: those across, and in the corners, are not judged")
    if isfinite(lens.system.object_distances[0]) and abs(lens.system.object_distances[0]) < FAR:
        found.append("Judged for an object at infinity, not for the distance of the design, "
                     f"{significant(lens.system.object_distances[0])} mm")
    return found


def back_focus(lens: Lens) -> float:
    """Last vertex → paraxial image of infinity (mm), at the d line."""
    return image_distance(lens.surfaces, inf, front_index=lens.front_index)


def _focal_length_x(lens: Lens) -> float:
    """Focal length (mm) of the section x–z, at the d line."""
    return focal_length(lens.sections[0].surfaces, front_index=lens.front_index)


def _field_angle(lens: Lens, image_height: float, efl: float) -> float:
    """The angle (radians) of the field whose chief ray meets the film at a height (mm).

    Beyond the image circle that of the largest height with a chief ray, or the paraxial one if this is larger.
    """
    heights = image_height * np.linspace(1.0, 0.0, HEIGHTS, endpoint=False)
    found = find_chief_rays(lens, back_focus(lens), np.column_stack([0.0 * heights, heights]), by_image=True)
    angles = np.abs(found.angles[:, 1])
    if isfinite(angles[0]):
        return float(angles[0])
    reached = angles[np.isfinite(angles)]
    return max(atan(image_height / (lens.front_index * efl)), float(reached[0]) if reached.size else 0.0)


def amount(rms: float, aim: str) -> str:
    """The rms (mm) of an aim in words."""
    if aim == "wavefront":
        return f"wave error {fixed(1000.0 * rms / D_LINE, 4)} waves rms"
    return f"spot {fixed(1000.0 * rms, 3)} µm rms"


def _by_field(values: np.ndarray, used: np.ndarray) -> list[np.ndarray]:
    """The values of used rays, whose axis is the last of one and the last but one of others, field by field."""
    ends = np.cumsum(used.sum(1))[:-1]
    return np.split(values, ends, axis=1 if values.ndim == 3 else 0)


def _known(lens: Lens, wavelength: float) -> bool:
    try:
        lens.indices(wavelength)
    except GlassError:
        return False
    return wavelength == D_LINE or any(surface.glass.disperses for surface in lens.surfaces)


def _sag(surface, height: float | None = None) -> float:
    height = surface.semi_diameter if height is None else min(height, surface.semi_diameter)
    return float(surface.sag(0.0, height))


def _forward(lens: Lens) -> float:
    """Whether the stop is imaged upright into the pupil: the height at the stop of a ray of height 1."""
    from lensbench.optics.paraxial import ray_matrix

    return ray_matrix(lens, 0, lens.stop_index)[0]


def _traced(table: SurfaceTable, origins: np.ndarray, directions: np.ndarray,
            clip: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3), directions (n, 3) and fates (n,) behind the lens of a table."""
    count = len(origins)
    points, after = np.empty((count, 3)), np.empty((count, 3))
    fate, surface = np.empty(count, np.int32), np.empty(count, np.int32)
    trace_rays(table, clip, np.ascontiguousarray(origins), np.ascontiguousarray(directions), points, after, fate,
               surface, None, 1)
    return points, after, fate


def _hits(table: SurfaceTable, at: np.ndarray, directions: np.ndarray, z: float) -> np.ndarray:
    """Where rays from (at, z) meet the last surface of a table, (n, 2); NaN for those that do not."""
    points, _, fate = _traced(table, np.column_stack([at, np.full(len(at), z)]), directions, False)
    return np.where((fate == 0)[:, None], points[:, :2], np.nan)
