"""Approximations of a picture are reported as findings."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.command.main import main
from lensbench.app.state.scene_assets.scene_findings import scene_findings
from lensbench.kernels.srgb import linear
from lensbench.optics.finding import Kind


def test_rough_coats_below_a_picture_of_the_sky_are_named_and_nothing_else():
    sky = lb.ImageSky(lb.Image.of(np.ones((2, 4, 3))))
    rough = lb.Scene("rough", sky=sky, spheres=(lb.Sphere((0, 0, -900), 90, lb.Material(kind="coat", gloss=0.8)),))
    found, = scene_findings(rough)
    assert found.kind is Kind.SAMPLING and "gloss below 1" in str(found)
    sharp = lb.Sphere((0, 0, -900), 90, lb.Material(kind="coat"))
    for other in (replace(rough, sky=lb.Sky()), replace(rough, spheres=(sharp,)), replace(rough, enclosed=True),
                  *map(lb.builtin_scene, lb.SCENES)):
        assert scene_findings(other) == ()


@pytest.mark.slow
def test_a_rendered_picture_says_what_its_scene_is_approximated_by(tmp_path, capsys):
    from PIL import Image

    Image.fromarray(np.full((8, 16, 3), round(255 * linear(np.array([0.5]))[0]), np.uint8)).save(tmp_path / "sky.png")
    (tmp_path / "rough.toml").write_text('[sky]\nimage = "sky.png"\n[[sphere]]\ncentre = [0, 0, -900]\nradius = 90\n'
                                         'material = { kind = "coat", gloss = 0.8 }\n', encoding="utf-8")
    assert main(["render", "--camera", "perspective", "--scene", str(tmp_path / "rough.toml"), "--size", "16x8",
                 "--samples", "1", "-o", str(tmp_path / "out.png")]) == 0
    assert "mirror the nearest sky of three colours" in capsys.readouterr().err
