"""Random lenses and cameras, odd but possible, and what must hold of their rays."""

import math
import random
import warnings

import numpy as np

import lensbench as lb
from lensbench import lenses

LENSES = ("lib-us10281683", "pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "pbrt-telephoto-250mm", "singlet", "singlet")
REFUSALS = (lb.LensError, lb.CameraError, lb.FilmError, lb.GlassError, lb.MediumError, lb.TransformError)
RAYS = 512


def singlet(rng):
    """A lens of two surfaces, spheres or planes, with its stop at either."""
    front, rear = 1.0 / rng.uniform(12.0, 200.0), rng.choice((0.0, -1.0 / rng.uniform(15.0, 300.0), 1e-9))
    rim = rng.uniform(1.0, 14.0)
    glass = lb.Glass(rng.uniform(1.4, 2.0), rng.uniform(20.0, 80.0))
    return lb.Lens((lb.Surface(rng.uniform(0.5, 12.0), rim, glass, curvature=front),
                    lb.Surface(0.0, rim, curvature=rear)),
                   rng.randrange(2))


def lens_camera(rng):
    """A camera with a lens of any model, stop, focus and film."""
    name = rng.choice(LENSES)
    lens = singlet(rng) if name == "singlet" else lenses.load(name)
    order = lb.first_order(lens)
    wide = math.exp(rng.uniform(math.log(0.05), math.log(8.0)))
    film = lb.Film(36.0 * wide * rng.uniform(0.3, 1.0), 24.0 * wide, rng.randint(1, 200), rng.randint(1, 200))
    f_number = rng.choice((None, order.f_number * math.exp(rng.uniform(0.0, 6.0))))
    nearest = lb.nearest_focus(lens)
    distance = rng.choice((math.inf, nearest, nearest * (1.0 + rng.random()), 10.0 ** rng.uniform(1.0, 12.0)))
    return lb.LensCamera(lens, film, distance, f_number, rng.choice(("trace", "polynomial", "polynomial", "thick",
                                                                     "thin", "pinhole")),
                         rng.choice((3, 5, 7, 9, 11)), focus_method=rng.choice(("paraxial", "real")),
                         medium=rng.choice((None, None, lb.Medium.water(5000.0), lb.Medium.fog(900.0))),
                         weights=rng.choice(("relative", "physical")))


def plain_camera(rng):
    """A camera without a lens."""
    film = lb.Film(10.0 ** rng.uniform(-2.0, 3.0), 10.0 ** rng.uniform(-2.0, 3.0), rng.randint(1, 200),
                   rng.randint(1, 200))
    fov = rng.choice((math.radians(0.001), math.radians(179.99), rng.uniform(0.01, 3.1)))
    return rng.choice((
        lambda: lb.PerspectiveCamera(film, fov=fov, lens_radius=rng.choice((0.0, 5.0)),
                                     focus_distance=rng.choice((math.inf, 1e-3, 1e12, 700.0))),
        lambda: lb.FisheyeCamera(film, fov=rng.choice((fov, math.radians(359.99), math.pi)),
                                 projection=rng.choice(("equidistant", "equisolid", "stereographic", "orthographic"))),
        lambda: lb.EnvironmentCamera(film, rng.choice(("equirectangular", "equal-area", "cube-map"))),
        lambda: lb.OrthographicCamera(film, rng.choice((1e-3, 1e9, 900.0)), rng.choice((0.0, 20.0)), 900.0),
        lambda: lb.PinholeCamera(film, rng.choice((1e-3, 50.0, 1e6)), rng.choice((1e-3, 0.3, 1e4)))))()


def fault(rng):
    """What is wrong with the rays of a random camera; "" where all is well or the camera is refused."""
    state = rng.getstate()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            camera = (lens_camera if rng.random() < 0.7 else plain_camera)(rng)
            places = np.random.default_rng(rng.getrandbits(32))
            raster = places.random((RAYS, 2)) * [camera.film.pixels_x, camera.film.pixels_y]
            rays = camera.generate_rays(raster, places.random((RAYS, 2)), dtype=rng.choice((np.float32, np.float64)))
    except REFUSALS as error:
        return "" if str(error).isprintable() and len(str(error)) < 400 else f"message {error}"
    except Exception as error:                          # any other is a fault of the program
        return f"{type(error).__name__}: {error} {state[1][-1]}"
    seen = rays.weights > 0.0
    if not (np.isfinite(rays.weights).all() and (rays.weights >= 0.0).all()):
        return f"weights of {camera}"
    if not (np.isfinite(rays.origins[seen]).all() and np.isfinite(rays.directions[seen]).all()):
        return f"rays that are not finite of {camera}"
    off = np.abs((rays.directions[seen].astype(float) ** 2).sum(1) - 1.0).max(initial=0.0)
    return f"directions off by {off:.1e} of {camera}" if off > 3e-4 else ""


def faults(times, seed):
    """The faults among so many random cameras."""
    rng = random.Random(seed)
    return [found for _ in range(times) if (found := fault(rng))]
