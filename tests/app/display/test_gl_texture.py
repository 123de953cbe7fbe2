"""The shaders against their numpy twin, and what each overlay promises."""

import moderngl
import numpy as np
import pytest

from lensbench.app.bench import tone
from lensbench.app.display.gl_texture import Development, Screen, softening
from lensbench.app.plots.blur import Blur

AMBER = (0.91, 0.64, 0.24)


@pytest.fixture(scope="module")
def screen():
    context = moderngl.create_context(standalone=True, backend="egl")
    yield Screen(context)
    context.release()


def ramp(width=256, height=32):
    """From ten stops below middle grey to seven above, in a grey, a red and a mixed band."""
    light = 0.18 * 2.0 ** np.linspace(-10.0, 7.0, width)
    image = np.zeros((height, width, 3), np.float32)
    image[:] = light[None, :, None]
    image[height // 3:] *= (1.0, 0.2, 0.05)
    image[2 * height // 3:] *= (0.0, 1.0, 1.0)
    return image


@pytest.mark.parametrize("curve", ["none", "filmic", "agx", "raw"])
@pytest.mark.parametrize(("exposure", "sensor"), [(-2.0, False), (0.0, False), (1.5, False), (0.0, True), (-1.0, True)])
def test_the_shader_develops_as_numpy_does(screen, curve, exposure, sensor):
    image = np.minimum(ramp(), 1.0) if sensor else ramp()
    screen.load(image)
    assert screen.developed(Development(exposure=exposure, tone=curve, sensor=sensor)) > 0
    expected = tone.develop(image, exposure, curve, sensor) * 255.0
    # half a step of rounding, and the half-step of pow in single precision
    assert np.abs(screen.read() - expected).max() <= 1.0


@pytest.mark.parametrize("curve", ["none", "filmic", "agx"])
def test_every_curve_keeps_middle_grey_and_rises(curve):
    light = 0.18 * 2.0 ** np.linspace(-9.0, 6.0, 200)
    shown = tone.develop(np.repeat(light[:, None], 3, 1), 0.0, curve)[:, 0]
    assert np.all(np.diff(shown) >= 0.0)
    assert tone.develop(np.full(3, 0.18), 0.0, curve)[0] == pytest.approx(tone.srgb(np.float64(0.18)), abs=1e-9)


def test_the_first_row_stays_the_first(screen):
    image = np.zeros((4, 6, 3), np.float32)
    image[0] = 1.0
    screen.load(image)
    screen.developed(Development(tone="none"))
    rows = screen.read()[:, 0, 0]
    assert rows[0] == 255 and rows[1:].max() == 0


def test_an_infinite_or_negative_light_is_shown_as_white_or_black(screen):
    image = np.zeros((4, 4, 3), np.float32)
    image[0], image[1] = np.inf, -1.0
    screen.load(image)
    screen.developed(Development(tone="none"))
    shown = screen.read()
    assert shown[0].min() == 255 and shown[1].max() == 0


def test_what_is_in_focus_is_amber_and_the_sides_of_it_differ(screen):
    image = np.full((1, 3, 3), 0.5, np.float32)
    screen.load(image, np.array([[600.0, 1100.0, np.inf]], np.float32))
    screen.developed(Development(overlay="coc", blur=Blur.even(20_000.0, 1 / 1000.0, 100.0)))
    near, sharp, far = screen.read()[0].astype(float)
    assert sharp[0] > sharp[1] > sharp[2]
    assert near[2] > near[0] and far[0] > far[1]


def test_the_plane_of_focus_veils_what_lies_behind_it_and_lines_where_it_cuts(screen):
    """A ground that recedes: untouched in front, a line at the plane, denser within the limits than beyond."""
    depth = np.linspace(800.0, 1400.0, 61, dtype=np.float32)
    screen.load(np.full((61, 5, 3), 0.18, np.float32), np.repeat(depth[:, None], 5, 1))
    blur = Blur.even(20_000.0, 1 / 1000.0, sharp=2.0)               # sharp from 909 to 1111 mm
    screen.developed(Development(overlay="plane", blur=blur, tone="none"))
    rows = screen.read()[:, 2].astype(int)
    at = {row: rows[int(np.abs(depth - row).argmin())] for row in (820.0, 950.0, 1000.0, 1050.0, 1350.0)}
    warm = {row: value[0] - value[2] for row, value in at.items()}
    assert warm[820.0] == 0 and warm[950.0] == warm[1050.0] > warm[1350.0] > 0
    assert at[1000.0].sum() > at[950.0].sum() + 100


def test_peaking_marks_an_edge_in_focus_and_not_one_out_of_focus(screen):
    image = np.full((8, 16, 3), 0.1, np.float32)
    image[:, 8:] = 0.6
    for distance, marked in ((1000.0, True), (300.0, False)):
        screen.load(image, np.full((8, 16), distance, np.float32))
        screen.developed(Development(overlay="peaking", blur=Blur.even(20_000.0, 1 / 1000.0)))
        edge = screen.read()[4, 8].astype(float) / 255.0
        assert bool(np.abs(edge - AMBER).max() < 0.02) is marked


def test_the_zebra_covers_the_clipped_and_nothing_else(screen):
    image = np.full((40, 40, 3), 0.18, np.float32)
    image[:20] = 100.0
    screen.load(image)
    screen.developed(Development(overlay="clipping", tone="none"))
    shown = screen.read().astype(int)
    striped = np.ptp(shown, axis=2) > 20
    assert 0.3 < striped[:20].mean() < 0.7 and not striped[20:].any()


def test_softening_keeps_a_plane_in_focus_as_it_is_and_fades_with_the_samples(screen):
    generator = np.random.default_rng(1)
    image = generator.random((32, 32, 3), np.float32)
    screen.load(image, np.full((32, 32), 1000.0, np.float32))
    setting = {"tone": "none", "blur": Blur.even(20_000.0, 1 / 1000.0)}
    screen.developed(Development(**setting))
    plain = screen.read().astype(int)
    screen.developed(Development(**setting, share=softening(1)))
    assert np.abs(screen.read().astype(int) - plain).max() <= 1
    screen.load(image, np.full((32, 32), 500.0, np.float32))
    screen.developed(Development(**setting, share=softening(1)))
    soft = screen.read()[8:24, 8:24]
    assert soft.std() < 0.5 * plain[8:24, 8:24].std()
    assert softening(1) == 0.35 and softening(16) == 0.0 and softening(400) == 0.0


@pytest.mark.parametrize("overlay", ["coc", "peaking", "plane"])
def test_the_sky_and_the_dark_count_as_infinitely_far_and_a_map_of_another_size_is_spread(screen, overlay):
    image = np.random.default_rng(2).random((6, 8, 3), np.float32)
    shown = []
    for depth in (np.array([[1000.0, np.inf], [-5.0, np.nan]], np.float32),
                  np.array([[1000.0, 1e12], [0.0, 1e12]], np.float32).repeat(3, 0).repeat(4, 1)):
        screen.load(image, depth)
        screen.developed(Development(overlay=overlay, blur=Blur.even(20_000.0, 1 / 1000.0), share=softening(1)))
        shown.append(screen.read().copy())
    assert (shown[0] == shown[1]).all() and np.ptp(shown[0]) > 50


@pytest.mark.parametrize("scale", [1.5, 1.0, 0.75])
def test_a_picture_of_about_its_own_size_has_no_copies(screen, scale):
    screen.load(np.full((48, 64, 3), 0.3, np.float32))
    screen.developed(Development())
    screen.draw_at(scale)
    texture, _ = screen.shown
    assert texture.filter == (moderngl.LINEAR, moderngl.LINEAR)
    with pytest.raises(moderngl.Error):
        texture.read(level=1)


@pytest.mark.parametrize("scale", [0.74, 0.5, 0.3, 0.1])
def test_a_picture_drawn_smaller_has_the_copies_that_its_scale_reads(screen, scale):
    level = int(np.ceil(-np.log2(scale)))
    for shade in (0.3, 0.6):                            # the second picture has copies of its own
        screen.load(np.random.default_rng(1).random((48, 64, 3), np.float32) * np.float32(shade))
        screen.developed(Development())
        screen.draw_at(scale)
        texture, _ = screen.shown
        made = np.frombuffer(texture.read(level=level), np.uint8)
        texture.build_mipmaps()                         # all of them
        assert np.array_equal(made, np.frombuffer(texture.read(level=level), np.uint8))
        assert len(made) == 4 * (48 >> level) * (64 >> level) and made.reshape(-1, 4)[:, :3].std() > 1.0
