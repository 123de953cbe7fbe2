"""PPM and PFM, byte by byte as their specifications have them."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings as profile, strategies as st

from lensbench.app.session.export import ExportError, develop, read_settings, save_picture
from lensbench.app.settings.settings import Settings

PLAIN = replace(Settings(), tone="none", exposure=1.0)


def picture(height=5, width=7):
    return np.random.default_rng(1).uniform(0.0, 0.7, (height, width, 3)).astype(np.float32)


def parts(path):
    """The words of a PPM's header, without comments, and what follows the one blank after them."""
    data, at, words = path.read_bytes(), 0, []
    while len(words) < 4:
        end = data.index(b"\n", at)
        words += [] if data[at:at + 1] == b"#" else data[at:end].split()
        at = end + 1
    return words, data[at:]


@given(st.integers(1, 9), st.integers(1, 9), st.sampled_from([8, 16]), st.booleans())
@profile(max_examples=30)
def test_a_ppm_holds_the_developed_codes_row_by_row_from_the_top(tmp_path_factory, height, width, bits, text):
    path, image, deepest = tmp_path_factory.mktemp("ppm") / "a.ppm", picture(height, width), 2**bits - 1
    save_picture(path, image, PLAIN, bits, text)
    (kind, *size), body = parts(path)
    assert [int(word) for word in size] == [width, height, deepest]
    if text:
        assert kind == b"P3" and all(len(line) <= 70 for line in body.split(b"\n"))
        numbers = [int(word) for word in body.split()]
    else:
        assert kind == b"P6" and len(body) == height * width * 3 * bits // 8
        numbers = struct.unpack(f">{height * width * 3}{'B' if bits == 8 else 'H'}", body)
    expected = np.rint(develop(image, PLAIN) * deepest).astype(int)
    np.testing.assert_array_equal(np.reshape(numbers, (height, width, 3)), expected)


def test_sixteen_bits_of_a_ppm_stand_high_byte_first(tmp_path):
    save_picture(tmp_path / "a.ppm", np.zeros((1, 1, 3), np.float32) + [0.0, 1e9, 0.0], replace(PLAIN, tone="none"), 16)
    assert parts(tmp_path / "a.ppm")[1] == b"\x00\x00\xff\xff\x00\x00"
    grey = np.full((1, 1, 3), 0.0313308 / 12.92 / 257 / 2, np.float32)          # on the straight part of sRGB: code 8
    save_picture(tmp_path / "a.ppm", grey, PLAIN, 16)
    assert parts(tmp_path / "a.ppm")[1] == b"\x00\x08" * 3


def test_a_pfm_holds_the_light_in_floats_of_low_byte_first_from_the_bottom_row(tmp_path):
    image = picture(3, 2)
    image[0, 0] = (-1.5, np.inf, 1e-20)
    save_picture(tmp_path / "a.pfm", image, PLAIN)
    head, size, order, body = (tmp_path / "a.pfm").read_bytes().split(b"\n", 3)
    assert (head, size, order) == (b"PF", b"2 3", b"-1.0")
    numbers = struct.unpack("<18f", body)
    np.testing.assert_array_equal(np.reshape(numbers, (3, 2, 3))[::-1], image)
    np.testing.assert_array_equal(numbers[:3], image[2, 0])


def test_a_ppm_carries_its_settings_as_a_comment_and_a_pfm_does_not(tmp_path):
    for text in (False, True):
        save_picture(tmp_path / "a.ppm", picture(), PLAIN, text=text)
        assert read_settings(tmp_path / "a.ppm") == PLAIN
    save_picture(tmp_path / "a.pfm", picture(), PLAIN)
    with pytest.raises(ExportError, match="neither"):
        read_settings(tmp_path / "a.pfm")
    (tmp_path / "a.ppm").write_bytes(b"P6\n# by hand\n1 1\n255\nabc")
    with pytest.raises(ExportError, match="not exported by lensbench"):
        read_settings(tmp_path / "a.ppm")


def test_only_a_ppm_is_written_as_text(tmp_path):
    with pytest.raises(ExportError, match=r"only a \.ppm"):
        save_picture(tmp_path / "a.png", picture(), PLAIN, text=True)
    with pytest.raises(ExportError, match=r"\.png.*\.ppm.*\.exr.*\.pfm"):
        save_picture(tmp_path / "a.bmp", picture(), PLAIN)
