"""Glasses against published indices, closed forms and each other."""

import re
from math import inf, nan, sqrt

import pytest
from hypothesis import given, strategies as st

import lensbench as lb
from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE, Glass, GlassError, from_formula

BK7 = (1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653)     # SCHOTT's data sheet


@given(st.floats(1.3, 2.2), st.floats(15.0, 100.0))
def test_the_model_reproduces_its_index_and_abbe_number(n_d, v_d):
    glass = Glass(n_d, v_d)
    assert glass.index() == n_d
    assert (n_d - 1.0) / (glass.index(F_LINE) - glass.index(C_LINE)) == pytest.approx(v_d, rel=1e-12)


@given(st.floats(1.3, 2.2), st.floats(15.0, 95.0), st.floats(0.365, 0.9), st.floats(1e-3, 0.1))
def test_the_model_bends_short_waves_more(n_d, v_d, wavelength, step):
    assert Glass(n_d, v_d).index(wavelength) > Glass(n_d, v_d).index(wavelength + step)


def test_a_glass_without_an_abbe_number_does_not_disperse():
    assert Glass(1.5).index(0.4) == Glass(1.5).index(0.7) == 1.5
    assert not Glass(1.5).disperses and not Glass(1.0).disperses and Glass(1.5, 60.0).disperses


def test_bk7_has_the_indices_of_its_data_sheet():
    glass = from_formula("N-BK7", "sellmeier", BK7, (0.3, 2.5))
    published = {0.3650146: 1.53627, 0.4046561: 1.53024, 0.4358343: 1.52668, 0.4861327: 1.52238, 0.5875618: 1.51680,
                 0.6562725: 1.51432, 0.7065188: 1.51289, 1.060: 1.50669}
    for wavelength, n in published.items():
        assert glass.index(wavelength) == pytest.approx(n, abs=6e-6)         # printed to five digits
    assert glass.v_d == pytest.approx(64.17, abs=5e-3)


W = 0.5
CLOSED_FORMS = [        # the same index written in each formula's own coefficients
    ("schott", (2.25, 0.01, 0.02, 1e-3, 1e-4, 1e-5), sqrt(2.25 + 0.01 * W**2 + 0.02 / W**2 + 1e-3 / W**4
                                                          + 1e-4 / W**6 + 1e-5 / W**8)),
    ("extended-2", (2.25, 0.01, 0.02, 0, 0, 0, 1e-3, 1e-4), sqrt(2.25 + 0.01 * W**2 + 0.02 / W**2 + 1e-3 * W**4
                                                                 + 1e-4 * W**6)),
    ("extended-3", (2.25, 0.01, 1e-3, 0.02, 0, 0, 0, 0, 1e-6), sqrt(2.25 + 0.01 * W**2 + 1e-3 * W**4 + 0.02 / W**2
                                                                    + 1e-6 / W**12)),
    ("sellmeier", (1.2, 0.01), sqrt(1.0 + 1.2 * 0.25 / 0.24)),
    ("sellmeier-2", (0.2, 1.0, 0.1, 0.01, 0.2), sqrt(1.2 + 0.25 / 0.24 + 0.01 / 0.21)),
    ("sellmeier-4", (1.2, 1.0, 0.01), sqrt(1.2 + 0.25 / 0.24)),
    ("handbook-1", (2.25, 0.01, 0.02, 0.01), sqrt(2.25 + 0.01 / 0.23 - 0.0025)),
    ("handbook-2", (1.25, 1.0, 0.02, 0.01), sqrt(1.25 + 0.25 / 0.23 - 0.0025)),
    ("herzberger", (1.5, 0.01, 1e-3, 1e-3, 1e-4, 1e-5),
     1.5 + 0.01 / 0.222 + 1e-3 / 0.222**2 + 1e-3 * W**2 + 1e-4 * W**4 + 1e-5 * W**6),
    ("cauchy", (1.5, 0.004, 1e-4), 1.5 + 0.016 + 16e-4),
    ("conrady", (1.5, 0.01, 1e-3), 1.5 + 0.02 + 1e-3 / W**3.5),
    ("table", ((0.4, 1.53), (0.5, 1.52), (0.6, 1.515)), 1.52),
]


@pytest.mark.parametrize("wavelength", [0.0, -1.0, nan, inf])
def test_what_is_no_wavelength_is_refused_by_glasses_of_one_index_too(wavelength):
    for glass in (Glass(1.62), Glass(1.0)):
        with pytest.raises(GlassError, match="it must be a positive number"):
            glass.index(wavelength)


@pytest.mark.parametrize("formula, coefficients, n", CLOSED_FORMS, ids=[row[0] for row in CLOSED_FORMS])
def test_each_formula_reads_its_coefficients_in_their_order(formula, coefficients, n):
    glass = Glass(1.5, 60.0, "G", formula, coefficients)
    assert glass.index(W) == pytest.approx(n, rel=1e-15)


def test_a_table_follows_the_curve_between_its_points():
    wavelengths = (0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7)
    exact = from_formula("N-BK7", "sellmeier", BK7, (0.3, 2.5))
    table = from_formula("N-BK7", "table", tuple((w, exact.index(w)) for w in wavelengths))
    for w in (0.41, 0.425, 0.52, F_LINE, D_LINE, C_LINE, 0.7):
        assert table.index(w) == pytest.approx(exact.index(w), abs=4e-6)    # the cubic's remainder between 0.4 and 0.45
    with pytest.raises(GlassError, match=r"from 0\.4 to 0\.7 µm"):
        table.index(0.39)


@pytest.mark.parametrize("wavelength", [0.29, 2.6, 0.0, -1.0, nan, inf])
def test_a_wavelength_out_of_range_is_an_error_that_names_the_range(wavelength):
    glass = from_formula("N-BK7", "sellmeier", BK7, (0.3, 2.5))
    with pytest.raises(GlassError, match=r"from 0\.3 to 2\.5 µm|positive number"):
        glass.index(wavelength)


@pytest.mark.parametrize("formula, coefficients, n", CLOSED_FORMS, ids=[row[0] for row in CLOSED_FORMS])
def test_every_formula_ends_where_its_range_does(formula, coefficients, n):
    glass = Glass(1.5, 60.0, "G", formula, coefficients, (W - 0.01, W + 0.02))
    assert glass.index(W - 0.01) and glass.index(W + 0.02)
    for wavelength in (W - 0.0101, W + 0.0201):
        with pytest.raises(GlassError, match=f"glass G is known from {W - 0.01:g} to {W + 0.02:g} µm, and not at"):
            glass.index(wavelength)


def test_a_model_of_two_numbers_ends_where_it_is_no_longer_a_glass():
    glass = Glass(1.62, 36.3)
    assert glass.index(0.365) > glass.index(1.014) > 1.5
    for wavelength in (0.3649, 1.0141):
        with pytest.raises(GlassError, match=r"index 1\.62 is known from 0\.365 to 1\.014 µm"):
            glass.index(wavelength)
    assert Glass(1.62).index(5.0) == 1.62               # no dispersion data of it at all


def test_a_lens_at_a_wavelength_beyond_a_glass_is_an_error_wherever_it_is_asked_for():
    glass = from_formula("N-BK7", "sellmeier", BK7, (0.3, 2.5))
    lens = lb.Lens((lb.Surface(5.0, 10.0, glass, curvature=0.02), lb.Surface(90.0, 9.0, curvature=0.0)), 1)
    for ask in (lambda: lens.indices(2.6), lambda: lb.first_order(lens, 2.6), lambda: lb.seidel(lens, 0.1, 2.0, 2.6),
                lambda: lb.trace(lens, [0.0, 1.0, -5.0], [0.0, 0.0, 1.0], wavelength=2.6)):
        with pytest.raises(GlassError, match=r"N-BK7 is known from 0\.3 to 2\.5 µm, and not at 2\.6 µm"):
            ask()


def test_a_glass_for_the_infrared_holds_the_index_nearest_to_the_d_line():
    glass = from_formula("IR", "herzberger", (2.6, 0.065, 0.099, 0.0), (2.0, 14.0))
    assert glass.n_d == glass.index(2.0) and glass.v_d is None
    with pytest.raises(GlassError, match="from 2 to 14 µm"):
        glass.index()


@pytest.mark.parametrize("wrong", [
    {"formula": "sellmeyer", "coefficients": (1.0,)}, {"formula": "sellmeier"},
    {"formula": "sellmeier", "coefficients": (1.0, 0.01, 1.0)},
    {"formula": "schott", "coefficients": (2.2, 0.0, nan, 0.0, 0.0, 0.0)},
    {"formula": "table", "coefficients": ((0.5, 1.5), (0.4, 1.51))}, {"wavelengths": (0.7, 0.4)},
    {"wavelengths": (nan, 0.7)}, {"n_d": 0.9}, {"v_d": -3.0}])
def test_a_glass_that_cannot_be_is_refused(wrong):
    with pytest.raises(GlassError):
        Glass(**{"n_d": 1.5, "v_d": 60.0, **wrong})


def test_a_formula_beyond_its_poles_is_an_error_and_no_number():
    with pytest.raises(GlassError, match="has no index"):
        Glass(1.5, 60.0, "pole", "sellmeier", (1.0, 0.25)).index(0.4)


@pytest.mark.parametrize("given", [{"name": "N-BK7"}, {"n_d": "N-BK7"}])
def test_the_name_of_a_glass_alone_is_refused_and_the_message_looks_it_up(given):
    with pytest.raises(GlassError, match="needs its index") as told:
        Glass(**given)
    found = eval(re.search(r"lb\.glass\(.*\)", str(told.value))[0])
    assert found.n_d == pytest.approx(1.5168, abs=1e-5)             # SCHOTT's data sheet
    with pytest.raises(GlassError, match="it must be a number of at least 1"):
        Glass()
    with pytest.raises(TypeError, match="glass 'N-BK7': it must be an lb.Glass"):
        lb.Surface(radius=50.0, thickness=4.0, semi_diameter=10.0, glass="N-BK7")
