"""Passes into textures: the former target comes back, and a processor that draws has one under way at a time."""

import moderngl
import numpy as np
import pytest

from lensbench.app.display.gl_texture import Queue, drawn_into, queue


@pytest.fixture
def context():
    made = moderngl.create_context(standalone=True, backend="egl")
    yield made
    made.release()


@pytest.fixture
def target(context):
    framebuffer = context.framebuffer([context.texture((4, 4), 4)])
    yield framebuffer
    framebuffer.release()


def noted(context, called):
    """A queue that notes its calls instead of those of a window."""
    waiting = object.__new__(Queue)
    waiting.finish = lambda: called.append("finish")
    context.extra = waiting
    return waiting


def test_the_former_target_comes_back_after_an_error_too(context, target):
    screen = context.simple_framebuffer((4, 4))
    screen.use()
    with drawn_into(context, target):
        assert context.detect_framebuffer().glo == target.glo
        context.clear(1.0, 0.0, 0.0, 1.0)
    assert context.detect_framebuffer().glo == screen.glo
    with pytest.raises(KeyError), drawn_into(context, target):
        raise KeyError
    assert context.detect_framebuffer().glo == screen.glo
    assert np.frombuffer(target.read(components=3), np.uint8).reshape(-1, 3).tolist() == 16 * [[255, 0, 0]]


def test_a_processor_that_draws_is_waited_for_before_a_pass(context, target):
    called = []
    waiting = noted(context, called)
    try:
        assert queue(context) is waiting
        with drawn_into(context, target):
            assert called == ["finish"]
            called.append("draw")
        assert called == ["finish", "draw"]
    finally:
        context.extra = None
    assert queue(context) is None
    with drawn_into(context, target):
        pass
    assert called == ["finish", "draw"]


def test_the_passes_of_a_window_that_a_processor_draws_go_one_by_one(drive):
    def use(hand):
        hand.picture()
        assert (queue(moderngl.get_context()) is not None) == hand.session.presenter.software
        hand.session.presenter.finish()

    assert drive(use).view.messages == []
