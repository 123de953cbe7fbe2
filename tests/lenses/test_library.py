"""The library lenses: each agrees with its header, is sound, and the famous types are present."""

import math
from dataclasses import asdict

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses.counts import counts
from lensbench.lenses.toml_header import COUNTS

NAMES = lenses.names()
CARDS = {card.name: card for card in lenses.describe()}


def test_the_library_has_the_famous_types():
    kinds = {card.kind for card in CARDS.values()}
    assert kinds >= {"double Gauss", "Tessar", "Cooke triplet", "Petzval", "Heliar", "Sonnar", "Biogon", "Topogon",
                     "Dagor", "Protar", "retrofocus", "telephoto", "fisheye", "phone lens"}
    assert len(NAMES) >= 24 and NAMES == sorted(NAMES)


def test_cards_are_in_the_order_of_the_names_and_complete():
    assert [card.name for card in lenses.describe()] == NAMES
    assert len({card.title for card in CARDS.values()}) == len(NAMES)
    for card in CARDS.values():
        assert card.title and card.kind and card.source and card.efl > 0.0 and card.f_number > 0.9
        assert card.year is None or 1840 <= card.year <= 2025
        assert card.image_circle is None or card.image_circle > 5.0


@pytest.mark.parametrize("name", NAMES)
def test_the_card_says_what_the_lens_is(name):
    lens, card = lenses.load(name), CARDS[name]
    assert asdict(counts(lens)) == {key: getattr(card, key) for key in COUNTS}
    assert (card.title, card.kind, card.year, card.source, card.maker, card.designer, card.patent, card.film_size,
            card.estimates, card.notes) == (lens.name, lens.kind, lens.year, lens.source, lens.maker, lens.designer,
                                            lens.patent, lens.film_size, lens.estimates, lens.notes)
    assert card.zooms == lens.zooms and card.has_aspheres == (card.aspheres > 0)


@pytest.mark.parametrize("name", NAMES)
def test_the_stated_focal_length_is_the_computed_one(name):
    # published focal lengths are nominal: within 1 %; the header's own figure has six digits
    lens, first_order = lenses.load(name), lb.first_order(lenses.load(name))
    assert CARDS[name].efl == pytest.approx(first_order.efl, rel=1e-5)
    assert lens.stated_efl is None or lens.stated_efl == pytest.approx(first_order.efl, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_the_stated_f_number_is_that_of_the_stop(name):
    # markings round to thirds of a stop; the widest gap is the pbrt telephoto's, f/5.6 on a stop of f/5.42
    lens = lenses.load(name)
    if lens.stated_f_number is not None:
        assert lens.stated_f_number == pytest.approx(lb.first_order(lens).f_number, rel=0.04)


@pytest.mark.parametrize("name", NAMES)
def test_each_lens_can_be_built(name):
    # no gap is negative, and neighbours do not cross inside the smaller of their rims (0.1 mm for the stop's plane)
    lens = lenses.load(name)
    assert not lens.findings
    for front, back in zip(lens.surfaces, lens.surfaces[1:], strict=False):
        assert front.thickness >= 0.0 and (front.glass.n_d == 1.0 or front.thickness > 0.0)
        rim = min(front.semi_diameter, back.semi_diameter)
        edge = front.thickness
        for surface, sign in ((front, -1.0), (back, 1.0)):
            c, k = surface.curvature, surface.conic
            root = math.sqrt(max(0.0, 1.0 - (1.0 + k) * (c * rim)**2))
            edge += sign * (c * rim**2 / (1.0 + root) + sum(a * rim**power for power, a in surface.aspheric))
        assert edge > -0.1


@pytest.mark.parametrize("name", NAMES)
def test_a_thin_bundle_meets_the_axis_at_the_stored_back_focus(name):
    # real rays at 5 % of the pupil: spherical aberration there is far below 1 % of the pupil's radius × slope
    lens, first_order = lenses.load(name), lb.first_order(lenses.load(name))
    height = 0.05 * first_order.entrance_pupil.radius
    start = np.array([[0.0, height, -1.0], [height, 0.0, -1.0]])
    rays = lb.trace(lens, start, np.array([[0.0, 0.0, 1.0]] * 2))
    assert (rays.fate == lb.Fate.PASSED).all()
    film = lens.length + lens.surfaces[-1].thickness
    steps = (film - rays.points[:, 2]) / rays.directions[:, 2]
    miss = np.abs(rays.points + steps[:, None] * rays.directions)[[0, 1], [1, 0]]
    assert (miss < 0.02 * height).all()


@pytest.mark.parametrize("name", NAMES)
def test_most_of_the_pupil_is_open_on_the_axis(name):
    # up to 0.9 of the paraxial pupil: beyond, spherical aberration moves rays past the stop's edge
    lens, first_order = lenses.load(name), lb.first_order(lenses.load(name))
    heights = np.linspace(0.0, 0.9, 10) * first_order.entrance_pupil.radius
    start = np.stack([0.0 * heights, heights, 0.0 * heights - 20.0], axis=1)
    rays = lb.trace(lens, start, np.tile([0.0, 0.0, 1.0], (10, 1)))
    assert (rays.fate == lb.Fate.PASSED).all()
