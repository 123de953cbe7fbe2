"""OBJ meshes with their MTL materials: base colour and its picture."""

from collections.abc import Callable, Iterator
from itertools import chain, groupby
from operator import itemgetter, methodcaller
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.scenes.mesh_parts import (
    GREY, WHITE, Look, LookError, MeshFile, Piece, coded, compact, cut_to_triangles, distinct, of_looks
)
from lensbench.core.kernels.numeric import linear
from lensbench.core.text import excerpt

CHUNK = 1 << 22                 # bytes that are read at once
MOST_MTL = 16 << 20             # bytes of all materials
BAND = 1 << 16                  # lines whose numbers are read at once
FREE_FORM = {b"cstype", b"curv", b"curv2", b"surf", b"bzp", b"bsp", b"cdc", b"cdp", b"res", b"call", b"csh"}
PASSED = {b"", b"g", b"o", b"s", b"l", b"p", b"vp", b"mg", b"usemap", b"maplib", b"shadow_obj", b"trace_obj", b"lod",
          b"bevel", b"c_interp", b"d_interp", b"ctech", b"stech"}
# How many words follow an option of a picture
OPTIONS = {"-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-texres": 1, "-imfchan": 1, "-bm": 1, "-boost": 1,
           "-type": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3}


class Paint(NamedTuple):
    """A material: its look, and what its picture's places are multiplied by and moved."""

    look: Look = Look()
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)


class _Rows:
    """Rows of numbers, read from words of the file by bands: whole files of them take ten times the memory."""

    def __init__(self, read: Callable[[list[bytes]], np.ndarray]):
        self.read, self.count = read, 0
        self._waiting: list[bytes] = []
        self._found: list[np.ndarray] = []

    def add(self, words: list[bytes]) -> None:
        """Take a word for each row."""
        self.count += len(words)
        self._waiting += words
        if len(self._waiting) >= BAND:
            self._flush()

    def _flush(self) -> None:
        self._found.append(self.read(self._waiting))
        if len(self._found[-1]) != len(self._waiting):
            raise ValueError("a line without numbers")
        self._waiting = []

    def array(self) -> np.ndarray:
        """All rows."""
        self._flush()
        return np.concatenate(self._found)


def _floats(width: int) -> Callable[[list[bytes]], np.ndarray]:
    """A reader of lines with so many numbers, or more. ValueError for one that holds fewer, or words."""
    def read(lines: list[bytes]) -> np.ndarray:
        if not lines:
            return np.empty((0, width))
        return np.loadtxt(lines, np.float64, comments=None, usecols=range(width), ndmin=2)
    return read


def _corners(words: list[bytes]) -> np.ndarray:
    """Rows (n, 3) of the corners a, a/b, a//c, a/b/c; 0 where a number is missing."""
    corners = np.zeros((len(words), 3), np.int64)
    slashes, *others = {*map(methodcaller("count", b"/"), words)} or {0}
    joined = b"/".join(words)
    if others or b"//" in joined or joined.endswith(b"/"):
        words = [b"/".join((*(number or b"0" for number in word.split(b"/")), b"0", b"0")[:3]) for word in words]
        slashes, joined = 2, b"/".join(words)
    numbers = np.array([*map(int, joined.split(b"/"))] if words else [], np.int64)
    corners[:, :slashes + 1] = numbers.reshape(-1, slashes + 1)
    return corners


class _Tables:
    """What an OBJ file holds, as its lines list it."""

    def __init__(self) -> None:
        self.points, self.places, self.normals, self.tints = (_Rows(_floats(width)) for width in (3, 2, 3, 6))
        self.corners = _Rows(_corners)
        self.lengths: list[int] = []                    # of each face
        self.used: list[tuple[int, bytes]] = [(0, b"")]         # from which face on which material
        self.libraries: list[bytes] = []

    def add(self, kind: bytes, rest: list[bytes]) -> None:
        """Take successive lines whose first two bytes are the same; SceneError for what is not read."""
        if kind == b"v ":
            self.points.add(rest)
            self.tints.add([line for line in rest if line.count(b" ") >= 5 and len(line.split()) >= 6])
        elif kind == b"f ":
            joined = b" ".join(rest)
            words = joined.split()
            if b"-" in joined:
                counts = self.points.count, self.places.count, self.normals.count
                words = [_forward(word, counts) for word in words]
            self.corners.add(words)
            self.lengths += [len(line.split()) for line in rest]
            if min(self.lengths[-len(rest):]) < 3:
                raise lb.SceneError("a face has fewer than three corners")
        elif kind == b"vt":
            self.places.add([line if b" " in line.strip() else line + b" 0" for line in rest])
        elif kind == b"vn":
            self.normals.add(rest)
        else:
            for line in rest:
                self._add_statement(kind + line)

    def _add_statement(self, line: bytes) -> None:
        word, _, value = line.partition(b" ")
        if word == b"usemtl":
            self.used.append((len(self.lengths), value.strip()))
        elif word == b"mtllib":
            self.libraries.append(value.strip())
        elif word in FREE_FORM:
            raise lb.SceneError(f"holds free-form surfaces ({word.decode()}): save it as polygons")
        elif word not in PASSED and not word.startswith(b"#"):
            raise lb.SceneError(f"the line {excerpt(line.decode('utf-8', 'replace'))} is not OBJ")


def read_obj(file: MeshFile) -> Iterator[Piece]:
    """The parts of an OBJ file, one for each material. ValueError, LookupError or SceneError for a damaged one."""
    tables = _Tables()
    for kind, run in chain.from_iterable(groupby(lines, key=itemgetter(slice(2))) for lines in _lines(file)):
        tables.add(kind, [line[2:] for line in run])
    points, uvs, normals, tints, lengths = (tables.points, tables.places, tables.normals, tables.tints,
                                               tables.lengths)
    paints: dict[bytes, Paint] = {}
    if not lengths:
        return
    file.count(sum(lengths) - 2 * len(lengths))
    if not file.plain:
        with of_looks():
            for library in tables.libraries:
                paints |= _materials(file, library)
    vertices = points.array()
    index = tables.corners.array()
    for k, (table, what) in enumerate(((points, "v"), (uvs, "vt"), (normals, "vn"))):
        if index[:, k].min() < (1 if k == 0 else 0) or index[:, k].max() > table.count:
            raise lb.SceneError(f"a face has a corner that does not exist (it has {table.count} rows {what})")
    index -= 1
    triangles, owner = cut_to_triangles(vertices, index[:, 0], np.array(lengths))
    if (index[:, 1:] < 0).all():
        picks, faces = (np.arange(len(vertices)), *[np.full(len(vertices), -1)] * 2), index[:, 0][triangles]
    else:                           # a vertex for each different trio of place, place in the picture and normal
        first, which = distinct(*index.T)
        picks, faces = index[first].T, which[triangles]
    uv = np.where(picks[1][:, None] >= 0, uvs.array()[picks[1]], np.nan) if uvs.count else None
    ups = np.where(picks[2][:, None] >= 0, normals.array()[picks[2]], 0.0) if normals.count else None
    colours = None
    if tints.count and not file.plain:
        levels = tints.array()[:, 3:]
        if tints.count != points.count or levels.max() > 1.0:
            raise LookError("colours of vertices (v x y z red green blue) must lie between 0 and 1, for all or none")
        colours = coded(levels[picks[0]])
    starts = np.array([face for face, _ in tables.used])
    names = {name: k for k, name in enumerate(dict.fromkeys(name for _, name in tables.used))}
    of_face = np.array([names[name] for _, name in tables.used])[np.searchsorted(starts, owner, "right") - 1]
    points_of = vertices[picks[0]]
    for name, group in zip(names, _groups(of_face, len(names)), strict=True):
        if not len(group):
            continue
        rows, own = compact(faces[group])
        paint = paints.get(name, Paint(Look(WHITE if colours is not None else GREY)))
        if name and name not in paints and tables.libraries and not file.plain:
            raise LookError(f"its material {excerpt(name.decode('utf-8', 'replace'))} is in none of its MTL files")
        places_of = None
        if paint.look.picture is not None:
            if uv is None or np.isnan(uv[rows]).any():
                raise LookError(f"faces with the picture {excerpt(paint.look.picture)} have no places in it (vt)")
            places_of = uv[rows] * paint.scale + paint.offset
        yield Piece(points_of[rows], own, paint.look, None if ups is None else ups[rows], places_of,
                   None if colours is None else colours[rows])


def _lines(file: MeshFile) -> Iterator[Iterator[bytes]]:
    """The lines of the file, by chunks, without spaces at their ends; those that end in a backslash are joined."""
    with file.path.open("rb") as lines:
        while text := lines.read(CHUNK) + lines.readline():
            while text.rstrip(b"\r\n").endswith(b"\\") and (more := lines.readline()):
                text += more
            text = text.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").replace(b"\t", b" ")
            yield map(bytes.strip, text.splitlines())


def _forward(word: bytes, counts: tuple[int, ...]) -> bytes:
    """A corner whose negative numbers count back from the rows so far, as one that counts from the first."""
    return b"/".join(b"%d" % (int(number) + count + 1) if number.startswith(b"-") else number
                     for number, count in zip(word.split(b"/"), counts, strict=False))


def _groups(keys: np.ndarray, count: int) -> list[np.ndarray]:
    """The positions of each of so many keys."""
    if count == 1:
        return [np.arange(len(keys))]
    order = np.argsort(keys, kind="stable")
    return np.split(order, np.searchsorted(keys[order], np.arange(1, count)))


def _materials(file: MeshFile, library: bytes) -> dict[bytes, Paint]:
    """The materials of `mtllib`: one file with spaces in its name, or several."""
    name = library.decode("utf-8", "replace").replace("\\", "/")
    try:
        texts = [file.bytes_of(name)]
    except lb.SceneError:
        if len(name.split()) < 2:
            raise
        texts = [file.bytes_of(word) for word in name.split()]
    if sum(map(len, texts)) > MOST_MTL:
        raise LookError(f"its materials take more than {MOST_MTL >> 20} MB")
    paints: dict[bytes, Paint] = {}
    own = b""
    for line in b"\n".join(texts).splitlines():
        kind, _, rest = line.replace(b"\t", b" ").strip().partition(b" ")
        if kind == b"newmtl":
            own = rest.strip()
            paints[own] = Paint()
        elif kind == b"Kd" and own in paints:
            words = rest.split()
            if words[:1] in ([b"spectral"], [b"xyz"]):
                raise lb.SceneError(f"a colour in the form Kd {words[0].decode()}: save it as red, green and blue")
            levels = np.array([float(word) for word in (words * 3 if len(words) == 1 else words)[:3]])
            if levels.shape != (3,) or not np.isfinite(levels).all():
                raise lb.SceneError("a colour Kd that is not three numbers")
            red, green, blue = map(float, linear(np.clip(levels, 0.0, 1.0)))
            paints[own] = paints[own]._replace(look=paints[own].look._replace(colour=(red, green, blue)))
        elif kind == b"map_Kd" and own in paints:
            paints[own] = _pictured(file, paints[own], rest.decode("utf-8", "replace"))
    # A picture is multiplied by its colour, which many programs write as black or leave out
    return {key: paint._replace(look=paint.look._replace(colour=WHITE))
            if paint.look.picture is not None and paint.look.colour in (GREY, (0.0, 0.0, 0.0)) else paint
            for key, paint in paints.items()}


def _pictured(file: MeshFile, paint: Paint, rest: str) -> Paint:
    """The material with the picture of map_Kd, of which -s and -o scale and move the places."""
    words = rest.split()
    values = {"-s": (1.0, 1.0), "-o": (0.0, 0.0)}
    while words and words[0] in OPTIONS:
        option, words = words[0], words[1:]
        numbers: list[str] = []
        for word in words[:OPTIONS[option]]:
            if OPTIONS[option] == 3 and numbers and not _is_number(word):
                break
            numbers.append(word)
        words = words[len(numbers):]
        if option in values:
            u, v = (*map(float, numbers), *values[option][len(numbers):])[:2]
            values[option] = (u, v)
    # The name may hold several spaces one after another
    name = rest[rest.index(words[0]):].strip().replace("\\", "/") if words else ""
    file.pictures[name] = file.bytes_of(name)
    return Paint(paint.look._replace(picture=name), values["-s"], values["-o"])


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
