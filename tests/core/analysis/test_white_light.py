"""White light of analyses against the pictures of edges, and against all 24 wavelengths of a picture."""

from math import inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.spectrum import PICTURE, WAVELENGTHS
from lensbench.core.kernels.block import BLUE, GREEN, RED

LUMINANCE = {RED: 0.2126, GREEN: 0.7152, BLUE: 0.0722}      # IEC 61966-2-1
ALL = [(line, LUMINANCE[channel] / 8.0) for channel, lines in WAVELENGTHS.items() for line in lines]
LINE_PAIRS = np.array([10.0, 20.0, 30.0, 40.0])
DISTANCE, LARGE = 2000.0, 4000.0        # mm, from the film to the edge, and half the side of its bright half-plane
PIXELS, PITCH = 800, 0.001              # mm


def edge_mtf(camera, axis):
    """MTF (4,) of the luminance of a rendered edge across x (axis 0) or y (1): Fourier transform of its slope."""
    film = camera.film
    centre = camera.generate_rays(np.array([[0.5 * film.pixels_x, 0.5 * film.pixels_y]]), np.array([[0.5, 0.5]]))
    origin, way = centre.origins[0], centre.directions[0]
    place = origin - way * (DISTANCE + origin[2]) / way[2]

    def luminance(offset):
        middle = place.copy()
        middle[axis] += offset
        plate = lb.Rectangle(tuple(middle), (LARGE, 0.0, 0.0), (0.0, LARGE, 0.0), lb.Material((1.0, 1.0, 1.0), "light"))
        scene = lb.Scene(sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3), plates=(plate,))
        return (lb.render(camera, scene, samples=256) @ list(LUMINANCE.values())).mean(axis)

    slope = np.diff(luminance(LARGE) / luminance(0.0))          # over the even light, which falls off with the field
    waves = np.exp(-2j * np.pi * LINE_PAIRS[:, None] * PITCH * np.arange(len(slope)))
    return np.abs(waves @ slope) / abs(slope.sum()) / np.sinc(LINE_PAIRS * PITCH)


@pytest.mark.parametrize(("name", "height"), [
    ("sigma-dg-hsm-art-35-f14", 10.0), ("sigma-dg-hsm-art-35-f14", 0.0), ("lib-tronnier-1953", 8.0),
    ("mamiya-sekor-af-55-f28", 12.0)])
def test_white_is_that_of_the_picture_of_an_edge(name, height):
    lens = lenses.load(name)
    for axis in (0, 1):                 # an edge across x shows the sagittal contrast of a field up, across y the other
        sides = (PIXELS, 8) if axis == 0 else (8, PIXELS)
        camera = lb.LensCamera(lens, lb.Film(sides[0] * PITCH, sides[1] * PITCH, *sides), focus_distance=DISTANCE,
                               film_pose=lb.FilmPose(rise=height))
        away = DISTANCE - camera.film_distance - camera.lens.length
        given = lb.analysis.conditions(camera.lens, fields=[height], wavelengths="picture", object_distance=away)
        rays = lb.analysis.ray_grid(camera.lens, camera.film_distance, given, 64)
        white = lb.analysis.mtf(rays, LINE_PAIRS, "geometric").white_modulus[0, axis]
        # 0.01, of which the noise of 256 × 8 samples a step of the edge is a half
        np.testing.assert_allclose(white, edge_mtf(camera, axis), atol=0.01)


def test_the_rule_of_the_picture_integrates_polynomials_like_all_its_wavelengths():
    (few, weights), (lines, shares) = np.array(PICTURE).T, np.array(ALL).T
    assert weights.sum() == pytest.approx(1.0, abs=5e-5)
    x, y = ((1.0 / each - 1.9) / 0.5 for each in (few, lines))         # −1 … 1
    for power in range(12):
        assert weights @ x**power == pytest.approx(shares @ y**power, abs=2e-4)        # the rule's five digits


@pytest.mark.parametrize("name", ["sigma-dg-hsm-art-35-f14", "mamiya-af-apo-if-300-f45", "zhong-yi-creator-28-f56",
                                  "canon-new-fd-l-150-600-f56", "lentil-kodak-petzval-1948"])
@pytest.mark.parametrize("method", ["diffraction", "geometric"])
def test_the_rule_of_the_picture_has_the_contrast_of_all_its_wavelengths(name, method):
    lens = lenses.load(name)
    away = lb.film_distance(lens, inf)

    def contrast(wavelengths):
        heights = np.array([0.0, 0.35, 0.7]) * 0.5 * np.hypot(*(lens.film_size or (36.0, 24.0)))
        given = lb.analysis.conditions(lens, fields=heights, wavelengths=wavelengths)
        return lb.analysis.mtf(lb.analysis.ray_grid(lens, away, given, 64), LINE_PAIRS, method).white_modulus

    np.testing.assert_allclose(contrast("picture"), contrast(ALL), atol=0.005)
    assert np.abs(contrast("fdc") - contrast(ALL)).max() > 0.02         # F, d and C alike are another light


def test_named_white_light():
    lens, plain = lenses.load("lib-tronnier-1953"), lenses.load("pbrt-dgauss-50mm")
    assert lb.analysis.conditions(lens, wavelengths="fdc").wavelengths == lb.analysis.conditions(lens).wavelengths
    assert lb.analysis.conditions(lens, wavelengths="lens") == lb.analysis.conditions(lens)
    photopic = lb.analysis.conditions(lens, wavelengths="photopic")
    assert photopic.primary_wavelength == 0.555 and max(photopic.weights) == photopic.weights[photopic.primary]
    assert any("weighted as the picture" in str(each) for each in
               lb.analysis.conditions(lens, wavelengths="picture").findings)
    assert len(lb.analysis.conditions(plain, wavelengths="picture").wavelengths) == 3       # no glass disperses
    with pytest.raises(lb.LensError, match="choose one of picture, photopic, lens, fdc"):
        lb.analysis.conditions(lens, wavelengths="blue")
