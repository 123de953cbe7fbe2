"""Stars of the blades in a picture: their light, their rays, and the balance with the lights that they come from."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.blade_star import open_pupil, sunstar
from lensbench.core.rendering.star_image import STAR_KERNEL_LINES, FlareImage, StarImage, _curves, star_kernel

GAUSS = lenses.load("pbrt-dgauss-50mm")
SQUARES = lb.Film(3.6, 2.4, 360, 240)           # pixels of 10 µm
FILM = lb.Film(36.0, 24.0, 24, 16)
BLACK = (0.0, 0.0, 0.0)


def polygon(corners, radius=0.03, turned=0.0):
    """A regular polygon in direction cosines."""
    around = turned + 2.0 * math.pi * np.arange(corners) / corners
    return radius * np.column_stack([np.cos(around), np.sin(around)])


def distances(kernel):
    down, across = (np.arange(-(n // 2), n // 2 + 1) * 0.01 for n in kernel.shape[:2])
    return np.hypot(across, down[:, None]), np.arctan2(-down[:, None] + 0.0 * across, across + 0.0 * down[:, None])


@pytest.mark.slow
def test_the_light_about_a_round_pupil_is_that_of_airys_pattern():
    """Beyond q falls λ / (π² a q) of it, the mean of J₀² + J₁² far out."""
    kernel, taken = star_kernel(polygon(400), SQUARES, (300, 300))
    r, _ = distances(kernel)
    for near, far in ((0.1, 0.3), (0.5, 2.0)):
        found = taken * kernel[(r > near) & (r <= far)].sum()
        assert found == pytest.approx(STAR_KERNEL_LINES / (math.pi**2 * 0.03) * (1.0 / near - 1.0 / far), rel=0.03)
    assert kernel.sum() == pytest.approx(1.0, rel=0.02)
    ring = kernel[(r > 0.5) & (r < 0.52)]
    assert ring.std() < 0.1 * ring.mean()                               # a round stop has no rays


@pytest.mark.slow
@pytest.mark.parametrize(("corners", "rays"), [(3, 6), (5, 10), (6, 6), (7, 14), (8, 8)])
def test_n_blades_draw_n_rays_or_twice_as_many_across_their_edges(corners, rays):
    turned = 0.3
    kernel, _ = star_kernel(polygon(corners, turned=turned), SQUARES, (100, 100))
    r, azimuth = distances(kernel)
    ring = (r > 0.6) & (r < 0.95)
    profile, _ = np.histogram(azimuth[ring], 180, (-math.pi, math.pi), weights=kernel[ring])
    bright = profile > 0.3 * profile.max()
    begins = np.flatnonzero(bright & ~np.roll(bright, 1))
    assert len(begins) == rays
    # On the raster x runs against the film, and y of `distances` upward against it
    edges = turned + (2.0 * np.arange(corners) + 1.0) * math.pi / corners
    wanted = np.concatenate([math.pi + edges, edges])
    for peak in -math.pi + (np.flatnonzero(profile > 0.6 * profile.max()) + 0.5) * math.pi / 90.0:
        assert np.abs(np.exp(1j * (wanted - peak)) - 1.0).min() < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("blades", [0, 5, 6])
def test_the_star_has_the_light_of_the_exact_pattern(blades):
    """Fraunhofer's amplitude of the whole polygon, all edges together, in a ring from 0.1 to 1 mm."""
    lens = lb.stopped_down(replace(GAUSS, blades=blades), 16.0)
    distance = lb.film_distance(lens, math.inf)
    kernel, taken = star_kernel(open_pupil(lens, distance, (0.0, 0.0)), SQUARES, (150, 150))
    r, _ = distances(kernel)
    exact = sunstar(lens, distance, radii=np.geomspace(0.1, 1.0, 100), azimuths=1440 if blades else 96, colours=8)
    light = np.trapezoid(exact.density.mean(1) * 2.0 * math.pi * exact.radii, exact.radii)
    assert taken.mean() * kernel[(r > 0.1) & (r < 1.0)].sum() == pytest.approx(light, rel=0.05)


@pytest.mark.slow
def test_stars_take_their_light_from_the_lights():
    scene = lb.Scene("sun", lb.Sky(BLACK, BLACK, BLACK), sun=lb.Sun((0.05, 0.03, -1.0), (1.0, 1.0, 1.0)))
    camera = lb.LensCamera(replace(GAUSS, blades=6), lb.Film(36.0, 24.0, 96, 64), f_number=16.0)
    found = []
    for flare in (None, lb.Flare(strength=0.0, stars=1.0)):
        rendering = lb.Rendering(camera, scene, flare=flare)
        rendering.add(128, threads=2)
        found.append(rendering.image())
    plain, starred = found
    lit = plain[..., 1] > 0.0
    assert starred.sum((0, 1)) == pytest.approx(plain.sum((0, 1)), rel=2e-3)
    assert starred.min() >= 0.0
    assert starred[~lit].sum(0) == pytest.approx((plain[lit] - starred[lit]).sum(0), rel=0.05)
    assert 0.005 < starred[~lit].sum() / plain.sum() < 0.05
    assert starred[~lit][:, 0].sum() > 1.2 * starred[~lit][:, 2].sum()      # by the wavelength


def test_stars_of_one_wavelength_have_light_in_proportion_to_it():
    """Light beyond a distance q grows as λ / q; here from half a pixel on, far beyond the Airy disk of both."""
    scene, sums = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0))), []
    for wavelength in (0.5, 1.0):
        image = FlareImage(lb.LensCamera(GAUSS, FILM, f_number=8.0), scene,
                           lb.Flare(strength=0.0, stars=1.0, wavelength=wavelength))
        with ThreadPoolExecutor(1) as pool:
            image.add(1, pool, 1, lambda: True)
        picture = np.zeros((16, 24, 3), np.float32)
        image.add_to(picture)
        sums.append(picture.sum((0, 1)))
    np.testing.assert_allclose(sums[1], 2.0 * sums[0], rtol=1e-3)       # some more of a wider ray misses the film
    np.testing.assert_allclose(sums[0], sums[0][0], rtol=1e-5)          # white
    assert sums[0][0] > 0.0


def test_stars_are_the_same_in_any_strips_of_the_picture(monkeypatch):
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)))
    image = StarImage(lb.LensCamera(GAUSS, FILM, f_number=8.0), scene, 1.0)
    with ThreadPoolExecutor(1) as pool:
        image.add(1, pool, 1, lambda: True)
    whole, strips = (np.ones((16, 24, 3), np.float32) for _ in range(2))
    image.add_to(whole)
    assert np.ptp(whole) > 1e-6
    monkeypatch.setattr("lensbench.core.rendering.star_image.LINES", 3)
    for first, end in ((0, 8), (8, 9), (9, 16)):
        image.add_to(strips[first:end], first)
    np.testing.assert_array_equal(strips, whole)


@pytest.mark.slow
def test_the_stars_of_a_large_picture_are_made_with_fewer_pixels(monkeypatch):
    scene = lb.Scene("sun", lb.Sky(BLACK, BLACK, BLACK), sun=lb.Sun((0.05, 0.03, -1.0), (1.0, 1.0, 1.0)))
    camera = lb.LensCamera(replace(GAUSS, blades=6), lb.Film(36.0, 24.0, 150, 99), f_number=16.0)
    found = []
    for largest in (1_000_000, 4000):
        monkeypatch.setattr("lensbench.core.rendering.star_image.LARGEST", largest)
        image = StarImage(camera, scene, 1.0)
        with ThreadPoolExecutor(1) as pool:
            image.add(4, pool, 1, lambda: True)
        picture = np.zeros((99, 150, 3), np.float32)
        image.add_to(picture)
        found.append(picture)
    fine, coarse = found
    line, column = np.unravel_index(fine[..., 1].argmax(), (99, 150))
    away = np.hypot(*np.meshgrid(np.arange(150) - column, np.arange(99) - line)) > 12.0       # not the core
    assert coarse[away].sum(0) == pytest.approx(fine[away].sum(0), rel=0.1)


@pytest.mark.slow
def test_a_lens_that_is_dark_on_the_axis_has_no_stars_and_says_so(monkeypatch):
    def dark(*_):
        raise lb.LensError("no light reaches this place of the film")

    monkeypatch.setattr("lensbench.core.rendering.star_image.open_pupil", dark)
    image = StarImage(lb.LensCamera(GAUSS, FILM), lb.builtin_scene("night-lights"), 1.0)
    with ThreadPoolExecutor(1) as pool:
        assert image.add(1, pool, 1, lambda: True)
    picture = np.ones((16, 24, 3), np.float32)
    image.add_to(picture)
    assert "no light reaches" in str(image.findings[0]) and (picture == 1.0).all()


@pytest.mark.slow
def test_stars_that_go_on_from_sums_are_the_same():
    scene = lb.Scene("sun", lb.Sky(BLACK, BLACK, BLACK), sun=lb.Sun((0.05, 0.03, -1.0), (1.0, 1.0, 1.0)))
    camera = lb.LensCamera(replace(GAUSS, blades=6), lb.Film(36.0, 24.0, 48, 32), f_number=16.0)
    first, second = (lb.Rendering(camera, scene, flare=lb.Flare("single-layer", stars=2.0)) for _ in range(2))
    first.add(2, threads=1)
    second.restore(first.state)
    assert (second.image() == first.image()).all()


def test_a_picture_that_can_have_no_stars_says_why():
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0)))
    image = StarImage(lb.PerspectiveCamera(lb.Film(), 0.6), scene, 1.0)
    assert "stars need a lens" in image.reason and "stars" in str(image.findings[0])


def test_the_edges_of_a_smooth_curve_turn_once_around_together():
    """Whatever their lengths; the corners of a square do not turn their straight edges."""
    angles = np.sort(np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 400)) + [0.0]
    points = np.column_stack([2.0 * np.cos(angles), np.sin(angles)])
    edges = np.roll(points, -1, 0) - points
    lengths = np.hypot(*edges.T)
    turns, curves = _curves(edges, lengths)
    assert turns.sum() == pytest.approx(2.0 * np.pi, rel=1e-12)
    np.testing.assert_allclose(curves, lengths.sum(), rtol=1e-12)
    square = np.array([[3.0, 0.0], [0.0, 2.0], [-3.0, 0.0], [0.0, -2.0]])
    turns, curves = _curves(square, np.abs(square).sum(1))
    assert turns.tolist() == [0.0] * 4 and curves.tolist() == [3.0, 2.0, 3.0, 2.0]


@pytest.mark.parametrize("reach", [(12, 7), (5, 9)])
def test_a_star_reaches_as_far_as_asked_across_and_down_and_is_the_same_turned_by_half(reach):
    """Of any pupil: the light of an amplitude over a real pupil has the square of its Fourier transform."""
    kernel, taken = star_kernel(polygon(5, turned=0.2), SQUARES, reach)
    assert kernel.shape[:2] == (2 * reach[1] + 1, 2 * reach[0] + 1) and taken.shape == (3,)
    assert kernel.sum() > 0.0
    np.testing.assert_allclose(kernel, kernel[::-1, ::-1], rtol=1e-9, atol=1e-12 * kernel.max())
