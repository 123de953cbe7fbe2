"""Make these sharp: rays of the whole pupil meet at the picked points behind the film that is found."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.sharp_points import made_sharp, picked_point
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings

START = replace(Settings(), f_number=4.0, position=(120.0, 80.0, 300.0), yaw=0.2, pitch=-0.1)
TWO = (((0.2, 0.3), 1500.0), ((0.8, 0.7), 1000.0))
THREE = (*TWO, ((0.5, 0.15), 1250.0))


def blur_at(settings: Settings, point: np.ndarray) -> float:
    """Rms distance (mm, in the world) from a point of the rays of the place where the picture shows it."""
    made = camera(settings)
    raster, visible = made.raster_from_point([point])
    assert visible.all()
    even = (np.arange(16) + 0.5) / 16.0
    samples = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)
    rays = made.generate_rays(np.repeat(raster, len(samples), 0), samples)
    lit = rays.weights > 0.0
    off = point - rays.origins[lit]
    aside = off - (off * rays.directions[lit]).sum(1, keepdims=True) * rays.directions[lit]
    return float(np.sqrt((aside**2).sum(1).mean()))


@pytest.mark.parametrize("picks", [TWO, THREE])
@pytest.mark.parametrize("change", [{}, {"focus_position": "real"}, {"lens_model": "thick"},
                                    {"lens": "lenshh-cooke-triplet-50", "f_number": 8.0}])
def test_the_picked_points_become_sharp(picks, change):
    settings = replace(START, **change)
    points = np.array([picked_point(settings, share, depth) for share, depth in picks])
    solved, shares = made_sharp(settings, points)
    blur = [blur_at(settings, point) for point in points]
    assert all(blur_at(solved, point) < 0.3 * max(blur) for point in points)
    np.testing.assert_allclose(shares * [960.0, 640.0], camera(solved).raster_from_point(points)[0], atol=0.5)
    assert solved.focus_position == settings.focus_position and solved.position == settings.position


def test_one_depth_needs_no_tilt_and_two_above_each_other_no_swing():
    flat = np.array([picked_point(START, share, 1300.0) for share in ((0.2, 0.5), (0.8, 0.5))])
    solved, _ = made_sharp(replace(START, lens_model="thick"), flat)
    assert abs(solved.tilt) < 1e-3 and abs(solved.swing) < 2e-3
    assert solved.focus_distance == pytest.approx(1300.0, rel=0.01)
    ground = np.array([picked_point(START, (0.5, down), depth) for down, depth in ((0.4, 1400.0), (0.9, 900.0))])
    solved, _ = made_sharp(START, ground)
    assert solved.tilt > 0.03 and abs(solved.swing) < 1e-3


def test_points_that_no_film_makes_sharp_together_are_refused():
    behind = np.array([picked_point(START, (0.5, 0.5), 1000.0), picked_point(START, (0.505, 0.5), 4000.0)])
    with pytest.raises(SettingsError, match="by more than 60°. Choose points that lie farther apart"):
        made_sharp(START, behind)
    with pytest.raises(SettingsError, match="choose a camera with a lens"):
        made_sharp(replace(START, camera="perspective"), behind)
    with pytest.raises(SettingsError, match="choose air"):
        made_sharp(replace(START, medium="water"), behind)
