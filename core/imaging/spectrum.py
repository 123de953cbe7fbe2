"""The colours of a picture as wavelengths: what each of its three channels sees.

A channel sees the main, positive lobe of its sRGB matching function (CIE 1931 in the fit of Wyman, Sloan and Shirley,
2013, equal energy), cut into eight parts of equal weight. Scenes have colours and no spectra: every wavelength of a
channel carries its whole radiance, so white stays white and dispersion only moves light.
"""

import numpy as np

from lensbench.core.kernels.block import BLUE, GREEN, RED, B as LANES, Step, rows, stage
from lensbench.core.kernels.sampling import WAVELENGTH, sobol

# Middles, by weight, of the eight parts (µm)
WAVELENGTHS = {
    RED: (0.5712, 0.5849, 0.5947, 0.6034, 0.6118, 0.6209, 0.6321, 0.6505),
    GREEN: (0.4965, 0.5145, 0.5259, 0.5356, 0.5452, 0.5552, 0.5669, 0.5832),
    BLUE: (0.4209, 0.4321, 0.4398, 0.4471, 0.4543, 0.4619, 0.4709, 0.4858),
}
# Weights of white light in analyses, each in words
WHITES = {"picture": "as the picture", "photopic": "by photopic vision", "lens": "as the lens file states",
          "fdc": "equally at F, d and C"}
# µm and weights. Gauss's rule in 1/λ for the 24 wavelengths above, with the luminance of their channels in sRGB
# (0.2126, 0.7152, 0.0722): exact for polynomials of degree 11 in 1/λ
PICTURE = ((0.42323, 0.01531), (0.44953, 0.04198), (0.50267, 0.21660), (0.54700, 0.42851), (0.59489, 0.23985),
           (0.64384, 0.05774))
# The luminous efficiency V(λ) of the CIE (1924) at the five wavelengths that design programs take for it
PHOTOPIC = ((0.470, 0.091), (0.510, 0.503), (0.555, 1.0), (0.610, 0.503), (0.650, 0.107))


@stage
def select_channel(lanes, p, ints, key):
    """One of the three channels; the others become 0. p: 1 or 0 for RED, GREEN and BLUE."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    keeps_red, keeps_green, keeps_blue = p[0] > real(0), p[1] > real(0), p[2] > real(0)
    for i in range(LANES):
        red[i] = red[i] if keeps_red else real(0)
        green[i] = green[i] if keeps_green else real(0)
        blue[i] = blue[i] if keeps_blue else real(0)


def channel_step(row: int) -> Step:
    """The step that keeps one channel, RED, GREEN or BLUE."""
    return Step(select_channel, [float(row == other) for other in WAVELENGTHS])


def spectral_part(sample: int, seed: np.uint32) -> int:
    """Part 0 to 7 of every channel for this sample of all pixels; eight samples take each part once."""
    return int(sobol(np.uint32(sample), WAVELENGTH, seed)) * 8 >> 32
