"""The automatic model in the bench: what the window shows is the choice's picture, and the bar says why."""

import json
import threading
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest

import lensbench as lb
from lensbench.app.bench.auto_model import choice_details, choice_summary, record
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.command.main import main
from lensbench.app.session.export import read_settings
from lensbench.app.session.picture_render import export_render
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.render_worker import RenderWorker
from tests.app.conftest import SMALL
from tests.app.workers.test_render_worker import wait

# A crop so small that the thin lens will do at f/2.8 and not wide open
PART = replace(SMALL, crop=0.3)
WIDE = replace(PART, f_number=None)


def choice(settings, previous=None):
    return lb.choose_model(camera(settings), lb.builtin_scene(settings.scene), previous=previous)


@pytest.fixture
def worker():
    made = RenderWorker(PART, threads=2)
    yield made
    made.stop()


def done(worker, settings):
    update = worker.newest()
    return (update is not None and update.settings == settings and update.samples == settings.samples
            and not update.is_provisional and update.depth is not None)


def test_the_bench_opens_with_the_automatic_model():
    assert (Settings().camera, Settings().lens_model) == ("lens", "auto")
    assert Settings.from_dict({"version": 1, "lens_model": "trace"}).lens_model == "trace"
    assert (choice(PART).model, choice(WIDE).model) == ("thin", "polynomial")


def test_the_picture_at_rest_is_that_of_the_choice_though_its_first_pass_was_not(worker):
    wait(lambda: done(worker, PART))
    for settings in (WIDE, PART, replace(PART, focus_distance=900.0)):
        worker.restart(settings)
        wait(lambda settings=settings: done(worker, settings))
        update = worker.newest()
        chosen = choice(settings)
        assert (update.choice.model, update.choice.degree) == (chosen.model, chosen.degree)
        expected = lb.render(chosen.applied(camera(settings)), lb.builtin_scene(settings.scene), settings.samples)
        # sums of eight samples, in passes of one, two, … : float32 addition in another order
        np.testing.assert_allclose(update.image, expected, rtol=1e-5, atol=1e-6)
        wait(lambda: worker.newest().speeds is not None)
        assert min(worker.newest().speeds) > 0.0


def test_a_camera_that_turns_is_not_judged_again(worker):
    wait(lambda: done(worker, PART))
    first = worker.newest().choice
    worker.restart(replace(PART, yaw=0.1, exposure=1.0, seed=3))
    wait(lambda: done(worker, replace(PART, yaw=0.1, exposure=1.0, seed=3)))
    assert worker.newest().choice is first


def test_a_hand_that_drags_sees_pictures_and_ends_with_the_right_one():
    seen, wake = [], threading.Event()
    dragged = RenderWorker(replace(WIDE, samples=4), wake=wake.set, threads=2)
    try:
        wait(lambda: dragged.newest() is not None)
        for i in range(60):
            dragged.restart(replace(WIDE, samples=4, f_number=2.1 + i / 50.0))
            wake.wait(0.01)
            wake.clear()
            seen.append(dragged.newest().choice)
        last = replace(WIDE, samples=4, f_number=2.1 + 59 / 50.0)
        wait(lambda: done(dragged, last))
        assert dragged.newest().choice.model == "thin"
        # One change on the way, and no way back: the choice does not flicker
        models = [found.model for found in seen if found is not None]
        assert sum(a != b for a, b in zip(models, models[1:], strict=False)) <= 1
    finally:
        dragged.stop()


def test_a_view_of_samples_shows_the_rays_of_the_full_trace(worker):
    origins = replace(PART, view="origin")
    worker.restart(origins)
    wait(lambda: done(worker, origins))
    traced = lb.Rendering(camera(replace(PART, lens_model="trace")), lb.builtin_scene(PART.scene), view="origin")
    traced.add(PART.samples)
    assert worker.newest().choice is None
    np.testing.assert_allclose(worker.newest().image, traced.image(), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("name", ["a.exr", "a.png"])
def test_an_export_chooses_afresh_and_records_the_choice(tmp_path, name):
    export_render(PART, tmp_path / name)
    assert read_settings(tmp_path / name) == PART             # the setting is “auto” still
    expected = record(choice(PART))
    assert expected["model"] == "thin" and "pinhole" in expected["refused"]
    if name == "a.exr":
        file = OpenEXR.File(str(tmp_path / name))
        assert json.loads(file.header()["lensbench"])["chosen"] == expected
        picture = lb.render(choice(PART).applied(camera(PART)), lb.builtin_scene(PART.scene), PART.samples)
        np.testing.assert_allclose(file.channels()["RGB"].pixels, picture, rtol=1e-5, atol=1e-6)
    else:
        assert json.dumps(expected)[1:-1].encode() in (tmp_path / name).read_bytes()


def test_the_command_line_says_what_was_chosen(tmp_path, capsys):
    words = ["render", "pbrt-dgauss-50mm", "--size", "24x16", "--samples", "1", "-o", str(tmp_path / "a.png")]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["chosen"]["model"] == "polynomial"
    assert main(words) == 0
    assert "Auto: polynomial of degree 3, off by" in capsys.readouterr().out
    assert main([*words, "--lens-model", "thin"]) == 0
    assert "Auto" not in capsys.readouterr().out


@pytest.mark.slow
def test_the_bar_says_what_was_chosen_what_it_saves_and_what_was_refused():
    thin = choice(PART)
    words = choice_summary(thin, (2.0, 50.0))
    assert words[0] == "Auto: thin lens" and words[1].startswith("off by 0.") and words[2] == "48 ns a ray saved (25 ×)"
    assert words[3].startswith("not pinhole: blur off by 1")
    details = choice_details(thin, None)
    assert "\nPinhole: blur off by" in details and "\nThin lens: chosen, off by" in details
    traced = lb.choose_model(camera(PART), lb.builtin_scene(PART.scene), 1e-7, 1e-7)
    assert choice_summary(traced, (50.0, 50.0))[:1] == ["Auto: full trace"]
    assert "no faster than the full trace here" in choice_summary(thin, (50.0, 50.2))
    assert choice_summary(traced, None)[1].startswith("not polynomial of degree 11:")


def test_the_bar_says_that_a_model_near_the_limit_does_not_replace_the_one_before():
    """A model that is within half a pixel was said to be refused for it."""
    refused = choice(PART)
    near = refused.table[-1]._replace(error_px=0.49, error_stops=0.01, worst="blur off by 0.49 px on the axis")
    other = refused.table[-1]._replace(model="polynomial", degree=3, error_px=0.1)
    kept = replace(refused, model="polynomial", degree=3, table=(*refused.table[:-1], near, other))
    assert choice_summary(kept, None)[-1] == "kept, as thin lens is near the limit: blur off by 0.49 px on the axis"
    assert "Thin lens: blur off by 0.49 px on the axis, near the limit: the model before is kept" in choice_details(
        kept, None)


@pytest.mark.slow
def test_the_model_is_chosen_by_hand_and_followed_along_the_aperture(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Camera")
        hand.ctx.item_click("//##Combo_00/Automatic")
        hand.picture()
        assert hand.settings.lens_model == "auto"
        assert hand.session.presenter.update.choice.model == "thin"
        # Click the aperture dial at its wide end
        hand.ctx.mouse_move_to_pos(hand.at("**/Aperture", 0.02, 0.6))
        hand.ctx.mouse_click(0)
        hand.picture()
        assert hand.settings.f_number is None or hand.settings.f_number < 2.2
        assert hand.session.presenter.update.choice.model == "polynomial"
        bar = hand.box("**/Automatic model")
        assert bar.max.x - bar.min.x > 0.4 * 1280.0 and bar.max.x < 1280.0
        hand.ctx.mouse_move("**/Automatic model")
        hand.ctx.sleep_no_skip(1.0, 0.05)
        hand.photograph(tmp_path / "bar.png")

    assert drive(use, replace(PART, lens_model="trace")).view.messages == []
    assert (tmp_path / "bar.png").exists()
