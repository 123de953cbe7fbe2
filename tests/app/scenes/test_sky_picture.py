"""Pictures of the sky from files: Radiance's format against an encoder of its own, OpenEXR, and damaged files."""

import math

import numpy as np
import OpenEXR
import pytest

import lensbench as lb
from lensbench.app.scenes import sky_picture
from lensbench.app.scenes.scene_file import load_scene
from lensbench.app.scenes.sky_picture import HdrError, read_hdr, read_sky

SILENT = [].append
HEAD = b"#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"


def rgbe(values):
    mantissa, exponent = np.frexp(values.max(-1))
    scale = np.where(values.max(-1) > 1e-32, np.ldexp(256.0, -exponent), 0.0)[..., None]
    found = np.concatenate([values * scale, (exponent + 128)[..., None]], -1).astype(np.uint8)
    found[values.max(-1) <= 1e-32] = 0
    return found


def coded(pixels):
    """Rows in runs: of three equal bytes or more, else literal."""
    out = bytearray()
    for row in pixels:
        out += bytes([2, 2, len(row) >> 8, len(row) & 255])
        for component in row.T:
            at = 0
            while at < len(component):
                run = 1
                while at + run < len(component) and component[at + run] == component[at] and run < 127:
                    run += 1
                out += bytes([128 + run, component[at]]) if run > 2 else bytes([1, component[at]])
                at += run if run > 2 else 1
    return bytes(out)


@pytest.fixture(scope="module")
def values():
    random = np.random.default_rng(7)
    found = random.uniform(0.0, 1.0, (20, 40, 3)) * 10.0 ** random.uniform(-3, 4, (20, 40, 1))
    found[5:9] = (0.5, 0.25, 0.125)
    found[0, 0] = 0.0
    return found


@pytest.mark.parametrize("encode", [coded, lambda pixels: pixels.tobytes()])
def test_a_radiance_picture_is_read_to_its_last_bit(tmp_path, values, encode):
    pixels = rgbe(values)
    (tmp_path / "a.hdr").write_bytes(HEAD % (20, 40) + encode(pixels))
    found = read_hdr(tmp_path / "a.hdr", 1000)
    # the middle of the interval of each mantissa: half a step of 1/128 of the brightest channel at the most
    assert (abs(found - values) <= values.max(-1, keepdims=True) / 250.0).all()
    assert found[5, 3] == pytest.approx((0.5, 0.25, 0.125), abs=0.0021) and not found[0, 0].any()
    assert read_sky("a.hdr", tmp_path, SILENT) == lb.Image.of(found)


@pytest.mark.parametrize(("change", "reason"), [
    (lambda d: d[:-30], "breaks off"), (lambda d: d[:20], "no size"), (lambda d: b"", "does not begin"),
    (lambda d: d.replace(b"-Y 20", b"+Y 20"), "top left"), (lambda d: d.replace(b"-Y 20", b"-Y 99999"), "million"),
    (lambda d: d.replace(b"rgbe", b"xyze"), "XYZ"), (lambda d: d.replace(b"+X 40", b"+X 41"), "breaks off"),
])
def test_a_damaged_radiance_picture_is_said_so(tmp_path, values, change, reason):
    (tmp_path / "a.hdr").write_bytes(change(HEAD % (20, 40) + coded(rgbe(values))))
    with pytest.raises(HdrError, match=reason):
        read_hdr(tmp_path / "a.hdr", 10_000)


def test_open_exr_and_plain_pictures_are_read(tmp_path, values):
    linear = np.ascontiguousarray(values, np.float32)
    OpenEXR.File({}, {"RGB": linear}).write(str(tmp_path / "a.exr"))
    assert read_sky("a.exr", tmp_path, SILENT) == lb.Image.of(linear)
    OpenEXR.File({}, {"Y": np.ascontiguousarray(linear[..., 0])}).write(str(tmp_path / "grey.exr"))
    assert (read_sky("grey.exr", tmp_path, SILENT).values == linear[..., :1]).all()


def test_bad_skies_are_one_clear_line(tmp_path, values):
    def exr(name, pixels):
        OpenEXR.File({}, {"RGB": np.ascontiguousarray(pixels, np.float32)}).write(str(tmp_path / name))

    exr("nan.exr", np.full((4, 8, 3), np.nan))
    exr("negative.exr", np.full((4, 8, 3), -1.0))
    exr("one.exr", np.ones((1, 1, 3)))
    exr("square.exr", np.ones((8, 8, 3)))
    (tmp_path / "half.exr").write_bytes((tmp_path / "square.exr").read_bytes()[:300])
    (tmp_path / "one.hdr").write_bytes(HEAD % (1, 1) + b"\1\2\3\x80")
    OpenEXR.File({}, {"Z": np.ones((4, 8), np.float32)}).write(str(tmp_path / "depth.exr"))
    (tmp_path / "words.hdr").write_text("no picture")
    for name, reason in {"nan.exr": "no pixel that is positive", "negative.exr": "no pixel that is positive",
                         "one.exr": "smaller than 2",
                         "one.hdr": "smaller than 2", "square.exr": "twice as wide",
                         "half.exr": "not a complete OpenEXR",
                         "depth.exr": "channels 'Z', and neither R", "words.hdr": "no picture of the kinds",
                         "../a.hdr": "there is no such",
                         "none.hdr": "no such file"}.items():
        with pytest.raises(lb.SceneError, match=reason) as caught:
            read_sky(name, tmp_path.resolve(), SILENT)
        assert "\n" not in str(caught.value)


def test_the_size_of_an_open_exr_picture_is_known_before_its_pixels(tmp_path, monkeypatch):
    path = tmp_path / "large.exr"
    noise = np.random.default_rng(3).random((20, 40, 3), np.float32)
    OpenEXR.File({}, {"RGB": noise}).write(str(path))
    path.write_bytes(path.read_bytes()[:-2000])         # reading all of it fails
    monkeypatch.setattr(sky_picture, "MOST_PIXELS", 500)
    with pytest.raises(lb.SceneError, match="million pixels"):
        read_sky("large.exr", tmp_path, SILENT)


def test_pixels_that_are_no_light_are_replaced_and_counted(tmp_path, values):
    linear = np.ascontiguousarray(values, np.float32)
    linear[2, 3] = (-0.01, 0.5, 0.5)                    # a filter rings
    linear[2, 4] = (0.5, -3.0, -4.0)
    linear[7, 1] = (np.inf, 1.0, 1.0)                   # beyond the range of 16 bits
    linear[8, 1] = (np.nan, 1.0, -np.inf)
    OpenEXR.File({}, {"RGB": linear}).write(str(tmp_path / "a.exr"))
    said = []
    found = read_sky("a.exr", tmp_path, said.append).values
    bad = ~(linear >= 0.0) | np.isinf(linear)
    assert (found[~bad] == linear[~bad]).all()
    assert not found[bad & ~(linear > 0.0)].any() and found[7, 1, 0] == linear[~bad].max()
    assert said == ["sky 'a.exr': 2 pixels (0.25 %) are negative and count as 0",
                    "sky 'a.exr': 2 pixels (0.25 %) are not finite and count as 0, or, if infinite, as the brightest "
                    "of the others"]


def test_a_lossy_sky_with_a_small_bright_sun_is_read_and_its_picture_says_what_was_changed(tmp_path):
    light = np.zeros((64, 128, 3), np.float32)
    light[20:23, 60:63] = 3.0
    OpenEXR.File({"compression": OpenEXR.Compression.DWAB_COMPRESSION, "type": OpenEXR.Storage.scanlineimage},
                 {"RGB": light.astype(np.float16)}).write(str(tmp_path / "sun.exr"))
    stored = OpenEXR.File(str(tmp_path / "sun.exr")).channels()["RGB"].pixels
    assert stored.min() < 0.0                           # it does ring, so that this test can fail
    (tmp_path / "a.toml").write_text('[sky]\nimage = "sun.exr"\n')
    scene = load_scene(tmp_path / "a.toml")
    camera = lb.PerspectiveCamera(lb.Film(width=36.0, height=24.0, pixels_x=6, pixels_y=4), math.radians(50))
    rendering = lb.Rendering(camera, scene)
    count = int((stored < 0.0).any(-1).sum())
    assert [each.message for each in rendering.findings] == list(scene.notes)
    assert f"sky 'sun.exr': {count} pixels" in scene.notes[0]
    assert scene.sky.image.values.min() == 0.0
