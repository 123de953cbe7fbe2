"""Where the bench puts the film: paraxially as long as that is as good, else at the least blur; and what it says."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.build import bench_of, design, focus_text, focusing
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.settings.settings import Settings
from tests.app.stand import drive
from tests.core.oracles import rms_on_film

WIDE = replace(Settings(), lens="pbrt-wide-22mm", f_number=None)


@pytest.mark.parametrize("lens", ["pbrt-wide-22mm", "optiland-tessar-f45", "pbrt-dgauss-50mm",
                                  "lv-minolta-af-100mm-f28-macro"])
@pytest.mark.parametrize("f_number", [None, 8.0, 22.0])
def test_the_film_moves_where_a_point_in_focus_is_half_a_pixel_sharper_for_it(lens, f_number):
    settings = replace(Settings(), lens=lens, f_number=f_number)
    ways = {how: bench_of(replace(settings, focus_position=how)) for how in ("auto", "paraxial", "real")}
    blur = {how: 2.0 * math.sqrt(2.0) * rms_on_film(way.lens, way.film_distance, 1200.0)
            for how, way in ways.items()}
    gain = blur["paraxial"] - blur["real"]
    chosen = "real" if gain > 0.5 * settings.film.pitch else "paraxial"
    assert ways["auto"].film_distance == ways[chosen].film_distance and ways["auto"].focusing.method == chosen
    # the grain of 400 rays
    assert ways["auto"].focusing.paraxial_blur == pytest.approx(blur["paraxial"], rel=0.02, abs=1e-4)
    assert ways["auto"].focusing.least_blur == pytest.approx(blur["real"], rel=0.02, abs=1e-4)
    assert camera(settings).film_distance == ways[chosen].film_distance


def test_at_a_switch_the_film_moves_by_less_than_anyone_can_see():
    """Opening the stop, the blur in focus grows without a step of more than half a pixel."""
    blur = [bench_of(replace(WIDE, f_number=n)).focusing for n in (16.0, 8.0, 5.6, 4.8, 4.0, 3.6, 3.2, 2.9, 2.7)]
    assert {found.method for found in blur} == {"paraxial", "real"}
    at = next(i for i, found in enumerate(blur) if found.method == "real")
    assert all(found.method == "real" for found in blur[at:])
    assert blur[at - 1].paraxial_blur - blur[at - 1].least_blur <= 0.5 * WIDE.film.pitch


def test_ideal_models_and_what_is_too_near_for_the_whole_bundle_are_focused_paraxially():
    lens = design(WIDE)                         # wide open
    for model in ("thick", "thin", "pinhole"):
        ideal = replace(WIDE, lens_model=model, focus_position="real")
        assert focusing(lens, ideal, WIDE.focus_distance).method == "paraxial"
    near = replace(WIDE, focus_position="real", focus_distance=50.0)
    assert focusing(lens, near, 50.0).method == "paraxial" and "nearest" in bench_of(near).reason
    assert "ideal" in focus_text(focusing(lens, replace(WIDE, lens_model="thin"), WIDE.focus_distance))


def test_the_read_out_says_what_is_done_and_what_the_other_way_would_give():
    got = readings(WIDE)
    assert got.focusing.method == "real" and got.focusing.blur == got.focusing.least_blur
    said = focus_text(got.focusing)
    assert said.startswith("Focused by the least blur") and "µm paraxially" in said
    assert focus_text(readings(replace(WIDE, focus_position="paraxial")).focusing).startswith("Focused paraxially")


def test_the_choice_is_made_by_hand_below_the_dials():
    """In a popup of the left column, which a lens with colour errors leaves just as much room for."""
    seen = {"settings": replace(WIDE, lens="lenshh-cooke-triplet-50")}
    chooser = Chooser()

    def show():
        seen["settings"] = controls_panel(seen["settings"], chooser)
        seen["ends"] = imgui.get_item_rect_max().x

    def test(ctx):
        ctx.yield_(3)
        assert seen["ends"] < 262.0
        ctx.item_click("**/Focus")
        ctx.item_click("//$FOCUSED/Paraxial")
        ctx.yield_(2)

    drive(show, test, (262, 440))
    assert seen["settings"].focus_position == "paraxial"
