"""The merit: residuals of forty digits, an independent dense trace, and what of a lens is judged and held."""

from dataclasses import replace
from math import atan, inf

import numpy as np
import pytest
from mpmath import mp, mpf

import lensbench as lb
from lensbench import Glass, Lens, Surface, SystemData, Wavelength, lenses
from lensbench.core.design.goal import Goal, MeritError, Position, held_lengths, image_distance
from lensbench.core.design.improve import derivatives
from lensbench.core.design.merit import DENSE, Merit
from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE
from lensbench.core.optics.prescription import with_surfaces

TRIPLET = lenses.load("lenshh-cooke-triplet-50")
# A stop in front: the rays in front of the lens do not depend on it
SINGLET = Lens((Surface(5.0, 4.0, curvature=0.0), Surface(3.0, 9.0, Glass(1.6, 55.0), curvature=1 / 40.0),
                Surface(40.0, 9.0, curvature=-1 / 60.0)), 0)
# Parallel light enters through the plane; an ellipse or hyperbola of the conic −n² behind it makes a perfect image
PERFECT = Lens((Surface(2.0, 6.0, curvature=0.0), Surface(5.0, 10.0, Glass(1.5), curvature=0.0),
                Surface(78.0, 10.0, conic=-2.25, curvature=-1 / 40.0)), 0)
SPHERES = replace(PERFECT, surfaces=(*PERFECT.surfaces[:2], replace(PERFECT.surfaces[2], conic=0.0)))
mp.dps = 40


def plain(angles, colours=(F_LINE, D_LINE, C_LINE), aim="spot", **named):
    """A goal that holds nothing: fields by angle (radians) along y, the axis first, of equal weight."""
    count = len(angles)
    position = Position(None, None, inf, tuple((0.0, angle) for angle in angles), (1.0 / count,) * count)
    return Goal((position,), colours, (1.0 / len(colours),) * len(colours), len(colours) // 2, aim, **named)


def exact(lens, curvatures, indices, origin, direction):
    """A ray through spheres in forty digits: its point on the plane of the last vertex, direction and path length."""
    p, d, n, z, path = [mpf(float(v)) for v in origin], [mpf(float(v)) for v in direction], mpf(1), mpf(0), mpf(0)
    path = sum(a * b for a, b in zip(p, d, strict=True))
    size = mp.sqrt(sum(v * v for v in d))
    d = [v / size for v in d]
    for c, surface, after in zip(curvatures, lens.surfaces, indices, strict=True):
        q = [p[0], p[1], p[2] - z]
        b = d[2] - c * sum(a * e for a, e in zip(q, d, strict=True))
        f = c * sum(a * a for a in q) - 2 * q[2]
        s = f / (b + mp.sqrt(b * b - c * f))
        path += n * s
        q = [a + s * e for a, e in zip(q, d, strict=True)]
        normal = [-c * q[0], -c * q[1], 1 - c * q[2]]
        cos = sum(a * e for a, e in zip(normal, d, strict=True))
        mu = n / mpf(after)
        g = mp.sqrt(1 - mu * mu * (1 - cos * cos)) - mu * cos
        d, n = [mu * e + g * m for e, m in zip(d, normal, strict=True)], mpf(after)
        p, z = [q[0], q[1], q[2] + z], z + mpf(surface.thickness)
    last = z - mpf(lens.surfaces[-1].thickness)
    away = (last - p[2]) / d[2]
    return [p[i] + away * d[i] for i in (0, 1)], d, path + n * away


def rays_of(merit, lens):
    at, areas, _ = merit._aimed(lens, 0, merit.used[0])
    origins, directions = merit._rays(0, at)
    return origins, directions, areas * merit.used[0]


def oracle(lens, curvatures, merit):
    """The spot residuals of a lens in forty digits, by the words of the merit's docstring."""
    origins, directions, areas = rays_of(merit, lens)
    columns = []
    for field in range(len(areas)):
        used = np.flatnonzero(areas[field])
        traced = [[exact(lens, curvatures, lens.indices(colour)[1:], origins[field, k], directions[field, k])
                   for k in used] for colour in merit.goal.wavelengths]
        total = sum(mpf(a) for a in areas[field][used])
        weights = [mpf(a) / total / 3 for a in areas[field][used]]
        pairs = [(w, point, [way[0] / way[2], way[1] / way[2]]) for rays in traced
                 for w, (point, way, _) in zip(weights, rays, strict=True)]
        centre = [[sum(w * pair[which][axis] for w, *pair in pairs) for axis in (0, 1)] for which in (0, 1)]
        columns.append([[mp.sqrt(w / len(areas)) * (pair[which][axis] - centre[which][axis]) for which in (0, 1)]
                        for w, *pair in pairs for axis in (0, 1)])
    film = -sum(a * b for a, b in columns[0]) / sum(b * b for _, b in columns[0])       # the spot on the axis
    return np.array([a + film * b for column in columns for a, b in column])


@pytest.mark.slow
def test_residuals_and_their_slopes_are_those_of_forty_digits():
    merit = Merit(SINGLET, plain((0.0, 0.1, 0.15)), (2, 5))
    curvatures = [mpf(s.curvature) for s in SINGLET.surfaces]
    residuals = merit.residuals(SINGLET)
    # By colour, then field, then ray, as the oracle has it by field, then colour
    by_field = residuals.reshape(3, 3, -1).transpose(1, 0, 2).ravel()
    assert np.allclose(by_field, oracle(SINGLET, curvatures, merit).astype(float), rtol=0.0, atol=1e-12)

    def of(values):
        return merit.residuals(with_surfaces(SINGLET, [
            (i, replace(SINGLET.surfaces[i], curvature=0.01 * c)) for i, c in zip((1, 2), values, strict=True)]))

    slopes = derivatives(of, 100.0 * np.array([s.curvature for s in SINGLET.surfaces[1:]]))
    for k in (1, 2):
        step = mpf(10) ** -12
        ahead, behind = (oracle(SINGLET, [c + sign * step * (i == k) for i, c in enumerate(curvatures)], merit)
                         for sign in (1, -1))
        expected = ((ahead - behind) / (2 * step)).astype(float) * 0.01
        found = slopes[:, k - 1].reshape(3, 3, -1).transpose(1, 0, 2).ravel()
        assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()       # of a forward difference


def test_a_perfect_image_has_no_wave_error_and_others_that_of_forty_digits():
    goal = plain((0.0,), (D_LINE,), "wavefront")
    assert lb.judge(PERFECT, goal).rms < 1e-12 and lb.judge(SPHERES, goal).rms > 1e-5
    merit = Merit(SPHERES, goal, (3, 4))
    errors, film, _ = merit.errors(SPHERES, 0)
    origins, directions, areas = rays_of(merit, SPHERES)
    curvatures = [mpf(s.curvature) for s in SPHERES.surfaces]
    lengths, ways = [], []
    for origin, direction in zip(origins[0], directions[0], strict=True):
        point, way, path = exact(SPHERES, curvatures, (1.0, 1.5, 1.0), origin, direction)
        lengths.append(path + mpf(film) * way[2] - point[0] * way[0] - point[1] * way[1])
        ways.append([float(way[0]), float(way[1])])
    lengths = np.array([float(length - lengths[0]) for length in lengths])
    share = np.sqrt(areas[0] / areas[0].sum())
    free = share[:, None] * np.column_stack([np.ones(len(lengths)), ways])
    left = share * lengths - free @ np.linalg.lstsq(free, share * lengths, rcond=None)[0]
    assert errors / merit.scale == pytest.approx(left, abs=1e-12)


def dense_rms(lens, goal, rays=301):
    """RMS spot (mm) of a lens by a square grid of parallel rays in front of it, focused where its axis is sharpest."""
    position = goal.positions[0]
    reach = 3.0 * max(s.semi_diameter for s in lens.surfaces)
    film, squares = None, 0.0
    for (_, angle), share in zip(position.fields, position.weights, strict=True):
        direction = np.array([0.0, np.sin(angle), np.cos(angle)])
        z = lb.first_order(lens).entrance_pupil.z
        x, y = (v.ravel() for v in np.meshgrid(np.linspace(0.0, reach, rays), np.linspace(-reach, reach, 2 * rays)))
        for _ in range(2):                      # the beam of a field, then a grid over it alone
            origins = np.column_stack([x, y, np.full(x.size, z)]) - 4.0 * lens.length * direction / direction[2]
            passed = lb.trace(lens, origins, direction).fate == lb.Fate.PASSED
            (a, b), (c, d) = ((v[passed].min(), v[passed].max()) for v in (x, y))
            edge = (b - a + d - c) / rays
            x, y = (v.ravel() for v in np.meshgrid(np.linspace(0.0, b + edge, rays),
                                                   np.linspace(c - edge, d + edge, 2 * rays)))
        points, slopes, weights = [], [], []
        for colour, weight in zip(goal.wavelengths, goal.weights, strict=True):
            traced = lb.trace(lens, origins[passed], direction, colour, clip=False)
            slope = traced.directions[:, :2] / traced.directions[:, 2:]
            points.append(traced.points[:, :2] + (lens.length - traced.points[:, 2:]) * slope)
            slopes.append(slope)
            weights.append(np.full(passed.sum(), weight / passed.sum()))
        points, slopes, weights = np.concatenate(points), np.concatenate(slopes), np.concatenate(weights)[:, None]
        points, slopes = (v - (weights * v).sum(0) * [0.0, 1.0] for v in (points, slopes))     # x is mirrored
        if film is None:
            film = -(weights * points * slopes).sum() / (weights * slopes**2).sum()
        squares += share * float((weights * (points + film * slopes) ** 2).sum())
    return np.sqrt(squares), film


@pytest.mark.slow
@pytest.mark.parametrize(("name", "height"), [("lenshh-cooke-triplet-50", 14.4), ("lenshh-cooke-triplet-50", 21.6),
                                              ("pbrt-dgauss-50mm", 20.0), ("phone-72-f4", 4.0)])
def test_a_lens_is_judged_as_an_independent_dense_trace_judges_it(name, height):
    lens = lenses.load(name)
    goal = lb.goal_of(lens, height)
    found = lb.judge(lens, goal)
    rms, film = dense_rms(lens, goal)
    assert found.rms == pytest.approx(rms, rel=0.02)                # 480 rays over a vignetted pupil
    assert found.films[0] == pytest.approx(film, abs=2e-3)


def test_the_wavelengths_fields_and_weights_of_the_file_are_judged():
    plain_goal = lb.goal_of(TRIPLET)
    assert plain_goal.wavelengths == (F_LINE, D_LINE, C_LINE) and "the lens states none" in plain_goal.judged[1]
    system = SystemData(field_kind=lb.FieldKind.ANGLE, fields=(lb.FieldPoint(0.0, 0.0, 3.0), lb.FieldPoint(0.0, 10.0)),
                        wavelengths=(Wavelength(0.85, 1.0), Wavelength(0.94, 3.0)), primary=1)
    goal = lb.goal_of(replace(TRIPLET, system=system))
    assert goal.wavelengths == (0.85, 0.94) and goal.weights == (0.25, 0.75) and goal.primary == 1
    assert goal.positions[0].weights == (0.75, 0.25)
    assert goal.positions[0].fields[1] == pytest.approx((0.0, np.radians(10.0)), abs=1e-12)
    assert "fields as the lens states them: 2 by angle" in goal.judged
    assert any("850, 940 nm" in said for said in goal.judged)
    assert lb.judge(TRIPLET, goal).rms == pytest.approx(dense_rms(TRIPLET, goal)[0], rel=0.02)
    near = replace(TRIPLET, system=SystemData(object_distances=(500.0,)))
    assert lb.goal_of(near).positions[0].object_distance == 500.0


def test_an_object_at_a_distance_is_judged_there():
    near = replace(PERFECT, surfaces=(PERFECT.surfaces[0], replace(PERFECT.surfaces[1], curvature=1 / 300.0),
                                      PERFECT.surfaces[2]), system=SystemData(object_distances=(1e5,)))
    far = replace(near, system=SystemData())
    for aim in ("spot", "wavefront"):           # at 1e5 mm the light is all but parallel
        close, parallel = (lb.judge(lens, lb.goal_of(lens, 2.0, aim)).rms for lens in (near, far))
        assert close == pytest.approx(parallel, rel=0.03)
    films = [lb.judge(lens, lb.goal_of(lens, 2.0)).films[0] for lens in (near, far)]
    paraxial = [image_distance(lens, distance, D_LINE) for lens, distance in ((near, 1e5), (far, inf))]
    assert films[0] - films[1] == pytest.approx(paraxial[0] - paraxial[1], rel=0.05) and films[0] > films[1]


def test_all_zoom_and_focus_positions_are_judged_and_their_lengths_held():
    zoom = lenses.load("canon-ef-28-105-f4")
    goal = lb.goal_of(zoom, 15.0)
    assert [(p.zoom, p.close) for p in goal.positions] == [(z, c) for z in zoom.positions.zoom_stations
                                                            for c in (0.0, 1.0)]
    for position in goal.positions:
        data = lb.first_order(position.of(zoom))
        assert position.held == pytest.approx((data.f_number, data.efl))
    assert goal.positions[0].held[1] == pytest.approx(28.9, abs=0.1)
    assert goal.positions[4].held[1] == pytest.approx(101.3, abs=0.1)
    assert goal.judged[0] == "positions: 6, of zoom and focus"
    distance = goal.positions[1].object_distance
    moved = goal.positions[1].of(zoom)
    assert distance + moved.length + lb.film_distance(zoom.at(zoom=0.0), lb.nearest_focus(zoom.at(zoom=0.0))) \
        == pytest.approx(lb.nearest_focus(zoom.at(zoom=0.0)))


def test_a_lens_in_water_and_both_focal_lengths_of_a_toroid_are_held():
    wet = replace(TRIPLET, front_index=1.333)
    goal = lb.goal_of(wet, 5.0, hold_back_focus=True)
    data = lb.first_order(wet)
    assert goal.positions[0].held == pytest.approx((data.f_number, data.efl, data.bfl), rel=1e-12)
    assert goal.positions[0].fields[-1][1] == pytest.approx(-atan(5.0 / (1.333 * data.efl)) * -1.0, rel=0.01)
    anamorphic = lenses.load("lentil-schneider-anamorphic-31-2001")
    held = held_lengths(anamorphic, inf, D_LINE, False)
    across, along = (lb.first_order(section).efl for section in anamorphic.sections)
    assert held[1:] == pytest.approx((along, across), rel=1e-12) and across < 0.6 * along
    flat = with_surfaces(TRIPLET, [(i, replace(s, curvature_x=0.0)) for i, s in enumerate(TRIPLET.surfaces)])
    assert len(held_lengths(flat, inf, D_LINE, False)) == 2         # a section without power


def test_fields_without_light_are_named_and_left_out():
    dark = lb.goal_of(lenses.load("lentil-schneider-anamorphic-31-2001"), 21.6)
    assert len(dark.positions[0].fields) < 6 and dark.left_out[-1].startswith("No light arrives from the field")
    assert sum(dark.positions[0].weights) == pytest.approx(1.0)
    assert lb.goal_of(TRIPLET, 18.0).left_out == ()
    fisheye = lenses.load("canon-178-degree-fisheye-y-155-f28")
    widest = lb.goal_of(fisheye, 21.6)
    assert "Light ends at the field 20.9 mm: judged there, not at 21.6 mm" in widest.left_out
    ray = lb.chief_ray(fisheye, lb.goal_of(fisheye, 14.0).positions[0].fields[-1][1])
    height = ray.points[-1, 1] + (fisheye.length + lb.first_order(fisheye).bfl - ray.points[-1, 2]) \
        * ray.direction[1] / ray.direction[2]
    assert abs(height) == pytest.approx(14.0, abs=1e-4)


def test_a_lens_that_cannot_be_judged_says_why():
    diverging = with_surfaces(TRIPLET, [(0, replace(TRIPLET.surfaces[0], curvature=-0.05))])
    with pytest.raises(MeritError, match="no image"):
        lb.goal_of(diverging, 18.0)
    with pytest.raises(MeritError, match="choose one of spot, wavefront"):
        lb.goal_of(TRIPLET, 18.0, "glare")
    with pytest.raises(MeritError, match="image height"):
        lb.goal_of(TRIPLET, -1.0)
    closed = with_surfaces(TRIPLET, [(i, replace(s, semi_diameter=1e-3)) for i, s in enumerate(TRIPLET.surfaces)
                                     if i != TRIPLET.stop_index])
    with pytest.raises(MeritError, match="hardly a ray"):
        lb.goal_of(closed, 18.0)
    strong = with_surfaces(TRIPLET, [(5, replace(TRIPLET.surfaces[5], curvature=-0.2, semi_diameter=4.9))])
    assert lb.judge(strong, lb.goal_of(TRIPLET, 18.0)).rms == inf


def test_equal_colours_count_as_one():
    one, three = (lb.judge(TRIPLET, plain((0.0, 0.2), (D_LINE,) * count, "wavefront")) for count in (1, 3))
    assert three.rms == pytest.approx(one.rms, rel=1e-9)
    assert DENSE[0] * DENSE[1] == Merit(TRIPLET, plain((0.0,)), DENSE).used[0].size
