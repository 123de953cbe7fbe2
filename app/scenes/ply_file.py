"""PLY meshes: text and binary, polygons and strips, colours of vertices or faces, places in pictures."""

import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.scenes.mesh_parts import (
    GREY, WHITE, Look, LookError, MeshFile, Piece, coded, compact, cut_to_triangles, of_looks, of_strip
)
from lensbench.core.text import excerpt

HEADER = 1 << 16                # bytes that are searched for the end of the header
MOST_TEXT = 128 << 20           # bytes of a text file: its numbers take four times as many
TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
         "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
         "float32": "f4", "float64": "f8"}
COLOURS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
LINEAR = ("linear_red", "linear_green", "linear_blue")        # of this program's own files: not coded as sRGB
PLACES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))


class Property(NamedTuple):
    """A column of an element: the type of its values, and that of its lengths where each row holds a list."""

    name: str
    kind: str
    lengths: str | None = None


class Column(NamedTuple):
    """The values of a column after one another, and how many each row has."""

    values: np.ndarray
    lengths: np.ndarray


Element = dict[str, Column]


def read_ply(file: MeshFile) -> Iterator[Piece]:
    """The parts of a PLY file, one for each picture. ValueError, LookupError or SceneError for a damaged one."""
    data = file.path.read_bytes()
    form, elements, pictures, start = _header(data)
    if form == "ascii":
        if len(data) > MOST_TEXT:
            raise lb.SceneError(f"a text file of more than {MOST_TEXT >> 20} MB: save it as binary PLY")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")             # what is no number ends it; the lengths then tell
            data, start = np.fromstring(data[start:], sep=" ").tobytes(), 0
    tables: dict[str, Element] = {}
    for name, count, properties in elements:
        tables[name], start = _element(data, start, count, properties, form)
    vertex, face = tables["vertex"], tables.get("face", {})
    points = _stacked(vertex, ("x", "y", "z"))
    if points is None:
        raise lb.SceneError("its vertices have no x, y, z")
    if "tristrips" in tables:
        (strips,) = tables["tristrips"].values()
        corners = _strips(strips.values.astype(np.int64)).reshape(-1)
        lengths = np.full(len(corners) // 3, 3)
    elif (column := face.get("vertex_indices", face.get("vertex_index"))) is not None:
        corners, lengths = column.values.astype(np.int64), column.lengths
    else:
        return
    file.count(int(np.maximum(lengths - 2, 0).sum()))
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
        raise lb.SceneError(f"a face has a corner that does not exist ({len(points)} vertices)")
    triangles, owner = cut_to_triangles(points, corners, lengths)
    uv = next((columns for names in PLACES if (columns := _stacked(vertex, names)) is not None), None)
    colours = next((columns for names in COLOURS if (columns := _stacked(vertex, names)) is not None), None)
    linear = _stacked(vertex, LINEAR)
    normals = _stacked(vertex, ("nx", "ny", "nz"))
    faces, taken = corners[triangles], np.arange(len(points))
    wedges, number = face.get("texcoord"), np.zeros(len(faces), np.int64)
    of_faces = next((columns for names in COLOURS if (columns := _stacked(face, names)) is not None), None)
    if of_faces is not None or (wedges is not None and pictures):
        # What belongs to a face or its corners: each triangle takes vertices of its own
        taken, faces = faces.reshape(-1), np.arange(faces.size).reshape(-1, 3)
        colours = None if colours is None else colours[taken]
        if of_faces is not None:
            colours = np.repeat(of_faces[owner], 3, 0)
        if wedges is not None:
            if not np.array_equal(wedges.lengths, 2 * lengths):
                raise lb.SceneError("the places in its picture (texcoord) are not two for each corner")
            uv = wedges.values.reshape(-1, 2)[triangles.reshape(-1)]
        elif uv is not None:
            uv = uv[taken]
        if "texnumber" in face:
            number = face["texnumber"].values.astype(np.int64)[owner]
    points = points[taken].astype(float)
    normals = None if normals is None else normals[taken]
    if file.plain or not pictures or uv is None:
        yield Piece(points, faces, Look(GREY if colours is None else WHITE), normals, uv if file.plain else None,
                   linear if colours is None else coded(colours))
        return
    for k in np.unique(number):
        if not 0 <= k < len(pictures):
            raise LookError(f"a face has the picture {k}, of {len(pictures)}")
        with of_looks():
            file.pictures[pictures[k]] = file.bytes_of(pictures[k])
        rows, own = compact(faces[number == k])
        yield Piece(points[rows], own, Look(WHITE, pictures[k]), None if normals is None else normals[rows],
                   uv[rows].astype(float))


def _header(data: bytes) -> tuple[str, list[tuple[str, int, list[Property]]], list[str], int]:
    """Its form, its elements with their lengths and properties, the names of its pictures, and where the rows start."""
    lines = data[:HEADER].split(b"\n")
    if lines[0].strip() != b"ply":
        raise ValueError("no PLY")
    form, start = "", len(lines[0]) + 1
    elements: list[tuple[str, int, list[Property]]] = []
    pictures: list[str] = []
    for raw in lines[1:]:
        start += len(raw) + 1
        line = raw.decode("utf-8", "replace").strip()
        words = line.split()
        match words:
            case ["format", form, "1.0"]:
                if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
                    raise lb.SceneError(f"the format {excerpt(form)} is not one of PLY")
            case ["element", name, count]:
                elements.append((name, int(count), []))
                if elements[-1][1] < 0:
                    raise ValueError("negative")
            case ["property", "list", lengths, kind, name]:
                if TYPES[lengths][0] == "f":
                    raise ValueError("lengths that are not whole")
                elements[-1][2].append(Property(name, TYPES[kind], TYPES[lengths]))
            case ["property", kind, name]:
                elements[-1][2].append(Property(name, TYPES[kind]))
            case ["comment", "TextureFile", *_]:
                pictures.append(line.split("TextureFile", 1)[1].strip())
            case ["end_header"]:
                if not form:
                    raise ValueError("no format")
                return form, elements, pictures, start
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise lb.SceneError(f"its header has the line {excerpt(line)}, which is not PLY")
    raise ValueError("no end of the header")


def _element(data: bytes, start: int, count: int, properties: list[Property], form: str) -> tuple[Element, int]:
    """The columns of an element whose rows begin at `start`, and where they end."""
    order = ">" if form == "binary_big_endian" else "<"
    text = form == "ascii"

    def of(kind: str) -> np.dtype:
        return np.dtype("<f8" if text else order + kind)

    if not count or not properties:
        return {p.name: Column(np.empty(0, p.kind), np.empty(0, np.int64)) for p in properties}, start
    # Rows that all are as the first one are read at once
    fields: list[tuple] = []
    position = start
    for k, p in enumerate(properties):
        size = 1
        if p.lengths is not None:
            size = int(np.frombuffer(data, of(p.lengths), 1, position)[0])
            fields.append((f"n{k}", of(p.lengths)))
            position += of(p.lengths).itemsize
        fields.append((str(k), of(p.kind), (size,)))
        position += size * of(p.kind).itemsize
        if size < 0 or position > len(data):
            raise ValueError("cut short")
    row = np.dtype(fields)
    if count * row.itemsize <= len(data) - start:
        rows = np.frombuffer(data, row, count, start)
        if all((rows[f"n{k}"] == rows[f"n{k}"][0]).all() for k, p in enumerate(properties) if p.lengths is not None):
            return {p.name: Column(_typed(rows[str(k)].reshape(-1), p.kind), np.full(count, rows[str(k)].shape[1]))
                    for k, p in enumerate(properties)}, start + count * row.itemsize
    if all(p.lengths is None for p in properties):
        raise ValueError("cut short")
    pieces: list[list[bytes]] = [[] for _ in properties]
    lengths: list[list[int]] = [[] for _ in properties]
    kinds = [(None if p.lengths is None else of(p.lengths), of(p.kind).itemsize) for p in properties]
    for _ in range(count):
        for k, (counted, size) in enumerate(kinds):
            length = 1
            if counted is not None:
                length = int(np.frombuffer(data, counted, 1, start)[0])
                start += counted.itemsize
            if length < 0 or start + length * size > len(data):
                raise ValueError("cut short")
            pieces[k].append(data[start:start + length * size])
            lengths[k].append(length)
            start += length * size
    return {p.name: Column(_typed(np.frombuffer(b"".join(pieces[k]), of(p.kind)), p.kind), np.array(lengths[k]))
            for k, p in enumerate(properties)}, start


def _typed(values: np.ndarray, kind: str) -> np.ndarray:
    """Values in the type that the header states: text is read as numbers of 64 bits."""
    typed = values.astype(kind)
    if kind[0] != "f" and (typed != values).any():
        raise ValueError("a number that its type does not hold")
    return typed


def _stacked(element: Element, names: tuple[str, ...]) -> np.ndarray | None:
    """The columns of these names side by side; None where one is missing or holds lists."""
    columns = [element[name] for name in names if name in element and (element[name].lengths == 1).all()]
    return np.stack([column.values for column in columns], 1) if len(columns) == len(names) else None


def _strips(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of strips that end in −1."""
    return np.concatenate([of_strip(strip[strip >= 0])
                           for strip in np.split(corners, np.flatnonzero(corners < 0) + 1)])
