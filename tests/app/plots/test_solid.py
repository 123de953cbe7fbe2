"""Solids of the lens and of the scene, the focused surface against traced spots, and the eye's matrix."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.plots.pixel_rays import beam, film_place
from lensbench.app.plots.pixel_spot import spot_of
from lensbench.app.plots.section import elements, sag, sketch
from lensbench.app.plots.solid_rays import best_focus, fan_lines, focused_surface, lost_lines, pixel_lines
from lensbench.app.plots.solids import FARTHEST, Eye, lens_parts, scene_parts
from lensbench.app.settings.settings import Settings
from tests.core.optics.test_surface_pose import posed

START = replace(Settings(), f_number=None)
ANAMORPHIC = "lentil-schneider-anamorphic-31-2001"


def test_the_half_lens_lies_on_its_surfaces_and_its_cut_in_the_section():
    shown = sketch(START)
    lens, cuts = shown.lens, []
    for element, (shell, cut) in zip(elements(lens), zip(*[iter(
            [part for part in lens_parts(shown) if part.glass is not None])] * 2, strict=True), strict=True):
        x, y, z = shell.points[::7].T
        assert shell.points[:, 0].min() > -1e-9 and shell.glass[0] == element.glass.n_d
        r = np.hypot(x, y)
        away = np.min([np.abs(z + shown.film_z - lens.vertices[i] - [sag(lens.surfaces[i], 0.0, h) for h in r])
                       for i in (element.front, element.front + 1)], axis=0)
        assert away.max() < 1e-9
        assert np.abs(cut.points[:, 0]).max() == 0.0
        a, b, c = cut.points[0::3, 1:], cut.points[1::3, 1:], cut.points[2::3, 1:]
        area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
        y, z = element.outline[:, 1], element.outline[:, 0]
        outline = 0.5 * abs(float(np.sum(z * np.roll(y, -1) - np.roll(z, -1) * y)))
        cuts.append(area)
        assert area == pytest.approx(outline, rel=3e-3)         # chords of arcs, laid out differently
    assert len(cuts) == len(elements(lens))


def test_a_cylinder_bends_across_one_direction_alone():
    shown = sketch(replace(START, lens=ANAMORPHIC))
    lens = shown.lens
    index = next(i for i, s in enumerate(lens.surfaces) if not s.is_rotationally_symmetric)
    element = next(e for e in elements(lens) if index in (e.front, e.front + 1))
    shell = [part for part in lens_parts(shown) if part.kind == "glass"][elements(lens).index(element)]
    surface, vertex = lens.surfaces[index], lens.vertices[index] - shown.film_z
    x, y, z = shell.points.T
    on = np.abs(z - vertex - np.nan_to_num(surface.sag(x, y), nan=1e9)) < 1e-9
    assert on.sum() > 100 and np.ptp(x[on]) > 0.5 * surface.semi_diameter


def test_a_rolled_cylinder_stands_rolled_and_is_cut_in_the_section(tmp_path):
    lens = posed(lenses.load(ANAMORPHIC), 0, 0, roll=0.5)
    lenses.save(lens, tmp_path / "rolled.toml")
    shown = sketch(replace(START, lens=str(tmp_path / "rolled.toml")))
    shell = next(part for part in lens_parts(shown) if part.kind == "glass")
    own = shown.lens.in_frame_of(0, shell.points + [0.0, 0.0, shown.film_z])
    on = np.abs(own[:, 2] - shown.lens.surfaces[0].sag(own[:, 0], own[:, 1])) < 1e-9
    assert on.sum() > 100 and shell.points[:, 0].min() > -1e-9


@pytest.mark.parametrize("radius", [0.0, 10.0, 18.0])
def test_the_focused_surface_is_where_the_traced_spot_is_smallest(radius):
    """Rays are traced from the film for the one, and from the scene for the other."""
    built = bench_of(START)
    y, z = best_focus(built.lens, built.film_distance, radius)
    front = np.array([0.0, 0.0])
    way = np.array([y, z]) - front
    sizes = [spot_of(built.lens, built.film_distance, (0.0, radius), (0.0, *(front + part * way).tolist())).diameter
             for part in (0.5, 0.85, 1.0, 1.15, 2.0)]
    assert sizes[2] < min(sizes) / (1.0 - 1e-9) and sizes[2] < 0.4 * min(sizes[0], sizes[-1])


def test_a_stopped_down_lens_focuses_the_axis_where_it_is_focused():
    errors = []
    for f_number in (11.0, 22.0):
        built = bench_of(replace(START, f_number=f_number))
        _, z = best_focus(built.lens, built.film_distance, 0.0)
        errors.append(built.film_z - z - START.focus_distance)
    # Spherical aberration moves the best focus by the square of the aperture
    assert abs(errors[1]) < 2.0 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    grid = focused_surface(replace(START, f_number=16.0))
    rows, columns = grid.shape[:2]
    assert grid[rows // 2, columns // 2, 2] == pytest.approx(-START.focus_distance, rel=3e-3)
    # The image is upside down: the upper right of the film sees what is below, at the left
    assert (grid[-1, -1, :2] < 0.0).all() and (grid[0, 0, :2] > 0.0).all()


@pytest.mark.parametrize("change", [{"tilt": 1e-9}, {"film_radius": 1e9}])
def test_the_surface_before_a_tilted_film_is_traced_as_that_of_a_centred_one(change):
    """To 2 % of its depth: the one takes 256 rays of the open stop, the other two rings of the region."""
    line, posed_film = (focused_surface(replace(START, f_number=8.0, **each)) for each in ({}, change))
    here = np.isfinite(line).all(2) & np.isfinite(posed_film).all(2)
    assert here.sum() > 150 and np.ptp(line[here][:, 2]) > 40.0             # curved
    assert np.abs(posed_film[here] - line[here]).max() < 0.02 * START.focus_distance
    tilted = focused_surface(replace(START, f_number=8.0, tilt=0.05))
    assert tilted[-1, 8, 2] < line[-1, 8, 2] - 100.0 or tilted[-1, 8, 2] > line[-1, 8, 2] + 100.0


def test_the_plane_of_an_ideal_camera_lies_at_its_focus_and_infinity_is_not_drawn():
    plane = focused_surface(replace(START, camera="perspective", f_number=2.0))
    np.testing.assert_allclose(plane[..., 2], -START.focus_distance, rtol=1e-9)
    assert not np.isfinite(focused_surface(replace(START, camera="perspective", f_number=2.0,
                                                   focus_distance=math.inf))).any()
    with pytest.raises(ValueError, match="no plane in focus"):
        focused_surface(replace(START, camera="environment"))


def test_lines_of_a_pixel_run_from_what_it_shows_to_its_film_point():
    raster = (480.5, 380.5)
    pieces = pixel_lines(START, raster).pieces
    film = film_place(START, raster)
    ends = pieces[np.abs(pieces[:, 1, 2]) < 1e-9][:, 1]
    assert len(ends) >= 16
    np.testing.assert_allclose(ends, np.tile([*film, 0.0], (len(ends), 1)), atol=1e-9)
    target = beam(START, raster).target                     # the camera stands at the origin of the world
    starts = pieces[pieces[:, 0, 2] < -500.0][:, 0]
    assert np.linalg.norm(starts.mean(0) - target) < 5.0 and len(starts) == len(ends)


def test_the_fans_of_the_section_meet_in_the_plane_of_focus():
    shown = sketch(replace(START, f_number=8.0))
    for strokes_ in fan_lines(shown, START.focus_distance):
        starts = strokes_.pieces[np.abs(strokes_.pieces[:, 0, 2] + START.focus_distance) < 1e-6][:, 0]
        assert len(starts) >= 5 and np.ptp(starts[:, 1]) < 1.0


def test_lost_lines_are_the_rays_that_a_surface_ends():
    shown = sketch(START)
    ended = [ray.surface for fan in shown.fans for ray in fan.rays if ray.kind == "dead"]
    assert ended and len(lost_lines(shown, (-1,)).pieces) == 0
    for surface in set(ended):
        rays = [ray for fan in shown.fans for ray in fan.rays if ray.surface == surface]
        assert len(lost_lines(shown, (surface,)).pieces) == sum(len(ray.path) - 1 for ray in rays)


def test_things_of_the_scene_keep_their_size_and_a_wall_about_the_camera_is_left_out():
    scene = lb.builtin_scene("still-life")
    parts, lines = scene_parts(START)
    assert len(parts) == len(scene.objects) and {line.kind for line in lines} == {"edge", "floor"}
    ball, part = scene.spheres[0], parts[0]
    np.testing.assert_allclose(np.linalg.norm(part.points - ball.centre, axis=1), ball.radius, rtol=1e-9)
    floor = next(line for line in lines if line.kind == "floor").pieces.reshape(-1, 3)
    normal = np.asarray(scene.floor.normal) / np.linalg.norm(scene.floor.normal)
    np.testing.assert_allclose(floor @ normal, scene.floor.height, atol=1e-6)
    room = replace(START, scene="room")
    assert 0 < len(scene_parts(room)[0]) < len(lb.builtin_scene("room").objects)
    assert scene_parts(replace(START, scene="no-such-scene")) == ((), ())


@pytest.mark.parametrize("shape", [(700.0, 160.0), (300.0, 600.0)])
@pytest.mark.parametrize("angles", [(-65.0, 18.0), (-90.0, 4.0), (140.0, -60.0)])
def test_the_eye_fits_a_box_and_looks_at_its_middle(shape, angles):
    low, high = np.array([-20.0, -40.0, -300.0]), np.array([60.0, 10.0, 5.0])
    eye = Eye(yaw=math.radians(angles[0]), pitch=math.radians(angles[1])).fitted(low, high, *shape)
    corners = np.array([[x, y, z, 1.0] for x in (-20.0, 60.0) for y in (-40.0, 10.0) for z in (-300.0, 5.0)])
    clip = corners @ eye.clip_from_camera(*shape).T
    assert (clip[:, 3] > 0.0).all() and (np.abs(clip[:, :3]) < clip[:, 3:]).all()
    assert np.abs(clip[:, :2] / clip[:, 3:]).max() > 0.5                # and fills the view
    middle = np.append(eye.target, 1.0) @ eye.clip_from_camera(*shape).T
    np.testing.assert_allclose(middle[:2], 0.0, atol=1e-9)
    np.testing.assert_allclose(eye.axes @ eye.axes.T, np.eye(3), atol=1e-12)


def test_turning_keeps_the_distance_and_zooming_has_ends():
    eye = Eye(target=(1.0, 2.0, 3.0), distance=50.0)
    turned = eye.turned(0.3, 0.2)
    assert np.linalg.norm(turned.place - turned.target) == pytest.approx(50.0)
    assert eye.turned(0.0, 9.0).pitch < math.radians(90.0)
    np.testing.assert_allclose(eye.moved(3.0, 4.0).target, np.array([1.0, 2.0, 3.0]) + 3.0 * eye.axes[0]
                               + 4.0 * eye.axes[1])
    assert eye.zoomed(1e9).distance == 1.0 and eye.zoomed(1e-9).distance == FARTHEST


def test_the_scene_is_at_the_left_of_the_lens_as_in_the_section():
    eye = Eye()
    ahead, film = (np.array([0.0, 0.0, z, 1.0]) @ eye.clip_from_camera(400.0, 300.0).T for z in (-50.0, 0.0))
    assert ahead[0] / ahead[3] < film[0] / film[3]
