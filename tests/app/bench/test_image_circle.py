"""How much of the film the lens lights, against the exit-pupil regions; and what follows it in the window."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.bench.readouts import dark_corners, lit
from lensbench.app.drawing.controls import chord
from lensbench.app.plots.exit_pupil import region
from lensbench.app.settings.settings import Settings
from tests.app.kinds import of_kind

CTRL = imgui.Key.mod_ctrl
FISHEYE = replace(Settings(), lens="pbrt-fisheye-10mm", f_number=None)


def test_light_reaches_the_film_up_to_the_edge_and_not_beyond():
    stand = bench_of(FISHEYE)
    edge = lit(FISHEYE)
    # Regions narrow to a sliver before the edge
    assert region(stand.lens, stand.film_distance, 0.98 * edge).area > 0.0
    assert region(stand.lens, stand.film_distance, 1.02 * edge).area == 0.0


def test_dark_corners_are_explained_by_both_diameters_and_only_where_there_are_some():
    assert dark_corners(FISHEYE) == f"Image circle ø {2.0 * lit(FISHEYE):.1f} mm, film diagonal 43.3 mm"
    assert dark_corners(replace(FISHEYE, crop=0.5)) == dark_corners(Settings()) == ""
    for name in ("thin", "pinhole", "perspective"):
        assert dark_corners(of_kind(FISHEYE, name)) == ""


def test_a_film_shifted_towards_or_beyond_the_edge_of_light_is_explained():
    small = replace(FISHEYE, film_width=8.0, film_height=6.0)
    circle = f"ø {2.0 * lit_radius(bench_of(small), 40.0):.1f} mm"
    assert dark_corners(small) == dark_corners(replace(small, rise=2.0)) == ""
    assert dark_corners(replace(small, rise=9.0)) == ""
    assert dark_corners(replace(small, rise=11.0)) == f"Image circle {circle}, and the film is shifted out to ø 29.1 mm"
    assert dark_corners(replace(small, shift=-20.0)).endswith(f"shifted beyond the image circle, {circle}")


@pytest.mark.parametrize("settings", [
    Settings(), replace(Settings(), crop=0.2), replace(Settings(), lens="no such lens"),
    replace(Settings(), camera="perspective")])
def test_a_lens_that_covers_its_film_lights_the_corner(settings):
    assert lit(settings) == 0.5 * settings.film.diagonal


@pytest.mark.slow
def test_the_film_point_stays_at_its_part_of_the_field(drive):
    def use(hand):
        hand.picture()
        hand.drag(hand.at("**/Field of view", 0.9, 0.5), hand.at("**/Field of view", 0.4, 0.5))
        assert hand.settings.crop < 0.5
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.session.panels._field == 0.7
        hand.drag(hand.at("**/Film radius", 0.69, 0.5), hand.at("**/Film radius", 0.4, 0.5))
        assert 0.3 < hand.session.panels._field < 0.5

    assert drive(use).view.messages == []


@pytest.mark.parametrize("f_number", [None, 64.0, 200.0])
def test_light_ends_where_the_last_of_many_rays_passes(f_number):
    """The read-out followed one ray to the middle of the stop, and missed up to a hundredth at pinholes."""
    built = bench_of(replace(Settings(), lens="pbrt-wide-22mm", f_number=f_number, film_width=60.0, film_height=45.0))
    radius, lens = lit_radius(built), built.lens
    at = np.linspace(-1.5, 1.5, 100_001) * lens.surfaces[-1].semi_diameter

    def lit(r: float) -> bool:
        ways = np.column_stack([at - r, 0.0 * at, np.full(at.size, -built.film_distance)])
        return bool((lb.trace(lens, [r, 0.0, lens.length + built.film_distance], ways).fate == lb.Fate.PASSED).any())

    assert lit(0.9995 * radius) and not lit(1.0005 * radius)
