"""Optical path differences against rayoptics' figures, and against the integral of where the rays land."""

from math import inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.grids.field_beams import OFFSET_S, OFFSET_T, OPD
from tests.core.analysis.grids.test_ray_grid import of_angles
from tests.core.oracles import REFERENCE, lens

# rayoptics 0.9.8, `analyses.eval_fan` of its model "Sasian Triplet" at 587.5618 nm: at parts of the paraxial entrance
# pupil about the chief ray, the landing point from that of the chief ray (mm) and the path difference (waves)
ENTRANCE = 11.679207956830547, 6.25                     # its z and radius, mm
PRINTED = {
    (0.0, 1): [(0.2, -0.0003162264057, 0.0030801213047), (0.6, -0.0077503803158, 0.2629005767215),
               (1.0, -0.0179609402338, 1.4713499462327)],
    (20.0, 0): [(0.2, -0.0086064650822, 0.1716394661808), (0.6, -0.0248615968468, 1.5391910189645),
                (1.0, -0.0150806194021, 3.5397159493938)],
    (20.0, 1): [(-1.0, -0.0295432347615, 2.4544671858868), (-0.6, 0.0264937865060, 1.9221503299051),
                (-0.2, 0.0147406571397, 0.2674001533115), (0.2, -0.0156538697636, 0.2799741043663),
                (0.6, -0.0338899858127, 2.2338866946797), (1.0, 0.0163099324541, 3.5767068327961)],
}


@pytest.mark.parametrize(("degrees", "fan"), PRINTED)
def test_path_differences_are_those_that_rayoptics_prints(degrees, fan):
    stack = lens("cooke")
    beams = of_angles(stack, REFERENCE["cooke"]["film_z"] - stack.length, degrees, pupil=8).beams
    part, landing, waves = np.array(PRINTED[degrees, fan]).T
    z, radius = ENTRANCE
    point, way = beams.chief.points[0], beams.chief.directions[0]
    points = np.tile(point + (z - point[2]) / way[2] * way, (len(part), 1))
    points[:, fan] += radius * part
    places = beams.across(points.T[:, None, :], np.tile(way, (len(part), 1)).T[:, None, :])[0]
    of_field = np.zeros(len(part), int)
    found, _ = beams.forward(lb.D_LINE, of_field, beams.starts(of_field, places))
    # rayoptics takes infinity as 1e10 mm, whose image lies f² / 1e10 mm = 2.5e-7 mm behind the focus
    np.testing.assert_allclose(found[OFFSET_S if fan == 0 else OFFSET_T], landing, rtol=0.0, atol=4e-8)
    # rayoptics goes to the sphere along equally inclined chords (Hopkins): the two paths differ by parts of the square
    # of the landing point over the sphere's diameter, 0.02 waves here
    np.testing.assert_allclose(found[OPD] / (1e-3 * lb.D_LINE), waves, rtol=0.0, atol=4e-4)


# Optiland 0.6.3, `OPDFan` of its sample CookeTriplet on the axis at 0.55 µm, 11 rays over the entrance pupil: radii and
# gaps (mm), indices, and the path differences in waves
CROWN, FLINT = 1.6226085614386923, 1.6236551229276037
TRIPLET = ((22.01359, 3.25896, CROWN), (-435.76044, 6.00755, 1.0), (-22.21328, 0.99997, FLINT),
           (20.29192, 4.75041, 1.0), (79.68360, 2.95208, CROWN), (-18.39533, 0.0, 1.0))
FILM, ENTRANCE_RADIUS, LINE = 42.20778, 5.0, 0.55
OPTILAND = {0.2: -0.0730971007, 0.4: -0.2630051276, 0.6: -0.4874846225, 0.8: -0.6315002254, 1.0: -0.5896609681}


def test_path_differences_on_the_axis_are_those_of_optiland():
    stack = lb.Lens(tuple(lb.Surface(gap, 9.0, lb.Glass(n), curvature=1.0 / r) for r, gap, n in TRIPLET), 3)
    given = lb.analysis.conditions(stack, None, [0.0], [LINE], field_kind=lb.FieldKind.ANGLE)
    beams = lb.analysis.ray_grid(stack, FILM, given, 8).beams
    places = np.column_stack([np.zeros(len(OPTILAND)), ENTRANCE_RADIUS * np.array(list(OPTILAND))])
    of_field = np.zeros(len(places), int)
    found, _ = beams.forward(LINE, of_field, beams.starts(of_field, places))
    np.testing.assert_allclose(found[OPD] / (1e-3 * LINE), list(OPTILAND.values()), rtol=0.0, atol=2e-9)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_path_difference_is_the_integral_of_where_the_rays_land(axis):
    stack = lenses.load("lib-tronnier-1953")
    rays = of_angles(stack, lb.film_distance(stack, inf), 10.0, pupil=192)
    n = rays.opd.shape[-1] // 2
    line = np.s_[0, 0, n, :] if axis == 0 else np.s_[0, 0, :, n]
    passed = np.flatnonzero(rays.passed[line])
    s, t, across, along, w = (each[line][passed] for each in (rays.pupil_s, rays.pupil_t, rays.offset_s, rays.offset_t,
                                                              rays.opd))
    steps = sum(0.5 * (each[1:] + each[:-1]) * np.diff(p) for each, p in ((across, s), (along, t)))
    np.testing.assert_allclose(np.cumsum(steps), w[1:] - w[0], rtol=0.0, atol=1e-3 * np.ptp(w))
