"""Ghosts of a lens: the paraxial estimate against closed forms, and the traced table against the estimate."""

import math

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.ghost_ranking import ghosts, paraxial_ghost
from lensbench.optics.ghost_path import ghost_path

N = 1.5
R = ((N - 1.0) / (N + 1.0)) ** 2
GAUSS = lenses.load("pbrt-dgauss-50mm")


def test_the_ghost_of_a_thin_singlet_focuses_where_the_closed_form_says():
    """A thin lens of power φ and two reflections has the power φ (3 n − 1) / (n − 1)."""
    c, d = 0.01, 1e-7
    thin = lb.Lens((lb.Surface(d, 1.0, lb.Glass(N), curvature=c), lb.Surface(100.0, 1.0, curvature=-c)), 0)
    focus, diameter, share = paraxial_ghost(thin, 30.0, (0, 1))
    short = 100.0 * (N - 1.0) / (3.0 * N - 1.0)
    assert focus + 30.0 == pytest.approx(short, rel=1e-6)
    assert diameter == pytest.approx(2.0 * (30.0 / short - 1.0), rel=1e-6) and share == pytest.approx(R**2, rel=1e-9)
    near = ghost_path(thin, (0, 1), (1e-4, 0.0, -1.0), (0.0, 0.0, 1.0))
    assert near.points[-1, 2] - near.points[-1, 0] * near.direction[2] / near.direction[0] == pytest.approx(short,
                                                                                                          rel=1e-5)


def test_the_traced_table_agrees_with_the_paraxial_estimate_on_the_axis():
    lens = lb.stopped_down(GAUSS, 32.0)                 # so narrow that aberrations are small
    found = ghosts(lens, lb.film_distance(lens, math.inf))
    assert len(found.rows) == 45 and found.rows[0].brightness >= found.rows[-1].brightness
    for row in found.rows:
        # A grid of 31 cells counts the rays within a circle to some percent
        assert row.share == pytest.approx(row.paraxial_share, rel=0.1)
        assert row.diameter == pytest.approx(row.paraxial_diameter, rel=0.1, abs=0.01)


@pytest.mark.slow
def test_a_lens_without_rotational_symmetry_has_no_paraxial_estimate():
    """The matrices of one meridian promised a ghost of 0.006 mm that spreads over 3 mm."""
    anamorphic = lenses.load("lentil-schneider-anamorphic-31-2001")
    found = ghosts(anamorphic, lb.film_distance(anamorphic, math.inf))
    assert all(math.isnan(value) for row in found.rows for value in (row.focus, row.paraxial_diameter,
                                                                     row.paraxial_share))
    assert found.rows[0].diameter > 1.0


def test_the_narrow_beam_of_a_fisheye_is_found_in_its_wide_front():
    """No ray of the first scan passed: table and pictures had no ghosts, and said that no light reaches the film."""
    lens = lenses.load("lib-miyamoto-fisheye-1964")
    away, front = lb.film_distance(lens, math.inf), lens.surfaces[0].semi_diameter
    found = ghosts(lens, away, (0.0, 0.7, math.inf), coating="uncoated", cells=21)
    entering = (lb.first_order(lens).entrance_pupil.radius / front) ** 2 * lb.transmission(lens, coating="uncoated")
    assert found.direct == pytest.approx(entering, rel=0.05) and 0.0 < found.total < 0.1
