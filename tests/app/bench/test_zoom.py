"""The zoom: its dial, the field of view that turns it, the options of the commands, and the figures of the stations."""

import json
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings as limits, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench import constraints
from lensbench.app.bench.build import bench_of, design
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.zoom import asked_zoom, engraved_zoom, focal_length, is_engraved, zoom_of
from lensbench.app.command.main import main
from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.panels.lens_browser import figures
from lensbench.app.session.edited_lens import edited
from lensbench.app.settings import dial_scales
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import read_close, read_zoom
from lensbench.lenses.editing.cells import with_radius, with_value
from tests.app.stand import drive

NIKKOR = "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"
PENTAX = "lv-pentax-02-standard-zoom-5-15-f28-45"
ZOOM = Settings(lens=NIKKOR, focus_distance=3000.0, f_number=None)
POCKET = replace(ZOOM, lens=PENTAX, film_width=6.2, film_height=4.6)


@limits(max_examples=25)
@given(st.sampled_from([NIKKOR, PENTAX]), st.floats(0.0, 1.0))
def test_a_zoom_setting_is_found_again_by_its_focal_length(name, place):
    lens = lenses.load(name)
    # to 1e-11 of the dial, whose focal lengths differ by a factor of 3
    assert zoom_of(lens, focal_length(lens, place)) == pytest.approx(place, abs=1e-10)
    assert zoom_of(lens, 1.0) == 0.0 and zoom_of(lens, 1000.0) == 1.0


@pytest.mark.parametrize("name", [NIKKOR, "canon-ef-28-105-f4", "canon-ef-ii-28-80-f35"])
def test_a_station_between_the_ends_is_set_by_its_focal_length_and_its_gaps_are_edited_there(name):
    """The zoom came as near as the focal length that was typed, and the gap was refused as one between two stations."""
    lens = lenses.load(name)
    gap, place = lens.positions.gaps[0], lens.positions.zoom_stations[1]
    length = lens.positions.focal_lengths[1]
    assert asked_zoom(lens, ("focal length", length)) == engraved_zoom(lens, round(length, 1)) == place
    there = replace(ZOOM, lens=name, zoom=place)
    wider = edited(there, lambda document: with_value(document, gap, "thickness", 9.0))[0]
    assert design(wider).surfaces[gap].thickness == 9.0
    beside = focal_length(lens, place) * 1.002
    assert focal_length(lens, engraved_zoom(lens, beside)) == pytest.approx(beside, rel=1e-12)


@limits(max_examples=25)
@given(st.floats(0.03, 3.0))
def test_the_field_of_view_turns_the_zoom_and_crops_only_beyond_its_longest_end(fov):
    turned = constraints.with_field_of_view(replace(ZOOM, crop=0.5), fov)
    narrow, wide = (2.0 * math.atan(12.0 / focal_length(lenses.load(NIKKOR), end)) for end in (1.0, 0.0))
    assert (turned.crop < 1.0) == (fov < narrow)
    assert 0.0 < turned.zoom < 1.0 or not narrow < fov < wide
    assert constraints.field_of_view(turned) == pytest.approx(min(fov, wide), rel=1e-9)
    assert constraints.ends_of_view(ZOOM)[1] == pytest.approx(wide, rel=1e-12)
    kept = constraints.with_field_of_view(ZOOM, fov, keep_zoom=True)
    assert kept.zoom == 0.0 and constraints.field_of_view(kept) == pytest.approx(min(fov, wide), rel=1e-9)


def test_what_the_lens_cannot_do_at_the_long_end_gives_way_and_comes_back_wide_open():
    wide = replace(POCKET, f_number=2.8)
    assert camera(wide).first_order.f_number == pytest.approx(2.8, rel=1e-3)
    tele = constraints.constrained(replace(wide, zoom=1.0))
    assert tele.f_number is None and readings(tele).widest_f_number == pytest.approx(4.345, abs=0.001)
    assert constraints.constrained(replace(Settings(), zoom=0.3)).zoom == 0.0        # a lens that does not zoom


def test_focusing_moves_the_groups_in_picture_section_and_read_outs_alike():
    near = replace(ZOOM, zoom=1.0, focus_distance=1600.0)
    stand, taken = bench_of(near), camera(near)
    assert stand.lens == taken.lens and stand.film_distance == taken.film_distance
    assert stand.lens.surfaces[4].thickness < design(near).surfaces[4].thickness
    got = readings(near)
    # what is engraved counts at infinity; the depth of field is that of the focused lens
    assert got.efl == pytest.approx(196.0, rel=1e-4) and got.f_number == pytest.approx(2.88, rel=1e-3)
    assert got.nearest_focus == pytest.approx(1500.0, rel=1e-5)
    assert got.near_limit < 1600.0 < got.far_limit
    assert got.t_number == readings(replace(near, focus_distance=math.inf)).t_number
    tight = readings(replace(near, focus_distance=500.0))
    assert "the nearest distance of this lens is 1.5" in tight.reason


def test_scaling_sets_the_shortest_focal_length_and_the_zoom_keeps_its_ratio():
    small = replace(ZOOM, focal_length=24.0)
    ends = [lb.first_order(design(replace(small, zoom=end))).efl for end in (0.0, 1.0)]
    assert ends == pytest.approx([24.0, 24.0 * 196.0 / 71.4], rel=1e-4)


@pytest.mark.parametrize(("text", "asked"), [("0.4", ("part", 0.4)), ("1", ("part", 1.0)), ("105mm", ("length", 105.0)),
                                             ("10,5 cm", ("length", 105.0))])
def test_a_zoom_is_typed_as_a_part_of_the_ring_or_as_a_focal_length(text, asked):
    assert read_zoom(text) == pytest.approx(asked)


@pytest.mark.parametrize("text", ["1.5", "-0.1", "wide", "nan", "", "105"])
def test_what_is_no_zoom_says_what_to_type(text):
    with pytest.raises(ValueError, match="from 0 .wide. to 1 .tele., or a focal length such as 105mm"):
        read_zoom(text)
    with pytest.raises(ValueError, match="from 0 .infinity. to 1"):
        read_close(text)


def test_settings_hold_a_zoom_and_old_ones_have_none():
    assert Settings.from_dict({"version": 1}).zoom == 0.0
    assert Settings.from_dict(replace(ZOOM, zoom=0.25).to_dict()).zoom == 0.25
    with pytest.raises(SettingsError, match="zoom 2"):
        replace(ZOOM, zoom=2.0).checked()
    with pytest.raises(lb.LensError, match="does not zoom"):
        design(replace(Settings(), zoom=0.5))


# The dial


def test_the_ring_is_engraved_with_the_stations_and_turns_geometrically():
    dial = dial_scales.zoom_scale((71.4, 105.0, 196.0))
    assert [text for _, text in dial.figures][0] == "71" and {"105", "196"} <= {text for _, text in dial.figures}
    assert (dial.low, dial.high, dial.reset) == (71.4, 196.0, 71.4)
    assert dial.to_unit(math.sqrt(71.4 * 196.0)) == pytest.approx(0.5)
    units = sorted(dial.to_unit(value) for value, _ in dial.figures)
    assert units == [dial.to_unit(value) for value, _ in dial.figures]
    assert [text for _, text in dial_scales.zoom_scale((5.1, 14.8)).figures][0] == "5.1"


def test_the_list_of_lenses_tells_both_ends_of_a_zoom():
    cards = {card.name: card for card in lenses.describe()}
    assert [figures(cards[name]) for name in (NIKKOR, PENTAX)] == [("71–196 mm", "f/2.88"), ("5.1–14.8 mm", "f/2.8")]


def test_a_zoom_lens_has_a_zoom_ring_in_place_of_the_one_that_scales(tmp_path):
    seen = {"shown": ZOOM}
    there = {}

    def gui():
        seen["shown"] = controls_panel(seen["shown"], Chooser())

    def test(ctx):
        def has(item):
            return ctx.item_exists(f"**/{item}")

        there["zoom"] = (has("Zoom"), has("Focal length"))
        box = ctx.item_info("**/Zoom").rect_full
        ctx.mouse_move_to_pos(type(box.min)(box.max.x - 12.0, 0.5 * (box.min.y + box.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)
        there["tele"] = seen["shown"]
        view = ctx.item_info("**/Field of view").rect_full
        ctx.mouse_move_to_pos(type(view.min)(view.max.x - 11.5, 0.5 * (view.min.y + view.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)
        there["wide"] = seen["shown"]
        seen["shown"] = Settings()
        ctx.yield_(2)
        there["prime"] = (has("Zoom"), has("Focal length"))

    drive(gui, test, size=(270, 440))
    assert there["zoom"] == (True, False) and there["prime"] == (False, True)
    assert there["tele"].zoom == pytest.approx(1.0, abs=0.02) and there["tele"].lens == NIKKOR
    assert there["wide"].zoom == pytest.approx(0.0, abs=0.02) and there["wide"].crop == 1.0


@pytest.mark.parametrize(("surface", "radius"), [(0, 3.0), (4, -3.0), (6, -3.0)])
def test_the_zoom_of_an_edited_lens_without_a_growing_focal_length_turns_by_its_part(surface, radius):
    """One diverges throughout, one at a part of its travel, of one the focal length falls."""
    bent = edited(replace(Settings(), lens="nikon-af-s-nikkor-g-ed-18-35-f35", f_number=None),
                  lambda document: with_radius(document, surface, radius))[0]
    assert not is_engraved(design(bent))
    seen = {"shown": bent}

    def gui():
        seen["shown"] = controls_panel(seen["shown"], Chooser())

    def test(ctx):
        box = ctx.item_info("**/Zoom").rect_full
        ctx.mouse_move_to_pos(type(box.min)(box.max.x - 12.0, 0.5 * (box.min.y + box.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)
        names = "Field of view", "Aperture", "Focus distance"
        seen["dials"] = [name for name in names if ctx.item_exists(f"**/{name}")]

    drive(gui, test, size=(270, 440))
    assert seen["shown"].zoom == pytest.approx(1.0, abs=0.02)
    assert readings(seen["shown"]).nearest_focus is None and seen["dials"] == ["Focus distance"]    # it forms no image
    with pytest.raises(lb.LensError, match="does not grow"):
        asked_zoom(design(bent), ("focal length", 20.0))


# The commands


def data(capsys, *words):
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_info_tells_the_stations_and_follows_the_zoom(capsys):
    told = data(capsys, "info", NIKKOR)
    rows = told["positions"]
    assert [row["name"] for row in rows[::2]] == ["71.4 mm, infinity", "105 mm, infinity", "196 mm, infinity"]
    for row in rows:
        assert row["in_focus"] == "inf" if row["close"] == 0.0 else row["in_focus"] == pytest.approx(1500.0, rel=1e-4)
        if row["close"] == 0.0:
            assert row["efl"] == pytest.approx(row["stated_efl"], rel=1e-4)
    assert data(capsys, "info", NIKKOR, "--zoom", "196mm")["efl"] == pytest.approx(196.0, rel=1e-4)
    assert data(capsys, "info", NIKKOR, "--zoom", "150 mm")["efl"] == pytest.approx(150.0, rel=1e-9)
    close = data(capsys, "info", NIKKOR, "--zoom", "1", "--close", "1")
    assert close["efl"] == lb.first_order(lenses.load(NIKKOR, zoom=1.0, close=1.0)).efl
    assert data(capsys, "info", "pbrt-dgauss-50mm")["positions"] == []
    assert main(["info", NIKKOR]) == 0
    assert "196 mm, close" in capsys.readouterr().out
    assert {card["tele_efl"] for card in data(capsys, "lenses")} >= {None, 196.0, 14.8246}


def test_convert_writes_all_positions_or_the_one_that_is_asked_for(tmp_path, capsys):
    assert main(["convert", NIKKOR, str(tmp_path / "all.zmx")]) == 0
    assert main(["convert", NIKKOR, str(tmp_path / "one.zmx"), "--zoom", "1", "--close", "0.5"]) == 0
    assert "positions" not in capsys.readouterr().out.partition("one.zmx")[2]
    assert lenses.load(tmp_path / "all.zmx").zooms
    one = lenses.load(tmp_path / "one.zmx")
    wanted = lenses.load(NIKKOR, zoom=1.0, close=0.5)
    assert one.positions is None and [s.thickness for s in one.surfaces] == [s.thickness for s in wanted.surfaces]
    assert main(["convert", NIKKOR, str(tmp_path / "one.dat")]) == 0
    assert "zoom and focus positions are left out" in capsys.readouterr().out


def test_trace_follows_the_zoom(tmp_path, capsys):
    (tmp_path / "rays.csv").write_text("0,1,-10,0,0,1\n")
    traced = data(capsys, "trace", NIKKOR, "--rays", str(tmp_path / "rays.csv"), "--zoom", "1")
    # a ray 1 mm off the axis leaves at the angle 1 / f, to the order of its height squared
    assert traced["m"][0] == pytest.approx(-1.0 / 196.0, rel=1e-3)


@pytest.mark.parametrize(("words", "said"), [
    (["info", "pbrt-dgauss-50mm", "--zoom", "0.5"], "does not zoom"),
    (["info", "pbrt-dgauss-50mm", "--close", "0.5"], "has no focus groups"),
    (["info", NIKKOR, "--zoom", "300mm"], "zooms from 71.4 to 196 mm"),
    (["info", NIKKOR, "--zoom", "3"], "from 0 (wide) to 1 (tele)"),
    (["info", NIKKOR, "--close", "x"], "from 0 (infinity) to 1"),
    (["render", NIKKOR, "-o", "a.png", "--fov", "30deg"], "sees 19.1°"),
    (["render", NIKKOR, "-o", "a.png", "--zoom", "1", "--fov", "15deg"], "sees 7.0°"),
    (["render", NIKKOR, "-o", "a.png", "--zoom", "1", "--camera", "perspective"], "has no lens to zoom"),
    (["render", NIKKOR, "-o", "a.png", "--focus", "1m"], "the nearest distance of this lens is 1.5 m"),
])
def test_what_a_lens_cannot_do_is_one_clear_line(words, said, capsys):
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert not out and len(err.splitlines()) == 1 and said in err


def test_the_options_turn_the_zoom_and_what_nobody_asked_for_gives_way(tmp_path):
    from lensbench.app.session.export import read_settings

    small = ["--size", "12x8", "--samples", "1", "--lens-model", "pinhole"]
    assert main(["render", NIKKOR, "-o", str(tmp_path / "a.png"), "--fov", "10deg", *small]) == 0
    turned = read_settings(str(tmp_path / "a.png"))
    assert turned.crop == 1.0 and constraints.field_of_view(turned) == pytest.approx(math.radians(10.0), rel=1e-9)
    assert main(["render", PENTAX, "-o", str(tmp_path / "b.png"), "--zoom", "1", *small]) == 0
    long = read_settings(str(tmp_path / "b.png"))
    assert long.zoom == 1.0 and long.f_number is None       # the default f/2.8 is out of reach there
