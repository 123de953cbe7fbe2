"""Mesh files that claim much, polygons of every form, and random files: right, or one line, in little time."""

import json
import logging
import random
import re
import time
import warnings

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.scenes.scene_file import SceneFileError, load_scene
from tests.app.scenes.mesh_files import CORNERS, Tree, carriers, pictured

FEW, MANY = 300, 5000


def load(folder, name, more=""):
    (folder / "a.toml").write_text(f'[[mesh]]\nfile = "{name}"\n{more}')
    return load_scene(folder / "a.toml").meshes


def area(meshes):
    return sum(4.0 * mesh.area for mesh in meshes)


# Polygons

SHAPES = {      # corners, and the area by hand
    "arrow": ([(0, 0), (2, 0), (0.5, 0.5), (0, 2)], 1.0),
    "house without a corner": ([(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)], 2.5),
    "L": ([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 3.0),
    "comb": ([(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 11.0),
    "hexagon": ([(1, 0), (2, 0), (3, 1), (2, 2), (1, 2), (0, 1)], 4.0)}


@pytest.mark.parametrize("form", ["obj", "ply"])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_polygon_of_any_form_has_its_area_from_every_first_corner(tmp_path, form, shape):
    """A law: triangles of one side that add up to the polygon's own area do not overlap."""
    flat, expected = SHAPES[shape]
    turned, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    for first in range(len(flat)):
        for way in (1, -1):
            corners = np.roll(np.pad(np.array(flat, float), ((0, 0), (0, 1))), first, 0)[::way] @ turned * 100.0
            rows = ["{:.9f} {:.9f} {:.9f}".format(*corner) for corner in corners]
            if form == "obj":
                text = [f"v {row}" for row in rows] + ["f " + " ".join(f"{k - len(rows)}" for k in range(len(rows)))]
            else:
                text = ["ply", "format ascii 1.0", f"element vertex {len(rows)}",
                        *[f"property double {axis}" for axis in "xyz"], "element face 1",
                        "property list uchar int vertex_index", "end_header", *rows,
                        f"{len(rows)} " + " ".join(map(str, range(len(rows))))]
            (tmp_path / f"a.{form}").write_text("\n".join(text) + "\n")
            mesh, = load(tmp_path, f"a.{form}")
            assert 4.0 * mesh.area == pytest.approx(expected * 1e4, rel=1e-5)
            a, b, c = (mesh.points[mesh.triangles[:, k]].astype(float) for k in range(3))
            assert np.linalg.norm(np.cross(b - a, c - a).sum(0)) / 2.0 == pytest.approx(expected * 1e4, rel=1e-5)


def test_without_its_library_a_concave_polygon_names_what_to_install(tmp_path, monkeypatch):
    import sys
    flat, _ = SHAPES["L"]
    (tmp_path / "a.obj").write_text("".join(f"v {x} {y} 0\n" for x, y in flat) + "f 1 2 3 4 5 6\n")
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    with pytest.raises(SceneFileError, match=r"mapbox_earcut: pip install lensbench\[mesh\]"):
        load(tmp_path, "a.obj")


# OBJ and PLY

def test_an_obj_with_joined_lines_mixed_corners_and_tabs_is_read(tmp_path):
    (tmp_path / "a.obj").write_bytes(
        b"# by hand\r\no thing\r\nv 0 0 0 1 0 0\r\n  v\t1 0 0 0 1 0\r\nv 1 1 0 0 0 1\r\nv 0 1 0 1 1 1\r\nvt 0.5\r\n"
        b"vn 0 0 1\r\nf 1//1 2//1 \\\r\n 3//1\r\ns off\r\nf -4/1/-1 -2 -1/-1\r\nl 1 2\r\n")
    mesh, = load(tmp_path, "a.obj")
    assert area([mesh]) == pytest.approx(1.0) and len(mesh.triangles) == 2
    colours = np.frombuffer(mesh.colours, np.float32).reshape(-1, 3)
    np.testing.assert_allclose(colours[(mesh.points == (1, 0, 0)).all(1)], [[0.0, 1.0, 0.0]])


@pytest.mark.parametrize(("form", "order"),
                         [("ascii", "<"), ("binary_little_endian", "<"), ("binary_big_endian", ">")])
def test_a_ply_of_triangles_and_quads_has_colours_of_its_faces(tmp_path, form, order):
    """Lists of different lengths, a column after them, and colours of faces, which triangles do not share."""
    head = (f"ply\nformat {form} 1.0\ncomment made by hand\nelement vertex 5\nproperty float x\nproperty float y\n"
            "property float z\nelement face 2\nproperty list uchar uint vertex_indices\nproperty uchar red\n"
            "property uchar green\nproperty uchar blue\nend_header\n").encode()
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
    faces = [([0, 1, 2, 3], [255, 0, 0]), ([1, 4, 2], [0, 0, 255])]
    if form == "ascii":
        rows = [" ".join(map(str, row)) for row in points.tolist() + [[len(f), *f, *c] for f, c in faces]]
        body = "\n".join(rows).encode()
    else:
        body = points.astype(order + "f4").tobytes() + b"".join(
            bytes([len(f)]) + np.array(f, order + "u4").tobytes() + bytes(c) for f, c in faces)
    (tmp_path / "a.ply").write_bytes(head + body)
    mesh, = load(tmp_path, "a.ply")
    colours = np.frombuffer(mesh.colours, np.float32).reshape(-1, 3)[mesh.triangles]
    assert area([mesh]) == pytest.approx(1.5)
    np.testing.assert_allclose(colours[:, 0], [[1, 0, 0], [1, 0, 0], [0, 0, 1]])
    assert (colours == colours[:, :1]).all()
    for length in (len(head) + 3, len(head) + len(body) - 4):
        (tmp_path / "a.ply").write_bytes((head + body)[:length])
        with pytest.raises(SceneFileError, match="damaged"):
            load(tmp_path, "a.ply")


# Files that claim much

def write_groups(folder, shades):
    """An OBJ of 20,000 triangles, each of its own material, of so many colours."""
    count = 20_000
    (folder / "a.obj").write_text("mtllib a.mtl\n" + "".join(
        f"v {k} 0 0\nv {k} 1 0\nv {k + 1} 0 0\nusemtl m{k}\nf {3 * k + 1} {3 * k + 2} {3 * k + 3}\n"
        for k in range(count)))
    (folder / "a.mtl").write_text("".join(
        f"newmtl m{k}\nKd {k % shades / shades} 0.5 0.5\n" for k in range(count)))
    return "a.obj"


def write_chain(folder, count=30_000):
    """A glTF file whose every node is the child of the one before, and shows the same triangle."""
    tree = Tree()
    tree.mesh(POSITION=tree.accessor(CORNERS, "VEC3"))
    tree.tree["nodes"] = [{"mesh": 0, "translation": [0, 0, 0.001], "children": [k + 1]} for k in range(count - 1)]
    tree.tree["nodes"].append({"mesh": 0, "translation": [0, 0, 0.001]})
    (folder / "chain.gltf").write_bytes(tree.gltf())
    return "chain.gltf"


def write_copies(folder, nodes=5000):
    """Many nodes that each show a mesh of 41,000 triangles."""
    tree = Tree()
    tree.mesh(POSITION=tree.accessor(np.random.default_rng(1).random((123_000, 3)).astype("<f4"), "VEC3"))
    tree.tree |= {"nodes": [{"mesh": 0}] * nodes, "scenes": [{"nodes": list(range(nodes))}]}
    (folder / "copies.glb").write_bytes(tree.glb())
    return "copies.glb"


def write_crossed(folder, count=40_000):
    """A polygon that crosses itself at random."""
    rng = np.random.default_rng(1)
    points = "".join("v {:.6f} {:.6f} 0\n".format(*point) for point in rng.random((count, 2)))
    (folder / "crossed.obj").write_text(points + "f " + " ".join(map(str, range(1, count + 1))) + "\n")
    return "crossed.obj"


def write_nest(folder):
    """JSON of 5 million empty lists."""
    (folder / "nest.gltf").write_bytes(b'{"asset": [' + b"[]," * 5_000_000 + b"[]]}")
    return "nest.gltf"


@pytest.mark.parametrize(("write", "outcome"), [
    (lambda folder: write_groups(folder, 20_000), "20 ?000 materials"), (lambda folder: write_groups(folder, 100), 100),
    (write_chain, 1), (write_copies, "claims more than .* triangles"), (write_crossed, "concave|inward corners"),
    (write_nest, "values of JSON")])
def test_a_file_that_claims_much_is_read_soon_or_refused(tmp_path, write, outcome):
    """Processor time, which other work on the machine lengthens little: 10 s are allowed."""
    name = write(tmp_path)
    start = time.process_time()
    if isinstance(outcome, int):
        assert len(load(tmp_path, name)) == outcome
    else:
        with pytest.raises(SceneFileError, match=outcome) as caught:
            load(tmp_path, name)
        assert "\n" not in str(caught.value)
    assert time.process_time() - start < 10.0


def test_the_meshes_of_a_scene_are_bounded_together(tmp_path, monkeypatch):
    from PIL import Image as Picture
    Picture.new("RGB", (32, 32)).save(tmp_path / "p.png")
    (tmp_path / "b.glb").write_bytes(pictured({"uri": "p.png"}).glb())
    twice = '[[mesh]]\nfile = "b.glb"\n'
    assert len(load(tmp_path, "b.glb", twice)) == 2
    for name, most, reason in (("scene_file.MOST_TRIANGLES", 1, "more than 1 triangles together"),
                               ("asset_files.MOST_TEXELS", 2047, "texels together"),
                               ("scene_file.MOST_OBJECTS", 1, "more than 1 objects")):
        with monkeypatch.context() as changed:
            changed.setattr(f"lensbench.app.scenes.{name}", most)
            with pytest.raises(SceneFileError, match=reason):
                load(tmp_path, "b.glb", twice)


def test_a_chain_of_nodes_adds_its_moves(tmp_path):
    mesh, = load(tmp_path, write_chain(tmp_path, 3000))
    np.testing.assert_allclose(np.unique(mesh.points[:, 2]), np.arange(1.0, 3001.0), rtol=1e-5)


# Random files

JSON_VALUES = (None, True, "text", "", [], {}, -1, 0, 3, 5126, 1e308, 10 ** 400, 2 ** 31, 2 ** 62, [1, 2, 3], [[]],
               {"a": 1}, "p.png", "../p.png", "data:,", "data:;base64,!", "VEC3", "MAT4", float("nan"), "/dev/zero",
               ["KHR_draco_mesh_compression"])
WORDS = ("v", "vt", "vn", "f", "usemtl", "mtllib", "1", "-1", "0", "1/1/1", "1//1", "nan", "1e999", "\\", "9" * 20, "m",
         "a.mtl", "../a.mtl", "l", "curv", "#", "\x1b[31m", "map_Kd", "newmtl", "Kd", "-s", "-o", "p.png",
         "/etc/passwd", "spectral", "ply", "format",
         "element", "property", "list", "uchar", "int", "float", "end_header",
         "vertex",
         "face", "1000000000", "-3")
MORE = ("", "", 'size = "1 m"\n', "smooth = true\n", 'material = { kind = "coat" }\n')


def changed_json(rng, value):
    """The value with one part of it replaced, lost or doubled."""
    if rng.random() < 0.15 or not isinstance(value, dict | list) or not value:
        return rng.choice(JSON_VALUES)
    if isinstance(value, list):
        k = rng.randrange(len(value))
        return value[:k] + [changed_json(rng, value[k])] * rng.choice((0, 1, 1, 1, 1, 2)) + value[k + 1:]
    key = rng.choice(list(value))
    return {k: changed_json(rng, v) if k == key else v for k, v in value.items()}


def changed_text(rng, data):
    """Text with words or lines replaced, lost or doubled; or bytes."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        way = rng.random()
        if way < 0.6:
            words = re.split(rb"(\s+)", data)
            k = rng.randrange(len(words))
            data = b"".join((*words[:k], rng.choice(WORDS).encode(), *words[k + rng.choice((0, 1)):]))
        elif way < 0.8:
            lines = data.split(b"\n")
            k = rng.randrange(len(lines))
            data = b"\n".join(lines[:k] + [lines[k]] * rng.choice((0, 2, 9)) + lines[k + 1:])
        else:
            k = rng.randrange(len(data) + 1)
            data = data[:k] + rng.choice((b"", rng.randbytes(3), b"\0" * 40)) + data[k + rng.choice((0, 1, 30)):]
    return data


def rich():
    """A glTF tree with nodes, a skin, morph targets, colours, places, a picture and a sparse accessor."""
    tree = pictured({"uri": "p.png"}, extensions={"KHR_texture_transform": {"offset": [0, 1], "scale": [1, 1]}})
    primitive = tree.tree["meshes"][0]["primitives"][0]
    primitive["attributes"] |= {
        "COLOR_0": tree.accessor(np.uint8([[255, 0, 9, 9]] * 3), "VEC4", normalized=True),
        "NORMAL": tree.accessor(np.array([[0, 0, 1]] * 3, "<f4"), "VEC3"),
        "JOINTS_0": tree.accessor(np.uint8([[0, 1, 0, 0]] * 3), "VEC4"),
        "WEIGHTS_0": tree.accessor(np.array([[0.5, 0.5, 0, 0]] * 3, "<f4"), "VEC4")}
    primitive |= {"indices": tree.accessor(np.array([0, 1, 2], "<u2"), "SCALAR"), "mode": 4,
                  "targets": [{"POSITION": tree.accessor(CORNERS, "VEC3")}]}
    tree.tree |= {"nodes": [{"mesh": 0, "skin": 0, "weights": [0.5], "children": [1, 2]}, {"rotation": [0, 0, 0, 1]},
                            {"translation": [1, 2, 3], "scale": [1, 2, 1], "mesh": 0}, {"matrix": [1.0] * 16}],
                  "extensionsUsed": ["KHR_texture_transform"], "samplers": [{}],
                  "skins": [{"joints": [1, 2], "inverseBindMatrices": tree.accessor(
                      np.tile(np.eye(4), (2, 1, 1)).reshape(2, 16).astype("<f4"), "MAT4")}]}
    tree.tree["accessors"][0]["sparse"] = {
        "count": 1, "indices": {"bufferView": tree.view(b"\1\0"), "componentType": 5123},
        "values": {"bufferView": tree.view(np.ones(3, "<f4").tobytes())}}
    return tree


def fuzz(folder, monkeypatch, caplog, times, seed):
    """Load so many random mesh files; those that can be read, and the longest time."""
    from PIL import Image as Picture
    Picture.new("RGB", (4, 4)).save(folder / "white.png")
    names = carriers(folder, (folder / "white.png").read_bytes())
    whole = {name: (folder / name).read_bytes() for name in (*names, "a.mtl")}
    kept = set(folder.iterdir())
    started = []
    monkeypatch.setattr("subprocess.Popen", lambda *args, **keys: started.append(args))
    rng, read, longest = random.Random(seed), 0, 0.0
    for number in range(times):
        for name, data in whole.items():
            (folder / name).write_bytes(data)
        name = rng.choice((*names, "a.mtl", "rich.gltf", "rich.glb", "rich.gltf", "rich.glb"))
        kind = name
        if name == "a.mtl":
            (folder / name).write_bytes(changed_text(rng, whole[name]))
            kind = "a.obj"
        elif name.startswith("rich"):
            tree = rich()
            for _ in range(rng.choice((1, 1, 2, 4))):
                tree.tree = changed_json(rng, tree.tree)
                if not isinstance(tree.tree, dict):
                    tree.tree = {}
            (folder / name).write_bytes(tree.gltf() if name.endswith("gltf") else tree.glb())
        else:
            (folder / name).write_bytes(changed_text(rng, whole[name]))
        start = time.process_time()
        try:
            meshes = load(folder, kind, rng.choice(MORE))
            read += 1
            assert all(isinstance(mesh, lb.Mesh) and np.isfinite(mesh.points).all() for mesh in meshes)
        except SceneFileError as error:
            assert "\n" not in str(error) and len(str(error)) < 700, number
        longest = max(longest, time.process_time() - start)
        assert not started and not caplog.records
    assert set(folder.iterdir()) <= kept | {folder / name for name in ("a.toml", "rich.gltf", "rich.glb")}
    return read, longest


def test_the_whole_file_of_the_fuzz_can_be_read(tmp_path):
    from PIL import Image as Picture
    Picture.new("RGB", (4, 4)).save(tmp_path / "p.png")
    (tmp_path / "rich.glb").write_bytes(rich().glb())
    (tmp_path / "rich.gltf").write_bytes(json.dumps(json.loads(rich().gltf())).encode())
    assert [len(load(tmp_path, name)) for name in ("rich.glb", "rich.gltf")] == [1, 1]


@pytest.mark.parametrize("times", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_random_mesh_files_are_meshes_or_one_line(tmp_path, monkeypatch, caplog, capfd, times):
    caplog.set_level(logging.INFO)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read, longest = fuzz(tmp_path, monkeypatch, caplog, times, seed=times)
    assert times * 0.1 < read < times * 0.9 and longest < 10.0
    assert capfd.readouterr() == ("", "")
