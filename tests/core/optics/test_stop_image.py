"""A picture in the stop: its image, upright and to scale, its light, and what it does not change."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.film_landing import landing_step
from lensbench.core.kernels.block import lane_buffer
from lensbench.core.optics.ghost_trace import GhostTracer
from lensbench.lenses.formats import toml_format

FILM = lb.Film(3.0, 3.0, 64, 64)
SIDE = 40                       # pixels down the picture of the letter F, 30 across: opaque beside it
BARS = ((6, 11, 4, 36), (6, 26, 4, 9), (6, 20, 18, 23))         # left, right, top, bottom, in its pixels


def lattice(n):
    return np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])


def letter() -> np.ndarray:
    """The letter F, which no turn and no mirror leaves as it is."""
    picture = np.zeros((SIDE, 30))
    for left, right, top, bottom in BARS:
        picture[top:bottom, left:right] = 1.0
    return picture


def in_letter(x, y):
    """Whether points of the unit disk, x right and y up, lie in the letter: by its bars, and no pixels."""
    across, down = x * SIDE / 2 + 15.0, SIDE / 2 - y * SIDE / 2
    return np.any([(across >= a) & (across < b) & (down >= c) & (down < d) for a, b, c, d in BARS], 0)


F = lb.StopImage.of(letter())
SHARE = letter().sum() * (2 / SIDE) ** 2 / math.pi              # of the disk: all bars lie within it


def camera(lens, model="trace", f_number=2.8, **more):
    return lb.LensCamera(lens, FILM, 1000.0, f_number, model=model, **more)


def with_letter(name="pbrt-dgauss-50mm", image=F):
    return replace(lenses.load(name), stop_image=image)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["trace", "thick", "thin"])
def test_a_far_light_shows_the_picture_upright_and_to_scale(model):
    """Against rays of a point 20 m away through the open lens, by the reference tracer, kept where they meet the
    letter: pixels differ where edges blur, and by noise; a mirrored letter differs by more than 0.5."""
    of = camera(with_letter(), model)
    lamp = lb.Material(kind="lamp", colour=(1e4,) * 3)
    dark = (0.0,) * 3
    shown = lb.render(of, lb.Scene("lamp", sky=lb.Sky(dark, dark, dark),
                                   spheres=(lb.Sphere((0.0, 0.0, -20_000.0), 5.0, lamp),)), samples=64)[..., 1]
    lens = of.lens.with_open_stop
    film_z = lens.length + of.film_distance
    origin, (x, y) = np.array([0.0, 0.0, film_z - 20_000.0]), 12.0 * (2.0 * lattice(1 << 17).T - 1.0)
    met = lb.trace(lens, origin, np.column_stack([x, y, np.full(len(x), 20_000.0 - film_z)]), record=True)
    at = met.paths[:, 1 + lens.stop_index, :2] / lens.stop.semi_diameter
    kept = (met.fate == lb.Fate.PASSED) & in_letter(*at.T)
    o, d = met.points[kept], met.directions[kept]
    film = o[:, :2] + ((film_z - o[:, 2]) / d[:, 2])[:, None] * d[:, :2]
    wanted, *_ = np.histogram2d((film[:, 1] / 3.0 + 0.5) * 64, (0.5 - film[:, 0] / 3.0) * 64, bins=64,
                                range=[[0, 64], [0, 64]])
    shown, wanted = shown / shown.sum(), wanted / wanted.sum()
    assert np.abs(shown - wanted).sum() < (0.15 if model == "trace" else 0.3)     # aberrations move edges by a pixel
    assert np.abs(shown[:, ::-1] - wanted).sum() > 0.5 and np.abs(shown[::-1] - wanted).sum() > 0.5


@pytest.mark.parametrize("model", ["trace", "polynomial", "thick", "thin", "pinhole"])
def test_the_axis_has_weight_one_and_the_light_of_the_stop_times_the_mean_transmission(model):
    """The lattice misses the letter's edges by 0.2 %, the pupil's aberration changes its area, and cos⁴ at f/8 weighs
    it by 0.1 %."""
    uv, middle = lattice(1 << 14), np.full((1 << 14, 2), 32.0)
    assert F.ring_means.mean() == pytest.approx(SHARE, rel=1e-3)
    assert camera(with_letter(), model, 8.0).generate_rays(middle, uv).weights.mean() == pytest.approx(1.0, abs=4e-3)
    whole, part = (camera(lens, model, 8.0, weights="physical").generate_rays(middle, uv).weights.mean()
                   for lens in (lenses.load("pbrt-dgauss-50mm"), with_letter()))
    assert part / whole == pytest.approx(SHARE, rel=8e-3)
    assert (lb.t_number(with_letter()) / lb.t_number(lenses.load("pbrt-dgauss-50mm"))) ** 2 == pytest.approx(
        1.0 / SHARE, rel=1e-3)


def test_cameras_without_a_prescription_and_tilted_lenses_have_weight_one_on_the_axis():
    uv, middle = lattice(1 << 14), np.full((1 << 14, 2), 32.0)
    lens = with_letter()
    bent = replace(lens.surfaces[2], pose=lb.SurfacePose(decentre_y=0.4, tilt_x=0.01))
    for of in (lb.PerspectiveCamera(FILM, 0.5, 8.0, 900.0, stop_image=F),
               lb.OrthographicCamera(FILM, 300.0, 40.0, 500.0, stop_image=F),
               camera(lens, "thin", film_pose=lb.FilmPose(tilt=0.02)),
               camera(replace(lens, surfaces=(*lens.surfaces[:2], bent, *lens.surfaces[3:])))):
        assert of.generate_rays(middle, uv).weights.mean() == pytest.approx(1.0, abs=8e-3)


@pytest.mark.parametrize("model", ["trace", "thin"])
def test_importance_weighs_rays_as_the_camera_does(model):
    """A grey wedge changes W by the factor by which it changes the weight of the same ray."""
    wedge = lb.StopImage.of(np.tile(np.linspace(0.0, 1.0, 64), (64, 1)))
    dim = camera(with_letter(image=wedge), model)
    rays, plain = (of.generate_rays(np.tile([20.0, 40.0], (500, 1)), lattice(500)) for of in (dim, dim.with_open_stop))
    lit = rays.weights > 0.0
    found, known = (of.importance(rays.origins[lit], rays.directions[lit]) for of in (dim, dim.with_open_stop))
    change = rays.weights[lit] / plain.weights[lit]
    assert lit.mean() > 0.9 and change.max() > 3.0 * change.min()
    near = np.abs(found.we - known.we * change) <= 1e-9 * known.we      # but where rounding picks the next texel
    assert near.mean() > 0.99
    np.testing.assert_array_equal(found.direction_pdf, known.direction_pdf)


def test_ghosts_pass_the_picture_as_often_as_they_cross_the_stop():
    half = with_letter(image=lb.StopImage.of(np.full((8, 8), 0.5)))
    rays = np.tile(np.array([[0.5], [0.3], [-200.0], [0.0], [0.0], [1.0], [1.0]]), (1, 4))
    stop = half.stop_index
    for pair in ((0, 1), (stop - 1, stop + 1)):
        light = []
        for lens in (half.with_open_stop, half):
            tracer, found = GhostTracer(lens, 35.0, [landing_step(FILM, 1.0)], real=np.float64), np.empty((6, 4))
            tracer.trace(lane_buffer(np.float64), pair, rays, found)
            light.append(found[2, 0])
        assert light[1] / light[0] == pytest.approx(0.5 if pair == (0, 1) else 0.125, rel=1e-12)


def test_a_white_picture_is_the_round_stop_and_the_centre_of_an_opaque_middle_still_projects():
    white, ring = (lb.StopImage.of(picture) for picture in (np.ones((9, 9)), np.pad(np.zeros((5, 5)), 2,
                                                                                  constant_values=1.0)))
    uv, raster = lattice(400), np.tile([10.0, 50.0], (400, 1))
    for model in ("trace", "thin"):
        open_, plain = (camera(lens, model).generate_rays(raster, uv)
                        for lens in (with_letter(image=white), lenses.load("pbrt-dgauss-50mm")))
        np.testing.assert_allclose(open_.weights, plain.weights, rtol=1e-3)
        of, point = camera(with_letter(image=ring), model), [[20.0, 10.0, -2000.0]]
        assert not (of.generate_rays([[32.0, 32.0]], [[0.5, 0.5]]).weights > 0.0).any()
        np.testing.assert_array_equal(of.raster_from_point(point)[0], of.with_open_stop.raster_from_point(point)[0])
        assert of.raster_from_point(point)[1].all()


def test_what_leaves_the_picture_out_says_so():
    lens = lb.stopped_down(with_letter(), 4.0)
    with pytest.raises(lb.LensError, match="picture in the stop"):
        lb.analysis.sunstar(lens, 36.0)
    text, findings = toml_format.write(lens)
    assert "picture" not in text and [str(found) for found in findings] != []
    choice = lb.choose_model(replace(camera(with_letter()), model="auto"), lb.builtin_scene("still-life"))
    assert choice.model not in ("polynomial",)


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.StopImage.of(np.zeros((4, 4))), "passes no light"),
    (lambda: lb.StopImage.of(np.ones((1, 4))), "at least 2"),
    (lambda: lb.StopImage.of(np.ones(4)), "rows and columns"),
    (lambda: lb.StopImage.of(np.full((4, 4), 1.1)), "from 0 to 1"),
    (lambda: lb.StopImage.of(np.full((4, 4), math.nan)), "from 0 to 1"),
    (lambda: lb.Iris(5, image=F), "place of the blades"),
    (lambda: replace(with_letter(), blades=7), "place of the blades"),
])
def test_a_picture_that_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_a_large_picture_is_averaged_and_keeps_its_light_and_its_place():
    rng = np.random.default_rng(1)
    large = np.kron(rng.random((40, 24)), np.ones((25, 25)))            # 1000 × 600
    made = lb.StopImage.of(large)
    assert made.side == 256
    assert made.grid.sum() * (1000 / 256) ** 2 == pytest.approx(large.sum(), rel=1e-6)
    x, y = rng.uniform(-0.5, 0.5, (2, 200))
    shown = made.at(x, y)
    inside = large[(500 - 500 * y).astype(int), (300 + 500 * x).astype(int)]
    assert (np.abs(shown - inside) < 1e-6).mean() > 0.7                 # but for texels across the edges of blocks
