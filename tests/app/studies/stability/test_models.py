"""Stability sweeps of camera models: the order of the models, and maps of their domains."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability import models, models as domains
from lensbench.core.analysis.model_choice import LADDER


@pytest.mark.parametrize("label", models.LENSES)
def test_each_degree_holds_at_least_as_far_as_the_one_before(label):
    for sweep in (models.field(label), models.f_number(label), models.object_distance(label)):
        fits = [curve for curve in sweep.curves if curve.name.startswith("polynomial")]
        for low, high in zip(fits, fits[1:], strict=False):
            assert (high.errors < low.errors)[low.errors > 1e-6].all()
        assert sweep.failure(fits[-1]) is None and fits[-1].errors.max() < 0.01
        assert all(curve.own and curve.switch for curve in sweep.curves)


def test_a_thin_lens_of_thin_glass_holds_to_the_seidel_order():
    """A stop at the lens has no distortion, so that the ideal model has its least error on the axis."""
    sweep = models.field("double Gauss")
    thin = next(curve for curve in sweep.curves if curve.name == "thin")
    assert thin.errors[0] < thin.errors[-1] and sweep.failure(thin) == 0      # a colour-corrected f/2 lens wide open


def test_the_field_angle_is_that_of_the_chief_ray_into_the_scene():
    lens = lenses.load("pbrt-dgauss-50mm")
    camera = lb.LensCamera(lens, models.film(12.0), math.inf, 16.0)
    angle = models.angle(camera, 3.0)
    # near the axis tan of the angle is the height over the focal length
    assert math.tan(math.radians(angle)) == pytest.approx(3.0 / lb.first_order(lens).efl, rel=5e-3)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_a_map_of_domains_never_gets_simpler_towards_the_corner(name):
    one_map = domains.domain(name, sizes=4, stops=3)
    assert one_map.rung.shape == (3, 4) and (np.diff(one_map.rung, axis=1) >= 0).all()
    assert (np.diff(one_map.angles) > 0).all() and (np.diff(one_map.f_numbers) < 0).all()
    # Auto chooses that very model there, for a scene of the same depths
    lens, focus = lenses.load(name), 2000.0
    for i, j in ((0, 3), (2, 0), (2, 3)):
        judged = models.judge(lens, one_map.half_diagonals[j], one_map.f_numbers[i], focus)
        model, degree = LADDER[one_map.rung[i, j]]
        rung = judged.rung(model, degree)
        assert rung.error_px <= 0.5 and rung.error_stops <= 0.05


@pytest.mark.parametrize("name", ["agfa-color-telinear-90-f4", "pbrt-dgauss-50mm"])
def test_the_lowest_row_of_a_map_is_the_lens_wide_open_with_a_round_stop(name):
    """It was drawn a ten-thousandth of a stop away, where blades already forbid every polynomial."""
    one_map, lens = domains.domain(name, sizes=2, stops=2), lenses.load(name)
    focus = max(models.FOCUS, 2.0 * lb.nearest_focus(lens))
    first = 0
    for half, rung in zip(one_map.half_diagonals, one_map.rung[-1], strict=True):
        judged = models.judge(lens, half, None, focus)
        while first < len(LADDER) - 1 and not domains._good(judged.rung(*LADDER[first])):
            first += 1
        assert rung == first
    assert first < len(LADDER) - 1                  # a polynomial holds


def test_maps_of_domains_are_written_with_a_sign_in_every_cell(tmp_path):
    maps = [domains.domain(name, sizes=3, stops=2) for name in ("pbrt-dgauss-50mm", "lenshh-cooke-triplet-50")]
    domains.save_domains(maps, tmp_path / "maps.svg")
    drawn = (tmp_path / "maps.svg").read_text()
    assert drawn.count("<image") == 2 and len(domains.COLOURS) == len(domains.SIGNS) == len(LADDER)
