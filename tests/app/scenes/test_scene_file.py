"""Scene files: the documented one is read as it says; every mistake is one line that names it."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture, ImageOps

import lensbench as lb
from lensbench.app.scenes import asset_files
from lensbench.app.scenes.scene_file import SceneFileError, find_scene, load_scene

DOCUMENT = Path(__file__).parents[3] / "docs" / "scenes.md"
BALL = '[[sphere]]\ncentre = [0, 0, -1000]\nradius = 50\n'


@pytest.fixture
def write(tmp_path):
    def write(text, name="mine.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path
    return write


def save_picture(path, values):
    Picture.fromarray(np.asarray(values, np.uint8)).save(path)
    return path


def test_the_documented_scene_is_what_it_says(write):
    text = re.search(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.S)[1]
    scene = load_scene(write(text))
    assert scene.name == "Two balls and a window light"
    assert scene.depth_range == (500.0, 6000.0)
    assert scene.floor.tile == 80.0
    assert scene.spheres[0].centre == (-80.0, -120.0, -1200.0)
    assert scene.spheres[1].material == lb.Material((0.93, 0.93, 0.94), "metal")
    assert scene.spheres[0].material.colour == pytest.approx((0.6308, 0.0296, 0.0116), abs=5e-5)   # sRGB by hand
    assert [p.material.kind for p in scene.plates] == ["lamp", "matte", "matte"]
    wheel = scene.plates[2]
    assert wheel.velocity == (400.0, 0.0, 0.0) and wheel.spin[2] * wheel.radius == pytest.approx(-400.0, rel=1e-3)
    assert scene.sun.angular_radius == pytest.approx(np.radians(0.5))
    assert scene.distance([0.0, 0.0, 0.0], [0.0, -0.6, -0.8])[0] == pytest.approx(200.0 / 0.6)     # the floor


def test_a_file_equals_itself_and_the_scene_built_in_python(write):
    path = write(BALL)
    assert load_scene(path) == load_scene(path)
    assert load_scene(path) == lb.Scene("mine", spheres=(lb.Sphere((0.0, 0.0, -1000.0), 50.0),))


def test_what_moves_is_read_in_its_units(write):
    scene = load_scene(write(BALL + 'velocity = ["36 km/h", "-2.5 cm/s", 7]\nspin = [0, 180, -90]\n'
                             'pivot = ["1 m", 0, -1000]\n'))
    assert scene == lb.Scene("mine", spheres=(lb.Sphere(
        (0.0, 0.0, -1000.0), 50.0, velocity=(10000.0, -25.0, 7.0), spin=(0.0, np.pi, -np.pi / 2),
        pivot=(1000.0, 0.0, -1000.0)),))
    assert scene.moves and not load_scene(write(BALL)).moves
    facing = "centre = [0, 0, -9]\ntarget = [0, 0, 0]\nwidth = 1\nheight = 1\nvelocity = [1, 2, 3]\n"
    assert load_scene(write(f"[[rectangle]]\n{facing}")).plates[0].velocity == (1.0, 2.0, 3.0)


def test_a_scene_is_found_by_its_name_or_its_path(write):
    assert find_scene("still-life") is lb.builtin_scene("still-life")
    path = write(BALL)
    assert find_scene(str(path)) == load_scene(path)
    with pytest.raises(SceneFileError, match="did you mean still-life"):
        find_scene("stil-life")
    with pytest.raises(SceneFileError, match="lensbench scenes lists the names"):
        find_scene("xyzzy")


@pytest.mark.parametrize(("text", "length"), [("1.2 m", 1200.0), ("35mm", 35.0), ("12 cm", 120.0), ("0.5km", 5e5),
                                              ("7", 7.0), ("1e2 mm", 100.0)])
def test_lengths_may_carry_a_unit(write, text, length):
    assert load_scene(write(BALL.replace("50", f'"{text}"'))).spheres[0].radius == pytest.approx(length)


MISTAKES = {
    "radius = 0": (BALL.replace("50", "0"), r"sphere 1: radius of a sphere is 0: it must be positive"),
    "negative radius": (BALL.replace("50", "-3"), r"sphere 1: .*positive"),
    "nan": (BALL.replace("50", "nan"), r"sphere 1: radius is nan"),
    "inf": (BALL.replace("-1000", "-inf"), r"sphere 1: centre is -inf"),
    "a huge integer": (BALL.replace("50", "1" + "0" * 400), r"sphere 1: radius"),
    "an endless integer": (BALL.replace("50", "1" * 5000), r"not TOML"),
    "text for a number": (BALL.replace("50", '"wide"'), r"radius 'wide': write a length"),
    "an unknown unit": (BALL.replace("50", '"2 ft"'), r"radius '2 ft'"),
    "true for a number": (BALL.replace("50", "true"), r"radius must be a number"),
    "two coordinates": (BALL.replace("0, 0, -1000", "0, -1000"), r"centre must be a list of 3"),
    "no centre": ("[[sphere]]\nradius = 3\n", r"sphere 1: centre is missing"),
    "an unknown key": (BALL + "radios = 3\n", r"sphere has no 'radios': did you mean radius"),
    "an unknown table": (BALL + "[[cone]]\n", r"a scene file has no 'cone' \(known: name, .* disk\)"),
    "a lens": ("format = 1\n[surfaces]\n", r"this is a lens file: a scene file is TOML that holds name, .* disk"),
    "settings": ('version = 1\nlens = "a"\n', r"this is a settings file: a scene file is TOML that holds"),
    "one bracket": (BALL.replace("[[sphere]]", "[sphere]"), r"write \[\[sphere\]\]"),
    "an unknown material": (BALL + 'material = "gold"\n', r"write a table \[material.gold\]"),
    "an unknown kind": (BALL + 'material = { kind = "velvet" }\n', r"'velvet': choose one of matte, coat"),
    "a colour above 1": (BALL + "material = { colour = [2, 0, 0] }\n", r"colour: its numbers must lie between 0 and 1"),
    "a colour below 0": (BALL + 'material = { kind = "lamp", colour = [-2, 0, 0] }\n', r"colour: .*negative"),
    "a colour by name": (BALL + 'material = { colour = "red" }\n', r"colour 'red': write a colour as"),
    "a speed in knots": (BALL + 'velocity = ["5 kn", 0, 0]\n', r"velocity '5 kn': write a speed .*km/h"),
    "a spin about nothing": (BALL + "spin = 3\n", r"spin must be a list of 3 numbers"),
    "a misspelt motion": (BALL + "velocty = [1, 0, 0]\n", r"did you mean velocity"),
    "gloss 2": (BALL + 'material = { kind = "coat", gloss = 2 }\n', r"gloss 2"),
    "a texture and colours": (BALL + '[floor]\ntexture = "a.png"\nlight = "#ffffff"\n', r"floor: texture 'a.png'"),
    "a sky of two kinds": (BALL + '[sky]\nimage = "a.hdr"\nzenith = [1, 1, 1]\n', r"image has no 'zenith'"),
    "a sky that is not there": (BALL + '[sky]\nimage = "a.hdr"\n', r"sky: sky 'a.hdr': there is no such file"),
    "a pattern on a sphere": (BALL + 'material = { pattern = { kind = "star" } }\n', r"a sphere has no pattern"),
    "an unknown pattern": ('[[disk]]\ncentre=[0,0,-9]\nnormal=[0,0,1]\nradius=1\nmaterial={pattern={kind="dots"}}\n',
                           r"disk 1: pattern 'dots'"),
    "a skew rectangle": ("[[rectangle]]\ncentre=[0,0,-9]\nright=[1,0,0]\nup=[1,1,0]\n", r"right angles"),
    "a flat rectangle": ("[[rectangle]]\ncentre=[0,0,-9]\nright=[0,0,0]\nup=[1,1,0]\n", r"cannot be zero"),
    "a target in the centre": ("[[rectangle]]\ncentre=[0,0,-9]\ntarget=[0,0,-9]\nwidth=1\nheight=1\n", r"target lies"),
    "no normal": ("[[disk]]\ncentre=[0,0,-9]\nnormal=[0,0,0]\nradius=1\n", r"normal of a disk cannot be zero"),
    "a sun from nowhere": (BALL + "[sun]\ndirection = [0, 0, 0]\n", r"direction of the sun"),
    "depths the wrong way": ("depth_range = [5, 1]\n" + BALL, r"depth_range"),
    "a subject by its names": ('subject = { distance = "1 m" }\n' + BALL, r"write its distance and its height"),
    "nothing at all": ("", r"shows nothing"),
    "broken text": ("[[sphere]\n", r"not TOML: .*line 1"),
    "diffuse_bounce = 1": ("diffuse_bounce = 1\n" + BALL, r"diffuse_bounce must be true or false"),
    "enclosed = 1": ("enclosed = 1\n" + BALL, r"enclosed must be true or false"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_line_that_names_the_file_and_what_is_wrong(write, name):
    text, reason = MISTAKES[name]
    path = write(text)
    with pytest.raises(SceneFileError, match=reason) as caught:
        load_scene(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and "\n" not in message
    assert caught.value.path == path


def test_what_is_no_scene_file_is_said_so(tmp_path):
    with pytest.raises(SceneFileError, match="No such file"):
        load_scene(tmp_path / "none.toml")
    with pytest.raises(SceneFileError, match="this is a folder"):
        load_scene(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(bytes(range(256)))
    with pytest.raises(SceneFileError, match="is not text"):
        load_scene(binary)
    large = tmp_path / "large.toml"
    large.write_bytes(b"#" * (1 << 20) + b"\n")
    with pytest.raises(SceneFileError, match="larger than 1 MB"):
        load_scene(large)
    many = tmp_path / "many.toml"
    many.write_text(BALL * 2001)
    with pytest.raises(SceneFileError, match="more than 2000 objects"):
        load_scene(many)


WALL = "[[rectangle]]\ncentre = [0, 0, -1000]\nright = [500, 0, 0]\nup = [0, 500, 0]\n"


def test_a_texture_is_linear_and_upright(write, tmp_path):
    (tmp_path / "deep").mkdir()
    save_picture(tmp_path / "deep" / "a.png", [[[255, 0, 0], [0, 255, 0]], [[188, 188, 188], [0, 0, 255]]])
    scene = load_scene(write(WALL + 'material = { texture = "deep/a.png" }\n'))
    image = scene.plates[0].material.pattern.image
    assert image.values[0, 0] == pytest.approx((1.0, 0.0, 0.0))
    assert image.values[1, 0] == pytest.approx((0.5028865,) * 3, abs=1e-6)      # IEC 61966-2-1 of 188 / 255


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_texture_is_turned_as_viewers_turn_it(write, tmp_path, orientation):
    exif = Picture.Exif()
    exif[0x0112] = orientation
    board = np.zeros((6, 9, 3), np.uint8)
    board[:2, :4], board[4:, 7:] = 255, 188
    Picture.fromarray(board).save(tmp_path / "a.png", exif=exif)
    image = load_scene(write(WALL + 'material = { texture = "a.png" }\n')).plates[0].material.pattern.image
    wanted = np.asarray(ImageOps.exif_transpose(Picture.open(tmp_path / "a.png")))
    assert image.values.shape == wanted.shape and ((image.values > 0.7) == (wanted > 200)).all()


@pytest.mark.slow
def test_a_large_texture_is_averaged_in_linear_light(write, tmp_path):
    board = np.zeros((512, 16384, 3), np.uint8)
    board[::2, ::2] = board[1::2, 1::2] = 255
    save_picture(tmp_path / "board.png", board)
    image = load_scene(write(WALL + 'material = { texture = "board.png" }\n')).plates[0].material.pattern.image
    assert (image.width, image.height) == (8192, 256)
    assert image.values == pytest.approx(0.5, abs=1e-5)         # half of the light, not of the code values


@pytest.mark.parametrize("name", ["x" * 10_000, "a\0b", "a\x1b[2J\nb", "x" * 10_000 + ".toml"])
def test_a_name_that_no_scene_can_have_is_one_short_line(name):
    with pytest.raises(SceneFileError) as caught:
        find_scene(name)
    assert len(str(caught.value)) < 500 and str(caught.value).isprintable()


@pytest.mark.parametrize("name", ["../a.png", "link.png", "folder/a.png", "up/../../a.png"])
def test_a_texture_outside_the_folder_of_the_scene_is_refused(write, tmp_path, name):
    home = tmp_path / "home"
    (home / "up").mkdir(parents=True)
    save_picture(tmp_path / "a.png", np.zeros((4, 4, 3)))
    os.symlink(tmp_path / "a.png", home / "link.png")
    os.symlink(tmp_path, home / "folder")
    path = write(WALL + f'material = {{ texture = "{name}" }}\n', "home/mine.toml")
    with pytest.raises(SceneFileError, match="outside the folder of the scene"):
        load_scene(path)


def test_textures_are_read_once_and_bounded_together(write, tmp_path, monkeypatch):
    for name in "abc":
        Picture.fromarray(np.full((8, 8, 3), 200, np.uint8)).save(tmp_path / f"{name}.png")
    monkeypatch.setattr(asset_files, "MOST_TEXELS", 128)
    walls = "".join(WALL + f'material = {{ texture = "{name}.png" }}\n' for name in "aab")
    images = [plate.material.pattern.image for plate in load_scene(write(walls)).plates]
    assert images[0] is images[1] is not images[2]
    with pytest.raises(SceneFileError, match="textures of the scene have more than"):
        load_scene(write(walls + '[floor]\ntexture = "c.png"\n'))


def test_a_texture_that_cannot_be_is_said_so(write, tmp_path):
    (tmp_path / "words.png").write_text("no picture")
    (tmp_path / "folder").mkdir()
    save_picture(tmp_path / "thin.png", np.zeros((1, 4, 3)))
    whole = save_picture(tmp_path / "whole.png", np.random.default_rng(1).integers(0, 255, (64, 64, 3)))
    (tmp_path / "half.png").write_bytes(whole.read_bytes()[:4000])
    Picture.new("1", (9000, 9000)).save(tmp_path / "vast.png")
    for name, reason in {"none.png": "no such file", "words.png": "no picture of the kinds", "folder": "is not a file",
                         "thin.png": "smaller than 2", "half.png": "damaged or cut short", "vast.png": "million pixels",
                         str(tmp_path / "whole.png"): "relative to the scene file"}.items():
        with pytest.raises(SceneFileError, match=reason):
            load_scene(write(WALL + f"material = {{ texture = '{name}' }}\n"))
    with pytest.raises(SceneFileError, match="a pattern or a texture"):
        load_scene(write(WALL + 'material = { texture = "whole.png", pattern = { kind = "star" } }\n'))
