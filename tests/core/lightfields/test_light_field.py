"""Light fields: a refocused picture is that of a camera focused there."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.lightfields.light_field import LightField, spread_offsets
from lensbench.core.lightfields.pupil_cells import Cell, cell_steps
from lensbench.core.lightfields.refocus_kernel import rescaled
from tests.core.cameras.test_camera_kinds import film_point
from tests.core.cameras.test_dispersion import landscape

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


@pytest.mark.parametrize("reach", [0.6, 1.0, 1.7])
def test_the_cells_of_the_pupil_divide_a_square_as_large_as_its_reach(reach):
    """Each is as far from the next as its own side, and the outer ones end at the reach, across and down alike."""
    field = LightField(perspective(1200.0), reach, np.ones((3, 4, 3, 2, 2), np.float32), np.ones((3, 4, 2, 2)))
    u, v = np.moveaxis(field.places, -1, 0)
    for ends, steps, side in ((u[:, [0, -1]], np.diff(u, axis=1), 2.0 * reach / 4),
                              (v[[0, -1]].T, np.diff(v, axis=0), 2.0 * reach / 3)):
        np.testing.assert_allclose(steps, side, rtol=1e-12)
        np.testing.assert_allclose(ends, np.tile([side / 2.0 - reach, reach - side / 2.0], (len(ends), 1)), rtol=1e-12)


@pytest.mark.parametrize(("camera", "blur"), [(perspective(1200.0), 1e-9), (real(1200.0), 0.3)],
                         ids=["ideal lens", "traced lens"])
def test_rays_of_a_film_point_through_all_cells_meet_in_focus(camera, blur):
    """Unit directions, weighed by cos⁴ of the angle at the film; blur: mm there, of the lens's aberrations."""
    x, y = (each.ravel() for each in np.meshgrid([-6.0, 0.0, 5.0], [-4.0, 0.0, 3.0]))
    places = np.array([[0.0, 0.0], [0.3, 0.1], [-0.2, 0.4]])
    crossed = []
    for place in places:
        steps = cell_steps(camera, Cell(tuple(place - 0.05), (0.1, 0.1), 1.0), lb.D_LINE)
        middle = {X: x, Y: y, U0: np.full(9, 0.5), U1: np.full(9, 0.5)}
        found = Program(steps, np.float64).run(middle, [X, Y, Z, L, M, N, WEIGHT], 9)
        origins, ways, weights = found[:3].T, found[3:6].T, found[6]
        np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1.0, rtol=1e-12)
        crossed.append((origins + (-1200.0 - origins[:, 2:]) / ways[:, 2:] * ways)[:, :2])
        to = place * camera.gaussian.approach_pupil + np.stack([x, y], 1) * camera.gaussian.approach_film
        np.testing.assert_allclose(weights, (1.0 + (to**2).sum(1))**-2.0, rtol=1e-12)
    assert np.ptp(crossed, axis=0).max() < blur


@pytest.mark.parametrize("model", ["thick", "thin"])
@pytest.mark.parametrize("distance", [400.0, 900.0, math.inf])
def test_the_shear_gives_the_place_where_rays_of_another_focus_met_the_recording_film(model, distance):
    """Rays of the other focus, by two of their points: the film point and the place in the pupil that have such."""
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 600.0, 2.8, model=model)
    field = LightField(camera, 1.0, np.ones((3, 3, 3, 2, 2), np.float32), np.ones((3, 3, 2, 2), np.float32))
    scale, shear = field.shear(distance)
    raster = np.random.default_rng(4).uniform((0.0, 0.0), (FILM.pixels_x, FILM.pixels_y), (40, 2))
    rays = replace(camera, focus_distance=distance).generate_rays(raster, np.random.default_rng(5).random((40, 2)))
    here, planes = camera.gaussian, np.array([-350.0, -1100.0])
    met = [(rays.origins + ((z - rays.origins[:, 2]) / rays.directions[:, 2])[:, None] * rays.directions)[:, :2]
           for z in planes]
    away = here.z - planes
    ways = np.column_stack([here.origin_film + away * here.slope_film, here.origin_pupil + away * here.slope_pupil])
    film, place = np.linalg.solve(ways, np.reshape(met, (2, -1)))
    x = film_point(FILM, raster).ravel()
    np.testing.assert_allclose(film, scale * x + shear * place, atol=1e-9)


def test_the_grids_of_the_views_are_spread_evenly_over_a_pixel():
    offsets = spread_offsets(15, 11)
    assert offsets.shape == (11, 15, 2) and (offsets >= -0.5).all() and (offsets < 0.5).all()
    for axis in (0, 1):                                 # every fifteenth of a pixel has about its share of 165
        assert np.ptp(np.histogram(offsets[..., axis], 15, (-0.5, 0.5))[0]) <= 4
    assert abs(offsets.mean((0, 1))).max() < 0.01


@pytest.mark.parametrize("scale", [1.0, 0.9, 1.07])
def test_a_rescaled_picture_has_its_middle_where_it_was_and_what_lies_beside_it_at_its_multiple(scale):
    """Waves of 12 pixels and more, well within what Lanczos's kernel keeps; pixels have their middles at halves."""
    middle = np.array([31.5, 22.0])
    x, y = np.arange(64) + 0.5 - middle[0], np.arange(48)[:, None] + 0.5 - middle[1]

    def waves(x, y):
        return np.stack([np.sin(0.4 * x + 0.3 * y), np.cos(0.5 * x + 0.0 * y), np.sin(0.2 * x - 0.45 * y)])

    found = rescaled(waves(x, y).astype(np.float32), scale, middle)[:, 8:-8, 8:-8]
    np.testing.assert_allclose(found, waves(scale * x, scale * y)[:, 8:-8, 8:-8], atol=1e-6 if scale == 1.0 else 0.01)


@pytest.mark.parametrize("distance", [300.0, 500.0, 800.0, 2000.0, math.inf])
def test_refocusing_magnifies_about_the_middle_of_the_picture(distance):
    """Of views that are all the same ramp: their shifts cancel, and the middle stays where it was to 0.003 pixels."""
    ramp = 1.0 + 0.01 * (np.arange(81) - 40.0)
    light = np.broadcast_to((ramp + ramp[:61, None] - ramp[30]).astype(np.float32), (5, 5, 3, 61, 81)).copy()
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 27.1, 81, 61), 500.0, 5.6, model="thin")
    field = LightField(camera, 1.0, light, np.ones((5, 5, 61, 81), np.float32))
    scale = field._shifts_and_weights(distance, None, (0.0, 0.0))[-1]
    assert abs(scale - 1.0) > 0.02 or distance == 500.0
    there, here = (field.refocus(d)[25:36, 35:46] for d in (distance, 500.0))
    assert there.mean() == pytest.approx(here.mean(), abs=0.003 * 0.02)
    assert there[:, -1].mean() - there[:, 0].mean() == pytest.approx(0.1 * scale, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [900.0, 1000.0, 1200.0, 1700.0, 2500.0])
def test_refocusing_is_focusing_before_the_capture(ideal_field, distance):
    direct = lb.render(perspective(distance), lb.builtin_scene(STILL), 1024)
    again = ideal_field.refocus(distance)
    assert psnr(again, direct) > 40.0
    assert again.mean() == pytest.approx(direct.mean(), rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [1500.0])
def test_a_real_lens_is_refocused_too(real_field, distance):
    assert psnr(real_field.refocus(distance), lb.render(real(distance), lb.builtin_scene(STILL), 1024)) > 40.0


@pytest.mark.slow
def test_the_whole_frame_is_refocused_from_what_was_recorded():
    """Edges repeated the last pixel of the views: 29.8 dB at 3 m, and 12 % of pixels were below 0 beside lights.

    At 0.7 m the lens that is focused has moved by 2 mm, which first-order shifts follow in the plane of focus alone.
    """
    film, scene = lb.Film(36.0, 24.0, 240, 160), lb.builtin_scene(STILL)
    field = lb.capture_light_field(replace(real(1200.0), film=film), scene, (9, 9), 32)
    for distance, least in ((700.0, 36.5), (900.0, 38.0), (2000.0, 38.0), (3000.0, 38.0), (5000.0, 38.0)):
        direct = lb.render(replace(real(distance), film=film), scene, 1024)
        again = field.refocus(distance)
        off = np.clip(again, 0.0, 1.0) - np.clip(direct, 0.0, 1.0)
        assert again.min() >= 0.0 and field.recorded(distance).min() == 1.0
        assert -10.0 * math.log10(np.mean(off**2)) > least, distance
        off = np.clip(field.refocus(distance, coarse=True), 0.0, 1.0) - np.clip(direct, 0.0, 1.0)
        assert -10.0 * math.log10(np.mean(off**2)) > 30.0, distance         # 22 without the margin


def test_a_refocused_picture_is_known_within_the_margin_and_black_beyond_it():
    """Of a white world: white wherever any view saw it, whatever the distance, and 0 where none did."""
    white = lb.Scene("white", sky=lb.Sky(*[(1.0,) * 3] * 3), enclosed=True)
    camera = replace(real(1200.0), film=lb.Film(36.0, 24.0, 48, 32))
    field = lb.capture_light_field(camera, white, (9, 9), 1)
    near, far = field.clear_range
    for distance in (near, 2000.0, far):
        assert field.recorded(distance).min() > 0.999 and field.refocus(distance).min() > 0.3
    beyond = replace(field, wide=None)                      # without a margin
    share, picture = beyond.recorded(far), beyond.refocus(far)
    assert share.min() < 0.9 and share[16, 24] > 0.999
    # The lens hides a few cells at the pupil's rim from the edge of the film: alone, they are dark there
    assert np.all(picture[share > 0.1] > 0.3) and np.all(picture[share == 0.0] < 0.3)
    assert field.nbytes == lb.recording_bytes(camera)


@pytest.mark.slow
def test_a_smaller_aperture_is_part_of_the_one_that_was_recorded(real_field):
    stopped = lb.render(real(1200.0, 5.6), lb.builtin_scene(STILL), 1024)
    # The rim of a small round aperture runs through cells, of which shares are taken: 9 across are 4.5 here
    assert psnr(real_field.refocus(1200.0, 5.6), stopped) > 36.0


@pytest.mark.slow
def test_one_view_is_what_a_pinhole_at_its_place_sees():
    scene, across, down = lb.builtin_scene(STILL), 3, 0
    field = lb.capture_light_field(perspective(1200.0, radius=3.0), scene, (5, 5), 40)
    u, v = field.places[down, across] * 3.0
    moved = np.eye(4)
    moved[:2, 3] = u, v
    # The pinhole's window is shifted: it sees the same part of the plane in focus, aside by the view's part of a pixel
    half, pixel = math.tan(0.096) * 1200.0, 2.0 / FILM.pixels_y
    aside = field.offsets[down, across] * pixel
    x, y = -u / half, -v / half
    window = (x - 1.5 + aside[0], x + 1.5 + aside[0], y - 1.0 - aside[1], y + 1.0 - aside[1])
    hole = lb.PerspectiveCamera(FILM, fov=0.192, world_from_camera=moved, window=window)
    direct = lb.render(hole, scene, 64)
    # A cell of 1.2 mm is no point: the far wall, and the floor's tiles towards its horizon, are blurred by half a pixel
    assert psnr(field.view(across, down), direct) > 30.0
    assert psnr(field.view(2, 2), direct) < 25.0


def small(**others):
    """A film of few pixels for as much of the scene."""
    return perspective(1200.0, lb.Film(14.4, 9.6, 120, 80), **others)


@pytest.mark.slow
@pytest.mark.parametrize("scene, others", [
    (STILL, {"medium": lb.Medium.fog(2500.0)}), (STILL, {"medium": lb.Medium.water(6000.0)}),
    ("fairground", {"shutter_close": 1.0 / 30.0})], ids=["fog", "water", "motion"])
def test_fog_water_and_motion_are_recorded_as_a_picture_shows_them(scene, others):
    camera, things = replace(small(), **others), lb.builtin_scene(scene)
    again = lb.capture_light_field(camera, things, (9, 9), 12).refocus(1200.0)
    # Two renders of so many samples differ by 40 decibels at the least, in the fairground
    assert psnr(again, lb.render(camera, things, 512)) > 38.0
    without = replace(camera, medium=None, shutter_close=1e-6)
    assert psnr(again, lb.render(without, things, 64)) < 25.0


@pytest.mark.slow
def test_the_blades_of_an_ideal_lens_are_in_its_light_field():
    camera, things = replace(small(), blades=5), lb.builtin_scene(STILL)
    field = lb.capture_light_field(camera, things, (9, 9), 12)
    direct = lb.render(replace(camera, focus_distance=900.0), things, 512)
    assert psnr(field.refocus(900.0), direct) > 38.0
    # A pentagon takes (5 / 2π) sin 72° of the circle's light, which at this aperture falls off by 1e-3 alone
    whole = lb.capture_light_field(small(), things, (9, 9), 12)
    part = field._on_axis.sum() / whole._on_axis.sum()
    assert part == pytest.approx(5.0 / (2.0 * math.pi) * math.sin(math.radians(72.0)), rel=0.01)
    # F-numbers go by area: a stop of twice the f-number takes a circle of a quarter of the pentagon's
    assert field.f_number == pytest.approx(whole.f_number / math.sqrt(5.0 / (2.0 * math.pi) * math.sin(
        math.radians(72.0))))
    taken = field.shares(2.0 * field.f_number).sum() * (2.0 * field.reach / 9) ** 2
    assert taken == pytest.approx(0.25 * 2.5 * math.sin(math.radians(72.0)), rel=0.02)


@pytest.mark.slow
def test_a_lens_that_disperses_is_recorded_in_colours():
    camera = lb.LensCamera(landscape(), lb.Film(1.92, 1.28, 96, 64), 1200.0)
    edge = lb.Rectangle((100.0, 0.0, -1150.0), (115.0, 0.0, 0.0), (0.0, 400.0, 0.0), lb.Material((0.0,) * 3))
    scene = lb.Scene("edge", sky=lb.Sky(*[(1.0,) * 3] * 3), enclosed=True, plates=(edge,))
    direct = lb.render(camera, scene, 257)
    coloured, plain = (lb.capture_light_field(replace(camera, dispersion=kept), scene, (5, 5), 16).refocus(1200.0)
                       for kept in (True, False))

    def off(picture):
        return np.sqrt(np.mean((picture - direct)[8:-8, 8:-8] ** 2))

    assert np.ptp(direct[8:-8, 8:-8].mean(0), axis=-1).max() > 0.2 and off(coloured) < 0.15 * off(plain)


@pytest.mark.slow
def test_a_moment_is_the_picture_of_a_shutter_open_then():
    fair, whole = lb.builtin_scene("fairground"), replace(small(), shutter_close=1.0 / 15.0)
    field = lb.capture_light_field(whole, fair, (9, 9), 24, moments=2)
    assert field.nbytes == lb.recording_bytes(whole, (9, 9), moments=2)
    mean = field.moments.astype(np.float32).mean(0)
    # Each is rounded to 11 bits
    assert np.allclose(mean, field.light.astype(np.float32), rtol=2e-3, atol=1e-6)
    first, second = (replace(whole, shutter_open=k / 30.0, shutter_close=(k + 1) / 30.0) for k in (0, 1))
    for instant, then, other in zip(field.instants, (first, second), (second, first), strict=True):
        again = instant.refocus(1200.0)
        # As far from a render as the whole exposure, of which it has half the samples
        assert psnr(again, lb.render(then, fair, 512)) > 36.0
        assert psnr(again, lb.render(other, fair, 512)) < 30.0
    with pytest.raises(lb.LightFieldError, match="nothing moves"):
        lb.capture_light_field(small(), lb.builtin_scene(STILL), (2, 2), 1, moments=2)
    with pytest.raises(lb.LightFieldError, match="moments: a whole number"):
        lb.capture_light_field(whole, fair, (2, 2), 1, moments=0)


@pytest.mark.slow
def test_a_lens_with_cylinders_is_refocused_too():
    lens, scene, film = lenses.load("lentil-schneider-anamorphic-31-2001"), lb.builtin_scene(STILL), lb.Film(
        14.4, 12.0, 84, 70)
    field = lb.capture_light_field(lb.LensCamera(lens, film, 2000.0), scene, (9, 9), 6)
    direct = lb.render(lb.LensCamera(lens, film, 1500.0), scene, 256)
    # Most of the picture is finer than these pixels, which costs as much at the distance that was recorded
    assert psnr(field.refocus(1500.0), direct) > max(29.0, psnr(field.refocus(2000.0), direct) + 5.0)
    # Its stop is seen round from about the film's middle; no cell that passes light is beyond the grid
    border = np.concatenate([field._on_axis[[0, -1]].ravel(), field._on_axis[:, [0, -1]].ravel()])
    assert 1.0 <= field.reach < 1.2 and border.max() < 0.8


@pytest.mark.slow
def test_an_off_axis_part_of_the_pupil_is_a_lens_at_its_place():
    scene, radius, place = lb.builtin_scene(STILL), 8.9, (0.5, -0.25)
    part = lb.picture_through(small(), scene, place, 0.4, 512)
    moved = np.eye(4)
    moved[:2, 3] = place[0] * radius, place[1] * radius
    # Its window is shifted: it sees the same part of the plane in focus
    half = math.tan(0.096) * 1200.0
    x, y = -moved[0, 3] / half, -moved[1, 3] / half
    aside = replace(small(radius=0.4 * radius), world_from_camera=moved,
                    window=(x - 1.5, x + 1.5, y - 1.0, y + 1.0))
    # On its film's side that lens has other angles: what cos⁴ makes of a white world is divided out
    white = lb.Scene("white", sky=lb.Sky(*[(1.0,) * 3] * 3), enclosed=True)
    there = lb.render(aside, scene, 512) / lb.render(aside, white, 64)
    assert psnr(part / lb.picture_through(small(), white, place, 0.4, 64), there) > 38.0
    field = lb.capture_light_field(small(), scene, (17, 17), 8)
    assert psnr(field.refocus(1200.0, field.f_number / 0.4, place), part) > 33.0     # a rim of cells


def waves(views=(9, 9), dtype=np.float32):
    """A field whose views are one smooth picture at a depth: shifted as the views' places have it."""
    camera = perspective(1200.0)
    blank = LightField(camera, 1.0, np.zeros((views[1], views[0], 3, 160, 240), dtype),
                       np.ones((views[1], views[0], 160, 240), dtype))
    used, _, shifts, _, _ = blank._shifts_and_weights(900.0, None, (0.0, 0.0))
    y, x = np.mgrid[0:160, 0:240]
    for (j, i), (across, down) in zip(used, shifts, strict=True):
        for channel, (fx, fy) in enumerate([(6, 4), (15, -10), (2, 16)]):       # whole waves: the edges join
            blank.light[j, i, channel] = 0.5 + 0.4 * np.cos(
                2.0 * math.pi * (fx * (x - across) / 240 + fy * (y - down) / 160))
    return blank


@pytest.mark.slow
def test_the_slice_of_the_spectrum_is_shift_and_add():
    field = waves()
    for distance in (900.0, 1000.0, 1700.0):
        sheared, sliced = field.refocus(distance), field.slice(distance)
        inside = (slice(EDGE, -EDGE), slice(EDGE, -EDGE))
        assert np.sqrt(np.mean((sheared[inside] - sliced[inside]) ** 2)) < 1e-3


@pytest.mark.slow
def test_waves_in_focus_keep_their_contrast():
    y, x = np.mgrid[0:160, 0:240]
    wave = 0.5 + 0.4 * np.cos(2.0 * math.pi * (15 * x / 240 - 10 * y / 160))
    # Half floats have 11 bits; the filter's ripple is the rest
    for dtype in (np.float32, np.float16):
        got = waves(dtype=dtype).refocus(900.0)[EDGE:-EDGE, EDGE:-EDGE, 1]
        assert np.abs(got - wave[EDGE:-EDGE, EDGE:-EDGE]).max() < 2e-3


@pytest.mark.slow
def test_cells_that_pass_no_light_are_known(ideal_field, real_field):
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


@pytest.mark.slow
def test_memory_is_as_announced(ideal_field):
    assert ideal_field.nbytes == lb.recording_bytes(perspective(1200.0), (17, 17))


def test_a_capture_is_the_same_for_any_number_of_threads():
    film = lb.Film(36.0, 24.0, 30, 20)
    one, two = (lb.capture_light_field(perspective(1200.0, film), lb.builtin_scene(STILL), (3, 2), 2, threads=threads)
                for threads in (1, 2))
    assert np.array_equal(one.light, two.light) and one.views == (3, 2)


@pytest.mark.slow
def test_views_lie_a_pixel_apart_where_the_clear_range_ends(real_field):
    near, far = real_field.clear_range
    assert near < 1200.0 < far
    for end in (near, far):
        if end not in (real_field.nearest, math.inf):
            assert real_field.apart(end) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("focus", [{"focus_distance": 1200.0, "focus_method": "real"}, {"film_distance": 38.5}],
                         ids=["real rays", "film distance"])
def test_the_clear_range_of_a_lens_is_known_however_it_was_focused(focus):
    """With real rays the nearest distance lies beyond the paraxial one."""
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, **focus)
    field = LightField(camera, 1.0, np.ones((17, 17, 3, 2, 2), np.float32), np.ones((17, 17, 2, 2)))
    assert field.nearest == lb.nearest_focus(camera.lens, camera.focus_method)
    near, far = field.clear_range
    assert field.nearest <= near < camera.focus_distance < far
    assert field.apart(near) <= 1.0 + 1e-9 and field.apart(field.nearest) > 1.0
    assert field.refocus(0.9 * field.nearest).shape == (2, 2, 3)        # taken for the nearest


def test_invalid_arguments_are_refused():
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
    hole = lb.PinholeCamera(film, 50.0, 0.5)
    with pytest.raises(lb.LightFieldError, match="no lens that focuses"):
        lb.capture_light_field(hole, scene, (3, 3), 1)
    with pytest.raises(lb.LightFieldError, match="no lens that focuses"):       # a file that names such a camera
        lb.LightField(hole, 1.0, np.ones((3, 3, 3, 8, 12), np.float32), np.ones((3, 3, 8, 12), np.float32))
    with pytest.raises(lb.LightFieldError, match="cancelled"):
        lb.capture_light_field(perspective(1200.0, film), scene, (2, 2), 1, progress=lambda share: False)
    field = lb.capture_light_field(perspective(1200.0, film), scene, (3, 3), 1)
    with pytest.raises(lb.LightFieldError, match="was not recorded"):
        field.refocus(1000.0, 1.0)
    with pytest.raises(lb.LightFieldError, match="leaves what was recorded"):
        field.refocus(1000.0, field.f_number * 2, view=(1.2, 0.0))
    with pytest.raises(lb.LightFieldError, match="positive"):
        field.refocus(1000.0, 0.0)


def test_a_picture_through_the_pupil_has_three_colours_and_is_white_but_for_the_fourth_power():
    white = lb.Scene("white", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))
    seen = lb.picture_through(perspective(1200.0, lb.Film(14.4, 9.6, 24, 16)), white, (0.0, 0.0), 1.0, 4)
    assert seen.shape == (16, 24, 3)
    size = 2.0 * math.tan(0.096) / 16.0
    r2 = sum(((at + 0.5 - middle) * size) ** 2 for at, middle in zip(np.mgrid[:16, :24], (8.0, 12.0), strict=True))
    np.testing.assert_allclose(seen, np.broadcast_to((1.0 + r2)[..., None] ** -2.0, seen.shape), atol=0.04)
    assert seen.mean() == pytest.approx(((1.0 + r2) ** -2.0).mean(), rel=5e-3)


def test_what_has_to_be_set_for_a_light_field_is_said_of_a_curved_film_too():
    curved = replace(real(1200.0), film_pose=lb.FilmPose(radius=-90.0))
    with pytest.raises(lb.LightFieldError, match="rise and shift to 0, and leave out the curvature"):
        lb.capture_light_field(curved, lb.builtin_scene(STILL), (2, 2))
