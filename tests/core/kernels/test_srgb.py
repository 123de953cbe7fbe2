"""The sRGB transfer function and its inverse."""

import numpy as np

from lensbench.core.kernels.numeric import linear, srgb


def test_the_inverse_gives_back_the_light_of_every_code_and_never_steps_back():
    """Above and below the point where the straight part ends; to the digits of the standard's constants."""
    light = np.linspace(0.0, 1.0, 20001)
    np.testing.assert_allclose(linear(srgb(light)), light, rtol=1e-7, atol=1e-9)
    codes = np.arange(256) / 255.0
    np.testing.assert_allclose(srgb(linear(codes)), codes, rtol=1e-7, atol=1e-9)
    assert (np.diff(linear(np.linspace(0.0, 1.0, 20001))) > 0.0).all()
