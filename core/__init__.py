"""The optics: lenses, cameras and pictures, with numpy and numba alone."""
