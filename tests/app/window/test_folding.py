"""Small and changing windows: columns that fold and come back, tools that move into a menu, the least size."""

import json
from dataclasses import replace

import pytest
from imgui_bundle import hello_imgui, imgui
from imgui_bundle.glfw_utils import glfw_window_hello_imgui

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.drawing import theme
from lensbench.app.window.docking import MINIMUM, Arrangement, arrangements
from lensbench.app.window.layouts import LAYOUTS, docks, folds, splits
from tests.app.conftest import SMALL

EM = 15.0
TOOLS = ("Fit", "100 %", "Focus pick", "Sharp pick", "Pin pixel", "Focus peaking", "CoC overlay", "Plane of focus",
         "Clipping", "Histogram", "Magnifier", "Views", "Compare", "Pause", "Restart", "Screenshot", "Export")


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("width", [640, 720, 900, 1100, 1130, 1280, 1920, 3840])
@pytest.mark.parametrize("height", [400, 500, 600, 720, 1080, 2160])
def test_the_picture_has_half_of_every_window_and_no_panel_is_lost(name, width, height):
    parts = {split.new_dock: split.ratio for split in splits(name, width, height, EM)}
    assert (1.0 - parts.get("Left", 0.0)) * (1.0 - parts.get("Right", 0.0)) >= 0.5 - 1e-6
    assert 1.0 - parts.get("Bottom", 0.0) >= 0.5
    assert all(0.0 < share < 1.0 for share in parts.values())
    laid = docks(name, folds(name, width, height, EM))
    assert set(laid) == set(parts)
    whole = [panel for panels in LAYOUTS[name].docks.values() for panel in panels]
    assert sorted(panel for panels in laid.values() for panel in panels) == sorted(whole)


def _resize(hand, width: int, height: int) -> None:
    glfw.set_window_size(glfw_window_hello_imgui(), width, height)
    hand.ctx.yield_(12)


def _places() -> dict[str, tuple[int, int, int, int]]:
    """Corner and size of the shown panels."""
    places = {}
    for panel in hello_imgui.get_runner_params().docking_params.dockable_windows:
        window = imgui.internal.find_window_by_name(panel.label)
        if window is not None and window.active and not window.hidden:
            places[panel.label] = tuple(round(side) for side in (*window.pos, *window.size))
    return places


@pytest.mark.slow
def test_columns_fold_in_a_small_window_and_unfold_as_they_were_arranged(drive):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("Plan")
        controls = imgui.internal.find_window_by_name("Controls")      # an arrangement of one's own
        imgui.internal.dock_builder_dock_window("Falloff", controls.dock_id)
        hand.ctx.yield_(2)
        hand.ctx.window_focus("Falloff")
        hand.ctx.yield_(4)
        hello_imgui.get_runner_params().docking_params.dockable_window_of_name("Spaces").is_visible = False
        hand.ctx.yield_(4)
        before = _places()
        assert before["Falloff"][0] < 300 and before["Plan"][0] > 900
        _resize(hand, 900, 600)
        narrow = _places()
        assert narrow["Render"][2] > 450
        assert narrow["Section"][1] == narrow["Circle of confusion"][1] > narrow["Render"][1]
        assert "Spaces" not in narrow
        _resize(hand, 640, 400)
        assert set(_places()) == {"Controls", "Render"} and _places()["Render"][2] >= 320
        _resize(hand, 1280, 720)
        assert _places() == before
        assert "Spaces" not in before

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_every_tool_is_in_the_row_or_in_its_menu(drive):
    def use(hand):
        hand.picture()
        for width, height in ((640, 400), (900, 600)):
            _resize(hand, width, height)
            shown = [tool for tool in TOOLS if hand.ctx.item_exists(f"//Render/{tool}")]
            for item in (*shown, "Picture size", "Strip Correction"):
                assert hand.box(f"**/{item}").max.x <= width, (item, width)
            rest = TOOLS[len(shown):]
            assert shown == list(TOOLS[:len(shown)]) and bool(rest) == (width == 640)
            if rest:
                assert hand.box("**/More tools").max.x < hand.box("**/Picture size").min.x
                hand.ctx.item_click("**/More tools")
                assert all(hand.ctx.item_exists(f"//##Popup_00/{tool}") or hand.ctx.item_exists(f"**/{tool}")
                           for tool in rest)
                hand.ctx.item_click("**/Histogram")
                assert hand.session.view.histogram
                hand.ctx.item_click("**/More tools")
                hand.ctx.item_click("**/Views")
                hand.ctx.item_click("**/fate")
                hand.ctx.yield_(2)
                assert hand.settings.view == "fate"

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_window_has_a_least_size(drive, monkeypatch):
    """GLFW is asked for it: on no display there is none, because GLFW 3.4 takes the least height for the greatest."""
    asked = []
    monkeypatch.setattr(glfw, "get_platform", lambda: glfw.PLATFORM_X11)
    monkeypatch.setattr(glfw, "set_window_size_limits", lambda _, *limits: asked.append(limits))
    drive(lambda hand: asked.append(theme.scale()), replace(SMALL, samples=1))
    limits, factor = asked
    assert limits == (*(round(side * factor) for side in MINIMUM), glfw.DONT_CARE, glfw.DONT_CARE)


@pytest.mark.slow
def test_a_window_that_grows_leaves_no_hole(drive):
    def use(hand):
        hand.picture()
        for size in ((640, 400), (1900, 1000), (900, 600), (1280, 720)):
            _resize(hand, *size)
            area = imgui.get_main_viewport()
            space = imgui.internal.dock_node_get_root_node(imgui.internal.find_window_by_name("Render").dock_node)
            assert space.size.x == area.work_size.x
            assert 0.0 <= area.work_size.y - space.size.y <= theme.em(2.2)      # the line at the bottom
            nodes = {panel.dock_node.id_: panel.dock_node for name in _places()
                     if (panel := imgui.internal.find_window_by_name(name))}.values()
            covered = sum((node.size.x + 3.0) * (node.size.y + 3.0) for node in nodes)
            assert covered >= space.size.x * space.size.y

    drive(use, replace(SMALL, samples=1))


@pytest.mark.slow
def test_each_layout_keeps_what_was_moved_shown_and_hidden_in_it(drive):
    def use(hand):
        hand.picture()
        window = hand.session
        controls = imgui.internal.find_window_by_name("Controls")
        imgui.internal.dock_builder_dock_window("Falloff", controls.dock_id)
        hand.ctx.yield_(2)
        hand.ctx.window_focus("Falloff")
        hello_imgui.get_runner_params().docking_params.dockable_window_of_name("Spaces").is_visible = False
        hand.ctx.yield_(8)
        mine = _places()
        assert mine["Falloff"][:2] == tuple(round(side) for side in controls.pos)
        hand.ctx.menu_click("//##MainMenuBar/View/Layout/Designer")
        hand.ctx.yield_(12)
        stock = _places()
        assert "Falloff" not in stock and "Seidel" in stock
        hand.ctx.menu_click("//##MainMenuBar/View/Analysis/Sunstar")        # one more panel, in this layout alone
        hand.ctx.yield_(8)
        hand.ctx.menu_click("//##MainMenuBar/View/Layout/Bench")
        hand.ctx.yield_(12)
        assert _places() == mine
        hand.ctx.menu_click("//##MainMenuBar/View/Layout/Designer")
        hand.ctx.yield_(12)
        panels = hello_imgui.get_runner_params().docking_params
        assert panels.dockable_window_of_name("Sunstar").is_visible
        hand.ctx.menu_click("//##MainMenuBar/View/Reset layout")
        hand.ctx.yield_(12)
        assert not panels.dockable_window_of_name("Sunstar").is_visible and _places() == stock
        hand.ctx.menu_click("//##MainMenuBar/View/Layout/Bench")            # another layout was not reset
        hand.ctx.yield_(12)
        assert _places() == mine and window.layout == "Bench"

    assert drive(use, size=(1600, 900)).view.messages == []


@pytest.mark.slow
def test_each_layout_keeps_the_order_of_its_tabs(drive):
    """Panels that the layout before had shown came first."""
    def tabs(name):
        return tuple(tab.window.name for tab in imgui.internal.find_window_by_name(name).dock_node.tab_bar.tabs)

    def use(hand):
        hand.picture()
        window = hand.session
        for layout in ("Bench", "Student", "Photographer", "Editor", "Bench", "Photographer", "Designer", "Bench",
                       "Student", "Photographer"):
            window.choose_layout(layout)
            hand.ctx.yield_(12)
            for names in LAYOUTS[layout].docks.values():
                assert tabs(names[-1]) == names

    assert drive(use, replace(SMALL, samples=1), size=(1600, 900)).view.messages == []


def test_arrangements_come_back_from_the_preferences_without_the_damaged_ones():
    given = {json.dumps(["Bench", {"Right": "Bottom"}]): [["Plan"], [], "[Window][Plan]\nPos=1,2\n"], "?": [[], [], ""],
             json.dumps(["Designer", {}]): 3}
    assert arrangements(json.dumps(given)) == {json.dumps(["Bench", {"Right": "Bottom"}]):
                                               Arrangement(["Plan"], [], "[Window][Plan]\nPos=1,2\n")}
    assert arrangements("") == arrangements("[1]") == arrangements("{") == {}
