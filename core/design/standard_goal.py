"""The goal that follows from a lens: what its file states is judged, and its lengths are held.

Lengths in mm, angles in radians, wavelengths in µm, lens frame.
"""

from dataclasses import replace
from math import degrees, hypot, inf, isfinite, isinf

import numpy as np

from lensbench.core.analysis.grids.chief_rays import ChiefRays, find_chief_rays
from lensbench.core.analysis.grids.field_conditions import FULL_FRAME, Conditions, conditions, wanted_chief_rays
from lensbench.core.design.goal import Goal, MeritError, Position, edge_thickness, held_lengths, image_distance
from lensbench.core.design.merit import DENSE, LEAST, Merit
from lensbench.core.optics.focus import film_distance, nearest_focus
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant

SHARES = (0.0, 0.7, 1.0)        # of the image height, where the lens states no fields
WIDEST = 1.5                    # radians: the largest field angle that rays are aimed at
HEIGHTS = 32                    # image heights among which the edge of a smaller image circle is searched
FAR = 1e8                       # mm: an object beyond it is at infinity
THINNEST_EDGE, THINNEST_CENTRE = 0.5, 0.8       # mm of glass, unless the start is thinner
AIMS = ("spot", "wavefront")


def goal_of(lens: Lens, image_height: float | None = None, aim: str = "spot", hold_back_focus: bool = False,
            edge: float | None = None, centre: float | None = None) -> Goal:
    """The goal that keeps focal length, f-number and thinnest edges of a lens at all of its positions.

    Args:
        lens: Its surfaces neither decentred nor tilted.
        image_height: Largest image height (mm): the axis, 0.7 and 1 of it are judged, of a lens with a cylinder or
            toroid along x and in the corner too. None: the fields that the lens states, else up to half the diagonal of
            its film.
        aim: "spot" or "wavefront".
        hold_back_focus: Whether to hold the distance from the last vertex to the paraxial image too.
        edge, centre: Least thickness (mm) of elements at their edge and at their centre; None: 0.5 and 0.8, or as thin
            as the lens is. Air gaps become no thinner than 0, or than they are.
    Raises:
        LensError: For a lens that forms no image or passes no light, an unknown aim, or an image height that is not
            positive.
    """
    if aim not in AIMS:
        raise MeritError(f"aim {aim!r}: choose one of {', '.join(AIMS)}")
    if not lens.is_centred:
        raise MeritError("decentred and tilted surfaces cannot be judged: set their decentres and tilts to 0")
    if image_height is not None and not 0.0 <= image_height < inf:
        raise MeritError(f"image height {significant(image_height)} mm: it must be a length from 0 mm")
    design = conditions(lens, fields=None if image_height is None else 1)
    stated = image_height is None and bool(lens.system.fields)
    judged = [finding.message for finding in design.findings if stated or not finding.message.startswith("fields")]
    if not any(surface.glass.disperses for surface in lens.surfaces):       # all wavelengths take the same paths
        design = replace(design, wavelengths=(design.primary_wavelength,), weights=(1.0,), primary=0)
    heights, weights = None, None
    if stated:
        weights = np.array([point.weight for point in lens.system.fields])
    else:
        shares = [(0.0, share) for share in SHARES]
        if not lens.is_rotationally_symmetric:
            shares += [(0.7, 0.0), (1.0, 0.0), (0.7, 0.7)]
        if image_height is None:
            image_height = 0.5 * hypot(*(lens.film_size or FULL_FRAME))
        heights = image_height * np.array(shares if image_height > 0.0 else shares[:1])
    left_out: list[str] = []
    positions: list[Position] = []
    for position in _stations(lens):
        moved, distance = position.of(lens), position.object_distance
        fo = first_order(moved, design.primary_wavelength)
        if not 0.0 < fo.efl < inf:
            raise MeritError("the lens forms no image: it cannot be improved before it does")
        if not isfinite(fo.entrance_pupil.z):
            raise MeritError("the lens is telecentric towards the scene: it cannot be judged")
        chief = _chief_rays(moved, replace(design, object_distance=distance), heights, left_out, position.words)
        heights = chief.images if heights is None else heights
        fields, shared = _fields(chief, distance, weights)
        positions.append(replace(
            position, fields=fields, weights=shared, floors=_floors(moved, edge, centre, varying=bool(positions)),
            held=held_lengths(moved, distance, design.primary_wavelength, hold_back_focus)))
    if not stated and heights is not None:
        judged.insert(0, "fields: image heights " + ", ".join(dict.fromkeys(
            significant(hypot(x, y), 3) for x, y in heights)) + " mm")
    if len(positions) > 1:
        judged.insert(0, f"positions: {len(positions)}, of zoom and focus")
    goal = Goal(tuple(positions), design.wavelengths, design.weights, design.primary, aim, hold_back_focus,
                tuple(judged))
    return replace(goal, positions=_lit(lens, goal, left_out), left_out=tuple(dict.fromkeys(left_out)))


def _stations(lens: Lens) -> list[Position]:
    """The positions without their fields: all zoom stations, each at infinity and at the nearest focus."""
    stations: list[Position] = []
    stated = lens.system.object_distances
    for i, zoom in enumerate(lens.positions.zoom_stations if lens.positions and lens.zooms else (None,)):
        distance = stated[min(i, len(stated) - 1)]
        close = 0.0 if lens.has_focus_groups else None
        stations.append(Position(zoom, close, distance if 0.0 < distance < FAR else inf))
        if lens.has_focus_groups:
            moved = lens.at(zoom=zoom)
            nearest = nearest_focus(moved)
            if nearest < FAR:
                before = nearest - moved.at(close=1.0).length - film_distance(moved, nearest)
                stations.append(Position(zoom, 1.0, before))
    return stations


def _chief_rays(lens: Lens, design: Conditions, heights: np.ndarray | None, left_out: list[str],
                where: str) -> ChiefRays:
    """The chief rays of image heights (n, 2), or of the stated fields; those beyond the image circle from its edge."""
    distance, wavelength = design.object_distance, design.primary_wavelength
    film = image_distance(lens, distance, wavelength)
    if heights is None:
        aims, by_image = wanted_chief_rays(lens, design)
    else:
        aims, by_image = heights, True

    def find(aims: np.ndarray) -> ChiefRays:
        return find_chief_rays(lens, film, aims, distance, by_image, wavelength)

    def judged(chief: ChiefRays) -> np.ndarray:
        return np.hypot(*chief.angles.T) < WIDEST           # NaN is not

    aims = np.array(aims, float)
    unit, where = "mm" if by_image or not isinf(distance) else "rad", f" at {where}" if where else ""
    for k in np.flatnonzero(~judged(find(aims))):
        nearer = aims[k] * np.linspace(1.0, 0.0, HEIGHTS, endpoint=False)[:, None]
        lit = np.flatnonzero(judged(find(nearer)))
        before, aims[k] = aims[k].copy(), nearer[lit[0]] if lit.size else 0.0
        left_out.append(f"Light ends at the field {significant(hypot(*aims[k]), 3)} {unit}{where}: judged there, not "
                        f"at {significant(hypot(*before), 3)} {unit}")
    return find(aims)


def _fields(chief: ChiefRays, distance: float,
            weights: np.ndarray | None) -> tuple[tuple[tuple[float, float], ...], tuple[float, ...]]:
    """Fields and weights of a position, with the axis in front."""
    fields = chief.angles
    if not isinf(distance):
        away = (-distance - chief.points[:, 2]) / chief.directions[:, 2]
        fields = chief.points[:, :2] + away[:, None] * chief.directions[:, :2]
    shares = np.ones(len(fields)) if weights is None or not weights.sum() else weights
    small = 1e-9 * max(1.0, float(np.abs(fields).max()))
    on_axis = (np.abs(fields) < small).all(1)
    share = np.append(shares[on_axis].sum(), shares[~on_axis]) / shares.sum()
    return ((0.0, 0.0), *((float(x), float(y)) for x, y in fields[~on_axis])), tuple(map(float, share))


def _lit(lens: Lens, goal: Goal, left_out: list[str]) -> tuple[Position, ...]:
    """The positions without the fields whose light does not arrive."""
    positions = []
    few, dense = Merit(lens, goal).used, Merit(lens, goal, DENSE).used
    for position, *masks in zip(goal.positions, few, dense, strict=True):
        lit = masks[0].any(1) & (masks[1].sum(1) >= LEAST)
        if not lit[0]:
            raise MeritError("hardly a ray passes this lens: open a clear aperture or move an element first")
        where = f" at {position.words}" if position.words else ""
        for field in np.array(position.fields)[~lit]:
            size = hypot(*field)
            said = f"{significant(degrees(size), 3)}°" if isinf(position.object_distance) else (
                f"{significant(size, 3)} mm on the object")
            left_out.append(f"No light arrives from the field {said}{where}: not judged")
        weights = np.where(lit, position.weights, 0.0)
        weights = weights / weights.sum() if weights.any() else np.where(np.arange(len(lit)) == 0, 1.0, 0.0)
        positions.append(replace(position, fields=tuple(np.array(position.fields)[lit].tolist()),
                                 weights=tuple(weights[lit].tolist())))
    return tuple(positions)


def _floors(lens: Lens, edge: float | None, centre: float | None,
            varying: bool) -> tuple[tuple[int, float, float], ...]:
    """Least edge and centre thickness of every gap, or of those alone that vary with the position."""
    floors = []
    for i, (front, back) in enumerate(zip(lens.surfaces, lens.surfaces[1:], strict=False)):
        if varying and not (lens.positions and i in lens.positions.gaps):
            continue
        glass = front.glass.n_d > 1.0
        now = edge_thickness(front, back)
        thin_edge = min(THINNEST_EDGE if glass else 0.0, now if isfinite(now) else inf)
        thin_centre = min(THINNEST_CENTRE if glass else 0.0, front.thickness)
        floors.append((i, edge if edge is not None and glass else thin_edge,
                       centre if centre is not None and glass else thin_centre))
    return tuple(floors)
