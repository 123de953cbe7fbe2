"""Many spheres: the tree finds what a list of them finds, and the sky's light to half a percent."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import BLUE, GREEN, RED, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery import scene_steps
from lensbench.core.scenery.intersect import spheres as intersect
from lensbench.core.scenery.intersect.spheres import CROWD, Entry, bounding_sphere, sphere_tree
from lensbench.core.scenery.shading import illumination, soft_shadows

DARK = lb.Sky((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def balls(n, seed=1, material=None):
    """Balls on a floor at the height −300, in rows before a camera at the origin."""
    rng, side = np.random.default_rng(seed), math.ceil(math.sqrt(n))
    found = []
    for i in range(n):
        radius = rng.uniform(20.0, 50.0)
        place = (120.0 * (i % side - side / 2) + rng.uniform(-20.0, 20.0), radius - 300.0,
                 -700.0 - 120.0 * (i // side) + rng.uniform(-20.0, 20.0))
        found.append(lb.Sphere(place, radius, material or lb.Material(tuple(rng.uniform(0.2, 0.9, 3)))))
    return tuple(found)


def picture(scene):
    scene_steps.radiance_steps.cache_clear()
    rendering = lb.Rendering(lb.PerspectiveCamera(lb.Film(36.0, 24.0, 96, 64)), scene, light_tracing=False)
    rendering.add(4, threads=1)
    return rendering.image()


@pytest.fixture
def plain_list(monkeypatch):
    """Every sphere by itself."""
    def listed(centres):
        return [Entry(np.array([j]), 0) for j in range(len(centres))]

    for module in (intersect, soft_shadows, illumination):
        monkeypatch.setattr(module, "sphere_tree", listed)
    yield
    scene_steps.radiance_steps.cache_clear()


@pytest.mark.parametrize("n", [0, 1, 2 * CROWD, 2 * CROWD + 1, 100, 1000])
def test_every_sphere_is_once_in_the_tree_below_the_nodes_that_hold_it(n):
    centres = np.random.default_rng(n).normal(size=(n, 3))
    entries = sphere_tree(centres)
    assert sorted(int(entry.members[0]) for entry in entries if not entry.below) == list(range(n))
    for i, entry in enumerate(entries):
        assert i + entry.below < len(entries)
        below = [e.members[0] for e in entries[i + 1:i + 1 + entry.below] if not e.below]
        assert not entry.below or sorted(below) == sorted(entry.members)
    assert n > 2 * CROWD or len(entries) == n


def test_a_node_reaches_around_its_spheres():
    rng = np.random.default_rng(4)
    centres, radii = rng.normal(size=(30, 3)) * 100.0, rng.uniform(1.0, 30.0, 30)
    middle, reach = bounding_sphere(centres, radii)
    assert (np.linalg.norm(centres - middle, axis=1) + radii <= reach).all()


@pytest.mark.parametrize("lit", ["sun", "lamp"])
def test_what_is_seen_and_its_shadows_are_those_of_a_list_bit_for_bit(lit, request):
    if lit == "sun":
        scene = lb.Scene("many", DARK, lb.Sun((0.6, 0.5, 0.3)), lb.Floor(-300.0), balls(300))
    else:
        lamp = lb.Rectangle((0.0, 900.0, -1500.0), (200.0, 0.0, 0.0), (0.0, 0.0, 200.0),
                            material=lb.Material((30.0, 30.0, 30.0), "lamp"))
        scene = lb.Scene("many", DARK, None, lb.Floor(-300.0), balls(300), (lamp,))
    found = picture(scene)
    request.getfixturevalue("plain_list")
    listed = picture(scene)
    assert found.max() > 0.1 and (found == 0.0).any()
    np.testing.assert_array_equal(found, listed)


@pytest.mark.slow
def test_the_light_of_the_sky_is_the_product_over_all_spheres_to_half_a_percent():
    held = balls(2000)
    scene = lb.Scene("many", lb.Sky(*[(1.0, 1.0, 1.0)] * 3), None, lb.Floor(-300.0), held)
    rng = np.random.default_rng(2)
    # Rays straight down onto the floor from just above it, in compact blocks
    x, z = (rng.uniform(-60.0, 60.0, (8, 512)) + [[rng.uniform(-2000.0, 2000.0)] for _ in range(8)] for _ in range(2))
    x, z = x.ravel(), z.ravel() - 3000.0
    given = {X: x, Y: np.full(x.size, -299.9), Z: z, L: np.zeros(x.size), M: -np.ones(x.size), N: np.zeros(x.size)}
    light = Program(scene.steps()).run(given, [RED, GREEN, BLUE], x.size)[1]
    alone = Program(replace(scene, spheres=()).steps()).run(given, [RED, GREEN, BLUE], x.size)[1]
    centres, radii = np.array([s.centre for s in held]), np.array([s.radius for s in held])
    free = np.ones(x.size)
    for centre, radius in zip(centres, radii, strict=True):
        away = centre - np.column_stack([x, np.full(x.size, -300.0), z])
        d2 = (away**2).sum(1)
        free *= 1.0 - np.clip(radius**2 * away[:, 1] / d2**1.5, 0.0, 1.0)
    open_air = (np.hypot(centres[:, 0, None] - x, centres[:, 2, None] - z) > radii[:, None]).all(0)
    assert open_air.sum() > 1000 and free[open_air].min() < 0.8
    np.testing.assert_allclose(light[open_air], (alone * free)[open_air], rtol=5e-3)
