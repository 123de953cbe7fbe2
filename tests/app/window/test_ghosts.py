"""The panel of ghosts in the whole window: ranked pairs, the pair under the mouse in section and picture."""

from dataclasses import replace

import pytest

from lensbench.app.bench.build import flare
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.window.analyses import PANELS
from tests.app.conftest import SMALL
from tests.app.window.test_analyses import show


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_the_pair_under_the_mouse_lights_its_surfaces_and_draws_its_ray(drive, tmp_path, size):
    assert "Ghosts" in PANELS

    def use(hand):
        hand.picture()
        show(hand, "Ghosts")
        state = hand.session.analyses.states["Ghosts"]
        assert state.figure is not None and state.figure.table.rows
        hand.photograph(tmp_path / "before.png")
        brightest = state.figure.table.rows[0][0]
        first, second = map(int, brightest.split("-"))
        hand.ctx.item_click(f"//Ghosts/**/{brightest.replace('-', ' · ')}")
        hand.ctx.yield_(4)
        links = hand.session.view.links
        assert state.choices["kept"] == brightest and links.surfaces == (first, second)
        assert links.ray is not None and len(links.ray.path) > 12 and links.ray.raster is not None
        hand.ctx.item_click("//Ghosts/Alone in the picture")
        hand.ctx.yield_(2)
        assert hand.settings.ghost_pair == brightest and flare(hand.settings).pairs == ((first, second),)
        hand.photograph(tmp_path / "after.png")
        hand.ctx.item_click(f"//Ghosts/**/{brightest.replace('-', ' · ')}")
        hand.ctx.yield_(2)
        assert state.choices["kept"] == "" and hand.settings.ghost_pair == ""

    assert drive(use, replace(SMALL, ghosts=True), size).view.messages == []


@pytest.mark.slow
def test_a_kept_pair_of_the_lens_before_is_no_pair_of_the_next(drive):
    def use(hand):
        hand.picture()
        show(hand, "Ghosts")
        state = hand.session.analyses.states["Ghosts"]
        kept = next(row[0] for row in state.figure.table.rows if int(row[0].split("-")[1]) > 5)
        hand.ctx.item_click(f"//Ghosts/**/{kept.replace('-', ' · ')}")
        hand.ctx.yield_(2)
        assert state.choices["kept"] == kept
        before = state.figure
        hand.session.take(with_lens(hand.settings, "lenshh-cooke-triplet-50"))      # of surfaces 0 to 5
        for _ in range(600):
            hand.ctx.yield_()
            if state.figure not in (None, before):
                break
        hand.ctx.yield_(2)
        assert state.figure is not before and state.choices["kept"] == ""

    assert drive(use, replace(with_lens(SMALL, "pbrt-dgauss-50mm"), ghosts=True)).view.messages == []
