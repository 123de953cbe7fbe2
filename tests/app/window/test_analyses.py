"""The analysis panels in the whole window: layouts, numbers under the cursor, files."""

import gc
import weakref
from dataclasses import replace
from itertools import product

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing.controls import chord
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.layouts import BENCH, LAYOUTS
from tests.app.conftest import SMALL


def inside(panel: str, x: float, y: float) -> ImVec2:
    window = imgui.internal.find_window_by_name(panel)
    return ImVec2(window.pos.x + x * window.size.x, window.pos.y + y * window.size.y)


def show(hand, name: str) -> None:
    """Show a panel as the menu does, and wait for its refined figure."""
    hand.ctx.menu_click(f"//##MainMenuBar/View/Analysis/{name}")
    settle(hand)


def settle(hand) -> None:
    hand.ctx.yield_(3)
    hand.wait(lambda: not hand.session.analyses.worker.busy, "the figures")
    hand.ctx.yield_(2)


def test_every_panel_of_a_layout_is_one_of_the_window_and_in_one_place(drive):
    def use(hand):
        labels = {panel.label for panel in hand.session.panels.windows()}
        for name, layout in LAYOUTS.items():
            placed = [panel for panels in layout.docks.values() for panel in panels]
            assert set(placed) <= labels and len(set(placed)) == len(placed), name

    drive(use)


@pytest.mark.slow
def test_a_layout_is_chosen_and_the_bench_comes_back(drive):
    def use(hand):
        hand.picture()
        for name in [*list(LAYOUTS)[1:], BENCH]:
            hand.ctx.menu_click(f"//##MainMenuBar/View/Layout/{name}")
            hand.ctx.yield_(8)
            assert hand.session.layout == name
            for panels in LAYOUTS[name].docks.values():
                front = imgui.internal.find_window_by_name(panels[0]).dock_node.visible_window
                assert front.name == panels[0], (name, panels[0])
        settle(hand)

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.long
def test_each_panel_shows_a_figure_whose_data_are_copied_and_says_why_there_is_none(drive):
    def use(hand):
        hand.picture()
        states = hand.session.analyses.states
        for name in PANELS:
            show(hand, name)
            figure = states[name].figure
            assert figure is not None and states[name].reason == "", name
            hand.ctx.mouse_move_to_pos(inside(name, 0.5, 0.9))
            hand.ctx.mouse_click(1)
            hand.ctx.yield_(2)
            hand.ctx.item_click("**/Copy data")
            assert imgui.get_clipboard_text() == figure.table.text("\t"), name
        hand.session.take(replace(hand.settings, camera="perspective"))
        for name in PANELS:
            hand.ctx.window_focus(f"//{name}")
            hand.ctx.yield_(3)
            assert states[name].figure is None and "no lens" in states[name].reason, name

    assert drive(use, replace(SMALL, blades=7)).view.messages == []


def test_a_figure_out_of_sight_is_dropped_with_the_next_settings_and_comes_back(drive):
    def use(hand):
        hand.picture()
        show(hand, "Spots")
        analyses, spots = hand.session.analyses, weakref.ref(hand.session.analyses.states["Spots"].figure)
        show(hand, "Wavefront")                         # in the same place
        assert spots() is not None
        hand.session.take(replace(hand.settings, focus_distance=900.0))
        settle(hand)
        gc.collect()
        assert spots() is None and analyses.states["Spots"].figure is None
        assert analyses.states["Wavefront"].figure is not None
        hand.ctx.window_focus("//Spots")
        settle(hand)
        assert analyses.states["Spots"].figure is not None

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_numbers_of_a_spot_under_the_cursor_are_those_of_the_table(drive):
    def use(hand):
        hand.picture()
        show(hand, "Spots")
        state = hand.session.analyses.states["Spots"]
        hand.ctx.item_click("**/Blur")
        settle(hand)
        assert "blur" in state.figure.conditions
        hand.ctx.mouse_move_to_pos(inside("Spots", 0.5, 0.5))
        hand.ctx.yield_(3)
        first, line, *_ = state.drawn.told.split("\n")
        assert first.startswith(("axis", "1", "2"))
        rms = float(line.split("RMS ")[1].split()[0])
        column = state.figure.table.head.index("rms radius (um)")
        assert any(abs(row[column] - rms) < 0.006 * rms for row in state.figure.table.rows)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_distortion_is_a_grid_among_the_curves_over_the_field(drive):
    def use(hand):
        hand.picture()
        show(hand, "Field curves")
        state = hand.session.analyses.states["Field curves"]
        hand.ctx.item_click("**/Grid###Shown grid")
        settle(hand)
        assert state.figure.title == "Distortion grid"
        hand.ctx.mouse_move_to_pos(inside("Field curves", 0.6, 0.5))
        hand.ctx.yield_(3)
        assert state.drawn.told.startswith("crossing (") and "its image" in state.drawn.told

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_the_film_dragged_through_the_map_moves_the_focus_dial(drive):
    def use(hand):
        hand.picture()
        show(hand, "MTF map")
        before, window = hand.settings, imgui.internal.find_window_by_name("MTF map")
        middle = _film(hand, window)
        hand.drag(middle, ImVec2(middle.x + 0.2 * window.size.x, middle.y))
        assert hand.settings.focus_distance < before.focus_distance         # the film is farther from the lens
        settle(hand)
        hand.ctx.key_press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        hand.ctx.yield_(3)
        assert hand.settings == before                                      # the whole drag is one step

    assert drive(use).view.messages == []


def _film(hand, window) -> ImVec2:
    """A place on the film's line: where the mouse turns it into a handle."""
    state = hand.session.analyses.states["MTF map"]
    y = window.pos.y + 0.55 * window.size.y
    for x in range(int(window.pos.x + 0.4 * window.size.x), int(window.pos.x + 0.75 * window.size.x), 2):
        hand.ctx.mouse_move_to_pos(ImVec2(x, y))
        hand.ctx.yield_(2)
        if state.figure is not None and not state.drawn.told:
            return ImVec2(x, y)
    raise AssertionError("no film in the map")


@pytest.mark.slow
def test_white_light_is_chosen_in_the_menu_of_a_panel_and_by_a_layout(drive):
    def use(hand):
        hand.picture()
        show(hand, "MTF")
        figure = hand.session.analyses.states["MTF"].figure
        assert "weighted as the picture" in figure.conditions
        hand.ctx.item_click("**/###MTF menu")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Weight wavelengths")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/By photopic vision")
        settle(hand)
        assert hand.settings.white == "photopic"
        assert "weighted by photopic vision" in hand.session.analyses.states["MTF"].figure.conditions
        hand.ctx.menu_click("//##MainMenuBar/View/Layout/Designer")
        hand.ctx.yield_(8)
        assert hand.settings.white == "lens"

    assert drive(use, replace(SMALL, lens="lib-tronnier-1953", f_number=None)).view.messages == []


@pytest.mark.slow
def test_a_figure_is_saved_where_the_dialog_says(drive, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))

    def use(hand):
        hand.picture()
        show(hand, "MTF")
        figure = hand.session.analyses.states["MTF"].figure
        hand.ctx.item_click("**/###MTF menu")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Save as CSV…")
        hand.ctx.yield_(3)
        hand.press(imgui.Key.enter)
        hand.wait((tmp_path / "analysis.csv").exists, "the file")
        hand.wait(lambda: hand.session.view.messages, "the message")
        assert (tmp_path / "analysis.csv").read_text() == figure.table.text()

    session = drive(use)
    assert session.view.messages == ["Plot saved as analysis.csv"] and not session.view.notices.errors()


@pytest.mark.slow
@pytest.mark.long
def test_the_figure_of_every_panel_is_drawn_into_a_file_and_its_numbers_are_saved(drive, tmp_path):
    def use(hand):
        hand.picture()
        analyses, view = hand.session.analyses, hand.session.view
        for name in PANELS:
            show(hand, name)
            figure = analyses.sheet.saving = analyses.states[name].figure
            for suffix in (".csv", ".svg"):
                path = tmp_path / f"{name}{suffix}"
                analyses.save(path)
                hand.wait(lambda path=path: f"Plot saved as {path.name}" in view.messages, "the message")
                content = path.read_bytes()
                assert content.startswith({".csv": figure.table.head[0].encode(), ".svg": b"<?xml"}[suffix]), path.name
                if suffix == ".svg":
                    assert all(word in content.decode() for word in figure.title.split())

    assert not drive(use, replace(SMALL, blades=7)).view.notices.errors()


@pytest.mark.slow
def test_a_is_behind_b_in_the_plots_while_both_are_compared(drive):
    def use(hand):
        hand.picture()
        show(hand, "MTF")
        state = hand.session.analyses.states["MTF"]
        alone = state.figure
        hand.press(imgui.Key.a)
        hand.press(imgui.Key.s)
        hand.session.take(replace(hand.settings, f_number=8.0))
        settle(hand)
        names = [layer.name for layer in state.figure.rows[0][0].named()]
        assert names == [*(layer.name for layer in alone.rows[0][0].named()), "A"]
        hand.ctx.mouse_move_to_pos(inside("MTF", 0.5, 0.5))
        hand.ctx.yield_(3)
        assert "   A 0." in state.drawn.told
        hand.session.take(replace(hand.settings, compare="off"))
        settle(hand)
        assert "A" not in [layer.name for layer in state.figure.rows[0][0].named()]

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.long
def test_every_panel_compares_a_and_b_and_is_read_everywhere(drive):
    """Ghosts failed: its table read the column that names the lens as a number."""
    def use(hand):
        hand.picture()
        hand.press(imgui.Key.a)
        hand.press(imgui.Key.s)
        hand.session.take(replace(hand.settings, lens="lenshh-cooke-triplet-50", f_number=8.0))
        hand.picture()
        for name, state in hand.session.analyses.states.items():
            show(hand, name)
            assert state.figure is not None and state.reason == "", name
            for x, y in product((0.3, 0.6, 0.85), (0.35, 0.55, 0.75)):
                hand.ctx.mouse_move_to_pos(inside(name, x, y))
                hand.ctx.yield_(1)

    assert drive(use, replace(SMALL, blades=7)).view.messages == []


@pytest.mark.slow
def test_a_mark_of_the_spots_under_the_mouse_is_a_ray_in_the_section(drive):
    def use(hand):
        hand.picture()
        show(hand, "Spots")
        links, window = hand.session.view.links, imgui.internal.find_window_by_name("Spots")
        for y, step in product((0.5, 0.55, 0.6), range(60)):
            hand.ctx.mouse_move_to_pos(ImVec2(window.pos.x + (0.4 + 0.003 * step) * window.size.x,
                                              window.pos.y + y * window.size.y))
            hand.ctx.yield_(2)
            if links.ray is not None:
                break
        assert links.ray is not None and links.ray.surface == -1 and ": from" in links.ray.end
        assert len(links.ray.path) == 13                    # 11 surfaces, far before them, and the film

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_low_panel_gives_its_room_to_the_plot(drive):
    """The dock below the picture of a small window: legend and remarks left no plot there."""
    def use(hand):
        hand.session.choose_layout("Photographer")
        hand.picture()
        settle(hand)
        state = hand.session.analyses.states["MTF"]
        assert state.figure is not None and "MTF 0 0" in state.drawn.shown, "no plot was drawn"

    drive(use, size=(900, 600))


@pytest.mark.slow
def test_a_copy_of_a_run_is_taken_and_undone(drive, tmp_path):
    def use(hand):
        hand.picture()
        show(hand, "Tolerances")
        hand.ctx.item_click("//Tolerances/**/###Show pictures")
        settle(hand)
        hand.photograph(tmp_path / "copies.png")
        hand.ctx.item_click("//Tolerances/**/Take a copy…")
        hand.ctx.yield_(3)
        hand.photograph(tmp_path / "menu.png")
        hand.ctx.item_click("//$FOCUSED/###4")
        hand.picture()
        assert ", copy " in hand.session.history.present.edited
        hand.photograph(tmp_path / "taken.png")
        hand.ctx.key_press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        hand.picture()
        assert hand.session.history.present.edited == ""

    assert drive(use, replace(SMALL, lens="lenshh-cooke-triplet-50", f_number=5.6), (1280, 720)).view.messages == []
