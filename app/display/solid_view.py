"""The 3-D view on the graphics card: solid parts with a depth test, translucent ones over them, lines of any width.

Uses moderngl, and no part of the window. The texture's first row is the lowest, as OpenGL has it.
"""

from dataclasses import dataclass

import moderngl
import numpy as np

from lensbench.app.display.gl_texture import drawn_into, shader_source
from lensbench.app.plots.solids import Eye, Part, Strokes

Rgba = tuple[float, float, float, float]
SAMPLES = 4                     # of each pixel, against jagged edges
LIGHT = np.array([0.35, 0.55, 0.76]) / np.linalg.norm([0.35, 0.55, 0.76])     # towards the light: right, up, back
SLACK = 64                      # buffers that are kept beyond those that are drawn,
MOST_KEPT = 4 << 20             # and their bytes


@dataclass(frozen=True)
class Solid:
    """A part with its colour on the screen.

    rim: opacity added where the surface is seen at a grazing angle. of_world: its points are in the world's frame.
    """

    part: Part
    tint: Rgba
    rim: float = 0.0
    of_world: bool = False


@dataclass(frozen=True)
class Line:
    """Strokes with their colour on the screen and their width in pixels; of_world: in the world's frame."""

    strokes: Strokes
    tint: Rgba
    width: float
    of_world: bool = False


@dataclass(frozen=True)
class Drawing:
    """Everything that the view shows; two equal ones give the same picture.

    pose: of the camera in the world, world_from_camera (4, 4) row by row.
    """

    eye: Eye
    pose: tuple[float, ...]
    solids: tuple[Solid, ...]
    lines: tuple[Line, ...]
    ground: Rgba


class SolidView:
    """Draws in one GL context (3.3 core or later) into a texture of its own."""

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._solid = context.program(shader_source("solid.vert"), shader_source("solid.frag"))
        self._stroke = context.program(shader_source("stroke.vert"), shader_source("stroke.frag"))
        self._arrays: dict[Part | Strokes, tuple[moderngl.VertexArray, moderngl.Buffer]] = {}
        self._texture: moderngl.Texture | None = None
        self._samples: tuple[moderngl.Renderbuffer, ...] = ()   # several a pixel: colours, depth
        self._drawn: moderngl.Framebuffer | None = None         # into these samples
        self._resolved: moderngl.Framebuffer | None = None
        self._done: Drawing | None = None
        self._frames: dict[bool, tuple] = {}    # of the camera and of the world: matrix, eye and light

    def picture(self, drawing: Drawing, size: tuple[int, int]) -> int:
        """The GL name of a texture with the drawing, of this size in pixels. Draws on a change."""
        size = max(size[0], 1), max(size[1], 1)
        if self._texture is None or self._texture.size != size:
            self._resize(size)
        if drawing != self._done:
            assert self._drawn is not None
            with drawn_into(self._context, self._drawn):
                self._draw(drawing, size)
            self._forget(drawing)
            self._done = drawing
        assert self._texture is not None
        return self._texture.glo

    def read(self) -> np.ndarray:
        """The picture (h, w, 3), the upper row first."""
        assert self._resolved is not None and self._texture is not None
        width, height = self._texture.size
        pixels = np.frombuffer(self._resolved.read(components=3, alignment=1), np.uint8)
        return pixels.reshape(height, width, 3)[::-1]

    def _resize(self, size: tuple[int, int]) -> None:
        context = self._context
        for thing in (self._drawn, self._resolved, self._texture, *self._samples):
            if thing is not None:
                thing.release()
        samples = min(SAMPLES, context.max_samples)
        self._samples = (context.renderbuffer(size, 4, samples=samples),
                         context.depth_renderbuffer(size, samples=samples))
        self._texture = context.texture(size, 4)
        self._texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._drawn = context.framebuffer(self._samples[:1], self._samples[1])
        self._resolved = context.framebuffer([self._texture])
        self._done = None

    def _draw(self, drawing: Drawing, size: tuple[int, int]) -> None:
        assert self._drawn is not None and self._resolved is not None
        context, eye = self._context, drawing.eye
        self._drawn.clear(*drawing.ground, depth=1.0)
        clip, world = eye.clip_from_camera(*size), np.reshape(drawing.pose, (4, 4))
        light = eye.axes.T @ LIGHT
        self._frames = {of_world: (np.ascontiguousarray((clip @ np.linalg.inv(frame)).T, "f4").tobytes(),
                                   tuple(frame[:3, :3] @ eye.place + frame[:3, 3]), tuple(frame[:3, :3] @ light))
                        for of_world, frame in ((False, np.eye(4)), (True, world))}
        _uniform(self._stroke, "size").value = size
        context.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        context.disable(moderngl.CULL_FACE)
        context.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA

        # Opaque parts, then lines, then translucent parts, which hide nothing behind them
        for solid in drawing.solids:
            if solid.tint[3] >= 1.0:
                self._draw_solid(solid)
        for line in drawing.lines:
            self._draw_line(line)
        self._drawn.depth_mask = False
        for solid in sorted((solid for solid in drawing.solids if solid.tint[3] < 1.0),
                            key=lambda solid: -self._away(solid)):
            self._draw_solid(solid)
        self._drawn.depth_mask = True
        context.copy_framebuffer(self._resolved, self._drawn)
        context.disable(moderngl.DEPTH_TEST)

    def _away(self, solid: Solid) -> float:
        """Distance (mm) from the eye to the middle of a part, which orders translucent parts."""
        points = solid.part.points
        return float(np.linalg.norm(points.mean(0) - self._frames[solid.of_world][1])) if len(points) else 0.0

    def _draw_solid(self, solid: Solid) -> None:
        shape = solid.part
        if not len(shape.points):
            return
        if shape not in self._arrays:
            data = np.hstack([shape.points, shape.normals]).astype("f4")
            buffer = self._context.buffer(data.tobytes())
            layout = [(buffer, "3f 3f", "point", "normal")]
            self._arrays[shape] = self._context.vertex_array(self._solid, layout), buffer
        matrix, eye, light = self._frames[solid.of_world]
        _uniform(self._solid, "clip_from_local").write(matrix)
        for name, value in (("eye", eye), ("light", light), ("tint", solid.tint), ("rim", solid.rim)):
            _uniform(self._solid, name).value = value
        self._arrays[shape][0].render(moderngl.TRIANGLES)

    def _draw_line(self, line: Line) -> None:
        pieces = line.strokes.pieces
        if not len(pieces):
            return
        if line.strokes not in self._arrays:
            buffer = self._context.buffer(pieces.reshape(len(pieces), 6).astype("f4").tobytes())
            self._arrays[line.strokes] = self._context.vertex_array(
                self._stroke, [(buffer, "3f 3f /i", "begin", "end")]), buffer
        _uniform(self._stroke, "clip_from_local").write(self._frames[line.of_world][0])
        _uniform(self._stroke, "tint").value, _uniform(self._stroke, "width").value = line.tint, line.width
        self._arrays[line.strokes][0].render(moderngl.TRIANGLE_STRIP, vertices=4, instances=len(pieces))

    def _forget(self, drawing: Drawing) -> None:
        """Release the oldest buffers that are no longer drawn while there are too many or too large ones."""
        drawn = {solid.part for solid in drawing.solids} | {line.strokes for line in drawing.lines}
        idle = {thing: buffer.size for thing, (_, buffer) in self._arrays.items() if thing not in drawn}
        number, size = len(idle), sum(idle.values())
        for thing, released in idle.items():
            if number <= SLACK and size <= MOST_KEPT:
                return
            array, buffer = self._arrays.pop(thing)
            array.release()
            buffer.release()
            number, size = number - 1, size - released


def _uniform(program: moderngl.Program, name: str) -> moderngl.Uniform:
    """A parameter of a shader."""
    uniform = program[name]
    assert isinstance(uniform, moderngl.Uniform)
    return uniform
