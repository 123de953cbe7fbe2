"""The dials of the controls for lenses that an edit has broken."""

import math
from dataclasses import replace

from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.state.figures import readings
from lensbench.app.state.lens_edit.editing import edited
from lensbench.app.state.settings import Settings
from lensbench.lenses.editing.cells import with_radius
from tests.app.stand import drive


def test_the_focus_dial_of_a_lens_that_focuses_on_nothing_turns():
    bent = edited(replace(Settings(), lens="sony-fe-g-20-f18", f_number=None),
                  lambda document: with_radius(document, 2, -0.5))[0]
    assert readings(bent).nearest_focus == math.inf
    seen = {"shown": bent}

    def gui():
        seen["shown"] = controls_panel(seen["shown"], Chooser())

    def test(ctx):
        box = ctx.item_info("**/Focus distance").rect_full
        ctx.mouse_move_to_pos(type(box.min)(box.min.x + 0.8 * (box.max.x - box.min.x), 0.5 * (box.min.y + box.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)

    drive(gui, test, size=(270, 440))
    assert 4000.0 < seen["shown"].focus_distance < 8000.0          # from 1.2 m
