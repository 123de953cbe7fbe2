"""The picture on the graphics card: a linear film goes in, a texture ready for the screen comes out.

Uses moderngl, and no part of the window. Textures hold the picture's first row first, so that imgui shows them
upright. The picture's alpha is the distance (mm) before the film of the object that a pixel sees; the shaders derive
from it how far the object is out of focus.

Passes into textures other than the window, one after the other where a processor draws.

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
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from math import ceil, log2

import moderngl
import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench import tone
from lensbench.app.plots.blur import NONE, Blur


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


TONES = {"none": 0, "filmic": 1, "agx": 2, "raw": 3}
OVERLAYS = {"none": 0, "coc": 1, "peaking": 2, "clipping": 3, "plane": 4}
SOFTENING = 0.35            # radius of the first passes' softening, of the circle of confusion's diameter
SOFTENED_SAMPLES = 16       # from here on the picture is not softened
WHOLE = 0.75                # screen pixels, from which a picture's pixel is drawn without copies: none is skipped
SMALLEST = 1e-4             # screen pixels, for which a picture's pixel has copies
SQUARES = 2.0               # screen pixels: from this size on the picture's pixels are drawn as squares

RGB = np.dtype("V12")       # three float32 that are copied as one

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Development:
    """All that the shaders need with the picture; two equal ones give the same screen."""

    exposure: float = 0.0
    tone: str = "filmic"
    overlay: str = "none"
    blur: Blur = NONE
    stripe: float = 6.0
    amber: Rgb = (0.91, 0.64, 0.24)
    nearer: Rgb = (0.34, 0.71, 0.91)
    farther: Rgb = (0.80, 0.47, 0.65)
    sensor: bool = False        # a sensor recorded it: 1 is saturated, and white
    share: float = 0.0          # of the softening, see `softening`


def softening(samples: int) -> float:
    """The share of the circle of confusion by which a picture of so many samples is softened."""
    return SOFTENING * max(0.0, 1.0 - (samples - 1) / (SOFTENED_SAMPLES - 1.0))


class _Target:
    """A texture that can be drawn into."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int], components: int, dtype: str):
        self.texture = _texture(context, size, components, dtype)
        self.framebuffer = context.framebuffer([self.texture])
        self.copies = 0                         # half as large each as the one before


class Screen:
    """Holds the textures of one picture in one GL context (3.3 core or later)."""

    def __init__(self, context: moderngl.Context, sharing: "Screen | None" = None):
        """sharing: another screen of the context, whose shaders it shares; a processor that draws holds 1.6 MB each."""
        self._context = context
        self._programs: dict[tuple[str, ...], moderngl.VertexArray] = {} if sharing is None else sharing._programs
        self._picture: moderngl.Texture | None = None
        self._texels = np.zeros((0, 0, 4), np.float32)      # of the picture, on their way,
        self._colours = np.zeros(0, RGB)                    # and their first three numbers
        self._depth: NDArray[np.float32] | None = None      # that they hold
        self._blur: moderngl.Texture | None = None
        self._blur_of: Blur | None = None
        self._soft: _Target | None = None
        self._shown: _Target | None = None
        self._apart: _Target | None = None
        self._done: Development | None = None
        self._loaded = 0                        # pictures so far
        self._apart_of: tuple = ()              # the pair of pictures of the difference

    @property
    def size(self) -> tuple[int, int]:
        """Pixels across and down; (0, 0) before the first picture."""
        return (0, 0) if self._picture is None else self._picture.size

    def load(self, image: NDArray[np.float32], depth: NDArray[np.float32] | None = None) -> None:
        """Take a linear picture (h, w, 3), and how far before the film its pixels look (mm): of any size, NaN is dark.

        Without a depth everything is infinitely far.
        """
        height, width = image.shape[:2]
        if self._picture is None or self._picture.size != (width, height):
            self._release()
            self._picture = _texture(self._context, (width, height), 4)
            self._soft = _Target(self._context, (width, height), 4, "f4")
            self._shown = _Target(self._context, (width, height), 4, "f1")
            self._texels = np.full((height, width, 4), np.inf, np.float32)
            self._colours = np.ndarray(height * width, RGB, self._texels, strides=4 * self._texels.itemsize)
            self._depth = None
        self._colours[:] = np.ascontiguousarray(image, np.float32).reshape(-1, 3).view(RGB)[:, 0]
        if depth is not self._depth:
            self._texels[..., 3] = np.inf if depth is None else np.nan_to_num(_resized(depth, (height, width)),
                                                                               nan=np.inf, posinf=np.inf)
            self._depth = depth
        self._picture.write(self._texels)
        self._loaded += 1
        self._done = None

    def developed(self, development: Development) -> int:
        """The GL name of a texture with the developed picture; 0 before the first picture. Draws on a change."""
        if self._picture is None or self._soft is None or self._shown is None:
            return 0
        if development != self._done:
            source = self._picture
            self._load_blur(development.blur)
            inserted = shader_source("blur.frag")
            if development.share > 0.0 and development.blur.blurs:
                self._draw(self._program("soften.frag", inserted), self._soft, source, blur=3, share=development.share)
                source = self._soft.texture
            develop = self._program("develop.frag", inserted, f"#define TONE {TONES[development.tone]}\n",
                                    f"#define OVERLAY {OVERLAYS[development.overlay]}\n",
                                    f"#define SENSOR {int(development.sensor)}\n", tone.glsl_constants())
            self._draw(develop, self._shown, source, gain=2.0 ** development.exposure,
                       headroom=tone.HEADROOM[development.tone],
                       blur=3, sharp=max(development.blur.sharp, 1.0), stripe=development.stripe,
                       amber=development.amber, nearer=development.nearer, farther=development.farther)
            self._done = replace(development)
        return self._shown.texture.glo

    def _load_blur(self, blur: Blur) -> None:
        """Put the nodes of a blur into texture unit 3."""
        if self._blur is None or self._blur_of is not blur:
            rows, columns = blur.nodes.shape[:2]
            if self._blur is None or self._blur.size != (columns, rows):
                if self._blur is not None:
                    self._blur.release()
                self._blur = _texture(self._context, (columns, rows), 3)
            self._blur.write(np.ascontiguousarray(blur.nodes, np.float32))
            self._blur_of = blur
        self._blur.use(3)

    def apart(self, other: "Screen", scale: float) -> int:
        """The GL name of a texture with the difference from another picture of the same size; `scale` is shown white.

        0 before there are two such pictures.
        """
        if self._picture is None or other._picture is None or self.size != other.size:
            return 0
        of = (self._loaded, other, other._loaded, scale)
        if self._apart is not None and self._apart_of == of:
            return self._apart.texture.glo
        self._apart = self._apart or _Target(self._context, self.size, 4, "f1")
        self._apart_of = of
        other._picture.use(2)
        self._draw(self._program("difference.frag"), self._apart, self._picture, other=2, gain=1.0 / scale)
        return self._apart.texture.glo

    @property
    def shown(self) -> tuple[moderngl.Texture, tuple] | None:
        """The texture of the developed picture, and a key of its content; None before the first picture."""
        return None if self._shown is None else (self._shown.texture, (self._loaded, self._done))

    def read(self) -> NDArray[np.uint8]:
        """The developed picture (h, w, 3)."""
        return self._read(self._shown)

    def read_apart(self) -> NDArray[np.uint8]:
        """The difference as shown (h, w, 3)."""
        return self._read(self._apart)

    @staticmethod
    def _read(target: _Target | None) -> NDArray[np.uint8]:
        if target is None:
            raise ValueError("nothing has been drawn yet")
        width, height = target.texture.size
        pixels = target.framebuffer.read(components=3, alignment=1)
        return np.frombuffer(pixels, np.uint8).reshape(height, width, 3)

    def draw_at(self, scale: float) -> None:
        """Draw each pixel of the picture with this many screen pixels: as squares if far enlarged."""
        above = moderngl.NEAREST if scale >= SQUARES else moderngl.LINEAR
        copies = 0 if scale >= WHOLE else ceil(-log2(max(scale, SMALLEST)))
        for target in (self._shown, self._apart):
            if target is None:
                continue
            if copies > target.copies:
                target.texture.build_mipmaps(0, copies)         # no more: each takes a processor that draws 0.5 ms
                target.copies = copies
            target.texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR if copies else moderngl.LINEAR, above)

    def _program(self, name: str, *inserted: str) -> moderngl.VertexArray:
        """A compiled shader of the package, with lines inserted after its version; made once."""
        key = (name, *inserted)
        if key not in self._programs:
            source = shader_source(name).replace("#version 330\n", "#version 330\n" + "".join(inserted), 1)
            self._programs[key] = self._context.vertex_array(
                self._context.program(shader_source("triangle.vert"), source), [])
        return self._programs[key]

    def _draw(self, array: moderngl.VertexArray, target: _Target, source: moderngl.Texture, **uniforms) -> None:
        target.copies = 0
        program = array.program
        for name, value in {"picture": 0, **uniforms}.items():
            uniform = program.get(name, None)
            if isinstance(uniform, moderngl.Uniform):
                uniform.value = value
        with drawn_into(self._context, target.framebuffer):
            self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
            source.use(0)
            array.render(moderngl.TRIANGLES, vertices=3)

    def _release(self) -> None:
        if self._picture is not None:
            self._picture.release()
        for target in (self._soft, self._shown, self._apart):
            if target is not None:
                target.texture.release()
                target.framebuffer.release()
        self._apart = None


def _resized(depth: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    """A depth map of another size, by the nearest pixels."""
    rows, columns = ((2 * np.arange(n) + 1) * m // (2 * n) for n, m in zip(shape, depth.shape, strict=True))
    return depth if depth.shape == shape else depth[np.ix_(rows, columns)]


@cache
def shader_source(name: str) -> str:
    """The text of a shader of the package."""
    return files("lensbench.shaders").joinpath(name).read_text(encoding="utf-8")


def _texture(context: moderngl.Context, size: tuple[int, int], components: int, dtype: str = "f4") -> moderngl.Texture:
    texture = context.texture(size, components, dtype=dtype)
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture
