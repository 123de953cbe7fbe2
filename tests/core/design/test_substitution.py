"""Other glasses in an improvement: they make the spots smaller than the radii alone."""

import pytest

import lensbench as lb
from lensbench import Glass, lenses
from lensbench.core.design.goal import MeritError
from lensbench.core.design.improve import FAR_N, FAR_V, SAME, TRIED, around, substitute
from lensbench.lenses.glass.catalogue import entries, replacements
from tests.core.design.test_merit import SINGLET


def test_the_glasses_tried_are_the_nearest_and_differ_from_each_other():
    found = around(Glass(1.62, 60.0), replacements())
    places = [(1.62 / FAR_N, 60.0 / FAR_V), *((each.n_d / FAR_N, each.v_d / FAR_V) for each in found)]
    assert len(found) == TRIED
    for k, (x, y) in enumerate(places):
        assert all((x - u) ** 2 + (y - v) ** 2 > SAME**2 for u, v in places[:k])
    away = [(x - places[0][0]) ** 2 + (y - places[0][1]) ** 2 for x, y in places[1:]]
    assert away == sorted(away) and away[-1] < 1.0


@pytest.mark.slow
def test_a_lens_gets_glasses_of_the_maker_and_smaller_spots_than_by_its_radii():
    goal, steps = lb.goal_of(SINGLET, 4.0), []
    alone = lb.improve(SINGLET, "radii", goal)
    done = substitute(SINGLET, "radii", goal, replacements("SCHOTT"), progress=steps.append)
    assert all(after.judgement.total < before.judgement.total for before, after in zip(steps, steps[1:], strict=False))
    assert [step.number for step in steps] == list(range(len(steps))) and done.steps == steps[-1].number
    glass = done.lens.surfaces[1].glass
    assert glass.name in {entry.name for entry in entries() if entry.maker == "SCHOTT"}
    # Colour is most of the blur of a single lens: a glass of less dispersion
    assert glass.v_d > 60.0 and done.end.rms < 0.95 * alone.end.rms
    assert lb.judge(done.lens, goal).rms == pytest.approx(done.end.rms, rel=1e-6)
    assert lb.first_order(done.lens).efl == pytest.approx(lb.first_order(SINGLET).efl, rel=1e-3)
    some = []
    ended = substitute(SINGLET, "radii", goal, replacements("SCHOTT"), progress=some.append,
                       cancelled=lambda: len(some) >= alone.steps + 2)
    assert ended.ended == "cancelled" and ended.lens.surfaces[1].glass != SINGLET.surfaces[1].glass


def test_no_glass_of_an_unknown_maker_and_none_for_a_lens_without_abbe_numbers():
    with pytest.raises(lb.GlassError, match="no glass of BRASS: choose one of .*SCHOTT"):
        replacements("BRASS")
    plain = lenses.load("pbrt-dgauss-50mm")
    with pytest.raises(MeritError, match="no Abbe numbers"):
        substitute(plain, "radii", lb.goal_of(plain, 10.0), replacements("SCHOTT"))
