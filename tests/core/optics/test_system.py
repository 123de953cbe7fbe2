from math import inf, nan

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, Wavelength

RELAY = SystemData(Aperture(ApertureKind.PUPIL_DIAMETER, (10.0, 8.0)), FieldKind.OBJECT_HEIGHT,
                   (FieldPoint(0.0, 0.0), FieldPoint(3.0, -4.0, 2.0, (0.1, 0.2, 0.0, -0.05))),
                   (Wavelength(0.248), Wavelength(0.2485, 0.5)), 0, (200.0, inf))


def test_scaling_scales_lengths_alone():
    twice = RELAY.scaled(2.0)
    assert twice.aperture.values == (20.0, 16.0)
    assert twice.fields[1] == FieldPoint(6.0, -8.0, 2.0, (0.1, 0.2, 0.0, -0.05))
    assert twice.object_distances == (400.0, inf)
    assert twice.wavelengths == RELAY.wavelengths


@pytest.mark.parametrize("kind", [ApertureKind.F_NUMBER, ApertureKind.OBJECT_NA, ApertureKind.WORKING_F_NUMBER])
def test_ratios_and_angles_keep_their_value_when_scaled(kind):
    data = SystemData(Aperture(kind, (0.5,)), FieldKind.ANGLE, (FieldPoint(0.0, 20.0),))
    assert data.scaled(3.0) == data


def test_a_scaled_lens_has_scaled_system_data():
    lens = lenses.load("lenshh-petzval")
    assert lens.system == SystemData()
    given = lb.Lens(lens.surfaces, lens.stop_index, system=RELAY)
    assert given.scaled(0.5).system == RELAY.scaled(0.5)


@pytest.mark.parametrize("factor", [0.0, -1.0, inf, nan])
def test_a_lens_is_scaled_by_a_positive_number_alone(factor):
    with pytest.raises(lb.LensError, match="must be a positive number"):
        lenses.load("lenshh-petzval").scaled(factor)


def test_the_primary_wavelength_is_the_d_line_unless_stated():
    assert SystemData().primary_wavelength == lb.D_LINE
    assert RELAY.primary_wavelength == 0.248


def test_the_largest_field_is_a_distance_from_the_axis():
    assert RELAY.largest_field == 5.0
    assert SystemData().largest_field == 0.0


@pytest.mark.parametrize("invalid", [
    lambda: Aperture(ApertureKind.F_NUMBER, (0.0,)),
    lambda: Aperture(ApertureKind.F_NUMBER, ()),
    lambda: Aperture(ApertureKind.PUPIL_DIAMETER, (nan,)),
    lambda: FieldPoint(inf, 0.0),
    lambda: FieldPoint(0.0, 0.0, weight=-1.0),
    lambda: Wavelength(0.0),
    lambda: Wavelength(0.5, nan),
    lambda: SystemData(primary=1),
    lambda: SystemData(object_distances=(nan,)),
    lambda: SystemData(object_distances=()),
])
def test_impossible_system_data_are_refused(invalid):
    with pytest.raises(lb.SystemDataError):
        invalid()


def test_the_stop_size_may_be_that_of_the_rim():
    assert Aperture(ApertureKind.STOP_SIZE, (0.0,)).values == (0.0,)


@pytest.mark.parametrize("size", [(36.0, 0.0), (nan, 24.0), (inf, 24.0)])
def test_a_film_without_a_size_is_refused(size):
    surfaces = lenses.load("lenshh-petzval").surfaces
    with pytest.raises(lb.LensError, match="film_size"):
        lb.Lens(surfaces, 0, film_size=size)
