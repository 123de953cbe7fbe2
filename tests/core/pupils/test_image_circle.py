"""The end of the light on films of any size."""

import math

import numpy as np
import pytest

from lensbench.core.pupils.outline_solver import Aim, edge_of_light
from tests.core.oracles import lens as reference_lens

DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])


@pytest.mark.parametrize("half_film", [100.0, 3e3, 2e5])
def test_the_edge_of_light_does_not_depend_on_the_size_of_the_film(half_film):
    """A film of more than 16 image circles was taken as lit throughout. To 0.5 % of the radius: rays of the scan."""
    aim = Aim(reference_lens("dgauss"), 43.34)
    near, _ = edge_of_light(aim, 60.0 * DIRECTIONS, math.sqrt(2.0))
    edge, light_ends = edge_of_light(aim, half_film * DIRECTIONS, math.sqrt(2.0))
    assert light_ends and half_film * edge == pytest.approx(60.0 * near, rel=5e-3)


def test_a_film_within_the_image_circle_is_lit_to_its_corner():
    edge, light_ends = edge_of_light(Aim(reference_lens("dgauss"), 43.34), 2.0 * DIRECTIONS, math.sqrt(2.0))
    assert not light_ends and (edge == math.sqrt(2.0)).all()
