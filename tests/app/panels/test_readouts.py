"""The read-outs say what the readings are."""

import math
from dataclasses import replace

import pytest

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.panels.readouts import NONE, Status, columns, own, readouts_panel, rows
from lensbench.app.plots.blur import focus_words
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.compilers import prepare
from tests.app.kinds import KINDS, of_kind
from tests.app.stand import drive

START = Settings(lens="pbrt-dgauss-50mm")


def table(settings: Settings, status: Status = Status()) -> dict[str, str]:  # noqa: B008 - a frozen value
    return {row.name: f"{row.value} {row.unit}".strip() for row in rows(settings, readings(settings), status)}


def test_words_state_what_is_sharp_and_the_blur_of_the_background():
    """The limits of the table; the blur of infinity by A m, of the thin lens f² / (N s)."""
    assert focus_words(START).startswith("Sharp from 1.16 to 1.24 m; background blur 2 % of the frame")
    open_ = replace(START, f_number=2.0)
    blur = float(focus_words(open_).split("blur ")[1].split(" %")[0])
    assert blur == pytest.approx(100.0 * 50.4**2 / (2.0 * (1200.0 - 50.4)) / 36.0, abs=0.5)
    assert "m to infinity; background sharp" in focus_words(replace(START, focus_distance=6000.0, f_number=22.0))
    assert focus_words(replace(START, camera="fisheye")) == "" == focus_words(replace(START, lens_model="pinhole"))


def test_the_table_of_the_double_gauss():
    # Figures of the published prescription: EFL 50.358, BFL 36.106, f/2.03 mm wide open; the rest by hand from them
    said = table(START, Status(164e6, 60.0, 128))
    assert said["Focal length"] == "50.4 mm" and said["Back focal length"] == "36.1 mm"
    assert said["f-number"] == "f/2.80" and said["Entrance pupil"] == "ø 18.0 mm"
    assert said["Field of view"] == "39.8° × 26.9°"       # with its distortion: 39.3° × 26.8° by 2 atan(h / 2f)
    assert said["Rays"] == "164 M/s" and said["Frames"] == "60 fps" and said["Samples"] == "128"
    assert said["Magnification"].startswith("1 : 21.")


@pytest.mark.parametrize("f_number", [0.95, 1.2, 2.8, 11.0])
def test_the_t_stop_reads_no_faster_than_the_f_number_of_the_same_lens(f_number):
    got = replace(readings(START), f_number=f_number, t_number=1.004 * f_number)
    said = {row.name.split(",")[0]: row.value for row in rows(START, got, Status())}
    assert said["f-number"].startswith("f/") and said["T-stop"].startswith("T ")
    assert float(said["T-stop"][2:]) >= float(said["f-number"][2:])


def test_infinity_reads_as_such():
    said = table(replace(START, focus_distance=math.inf))
    assert said["Magnification"] == "1 : ∞" and said["Depth of field"].endswith("∞ m")


def test_limits_close_together_get_the_digits_that_tell_them_apart():
    said = table(replace(START, focus_distance=200.0, f_number=None))
    near, far = said["Depth of field"].removesuffix(" m").split(" – ")
    assert near != far


@pytest.mark.parametrize("model", ["pinhole", "perspective"])
def test_what_has_no_meaning_is_a_dash(model):
    said = table(of_kind(START, model))
    assert said["T-stop"] == NONE
    assert said["Focal length"] != f"{NONE} mm"


@pytest.mark.parametrize("model", KINDS)
def test_a_camera_shows_the_rows_that_it_has(model):
    settings = of_kind(START, model)
    every = rows(settings, readings(settings), Status(164e6, 60.0, 128))
    shown = own(settings, every)
    if not (settings.has_lens and settings.has_stop):
        assert [row.name for row in shown] == [row.name for row in every if row.value != NONE]
        assert not shown[0].gap and len(shown) < len(every)
    else:
        assert shown == every


def test_every_row_is_explained_and_abbreviations_are_spelled_out():
    meanings = {row.name: row.meaning for row in rows(START, readings(START), Status())}
    assert all(meanings.values())
    assert "Effective focal length (EFL)" in meanings["Focal length"]
    assert "Back focal length (BFL)" in meanings["Back focal length"]
    assert "circle of confusion (CoC)" in meanings["Depth of field"]


def test_limits_count_from_what_their_meaning_names():
    """The depth of field of the perspective camera is that of an ideal lens before a fixed film, from the lens."""
    settings = replace(of_kind(START, "perspective"), f_number=2.8, focus_distance=1200.0)
    for of, start in ((settings, "the lens"), (START, "the film")):
        meanings = {row.name: row.meaning for row in rows(of, readings(of), Status())}
        assert f"from {start}" in meanings["Depth of field"] and f"from {start}" in meanings["Nearest focus"]
    got = readings(settings)
    # Sharp at the near limit: the cone is as wide on the film as the limit, by 1/f' = 1/s + 1/film = 1/near + 1/image
    film, of_near = got.efl, 1.0 / (1.0 / 1200.0 + 1.0 / got.efl - 1.0 / got.near_limit)
    assert got.efl / 2.8 * abs(of_near - film) / of_near == pytest.approx(got.limit, rel=1e-6)


@pytest.mark.parametrize("size", [(10, 10), (60, 300), (270, 440)])
def test_the_panel_lives_in_any_window_and_any_state(size):
    shown = [START]

    def test(ctx):
        for change in ({}, {"lens": "no-such-lens"}, {"focus_distance": 3.0}, {"camera": "perspective"},
                       {"film_width": math.nan}):
            shown[0] = replace(START, **change)
            ctx.yield_(2)

    drive(lambda: readouts_panel(shown[0], Status()), test, size)


@pytest.mark.parametrize(("width", "apart"), [(240.0, 64.0), (240.0, 20.0), (420.0, 64.0)])
def test_a_long_difference_of_a_and_b_does_not_reach_the_value_of_b(width, apart):
    column, (_, end) = columns(width, 95.0, apart)
    assert width - apart >= end - 1e-9 and column > 0.0
    assert apart > (width - 95.0) / 3.0 or column == pytest.approx((width - 95.0) / 3.0)


@pytest.mark.parametrize("change", [{}, {"camera": "perspective"}, {"lens_model": "pinhole"}, {"lens": "no-such-lens"}])
def test_the_panels_can_be_prepared_for_any_state(change):
    prepare(replace(START, **change))


def test_a_depth_of_field_that_aberrations_exceed_is_not_amber_and_says_so():
    soft = replace(START, lens="lv-czj-tessar-50-f28", f_number=2.8, focus_position="paraxial")
    sharp = replace(soft, f_number=11.0)
    for settings, expected in ((soft, True), (sharp, False)):
        got = readings(settings)
        row = next(row for row in rows(settings, got, Status()) if row.name == "Depth of field")
        assert got.soft == expected == (got.focusing.blur > got.limit)
        assert row.amber != expected and ("aberrations" in row.meaning) == expected
