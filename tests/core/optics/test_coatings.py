"""Coatings: thin layers against closed forms and published figures, tables, energy."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.optics.coatings import COATINGS, Coating, CoatingError, Layer

ANGLES = np.linspace(0.0, 1.55, 40)


def fresnel(n, m, angle):
    """Fresnel's formulas in sines and tangents, s and p."""
    inside = np.arcsin(n / m * np.sin(angle))
    return (np.sin(angle - inside) / np.sin(angle + inside))**2, (np.tan(angle - inside) / np.tan(angle + inside))**2


def test_bare_glass_reflects_by_fresnel_from_either_side():
    angle = ANGLES[1:]
    for n, m in ((1.0, 1.52), (1.33, 1.8), (1.52, 1.72)):
        s, p = Coating().reflectance(n, m, np.cos(angle))
        assert np.allclose((s, p), fresnel(n, m, angle), rtol=1e-9, atol=1e-15)
        back = np.cos(np.arcsin(n / m * np.sin(angle)))
        for coating in (Coating(), *COATINGS.values()):         # Stokes: the same from behind, at the refracted angle
            assert np.allclose(coating.reflectance(m, n, back), coating.reflectance(n, m, np.cos(angle)), atol=1e-9)


def test_no_light_of_p_is_reflected_at_brewsters_angle_and_all_beyond_the_critical_one():
    brewster = math.atan(1.5)
    assert float(Coating().reflectance(1.0, 1.5, math.cos(brewster)).p) == pytest.approx(0.0, abs=1e-30)
    beyond = math.cos(math.asin(1.0 / 1.5) + 1e-3)
    assert Coating.broadband().reflectance(1.5, 1.0, beyond) == (1.0, 1.0)


def test_a_quarter_wave_of_mgf2_on_crown_reflects_1_3_per_cent():
    n, m = 1.38, 1.52                           # 1.26 %: Macleod, Thin-Film Optical Filters, ch. 4
    one = Coating.single_layer(n, 0.55)
    exact = ((n * n - m) / (n * n + m)) ** 2
    assert float(one.reflectance(1.0, m, wavelength=0.55).mean) == pytest.approx(exact, rel=1e-12)
    assert exact == pytest.approx(0.0126, abs=5e-5)
    half = Coating((Layer(2.3, 0.5),), 0.55)    # a half wave is absent, whatever it is made of
    assert half.reflectance(1.0, m, wavelength=0.55).s == pytest.approx(((m - 1.0) / (m + 1.0)) ** 2, rel=1e-9)


def test_a_v_coat_of_two_quarter_waves_is_dark_where_the_indices_say_so():
    m, inner = 1.52, 1.70
    outer = inner / math.sqrt(m)                # n₁² m = n₂²
    v_coat = Coating((Layer(outer, 0.25), Layer(inner, 0.25)), 0.532)
    assert float(v_coat.reflectance(1.0, m, wavelength=0.532).mean) == pytest.approx(0.0, abs=1e-30)
    other = Coating((Layer(1.38, 0.25), Layer(inner, 0.25)), 0.532)
    ratio = 1.38**2 * m / inner**2
    assert float(other.reflectance(1.0, m, wavelength=0.532).s) == pytest.approx(((1 - ratio) / (1 + ratio))**2)


def test_one_layer_is_airys_sum_at_any_angle_and_wavelength():
    n, m, waves, design, wavelength = 1.38, 1.62, 0.25, 0.55, 0.47
    for angle in (0.0, 0.6, 1.2):
        inside = math.asin(math.sin(angle) / n)
        last = math.asin(math.sin(angle) / m)
        phase = 4.0 * math.pi * waves * design / wavelength * math.cos(inside)
        found = Coating.single_layer(n, design).reflectance(1.0, m, math.cos(angle), wavelength)
        for got, (a, b, c) in zip(found, (
                (math.cos(angle), n * math.cos(inside), m * math.cos(last)),
                (1.0 / math.cos(angle), n / math.cos(inside), m / math.cos(last))), strict=True):
            first, second = (a - b) / (a + b), (b - c) / (b + c)
            wave = complex(math.cos(phase), -math.sin(phase))
            assert float(got) == pytest.approx(abs((first + second * wave) / (1 + first * second * wave))**2, rel=1e-12)


def test_energy_is_kept_through_layers():
    """T by the transmitted field: T = 4 η₀ η / |η₀ B + C|², from 2 × 2 matrices multiplied out."""
    angle, wavelength, n, m = 0.7, 0.49, 1.0, 1.7
    layers = [(1.38, 0.25), (2.05, 0.5), (1.62, 0.25)]
    found = Coating(tuple(Layer(*layer) for layer in layers), 0.55).reflectance(n, m, math.cos(angle), wavelength)
    for got, power in zip(found, (1, -1), strict=True):
        def admittance(index, power=power):
            return index * math.sqrt(1.0 - (math.sin(angle) / index) ** 2) ** power
        whole = np.eye(2, dtype=complex)
        for index, waves in layers:
            d = 2 * math.pi * waves * 0.55 / wavelength * math.sqrt(1.0 - (math.sin(angle) / index) ** 2)
            eta = admittance(index)
            whole = whole @ [[math.cos(d), 1j * math.sin(d) / eta], [1j * eta * math.sin(d), math.cos(d)]]
        field, flow = whole @ [1.0, admittance(m)]
        passed = 4.0 * admittance(n) * admittance(m) / abs(admittance(n) * field + flow) ** 2
        assert float(got) + passed == pytest.approx(1.0, abs=1e-14)


def test_three_layers_reflect_a_third_of_a_per_cent_over_the_visible_on_every_glass():
    for index in (1.5, 1.6, 1.7, 1.8, 1.9):
        mean = np.mean([COATINGS["multi-layer"].reflectance(1.0, index, wavelength=w).mean
                        for w in np.linspace(0.42, 0.68, 27)])
        assert 0.002 < mean < 0.0045
        assert float(COATINGS["multi-layer"].reflectance(1.0, index, wavelength=0.55).mean) < 1e-12


def test_a_table_is_linear_between_its_entries_and_keeps_its_ends():
    own = Coating.table((0.4, 0.6), [[0.01, 0.03], [0.02, 0.06]], (0.0, 1.0))
    assert float(own.reflectance(1.0, 1.5, math.cos(0.5), 0.5).mean) == pytest.approx(0.03, rel=1e-12)
    assert float(own.reflectance(1.0, 1.5, 1.0, 0.7).mean) == pytest.approx(0.02, rel=1e-12)
    inside = math.asin(math.sin(0.5) / 1.5)     # from the glass: the angle counts in the air
    assert float(own.reflectance(1.5, 1.0, math.cos(inside), 0.5).mean) == pytest.approx(0.03, rel=1e-9)


@pytest.mark.parametrize("wrong", [
    lambda: Coating(((1.38, 0.0),)), lambda: Coating(((0.5, 0.25),)), lambda: Coating(((None, 0.25),)),
    lambda: Coating.table((0.6, 0.4), (0.1, 0.1)), lambda: Coating.table((0.4,), ((0.1, 0.2),)),
    lambda: Coating.table((0.4,), (1.5,)), lambda: Coating(wavelength=math.nan),
    lambda: Coating(((1.38, 0.25),), wavelengths=(0.5,), reflectances=((0.1,),))])
def test_a_coating_that_cannot_be_is_refused(wrong):
    with pytest.raises(CoatingError, match="coating"):
        wrong()


def test_a_surface_keeps_its_coating_when_a_lens_is_reversed_or_scaled():
    own = lb.Surface(3.0, 10.0, lb.Glass(1.6), curvature=0.02, coating=Coating.single_layer())
    assert own.scaled(2.0).coating == own.coating == own.reversed(1.0, lb.AIR).coating


@pytest.mark.parametrize("cosine", [-0.5, 1.01, math.nan, [0.5, -1e-6]])
def test_a_number_that_is_no_cosine_of_incidence_is_refused(cosine):
    with pytest.raises(CoatingError, match="between 0 and 1"):
        Coating().reflectance(1.0, 1.5, cosine)
