"""Textures, buffers, renderbuffers and framebuffers that stay on the graphics card, as OpenGL itself counts them."""

import ctypes

import moderngl
import numpy as np
import pytest

from lensbench.app.bench.pose import LookAround
from lensbench.app.display import small_textures
from lensbench.app.display.gl_texture import Development, Screen
from lensbench.app.display.small_textures import MapPictures, Panorama, SmallTextures
from lensbench.app.display.solid_view import MOST_KEPT, Drawing, Line, Solid, SolidView
from lensbench.app.plots.blur import Blur
from lensbench.app.plots.solids import Eye, Part, Strokes

KINDS = "Texture", "Buffer", "Renderbuffer", "Framebuffer", "VertexArray", "Program"
NAMES = 500             # more than these tests ever have of a kind
SIZES = [(40 + 3 * i, 30 + 2 * i) for i in range(8)]
STILL = tuple(np.eye(4).ravel().tolist())


@pytest.fixture
def context():
    made = moderngl.create_context(standalone=True, backend="egl")
    yield made
    made.release()


def alive() -> dict[str, int]:
    """Objects of each kind in the current context."""
    find = ctypes.CDLL("libEGL.so.1").eglGetProcAddress
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    counts = {}
    for kind in KINDS:
        is_one = ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(find(f"glIs{kind}".encode()))
        counts[kind] = sum(is_one(name) != 0 for name in range(1, NAMES))
    return counts


def part(triangles: int = 1) -> Part:
    points = np.tile([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [0.0, 5.0, 0.0]], (triangles, 1))
    return Part("thing", points, np.tile([0.0, 0.0, 1.0], (len(points), 1)))


def solid_drawing(*parts: Part) -> Drawing:
    lines = (Line(Strokes("edge", np.zeros((2, 2, 3))), (1.0, 1.0, 1.0, 1.0), 1.0),)
    return Drawing(Eye(), STILL, tuple(Solid(shape, (0.9, 0.9, 0.9, 1.0)) for shape in parts), lines, (0.0,) * 4)


def test_a_3d_view_of_another_size_leaves_nothing_of_the_last_one(context):
    view, drawing = SolidView(context), solid_drawing(part())
    view.picture(drawing, (32, 24))
    first = alive()
    assert first["Renderbuffer"] == 2 and first["Texture"] >= 1
    for size in SIZES:
        view.picture(drawing, size)
    assert alive() == first


def test_a_3d_view_forgets_large_parts_that_it_no_longer_draws(context):
    view, triangles = SolidView(context), MOST_KEPT // (3 * 24) // 3
    view.picture(solid_drawing(part(triangles)), (32, 24))
    first = alive()["Buffer"]
    for _ in range(10):
        view.picture(solid_drawing(part(triangles)), (32, 24))
    assert alive()["Buffer"] <= first + 2 * 4           # parts and lines of what fits


def test_pictures_of_another_size_leave_nothing_of_the_last_one(context):
    screen, other = Screen(context), Screen(context)

    def show(width: int, height: int) -> None:
        for drawn in (screen, other):
            drawn.load(np.full((height, width, 3), 0.2, np.float32))
            drawn.developed(Development(blur=Blur.even(1.0, 0.0), share=0.3))
        screen.apart(other, 0.5)
        screen.draw_at(0.5)

    show(32, 24)
    first = alive()
    for size in SIZES:
        show(*size)
    assert alive() == first


def test_a_look_around_of_another_size_leaves_nothing_of_the_last_one(context):
    panorama, source = Panorama(context), context.texture((8, 4), 4)
    panorama.picture(source, 0, "equirectangular", LookAround(0.0, 0.0, 1.5), (32, 24))
    first = alive()
    for size in SIZES:
        panorama.picture(source, 0, "equirectangular", LookAround(0.0, 0.0, 1.5), size)
    assert alive() == first


def test_a_small_picture_that_changes_or_goes_leaves_no_texture(context):
    pictures = {"a": np.zeros((4, 6, 3), np.uint8)}
    textures, before = SmallTextures(pictures), alive()
    assert textures.of("a")
    for _ in range(5):
        pictures["a"] = np.zeros((4, 6, 3), np.uint8)
        textures.of("a")
    assert alive()["Texture"] == before["Texture"] + 1
    del pictures["a"]
    assert textures.of("a") is None and alive() == before


def test_textures_of_pictures_that_are_gone_or_no_longer_shown_are_released_but_none_of_the_last_frame(
        context, monkeypatch):
    monkeypatch.setattr(small_textures, "MOST_KEPT", 3 * 4 * 24)        # three of these
    pictures = {name: np.zeros((4, 6, 3), np.uint8) for name in "abcdefgh"}
    textures, before = SmallTextures(pictures), alive()["Texture"]

    def frame(names: str) -> int:
        textures.begin_frame()
        for name in names:
            textures.of(name)
        return alive()["Texture"] - before

    assert frame("abcde") == 5                          # more than may stay, but all are shown
    first = textures.of("d")
    assert frame("abcde") == 5
    assert frame("df") == 6
    assert frame("") == 3 and textures.of("d") == first     # of f, d and the last of the others
    pictures.clear()
    assert frame("") == 0


def test_a_map_that_the_last_frame_did_not_draw_leaves_no_texture(context):
    maps, before = MapPictures(), alive()["Texture"]
    picture, other = np.zeros((4, 6, 4), np.uint8), np.ones((4, 6, 4), np.uint8)

    def frame(**drawn) -> list[int]:
        maps.begin_frame()
        return [maps.texture(name, picture) for name, picture in drawn.items()]

    first = frame(a=picture, b=picture)
    assert alive()["Texture"] - before == 2 and frame(a=picture, b=picture) == first
    for second in (other, picture, other):
        frame(a=second, b=picture)
    assert alive()["Texture"] - before == 2
    frame(b=picture)
    frame(b=picture)
    assert alive()["Texture"] - before == 1 and frame(b=picture) == first[1:]
    frame()
    frame()
    assert alive()["Texture"] == before
