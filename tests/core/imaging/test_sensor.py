"""The sensor: the photon transfer curve, the floor of reading, the two ways to clip, and the same noise every time."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.imaging.exposure import PHOTONS, SATURATION


def flat(electrons, sensor, shape=(300, 400)):
    """A picture that collects this mean number of electrons, in lux seconds."""
    return np.full((*shape, 3), electrons / sensor.electrons, np.float32)


@pytest.mark.parametrize("iso", [100.0, 800.0])
def test_the_photon_transfer_curve_has_the_slope_one(iso):
    """Variance against mean in electrons, over three decades: 360,000 numbers know a variance to 0.25 %."""
    sensor = lb.Sensor(full_well=60_000.0, read_noise=2.0)
    means = np.geomspace(10.0, 0.8 * sensor.top(max(iso, 100.0)), 8)
    shots = [sensor.record(flat(mean, sensor), iso, seed=3).astype(float) * sensor.electrons for mean in means]
    step = sensor.top(iso) / (2**sensor.bits - 1)
    variance = np.array([shot.var() for shot in shots]) - 2.0**2 - step**2 / 12.0
    np.testing.assert_allclose([shot.mean() for shot in shots], means, rtol=2e-3)
    slope = (variance * means).sum() / (means * means).sum()
    assert slope == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(variance / means, 1.0, atol=0.02)


@pytest.mark.parametrize("mean", [0.3, 1.0, 3.0, 7.9, 8.1, 20.0])
def test_few_electrons_follow_poissons_law(mean):
    """The counts against the law's own, without read noise, a number of the converter for each electron."""
    sensor = lb.Sensor(full_well=16383.0, read_noise=0.0, bits=14, pitch=5.0)
    counts = np.rint(sensor.record(flat(mean, sensor), 100.0) * sensor.electrons).astype(int).ravel()
    law = np.array([math.exp(-mean + k * math.log(mean) - math.lgamma(k + 1)) for k in range(60)])
    found = np.bincount(counts, minlength=60)[:60]
    expected = law * counts.size
    enough = expected > 20.0
    chi2 = ((found - expected)[enough] ** 2 / expected[enough]).sum() / enough.sum()
    if mean < 8.0:
        assert chi2 < 2.5
    else:               # the normal law with the third moment: its cumulative is within 0.4 % of Poisson's
        assert np.abs(np.cumsum(found / counts.size) - np.cumsum(law)).max() < 4e-3
    assert counts.mean() == pytest.approx(mean, rel=5e-3) and counts.var() == pytest.approx(mean, rel=0.02)


@pytest.mark.parametrize("mean", [8.1, 20.0])
def test_the_third_central_moment_of_the_electrons_is_their_mean(mean):
    """As by Poisson's law; three million numbers know it to 1 %.

    The outer cells of the table of the normal law, straight lines, take 2 % of it.
    """
    sensor = lb.Sensor(full_well=16383.0, read_noise=0.0, bits=14, pitch=5.0)
    counts = np.rint(sensor.record(flat(mean, sensor, (1000, 1000)), 100.0) * sensor.electrons).astype(float)
    assert ((counts - counts.mean()) ** 3).mean() == pytest.approx(mean, rel=0.05)


def test_dark_frames_have_the_noise_of_reading_and_rounding_and_no_bias():
    sensor = lb.Sensor(full_well=40_000.0, read_noise=3.0)
    for iso in (100.0, 1600.0):
        dark = sensor.record(np.zeros((300, 400, 3), np.float32), iso) * sensor.electrons
        step = sensor.top(iso) / 16383.0
        assert dark.std() == pytest.approx(math.hypot(3.0, step / math.sqrt(12.0)), rel=0.03)
        assert abs(dark.mean()) < 5.0 * dark.std() / math.sqrt(dark.size)
        if iso == sensor.base_iso:
            assert sensor.dynamic_range == pytest.approx(math.log2(sensor.full_well / dark.std()), abs=0.05)
    normal = np.sort(dark.ravel() / dark.std())
    assert normal[int(0.975 * normal.size)] == pytest.approx(1.96, abs=0.05)


def test_the_gain_amplifies_signal_and_noise_alike():
    """In numbers of the converter both double with the ISO; in exposure neither changes but for the rounding."""
    sensor = lb.Sensor(read_noise=0.0, bits=16)
    low, high = (sensor.record(flat(2000.0, sensor), iso) / (sensor.top(iso) / 65535.0 / sensor.electrons)
                 for iso in (400.0, 800.0))
    assert high.mean() / low.mean() == pytest.approx(2.0, rel=1e-3)
    assert high.std() / low.std() == pytest.approx(2.0, rel=1e-2)


def test_a_picture_clips_where_the_well_is_full_or_the_converter_at_its_end():
    sensor = lb.Sensor(full_well=30_000.0, base_iso=100.0, read_noise=0.0)
    ramp = np.repeat(np.linspace(0.0, 3.0 * sensor.clips_at(100.0), 600, dtype=np.float32), 30).reshape(60, 100, 3)
    for iso in (50.0, 100.0, 400.0):
        out = sensor.record(ramp, iso)
        assert out.max() == pytest.approx(sensor.clips_at(iso), rel=1e-4)
    assert sensor.clips_at(400.0) == pytest.approx(sensor.clips_at(100.0) / 4.0)
    assert sensor.clips_at(50.0) == sensor.clips_at(100.0)          # the gain falls, the well grows no larger
    assert sensor.clips_at(100.0) == pytest.approx(SATURATION / 100.0)
    for bits in (8, 10, 12, 14):
        assert np.unique(lb.Sensor(read_noise=0.0, bits=bits).record(ramp, 100.0)[..., 0]).size <= 2**bits


@pytest.mark.parametrize("full_well", [200.0, 1000.0])
def test_a_full_well_gives_its_own_number_of_electrons_and_not_one_less(full_well):
    """At half the base ISO the converter reaches twice as far as the well: what fills it is exactly the full well."""
    sensor = lb.Sensor(full_well=full_well, read_noise=0.0, bits=16)
    shot = sensor.record(flat(5.0 * full_well, sensor, (20, 30)), 50.0).astype(float) * sensor.electrons
    assert np.abs(shot - full_well).max() <= 0.51 * sensor.top(50.0) / 65535.0


def test_fewer_photons_become_electrons_and_larger_pixels_collect_more():
    small, large = lb.Sensor(pitch=4.0), lb.Sensor(pitch=8.0, full_well=200_000.0)
    assert large.electrons == pytest.approx(4.0 * small.electrons)
    assert lb.Sensor(pitch=4.0, quantum_efficiency=0.25).electrons == pytest.approx(small.electrons / 2.0)
    assert small.electrons == pytest.approx(0.5 * PHOTONS * 16.0)
    # at one exposure the ratio of signal to noise goes as the square root of the light collected
    exposure = np.full((200, 300, 3), 0.05, np.float32)
    ratios = [shot.mean() / shot.std() for shot in (it.record(exposure, 100.0) for it in (small, large))]
    assert ratios[1] / ratios[0] == pytest.approx(2.0, rel=0.02)
    film = lb.Film(36.0, 24.0, 6000, 4000)
    own = lb.Sensor.of(film)
    assert own.pixel_pitch == pytest.approx(6.0) and own.clips_at(100.0) == pytest.approx(SATURATION / 100.0)
    assert lb.Sensor().pixel_pitch == pytest.approx(5.6, abs=0.1)


def test_noise_depends_on_the_seed_and_the_place_alone(monkeypatch):
    sensor, image = lb.Sensor(), np.full((200, 700, 3), 0.1, np.float32)
    first = sensor.record(image, 400.0, seed=7)
    np.testing.assert_array_equal(first, sensor.record(image, 400.0, seed=7))
    monkeypatch.setattr("lensbench.core.imaging.sensor.PART", 1000)          # other threads take other parts
    np.testing.assert_array_equal(first, sensor.record(image, 400.0, seed=7))
    other = sensor.record(image, 400.0, seed=8)
    assert abs(np.corrcoef((first - 0.1).ravel(), (other - 0.1).ravel())[0, 1]) < 0.01
    noise = first - first.mean()
    for a, b in ((noise[:, 1:], noise[:, :-1]), (noise[1:], noise[:-1]), (noise[..., 0], noise[..., 1])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.01


def test_the_exposure_of_a_value_only_sets_the_unit():
    sensor, image = lb.Sensor(), np.full((50, 60, 3), 0.2, np.float32)
    np.testing.assert_allclose(sensor.record(image, 200.0, lux_seconds=0.25) * 0.25, sensor.record(image / 4, 200.0),
                               rtol=1e-5)


def test_lost_and_endless_values_stay_numbers():
    image = np.array([[[math.nan, math.inf, -1.0]]], np.float32)
    assert np.isfinite(lb.Sensor().record(image, 100.0)).all()


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.Sensor().record(np.ones((2, 2, 3)), 0.0), "ISO 0"),
    (lambda: lb.Sensor().record(np.ones((2, 2, 3)), math.nan), "ISO nan"),
    (lambda: lb.Sensor().record(np.ones((2, 2, 3)), 100.0, lux_seconds=-1.0), "exposure -1"),
    (lambda: lb.Sensor(full_well=0.0), "full well 0"),
    (lambda: lb.Sensor(quantum_efficiency=1.5), "quantum efficiency"),
    (lambda: lb.Sensor(read_noise=-1.0), "read noise"),
    (lambda: lb.Sensor(base_iso=0.0), "base ISO 0"),
    (lambda: lb.Sensor(bits=7), "8 to 16"),
    (lambda: lb.Sensor(pitch=0.0), "pixel pitch"),
])
def test_what_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(lb.ExposureError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
