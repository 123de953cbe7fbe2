"""The exposure triangle: EV and its luminance, H = E t, metering; the same exposure by two ways is two pictures."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.exposure import GREY, LUMINANCE, PHOTONS, SATURATION

numbers, times, isos = st.floats(0.7, 64.0), st.floats(1e-5, 3600.0), st.floats(1.0, 1e6)
FILM = lb.Film(36.0, 24.0, 96, 64)


@given(numbers, times, isos)
@settings(deadline=None)
def test_ev_goes_both_ways(f_number, time, iso):
    exposure = lb.Exposure(f_number, time, iso)
    assert 2.0**exposure.ev == pytest.approx(f_number**2 / time, rel=1e-12)
    assert lb.ev100(exposure.luminance) == pytest.approx(exposure.ev100, abs=1e-9)
    for by in ("time", "iso", "f_number"):
        again = exposure.at_ev100(9.0, by)
        assert again.ev100 == pytest.approx(9.0, abs=1e-9)
        assert [name for name in ("time", "iso", "f_number")
                if getattr(again, name) != pytest.approx(getattr(exposure, name), rel=1e-9)] in ([by], [])


def test_the_scale_of_ev_is_the_known_one():
    """EV 0 is f/1 for 1 s; sunny 16, f/16 at 1/100 s and ISO 100, is EV 14.6, for a mean luminance of 3,200 cd/m²."""
    assert lb.Exposure(1.0, 1.0).ev == 0.0 and lb.Exposure(1.0, 1.0, 200.0).ev100 == -1.0
    sunny = lb.Exposure(16.0, 1.0 / 100.0)
    assert sunny.ev100 == pytest.approx(14.644, abs=1e-3) and sunny.luminance == pytest.approx(3200.0)
    assert lb.luminance(0.0) == 0.125


@given(numbers, times, isos, st.floats(-5.0, 5.0))
@settings(deadline=None)
def test_a_stop_is_a_stop_by_any_of_the_three(f_number, time, iso, stops):
    exposure = lb.Exposure(f_number, time, iso)
    for by in ("time", "iso", "f_number"):
        assert exposure.brighter(stops, by).brightness == pytest.approx(exposure.brightness * 2.0**stops, rel=1e-9)
    assert exposure.brighter(stops, "iso").joules == exposure.joules


def test_what_is_metered_comes_out_near_middle_grey():
    """A uniform scene of the metered luminance gets π / 4 · 12.5 / ISO = 9.8 / ISO lux s, where 10 is the norm."""
    for exposure in (lb.Exposure(8.0, 0.01), lb.Exposure(2.0, 1.0, 3200.0)):
        value = exposure.brightness * exposure.luminance / LUMINANCE
        assert value == pytest.approx(math.pi / 4.0 * 12.5 / SATURATION, rel=1e-12)
        assert abs(math.log2(value / GREY)) < 0.05


def test_a_lux_second_is_so_many_photons():
    """683 lm/W at 540 THz, by the definition of the candela, which is 555.17 nm: 3e-4 off 555."""
    assert PHOTONS == pytest.approx(1.0 / 683.0 / (6.62607015e-34 * 540e12) * 1e-12, rel=4e-4)


def test_h_is_e_times_t_on_the_axis_of_a_real_lens():
    """Against physical weights, with the working f-number of the real marginal ray: 0.2 % of the lattice's noise."""
    n = 4096
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 4.0, weights="physical",
                           shutter_close=1.0 / 60.0)
    weight = camera.generate_rays(np.tile([48.0, 32.0], (n, 1)), uv).weights.mean()
    exposure = lb.Exposure(lb.working_f_number(camera.lens, camera.film_distance), camera.effective_time)
    assert exposure.lux_seconds == pytest.approx(weight * LUMINANCE, rel=2e-3)
    assert exposure.joules == pytest.approx(weight * LUMINANCE / 683.0, rel=2e-3)


def test_half_the_time_and_a_stop_more_is_the_same_exposure_and_another_picture():
    """The means agree to 0.3 % (1 + 1/(4 N²) between the two cones, noise); the pictures differ far beyond the noise:
    the wider one is blurred by its depth of field, the longer one by the camera's turn.
    """
    turned = np.eye(4)
    turned[0, 0] = turned[2, 2] = math.cos(0.03)
    turned[0, 2], turned[2, 0] = math.sin(0.03), -math.sin(0.03)

    def picture(f_number, time, seed=0):
        camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1500.0, f_number, model="thin",
                               weights="physical", shutter_close=time,
                               world_from_camera=lb.AnimatedTransform(np.eye(4), turned, 0.0, 0.02))
        return lb.render(camera, lb.builtin_scene("focus-ruler"), samples=64, seed=seed).astype(float)

    small, again, wide = picture(8.0, 0.02), picture(8.0, 0.02, 1), picture(4.0 * math.sqrt(2.0), 0.01)
    assert lb.Exposure(8.0, 0.02).ev == pytest.approx(lb.Exposure(4.0 * math.sqrt(2.0), 0.01).ev)
    assert wide.mean() == pytest.approx(small.mean(), rel=0.02)     # what moves into the picture meanwhile
    noise, other = (np.sqrt(((it - small) ** 2).mean()) for it in (again, wide))
    assert other > 3.0 * noise


def test_metering_by_the_mean_and_by_the_highlights():
    rng = np.random.default_rng(5)
    image = np.exp(rng.normal(0.0, 1.5, (60, 80, 1))) * np.ones(3) * 7.0
    level = 2.0 ** np.log2(image[..., 0]).mean()
    assert 2.0 ** lb.metered_stops(image) * level == pytest.approx(GREY, rel=1e-4)
    safe = image * 2.0 ** lb.metered_stops(image, "highlights")
    assert 0.0 < (safe > 1.0 + 1e-6).mean() <= 0.001
    assert lb.metered_stops(image * 4.0) == pytest.approx(lb.metered_stops(image) - 2.0, abs=1e-4)
    # Where a channel is dark, a pixel lost or the sky black, the others count
    image[:10] = 0.0
    image[0, 0] = math.nan
    assert math.isfinite(lb.metered_stops(image)) and lb.metered_stops(np.zeros((4, 4, 3)), "highlights") == 0.0
    assert lb.metered_stops(np.zeros((4, 4, 3))) == 0.0


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.Exposure(0.0, 0.01), "f-number 0"),
    (lambda: lb.Exposure(2.8, -1.0), "shutter time -1"),
    (lambda: lb.Exposure(2.8, 0.01, 0.0), "ISO 0"),
    (lambda: lb.Exposure(2.8, math.inf), "shutter time ∞"),
    (lambda: lb.Exposure(math.nan, 1.0), "f-number nan"),
    (lambda: lb.Exposure(2.8, 0.01).brighter(math.nan), "finite"),
    (lambda: lb.Exposure(2.8, 0.01).brighter(1.0, "luck"), "time, iso, f_number"),
    (lambda: lb.metered_stops(np.ones((2, 2, 3)), "guess"), "mean, highlights"),
    (lambda: lb.Exposure(2.8, 0.01).brighter(1e308, "f_number"), "stops 1×10"),
    (lambda: lb.Exposure(2.8, 0.01).at_ev100(-math.inf), "EV100"),
    (lambda: lb.Exposure(2.8, 0.01).at_ev100(1e308, "f_number"), "EV100"),
    (lambda: lb.luminance(math.nan), "EV100 nan"),
    (lambda: lb.luminance(1e308), "EV100"),
    (lambda: lb.ev100(0.0), "luminance 0"),
])
def test_what_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(lb.ExposureError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
