"""Cameras of a Python function: equal to their built-in twins, laws of optics, and what they refuse."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.sampling import unit_disk

FILM = lb.Film(36.0, 24.0, 60, 40)
DISTANCE = 50.0


def film_points(raster):
    """The rule of the design page, written out: film points (mm) seen from the front, upright."""
    return np.stack([(raster[:, 0] / FILM.pixels_x - 0.5) * FILM.width,
                     (0.5 - raster[:, 1] / FILM.pixels_y) * FILM.height, np.full(len(raster), -DISTANCE)], 1)


def pinhole(raster, uv, time):
    directions = film_points(raster)
    return np.zeros(3), directions, (DISTANCE / np.linalg.norm(directions, axis=1)) ** 4


def thin_lens(radius, focus):
    def rays(raster, uv, time):
        aimed = film_points(raster)
        lens = np.pad(radius * unit_disk(uv), ((0, 0), (0, 1)))
        met = aimed * focus / DISTANCE
        inside = lens + aimed * [-1.0, -1.0, 1.0]               # from the film through the lens point
        inside[:, :2] = aimed[:, :2] + lens[:, :2]
        cosine = DISTANCE / np.linalg.norm(inside, axis=1)
        on_axis = 1.0 + (radius / DISTANCE) ** 2                # normalises the mean of cos⁴ over the lens to 1
        return lens, met - lens, cosine**4 * on_axis
    return rays


def samples(n=2000):
    random = np.random.default_rng(0)
    return random.random((n, 2)) * [FILM.pixels_x, FILM.pixels_y], random.random((n, 2))


FOV = 2.0 * math.atan(12.0 / DISTANCE)
TWINS = {
    "perspective": (pinhole, lb.PerspectiveCamera(FILM, FOV)),
    "thin lens": (thin_lens(9.0, 700.0), lb.PerspectiveCamera(FILM, FOV, 9.0, 700.0)),
}


@pytest.mark.parametrize("name", TWINS)
def test_a_custom_camera_sends_the_rays_of_its_built_in_twin(name):
    rays, twin = TWINS[name]
    raster, uv = samples()
    for real, tolerance in ((np.float64, 3e-8), (np.float32, 1e-6)):       # the disk's polynomials are good to 3e-8
        own = lb.CustomCamera(FILM, rays).generate_rays(raster, uv, dtype=real)
        given = twin.generate_rays(raster, uv, dtype=real)
        np.testing.assert_allclose(own.origins, given.origins, rtol=0, atol=9.0 * tolerance)
        np.testing.assert_allclose(own.directions, given.directions, rtol=0, atol=tolerance)
        np.testing.assert_allclose(own.weights, given.weights, rtol=0, atol=2.0 * tolerance)


@pytest.mark.parametrize("name", TWINS)
def test_a_custom_camera_takes_the_picture_of_its_built_in_twin(name):
    rays, twin = TWINS[name]
    scene = lb.builtin_scene("grid-wall")
    pictures = []
    for camera in (lb.CustomCamera(FILM, rays, time_dependent=False), twin):
        rendering = lb.Rendering(camera, scene, real=np.float64, light_tracing=False)
        rendering.add(4)
        pictures.append(rendering.image())
    np.testing.assert_allclose(*pictures, rtol=0, atol=1e-5)


def test_a_tilted_lens_is_sharp_on_the_plane_through_the_hinge():
    """Scheimpflug: film, lens plane and plane in focus meet in one line; here a lens that is tilted about x."""
    tilt, focal = 0.15, 45.0
    across, axis = np.array([0.0, math.cos(tilt), math.sin(tilt)]), np.array([0.0, math.sin(tilt), -math.cos(tilt)])

    def rays(raster, uv, time):
        film = film_points(raster) * -1.0                       # behind the lens, upside down
        behind = -film @ axis                                   # distance from the lens plane
        ahead = 1.0 / (1.0 / focal - 1.0 / behind)
        image = film * -(ahead / behind)[:, None]
        disk = 5.0 * unit_disk(uv)
        lens = disk[:, :1] * [1.0, 0.0, 0.0] + disk[:, 1:] * across
        return lens, image - lens, 1.0

    camera = lb.CustomCamera(FILM, rays, time_dependent=False)
    # The plane in focus, by the hinge of film and lens plane, and Newton's equation on the axis
    raster, _ = samples(300)
    rays_ = camera.generate_rays(np.repeat(raster, 7, 0), np.random.default_rng(1).random((2100, 2)))
    o, d = rays_.origins.reshape(300, 7, 3), rays_.directions.reshape(300, 7, 3)
    # The film z = 50 meets the lens plane at y = 50 / tan(tilt)
    hinge = np.array([0.0, DISTANCE / math.tan(tilt), DISTANCE])
    on_axis = axis * (1.0 / (1.0 / focal - math.cos(tilt) / DISTANCE))
    normal = np.cross([1.0, 0.0, 0.0], on_axis - hinge)
    t = ((hinge - o) @ normal) / (d @ normal)
    met = o + t[..., None] * d
    assert np.ptp(met, axis=1).max() < 1e-8 * np.abs(met).max()
    assert np.abs(met[:, 0] @ normal / np.linalg.norm(normal) - hinge @ normal / np.linalg.norm(normal)).max() < 1e-8


def test_a_function_of_time_gets_seconds_and_at_holds_them():
    def sliding(raster, uv, time):
        return np.stack([100.0 * time, 0.0 * time, 0.0 * time], 1), [0.0, 0.0, -1.0]

    camera = lb.CustomCamera(FILM, sliding, shutter_open=2.0, shutter_close=4.0)
    raster, uv = samples(100)
    np.testing.assert_allclose(camera.generate_rays(raster, uv, 0.5).origins[:, 0], 300.0)
    np.testing.assert_allclose(camera.at(2.5).generate_rays(raster, uv, 0.5).origins[:, 0], 250.0)
    # A pair of a white and a black half: half of the time over each
    white, black = ((tone,) * 3 for tone in (1.0, 0.0))
    wall = lb.Rectangle((0.0, 0.0, -10.0), (300.0, 0.0, 0.0), (0.0, 500.0, 0.0), lb.Material(white, "light"))
    picture = lb.render(camera, lb.Scene("wall", lb.Sky(black, black, black), plates=(wall,)), 64)
    assert picture.mean() == pytest.approx(0.5, abs=0.02)       # seen from x = 200 mm to 300 mm of 200 mm to 400 mm
    with pytest.raises(lb.CameraError, match="at.seconds"):
        camera.raster_from_point([[0.0, 0.0, -5.0]], time=[0.2])


def test_points_project_through_a_custom_camera():
    rays, twin = TWINS["thin lens"]
    raster, uv = samples(50)
    of = twin.generate_rays(raster, uv)
    back, visible = lb.CustomCamera(FILM, rays).raster_from_point(of.origins + 650.0 * of.directions, uv)
    assert visible.all()
    np.testing.assert_allclose(back, raster, atol=1e-4)         # the polynomials of the disk, 3e-8 of 9 mm


def returning(value):
    return lambda raster, uv, time: value(len(raster))


DOWN = [0.0, 0.0, -1.0]


@pytest.mark.parametrize("value, message", [
    (lambda n: None, "returned None: it must return origins"),
    (lambda n: np.zeros((n, 6)), r"an array of the shape \(\d+, 6\)"),
    (lambda n: (np.zeros(3), np.ones((n, 2))), "directions as an array"),
    (lambda n: (np.zeros(3), np.ones((n + 1, 3))), "must have the shape"),
    (lambda n: (np.zeros(3), "ahead"), "directions as 'ahead'"),
    (lambda n: (np.zeros(3), np.zeros((n, 3))), "direction of length 0"),
    (lambda n: (np.zeros(3), np.full((n, 3), np.nan)), "direction that is not finite"),
    (lambda n: ([0.0, 0.0, np.inf], DOWN), "origin that is not finite"),
    (lambda n: (np.zeros(3), DOWN, np.full(n, np.nan)), "weight that is not a finite"),
    (lambda n: (np.zeros(3), DOWN, 1e300), "weight that is not a finite number below 1e30"),
    (lambda n: ([0.0, 1e300, 0.0], DOWN), "origin that is not finite and within 1e30 mm"),
    (lambda n: (np.zeros(3), np.full((n, 3), 1j)), "directions as an array"),
    (lambda n: (np.zeros(3), DOWN, -np.ones(n)), "negative weight"),
    (lambda n: (np.zeros(3), DOWN, np.ones(n + 1)), "weights as an array"),
])
def test_what_is_no_ray_is_refused_when_the_camera_is_made(value, message):
    with pytest.raises(lb.CameraError, match=message):
        lb.CustomCamera(FILM, returning(value))


def test_a_film_that_is_none_is_refused():
    with pytest.raises(lb.CameraError, match="is an lb.Film, not 36.0"):
        lb.CustomCamera(36.0, returning(lambda n: (np.zeros(3), DOWN)))


def test_a_fault_in_the_middle_of_a_picture_ends_it_with_its_message():
    def late(raster, uv, time):
        directions = film_points(raster)
        directions[(raster < 3.0).all(1)] = np.nan
        return np.zeros(3), directions

    with pytest.raises(lb.CameraError, match="not finite for the raster point"):
        lb.render(lb.CustomCamera(FILM, late), lb.builtin_scene("grid-wall"), 2)

    class MineError(Exception):
        pass

    calls = []

    def broken(raster, uv, time):
        calls.append(1)
        if len(calls) > 1:
            raise MineError
        return np.zeros(3), film_points(raster)

    with pytest.raises(MineError):
        lb.CustomCamera(FILM, broken).generate_rays([[1.0, 1.0]], [[0.5, 0.5]])
    lb.PerspectiveCamera(FILM).generate_rays([[1.0, 1.0]], [[0.5, 0.5]])       # nothing remains of the error


def test_blocked_rays_may_hold_anything():
    def half(raster, uv, time):
        lit = raster[:, 0] > 30.0
        return (np.where(lit[:, None], 0.0, np.nan), np.where(lit[:, None], film_points(raster), 0.0), lit * 1.0)

    picture = lb.render(lb.CustomCamera(FILM, half), lb.Scene("white", lb.Sky((1, 1, 1), (1, 1, 1), (1, 1, 1))), 1)
    assert (picture[:, :30] == 0.0).all() and (picture[:, 31:] > 0.5).all()


@pytest.mark.parametrize("make, message", [
    (lambda: lb.CustomCamera(FILM), "needs a function"),
    (lambda: lb.CustomCamera(FILM, lambda raster, uv: None), "rays is called with raster, uv and time"),
    (lambda: lb.CustomCamera(FILM, pinhole, time_dependent=False, back=lambda rays: None),
     "back is called with origins and directions"),
    (lambda: lb.CustomCamera(FILM, pinhole, weights="physical"), "leave weights out"),
    (lambda: lb.CustomCamera(FILM, pinhole, medium=lb.Medium.water(5000.0)), "index 1"),
    (lambda: lb.CustomCamera(FILM, pinhole).intrinsics, "come from a function"),
    (lambda: lb.BareSensor(FILM).intrinsics, "forms no picture"),
    (lambda: lb.capture_light_field(lb.CustomCamera(FILM, pinhole), lb.builtin_scene("grid-wall")),
     "come from a function"),
])
def test_what_a_custom_camera_cannot_do_is_said(make, message):
    with pytest.raises(lb.CameraError, match=message):
        make()


def test_a_camera_that_overrides_generate_rays_is_not_rendered_as_another():
    @dataclass(frozen=True, eq=False)
    class Own(lb.PerspectiveCamera):
        def generate_rays(self, *arguments, **named):
            return super().generate_rays(*arguments, **named)

    for use in (lb.render, lb.depth_map):
        with pytest.raises(lb.CameraError, match="Own overrides generate_rays.*CustomCamera"):
            use(Own(FILM), lb.builtin_scene("grid-wall"))


def test_a_custom_camera_sends_the_rays_of_a_thin_lens_before_a_tilted_film():
    """The built-in twin of Scheimpflug: a point of the film, a point of the lens, and Newton's image of the former."""
    tilt, distance = 0.2, 1500.0
    twin = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, distance, 4.0, model="thin", weights="one",
                         film_pose=lb.FilmPose(tilt=tilt))
    data = lb.first_order(twin.lens)
    front = -twin.lens.length - twin.film_distance                      # z of the first vertex, of the film 0
    place = data.entrance_pupil.z + front
    # In focus at `distance` with the magnification of the real lens: f over the distance to its front focus
    image = (distance + place) * data.efl / (distance + front + data.front_principal - data.efl)
    focal = 1.0 / (1.0 / image + 1.0 / (distance + place))

    def rays(raster, uv, time):
        film = -film_points(raster)
        # The top of the film tips back, away from the lens
        point = np.stack([film[:, 0], film[:, 1] * math.cos(tilt), film[:, 1] * math.sin(tilt)], 1)
        behind = image + point[:, 2]
        ahead = 1.0 / (1.0 / focal - 1.0 / behind)
        met = np.stack([*(-point[:, :2] * (ahead / behind)[:, None]).T, place - ahead], 1)
        lens = np.pad(data.entrance_pupil.radius * unit_disk(uv), ((0, 0), (0, 1))) + [0.0, 0.0, place]
        return lens, np.where(ahead[:, None] > 0.0, met - lens, lens - met)

    raster, uv = samples()
    own, given = (camera.generate_rays(raster, uv, dtype=np.float64)
                  for camera in (lb.CustomCamera(FILM, rays, time_dependent=False), twin))
    np.testing.assert_allclose(own.directions, given.directions, rtol=0, atol=1e-6)
    beside = np.cross(given.origins - own.origins, given.directions)                # mm between the two lines
    np.testing.assert_allclose(beside, 0.0, rtol=0, atol=1e-6)
    np.testing.assert_allclose(own.weights, given.weights, rtol=0, atol=1e-6)
