"""The plane of sharp focus of a tilted lens or film, its wedge of depth of field, and their lines.

Camera frame, mm. To first order a lens images planes into planes: that of the film into the plane of sharp focus. Both
meet in the Scheimpflug line, seen through the principal planes. Films parallel to this one have planes in focus that
meet in the hinge line, where the front focal plane meets the plane through the front principal point parallel to the
film. (Merklinger, Focusing the View Camera, 1996, ch. 3 and appendix.) Behind a lens without rotational symmetry the
planes are those of narrow traced beams. A film at the least blur of real rays counts as that of the paraxial image.

A beam of a film point has its focus where it is narrowest, in mean squares, as seen from where it leaves the lens:
between both foci of an astigmatic beam. Foci are given by their nearness, 1/mm, which passes through 0 where they go
beyond infinity.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.cameras.real_lens import LensCamera
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, trace
from lensbench.core.pupils.outline_solver import Aim
from lensbench.core.text import significant

BESIDE = 0.01           # of half the film's sides: from the axis to film points whose beams give a plane
FARTHEST = 1e-12        # 1/mm: a plane in focus farther than its inverse lies at infinity
PARALLEL = 1e-9         # radians between two planes
ACROSS = 1e-3                   # of the stop's radius: half the width of a narrow beam
NARROW = ACROSS * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
RAYS = 256                      # of a whole beam, over the open stop
BEYOND = 1.1                    # × the stop's radius: how far they reach, for images of the stop that are not linear
LEAST = 3                       # rays that have a focus


@dataclass(frozen=True)
class Line:
    """A line in space: a point (3,) in mm and a unit direction (3,), camera frame."""

    point: np.ndarray
    direction: np.ndarray


@dataclass(frozen=True)
class Plane:
    """A plane n · p = offset in the camera frame: unit normal (3,), n, towards the camera or up, and offset (mm)."""

    normal: np.ndarray
    offset: float

    @classmethod
    def facing(cls, normal: np.ndarray, offset: float) -> "Plane":
        """The plane normal · p = offset, for a normal (3,) of any length and sign."""
        size = float(np.linalg.norm(normal))
        sign = 1.0 if (normal[2] if abs(normal[2]) > 1e-9 * size else normal[1] or normal[0]) > 0.0 else -1.0
        return cls(sign * normal / size, sign * offset / size)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distances (n,) in mm of points (n, 3) from the plane, positive on the side of the normal."""
        return np.asarray(points, float) @ self.normal - self.offset

    def crossing(self, section: str) -> tuple[np.ndarray, np.ndarray]:
        """Where the plane crosses the section "yz" (x = 0) or "xz" (y = 0): a point (2,) and a unit direction (2,), mm,
        or NaN.

        Each is the coordinate across the axis and z.
        """
        axis = {"yz": 1, "xz": 0}[section]
        normal = np.array([self.normal[axis], self.normal[2]])
        size = float(normal @ normal)
        if size < 1e-24:
            return np.full(2, math.nan), np.full(2, math.nan)
        return normal * (self.offset / size), np.array([-normal[1], normal[0]]) / math.sqrt(size)


@dataclass(frozen=True)
class SharpFocus:
    """What is in focus behind a film in any pose, to first order.

    Args:
        plane: The plane of sharp focus; None where it lies at infinity.
        near, far: Limits of the wedge, whose points are blurred to the circle of confusion at the film's middle; None
            at infinity.
        hinge, scheimpflug: The two lines; None for planes in focus that are parallel. The Scheimpflug line is that in
            the front principal plane; None at infinity, and for a lens without rotational symmetry, which has no such
            plane.
    """

    plane: Plane | None
    near: Plane | None
    far: Plane | None
    hinge: Line | None
    scheimpflug: Line | None


@dataclass(frozen=True, eq=False)
class Beams:
    """Beams of film points: where each leaves the lens (n, 3), its unit direction (n, 3), nearness (n,) of its focus
    along it.

    across (n, 3, 3): mean squares and products of the rays' distances from the middle as they leave (mm²); mixed: of
    these, by rows, and the slopes of the rays against it, by columns (mm); slopes: of the slopes. NaN without light.
    """

    starts: np.ndarray
    directions: np.ndarray
    nearness: np.ndarray
    across: np.ndarray
    mixed: np.ndarray
    slopes: np.ndarray

    @property
    def foci(self) -> np.ndarray:
        """Foci (n, 4) in homogeneous coordinates."""
        return np.column_stack([self.starts * self.nearness[:, None] + self.directions, self.nearness])

    @property
    def depth_nearness(self) -> np.ndarray:
        """One over the distance (n,) from the film's plane, along the axis of the camera, to the foci."""
        x, y, z, w = self.foci.T
        return np.asarray(-w / z)


def beams(lens: Lens, film_distance: float, film: np.ndarray, whole: bool = False) -> Beams:
    """Beams of film points (n, 3), narrow about the ray through the middle of the stop, or of the whole open stop."""
    aim = Aim(lens, film_distance)
    centres, images = aim.stop_centres(film, aim.paraxial_centres(film))
    sides = _disc(RAYS) if whole else NARROW
    rear = centres[:, None] + sides @ images.transpose(0, 2, 1)
    back = lens.length + film_distance
    starts = np.repeat(film + [0.0, 0.0, back], len(sides), 0)
    ways = np.concatenate([rear, np.full((*rear.shape[:2], 1), lens.length)], 2).reshape(-1, 3) - starts
    sent = np.isfinite(ways).all(1)
    met = trace(lens, starts, np.where(sent[:, None], ways, [0.0, 0.0, -1.0]), clip=whole)
    passed = (sent & (met.fate == Fate.PASSED)).reshape(len(film), len(sides), 1)
    passed = passed & (passed.sum(1, keepdims=True) >= (LEAST if whole else len(sides)))
    points, directions = (np.where(passed, values.reshape(len(film), len(sides), 3), 0.0)
                          for values in (met.points, met.directions))

    # About the mean ray, at its distance t: a + t b, which looks narrowest at 1/t = −Σ a·b / Σ a·a
    with np.errstate(divide="ignore", invalid="ignore"):            # no ray
        count = passed.sum(1)
        start, along = points.sum(1) / count, directions.sum(1)
        along /= np.linalg.norm(along, axis=1)[:, None]
        cosines = (directions * along[:, None]).sum(2, keepdims=True)
        a = points - start[:, None]
        a = a - directions * ((a * along[:, None]).sum(2, keepdims=True) / cosines)
        b = directions / cosines
        a, b = (np.where(passed, values - np.where(passed, values, 0.0).sum(1, keepdims=True) / count[:, None], 0.0)
                for values in (a, b))
        across, mixed, slopes = (np.einsum("nri,nrj->nij", one, two) / count[..., None]
                                 for one, two in ((a, a), (a, b), (b, b)))
        nearness = -np.trace(mixed, axis1=1, axis2=2) / np.trace(across, axis1=1, axis2=2)
    return Beams(start - [0.0, 0.0, back], along, nearness, across, mixed, slopes)


def focused_plane(lens: Lens, film_distance: float, film: np.ndarray) -> np.ndarray | None:
    """Plane (4,) with normal · p + last number = 0 that is in focus on the plane of film points (n, 3).

    Fitted to the foci in homogeneous coordinates, where it may lie at infinity. None where a film point sees no ray.
    """
    foci = beams(lens, film_distance, film).foci
    if not np.isfinite(foci).all():
        return None
    foci /= np.linalg.norm(foci, axis=1)[:, None]
    return np.asarray(np.linalg.svd(foci)[2][-1])


def _disc(count: int) -> np.ndarray:
    """Points (count, 2) over a disc of the stop, evenly: the spiral of the golden angle."""
    k = np.arange(count)
    radius, angle = BEYOND * np.sqrt((k + 0.5) / count), k * np.pi * (3.0 - np.sqrt(5.0))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def sharp_focus(camera: LensCamera, circle: float) -> SharpFocus:
    """The plane of sharp focus of a camera, its wedge and its lines.

    Args:
        camera: Of any model, its film in any pose; its lens is focused and stopped down. Before a window into a medium
            of another index, the planes and the hinge line are those beyond it, near the axis; the Scheimpflug line is
            not, for it lies in the lens.
        circle: Largest diameter (mm) of a blur that counts as sharp.
    Raises:
        CameraError: A circle that is not positive, or an afocal lens.
    """
    if not (math.isfinite(circle) and circle > 0.0):
        raise CameraError(f"circle of confusion {significant(circle)} mm: it must be positive")
    if not math.isfinite(first_order(camera.lens, D_LINE).efl):
        raise CameraError("the lens is afocal: it has no plane of sharp focus")
    focus = _before_window(camera, circle)
    if not camera.has_port:
        return focus
    port = camera.flat_port
    sharp, near, far = (None if plane is None else _beyond(plane, port)
                        for plane in (focus.plane, focus.near, focus.far))
    hinge = focus.hinge
    if hinge is not None:
        point, way = hinge.point.copy(), hinge.direction * [1.0, 1.0, port.index]
        point[2] = -port.true(-point[2])
        hinge = Line(point, way / np.linalg.norm(way))
    return SharpFocus(sharp, near, far, hinge, focus.scheimpflug)


def _beyond(plane: Plane, port: FlatPort) -> Plane:
    """The plane that a camera sees as this one through its window; near the axis, z alone changes."""
    x, y, z = plane.normal
    return Plane.facing(np.array([x, y, z / port.index]),
                        plane.offset + z * (port.index - 1.0) * port.window / port.index)


def _before_window(camera: LensCamera, circle: float) -> SharpFocus:
    """What is in focus in air."""
    lens = camera.lens
    fo = first_order(lens, D_LINE)
    last = -camera.film_distance
    front, rear = last - lens.length + fo.front_principal, last + fo.rear_principal         # principal planes
    a, b, g = camera.film_pose.axes[2]
    n = lens.front_index
    start, unit = float(camera.film_pose.centre @ camera.film_pose.axes[2]) - g * rear, 1.0
    if camera.focus_method != "paraxial" and camera.film_at is None and camera.follows_rays:
        # The film is where real rays meet; where paraxial ones of the same object would do, these planes belong
        before = camera.focus_distance + front
        image, unit = (fo.efl, 1.0) if math.isinf(before) else (before * fo.efl, before - n * fo.efl)
        start = start * unit + g * (image + rear * unit)            # over unit, 0 for an object at the front focus

    # The film a x + b y + g v = e / unit, v behind the rear principal plane, is the image of this plane (x, y, u), u
    # before the front one: by 1/v = 1/f − n/u and x′ / v = −n x / u
    def imaged(e: float) -> Plane | None:
        along = g * unit - e / fo.efl
        normal = np.array([-n * a * unit, -n * b * unit, -along])   # u = front − z
        offset = -e * n - along * front
        size = float(np.linalg.norm(normal))
        return None if size * abs(fo.efl) < 1e-12 * abs(e) else Plane.facing(normal, offset)

    # The film's middle may move along the axis by so much before a point becomes the circle
    if math.isfinite(fo.exit_pupil.z):
        diameter = 2.0 * fo.exit_pupil.radius * lens.iris.equivalent_radius
        cone = diameter / abs(camera.film_distance + lens.length - fo.exit_pupil.z)
    else:
        cone = 1.0 / fo.f_number                  # telecentric: the slope is the stop's radius over f
    depth = circle / cone if cone > 0.0 else math.inf
    if not lens.is_rotationally_symmetric:
        return _traced(camera, depth)
    planes = [imaged(start + g * unit * shift) for shift in (0.0, depth, -depth)]
    if not camera.film_pose.is_tilted:
        return SharpFocus(planes[0], planes[1], planes[2], None, None)
    tilted, across = np.array([a, b]) / math.hypot(a, b), np.array([-b, a, 0.0]) / math.hypot(a, b)
    aside = tilted * (g * fo.efl / math.hypot(a, b))                # n u = f: n (a x + b y) = g u
    hinge = Line(np.array([*aside, front - n * fo.efl]), across)
    meeting = None if unit == 0.0 else tilted * (start / unit / math.hypot(a, b))
    return SharpFocus(planes[0], planes[1], planes[2], hinge,
                      None if meeting is None else Line(np.array([*meeting, front]), across))


def _traced(camera: LensCamera, depth: float) -> SharpFocus:
    """What is in focus behind a lens without rotational symmetry; depth: of the film's middle along the axis, mm."""
    pose = replace(camera.film_pose, radius=math.inf)
    on_axis = pose.film_points(np.zeros((1, 2)), np.zeros((1, 2)))
    beside = BESIDE * 0.5 * np.array([camera.film.width, camera.film.height])
    film = pose.points(on_axis + beside * [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])

    def imaged(shift: float) -> Plane | None:
        image = focused_plane(camera.lens, camera.film_distance, film + [0.0, 0.0, shift])
        if image is None or np.linalg.norm(image[:3]) < FARTHEST * abs(image[3]):
            return None
        return Plane.facing(image[:3], -float(image[3]))

    sharp, near, far = (imaged(shift) for shift in (0.0, depth, -depth))
    hinge = None
    if near is not None and far is not None:
        along = np.cross(near.normal, far.normal)
        if np.linalg.norm(along) > PARALLEL:
            offsets = np.array([near.offset, far.offset])
            point = np.linalg.lstsq(np.stack([near.normal, far.normal]), offsets, rcond=None)[0]
            across = float(along[:2] @ along[:2])       # the point of the line that is nearest to the axis
            t = -float(point[:2] @ along[:2]) / across if across > 0.0 else 0.0
            hinge = Line(point + t * along, along / np.linalg.norm(along))
    return SharpFocus(sharp, near, far, hinge, None)
