"""The finish of a surface: how it reflects, as the one number that the row FINISH holds.

| number | surface |
|---|---|
| MATTE | no reflection but the diffuse one |
| above 0, up to 1 | a clear coat over a matte ground: its gloss |
| METAL | metal |
| INSIDE | a mesh of glass, met from inside |
| GLASS | a pane of glass |
| GLASS + radius (mm) | a ball of glass |
| GLASS + SOLID | a mesh of glass, met from outside |

The functions read it in stages; `real` is the type of the lanes. `Material.finish` gives it.
"""

from lensbench.kernels.cache import njit

MATTE, METAL, INSIDE, GLASS = 0.0, 2.0, 2.5, 3.0
SOLID = 1e7
SHARP = 0.999           # gloss from which a coat reflects lights sharply


@njit(inline="always")
def is_sharp_coat(real, finish):
    """Whether this is a clear coat that reflects lights sharply."""
    return (finish >= real(SHARP)) & (finish < real(METAL))


@njit(inline="always")
def is_rough_coat(real, finish):
    """Whether this is a clear coat that spreads the lights that it reflects."""
    return (finish > real(MATTE)) & (finish < real(SHARP))


@njit(inline="always")
def is_metal(real, finish):
    """Whether this is metal, or glass met from inside."""
    return (finish >= real(METAL)) & (finish < real(GLASS))


@njit(inline="always")
def is_specular(real, finish):
    """Whether a path goes on from here in one direction: metal and glass."""
    return finish >= real(METAL)


@njit(inline="always")
def is_glass(real, finish):
    """Whether this is glass that the ray meets from outside."""
    return finish >= real(GLASS)


@njit(inline="always")
def is_ball(real, finish):
    """Whether this is glass that is no pane: a ball, or a mesh before `solid_bend`."""
    return finish > real(GLASS)


@njit(inline="always")
def ball_radius(real, finish):
    """Radius of a ball of glass in mm; 0 or less for everything else."""
    return finish - real(GLASS)


@njit(inline="always")
def is_solid(real, finish):
    """Whether this is a mesh of glass."""
    return (finish == real(INSIDE)) | (finish > real(0.5 * SOLID))
