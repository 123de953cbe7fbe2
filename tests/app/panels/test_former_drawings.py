"""Panels release what they drew of former settings: drawings would fill tens of megabytes in hours of use."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.display.small_textures import MapPictures
from lensbench.app.drawing.plot_painter import Drawn, draw_figure
from lensbench.app.panels import exit_pupil, view_3d
from lensbench.app.panels.lens_section import panel as lens_section
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.plots.plot import Axis, Curve, Figure, Map, Plot, Table
from lensbench.app.settings.settings import Settings
from tests.app.stand import drive

START = Settings(lens="pbrt-dgauss-50mm")
X = np.linspace(0.0, 1.0, 40)


def figure() -> Figure:
    """A map with contours and a curve."""
    shades = Map("contrast", np.outer(X, X), (0.0, 1.0), (0.0, 1.0), levels=(0.25, 0.5))
    axes = Axis("x", 0.0, 1.0), Axis("y", 0.0, 1.0)
    return Figure("Both", ((Plot(*axes, (shades,)), Plot(*axes, (Curve("square", X, X**2),))),), Table((), ()))


def test_a_plot_holds_the_drawings_of_its_newest_figure_alone():
    state, shown, made = Drawn(MapPictures()), [figure()], []

    def gui():
        draw_figure("Both", shown[0], imgui.get_content_region_avail(), state)

    def test(ctx):
        ctx.yield_(3)
        made.append(len(state.memo))
        for _ in range(30):
            former.append(weakref.ref(shown[0].rows[0][0]))
            shown[0] = figure()
            ctx.yield_(2)
        ctx.yield_(2)
        made.append(len(state.memo))

    former: list = []
    drive(gui, test)
    gc.collect()
    assert made[0] == made[1] >= 4                      # the legend, the curve, the gaps and the contours
    assert len(former) == 30 and not any(reference() for reference in former)


@pytest.mark.parametrize("panel", ["section", "view", "pupil"])
def test_a_panel_holds_no_more_after_many_settings_than_after_one(panel):
    state = {"section": lens_section.SectionState, "view": view_3d.View3DState, "pupil": exit_pupil.PupilState}[panel]()
    shown, sizes = [START], []
    memo = state.drawn.memo if panel == "pupil" else state.memo

    def gui():
        if panel == "section":
            lens_section.lens_section_panel(shown[0], state, 10.0)
        elif panel == "view":
            view_3d.composed(shown[0], view_3d.sketch(shown[0]), Pointed(), state)
            imgui.dummy(ImVec2(1.0, 1.0))
        else:
            exit_pupil.exit_pupil_panel(shown[0], 10.0, state)

    def test(ctx):
        ctx.yield_(4)
        sizes.append(len(memo))
        for i in range(12):
            shown[0] = replace(START, focus_distance=800.0 + 150.0 * i)
            ctx.yield_(2)
        ctx.yield_(2)
        sizes.append(len(memo))

    drive(gui, test, (300, 350))
    assert sizes[0] == sizes[1] > 0
