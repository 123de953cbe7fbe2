"""Depth from a light field: the scene's depth where there is detail, and the picture in focus everywhere."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.lightfields.depth import SHIFT_ERROR
from tests.core.lightfields.test_light_field import EDGE, FILM, STILL, perspective, psnr, waves

INSIDE = (slice(EDGE, -EDGE), slice(EDGE, -EDGE))


@pytest.fixture(scope="module")
def field():
    return lb.capture_light_field(perspective(1200.0), lb.builtin_scene(STILL), (9, 9), 4)


@pytest.fixture(scope="module")
def found(field):
    return lb.find_depth(field)


def apart(field, distance):
    """How far neighbouring views lie apart that are focused at other distances (mm), in pixels, with its sign."""
    near, far = (1.0 / 400.0, 1e-9)
    turned = np.linspace(far, near, 200)
    lie = np.array([field.shear(1.0 / t)[1] for t in turned]) * 2.0 / 9.0 * FILM.pixels_x / FILM.width
    return np.interp(1.0 / distance, turned, lie)


@pytest.mark.slow
def test_the_depth_is_that_of_the_scene_where_there_is_confidence(field, found):
    true = lb.depth_map(perspective(1200.0), lb.builtin_scene(STILL))
    off = np.abs(apart(field, found.distance) - apart(field, np.minimum(true, 1e9)))[INSIDE]
    sure = found.confidence[INSIDE] > 0.5
    assert 0.5 < sure.mean() < 1.0
    # Of the rest, mirrors show what lies behind them, and rims are as wide as the window
    assert np.median(off[sure]) < 0.05
    assert np.mean(off[sure] < 0.25) > 0.85


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "focus", "off"), [(STILL, 1200.0, 0.06), ("room", 2000.0, 0.2)])
def test_the_error_in_millimetres_holds_for_most_sure_pixels(scene, focus, off):
    """Depths were off by 14 % on the room, and nothing stated it. Mirrors and rims are off by more, hence the range."""
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, focus, 2.8)
    found = lb.find_depth(lb.capture_light_field(camera, lb.builtin_scene(scene), (9, 9), 16))
    true = lb.depth_map(camera, lb.builtin_scene(scene))
    known = (found.confidence > 0.5) & (true < 1e5) & np.isfinite(found.distance)
    wrong, stated = np.abs(found.distance[known] - true[known]), found.error[known]
    assert 0.5 < np.mean(wrong <= stated) < 0.85
    assert 0.4 * off < np.median(stated / found.distance[known]) < 2.0 * off


def test_the_error_of_a_depth_grows_with_the_square_of_its_distance_and_falls_with_the_baseline():
    """Of a thin lens, σ is linear in 1 / distance: the error is SHIFT_ERROR pixels at the pupil's outermost views."""
    camera, reach = perspective(1200.0), 8.9
    rng = np.random.default_rng(1)
    light = rng.random((3, 3, 3, 40, 60)).astype(np.float32)
    found = lb.find_depth(lb.LightField(camera, 1.0, light, np.ones((3, 3, 40, 60), np.float32)), 700.0, 3000.0)
    # A point at z is seen shifted by f B (1/z − 1/focus) on the film, B from the middle to the outermost views
    pixel = FILM.width / FILM.pixels_x
    baseline = reach * (1.0 - 1.0 / 3.0)
    error = SHIFT_ERROR * pixel / (camera.film_distance * baseline) * found.distance.astype(float) ** 2
    # On the ramp of σ over 1/z, read from a table, and with a share of the offsets of the pixel grids
    assert np.median(found.error / error) == pytest.approx(1.0, rel=0.02)


@pytest.mark.slow
def test_the_found_picture_is_in_focus_everywhere(field, found):
    camera = perspective(1200.0, radius=0.0)
    y, x = np.mgrid[0:160, 0:240] + 0.5
    fall = camera.generate_rays(np.stack([x.ravel(), y.ravel()], 1), np.full((x.size, 2), 0.5), np.zeros(x.size))
    sharp = lb.render(camera, lb.builtin_scene(STILL), 256) / fall.weights.reshape(160, 240, 1)
    # A hundredth of the pixels lies at rims and highlights, and has half of the error
    assert psnr(found.picture, sharp) > 28.0
    assert psnr(found.picture, sharp) > psnr(field.view(4, 4), sharp) + 3.0
    assert psnr(found.picture, sharp) > psnr(field.refocus(1200.0), sharp) + 8.0


@pytest.mark.slow
def test_views_of_one_plane_tell_its_distance():
    for dtype in (np.float32, np.float16):
        found = lb.find_depth(waves(dtype=dtype), 700.0, 2000.0)
        # What is between two pixels is read along straight lines, and the least of the cost by a parabola
        assert np.abs(found.distance[INSIDE] - 900.0).max() < 10.0
        assert np.median(np.abs(found.distance[INSIDE] - 900.0)) < 3.0


@pytest.mark.slow
def test_where_nothing_varies_there_is_no_confidence():
    field = waves()
    field.light[...] = 0.5
    assert lb.find_depth(field).confidence.max() < 0.01


def test_invalid_arguments_are_refused(field):
    single = lb.capture_light_field(perspective(1200.0), lb.builtin_scene(STILL), (1, 1), 1)
    with pytest.raises(lb.LightFieldError, match="single view has no depth"):
        lb.find_depth(single)
    with pytest.raises(lb.LightFieldError, match="must be nearer"):
        lb.find_depth(field, 2000.0, 1000.0)
    for nearest in (-1000.0, 0.0, math.nan):
        with pytest.raises(lb.LightFieldError, match="must be positive"):
            lb.find_depth(field, nearest)
    shares = []

    def progress(share):
        shares.append(share)
        return len(shares) < 3

    with pytest.raises(lb.LightFieldError, match="cancelled"):
        lb.find_depth(field, progress=progress)
    assert len(shares) == 3 and 0.0 < shares[0] < shares[-1] < math.inf
