"""Planes of sharp focus: their geometry, whatever the length and sign of the normal that they are made of."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.focus_wedge import Plane, sharp_focus
from lensbench.core.imaging.film import FilmPose


@pytest.mark.parametrize("size", [1.0, -1.0, 0.02, -30.0])
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.3, -0.5, 0.8), (0.0, 1.0, 0.0), (-0.4, 0.0, 0.0)])
def test_distances_from_a_plane_are_those_along_its_unit_normal_towards_the_camera_or_up(normal, size):
    unit = np.array(normal) / np.linalg.norm(normal)
    unit *= np.sign(unit[2] or unit[1] or unit[0])
    plane = Plane.facing(size * np.array(normal), size * 70.0)
    assert np.linalg.norm(plane.normal) == pytest.approx(1.0, rel=1e-12)
    foot = np.array(normal) * 70.0 / np.dot(normal, normal)          # normal · foot = 70
    across = np.cross(unit, [0.6, 0.5, 0.3])
    away = np.array([-900.0, 0.0, 3.0])
    np.testing.assert_allclose(plane.distance(foot + 40.0 * across + away[:, None] * unit), away, atol=1e-9)


def meeting(of, row, side):
    """Where side × side rays of the film point in the middle of a pixel row come nearest to a point, by least rms."""
    even = (np.arange(side) + 0.5) / side
    samples = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)
    rays = of.generate_rays(np.broadcast_to([180.0, row], samples.shape), samples)
    slopes = rays.directions[:, :2] / rays.directions[:, 2:]
    places = rays.origins[:, :2] - rays.origins[:, 2:] * slopes
    off, leaning = places - places.mean(0), slopes - slopes.mean(0)
    z = -float((leaning * off).sum() / (leaning**2).sum())
    return np.array([*(places.mean(0) + z * slopes.mean(0)), z])


def test_beyond_a_window_into_water_the_plane_is_where_rays_of_film_points_come_together():
    film = lb.Film(36.0, 24.0, 360, 240)
    of = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film, 1000.0, 4.0, model="thick",
                       film_pose=FilmPose(tilt=0.03), medium=lb.Medium.water(50_000.0))
    found = sharp_focus(of, 0.03)
    for row in (90.0, 120.0, 150.0):                            # near the axis, where the window has one focus
        at = meeting(of, row, 16)
        assert abs(found.plane.distance(at[None])[0]) < 0.004 * abs(at[2])
    in_air = sharp_focus(replace(of, medium=None), 0.03)
    middle = [plane.offset / plane.normal[2] for plane in (found.plane, in_air.plane)]
    assert middle[0] == pytest.approx(-of.flat_port.true(-middle[1]), rel=1e-12)
    # The hinge line lies in the three planes
    for plane in (found.plane, found.near, found.far):
        on_line = found.hinge.point + np.array([[0.0], [100.0]]) * found.hinge.direction
        np.testing.assert_allclose(plane.distance(on_line), 0.0, atol=1e-9 * np.linalg.norm(found.hinge.point))


@pytest.mark.parametrize("name, focus", [("lenshh-cooke-triplet-50", 1494.0), ("wood-100-f16", 2500.0)])
def test_the_plane_of_a_film_at_the_least_blur_is_where_real_rays_come_together(name, focus):
    """Spherical aberration moves that film by so much that paraxial rays would meet 4 to 12 % farther away."""
    film = lb.Film(36.0, 24.0, 360, 240)
    of = lb.LensCamera(lenses.load(name), film, focus, focus_method="real", film_pose=FilmPose(tilt=0.03))
    found = sharp_focus(of, 0.03).plane
    assert found.offset / found.normal[2] == pytest.approx(-focus, rel=1e-9)
    for row in (110.0, 120.0, 130.0):                           # near the axis
        at = meeting(of, row, 24)
        assert abs(found.distance(at[None])[0]) < 0.02 * abs(at[2]), row


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_an_object_at_the_front_focus_has_its_plane_there(tilt):
    """Its paraxial image is at infinity, and so are all planes of the wedge: the front focal plane, in closed form."""
    lens, film = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 4.0), lb.Film()
    camera = lb.LensCamera(lens, film, focus_distance=500.0, f_number=4.0, film_pose=FilmPose(tilt=tilt))
    fo, film_distance = lb.first_order(lens), 20.0
    for _ in range(100):                                # object less principal plane is f, also as it is rounded
        front = -film_distance - lens.length
        principal = front + fo.front_principal
        distance = fo.efl - principal
        if distance + principal == fo.efl:
            break
        film_distance = float(np.nextafter(film_distance, np.inf))
    assert distance + principal == fo.efl
    at_focus = SimpleNamespace(lens=lens, film_distance=film_distance, film_pose=camera.film_pose,
                               focus_method="real", film_at=None, follows_rays=True, focus_distance=distance,
                               has_port=False)
    found = sharp_focus(at_focus, 0.03)
    for plane in (found.plane, found.near, found.far):
        assert plane.normal == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
        assert plane.offset == pytest.approx(front + fo.ffl, abs=1e-9)
    assert found.scheimpflug is None


def test_the_plane_is_continuous_through_the_front_focus():
    """A little before and behind it the plane lies where 1/u = 1/v of the thick lens has it, by its own distance."""
    lens = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 4.0)
    camera = lb.LensCamera(lens, lb.Film(), focus_distance=500.0, f_number=4.0)
    for distance in (lens.length + camera.film_distance - lb.first_order(lens).ffl + off for off in (-1e-3, 1e-3)):
        seen = SimpleNamespace(lens=lens, film_distance=camera.film_distance, film_pose=camera.film_pose,
                               focus_method="real", film_at=None, follows_rays=True, focus_distance=distance,
                               has_port=False)
        assert sharp_focus(seen, 0.03).plane.offset == pytest.approx(-distance, rel=1e-9)


@pytest.mark.parametrize("name, focus", [("pbrt-dgauss-50mm", 3000.0), ("lenshh-cooke-triplet-50", 1494.0)])
def test_near_and_far_planes_of_an_upright_film_are_the_limits_of_its_depth_of_field(name, focus):
    """Where the film moves by δ the circle is δ D / s′, at the limits δ D / (s′ ± δ): c / D apart."""
    circle = 0.01
    camera = lb.LensCamera(lenses.load(name), lb.Film(), focus, focus_method="paraxial")
    found = sharp_focus(camera, circle)
    near, far = lb.thick_depth_of_field(camera.lens, camera.film_distance, focus, circle)
    diameter = 2.0 * lb.first_order(camera.lens).exit_pupil.radius
    for plane, limit in ((found.near, near), (found.far, far)):
        assert plane.normal == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
        assert plane.offset + focus == pytest.approx(focus - limit, rel=2.0 * circle / diameter)


@pytest.mark.parametrize("index", [1.0, 1.333])
@pytest.mark.parametrize("method", ["paraxial", "real"])
@pytest.mark.parametrize("pose", [FilmPose(), FilmPose(tilt=0.04, swing=-0.02)])
def test_the_plane_of_an_immersed_lens_crosses_the_axis_where_it_is_focused(pose, method, index):
    """Its wedge and its plane meet in the hinge line: the front focal plane at 1 / power times the index before it."""
    lens = replace(lenses.load("lenshh-cooke-triplet-50"), front_index=index)
    camera = lb.LensCamera(lens, lb.Film(), 1500.0, 5.6, focus_method=method, film_pose=pose)
    found = sharp_focus(camera, 0.03)
    assert found.plane.offset / found.plane.normal[2] == pytest.approx(-1500.0, rel=1e-9)
    if pose.is_tilted:
        on_line = found.hinge.point + np.array([[0.0], [100.0]]) * found.hinge.direction
        for plane in (found.plane, found.near, found.far):
            np.testing.assert_allclose(plane.distance(on_line), 0.0, atol=1e-9 * np.linalg.norm(found.hinge.point))


def test_ideal_rays_are_in_focus_on_the_conjugate_of_the_film():
    """The film is where real rays meet; those of the model thick meet it from another plane."""
    camera = lb.LensCamera(lenses.load("lenshh-cooke-triplet-50"), lb.Film(), 1494.0, focus_method="real",
                           model="thick")
    expected = lb.focused_distance(camera.lens, camera.film_distance)
    assert sharp_focus(camera, 0.03).plane.offset == pytest.approx(-expected, rel=1e-9)
    assert expected != pytest.approx(1494.0, rel=1e-3)


def test_beyond_a_window_the_hinge_of_a_tilted_lens_lies_in_its_wedge_nearest_to_the_axis():
    lens = lenses.load("pbrt-dgauss-50mm")
    lens = replace(lens, surfaces=tuple(replace(surface, pose=lb.SurfacePose(tilt_x=0.05, tilt_y=0.04, pivot=i))
                                        for i, surface in enumerate(lens.surfaces)))
    for medium in (None, lb.Medium.water(50_000.0)):
        camera = lb.LensCamera(lens, lb.Film(), 1000.0, 4.0, film_pose=FilmPose(tilt=0.03), medium=medium)
        found = sharp_focus(camera, 0.3)
        on_line = found.hinge.point + np.array([[0.0], [100.0]]) * found.hinge.direction
        for plane in (found.near, found.far):
            np.testing.assert_allclose(plane.distance(on_line), 0.0, atol=1e-8 * np.linalg.norm(found.hinge.point))
        assert abs(found.hinge.direction[2]) > 1e-4
        aside = found.hinge.point[:2] @ found.hinge.direction[:2]
        assert aside == pytest.approx(0.0, abs=1e-8 * np.linalg.norm(found.hinge.point))


@pytest.mark.parametrize("index", [1.0, 1.333])
def test_the_wedge_of_a_lens_whose_stop_is_at_its_front_focus_is_its_depth_of_field(index):
    """Its exit pupil is at infinity, in water too: δ is the circle times the focal length over the stop's diameter."""
    water, glass = lb.Glass(index), lb.Glass(1.6)
    rear = (lb.Surface(4.0, 12.0, glass, curvature=0.025), lb.Surface(0.0, 12.0, curvature=-0.025))
    gap = -lb.first_order(lb.Lens(rear, 0, front_index=index)).ffl
    lens = lb.Lens((lb.Surface(gap, 2.0, water, curvature=0.0), *rear), 0, front_index=index)
    camera, circle = lb.LensCamera(lens, lb.Film(), 3000.0, focus_method="paraxial"), 0.001
    assert np.isinf(lb.first_order(lens).exit_pupil.z)
    found = sharp_focus(camera, circle)
    near, far = lb.thick_depth_of_field(lens, camera.film_distance, 3000.0, circle)
    for plane, limit in ((found.near, near), (found.far, far)):
        assert -plane.offset - 3000.0 == pytest.approx(limit - 3000.0, rel=0.01)
