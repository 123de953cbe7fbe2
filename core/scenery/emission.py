"""What a surface emits and which path sees it, as the numbers of the rows EMITS and PATH.

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
its own into EMITS, above SMALL_LIGHT and below BENDS.
"""

from lensbench.kernels.cache import njit

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
