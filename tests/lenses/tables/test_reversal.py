"""Reversed lenses trace the reversed rays, and scaled lenses the scaled rays."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import AIR, Glass, Lens, Surface, lenses
from lensbench.core.optics.system import Aperture, ApertureKind, FieldPoint, SystemData, Wavelength
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.editing.elements import flipped, reversed_lens

ODD = Lens((Surface(6.0, 12.0, Glass(1.62, 60.0), -0.7, ((3, 2e-5), (4, -1e-6)), curvature=0.02),
            Surface(2.0, 12.0, Glass(1.7, 30.0), curvature=-0.015),
            Surface(5.0, 12.0, AIR, 2.0, ((6, 1e-9),), curvature=0.004),
            Surface(4.0, 12.0, Glass(1.5, 64.0), curvature=0.01, curvature_x=-0.01),
            Surface(60.0, 12.0, curvature=0.0)), 2)
LENSES = {"odd": ODD, **{name: lenses.load(name) for name in (
    "pbrt-dgauss-50mm", "lib-us10281683", "lv-nikon-z-58f095-noct", "pbrt-fisheye-10mm")}}


def through(lens, origins, directions):
    traced = lb.trace(lens, origins, directions, clip=False)
    assert (traced.fate == lb.Fate.PASSED).all()
    return traced


def rays(lens, seed):
    """Rays near the axis towards the front, of which all pass."""
    rng = np.random.default_rng(seed)
    height = 0.2 * min(surface.semi_diameter for surface in lens.surfaces)
    origins = np.column_stack([rng.uniform(-height, height, (20, 2)), np.full(20, -5.0)])
    directions = np.column_stack([rng.uniform(-0.05, 0.05, (20, 2)), np.ones(20)])
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


def test_of_the_system_data_a_reversed_lens_keeps_the_wavelengths():
    system = SystemData(Aperture(ApertureKind.PUPIL_DIAMETER, (8.0,)), fields=(FieldPoint(0.0, 5.0),),
                        wavelengths=(Wavelength(0.5), Wavelength(0.6)), primary=1, object_distances=(200.0,))
    back = reversed_lens(replace(ODD, system=system))
    assert back.system == SystemData(wavelengths=system.wavelengths, primary=1)
    assert any("belong to its other end" in str(finding) for finding in back.findings)
    marked = reversed_lens(replace(ODD, stated_f_number=2.8, stated_efl=50.0))
    assert (marked.stated_f_number, marked.stated_efl) == (None, 50.0)
    assert [str(finding) for finding in marked.findings] == [
        "the stated f-number is left out: it belongs to its other end"]
    assert not reversed_lens(ODD).findings


def turned(vectors, length=0.0):
    """Points, or with length 0 directions, in the frame of the lens reversed, seen in a mirror."""
    return vectors * [1.0, 1.0, -1.0] + [0.0, 0.0, length]


@pytest.mark.parametrize("name", LENSES)
def test_light_goes_the_same_way_back_through_the_lens_turned_round(name):
    lens = LENSES[name]
    origins, directions = rays(lens, 1)
    out = through(lens, origins, directions)
    behind = out.points + 5.0 * out.directions
    back = through(reversed_lens(lens), turned(behind, lens.length), turned(-out.directions))
    assert np.allclose(back.directions, turned(-directions), rtol=0.0, atol=1e-11)
    # It leaves on the line on which it came: a place of 1e-10 mm after twice the lens's surfaces
    onward = turned(origins, lens.length) - back.points
    assert np.abs(np.cross(onward, back.directions)).max() < 1e-10


@given(st.floats(0.01, 100.0))
@settings(max_examples=20)
@pytest.mark.parametrize("name", LENSES)
def test_a_scaled_lens_traces_the_scaled_rays(name, factor):
    lens = LENSES[name]
    origins, directions = rays(lens, 2)
    plain, scaled = through(lens, origins, directions), through(lens.scaled(factor), factor * origins, directions)
    assert np.allclose(scaled.points, factor * plain.points, rtol=1e-11, atol=1e-11 * factor * lens.length)
    assert np.allclose(scaled.directions, plain.directions, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("name", LENSES)
def test_turned_round_twice_is_the_lens_but_for_its_back_focus(name):
    lens = replace(LENSES[name], positions=None)
    twice = reversed_lens(reversed_lens(lens))
    assert twice.surfaces[:-1] == lens.surfaces[:-1] and twice.stop_index == lens.stop_index
    assert twice.surfaces[-1] == replace(lens.surfaces[-1], thickness=0.0)


@pytest.mark.parametrize("turn", [reversed_lens, lambda lens: flipped(LensDocument(lens), 0, 4).lens],
                         ids=["reversed", "flipped"])
def test_the_stop_of_a_lens_turned_about_y_passes_light_where_it_did(turn):
    picture = lb.StopImage.of(np.random.default_rng(3).random((6, 6)))
    x, y = np.random.default_rng(4).uniform(-1.0, 1.0, (2, 2000))
    for iris in ({"blades": 5, "blade_rotation": 0.4, "roundness": 0.3, "blade_reach": 1.0}, {"stop_image": picture}):
        lens = replace(ODD, **iris)
        turned_lens = turn(lens)
        assert (turned_lens.iris.transmission(-x, y) == lens.iris.transmission(x, y)).all()
        assert (turned_lens.iris.transmission(x, y) != lens.iris.transmission(x, y)).any()
        assert turn(turned_lens).iris == lens.iris
    element = flipped(LensDocument(replace(ODD, blades=5, blade_rotation=0.4)), 3, 4).lens
    assert element.blade_rotation == 0.4                    # the stop stands before it
