"""Damaged settings, pictures and recordings: the whole ones, ways to damage them, and what must be read from them."""

import io
import json
import random
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Recording
from lensbench.app.session.export import ExportError, save_picture
from lensbench.app.session.recordings import load_light_field, load_lumigraph, save_light_field, save_lumigraph
from lensbench.app.session.states import load_settings, save_settings
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import VERSION, Settings
from tests.mishaps import JUNK

SMALL = Settings(lens_model="thin", pixels_x=6, pixels_y=4, dispersion="off")
ERRORS = (SettingsError, ExportError, lenses.LensFileError, lb.LensError, lb.CameraError, lb.FilmError)
ODD = [None, True, "", "wide", "x" * 10**5, "\x1b[31m\n", [], [1, 2], {}, {"a": {}}, -1, 0, 1e300, -1e-320, 10**400,
       float("nan"), float("inf"), 0.1, 1, "inf", [[]], [0.0, float("nan"), 1.0], "\udcff"]
DTYPES = ["<f2", "<f4", "<f8", ">f4", "<i8", "<i1", "|b1", "<U3", "|S5", "<c16", "<M8[s]", "|V7"]


def whole_files(folder):
    """A small whole file of every kind, and its reader, by name."""
    folder = Path(folder)
    image = np.random.default_rng(1).random((4, 6, 3), np.float32)
    save_settings(folder / "a.toml", SMALL)
    for name in ("a.png", "a.ppm", "a.exr"):
        save_picture(folder / name, image, SMALL)
    save_light_field(folder / "field.npz", recording())
    save_light_field(folder / "moments.npz", recording(moments=2))
    save_light_field(folder / "sensor.npz", sensor())
    view = replace(SMALL, camera="perspective")
    texels = np.random.default_rng(2).random((2, 3, 4, 6, 4)).astype(np.float16)
    save_lumigraph(folder / "array.npz", lb.Lumigraph(lb.lumigraph_pinhole(camera(view)), 5.0, 900.0, texels), view)
    return {path.name: reader(path.name) for path in folder.iterdir()}


def reader(name):
    """The function that reads a file of this name, and returns plain values to be compared."""
    if name == "array.npz":
        return lambda path: arrays_of(load_lumigraph(path))
    return (lambda path: arrays_of(load_light_field(path))) if name.endswith(".npz") else load_settings


def recording(moments=0):
    """A light field of 2 × 3 views of noise."""
    rng = np.random.default_rng(3)
    light = rng.random((2, 3, 3, 4, 6)).astype(np.float16)
    more = rng.random((moments, *light.shape)).astype(np.float16) if moments else None
    return Recording(lb.LightField(camera(SMALL), 1.2, light, rng.random((2, 3, 4, 6)).astype(np.float16), 0.9,
                                   moments=more), SMALL)


def sensor():
    """A raw picture behind 3 × 3 pixels a microlens."""
    rng = np.random.default_rng(4)
    plenoptic = lb.PlenopticCamera(camera(SMALL), 3, 4.0)
    across, down = plenoptic.sensor
    raw = lb.RawPicture(plenoptic, rng.random((down, across, 3), np.float32), rng.random((down, across), np.float32))
    return Recording(raw.decoded(), SMALL, raw)


def arrays_of(found):
    """Settings, numbers and arrays of a recording or a lumigraph, as bytes."""
    if isinstance(found, tuple):
        lumigraph, settings = found
        return settings, lumigraph.spacing, lumigraph.distance, lumigraph.texels.tobytes()
    field, raw = found.field, found.raw
    parts = (field.light, field.coverage, field.moments) if raw is None else (raw.picture, raw.white)
    return found.settings, field.reach, field.fill, *(None if part is None else part.tobytes() for part in parts)


def by_values(whole, rng):
    """A file whose settings have odd values, or names, with every checksum right."""
    plain = SMALL.to_dict()
    for _ in range(rng.randint(1, 3)):
        name = rng.choice([*plain, "lens_model", "no such name", "\x1b[2J\n"])
        plain[name] = rng.choice(ODD)
    text = json.dumps(plain, ensure_ascii=True).encode()
    text = rng.choice([text, text, text, b"[" * 10**5, b"9" * 5000, text.replace(b'"', b"'"), b'"' + text,
                       b"\xff" + text, b"[[1, 2]]", b'[["version", 1]]', b"null"])
    return with_settings(whole, text, plain)


def with_settings(whole, text, plain):
    """A file of the kind of `whole` with other settings: JSON text, in TOML the plain values."""
    if whole.startswith(b"\x89PNG"):
        body = b"lensbench\0\0\0\0\0" + text
        at = whole.index(b"iTXt") - 4
        end = at + 12 + struct.unpack(">I", whole[at:at + 4])[0]
        part = struct.pack(">I", len(body)) + b"iTXt" + body + struct.pack(">I", zlib.crc32(b"iTXt" + body))
        return whole[:at] + part + whole[end:]
    if whole.startswith(b"P6"):
        lines = whole.split(b"\n", 2)
        return b"\n".join((lines[0], b"# lensbench " + text, lines[2]))
    if whole.startswith(b"\x76\x2f\x31\x01"):
        at = whole.index(b"lensbench\0string\0") + 17
        end = at + 4 + struct.unpack("<i", whole[at:at + 4])[0]
        return whole[:at] + struct.pack("<i", len(text)) + text + whole[end:]      # its chunks are elsewhere now
    if whole.startswith(b"PK"):
        with np.load(io.BytesIO(whole)) as archive:
            arrays = {name: archive[name] for name in archive if name != "checksum"}
        return packed(arrays | {"settings": np.array(text.decode("latin-1"))})
    lines = [f"{json.dumps(name)} = {toml(value)}" for name, value in plain.items() if value is not None]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def toml(value):
    """A value as TOML writes it, near enough."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name} = {toml(part)}" for name, part in value.items()) + "}"
    return json.dumps(value, ensure_ascii=False).replace("NaN", "nan").replace("Infinity", "inf")


def by_arrays(whole, rng):
    """A recording with other arrays: of another type, shape or content, missing, added, or compressed."""
    with np.load(io.BytesIO(whole)) as archive:
        arrays = {name: archive[name] for name in archive if name != "checksum"}
    for _ in range(rng.randint(1, 2)):
        name = rng.choice([name for name in arrays if name != "settings"] or ["light"])
        arrays[name] = damaged(arrays.get(name, np.zeros(3)), rng)
        if rng.random() < 0.1:
            del arrays[name]
        elif rng.random() < 0.1:
            arrays[rng.choice(["more", "moments", "fill", "raw", "pictures", "a/../../b", "\n"])] = arrays[name]
    content = packed(arrays, rng.random() < 0.2)
    return content if rng.random() < 0.7 else with_claim(content, rng)


def damaged(array, rng):
    """An array that this program would not have written."""
    kind = rng.randrange(8)
    if kind == 0:
        return np.zeros(array.shape, rng.choice(DTYPES))
    if kind == 1:
        return np.array([object(), None] if rng.random() < 0.5 else {"a": 1}, dtype=object)
    if kind == 2 and array.dtype.kind in "fi":
        with np.errstate(invalid="ignore", over="ignore"):
            return array.astype(rng.choice(["<f2", "<f4", "<f8", "<i8"]))
    if kind == 3:
        return np.zeros([rng.randrange(4) for _ in range(rng.randrange(7))], array.dtype)
    if kind == 4:
        return array.reshape(-1)[: rng.randrange(array.size + 1)]
    if kind == 5:
        return np.array([rng.choice(ODD[:6])] * rng.randrange(3))
    if array.dtype.kind == "f" and array.size:
        array = array.copy()
        array.reshape(-1)[rng.randrange(array.size)] = rng.choice([np.nan, np.inf, -np.inf, -1.0, -0.0, 1e-30])
        return array
    return np.asfortranarray(array)


def packed(arrays, compressed=False):
    """The bytes of an .npz of these arrays, without a checksum; objects as pickles."""
    file = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(file, **arrays)
    return file.getvalue()


def with_claim(content, rng):
    """The archive with a header that claims another shape or type, of the same length."""
    at = content.find(b"'shape': (", rng.randrange(len(content)))
    if at < 0:
        return content
    end = content.index(b"}", at)
    claim = rng.choice([b"'shape': (99999999999,), ", b"'shape': (-3, 2), ", b"'shape': (9" + b"9" * 20,
                        b"'shape': 3, ", b"'shape': (1,2,3,4), ", b"'shape': ((1,),), "])[:end - at].ljust(end - at)
    return content[:at] + claim + content[end:]


def by_mixture(whole, rng):
    """Bytes of two files exchanged at a random place, or junk put in."""
    i, j = rng.randrange(len(whole) + 1), rng.randrange(len(whole) + 1)
    return rng.choice([whole[:i] + whole[j:], whole[:i] + rng.choice(JUNK) + whole[i:],
                       whole[:i] + random.Random(rng.random()).randbytes(rng.randint(1, 9)) + whole[i + 4:]])


assert SMALL.to_dict()["version"] == VERSION
