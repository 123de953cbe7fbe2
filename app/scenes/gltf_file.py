"""glTF and GLB meshes: triangles of the scene where their nodes, skins and morph weights put them, with base colours.

After the specification glTF 2.0.1 of the Khronos Group. A value of the wrong type is a SceneError that names it.
"""

import base64
import binascii
import json
import struct
from collections.abc import Iterator
from typing import Any
from urllib.parse import unquote

import numpy as np

import lensbench as lb
from lensbench.app.scenes.mesh_parts import WHITE, Look, MeshFile, Piece, compact, draco_decoded, of_looks, of_strip
from lensbench.core.text import excerpt, significant

MOST_JSON = 64 << 20            # bytes
MOST_MARKS = 3_000_000          # brackets and commas of the JSON: each takes about 100 bytes when it is read
MOST_NODES = 100_000            # with the primitives of their meshes
MOST_SPARSE = 1 << 24           # numbers of accessors that other numbers replace
REPEATED = 10497                # a sampler's wrap
SHARPEST = 0.01                 # of the gloss of a coat: rougher ones look like it
BEYOND = 0.01                   # of a picture, where the wrap does not count
KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# What this reader does, or what a picture of base colours does not need
KNOWN = ("KHR_mesh_quantization", "KHR_texture_transform", "KHR_draco_mesh_compression", "EXT_texture_webp",
         "KHR_materials_", "KHR_lights_", "KHR_animation_", "KHR_xmp", "KHR_node_visibility")
INSTEAD = {"EXT_meshopt_compression": "save it without compression", "KHR_meshopt_compression": "save it without "
           "compression", "KHR_texture_basisu": "save its pictures as PNG or JPEG", "EXT_texture_avif": "save its "
           "pictures as PNG or JPEG", "MSFT_texture_dds": "save its pictures as PNG or JPEG", "EXT_mesh_gpu_instancing":
           "save it with a node for each instance"}
WORDS = {int: "a whole number", dict: "an object", list: "a list", str: "text", bool: "true or false"}
Object = dict[str, Any]


def read_gltf(file: MeshFile) -> Iterator[Piece]:
    """The parts of a glTF or GLB file, one for each primitive of a node. SceneError, ValueError or LookupError."""
    return _Gltf(file).parts()


def _get(holder: Object, name: str, kind: type, default: Any = None) -> Any:
    """A value of an object, of this type; the default, unless it is None, where it has none."""
    value = holder.get(name, default)
    if value is None:
        raise lb.SceneError(f"{name} is missing")
    fits = isinstance(value, kind)
    if kind is int and isinstance(value, int):
        fits = value >= 0 and not isinstance(value, bool)
    if not fits:
        raise lb.SceneError(f"{name} must be {WORDS[kind]}, not {excerpt(value)}")
    return value


def _numbers(holder: Object, name: str, count: int, default: Any = None) -> np.ndarray:
    """So many finite numbers of an object."""
    value = _get(holder, name, list, default)
    if len(value) != count or any(isinstance(x, bool) or not isinstance(x, int | float) or not abs(x) < 1e30
                                  for x in value):
        raise lb.SceneError(f"{name} must be a list of {count} finite numbers, not {excerpt(value)}")
    return np.array(value, float)


def _scaled(raw: np.ndarray, normalized: bool) -> np.ndarray:
    """Numbers of an accessor as floats; normalized whole numbers are fractions of the largest."""
    if not normalized or raw.dtype.kind == "f":
        return raw.astype(float)
    return np.maximum(raw / float(np.iinfo(raw.dtype).max), -1.0)


class _Gltf:
    """The JSON of a glTF file and the bytes that it names."""

    def __init__(self, file: MeshFile):
        self.file = file
        self.tree, self.binary = _tree(file.path.read_bytes(), file.path.suffix.lower() == ".glb")
        version = _get(_get(self.tree, "asset", dict, {}), "version", str, "2.0")
        if not version.startswith("2."):
            raise lb.SceneError(f"glTF of the version {excerpt(version)}: save it as glTF 2.0")
        names = [*_get(self.tree, "extensionsRequired", list, [])]
        names += [name for name in _get(self.tree, "extensionsUsed", list, []) if name == "EXT_mesh_gpu_instancing"]
        for name in names:
            if not isinstance(name, str) or not name.startswith(KNOWN):
                self._refuse(name)
        self.used_sparse = 0
        self._sparse: dict[int, np.ndarray] = {}
        self._buffers: dict[int, bytes] = {}
        self._draco: dict[int, Any] = {}

    def _refuse(self, extension: Any) -> None:
        raise lb.SceneError(f"needs the extension {excerpt(extension)}, which is not read"
                            + (f": {INSTEAD[extension]}" if extension in INSTEAD else ""))

    def item(self, name: str, index: Any) -> Object:
        """The object of a list of the file at a whole number."""
        items = _get(self.tree, name, list, [])
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(items):
            raise lb.SceneError(f"{name} has no entry {excerpt(index)} (it has {len(items)})")
        if not isinstance(items[index], dict):
            raise lb.SceneError(f"an entry of {name} must be an object, not {excerpt(items[index])}")
        return items[index]

    # Numbers

    def uri(self, uri: str) -> bytes:
        """The bytes of a data URI, or of a file next to the mesh."""
        if not uri.startswith("data:"):
            return self.file.bytes_of(unquote(uri))
        head, comma, text = uri.partition(",")
        try:
            if not comma:
                raise ValueError("no data")
            if not head.endswith(";base64"):
                return unquote(text).encode("latin-1")
            return base64.b64decode(text, validate=True)
        except (ValueError, binascii.Error) as error:
            raise lb.SceneError(f"the address {excerpt(uri)} holds no data that can be read") from error

    def view(self, index: Any) -> tuple[memoryview, int]:
        """The bytes of a buffer view, and its stride; 0 where its rows are packed."""
        view = self.item("bufferViews", index)
        which = _get(view, "buffer", int)
        if which not in self._buffers:
            buffer = self.item("buffers", which)
            if "uri" in buffer:
                self._buffers[which] = self.uri(_get(buffer, "uri", str))
            elif which == 0 and self.binary is not None:
                self._buffers[which] = self.binary
            elif "EXT_meshopt_compression" in _get(buffer, "extensions", dict, {}):
                self._refuse("EXT_meshopt_compression")
            else:
                raise lb.SceneError(f"buffer {which} names no data")
        start, length = _get(view, "byteOffset", int, 0), _get(view, "byteLength", int)
        data = memoryview(self._buffers[which])
        if start + length > len(data):
            raise lb.SceneError(f"buffer {which} ends before its view {index}: the file is cut short")
        return data[start:start + length], _get(view, "byteStride", int, 0)

    def rows(self, view: Any, start: int, count: int, width: int, kind: str) -> np.ndarray:
        """Numbers (count, width) of a buffer view, not copied."""
        data, stride = self.view(view)
        size = np.dtype(kind).itemsize
        stride = stride or width * size
        if count and start + stride * (count - 1) + width * size > len(data):
            raise lb.SceneError(f"an accessor reads beyond its buffer view {view}: the file is cut short")
        return np.ndarray((count, width), kind, data, start if count else 0, (stride, size))

    def accessor(self, index: Any, width: int | None = None) -> tuple[np.ndarray, bool]:
        """Numbers (count, width) of an accessor, as stored, and whether they are normalized."""
        accessor = self.item("accessors", index)
        kind, form = _get(accessor, "componentType", int), _get(accessor, "type", str)
        if kind not in KINDS or WIDTHS.get(form) not in ((width,) if width else WIDTHS.values()):
            raise lb.SceneError(f"accessor {index} has the type {excerpt(form)} of {excerpt(kind)}, which does not fit "
                                "its use")
        count, normalized = _get(accessor, "count", int), _get(accessor, "normalized", bool, False)
        if "bufferView" in accessor:
            numbers = self.rows(accessor["bufferView"], _get(accessor, "byteOffset", int, 0), count, WIDTHS[form],
                              KINDS[kind])
        elif count > np.iinfo(np.int64).max // 64:
            raise lb.SceneError(f"the count {excerpt(count)} of accessor {index} is too large")
        else:
            numbers = np.broadcast_to(np.zeros(1, KINDS[kind]), (count, WIDTHS[form]))
        if "sparse" not in accessor:
            return numbers, normalized
        if index not in self._sparse:
            sparse = _get(accessor, "sparse", dict)
            few = _get(sparse, "count", int)
            indices, values = _get(sparse, "indices", dict), _get(sparse, "values", dict)
            self.used_sparse += numbers.size
            if self.used_sparse > MOST_SPARSE:
                raise lb.SceneError(f"sparse accessors of more than {significant(MOST_SPARSE)} numbers")
            rows = self.rows(_get(indices, "bufferView", int), _get(indices, "byteOffset", int, 0), few, 1,
                             KINDS[_get(indices, "componentType", int)])[:, 0]
            if few and rows.max() >= count:
                raise lb.SceneError(f"accessor {index} replaces a row that it does not have")
            numbers = numbers.copy()
            numbers[rows.astype(np.int64)] = self.rows(
                _get(values, "bufferView", int), _get(values, "byteOffset", int, 0), few, WIDTHS[form], KINDS[kind])
            self._sparse[index] = numbers
        return self._sparse[index], normalized

    # Nodes

    def parts(self) -> Iterator[Piece]:
        """The triangles of every node of the scene, where the node stands."""
        worlds = self._worlds()
        lines = 0
        for index, world in worlds.items():
            node = self.item("nodes", index)
            if "mesh" not in node:
                continue
            mesh = self.item("meshes", node["mesh"])
            primitives = _get(mesh, "primitives", list)
            self.steps += len(primitives)
            if self.steps > MOST_NODES:
                raise lb.SceneError(f"has more than {significant(MOST_NODES)} nodes and primitives: join them")
            for primitive in primitives:
                if not isinstance(primitive, dict):
                    raise lb.SceneError(f"a primitive must be an object, not {excerpt(primitive)}")
                if _get(primitive, "mode", int, 4) < 4:
                    lines += 1
                    continue
                piece = self._part(primitive, node, _get(mesh, "weights", list, []), world, worlds)
                if piece is not None:
                    yield piece
        if lines and not self.file.triangles:
            raise lb.SceneError("holds points or lines, no triangles")

    def _worlds(self) -> dict[int, np.ndarray]:
        """The transform (4, 4) to the frame of the file of every node of its scene."""
        nodes = _get(self.tree, "nodes", list, [])
        scenes = _get(self.tree, "scenes", list, [])
        if len(nodes) > MOST_NODES:
            raise lb.SceneError(f"has more than {significant(MOST_NODES)} nodes: join them")
        if scenes:
            roots = _get(self.item("scenes", self.tree.get("scene", 0)), "nodes", list, [])
        else:
            below = {child for k in range(len(nodes)) for child in _get(self.item("nodes", k), "children", list, [])
                     if isinstance(child, int)}
            roots = [k for k in range(len(nodes)) if k not in below] or [0][:len(nodes)]
        self.steps = 0
        worlds: dict[int, np.ndarray] = {}
        waiting = [(root, np.eye(4)) for root in reversed(roots)]
        while waiting:
            index, above = waiting.pop()
            node = self.item("nodes", index)
            if index in worlds:
                raise lb.SceneError(f"a node of the file contains itself, or has two parents (node {index})")
            if _get(_get(_get(node, "extensions", dict, {}), "KHR_node_visibility", dict, {}), "visible", bool, True):
                worlds[index] = above @ _local(node)
                waiting += [(child, worlds[index]) for child in reversed(_get(node, "children", list, []))]
        self.steps = len(worlds)
        return worlds

    def _part(self, primitive: Object, node: Object, weights: list, world: np.ndarray,
              worlds: dict[int, np.ndarray]) -> Piece | None:
        """The triangles of a primitive, in the frame of the file; None where it has none."""
        columns, faces = self._columns(primitive)
        if "POSITION" not in columns:
            raise lb.SceneError("a primitive has no POSITION")
        total = len(columns["POSITION"][0])
        mode = _get(primitive, "mode", int, 4)
        count = total if faces is None else len(faces)
        self.file.count(count // 3 if mode == 4 else max(count - 2, 0))
        triangles = _triangles(np.arange(count) if faces is None else faces, mode)
        if not len(triangles):
            return None
        if triangles.max() >= total:
            raise lb.SceneError(f"a triangle has a corner that does not exist ({total} vertices)")
        # An accessor may serve many primitives
        rows, triangles = compact(triangles) if total > triangles.size else (slice(None), triangles)

        def column(name: str, of: dict = columns, normalized: bool = False) -> np.ndarray | None:
            if name not in of:
                return None
            raw, fractions = of[name]
            if len(raw) != total:
                raise lb.SceneError(f"{name} has {len(raw)} rows for {total} vertices")
            return _scaled(raw[rows], fractions or normalized)

        points, normals = column("POSITION"), column("NORMAL")
        weights = _get(node, "weights", list, weights)
        targets = _get(primitive, "targets", list, []) if any(weights) else []
        for target, weight in zip(targets, _numbers({"weights": weights}, "weights", len(targets)) if targets else (),
                                  strict=True):
            moved = self._accessors(target)
            points = points + weight * (0.0 if (more := column("POSITION", moved)) is None else more)
            if normals is not None and (more := column("NORMAL", moved)) is not None:
                normals = normals + weight * more
        if "skin" in node:
            points, normals = self._skinned(node["skin"], points, normals, column, worlds)
        else:
            points = points @ world[:3, :3].T + world[:3, 3]
            if np.linalg.det(world[:3, :3]) < 0.0:
                triangles = triangles[:, ::-1]
            if normals is not None:
                normals = normals @ _cofactors(world[:3, :3]).T
        if self.file.plain:
            return Piece(points, triangles, Look(), normals)
        with of_looks():
            look, uv = self._look(primitive, column)
        colours = column("COLOR_0", normalized=True)
        return Piece(points, triangles, look, normals, uv,
                    None if colours is None else np.clip(colours[:, :3], 0.0, 1.0).astype(np.float32))

    def _accessors(self, names: Any) -> dict[str, tuple[np.ndarray, bool]]:
        """The columns of an object of accessors, by their names."""
        widths = {"POSITION": (3,), "NORMAL": (3,), "COLOR_0": (3, 4), "JOINTS": (4,), "WEIGHTS": (4,),
                  "TEXCOORD": (2,)}
        columns = {}
        for name in _get({"attributes": names}, "attributes", dict):
            fit = widths.get(name, widths.get(name.split("_")[0], ()))
            if fit:
                columns[name] = self.accessor(names[name])
                if columns[name][0].shape[1] not in fit:
                    raise lb.SceneError(f"{name} has {columns[name][0].shape[1]} numbers for each vertex")
        return columns

    def _columns(self, primitive: Object) -> tuple[dict[str, tuple[np.ndarray, bool]], np.ndarray | None]:
        """The columns of the vertices of a primitive, and the rows of its corners (n,), if it has such."""
        attributes = _get(primitive, "attributes", dict)
        packed = _get(_get(primitive, "extensions", dict, {}), "KHR_draco_mesh_compression", dict, {})
        if not packed:
            indices = self.accessor(primitive["indices"], 1)[0][:, 0] if "indices" in primitive else None
            if indices is not None and indices.dtype.kind != "u":
                raise lb.SceneError("indices that are not whole numbers")
            return self._accessors(attributes), indices
        view = _get(packed, "bufferView", int)
        if view not in self._draco:
            self._draco[view] = draco_decoded(bytes(self.view(view)[0]))
        faces, columns = self._draco[view]
        columns = {name: (columns[index], _get(self.item("accessors", attributes.get(name)), "normalized", bool, False))
                   for name, index in _get(packed, "attributes", dict).items() if index in columns}
        return columns, faces

    def _skinned(self, index: Any, points: Any, normals: Any, column: Any, worlds: dict) -> tuple[Any, Any]:
        """Points and normals where the joints of a skin stand."""
        skin = self.item("skins", index)
        joints = _get(skin, "joints", list)
        inverse = np.tile(np.eye(4), (len(joints), 1, 1))
        if "inverseBindMatrices" in skin:
            columns = self.accessor(skin["inverseBindMatrices"], 16)[0].astype(float)
            inverse = columns.reshape(-1, 4, 4).transpose(0, 2, 1)
        if len(inverse) < len(joints) or not all(isinstance(joint, int) and joint in worlds for joint in joints):
            raise lb.SceneError(f"skin {index} has joints that are not in the scene, or lack a matrix")
        bones = np.stack([worlds[joint] for joint in joints]) @ inverse[:len(joints)] if joints else np.empty((0, 4, 4))
        blend = np.zeros((len(points), 4, 4))
        for k in range(8):
            which, weight = column(f"JOINTS_{k}"), column(f"WEIGHTS_{k}", normalized=True)
            if which is None or weight is None:
                break
            if len(which) and which.max() >= len(bones):
                raise lb.SceneError(f"a vertex has a joint that skin {index} does not have")
            for j in range(4):
                blend += weight[:, j, None, None] * bones[which[:, j].astype(np.int64)]
        moved = np.einsum("nij,nj->ni", blend[:, :3, :3], points) + blend[:, :3, 3]
        return moved, None if normals is None else np.einsum("nij,nj->ni", _cofactors(blend[:, :3, :3]), normals)

    # Colours

    def _look(self, primitive: Object, column: Any) -> tuple[Look, np.ndarray | None]:
        """Base colour, its picture and coat, and the positions of the vertices in the picture."""
        if "material" not in primitive:
            return Look(WHITE), None
        material = self.item("materials", primitive["material"])
        paint = _get(material, "pbrMetallicRoughness", dict, {})
        factor, texture = "baseColorFactor", "baseColorTexture"
        glossy = _get(_get(material, "extensions", dict, {}), "KHR_materials_pbrSpecularGlossiness", dict, {})
        if glossy:
            paint, factor, texture = glossy, "diffuseFactor", "diffuseTexture"
        red, green, blue = map(float, np.clip(_numbers(paint, factor, 4, [1.0] * 4)[:3], 0.0, 1.0))
        colour = red, green, blue
        varnish = _get(_get(material, "extensions", dict, {}), "KHR_materials_clearcoat", dict, {})
        (amount,), (roughness,) = (_numbers({name: [varnish.get(name, 0.0)]}, name, 1)
                                   for name in ("clearcoatFactor", "clearcoatRoughnessFactor"))
        coat = float(np.clip(1.0 - roughness, SHARPEST, 1.0)) if amount >= 0.5 else None
        if texture not in paint:
            return Look(colour, coat=coat), None
        info = _get(paint, texture, dict)
        change = _get(_get(info, "extensions", dict, {}), "KHR_texture_transform", dict, {})
        name = f"TEXCOORD_{_get(change, 'texCoord', int, _get(info, 'texCoord', int, 0))}"
        uv = column(name)
        if uv is None:
            raise lb.SceneError(f"a texture has no places on its mesh ({name})")
        if change:
            turn = change.get("rotation", 0.0)
            (turn,) = _numbers({"rotation": [turn]}, "rotation", 1)
            cos, sin = np.cos(turn), np.sin(turn)
            uv = (uv * _numbers(change, "scale", 2, [1.0, 1.0])) @ np.array([[cos, -sin], [sin, cos]]) + _numbers(
                change, "offset", 2, [0.0, 0.0])
        texture_of = self.item("textures", _get(info, "index", int))
        sampler = self.item("samplers", texture_of["sampler"]) if "sampler" in texture_of else {}
        for axis, side in enumerate(("wrapS", "wrapT")):
            if _get(sampler, side, int, REPEATED) != REPEATED and np.abs(uv[:, axis] - 0.5).max() > 0.5 + BEYOND:
                raise lb.SceneError(f"a texture is clamped or mirrored beyond its border ({side}): make it repeat")
        return Look(colour, self._picture(texture_of), coat), np.stack([uv[:, 0], 1.0 - uv[:, 1]], 1)

    def _picture(self, texture: Object) -> int:
        """The number of the image of a texture, whose bytes are then among the pictures of the file."""
        others = _get(texture, "extensions", dict, {})
        source = _get(others, "EXT_texture_webp", dict, texture).get("source")
        if source is None:
            if others:
                self._refuse(next(iter(others)))
            raise lb.SceneError("a texture names no image")
        image = self.item("images", source)
        if source not in self.file.pictures:
            self.file.pictures[source] = self.uri(_get(image, "uri", str)) if "uri" in image else \
                bytes(self.view(_get(image, "bufferView", int))[0])
        return source


def _tree(data: bytes, binary: bool) -> tuple[Object, bytes | None]:
    """The JSON of a file, and the binary chunk of a GLB."""
    chunk = None
    if binary:
        magic, _, length, size, kind = struct.unpack("<4sIII4s", data[:20])
        if magic != b"glTF" or kind != b"JSON" or not 20 + size <= length <= len(data):
            raise ValueError("cut short")
        if length >= 28 + size:
            more, kind = struct.unpack("<I4s", data[20 + size:28 + size])
            if kind == b"BIN\0":
                if 28 + size + more > length:
                    raise ValueError("cut short")
                chunk = data[28 + size:28 + size + more]
        data = data[20:20 + size]
    if len(data) > MOST_JSON or sum(map(data.count, (b",", b"[", b"{"))) > MOST_MARKS:
        raise lb.SceneError(f"has more than {MOST_JSON >> 20} MB or {significant(MOST_MARKS)} values of JSON: save it "
                            "as GLB")
    tree = json.loads(data.decode("utf-8-sig"))
    if not isinstance(tree, dict):
        raise ValueError("no object")
    return tree, chunk


def _local(node: Object) -> np.ndarray:
    """The transform (4, 4) of a node to the frame of its parent."""
    if "matrix" in node:
        return _numbers(node, "matrix", 16).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        x, y, z, w = _numbers(node, "rotation", 4)
        matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    if "scale" in node:
        matrix[:3, :3] *= _numbers(node, "scale", 3)
    if "translation" in node:
        matrix[:3, 3] = _numbers(node, "translation", 3)
    return matrix


def _cofactors(matrix: np.ndarray) -> np.ndarray:
    """What turns normals as a matrix (…, 3, 3) turns planes; of a flat one too. Mirrors included."""
    a, b, c = matrix[..., 0], matrix[..., 1], matrix[..., 2]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], -1) * np.sign(
        np.einsum("...i,...i->...", a, np.cross(b, c)))[..., None, None]


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    """Triangles (m, 3) of the corners of a primitive: of a list, a strip or a fan."""
    corners = corners.astype(np.int64)
    if mode == 4:
        return corners[:len(corners) // 3 * 3].reshape(-1, 3)
    if mode == 5:
        return of_strip(corners)
    if mode == 6:
        k = np.arange(max(len(corners) - 2, 0))
        return np.stack([corners[k + 1], corners[k + 2], np.broadcast_to(corners[:1], k.shape)], 1)
    raise lb.SceneError(f"mode {mode} of a primitive is not one of glTF")
