"""The view from inside a panorama on the graphics card, as a texture with the first row first."""

import moderngl

from lensbench.app.display.gl_texture import shader_source
from lensbench.app.display.passes import drawn_into
from lensbench.app.state.picture.look_around import LookAround
from lensbench.app.state.setting_table import LAYOUTS


class Panorama:
    """Draws in one GL context (3.3 core or later) into a texture of its own."""

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._array = context.vertex_array(
            context.program(shader_source("triangle.vert"), shader_source("look_around.frag")), [])
        self._texture: moderngl.Texture | None = None
        self._framebuffer: moderngl.Framebuffer | None = None
        self._done: tuple = ()

    def picture(self, source: moderngl.Texture, of: object, layout: str, look: LookAround,
                size: tuple[int, int]) -> int:
        """The GL name of a texture of this size (pixels) with the view.

        source: the developed panorama; of: a key that changes with its content. Draws on a change.
        """
        size = max(size[0], 1), max(size[1], 1)
        if self._texture is None or self._texture.size != size:
            if self._texture is not None and self._framebuffer is not None:
                self._framebuffer.release()
                self._texture.release()
            self._texture = self._context.texture(size, 4)
            self._framebuffer = self._context.framebuffer([self._texture])
            self._done = ()
        assert self._framebuffer is not None
        key = (source.glo, of, layout, look, size)
        if key != self._done:
            for name, value in (("picture", 0), ("layout_kind", list(LAYOUTS).index(layout)),
                                ("turn", tuple(look.axes.T.ravel())), ("reach", look.reach(size)), ("size", size)):
                uniform = self._array.program[name]
                assert isinstance(uniform, moderngl.Uniform)
                uniform.value = value
            with drawn_into(self._context, self._framebuffer):
                self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
                source.use(0)
                self._array.render(moderngl.TRIANGLES, vertices=3)
            self._done = key
        return self._texture.glo
