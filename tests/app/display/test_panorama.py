"""The shader that looks around in a panorama, against the same look in numpy."""

import moderngl
import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.pose import LookAround
from lensbench.app.display.gl_texture import Development, Screen
from lensbench.app.display.small_textures import Panorama

SHAPES = {"equirectangular": (512, 256), "equal-area": (512, 512), "cube-map": (512, 384)}


@pytest.mark.parametrize("layout", SHAPES)
def test_the_shader_shows_the_pixels_that_the_look_points_at(layout):
    context = moderngl.create_context(standalone=True, backend="egl")
    screen, panorama = Screen(context), Panorama(context)
    width, height = SHAPES[layout]
    film = lb.Film(36.0, 36.0 * height / width, width, height)
    image = np.zeros((height, width, 3), np.float32)                # each pixel is coloured by its place
    image[..., 0] = (np.arange(width) + 0.5) / width
    image[..., 1] = ((np.arange(height) + 0.5) / height)[:, None]
    screen.load(image)
    screen.developed(Development(tone="raw"))
    size, look = (48, 32), LookAround(2.3, 0.5, 1.9)
    panorama.picture(*screen.shown, layout, look, size)
    shown = np.frombuffer(panorama._framebuffer.read(components=3, alignment=1), np.uint8).reshape(32, 48, 3) / 255.0
    expected = np.array([[look.raster(((x + 0.5) / 48, (y + 0.5) / 32), size, film, layout) for x in range(48)]
                         for y in range(32)]) / [width, height]
    off = np.abs(shown[..., :2] - expected).max(2)
    # but for pixels beside a seam of the layout, where two ends of the picture meet
    assert np.quantile(off, 0.97) <= 1.5 / 255.0
    assert np.ptp(shown[..., 0]) > 0.2
    context.release()
