"""Pictures of others: only listed formats, by content; turned as Pillow turns them; refused before they are decoded."""

import struct
import zlib
from io import BytesIO

import numpy as np
import pytest
from PIL import EpsImagePlugin, Image, ImageOps

from lensbench.lenses.picture_file import FORMATS, MOST_PIXELS, PictureFileError, read_picture_file

LEVELS = np.random.default_rng(5).integers(0, 255, (12, 20, 3), np.uint8)
POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n(ran) print\nshowpage\n"


def saved(form, picture=None, **options):
    file = BytesIO()
    (picture or Image.fromarray(LEVELS)).save(file, form, **options)
    return file.getvalue()


def png_head(width, height, depth=8, colour=2):
    """A PNG file that claims a size, with one byte of pixels."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("form", FORMATS)
def test_the_format_follows_from_the_content(form, tmp_path):
    (tmp_path / "a.xyz").write_bytes(saved(form))
    for source in (tmp_path / "a.xyz", (tmp_path / "a.xyz").read_bytes()):
        picture = read_picture_file(source)
        assert picture.format == form and picture.size == (20, 12)
    if form in ("PNG", "TIFF", "BMP"):
        assert (np.asarray(picture) == LEVELS).all()


@pytest.mark.parametrize("data", [POSTSCRIPT, b"\xc5\xd0\xd3\xc6" + bytes(28) + POSTSCRIPT, saved("GIF"), saved("PPM"),
                                  saved("PDF"), saved("ICO"), saved("TGA"), b"", b"RIFF\0\0\0\0WAVE"])
def test_other_formats_are_refused_and_run_no_program(data, monkeypatch, tmp_path):
    monkeypatch.setattr(EpsImagePlugin, "Ghostscript", lambda *args, **kwargs: pytest.fail("Ghostscript was started"))
    (tmp_path / "texture.png").write_bytes(data)
    with pytest.raises(PictureFileError, match="no picture of the kinds PNG, JPEG"):
        read_picture_file(tmp_path / "texture.png")


@pytest.mark.parametrize("orientation", range(9))
def test_a_picture_is_turned_as_pillow_turns_it(orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    data = saved("PNG", exif=exif)
    expected = ImageOps.exif_transpose(Image.open(BytesIO(data)))
    assert (np.asarray(read_picture_file(data)) == np.asarray(expected)).all()
    assert (np.asarray(read_picture_file(data, upright=False)) == LEVELS).all()


@pytest.mark.parametrize("data", [png_head(13_000, 13_000), png_head(60_000, 60_000), png_head(2**31 - 1, 2**31 - 1),
                                  png_head(8193, 8192, 1, 0)])
def test_too_many_pixels_are_refused_by_the_header(data):
    assert 13_000**2 > MOST_PIXELS
    with pytest.raises(PictureFileError, match="67 million pixels"):
        read_picture_file(data)


def test_memory_of_the_decoder_counts(monkeypatch):
    # 60 × 40 pixels: 4 bytes each, and 6 of coefficients of a progressive file, or 8 of a strip of 16 bits
    progressive = saved("JPEG", Image.new("RGB", (60, 40)), progressive=True)
    monkeypatch.setattr("lensbench.lenses.picture_file.MOST_BYTES", 9 * 60 * 40)
    read_picture_file(saved("JPEG", Image.new("RGB", (60, 40))))
    for data in (progressive, saved("WEBP", Image.new("RGB", (60, 40)))):
        with pytest.raises(PictureFileError, match="to decode, at most"):
            read_picture_file(data)


def test_floating_point_pixels_have_no_white_unless_wanted():
    data = saved("TIFF", Image.fromarray(np.full((4, 4), 0.5, np.float32)))
    with pytest.raises(PictureFileError, match="floating-point numbers: save it with 8 or 16 bits"):
        read_picture_file(data)
    assert np.asarray(read_picture_file(data, real=True))[0, 0] == 0.5


@pytest.mark.parametrize("form", FORMATS)
def test_damaged_files_are_one_line(form):
    data = saved(form)
    random = np.random.default_rng(3)
    for k in range(150):
        damaged = bytearray(data[:random.integers(12, len(data))] if k % 2 else data)
        for offset in random.integers(0, len(damaged), 1 + k % 6):
            damaged[offset] = random.integers(256)
        try:
            read_picture_file(bytes(damaged))
        except PictureFileError as error:
            assert "\n" not in str(error)
