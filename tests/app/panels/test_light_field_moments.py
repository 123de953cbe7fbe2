"""Moments of the exposure that a light field kept apart: on the command line, in files, in the panel *Light field*."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.light_field_query import Look, light_field_picture, radiance, radiance_over_time
from lensbench.app.command.main import main
from lensbench.app.session.recordings import load_light_field, save_light_field
from tests.app.conftest import SMALL

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("moments") / "field.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--lens-model", "thin", "--scene", "fairground", "--size",
                 "36x24", "--shutter", "1/15", "--views", "3x3", "--samples", "8", "--moments", "4", "-o",
                 str(path)]) == 0
    return path


def test_moments_come_back_from_their_file_and_are_focused_one_by_one(recorded, tmp_path, capsys):
    recording = load_light_field(recorded)
    field = recording.field
    assert field.moments.shape == (4, 3, 3, 3, 24, 36) and len(field.instants) == 4
    save_light_field(tmp_path / "again.npz", recording)
    assert np.array_equal(load_light_field(tmp_path / "again.npz").field.moments, field.moments)
    look = Look("focus", 1200.0, moment=2)
    assert np.array_equal(light_field_picture(recording, look, None), field.instants[2].refocus(1200.0))
    assert np.abs(light_field_picture(recording, look, None) - field.refocus(1200.0)).max() > 0.01
    for moment in ("1", "4"):
        assert main(["lightfield", "refocus", str(recorded), "--moment", moment, "-o", str(tmp_path / "a.pfm")]) == 0
    assert main(["lightfield", "refocus", str(recorded), "--moment", "5", "-o", str(tmp_path / "a.pfm")]) == 2
    assert "holds 4" in capsys.readouterr().err


def test_the_radiance_of_a_pixel_over_time_has_the_mean_of_the_whole(recorded, capsys):
    recording = load_light_field(recorded)
    moments, whole = radiance_over_time(recording, (20, 12)), radiance(recording, (20, 12))
    assert moments.shape == (4, 3, 3, 3)
    assert np.allclose(moments.mean(0), whole, rtol=3e-3, atol=1e-5)         # half floats
    assert main(["lightfield", "view", str(recorded), "--pixel", "20", "12", "--json"]) == 0
    assert np.allclose(json.loads(capsys.readouterr().out)["radiance_over_time"], moments)


def test_what_has_no_moments_says_so(tmp_path, capsys):
    for arguments, says in ((["--moments", "2"], "nothing moves"),
                            (["--moments", "2", "--microlenses", "3"], "adds up its exposure")):
        assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--size", "12x8", "--samples", "1", *arguments, "-o",
                     str(tmp_path / "field.npz")]) == 2
        assert says in capsys.readouterr().err


def test_moments_are_recorded_by_buttons_and_looked_at(drive):
    start = replace(SMALL, lens_model="thin", scene="fairground", shutter=1.0 / 15.0)

    def use(hand):
        controller = hand.session.light_field
        hand.picture()
        hand.ctx.window_focus("Light field")
        hand.ctx.yield_(3)
        for button in ("Views 5", "Samples 4", "Moments 2", "Pixels 320"):
            hand.ctx.item_click(f"//Light field/**/{button}")
        announced = controller.form.bytes(hand.settings)
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: controller.worker.recording is not None, "the light field")
        assert controller.worker.recording.size == announced
        hand.ctx.yield_(3)
        hand.ctx.item_click("//Light field/**/Moment 1")
        hand.wait(lambda: (shown := controller.field_picture).look == controller.look.asked and not shown.coarse,
                  "the picture of the moment")
        assert controller.look.moment == 1
        field = controller.worker.recording.field
        assert np.array_equal(controller.field_picture.image, field.instants[1].refocus(controller.look.distance))
        hand.ctx.item_click("//Light field/**/Show rays")
        hand.ctx.yield_(3)
        hand.ctx.mouse_move_to_pos(hand.at("**/Over time", 0.5, 0.5))
        hand.ctx.item_click("//Light field/**/Moment -1")
        hand.wait(lambda: (shown := controller.field_picture).look == controller.look.asked and not shown.coarse,
                  "the picture of the whole")
        assert isinstance(field, lb.LightField)
        assert np.array_equal(controller.field_picture.image, field.refocus(controller.look.distance))

    assert drive(use, start).view.messages == []
