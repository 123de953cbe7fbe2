"""A copy of a production run as a lens: the public tracer gives its rays, spots and film as the run does."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.design.tolerance_rays import Judge
from lensbench.core.design.tolerances import Tolerances, manufactured, production

TRIPLET = lb.stopped_down(lenses.load("lenshh-cooke-triplet-50"), 5.6)


@pytest.mark.slow
def test_the_rays_of_a_copy_make_the_spots_of_the_run():
    wide = Tolerances(0.002, 0.05, 0.001, 0.03, 0.001)
    film = lb.Film(24.0, 16.0)
    run, judge = production(TRIPLET, film, wide, copies=3, seed=5), Judge(TRIPLET, film, None)
    for copy in range(3):
        lens = manufactured(TRIPLET, run, copy)
        assert not lens.is_rotationally_symmetric and lens.length != TRIPLET.length
        at = []
        for wavelength in judge.wavelengths:
            rays = lb.trace(lens, judge.origins, judge.directions, wavelength, clip=False, forward=True)
            assert (rays.fate == lb.Fate.PASSED).all()
            slope = rays.directions[:, :2] / rays.directions[:, 2:]
            at.append(rays.points[:, :2] + (run.film[copy] - rays.points[:, 2:]) * slope)
        for field in range(len(run.fields)):
            here = judge.fields == field
            points = np.concatenate([each[here] for each in at])
            weights = np.outer(judge.weights, judge.areas[here]).ravel()
            middle = (weights[:, None] * points).sum(0)
            spot = np.sqrt((weights * ((points - middle) ** 2).sum(1)).sum())
            # The table of a changed glass holds its indices to 1e-6, and a spot of 10 µm to a thousandth
            assert spot == pytest.approx(run.spots[copy, field], rel=1e-3)


def test_a_changed_glass_has_the_change_at_every_wavelength():
    run = production(TRIPLET, tolerances=Tolerances(0.0, 0.0, 0.001, 0.0, 0.0), copies=1)
    lens = manufactured(TRIPLET, run, 0)
    for (kind, i), error in zip(run.names, run.drawn[0], strict=True):
        assert kind == "index"
        for wavelength in (0.4047, 0.4861, 0.5876, 0.6563, 0.9):
            glass = TRIPLET.surfaces[i].glass
            assert lens.surfaces[i].glass.index(wavelength) - glass.index(wavelength) == pytest.approx(error, abs=1e-6)


def test_a_copy_that_the_run_does_not_have_is_refused():
    run = production(TRIPLET, tolerances=Tolerances(0.0, 0.01, 0.0, 0.0, 0.0), copies=1)
    with pytest.raises(lb.LensError, match="copies 0 to 0"):
        manufactured(TRIPLET, run, 1)
    with pytest.raises(lb.LensError, match="another lens"):
        manufactured(lb.Lens(TRIPLET.surfaces[:3], 1), run, 0)
