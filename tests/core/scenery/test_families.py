"""The table of families of shapes: what it says of the shapes that `lb` offers."""

import inspect

import pytest

import lensbench as lb
from lensbench.scenery.families import FAMILIES, by_field

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
