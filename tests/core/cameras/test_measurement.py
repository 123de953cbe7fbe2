"""The measurement equation: what a uniform scene gives in every camera, falloff in its parts, distortion."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.exposure import RADIANCE
from tests.core.oracles import of_one_colour

FILM = lb.Film(36.0, 24.0, 48, 32)
SKY = lb.Scene("sky", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))
SECONDS = 0.02


def disk_light(offset, distance, radius):
    """E of a point under a parallel disk of radiance 1, `offset` from its axis: π/2 (1 − …), in closed form."""
    d2, h2, r2 = np.asarray(offset) ** 2, distance**2, radius**2
    return 0.5 * math.pi * (1.0 - (d2 + h2 - r2) / np.sqrt((d2 + h2 + r2) ** 2 - 4.0 * d2 * r2))


def over_the_film(function, film=FILM, points=48):
    """The mean over the film of a function of the distance from its middle, by Gauss's rule."""
    node, weight = np.polynomial.legendre.leggauss(points)
    x, y = np.meshgrid(0.5 * film.width * node, 0.5 * film.height * node)
    return (np.outer(weight, weight) * function(np.hypot(x, y))).sum() / 4.0


def lens_light(camera):
    """E over the radius of the film, from the solved exit pupils."""
    radii = np.linspace(0.0, 0.5 * camera.film.diagonal, 400)
    light = lb.falloff(camera.lens, camera.film_distance, radii).irradiance
    return lambda r: np.interp(r, radii, light)


def kind(name, weights):
    """A camera by its name, and its E for radiance 1 over the distance from the film's middle."""
    fields = {"weights": weights, "shutter_close": SECONDS}
    if name == "perspective":
        camera = lb.PerspectiveCamera(FILM, fov=0.9, lens_radius=6.0, focus_distance=700.0, **fields)
        return camera, lambda r: disk_light(r, camera.film_distance, 6.0)
    if name == "hole":
        return lb.PinholeCamera(FILM, 40.0, 1.5, **fields), lambda r: disk_light(r, 40.0, 1.5)
    if name == "bare":
        return lb.BareSensor(FILM, **fields), lambda r: math.pi + 0.0 * r
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, math.inf if name == "thin" else 1500.0, 4.0,
                           model=name, dispersion=False, **fields)
    fo = camera.first_order
    if name == "thin":
        return camera, lambda r: disk_light(r, fo.efl, fo.entrance_pupil.radius)
    if name == "thick":
        away = camera.lens.length + camera.film_distance - fo.exit_pupil.z
        return camera, lambda r: disk_light(r, away, fo.exit_pupil.radius)
    return camera, lens_light(camera)


@pytest.mark.parametrize("weights", ["relative", "physical"])
@pytest.mark.parametrize("name", ["perspective", "hole", "bare", "trace", "polynomial", "thick", "thin"])
def test_a_uniform_scene_integrates_to_the_quadrature_value(name, weights):
    """Within 0.1 %, over the whole film: both forms of weights, by 400,000 samples of a net."""
    camera, light = kind(name, weights)
    image = lb.render(camera, SKY, samples=256).astype(float)
    expected = over_the_film(light)
    expected *= SECONDS if weights == "physical" else 1.0 / float(light(np.zeros(1))[0])
    assert image.mean() == pytest.approx(expected, rel=1e-3)


def test_cameras_without_an_opening_see_a_uniform_scene_as_it_is():
    """1 wherever a camera looks: over the whole film, or the disk of a fisheye's image, whose edge cuts pixels."""
    for camera, part in ((lb.PerspectiveCamera(FILM, fov=1e-3), 1.0),
                         (lb.OrthographicCamera(FILM, 500.0), 1.0),
                         (lb.OrthographicCamera(FILM, 500.0, 20.0, 900.0), 1.0),
                         (lb.EnvironmentCamera(FILM), 1.0),
                         (lb.EnvironmentCamera(FILM, layout="cube-map"), 0.5),
                         *((lb.FisheyeCamera(FILM, 2.8, projection), math.pi * 12.0**2 / (36.0 * 24.0))
                           for projection in ("equidistant", "equisolid", "stereographic", "orthographic"))):
        assert lb.render(camera, SKY, samples=256).mean() == pytest.approx(part, rel=1e-3)


def test_a_pinholes_picture_falls_by_cos4_over_the_whole_film():
    camera = lb.PerspectiveCamera(FILM, fov=1.3)
    expected = over_the_film(lambda r: (1.0 + (r / camera.film_distance) ** 2) ** -2)
    assert lb.render(camera, SKY, samples=256).mean() == pytest.approx(expected, rel=1e-3)


def test_a_telecentric_cameras_light_is_that_of_its_cone_times_its_scale():
    """π sin² of the cone in the scene, as dense on the film as the scale is large: (500 / 36)², times the time."""
    camera = lb.OrthographicCamera(FILM, 500.0, 20.0, 900.0, weights="physical", shutter_close=SECONDS)
    expected = math.pi * 20.0**2 / (20.0**2 + 900.0**2) * (500.0 / 36.0) ** 2 * SECONDS
    assert lb.render(camera, SKY, samples=64).mean() == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lentil-nikon-retrofocus-1971", "pbrt-fisheye-10mm"])
def test_on_the_axis_irradiance_is_pi_sin2_and_the_picture_holds_its_joules(name):
    """A film of 0.2 mm about the axis, within the noise, 0.3 %; E, H and the energy of a pixel follow each other."""
    film = lb.Film(0.2, 0.2, 16, 16)
    camera = lb.LensCamera(lenses.load(name), film, 2000.0, 5.6, weights="physical", shutter_close=SECONDS)
    image = lb.render(camera, SKY, samples=64).astype(float)
    sine = 1.0 / (2.0 * lb.working_f_number(camera.lens, camera.film_distance))
    assert lb.irradiance(image, camera.effective_time).mean() == pytest.approx(RADIANCE * math.pi * sine**2, rel=3e-3)
    np.testing.assert_allclose(lb.radiant_exposure(image), lb.irradiance(image, SECONDS) * SECONDS, rtol=1e-12)
    area = 0.2e-3**2
    assert lb.pixel_energy(image, film).sum() / 3.0 == pytest.approx(
        lb.radiant_exposure(image).mean() * area, rel=1e-12)
    assert lb.falloff(camera.lens, camera.film_distance, [0.0]).irradiance[0] == pytest.approx(
        math.pi * sine**2, rel=1e-4)


def holes(*radii_and_gaps):
    """A "lens" of openings alone: radius, gap, radius, gap, … (mm), the first one its stop."""
    pairs = zip(radii_and_gaps[::2], radii_and_gaps[1::2], strict=True)
    return lb.Lens(tuple(lb.Surface(gap, radius, curvature=0.0) for radius, gap in pairs), 0)


def test_one_opening_has_natural_falloff_alone_and_that_is_the_closed_form():
    radii = np.linspace(0.0, 40.0, 9)
    found = lb.falloff(holes(3.0, 0.0), 30.0, radii)
    light = disk_light(radii, 30.0, 3.0)
    np.testing.assert_allclose(found.vignetting, 1.0, atol=1e-9)
    np.testing.assert_allclose(found.natural, light / light[0], rtol=1e-6)
    np.testing.assert_allclose(found.irradiance, light, rtol=1e-6)
    # and that is cos⁴ of a point of the film, for a small opening
    small = lb.falloff(holes(0.01, 0.0), 30.0, radii)
    np.testing.assert_allclose(small.total, (1.0 + (radii / 30.0) ** 2) ** -2, rtol=1e-6)
    np.testing.assert_allclose(small.stops, -2.0 * np.log2(1.0 + (radii / 30.0) ** 2), atol=1e-5)


def test_two_openings_vignette_by_the_overlap_of_two_circles():
    """The front opening, seen from the film on the plane of the rear one: its circle shrinks and moves."""
    front, gap, rear, distance = 5.0, 12.0, 5.0, 20.0
    radii = np.linspace(0.0, 12.0, 13)
    found = lb.falloff(holes(front, gap, rear, 0.0), distance, radii)
    scale = distance / (distance + gap)
    a, b, d = rear, front * scale, radii * (1.0 - scale)
    with np.errstate(invalid="ignore", divide="ignore"):
        lens_shape = (a * a * np.arccos(np.clip((d * d + a * a - b * b) / (2 * d * a), -1, 1))
                      + b * b * np.arccos(np.clip((d * d + b * b - a * a) / (2 * d * b), -1, 1))
                      - 0.5 * np.sqrt(np.clip((-d + a + b) * (d + a - b) * (d - a + b) * (d + a + b), 0, None)))
    area = np.where(d <= a - b, math.pi * b * b, lens_shape)
    np.testing.assert_allclose(found.vignetting, area / area[0], atol=2e-4)
    assert found.vignetting[0] == 1.0 and found.vignetting[-1] < 0.6
    np.testing.assert_array_equal(found.total, found.natural * found.vignetting)
    beyond = lb.falloff(holes(front, gap, rear, 0.0), distance, [40.0])
    assert beyond.total[0] == 0.0 and beyond.stops[0] == -math.inf


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lentil-nikon-retrofocus-1971", "lenshh-us4338001-tele"])
def test_distortion_is_that_of_the_chief_rays_from_far_objects(name):
    """The chief ray by the other way: from the scene, aimed at the middle of the stop, to the film."""
    lens = lenses.load(name)
    fo, distance = lb.first_order(lens), lb.film_distance(lens, math.inf)
    found = lb.distortion(lens, distance, np.linspace(0.0, 18.0, 7))
    for r, angle, ideal in zip(found.radii[1:], found.angles[1:], found.ideal[1:], strict=True):
        ray = lb.chief_ray(lens, float(angle))
        landed = ray.points[-1] + ray.direction * (lens.length + distance - ray.points[-1][2]) / ray.direction[2]
        assert abs(landed[1]) == pytest.approx(r, rel=1e-7)
        assert ideal == pytest.approx(fo.efl * math.tan(angle), rel=1e-12)
    assert found.percent[0] == 0.0 and found.angles[0] == pytest.approx(0.0, abs=1e-12)
    assert found.percent[-1] == pytest.approx(100.0 * (18.0 / found.ideal[-1] - 1.0))


@pytest.mark.parametrize("wavelength", [lb.D_LINE, 0.4358])
@pytest.mark.parametrize("focus", [math.inf, 9000.0])
@pytest.mark.parametrize("index", [1.0, 1.333])
def test_close_to_the_axis_no_lens_distorts_its_own_scale(index, focus, wavelength):
    """In water, near and in blue light too: distortion begins with the square of the radius, here 1e-6 of it."""
    lens = replace(lenses.load("lib-tronnier-1953"), front_index=index)
    away = lb.film_distance(lens, focus)
    found = lb.distortion(lens, away, [0.05, 0.1], wavelength=wavelength)
    assert np.isfinite(found.ideal).all() and found.percent == pytest.approx([0.0, 0.0], abs=1e-3)
    of_blue = lb.distortion(of_one_colour(lens, wavelength), away, [5.0, 15.0])
    np.testing.assert_allclose(lb.distortion(lens, away, [5.0, 15.0], wavelength=wavelength).ideal, of_blue.ideal,
                               rtol=1e-9)


def test_lenses_distort_as_their_kinds_do():
    """A retrofocus lens bulges, a telephoto pulls in; a wide one of many elements turns from the one to the other."""
    for name, kind in (("lentil-nikon-retrofocus-1971", "barrel"), ("lenshh-us4338001-tele", "pincushion"),
                       ("pbrt-wide-22mm", "moustache")):
        lens = lenses.load(name)
        assert lb.distortion(lens, lb.film_distance(lens, math.inf), np.linspace(0.0, 21.6, 20)).kind == kind


def test_a_symmetric_lens_at_its_own_size_has_no_distortion():
    """By symmetry about the stop a chief ray leaves as it came, at −1: third order and beyond, whatever its power."""
    glass = lb.Glass(1.6)
    half = (lb.Surface(4.0, 12.0, glass, curvature=1.0 / 20.0), lb.Surface(6.0, 11.0, curvature=1.0 / 28.0))
    lens = lb.Lens((*half, lb.Surface(6.0, 2.0, curvature=0.0), lb.Surface(4.0, 11.0, glass, curvature=-1.0 / 28.0),
                    lb.Surface(0.0, 12.0, curvature=-1.0 / 20.0)), 2)
    fo = lb.first_order(lens)
    radii = np.linspace(0.0, 14.0, 8)
    at_one = lb.distortion(lens, fo.bfl + fo.efl, radii)
    np.testing.assert_allclose(at_one.ideal, radii, rtol=1e-9)
    assert at_one.kind == "none"
    assert lb.distortion(lens, fo.bfl, radii).kind != "none"


def test_fisheyes_follow_one_of_their_projections():
    for name, projections in (("lib-miyamoto-fisheye-1964", {"equidistant", "equisolid"}),
                              ("lenshh-laikin-fisheye160-f2", {"equisolid"})):
        lens = lenses.load(name)
        distance = lb.film_distance(lens, math.inf)
        radii = np.linspace(0.0, 7.5, 12)
        best = lb.distortion(lens, distance, radii, "best")
        assert best.projection in projections
        assert best.rms < 0.3 * lb.distortion(lens, distance, radii).rms
        assert abs(best.percent[3]) < 2.0
    assert lb.distortion(lenses.load("pbrt-dgauss-50mm"), 35.0, [0.0, 10.0], "best").projection == "rectilinear"


def test_a_grid_bulges_as_its_radii_do():
    lens, film = lenses.load("lentil-nikon-retrofocus-1971"), lb.Film(36.0, 24.0)
    distance = lb.film_distance(lens, 3000.0)
    ideal, real = lb.distortion_grid(lens, distance, film, 9)
    assert ideal.shape == real.shape == (9, 13, 2)
    assert lb.distortion_grid(lens, distance, film, 2)[1].shape == (2, 3, 2)
    np.testing.assert_allclose(ideal[0, 0], [-18.0, -12.0])
    np.testing.assert_allclose(real[4, 6], 0.0, atol=1e-12)
    np.testing.assert_allclose(real[::-1, ::-1], -real, atol=1e-9)
    radius = np.hypot(*real[0, 0])
    percent = 100.0 * (radius / np.hypot(18.0, 12.0) - 1.0)
    assert percent == pytest.approx(lb.distortion(lens, distance, [radius]).percent[0], abs=0.02)
    middle, corner = real[0, 6, 1], real[0, 0, 1]               # a line along the film's edge: barrel
    assert middle < corner < 0.0


def test_a_lens_moved_aside_as_a_whole_draws_the_same_grid():
    """By the search for a decentred lens, of far objects, whose light is the same there."""
    lens, film = lenses.load("lentil-nikon-retrofocus-1971"), lb.Film(36.0, 24.0)
    aside = replace(lens, surfaces=tuple(replace(each, pose=lb.SurfacePose(decentre_x=0.7, decentre_y=-0.4))
                                         for each in lens.surfaces))
    away = lb.film_distance(lens, math.inf)
    ideal, real = lb.distortion_grid(lens, away, film, 5, steps=2)
    assert real.shape == (9, 13, 2) and np.abs(real - ideal).max() > 0.3
    np.testing.assert_allclose(lb.distortion_grid(aside, away, film, 5, steps=2)[1], real, atol=2e-3)
    with pytest.raises(lb.LensError, match="decentred surface is compared"):
        lb.distortion_grid(aside, away, film, projection="equidistant")


def test_light_and_chief_rays_are_not_those_of_the_blades():
    lens = lenses.load("pbrt-dgauss-50mm")
    bladed = replace(lens, blades=6, blade_reach=1.0)
    for one, other in zip(*(lb.distortion(it, 35.0, [0.0, 9.0]).percent for it in (lens, bladed)), strict=True):
        assert one == other


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.distortion(lenses.load("pbrt-dgauss-50mm"), 35.0, [1.0], "flat"), "choose one of rectilinear"),
    (lambda: lb.distortion(holes(3.0, 0.0), 35.0, [1.0]), "afocal"),
    (lambda: lb.distortion_grid(lenses.load("pbrt-dgauss-50mm"), 35.0, FILM, 1), "at least 2"),
    (lambda: lb.falloff(lenses.load("pbrt-dgauss-50mm"), 35.0, [-1.0]), "film radii"),
    (lambda: lb.falloff(lenses.load("pbrt-dgauss-50mm"), 0.0, [1.0]), "behind the lens"),
    (lambda: lb.irradiance(np.ones((1, 1, 3)), 0.0), "open time 0"),
])
def test_invalid_settings_are_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
