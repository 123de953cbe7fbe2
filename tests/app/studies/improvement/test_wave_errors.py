"""Wave errors of an improvement: none where theory has none, those of forty digits elsewhere, and what they are for."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf

from lensbench import Glass, Lens, Surface, lenses
from lensbench.app.command.main import main
from lensbench.app.studies.improvement.improve import improved, radii
from lensbench.app.studies.improvement.merit import Goal, Merit, MeritError, goal_of
from lensbench.app.studies.improvement.wave_errors import wave_errors
from lensbench.lenses.editing.document import LensDocument
from lensbench.optics.glass import D_LINE

mp.dps = 40
TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
# Parallel light enters through the plane; an ellipse or hyperbola of the conic −n² behind it makes a perfect image
PERFECT = Lens((Surface(2.0, 6.0, curvature=0.0), Surface(5.0, 10.0, Glass(1.5), curvature=0.0),
                Surface(78.0, 10.0, curvature=-1 / 40.0, conic=-2.25)), 0)
SPHERES = replace(PERFECT, surfaces=(*PERFECT.surfaces[:2], replace(PERFECT.surfaces[2], conic=0.0)))


def beam(count=15, top=6.0):
    heights = np.linspace(-top, top, count)
    origins = np.column_stack([np.zeros(count), heights, np.full(count, -3.0)])[None]
    return origins, np.tile([0.0, 0.0, 1.0], (1, count, 1)), np.ones((1, count))


def exact(lens, height):
    """Optical length (mm) from z = −3 to the point nearest to the last vertex, and the direction there; 40 digits."""
    n, radius, thick = mpf(lens.surfaces[1].glass.n_d), 1 / mpf(lens.surfaces[2].curvature), mpf(7)
    y = mpf(height)
    sag = radius + mp.sqrt(radius**2 - y**2)                # of a sphere with a negative radius
    length = 3 + mpf(2) + n * (5 + sag)
    normal_y, normal_z = y / radius, 1 - sag / radius
    cosine = normal_z
    root = mp.sqrt(1 - n**2 * (1 - cosine**2))
    dy, dz = (root - n * cosine) * normal_y * -1, n + (root - n * cosine) * normal_z
    at = thick + sag, y
    rest = (mpf(lens.length) - at[0]) * dz - at[1] * dy
    return length + rest, dy, dz


def test_a_perfect_image_has_no_wave_error():
    errors = wave_errors(PERFECT, (D_LINE,), *beam())
    assert np.abs(errors).max() < 1e-12
    assert np.abs(wave_errors(SPHERES, (D_LINE,), *beam())).max() > 1e-4


def test_wave_errors_are_those_of_forty_digits():
    origins, directions, weights = beam()
    rays = [exact(SPHERES, y) for y in origins[0, :, 1]]
    lengths = np.array([float(length - rays[7][0]) for length, _, _ in rays])
    free = np.array([[1.0, float(dy), float(dz)] for _, dy, dz in rays])
    share = np.sqrt(1.0 / len(rays))
    left = lengths - free @ np.linalg.lstsq(free, lengths, rcond=None)[0]
    found = wave_errors(SPHERES, (D_LINE,), origins, directions, weights)
    assert found == pytest.approx(share * left, abs=1e-12)


def test_equal_colours_count_as_one_and_a_lost_ray_ends_it():
    goal = replace(goal_of(TRIPLET, 15.0, "wavefront"), colours=(D_LINE,))
    one, three = (Merit(TRIPLET.lens, replace(goal, colours=(D_LINE,) * count)) for count in (1, 3))
    assert three.rms(TRIPLET.lens) == pytest.approx(one.rms(TRIPLET.lens), rel=1e-9)
    assert wave_errors(TRIPLET.lens, (D_LINE,), *beam(5, 30.0)) is None
    with pytest.raises(MeritError, match="choose one of spot, wavefront"):
        Merit(TRIPLET.lens, Goal(0.2, aim="glare"))


@pytest.mark.slow
def test_each_aim_is_met_best_by_its_own_improvement(capsys):
    goals = {aim: goal_of(TRIPLET, 15.0, aim) for aim in ("spot", "wavefront")}
    merits = {aim: Merit(TRIPLET.lens, goal) for aim, goal in goals.items()}
    ends = {aim: list(improved(TRIPLET, radii(TRIPLET), goal))[-1].document.lens for aim, goal in goals.items()}
    for aim, other in (("spot", "wavefront"), ("wavefront", "spot")):
        assert merits[aim].rms(ends[aim]) < merits[aim].rms(ends[other])
        assert merits[aim].rms(ends[aim]) < merits[aim].rms(TRIPLET.lens)
    assert main(["improve", "lenshh-cooke-triplet-50", "--merit", "wavefront"]) == 0
    assert "waves rms" in capsys.readouterr().out
