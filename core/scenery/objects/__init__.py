"""Scene objects, materials and light as frozen values, a file for each kind.

World frame, mm. Colours are linear red, green and blue; radiance is relative,
with 1 the radiance of a white surface under a uniform sky of 1.
"""

from lensbench.scenery.objects.image_sky import ImageSky
from lensbench.scenery.objects.material import Image, Material, Pattern
from lensbench.scenery.objects.mesh import Mesh
from lensbench.scenery.objects.planar import Disk, Rectangle
from lensbench.scenery.objects.shape import Moving, Shape, by_family, displaced
from lensbench.scenery.objects.sphere import Sphere
from lensbench.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.scenery.values import SceneError, Triple, across, check, triple, unit

__all__ = ["Disk", "Floor", "Image", "ImageSky", "Material", "Mesh", "Moving", "Pattern", "Rectangle", "SceneError",
           "Shape", "Sky", "Sphere", "Sun", "Triple", "across", "by_family", "check", "displaced", "triple", "unit"]
