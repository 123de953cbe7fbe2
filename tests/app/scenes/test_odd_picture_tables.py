"""Tables of scene files that name pictures, with odd values of every kind: a scene or one line, never anything else."""

import math

import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from PIL import Image as Picture

from lensbench.app.scenes.scene_file import SceneFileError, load_scene

KEYS = {
    "photograph": ("image", "depth", "fov", "depth_is", "near", "far", "fill", "holes"),
    "sky": ("image", "turn", "brightness", "zenith", "horizon", "ground", "up"),
    "floor": ("texture", "height", "tile", "light", "dark", "gloss", "normal", "turn", "offset"),
    "sun": ("direction", "colour", "angular_radius"),
    "material.a": ("kind", "texture", "colour", "gloss", "pattern"),
}
WHOLE = {"photograph": {"image": '"a.png"', "depth": '"d.png"', "fov": "50", "near": "1000", "far": "2000"},
         "sky": {"image": '"s.exr"'}, "floor": {"texture": '"a.png"'}, "sun": {"direction": "[0, 1, 0]"},
         "material.a": {"texture": '"a.png"'}}
FILES = st.sampled_from([f'"{name}"' for name in (
    "a.png", "d.png", "z.exr", "s.exr", "phone.jpg", "odd.toml", "none.png", ".", "", "..", "a\\u0000b", "x" * 300,
    "c:\\\\a.png", "folder")])
NUMBERS = st.sampled_from([
    "0", "-1", "1e308", "-1e308", "1e-308", "nan", "inf", "-inf", "9" * 400, "1e9", "180", "360", "0x7fffffffffffffff",
    "-0.0", "true", "false"])
OTHERS = st.sampled_from([
    '"1 m"', '"-1 m"', '"1e999 m"', '"m"', '"#ffffff"', '"#xyz"', '"matte"', '"lamp"', '"glass"', "[]", "{}", "[[]]",
    "[1, 2, 3]", "[0, 0, 0]", "[nan, 1, 1]", '["1 m", "2 m", "3 m"]', "[1e308, 1, 1]", "[true, 1, 1]", "{ kind = 1 }",
    '{ kind = "star", columns = [] }', '{ kind = "checker" }', '{ kind = "checker", columns = 1e9, rows = nan }',
    "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", '"distance"', '"disparity"', '"shown"'])


@st.composite
def tables(draw):
    """A table of `KEYS`: whole but for up to three keys, whose values are odd; and its name."""
    name = draw(st.sampled_from(sorted(KEYS)))
    odd = draw(st.dictionaries(st.sampled_from(KEYS[name]), FILES | NUMBERS | OTHERS, min_size=1, max_size=3))
    return name, WHOLE[name] | odd


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("odd")
    ramp = np.repeat(np.linspace(0.1, 1.0, 16)[None], 8, 0)
    Picture.fromarray(np.full((8, 16, 3), 188, np.uint8)).save(place / "a.png")
    Picture.fromarray(np.full((8, 16, 3), 188, np.uint8)).save(place / "phone.jpg")
    Picture.fromarray(np.uint16(ramp * 65535)).save(place / "d.png")
    OpenEXR.File({}, {"Z": np.ascontiguousarray(ramp, np.float32)}).write(str(place / "z.exr"))
    OpenEXR.File({}, {"RGB": np.ones((8, 16, 3), np.float32)}).write(str(place / "s.exr"))
    (place / "folder").mkdir()
    return place


def outcome(folder, text):
    """The scene of a text, or the one line of its refusal."""
    (folder / "odd.toml").write_text(text)
    try:
        return load_scene(folder / "odd.toml")
    except SceneFileError as error:
        assert "\n" not in str(error) and len(str(error)) < 700
        return str(error)


@settings(deadline=None, max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tables())
def test_odd_values_give_a_scene_or_one_line(folder, table):
    name, values = table
    ball = "" if name == "photograph" else "\n[[sphere]]\ncentre = [0, 0, -1000]\nradius = 100\n"
    found = outcome(folder, f"[{name}]\n" + "".join(f"{key} = {value}\n" for key, value in values.items()) + ball)
    if not isinstance(found, str):
        assert all(map(math.isfinite, found.depth_range))


@pytest.mark.parametrize("value", ["[]", "{}", "1", "true", '""', "[[1]]", "nan", "1979-05-27"])
@pytest.mark.parametrize("key", ["unit", "size", "scale", "rotation", "position", "smooth", "file", "material"])
def test_odd_values_of_a_mesh_are_one_line(folder, key, value):
    keys = {"file": '"none.obj"'} | {key: value}
    found = outcome(folder, "[[mesh]]\n" + "".join(f"{name} = {text}\n" for name, text in keys.items()))
    assert isinstance(found, str)
