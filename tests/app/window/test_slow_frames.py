"""Fast hands on slow frames: several events of mouse and keys come between two frames, and none is lost or mistaken."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from tests.app.conftest import SMALL, mouse_to

KEY = imgui.Key
ON_FIT, ON_PICTURE = (304.0, 35.0), (630.0, 330.0)      # of a window of 1280 × 720
NOWHERE = -3.4028234663852886e38, -3.4028234663852886e38        # where imgui has a mouse that left the window


@pytest.mark.slow
def test_a_click_focuses_though_the_mouse_came_to_the_picture_in_the_same_frame(slow_frames):
    def script(session):
        yield from [0] * 3
        mouse_to(*ON_FIT)
        yield from [0] * 2
        mouse_to(*ON_PICTURE)
        imgui.get_io().add_mouse_button_event(0, True)
        imgui.get_io().add_mouse_button_event(0, False)
        yield from [0] * 6
        assert session.history.present.focus_distance != 2000.0

    slow_frames(script, replace(SMALL, focus_distance=2000.0))


@pytest.mark.slow
@pytest.mark.parametrize("released_first", [False, True])
def test_ctrl_z_never_acts_as_z(slow_frames, released_first):
    def script(session):
        io = imgui.get_io()
        yield from [0] * 3
        session.take(replace(session.history.present, exposure=1.0))
        yield from [0] * 3
        for key in (KEY.left_ctrl, KEY.mod_ctrl):
            io.add_key_event(key, True)
        yield 0
        io.add_key_event(KEY.z, True)
        for key in (KEY.left_ctrl, KEY.mod_ctrl):
            if released_first:                          # before the next frame, as fast hands do
                io.add_key_event(key, False)
        yield from [0] * 2
        io.add_key_event(KEY.z, False)
        for key in (KEY.left_ctrl, KEY.mod_ctrl):
            io.add_key_event(key, False)
        yield from [0] * 3
        assert session.history.present == SMALL
        io.add_key_event(KEY.z, True)                   # and Z alone is Z
        yield 0
        io.add_key_event(KEY.z, False)
        yield from [0] * 2
        assert session.history.present.overlay == "clipping"

    slow_frames(script)


def test_a_drag_past_the_end_of_the_aperture_opens_the_lens_though_the_release_comes_in_the_same_frame(slow_frames):
    def script(session):
        io, x, y = imgui.get_io(), 100.0, 255.0       # on the dial Aperture, which begins at x = 10
        session.take(replace(session.history.present, f_number=5.6))
        yield from [0] * 3
        mouse_to(x, y)
        yield from [0] * 2
        io.add_mouse_button_event(0, True)
        yield from [0] * 2
        mouse_to(x - 20.0, y)
        yield from [0] * 2
        assert session.history.present.f_number > 2.0
        mouse_to(4.0, y)
        io.add_mouse_button_event(0, False)
        yield from [0] * 3
        assert session.history.present.f_number is None         # wide open, exactly
        session.take(replace(session.history.present, f_number=5.6))
        yield from [0] * 2
        mouse_to(x, y)
        yield from [0] * 2
        io.add_mouse_button_event(0, True)
        yield from [0] * 2
        mouse_to(x + 10.0, y)
        yield from [0] * 2
        dragged = session.history.present.f_number
        io.add_mouse_pos_event(*NOWHERE)                # the mouse has left the window
        io.add_mouse_button_event(0, False)
        yield from [0] * 3
        assert session.history.present.f_number == dragged

    slow_frames(script)
