"""Laws of the engraved scales."""

import math

import pytest
from hypothesis import example, given, settings, strategies as st

from lensbench.app.settings.dial_scales import (
    F_NUMBERS, aperture_scale, exposure_scale, figures_that_fit, focal_length_scale, focus_scale, fov_scale
)
from lensbench.app.settings.text_values import format_area, read_distance, read_f_number

SCALES = [focus_scale(300.0), focus_scale(42.0), focus_scale(1800.0), aperture_scale(1.98), aperture_scale(0.95),
          aperture_scale(11.3), exposure_scale(), fov_scale(0.05, 0.9), focal_length_scale()]
every_scale = pytest.mark.parametrize("scale", SCALES)


@every_scale
@settings(deadline=None)
@given(u=st.floats(0.0, 1.0))
def test_value_and_place_are_inverse(scale, u):
    # Near infinity the focus scale loses digits as d grows: u is kept to 1e-9 all the same
    assert scale.to_unit(scale.from_unit(u)) == pytest.approx(u, abs=1e-9)


@every_scale
def test_the_ends_are_exact_and_what_lies_beyond_stands_at_the_ends(scale):
    assert scale.from_unit(0.0) == scale.low and scale.from_unit(1.0) == scale.high
    assert scale.to_unit(scale.low) == 0.0 and scale.to_unit(scale.high) == 1.0
    assert scale.to_unit(scale.low - 1.0) == 0.0 and scale.to_unit(scale.high + 1.0) == 1.0
    assert scale.to_unit(math.nan) == 0.0


@every_scale
def test_places_rise_with_values(scale):
    places = [scale.to_unit(scale.from_unit(i / 50)) for i in range(51)]
    assert places == sorted(places)
    assert all(0.0 <= scale.to_unit(value) <= 1.0 for value, _ in scale.figures)


def test_the_focus_scale_is_that_of_the_study():
    scale = focus_scale(300.0)
    for metres in (0.3, 0.5, 1.0, 1.2, 3.0, 10.0):
        assert scale.to_unit(metres * 1000.0) == pytest.approx((metres - 0.3) / (metres - 0.3 + 1.2), rel=1e-12)
    assert [text for _, text in scale.figures] == ["0.3", "0.5", "0.7", "1", "1.5", "2", "3", "5", "10", "∞"]


@every_scale
@settings(deadline=None)
@given(u=st.floats(0.0, 1.0))
@example(u=0.43063435175534004)         # 9.9499° on the scale of angles
@example(u=0.27601950687195137)         # 499.99 mm on the scale of distances
def test_what_is_shown_can_be_typed_back(scale, u):
    value = scale.from_unit(u)
    typed = scale.parse(scale.format(value))
    assert scale.format(typed) == scale.format(value)


@pytest.mark.parametrize(("text", "mm"), [("1.2 m", 1200.0), ("120cm", 1200.0), ("1200 mm", 1200.0), ("1,2", 1200.0),
                                          ("inf", math.inf), ("∞", math.inf), (" 3 ", 3000.0), ("1 km", 1e6)])
def test_distances_are_read_as_people_write_them(text, mm):
    assert read_distance(text) == pytest.approx(mm, rel=1e-15)


@pytest.mark.parametrize("text", ["f/2.8", "2.8", "F 2.8", "f2.8"])
def test_f_numbers_are_read_as_people_write_them(text):
    assert read_f_number(text) == 2.8


@every_scale
@pytest.mark.parametrize("text", ["", "abc", "f/", "1.2.3", "nan", "12 apples", "--3"])
def test_what_is_no_value_is_refused_with_an_example(scale, text):
    with pytest.raises(ValueError, match="such as"):
        scale.parse(text)


def test_a_value_out_of_reach_is_refused_with_the_reach():
    with pytest.raises(ValueError, match=r"0\.300 m to ∞"):
        focus_scale(300.0).parse("10 cm")
    with pytest.raises(ValueError, match=r"f/2 to f/22"):
        aperture_scale(1.98).parse("f/1.4")


def test_the_rounded_end_of_a_ring_can_be_typed():
    assert aperture_scale(1.98).parse("f/2") == 1.98
    assert focus_scale(199.7).parse("0.2 m") == 199.7


def test_apertures_snap_to_engraved_third_stops_and_to_wide_open():
    scale = aperture_scale(1.98)
    assert scale.snapped(2.9) == 2.8
    assert scale.snapped(1.99) == 1.98
    assert scale.stepped(2.8, 1) == 3.2 and scale.stepped(2.8, -1) == 2.5 and scale.stepped(3.0, 1) == 3.2
    assert scale.stepped(22.0, 1) == 22.0 and scale.stepped(1.98, -1) == 1.98
    assert set(scale.snaps[1:]) <= set(F_NUMBERS)


def test_third_stops_are_a_third_of_a_stop_apart():
    # Engraved numbers are rounded to two digits: within a sixth of a stop of the law 2^(i/6)
    for i, n in enumerate(F_NUMBERS):
        assert abs(2.0 * math.log2(n / 0.7071) - i / 3.0) < 1 / 6


def test_a_continuous_ring_steps_by_a_hundredth_and_keeps_a_click():
    scale = focus_scale(300.0)
    assert scale.snapped(1234.5) == 1234.5
    assert scale.to_unit(scale.stepped(1200.0, 3)) == pytest.approx(scale.to_unit(1200.0) + 0.03, abs=1e-12)


@every_scale
@pytest.mark.parametrize("length", [1.0, 40.0, 90.0, 180.0, 230.0, 900.0])
def test_engraved_figures_never_touch_and_the_anchor_stays(scale, length):
    widths = tuple(7.0 * len(text) for _, text in scale.figures)
    width_of = dict(zip(scale.figures, widths, strict=True))
    fit = figures_that_fit(scale, length, widths, 4.0)
    assert scale.figures[scale.anchor] in fit
    for a, b in zip(fit, fit[1:], strict=False):
        apart = (scale.to_unit(b[0]) - scale.to_unit(a[0])) * length
        assert apart >= 0.5 * (width_of[a] + width_of[b]) + 4.0


@pytest.mark.parametrize(("area", "text"), [(0.0312, "0.0312 mm²"), (2.234, "2.23 mm²"), (9.996, "10 mm²"),
                                            (123.4, "123 mm²"), (1667.0, "1670 mm²"), (0.0, "0 mm²")])
def test_areas_have_three_digits_and_no_power_of_ten(area, text):
    assert format_area(area) == text
