"""Pictures of meshes: none runs code, all take little memory, and colours and corners are where they belong."""

import io
import subprocess
import tracemalloc

import numpy as np
import pytest
from PIL import EpsImagePlugin, Image as Picture

from lensbench.app.scenes.scene_file import SceneFileError, load_scene
from lensbench.core.kernels.numeric import linear
from tests.app.scenes.mesh_files import carriers, pictured

POSTSCRIPT = (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\n(hole) (w) file closefile\n"
              b"showpage\n")
CARRIERS = ("a.obj", "a.ply", "beside.gltf", "within.gltf", "held.glb")
CODES = np.uint8([[[250, 0, 0], [0, 250, 0]], [[0, 0, 250], [188, 188, 188]]])


def load(folder, name, more=""):
    (folder / "a.toml").write_text(f'[[mesh]]\nfile = "{name}"\n{more}')
    return load_scene(folder / "a.toml").meshes


def encoded(picture, form="PNG", **options):
    stream = io.BytesIO()
    picture.save(stream, form, **options)
    return stream.getvalue()


@pytest.fixture
def opened(monkeypatch):
    """What was opened as PostScript, or started as a process."""
    found = []

    def record(*args, **keys):
        found.append(args)
        raise OSError("caught")

    monkeypatch.setattr(EpsImagePlugin.EpsImageFile, "_open", record)
    monkeypatch.setattr(subprocess, "Popen", record)
    return found


@pytest.mark.parametrize("name", CARRIERS)
def test_a_picture_that_is_postscript_is_never_opened_as_such(tmp_path, opened, name):
    assert carriers(tmp_path, POSTSCRIPT) == CARRIERS
    with pytest.raises(SceneFileError, match="no picture of the kinds PNG.*or give the mesh a material") as caught:
        load(tmp_path, name)
    assert "\n" not in str(caught.value)
    assert len(load(tmp_path, name, 'material = { kind = "matte" }\n')) == 1
    assert not opened
    with pytest.raises(OSError):                # the trap is where a library without a list of formats falls into it
        Picture.open(io.BytesIO(POSTSCRIPT))
    assert opened


@pytest.mark.parametrize("name", CARRIERS)
def test_a_picture_has_its_linear_colours_and_its_places(tmp_path, name):
    carriers(tmp_path, encoded(Picture.fromarray(CODES)))
    mesh, = load(tmp_path, name)
    np.testing.assert_allclose(mesh.material.pattern.image.values, linear(CODES / 255.0), atol=1e-6)
    places = np.frombuffer(mesh.uv, np.float32).reshape(-1, 2)
    np.testing.assert_allclose(places, mesh.points[:, :2] / np.abs(mesh.points).max(), atol=1e-6)


@pytest.mark.parametrize("name", CARRIERS)
def test_exif_does_not_turn_a_picture_whose_places_count_stored_texels(tmp_path, name):
    exif = Picture.Exif()
    exif[0x0112] = 6
    larger = Picture.fromarray(CODES.repeat(8, 0).repeat(16, 1))
    carriers(tmp_path, encoded(larger, "JPEG", exif=exif, quality=95, subsampling=0))
    image = load(tmp_path, name)[0].material.pattern.image
    assert (image.width, image.height) == (32, 16)
    np.testing.assert_allclose(image.values[4, 8], linear(np.array([250, 0, 0]) / 255.0), atol=0.03)


@pytest.mark.parametrize("name", ("a.obj", "held.glb"))
def test_a_picture_of_many_pixels_is_refused_before_it_is_decoded(tmp_path, name):
    carriers(tmp_path, encoded(Picture.new("1", (13_000, 13_000))))
    tracemalloc.start()
    with pytest.raises(SceneFileError, match="more than 67 million pixels"):
        load(tmp_path, name)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50 << 20


def test_the_pictures_of_a_file_share_their_texels(tmp_path, monkeypatch):
    monkeypatch.setattr("lensbench.app.scenes.mesh_file.MOST_TEXELS", 64 * 32)
    light = np.uint8(np.random.default_rng(1).integers(0, 2, (64, 64, 3)) * 255)
    (tmp_path / "a.png").write_bytes(encoded(Picture.fromarray(light)))
    (tmp_path / "a.gltf").write_bytes(pictured({"uri": "a.png"}).gltf())
    image = load(tmp_path, "a.gltf")[0].material.pattern.image
    assert image.width * image.height <= 64 * 32
    np.testing.assert_allclose(image.values.mean((0, 1)), (light / 255.0).mean((0, 1)), atol=0.02)


def test_a_texture_transform_moves_the_places(tmp_path):
    """The example of the extension: the lower left quadrant, turned clockwise by 90°."""
    carriers(tmp_path, encoded(Picture.fromarray(CODES)))
    uv = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "<f4")
    change = {"offset": [0.0, 1.0], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    (tmp_path / "t.gltf").write_bytes(pictured({"uri": "p.png"}, uv,
                                               extensions={"KHR_texture_transform": change}).gltf())
    places = np.frombuffer(load(tmp_path, "t.gltf")[0].uv, np.float32).reshape(-1, 2)
    np.testing.assert_allclose(places, [[0.0, 0.0], [0.0, 0.5], [0.5, 0.0]], atol=1e-6)     # from the lower left corner


@pytest.mark.parametrize("wrap", [33071, 33648])
def test_a_picture_that_does_not_repeat_is_refused_where_that_shows(tmp_path, wrap):
    carriers(tmp_path, encoded(Picture.fromarray(CODES)))
    for most, matters in ((1.0, False), (1.5, True)):
        tree = pictured({"uri": "p.png"}, np.array([[0.0, 0.0], [most, 0.0], [0.0, 1.0]], "<f4"))
        tree.tree |= {"samplers": [{"wrapS": wrap}], "textures": [{"source": 0, "sampler": 0}]}
        (tmp_path / "w.gltf").write_bytes(tree.gltf())
        if not matters:
            assert len(load(tmp_path, "w.gltf")) == 1
            continue
        with pytest.raises(SceneFileError, match=r"clamped or mirrored .*\(wrapS\).*; or give the mesh a material"):
            load(tmp_path, "w.gltf")


def test_an_obj_picture_is_multiplied_by_its_colour_and_scaled(tmp_path):
    carriers(tmp_path, encoded(Picture.fromarray(CODES)))
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd -s 2 4 1 -o 0.25 0 -clamp on p.png\n")
    mesh, = load(tmp_path, "a.obj")
    assert mesh.material.colour == pytest.approx((0.2140411,) * 3, abs=1e-6)
    places = np.frombuffer(mesh.uv, np.float32).reshape(-1, 2)
    np.testing.assert_allclose(sorted(map(tuple, places)), [(0.25, 0.0), (0.25, 4.0), (2.25, 0.0)])
