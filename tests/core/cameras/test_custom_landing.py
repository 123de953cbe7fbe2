"""Light traced to the film of a custom camera by the way back that its user gives."""

import itertools
import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.cameras.custom import CustomLanding
from tests.core.cameras.test_custom import DISTANCE, FILM, FOV, TWINS, film_points, pinhole, thin_lens

BLACK = (0.0, 0.0, 0.0)
FAR = 12000.0
SIZE = [FILM.width, -FILM.height]
PIXELS = [FILM.pixels_x, FILM.pixels_y]


def back_through(radius, focus):
    """The inverse of `thin_lens`; of `pinhole` for a radius of 0."""
    def back(origins, directions):
        slopes = directions[:, :2] / -directions[:, 2:]
        lens = origins[:, :2] + origins[:, 2:] * slopes
        film = (lens + focus * slopes) * DISTANCE / focus
        return (film / SIZE + 0.5) * PIXELS, lb.unit_square(lens / radius) if radius else np.full((len(lens), 2), 0.5)
    return back


BACK = {"perspective": back_through(0.0, 1.0), "thin lens": back_through(9.0, 700.0)}


def lights(size=40.0):
    shine = lb.Material((40.0, 30.0, 20.0), "light")
    return lb.Scene("lights", lb.Sky(BLACK, BLACK, BLACK), spheres=(
        lb.Sphere((900.0, 700.0, -FAR), size, shine), lb.Sphere((-3100.0, 2000.0, -FAR), size, shine),
        lb.Sphere((-120.0, -100.0, -1440.0), 3.0, shine)))


def picture(camera, samples, scene=None, **more):
    rendering = lb.Rendering(camera, scene or lights(), **more)
    rendering.add(samples)
    return rendering.image().astype(float), rendering.light_traced


def test_pupil_samples_come_back_from_the_disk():
    uv = np.random.default_rng(0).random((1000, 2))
    np.testing.assert_allclose(lb.unit_square(lb.unit_disk(uv)), uv, atol=1e-14)
    beyond = lb.unit_square(lb.unit_disk(uv) / np.linalg.norm(lb.unit_disk(uv), axis=1)[:, None] * 1.01)
    assert (np.abs(2.0 * beyond - 1.0).max(1) > 1.0).all()
    np.testing.assert_allclose(lb.unit_square([[0.0, 0.0]]), [[0.5, 0.5]])


@pytest.mark.slow
@pytest.mark.parametrize("name", TWINS)
def test_light_reaches_the_film_of_a_custom_camera_as_that_of_its_built_in_twin(name):
    """A pinhole draws the rays of its twin, so that only the numeric derivatives differ; a pupil draws its own."""
    rays, twin = TWINS[name]
    own, seen = picture(lb.CustomCamera(FILM, rays, False, BACK[name]), 96)
    given, also = picture(twin, 96)
    assert seen == also == {0, 1, 2}
    assert own.sum((0, 1)) == pytest.approx(given.sum((0, 1)), rel=1e-6 if name == "perspective" else 3e-3)
    assert np.abs(own - given).max() < (1e-6 if name == "perspective" else 0.03) * given.max()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["bent", "vignetted"])
def test_traced_light_is_the_flux_that_the_cameras_own_rays_find(kind):
    """Functions without a built-in twin; the noise of both pictures together is 0.4 %."""
    thin, thin_back = thin_lens(9.0, 5000.0), back_through(9.0, 5000.0)

    def bend(raster):                                           # a film point farther out than it is: 1 + 0.4 r²
        a = np.asarray(raster) / PIXELS - 0.5
        return (a * (1.0 + 0.4 * (a**2).sum(1))[:, None] + 0.5) * PIXELS

    def unbend(raster):
        b = raster / PIXELS - 0.5
        r = far = np.linalg.norm(b, axis=1)
        for _ in range(60):
            r = far / (1.0 + 0.4 * r**2)
        return (b * (r / np.where(far > 0.0, far, 1.0))[:, None] + 0.5) * PIXELS

    def bent(raster, uv, time):
        return thin(bend(raster), uv, time)

    def unbent(origins, directions):
        raster, uv = thin_back(origins, directions)
        return unbend(raster), uv

    def cut(raster, uv, time):
        origins, directions, weights = thin(raster, uv, time)
        return origins, directions, weights * (uv[:, 0] < 0.7) * (0.2 + uv[:, 1])

    rays, back = {"bent": (bent, unbent), "vignetted": (cut, thin_back)}[kind]
    scene = lights(110.0)
    camera = lb.CustomCamera(FILM, rays, False, back)
    traced, seen = picture(camera, 64, scene)
    plain, _ = picture(camera, 1536, scene, light_tracing=False)
    assert seen == {0, 1, 2}
    assert traced.sum((0, 1)) == pytest.approx(plain.sum((0, 1)), rel=1.2e-2)


@pytest.mark.slow
def test_light_reaches_an_eye_beside_the_axis_as_a_camera_that_stands_there():
    eye = np.array([30.0, 4.0, 2.0])
    place = np.eye(4)
    place[:3, 3] = eye

    def back(origins, directions):
        return BACK["perspective"](origins - eye, directions)

    own, seen = picture(lb.CustomCamera(FILM, lambda raster, *_: (eye, film_points(raster)), False, back), 16)
    given, also = picture(lb.PerspectiveCamera(FILM, FOV, world_from_camera=place, weights="radiance"), 16)
    assert seen == also == {0, 1, 2}
    assert own.sum((0, 1)) == pytest.approx(given.sum((0, 1)), rel=1e-5)


def returning(make):
    return lambda origins, directions: make(len(origins))


@pytest.mark.parametrize("back, message", [
    (3, "back is a function of origins"),
    (returning(lambda n: None), "must return raster points and pupil samples"),
    (returning(lambda n: np.zeros((n, 2))), "must return raster points and pupil samples"),
    (returning(lambda n: (np.zeros((n, 3)), np.zeros((n, 2)))), r"raster of the shape \(\d+, 3\)"),
    (returning(lambda n: (np.zeros((n, 2)), "middle")), r"uv of the shape \(\)"),
    (returning(lambda n: (np.full((n, 2), np.nan), np.zeros((n, 2)))), "raster that is not a number.*return inf"),
    (returning(lambda n: (np.zeros((n, 2)), np.zeros((n, 2)))), r"does not invert .* the ray of the raster point \("),
    (back_through(9.0, 690.0), "does not invert"),
    (back_through(9.1, 700.0), "does not invert"),
])
def test_a_way_back_that_is_none_is_refused_when_the_camera_is_made(back, message):
    with pytest.raises(lb.CameraError, match=message):
        lb.CustomCamera(FILM, TWINS["thin lens"][0], False, back)


def test_a_way_back_needs_a_camera_at_one_time_with_an_etendue():
    with pytest.raises(lb.CameraError, match="time_dependent=False"):
        lb.CustomCamera(FILM, pinhole, back=BACK["perspective"])

    def slit(raster, uv, time):                 # every film point sees from a point of its own
        ahead = film_points(raster)
        return np.pad(ahead[:, :1], ((0, 0), (0, 2))), ahead

    def from_slit(origins, directions):
        slopes = directions[:, :2] / -directions[:, 2:]
        return (slopes * DISTANCE / SIZE + 0.5) * PIXELS, np.full((len(slopes), 2), 0.5)

    with pytest.raises(lb.CameraError, match="no étendue"):
        lb.CustomCamera(FILM, slit, False, from_slit)
    with pytest.raises(lb.CameraError, match="blocks every ray"):
        lb.CustomCamera(FILM, lambda *_: (np.zeros(3), [0.0, 0.0, -1.0], 0.0), False, from_slit)


def test_a_way_back_that_errs_only_for_some_rays_ends_the_picture_with_its_message():
    """Beyond the probes: wrong, mirrored across, or no number, for the rays of one light."""
    def wrong(change):
        def back(origins, directions):
            raster, uv = BACK["perspective"](origins, directions)
            here = (np.abs(raster - raster_of_light) < 0.02).all(1)
            return np.where(here[:, None], change(raster), raster), uv
        return back

    raster_of_light = np.array([900.0, 700.0]) / FAR * DISTANCE / SIZE * PIXELS + 0.5 * np.array(PIXELS)
    shine = lb.Material((40.0, 30.0, 20.0), "light")
    scene = lb.Scene("light", lb.Sky(BLACK, BLACK, BLACK), spheres=(lb.Sphere((900.0, 700.0, -FAR), 2.0, shine),))
    another = "for which the function returns another ray"
    for change, message in ((lambda raster: 20.0, another), (lambda raster: [PIXELS[0], 0.0] + [-1.0, 1.0] * raster,
                                                             another), (lambda raster: math.nan, "not a number")):
        camera = lb.CustomCamera(FILM, pinhole, False, wrong(change))
        with pytest.raises(lb.CameraError, match=message):
            picture(camera, 1, scene)


def test_the_function_is_not_asked_for_rays_beyond_the_film_or_the_pupil():
    """Nor for differences at the very edges."""
    def rays(raster, uv):
        assert raster.min() >= 0.0 and (raster <= PIXELS).all() and uv.min() >= 0.0 and uv.max() <= 1.0
        origins, directions, *_ = TWINS["thin lens"][0](raster, uv, np.zeros(len(raster)))
        return origins, directions, np.ones(len(raster))

    corners = np.array(list(itertools.product((0.0, 1.0), repeat=4)))
    way_back = CustomLanding(FILM, rays, BACK["thin lens"])
    assert (way_back._measured(corners[:, :2] * PIXELS, corners[:, 2:]).etendue > 0.0).all()
