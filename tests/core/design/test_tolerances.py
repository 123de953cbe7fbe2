"""Tolerances: copies against forty digits and against lenses built from the same numbers; what a run looks like."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mpmath import cos, matrix, mp, mpf, sin, sqrt

import lensbench as lb
from lensbench import Glass, Lens, Surface, lenses
from lensbench.core.design.merit import judge as judge_lens
from lensbench.core.design.standard_goal import goal_of
from lensbench.core.design.tolerance_rays import (
    FIELDS, POSE, Judge, bodies, copies_of, elements, set_poses, trace_copies
)
from lensbench.core.design.tolerances import Tolerances, manufactured, production, sensitivities
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.optics.surfaces import AFTER, BEFORE

mp.dps = 40
DOUBLET = Lens((Surface(4.0, 9.0, Glass(1.6), curvature=1 / 40.0), Surface(2.0, 9.0, Glass(1.7), curvature=-1 / 60.0),
                Surface(5.0, 9.0, curvature=-1 / 200.0), Surface(3.0, 6.0, curvature=0.0),
                Surface(2.0, 8.0, Glass(1.65), curvature=-1 / 50.0),
                Surface(0.0, 8.0, curvature=1 / 80.0)), 3)
TRIPLET = lb.stopped_down(lenses.load("lenshh-cooke-triplet-50"), 5.6)


def oracle(lens, poses, film_z, origin, direction):
    """x, y and slopes at z = film_z by forty digits: spheres placed in space, the vector form of Snell's law."""
    p, d = matrix([mpf(v) for v in origin]), matrix([mpf(v) for v in direction])
    d /= sqrt(sum(v * v for v in d))
    index = mpf(1)
    for (first, last), pose in zip(bodies(lens).tolist(), poses, strict=True):
        dx, dy, a, b = (mpf(v) for v in pose)
        turn = matrix([[cos(b), 0, sin(b)], [0, 1, 0], [-sin(b), 0, cos(b)]]) * matrix(
            [[1, 0, 0], [0, cos(a), -sin(a)], [0, sin(a), cos(a)]])
        pivot = matrix([0, 0, mpf(lens.vertices[first])])
        for i in range(first, last + 1):
            surface, n = lens.surfaces[i], mpf(lens.surfaces[i].glass.n_d)
            vertex = pivot + matrix([dx, dy, 0]) + turn * (matrix([0, 0, mpf(lens.vertices[i])]) - pivot)
            axis, c = turn * matrix([0, 0, 1]), mpf(surface.curvature)
            if c == 0:
                t, normal = ((vertex - p).T * axis)[0] / (d.T * axis)[0], axis
            else:
                off = p - (vertex + axis / c)
                half = (off.T * d)[0]
                root = sqrt(half**2 - (off.T * off)[0] + 1 / c**2)
                t = min((-half - root, -half + root), key=lambda t: abs(((p + t * d - vertex).T * axis)[0]))
                normal = -c * (off + t * d)
            p = p + t * d
            cosine = (d.T * normal)[0]
            ratio = index / n
            d = ratio * d + (sqrt(1 - ratio**2 * (1 - cosine**2)) - ratio * cosine) * normal
            index = n
    t = (mpf(film_z) - p[2]) / d[2]
    return [float(p[k] + t * d[k]) for k in range(2)] + [float(d[k] / d[2]) for k in range(2)]


@pytest.mark.slow
def test_tilted_and_decentred_elements_agree_with_forty_digits():
    assert elements(DOUBLET) == [(0, 2), (4, 5)] and bodies(DOUBLET).tolist() == [[0, 2], [3, 3], [4, 5]]
    random = np.random.default_rng(4)
    poses = np.zeros((4, 3, POSE))
    poses[1:, 0], poses[1:, 2] = random.normal(0.0, 0.05, (3, POSE)), random.normal(0.0, 0.05, (3, POSE))
    poses[2, 0] = 0.0
    origins = np.column_stack([random.normal(0.0, 2.0, (6, 2)), np.full(6, -7.0)])
    directions = np.column_stack([random.normal(0.0, 0.05, (6, 2)), np.ones(6)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    out = np.empty((4, 1, 6, 4))
    tables = copies_of(DOUBLET, (lb.D_LINE,), 4)
    posed = set_poses(tables, bodies(DOUBLET), poses)
    trace_copies(surface_table(DOUBLET).kinds, posed, tables, 90.0, origins, directions, out)
    wanted = [[oracle(DOUBLET, pose, 90.0, o, d) for o, d in zip(origins, directions, strict=True)] for pose in poses]
    assert np.abs(out[:, 0] - wanted).max() < 1e-12
    assert np.abs(out[1, 0] - out[0, 0]).max() > 1e-2            # the poses do something


@pytest.mark.slow
def test_copies_are_the_lenses_with_their_numbers():
    made = production(TRIPLET, lb.Film(24.0, 16.0), Tolerances(0.005, 0.1, 0.002, 0.0, 0.0), 3, seed=7)
    for copy in range(3):
        surfaces = list(TRIPLET.surfaces)
        for (kind, i), error in zip(made.names, made.drawn[copy].tolist(), strict=True):
            if kind == "radius":
                surfaces[i] = replace(surfaces[i], curvature=surfaces[i].curvature / (1.0 + error))
            elif kind == "thickness":
                surfaces[i] = replace(surfaces[i], thickness=surfaces[i].thickness + error)
        lens = replace(TRIPLET, surfaces=tuple(surfaces))
        index = {i: error for (kind, i), error in zip(made.names, made.drawn[copy].tolist(), strict=True)
                 if kind == "index"}
        # The spot on the axis by the reference tracer, with the indices changed in its table
        judge = Judge(TRIPLET, lb.Film(24.0, 16.0), None)
        here, weights, points, slopes = judge.fields == 0, [], [], []
        for wavelength, weight in zip(judge.wavelengths, judge.weights, strict=True):
            table = surface_table(lens, wavelength)
            for i, error in index.items():
                table.numbers[i, AFTER] += error
                table.numbers[i + 1, BEFORE] += error
            n = int(here.sum())
            hit, after = np.empty((n, 3)), np.empty((n, 3))
            trace_rays(table, False, judge.origins[here], judge.directions[here], hit, after, np.empty(n, np.int32),
                       np.empty(n, np.int32), None, 1)
            z = made.film[copy]
            slopes.append(after[:, :2] / after[:, 2:])
            points.append(hit[:, :2] + (z - hit[:, 2:]) * slopes[-1])
            weights.append(weight * judge.areas[here])
        p, s, w = (np.concatenate(parts) for parts in (points, slopes, weights))
        w = w / w.sum()
        p, s = p - (w[:, None] * p).sum(0), s - (w[:, None] * s).sum(0)
        spot, nearer, farther = (math.sqrt((w * ((p + t * s) ** 2).sum(1)).sum()) for t in (0.0, -1e-3, 1e-3))
        assert spot == pytest.approx(made.spots[copy, 0], rel=1e-9)
        assert spot < nearer and spot < farther         # the film lies where the axis is sharpest
        turned = np.abs((w[:, None, None] * np.exp(2j * np.pi * judge.frequencies[:, None] * p[:, None, :])).sum(0))
        assert judge.limits[:, None] * turned + judge.diffraction[0] == pytest.approx(made.contrast[copy, 0], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lenshh-cooke-triplet-50", "lib-tronnier-1953"])
def test_the_design_has_the_contrast_of_the_mtf_and_the_best_focus_that_is_defined(name):
    lens = lenses.load(name)
    judge, run = Judge(lens, None, None, "picture"), production(lens, copies=4, seed=1, wavelengths="picture")
    colours = judge.wavelengths, judge.weights
    away = lb.best_focus(lens, *colours)
    assert run.nominal_film - lens.length == pytest.approx(away, abs=1e-3)
    given = lb.analysis.conditions(lens, None, run.fields, "picture", math.inf)
    grid = lb.analysis.ray_grid(lens, away, given, 100)
    spots = lb.analysis.spots(grid)
    assert spots.best_shifts[0] == pytest.approx(0.0, abs=1e-3)
    assert run.nominal_spots[0] == pytest.approx(spots.white_rms_radius[0, 0], rel=0.01)
    waves = lb.analysis.mtf(grid, run.frequencies).white_modulus.transpose(0, 2, 1)
    assert run.nominal == pytest.approx(waves, abs=0.01)
    # A copy differs from its MTF by less than its rays alone do
    copy = manufactured(lens, run, 0)
    given = lb.analysis.conditions(copy, None, [(0.0, run.fields[0])], "picture", math.inf)
    grid = lb.analysis.ray_grid(copy, run.film[0] - copy.length, given, 64)
    waves = lb.analysis.mtf(grid, run.frequencies).white_modulus.transpose(0, 2, 1)[0]
    off, by_rays = (np.abs(run.contrast[0, 0] - part - waves).max() for part in (0.0, judge.diffraction[0]))
    assert off < min(0.8 * by_rays, 0.03)


@pytest.mark.slow
def test_improve_has_the_best_focus_that_is_defined():
    for name in ("pbrt-dgauss-50mm", "lenshh-cooke-triplet-50"):
        lens = lenses.load(name)
        goal = goal_of(lens)
        assert judge_lens(lens, goal).films[0] == pytest.approx(
            lb.best_focus(lens, goal.wavelengths, goal.weights), abs=1e-3)


@pytest.mark.slow
def test_a_run_lies_around_the_design_and_narrower_tolerances_keep_nearer_to_it():
    wide, narrow = (production(TRIPLET, tolerances=Tolerances(*(part * t for t in vars(Tolerances()).values())),
                               copies=200, seed=3) for part in (4.0, 1.0))
    assert np.array_equal(production(TRIPLET, copies=200, seed=3).contrast, narrow.contrast)
    assert np.abs(narrow.drawn / [vars(Tolerances())[kind] for kind, _ in narrow.names]).max() <= 1.0
    assert np.allclose(wide.drawn, 4.0 * narrow.drawn)
    for run in (wide, narrow):
        low, middle, high = run.band()
        assert (low <= middle).all() and (middle <= high).all()
        assert low.shape == (len(FIELDS), len(run.frequencies), 2)
    assert (wide.band()[2] - wide.band()[0]).mean() > 2.0 * (narrow.band()[2] - narrow.band()[0]).mean()
    nothing = production(TRIPLET, tolerances=Tolerances(1e-12, 0.0, 0.0, 0.0, 0.0), copies=2)
    assert nothing.contrast[1] == pytest.approx(nothing.nominal, abs=1e-6)
    # A lens without errors is symmetric: fields on both sides of the axis are alike
    assert narrow.nominal[1] == pytest.approx(narrow.nominal[2], abs=1e-9)


@pytest.mark.slow
def test_sensitivities_name_every_error_once_and_grow_with_it():
    found = sensitivities(TRIPLET)
    kinds = [each.kind for each in found]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "radius": 6, "thickness": 5 + (len(TRIPLET.surfaces) - 6), "index": 3, "decentre": 3, "tilt": 3}
    assert [each.spot for each in found] == sorted((each.spot for each in found), reverse=True)
    double = sensitivities(TRIPLET, tolerances=Tolerances(decentre=0.2))
    single = sensitivities(TRIPLET, tolerances=Tolerances(decentre=0.1))
    one = {e.surface: e.spot for e in single if e.kind == "decentre"}
    two = {e.surface: e.spot for e in double if e.kind == "decentre"}
    assert all(two[i] > 1.5 * one[i] > 0.0 for i in one)


def test_a_fisheyes_copies_are_judged_at_the_heights_where_its_light_lands():
    """Its beam fills too little of the front surface for a coarse search, and lands far from f tan θ."""
    fisheye = lenses.load("lib-miyamoto-fisheye-1964")
    run = production(fisheye, lb.Film(36.0, 24.0), copies=2)
    half = 0.5 * math.hypot(36.0, 24.0)
    away = fisheye.length + lb.film_distance(fisheye, math.inf)

    def height(angle):
        ray = lb.chief_ray(fisheye, angle)
        return abs(ray.points[-1, 1] + (away - ray.points[-1, 2]) * ray.direction[1] / ray.direction[2])

    # The next larger one of the heights that are tried, by sixteenths, has no light from in front of the lens
    assert height(math.radians(89.0)) < half * 9 / 16 and half / 2 < height(math.radians(85.0))
    # The middle of the beam lies off the chief ray by its coma and what the rims cut off
    assert run.fields[1:4:2] == pytest.approx([0.7 * half / 2, half / 2], rel=0.02)


def test_what_has_no_tolerances_is_refused():
    for bad in ({"radius": -0.1}, {"tilt": math.nan}, {"thickness": 1.0}):
        with pytest.raises(LensError, match="tolerance of"):
            Tolerances(**bad)
    with pytest.raises(LensError, match="copies"):
        production(TRIPLET, copies=0)
    with pytest.raises(LensError, match="symmetric"):
        sensitivities(lenses.load("lentil-schneider-anamorphic-31-2001"))


@pytest.mark.parametrize("side", [700.0, 7000.0])
def test_a_film_far_larger_than_the_image_is_judged_where_light_arrives(side):
    run = production(TRIPLET, lb.Film(side, side, 1, 1), copies=1)
    assert 15.0 < run.fields[3] < 40.0 and np.isfinite(run.nominal_spots).all()
