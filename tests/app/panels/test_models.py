"""The panel Models: measured in the background, and a click takes the picture with a model."""

from dataclasses import replace
from time import monotonic, sleep

import pytest
from imgui_bundle import ImVec2

from lensbench.app.bench.camera_kinds import camera
from lensbench.app.panels.models import ModelsState, _model, _present, models_panel
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.studies.charts.curves import Mark
from lensbench.app.studies.charts.subjects import Subject, chart
from lensbench.app.workers.study_workers import ChartWorker, charted
from tests.app.stand import centre, drive

pytestmark = pytest.mark.slow           # their chart compiles five polynomials
START = Settings(lens="lenshh-cooke-triplet-50", lens_model="trace", f_number=8.0)


@pytest.fixture(scope="module", autouse=True)
def compiled():
    """What is measured, compiled before a window takes its share of the processor."""
    there = camera(START)
    chart(Subject(START.lens, START.lens, there), seconds=0.0, in_the_renderer=False)


class Panel:
    def __init__(self, settings: Settings = START):
        self.settings, self.worker, self.state = settings, ChartWorker(), ModelsState()

    def show(self) -> None:
        sleep(0.002)                                    # a screen's pause between two frames
        self.settings = models_panel(self.settings, self.worker, self.state)

    def wait(self, ctx) -> None:
        end = monotonic() + 240.0
        while self.worker.of != charted(self.settings):
            assert monotonic() < end
            ctx.yield_()
        ctx.yield_(3)


def test_the_chart_of_the_present_lens_comes_by_itself_and_a_click_takes_a_model():
    panel, values = Panel(), {}

    def click(ctx, item: str) -> None:
        ctx.mouse_move_to_pos(centre(ctx, item))
        ctx.yield_(2)
        ctx.mouse_click(0)
        ctx.yield_(2)

    def test(ctx):
        panel.wait(ctx)
        for name in ("degree 7", "thin lens", "pinhole", "scalar reference", "trace, float64", "degree 11"):
            click(ctx, f"**/###Model {name}")
            values[name] = panel.settings.lens_model, panel.settings.degree
        click(ctx, "**/###Model trace, float32 name")       # its name is as good as its mark
        values["trace"] = panel.settings
        for shown in ("worst", "light"):
            click(ctx, f"**/###Error {shown}")
            ctx.mouse_move_to_pos(centre(ctx, "**/###Model degree 9"))
            ctx.yield_(3)
        values["chart"] = panel.worker.chart
        click(ctx, "**/###Measure again")
        panel.wait(ctx)

    drive(panel.show, test, (420, 320))
    assert values["degree 7"] == ("polynomial", 7)
    assert values["thin lens"] == ("thin", 7)
    assert values["pinhole"] == values["scalar reference"] == values["trace, float64"] == ("pinhole", 7)
    assert values["degree 11"] == ("polynomial", 11)
    assert values["trace"] == replace(START, degree=11)
    marks = {mark.name: mark for mark in values["chart"].marks}
    assert marks["trace, float32"].error < marks["degree 3"].error < marks["pinhole"].error


def test_a_picture_is_taken_with_the_degree_that_is_set():
    assert camera(replace(START, lens_model="polynomial", degree=5)).degree == 5
    with pytest.raises(SettingsError, match="degree 4"):
        replace(START, degree=4).checked()


def test_the_present_model_is_marked_and_of_the_automatic_one_its_choice():
    assert _present(replace(START, lens_model="polynomial", degree=5), None) == "degree 5"
    assert _present(replace(START, lens_model="auto"), ("thin", 0)) == "thin lens"
    assert _present(replace(START, lens_model="auto"), None) == ""


def test_only_a_valid_model_of_pictures_can_be_chosen():
    assert _model(Mark("scalar reference", "scalar")) is _model(Mark("trace, float64", "trace")) is None
    assert _model(Mark("thin lens", "thin")) == ("thin", 0)
    assert _model(Mark("table", "table")) is None               # the charts alone draw it
    assert _model(Mark("degree 9", "polynomial", why="blades")) is None


STATES = [START, replace(START, lens="no-such-lens"), replace(START, camera="fisheye"), replace(START, f_number=0.3),
          replace(START, lens="lentil-schneider-anamorphic-31-2001", f_number=None)]


@pytest.mark.parametrize("size", [(30, 30), (90, 75), (90, 500), (900, 110)])
def test_the_panel_lives_in_any_window_and_any_state(size):
    panel = Panel()

    def test(ctx):
        for state in STATES:
            panel.settings = state
            ctx.yield_(3)
            assert panel.settings == state

    drive(panel.show, test, size)


def test_a_measurement_that_is_cancelled_leaves_the_settings_alone_until_they_change():
    panel = Panel()

    def test(ctx):
        while panel.worker.task is None:
            ctx.yield_()
        panel.worker.task.cancel()
        while panel.worker.task is not None:
            ctx.yield_()
        end = monotonic() + 0.8
        while monotonic() < end:
            ctx.yield_()
        assert panel.worker.task is None and panel.worker.chart is None
        panel.settings = replace(START, f_number=11.0)
        panel.wait(ctx)
        assert panel.worker.chart is not None
        ctx.mouse_move_to_pos(ImVec2(5.0, 5.0))

    drive(panel.show, test, (300, 300))
