"""The sharpening of refocused pictures undoes what the reading of the views takes, and no more."""

import numpy as np

from lensbench.core.lightfields.refocus_kernel import HIGHEST_GAIN, spectral_gain


def kept(f, width):
    """Part of a wave of f cycles per pixel that is left of it in the mean over a width (pixels)."""
    x = (np.arange(2000) + 0.5) / 2000 - 0.5
    return np.cos(2.0 * np.pi * f[:, None] * width * x).mean(1)


def test_the_gain_restores_what_the_spread_of_a_view_takes_up_to_its_limit():
    f = np.linspace(0.0, 0.5, 40)
    np.testing.assert_allclose(spectral_gain(f, 0.0, 1.0), 1.0)
    for step, fill in ((0.7, 1.0), (1.6, 1.0), (1.9, 0.5)):
        taken = kept(f, step) * kept(f, fill) / kept(f, 1.0)
        found = spectral_gain(f, step, fill)
        within = taken * HIGHEST_GAIN > 1.0
        np.testing.assert_allclose((found * taken)[within], 1.0, rtol=1e-5)
        assert (found[~within] == HIGHEST_GAIN).all()
