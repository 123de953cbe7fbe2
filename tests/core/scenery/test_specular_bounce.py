"""The footprints of pixel and pupil behind mirrors, panes and balls of glass, against matrices of paraxial optics."""

import numpy as np

from lensbench.core.kernels.block import (
    DEPTH, FINISH, NX, NY, NZ, OX, OY, OZ, PIXEL_SIDE, PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD, TB, TG, TR, L, M, N,
    Step, X, Y, Z
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.shading.bounces import bounce_pupil_part, specular_bounce
from lensbench.core.scenery.shading.illumination import INDEX
from lensbench.core.scenery.surface_codes import GLASS, METAL


def bounced(finish, depth, side, spread, wanted):
    """Rows of rays along −z that meet a surface there, with the same footprint of pixel and pupil."""
    n, one, zero = len(depth), np.ones(len(depth)), np.zeros(len(depth))
    given = {X: zero, Y: zero, Z: zero, L: zero, M: zero, N: -one, DEPTH: depth, FINISH: finish, NX: zero, NY: zero,
             NZ: one, TR: one, TG: one, TB: one, PIXEL_SIDE: side, PIXEL_SPREAD: spread, PUPIL_RADIUS: side,
             PUPIL_SPREAD: spread, OX: 0.3 * one, OY: -0.2 * one, OZ: zero}
    steps = [Step(bounce_pupil_part), Step(specular_bounce)]
    return Program(steps, np.float64).run(given, wanted, n)


def footprints(n=300, seed=3):
    random = np.random.default_rng(seed)
    return random.uniform(5.0, 2000.0, n), random.uniform(-3.0, 3.0, n), random.normal(0.0, 2e-3, n)


def test_a_ball_of_glass_bends_a_footprint_as_its_two_surfaces_do():
    """Refraction into the glass, 2 R of it, refraction out: the matrices of a thick lens, at the place behind it."""
    depth, side, spread = footprints()
    radius = np.random.default_rng(4).uniform(2.0, 300.0, len(depth))
    at = side + depth * spread
    inside = (spread - (INDEX - 1.0) / radius * at) / INDEX
    out = at + 2.0 * radius * inside
    wanted = out, INDEX * inside - (INDEX - 1.0) / radius * out
    found = bounced(GLASS + radius, depth, side, spread, [PIXEL_SIDE, PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD, Z])
    np.testing.assert_allclose(found[:2], wanted, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found[2:4], wanted, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found[4], -depth - 2.0 * radius, rtol=1e-4)      # there, but for the lift


def test_mirrors_and_panes_let_a_footprint_grow_with_the_way():
    depth, side, spread = footprints()
    for finish in (METAL, GLASS):
        found = bounced(np.full(len(depth), finish), depth, side, spread,
                        [PIXEL_SIDE, PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD])
        np.testing.assert_allclose(found, [side + depth * spread, spread] * 2, rtol=1e-12, atol=1e-12)


def test_a_mirror_reflects_the_place_in_the_pupil_and_glass_keeps_it():
    """A mirror at 45° exchanges x and z, as it turns a ray along −z to −x."""
    one, h = np.ones(1), np.sqrt(0.5)
    for finish, wanted in ((METAL, (0.5, 0.2, 0.3)), (GLASS, (0.3, 0.2, 0.5)), (GLASS + 40.0, (0.3, 0.2, 0.5))):
        given = {N: -one, DEPTH: one, FINISH: finish * one, NX: -h * one, NZ: h * one, OX: 0.3 * one, OY: 0.2 * one,
                 OZ: 0.5 * one, TR: one, TG: one, TB: one}
        found = Program([Step(bounce_pupil_part)], np.float64).run(given, [OX, OY, OZ], 1)[:, 0]
        np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_rays_leave_a_ball_of_glass_turned_by_snells_law_twice():
    random = np.random.default_rng(7)
    ways, normals = random.normal(size=(2, 500, 3))
    ways, normals = (v / np.linalg.norm(v, axis=1)[:, None] for v in (ways, normals))
    normals *= -np.sign((ways * normals).sum(1))[:, None]
    along = -(ways * normals).sum(1)
    across = ways + along[:, None] * normals
    across /= np.linalg.norm(across, axis=1)[:, None]
    angle = np.arccos(along)
    left = 2.0 * np.arcsin(np.sin(angle) / 1.5) - angle         # from the normal's line, after both surfaces
    one = np.ones(500)
    given = {L: ways[:, 0], M: ways[:, 1], N: ways[:, 2], DEPTH: 900.0 * one, FINISH: (GLASS + 40.0) * one,
             NX: normals[:, 0], NY: normals[:, 1], NZ: normals[:, 2], TR: one, TG: one, TB: one}
    found = Program([Step(specular_bounce)], np.float64).run(given, [L, M, N], 500).T
    np.testing.assert_allclose(found, np.sin(left)[:, None] * across - np.cos(left)[:, None] * normals, atol=1e-9)
