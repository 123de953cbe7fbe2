"""Photographs that carry their depth map: JPEG files with Google's XMP namespaces GDepth and GImage.

A large map travels in extended XMP: base64 text, cut into segments of the JPEG, each with its offset. A property is an
attribute or, in long hand, an element. The XML may declare no types and entities, so that nothing in it is expanded.
References: Google, Depthmap metadata; Adobe, XMP specification part 1, 7.4 and 7.9.2.2; part 3, 1.1.3.1.
"""

import base64
import binascii
import math
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.depth_levels import grey_levels
from lensbench.app.state.scene_assets.heic_depth import is_heic, read_heic_photograph
from lensbench.app.state.scene_assets.phone_photograph import PhonePhotograph, stated_fov
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.texture import image_of
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.lenses.picture_file import PictureFileError, read_picture_file
from lensbench.lenses.regular_file import open_regular
from lensbench.scenery.photograph import reduced

MOST_BYTES = 64 << 20           # of a photograph: its texts are held several times
XMP, EXTENDED = b"http://ns.adobe.com/xap/1.0/\0", b"http://ns.adobe.com/xmp/extension/\0"
SPACES = ("GDepth:", "GImage:")
ORIENTATION = 0x0112            # tag
UNREADABLE = ("of phones, JPEG files with a GDepth map and HEIC portraits are read; Apple's portraits in JPEG and "
              "Dynamic Depth are not: save the map as PNG, and name it as depth")


def read_phone_photograph(name: str, folder: Path) -> PhonePhotograph:
    """A photograph of a phone with the depth map in its file, turned upright; SceneError in one line."""
    path = asset_path(name, folder, "photograph", MOST_BYTES)
    with open_regular(path) as file:
        data = file.read()
    if is_heic(data[:12]):
        return read_heic_photograph(path, name)
    try:
        found = _attributes(data)
        if not found.get("GDepth:Data"):
            raise lb.SceneError(f"it carries no depth map; {UNREADABLE}")
        exif = read_picture_file(data, upright=False).getexif()
        sharp = found.pop("GImage:Data", "")            # where there is one
        picture = read_picture_file(_decoded(sharp) if sharp else data, upright=False)
        image, size = image_of(picture), picture.size
        coded = reduced(grey_levels(read_picture_file(_decoded(found.pop("GDepth:Data")), upright=False)))
    except (PictureFileError, expat.ExpatError, binascii.Error, lb.SceneError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: {error}") from error
    part = coded / (65535.0 if coded.dtype.itemsize > 1 else 255.0)
    away = _distances(found, part, name)
    turn = exif.get(ORIENTATION, 1)
    fov = stated_fov(exif, size, size[1] if turn in (5, 6, 7, 8) else size[0])
    upright = lb.Image.of(_turned(image.values, turn))
    return PhonePhotograph(upright, _turned(away, turn), found.get("GDepth:MeasureType") == "OpticRay", fov)


def _attributes(data: bytes) -> dict[str, str]:
    """The attributes of GDepth and GImage in the XMP segments of a JPEG file; ExpatError for damaged ones."""
    plain, pieces, at = b"", list[tuple[int, bytes]](), 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] not in (0xDA, 0xD9):
        length = int.from_bytes(data[at + 2:at + 4], "big")
        body = data[at + 4:at + 2 + length]
        if data[at + 1] == 0xE1 and body.startswith(XMP):
            plain = plain or body[len(XMP):]
        elif data[at + 1] == 0xE1 and body.startswith(EXTENDED) and len(body) > len(EXTENDED) + 40:
            head = len(EXTENDED) + 32                       # behind the digest that names the packet
            pieces.append((int.from_bytes(body[head + 4:head + 8], "big"), body[head + 8:]))
        at += 2 + max(length, 2)
    extended = b"".join(piece for _, piece in sorted(pieces, key=lambda piece: piece[0]))
    return _properties(plain) | _properties(extended)


def _properties(packet: bytes) -> dict[str, str]:
    """The texts of the properties of GDepth and GImage in a packet of XMP, by name; ExpatError where it is damaged."""
    found: dict[str, list[str]] = {}
    inside: list[str] = []                              # elements from the root to the current one

    def start(name: str, attributes: dict[str, str]) -> None:
        inside.append(name)
        found.update({key: [value] for key, value in attributes.items() if key.startswith(SPACES)})
        if name.startswith(SPACES):
            found[name] = []

    def add(text: str) -> None:
        if inside and inside[-1].startswith(SPACES):
            found[inside[-1]].append(text)

    def refuse(*_: Any) -> None:
        raise lb.SceneError("its XMP declares types of its own: it is not read")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, lambda name: inside.pop()
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = add, refuse
    if packet.strip(b" \0\t\r\n"):
        parser.Parse(packet.rstrip(b"\0"), True)
    return {name: "".join(texts).strip() for name, texts in found.items()}


def _decoded(text: str) -> bytes:
    """The bytes of base64 text; binascii.Error where it is none."""
    return base64.b64decode("".join(text.split()), validate=True)


def _distances(found: dict[str, str], part: np.ndarray, name: str) -> np.ndarray:
    """Distances (mm) of a map whose values lie in [0, 1], 0 the nearest."""
    form, unit = found.get("GDepth:Format", ""), found.get("GDepth:Units", "m")
    try:
        near, far = (float(found[f"GDepth:{which}"]) * {"m": 1000.0, "mm": 1.0}[unit] for which in ("Near", "Far"))
    except (KeyError, ValueError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has no Near and Far in m or mm") from error
    if not 0.0 < near < far < math.inf:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map goes from {significant(near)} mm to "
                            f"{significant(far)} mm")
    if form == "RangeInverse":
        return far * near / (far - part * (far - near))
    if form == "RangeLinear":
        return near + part * (far - near)
    raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has the format {excerpt(form)}, "
                        "neither RangeInverse nor RangeLinear")


def _turned(rows: np.ndarray, orientation: int) -> np.ndarray:
    """A picture (h, w, …), turned upright by its EXIF orientation."""
    if orientation in (5, 6, 7, 8):
        rows = rows.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        rows = rows[:, ::-1]
    return rows[::-1] if orientation in (3, 4, 7, 8) else rows
