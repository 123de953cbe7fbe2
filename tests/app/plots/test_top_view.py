"""The section from above is that of a lens and a film turned by hand, and traces the same rays."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.focus_plane import in_section
from lensbench.app.plots.pixel_rays import pixel_fan
from lensbench.app.plots.section import UNMARKED, has_two_sections, quarter_turned, sketch
from lensbench.app.settings.settings import Settings
from tests.core.optics.test_surface_pose import posed, rays

TRIPLET = lenses.load("lenshh-cooke-triplet-50")
START = replace(Settings(), f_number=8.0, focus_distance=1500.0, lens_model="trace")


def of(folder, lens, name="lens"):
    lenses.save(lens, folder / f"{name}.toml")
    return replace(START, lens=str(folder / f"{name}.toml"))


@pytest.mark.parametrize("change", [{}, {"conic": -0.6}, {"aspheric": ((4, 1e-6),)}])
def test_a_turned_lens_traces_turned_rays(change):
    lens = posed(TRIPLET, 0, 1, decentre_x=0.7, decentre_y=-0.4, tilt_x=0.11, tilt_y=-0.07)
    lens = replace(lens, surfaces=(replace(lens.surfaces[0], **change), *lens.surfaces[1:]))
    _check_turned(posed(lens, 4, 5, decentre_x=-0.5, tilt_y=0.09))


def test_a_turned_lens_has_its_cylinders_blades_and_picture_turned():
    lens = posed(TRIPLET, 0, 0, decentre_x=0.7, tilt_x=-0.15, tilt_y=0.1, roll=0.3)
    _check_turned(replace(lens, surfaces=(replace(lens.surfaces[0], curvature_x=0.01), *lens.surfaces[1:]), blades=3,
                          blade_reach=1.0))
    blades = replace(posed(lens, lens.stop_index, lens.stop_index, tilt_x=0.2, tilt_y=0.3), blades=3,
                     blade_reach=1.0)
    _check_turned(blades)
    half = lb.StopImage.of(np.concatenate([np.zeros((8, 4)), np.ones((8, 4))], 1))         # open at +x
    _check_turned(replace(TRIPLET, stop_image=half))
    assert quarter_turned(TRIPLET) is TRIPLET


def _check_turned(lens):
    origins, ways = rays(400, 7.0)
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])                  # p @ turn: x to y, y to −x
    here, there = lb.trace(lens, origins, ways), lb.trace(quarter_turned(lens), origins @ turn, ways @ turn)
    passed = here.fate == lb.Fate.PASSED
    assert 20 < passed.sum() < 400 and (here.fate == there.fate).all()
    assert np.abs(here.points @ turn - there.points)[passed].max() < 1e-12
    assert np.abs(here.directions @ turn - there.directions)[passed].max() < 1e-13


def test_the_section_from_above_is_that_from_the_side_of_the_lens_turned_by_hand(tmp_path):
    one = of(tmp_path, posed(TRIPLET, 0, 1, decentre_x=0.6, tilt_y=-0.04), "one")
    two = of(tmp_path, posed(TRIPLET, 0, 1, decentre_y=0.6, tilt_x=0.04), "two")
    above, side = sketch(one, above=True), sketch(two)
    assert above.above and not side.above and above.unmarked == side.unmarked == UNMARKED and above.marks == ()
    for fan, wanted in zip(above.fans, side.fans, strict=True):
        assert fan.height == wanted.height and len(fan.rays) == len(wanted.rays)
        for ray, same in zip(fan.rays, wanted.rays, strict=True):
            assert ray.kind == same.kind and ray.path == pytest.approx(same.path, abs=1e-9)
    found, same = in_section(one, above=True), in_section(two)
    for name, (point, _) in found.planes.items():
        away, way = point - same.planes[name][0], same.planes[name][1]
        assert away[0] * way[1] - away[1] * way[0] == pytest.approx(0.0, abs=0.05)   # at 1.5 m; film points differ
    # The pixel at the left edge, as that at the lower edge; the film is 36 × 24 mm, and square here
    one, two = (replace(each, film_width=24.0, film_height=24.0, pixels_x=600, pixels_y=600) for each in (one, two))
    left, low = pixel_fan(one, (10.0, 300.0), above=True), pixel_fan(two, (300.0, 590.0))
    chief, wanted = (next(ray for ray in fan.rays if ray.kind == "chief") for fan in (left, low))
    assert chief.path[-1] == pytest.approx(wanted.path[-1]) and chief.path == pytest.approx(wanted.path, abs=0.02)


def test_a_film_that_swings_leans_from_above_as_one_that_tilts_does_from_the_side():
    swung, tilted = replace(START, lens="pbrt-dgauss-50mm", swing=0.1, shift=4.0), replace(
        START, lens="pbrt-dgauss-50mm", tilt=0.1, rise=4.0, film_width=24.0, film_height=36.0)
    above, side = in_section(swung, above=True), in_section(tilted)
    assert above.film == pytest.approx(side.film) and set(above.planes) == set(side.planes) == {"sharp", "near", "far"}
    for name in above.points:
        assert above.points[name] == pytest.approx(side.points[name])
    assert math.atan2(*(above.film[1] - above.film[0])) == pytest.approx(0.1)
    assert np.ptp(in_section(swung).film[:, 0]) == 0.0                     # from the side only the shift moves the film
    assert has_two_sections(swung, TRIPLET) and not has_two_sections(START, TRIPLET)
    assert sketch(START).marks and not sketch(START).unmarked
