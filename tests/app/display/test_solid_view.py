"""The 3-D view on the graphics card: the depth test, translucent parts, the world's frame, and the width of lines."""

import math

import moderngl
import numpy as np
import pytest

from lensbench.app.display.solid_view import Drawing, Line, Solid, SolidView
from lensbench.app.plots.solids import Eye, Part, Strokes, grid_part

SIZE = (96, 64)
EYE = Eye(distance=100.0, yaw=0.0, pitch=0.0)           # at +z, looks along −z, y up
STILL = tuple(np.eye(4).ravel().tolist())
RED, GREEN, DARK = (0.9, 0.0, 0.0, 1.0), (0.0, 0.9, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)


@pytest.fixture
def view():
    context = moderngl.create_context(standalone=True, backend="egl")
    yield SolidView(context)
    context.release()


def square(z: float, half: float = 8.0, x: float = 0.0) -> Part:
    return grid_part("thing", np.array([[[x - half, -half, z], [x + half, -half, z]],
                                        [[x - half, half, z], [x + half, half, z]]]))


def shot(view, solids=(), lines=(), pose=STILL, eye=EYE) -> np.ndarray:
    view.picture(Drawing(eye, pose, tuple(solids), tuple(lines), DARK), SIZE)
    return view.read().astype(int)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_part_hides_the_farther_in_any_order(view, order):
    parts = [Solid(square(0.0), RED), Solid(square(-20.0, 16.0), GREEN)]
    middle = shot(view, [parts[i] for i in order])
    assert middle[32, 48, 0] > 60 and middle[32, 48, 1] == 0
    assert middle[32, 62, 1] > 60 and middle[32, 62, 0] == 0        # beside the nearer one


def test_a_translucent_part_hides_nothing_behind_it(view):
    both = shot(view, [Solid(square(10.0), (0.9, 0.0, 0.0, 0.4)), Solid(square(-20.0), GREEN)])
    assert both[32, 48, 0] > 30 and both[32, 48, 1] > 30


def test_a_line_is_hidden_by_what_stands_before_it_and_as_wide_as_it_is_asked(view):
    across = Strokes("x", np.array([[[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0]]]))
    for width in (2.0, 6.0):
        column = shot(view, lines=[Line(across, GREEN, width)])[:, 48, 1]
        assert column.sum() / 255.0 / 0.9 == pytest.approx(width, abs=0.6)
    hidden = shot(view, [Solid(square(5.0), RED)], [Line(across, GREEN, 2.0)])
    assert hidden[32, 48, 1] == 0 and hidden[32, 80, 1] > 100
    behind = Strokes("x", np.array([[[0.0, 0.0, 0.0], [0.0, 3.0, 400.0]]]))        # ends behind the eye
    assert shot(view, lines=[Line(behind, GREEN, 3.0)])[..., 1].max() > 100


def test_the_upper_row_is_above_and_things_of_the_world_stand_where_the_camera_sees_them(view):
    up = shot(view, [Solid(grid_part("x", np.array([[[-5.0, 10.0, 0.0], [5.0, 10.0, 0.0]],
                                                    [[-5.0, 18.0, 0.0], [5.0, 18.0, 0.0]]])), RED)])
    assert up[:32, :, 0].max() > 60 and up[32:, :, 0].max() == 0
    pose = np.eye(4)
    pose[:3, 3] = 1000.0, 0.0, 0.0                                  # the camera stands 1 m to the right
    moved = shot(view, [Solid(square(0.0, x=1000.0), RED, of_world=True)], pose=tuple(pose.ravel().tolist()))
    still = shot(view, [Solid(square(0.0), RED)])
    np.testing.assert_array_equal(moved, still)


def test_a_view_is_drawn_again_only_on_a_change_and_takes_another_size(view):
    drawing = Drawing(EYE, STILL, (Solid(square(0.0), RED),), (), DARK)
    first = view.picture(drawing, SIZE)
    assert view.picture(drawing, SIZE) == first and view.read().shape == (64, 96, 3)
    turned = shot(view, drawing.solids, eye=EYE.turned(math.radians(80.0), 0.0))
    assert (turned[..., 0] > 20).sum() < 0.5 * (shot(view, drawing.solids)[..., 0] > 20).sum()
    view.picture(drawing, (40, 30))
    assert view.read().shape == (30, 40, 3)
