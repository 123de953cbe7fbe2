"""The point spread against the render of a small light: same centroid, same widths, within the noise of the render."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.rendering.progressive import Rendering
from lensbench.core.scenery.objects.basic_shapes import Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene

BLACK = (0.0, 0.0, 0.0)
PITCH = 0.1             # mm, of a pixel
SIZE = 1.0 / 420.0      # radius of the light over its distance
SEEDS, SAMPLES = 6, 600


def moments(image, x, y):
    """Centroid (2,) and mean squares (2,) about it along x and y of light at places x and y."""
    light = image / image.sum()
    middle = np.array([(light * x).sum(), (light * y).sum()])
    return np.concatenate([middle, [(light * (x - middle[0])**2).sum(), (light * (y - middle[1])**2).sum()]])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "f_number", "away", "field", "sides"), [
    ("pbrt-dgauss-50mm", 2.0, 6000.0, (0.0, 0.0), (40, 40)), ("pbrt-dgauss-50mm", 2.8, 700.0, (0.0, -60.0), (40, 130)),
    ("lib-tronnier-1953", None, 5000.0, (400.0, 300.0), (110, 90))])
def test_a_point_spread_has_the_centroid_and_the_widths_of_a_rendered_light(name, f_number, away, field, sides):
    film = lb.Film(PITCH * sides[0], PITCH * sides[1], *sides)
    camera = lb.LensCamera(lenses.load(name), film, 1500.0, f_number, model="trace", dispersion=False)
    film_z, radius = camera.lens.length + camera.film_distance, SIZE * away
    scene = Scene("light", sky=Sky(BLACK, BLACK, BLACK),
                  spheres=(Sphere((*field, -away), radius, Material((50.0, 50.0, 50.0), "light")),))
    rows, columns = np.mgrid[:sides[1], :sides[0]] + 0.5
    x, y = PITCH * (0.5 * sides[0] - columns), PITCH * (rows - 0.5 * sides[1])      # the image is upside down
    seen = []
    for seed in range(SEEDS):
        rendering = Rendering(camera, scene, seed, light_tracing=False)
        rendering.add(SAMPLES)
        seen.append(moments(rendering.image()[..., 1].astype(float), x, y))
    found, noise = np.mean(seen, 0), np.std(seen, 0, ddof=1) / SEEDS**0.5

    fields = np.array(field) + [[0.0, 0.0], [radius, 0.0], [0.0, radius]]
    given = lb.analysis.conditions(camera.lens, film, fields, [lb.D_LINE], away - film_z, lb.FieldKind.OBJECT_HEIGHT)
    rays = lb.analysis.ray_grid(camera.lens, camera.film_distance, given, 64)
    spread = lb.analysis.psf(rays, 256)
    at, axes = spread.offsets[0], rays.beams.axes[0]
    s, t = np.meshgrid(at, at)
    light = spread.density[0, 0].astype(float)
    wanted = moments(light, *((s * axes[0, k] + t * axes[1, k]) for k in (0, 1)))
    wanted[:2] += rays.images[0] + spread.centres[0] @ axes
    # The light is a small disk and a pixel a square: each adds its own mean square
    disk = ((rays.images[1:] - rays.images[0])**2).sum(0) / 4.0
    wanted[2:] += disk + PITCH**2 / 12.0
    size = np.sqrt(wanted[2:].sum())
    assert noise[:2].max() < 0.01 * size and noise[2:].max() < 0.01 * size**2       # else the test shows nothing
    np.testing.assert_array_less(np.abs(found - wanted), 4.0 * noise + np.repeat([0.004 * size, 0.006 * size**2], 2))
