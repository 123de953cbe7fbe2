"""Elements, groups and focus groups, held to what makers publish of their products."""

from dataclasses import replace

import pytest

from lensbench import Glass, Lens, Surface, lenses
from lensbench.lenses.tables.counts import counts

CROWN, FLINT = Glass(1.5168, 64.2), Glass(1.62, 36.3)


@pytest.mark.parametrize(("name", "elements", "groups"), [
    ("lv-nikon-z-58f095-noct", 17, 10),
    ("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", 21, 15),
    ("lv-minolta-af-100mm-f28-macro", 8, 8),
    ("lv-zeiss-planar-t-50f14", 7, 6),
    ("lv-leica-summicron-m-50f2-v5", 6, 4),
    ("lv-czj-tessar-50-f28", 4, 3),
    ("lib-goerz-dagor", 6, 2)])
def test_the_counts_are_those_that_the_maker_publishes(name, elements, groups):
    numbers = counts(lenses.load(name))
    assert (numbers.elements, numbers.groups) == (elements, groups)


def test_plates_resin_layers_and_a_stop_inside_an_element_do_not_count():
    doublet = (Surface(4.0, 10.0, CROWN, curvature=0.02), Surface(1.0, 10.0, FLINT, curvature=-0.02),
               Surface(5.0, 10.0, curvature=0.0))
    plate = (Surface(1.0, 10.0, CROWN, curvature=0.0), Surface(20.0, 10.0, curvature=0.0))
    resin = (Surface(0.1, 10.0, FLINT, curvature=0.019), *doublet)
    split = (Surface(2.0, 10.0, CROWN, curvature=0.02), Surface(2.0, 9.0, CROWN, curvature=0.0), *doublet[1:])
    for table, elements in ((doublet, 2), (doublet + plate, 2), (resin, 2), (split, 2)):
        numbers = counts(Lens(table, 1))
        assert (numbers.elements, numbers.groups, numbers.surfaces) == (elements, 1, len(table))


def test_a_block_between_varying_gaps_is_one_focus_group():
    lens = lenses.load("lv-minolta-af-100mm-f28-macro")
    assert counts(lens).focus_groups == 3           # two floating gaps, and the whole moves
    assert counts(replace(lens, positions=None)).focus_groups == 0
    assert counts(lenses.load("lv-nikon-z-58f095-noct")).focus_groups >= 1


def test_aspheres_are_surfaces_with_a_conic_or_terms():
    plain = Surface(4.0, 10.0, CROWN, curvature=0.02)
    table = (plain, replace(plain, conic=-1.0), replace(plain, aspheric=((4, 1e-6),)),
             replace(plain, curvature=0.0, conic=-1.0), replace(plain, curvature_x=0.0))
    assert counts(Lens(table, 0)).aspheres == 2
