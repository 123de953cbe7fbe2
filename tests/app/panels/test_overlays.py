"""What is laid over the picture: circles of confusion against the closed form, and the histogram."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.tone import BINS, histogram
from lensbench.app.plots.blur import Blur
from lensbench.app.settings.settings import Settings


@pytest.mark.parametrize("focus", [400.0, 1200.0, 50_000.0, math.inf])
@pytest.mark.parametrize("f_number", [None, 2.8, 16.0])
def test_the_overlay_shows_the_circles_of_confusion_of_the_closed_form(focus, f_number):
    settings = replace(Settings(), focus_distance=focus, f_number=f_number, focus_position="paraxial")
    depth = np.array([[250.0, 400.0, 1000.0, 1200.0, 8000.0, 1e6]], np.float32)
    blur, stand = Blur.of(settings), bench_of(settings)
    shown = np.array([[blur.pixels(distance, (0.3, 0.7)) for distance in depth[0].tolist()]])
    film_distance = lb.film_distance(stand.lens, focus)
    expected = lb.thick_circle_of_confusion(stand.lens, film_distance, depth[0].astype(float))[None]
    # both in double: what is in focus comes out as a difference of reciprocals of 1/1000 mm, times gains of 1e5 px mm
    np.testing.assert_allclose(shown, expected / settings.film.pitch, rtol=1e-9, atol=1e-9)


def test_a_pinhole_blurs_nothing_and_a_missing_lens_is_no_error():
    assert not Blur.of(replace(Settings(), lens_model="pinhole")).blurs
    assert not Blur.of(replace(Settings(), lens="no-such-lens")).blurs
    assert Blur.of(replace(Settings(), camera="perspective")).blurs


def test_a_grey_picture_stands_in_one_bin_and_exposure_moves_it_to_the_right():
    grey = np.full((50, 80, 3), 0.18, np.float32)
    places = [int(np.argmax(histogram(grey, stops, "filmic")[3])) for stops in (-2.0, 0.0, 1.0)]
    assert places == sorted(places) and len(set(places)) == 3
    shares = histogram(grey, 0.0, "none")
    assert shares.shape == (4, BINS) and (shares.sum(axis=1) == 1.0).all()


def test_a_histogram_bears_what_is_no_number():
    picture = np.full((8, 8, 3), np.nan, np.float32)
    picture[0] = np.inf
    assert np.isfinite(histogram(picture, 0.0, "agx")).all()
