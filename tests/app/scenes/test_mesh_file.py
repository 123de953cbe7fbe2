"""Meshes from files: OBJ, PLY, glTF and GLB, written by hand or by trimesh, and files that are broken or hostile."""

import json
import os
import struct
import time

import numpy as np
import pytest
import trimesh
from PIL import Image as Picture

import lensbench as lb
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene, load_scene, scene_stamp

SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
UV = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@pytest.fixture
def scene(tmp_path):
    def load(text):
        (tmp_path / "a.toml").write_text(text)
        return load_scene(tmp_path / "a.toml")
    return load


def gltf(folder, name="a.gltf", **change):
    """A square as glTF with a buffer in a file beside it; change: parts of the JSON."""
    points, corners = SQUARE.astype("<f4").tobytes(), FACES.astype("<u4").tobytes()
    (folder / "a.bin").write_bytes(points + corners)
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "buffers": [{"uri": "a.bin", "byteLength": len(points) + len(corners)}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
                            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"}]}
    (folder / name).write_text(json.dumps({**tree, **change}))


def test_an_obj_has_places_normals_and_the_texture_of_its_material(scene, tmp_path):
    lines = [f"v {x} {y} {z}" for x, y, z in SQUARE] + [f"vt {u} {v}" for u, v in UV] + ["vn 0 0 1"]
    faces = ["f " + " ".join(f"{k + 1}/{k + 1}/1" for k in face) for face in FACES]
    (tmp_path / "a.obj").write_text("\n".join(["mtllib a.mtl", *lines, "usemtl wood", *faces]))
    (tmp_path / "a.mtl").write_text("newmtl wood\nKd 1 1 1\nmap_Kd wood.png\n")
    wood = np.uint8([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [188, 188, 188]]])
    Picture.fromarray(wood).save(tmp_path / "wood.png")
    mesh, = scene('[[mesh]]\nfile = "a.obj"\nunit = "m"\nposition = [0, 0, -2000]\n').meshes
    assert np.ptp(mesh.points, 0) == pytest.approx((1000.0, 1000.0, 0.0)) and (mesh.points[:, 2] == -2000.0).all()
    assert mesh.material.pattern.image.values[0, 0] == pytest.approx((1.0, 0.0, 0.0))
    normals = np.frombuffer(mesh.normals, np.float32).reshape(-1, 3)
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (len(normals), 1)), atol=1e-6)
    places = np.frombuffer(mesh.uv, np.float32).reshape(-1, 2)
    np.testing.assert_allclose(mesh.points[:, :2] / 1000.0, places, atol=1e-6)      # the lower left corner is 0, 0


def test_a_ply_has_the_colours_of_its_vertices(scene, tmp_path):
    colours = np.uint8([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [188, 188, 188, 255]])
    trimesh.Trimesh(SQUARE, FACES, vertex_colors=colours, process=False).export(tmp_path / "a.ply")
    mesh, = scene('[[mesh]]\nfile = "a.ply"\nsize = "30 cm"\nrotation = [0, 90, 0]\n').meshes
    tints = np.frombuffer(mesh.colours, np.float32).reshape(-1, 3)
    assert tints[3] == pytest.approx((0.5028865,) * 3, abs=1e-6) and tints[0] == pytest.approx((1.0, 0.0, 0.0))
    np.testing.assert_allclose(np.ptp(mesh.points, 0), (0.0, 300.0, 300.0), atol=1e-4)
    assert mesh.points[:, 2].min() == pytest.approx(-300.0)             # +x turned to −z


def test_a_gltf_is_in_metres_and_its_nodes_place_it(scene, tmp_path):
    gltf(tmp_path, nodes=[{"children": [1], "translation": [0, 0, -3]}, {"mesh": 0, "scale": [2, 1, 1]}],
         materials=[{"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1.0]}}],
         meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}])
    mesh, = scene('[[mesh]]\nfile = "a.gltf"\n').meshes
    assert mesh.points.max(0) == pytest.approx((2000.0, 1000.0, -3000.0))
    assert mesh.material.colour == pytest.approx((0.2, 0.4, 0.6), abs=0.003)
    metal, = scene('[[mesh]]\nfile = "a.gltf"\nscale = 0.5\nmaterial = { kind = "metal", colour = "#ffffff" }\n').meshes
    assert metal.material.kind == "metal" and metal.points.max(0) == pytest.approx((1000.0, 500.0, -1500.0))


def test_a_glb_is_read_and_smoothed(scene, tmp_path):
    (tmp_path / "a.glb").write_bytes(trimesh.creation.icosphere(2).export(file_type="glb"))
    mesh, = scene('[[mesh]]\nfile = "a.glb"\nsmooth = true\nmaterial = { kind = "glass" }\n').meshes
    normals = np.frombuffer(mesh.normals, np.float32).reshape(-1, 3)
    np.testing.assert_allclose(normals, mesh.points / 1000.0, atol=0.03)         # a sphere of 320 triangles
    assert mesh.material.kind == "glass"


def test_a_changed_mesh_file_is_read_again(tmp_path):
    gltf(tmp_path)
    (tmp_path / "a.toml").write_text('[[mesh]]\nfile = "a.gltf"\n')
    path = str(tmp_path / "a.toml")
    first, stamp = cached_scene(path), scene_stamp(path)
    gltf(tmp_path, nodes=[{"mesh": 0, "scale": [3, 3, 3]}])
    os.utime(tmp_path / "a.gltf", ns=(1, 1))
    assert scene_stamp(path) != stamp
    assert cached_scene(path).meshes[0].points.max() == pytest.approx(3.0 * first.meshes[0].points.max())


def test_nothing_outside_the_folder_is_read(scene, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "secret.bin").write_bytes(b"0" * 72)
    os.symlink(tmp_path / "secret.bin", home / "link.bin")
    for uri in ("../secret.bin", "link.bin", str(tmp_path / "secret.bin"), "https://example.com/a.bin", "file:///etc/a"):
        gltf(home, buffers=[{"uri": uri, "byteLength": 72}])
        (home / "a.toml").write_text('[[mesh]]\nfile = "a.gltf"\n')
        with pytest.raises(SceneFileError, match="outside the folder|relative to|no such file|on a network") as caught:
            load_scene(home / "a.toml")
        assert "\n" not in str(caught.value)
    (home / "a.obj").write_text("mtllib ../a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n")
    (tmp_path / "a.mtl").write_text("newmtl x\nKd 1 0 0\n")
    (home / "b.toml").write_text('[[mesh]]\nfile = "a.obj"\n')
    with pytest.raises(SceneFileError, match="outside the folder"):
        load_scene(home / "b.toml")


def glb(tree):
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON") + text


BROKEN = {
    "none.obj": (None, "no such file"),
    "words.obj": (b"these are words\n", "the line 'these are words' is not OBJ"),
    "empty.obj": (b"", "no triangles|damaged"),
    "cut.ply": (b"ply\nformat binary_little_endian 1.0\nelement ver", "the line 'element ver'"),
    "zero.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                 b"element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n",
                 "no triangles|damaged"),
    "nan.obj": (b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
    "flat.obj": (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "area"),
    "beyond.obj": (b"v 0 0 0\nv 1 0 0\nf 1 2 9\n", "damaged|does not exist|no triangles"),
    "a.stl": (b"solid a\n", "choose a file of the kinds obj, ply, gltf, glb"),
    "cut.glb": (glb({"nodes": []})[:30], "damaged"), "text.glb": (b"glTF and more text than a header", "damaged"),
    "cycle.glb": (glb({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                       "nodes": [{"children": [1]}, {"children": [0]}]}), "contains itself"),
    "bare.glb": (glb({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                      "accessors": [{"componentType": 5126, "count": 1 << 29, "type": "VEC3"}]}),
                 "claims more than .* triangles"),
    "lost.glb": (glb({"asset": {"version": "2.0"}, "nodes": [{"children": [7]}]}), r"nodes has no entry 7"),
    "list.gltf": (b"[1, 2]", "damaged"), "nothing.gltf": (b"{}", "damaged|no triangles"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_mesh_is_one_clear_line(scene, tmp_path, name):
    data, reason = BROKEN[name]
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(SceneFileError, match=reason) as caught:
        scene(f'[[mesh]]\nfile = "{name}"\n')
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize(("text", "reason"), [
    ('size = 1\nunit = "m"\n', "choose one"), ('size = 1\nheight = 2\n', "choose one"),
    ("foot = [0, 0, 0]\nposition = [0, 0, 0]\n", "not both"), ("scale = 0\n", "scale must be positive"),
    ('unit = "ft"\n', "choose one of mm"), ("velocity = [1, 0, 0]\n", "no 'velocity'"),
    ("unit = []\n", r"unit \[\]: choose one of mm"),
    ("position = [1e308, 0, 0]\n", "position is 1e.308: it must be a finite"),
    ("smooth = 1\n", "true or false"), ('material = "gold"\n', "not in the file"),
])
def test_a_mistake_in_the_table_is_one_clear_line(scene, tmp_path, text, reason):
    gltf(tmp_path)
    with pytest.raises(SceneFileError, match=f"mesh 1: .*{reason}"):
        scene(f'[[mesh]]\nfile = "a.gltf"\n{text}')


def test_a_missing_texture_is_said_unless_a_material_takes_its_place(scene, tmp_path):
    (tmp_path / "a.obj").write_text("mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n")
    with pytest.raises(SceneFileError, match="its file 'gone.mtl': there is no such file; or give the mesh a material"):
        scene('[[mesh]]\nfile = "a.obj"\n')
    assert len(scene('[[mesh]]\nfile = "a.obj"\nmaterial = { colour = "#ffffff" }\n').meshes) == 1


def test_nodes_of_one_look_are_one_mesh_and_those_of_another_their_own(scene, tmp_path, monkeypatch):
    gltf(tmp_path, nodes=[{"mesh": k % 2, "translation": [0.0, 0.0, 0.001 * k]} for k in range(200)],
         scenes=[{"nodes": list(range(200))}],
         materials=[{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 1.0]}}],
         meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
                 {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])
    red, white = sorted(scene('[[mesh]]\nfile = "a.gltf"\n').meshes, key=lambda mesh: mesh.material.colour)
    assert red.material.colour == (1.0, 0.0, 0.0) and white.material.colour == (1.0, 1.0, 1.0)    # glTF's own default
    assert len(red.triangles) == len(white.triangles) == 200
    np.testing.assert_allclose(np.unique(red.points[red.triangles][..., 2]), np.arange(0.0, 200.0, 2.0), atol=1e-4)
    np.testing.assert_allclose(np.unique(white.points[white.triangles][..., 2]), np.arange(1.0, 200.0, 2.0), atol=1e-4)
    monkeypatch.setattr("lensbench.app.scenes.mesh_parts.MOST_TRIANGLES", 399)
    with pytest.raises(SceneFileError, match="more than 399 triangles"):
        scene('[[mesh]]\nfile = "a.gltf"\n\n')


@pytest.mark.parametrize(("change", "reason"), [
    (None, ""), ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}]},
                 r"a texture has no places on its mesh \(TEXCOORD_0\)"),
    ({"textures": []}, "textures has no entry 0"),
    ({"images": [{"uri": "data:image/png;base64,AAAA"}]}, "texture 0: it is no picture of the kinds PNG"),
    ({"textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]}, "KHR_texture_basisu.*as PNG or JPEG")])
def test_a_texture_of_a_gltf_that_cannot_be_read_is_named(scene, tmp_path, change, reason):
    """Whole; without places, without texture, damaged, of an unknown extension."""
    Picture.fromarray(np.full((4, 4, 3), 90, np.uint8)).save(tmp_path / "wood.png")
    gltf(tmp_path, **{
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
        "images": [{"uri": "wood.png"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"},
                      {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}]} | (change or {}))
    if change is None:
        assert scene('[[mesh]]\nfile = "a.gltf"\n').meshes[0].material.pattern is not None
        return
    with pytest.raises(SceneFileError, match=f"{reason}.*; or give the mesh a material"):
        scene('[[mesh]]\nfile = "a.gltf"\n')
    assert len(scene('[[mesh]]\nfile = "a.gltf"\nmaterial = { colour = "#ffffff" }\n').meshes) == 1


@pytest.mark.slow
def test_a_million_triangles_are_read(scene, tmp_path):
    across = 708
    x, y = np.meshgrid(np.arange(across), np.arange(across))
    points = np.stack([x, y, 5.0 * np.sin(x / 9.0) * np.cos(y / 7.0)], -1).reshape(-1, 3)
    k = (np.arange(across - 1)[:, None] * across + np.arange(across - 1)).reshape(-1)
    faces = np.concatenate([np.stack([k, k + 1, k + across], -1), np.stack([k + 1, k + across + 1, k + across], -1)])
    trimesh.Trimesh(points, faces, process=False).export(tmp_path / "a.ply")
    scene('[[mesh]]\nfile = "a.ply"\n').meshes[0].distance(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))   # compiled
    start = time.process_time()
    mesh, = scene('[[mesh]]\nfile = "a.ply"\nposition = [-350, -350, -900]\n').meshes
    found = mesh.distance(np.zeros((1, 3)), np.array([[0.0, 0.0, -1.0]]))
    print(f"{len(faces)} triangles in {time.process_time() - start:.2f} s")
    assert len(mesh.triangles) == 999_698
    assert found[0] == pytest.approx(900.0 - 5.0 * np.sin(350.0 / 9.0) * np.cos(50.0), abs=0.05)
    assert isinstance(mesh, lb.Mesh)
