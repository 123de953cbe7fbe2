"""Rays from film points beside the plane of the film to the middle of the stop, against the reference tracer."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.pupils.outline_solver import CENTRED, Aim

FILM = np.array([[0.0, 0.0, 0.0], [9.0, -4.0, 2.5], [-12.0, 8.0, -3.0], [5.0, 5.0, 6.0], [-3.0, -14.0, -1.0]])


def on_stop(lens, away, film, rear):
    """Points (n, 2) in radii of the stop at which rays from film points (n, 3), z behind the film, meet it."""
    start = film + [0.0, 0.0, lens.length + away]
    found = lb.trace(lens, start, np.column_stack([rear, np.full(len(rear), lens.length)]) - start, clip=False,
                     record=True)
    return found.paths[:, len(lens.surfaces) - lens.stop_index, :2] / lens.stop.semi_diameter


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-telephoto-250mm", "lentil-schneider-anamorphic-31-2001"])
def test_rays_to_the_centres_of_the_stop_meet_them_and_its_images_are_their_slopes(name):
    lens = lenses.load(name)
    away = lb.film_distance(lens, 3000.0)
    aim = Aim(lens, away)
    centres, images = aim.stop_centres(FILM, aim.paraxial_centres(FILM))
    middles = on_stop(lens, away, FILM, centres)
    assert np.abs(middles).max() < CENTRED
    for aside in ([1e-3, 0.0], [0.0, 1e-3]):
        moved = on_stop(lens, away, FILM, centres + images @ aside) - middles
        np.testing.assert_allclose(moved, [aside] * len(FILM), atol=3e-5)
    for start in (centres + 0.3, centres + 1e4):            # beside them, and where no ray comes through
        found, _ = aim.stop_centres_near(FILM, start)
        assert np.abs(on_stop(lens, away, FILM, found)).max() < CENTRED
