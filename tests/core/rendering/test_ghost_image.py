"""Ghosts in a picture: their light is that of the table, and what has none says why."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.ghost_ranking import ghosts
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.kernels.block import BLUE, RED
from lensbench.core.optics.finding import Kind
from lensbench.core.optics.ghost_path import ghost_pairs, ghost_path
from lensbench.core.rendering import ghost_image
from lensbench.core.rendering.ghost_image import Flare, GhostImage
from lensbench.core.rendering.ghost_lights import add_cells, add_lines, ghost_lights

GAUSS = lenses.load("pbrt-dgauss-50mm")
FILM = lb.Film(36.0, 24.0, 24, 16)


def test_cells_keep_the_light_and_fill_what_they_cover_evenly():
    x, y = np.meshgrid(np.linspace(4.3, 26.7, 8), np.linspace(2.2, 15.9, 8))
    found = np.ones((6, 64), np.float32)
    found[0], found[1] = x.ravel() + 0.3 * y.ravel(), y.ravel()
    film, gain = np.zeros((40 * 20, 3), np.float32), np.array([1.0, 2.0, 0.5], np.float32)
    for top, bottom in ((0, 7), (7, 20)):               # threads take rows of their own
        edges = np.zeros((bottom - top, 41, 3))
        add_cells(edges, found, 7, 40, top, bottom, gain)
        add_lines(film, edges, 40 * top)
    assert np.allclose(film.sum(0), 49.0 * gain, rtol=2e-2)
    inner = film.reshape(20, 40, 3)[6:12, 12:20, 1]
    assert np.allclose(inner, inner[0, 0], rtol=1e-5)
    found[:2] = 5.5                                     # a focus: all light on one pixel
    edges = np.zeros((20, 41, 3))
    add_cells(edges, found, 7, 40, 0, 20, gain)
    film[:] = 0.0
    add_lines(film, edges, 0)
    assert np.allclose(film[5 * 40 + 5], 49.0 * gain, rtol=1e-5)


def test_the_light_of_a_picture_of_ghosts_is_that_of_the_table():
    """The sun on the axis: the sum over the film of each pair is its share of the sun's picture."""
    lens = lb.stopped_down(GAUSS, 16.0)
    camera = lb.LensCamera(lens, lb.Film(36.0, 24.0, 96, 64), weights="physical")
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)))
    row = next(row for row in ghosts(lens, camera.film_distance).rows if 2.0 < row.diameter < 8.0)
    sums = []
    with ThreadPoolExecutor(2) as pool:
        for threads, strength in ((1, 1.0), (2, 0.5)):
            image = GhostImage(camera, scene, Flare(strength=strength, pairs=((row.first, row.second),)))
            image.add(1, pool, threads, lambda: True)
            picture = np.zeros((64, 96, 3), np.float32)
            image.add_to(picture)
            sums.append(picture)
    assert np.allclose(sums[0], 2.0 * sums[1], rtol=1e-5)
    direct = lb.Rendering(camera, scene)
    direct.add(1024, threads=2)                         # noise: 1 %
    assert sums[0][..., 1].sum() == pytest.approx(row.share * direct.image()[..., 1].sum(), rel=0.06)


def test_ghosts_are_the_same_in_any_strips_of_the_picture():
    scene = lb.Scene((), sun=lb.Sun((0.1, 0.05, -1.0), (1.0, 1.0, 1.0)))
    image = GhostImage(lb.LensCamera(GAUSS, FILM), scene, Flare(pairs=((0, 1), (2, 9))))
    with ThreadPoolExecutor(1) as pool:
        image.add(1, pool, 1, lambda: True)
    whole, strips = (np.zeros((16, 24, 3), np.float32) for _ in range(2))
    image.add_to(whole)
    assert np.ptp(whole, axis=0).max() > 0.0
    for first, end in ((0, 8), (8, 9), (9, 16)):
        image.add_to(strips[first:end], first)
    np.testing.assert_array_equal(strips, whole)


def test_a_picture_that_can_have_no_ghosts_says_why():
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0)))
    assert "surfaces" in GhostImage(lb.PerspectiveCamera(lb.Film(), 0.6), scene, Flare()).reason
    camera = lb.LensCamera(GAUSS, FILM, medium=lb.Medium.water(5000.0))
    finding, = lb.Rendering(camera, scene, flare=Flare()).findings
    assert finding.kind == Kind.NO_GHOSTS and "port" in finding.message
    assert lb.Rendering(camera, scene).findings == ()


@pytest.mark.parametrize("scene, reason", [
    (lb.Scene(), "no sun and no small light that the lens sees"),
    (lb.Scene(sun=lb.Sun((0.0, 0.0, 1.0))), "no sun and no small light that the lens sees|miss the film"),
    (lb.Scene(sun=lb.Sun((0.0, 0.0, -1.0)), plates=(lb.Disk((0.0, 0.0, -500.0), (0.0, 0.0, 1.0), 400.0),)),
     "no sun and no small light that the lens sees"),
    (lb.Scene(sun=lb.Sun((0.0, 0.0, -1.0))), None)])
def test_ghosts_and_stars_that_no_light_can_show_say_so(scene, reason):
    """A scene without lights, the sun behind the camera, behind a disk, and before the camera."""
    rendering = lb.Rendering(lb.LensCamera(GAUSS, FILM), scene, flare=Flare(stars=1.0))
    rendering.add(1)
    words = [each.message for each in rendering.findings if each.kind == Kind.NO_GHOSTS]
    assert len(words) == (0 if reason is None else 2)
    for word, about in zip(words, ("ghosts", "stars"), strict=False):
        assert word.startswith(f"no {about}: ") and re.search(f"{reason}|no light lies in the picture", word)


LAMPS = tuple(lb.Sphere((300.0 * (i % 10 - 5), 300.0 * (i // 10 - 3), -9000.0), 12.0,
                        lb.Material((1.0 / (1 + i % 7), 1.0, 1.0), "light")) for i in range(50))


def test_a_pair_that_the_lens_does_not_have_is_said():
    camera = lb.LensCamera(GAUSS, FILM)
    for pair, said in (((3, 99), "no ghost of surfaces 3 and 99"), (ghost_pairs(GAUSS)[0], "")):
        image = GhostImage(camera, lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0))), Flare(pairs=(pair,)))
        assert image.reason.startswith(said) and bool(image.findings) is bool(said)


def test_drawn_ghosts_have_the_light_of_all(monkeypatch):
    """Of 60 grids a pass traces 4 and draws 6; all passes together have the light of all, also in quarters."""
    camera, flare = lb.LensCamera(GAUSS, FILM), Flare(pairs=ghost_pairs(GAUSS)[::9])
    sums = []
    for bright, drawn, passes in ((4, 6, 20), (60, 0, 1)):
        monkeypatch.setattr(ghost_image, "BEST", bright)
        monkeypatch.setattr(ghost_image, "DRAWN", drawn)
        image = GhostImage(camera, lb.Scene(spheres=LAMPS[:12]), flare)
        with ThreadPoolExecutor(1) as pool:
            image.add(ghost_image.PERIOD * passes, pool, 1, lambda: True)
        picture = np.zeros((16, 24, 3), np.float32)
        image.add_to(picture)
        sums.append(picture.reshape(2, 8, 2, 12, 3).sum((1, 3)))
    assert sums[0].sum((0, 1)) == pytest.approx(sums[1].sum((0, 1)), rel=0.02)
    assert sums[0] == pytest.approx(sums[1], rel=0.08)


def test_lights_beyond_the_brightest_are_counted_in_a_finding(monkeypatch):
    monkeypatch.setattr("lensbench.core.rendering.ghost_lights.MOST_LIGHTS", 48)
    with ThreadPoolExecutor(1) as pool:
        for count, expected in ((50, [2.0]), (48, [])):
            image = GhostImage(lb.LensCamera(GAUSS, FILM), lb.Scene(spheres=LAMPS[:count]), Flare(pairs=((0, 1),)))
            image.add(1, pool, 1, lambda: True)
            assert [each.figures["lights"] for each in image.findings] == expected
            assert all(each.kind == Kind.DIM_LIGHTS and 0.02 < each.figures["share"] < 0.05
                       and "2 dimmer lights" in str(each) for each in image.findings)


def test_fog_that_hides_the_sun_hides_its_ghosts():
    """The sun lies at the distance of the sky: e^(−σ · 10⁹ mm) of its light is left, in the picture and in ghosts."""
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)))
    clear, = ghost_lights(lb.LensCamera(GAUSS, FILM), scene, -90.0, 20.0).lights
    hazy, = ghost_lights(lb.LensCamera(GAUSS, FILM, medium=lb.Medium(scattering=(1e-9, 2e-9, 0.0))), scene, -90.0,
                         20.0).lights
    np.testing.assert_allclose(hazy.irradiance, clear.irradiance * np.exp([-1.0, -2.0, 0.0]), rtol=1e-12)
    camera = lb.PerspectiveCamera(FILM, 1e-3)           # the sun fills the film
    pictures = []
    for medium in (None, lb.Medium(scattering=(1e-9, 2e-9, 0.0))):
        rendering = lb.Rendering(replace(camera, medium=medium), scene)
        rendering.add(1)
        pictures.append(rendering.image()[8, 12])
    np.testing.assert_allclose(pictures[1] / pictures[0], hazy.irradiance / clear.irradiance, rtol=1e-4)
    assert ghost_lights(lb.LensCamera(GAUSS, FILM, medium=lb.Medium.fog(50e3)), scene, -90.0, 20.0).lights == []


def test_the_colours_of_a_ghost_lie_where_single_rays_of_their_wavelengths_land():
    """Behind a small stop a ghost lies about its chief ray, here those of eight wavelengths of red and of blue, by the
    reference tracer. The stop of 0.1 mm and pixels of 0.05 mm move the difference by a few µm."""
    glass = lb.Glass(1.8, 25.0)
    lens = lb.Lens((lb.Surface(2.0, 0.1, curvature=0.0), lb.Surface(6.0, 9.0, glass, curvature=1 / 60.0),
                    lb.Surface(0.0, 9.0, curvature=-1 / 60.0)),
                   0)
    camera, pair = lb.LensCamera(lens, lb.Film(80.0, 16.0, 1600, 320)), (1, 2)
    assert camera.disperses and not replace(camera, dispersion=False).disperses
    found = []
    for of in (camera, replace(camera, dispersion=False)):
        image = GhostImage(of, lb.Scene("sun", sun=lb.Sun((0.25, 0.0, -1.0))), Flare(pairs=(pair,)))
        with ThreadPoolExecutor(2) as pool:
            image.add(29, pool, 2, lambda: True)
        shown = np.zeros((320, 1600, 3), np.float32)
        image.add_to(shown)
        assert image.passes >= 8 and (shown[:, [0, -1]] == 0.0).all()
        found.append((shown.sum(0) * (40.0 - 0.05 * (np.arange(1600) + 0.5))[:, None]).sum(0) / shown.sum((0, 1)))
    film_z, way, chief = lens.length + camera.film_distance, np.array([-0.25, 0.0, 1.0]), []
    for row in (RED, BLUE):
        paths = [ghost_path(lens, pair, -10.0 * way, way, line) for line in WAVELENGTHS[row]]
        chief.append(np.mean([path.points[-1][0] + (film_z - path.points[-1][2]) / path.direction[2] * path.direction[0]
                              for path in paths]))
    assert abs(chief[0] - chief[1]) > 0.1
    assert found[0][[0, 2]] == pytest.approx(np.array(chief), abs=0.02)
    assert found[0][0] - found[0][2] == pytest.approx(chief[0] - chief[1], abs=0.01)
    assert abs(found[1][0] - found[1][2]) < 1e-3
