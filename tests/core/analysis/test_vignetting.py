"""The beam that passes at each field angle, against 40-digit values, rays traced one by one and symmetry."""

import json
from dataclasses import replace
from math import inf, radians

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import DATA, TRACED, biconvex, lens
from tests.library import CLASSICS

FIELDS = json.loads((DATA / "fields.json").read_text(encoding="utf-8"))


def passes(stack, angle, distance, x, height):
    """Rays at x and height across the beam, by the reference tracer with its rims."""
    x, height = np.broadcast_arrays(np.asarray(x, float), height)
    origins = np.column_stack([x, height * np.cos(angle), -height * np.sin(angle)])
    point = -distance * np.array([0.0, np.sin(angle), np.cos(angle)])
    ways = -point / np.linalg.norm(point) if distance > 1e11 else origins - point
    return lb.trace(stack, origins, ways, forward=True).fate == lb.Fate.PASSED


@pytest.mark.parametrize("name", TRACED)
def test_beams_agree_with_forty_digits_edge_by_edge(name):
    for degrees, (low, low_surface, high, high_surface) in FIELDS[name]["vignetting"].items():
        beam = lb.vignetting(lens(name), radians(float(degrees)))
        assert beam.on_plane(0.0) == pytest.approx((low, high), abs=1e-12)
        assert (beam.low_surface, beam.high_surface) == (low_surface, high_surface)


@pytest.mark.parametrize(("name", "degrees", "distance"), [
    ("pbrt-dgauss-50mm", 18.0, 1e12), ("pbrt-dgauss-50mm", -11.0, 300.0), ("lib-miyamoto-fisheye-1964", 60.0, 200.0),
    ("lib-miyamoto-fisheye-1964", 90.0, 1e12), ("lib-miyamoto-fisheye-1964", 92.0, 1e12),
    ("lib-miyamoto-fisheye-1964", 92.0, 500.0), ("lenshh-petzval", 6.0, 1e12)])
def test_rays_traced_one_by_one_pass_between_the_edges_and_nowhere_else(name, degrees, distance):
    stack, angle = lenses.load(name), radians(degrees)
    beam = lb.vignetting(stack, angle, inf if distance > 1e11 else distance)
    width = beam.high - beam.low
    inside = np.linspace(beam.low + 1e-9, beam.high - 1e-9, 301)
    assert passes(stack, angle, distance, 0.0, inside).all()
    beyond = np.append(1e-9, np.geomspace(1e-6, 3.0, 200) * width)
    for outside in (beam.low - beyond, beam.high + beyond):
        assert not passes(stack, angle, distance, 0.0, outside).any()
    # and across, in the middle
    middle, half = 0.5 * (beam.low + beam.high), beam.half_width
    across = np.array([-half - 1e-9, -half + 1e-9, 0.0, half - 1e-9, half + 1e-9])
    assert list(passes(stack, angle, distance, across, middle)) == [False, True, True, True, False]


@pytest.mark.parametrize("name", [name if i % 4 == 0 else pytest.param(name, marks=pytest.mark.slow)
                                  for i, name in enumerate(CLASSICS)])
def test_of_every_lens_a_scan_finds_the_same_beam(name):
    stack = lenses.load(name)
    height = np.linspace(-1.6, 1.6, 1501) * stack.surfaces[0].semi_diameter
    for degrees, distance in ((0.0, 20.0 * stack.length), (7.0, 1e12), (28.0, 1e12)):
        passed = passes(stack, radians(degrees), distance, 0.0, height)
        try:
            beam = lb.vignetting(stack, radians(degrees), inf if distance > 1e11 else distance)
        except lb.LensError:
            assert not passed.any()
            continue
        clear = np.minimum(np.abs(height - beam.low), np.abs(height - beam.high)) > 1e-9
        np.testing.assert_array_equal(passed[clear], ((height > beam.low) & (height < beam.high))[clear])


@pytest.mark.parametrize("distance", [inf, 800.0])
def test_on_the_axis_the_beam_is_round(distance):
    for name in TRACED:
        beam = lb.vignetting(lens(name), 0.0, distance)
        assert (-beam.low, beam.half_width) == pytest.approx((beam.high, beam.high), abs=1e-12)
        assert beam.low_surface == beam.high_surface == beam.half_width_surface


def test_an_opposite_field_has_the_mirrored_beam():
    there, back = (lb.vignetting(lens("rf50"), sign * 0.3, 900.0) for sign in (1.0, -1.0))
    assert (back.low, back.high) == pytest.approx((-there.high, -there.low), abs=1e-12)
    assert (back.low_surface, back.high_surface) == (there.high_surface, there.low_surface)


def test_a_point_ever_farther_away_has_the_beam_of_one_at_infinity():
    far = lb.vignetting(lens("dgauss"), 0.2)
    errors = [abs(lb.vignetting(lens("dgauss"), 0.2, distance).high - far.high) for distance in (1e5, 1e6, 1e7)]
    assert errors[0] < 0.01
    np.testing.assert_allclose([errors[0] / errors[1], errors[1] / errors[2]], 10.0, rtol=0.01)      # as 1 / distance


def test_the_smallest_stop_is_found_and_its_blades_are_taken_for_their_circle():
    pinhole = lens("dgauss").with_stop_radius(1e-4)
    beam = lb.vignetting(pinhole, 0.1)
    assert (beam.low_surface, beam.high_surface) == (pinhole.stop_index, pinhole.stop_index)
    fo = lb.first_order(pinhole)
    assert beam.high - beam.low == pytest.approx(2.0 * fo.entrance_pupil.radius, rel=0.02)
    assert lb.vignetting(replace(pinhole, blades=5, blade_reach=1.0), 0.1) == beam


def test_a_thin_plate_shows_its_own_rim_as_the_cosine_of_the_field():
    plate = lb.Lens((lb.Surface(0.0, 4.0, curvature=0.0),), 0)
    beam = lb.vignetting(plate, 1.0)
    assert (beam.low, beam.high) == pytest.approx((-4.0 * np.cos(1.0), 4.0 * np.cos(1.0)), abs=1e-13)
    assert beam.half_width == pytest.approx(4.0, abs=1e-13)
    assert beam.on_plane(0.0) == pytest.approx((-4.0, 4.0), abs=1e-13)


@pytest.mark.parametrize(("angle", "distance", "message"), [
    (1.2, inf, "no light of a point at 68.75° passes"), (2.0, inf, "no light"), (3.2, inf, "below 180°"),
    (0.1, 0.0, "must be positive"), (0.1, -1.0, "must be positive")])
def test_dark_fields_and_invalid_arguments_are_refused_in_one_line(angle, distance, message):
    with pytest.raises(lb.LensError, match=message):
        lb.vignetting(lens("dgauss") if distance else biconvex(), angle, distance)
