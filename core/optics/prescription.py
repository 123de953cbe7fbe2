"""The prescription of a lens: its surfaces from the scene to the film, as frozen values, and their numbers by name.

Lengths in mm, curvatures in 1/mm, angles in radians, in the lens frame: the origin is the first vertex, and light
travels along +z.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite
from typing import Any

import numpy as np

from lensbench.core.lazy import called, hashed_once
from lensbench.core.optics.finding import Finding
from lensbench.core.optics.glass import AIR, D_LINE, Glass, GlassError
from lensbench.core.optics.iris import Iris, IrisError
from lensbench.core.optics.lens_surface import Frame, LensError, Surface, SurfacePose
from lensbench.core.optics.stop_image import StopImage
from lensbench.core.optics.surfaces import HIGHEST_POWER
from lensbench.core.optics.system import SystemData
from lensbench.core.optics.zoom_positions import Positions, PositionsError
from lensbench.core.text import significant


@hashed_once
@dataclass(frozen=True)
class Lens:
    """Surfaces 0 … from the scene to the film, with the stop and what is known of the lens.

    Args:
        surfaces: From the scene to the film, at the current positions; the last thickness is the stored back focus, or
            0.
        stop_index: Index of the surface that is the aperture stop.
        name, kind, source, notes: Its name; "double Gauss", "fisheye", …; the patent, book or design file; remarks.
        year: Of the publication.
        stated_efl: Focal length as published (mm).
        stated_f_number: f-number as published, wide open.
        positions: The gaps of a zoom, or of a lens that focuses by moving groups; `at` moves them.
        findings: What a reader assumed or found odd; ignored in comparisons.
        blades: Number of blades of the stop, 3 to 24, or 0 for a circle.
        blade_rotation: Radians, counter-clockwise as seen from behind the camera; at 0 a corner points up.
        roundness: Of the blades: 0 for straight ones to 1 for a circle.
        blade_reach: Distance of the blades' corners from the axis in units of the stop's radius, from 1; inf: behind
            the rim, as those of a lens that is wide open, whose stop is round. `stopped_down` closes them.
        stop_image: A picture in the stop, instead of blades; of lens files, those of the own format alone hold it.
        front_index: Index of the medium before the first surface: 1 for air, 1.33 for water.
        system: Aperture, fields, wavelengths and object distance that the lens was designed for.
        maker, designer, patent: Who sold it (else whose patent it is), who designed it, the patent's number; "" where
            not known.
        film_size: (2,) tuple of float or None. Width and height (mm) of the film or sensor that the lens was made for.
        estimates: What of the prescription is not published but estimated, such as "all rims"; "" for nothing.
    Raises:
        LensError: For no surface, or for an invalid stop, position, index or iris.
    """

    surfaces: tuple[Surface, ...]
    stop_index: int
    name: str = ""
    kind: str = ""
    year: int | None = None
    source: str = ""
    stated_efl: float | None = None
    stated_f_number: float | None = None
    notes: str = ""
    positions: Positions | None = None
    findings: tuple[Finding, ...] = field(default=(), compare=False)
    blades: int = 0
    blade_rotation: float = 0.0
    roundness: float = 0.0
    blade_reach: float = inf
    stop_image: StopImage | None = None
    front_index: float = 1.0
    system: SystemData = SystemData()
    maker: str = ""
    designer: str = ""
    patent: str = ""
    film_size: tuple[float, float] | None = None
    estimates: str = ""

    def __post_init__(self) -> None:
        if not self.surfaces:
            raise LensError("a lens needs at least one surface")
        if not 0 <= self.stop_index < len(self.surfaces):
            raise LensError(f"stop index {self.stop_index}: this lens has surfaces 0 to {len(self.surfaces) - 1}")
        if self.positions is not None and self.positions.gaps[-1] >= len(self.surfaces):
            raise LensError(f"the gap behind surface {self.positions.gaps[-1]} varies: this lens has surfaces 0 to "
                            f"{len(self.surfaces) - 1}")
        for i, surface in enumerate(self.surfaces):
            if surface.pose is not None and not 0 <= i - surface.pose.pivot < len(self.surfaces):
                raise LensError(f"surface {i} pivots about the vertex of surface {i - surface.pose.pivot}: this lens "
                                f"has surfaces 0 to {len(self.surfaces) - 1}")
        if not (isfinite(self.front_index) and 1.0 <= self.front_index <= 3.0):
            raise LensError(f"index {significant(self.front_index)} before the lens: it must lie between 1 (air) and 3")
        if self.film_size is not None and not all(0.0 < side < inf for side in self.film_size):
            raise LensError("film_size: width and height must be positive numbers")
        try:
            object.__setattr__(self, "blades", self.iris.blades)
        except IrisError as error:
            raise LensError(str(error)) from None

    @property
    def stop(self) -> Surface:
        """The aperture stop."""
        return self.surfaces[self.stop_index]

    @property
    def iris(self) -> Iris:
        """Shape of the stop, for a stop of radius 1."""
        return Iris(self.blades, self.blade_rotation, self.roundness, self.stop_image, self.blade_reach)

    @property
    def equivalent_stop_radius(self) -> float:
        """Radius (mm) of the circle that has the area of the stop's opening; the f-number refers to it (ISO 517)."""
        return self.stop.semi_diameter * self.iris.equivalent_radius

    @cached_property
    def with_round_stop(self) -> "Lens":
        """The lens with a round stop of as much area as its blades leave; they lie behind its rim."""
        if self.blade_reach == inf or self.iris.is_round:
            return self
        return replace(self.with_stop_radius(self.equivalent_stop_radius), blade_reach=inf)

    @cached_property
    def with_open_stop(self) -> "Lens":
        """The lens without a picture in its stop."""
        return self if self.stop_image is None else replace(self, stop_image=None)

    @cached_property
    def is_rotationally_symmetric(self) -> bool:
        """Whether no surface is a cylinder or toroid, tilted or decentred; blades do not count."""
        return self.is_centred and all(surface.is_rotationally_symmetric for surface in self.surfaces)

    @cached_property
    def is_centred(self) -> bool:
        """Whether no surface is decentred, tilted or rolled."""
        return all(surface.pose is None for surface in self.surfaces)

    @cached_property
    def is_mirror_symmetric(self) -> bool:
        """Whether every surface is its own mirror image left to right and upside down: a quadrant stands for all."""
        return all(surface.is_mirror_symmetric for surface in self.surfaces)

    @property
    def asymmetry(self) -> str:
        """What the lens has that keeps it from rotational symmetry, in words for a message; "" for nothing."""
        own = dict.fromkeys(surface.asymmetry for surface in self.surfaces if surface.asymmetry)
        return " and ".join([*own, *["a tilted or decentred surface"] * (not self.is_centred)])

    @cached_property
    def centred(self) -> "Lens":
        """The lens without its poses; of rolled cylinders and toroids see `Surface.centred`."""
        return self if self.is_centred else replace(self, surfaces=tuple(surface.centred for surface in self.surfaces))

    @cached_property
    def frames(self) -> tuple[Frame | None, ...]:
        """The motion that tilts and decentres each surface, the same for those that move as one; None if centred."""
        known: dict[tuple[SurfacePose, int], Frame] = {}
        frames: list[Frame | None] = []
        for i, surface in enumerate(self.surfaces):
            if surface.pose is None:
                frames.append(None)
                continue
            key = replace(surface.pose, pivot=0), i - surface.pose.pivot
            if key not in known:
                known[key] = Frame.of(surface.pose, self.vertices[key[1]])
            frames.append(known[key])
        return tuple(frames)

    def vertex(self, i: int) -> np.ndarray:
        """Position (3,) of the vertex of surface i, lens frame (mm)."""
        frame, z = self.frames[i], self.vertices[i]
        return np.array([0.0, 0.0, z]) if frame is None else frame.at(z)

    def in_frame_of(self, i: int, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the lens frame, mm, in the frame of surface i: its vertex is the origin, and +z its axis."""
        moved, frame = points - self.vertex(i), self.frames[i]
        return moved if frame is None else moved @ frame.rotation

    def mirrored(self, across: bool, up: bool) -> "Lens":
        """The lens mirrored across (along x), up (along y), or both; the iris stays. Itself if it is symmetric."""
        return self if self.is_mirror_symmetric else replace(
            self, surfaces=tuple(surface.mirrored(across, up) for surface in self.surfaces))

    @property
    def in_air(self) -> "Lens":
        """The lens with air before its first surface."""
        return self if self.front_index == 1.0 else replace(self, front_index=1.0)

    def section(self, axis: str) -> "Lens":
        """The centred lens that has the section x–z (axis "x") or y–z ("y") of this one; LensError for another axis.

        This lens itself if it is rotationally symmetric.
        """
        if axis not in ("x", "y"):
            raise LensError(f"section {axis!r}: it is 'x' for x–z or 'y' for y–z")
        return self if self.is_rotationally_symmetric else self._cut[axis == "y"]

    @cached_property
    def _cut(self) -> tuple["Lens", "Lens"]:
        """The lenses with the sections x–z and y–z of this one, centred."""
        x, y = (replace(self, surfaces=tuple(surface.section(axis) for surface in self.centred.surfaces))
                for axis in ("x", "y"))
        return x, y

    @property
    def sections(self) -> tuple["Lens", ...]:
        """The lenses of the sections x–z and y–z, centred; that of a lens without cylinder or toroid alone."""
        if self.centred.is_rotationally_symmetric:
            return (self.centred,)
        return self.section("x"), self.section("y")

    def _repr_html_(self) -> str:
        """Section and figures, for a notebook."""
        return called("app.notebook.cards", "lens_card", self)

    @cached_property
    def vertices(self) -> tuple[float, ...]:
        """Places z of the vertices (mm, lens frame): 0, then the running sum of the gaps."""
        z, places = 0.0, []
        for surface in self.surfaces:
            places.append(z)
            z += surface.thickness
        return tuple(places)

    @property
    def length(self) -> float:
        """First vertex → last vertex (mm)."""
        return self.vertices[-1]

    @cached_property
    def reference_wavelength(self) -> float:
        """The wavelength of first-order data (µm): the primary one of the lens file, by default the d line.

        The d line as well if a glass is not known at the primary one.
        """
        try:
            self.indices(self.system.primary_wavelength)
        except GlassError:
            return D_LINE
        return self.system.primary_wavelength

    def indices(self, wavelength: float = D_LINE) -> tuple[float, ...]:
        """Refractive indices of all media at a wavelength (µm): before the first surface, then behind each."""
        known = self.known.get(("indices", wavelength))
        if known is None:
            known = self.front_index, *(surface.glass.index(wavelength) for surface in self.surfaces)
            self.known["indices", wavelength] = known
        return known

    @cached_property
    def known(self) -> dict[tuple[str, float], Any]:
        """Results computed from this lens, by name and wavelength; valid because a lens never changes."""
        return {}

    def scaled(self, factor: float) -> "Lens":
        """The lens with all lengths multiplied by a factor, those of positions and system data too; LensError if not
        positive.
        """
        if not (isfinite(factor) and factor > 0.0):
            raise LensError(f"scale {significant(factor)}: it must be a positive number")
        return replace(self, surfaces=tuple(surface.scaled(factor) for surface in self.surfaces),
                       stated_efl=None if self.stated_efl is None else self.stated_efl * factor,
                       positions=None if self.positions is None else self.positions.scaled(factor),
                       system=self.system.scaled(factor))

    def with_stop_radius(self, radius: float) -> "Lens":
        """The lens with another radius (mm) of its stop, at its other positions in proportion."""
        surfaces = list(self.surfaces)
        surfaces[self.stop_index] = replace(self.stop, semi_diameter=radius)
        positions = self.positions and self.positions.with_stops(radius / self.stop.semi_diameter)
        return replace(self, surfaces=tuple(surfaces), positions=positions)

    @property
    def iris_turned(self) -> "Lens":
        """The lens with its stop alone turned by half a turn about y: blades and picture are mirrored along x."""
        return replace(self, blade_rotation=-self.blade_rotation or 0.0,
                       stop_image=self.stop_image and self.stop_image.from_behind)

    @property
    def zooms(self) -> bool:
        """Whether the lens has zoom stations."""
        return self.positions is not None and self.positions.zooms

    @property
    def has_focus_groups(self) -> bool:
        """Whether groups of the lens move to focus; other lenses are focused as a whole."""
        return self.positions is not None and self.positions.focuses

    def at(self, zoom: float | None = None, close: float | None = None) -> "Lens":
        """The lens with its groups moved; the varying gaps, a varying stop and the stated data follow.

        zoom: from 0, wide, to 1, tele. close: focus of a lens with focus groups, from 0, infinity, to 1, the nearest
        position. None leaves either. LensError beyond 0 to 1, or for a position other than 0 that the lens does not
        have.
        """
        for asked, has, what in ((zoom, self.zooms, "does not zoom: zoom must be 0"),
                                 (close, self.has_focus_groups, "has no focus groups and is focused as a whole: "
                                                                "close must be 0")):
            if asked and not has:
                raise LensError(f"this lens {what}")
        now = self.positions
        if now is None:
            return self
        try:
            now = now.at(now.zoom if zoom is None else zoom, now.close if close is None else close)
        except PositionsError as error:
            raise LensError(str(error)) from None
        surfaces = list(self.surfaces)
        for i, gap in zip(now.gaps, now.thickness_now, strict=True):
            surfaces[i] = replace(surfaces[i], thickness=gap)
        if (stop := now.stop_now) is not None:
            surfaces[self.stop_index] = replace(surfaces[self.stop_index], semi_diameter=stop)
        return replace(self, surfaces=tuple(surfaces), positions=now,
                       stated_efl=now.focal_length_now if now.focal_lengths else self.stated_efl,
                       stated_f_number=now.f_number_now if now.f_numbers else self.stated_f_number)


def front_medium(lens: Lens) -> Glass:
    """The medium before the first surface."""
    return AIR if lens.front_index == 1.0 else Glass(lens.front_index)


def medium_before(lens: Lens, surface: int) -> Glass:
    """The medium before a surface, numbered from 0; that behind the last one for the number of surfaces."""
    return lens.surfaces[surface - 1].glass if surface else front_medium(lens)


def refracts(lens: Lens, surface: int) -> bool:
    """Whether a surface bends light: the indices before and behind it differ, at some wavelength.

    The names of the media do not count. A stop in air, or within an element, bends nothing.
    """
    return _index_law(medium_before(lens, surface)) != _index_law(lens.surfaces[surface].glass)


def _index_law(glass: Glass) -> tuple[Any, ...]:
    """The numbers from which the index of a medium follows."""
    if glass.formula != "model":
        return glass.formula, glass.coefficients
    return glass.n_d, glass.v_d if glass.disperses else None


CURVATURE, CURVATURE_X, THICKNESS, SEMI_DIAMETER, CONIC = ("curvature", "curvature_x", "thickness", "semi_diameter",
                                                           "conic")
QUANTITIES = (CURVATURE, CURVATURE_X, THICKNESS, SEMI_DIAMETER, CONIC,
              *(f"r{power}" for power in range(2, HIGHEST_POWER + 1)))
WORDS = {CURVATURE: "radius", CURVATURE_X: "radius of the section x–z", THICKNESS: "thickness",
         SEMI_DIAMETER: "semi-diameter", CONIC: "conic constant"}
# Numbers of a tilted or decentred surface, which `poses` edits; no rule holds them
POSE = {"decentre_x": "decentre along x", "decentre_y": "decentre along y", "tilt_x": "tilt about x",
        "tilt_y": "tilt about y", "roll": "roll about its axis"}


def value_of(surface: Surface, quantity: str) -> float:
    """A number of a surface, one of QUANTITIES or of POSE: mm, 1/mm, radians or mm^(1 − p).

    `curvature_x` of a rotationally symmetric surface is its curvature.
    """
    if quantity == CURVATURE_X:
        return surface.curvature if surface.curvature_x is None else surface.curvature_x
    if quantity in POSE:
        return 0.0 if surface.pose is None else float(getattr(surface.pose, quantity))
    if quantity in WORDS:
        return float(getattr(surface, quantity))
    return dict(surface.aspheric).get(int(quantity[1:]), 0.0)


def with_value_of(surface: Surface, quantity: str, value: float) -> Surface:
    """The surface with another number, one of QUANTITIES, in the unit of `value_of`; LensError for an invalid one."""
    if quantity in WORDS:
        changed: dict[str, Any] = {quantity: value}
        return replace(surface, **changed)
    power = int(quantity[1:])
    return replace(surface, aspheric=(*((p, a) for p, a in surface.aspheric if p != power), (power, value)))


def with_surfaces(lens: Lens, changed: Sequence[tuple[int, Surface]]) -> Lens:
    """The lens with some surfaces, by their index, replaced."""
    surfaces = list(lens.surfaces)
    for i, surface in changed:
        surfaces[i] = surface
    return replace(lens, surfaces=tuple(surfaces))
