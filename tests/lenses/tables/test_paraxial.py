"""Paraxial figures of the rows of files, against the first-order data of the built lens."""

from dataclasses import replace
from math import inf

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses.tables.paraxial import f_number, focal_length, image_distance

STACK = lenses.load("lib-tronnier-1953")


@pytest.mark.parametrize("wavelength", [lb.D_LINE, 0.4358])
@pytest.mark.parametrize("index", [1.0, 1.333])
def test_rows_of_any_medium_and_colour_have_the_figures_of_the_lens(index, wavelength):
    lens = replace(STACK, front_index=index)
    fo = lb.first_order(lens, wavelength)
    stated = wavelength, index
    assert focal_length(lens.surfaces, *stated) == pytest.approx(fo.efl, rel=1e-12)
    assert f_number(lens.surfaces, lens.stop_index, *stated) == pytest.approx(fo.f_number, rel=1e-12)
    assert image_distance(lens.surfaces, inf, *stated) == pytest.approx(fo.bfl, rel=1e-12)
    for distance in (0.5, 8000.0, -40.0):
        behind = index * fo.efl**2 / (distance + fo.ffl)                        # Newton's equation
        assert image_distance(lens.surfaces, distance, *stated) == pytest.approx(fo.bfl + behind, rel=1e-10)
