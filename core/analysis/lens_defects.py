"""What a lens meets that its design does not have: a ripple on a surface, glass in front of the sensor, an adapter.

Lengths in mm. A ripple, left by the tool that cut or moulded a surface, is a wave h/2 · (cos(2π r / p) − 1) in the
sag, of period p and height h from trough to crest. To first order, exact for nanometres, W changes by (n′ N′ − n N) ×
the ripple where a ray meets the surface, N and N′ its direction cosines along the axis before and behind it; the ray
lands at the slope of that change in the pupil (Welford, "Aberrations of Optical Systems", ch. 7).

A plane plate of thickness t and index n moves the image by t (1 − 1/n) away from the lens, which focusing undoes, and
adds spherical aberration, astigmatism and colour, wherever it stands (Smith, "Modern Optical Engineering", ch. 7).
"""

from dataclasses import replace
from math import cos, inf, pi

import numpy as np

from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.glass import D_LINE, Glass
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens, refracts
from lensbench.core.optics.scalar_trace import trace
from lensbench.core.text import significant

RESOLVED = 2.5          # points of the grid to a period, at the least


def rippled(rays: RayGrid, surface: int, period: float, height: float, phase: float = 0.0) -> RayGrid:
    """The rays of a grid through a lens with a ripple on one surface.

    Args:
        rays: From `ray_grid`; its points must resolve the rings, or a finding says so.
        surface: Index of the surface.
        period: Distance from ring to ring along the radius, mm.
        height: From trough to crest, mm; 50 nm is 5e-5.
        phase: Of the ripple on the axis, rad; 0 is a crest, towards +z. The vertex stays.
    Returns:
        With other `opd`, `offset_s` and `offset_t`. Rays end at the same rims.
    Raises:
        LensError: For another surface, one that refracts nothing, a period that is not positive, and a height that is
            negative.
    """
    lens, beams = rays.lens, rays.beams
    check_ripple_surface(lens, surface)
    if not 0.0 < period < inf:
        raise LensError(f"a ripple of period {significant(period)} mm: the period must be positive")
    if not 0.0 <= height < inf:
        raise LensError(f"a ripple {significant(height)} mm high: the height must be 0 or more")
    fields, points = len(rays.images), rays.opd.shape[-1]
    s, t = (np.ascontiguousarray(np.broadcast_to(coordinate, (fields, points, points))) for coordinate in
            (rays.pupil[:, 0, None, :], rays.pupil[:, 1, :, None]))
    places = beams.towards_scene(s, t)[0]
    keep = np.flatnonzero(np.isfinite(rays.opd).any(1).ravel())
    of_field = np.concatenate([keep // points**2, np.arange(fields)])
    along = np.concatenate([places.reshape(-1, 2)[keep], beams.across(
        beams.chief.points.T[:, :, None], beams.chief.directions.T[:, :, None])[:, 0]])
    known = np.isfinite(along).all(1)
    start = beams.starts(of_field, np.where(known[:, None], along, 0.0))
    origins = start[:3].T + [0.0, 0.0, lens.length + rays.film_distance]
    opd, offset_s, offset_t = rays.opd.copy(), rays.offset_s.copy(), rays.offset_t.copy()
    coarsest = inf
    for c, line in enumerate(rays.conditions.wavelengths):
        went = trace(lens, origins, start[3:6].T, line, clip=False, record=True, forward=True)
        assert went.paths is not None
        feet, indices = went.paths[:, surface + 1], lens.indices(line)
        incoming = start[3:6].T if surface == 0 else _unit(feet - went.paths[:, surface])
        outgoing = went.directions if surface == len(lens.surfaces) - 1 else _unit(went.paths[:, surface + 2] - feet)
        bend = indices[surface + 1] * outgoing[:, 2] - indices[surface] * incoming[:, 2]
        r = np.hypot(feet[:, 0], feet[:, 1])
        waves = 2.0 * pi * r / period + phase
        change = 0.5 * height * bend * (np.cos(waves) - cos(phase))
        by_r = -pi * height / period * bend * np.sin(waves) / np.where(r > 0.0, r, 1.0)     # over r, for d(r²) / 2
        grid = np.full((4, fields * points * points), np.nan)
        grid[:, keep] = (change[:len(keep)] - change[len(keep):][of_field[:len(keep)]], by_r[:len(keep)],
                         *feet[:len(keep), :2].T)
        made, by_r, x, y = grid.reshape(4, fields, points, points)
        cells = []
        for axis, offset, step in ((2, offset_s, rays.steps[:, 0]), (1, offset_t, rays.steps[:, 1])):
            dx, dy = np.gradient(x, axis=axis), np.gradient(y, axis=axis)
            offset[:, c] += np.nan_to_num(by_r * (x * dx + y * dy) / step[:, None, None])
            cells.append(np.hypot(dx, dy))
        opd[:, c] += np.nan_to_num(made)
        apart = np.fmax(*cells)[rays.passed[:, c]]
        if np.isfinite(apart).any():
            coarsest = min(coarsest, period / max(float(np.nanmax(apart)), 1e-30))
    findings = rays.findings
    if coarsest < RESOLVED:
        findings = (*findings, Finding(
            Kind.SAMPLING, surface, f"{points} points across the pupil do not resolve a ripple of {significant(period)}"
            " mm: its rings are not shown as they are", figures={"points a period": coarsest}))
    return replace(rays, opd=opd, offset_s=offset_s, offset_t=offset_t, findings=findings)


def check_ripple_surface(lens: Lens, surface: float) -> None:
    """LensError for a number of a surface, from 0, that the lens does not have, or of one that refracts nothing."""
    if surface not in range(len(lens.surfaces)):
        raise LensError(f"ripple: there is no surface {significant(surface)}: they are numbered from 0 to "
                        f"{len(lens.surfaces) - 1}")
    if not refracts(lens, int(surface)):
        what = "the aperture stop" if surface == lens.stop_index else "a surface"
        raise LensError(f"ripple: surface {significant(surface)} is {what} between equal media, where a ripple has no "
                        "effect: choose a surface of a glass")


def _unit(vectors: np.ndarray) -> np.ndarray:
    """The vectors (n, 3) with length 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


CROWN = 64.0            # Abbe number of the plate
RIM = 3.0               # semi-diameter of the plate, × what a ray at 45° from the last rim needs: it ends no light


def with_sensor_stack(lens: Lens, film_distance: float, thickness: float, index: float | Glass = 1.52,
                      adapter_error: float = 0.0, refocused: bool = True) -> tuple[Lens, float]:
    """The lens with a plane plate before its film, and its film distance.

    Args:
        lens: The lens, focused; in air behind.
        film_distance: Last vertex → film, mm.
        thickness: Of the plate, mm; 0 for none.
        index: Of the plate. A number gets the dispersion of crown glass (V_d 64) if any glass of the lens has a known
            one.
        adapter_error: By which an adapter holds the lens too far from the film, mm; negative: too near.
        refocused: Whether the film follows the shift of the plate, as after focusing.
    Returns:
        (Lens, float). The lens with two plane surfaces more, without focus and zoom positions, and the distance from
            the plate to the film, mm.
    Raises:
        LensError: For a negative thickness, an index below 1, a lens that does not end in air, and where plate and
            adapter leave no room before the film.
    """
    if not 0.0 <= thickness < inf:
        raise LensError(f"a stack {significant(thickness)} mm thick: the thickness must be 0 or more")
    glass = index if isinstance(index, Glass) else _glass(lens, index)
    if lens.indices()[-1] != 1.0:
        raise LensError("this lens ends in glass: a stack needs air before it")
    if not -inf < adapter_error < inf:
        raise LensError(f"an adapter error of {significant(adapter_error)} mm: it must be a finite length")
    n = glass.index(D_LINE)
    shift = thickness * (1.0 - 1.0 / n) if refocused else 0.0
    air = film_distance + adapter_error + shift - thickness             # before and behind the plate
    if not air > 0.0:
        raise LensError(f"no room for a stack of {significant(thickness)} mm: the film lies "
                        f"{significant(film_distance + adapter_error, 3)} mm behind the last vertex: choose "
                        "thinner glass")
    if thickness == 0.0:
        return lens, film_distance + adapter_error
    *before, last = lens.surfaces
    half = 0.5 * air
    rim = RIM * (last.semi_diameter + air + thickness)
    plate = Surface(thickness, rim, glass, curvature=0.0), Surface(0.0, rim, curvature=0.0)
    return replace(lens, surfaces=(*before, replace(last, thickness=half), *plate), positions=None), half


def _glass(lens: Lens, index: float) -> Glass:
    """The plate of an index, with dispersion for a lens that has some."""
    if not 1.0 <= index < inf:
        raise LensError(f"a stack of index {significant(index)}: the index must be 1 or more")
    return Glass(index, CROWN if any(surface.glass.disperses for surface in lens.surfaces) and index > 1.0 else None)
