"""Traces with optical paths: points against 40-digit rays, paths and ends of rays against the scalar tracer."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import CLEARANCE, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import PATH, STOP_SHARE, VICTIM, path_steps
from tests.core.optics.test_surface_pose import posed

WANTED = (X, Y, Z, L, M, N, WEIGHT, CLEARANCE, PATH, VICTIM, STOP_SHARE)


def traced(lens, film_distance, origins, directions):
    """The rows WANTED of rays in the lens frame."""
    z = origins[:, 2] - lens.length - film_distance
    given = dict(zip((X, Y, Z, L, M, N), (*origins[:, :2].T, z, *directions.T), strict=True))
    out = Program(path_steps(lens, film_distance), np.float64).run({**given, WEIGHT: np.ones(len(z))}, WANTED, len(z))
    return dict(zip(WANTED, out, strict=True))


def bundle(lens, angle, count=600, seed=3):
    """Parallel rays over the first surface and somewhat beyond, from the plane through its vertex."""
    rng = np.random.default_rng(seed)
    reach = 1.3 * lens.surfaces[0].semi_diameter
    origins = np.column_stack([*rng.uniform(-reach, reach, (2, count)), np.full(count, -5.0)])
    return origins, np.tile([0.0, np.sin(angle), np.cos(angle)], (count, 1))


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lib-tronnier-1953", "rf50", "decentred"])
def test_paths_and_ends_of_rays_agree_with_the_scalar_tracer(name):
    from tests.core.oracles import lens as reference
    if name == "decentred":
        lens = posed(lenses.load("pbrt-dgauss-50mm"), 2, 4, decentre_y=0.3, tilt_x=0.02, tilt_y=-0.03)
    else:
        lens = reference(name) if name == "rf50" else lenses.load(name)
    origins, directions = bundle(lens, 0.2)
    found = traced(lens, 40.0, origins, directions)
    t = lb.trace(lens, origins, directions, record=True)
    passed = t.fate == lb.Fate.PASSED
    assert 50 < passed.sum() < 550
    np.testing.assert_array_equal(found[VICTIM] < 0, passed)
    np.testing.assert_array_equal(found[WEIGHT] > 0, passed)
    ends = t.surface + (t.fate == lb.Fate.MISSED)
    np.testing.assert_array_equal(found[VICTIM][~passed], ends[~passed])
    paths = (np.linalg.norm(np.diff(t.paths, axis=1), axis=2) * lens.indices()[:-1]).sum(1)
    np.testing.assert_allclose(found[PATH][passed], paths[passed], rtol=0.0, atol=1e-11)
    at_stop = np.hypot(*t.paths[passed, 1 + lens.stop_index, :2].T) / lens.stop.semi_diameter
    np.testing.assert_allclose(found[STOP_SHARE][passed], at_stop**2, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(np.column_stack([found[X], found[Y]])[passed], t.points[passed, :2], atol=1e-11)


def test_the_blades_of_the_stop_end_rays_at_the_stop():
    from dataclasses import replace
    lens = lb.stopped_down(replace(lenses.load("pbrt-dgauss-50mm"), blades=5), 5.6)
    found = traced(lens, 36.0, *bundle(lens, 0.0))
    t = lb.trace(lens, *bundle(lens, 0.0))
    np.testing.assert_array_equal(found[VICTIM] < 0, t.fate == lb.Fate.PASSED)
    beyond_blades = (found[VICTIM] == lens.stop_index) & (found[STOP_SHARE] < 1.0)
    assert beyond_blades.any()
