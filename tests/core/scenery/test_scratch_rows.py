"""Scratch rows that pass between stages: no stage on the way changes what a later one reads."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import (
    ALIVE, ARRIVING, BLUE, GREEN, KEYS, LIT, ONWARD, PITCH, RED, SHADOW_RAY, TIME, TINT, V0, WEIGHT, B, L, X,
    lane_buffer
)
from tests.core.scenery.test_scene import unit

RAYS = {"sun_rays", "lamp_rays", "gradient_rays", "sky_rays", "mesh_lamp_rays", "many_lamp_rays"}
SUMS = {"add_lit": SHADOW_RAY, "add_tinted": (*SHADOW_RAY, *TINT)}
LEAVING = {"solid_leave": 1.0, "diffuse_leave": 2.0}            # the mark of the lanes that each sends on
GLASS = lb.Mesh.of([[-300, -200, -1500], [300, -200, -1500], [0, -200, -900], [0, 300, -1200]],
                   [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], lb.Material((1.0,) * 3, "glass"))
SCENES = {
    "fairground": lb.builtin_scene("fairground"), "dusk street": lb.builtin_scene("dusk-street"),
    "lit room with glass": replace(lb.builtin_scene("room"), diffuse_bounce=True, meshes=(GLASS,)),
    "picture of the sky": lb.Scene("sky", lb.ImageSky(lb.Image.of(np.ones((2, 4, 3)))), floor=lb.Floor(),
                                   spheres=(lb.Sphere((0.0, 0.0, -900.0), 200.0),), meshes=(GLASS,)),
}


@pytest.mark.parametrize("name", SCENES)
def test_stages_keep_the_rows_that_a_later_one_reads(name):
    random = np.random.default_rng(1)
    lanes, key = lane_buffer(), np.zeros(KEYS, np.uint32)
    row = lanes.reshape(-1, PITCH)[:, :B]
    row[L:L + 3] = unit(np.column_stack([random.uniform(-0.6, 0.6, (B, 2)), -np.ones(B)])).T
    row[X:X + 3], row[TIME], row[V0:V0 + 2], row[WEIGHT] = 0.0, 0.01, random.random((2, B)), 1.0
    key[ALIVE] = key[LIT] = 1
    rays = onward = None
    compared = 0
    for step in SCENES[name].steps():
        if (step.gated and key[ALIVE] == 0) or (step.lights and key[LIT] == 0):
            continue
        kernel, lit = step.kernel.__name__, row[RED] + row[GREEN] + row[BLUE] > 0.0
        if kernel in SUMS:
            read = list(SUMS[kernel])
            np.testing.assert_array_equal(row[read][:, lit], rays[read][:, lit])
            assert (row[ARRIVING][lit] <= rays[ARRIVING][lit]).all()
            compared += 1
        if kernel in LEAVING:
            sent = onward[ONWARD[-1]] == LEAVING[kernel]
            np.testing.assert_array_equal(row[list(ONWARD)][:, sent], onward[list(ONWARD)][:, sent])
            compared += 1
        step.kernel(lanes, np.asarray(step.parameters, np.float32), np.asarray(step.integers, np.int64), key)
        rays = row.copy() if kernel in RAYS else rays
        onward = row.copy() if kernel in ("solid_bend", "diffuse_bend") else onward
    assert compared > 0
