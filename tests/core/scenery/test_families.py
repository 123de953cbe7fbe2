"""The table of families of shapes: what it says of the shapes that `lb` offers."""

import inspect
import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.scenery.families import FAMILIES, by_field

SHAPES = [value for name in lb.__all__ if inspect.isclass(value := getattr(lb, name)) and hasattr(value, "family")]


@pytest.mark.parametrize("shape", SHAPES)
def test_a_shape_belongs_to_the_row_of_its_family_and_a_scene_has_its_field(shape):
    row = FAMILIES[shape.family]
    assert issubclass(shape, row.kind)
    assert getattr(lb.Scene(), row.field) == ()


def test_a_scene_made_of_shapes_by_their_fields_has_just_these_shapes():
    ball, disk = lb.Sphere((0.0, 0.0, -9.0), 1.0), lb.Disk((0.0, 0.0, -9.0), (0.0, 0.0, 1.0), 2.0)
    mesh = lb.Mesh.of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    scene = lb.Scene(**by_field([mesh, disk, ball]))
    assert (scene.spheres, scene.plates, scene.meshes) == ((ball,), (disk,), (mesh,))
    assert scene.objects == (ball, disk, mesh)
    with pytest.raises(lb.SceneError, match="spheres of a scene: Disk"):
        lb.Scene(spheres=(disk,))


@pytest.mark.parametrize(("shape", "area"), [
    (lb.Disk((1.0, 2.0, -9.0), (0.0, 1.0, 0.0), 2.0), 10 * math.sin(math.pi / 10) * math.cos(math.pi / 10) * 2.0**2),
    (lb.Sphere((1.0, 2.0, -9.0), 2.0), 10 * math.sin(math.pi / 10) * math.cos(math.pi / 10) * 2.0**2),
    (lb.Rectangle((1.0, 2.0, -9.0), (3.0, 0.0, 0.0), (0.0, 0.0, 2.0)), 24.0)], ids=["disk", "sphere", "rectangle"])
def test_the_outline_from_above_encloses_the_area_of_an_inscribed_polygon(shape, area):
    x, _, z = np.transpose(shape.outline(10))
    assert abs((x * np.roll(z, 1) - z * np.roll(x, 1)).sum()) / 2.0 == pytest.approx(area, rel=1e-12)
    assert (x.mean(), z.mean()) == pytest.approx((1.0, -9.0))


@pytest.mark.parametrize("shape", [lb.Disk((1.0, 2.0, -9.0), (0.0, 1.0, 0.0), 3.0), lb.Sphere((1.0, 2.0, -9.0), 3.0),
                                   lb.Rectangle((1.0, 2.0, -9.0), (3.0, 0.0, 0.0), (0.0, 0.0, 2.0))])
def test_the_area_of_a_shape_is_that_of_a_fine_outline(shape):
    x, _, z = np.transpose(shape.outline(3000))
    assert shape.area == pytest.approx(abs((x * np.roll(z, 1) - z * np.roll(x, 1)).sum()) / 2.0, rel=1e-5)
