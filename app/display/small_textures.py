"""Textures of small pictures by name, made when they are first shown."""

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

MOST_KEPT = 16 << 20            # bytes of textures that are no longer shown: 70 pictures of moments


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
        held = sum(_size(texture) for _, texture in self._textures.values())
        for name, (_, texture) in list(self._textures.items()):
            if name not in self._pictures or held > MOST_KEPT and name not in self._shown:
                held -= _size(texture)
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


def _size(texture: moderngl.Texture) -> int:
    """Bytes of a texture of four bytes a pixel."""
    return 4 * texture.width * texture.height
