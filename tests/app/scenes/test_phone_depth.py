"""Photographs of phones with their depth map in the file."""

import base64
import math
import re
import sys
import time
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image as Picture, ImageOps

import lensbench as lb
from lensbench.app.scenes.photograph import EQUIVALENT, EXIF, EXTENDED, XMP, read_phone_photograph
from lensbench.app.scenes.scene_file import SceneFileError, load_scene

SCENE = '[photograph]\nimage = "phone.jpg"\n'
HEIC = b"\0\0\0\x18ftypheic" + bytes(40)
RAMP = np.repeat(np.linspace(0.0, 1.0, 12)[None], 8, 0)


def encoded(levels, form="PNG"):
    file = BytesIO()
    Picture.fromarray(levels).save(file, form, quality=95)
    return file.getvalue()


def segment(body):
    return b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body


def phone_file(path, depth=None, orientation=1, equivalent=26, piece=700, more="", **attributes):
    """A JPEG file as Google's camera writes it: attributes in XMP, the map in pieces of extended XMP."""
    exif = Picture.Exif()
    exif[0x0112] = orientation
    if equivalent:
        exif.get_ifd(0x8769)[0xA405] = equivalent
    file = BytesIO()
    colours = np.zeros((8, 12, 3), np.uint8)
    colours[:, :6, 0], colours[:4, :, 1] = 200, 120
    Picture.fromarray(colours).save(file, "JPEG", exif=exif, quality=95)
    values = {"Format": "RangeInverse", "Near": "0.5", "Far": "4.0", "Units": "m", "Mime": "image/png"} | attributes
    said = " ".join(f'GDepth:{name}="{value}"' for name, value in values.items() if value is not None)
    packet = f'<x:xmpmeta><rdf:Description {said} xmpNote:HasExtendedXMP="{"A" * 32}"/></x:xmpmeta>'.encode()
    data = file.getvalue()
    whole = b""
    if depth is not None:
        text = base64.b64encode(encoded(depth)).decode()
        long = f'<rdf:Description GDepth:Data="{text}" {more}/>'.encode()
        for at in range(0, len(long), piece):
            whole = segment(EXTENDED + b"A" * 32 + len(long).to_bytes(4, "big") + at.to_bytes(4, "big")
                            + long[at:at + piece]) + whole          # the pieces may come in any order
    path.write_bytes(data[:2] + segment(XMP + packet) + whole + data[2:])


@pytest.mark.parametrize(("form", "middle"), [("RangeInverse", 1.0 / (0.5 / 0.5 + 0.5 / 4.0)), ("RangeLinear", 2.25)])
@pytest.mark.parametrize("levels", [np.uint8(255 * RAMP), np.uint16(65535 * RAMP)], ids=["8 bits", "16 bits"])
def test_a_map_has_the_distances_that_its_format_says(tmp_path, form, middle, levels):
    phone_file(tmp_path / "phone.jpg", levels, Format=form)
    found = read_phone_photograph("phone.jpg", tmp_path)
    assert (found.away.min(), found.away.max()) == pytest.approx((500.0, 4000.0))
    assert np.interp(0.5, RAMP[0], found.away[0]) == pytest.approx(1000.0 * middle, rel=0.03)
    assert found.fov == pytest.approx(2.0 * math.atan(math.hypot(36, 24) * 12 / math.hypot(12, 8) / 52.0))


@pytest.mark.parametrize("orientation", range(1, 9))
def test_picture_and_map_are_turned_upright_as_pillow_turns_them(tmp_path, orientation):
    levels = np.uint8(np.arange(96).reshape(8, 12))
    phone_file(tmp_path / "phone.jpg", levels, orientation, Format="RangeLinear", Near="1", Far="256", Units="mm")
    found = read_phone_photograph("phone.jpg", tmp_path)
    with Picture.open(tmp_path / "phone.jpg") as picture:
        upright = ImageOps.exif_transpose(picture)
        exif = picture.getexif()
    assert found.picture.values.shape[:2] == upright.size[::-1]
    linear = (np.asarray(upright) / 255.0) ** 2.2
    assert np.abs(found.picture.values - linear).max() < 0.02
    turned = Picture.fromarray(levels)
    turned.getexif().update(exif)
    wanted = np.asarray(ImageOps.exif_transpose(turned)).astype(float)
    np.testing.assert_allclose(found.away, 1.0 + wanted, atol=1e-9)
    assert (found.fov < 1.0) == (orientation >= 5)          # across the shorter side


def test_a_scene_needs_nothing_but_the_file_and_takes_the_sharp_picture(tmp_path):
    sharp = base64.b64encode(encoded(np.full((8, 12, 3), 255, np.uint8), "JPEG")).decode()
    phone_file(tmp_path / "phone.jpg", np.uint8(255 * RAMP), more=f'GImage:Mime="image/jpeg" GImage:Data="{sharp}"')
    (tmp_path / "a.toml").write_text(SCENE)
    scene = load_scene(tmp_path / "a.toml")
    assert scene.meshes[0].material.pattern.image.values.min() > 0.98
    away = -scene.meshes[0].points[:, 2]
    assert (away.min(), away.max()) == pytest.approx((500.0, 4000.0), rel=0.25)     # corners lie between pixels


def test_distances_along_the_rays_become_distances_along_the_axis(tmp_path):
    flat = np.full((8, 12), 128, np.uint8)
    flat[0, 0], flat[0, 1] = 0, 255
    phone_file(tmp_path / "phone.jpg", flat, MeasureType="OpticRay", Format="RangeLinear")
    (tmp_path / "a.toml").write_text(SCENE + "fov = 90\n")
    points = load_scene(tmp_path / "a.toml").meshes[0].points
    inner = points[points[:, 1] < 0.0]                      # the lower half: one distance, but for coarse cells
    away = np.linalg.norm(inner, axis=1)
    assert np.ptp(away) < 0.12 * away.mean() and np.ptp(inner[:, 2]) > 0.2 * away.mean()


@pytest.mark.parametrize(("made", "text", "reason"), [
    ({}, SCENE, "carries no depth map; .*HEIC"),
    ({"depth": np.uint8(255 * RAMP), "equivalent": 0}, SCENE, "give fov"),
    ({"depth": np.uint8(255 * RAMP), "Near": "5"}, SCENE, "from 5000 mm to 4000 mm"),
    ({"depth": np.uint8(255 * RAMP), "Far": None}, SCENE, "no Near and Far"),
    ({"depth": np.uint8(255 * RAMP), "Format": "Magic"}, SCENE, "'Magic', neither RangeInverse"),
    ({"depth": np.uint8(255 * RAMP)}, SCENE + "near = 1\n", "near belongs to a depth map"),
    ({"depth": np.uint8(255 * RAMP)}, SCENE + 'depth = "phone.jpg"\n', "needs fov"),
])
def test_what_cannot_be_read_is_one_clear_line(tmp_path, made, text, reason):
    phone_file(tmp_path / "phone.jpg", **made)
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(SceneFileError, match=reason) as caught:
        load_scene(tmp_path / "a.toml")
    assert "\n" not in str(caught.value)


def in_long_hand(packet):
    """The same properties as elements; the closing tag has white space behind it, as serialisers write it."""
    head, _, rest = packet.partition(b"<rdf:Description ")
    attributes, _, _ = rest.partition(b"/>")
    elements = re.sub(rb'([\w:]+)="([^"]*)"\s*', rb"<\1>\n  \2\n</\1>\n  ", attributes)
    return head + b"<rdf:Description>\n  " + elements + b"</rdf:Description>" + rest.partition(b"/>")[2]


def test_properties_in_long_hand_are_those_of_attributes(tmp_path, monkeypatch):
    phone_file(tmp_path / "phone.jpg", np.uint8(255 * RAMP), piece=60_000)
    short = read_phone_photograph("phone.jpg", tmp_path)
    whole = segment
    monkeypatch.setitem(globals(), "segment", lambda body: whole(
        XMP + in_long_hand(body[len(XMP):]) if body.startswith(XMP) else extended_in_long_hand(body)))
    phone_file(tmp_path / "phone.jpg", np.uint8(255 * RAMP), piece=60_000)
    assert b"</GDepth:Near>" in (tmp_path / "phone.jpg").read_bytes()
    long = read_phone_photograph("phone.jpg", tmp_path)
    assert (long.away == short.away).all() and long.picture == short.picture


def extended_in_long_hand(body):
    head = len(EXTENDED) + 32
    packet = in_long_hand(body[head + 8:])
    return body[:head] + len(packet).to_bytes(4, "big") + bytes(4) + packet


HOSTILE = {
    "names without end": b"<a>" + b"GDepth:" * 60_000,
    "quotes without end": b"<a " + b'GDepth:a="' * 40_000,
    "blanks": b"<a GDepth:a" + b" " * 60_000,
    "deep elements": b"<GDepth:a>" * 6_000,
    "entities": b'<!DOCTYPE a [<!ENTITY x "xxxxxxxxxx">' + b"".join(
        b'<!ENTITY x%d "%s">' % (k, b"&x%d;" % (k - 1) * 10 if k else b"&x;" * 10) for k in range(12))
                + b"]><a><GDepth:Data>&x11;</GDepth:Data></a>",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_notes_are_refused_in_linear_time(tmp_path, name):
    phone_file(tmp_path / "phone.jpg", np.uint8(255 * RAMP))
    packet = HOSTILE[name]
    pieces = [packet[at:at + 60_000] for at in range(0, len(packet), 60_000)]
    data = (tmp_path / "phone.jpg").read_bytes()
    data = data[:2] + b"".join(segment(EXTENDED + b"B" * 32 + len(packet).to_bytes(4, "big")
                                       + (60_000 * k).to_bytes(4, "big") + piece)
                               for k, piece in enumerate(pieces)) + data[2:]
    (tmp_path / "phone.jpg").write_bytes(data)
    begun = time.perf_counter()
    with pytest.raises(lb.SceneError) as caught:
        read_phone_photograph("phone.jpg", tmp_path)
    assert time.perf_counter() - begun < 2.0 and "\n" not in str(caught.value)    # 60 s by a quadratic search


class _HeicFile:
    """What pillow_heif shows of a portrait of an iPhone: a picture, and a map of disparities in 1/m."""

    def __init__(self, meaning, shape=(6, 8)):
        exif = Picture.Exif()
        exif.get_ifd(EXIF)[EQUIVALENT] = 26
        self.picture, self.size = Picture.new("RGB", (80, 60), (200, 90, 30)), (80, 60)
        self.picture.info["exif"] = exif.tobytes()
        levels = np.linspace(0, 255, shape[0] * shape[1]).round().astype(np.uint8).reshape(shape)
        coded = SimpleNamespace(size=shape[::-1], info={"metadata": meaning},
                                to_pillow=lambda: Picture.fromarray(levels))
        self.info, self.to_pillow = {"depth_images": [coded] if meaning is not None else []}, lambda: self.picture


@pytest.mark.parametrize("meaning", [{"representation_type": 1, "d_min": 0.5, "d_max": 4.0},
                                     {"representation_type": 0, "z_near": 0.25, "z_far": 2.0}])
def test_a_portrait_in_heic_has_its_distances_and_its_field(meaning, tmp_path, monkeypatch):
    (tmp_path / "a.heic").write_bytes(HEIC)
    monkeypatch.setitem(sys.modules, "pillow_heif", SimpleNamespace(open_heif=lambda path: _HeicFile(meaning)))
    found = read_phone_photograph("a.heic", tmp_path)
    assert found.away.shape == (6, 8) and not found.radial
    assert found.away[0, 0] == pytest.approx(2000.0) and found.away[-1, -1] == pytest.approx(250.0)
    # Lines of equal disparity are equal steps of 1 / distance, to half a level of the map
    np.testing.assert_allclose(1000.0 / found.away.ravel(), np.linspace(0.5, 4.0, 48), atol=0.5 * 3.5 / 255.0)
    # 26 mm on 35 mm film, as the calibration in such a file has it: 3032.6 of 4032 pixels
    assert found.fov == pytest.approx(2.0 * math.atan(4032 / 3032.6 / 2.0), rel=3e-3)
    assert found.picture.values.shape == (60, 80, 3)


@pytest.mark.parametrize("meaning, shape, message", [
    (None, (6, 8), "carries no depth map"), ({}, (6, 8), "does not state its distances"),
    ({"representation_type": 3, "d_min": 0.5, "d_max": 4.0}, (6, 8), "does not state its distances"),
    ({"representation_type": 1, "d_min": 4.0, "d_max": math.nan}, (6, 8), "goes from 4 to nan"),
    ({"representation_type": 1, "d_min": 0.5, "d_max": 4.0}, (8, 6), "another shape"),
])
def test_heic_files_without_distances_are_refused_in_words(meaning, shape, message, tmp_path, monkeypatch):
    (tmp_path / "a.heic").write_bytes(HEIC)
    monkeypatch.setitem(sys.modules, "pillow_heif", SimpleNamespace(open_heif=lambda path: _HeicFile(meaning, shape)))
    with pytest.raises(lb.SceneError, match=message):
        read_phone_photograph("a.heic", tmp_path)


def test_heic_without_its_reader_and_damaged_files_are_refused_in_words(tmp_path, monkeypatch):
    (tmp_path / "a.toml").write_text(SCENE)
    phone = tmp_path / "phone.jpg"
    phone.write_bytes(HEIC)
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    with pytest.raises(SceneFileError, match="HEIC file.*lensbench.heic."):
        load_scene(tmp_path / "a.toml")
    phone_file(phone, np.uint8(255 * RAMP))
    whole = phone.read_bytes()
    for cut in (3, 20, 200, 900, len(whole) - 300):
        phone.write_bytes(whole[:cut])
        with pytest.raises(SceneFileError):
            load_scene(tmp_path / "a.toml")
