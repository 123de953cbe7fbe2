"""The lens card: what is known of a lens, what is estimated, and its glasses."""

from dataclasses import replace

import pytest

from lensbench import lenses
from lensbench.app.panels.lens_card import LensCardState, glass_rows, lens_card_panel, provenance
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.system import Aperture, ApertureKind, FieldPoint, SystemData, Wavelength
from tests.app.stand import drive

LENS = "lv-leica-summicron-m-50f2-v5"


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", LENS, "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"])
def test_the_card_agrees_with_the_library(name):
    card = next(card for card in lenses.describe() if card.name == name)
    rows = dict(provenance(lenses.load(name)))
    assert rows.get("Maker", "") == card.maker and rows.get("Estimated *", "") == card.estimates
    assert rows["Elements"].startswith(f"{card.elements} in {card.groups} group")
    assert rows.get("Year", "").startswith(str(card.year or ""))
    length, speed = rows["Computed"].split(" mm  f/")
    assert float(length.split("–")[0]) == pytest.approx(card.efl, rel=1e-3)
    assert float(speed) == pytest.approx(card.computed_f_number, abs=0.006)


def test_an_estimated_year_has_a_star_and_what_is_not_known_no_row():
    lens = replace(lenses.load(LENS), year=1950, estimates="year, all rims", designer="", patent="")
    rows = dict(provenance(lens))
    assert rows["Year"] == "1950*" and "Designer" not in rows and "Patent" not in rows


def test_what_the_lens_was_designed_for_has_its_rows():
    system = SystemData(Aperture(ApertureKind.PUPIL_DIAMETER, (8.0, 10.0)), fields=(FieldPoint(3.0, 4.0),),
                        wavelengths=(Wavelength(0.248),))
    rows = dict(provenance(replace(lenses.load(LENS), system=system)))
    assert (rows["Aperture"], rows["Fields"], rows["Wavelengths"]) == (
        "entrance-pupil diameter 8, 10 mm", "angle (3, 4)°", "248 nm")
    assert "Object" not in rows and "Aperture" not in dict(provenance(lenses.load(LENS)))


def test_every_glass_has_a_row_with_its_surface():
    lens = lenses.load("pbrt-dgauss-50mm")
    rows = glass_rows(lens)
    assert [row.glass for row in rows] == [surface.glass for surface in lens.surfaces if surface.glass.n_d > 1.0]
    assert all(lens.surfaces[row.surface].glass == row.glass for row in rows)


@pytest.mark.slow
def test_the_check_runs_in_the_background_and_every_part_is_drawn():
    state, settings = LensCardState(), [replace(Settings(), lens=LENS)]

    def use(ctx):
        for _ in range(2000):
            ctx.yield_()
            if state.checks.found or state.checks.problems:
                break
        assert not state.checks.problems and len(state.checks.found) == 1
        for name in ("lib-us10281683", "no such lens"):
            settings[0] = replace(Settings(), lens=name)
            ctx.yield_(3)
        settings[0] = replace(Settings(), camera="perspective")
        ctx.yield_(3)

    drive(lambda: lens_card_panel(settings[0], state), use, (300, 700))
    state.checks.stop()
