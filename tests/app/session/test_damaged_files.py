"""Damaged settings, pictures and recordings: one clear line, or what was written. The short form of `make fuzz`."""

import io
import json
import struct
import warnings
import zipfile
import zlib

import numpy as np
import pytest

from lensbench.app.session.export import ExportError
from lensbench.app.session.recordings import LARGEST, load_light_field
from lensbench.app.session.states import load_settings
from lensbench.app.settings.settings import Settings
from tests.app.session import damage
from tests.app.session.damage import ERRORS, SMALL, packed, whole_files, with_settings
from tests.mishaps import by_bytes, by_lines, outlive

NAMES = ("a.toml", "a.png", "a.ppm", "a.exr", "field.npz", "moments.npz", "sensor.npz", "array.npz")
WAYS = [(name, way) for name in NAMES for way in (by_bytes, damage.by_mixture, damage.by_values,
                                                  *([damage.by_arrays] if name.endswith("npz") else [by_lines]))]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The bytes and the reader of every whole file."""
    folder = tmp_path_factory.mktemp("whole")
    readers = whole_files(folder)
    assert set(readers) == set(NAMES)
    for name, read in readers.items():
        assert read(folder / name) is not None
    return {name: ((folder / name).read_bytes(), read) for name, read in readers.items()}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "way"), WAYS, ids=lambda part: getattr(part, "__name__", part))
def test_a_damaged_file_is_one_clear_line_or_what_was_written(files, tmp_path, name, way):
    goes_on(files, tmp_path, name, way, 150)


def goes_on(files, folder, name, way, times):
    """Read a file after random changes: with numbers of any kind, what is read is a recording as it was written."""
    whole, read = files[name]
    (folder / name).write_bytes(whole)
    good = read(folder / name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = outlive(folder / name, whole, way, times, "short", read, ERRORS)
    for one in found:
        if isinstance(one, Settings):
            assert one.checked() is one
        elif way in (by_bytes, damage.by_mixture):
            assert one == good


# What has failed, as rows

def replaced(old, new):
    def change(whole):
        assert old in whole
        return whole.replace(old, new, 1)
    return change


DAMAGE = {
    "an EXR whose text is no UTF-8": ("a.exr", replaced(b'"thin"', b'"th\xff\xfe"'), "not text"),
    "an EXR whose attribute is an integer": ("a.exr", replaced(b"lensbench\0string", b"lensbench\0double"), "not text"),
    "an EXR whose attribute is endless": (
        "a.exr", replaced(b"lensbench\0string\0", b"lensbench\0string\0\xff\xff\xff\x7f"), "breaks off"),
    "a PPM with a list as settings": ("a.ppm", lambda whole: with_settings(whole, b"[[1, 2]]", {}), "braces"),
    "a PNG with pairs as settings": ("a.png", lambda whole: with_settings(whole, b'[["version", 1]]', {}), "braces"),
    "a PNG with nested brackets": ("a.png", lambda whole: with_settings(whole, b"[" * 100_000, {}), "damaged"),
    "a PNG with 5000 digits": ("a.png", lambda whole: with_settings(whole, b'{"version": ' + b"9" * 5000 + b"}", {}),
                               "damaged"),
    "a PPM with an infinite focal length": (
        "a.ppm", lambda whole: with_settings(whole, b'{"version": 1, "focal_length": 1e999}', {}), "from 0.001 mm"),
    "a TOML with 5000 digits": ("a.toml", lambda whole: whole + b"\nx = " + b"9" * 5000, "not TOML"),
    "a TOML with 10⁵ digits in hex": ("a.toml", replaced(b"seed = 0", b"seed = 0x" + b"f" * 100_000), "seed"),
    "a TOML with nested brackets": ("a.toml", lambda whole: whole + b"\nx = " + b"[" * 100_000, "not TOML"),
    "a TOML of 2 MB": ("a.toml", lambda whole: whole + b"#" * (2 << 20), "larger than 1 MB"),
    "a TOML with a long word": ("a.toml", replaced(b'"still-life"', b'["' + b"y" * 100_000 + b'"]'), "…"),
    "a TOML with a terminal escape": ("a.toml", replaced(b"seed", b'"\\u001b[2J\\n"'), r"\\x1b\[2J\\n"),
}


@pytest.mark.parametrize("row", DAMAGE)
def test_what_once_broke_a_reader_is_one_line(files, tmp_path, row):
    name, change, says = DAMAGE[row]
    (tmp_path / name).write_bytes(change(files[name][0]))
    with pytest.raises(ERRORS, match=says) as caught:
        load_settings(tmp_path / name)
    text = str(caught.value).replace(str(tmp_path), "")
    assert len(text) < 500 and text.isprintable()


def arrays(files, name="field.npz"):
    with np.load(io.BytesIO(files[name][0])) as archive:
        return {name: archive[name] for name in archive if name != "checksum"}


def changed(**values):
    return lambda found: packed({name: value for name, value in {**found, **values}.items() if value is not None})


def with_number(name, value):
    def change(found):
        found[name].reshape(-1)[5] = value
        return packed(found)
    return change


RECORDINGS = {
    "objects": (changed(light=np.array([object()])), "header"),
    "text for numbers": (changed(reach=np.array("wide")), "not those"),
    "complex numbers": (changed(reach=np.array(1j)), "not those"),
    "a list for a number": (changed(reach=np.zeros(3)), "not those"),
    "whole numbers": (changed(light=np.zeros((2, 3, 3, 4, 6), int)), "not those"),
    "no views": (changed(light=np.zeros((0, 3, 3, 4, 6), np.float16), coverage=np.zeros((0, 3, 4, 6), np.float16)),
                 "not those"),
    "nan in the light": (with_number("light", np.nan), "not finite"),
    "infinite light": (with_number("light", np.inf), "not finite"),
    "negative light": (with_number("light", -1.0), "negative"),
    "negative zero": (with_number("light", -0.0), "negative"),
    "nan in the coverage": (with_number("coverage", np.nan), "not finite"),
    "nan for the reach": (changed(reach=np.array(np.nan)), "not finite"),
    "no reach": (changed(reach=np.array(0.0)), "reach"),
    "an array more": (changed(gill=np.array(0.5)), "'gill'"),
    "moments of another shape": (changed(moments=np.zeros((2, 1), np.float16)), "not those"),
    "settings of numbers": (changed(settings=np.zeros(3)), "not text"),
}


@pytest.mark.parametrize("row", RECORDINGS)
def test_a_recording_with_odd_arrays_is_refused(files, tmp_path, row):
    change, says = RECORDINGS[row]
    (tmp_path / "a.npz").write_bytes(change(arrays(files)))
    with pytest.raises(ExportError, match=says):
        load_light_field(tmp_path / "a.npz")


def test_a_recording_without_a_checksum_and_opens(files, tmp_path):
    for transposed in (False, True):
        found = arrays(files)
        if transposed:
            found["light"] = np.asfortranarray(found["light"])
        (tmp_path / "old.npz").write_bytes(packed(found, compressed=transposed))
        assert damage.arrays_of(load_light_field(tmp_path / "old.npz")) == damage.arrays_of(damage.recording())


def test_a_recording_whose_arrays_were_exchanged_has_another_checksum(files, tmp_path):
    found = arrays(files)
    with np.load(io.BytesIO(files["field.npz"][0])) as archive:
        checksum = archive["checksum"]
    found["light"][0, 0] += 1.0
    (tmp_path / "a.npz").write_bytes(packed(found | {"checksum": checksum}))
    with pytest.raises(ExportError, match="checksum"):
        load_light_field(tmp_path / "a.npz")


def test_nothing_is_unpacked_that_a_small_file_claims_to_hold(files, tmp_path):
    """Zeros compress a thousandfold: a file of 2 MB that would fill 1.1 GB is refused by its header."""
    side = 4096
    plain = {**SMALL.to_dict(), "pixels_x": side, "pixels_y": side}
    shapes = {"light": (4, 3, 3, side, side), "coverage": (4, 3, side, side)}
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name, shape in shapes.items():
            header = io.BytesIO()
            np.lib.format.write_array_header_1_0(header, {"descr": "<f2", "fortran_order": False, "shape": shape})
            claimed(archive, f"{name}.npy", header.getvalue(), 2 * int(np.prod(shape)))
        for name, value in (("reach", 1.2), ("settings", json.dumps(plain))):
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.array(value))
    with pytest.raises(ExportError, match=f"at most {LARGEST // 10**9} GB"):
        load_light_field(tmp_path / "a.npz")


def claimed(archive, name, beginning, length):
    """Add a member that claims to unpack to a header and so many bytes more."""
    member = zipfile.ZipInfo(name)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    with archive.open(member, "w") as file:
        file.write(packer.compress(beginning + bytes(100)) + packer.flush())
    member.compress_type, member.file_size = zipfile.ZIP_DEFLATED, len(beginning) + length
    member.CRC = zlib.crc32(beginning + bytes(100))


def test_an_archive_of_many_members_is_refused_before_its_directory_is_read(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for i in range(100):
            archive.writestr(f"{i}.npy", b"")
    with pytest.raises(ExportError, match="no light field"):
        load_light_field(tmp_path / "a.npz")
    end = b"PK\x05\x06" + struct.pack("<HHHHIIH", 0, 0, 2, 2, 1 << 30, 0, 0)
    (tmp_path / "a.npz").write_bytes(bytes(500) + end)
    with pytest.raises(ExportError, match="no light field"):
        load_light_field(tmp_path / "a.npz")
