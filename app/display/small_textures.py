"""Textures of small pictures by name, made when they are first shown."""

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray


class SmallTextures:
    """Pictures (h, w, 3) of 8 bits that never change, on the graphics card. Needs a current GL context."""

    def __init__(self, pictures: Mapping[str, NDArray[np.uint8]]):
        self._pictures = pictures
        self._textures: dict[str, moderngl.Texture] = {}

    def of(self, name: str) -> tuple[int, tuple[int, int]] | None:
        """The GL name and the size in pixels of a picture; None until it is there."""
        if name not in self._textures:
            pixels = self._pictures.get(name)
            if pixels is None:
                return None
            height, width = pixels.shape[:2]
            texture = moderngl.get_context().texture((width, height), 3, np.ascontiguousarray(pixels), alignment=1)
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR) 
            self._textures[name] = texture
        texture = self._textures[name]
        return texture.glo, texture.size
