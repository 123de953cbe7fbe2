"""Plots of a lens as it is stopped down or focused, of the axis, and of the glass before a sensor and an adapter."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.plots.plot import (
    DASHED, DOTTED, SOLID, Axis, Curve, Figure, Plot, Table, light_limit, reach, wavelength_name
)
from lensbench.app.plots.query import Query, with_rims
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.aperture_curves import breathing, focus_shift, relative_illumination
from lensbench.core.analysis.axial_curves import chromatic_focal_shift, longitudinal_aberration
from lensbench.core.analysis.chief_ray_curves import field_curves
from lensbench.core.analysis.grids.traced_grid import RayGrid, close_foci, ray_grid
from lensbench.core.analysis.lens_defects import with_sensor_stack
from lensbench.core.analysis.transfer_function import mtf
from lensbench.core.optics.finding import Kind
from lensbench.core.text import f_number_text, fixed, significant, true_minus

FREQUENCY = 30.0                # lp/mm, at which the MTF chooses a focus
SLOWEST = 22.0
ROOM = 3.0                      # × the focus shift, to which the axis goes where the depth of focus is greater
DEEP = 30.0                     # part of the depth of focus beyond which a shift counts as none


def focus_shift_figure(query: Query, points: int, f_number: float | None = None) -> Figure:
    """Best focus on the axis against the f-number, from that of the query to f/22; LensError for an afocal lens.

    f_number: marked, where it is not that of the query.
    """
    widest = lb.f_number_at_infinity(query.bench.lens)
    stops = math.sqrt(2.0) ** (0.5 * np.arange(1 + max(2, math.ceil(4 * math.log2(max(SLOWEST / widest, 1.0))))))
    # The f-numbers are those at the primary wavelength of the design, whatever the light
    numbers = widest * stops
    shifts = focus_shift(query.lens, query.bench.film_distance, query.conditions(),
                        lb.f_number_at_infinity(query.lens) * stops, FREQUENCY, 2.0 * query.bench.film.pitch)
    most = 1000.0 * float(np.nanmax(np.abs([shifts.least_blur, shifts.best_mtf]), initial=0.0))
    deep = 1000.0 * float(shifts.depth[0])
    limit = reach([min(max(most, deep), max(ROOM * most, deep / DEEP))])
    curves = (Curve("least rms blur", numbers, 1000.0 * shifts.least_blur),
              Curve(f"highest MTF at {fixed(FREQUENCY, 0)} lp/mm", numbers, 1000.0 * shifts.best_mtf, "field0", DASHED),
              *(Curve("depth of focus" if sign > 0.0 else "", numbers,
                      1000.0 * (shifts.least_blur + sign * shifts.depth), "faint", DOTTED) for sign in (1.0, -1.0)),
              Curve("film", numbers[[0, -1]], np.zeros(2), "amber", weight=1.0))
    if f_number is not None and numbers[0] < f_number <= numbers[-1]:
        curves += (Curve.straight((f_number, f_number), (-limit, limit), dash=DASHED),)
    table = Table(("f-number", "least blur (mm)", "highest MTF (mm)", "depth of focus (mm)"), tuple(zip(
        numbers, shifts.least_blur, shifts.best_mtf, shifts.depth, strict=True)))
    said = f"depth of focus for a blur of {significant(1000.0 * shifts.limit, 2)} µm, two pixels"
    unknown = ", ".join(f_number_text(number) for number in numbers[np.isnan(shifts.best_mtf)].tolist())
    remarks = []
    if unknown:
        remarks.append(f"the MTF at {fixed(FREQUENCY, 0)} lp/mm has no maximum near the least blur at {unknown}")
    if deep > limit:
        remarks.append(f"the depth of focus at {f_number_text(float(numbers[0]))}, ± {significant(deep, 2)} µm, lies "
                       "beyond the plot")
    return Figure("Focus shift", ((Plot(Axis("f-number", numbers[0], numbers[-1], log=True),
                                        Axis("Focus (µm)", -limit, limit), curves,
                                        "Best focus behind the film"),),), table,
                  query.words(None, "axis", said), tuple(remarks))


def breathing_figure(query: Query, points: int) -> Figure:
    """Change of the field of view against the focus distance; FocusError for a lens that forms no image.

    The view ends at the film's corner, or at the edge of light of a smaller image circle.
    """
    query = query.lines
    film, height = query.bench.film, query.largest_height
    share = 2.0 * height / film.diagonal
    curve = breathing(query.lens, replace(film, width=share * film.width, height=share * film.height), None,
                      query.conditions().primary_wavelength, query.bench.lens)
    near = np.isfinite(curve.distances) & np.isfinite(curve.half_angles)
    metres, change = curve.distances[near] / 1000.0, curve.change[near]
    limit = reach(change, 1.0)
    table = Table(("focus distance (m)", "half field (deg)", "change of the view (%)", "focal length (mm)",
                   "magnification"), tuple(zip(curve.distances / 1000.0, np.degrees(curve.half_angles), curve.change,
                                               curve.focal_lengths, curve.magnifications, strict=True)))
    low, high = (float(metres.min()), float(metres.max())) if metres.size else (1.0, 2.0)
    return Figure("Breathing", ((Plot(Axis("Focus distance (m)", low, high, log=True),
                                      Axis("Field (%)", -limit, limit),
                                      (Curve("wider than at infinity", metres, change),
                                       Curve.straight((low, high), (0.0, 0.0), "grid"))),),), table,
                  f"{'corner of the film' if share == 1.0 else 'edge of light'}, {significant(height, 4)} mm · "
                  f"{query.primary_alone} · tangent of the half field",
                  tuple(map(str, curve.findings)))


def illumination_figure(query: Query, points: int) -> Figure:
    """Relative illumination over the film at four apertures, split wide open.

    LensError for a lens without rotational symmetry.
    """
    query = query.lines
    if query.lens.asymmetry:
        raise lb.LensError("relative illumination is a function of the image height alone for lenses with rotational "
                           f"symmetry: this one has {query.lens.asymmetry}")
    lights = relative_illumination(query.lens, query.bench.film_distance, query.bench.film, points=max(points, 9),
                                   wavelength=query.conditions().primary_wavelength)
    # The f-numbers are those at the primary wavelength of the design, whatever the light
    named = [(f_number_text(query.bench.f_number * math.sqrt(2.0)**k), light) for k, (_, light) in enumerate(lights)]
    first = named[0][1]
    curves = [Curve(name, light.radii, 100.0 * light.total, f"field{k - 1}" if k else "strong")
              for k, (name, light) in enumerate(named)]
    curves += [Curve(f"natural, {named[0][0]}", first.radii, 100.0 * first.natural, "dim", DASHED),
               Curve(f"vignetting, {named[0][0]}", first.radii, 100.0 * first.vignetting, "dim", DOTTED)]
    table = Table(("aperture", "film radius (mm)", "total", "natural", "vignetting"), tuple(
        (name, *row) for name, light in named
        for row in zip(light.radii, light.total, light.natural, light.vignetting, strict=True)))
    plot = Plot(Axis("Image height (mm)", 0.0, first.radii[-1]), Axis("Light (%)", 0.0, light_limit(first)),
                tuple(curves))
    return with_rims(query, Figure("Relative illumination", ((plot,),), table, query.words(None, query.primary_alone),
                                   query.open_stop))


def axial_figure(query: Query, points: int) -> Figure:
    """Where axial rays cross the axis against their height in the stop, and the paraxial focus against wavelength.

    points: heights in the stop. LensError for a lens with a cylinder or toroid, and one without a focus.
    """
    query = query.lines
    conditions, away = query.conditions(), query.bench.film_distance
    along = longitudinal_aberration(query.lens, away, conditions, max(points, 9))
    shift = chromatic_focal_shift(query.lens, away, conditions)
    limit = reach(np.concatenate([along.foci.ravel(), shift.foci]))
    curves = [Curve(wavelength_name(line), foci, along.heights, line)
              for line, foci in zip(conditions.wavelengths, along.foci, strict=True)]
    zero = Curve.straight((0.0, 0.0), (0.0, 1.0), "grid")
    colours = 1000.0 * shift.wavelengths
    rest = Curve.straight((0.0, 0.0), (colours[0], colours[-1]), "grid")
    focus = Axis("Focus (mm)", -limit, limit)
    table = Table(("wavelength (um)", "height in the stop", "focus behind the film (mm)"),
                  tuple((line, height, focus_z) for line, foci in zip(conditions.wavelengths, along.foci, strict=True)
                        for height, focus_z in zip(along.heights, foci, strict=True))
                  + tuple((line, 0.0, focus_z) for line, focus_z in zip(shift.wavelengths, shift.foci, strict=True)))
    return Figure("Longitudinal aberration and chromatic focal shift", ((
        Plot(focus, Axis("Height in the stop", 0.0, 1.0), (zero, *curves), "Longitudinal aberration",
             across=True),
        Plot(focus, Axis("Wavelength (nm)", colours[0], colours[-1]),
             (rest, Curve("paraxial focus", shift.foci, colours)),
             "Paraxial focus", across=True)),), table, query.words(None, "axis"),
        tuple(str(finding) for finding in conditions.findings if finding.kind in (Kind.GLASS, Kind.LEFT_OUT)))


FREQUENCIES = (10.0, 30.0)      # lp/mm
FIELDS = 13
TINTS = ("chart2", "chart0")
Foci = tuple[np.ndarray, np.ndarray, np.ndarray]        # image heights, sagittal and tangential foci (n,)


class Stack(NamedTuple):
    """Glass before the sensor: thickness (mm) and index; and by how much (mm) an adapter is too long."""

    thickness: float = 2.0
    refractive_index: float = 1.52
    adapter_error: float = 0.0


USUAL = Stack()


def stack_figure(query: Query, points: int, stack: Stack = USUAL) -> Figure:
    """Contrast and foci over the field behind a stack, those of the bare lens dim next to them.

    The lens is focused again paraxially for the stack, not for the adapter. LensError for a stack without room.
    """
    conditions = query.conditions(FIELDS)
    lens, away = with_sensor_stack(query.lens, query.bench.film_distance, *stack)
    bare = ray_grid(query.lens, query.bench.film_distance, conditions, points)
    behind = ray_grid(lens, away, conditions, points)
    contrast = [mtf(rays, FREQUENCIES).white_modulus for rays in (bare, behind)]
    if query.lens.is_rotationally_symmetric:
        curves = [field_curves(traced, film, conditions, 2 * points + 1)
                  for traced, film in ((query.lens, query.bench.film_distance), (lens, away))]
        primary = conditions.primary
        foci = [(traced.heights, traced.sagittal[:, primary], traced.tangential[:, primary]) for traced in curves]
    else:
        both = [(rays, close_foci(rays)[:, conditions.primary]) for rays in (bare, behind)]
        foci = [(rays.image_heights, pair[:, 0], pair[:, 1]) for rays, pair in both]
    plots = (_contrast(bare, *contrast), _foci(foci[0], foci[1], bare))
    words = query.words(behind, f"stack {significant(stack.thickness)} mm, index {significant(stack.refractive_index)}",
                        f"adapter {significant(stack.adapter_error, signed=True)} mm", "dim: without both",
                        "focused again for the stack alone")
    return with_rims(query, Figure("Sensor stack", (plots,), _table(bare, *contrast), true_minus(words),
                                   (*_infinity(query, stack), *query.remarks(behind))))


def _contrast(bare: RayGrid, without: np.ndarray, with_: np.ndarray) -> Plot:
    """The contrast (F, 2, K) without the stack and with it."""
    curves = []
    for k in range(len(FREQUENCIES)):
        curves += [Curve("bare", bare.image_heights, without[:, a, k], "faint", dash, 1.2)
                   for a, dash in ((0, SOLID), (1, DASHED))]
    for k, frequency in enumerate(FREQUENCIES):
        for a, dash in ((0, SOLID), (1, DASHED)):
            curves.append(Curve(f"{significant(frequency)} {'ST'[a]}", bare.image_heights, with_[:, a, k], TINTS[k],
                                dash))
    return Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(bare.image_heights))), Axis("Contrast", 0.0, 1.0),
                tuple(curves), "MTF")


def _foci(bare: Foci, behind: Foci, rays: RayGrid) -> Plot:
    """Image heights with sagittal and tangential foci (n,) without the stack and with it."""
    lit = rays.image_heights[rays.lit]
    end = 1.0001 * float(lit[-1]) if lit.size else math.inf
    curves, known = [], []
    for (heights, *both), name, tint, weight in ((bare, "bare", "faint", 1.2), (behind, "", "strong", 1.6)):
        for way, foci, dash in zip(("sagittal", "tangential"), both, (SOLID, DASHED), strict=True):
            shown = np.where(heights <= end, foci, np.nan)
            known.append(shown[np.isfinite(shown)])
            curves.append(Curve(name or way, heights, shown, tint, dash, weight))
    limit = reach(np.concatenate(known), 0.01)
    return Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(bare[0]))), Axis("Focus (mm)", -limit, limit),
                tuple(curves), "Foci behind the film")


def _infinity(query: Query, stack: Stack) -> tuple[str, ...]:
    """Where the lens is focused at its mark of infinity, on this adapter."""
    if stack.adapter_error == 0.0:
        return ()
    if stack.adapter_error < 0.0:
        return ("with this adapter the lens focuses beyond infinity at its mark: infinity is reached before it",)
    try:
        whole = replace(query.bench.lens.at(close=0.0), positions=None)
        reached = lb.focused_distance(whole, lb.film_distance(whole, math.inf) + stack.adapter_error)
    except lb.LensError:
        return ()
    return (f"with this adapter the lens does not reach infinity: its mark lies at {format_distance(float(reached))}",)


def _table(bare: RayGrid, without: np.ndarray, with_: np.ndarray) -> Table:
    head = ("field (mm)", "frequency (lp/mm)", "sagittal", "tangential", "sagittal bare", "tangential bare")
    return Table(head, lambda: ((height, frequency, *with_[f, :, k], *without[f, :, k])
                                for f, height in enumerate(bare.image_heights)
                                for k, frequency in enumerate(FREQUENCIES)))
