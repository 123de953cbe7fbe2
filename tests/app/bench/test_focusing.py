"""Where the bench puts the film: paraxially as long as that is as good, else where contrast is best; what it says."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import POSITIONS, bench_of, design, focus_text, focusing
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.axis_contrast import axis_contrast
from tests.app.stand import drive
from tests.core.oracles import rms_on_film

WIDE = replace(Settings(), lens="pbrt-wide-22mm", f_number=None)


LENSES = ("pbrt-dgauss-50mm", "pbrt-wide-22mm", "canon-50-f12", "hasselblad-xcd-65-f28", "minolta-af-apo-80-200-f28",
          "lib-rudolph-protar-a", "fujifilm-fujinon-xf-r-wr-23-f2", "carl-zeiss-tessar-50-f35", "lenshh-petzval",
          "lenshh-cooke-triplet-50", "optiland-double-gauss", "canon-rf-l-usm-85-f12", "canon-fd-l-50-f12",
          "voigtlander-color-skopar-105-f35", "carl-zeiss-apo-germinar-375-f9", "canon-ef-28-105-f4", "tessar-52-f35",
          "angenieux-retrofocus-type-r11-28-f35", "lv-minolta-af-100mm-f28-macro", "brendel-tessar-100-f28")


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("f_number", [None, 5.6, 11.0])
def test_automatic_focus_has_the_best_contrast_of_the_mtf_of_the_picture(lens, f_number):
    """Within 0.02 of the best film of a fine scan by the diffraction MTF; stated contrasts are that MTF to 0.06."""
    bench = bench_of(replace(Settings(), lens=lens, f_number=f_number, focus_distance=3000.0))
    conditions = lb.analysis.conditions(bench.lens, wavelengths="picture", fields=[0.0, 1e-4],
                                        object_distance=3000.0 - bench.film_z)
    mtf = lb.analysis.mtf_map(bench.lens, bench.film_distance, conditions, 30.0, np.linspace(-0.4, 0.4, 401), 2, 48)
    contrast = mtf.white[0].mean(0)
    assert contrast[200] >= contrast.max() - 0.02
    own = dict(zip(POSITIONS, bench.focusing.contrasts, strict=True))[bench.focusing.method]
    assert own == pytest.approx(contrast[200], abs=0.06)


def test_the_double_gauss_at_f_2_gains_from_a_third_to_two_thirds_of_contrast():
    """Issue 41: at the least blur 0.35 on the axis, and over 0.6 some 0.07 mm nearer to the lens."""
    settings = replace(Settings(), lens="pbrt-dgauss-50mm", f_number=2.0)
    benches = {how: bench_of(replace(settings, focus_position=how)) for how in ("auto", "real")}
    best, least, _ = benches["auto"].focusing.contrasts
    assert best > 0.6 and least < 0.4
    assert benches["auto"].film_distance - benches["real"].film_distance == pytest.approx(-0.07, abs=0.02)
    assert camera(settings).film_distance == benches["auto"].film_distance


@pytest.mark.parametrize("how", ["auto", "real", "paraxial"])
def test_blur_in_focus_is_that_of_the_rays_on_the_film(how):
    bench = bench_of(replace(WIDE, focus_position=how))
    blur = 2.0 * math.sqrt(2.0) * rms_on_film(bench.lens, bench.film_distance, 1200.0)
    assert bench.focusing.blur == pytest.approx(blur, rel=0.02)        # the grain of 400 rays


def test_stopping_down_ends_at_the_paraxial_focus_without_a_loss_of_contrast():
    focusing = [bench_of(replace(WIDE, f_number=number)).focusing for number in (4.0, 5.6, 8.0, 11.0, 16.0, 22.0)]
    assert focusing[0].method == "contrast" and focusing[-1].method == "paraxial"
    for position in focusing:
        best, least, paraxial = position.contrasts
        assert best >= max(least, paraxial) - 1e-3 and (position.method == "contrast") == (best - paraxial > 0.01)


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
    assert got.focusing.method == "contrast"
    said = focus_text(got.focusing)
    assert said.startswith("Focused for the best contrast: lines") and "% by the least blur" in said
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
        ctx.item_click("**/###Drawer Tilt")
        ctx.item_click("//$FOCUSED/Paraxial")
        ctx.yield_(2)

    drive(show, test, (262, 440))
    assert seen["settings"].focus_position == "paraxial"


@pytest.mark.parametrize("times", [1.02, 1.05, 1.5, 20.0])
@pytest.mark.parametrize("how", ["auto", *POSITIONS])
def test_the_contrast_and_blur_that_are_stated_are_those_on_the_film(how, times):
    near = lb.nearest_focus(design(Settings()))
    settings = replace(Settings(), f_number=None, dispersion="off", focus_position=how, focus_distance=times * near)
    bench = bench_of(settings)
    stated = dict(zip(POSITIONS, bench.focusing.contrasts, strict=True))
    away = settings.focus_distance - bench.lens.length - bench.film_distance
    own = float(axis_contrast(bench.lens, np.array([bench.film_distance]), away)[0])
    assert stated[bench.focusing.method] == pytest.approx(own, abs=1e-6)
    assert how != "auto" or own >= max(stated.values()) - 0.011
    blur = lb.real_circle_of_confusion(bench.lens, bench.film_distance, [settings.focus_distance])[0][0]
    assert bench.focusing.blur == pytest.approx(float(blur), rel=1e-6)


def test_a_lens_that_shows_no_fine_lines_is_focused_by_its_least_blur():
    soft = next(name for name in lenses.names() if name.endswith("sfc-soft-focus-150-f4"))
    position = bench_of(replace(Settings(), lens=soft, f_number=None, focus_distance=math.inf)).focusing
    assert position.method == "real" and position.shift == 0.0 and max(position.contrasts) < 0.2
