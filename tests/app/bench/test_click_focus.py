"""A click in the picture with a tilted or decentred film or lens, against the rays of the camera that it focuses."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lensbench import lenses
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.focus_plane import BEYOND, TOO_NEAR, UNLIT, focused_at
from lensbench.app.settings.settings import Settings
from tests.core.optics.test_surface_pose import posed

TILTED = replace(Settings(), lens_model="trace", tilt=0.08, f_number=4.0, focus_distance=1500.0)
CURVED = replace(TILTED, tilt=0.0, film_radius=-90.0)
TRIPLET = "lenshh-cooke-triplet-50"


def bent(folder, first, last, **pose):
    lenses.save(posed(lenses.load(TRIPLET), first, last, **pose), folder / "bent.toml")
    return Settings(lens=str(folder / "bent.toml"), f_number=5.6, focus_distance=1500.0, lens_model="trace")


def sharpest(settings, part, depths):
    """The depth (mm) at which the rays of a part of the picture look narrowest from the film."""
    uv = (np.stack(np.meshgrid(np.arange(24), np.arange(24)), 2).reshape(-1, 2) + 0.5) / 24.0
    rays = camera(settings).generate_rays(np.tile([[part[0] * 960.0, part[1] * 640.0]], (len(uv), 1)), uv)
    o, d = rays.origins[rays.weights > 0.0], rays.directions[rays.weights > 0.0]
    met = o[:, :2] - d[:, :2] / d[:, 2:] * (depths[:, None, None] + o[:, 2:])
    return depths[np.argmin(met.var(1).sum(1) / depths**2)]


def check(settings, part, depth):
    found = focused_at(settings, part, depth)
    there = replace(settings, focus_distance=found.distance)
    depths = depth * np.geomspace(0.7, 1.4, 701)                                # 0.1 % apart
    assert not found.remark and sharpest(there, part, depths) == pytest.approx(depth, rel=0.008)
    centred = sharpest(replace(settings, focus_distance=depth), part, depths)   # as a click on a centred camera
    assert abs(centred - depth) > 0.03 * depth


@pytest.mark.parametrize(("settings", "part"), [(TILTED, (0.5, 0.15)), (TILTED, (0.8, 0.7)), (CURVED, (0.85, 0.2))])
def test_a_click_before_a_tilted_film_makes_its_place_sharp(settings, part):
    check(replace(settings, focus_position="real"), part, 1200.0)


@pytest.mark.slow
@pytest.mark.parametrize(("body", "pose"), [((0, 5), {"tilt_x": 0.07}), ((0, 5), {"tilt_x": 0.03, "tilt_y": -0.04}),
                                            ((4, 5), {"tilt_y": 0.03, "decentre_y": 0.2})])
@pytest.mark.parametrize("part", [(0.3, 0.2), (0.7, 0.75)])
def test_a_click_through_a_tilted_lens_makes_its_place_sharp(body, pose, part, tmp_path):
    settings = replace(bent(tmp_path, *body, **pose), focus_position="real")
    check(settings, part, 1200.0)
    narrow = replace(settings, f_number=22.0, focus_position="paraxial")        # by beams of no width
    found = replace(narrow, focus_distance=focused_at(narrow, part, 1200.0).distance)
    assert sharpest(found, part, 1200.0 * np.geomspace(0.7, 1.4, 701)) == pytest.approx(1200.0, rel=0.03)


def test_a_click_before_a_centred_film_is_its_depth_and_one_out_of_reach_says_so(tmp_path):
    assert focused_at(replace(TILTED, tilt=0.0), (0.2, 0.2), 1200.0) == (1200.0, "")
    assert focused_at(TILTED, (0.5, 0.5), math.inf) == (math.inf, "")
    assert focused_at(TILTED, (0.8, 0.95), math.inf) == (math.inf, BEYOND)
    nearest = focused_at(TILTED, (0.5, 0.1), 60.0)
    assert nearest.remark == TOO_NEAR and nearest.distance < 500.0
    dark = replace(bent(tmp_path, 0, 5, tilt_x=0.05), film_width=360.0, film_height=240.0)
    assert focused_at(dark, (0.02, 0.02), 900.0) == (900.0, UNLIT)


@pytest.mark.parametrize("part", [(0.5, 0.5), (0.15, 0.2), (0.9, 0.5)])
@pytest.mark.parametrize("camera_kind", ["perspective", "lens"])
def test_what_is_clicked_under_water_is_where_the_rays_of_its_pixel_come_together(camera_kind, part):
    start = replace(Settings(), medium="water", f_number=8.0, camera=camera_kind, fov=0.9, lens_model="thick")
    depth = 1500.0
    found = focused_at(start, part, depth)
    of = camera(replace(start, focus_distance=found.distance))
    even = (np.arange(16) + 0.5) / 16.0
    samples = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)
    raster = np.broadcast_to([part[0] * of.film.pixels_x, part[1] * of.film.pixels_y], samples.shape)
    rays = of.generate_rays(raster, samples)
    slopes = rays.directions[:, :2] / rays.directions[:, 2:]
    places = rays.origins[:, :2] - rays.origins[:, 2:] * slopes
    slopes, places = slopes - slopes.mean(0), places - places.mean(0)
    sharpest = -float((slopes * places).sum() / (slopes**2).sum())          # z of least rms
    # The cone aslant has two foci, of which the formula takes the mean: within a part of their distance
    assert -sharpest == pytest.approx(depth, rel=1e-5 if part == (0.5, 0.5) else 0.012)
    middle = replace(start, focus_distance=depth)
    assert abs(found.distance - depth) < 1e-6 * depth if part == (0.5, 0.5) else found.distance < middle.focus_distance
