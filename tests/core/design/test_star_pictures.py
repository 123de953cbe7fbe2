"""Pictures of a star: their lines have the contrast that the rays of the same field give, and keep their light."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.design.tolerance_rays import Judge
from lensbench.core.design.tolerances import PAIRS, SIDE, Tolerances, production, star_pictures


@pytest.mark.slow
def test_a_ring_of_the_star_has_the_contrast_of_the_run_at_its_frequency():
    lens, film = lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0)
    frequency = 15.0
    run = production(lens, film, Tolerances(0.004, 0.1, 0.002, 0.0, 0.0), copies=3, seed=2, frequencies=[frequency])
    found, width = star_pictures(lens, run, [0, 1, 2], film)
    assert found.shape == (4, len(run.fields), SIDE, SIDE) and width == pytest.approx(film.diagonal / PAIRS)
    # Around a ring of the radius r the sectors have the frequency PAIRS / (2 π r); without tilts the axis blurs evenly
    radius = PAIRS / (2.0 * math.pi * frequency) / (width / SIDE)
    at = np.arange(SIDE) - 0.5 * (SIDE - 1)
    away, angle = np.hypot(at, at[:, None]), np.arctan2(at[:, None], at)
    ring = (away > radius - 2.0) & (away < radius + 2.0)
    judge = Judge(lens, film, [frequency])
    contrast = [run.nominal, *run.contrast]
    for picture, exact in zip(found, contrast, strict=True):
        wave = np.exp(1j * PAIRS * angle[ring])
        # A square wave from 0 to 1 has the amplitude 2 / π; pixels take a part of it, as sinc of their width does
        pixel = np.sinc(frequency * width / SIDE)
        seen = abs(2.0 * np.mean(picture[0][ring] * wave)) / (2.0 / math.pi) / pixel
        assert seen == pytest.approx((exact - judge.diffraction)[0, 0].mean() / judge.limits[0], abs=0.03)
    assert min(exact[0, 0].mean() for exact in contrast) < 0.9 * max(exact[0, 0].mean() for exact in contrast)
    assert found.mean((2, 3)) == pytest.approx(0.5, abs=5e-3)
