"""The panel *Stability*: a sweep selected with a real mouse, measured in the background, cancelled, read."""

import threading

import numpy as np
import pytest

from lensbench.app.panels import stability
from lensbench.app.studies.stability.plots import FAMILIES
from lensbench.app.studies.stability.sweep import Sweep, curve, with_progress
from lensbench.app.workers import study_workers as surveying
from lensbench.app.workers.study_workers import StabilityWorker
from tests.app.stand import drive as drive_panel

FIRST, SPHERES = ("Intersection", "Distance of the ray's origin"), "Radius of a sphere"


def wait(ctx, what, frames=3000):
    for _ in range(frames):
        if what():
            ctx.yield_(2)
            return
        ctx.yield_()
        threading.Event().wait(0.01)
    raise AssertionError("waited in vain")


@pytest.mark.slow
def test_families_and_sweeps_are_chosen_and_measured_and_a_method_shows_where_it_fails(drive, tmp_path):
    for title in (SPHERES, FIRST[1]):                           # compiled before the window opens
        FAMILIES["Intersection"][title]()

    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Stability")
        hand.ctx.yield_(3)
        sweeps = hand.session.panels._stability_worker.found
        hand.wait(lambda: ("Intersection", SPHERES) in sweeps, "the first sweep")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//Stability/##Sweep")
        hand.ctx.item_click("//##Combo_00/Distance of the ray's origin")
        hand.wait(lambda: FIRST in sweeps, "the second")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/###foot form, float32")
        assert hand.session.panels._stability_state.method == "foot form, float32"
        hand.ctx.yield_(3)
        hand.photograph(tmp_path / "window.png")
        hand.ctx.item_click("//Stability/##Family")
        hand.ctx.item_click("//##Combo_00/Closed forms")
        family = ("Closed forms", "Thin lens as the focus comes to f")
        hand.wait(lambda: family in sweeps, "another family")
        state = hand.session.panels._stability_state
        assert state.title == family[1] and state.method == ""

    session = drive(use)
    assert session.view.messages == []
    assert (tmp_path / "window.png").stat().st_size > 50_000


def slow(started, go):
    """A sweep that waits between its values until it may go on."""
    def measure():
        errors = []
        for value in with_progress(np.array([1.0, 2.0, 3.0])):
            errors.append(0.01 * value)
            started.set()
            go.wait(20.0)
        return Sweep("Patience", "Time", "s", np.array([1.0, 2.0, 3.0]), "Length", "mm", 0.1, "a tenth",
                      (curve("ruler", errors, own=True), curve("hand, float32", [0.05, 0.5, "MISSED"])))
    return measure


def test_measuring_is_cancelled_by_its_button_and_begun_again_by_hand(monkeypatch):
    started, go = threading.Event(), threading.Event()
    families = {"Waiting": {"Patience": slow(started, go)}}
    monkeypatch.setattr(surveying, "FAMILIES", families)
    monkeypatch.setattr(stability, "FAMILIES", families)
    worker, state = StabilityWorker(), stability.StabilityState("Waiting", "Patience")

    def use(ctx):
        wait(ctx, started.is_set)
        ctx.item_click("**/###Cancel task")
        go.set()
        wait(ctx, lambda: worker.key is None)
        assert worker.declined == ("Waiting", "Patience") and not worker.found
        ctx.yield_(5)
        assert worker.key is None                             # it is left alone until it is asked for
        ctx.item_click("**/Measure")
        wait(ctx, lambda: worker.found)
        ctx.item_click("**/###hand, float32")
        ctx.yield_(2)
        assert state.method == "hand, float32"
        ctx.item_click("**/###hand, float32")
        assert state.method == ""

    drive_panel(lambda: stability.stability_panel(worker, state), use, size=(720, 200))


def test_what_goes_wrong_while_measuring_is_said_in_the_panel(monkeypatch):
    def broken():
        raise ZeroDivisionError("a lens without glass")

    families = {"Waiting": {"Patience": broken}}
    monkeypatch.setattr(surveying, "FAMILIES", families)
    worker = StabilityWorker()
    worker.want(("Waiting", "Patience"))
    worker.task.join(10.0)
    worker.collect()
    assert worker.problems == {("Waiting", "Patience"): "ZeroDivisionError: a lens without glass"}
    worker.want(("Waiting", "Patience"))
    assert worker.key is None                                 # nor is it tried in every frame


def test_another_choice_gives_up_what_is_under_way_and_is_measured_next(monkeypatch):
    started, go = threading.Event(), threading.Event()
    monkeypatch.setattr(surveying, "FAMILIES", {"Waiting": {"Patience": slow(started, go), "Haste": slow(started, go)}})
    worker = StabilityWorker()
    worker.want(("Waiting", "Patience"))
    assert started.wait(10.0)
    worker.want(("Waiting", "Haste"))
    go.set()
    worker.task.join(10.0)
    worker.want(("Waiting", "Haste"))
    worker.task.join(10.0)
    worker.collect()
    assert list(worker.found) == [("Waiting", "Haste")]


@pytest.mark.parametrize("rising", [True, False])
def test_the_hard_values_stand_at_the_right_whichever_way_the_quantity_runs(rising):
    values = np.array([1.0, 10.0, 100.0]) if rising else np.array([100.0, 10.0, 1.0])
    sweep = Sweep("Heat", "Heat", "K", values, "Length", "mm", 0.1, "a tenth", (curve("ruler", [0.0, 0.0, 1.0]),))
    plot = stability.sweep_plot(sweep, "")
    assert plot.x.low < 1.0 and plot.x.high > 100.0 and plot.x.falling is not rising
