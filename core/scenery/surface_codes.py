"""Codes of surfaces and paths: the numbers that the rows FINISH, EMITS and PATH hold.

| FINISH | surface |
|---|---|
| MATTE | no reflection but the diffuse one |
| above 0, up to 1 | a clear coat over a matte ground: its gloss |
| METAL | metal |
| INSIDE | a mesh of glass, met from inside |
| GLASS | a pane of glass |
| GLASS + radius (mm) | a ball of glass |
| GLASS + SOLID | a mesh of glass, met from outside |

| EMITS | surface |
|---|---|
| BENDS | emits nothing; paths that it deflects see no SMALL_LIGHT, which is traced to the film through it |
| DARK | emits nothing: RED, GREEN and BLUE are its albedo |
| SHINES | RED, GREEN and BLUE are its radiance |
| LAMP | shines, and lights every surface itself: a DIFFUSE path does not see it |
| SMALL_LIGHT | shines, and its light comes to SPECULAR paths from the film |

| PATH | path |
|---|---|
| DIRECT | from the film, or reflected last by one that does not bend |
| SPECULAR | deflected last by a surface that BENDS |
| DIFFUSE | sent on by a matte surface |

A path sees the emission of a surface where the sum of both is less than HIDDEN. `Scene.marking_steps` writes numbers of
its own into EMITS, above SMALL_LIGHT and below BENDS. In the functions `real` is the type of the lanes.
"""

from lensbench.core.kernels.cache import njit

BENDS, DARK, SHINES, LAMP, SMALL_LIGHT = -1.0, 0.0, 1.0, 1.6, 2.0
DIRECT, SPECULAR, DIFFUSE = 0.0, 1.0, 1.5
HIDDEN = 3.0


@njit(inline="always")
def shines(real, emits):
    """Whether the surface emits anything."""
    return emits > real(DARK)


@njit(inline="always")
def is_seen(real, emits, path):
    """Whether the path sees what the surface emits."""
    return (emits > real(DARK)) & (emits + path < real(HIDDEN))


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
