"""A pixel followed through the panels by a real mouse: hovered, pinned, unpinned; rays of plots, and surfaces."""

from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.plots.section import sketch, surface_curves
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

KEY = imgui.Key
ANAMORPHIC = "lentil-schneider-anamorphic-31-2001"
LENSES = ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm", ANAMORPHIC]


def point_at_picture(hand, x: float, y: float) -> None:
    hand.ctx.mouse_move_to_pos(hand.at("**/Picture", x, y))
    hand.ctx.yield_(3)


def inside(panel: str, x: float, y: float) -> ImVec2:
    window = imgui.internal.find_window_by_name(panel)
    return ImVec2(window.pos.x + x * window.size.x, window.pos.y + y * window.size.y)


@pytest.mark.slow
@pytest.mark.parametrize("lens", LENSES)
def test_a_hovered_pixel_shows_its_rays_in_every_panel(drive, lens):
    def use(hand):
        panels = hand.session.panels
        hand.picture()
        hand.ctx.window_focus("//Plan")
        assert panels.kept.section.pixel_rays == 0
        point_at_picture(hand, 0.5, 0.45)
        assert panels.kept.section.pixel_rays == 15                   # nine that pass, three lost on either side
        assert 2 <= panels.kept.plan.pixel_rays <= 9
        hand.ctx.window_focus("//Pixel")
        point_at_picture(hand, 0.52, 0.45)
        assert len(panels.kept.pixel.places) > 100
        point_at_picture(hand, 0.5, 1.5)                                # the mouse leaves the picture
        assert panels.kept.section.pixel_rays == 0 and len(panels.kept.pixel.places) == 0

    assert drive(use, replace(SMALL, lens=lens, f_number=None)).view.messages == []


@pytest.mark.slow
def test_a_pixel_is_pinned_and_unpinned_by_tool_key_and_mouse(drive):
    def use(hand):
        view, panels = hand.session.view, hand.session.panels
        hand.picture()
        before = hand.settings
        point_at_picture(hand, 0.5, 0.5)
        hand.press(KEY.i)
        pinned = view.links.pinned
        assert pinned is not None
        hand.ctx.mouse_move_to_pos(hand.at("**/Exposure", 0.5, 0.5))
        hand.ctx.yield_(3)
        assert panels.kept.section.pixel_rays == 15                   # it stays while the mouse is elsewhere
        hand.press(KEY.escape)
        assert view.links.pinned is None and panels.kept.section.pixel_rays == 0
        hand.ctx.item_click("**/Pin pixel")
        for is_pinned in (True, False):                                 # a click pins, another one unpins
            point_at_picture(hand, 0.5, 0.5)
            hand.ctx.mouse_click(0)
            hand.ctx.yield_(2)
            assert (view.links.pinned is not None) == is_pinned
        hand.ctx.item_click("**/Pin pixel")
        assert view.focus_pick and not view.pin_pick
        hand.ctx.menu_click("//##MainMenuBar/View/Pin pixel")
        assert view.links.pinned is not None
        assert hand.settings == before                                  # none of this focuses, or is a step of undo

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_the_point_spread_is_that_of_the_hovered_pixel_and_stays_when_the_mouse_leaves(drive):
    def use(hand):
        hand.picture()
        hand.ctx.menu_click("//##MainMenuBar/View/Analysis/Point spread")
        hand.ctx.yield_(3)
        state, worker = hand.session.analyses.states["Point spread"], hand.session.analyses.worker
        hand.ctx.item_click("**/Pixel###Field pixel")
        hand.ctx.yield_(3)
        assert state.figure is None and "Point at the picture" in state.reason
        titles = []
        for x, y in ((0.5, 0.5), (0.8, 0.6)):
            point_at_picture(hand, x, y)
            hand.ctx.mouse_move_to_pos(inside("Point spread", 0.5, 0.6))
            hand.ctx.yield_(3)
            hand.wait(lambda: not worker.busy, "the figure")
            hand.ctx.yield_(2)
            titles.append((state.figure.rows[0][0].title, state.figure.conditions))
        assert titles[0] != titles[1] and float(titles[0][0].split()[0]) < 1.0 < 5.0 < float(titles[1][0].split()[0])

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_points_of_the_pupil_and_of_the_spot_are_rays_in_the_section(drive):
    def use(hand):
        links, panels = hand.session.view.links, hand.session.panels
        hand.picture()
        hand.ctx.window_focus("//Pixel")
        point_at_picture(hand, 0.5, 0.5)
        hand.press(KEY.i)
        hand.ctx.mouse_move_to_pos(inside("Exit pupil", 0.55, 0.6))
        hand.ctx.yield_(3)
        ray = links.ray
        assert ray is not None and ray.path.shape[1] == 3
        hand.ctx.mouse_move_to_pos(ImVec2(*panels.kept.pixel.places[17].tolist()))
        hand.ctx.yield_(3)
        assert links.ray.end.startswith("from the sphere") and links.ray.surface == -1
        point_at_picture(hand, 0.5, 0.5)
        assert links.ray is None and len(panels.kept.pixel.places) > 100

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_surface_under_the_mouse_is_lit_with_the_rays_that_its_rim_ends(drive):
    def use(hand):
        links, state = hand.session.view.links, hand.session.panels.kept.section
        hand.picture()
        hand.ctx.window_focus("//Lens card")
        lens, corner = sketch(hand.settings).lens, hand.box("**/Section canvas").min
        for index in (0, len(lens.surfaces) - 1):
            z, y = surface_curves(lens)[index][4]
            hand.ctx.mouse_move_to_pos(state.view.to_screen(corner, z, y))
            hand.ctx.yield_(3)
            assert links.surfaces == (index,)
        z = 0.5 * (lens.vertices[0] + lens.vertices[1])
        hand.ctx.mouse_move_to_pos(state.view.to_screen(corner, z, 0.3))
        hand.ctx.yield_(3)
        assert links.surfaces == (0, 1)                                 # the glass between
        point_at_picture(hand, 0.5, 0.5)
        assert links.surfaces == ()

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["perspective", "thin", "pinhole", "environment", "bare-sensor", "finite-pinhole"])
def test_an_ideal_camera_shows_what_it_has_and_says_the_rest(drive, kind):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Pixel")
        point_at_picture(hand, 0.5, 0.5)
        drawn = hand.session.panels.kept.section.pixel_rays
        assert drawn == {"perspective": 9, "thin": 9, "pinhole": 1}.get(kind, 0)
        assert len(hand.session.panels.kept.pixel.places) == 0

    assert drive(use, of_kind(SMALL, kind)).view.messages == []
