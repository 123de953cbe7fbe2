"""Improvement: slopes against forty digits, a spoiled triplet back at its published spot, what is held stays held."""

import json
from dataclasses import replace
from math import atan, inf

import numpy as np
import pytest
from mpmath import mp, mpf

import lensbench as lb
from lensbench import Glass, Lens, Surface, lenses
from lensbench.app.command.main import main
from lensbench.app.studies.improvement.improve import improved, jacobian, radii
from lensbench.app.studies.improvement.merit import Goal, Merit, MeritError, back_focus, goal_of, left_out
from lensbench.lenses.editing.cells import with_radius, with_rule, with_value
from lensbench.lenses.editing.document import LensDocument, Solve, with_surfaces
from lensbench.lenses.paraxial import focal_length

TRIPLET = LensDocument(lenses.load("lenshh-cooke-triplet-50"))
# A stop in front: the rays in front of the lens do not depend on it
SINGLET = LensDocument(Lens((Surface(5.0, 4.0, curvature=0.0), Surface(3.0, 9.0, Glass(1.6, 55.0), curvature=1 / 40.0),
                             Surface(40.0, 9.0, curvature=-1 / 60.0)), 0))


mp.dps = 40


def spoiled(seed):
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], 6)
    return replace(TRIPLET, lens=with_surfaces(TRIPLET.lens, [
        (i, replace(s, curvature=s.curvature / (1.0 + 0.03 * signs[i]))) for i, s in enumerate(TRIPLET.surfaces)]))


def traced(numbers, indices, origin, direction):
    """A ray through spheres in forty digits: (x, y) on the plane of the last vertex, and its slopes."""
    p, d, n = [mpf(v) for v in origin], [mpf(v) for v in direction], mpf(1)
    z = mpf(0)
    for (c, t), after in zip(numbers, indices, strict=True):
        q = [p[0], p[1], p[2] - z]
        b = d[2] - c * sum(a * e for a, e in zip(q, d, strict=True))
        f = c * sum(a * a for a in q) - 2 * q[2]
        s = f / (b + mp.sqrt(b * b - c * f))
        q = [a + s * e for a, e in zip(q, d, strict=True)]
        normal = [-c * q[0], -c * q[1], 1 - c * q[2]]
        cos = sum(a * e for a, e in zip(normal, d, strict=True))
        mu = n / mpf(after)
        g = mp.sqrt(1 - mu * mu * (1 - cos * cos)) - mu * cos
        d, n = [mu * e + g * m for e, m in zip(d, normal, strict=True)], mpf(after)
        p, z = [q[0], q[1], q[2] + z], z + t
    z -= numbers[-1][1]
    return [p[i] + (z - p[2]) * d[i] / d[2] for i in (0, 1)], [d[i] / d[2] for i in (0, 1)]


def oracle(lens, curvatures, goal, merit):
    """The spot residuals of a lens with other curvatures, in forty digits, by the words of the merit's docstring."""
    beams = merit.beams
    numbers = [(mpf(c), mpf(s.thickness)) for c, s in zip(curvatures, lens.surfaces, strict=True)]
    columns = []
    for field in range(3):
        used = np.flatnonzero(beams.weights[field])
        weights = [mpf(w) for w in beams.weights[field][used]]
        total = sum(weights) * len(merit.colours)
        origins, directions = beams.origins[field], beams.directions[field]
        found = [[traced(numbers, lens.indices(colour)[1:], origins[k], directions[k]) for k in used]
                 for colour in merit.colours]
        pairs = [(w, ray) for rays in found for w, ray in zip(weights, rays, strict=True)]
        centre = [[mpf(0), sum(w * ray[which][1] for w, ray in pairs) / total] for which in (0, 1)]
        columns += [[mp.sqrt(w / total / 3) * (ray[which][axis] - centre[which][axis]) for which in (0, 1)]
                    for w, ray in pairs for axis in (0, 1)]
    film = -sum(a * b for a, b in columns) / sum(b * b for _, b in columns)
    return np.array([a + film * b for a, b in columns])


@pytest.mark.slow
def test_residuals_and_their_slopes_are_those_of_forty_digits():
    goal = Goal(0.15)
    merit = Merit(SINGLET.lens, goal)
    curvatures = [mpf(s.curvature) for s in SINGLET.surfaces]
    exact = oracle(SINGLET.lens, curvatures, goal, merit)
    count = len(exact)
    assert np.allclose(merit.residuals(SINGLET.lens)[:count], exact.astype(float), rtol=0.0, atol=1e-12)
    scales = np.array([0.01, 0.01])
    slopes = jacobian(SINGLET, [(1, "curvature"), (2, "curvature")], scales, merit)
    for k in (1, 2):
        step = mpf(10) ** -12
        ahead, behind = ([c + sign * step * (i == k) for i, c in enumerate(curvatures)] for sign in (1, -1))
        slope = (oracle(SINGLET.lens, ahead, goal, merit) - oracle(SINGLET.lens, behind, goal, merit)) / (2 * step)
        expected = slope.astype(float) * scales[k - 1]
        assert np.abs(slopes[:count, k - 1] - expected).max() < 1e-8 * np.abs(expected).max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_spoiled_triplet_comes_back_to_its_published_spot(seed):
    goal = goal_of(TRIPLET, 18.2)
    published = Merit(TRIPLET.lens, goal).rms(TRIPLET.lens)
    start = spoiled(seed)
    steps = list(improved(start, radii(start), goal))
    assert steps[0].rms > 1.5 * published and steps[-1].rms <= published
    assert all(a.merit > b.merit for a, b in zip(steps, steps[1:], strict=False))
    assert focal_length(steps[-1].document.surfaces) == pytest.approx(goal.focal_length, rel=2e-3)
    # Only what was free has changed
    last = steps[-1].document
    assert [replace(s, curvature=0.0) for s in last.surfaces] == [replace(s, curvature=0.0) for s in start.surfaces]


@pytest.mark.slow
def test_rules_are_kept_thin_glass_is_pushed_back_and_an_asphere_cures_what_it_can():
    held = with_rule(spoiled(1), Solve(5, "efl", 50.0))
    last = list(improved(held, radii(held), goal_of(held, 12.0)))[-1].document
    assert (5, "curvature") not in radii(held) and focal_length(last.surfaces) == pytest.approx(50.0, rel=1e-12)
    thin = with_value(TRIPLET, 4, "thickness", 1.0)
    goal = replace(goal_of(TRIPLET, 5.0), edge=1.0)
    thick = list(improved(thin, [(4, "thickness")], goal))[-1].document
    assert thick.surfaces[4].thickness > 2.0
    # On the axis a conic makes a plano-hyperbolic singlet free of spherical aberration: k = −n²
    plano = LensDocument(Lens((Surface(0.0, 8.0, curvature=0.0), Surface(3.0, 9.0, Glass(1.5), curvature=0.0),
                               Surface(40.0, 9.0, curvature=-1 / 20.0)), 0))
    cured = list(improved(plano, [(2, "conic")], Goal(0.0)))[-1]
    assert cured.document.surfaces[2].conic == pytest.approx(-2.25, abs=1e-4) and cured.rms < 1e-6


def test_a_lens_that_cannot_be_improved_says_why():
    with pytest.raises(MeritError, match="no image"):
        goal_of(with_radius(TRIPLET, 0, -20.0), 18.0)
    with pytest.raises(MeritError, match="no number is free"):
        next(improved(TRIPLET, [], goal_of(TRIPLET, 18.0)))
    with pytest.raises(MeritError, match="field angle"):
        Merit(TRIPLET.lens, Goal(2.0))
    closed = with_value(TRIPLET, 3, "semi_diameter", 3.9)
    for i in (0, 1, 2, 4, 5):
        closed = with_value(closed, i, "semi_diameter", 1e-3)
    with pytest.raises(MeritError):
        Merit(closed.lens, goal_of(TRIPLET, 18.0))
    assert Merit(TRIPLET.lens, goal_of(TRIPLET, 18.0)).rms(with_radius(TRIPLET, 5, -5.0).lens) == inf


@pytest.mark.slow
def test_the_command_writes_the_improved_lens_and_its_steps(tmp_path, capsys):
    path = tmp_path / "better.toml"
    assert main(["improve", "lenshh-cooke-triplet-50", "--vary", "5.radius", "-o", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["spots_mm"][-1] < told["spots_mm"][0] and told["image_height_mm"] == pytest.approx(18.2)
    assert lenses.load(path).surfaces[5].curvature == told["numbers"][0]["after"]
    assert lb.first_order(lenses.load(path)).efl == pytest.approx(50.02, rel=2e-3)
    assert main(["improve", "lenshh-cooke-triplet-50", "--vary", "9.radius"]) == 2
    assert "of surfaces 0 to 5" in capsys.readouterr().err


def test_a_gap_that_moves_with_the_zoom_is_refused_and_not_lost_in_silence():
    zoom = LensDocument(lenses.load(next(card.name for card in lenses.describe() if card.zooms)).at(zoom=0.0))
    gap = zoom.lens.positions.gaps[0]
    with pytest.raises(MeritError, match=f"behind surface {gap} varies"):
        next(improved(zoom, [(gap, "thickness")], goal_of(zoom, 10.0)))


def test_the_radius_of_the_other_section_is_free_to_change_too():
    bent = replace(TRIPLET.surfaces[5], curvature_x=1.03 * TRIPLET.surfaces[5].curvature)
    start = replace(TRIPLET, lens=with_surfaces(TRIPLET.lens, [(5, bent)]))
    last = list(improved(start, [(5, "curvature_x")], goal_of(TRIPLET, 10.0)))[-1].document.surfaces[5]
    assert last.curvature == TRIPLET.surfaces[5].curvature
    assert last.curvature_x == pytest.approx(last.curvature, rel=3e-3)


def test_the_command_names_fields_without_light_and_each_number_once(capsys):
    asked = ["improve", "lenshh-cooke-triplet-50", "--vary", "5.radius,5.radius", "--json"]
    assert main([*asked, "--image-height", "1000"]) == 0
    told = capsys.readouterr()
    assert "No light arrives at 0.7 and 1 of the largest field angle, 85.9°" in told.err
    assert len(json.loads(told.out)["numbers"]) == 1
    assert main([*asked, "--image-height", "5"]) == 0 and not capsys.readouterr().err


def test_a_lens_in_water_is_judged_in_water_and_both_focal_lengths_of_a_toroid_are_held():
    wet = replace(TRIPLET, lens=replace(TRIPLET.lens, front_index=1.333))
    goal = goal_of(wet, 5.0)
    assert goal.focal_length == pytest.approx(lb.first_order(wet.lens).efl, rel=1e-12)
    assert goal.field == pytest.approx(atan(5.0 / (1.333 * goal.focal_length)), rel=0.01)       # but for distortion
    assert back_focus(wet.lens) == pytest.approx(lb.first_order(wet.lens).bfl, rel=1e-12)
    assert Merit(wet.lens, goal)._penalties(wet.lens, goal)[0] == pytest.approx(0.0, abs=1e-9)
    anamorphic = LensDocument(lenses.load("lentil-schneider-anamorphic-31-2001"))
    goal = goal_of(anamorphic, 10.0)
    x, y = (lb.first_order(section).efl for section in anamorphic.lens.sections)
    assert (goal.focal_length_x, goal.focal_length) == pytest.approx((x, y), rel=1e-12) and x < 0.6 * y
    assert left_out(anamorphic.lens, goal) == ["The fields lie along y: those across, and in the corners, are not "
                                               "judged"]


def test_the_largest_field_of_a_fisheye_is_that_of_its_image_and_what_is_not_judged_is_said():
    fisheye = LensDocument(lenses.load("canon-178-degree-fisheye-y-155-f28"))
    goal = goal_of(fisheye, 14.0)
    ray = lb.chief_ray(fisheye.lens, goal.field)
    film = fisheye.lens.length + back_focus(fisheye.lens)
    height = ray.points[-1, 1] + (film - ray.points[-1, 2]) * ray.direction[1] / ray.direction[2]
    assert abs(height) == pytest.approx(14.0, abs=1e-4) and goal.field > 0.9
    assert "The fields end at 85.9°" in left_out(fisheye.lens, goal_of(fisheye, 21.6))[0]
    assert left_out(TRIPLET.lens, goal_of(TRIPLET, 18.0)) == []


def test_a_field_beyond_the_image_is_no_smaller_and_a_section_without_power_is_let_go(capsys, tmp_path):
    fisheye = LensDocument(lenses.load("pbrt-fisheye-10mm"))
    fields = [goal_of(fisheye, height).field for height in (8.0, 12.0, 16.0, 20.0, 24.0)]
    assert fields == sorted(fields) and fields[-1] > 1.4
    flat = [(i, replace(s, curvature_x=0.0)) for i, s in enumerate(TRIPLET.surfaces) if s.curvature]
    cylinders = replace(TRIPLET, lens=with_surfaces(TRIPLET.lens, flat))
    goal = goal_of(cylinders, 10.0)
    assert goal.focal_length_x is None
    assert np.isfinite(Merit(cylinders.lens, goal)._penalties(cylinders.lens, goal)).all()
