"""Images of every size up to 8192 × 8192 texels are looked up texel by texel, in single precision too."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import (
    A1, A2, A4, A5, A6, A7, A8, BLUE, GREEN, PATH, PITCH, RED, B, L, M, N, lane_buffer
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.texture import SECOND, Ripmap, look_up, ripmap


def test_every_texel_of_a_large_image_is_seen_in_its_place():
    # 17.9 million numbers with their reductions: more than single precision counts one by one
    height, width = 1500, 2000
    image = np.zeros((height, width, 3), np.float32)
    image[..., 0], image[..., 1] = np.arange(width) / width, np.arange(height)[:, None] / height
    pattern = lb.Pattern("image", image=lb.Image.of(image))
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (400.0, 0.0, 0.0), (0.0, 300.0, 0.0),
                        lb.Material((1.0,) * 3, "light", pattern=pattern))
    beside = lb.Rectangle((600.0, 0.0, -1000.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), lb.Material((0.5,) * 3, "light"))
    scene = lb.Scene("wall", plates=(wall, beside))
    random = np.random.default_rng(3)
    i, j = random.integers(0, height, 600), random.integers(0, width, 600)
    i[:2], j[:2] = (0, height - 1), (0, width - 1)
    u, v = (2.0 * j + 1.0) / width - 1.0, 1.0 - (2.0 * i + 1.0) / height
    points = np.column_stack([400.0 * u, 300.0 * v, np.full(600, -1000.0)])
    points[5] = (600.0, 0.0, -1000.0)
    d = points / np.linalg.norm(points, axis=1)[:, None]
    found = Program(scene.steps(), np.float32).run({L: d[:, 0], M: d[:, 1], N: d[:, 2]}, [RED, GREEN, BLUE], 600).T
    assert found[5] == pytest.approx(0.5)               # the shape that follows in the parameters
    found, i, j = np.delete(found, 5, 0), np.delete(i, 5), np.delete(j, 5)
    # a ray meets the wall within 1e-3 of a texel; the code has 16 bits, a step of 3e-5 at 1
    np.testing.assert_allclose(found[:, 0], j / width, atol=3e-5)
    np.testing.assert_allclose(found[:, 1], i / height, atol=3e-5)


@pytest.mark.parametrize("specular", [0.0, 1.0])
def test_the_last_texel_of_the_largest_image_is_found(specular):
    # Memory that nobody writes takes no place: only the pages of a few texels are there
    side = 8192
    levels = [max(2, side >> k) for k in range(13)]
    header, integers = Ripmap(levels, levels, [0] * 145, np.zeros((0, 3))).packed()[0]
    second = side * side * (specular > 0.0)
    numbers = np.zeros(header.size + 3 * side * side * 2, np.float32)
    numbers[:header.size] = header
    texels = numbers[header.size:].reshape(-1, 3)
    texels[second + side * side - 1] = 1.0, 2.0, 3.0
    texels[second + side * (side - 2) + 5] = 4.0, 5.0, 6.0
    lanes = lane_buffer()
    row = rows_of(lanes)
    row[A7], row[A8], row[PATH] = 0.0, 0.0, specular
    row[A1], row[A2] = 1.0, -1.0
    row[A1, 1], row[A2, 1] = 11.0 / side - 1.0, 3.0 / side - 1.0
    integers = np.array(integers)
    integers[SECOND] = second
    look_up(lanes, numbers, integers)
    assert row[[A4, A5, A6], 0].tolist() == [1.0, 2.0, 3.0]
    assert row[[A4, A5, A6], 1] == pytest.approx([4.0, 5.0, 6.0], rel=1e-3)


def rows_of(lanes):
    """The rows of a lane buffer as a table (rows, lanes)."""
    return lanes.reshape(-1, PITCH)[:, :B]


def test_a_larger_image_is_refused_before_it_is_copied():
    large = np.broadcast_to(np.float32(0.0), (8, 9000, 3))
    with pytest.raises(lb.SceneError, match="9000 × 8 texels is too large: reduce it to at most 8192 × 8192"):
        lb.Image.of(large)


def test_a_ramp_looks_the_same_through_footprints_of_any_width_and_height():
    """The means of whole texels of a ramp are the ramp at their middles."""
    wide, tall = 256, 64
    u, v = np.meshgrid((2.0 * np.arange(wide) + 1.0) / wide - 1.0, 1.0 - (2.0 * np.arange(tall) + 1.0) / tall)
    ramp = np.stack([0.5 + 0.4 * u, 0.5 + 0.3 * v, 0.5 + 0.2 * u - 0.25 * v], -1)
    (header, integers), (texels, _) = ripmap(ramp).packed()
    random = np.random.default_rng(9)
    lanes = lane_buffer(np.float64)
    row = rows_of(lanes)
    for widest in (-1.2, 0.3):
        u, v = random.uniform(-0.45, 0.45, (2, B))
        row[A1], row[A2], (row[A7], row[A8]) = u, v, 10.0 ** random.uniform(-3.0, widest, (2, B))
        look_up(lanes, np.concatenate([header, texels]), np.array(integers))
        expected = [0.5 + 0.4 * u, 0.5 + 0.3 * v, 0.5 + 0.2 * u - 0.25 * v]
        np.testing.assert_allclose(row[[A4, A5, A6]], expected, atol=1e-9)
