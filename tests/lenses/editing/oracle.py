"""Paraxial figures in forty digits, from the numbers of a lens alone: an oracle that shares no code with the solves."""

from mpmath import mp, mpf

mp.dps = 40


def bent(lens, upto=None, height=1, slope=0):
    """Height and slope behind surface `upto` of a paraxial d-line ray, and the heights on the way."""
    y, u, n, heights = mpf(height), mpf(slope), mpf(lens.front_index), []
    last = len(lens.surfaces) - 1 if upto is None else upto
    for i, surface in enumerate(lens.surfaces[:last + 1]):
        heights.append(y)
        after = mpf(surface.glass.n_d)
        c = mpf(surface.curvature) + 2 * mpf(dict(surface.aspheric).get(2, 0.0))
        u = (n * u - y * c * (after - n)) / after
        n = after
        if i < last:
            y += u * mpf(surface.thickness)
    return y, u, heights


def efl(lens):
    return -1 / bent(lens)[1]


def bfl(lens):
    y, u, _ = bent(lens)
    return -y / u


def edge(front, back):
    """Thickness between the rims of two spheres, along the axis."""
    def sag(surface):
        c, h = mpf(surface.curvature), mpf(surface.semi_diameter)
        return c * h * h / (1 + mp.sqrt(1 - c * c * h * h))
    return mpf(front.thickness) + sag(back) - sag(front)
