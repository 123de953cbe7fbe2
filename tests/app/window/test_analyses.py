"""The analysis panels in the whole window: layouts, numbers under the cursor, files."""

from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.state.request import Request
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.layouts import BENCH, LAYOUTS


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
                assert imgui.internal.find_window_by_name(panels[0]).active, (name, panels[0])
        settle(hand)

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_each_panel_shows_a_figure_and_says_why_there_is_none(drive, name):
    def use(hand):
        hand.picture()
        show(hand, name)
        state = hand.session.analyses.states[name]
        assert state.figure is not None and state.reason == ""
        hand.session.take(replace(hand.settings, camera="perspective"))
        settle(hand)
        assert state.figure is None and "no lens" in state.reason

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_numbers_of_a_spot_under_the_cursor_are_those_of_the_table(drive):
    def use(hand):
        hand.picture()
        show(hand, "Spots")
        hand.ctx.mouse_move_to_pos(inside("Spots", 0.5, 0.3))
        hand.ctx.yield_(3)
        state = hand.session.analyses.states["Spots"]
        first, line, *_ = state.drawn.told.split("\n")
        assert first.startswith(("axis", "1", "2"))
        rms = float(line.split("RMS ")[1].split()[0])
        column = state.figure.table.head.index("rms radius (um)")
        assert any(abs(row[column] - rms) < 0.006 * rms for row in state.figure.table.rows)

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_every_figure_is_copied_and_saved(drive, name, tmp_path):
    def use(hand):
        hand.picture()
        show(hand, name)
        hand.ctx.mouse_move_to_pos(inside(name, 0.5, 0.6))
        hand.ctx.mouse_click(1)
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Copy data")
        figure = hand.session.analyses.states[name].figure
        assert imgui.get_clipboard_text() == figure.table.text("\t")
        for request, suffix in ((Request.SAVE_PLOT_CSV, ".csv"), (Request.SAVE_PLOT_SVG, ".svg"),
                                (Request.SAVE_PLOT_PNG, ".png")):
            hand.session.analyses.sheet.saving = figure
            path = tmp_path / f"figure{suffix}"
            hand.session.analyses.save(path)
            hand.wait(path.exists, f"the {request}")
            hand.wait(lambda: hand.session.analyses._saving is None, "the end of the saving")
        assert (tmp_path / "figure.csv").read_text() == figure.table.text()
        assert "<svg" in (tmp_path / "figure.svg").read_text()[:600]
        assert (tmp_path / "figure.png").read_bytes()[:4] == b"\x89PNG"

    session = drive(use)
    assert session.view.messages and set(session.view.messages) == session.view.done
