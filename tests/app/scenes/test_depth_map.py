"""Photographs with depth maps from scene files."""

import numpy as np
import OpenEXR
import pytest
from PIL import Image as Picture, ImageOps

from lensbench.app.scenes.scene_file import SceneFileError, load_scene

PHOTO = '[photograph]\nimage = "a.png"\nfov = 60\n'


@pytest.fixture
def folder(tmp_path):
    Picture.fromarray(np.full((8, 12, 3), 188, np.uint8)).save(tmp_path / "a.png")
    ramp = np.repeat(np.linspace(0.0, 1.0, 12)[None], 8, 0)
    Picture.fromarray(np.uint16(ramp * 65535)).save(tmp_path / "deep.png")
    Picture.fromarray(np.uint8(ramp * 255)).save(tmp_path / "flat.png")
    OpenEXR.File({}, {"Z": np.ascontiguousarray(1.5 + ramp, np.float32)}).write(str(tmp_path / "metres.exr"))
    Picture.fromarray(np.zeros((8, 12), np.uint8)).save(tmp_path / "black.png")
    return tmp_path


def load(folder, text):
    (folder / "a.toml").write_text(text)
    return load_scene(folder / "a.toml")


@pytest.mark.parametrize(("depth", "middle"), [
    ('depth = "deep.png"\nnear = "1 m"\nfar = "3 m"\n', 2000.0), ('depth = "metres.exr"\n', 2000.0),
    ('depth = "flat.png"\ndepth_is = "disparity"\nnear = 1000\nfar = 3000\n', 1500.0)])
def test_a_depth_map_is_read_in_its_meaning(folder, depth, middle):
    scene = load(folder, PHOTO + depth)
    away = -scene.meshes[0].points[:, 2]
    if "metres" in depth:
        assert (away.min(), away.max()) == pytest.approx((1500.0, 2500.0), rel=0.05)
    else:
        assert (away.min(), away.max()) == pytest.approx((1000.0, 3000.0), rel=0.11)
    assert np.median(away) == pytest.approx(middle, rel=0.06)
    assert scene.meshes[0].material.pattern.image.values[0, 0] == pytest.approx((0.5028865,) * 3, abs=1e-6)


@pytest.mark.parametrize(("text", "reason"), [
    (PHOTO, "carries no depth map"), (PHOTO + 'depth = "deep.png"\n', "near and far are missing"),
    (PHOTO + 'depth = "deep.png"\nnear = 3\nfar = 2\n', "less than far"),
    (PHOTO + 'depth = "deep.png"\nnear = 1e-300\nfar = 2\n', "below 0.001 mm"),
    (PHOTO + 'depth = "deep.png"\nnear = 3\nfar = "60 km"\n', "at most 25 km"),
    (PHOTO + 'depth = "black.png"\nnear = 1\nfar = 2\n', "one value only"),
    (PHOTO + 'depth = "a.toml"\nnear = 1\nfar = 2\n', "no picture of the kinds"),
    (PHOTO + 'depth = "../a.png"\nnear = 1\nfar = 2\n', "no such file|outside"),
    (PHOTO + 'depth = "deep.png"\nnear = 1\nfar = 2\ndepth_is = "blue"\n', "distance, disparity"),
    (PHOTO + 'depth = "deep.png"\nnear = 1\nfar = 2\nfill = "magic"\n', "plain, shown, none"),
    (PHOTO + 'depth = "deep.png"\nnear = 1\nfar = 2\n[floor]\n', "has no 'floor'"),
])
def test_a_mistake_is_one_clear_line(folder, text, reason):
    with pytest.raises(SceneFileError, match=reason) as caught:
        load(folder, text)
    assert "\n" not in str(caught.value)


STEPS = np.array([1000.0, 1384.0, 2991.0, 4600.0])      # mm


def steps(rows=16, columns=24):
    """Distances (mm) in four upright stripes."""
    return np.repeat(np.repeat(STEPS, columns // 4)[None], rows, 0)


def distances(folder, name, levels, keys):
    """The distances of the cells of the photograph's mesh, and what was said; levels are written by the suffix."""
    if name.endswith(".exr"):
        OpenEXR.File({}, {"Z": np.ascontiguousarray(levels, np.float32)}).write(str(folder / name))
    else:
        Picture.fromarray(levels).save(folder / name)
    Picture.fromarray(np.full((16, 24, 3), 99, np.uint8)).save(folder / "a.png")
    scene = load(folder, PHOTO + f'fill = "none"\ndepth = "{name}"\n' + keys)
    corners = -scene.meshes[0].points[:, 2].reshape(-1, 4).astype(float)
    return corners.mean(1).reshape(16, 24), scene.notes


def test_a_depth_map_in_false_colours_is_refused_with_what_to_save(folder):
    ramp = np.repeat(np.linspace(0.0, 1.0, 24)[None], 16, 0)
    hot = np.stack([np.clip(3 * ramp - k, 0, 1) for k in range(3)], -1)           # red, yellow, white
    for levels in (np.uint8(255 * hot), np.uint8(255 * hot[..., ::-1])):
        with pytest.raises(SceneFileError, match="red, green and blue differ.*one channel"):
            distances(folder, "b.png", levels, "near = 1000\nfar = 4600\n")
    OpenEXR.File({}, {"RGB": np.ascontiguousarray(hot, np.float32)}).write(str(folder / "b.exr"))
    with pytest.raises(SceneFileError, match="red, green and blue differ"):
        load(folder, PHOTO + 'depth = "b.exr"\n')
    grey = np.repeat(np.uint8(1 + 254 * ramp)[..., None], 3, 2)
    found, notes = distances(folder, "b.png", grey, "near = 1000\nfar = 4600\n")
    assert (np.diff(found[8]) > 0.0).all() and notes == ()


@pytest.mark.parametrize("holes", ["scattered", "block"])
def test_pixels_without_a_distance_take_that_of_a_neighbour_and_are_counted(folder, holes):
    whole = steps()
    missing = np.zeros(whole.shape, bool)
    if holes == "block":
        missing[4:9, 7:11] = True                       # within the second stripe
    else:
        missing[1::5, 2::6] = True
    levels = np.where(missing, 0, whole).astype(np.uint16)
    found, notes = distances(folder, "b.png", levels, "near = 1000\nfar = 4600\n")
    np.testing.assert_allclose(found, whole, rtol=1e-4)
    share = float(f"{100.0 * missing.mean():.2g}")
    assert len(notes) == 1 and f"{share:g} % of the pixels hold no distance" in notes[0] and "holes = false" in notes[0]
    # The same in floats of metres, where NaN, negative numbers and 0 stand for it
    for void in (np.nan, -1.0, 0.0, -np.inf):
        found, notes = distances(folder, "b.exr", np.where(missing, void, whole / 1000.0), "")
        np.testing.assert_allclose(found, whole, rtol=1e-4)
        assert len(notes) == 1


def test_zero_is_a_distance_where_it_is_one(folder):
    ramp = np.repeat(np.linspace(0, 255, 24)[None], 16, 0).round().astype(np.uint8)
    found, notes = distances(folder, "b.png", ramp, "near = 1000\nfar = 3000\n")
    assert notes == () and (np.diff(found[8]) > 0.0).all()
    stripes = np.where(steps() < 1200.0, 0, 200).astype(np.uint8)
    stripes[:, 20:] = 255
    found, notes = distances(folder, "b.png", stripes, "near = 1000\nfar = 3000\nholes = false\n")
    assert notes == () and found[8, 0] == pytest.approx(1000.0, rel=1e-6)
    disparity = np.where(steps() < 1200.0, 255, np.where(steps() < 3000.0, 200, 0)).astype(np.uint8)
    found, notes = distances(folder, "b.png", disparity, 'near = 1000\nfar = 3000\ndepth_is = "disparity"\n')
    assert notes == () and found[8, -1] == pytest.approx(3000.0, rel=1e-6)       # the sky


@pytest.mark.parametrize("endless", [1e10, 65504.0, 1e5, np.inf, 3.4e38])
@pytest.mark.parametrize("keys", ["", "near = 1000\nfar = 2991\n"])
def test_where_a_ray_met_nothing_the_map_goes_on_behind_all_and_the_rest_keeps_its_depth(folder, endless, keys):
    whole = steps()
    away = whole > 4000.0
    found, notes = distances(folder, "b.exr", np.where(away, endless, whole / 1000.0), keys)
    np.testing.assert_allclose(found[~away], whole[~away], rtol=1e-4)
    assert (found[away] > 2.0 * whole[~away].max()).all()
    assert "25 % of the pixels have the level of what has no end" in notes[0]


def test_a_greatest_number_of_sixteen_bits_far_above_all_others_flattens_none_of_them(folder):
    whole = steps()
    away = whole > 4000.0
    levels = np.where(away, 65535, whole).astype(np.uint16)
    found, notes = distances(folder, "b.png", levels, "near = 1000\nfar = 2991\n")
    np.testing.assert_allclose(found[~away], whole[~away], rtol=1e-4)
    assert (found[away] > 2991.0).all() and "25 % of the pixels" in notes[0]
    found, notes = distances(folder, "b.png", levels, "near = 1000\nfar = 65535\nholes = false\n")
    np.testing.assert_allclose(found, levels, rtol=1e-4)
    assert notes == ()


def test_the_true_reason_is_passed_on(folder):
    OpenEXR.File({}, {"depth": np.ones((8, 12), np.float32)}).write(str(folder / "b.exr"))
    with pytest.raises(SceneFileError, match=r"depth map 'b.exr': it has the channels 'depth', and neither Z nor Y"):
        load(folder, PHOTO + 'depth = "b.exr"\n')
    (folder / "c.exr").write_bytes((folder / "b.exr").read_bytes()[:200])
    with pytest.raises(SceneFileError, match=r"depth map 'c.exr': it is not a complete OpenEXR file"):
        load(folder, PHOTO + 'depth = "c.exr"\n')
    OpenEXR.File({}, {"Z": np.full((8, 12), np.nan, np.float32)}).write(str(folder / "d.exr"))
    with pytest.raises(SceneFileError, match=r"depth map 'd.exr': none of its pixels holds a distance"):
        load(folder, PHOTO + 'depth = "d.exr"\n')
    OpenEXR.File({}, {"Z": np.linspace(3e4, 5e4, 96, dtype=np.float32).reshape(8, 12)}).write(str(folder / "e.exr"))
    with pytest.raises(SceneFileError, match=r"depth map 'e.exr': it reaches 50 km.*give near and far"):
        load(folder, PHOTO + 'depth = "e.exr"\n')


@pytest.mark.parametrize("orientation", range(1, 9))
def test_photograph_and_map_are_turned_upright(folder, orientation):
    exif = Picture.Exif()
    exif[0x0112] = orientation
    tall = orientation >= 5
    colours = np.zeros((12, 18, 3) if not tall else (18, 12, 3), np.uint8)
    colours[:6, :6] = 255                               # what is stored at the top left
    Picture.fromarray(colours).save(folder / "a.png", exif=exif)
    Picture.fromarray(np.uint8(np.linspace(1, 255, 216)).reshape(12, 18)).save(folder / "b.png")
    scene = load(folder, PHOTO + 'depth = "b.png"\nnear = 1000\nfar = 3000\n')
    shown = scene.meshes[0].material.pattern.image.values[..., 0]
    wanted = ImageOps.exif_transpose(Picture.open(folder / "a.png"))
    assert shown.shape == (12, 18) and ((shown > 0.5) == (np.asarray(wanted)[..., 0] > 127)).all()
