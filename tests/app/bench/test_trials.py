"""The trials of the first minutes, and the terms that the read-outs use."""

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.lens_choice import TRIALS, tried
from lensbench.app.bench.readouts import Readings
from lensbench.app.panels.readouts import Status, rows
from lensbench.app.settings.settings import Settings
from lensbench.app.window.terms import TERMS

PROGRESS = ("Rays", "Frames")       # of the window, no terms of optics


@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: trial.title)
def test_a_trial_shows_its_lens_at_its_aperture_before_its_scene(trial):
    found = tried(Settings(samples=7, pixels_x=300, pixels_y=200, exposure=3.0), trial)
    assert (found.lens, found.scene, found.blades) == (trial.lens, trial.scene, trial.blades)
    assert found.f_number == trial.f_number
    assert (found.samples, found.exposure) == (7, lb.builtin_scene(trial.scene).exposure)
    card = next(card for card in lenses.describe() if card.name == trial.lens)
    assert readings(found).efl == pytest.approx(card.efl, rel=0.01)


def test_every_read_out_is_explained_among_the_terms():
    said = " ".join(f"{term.name} {term.meaning}" for group in TERMS.values() for term in group).casefold()
    names = {row.name.partition(",")[0] for row in rows(Settings(), Readings(), Status())}
    assert sorted(name for name in names - set(PROGRESS) if name.casefold() not in said) == []
