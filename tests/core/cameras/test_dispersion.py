"""Colours that a lens spreads: pictures against rays traced at every wavelength."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.spectrum import WAVELENGTHS, spectral_part
from lensbench.core.kernels.block import BLUE, GREEN, RED
from lensbench.core.scenery.objects.basic_shapes import Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene

PIXEL = 0.02        # mm
CHANNELS = (RED, GREEN, BLUE)
BLACK = (0.0, 0.0, 0.0)
FLINT = lb.Glass(1.62, 36.4)


def landscape(glass=FLINT):
    """A flint meniscus behind its stop, about 60 mm f/12: it spreads colours along the axis and across the film."""
    return lb.Lens((lb.Surface(25.0, 2.5, curvature=0.0), lb.Surface(3.0, 12.0, glass, curvature=-1 / 60.0),
                    lb.Surface(0.0, 12.0, curvature=-1 / 22.5)), 0)


def lamp(x, y, z=-3000.0, radius=2.0):
    """A small bright ball in the dark, at a place of the camera frame (mm)."""
    bright = Material((100.0,) * 3, "light")
    return Scene("lamp", sky=Sky(BLACK, BLACK, BLACK), spheres=(Sphere((x, y, z), radius, bright),))


def moments(picture):
    """Of each channel: the x, y of its centroid on the film (mm), and the variance about it in x and y together."""
    h, w, _ = picture.shape
    x, y = (0.5 - (np.arange(w) + 0.5) / w) * w * PIXEL, ((np.arange(h) + 0.5) / h - 0.5) * h * PIXEL
    out = []
    for light in np.moveaxis(picture.astype(float), 2, 0):
        light = light / light.sum()
        across, down = light.sum(0), light.sum(1)
        cx, cy = across @ x, down @ y
        out.append((cx, cy, across @ (x - cx) ** 2 + down @ (y - cy) ** 2))
    return np.array(out)


def traced(camera, place, wavelengths):
    """The same of the rays from a point (camera frame) through the stop, traced by the scalar reference."""
    end = camera.lens.length + camera.film_distance             # of the camera's origin in the lens frame
    origin = np.array(place) + [0.0, 0.0, end]
    steps = np.linspace(-2.55, 2.55, 152)
    aims = np.stack([*np.meshgrid(steps, steps), np.zeros((152, 152))], 2).reshape(-1, 3)
    spots = []
    for wavelength in wavelengths:
        rays = lb.trace(camera.lens, origin, aims - origin, wavelength)
        passed = rays.fate == lb.Fate.PASSED
        p, d = rays.points[passed], rays.directions[passed]
        spots.append((p + d * ((end - p[:, 2]) / d[:, 2])[:, None])[:, :2])
    middle = np.mean([spot.mean(0) for spot in spots], 0)
    return [*middle, np.mean([((spot - middle) ** 2).sum(1).mean() for spot in spots])]


@pytest.fixture(scope="module")
def spots():
    """The lamp on the axis and far off it: the moments in the picture and those of the traced rays."""
    found = {}
    for name, place, side, samples in (("axis", (0.0, 0.0), 64, 1600), ("corner", (160.0, -110.0), 352, 320)):
        film = lb.Film(side * PIXEL, side * PIXEL, side, side)
        camera = lb.LensCamera(landscape(), film, 3000.0)
        picture = lb.render(camera, lamp(*place), samples=1 + samples)
        magnification = camera.first_order.efl / (3000.0 - 2.0 * camera.first_order.efl)
        disk_and_pixel = 2.0 * magnification**2 + PIXEL**2 / 6.0         # variances of a disk of radius 2 and a square
        expected = np.array([traced(camera, (*place, -3000.0), WAVELENGTHS[channel]) for channel in CHANNELS])
        found[name] = moments(picture), expected + [0.0, 0.0, disk_and_pixel]
    return found


@pytest.mark.slow
def test_each_channel_lies_where_rays_of_its_wavelengths_meet(spots):
    """Lateral colour: every centroid within a tenth of a pixel, where red and blue are more than a pixel apart."""
    seen, expected = spots["corner"]
    assert seen[:, :2] == pytest.approx(expected[:, :2], abs=0.1 * PIXEL)
    assert np.hypot(*(expected[0] - expected[2])[:2]) > PIXEL


@pytest.mark.slow
def test_each_channel_is_as_blurred_as_rays_of_its_wavelengths(spots):
    """Longitudinal colour: the d line is in focus, so that the rest is not, blue most; within sampling noise."""
    seen, expected = spots["axis"]
    assert seen[:, :2] == pytest.approx(0.0, abs=0.1 * PIXEL)
    assert seen[:, 2] == pytest.approx(expected[:, 2], rel=0.03)
    assert expected[2, 2] > 2.0 * expected[1, 2] > 3.0 * expected[0, 2]


def test_white_stays_white():
    """On the axis, and everywhere of a lens whose regions only its stop cuts: within 0.1 %."""
    film = lb.Film(12.0, 8.0, 48, 32)
    for lens, f_number in ((landscape(), 16.0), (lenses.load("lv-zeiss-planar-t-50f14"), 8.0)):
        camera = lb.LensCamera(lens, film, 2000.0, f_number)
        assert camera.disperses
        picture = lb.render(camera, lb.builtin_scene("white-wall"), samples=65)
        rows = picture.mean((0, 1))
        assert rows == pytest.approx(rows[1], rel=1e-3)
        middle = picture[14:18, 22:26].mean((0, 1))
        assert middle == pytest.approx(middle[1], rel=1e-3)


def test_a_corner_is_as_dark_in_each_colour_as_quadrature_says():
    """A fast lens vignettes each wavelength a little differently; the axis is 1 in all of them."""
    film = lb.Film(36.0, 24.0, 60, 40)
    camera = lb.LensCamera(lenses.load("lv-zeiss-planar-t-50f14"), film, 2000.0)
    picture = lb.render(camera, lb.builtin_scene("white-wall"), samples=1 + 8 * 24)
    rows, columns = np.mgrid[0:40, 0:60]
    radii = np.hypot((0.5 - (columns + 0.5) / 60) * 36.0, ((rows + 0.5) / 40 - 0.5) * 24.0)
    for i, channel in enumerate(CHANNELS):
        light = np.zeros(60)
        for wavelength in WAVELENGTHS[channel]:
            pupil = lb.exit_pupil(camera.lens, camera.film_distance, np.linspace(0.0, 21.7, 60), wavelength, points=129)
            light += pupil.cos4_area / pupil.cos4_area[0] / 8.0
        for low in (0.0, 5.0, 10.0, 15.0, 19.0):
            ring = (radii >= low) & (radii < low + 3.0)
            expected = np.interp(radii[ring], pupil.film_radii, light).mean()
            assert picture[..., i][ring].mean() == pytest.approx(expected, abs=2e-3)


def test_a_lens_without_dispersion_takes_the_very_picture_of_the_d_line():
    film, scene = lb.Film(36.0, 24.0, 60, 40), lb.builtin_scene("still-life")
    plain = lenses.load("pbrt-dgauss-50mm")
    assert not lb.LensCamera(plain, film, 1200.0).disperses
    for dispersion in (None, False, True):
        picture = lb.render(lb.LensCamera(plain, film, 1200.0, dispersion=dispersion), scene, samples=3)
        assert np.array_equal(picture, lb.render(lb.LensCamera(plain, film, 1200.0), scene, samples=3))
    spread = lenses.load("lv-czj-tessar-50-f28")
    bare = replace(spread, surfaces=tuple(replace(s, glass=lb.Glass(s.glass.n_d)) for s in spread.surfaces))
    assert lb.LensCamera(spread, film, 1200.0).disperses
    assert np.array_equal(lb.render(lb.LensCamera(spread, film, 1200.0, dispersion=False), scene, samples=3),
                          lb.render(lb.LensCamera(bare, film, 1200.0), scene, samples=3))
    assert not lb.LensCamera(spread, film, 1200.0, model="thin").disperses


def test_a_cancelled_pass_sets_up_no_camera_of_another_part_of_the_spectrum(monkeypatch):
    camera = lb.LensCamera(lenses.load("lv-czj-tessar-50-f28"), lb.Film(36.0, 24.0, 12, 8), 1200.0)
    rendering = lb.Rendering(camera, lb.builtin_scene("white-wall"))
    assert rendering.add(1, threads=1)
    monkeypatch.setattr(lb.LensCamera, "steps", lambda *_: pytest.fail("a camera was set up"))
    assert not rendering.add(8, threads=1, wanted=lambda: False)


def test_the_first_sample_is_neutral_and_samples_one_by_one_are_those_at_once():
    film, scene = lb.Film(36.0, 24.0, 60, 40), lb.builtin_scene("white-wall")
    camera = lb.LensCamera(landscape(), film, 2000.0)
    by_one, at_once = lb.Rendering(camera, scene), lb.Rendering(camera, scene)
    assert by_one.add(1)
    assert np.ptp(by_one.image(), axis=2).max() == 0.0
    for _ in range(4):
        by_one.add(1, threads=1)
    at_once.add(5)
    assert np.array_equal(by_one.image(), at_once.image())


def test_a_run_of_eight_samples_takes_every_part_of_the_spectrum():
    for seed in (0, 1, 12345):
        parts = [spectral_part(sample, np.uint32(seed)) for sample in range(64)]
        for start in range(0, 64, 8):
            assert sorted(parts[start:start + 8]) == list(range(8))


def test_the_wavelengths_are_the_eighths_of_the_matching_functions():
    """By the fit of Wyman, Sloan and Shirley (2013) and the primaries of sRGB, to the half nanometre of its steps."""
    nm = np.arange(380.0, 751.0, 0.5)

    def lobe(peak, below, above):
        return np.exp(-0.5 * ((nm - peak) * np.where(nm < peak, below, above)) ** 2)

    x = (0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
         - 0.065 * lobe(501.1, 0.0490, 0.0382))
    y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)
    z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725)
    red = np.where(nm > 530.0, 3.2406 * x - 1.5372 * y - 0.4986 * z, 0.0)       # without its violet lobe
    for channel, curve in zip(CHANNELS, (red, -0.9689 * x + 1.8758 * y + 0.0415 * z,
                                         0.0557 * x - 0.2040 * y + 1.0570 * z), strict=True):
        share = np.cumsum(np.maximum(curve, 0.0))
        expected = np.interp((np.arange(8) + 0.5) / 8, share / share[-1], nm) / 1e3
        assert WAVELENGTHS[channel] == pytest.approx(expected, abs=5e-4)


def test_a_glass_that_is_not_known_in_all_colours_gives_a_picture_of_the_d_line_or_is_refused():
    narrow = lb.Glass(1.62, 36.4, "NARROW", "cauchy", (1.6, 0.007), (0.5, 0.7))
    film = lb.Film(36.0, 24.0, 60, 40)
    assert not lb.LensCamera(landscape(narrow), film, 2000.0).disperses
    with pytest.raises(lb.CameraError, match=r"NARROW is known from 0\.5 to 0\.7 µm"):
        lb.LensCamera(landscape(narrow), film, 2000.0, dispersion=True)


def test_rays_of_a_wavelength_bend_as_the_reference_bends_them():
    camera = lb.LensCamera(landscape(), lb.Film(30.0, 20.0, 300, 200), 3000.0)
    raster, uv = np.array([[30.0, 40.0], [250.0, 120.0]]), np.array([[0.3, 0.4], [0.7, 0.2]])
    for wavelength in (0.43, lb.D_LINE, 0.65):
        rays = camera.generate_rays(raster, uv, wavelength=wavelength)
        shift = [0.0, 0.0, camera.lens.length + camera.film_distance]
        back = lb.trace(camera.lens, rays.origins + shift - rays.directions * -100.0, -rays.directions, wavelength)
        assert (back.fate == lb.Fate.PASSED).all()
        film = back.points + back.directions * ((shift[2] - back.points[:, 2]) / back.directions[:, 2])[:, None]
        expected = np.column_stack([(0.5 - raster[:, 0] / 300) * 30.0, (raster[:, 1] / 200 - 0.5) * 20.0])
        assert film[:, :2] == pytest.approx(expected, abs=1e-9)
