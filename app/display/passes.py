"""Passes into textures beside the window, one after the other where a processor draws.

Mesa's llvmpipe collects the draw calls of a target in a scene, and takes the first of its scenes that is done for the
next target. A scene that is never taken again stays tied to its target, and so each frame that shows this texture waits
within imgui's draw calls, with Python's lock held, for all that it has drawn so far: 6 of 8 ms. A second scene comes
into being where a target is begun before the one before is done, once and for all. So each pass first waits for the
one before, and so does the frame, without Python's lock (read from Mesa 22.3's machine code, and measured). Nothing is
under way while panels are drawn: to begin with a pass at once, by glFlush, gained nothing.
"""

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import moderngl


class Queue:
    """The draw calls that a processor has not done yet, of the current context of GLFW. OSError: there is no glFinish.

    finish: waits for them; the call goes by ctypes, and other threads of Python go on.
    """

    def __init__(self) -> None:
        import glfw  # late: after imgui_bundle, so that both share one library

        address = ctypes.cast(glfw.get_proc_address("glFinish"), ctypes.c_void_p).value
        if address is None:
            raise OSError("OpenGL has no glFinish: another driver is needed")
        self.finish: Callable[[], None] = ctypes.CFUNCTYPE(None)(address)


def queue(context: moderngl.Context) -> Queue | None:
    """The queue of a context that `one_by_one` has prepared."""
    return context.extra if isinstance(context.extra, Queue) else None


def one_by_one(context: moderngl.Context) -> None:
    """A processor draws in this context, which is GLFW's current one: its passes wait for one another."""
    context.extra = Queue()


@contextmanager
def drawn_into(context: moderngl.Context, framebuffer: moderngl.Framebuffer) -> Iterator[None]:
    """Draw into a framebuffer, then into the former one again."""
    before, waiting = context.detect_framebuffer(), queue(context)
    if waiting is not None:
        waiting.finish()
    framebuffer.use()
    try:
        yield
    finally:
        before.use()
