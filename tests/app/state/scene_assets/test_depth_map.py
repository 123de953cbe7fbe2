"""Photographs with depth maps from scene files."""

import numpy as np
import OpenEXR
import pytest
from PIL import Image as Picture

from lensbench.app.state.scene_file import SceneFileError, load_scene

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
