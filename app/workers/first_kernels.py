"""Kernels of a first picture, known before it asks for them: at the first start all compilers begin at once.

A picture asks for a kernel where it comes to it, one after the other. The list here is that of a camera with a lens of
rotational symmetry, longest compilations first, and of any scene; other lenses and cameras ask for the rest of theirs.

Cache warm-up of the kernels that the panels use, before the first panel is drawn.

Compiling takes seconds at the very first start: call `prepare` from a thread of its own, and draw the panels when it
is done.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numba import boolean, float32, float64, int64, types, uint32

from lensbench.app.bench.build import prescription, setup
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.plots.blur import curves, plot_range
from lensbench.app.plots.exit_pupil import box_samples
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.plots.section import sketch
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.settings import Settings
from lensbench.core.cameras import pupil_footprint, ray_generation
from lensbench.core.imaging import film
from lensbench.core.kernels import program, sampling, tile_order
from lensbench.core.kernels.cache import is_compiled
from lensbench.core.kernels.program import Code, stage_signature
from lensbench.core.optics import axial_bundle, block_trace as clearance, surfaces
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.pupils import irregular_regions, radial_sampler, radial_sampler as equal_areas, rim_solver


def prepare(settings: Settings) -> None:
    """Compute once what every panel shows of these settings; the panels show the errors."""
    try:
        got = readings(settings)
        sketch(settings)
        curves(settings.optics, *plot_range(got)[:2])
        built = setup(settings)
        box_samples(built.lens, built.film_distance, 0.0)
        pixel_readings(settings, (0.5 * settings.film.pixels_x, 0.5 * settings.film.pixels_y))
    except (ValueError, OSError):
        return


TRACED = ("auto", "trace", "polynomial")        # lens models whose first picture needs the pupil of the lens


def missing_kernels(settings: Settings) -> list[tuple[Any, Any]]:
    """Kernels and signatures that the first picture of the settings needs and that are compiled nowhere yet.

    ValueError or OSError for a lens or a scene that cannot be read.
    """
    return [(kernel, signature) for kernel, signature in dict.fromkeys(_wanted(settings))
            if not is_compiled(kernel, signature)]


def _wanted(settings: Settings) -> Iterator[tuple[Any, Any]]:
    """Kernels of a first picture with their signatures: first those that set up the lens, then those of its passes."""
    single = stage_signature(np.float32)
    line, table, numbers = float64[::1], float64[:, ::1], float32[:, ::1]
    code = _code(float32)
    if settings.has_lens and settings.lens_model in TRACED and (
            lens := prescription(settings)).is_rotationally_symmetric:
        rows = types.NamedTuple((int64[::1], boolean[::1], table), surfaces.SurfaceTable)
        tracer = types.NamedTuple((_tracer(float64), _tracer(float32), float64), clearance.ClearanceTracer)
        yield axial_bundle.trace_bundles, (rows, line, line, float64[:, :, ::1], *[float64[:, :, :, ::1]] * 2, table)
        yield clearance.clearances, (line, line, line, line, line, float64, line, tracer, float64)
        yield rim_solver.rim_distances, (*[line] * 6, table, table, table, float64, float64, float64, table, tracer,
                                         float64)
        yield rim_solver._centres, (line, float64, *[line] * 5, tracer)
        yield radial_sampler.aim_radial, single
        yield surfaces._sags, (rows, line, line, line)
        yield equal_areas.equal_areas, (float64[:, :, ::1], int64)
        yield rim_solver._directions, (line, table, line, line, float64, table, table, table)
        for step in surface_steps(lens, 1.0):
            yield step.kernel, single
            yield step.kernel, stage_signature(np.float64)
        yield rim_solver.project_rear_rim, (line, line, line, float64)
        yield irregular_regions._search_boxes, (line, float64[:, :, ::1], int64)
        yield irregular_regions._contradictions, (table, table, boolean[:, :, ::1], line, float64[:, :, ::1])
        yield rim_solver._centroids, (line, table, line, line)
        yield film.film_from_raster, single
    scene = cached_scene(settings.scene)
    for step in reversed(scene.steps()):                # light and shadows, at the end, take longest
        yield step.kernel, single
    if scene.is_patterned or scene.is_rough:
        yield program._run, (numbers, int64[::1], numbers, int64[::1], float32[::1], code)
        yield ray_generation.pixel_spread, single
    if scene.is_rough:
        yield pupil_footprint.pupil_size, single
        yield pupil_footprint.pupil_part, single
    yield sampling.sample_pixels, single
    yield sampling.sample_lights, single
    yield program._expose, (numbers, float32[::1], code, int64, int64, int64[:, ::1], float32[::1], uint32,
                           int64)
    yield tile_order._unroll, (numbers, float32[::1], float32[:, :, ::1])


def _code(real: Any) -> Any:
    """Type of a `Code` with parameters of the type `real`."""
    return types.NamedTuple((int64[::1], boolean[::1], real[::1], int64[::1], int64[:, ::1]), Code)


def _tracer(real: Any) -> Any:
    """Type of the lane buffer, code and key of a `ClearanceTracer`."""
    return types.Tuple((real[::1], _code(real), uint32[::1]))
