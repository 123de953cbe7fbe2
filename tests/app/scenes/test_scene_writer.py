"""A scene that is written opens to the same scene: shipped, made by code, and of files elsewhere."""

import tomllib
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image

import lensbench as lb
from lensbench.app.scenes.opened_scenes import mesh_table
from lensbench.app.scenes.scene_file import SceneFileError, find_scene, load_scene
from lensbench.app.scenes.scene_writer import own_scene, save_scene, scene_text


@pytest.fixture(autouse=True)
def own_data(tmp_path, monkeypatch):
    """The program's own scenes go to a folder of the test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def assert_same(written, scene):
    """Equal, but for the last bit of unit normals, which a reader makes unit again, and of angles, which are degrees in
    a file; disks follow the rectangles.
    """
    assert len(written.meshes) == len(scene.meshes)
    for mine, theirs in zip(written.meshes, scene.meshes, strict=True):
        one, other = (np.frombuffer(mesh.normals, np.float32) for mesh in (mine, theirs))
        np.testing.assert_allclose(one, other, atol=2e-7)
        for field in fields(mine):
            if field.name != "normals":
                assert getattr(mine, field.name) == getattr(theirs, field.name), field.name
    plain = []
    for each in (written, scene):
        plates = sorted(each.plates, key=lambda plate: plate.round)
        spins = [shape.spin for shape in (*each.spheres, *plates)]
        rest = [tuple(replace(shape, spin=(0.0, 0.0, 0.0)) for shape in shapes) for shapes in (each.spheres, plates)]
        plain.append((replace(each, meshes=(), spheres=rest[0], plates=rest[1]), spins))
    np.testing.assert_allclose(plain[0][1], plain[1][1], rtol=4e-16)
    for field in fields(lb.Scene):
        assert getattr(plain[0][0], field.name) == getattr(plain[1][0], field.name) or field.name == "notes", field.name


@pytest.mark.parametrize("name", lb.SCENES)
def test_a_shipped_scene_that_is_saved_opens_to_the_same_scene(tmp_path, name):
    (tmp_path / "kept").mkdir()
    save_scene(name, tmp_path / "kept" / "mine.toml")
    for path in (tmp_path / "data").rglob("*.*"):
        path.unlink()                                       # what was saved needs nothing of the program's own folder
    assert_same(load_scene(tmp_path / "kept" / "mine.toml"), find_scene(name))


def test_a_scene_of_files_elsewhere_is_saved_with_copies_of_all_that_they_name(tmp_path):
    for name in ("far", "near"):
        (tmp_path / name).mkdir()
    (tmp_path / "far" / "a.obj").write_text("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                                            "usemtl m\nf 1/1 2/2 3/3\n")
    (tmp_path / "far" / "a.mtl").write_text("newmtl m\nmap_Kd deep/p.png\n")
    (tmp_path / "far" / "deep").mkdir()
    Image.new("RGB", (4, 4), (200, 100, 50)).save(tmp_path / "far" / "deep" / "p.png")
    own = own_scene(mesh_table(tmp_path / "far" / "a.obj", 50.0), "a")
    assert save_scene(str(own), tmp_path / "near" / "b.toml") == ["a.obj", "a.mtl", "p.png"]
    assert save_scene(str(own), tmp_path / "c.toml") == []                  # they lie below
    scene = load_scene(own)
    (tmp_path / "far" / "a.mtl").unlink()
    assert load_scene(tmp_path / "near" / "b.toml") == scene
    assert tomllib.loads((tmp_path / "c.toml").read_text())["mesh"][0]["file"] == "far/a.obj"


def test_a_scene_that_is_saved_in_its_folder_keeps_its_comments(tmp_path):
    (tmp_path / "a.toml").write_text("# Mine\n[floor]\n")
    assert save_scene(str(tmp_path / "a.toml"), tmp_path / "b.toml") == []
    assert (tmp_path / "b.toml").read_text() == "# Mine\n[floor]\n"


def test_only_the_program_s_own_scenes_name_files_elsewhere(tmp_path):
    (tmp_path / "a.ply").write_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                    "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    table = mesh_table(tmp_path / "a.ply")
    assert load_scene(own_scene(table, "a")).meshes
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "a.toml").write_text(scene_text(table))
    with pytest.raises(SceneFileError, match="name it relative to the scene file"):
        load_scene(tmp_path / "below" / "a.toml")


@given(st.dictionaries(st.text(max_size=9), st.recursive(
    st.booleans() | st.integers(-9, 9) | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=9),
    lambda part: st.lists(part, max_size=3) | st.dictionaries(st.text(max_size=5), part, max_size=3), max_leaves=9)))
def test_a_table_that_is_written_is_read_again(table):
    assert tomllib.loads(scene_text(table)) == table


@pytest.mark.parametrize(("up", "flat"), [("y", 1), ("z", 2), ("-z", 2)])
def test_a_mesh_that_is_flat_along_its_height_stands_upright(tmp_path, up, flat):
    corners = np.insert([[-1, -1], [1, -1], [1, 1], [-1, 1]], flat, 0, axis=1)
    path = tmp_path / "plane.obj"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3 4\n")
    scene = load_scene(own_scene(mesh_table(path, up=up), path.stem))
    (mesh,) = scene.meshes
    assert np.ptp(mesh.points, axis=0)[1] == pytest.approx(300.0, rel=1e-5)
    assert scene.subject[0] < 2000.0
    path.write_text("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n")
    with pytest.raises(lb.SceneError):
        mesh_table(path, up=up)


def test_files_of_one_name_from_two_folders_stay_apart(tmp_path):
    for folder, colour in (("a", (255, 0, 0)), ("b", (0, 0, 255))):
        (tmp_path / folder).mkdir()
        Image.new("RGB", (4, 4), colour).save(tmp_path / folder / "t.png")
    ball = '[[sphere]]\ncentre = [{}, 0, -900]\nradius = 100\nmaterial = {{ kind = "matte", texture = "{}" }}\n'
    source = tmp_path / "scene.toml"
    source.write_text("".join(ball.format(i, name) for i, name in enumerate(("a/t.png", "b/t.png", "a/t.png"))))
    saved = tmp_path / "elsewhere" / "copy.toml"
    saved.parent.mkdir()
    assert save_scene(str(source), saved) == ["t.png", "t.png"]
    assert load_scene(saved).spheres == load_scene(source).spheres
