"""Mesh files written by hand: a triangle or more with a picture, in every form that the readers know."""

import base64
import json
import struct

import numpy as np

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "<f4")
PLACES = np.array([[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]], "<f4")


class Tree:
    """The JSON of a glTF file with a buffer that grows."""

    def __init__(self):
        self.data = b""
        self.tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "bufferViews": [], "accessors": []}

    def view(self, data, **keys):
        """The index of a new buffer view with these bytes."""
        self.data += b"\0" * (-len(self.data) % 4)
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **keys})
        self.data += data
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, rows, form, **keys):
        """The index of a new accessor of these rows."""
        rows = np.asarray(rows)
        kind = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}[rows.dtype.str[1:]]
        padded = rows if rows.ndim == 1 or rows.strides[0] % 4 == 0 else \
            np.pad(rows, ((0, 0), (0, -rows.strides[0] % 4 // rows.itemsize)))
        stride = {"byteStride": padded.strides[0]} if rows.ndim > 1 else {}
        keys = {"bufferView": self.view(padded.tobytes(), **stride), **keys}
        self.tree["accessors"].append({"componentType": kind, "count": len(rows), "type": form, **keys})
        return len(self.tree["accessors"]) - 1

    def mesh(self, material=None, **attributes):
        """Make the only mesh one of these attributes, each an index of an accessor."""
        primitive = {"attributes": attributes} | ({} if material is None else {"material": 0})
        if material is not None:
            self.tree["materials"] = [material]
        self.tree["meshes"] = [{"primitives": [primitive]}]
        return self

    def gltf(self):
        """The text of a glTF file with its buffer as a data URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        return json.dumps(self.tree | {"buffers": [{"uri": uri, "byteLength": len(self.data)}]}).encode()

    def glb(self):
        """The bytes of a GLB file."""
        text = json.dumps(self.tree | {"buffers": [{"byteLength": len(self.data)}]}).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        return struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON") + text + \
            struct.pack("<I4s", len(data), b"BIN\0") + data


def pictured(image, uv=PLACES, **info):
    """A triangle with a picture; image: of the tree, such as {"uri": …}."""
    tree = Tree()
    attributes = {"POSITION": tree.accessor(CORNERS, "VEC3"), "TEXCOORD_0": tree.accessor(uv, "VEC2")}
    tree.tree |= {"images": [image], "textures": [{"source": 0}]}
    return tree.mesh({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **info}}}, **attributes)


def carriers(folder, picture):
    """The names of mesh files, written to the folder, that hold or name this picture in every way."""
    (folder / "p.png").write_bytes(picture)
    (folder / "a.mtl").write_text("newmtl m\nKd 1 1 1\nmap_Kd p.png\n")
    (folder / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
                                  "f 1/1 2/2 3/3\n")
    (folder / "a.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile p.png\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nproperty float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n")
    (folder / "beside.gltf").write_bytes(pictured({"uri": "p.png"}).gltf())
    encoded = base64.b64encode(picture).decode()
    (folder / "within.gltf").write_bytes(pictured({"uri": f"data:image/png;base64,{encoded}"}).gltf())
    held = pictured({"mimeType": "image/png"})
    held.tree["images"][0]["bufferView"] = held.view(picture)
    (folder / "held.glb").write_bytes(held.glb())
    return "a.obj", "a.ply", "beside.gltf", "within.gltf", "held.glb"
