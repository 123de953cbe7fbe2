"""Conditions of an analysis: fields, wavelengths and the object's distance, and where each of them comes from.

A lens file may state them (`Lens.system`). What it does not state is taken from the film and from the visible
spectrum, and a finding says so. mm, degrees and µm, as in `lensbench.core.optics.system`.

Two threads that the analyses share, so that a figure of milliseconds does not wait for threads to start.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from math import atan, atan2, hypot, inf, isinf, radians, tan
from typing import Any, TypeVar

import numpy as np

from lensbench.core.cameras.lens_settings import has_dispersion
from lensbench.core.imaging.film import Film
from lensbench.core.imaging.spectrum import PHOTOPIC, PICTURE, WHITES
from lensbench.core.kernels.pauses import due, pause
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE, GlassError
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import FieldKind
from lensbench.core.text import fixed, significant

VISIBLE = (F_LINE, D_LINE, C_LINE)      # µm; the primary is the middle one
LONGEST = 100.0         # µm; a larger number is one of nanometres
FIELDS = 12                             # from the film's centre to its corner
FULL_FRAME = (36.0, 24.0)               # mm, for a lens whose film is not known


@dataclass(frozen=True)
class Conditions:
    """Fields, wavelengths and object distance of an analysis, from `conditions`.

    Args:
        field_kind: Quantity in which `fields` are given.
        fields: tuple of (float, float). x and y of each field point: degrees, or mm on the object plane or on the film.
        wavelengths: µm.
        weights: Of the wavelengths, of sum 1.
        primary: Index of the wavelength whose chief rays are the references.
        object_distance: Object plane → first vertex, mm; inf for an object at infinity.
        findings: What is assumed or left out; ignored in comparisons.
    Raises:
        LensError: For wavelengths that are not positive micrometres, weights, fields or a primary wavelength that do
            not fit, and object heights of an object at infinity.
    """

    field_kind: FieldKind
    fields: tuple[tuple[float, float], ...]
    wavelengths: tuple[float, ...] = VISIBLE
    weights: tuple[float, ...] = (1.0 / 3.0,) * 3
    primary: int = 1
    object_distance: float = inf
    findings: tuple[Finding, ...] = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Conditions) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[Any, ...]:
        return (self.field_kind, self.fields, self.wavelengths, self.weights, self.primary, self.object_distance)

    def __post_init__(self) -> None:
        if not self.wavelengths or len(self.weights) != len(self.wavelengths):
            raise LensError("an analysis needs at least one wavelength, and a weight for each")
        for wavelength in self.wavelengths:
            check_wavelength(wavelength)
        if not 0 <= self.primary < len(self.wavelengths):
            raise LensError(f"primary wavelength {self.primary}: there are {len(self.wavelengths)}")
        if not sum(self.weights) > 0.0 or min(self.weights) < 0.0:
            raise LensError("the weights of the wavelengths must not be negative, and one must be positive")
        if not self.fields or not np.isfinite(np.array(self.fields)).all():
            raise LensError("an analysis needs at least one field point, of finite numbers")
        if not self.object_distance > 0.0:
            raise LensError(f"object distance {significant(self.object_distance)} mm: it must be positive, or inf")
        if self.field_kind is FieldKind.OBJECT_HEIGHT and isinf(self.object_distance):
            raise LensError("fields by object height need an object at a finite distance")

    @property
    def primary_wavelength(self) -> float:
        """The primary wavelength, µm."""
        return self.wavelengths[self.primary]


def conditions(lens: Lens, film: Film | None = None, fields: int | Sequence[Any] | None = None,
               wavelengths: str | Sequence[Any] | None = None, object_distance: float | None = None,
               field_kind: FieldKind = FieldKind.REAL_IMAGE_HEIGHT) -> Conditions:
    """The conditions under which a lens is analysed.

    Args:
        lens: The lens.
        film: Its half-diagonal is the last field, where the lens states none; None: `lens.film_size`, else 36 × 24 mm.
        fields: None, int or sequence. None: those that the lens states, else 12 from the film's centre to its corner. A
            number: that many along the film's half-diagonal. A sequence: y, or (x, y), of each in the quantity
            `field_kind`.
        wavelengths: None, str or sequence. µm, or (µm, weight); the middle one is the primary. A name of white light:
            "picture" weights wavelengths by the luminance that a picture gives them, "photopic" by that of the eye,
            "fdc" takes F, d and C with equal weights. "lens" or None: those that the lens states, else F, d and C.
        object_distance: Object plane → first vertex, mm. None: the one that the lens states, inf by default.
        field_kind: Of a sequence of fields: degrees for ANGLE, else mm.
    Returns:
        Its findings name the source of each part.
    Raises:
        LensError: For an invalid sequence, or a glass that is known at none of the wavelengths.
    """
    findings: list[Finding] = []
    if object_distance is None:
        object_distance = lens.system.object_distances[0]
        if not object_distance > 0.0:
            findings.append(note(Kind.ASSUMED, "the stated object distance is not in front of the lens: the object is "
                                               "taken at infinity", distance=object_distance))
            object_distance = inf
    kind, points = _fields(lens, film, fields, field_kind, object_distance, findings)
    colours, weights, primary = _colours(lens, wavelengths, findings)
    if colours != (D_LINE,):
        findings += unknown_dispersion(lens)
    return Conditions(kind, points, colours, weights, primary, object_distance, tuple(findings))


def white_light(lens: Lens, name: str) -> tuple[tuple[float, float], ...]:
    """Wavelengths (µm) and weights of one of WHITES for a lens, the middle one primary; () for those that it states.

    The picture of a lens whose dispersion is known at some wavelengths only is that of the d line alone. LensError for
    another name.
    """
    if name not in WHITES:
        raise LensError(f"white light {name!r}: choose one of {', '.join(WHITES)}, or give wavelengths in µm")
    if name == "picture" and not has_dispersion(lens):
        return ((D_LINE, 1.0),) if any(surface.glass.disperses for surface in lens.surfaces) else ()
    return {"picture": PICTURE, "photopic": PHOTOPIC, "fdc": tuple((line, 1.0) for line in VISIBLE), "lens": ()}[name]


def unknown_dispersion(lens: Lens) -> tuple[Finding, ...]:
    """A finding where glasses of a lens have one index at all wavelengths, for want of another."""
    glasses = [medium.glass for medium in lens.surfaces if medium.glass.n_d != 1.0 or medium.glass.disperses]
    unknown = sum(not medium.disperses for medium in glasses)
    if not unknown:
        return ()
    return (note(Kind.GLASS, "no dispersion data for this lens: all wavelengths take the same paths"
                 if unknown == len(glasses) else f"the dispersion of {unknown} of {len(glasses)} glasses is not known: "
                 "they have one index at all wavelengths", unknown=unknown),)


def check_wavelength(wavelength: float) -> None:
    """LensError for what is no wavelength in µm."""
    if not 0.0 < wavelength < inf:
        raise LensError("a wavelength must be a positive number of micrometres")
    if wavelength > LONGEST:
        raise LensError(f"wavelength {significant(wavelength)} µm: give it in micrometres, such as 0.55 for 550 nm")


def field_name(conditions: Conditions, i: int) -> str:
    """A field in words.

    Args:
        conditions: Conditions with the field.
        i: Index of the field.
    Returns:
        Such as "12.4 mm" or "14°".
    """
    x, y = (round(coordinate, 5) for coordinate in conditions.fields[i])
    unit = "°" if conditions.field_kind is FieldKind.ANGLE else " mm"
    return f"{significant(y, 4)}{unit}" if x == 0.0 else f"({significant(x, 4)}, {significant(y, 4)}){unit}"


def field_names(conditions: Conditions, which: np.ndarray) -> str:
    """Fields by their rising indices (n,), in words; more than three neighbours by the first and the last."""
    parts: list[str] = []
    for run in np.split(which, np.flatnonzero(np.diff(which) != 1) + 1):
        names = [field_name(conditions, int(i)) for i in run]
        parts += [f"{names[0]} to {names[-1]}"] if len(names) > 3 else names
    return ", ".join(parts)


def _fields(lens: Lens, film: Film | None, fields: int | Sequence[Any] | None, kind: FieldKind, object_distance: float,
            findings: list[Finding]) -> tuple[FieldKind, tuple[tuple[float, float], ...]]:
    if fields is None and lens.system.fields:
        if lens.system.field_kind is not FieldKind.OBJECT_HEIGHT or not isinf(object_distance):
            points = tuple((point.x, point.y) for point in lens.system.fields)
            findings.append(note(Kind.ASSUMED, f"fields as the lens states them: {len(points)} by "
                                               f"{lens.system.field_kind}", fields=len(points)))
            cut = sum(any(point.vignetting) for point in lens.system.fields)
            if cut:
                findings.append(note(
                    Kind.LEFT_OUT, f"the vignetting factors of {cut} of these fields are not applied: clear apertures "
                    "limit the light, as stated, or estimated from the factors", fields=cut))
            return lens.system.field_kind, points
        findings.append(note(Kind.ASSUMED, "the lens states object heights, but its object is at infinity here: "
                                           "fields over the film instead"))
    if fields is not None and not isinstance(fields, int | np.integer):
        if any(np.ndim(field) and len(field) != 2 for field in fields):
            raise LensError("a field point is one number, y, or two, (x, y)")
        points = tuple((0.0, float(field)) if np.ndim(field) == 0 else (float(field[0]), float(field[1]))
                       for field in fields)
        return kind, points
    count = FIELDS if fields is None else int(fields)
    if count < 1:
        raise LensError(f"{count} fields: at least 1 is needed")
    if film is not None:
        half, said = 0.5 * film.diagonal, "the film"
    elif lens.film_size is not None:
        half, said = 0.5 * hypot(*lens.film_size), "the film that the lens was made for"
    else:
        half, said = 0.5 * hypot(*FULL_FRAME), "a film of 36 × 24 mm, since none is stated"
    findings.append(note(Kind.ASSUMED, f"fields: {count} from the centre of {said} to its corner, "
                                       f"{fixed(half, 2)} mm", fields=count, radius=half))
    heights = np.linspace(0.0, half, count) if count > 1 else [0.0]
    return FieldKind.REAL_IMAGE_HEIGHT, tuple((0.0, float(height)) for height in heights)


def _colours(lens: Lens, wavelengths: str | Sequence[Any] | None, findings: list[Finding]
            ) -> tuple[tuple[float, ...], tuple[float, ...], int]:
    named = wavelengths if isinstance(wavelengths, str) else None
    if named is not None:
        wavelengths = white_light(lens, named) or None
    if wavelengths is not None:
        pairs = [(float(colour), 1.0) if np.ndim(colour) == 0 else (float(colour[0]), float(colour[1]))
                 for colour in wavelengths]
        primary, source = len(pairs) // 2, "given" if named is None else f"weighted {WHITES[named]}"
    elif lens.system.wavelengths:
        pairs = [(colour.micrometres, colour.weight) for colour in lens.system.wavelengths]
        primary, source = lens.system.primary, "as the lens states them"
    else:
        pairs, primary, source = [(line, 1.0) for line in VISIBLE], 1, "F, d and C with equal weights, since the " \
                                                                       "lens states none"
    if not pairs:
        raise LensError("an analysis needs at least one wavelength")
    if not all(weight >= 0.0 for _, weight in pairs):
        raise LensError("the weights of the wavelengths must not be negative, and one must be positive")
    known: list[tuple[float, float]] = []
    chief, why = 0, ""
    for i, (line, weight) in enumerate(pairs):
        try:
            lens.indices(line)
        except GlassError as error:
            why = why or str(error)
            findings.append(Finding(Kind.LEFT_OUT, None, f"wavelength {significant(1000.0 * line)} nm is left out: "
                                                         f"{error}", figures={"wavelength": line}))
            continue
        chief = len(known) if i <= primary else chief
        if weight > 0.0 or i == primary:
            known.append((line, weight))
    if not known:
        raise LensError(f"no wavelength is left to analyse: {why}")
    total = sum(weight for _, weight in known) or 1.0
    if wavelengths is None or named is not None:
        findings.append(note(Kind.ASSUMED, f"wavelengths {source}: "
                             + ", ".join(f"{significant(1000.0 * line, 4)}" for line, _ in known) + " nm"))
    return (tuple(line for line, _ in known), tuple(weight / total for _, weight in known),
            min(chief, len(known) - 1))


def wanted_chief_rays(lens: Lens, conditions: Conditions) -> tuple[np.ndarray, bool]:
    """What `find_chief_rays` takes for the fields of these conditions: its `wanted` (n, 2) and its `by_image`.

    Raises:
        LensError: For paraxial image heights of an afocal lens.
    """
    points = np.array(conditions.fields, float).reshape(-1, 2)
    if conditions.field_kind is FieldKind.REAL_IMAGE_HEIGHT:
        return points, True
    if conditions.field_kind is FieldKind.OBJECT_HEIGHT:
        return points, False
    if conditions.field_kind is FieldKind.ANGLE:
        angles = np.array([_angle_vector(x, y) for x, y in points])
        far = isinf(conditions.object_distance)
        return angles if far else _on_object(lens, conditions, np.tan(angles)), False
    fo = first_order(lens, conditions.primary_wavelength)
    if isinf(fo.efl):
        raise LensError("an afocal lens has no paraxial image heights")
    if isinf(conditions.object_distance):
        slopes = points / (lens.front_index * fo.efl)
        size = np.hypot(slopes[:, 0], slopes[:, 1])
        return slopes * np.where(size > 0.0, np.arctan(size) / np.where(size > 0.0, size, 1.0), 1.0)[:, None], False
    magnification = lens.front_index * fo.efl / (fo.ffl + conditions.object_distance)
    return -points / magnification, False


def _angle_vector(x: float, y: float) -> tuple[float, float]:
    """Angle vector (rad) of the field angles x and y (degrees), whose tangents are the slopes of the light."""
    x, y = radians(x), radians(y)
    if x == 0.0 or y == 0.0:
        return x, y
    across, up = tan(x), tan(y)
    size, azimuth = atan(hypot(across, up)), atan2(up, across)
    return size * float(np.cos(azimuth)), size * float(np.sin(azimuth))


def _on_object(lens: Lens, conditions: Conditions, slopes: np.ndarray) -> np.ndarray:
    """Points (n, 2) of the object plane from which light aims at the entrance pupil with these slopes (n, 2)."""
    pupil = first_order(lens, conditions.primary_wavelength).entrance_pupil.z
    return -slopes * (conditions.object_distance + (0.0 if isinf(pupil) else pupil))


THREADS = 2
PARTS = 8               # handed to the threads at most: each costs a twentieth of a millisecond
Item = TypeVar("Item")


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(THREADS, "lensbench analysis")


def each_in_turn(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Do the work of each item on the present thread, which may pause before each: of work that is soon done."""
    for item in items:
        pause()
        work(item)


def each_of(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Do the work of each item on the threads and wait for all; an error in one is raised. `work` must not call it.

    Where the present thread shall pause, what is not begun waits, and the threads are free for others.
    """
    left, paused = list(items), due()

    def do(share: list[Item]) -> list[Item]:
        for done, item in enumerate(share):
            if paused():
                return share[done:]
            work(item)
        return []

    while left:
        pause()
        parts = [left[i::PARTS] for i in range(min(PARTS, len(left)))]
        left = [item for unfinished in _pool().map(do, parts) for item in unfinished]
