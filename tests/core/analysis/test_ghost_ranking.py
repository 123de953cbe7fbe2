"""Ghosts of a lens: the paraxial estimate against closed forms, and the traced table against the estimate."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.ghost_ranking import ghosts, paraxial_ghost
from lensbench.core.optics.ghost_path import ghost_order, ghost_path

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
    # The pupil of a fisheye faces the light, its front does not
    assert found.direct == pytest.approx(entering / math.cos(0.7), rel=0.05) and 0.0 < found.total < 0.1


def _fresnel(cosine, n):
    """Mean reflectance of both polarisations, from air into a medium."""
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / n**2)
    s, p = (cosine - n * inner) / (cosine + n * inner), (inner - n * cosine) / (inner + n * cosine)
    return 0.5 * (s**2 + p**2)


@pytest.mark.parametrize("light", [(0.0, 0.0, math.inf), (0.0, 0.5, math.inf), (0.4, -0.9, math.inf), (0.0, 0.0, -25.0),
                                   (9.0, -30.0, -25.0)])
def test_a_plate_passes_what_its_front_lets_in_but_for_two_reflections(light):
    """The part of a distant light lacked cos θ, that of a near one its solid angle: 0.88 of it at 0.5 rad."""
    plate = lb.Lens((lb.Surface(4.0, 10.0, lb.Glass(N), curvature=0.0), lb.Surface(50.0, 30.0, curvature=0.0)), 0)
    if math.isinf(light[2]):
        cosine = np.array(1.0 / math.hypot(math.tan(light[0]), math.tan(light[1]), 1.0))
        weight = np.array(1.0)
    else:
        radius, turn = np.sqrt((np.arange(200) + 0.5) / 200)[:, None] * 10.0, np.arange(200) / 200 * 2.0 * math.pi
        away = np.sqrt((radius * np.cos(turn) - light[0])**2 + (radius * np.sin(turn) - light[1])**2 + light[2]**2)
        cosine, weight = -light[2] / away, -light[2] / away**3
    expected = float((weight * (1.0 - _fresnel(cosine, N))**2).sum() / weight.sum())
    # Rays on a circle are counted to 0.2 %
    assert ghosts(plate, 30.0, light).direct == pytest.approx(expected, rel=5e-3)


def _brute_ghost(lens, away, pair, angle, side=400):
    """Share, centre (x, y) and size of a ghost: every surface written out for side² rays across the whole front."""
    n, mm = lens.indices(), lens.vertices
    towards = np.array([0.0, math.sin(angle), -math.cos(angle)])
    reach = 1.5 * lens.surfaces[0].semi_diameter
    a = ((np.arange(side) + 0.5) / side * 2.0 - 1.0) * reach

    def traced(pair):
        point = np.stack([*np.meshgrid(a, a), np.zeros((side, side))]).reshape(3, -1)
        point[1:] = point[1] * np.array([[math.cos(angle)], [math.sin(angle)]])
        ray, light = np.tile(-towards[:, None], point.shape[1]), np.full(point.shape[1], (a[1] - a[0])**2)
        with np.errstate(invalid="ignore"):
            for i, forward, mirror in ghost_order(len(lens.surfaces), pair):
                p, c, rim = point - [[0.0], [0.0], [mm[i]]], lens.surfaces[i].curvature, lens.surfaces[i].semi_diameter
                b = ray[2] - c * (p * ray).sum(0)
                e = c * (p * p).sum(0) - 2.0 * p[2]
                p = p + e / (b + np.copysign(np.sqrt(b * b - c * e), ray[2])) * ray
                normal = np.stack([c * p[0], c * p[1], c * p[2] - 1.0])
                normal *= np.where((normal * ray).sum(0) > 0.0, 1.0, -1.0)
                cosine, ratio = (normal * ray).sum(0), n[i] / n[i + 1] if forward else n[i + 1] / n[i]
                inner = np.sqrt(1.0 - ratio**2 * (1.0 - cosine**2))
                s = (ratio * cosine - inner) / (ratio * cosine + inner)
                q = (ratio * inner - cosine) / (ratio * inner + cosine)
                reflected = 0.5 * (s * s + q * q)
                if mirror:
                    light, ray = light * np.nan_to_num(reflected, nan=1.0), ray - 2.0 * cosine * normal
                else:
                    light, ray = light * (1.0 - reflected), ratio * (ray - cosine * normal) + inner * normal
                kept = (p[0]**2 + p[1]**2 <= rim**2) & ((ray[2] > 0.0) == (forward != mirror))
                light, point = np.where(kept, np.nan_to_num(light), 0.0), p + [[0.0], [0.0], [mm[i]]]
        lit = light > 0.0
        return light[lit], (point + (lens.length + away - point[2]) / ray[2] * ray)[:2, lit]

    direct, (light, place) = traced((-1, -1))[0].sum(), traced(pair)
    centre = (place * light).sum(1) / light.sum()
    spread = (((place - centre[:, None])**2).sum(0) * light).sum() / light.sum()
    return light.sum() / direct, centre, 2.0 * math.sqrt(2.0 * spread), light.size


@pytest.mark.parametrize(("name", "angle", "pairs"), [
    ("pbrt-dgauss-50mm", 0.2, ((0, 10), (1, 6), (1, 10), (2, 10), (3, 6))),
    ("lv-zeiss-planar-t-50f14", 0.2, ((0, 11),)), ("yashica-ml-24-f28", 0.2, ((0, 6), (5, 10), (5, 12))),
    ("leica-apo-vario-elmarit-sl-90-280-f28", 0.2, ((14, 23), (2, 18))),
    ("lentil-minolta-fisheye-1978", 0.2, ((5, 8),))])
def test_a_ghost_has_the_light_of_all_islands_of_the_front_and_is_symmetric(name, angle, pairs):
    """Islands between the rays of a scan were lost: 0-10 of the double Gauss had 65 % of its light, 1 mm aside."""
    lens = lb.stopped_down(replace(lenses.load(name), blades=0), 8.0)
    away = lb.film_distance(lens, math.inf)
    rows = {(row.first, row.second): row for row in ghosts(lens, away, (0.0, angle, math.inf)).rows}
    for pair in pairs:
        share, centre, size, rays = _brute_ghost(lens, away, pair, angle)
        row = rows[pair]
        # The brute-force grid counts the rays within an edge to some 1.5 / √rays of itself, where they are few
        assert row.share == pytest.approx(share, rel=max(0.01, 1.5 / math.sqrt(rays))), (pair, rays)
        assert abs(row.centre[0]) < 3e-3 * row.diameter, pair
        assert row.centre[1] == pytest.approx(centre[1], abs=0.02 * size), pair
        assert row.diameter == pytest.approx(size, rel=max(0.01, 1.5 / math.sqrt(rays))), pair
