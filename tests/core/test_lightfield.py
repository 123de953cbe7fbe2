"""Light fields: what is focused afterwards is what a camera focused there would have seen."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lightfield import LightField

FILM = lb.Film(14.4, 9.6, 240, 160)             # a part of the full frame at 600 pixels across
EDGE = 24                                       # pixels at the border that views see less of
STILL = "still-life"


def perspective(focus, film=FILM, radius=8.9):
    return lb.PerspectiveCamera(film, fov=0.192, lens_radius=radius, focus_distance=focus)


def real(focus, f_number=2.8):
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, focus, f_number)


def psnr(a, b):
    """Decibels, linear, clipped to [0, 1], peak 1, away from the border."""
    a, b = (np.clip(picture[EDGE:-EDGE, EDGE:-EDGE], 0.0, 1.0) for picture in (a, b))
    return -10.0 * math.log10(np.mean((a - b) ** 2))


@pytest.fixture(scope="module")
def ideal_field():
    return lb.capture_light_field(perspective(1200.0), lb.builtin_scene(STILL), (17, 17), 5)


@pytest.fixture(scope="module")
def real_field():
    return lb.capture_light_field(real(1200.0), lb.builtin_scene(STILL), (9, 9), 16)


@pytest.mark.parametrize("distance", [900.0, 2500.0])
def test_focusing_afterwards_is_focusing_before(ideal_field, distance):
    direct = lb.render(perspective(distance), lb.builtin_scene(STILL), 1024)
    again = ideal_field.refocus(distance)
    # a third of the error is the floor's tiles towards its horizon, which interpolation between pixels blurs
    assert psnr(again, direct) > 38.5
    assert again.mean() == pytest.approx(direct.mean(), rel=0.005)


@pytest.mark.parametrize("distance", [1500.0])
def test_a_real_lens_is_focused_afterwards_too(real_field, distance):
    assert psnr(real_field.refocus(distance), lb.render(real(distance), lb.builtin_scene(STILL), 1024)) > 38.0


def test_a_smaller_aperture_is_part_of_the_one_that_was_recorded(real_field):
    stopped = lb.render(real(1200.0, 5.6), lb.builtin_scene(STILL), 1024)
    # The rim of a small round aperture runs through cells, of which shares are taken: 9 across are 4.5 here
    assert psnr(real_field.refocus(1200.0, 5.6), stopped) > 36.0


def test_one_view_is_what_a_pinhole_at_its_place_sees():
    scene, across, down = lb.builtin_scene(STILL), 2, 0
    field = lb.capture_light_field(perspective(1200.0, radius=3.0), scene, (3, 3), 100)
    u, v = field.places[down, across] * 3.0
    moved = np.eye(4)
    moved[:2, 3] = u, v
    # The pinhole's window is shifted: it sees the same part of the plane in focus, aside by the view's part of a pixel
    half = math.tan(0.096) * 1200.0
    used, _, shifts, _, _ = field._sheared(1200.0, None, (0.0, 0.0))
    aside = -shifts[(used == [down, across]).all(1)][0] * 2.0 / FILM.pixels_y
    x, y = -u / half, -v / half
    window = (x - 1.5 + aside[0], x + 1.5 + aside[0], y - 1.0 - aside[1], y + 1.0 - aside[1])
    hole = lb.PerspectiveCamera(FILM, fov=0.192, world_from_camera=moved, window=window)
    # A cell of 2 mm is no point: the far wall, and the floor's tiles towards its horizon, are blurred by a pixel; the
    # wall's dark corner is left out
    assert psnr(field.view(across, down), lb.render(hole, scene, 256)) > 28.5
    assert psnr(field.view(1, 1), lb.render(hole, scene, 256)) < 25.0


def waves(views=(9, 9), dtype=np.float32):
    """A field whose views are one smooth picture at a depth: shifted as the views' places have it."""
    camera = perspective(1200.0)
    blank = LightField(camera, 1.0, np.zeros((views[1], views[0], 3, 160, 240), dtype),
                       np.ones((views[1], views[0], 160, 240), dtype))
    used, _, shifts, _, _ = blank._sheared(900.0, None, (0.0, 0.0))
    y, x = np.mgrid[0:160, 0:240]
    for (j, i), (across, down) in zip(used, shifts, strict=True):
        for channel, (fx, fy) in enumerate([(6, 4), (15, -10), (2, 16)]):       # whole waves: the edges join
            blank.light[j, i, channel] = 0.5 + 0.4 * np.cos(
                2.0 * math.pi * (fx * (x - across) / 240 + fy * (y - down) / 160))
    return blank


def test_the_slice_of_the_spectrum_is_shear_and_add():
    field = waves()
    for distance in (900.0, 1000.0, 1700.0):
        sheared, sliced = field.refocus(distance), field.slice(distance)
        inside = (slice(EDGE, -EDGE), slice(EDGE, -EDGE))
        assert np.sqrt(np.mean((sheared[inside] - sliced[inside]) ** 2)) < 1e-3


def test_where_the_waves_are_in_focus_they_are_as_they_were():
    y, x = np.mgrid[0:160, 0:240]
    wave = 0.5 + 0.4 * np.cos(2.0 * math.pi * (15 * x / 240 - 10 * y / 160))
    # Half floats have 11 bits; the filter's ripple is the rest
    for dtype in (np.float32, np.float16):
        got = waves(dtype=dtype).refocus(900.0)[EDGE:-EDGE, EDGE:-EDGE, 1]
        assert np.abs(got - wave[EDGE:-EDGE, EDGE:-EDGE]).max() < 2e-3


def test_what_passes_no_light_is_known(ideal_field, real_field):
    # On the axis the disk fills π/4 of the square, less what cos⁴ takes: ∫ cos⁴ dA = π sin² z² of a disk
    tangent = 8.9 / perspective(1200.0).film_distance
    expected = math.pi / 4.0 / (1.0 + tangent**2)
    assert ideal_field._on_axis.mean() == pytest.approx(expected, rel=0.005)
    assert ideal_field.coverage[0, 0].max() == 0.0 and ideal_field.coverage[8, 8].min() > 0.9
    # The corners of the real lens's grid are dark, and vignetting takes from the pupil at the film's edge
    assert real_field.coverage[0, 0].max() == 0.0
    wide = replace(real(1200.0), film=lb.Film(36.0, 24.0, 36, 24))
    whole = lb.capture_light_field(wide, lb.builtin_scene(STILL), (9, 9))
    middle, edge = whole.coverage[4, :, 12, 18].astype(float), whole.coverage[4, :, 12, -1].astype(float)
    assert middle[0] > 0.7 and edge[0] == 0.0 and edge.sum() < 0.7 * middle.sum()
    # What is left leans to one side, by cos⁴ and by vignetting
    assert abs(edge[1:4].sum() - edge[5:8].sum()) > 0.1
    assert real_field.reach == pytest.approx(1.0, abs=0.1)


def test_memory_is_as_announced(ideal_field):
    assert ideal_field.light.nbytes + ideal_field.coverage.nbytes == lb.light_field_bytes(FILM, (17, 17))


def test_a_capture_is_the_same_for_any_number_of_threads():
    film = lb.Film(36.0, 24.0, 30, 20)
    one, two = (lb.capture_light_field(perspective(1200.0, film), lb.builtin_scene(STILL), (3, 2), 2, threads=threads)
                for threads in (1, 2))
    assert np.array_equal(one.light, two.light) and one.views == (3, 2)


def test_views_lie_a_pixel_apart_where_the_clear_range_ends(real_field):
    near, far = real_field.clear_range
    assert near < 1200.0 < far
    for end in (near, far):
        if end not in (real_field.nearest, math.inf):
            assert real_field.apart(end) == pytest.approx(1.0, rel=1e-6)


def test_what_cannot_be_is_said():
    camera, scene = perspective(1200.0), lb.builtin_scene(STILL)
    for views in ((0, 9), (9, -1), (2.5, 2)):
        with pytest.raises(lb.LightFieldError, match="whole numbers of at least 1"):
            lb.capture_light_field(camera, scene, views)
    with pytest.raises(lb.LightFieldError, match="GB that are free"):
        lb.capture_light_field(replace(camera, film=lb.Film(36.0, 24.0, 9000, 6000)), scene, (65, 65))
    with pytest.raises(lb.LightFieldError, match="pinhole"):
        lb.capture_light_field(replace(camera, lens_radius=0.0), scene)
    with pytest.raises(lb.LightFieldError, match="at least 1"):
        lb.capture_light_field(camera, scene, samples=0)
    film = lb.Film(36.0, 24.0, 12, 8)
    with pytest.raises(lb.LightFieldError, match="given up"):
        lb.capture_light_field(perspective(1200.0, film), scene, (2, 2), 1, told=lambda share: False)
    field = lb.capture_light_field(perspective(1200.0, film), scene, (3, 3), 1)
    with pytest.raises(lb.LightFieldError, match="was not recorded"):
        field.refocus(1000.0, 1.0)
    with pytest.raises(lb.LightFieldError, match="leaves what was recorded"):
        field.refocus(1000.0, field.f_number * 2, view=(1.2, 0.0))
    with pytest.raises(lb.LightFieldError, match="positive"):
        field.refocus(1000.0, 0.0)
