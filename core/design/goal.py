"""The goal of an improvement: positions, fields and wavelengths that are judged, and what must not change.

Lengths in mm, angles in radians, wavelengths in µm, lens frame.
"""

from dataclasses import dataclass
from math import inf, isfinite, isinf

from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant


class MeritError(LensError):
    """A lens that cannot be judged or improved; the message states why."""


@dataclass(frozen=True)
class Position:
    """A zoom and focus position, and what is judged and held there.

    zoom, close: as for `Lens.at`, None for a lens without such positions. object_distance: object → first vertex (mm),
    or inf. fields: points of the object plane (mm), or angle vectors of the light from infinity (radians), the axis
    first; weights: of sum 1, that of the axis may be 0. held: `held_lengths` at the start, () holds nothing. floors:
    surface, and the least edge and centre thickness (mm) of the gap behind it.
    """

    zoom: float | None
    close: float | None
    object_distance: float
    fields: tuple[tuple[float, float], ...] = ()
    weights: tuple[float, ...] = ()
    held: tuple[float, ...] = ()
    floors: tuple[tuple[int, float, float], ...] = ()

    @property
    def words(self) -> str:
        """Such as "zoom 0.5, nearest focus"; "" for a lens with one position."""
        zoom = "" if self.zoom is None else f"zoom {significant(self.zoom, 3)}"
        return ", ".join(filter(None, (zoom, {0.0: "infinity", 1.0: "nearest focus"}.get(self.close or 0.0)
                                       if self.close is not None else "")))

    def of(self, lens: Lens) -> Lens:
        """The lens at this position."""
        return lens.at(self.zoom, self.close)


@dataclass(frozen=True)
class Goal:
    """What an improvement aims at, from `goal_of`.

    Args:
        positions: All of them count equally.
        wavelengths, weights: µm, and their weights of sum 1.
        primary: Index of the wavelength at which rays are aimed and lengths are held.
        aim: "spot" for the rms radius of the spots, "wavefront" for the rms wave error.
        hold_back_focus: Whether the back focus is held with focal length and f-number.
        judged: What is judged, in sentences.
        left_out: What is not judged, in sentences.
    """

    positions: tuple[Position, ...]
    wavelengths: tuple[float, ...]
    weights: tuple[float, ...]
    primary: int
    aim: str = "spot"
    hold_back_focus: bool = False
    judged: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def primary_wavelength(self) -> float:
        """The primary wavelength, µm."""
        return self.wavelengths[self.primary]


def held_lengths(lens: Lens, object_distance: float, wavelength: float, hold_back_focus: bool) -> tuple[float, ...]:
    """f-number, focal lengths of sections with power (mm) and, if asked, back focus (mm) at a position."""
    sections = [first_order(section, wavelength) for section in reversed(lens.sections)]
    lengths = [sections[0].f_number, *(fo.efl for fo in sections if isfinite(fo.efl))]
    return tuple([*lengths, image_distance(lens, object_distance, wavelength)] if hold_back_focus else lengths)


def image_distance(lens: Lens, object_distance: float, wavelength: float) -> float:
    """Last vertex → paraxial image (mm) of the axis point `object_distance` (mm) before the first vertex."""
    a, b, c, d = ray_matrix(lens, 0, len(lens.surfaces), wavelength)
    nearness = 0.0 if isinf(object_distance) else lens.front_index / object_distance
    height, slope = a + b * nearness, c + d * nearness
    return -lens.indices(wavelength)[-1] * height / slope if slope else inf


def edge_thickness(front: Surface, back: Surface) -> float:
    """Thickness (mm) of the gap between two surfaces: of glass between its edges, of air where it is thinnest there."""
    if front.glass.n_d > 1.0:
        return front.thickness + _sag(back, back.semi_diameter) - _sag(front, front.semi_diameter)
    height = min(front.semi_diameter, back.semi_diameter)
    return front.thickness + _sag(back, height) - _sag(front, height)


def _sag(surface: Surface, height: float) -> float:
    return float(surface.sag(0.0, height))
