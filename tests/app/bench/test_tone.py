"""What developing does to light: laws that hold for every tone curve, with no graphics card."""

import numpy as np
import pytest
from hypothesis import given, settings as profile, strategies as st

from lensbench.app.bench import tone
from lensbench.app.settings.setting_table import TONES

light = st.floats(0.0, 1e8)
every_tone = pytest.mark.parametrize("curve", TONES)


def display(code):
    """The inverse of the sRGB transfer, from its standard: IEC 61966-2-1."""
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def test_srgb_is_the_inverse_of_the_standards_decoding():
    values = np.linspace(0.0, 1.0, 1001)
    # The standard's knee is given to 7 digits: its two pieces differ there by 3e-8
    np.testing.assert_allclose(display(tone.srgb(values)), values, atol=1e-7)


@every_tone
@given(st.tuples(light, light, light), st.floats(-10.0, 10.0))
@profile(max_examples=50)
def test_every_light_is_developed_into_the_range_of_the_screen(curve, colour, exposure):
    shown = tone.develop(np.array(colour), exposure, curve)
    assert np.all(shown >= 0.0) and np.all(shown <= 1.0)


@every_tone
@given(light)
@profile(max_examples=50)
def test_a_neutral_light_stays_neutral(curve, value):
    shown = tone.develop(np.full(3, value), 0.0, curve)
    np.testing.assert_allclose(shown, shown[0], atol=1e-9)


@every_tone
def test_more_light_is_never_shown_darker(curve):
    grey = np.concatenate([[0.0], np.geomspace(1e-6, 1e4, 4000)])[:, None] * np.ones(3)
    shown = tone.develop(grey, 0.0, curve)[:, 0]
    assert shown[0] == 0.0 and shown[-1] == pytest.approx(1.0)
    assert np.all(np.diff(shown) >= -1e-12)     # rounding


@every_tone
def test_middle_grey_stays_where_it_is(curve):
    assert display(tone.develop(np.full(3, 0.18), 0.0, curve))[0] == pytest.approx(0.18, abs=1e-6)


@every_tone
@given(st.floats(0.0, 10.0), st.integers(-6, 6))
@profile(max_examples=30)
def test_a_stop_of_exposure_is_twice_the_light(curve, value, stops):
    np.testing.assert_allclose(tone.develop(np.full(3, value), stops, curve),
                               tone.develop(np.full(3, value * 2.0 ** stops), 0.0, curve), atol=1e-12)


def test_agx_takes_a_bright_pure_colour_towards_white_and_keeps_its_hue():
    dim, bright = (tone.develop(np.array([0.1, 0.5, 1.0]) * gain, 0.0, "agx") for gain in (0.3, 30.0))
    assert np.ptp(bright) < np.ptp(dim)
    assert bright[0] < bright[1] < bright[2]


@every_tone
def test_what_saturates_a_sensor_is_white_and_grey_and_below_stay_as_they_are(curve):
    recorded = np.linspace(0.0, 1.0, 1001)[:, None] * np.ones(3)
    plain, shown = (tone.develop(recorded, 0.0, curve, sensor)[:, 0] for sensor in (False, True))
    assert shown[-1] == pytest.approx(1.0, abs=1e-9) and np.all(np.diff(shown) > 0.0)
    np.testing.assert_array_equal(shown[:181], plain[:181])
    # nothing else of a raw converter: no value is darkened, and none is brightened by more than saturation is
    assert np.all(shown >= plain - 1e-12) and np.all(display(shown) / np.maximum(display(plain), 1e-9)
                                                     <= 1.0 / display(plain[-1]) + 1e-9)
