"""Pictures on disk: what is in them, and that a file of a name is the old one or the new one, whatever happens."""

import json
import math
import os
import resource
import signal
import struct
import subprocess
import sys
import time
import zlib
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings as profile, strategies as st
from PIL import Image

from lensbench.app.session.export import ExportError, develop, read_settings, replacing, save_bands, save_picture
from lensbench.app.settings.settings import VERSION, Settings

SETTINGS = Settings(lens="pbrt-dgauss-50mm", focus_distance=math.inf, f_number=None, position=(1.0, -2.0, 3.5),
                    exposure=0.5, tone="agx")


def picture(height=37, width=53, seed=3):
    return np.random.default_rng(seed).gamma(0.5, 1.0, (height, width, 3)).astype(np.float32)


def pixels_of_png(path):
    """Width, height, bits and (h, w, 3) codes: decoded here with the filter that the file names, row by row."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0]
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", body[:10])
            assert colour == 2
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, -1)
    assert np.all(rows[:, 0] == 2)
    bytes_ = np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8)
    return bits, bytes_.view(">u2" if bits == 16 else np.uint8).reshape(height, width, 3).astype(int)


# What is in a picture


def test_an_8_bit_png_holds_the_developed_picture_to_half_a_code(tmp_path):
    save_picture(tmp_path / "a.png", picture(), SETTINGS)
    with Image.open(tmp_path / "a.png") as read:
        assert read.mode == "RGB"
        codes = np.asarray(read, float)
        assert read.info["Software"].startswith("lensbench")
    assert np.max(np.abs(codes / 255.0 - develop(picture(), SETTINGS))) <= 0.5 / 255.0 + 1e-12


def test_a_16_bit_png_holds_the_developed_picture_to_half_a_code(tmp_path):
    image = picture(height=131)                 # more than two bands of rows
    save_picture(tmp_path / "a.png", image, SETTINGS, bits=16)
    bits, codes = pixels_of_png(tmp_path / "a.png")
    assert bits == 16
    assert np.max(np.abs(codes / 65535.0 - develop(image, SETTINGS))) <= 0.5 / 65535.0 + 1e-12
    with Image.open(tmp_path / "a.png") as read:
        read.load()                             # another reader finds it whole


def test_an_exr_holds_linear_light_as_it_is_from_any_memory_layout(tmp_path):
    image = picture()[::-1].transpose(1, 0, 2)
    save_picture(tmp_path / "a.exr", image, SETTINGS)
    read = OpenEXR.File(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(read.channels()["RGB"].pixels, image)


@pytest.mark.parametrize("name", ["a.png", "a.ppm", "a.exr", "a.pfm"])
@pytest.mark.parametrize("more", [{}, {"noise": True}, {"exposing": "triangle", "noise": True},
                                  {"exposing": "automatic", "noise": True}])
def test_a_picture_that_comes_in_bands_is_written_as_one_that_comes_whole(tmp_path, name, more):
    image, settings = picture(), replace(SETTINGS, **more)
    save_picture(tmp_path / name, image, settings)
    save_bands(tmp_path / f"bands-{name}", image.shape[:2], iter([image[:16], image[16:32], image[32:]]), settings)
    if name in ("a.png", "a.ppm"):
        whole, bands = (np.asarray(Image.open(tmp_path / each), int) for each in (name, f"bands-{name}"))
        step = 1 if settings.noise else 0       # numbers in whole registers and those left over are rounded apart
        assert np.abs(whole - bands).max() <= step and np.mean(whole == bands) > 0.99
    else:
        assert (tmp_path / name).read_bytes() == (tmp_path / f"bands-{name}").read_bytes()


@given(st.integers(1, 9), st.integers(1, 9), st.sampled_from([8, 16]))
@profile(max_examples=20)
def test_every_size_survives_the_way_through_a_png(tmp_path_factory, height, width, bits):
    path = tmp_path_factory.mktemp("png") / "a.png"
    save_picture(path, picture(height, width), SETTINGS, bits)
    _, codes = pixels_of_png(path)
    assert codes.shape == (height, width, 3)


def test_a_picture_with_values_that_are_no_numbers_is_written_black_there(tmp_path):
    image = picture()
    image[3, 4] = np.nan
    image[5, 6] = np.inf
    save_picture(tmp_path / "a.png", image, SETTINGS)
    with Image.open(tmp_path / "a.png") as read:
        assert read.getpixel((4, 3)) == (0, 0, 0)
        assert read.getpixel((6, 5)) == (255, 255, 255)


# Its settings


@pytest.mark.parametrize("name", ["a.png", "a.PNG", "a.exr"])
def test_settings_come_back_from_a_picture_as_they_were(tmp_path, name):
    save_picture(tmp_path / name, picture(), SETTINGS)
    assert read_settings(tmp_path / name) == SETTINGS


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def with_text(path, text):
    """A PNG of one pixel that carries this text as its settings."""
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0))
                     + chunk(b"iTXt", b"lensbench\0\0\0\0\0" + text) + chunk(b"IDAT", zlib.compress(bytes(4)))
                     + chunk(b"IEND", b""))
    return path


def test_a_png_of_another_program_is_said_to_hold_no_settings(tmp_path):
    Image.new("RGB", (8, 8)).save(tmp_path / "other.png")
    with pytest.raises(ExportError, match="not exported by lensbench"):
        read_settings(tmp_path / "other.png")


def test_an_exr_of_another_program_is_said_to_hold_no_settings(tmp_path):
    OpenEXR.File({}, {"RGB": picture()}).write(str(tmp_path / "other.exr"))
    with pytest.raises(ExportError, match="not exported by lensbench"):
        read_settings(tmp_path / "other.exr")


def test_settings_of_a_newer_version_ask_for_an_update(tmp_path):
    newer = json.dumps({**SETTINGS.to_dict(), "version": VERSION + 1, "wavelengths": 9})
    with pytest.raises(ExportError, match="update lensbench"):
        read_settings(with_text(tmp_path / "newer.png", newer.encode()))


@pytest.mark.parametrize("text", [b"", b"{", b"[1, 2]", b"7", b'{"version": "1"}', b'{"version": 1, "lense": "x"}',
                                  b'{"version": 1, "crop": "wide"}', b'{"version": 1, "position": 4}',
                                  b'{"version": 1, "f_number": -2}', b'{"version": 1, "pixels_x": 0}',
                                  b'{"version": 1, "pixels_x": "a"}', b'{"version": 1, "film_width": -36}',
                                  b'{"version": 1, "pixels_x": 1000000, "pixels_y": 1000}',
                                  b'{"version": 1, "seed": -1}', b'{"version": 1, "samples": 1.5}',
                                  b'{"version": 1, "lens": 7}', b"\xff\xfe"])
def test_settings_that_make_no_sense_are_refused_with_the_files_name(tmp_path, text):
    with pytest.raises(ExportError, match="odd.png"):
        read_settings(with_text(tmp_path / "odd.png", text))


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_picture_that_is_cut_off_anywhere_is_refused(tmp_path, name):
    save_picture(tmp_path / name, picture(), SETTINGS)
    whole = (tmp_path / name).read_bytes()
    for end in (0, 3, 8, 20, 60, 200, *((len(whole) // 2, len(whole) - 1) if name == "a.png" else ())):
        (tmp_path / name).write_bytes(whole[:end])
        with pytest.raises(ExportError, match=name):
            read_settings(tmp_path / name)


def test_damaged_settings_are_refused(tmp_path):
    save_picture(tmp_path / "a.png", picture(), SETTINGS)
    (tmp_path / "a.png").write_bytes((tmp_path / "a.png").read_bytes().replace(b'"seed": 0', b'"seed": 8'))
    with pytest.raises(ExportError, match="damaged"):
        read_settings(tmp_path / "a.png")


@pytest.mark.parametrize("content", [None, b"", b"hello", b"\xff\xd8\xff\xe0 a JPEG"])
def test_what_is_no_picture_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "no.png").write_bytes(content)
    with pytest.raises(ExportError, match="no.png"):
        read_settings(tmp_path / "no.png")


# Whole or not at all


def test_another_suffix_is_refused_with_those_that_can_be_written(tmp_path):
    with pytest.raises(ExportError, match=r"\.png.*\.exr"):
        save_picture(tmp_path / "a.jpg", picture(), SETTINGS)


def test_a_depth_other_than_8_and_16_is_refused(tmp_path):
    with pytest.raises(ExportError, match="8 or 16"):
        save_picture(tmp_path / "a.png", picture(), SETTINGS, bits=12)


def test_a_missing_folder_and_a_folder_in_the_files_place_are_named(tmp_path):
    with pytest.raises(ExportError, match="there is no folder"):
        save_picture(tmp_path / "no" / "a.png", picture(), SETTINGS)
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(ExportError, match="this is a folder"):
        save_picture(tmp_path / "folder.png", picture(), SETTINGS)


def test_a_link_stays_and_the_file_that_it_names_is_replaced(tmp_path):
    (tmp_path / "link.png").symlink_to(tmp_path / "real.png")
    save_picture(tmp_path / "link.png", picture(), SETTINGS)
    assert (tmp_path / "link.png").is_symlink()
    assert read_settings(tmp_path / "real.png") == SETTINGS


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, name):
    # A limit on the size of files stands in for the disk: writing fails part of the way
    (tmp_path / name).write_bytes(b"the old file")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with pytest.raises(ExportError, match="too large: nothing was written"):
            save_picture(tmp_path / name, picture(400, 400), SETTINGS)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert os.listdir(tmp_path) == [name]
    assert (tmp_path / name).read_bytes() == b"the old file"


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device"), MemoryError])
def test_an_interruption_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, error):
    def interrupted(image, settings):
        raise error

    (tmp_path / "a.png").write_bytes(b"the old file")
    monkeypatch.setattr("lensbench.app.session.export.develop", interrupted)
    with pytest.raises((KeyboardInterrupt, ExportError, MemoryError)):
        save_picture(tmp_path / "a.png", picture(), SETTINGS)
    assert os.listdir(tmp_path) == ["a.png"]
    assert (tmp_path / "a.png").read_bytes() == b"the old file"


KILLED = """
import sys, time
import numpy as np
from lensbench.app.session import export
from lensbench.app.settings.settings import Settings
def never(image, settings):
    print("writing", flush=True)
    time.sleep(600)
export.develop = never
export.save_picture(sys.argv[1], np.ones((300, 300, 3), np.float32), Settings())
"""


def test_the_old_file_survives_a_kill_amid_the_writing(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"the old file")
    with subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout.readline() == "writing\n"
        running.send_signal(signal.SIGKILL)
    assert path.read_bytes() == b"the old file"
    assert len(os.listdir(tmp_path)) == 2           # the process could not remove its temporary file
    other = tmp_path / f".lensbench-{os.getpid()}-01234567.part"
    other.write_bytes(b"of a process that runs")
    save_picture(path, picture(), SETTINGS)         # the next writer does
    assert sorted(os.listdir(tmp_path)) == sorted(["a.png", other.name])
    os.utime(other, (time.time() - 3 * 86400.0,) * 2)           # a large picture is under way
    save_picture(path, picture(), SETTINGS)
    assert sorted(os.listdir(tmp_path)) == sorted(["a.png", other.name])
    os.utime(other, (1e9, 1e9))
    save_picture(path, picture(), SETTINGS)
    assert os.listdir(tmp_path) == ["a.png"]


def test_two_writers_of_one_file_do_not_disturb_each_other(tmp_path):
    path = tmp_path / "a.png"
    with replacing(path) as one, replacing(path) as two:
        one.write_bytes(b"the first")
        two.write_bytes(b"the second")
    assert path.read_bytes() == b"the first" and os.listdir(tmp_path) == ["a.png"]
