"""Tracers of other programs, if installed: rayoptics, Optiland and batoid on the same lens and the same rays.

Optiland and rayoptics open files written by lensbench; the surfaces of batoid are built one by one. Rays come from the
scene, at the d line, and ignore the rims; mm, lens frame. Each program gives the points on the last surface.
"""

import tempfile
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.curves import Mark
from lensbench.app.studies.charts.truth import Truth
from lensbench.app.studies.timing import time_in_turn

BEFORE = 50.0                   # mm from the origins of the rays to the first vertex
RAYS, FEW = 2000, 50            # rayoptics traces one ray at a time
SECONDS = 0.3                   # s: for the timing of each
Run = Callable[[np.ndarray, np.ndarray], np.ndarray]


def through_optiland(lens: lb.Lens, folder: Path) -> Run:
    """A function of origins and directions (n, 3) that returns the points (n, 3) on the last surface, by Optiland."""
    import optiland.fileio
    from optiland.rays import RealRays

    lenses.save(lens, folder / "lens.json")
    surfaces = optiland.fileio.load_optiland_file(str(folder / "lens.json")).surfaces.surfaces[1:-1]
    for surface in surfaces:
        surface.aperture = None

    def run(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        rays = RealRays(*origins.T, *directions.T, np.ones(len(origins)), np.full(len(origins), lb.D_LINE))
        for surface in surfaces:
            surface.trace(rays)
        return np.column_stack([rays.x, rays.y, rays.z])
    return run


def through_rayoptics(lens: lb.Lens, folder: Path) -> Run:
    """The same by rayoptics; rays begin on the plane BEFORE the first vertex."""
    import rayoptics.gui.appcmds
    from rayoptics.raytr.raytrace import trace_raw

    lenses.save(lens, folder / "lens.roa")
    model = rayoptics.gui.appcmds.open_model(folder / "lens.roa")
    model["seq_model"].gaps[0].thi = BEFORE
    model.update_model()
    line = model["optical_spec"]["wvls"].wavelengths[1]
    path = list(model["seq_model"].path(line))

    def run(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        points = [trace_raw(iter(path), np.array([x, y, 0.0]), way, line)[0][-2][0]
                 for (x, y, _), way in zip(origins, directions, strict=True)]
        return np.array(points) + [0.0, 0.0, lens.length]
    return run


def through_batoid(lens: lb.Lens, _: Path) -> Run:
    """The same by batoid; LensError for a surface that batoid lacks."""
    import batoid

    if not all(batoid_has(surface) for surface in lens.surfaces):
        raise lb.LensError("batoid 0.9 lacks a surface type of this lens")
    items, before = [], 1.0
    shape: Any
    for i, (surface, z) in enumerate(zip(lens.surfaces, lens.vertices, strict=True)):
        terms = dict(surface.aspheric)
        if surface.curvature == 0.0 and not terms:
            shape = batoid.Plane()
        elif terms:
            coefficients = [terms.get(power, 0.0) for power in range(4, max(terms) + 1, 2)]
            shape = batoid.Asphere(1.0 / surface.curvature, surface.conic, coefficients)
        else:
            shape = batoid.Quadric(1.0 / surface.curvature, surface.conic)
        items.append(batoid.RefractiveInterface(
            shape, name=str(i), coordSys=batoid.CoordSys().shiftGlobal([0.0, 0.0, z]),
            inMedium=batoid.ConstMedium(before), outMedium=batoid.ConstMedium(surface.glass.n_d)))
        before = surface.glass.n_d
    system = batoid.CompoundOptic(items, name="lens", inMedium=batoid.ConstMedium(1.0),
                                  outMedium=batoid.ConstMedium(before))

    def run(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        rays = batoid.RayVector(*origins.T.copy(), *directions.T.copy())
        system.trace(rays)
        return rays.toCoordSys(batoid.globalCoordSys).r
    return run


def batoid_has(surface: lb.Surface) -> bool:
    """Whether batoid 0.9 traces a surface: even powers from r⁴ on; on a parabola (k = −1) it finds a wrong point."""
    even = all(power % 2 == 0 and power > 2 for power, _ in surface.aspheric)
    return surface.is_rotationally_symmetric and even and not (surface.aspheric and surface.conic == -1.0)


PEERS = {"rayoptics": through_rayoptics, "optiland": through_optiland, "batoid": through_batoid}


def installed() -> list[str]:
    """Names of the installed programs."""
    return [name for name in PEERS if find_spec(name) is not None]


def peer_marks(names: Sequence[str], truth: Truth) -> list[Mark]:
    """Marks of these programs on the rays of a lens: ns a ray, and error in pixels on the last surface."""
    lens, pitch = truth.camera.lens, truth.camera.film.pitch
    origins, directions = (values[:RAYS] for values in truth.arriving(BEFORE))
    true = lb.trace(lens, origins, directions, clip=False, forward=True).points
    marks: dict[str, Mark] = {}
    runs: dict[str, Callable[[], object]] = {}
    counts: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")                 # they raise errors of their own
        for name in names:
            try:
                run, count = PEERS[name](lens, Path(folder)), min(FEW if name == "rayoptics" else RAYS, len(origins))
                off = np.linalg.norm(run(origins[:count], directions[:count]) - true[:count], axis=1) / pitch
            except Exception as error:                  # of any kind: the other programs still run
                marks[name] = Mark(name, "peer", why=str(error).split("\n")[0] or type(error).__name__)
                continue
            figures = {"rms, px": float(np.sqrt((off**2).mean())), "p99, px": float(np.quantile(off, 0.99)),
                       "worst, px": float(off.max())}
            marks[name] = Mark(name, "peer", error=figures["rms, px"], worst=figures["worst, px"], figures=figures)
            runs[name], counts[name] = partial(run, origins[:count], directions[:count]), count
        times = time_in_turn(runs, SECONDS) if runs else {}
    finished = []
    for name, mark in marks.items():
        if name in times:
            cost = times[name].per_item(counts[name])
            figures = {"streamed, ns": cost.least, "spread, %": cost.spread, **mark.figures}
            why = "" if np.isfinite(mark.error) else "loses rays that the lens passes"
            mark = Mark(name, "peer", cost.least, mark.error, cost.spread, mark.worst, why, figures)
        finished.append(mark)
    return finished
