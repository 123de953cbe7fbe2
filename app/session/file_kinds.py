"""What a file is, by its first bytes: what *Open…*, a drop and `lensbench view FILE` decide by."""

import re
import tomllib
from pathlib import Path
from typing import Literal

from lensbench.app.scenes.mesh_file import READERS as MESHES
from lensbench.app.scenes.photograph import is_heic
from lensbench.app.scenes.sky_picture import EXR, is_hdr
from lensbench.app.session.export import PNG_SIGNATURE, carried_text
from lensbench.app.session.picture_formats import SIGNATURES as PIXMAPS
from lensbench.lenses import READERS
from lensbench.lenses.file_error import open_regular
from lensbench.lenses.picture_file import SIGNATURES

Kind = Literal["lens", "scene", "settings", "picture", "light field", "mesh", "sky", "photograph"]
MOST_READ = 1 << 20             # bytes of a .toml file to know its kind: no kind has more
PHOTOGRAPHS = (".jpg", ".jpeg", ".heic", ".png", ".tif", ".tiff", ".webp", ".bmp")
SKIES = (".hdr", ".pic", ".exr")
SUFFIXES = tuple(dict.fromkeys((*READERS, ".toml", *(f".{name}" for name in MESHES), *SKIES, *PHOTOGRAPHS, ".ppm",
                                ".npz")))


def file_kind(path: Path) -> Kind:
    """The kind of a file: "picture" is one that carries settings. OSError, ExportError for a damaged picture.

    Files without a signature are told by their suffix: OBJ and glTF, and the formats of lenses.
    """
    with open_regular(path) as file:
        head = file.read(16)
        if path.suffix.lower() == ".toml":
            return _table_kind((head + file.read(MOST_READ - len(head))).decode("utf-8", errors="replace"))
    if head.startswith((PNG_SIGNATURE, EXR, *PIXMAPS)) and (head.startswith(PIXMAPS) or carried_text(path) is not None):
        return "picture"
    if head.startswith(EXR) or is_hdr(head):
        return "sky"
    if head.startswith(tuple(signature for signature, _ in SIGNATURES)) or is_heic(head) or head[8:12] == b"WEBP":
        return "photograph"
    if head.startswith((b"glTF", b"ply\n", b"ply\r")) or path.suffix[1:].lower() in MESHES:
        return "mesh"
    return "light field" if path.suffix.lower() == ".npz" and head.startswith(b"PK") else "lens"


def _table_kind(text: str) -> Kind:
    try:
        keys = set(tomllib.loads(text))
    except tomllib.TOMLDecodeError:                     # its reader tells what is wrong with it
        keys = set(re.findall(r"^(?:\[+\s*)?(version|columns|surfaces)\b", text, re.MULTILINE))
    return "settings" if "version" in keys else "lens" if keys & {"columns", "surfaces"} else "scene"
