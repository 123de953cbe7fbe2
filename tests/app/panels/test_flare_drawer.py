"""The drawer Flare: switches for ghosts and stars, which state where no light shows them, and blades and coating."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from lensbench.app.bench.lens_choice import with_scene
from lensbench.app.drawing.controls import chord
from lensbench.app.workers.flare_worker import FlareWorker
from tests.app.conftest import SMALL

KEY = imgui.Key


@pytest.mark.slow
def test_the_switches_state_where_no_light_shows_them_and_low_sun_shows_both(drive, tmp_path):
    dark = replace(SMALL, scene="grid-wall", f_number=11.0, coating="single-layer")

    def use(hand):
        worker = hand.session.chooser.flare.worker
        hand.picture()
        hand.ctx.item_click("**/###Drawer Flare")
        hand.wait(lambda: worker.reasons(hand.settings), "the measurement")
        assert worker.reasons(hand.settings) == {
            name: f"No light in this scene is small and bright enough to show {name}" for name in ("ghosts", "stars")}
        hand.photograph(tmp_path / "none.png")
        hand.ctx.item_click("//$FOCUSED/Try the scene Low sun")
        hand.wait(lambda: worker.reasons(hand.settings), "the measurement")
        assert hand.settings.scene == "low-sun" and worker.reasons(hand.settings) == {"ghosts": "", "stars": ""}
        hand.picture()
        plain = hand.session.presenter.update.image
        for name in ("Ghosts", "Stars"):
            hand.ctx.item_click(f"//$FOCUSED/{name}")
        hand.ctx.item_click("//$FOCUSED/Blades 6")
        hand.picture()
        hand.photograph(tmp_path / "both.png")
        assert hand.settings.ghosts and hand.settings.stars and hand.settings.blades == 6
        assert (hand.session.presenter.update.image - plain).max() > 0.1
        hand.ctx.item_click("//$FOCUSED/Blades & coating")              # off: as designed
        hand.ctx.yield_(2)
        assert hand.settings.blades is None and hand.settings.coating == "auto"
        hand.press(KEY.escape)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings.blades == 6

    assert drive(use, dark).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize(("settings", "word"), [
    (replace(SMALL, scene="fairground"), "moves"), (replace(SMALL, camera="orthographic"), "lens with surfaces")])
def test_a_camera_or_scene_without_flare_is_named(settings, word):
    worker = FlareWorker()
    while not worker.reasons(settings):
        assert worker.task is not None
        worker.task.join()
    assert all(word in reason for reason in worker.reasons(settings).values())


def test_every_light_of_low_sun_is_in_the_picture():
    from lensbench import builtin_scene
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.core.scenery.small_lights import small_lights

    scene, view = builtin_scene("low-sun"), camera(with_scene(SMALL, "low-sun"))
    back = np.linalg.inv(np.asarray(view.world_from_camera, float))
    points = [back[:3, :3] @ np.asarray(scene.sun.direction)] + [
        back[:3, :3] @ np.asarray(light.centre) + back[:3, 3] for light in small_lights(scene.objects)]
    half = np.array([18.0, 12.0]) / 50.4
    inside = [bool((np.abs(point[:2] / -point[2]) < half).all()) for point in points]
    assert inside[0] and sum(inside) >= 8
