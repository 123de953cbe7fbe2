"""Photographs that carry their depth map: JPEG files with Google's XMP namespaces GDepth and GImage.

A large map travels in extended XMP: base64 text, cut into segments of the JPEG, each with its offset. The text is
searched for the attributes of the two namespaces and not parsed as XML, so that nothing in it is expanded.
References: Google, Depthmap metadata; Adobe, XMP specification part 3, 1.1.3.1.
"""

import base64
import binascii
import math
import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.heic_depth import is_heic, read_heic_photograph
from lensbench.app.state.scene_assets.phone_photograph import PhonePhotograph, stated_fov
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.texture import FORMATS, MOST_BYTES, MOST_TEXELS, image_of
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt

XMP, EXTENDED = b"http://ns.adobe.com/xap/1.0/\0", b"http://ns.adobe.com/xmp/extension/\0"
ATTRIBUTE = re.compile(rb"(GDepth|GImage):(\w+)(?:\s*=\s*[\"']([^\"']*)[\"']|>([^<]*)<)")
ORIENTATION = 0x0112            # tag
UNREADABLE = ("of phones, JPEG files with a GDepth map and HEIC portraits are read; Apple's portraits in JPEG and "
              "Dynamic Depth are not: save the map as PNG, and name it as depth")


def read_phone_photograph(name: str, folder: Path) -> PhonePhotograph:
    """A photograph of a phone with the depth map in its file, turned upright; SceneError in one line."""
    from PIL import Image as Picture

    path = asset_path(name, folder, "photograph", MOST_BYTES)
    data = path.read_bytes()
    if is_heic(data[:12]):
        return read_heic_photograph(path, name)
    found = _attributes(data)
    if not found.get("GDepth:Data"):
        raise lb.SceneError(f"photograph {excerpt(name)} carries no depth map; {UNREADABLE}")
    try:
        with Picture.open(BytesIO(data), formats=("JPEG",)) as primary:
            exif = primary.getexif()
        with _opened(found.get("GImage:Data") or data, name) as picture:    # the sharp one, where there is one
            image, size = image_of(picture), picture.size
        with _opened(found["GDepth:Data"], name) as coded:
            levels: Any = np.asarray(coded if coded.mode.startswith(("I", "L")) and coded.mode != "LA"
                                     else coded.convert("RGB"))
            part = (levels[..., 0] if levels.ndim == 3 else levels) / (65535.0 if coded.mode.startswith("I") else 255.0)
    except (OSError, SyntaxError, ValueError, MemoryError, Picture.DecompressionBombError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: its picture or its depth map cannot be read") from error
    away = _distances(found, part, name)
    turn = exif.get(ORIENTATION, 1)
    fov = stated_fov(exif, size, size[1] if turn in (5, 6, 7, 8) else size[0])
    upright = lb.Image.of(_turned(image.values, turn))
    return PhonePhotograph(upright, _turned(away, turn), found.get("GDepth:MeasureType") == b"OpticRay", fov)


def _attributes(data: bytes) -> dict[str, bytes]:
    """The attributes of GDepth and GImage in the XMP segments of a JPEG file."""
    plain, pieces, at = b"", [], 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] not in (0xDA, 0xD9):
        length = int.from_bytes(data[at + 2:at + 4], "big")
        body = data[at + 4:at + 2 + length]
        if data[at + 1] == 0xE1 and body.startswith(XMP):
            plain += body[len(XMP):]
        elif data[at + 1] == 0xE1 and body.startswith(EXTENDED) and len(body) > len(EXTENDED) + 40:
            head = len(EXTENDED) + 32                       # behind the digest that names the packet
            pieces.append((int.from_bytes(body[head + 4:head + 8], "big"), body[head + 8:]))
        at += 2 + max(length, 2)
    extended = b"".join(piece for _, piece in sorted(pieces, key=lambda piece: piece[0]))
    return {f"{space.decode()}:{name.decode()}": value or text
            for space, name, value, text in ATTRIBUTE.findall(plain + b" " + extended)}


def _opened(data: bytes, name: str) -> Any:
    """A picture of PIL from a file in memory, or from base64 text."""
    from PIL import Image as Picture

    if not data.startswith(b"\xff\xd8"):
        try:
            data = base64.b64decode(b"".join(data.split()), validate=True)
        except binascii.Error as error:
            raise lb.SceneError(f"photograph {excerpt(name)}: a picture in it is no base64 text") from error
    picture = Picture.open(BytesIO(data), formats=FORMATS)
    if picture.width * picture.height > MOST_TEXELS or min(picture.size) < 2:
        raise lb.SceneError(f"photograph {excerpt(name)}: a picture in it has {picture.width} × {picture.height} "
                            "pixels")
    return picture


def _distances(found: dict[str, bytes], part: np.ndarray, name: str) -> np.ndarray:
    """Distances (mm) of a map whose values lie in [0, 1], 0 the nearest."""
    form, unit = found.get("GDepth:Format", b""), found.get("GDepth:Units", b"m")
    try:
        near, far = (float(found[f"GDepth:{which}"]) * {b"m": 1000.0, b"mm": 1.0}[unit] for which in ("Near", "Far"))
    except (KeyError, ValueError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has no Near and Far in m or mm") from error
    if not 0.0 < near < far < math.inf:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map goes from {significant(near)} mm to "
                            f"{significant(far)} mm")
    if form == b"RangeInverse":
        return far * near / (far - part * (far - near))
    if form == b"RangeLinear":
        return near + part * (far - near)
    raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has the format {excerpt(form.decode('latin1'))}, "
                        "neither RangeInverse nor RangeLinear")


def _turned(rows: np.ndarray, orientation: int) -> np.ndarray:
    """A picture (h, w, …), turned upright by its EXIF orientation."""
    if orientation in (5, 6, 7, 8):
        rows = rows.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        rows = rows[:, ::-1]
    return rows[::-1] if orientation in (3, 4, 7, 8) else rows
