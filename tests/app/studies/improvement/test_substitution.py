"""Other glasses in an improvement: they make the spots smaller than the radii alone, by the same rays."""

import pytest

from lensbench import Glass, lenses
from lensbench.app.command.main import main
from lensbench.app.studies.improvement.improve import improved, radii
from lensbench.app.studies.improvement.merit import Merit, MeritError, goal_of
from lensbench.app.studies.improvement.substitution import FAR_N, FAR_V, SAME, TRIED, around, substituted
from lensbench.lenses import glass_catalogue
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.paraxial import focal_length
from tests.app.studies.improvement.test_improve import SINGLET


def test_the_glasses_tried_are_the_nearest_and_differ_from_each_other():
    known = [entry for entry in glass_catalogue.entries() if entry.n_d and entry.v_d]
    found = around(Glass(1.62, 60.0), known)
    places = [(1.62 / FAR_N, 60.0 / FAR_V), *((each.n_d / FAR_N, each.v_d / FAR_V) for each in found)]
    assert len(found) == TRIED
    for k, (x, y) in enumerate(places):
        assert all((x - u) ** 2 + (y - v) ** 2 > SAME**2 for u, v in places[:k])
    away = [(x - places[0][0]) ** 2 + (y - places[0][1]) ** 2 for x, y in places[1:]]
    assert away == sorted(away) and away[-1] < 1.0


@pytest.mark.slow
def test_a_lens_gets_glasses_of_the_maker_and_smaller_spots_than_by_its_radii():
    goal = goal_of(SINGLET, 4.0)
    cells, merit = radii(SINGLET), Merit(SINGLET.lens, goal)
    alone = list(improved(SINGLET, cells, goal))[-1]
    steps = list(substituted(SINGLET, cells, goal, "SCHOTT"))
    assert all(after.merit <= before.merit for before, after in zip(steps, steps[1:], strict=False))
    assert [step.number for step in steps] == sorted(step.number for step in steps)
    lens = steps[-1].document.lens
    glass = lens.surfaces[1].glass
    assert glass.name in {entry.name for entry in glass_catalogue.entries() if entry.maker == "SCHOTT"}
    # Colour is most of the blur of a single lens: a glass of less dispersion
    assert glass.v_d > 60.0 and merit.rms(lens) < 0.95 * alone.rms
    assert merit.rms(lens) == pytest.approx(steps[-1].rms)
    assert focal_length(lens.surfaces) == pytest.approx(goal.focal_length, rel=5e-3)


def test_no_glass_of_an_unknown_maker_and_none_for_a_lens_without_abbe_numbers(capsys):
    goal = goal_of(SINGLET, 4.0)
    with pytest.raises(MeritError, match="no glass of BRASS: choose one of .*SCHOTT"):
        next(substituted(SINGLET, radii(SINGLET), goal, "BRASS"))
    plain = LensDocument(lenses.load("pbrt-dgauss-50mm"))
    with pytest.raises(MeritError, match="no Abbe numbers"):
        next(substituted(plain, radii(plain), goal_of(plain, 10.0)))
    assert main(["improve", "lenshh-cooke-triplet-50", "--glasses", "brass"]) == 2
    assert "no glass of BRASS" in capsys.readouterr().err
