"""The sRGB transfer function, IEC 61966-2-1, and its inverse."""

import numpy as np


def srgb(linear):
    """The sRGB transfer function, IEC 61966-2-1, of values in [0, 1]."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1.0 / 2.4) - 0.055)


def linear(codes):
    """Linear light of sRGB values in [0, 1]: the inverse of `srgb`."""
    return np.where(codes <= 0.04045, codes / 12.92, ((np.maximum(codes, 0.04045) + 0.055) / 1.055) ** 2.4)
