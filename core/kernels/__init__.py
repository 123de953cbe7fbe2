"""Blocks of lanes, programs of stages, sampling, root finding and half floats: numpy and numba alone."""
