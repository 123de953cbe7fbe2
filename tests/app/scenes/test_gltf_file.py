"""glTF: numbers, nodes, skins and colours as its specification says; what is not read is refused by its name."""

import json
import sys

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.scenes.gltf_file import SHARPEST
from lensbench.app.scenes.scene_file import SceneFileError, load_scene
from tests.app.scenes.mesh_files import CORNERS, PLACES, Tree, pictured


def load(folder, tree, form="glb", more=""):
    (folder / f"a.{form}").write_bytes(getattr(tree, form)() if isinstance(tree, Tree) else tree)
    (folder / "a.toml").write_text(f'[[mesh]]\nfile = "a.{form}"\n{more}')
    return load_scene(folder / "a.toml").meshes


def triangle(**attributes):
    tree = Tree()
    return tree.mesh(POSITION=tree.accessor(CORNERS, "VEC3"),
                     **{name: tree.accessor(*value[:2], **(value[2] if len(value) > 2 else {}))
                        for name, value in attributes.items()})


@pytest.mark.parametrize(("rows", "keys"), [
    (np.array([[0.2, 0.5, 1.0]] * 3, "<f4"), {}), (np.uint8([[51, 128, 255, 255]] * 3), {"normalized": True}),
    (np.array([[13107, 32768, 65535]] * 3, "<u2"), {"normalized": True})])
def test_colours_of_vertices_are_linear(tmp_path, rows, keys):
    mesh, = load(tmp_path, triangle(COLOR_0=(rows, "VEC3" if rows.shape[1] == 3 else "VEC4", keys)))
    colours = np.frombuffer(mesh.colours, np.float32).reshape(-1, 3)
    np.testing.assert_allclose(colours, [[0.2, 0.5, 1.0]] * 3, atol=0.002)
    assert mesh.material.colour == (1.0, 1.0, 1.0)


def test_colours_of_vertices_colour_and_picture_of_a_material_count_together(tmp_path):
    from PIL import Image as Picture
    Picture.fromarray(np.full((2, 2, 3), 188, np.uint8)).save(tmp_path / "p.png")
    tree = pictured({"uri": "p.png"})
    tree.tree["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.25, 0.5, 0.123456, 1.0]
    tree.tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = tree.accessor(
        np.full((3, 3), 0.75, "<f4"), "VEC3")
    mesh, = load(tmp_path, tree)
    assert mesh.material.colour == pytest.approx((0.25, 0.5, 0.123456), abs=1e-9)      # not in steps of 1/255
    assert mesh.material.pattern is not None and np.frombuffer(mesh.colours, np.float32) == pytest.approx(0.75)


@pytest.mark.parametrize(("varnish", "kind", "gloss"), [
    ({}, "matte", 1.0), ({"clearcoatFactor": 0.4}, "matte", 1.0), ({"clearcoatFactor": 1}, "coat", 1.0),
    ({"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.375}, "coat", 0.625),
    ({"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 1}, "coat", SHARPEST)])
def test_a_clear_coat_covers_the_colour_of_its_material_alone(tmp_path, varnish, kind, gloss):
    tree = triangle()
    tree.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 1.0]},
                               "extensions": {"KHR_materials_clearcoat": varnish}}]
    tree.tree["meshes"][0]["primitives"][0]["material"] = 0
    material = load(tmp_path, tree)[0].material
    assert material == lb.Material((0.25, 0.5, 0.75), kind, gloss)
    with pytest.raises(SceneFileError, match="clearcoatFactor"):
        tree.tree["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {"clearcoatFactor": "much"}
        load(tmp_path, tree)


@pytest.mark.parametrize(("dtype", "most"), [("u2", 65535), ("i2", 32767), ("u1", 255), ("i1", 127)])
def test_normalized_whole_numbers_are_fractions(tmp_path, dtype, most):
    """KHR_mesh_quantization: a metre stays a metre; whole numbers that are not normalized are themselves."""
    tree = Tree()
    tree.tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    tree.mesh(POSITION=tree.accessor((CORNERS * most).astype(dtype), "VEC3", normalized=True))
    assert load(tmp_path, tree)[0].points.max(0) == pytest.approx((1000.0, 1000.0, 0.0))
    tree = Tree()
    tree.mesh(POSITION=tree.accessor((CORNERS * most).astype(dtype), "VEC3"))
    assert load(tmp_path, tree)[0].points.max(0) == pytest.approx((1000.0 * most, 1000.0 * most, 0.0))


def test_sparse_accessors_replace_rows(tmp_path):
    tree = triangle()
    rows, values = tree.view(np.array([1], "<u2").tobytes()), tree.view(np.array([[5, 0, 0]], "<f4").tobytes())
    tree.tree["accessors"][0]["sparse"] = {"count": 1, "indices": {"bufferView": rows, "componentType": 5123},
                                           "values": {"bufferView": values}}
    assert load(tmp_path, tree)[0].points.max(0) == pytest.approx((5000.0, 1000.0, 0.0))


@pytest.mark.parametrize(("mode", "expected"), [
    (4, [[0, 1, 2], [3, 4, 5]]), (5, [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]),
    (6, [[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 5, 0]])])
def test_lists_strips_and_fans_are_triangles(tmp_path, mode, expected):
    angle = np.arange(6.0) ** 1.2
    points = np.stack([np.cos(angle), np.sin(angle), angle], 1).astype("<f4")
    tree = Tree()
    tree.mesh(POSITION=tree.accessor(points, "VEC3")).tree["meshes"][0]["primitives"][0]["mode"] = mode
    mesh, = load(tmp_path, tree)
    np.testing.assert_allclose(mesh.points[mesh.triangles] / 1000.0, points[expected], atol=1e-6)


def test_skins_and_morph_weights_move_the_vertices(tmp_path):
    """Two joints, 2 m up and turned by 90° about z: the middle of both for half weights. The mesh's own node does not
    count."""
    tree = triangle(JOINTS_0=(np.uint8([[0, 1, 0, 0]] * 3), "VEC4"),
                    WEIGHTS_0=(np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0.5, 0.5, 0, 0]], "<f4"), "VEC4"))
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[:, 2, 3] = 1.0
    tree.tree |= {"nodes": [{"mesh": 0, "skin": 0, "translation": [9, 9, 9], "weights": [0.5]},
                            {"translation": [0, 2, 0]}, {"rotation": [0, 0, 0.5 ** 0.5, 0.5 ** 0.5]}],
                  "scenes": [{"nodes": [0, 1, 2]}]}
    tree.tree["skins"] = [{"joints": [1, 2], "inverseBindMatrices": tree.accessor(
        inverse.transpose(0, 2, 1).reshape(2, 16).astype("<f4"), "MAT4")}]
    moved = tree.accessor(np.array([[0, 0, 0], [2, 0, 0], [0, 0, 0]], "<f4"), "VEC3")
    tree.tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": moved}]
    mesh, = load(tmp_path, tree)
    # (0, 0, 0) → 2 up; (2, 0, 0) → (0, 2, 0); (0, 1, 0) → mean of (0, 3, 0) and (−1, 0, 0); all 1 back
    corners = mesh.points[mesh.triangles[0]] / 1000.0
    np.testing.assert_allclose(corners, [[0, 2, 1], [0, 2, 1], [-0.5, 1.5, 1]], atol=1e-6)


def test_a_mirrored_node_keeps_its_outside_and_a_flat_one_its_normals(tmp_path):
    tree = triangle(NORMAL=(np.array([[0, 0.6, 0.8]] * 3, "<f4"), "VEC3"))
    tree.tree["nodes"][0]["scale"] = [-2.0, 1.0, 1.0]
    mesh, = load(tmp_path, tree)
    a, b, c = mesh.points[mesh.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0.0 and mesh.normals[:12] == np.array([0, 0.6, 0.8], np.float32).tobytes()


def test_draco_is_decoded_or_refused_with_what_to_install(tmp_path, monkeypatch):
    draco = pytest.importorskip("DracoPy")
    rng = np.random.default_rng(1)
    points = np.pad(np.stack(np.meshgrid(*[np.arange(20.0)] * 2), -1).reshape(-1, 2), ((0, 0), (0, 1))) / 20.0
    points[:, 2] = rng.random(400)
    k = (np.arange(19)[:, None] * 20 + np.arange(19)).reshape(-1)
    faces = np.concatenate([np.stack([k, k + 1, k + 20], 1), np.stack([k + 1, k + 21, k + 20], 1)])
    packed = draco.encode(points, faces, quantization_bits=14, colors=np.full((400, 3), 128, np.uint8))
    numbers = {attribute["attribute_type"]: attribute["unique_id"] for attribute in draco.decode(packed).attributes}
    tree = Tree()
    tree.tree |= {"extensionsRequired": ["KHR_draco_mesh_compression"], "accessors": [
        {"componentType": 5126, "count": 400, "type": "VEC3"},
        {"componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        {"componentType": 5121, "count": 400, "type": "VEC3", "normalized": True}]}
    tree.mesh(POSITION=0, COLOR_0=2).tree["meshes"][0]["primitives"][0] |= {"indices": 1, "extensions": {
        "KHR_draco_mesh_compression": {"bufferView": tree.view(packed),
                                       "attributes": {"POSITION": numbers[0], "COLOR_0": numbers[2]}}}}
    mesh, = load(tmp_path, tree)
    a, b, c = points[faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0
    assert 4.0 * mesh.area / 1e6 == pytest.approx(area, rel=1e-3) and len(mesh.triangles) == len(faces)
    assert np.frombuffer(mesh.colours, np.float32) == pytest.approx(128 / 255, abs=1e-6)
    whole = tree.glb()
    at = whole.index(b"DRACO")
    for damaged in (whole[:at + 13] + b"\xff\xff\xff\x7f" + whole[at + 17:], whole[:at + 7] + b"\0" + whole[at + 8:],
                    whole[:at + 200] + bytes(200) + whole[at + 400:]):
        with pytest.raises(SceneFileError, match="Draco data"):
            load(tmp_path, damaged)
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(SceneFileError, match=r"KHR_draco_mesh_compression.* pip install lensbench\[mesh\]"):
        load(tmp_path, whole)


@pytest.mark.parametrize(("change", "reason"), [
    ({"extensionsRequired": ["EXT_meshopt_compression"]}, "'EXT_meshopt_compression'.*without compression"),
    ({"extensionsRequired": ["KHR_texture_basisu"]}, "'KHR_texture_basisu'.*PNG or JPEG"),
    ({"extensionsRequired": ["ACME_new"]}, "'ACME_new', which is not read"),
    ({"extensionsRequired": [7]}, "the extension 7"),
    ({"extensionsRequired": "a"}, "extensionsRequired must be a list"),
    ({"extensionsUsed": ["EXT_mesh_gpu_instancing"]}, "'EXT_mesh_gpu_instancing'.*a node for each instance"),
    ({"asset": {"version": "1.0"}}, "glTF of the version '1.0'"), ({"asset": 3}, "asset must be an object, not 3"),
    ({"nodes": [{"mesh": "0"}]}, "meshes has no entry '0'"), ({"nodes": [{"mesh": True}]}, "meshes has no entry True"),
    ({"nodes": [{"mesh": 0, "scale": [1, 1]}]}, "scale must be a list of 3 finite numbers"),
    ({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 10 ** 400]}]}, "rotation must be a list of 4"),
    ({"nodes": [{"mesh": 0, "matrix": "no"}]}, "matrix must be a list, not 'no'"),
    ({"nodes": [{"children": [0]}]}, "contains itself"), ({"nodes": 5}, "nodes must be a list, not 5"),
    ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 1}]}]}, "points or lines, no triangles"),
    ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 9}]}]}, "mode 9"),
    ({"meshes": [{"primitives": [{"attributes": {}}]}]}, "no POSITION"),
    ({"meshes": [{"primitives": [[]]}]}, r"a primitive must be an object, not \[\]"),
])
def test_what_cannot_be_read_is_one_line_that_names_it(tmp_path, change, reason):
    tree = triangle()
    tree.tree |= change
    with pytest.raises(SceneFileError, match=reason) as caught:
        load(tmp_path, tree, "gltf")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("key", "value", "reason"), [
    ("count", "three", "count must be a whole number, not 'three'"), ("count", -3, "count must be a whole"),
    ("count", 4, "reads beyond its buffer view"), ("count", 1e3, "count must be a whole"),
    ("componentType", "5126", "componentType must be"), ("componentType", 5130, "does not fit"),
    ("type", ["VEC3"], "type must be text"), ("type", "VEC2", "POSITION has 2 numbers"), ("byteOffset", None, "reads"),
    ("byteOffset", 10 ** 30, "reads beyond"), ("normalized", "yes", "normalized must be true or false"),
    ("sparse", [], "sparse must be an object"), ("bufferView", 8, "bufferViews has no entry 8"),
])
def test_a_value_of_an_accessor_that_is_none_is_named(tmp_path, key, value, reason):
    tree = triangle()
    tree.tree["accessors"][0][key] = value
    if value is None:
        tree.tree["accessors"][0][key] = 4
    with pytest.raises(SceneFileError, match=reason) as caught:
        load(tmp_path, tree, "gltf")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("form", ["gltf", "glb"])
def test_a_square_of_a_gltf_file_reads_as_trimesh_reads_it(tmp_path, form):
    """An independent reader and writer: places, nodes and faces of a box."""
    import trimesh

    scene = trimesh.Scene()
    turned = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0.2, 0.3])
    scene.add_geometry(trimesh.creation.box((1.0, 2.0, 3.0)), transform=turned)
    written = scene.export(file_type=form)
    for name, data in (written if form == "gltf" else {"a.glb": written}).items():
        (tmp_path / ("a.gltf" if name.endswith(".gltf") else name)).write_bytes(data)
    (tmp_path / "a.toml").write_text(f'[[mesh]]\nfile = "a.{form}"\n')
    mesh, = load_scene(tmp_path / "a.toml").meshes
    np.testing.assert_allclose([mesh.points.min(0) / 1000, mesh.points.max(0) / 1000], scene.bounds, atol=1e-6)
    assert mesh.area / 1e6 == pytest.approx(22.0 / 4.0) and isinstance(mesh, lb.Mesh)


def test_names_with_escapes_are_read_and_lead_nowhere_else(tmp_path):
    tree = triangle()
    tree.tree["buffers"] = [{"uri": "my%20data.bin", "byteLength": len(tree.data)}]
    (tmp_path / "my data.bin").write_bytes(tree.data)
    assert len(load(tmp_path, json.dumps(tree.tree).encode(), "gltf")) == 1
    for uri in ("%2e%2e/secret.bin", "%2Fetc%2Fpasswd", "a%00b", "http%3A//example.com/a"):
        tree.tree["buffers"][0]["uri"] = uri
        with pytest.raises(SceneFileError, match="outside|relative to|network|no such file"):
            load(tmp_path, json.dumps(tree.tree).encode(), "gltf")


def test_places_beyond_a_material_of_the_scene_do_not_matter(tmp_path):
    tree = pictured({"uri": "gone.png"}, PLACES)
    with pytest.raises(SceneFileError, match="'gone.png': there is no such file; or give the mesh a material"):
        load(tmp_path, tree)
    assert len(load(tmp_path, tree, more='material = { kind = "metal" }\n')) == 1
