"""Memory of the caches of the core: in sum that of a small laptop, and bounded as scenes come and go."""

import importlib
import pkgutil

import numpy as np

from lensbench import core
from lensbench.core.kernels.byte_cache import ByteCache
from lensbench.core.scenery import small_lights
from lensbench.core.scenery.intersect.texture import texture
from lensbench.core.scenery.objects.basic_shapes import Rectangle
from lensbench.core.scenery.objects.material import Image, Material, Pattern

LAPTOP = 8 << 30
PICTURE = (512, 1195)                   # texels of 12 bytes: 7 MB, of which four are below the bound


def test_all_caches_of_the_core_leave_most_of_a_laptop_with_8_gb():
    """A tenth of its memory, beside the textures of the present scene, which it needs."""
    caches = set()
    for module in pkgutil.walk_packages(core.__path__, "lensbench.core."):
        caches |= {each for each in vars(importlib.import_module(module.name)).values() if isinstance(each, ByteCache)}
    assert {small_lights.split_light, texture} <= caches
    assert sum(each.most_bytes for each in caches if each is not texture) < LAPTOP // 10


def test_small_lights_forget_the_pictures_of_scenes_seen_before():
    caches = (small_lights._all, small_lights._patches, small_lights.split_light, small_lights.light_samples,
              small_lights.mean_radiances, small_lights.with_unit_radiance)
    for each in caches:
        each.cache_clear()
    for k in range(12):
        image = Image.of(np.full((*PICTURE, 3), 0.01 * (k + 1)))
        shown = Rectangle((0.0, 0.0, -900.0), (50.0, 0.0, 0.0), (0.0, 50.0, 0.0),
                          Material((1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=image)))
        objects = (shown,)
        small_lights.small_lights(objects)
        small_lights.split_light(objects, ())
        small_lights.mean_radiances(objects)
        small_lights.with_unit_radiance(objects)
    held = [each.held for each in caches]
    assert max(held) <= 32 << 20 and min(held) >= image.values.nbytes       # the newest is kept
