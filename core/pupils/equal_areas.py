"""Division of exit-pupil regions into sectors of equal area."""

import numpy as np

from lensbench.kernels.cache import njit


@njit(cache=True, error_model="numpy", nogil=True)
def equal_areas(rims, sectors):
    """Corners (rings, sectors + 1, 2) at equal areas about 0 along the chords of rims (rings, points, 2)."""
    rings, points, _ = rims.shape
    corners, area = np.zeros((rings, sectors + 1, 2)), np.zeros(points)
    for ring in range(rings):
        rim = rims[ring]
        for i in range(1, points):
            area[i] = area[i - 1] + rim[i - 1, 0] * rim[i, 1] - rim[i, 0] * rim[i - 1, 1]
        if area[points - 1] > 0.0:
            i = 0
            for k in range(sectors + 1):
                wanted = area[points - 1] * k / sectors
                while i < points - 2 and area[i + 1] <= wanted:
                    i += 1
                share = (wanted - area[i]) / (area[i + 1] - area[i]) if area[i + 1] > area[i] else 0.0
                share = min(max(share, 0.0), 1.0)
                for axis in range(2):
                    corners[ring, k, axis] = rim[i, axis] * (1.0 - share) + rim[i + 1, axis] * share
    return corners
