"""The colours of a picture as wavelengths: what each of its three channels sees.

A channel sees the main, positive lobe of its sRGB matching function (CIE 1931 by the fit of Wyman, Sloan
and Shirley, 2013, for a spectrum of equal energy), here cut into eight parts of equal weight. A scene has
no spectra, only colours: every wavelength of a channel carries the channel's whole radiance, so what
is white stays white, and dispersion moves the light of each wavelength, and no more.
"""

import numpy as np

from lensbench.kernels.block import BLUE, GREEN, RED, Step, rows, stage
from lensbench.kernels.block import B as LANES
from lensbench.kernels.sampling import WAVELENGTH, sobol

# The middles (by weight) of the eight parts, µm
WAVELENGTHS = {
    RED: (0.5712, 0.5849, 0.5947, 0.6034, 0.6118, 0.6209, 0.6321, 0.6505),
    GREEN: (0.4965, 0.5145, 0.5259, 0.5356, 0.5452, 0.5552, 0.5669, 0.5832),
    BLUE: (0.4209, 0.4321, 0.4398, 0.4471, 0.4543, 0.4619, 0.4709, 0.4858),
}


@stage
def select_channel(lanes, p, key):
    """Keep one of the three channels. p: 1 for the one that is kept, 0 for the others."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    keeps_red, keeps_green, keeps_blue = p[0] > real(0), p[1] > real(0), p[2] > real(0)
    for i in range(LANES):
        red[i] = red[i] if keeps_red else real(0)
        green[i] = green[i] if keeps_green else real(0)
        blue[i] = blue[i] if keeps_blue else real(0)


def channel_step(row: int) -> Step:
    """The step that keeps the channel RED, GREEN or BLUE alone."""
    return Step(select_channel, [float(row == other) for other in WAVELENGTHS])


def spectral_part(sample: int, seed: np.uint32) -> int:
    """Which of the eight parts of every channel sample `sample` of all pixels takes: each once in eight samples."""
    return int(sobol(np.uint32(sample), WAVELENGTH, seed)) * 8 >> 32
