"""Lenses and reference values of tests/data, and random lenses, for the tests of the optics."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import settings, strategies as st

import lensbench as lb

DATA = Path(__file__).parents[1] / "data"
REFERENCE = json.loads((DATA / "oracles.json").read_text(encoding="utf-8"))
PBRT_FOCUS = json.loads((DATA / "pbrt_focus.json").read_text(encoding="utf-8"))
LAW = settings(max_examples=60)
NAMES = ("dgauss", "fisheye", "cooke")
TRACED = (*NAMES, "rf50", "codev")                      # rf50 has two aspheres
WAVELENGTHS = [(name, line) for name in TRACED for line in REFERENCE[name]["paraxial"]]


def _pairs(terms=()):
    return tuple((power, coefficient) for power, coefficient in terms)


def lens(name: str, line: str = "d") -> lb.Lens:
    """The reference lens with the indices of one spectral line."""
    data = REFERENCE[name]
    surfaces = [lb.Surface(thickness, semi_diameter,
                           lb.Glass(n[line]) if n else lb.AIR, curvature=1.0 / radius if radius else 0.0,
                           aspheric=_pairs(*terms))
                for radius, thickness, semi_diameter, n, *terms in data["surfaces"]]
    return lb.Lens(tuple(surfaces), data["stop"], name=name)


def pbrt_rays(name: str, film: np.ndarray, direction: np.ndarray, rear_z: float) -> tuple[np.ndarray, np.ndarray]:
    """Rays of pbrt's camera space (metres, film at z = 0, +z towards the scene) in the lens frame (mm)."""
    last_vertex = lens(name).length
    origins = np.column_stack([1000.0 * film, np.full(len(film), last_vertex + 1000.0 * rear_z)])
    return origins, np.column_stack([direction[:, :2], -direction[:, 2]])


def biconvex(curvature: float = 0.01, thickness: float = 4.0, index: float = 1.5,
             semi_diameter: float = 10.0) -> lb.Lens:
    """One lens in air; its first surface is the stop."""
    return lb.Lens((lb.Surface(thickness, semi_diameter, lb.Glass(index), curvature=curvature),
                    lb.Surface(0.0, 2.0 * semi_diameter, curvature=-curvature)), 0)


def rms_on_film(wide: lb.Lens, film: float, focus_distance: float, rays: int = 400) -> float:
    """Rms radius on the film of rays at even steps of pupil area, the pupil found by stepping outwards."""
    before = focus_distance - film - wide.length
    heights = np.linspace(0.0, wide.surfaces[0].semi_diameter, 20001)[1:]
    origins = np.column_stack([0.0 * heights, heights, 0.0 * heights])
    way = np.column_stack([0.0 * heights, heights / before, np.ones_like(heights)])
    edge = heights[lb.trace(wide, origins, way).fate == lb.Fate.PASSED].max()
    heights = edge * np.sqrt((np.arange(rays) + 0.5) / rays)
    t = lb.trace(wide, np.column_stack([0.0 * heights, heights, 0.0 * heights]),
                 np.column_stack([0.0 * heights, heights / before, np.ones_like(heights)]))
    on_film = t.points[:, 1] + (wide.length + film - t.points[:, 2]) * t.directions[:, 1] / t.directions[:, 2]
    return float(np.sqrt(np.mean(on_film**2)))


@st.composite
def lenses(draw, most: int = 8) -> lb.Lens:
    """Random stacks of surfaces, rims well within every sphere; the last medium is air."""
    count = draw(st.integers(1, most))
    radius = st.one_of(st.floats(12.0, 300.0), st.floats(-300.0, -12.0))
    curvature = st.one_of(st.just(0.0), radius.map(lambda r: 1.0 / r))
    surfaces = tuple(
        lb.Surface(draw(st.floats(0.5, 8.0)), draw(st.floats(4.0, 9.0)),
                   lb.AIR if i % 2 or i == count - 1 else lb.Glass(draw(st.floats(1.4, 1.95))),
                   curvature=draw(curvature))
        for i in range(count))
    return lb.Lens(surfaces, draw(st.integers(0, count - 1)))


def behind_stop(gap: float) -> lb.Lens:
    """A biconvex lens of 42 mm, its stop this far behind its rear focus."""
    glass = (lb.Surface(4.0, 8.0, lb.Glass(1.6), curvature=0.02), lb.Surface(0.0, 8.0, curvature=-0.02))
    focus = lb.first_order(lb.Lens(glass, 0)).bfl
    return lb.Lens((glass[0], lb.Surface(focus + gap, 8.0, curvature=-0.02), lb.Surface(0.0, 2.0, curvature=0.0)), 2)


def of_one_colour(stack: lb.Lens, wavelength: float) -> lb.Lens:
    """The lens with glasses that do not disperse, of the indices that its own have at a wavelength (µm)."""
    return replace(stack, surfaces=tuple(replace(surface, glass=lb.Glass(n)) for surface, n in zip(
        stack.surfaces, stack.indices(wavelength)[1:], strict=True)))
