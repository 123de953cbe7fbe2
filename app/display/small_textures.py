"""Textures of small pictures by name, made when they are first shown."""

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray


class SmallTextures:
    """Pictures (h, w, 3 or 4) of 8 bits on the graphics card. Needs a current GL context.

    pictures: by name; an array is never changed, but another may take its place.
    """

    def __init__(self, pictures: Mapping[str, NDArray[np.uint8]]):
        self._pictures = pictures
        self._textures: dict[str, tuple[NDArray[np.uint8], moderngl.Texture]] = {}

    def of(self, name: str) -> tuple[int, tuple[int, int]] | None:
        """The GL name and the size in pixels of a picture; None until it is there."""
        pixels = self._pictures.get(name)
        shown, texture = self._textures.get(name, (None, None))
        if shown is not pixels and texture is not None:
            texture.release()
            del self._textures[name]
        if pixels is None:
            return None
        if shown is not pixels or texture is None:
            height, width = pixels.shape[:2]
            rgba = np.full((height, width, 4), 255, np.uint8)   # three bytes a pixel take llvmpipe longer
            rgba[..., :pixels.shape[2]] = pixels
            texture = moderngl.get_context().texture((width, height), 4, rgba)
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._textures[name] = pixels, texture
        return texture.glo, texture.size
