"""Textures of small pictures by name, of maps of plots, and the view from inside a panorama."""

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.pose import LookAround
from lensbench.app.display.gl_texture import drawn_into, shader_source
from lensbench.app.settings.setting_table import LAYOUTS


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


MOST_KEPT = 16 << 20            # bytes of textures that are no longer shown: 70 snapshots


class SmallTextures:
    """Pictures (h, w, 3 or 4) of 8 bits on the graphics card. Needs a current GL context.

    pictures: by name; an array is never changed, but another may take its place. Call `begin_frame` before those of a
    frame.
    """

    def __init__(self, pictures: Mapping[str, NDArray[np.uint8]]):
        self._pictures = pictures
        self._textures: dict[str, tuple[NDArray[np.uint8], moderngl.Texture]] = {}      # the last one shown is last
        self._shown: set[str] = set()           # since the frame began

    def begin_frame(self) -> None:
        """Release textures of pictures that are gone; if all hold more than MOST_KEPT, those not shown for longest."""
        size = sum(_size(texture) for _, texture in self._textures.values())
        for name, (_, texture) in list(self._textures.items()):
            if name not in self._pictures or size > MOST_KEPT and name not in self._shown:
                size -= _size(texture)
                self._release(name)
        self._shown.clear()

    def of(self, name: str) -> tuple[int, tuple[int, int]] | None:
        """The GL name and the size in pixels of a picture; None until it is there."""
        pixels = self._pictures.get(name)
        shown, texture = self._textures.get(name, (None, None))
        if shown is not pixels and texture is not None:
            self._release(name)
        if pixels is None:
            return None
        if shown is not pixels or texture is None:
            height, width = pixels.shape[:2]
            rgba = np.full((height, width, 4), 255, np.uint8)   # three bytes a pixel take llvmpipe longer
            rgba[..., :pixels.shape[2]] = pixels
            texture = moderngl.get_context().texture((width, height), 4, rgba)
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._textures.pop(name, None)
        self._textures[name] = pixels, texture
        self._shown.add(name)
        return texture.glo, texture.size

    def _release(self, name: str) -> None:
        self._textures.pop(name)[1].release()


class MapPictures:
    """The pictures of maps between frames, each a texture. Call `begin_frame` before those of a frame."""

    def __init__(self) -> None:
        self._drawn: dict[str, NDArray[np.uint8]] = {}          # in this frame, or until it begins in the last one
        self._textures = SmallTextures(self._drawn)

    def begin_frame(self) -> None:
        """Release the textures of maps that the last frame did not draw."""
        self._textures.begin_frame()
        self._drawn.clear()

    def texture(self, name: str, picture: NDArray[np.uint8]) -> int:
        """The GL name of a map's texture, made again where another picture (h, w, 4) has taken the place of the last.

        name: of the map.
        """
        self._drawn[name] = picture
        texture_and_size = self._textures.of(name)
        assert texture_and_size is not None
        return texture_and_size[0]


def _size(texture: moderngl.Texture) -> int:
    """Bytes of a texture of four bytes a pixel."""
    return 4 * texture.width * texture.height
