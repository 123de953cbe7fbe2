"""Fog and water: Beer and Lambert's law along every ray, and the airlight that makes up for what is lost."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench.core.kernels.block import BLUE, DEPTH, GREEN, RED, SB, SG, SR, TB, TG, TR, B
from lensbench.core.kernels.program import Program

FILM = lb.Film(36.0, 24.0, 96, 64)
MURK = lb.Medium(absorption=(1e-4, 2e-4, 0.0), scattering=(3e-4, 0.0, 1e-4), light=(0.5, 0.8, 1.0))
DARK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)


@pytest.mark.parametrize("real", [np.float32, pytest.param(np.float64, marks=pytest.mark.slow)])
def test_transmittance_falls_exponentially(real):
    """The stages against the library's exponential: 64 times the rounding of a float, 1e-8 of the polynomial.

    Relative to what is left, down to e^−40; beyond it nothing is.
    """
    d = np.concatenate([np.geomspace(1e-3, 4e5, B - 1), [1e9]])
    carried = Program(MURK.steps, real).run({DEPTH: d, TR: np.ones(B), TG: np.full(B, 0.5), TB: np.ones(B)},
                                            [TR, TG, TB, SR, SG, SB], B).astype(float)
    sigma = np.array([4e-4, 2e-4, 1e-4])
    passed = np.exp(-d[:, None] * sigma) * [1.0, 0.5, 1.0]
    tolerance = 1e-5 if real is np.float32 else 2e-8
    np.testing.assert_allclose(carried[:3].T, passed, rtol=tolerance, atol=math.exp(-39.9))
    np.testing.assert_allclose(carried[3:].T, (1.0 - np.exp(-d[:, None] * sigma)) * [0.375, 0.0, 1.0], atol=tolerance)
    dimmed = Program(MURK.dimming, real).run({DEPTH: d, RED: np.ones(B), GREEN: np.full(B, 0.5), BLUE: np.ones(B)},
                                             [RED, GREEN, BLUE], B)
    np.testing.assert_allclose(dimmed.T, passed, rtol=tolerance, atol=math.exp(-39.9))


absorptions = st.tuples(*[st.floats(0.0, 1e-3)] * 3)


@settings(max_examples=40)
@given(absorptions, absorptions, st.floats(0.0, 1e4), st.floats(0.0, 1e4))
def test_two_lengths_together_are_their_sum(absorption, scattering, one, other):
    medium = lb.Medium(1.0, absorption, scattering, (0.3, 0.6, 0.9))
    np.testing.assert_allclose(medium.transmittance(one) * medium.transmittance(other),
                               medium.transmittance(one + other), rtol=1e-12)
    radiance = np.array([2.0, 0.1, 0.5])
    np.testing.assert_allclose(medium.seen(medium.seen(radiance, one), other), medium.seen(radiance, one + other),
                               rtol=1e-9)
    assert np.allclose(medium.seen(radiance, 0.0), radiance)


def wall(distance):
    lamp = lb.Material(kind="lamp", colour=(2.0, 1.0, 0.4))
    plate = lb.Rectangle((0.0, 0.0, -distance), (9e5, 0.0, 0.0), (0.0, 9e5, 0.0), lamp)
    return lb.Scene("wall", sky=DARK, plates=(plate,))


@pytest.mark.slow
@pytest.mark.parametrize("distance", [500.0, 3000.0, 20_000.0])
def test_a_glowing_wall_is_seen_through_the_medium_by_the_law(distance):
    """Each pixel along its own length of ray: d / cos θ."""
    camera = lb.PerspectiveCamera(FILM, fov=1.2, medium=MURK)
    rays = camera.generate_rays(np.stack(np.meshgrid(np.arange(96) + 0.5, np.arange(64) + 0.5), -1).reshape(-1, 2),
                                np.full((96 * 64, 2), 0.5))
    length = distance / -rays.directions[:, 2]
    expected = MURK.seen(np.array([2.0, 1.0, 0.4]), length) * rays.weights[:, None]
    image = lb.render(camera, wall(distance), samples=64)
    np.testing.assert_allclose(image.reshape(-1, 3), expected, rtol=3e-3, atol=2e-4)    # the mean over a pixel


def test_far_away_only_the_airlight_is_left_and_clear_air_costs_no_stage():
    """No step more than without a medium, and the same picture bit for bit."""
    scene = lb.builtin_scene("still-life")
    clear = lb.Medium(index=1.33)
    assert clear.is_clear and clear.steps == clear.dimming == []
    assert len(scene.steps(medium=clear)) == len(scene.steps()) == len(scene.steps(medium=MURK)) - scene_rounds(scene)
    plain, through = (lb.render(lb.PerspectiveCamera(FILM, medium=medium), scene, samples=4)
                      for medium in (None, lb.Medium()))
    np.testing.assert_array_equal(plain, through)
    thick = lb.Medium.fog(100.0, (0.2, 0.4, 0.6))
    image = lb.render(lb.PerspectiveCamera(FILM, medium=thick), scene, samples=4)
    np.testing.assert_allclose(image[:10].mean((0, 1)) / image[:10, :, :1].mean((0, 1)), [1.0, 2.0, 3.0], rtol=1e-3)


def scene_rounds(scene):
    """How often a path goes on, and first sets out."""
    names = [step.kernel.py_func.__name__ for step in scene.steps()]
    return names.count("gather_emission")


def test_a_mirror_is_as_far_as_what_it_shows():
    """A ball of metal before a glowing wall behind the camera: the length of both parts of the path counts."""
    lamp = lb.Material(kind="lamp", colour=(1.0, 1.0, 1.0))
    metal = lb.Material(kind="metal", colour=(1.0, 1.0, 1.0))
    sphere = lb.Sphere((0.0, 0.0, -1000.0), 100.0, metal)
    behind = lb.Rectangle((0.0, 0.0, 2000.0), (5e5, 0.0, 0.0), (0.0, 5e5, 0.0), lamp)
    scene = lb.Scene("mirror", sky=DARK, spheres=(sphere,), plates=(behind,))
    medium = lb.Medium(absorption=(3e-4, 1e-4, 0.0))
    film = lb.Film(0.2, 0.2, 4, 4)
    with_it, without = (lb.render(lb.PerspectiveCamera(film, fov=0.002, medium=m), scene, samples=16).mean((0, 1))
                        for m in (medium, None))
    np.testing.assert_allclose(with_it / without, medium.transmittance(900.0 + 2900.0), rtol=2e-3)


def test_splatted_lights_are_dimmed_as_the_cameras_rays_find_them():
    """Energy of a small lamp, traced from its own side and by the camera's rays: noise of the latter 1 %."""
    lamp = lb.Material(kind="lamp", colour=(4e3, 3e3, 2e3))
    scene = lb.Scene("lamp", sky=DARK, spheres=(lb.Sphere((20.0, 0.0, -4000.0), 8.0, lamp),))
    camera = lb.PerspectiveCamera(lb.Film(1.0, 1.0, 32, 32), fov=0.05, lens_radius=8.0, focus_distance=2000.0,
                                  medium=MURK)
    traced, plain = (lb.Rendering(camera, scene, light_tracing=flag) for flag in (True, False))
    assert traced.light_traced and not plain.light_traced
    for rendering, samples in ((traced, 16), (plain, 1024)):
        rendering.add(samples)
    np.testing.assert_allclose(traced.image().mean((0, 1)), plain.image().mean((0, 1)), rtol=0.02)


def test_fog_is_told_by_its_visibility():
    """Contrast of a black thing against the airlight at that distance: Koschmieder's fiftieth."""
    fog = lb.Medium.fog(50_000.0)
    assert fog.transmittance(50_000.0) == pytest.approx(0.02)
    np.testing.assert_allclose(1.0 - fog.seen(np.zeros(3), 50_000.0), 0.02)
    np.testing.assert_allclose(fog.airlight, 1.0)


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.Medium(index=0.5), "index 0.5"),
    (lambda: lb.Medium(absorption=(1.0, 2.0)), "absorption"),
    (lambda: lb.Medium(scattering=(-1.0, 0.0, 0.0)), "scattering"),
    (lambda: lb.Medium(light=(math.nan, 0.0, 0.0)), "light"),
    (lambda: lb.Medium.fog(0.0), "visibility 0"),
])
def test_what_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(lb.MediumError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
