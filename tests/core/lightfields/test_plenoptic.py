"""The plenoptic camera: closed forms of the pictures behind microlenses, and the decoded light field."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.lightfields.plenoptic import PlenopticCamera

WHITE = lb.Scene("white", sky=lb.Sky(*[(1.0,) * 3] * 3), enclosed=True)
NARROW = lb.Film(14.4, 9.6, 24, 16)


def camera(focus=1200.0, film=NARROW, fov=0.192, radius=8.9):
    return lb.PerspectiveCamera(film, fov=fov, lens_radius=radius, focus_distance=focus)


def psnr(a, b, edge=12):
    """Decibels, linear, clipped to [0, 1], peak 1, away from the border."""
    a, b = (np.clip(picture[edge:-edge, edge:-edge], 0.0, 1.0) for picture in (a, b))
    return -10.0 * math.log10(np.mean((a - b) ** 2))


def test_matched_microlenses_fill_their_pictures_exactly():
    plenoptic = PlenopticCamera(camera(), 15)
    assert plenoptic.fill == pytest.approx(1.0, abs=1e-12) and plenoptic.spilled == 0.0
    k, white = 15, plenoptic.expose(WHITE, 64).white
    disk = white[8 * k:9 * k, 12 * k:13 * k]                # just beside the axis
    for line in (disk[k // 2], disk[:, k // 2]):
        assert (line[1:-1] > 0.9).all() and line[[0, -1]].min() > 0.5
    assert disk[0, 0] == 0.0
    # A disk in its square, less what cos⁴θ takes: ∫ cos⁴θ dA is sin² for tan² of the cone. Seen from the microlens's
    # sides the pupil stands aside by 0.3 mm of its 8.9: so much of the rim is another picture's
    tangent = 0.5 / plenoptic.main_f_number
    assert disk.mean() == pytest.approx(math.pi / 4.0 / (1.0 + tangent**2), rel=5e-3)


def test_the_pictures_lie_where_a_pupil_at_a_finite_distance_puts_them():
    plenoptic = PlenopticCamera(camera(fov=0.8, radius=2.0), 9)
    distance = plenoptic.camera.film_distance
    shift = plenoptic.microlens_f_number * 7.2 / distance
    assert shift > 2.0                          # pictures, at the film's edge, where microlenses saw a pupil far away
    white = plenoptic.expose(WHITE, 32).white.reshape(16, 9, 24, 9)
    place, mass = np.arange(9) - 4.0, white.sum((1, 3))
    # cos⁴θ alone leans a picture inwards: a disk of radius R by R/4 of what cos⁴θ changes along R
    tangent = math.hypot(7.2, 4.8) / distance
    most = 4.5 / 4.0 * 4.0 * tangent / (1.0 + tangent**2) * 0.5 / plenoptic.main_f_number
    assert np.abs(np.einsum("abcd,d->ac", white, place) / mass).max() < most < 0.5
    assert np.abs(np.einsum("abcd,b->ac", white, place) / mass).max() < most


@pytest.mark.parametrize("ratio", [0.5, 1.25, 1.5, 2.0])
def test_pictures_overlap_or_leave_pixels_dark_by_the_ratio_of_f_numbers(ratio):
    matched = PlenopticCamera(camera(), 15)
    plenoptic = replace(matched, f_number=ratio * matched.matched_f_number)
    assert plenoptic.fill == pytest.approx(plenoptic.microlens_f_number / plenoptic.main_f_number / plenoptic.spread)
    assert plenoptic.fill == pytest.approx(ratio, rel=0.04)             # the pupil is not infinitely far
    inner = plenoptic.expose(WHITE, 32).white[45:-45, 45:-45]
    tangent = 0.5 / plenoptic.main_f_number
    assert inner.mean() == pytest.approx(math.pi / 4.0 * plenoptic.fill**2 / (1.0 + tangent**2), rel=0.01)
    # Pixels that an edge runs through are neither dark nor lit: count their light
    lit = np.minimum(inner / (1.0 + tangent**2) ** -2, 1.0)
    assert lit.mean() == pytest.approx(plenoptic.used, abs=0.02)
    assert (plenoptic.spilled > 0.0) == (ratio > 1.0)
    assert plenoptic.used == pytest.approx(math.pi / 4.0 * plenoptic.fill**2 * (1.0 - plenoptic.spilled))


@pytest.mark.slow
def test_all_light_that_falls_on_the_film_falls_on_the_sensor():
    scene, plenoptic = lb.builtin_scene("room"), PlenopticCamera(camera(), 9)
    # Irradiance in units of radiance: π sin² of the cone for the film; f-numbers for the sensor's pixels
    sine2 = 1.0 / (1.0 + (2.0 * plenoptic.main_f_number) ** 2)
    film = lb.render(plenoptic.camera, scene, 1024).mean() * math.pi * sine2
    sensor = plenoptic.expose(scene, 64).picture.mean() * (plenoptic.spread / plenoptic.microlens_f_number) ** 2
    assert sensor == pytest.approx(film, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("distance, least", [(1200.0, 43.0), (900.0, 33.0), (2500.0, 38.0)])
def test_its_light_field_refocuses_at_the_resolution_of_the_microlenses(field, distance, least):
    film = lb.Film(14.4, 9.6, 120, 80)
    direct = lb.render(camera(distance, film), lb.builtin_scene("room"), 512)
    again = field.refocus(distance)
    # Microlenses leave their views' grids alike: detail finer than they are is seen as false detail away from the focus
    assert psnr(again, direct) > least and field.views == (9, 9) and again.shape == (80, 120, 3)
    assert again.mean() == pytest.approx(direct.mean(), rel=0.01)


@pytest.fixture(scope="module")
def field():
    return PlenopticCamera(camera(film=lb.Film(14.4, 9.6, 120, 80)), 9).expose(lb.builtin_scene("room"), 12).decoded()


@pytest.mark.slow
def test_its_field_is_what_a_lens_records(field):
    recorded = lb.capture_light_field(field.camera, lb.builtin_scene("room"), (9, 9), 12)
    assert field.reach == pytest.approx(recorded.reach, abs=1e-12)
    # To noise: 80 × 120 × 12 samples where an edge runs through the cell
    assert np.abs(field.coverage.astype(float) - recorded.coverage).mean((2, 3)).max() < 0.1
    assert np.abs((field.coverage.astype(float) - recorded.coverage).mean((2, 3))).max() < 0.01
    # The lens records its views aside by parts of a pixel, so that they are not alike one by one
    assert psnr(field.refocus(1200.0, 8.0), recorded.refocus(1200.0, 8.0)) > 36.0


def test_behind_a_microlens_things_beyond_the_focus_are_upside_down():
    """A wall, white to the right of the axis: from beyond the focus it is seen by the left of the pupil."""
    # From far off, so that a microlens's place in the scene is small beside the pupil
    plenoptic = PlenopticCamera(camera(film=lb.Film(15.0, 10.2, 25, 17), fov=0.0192), 9)
    for depth, left, right in ((2400.0, 1.0, 0.0), (600.0, 0.0, 1.0)):
        wall = lb.Rectangle((500.0, 0.0, -depth), (500.0, 0.0, 0.0), (0.0, 900.0, 0.0),
                            lb.Material((1.0,) * 3, "light"))
        picture = plenoptic.expose(lb.Scene("edge", sky=lb.Sky(*[(0.0,) * 3] * 3), plates=(wall,)), 16).behind(12, 8)
        assert picture[4, 2, 0] == pytest.approx(left, abs=0.05) and picture[4, 6, 0] == pytest.approx(right, abs=0.05)


@pytest.mark.slow
def test_a_real_lens_vignettes_the_pictures_at_the_edge():
    lens = lenses.load("pbrt-dgauss-50mm")
    main = lb.LensCamera(lens, lb.Film(36.0, 24.0, 36, 24), 1200.0)
    raw = PlenopticCamera(main, 9).expose(lb.builtin_scene("room"), 16)
    areas = raw.white.reshape(24, 9, 36, 9).sum((1, 3))
    assert areas[0, 0] < 0.6 * areas[12, 18]
    # π/4 of 81 pixels; the working f-number of small angles is to first order
    assert areas[12, 18] == pytest.approx(math.pi / 4.0 * 81.0, rel=0.06)
    direct = lb.render(main, lb.builtin_scene("room"), 512)
    assert psnr(raw.decoded().refocus(1200.0), direct, 3) > 38.0


def test_invalid_arguments_are_refused():
    for wrong, says in (({"pixels": 0}, "whole number"), ({"pixels": 2.5}, "whole number"),
                        ({"f_number": -1.0}, "positive number")):
        with pytest.raises(lb.LightFieldError, match=says):
            PlenopticCamera(camera(), **wrong)
    with pytest.raises(lb.LightFieldError, match="as wide as high"):
        PlenopticCamera(camera(film=lb.Film(14.4, 9.6, 24, 20)))
    with pytest.raises(lb.LightFieldError, match="pinhole"):
        PlenopticCamera(camera(radius=0.0))
    with pytest.raises(lb.LightFieldError, match="GB that are free"):
        PlenopticCamera(camera(film=lb.Film(36.0, 24.0, 9000, 6000)), 65).expose(WHITE)
    with pytest.raises(lb.LightFieldError, match="cancelled"):
        PlenopticCamera(camera(), 3).expose(WHITE, 1, progress=lambda share: False)
