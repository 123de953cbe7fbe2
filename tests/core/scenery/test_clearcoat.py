"""What coats, glass and metal add of what they reflect sharply, stage by stage against Schlick's law."""

import numpy as np
import pytest

from lensbench.core.kernels.block import A6, FINISH, NX, PITCH, RED, SR, TR, B, L, lane_buffer
from lensbench.core.scenery.shading.clearcoat import sharp_close
from lensbench.core.scenery.surface_codes import GLASS, MATTE, METAL
from tests.core.scenery.test_scene import unit

BARE = 0.04             # of the light that glass of index 1.5 reflects at right angles


@pytest.mark.parametrize("last", [0, 1])
def test_every_channel_reflects_by_schlicks_law_metal_only_at_the_end_of_a_path(last):
    random = np.random.default_rng(6)
    lanes = lane_buffer(np.float64)
    row = lanes.reshape(-1, PITCH)[:, :B]
    ways, normals = unit(random.normal(size=(B, 3))), unit(random.normal(size=(B, 3)))
    normals *= -np.sign((ways * normals).sum(1))[:, None]
    finish = random.choice([MATTE, 1.0, METAL, GLASS, GLASS + 40.0], B)
    colour, light, left, before = random.random((4, 3, B))
    row[L:L + 3], row[NX:NX + 3], row[FINISH] = ways.T, normals.T, finish
    row[RED:RED + 3], row[A6:A6 + 3], row[TR:TR + 3], row[SR:SR + 3] = colour, light, left, before
    sharp_close(lanes, last)
    edge = (1.0 + (ways * normals).sum(1)) ** 5
    one = BARE + (1.0 - BARE) * edge
    # A pane reflects at both sides, again and again: F + (1 − F)² F / (1 − F²)
    glassy = ((finish == 1.0) | (finish > GLASS)) * one + (finish == GLASS) * 2.0 * one / (1.0 + one)
    metal = (finish == METAL) * last * (colour + (1.0 - colour) * edge)
    np.testing.assert_allclose(row[SR:SR + 3], before + left * light * (glassy + metal), rtol=1e-12)
    np.testing.assert_allclose(row[RED:RED + 3], colour * (1.0 - glassy * (finish == 1.0)), rtol=1e-12)
