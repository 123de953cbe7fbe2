"""The lens cut in half, with its stop and its film. Lengths in mm, camera frame: the film lies in z = 0.

The cut is the section y–z; what lies at x < 0 is taken away, so that the section's rays lie open. From there the scene
is at the left, as in the section.
"""

from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.geometry.elements import before_roll, elements, sag
from lensbench.app.state.geometry.section import Sketch
from lensbench.app.state.solid.shapes import Part, Strokes, flat_part, grid_part, strokes
from lensbench.kernels.byte_cache import byte_cache

ACROSS = 17                     # points along each side of a curved film
AROUND = 37                     # points about the axis, from +y past +x to −y
TURNS = 0.5 * np.pi * np.linspace(1.0, -1.0, AROUND)
MOST_KEPT = 6 << 20             # bytes of glass: three double Gausses
RADII = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, 15))        # parts of a rim, closer towards it


def lens_parts(shown: Sketch) -> tuple[Part, ...]:
    """The glass, the stop and the film of a section; without a lens the film and an opening alone."""
    parts: list[Part] = []
    if shown.lens is not None:
        parts += _glass(shown.lens, shown.glasses, shown.film_z)
    if shown.stop_radius is not None:
        outer = max(1.12 * (shown.open_radius or shown.stop_radius), 1.08 * shown.near_stop)
        parts.append(_ring(shown.stop_z - shown.film_z, shown.stop_radius, outer))
    return tuple(parts)


@byte_cache(MOST_KEPT, 8)
def _glass(lens: lb.Lens, glasses: tuple[lb.Glass, ...], film_z: float) -> tuple[Part, ...]:
    """Of each element the half shell and its cut face."""
    found = []
    for element in elements(lens):
        of = glasses[element.front]
        glass = of.n_d, of.v_d if of.v_d is not None else 60.0
        front, rear = lens.surfaces[element.front], lens.surfaces[element.front + 1]
        edge = float(np.abs(element.outline[:, 1]).max())
        z = [lens.vertices[element.front] - film_z, lens.vertices[element.front + 1] - film_z]
        sheets = [_placed(_sheet(surface, at, edge), lens, i, film_z) for surface, at, i in zip(
            (front, rear), z, (element.front, element.front + 1), strict=True)]
        shell = np.concatenate([sheets[0], sheets[1][::-1]])
        both = element.front, element.front + 1
        found.append(grid_part("glass", shell, glass=glass, surfaces=both))
        quads = np.concatenate([np.zeros((*element.strips.shape[:2], 1)), element.strips[..., ::-1]], axis=2)
        quads[..., 2] -= film_z
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        cut = flat_part("cut", triangles, glass=glass)
        found.append(Part("cut", cut.points, np.tile([-1.0, 0.0, 0.0], (len(cut.points), 1)), glass, surfaces=both))
    return tuple(found)


@lru_cache(maxsize=8)
def lens_outlines(lens: lb.Lens, film_z: float) -> Strokes:
    """The edges of the cut faces."""
    closed = [np.vstack([element.outline, element.outline[:1]]) for element in elements(lens)]
    return strokes("outline", [np.column_stack([np.zeros(len(edge)), edge[:, 1], edge[:, 0] - film_z])
                               for edge in closed])


def _sheet(surface: lb.Surface, z: float, edge: float) -> np.ndarray:
    """Half a surface (radii, AROUND, 3) from its vertex to the edge of its element, flat beyond its rim."""
    rim = min(surface.semi_diameter, edge)
    radii = np.append(rim * RADII, edge) if edge > rim else rim * RADII
    x, y = radii[:, None] * np.cos(TURNS), radii[:, None] * np.sin(TURNS)
    return np.stack([x, y, z + sag(surface, x, y)], axis=-1)


def _placed(points: np.ndarray, lens: lb.Lens, i: int, film_z: float) -> np.ndarray:
    """Points (…, 3) of surface i in line, camera frame, moved by its pose; the roll is in the points."""
    frame = lens.frames[i]
    if frame is None:
        return points
    return (points + [0.0, 0.0, film_z]) @ before_roll(lens, i).T + frame.shift - [0.0, 0.0, film_z]


def _ring(z: float, inner: float, outer: float) -> Part:
    """Half a flat ring."""
    radii = np.array([[inner], [outer]])
    x, y = radii * np.cos(TURNS), radii * np.sin(TURNS)
    return grid_part("stop", np.stack([x, y, np.full_like(x, z)], axis=-1))


def film_part(film: lb.Film, pose: lb.FilmPose) -> Part:
    """The film's surface."""
    part = np.linspace(-0.5, 0.5, ACROSS if pose.is_curved else 2)
    return grid_part("film", pose.points(np.stack(np.meshgrid(part * film.width, part * film.height), -1)))


def film_outline(film: lb.Film, pose: lb.FilmPose) -> np.ndarray:
    """Its edge, a closed path (n, 3)."""
    side = np.linspace(-0.5, 0.5, ACROSS if pose.is_curved else 2)[:-1]
    low = np.full_like(side, -0.5)
    x = np.concatenate([side, -low, -side, low, [-0.5]])
    y = np.concatenate([low, side, -low, -side, [-0.5]])
    return pose.points(np.column_stack([x * film.width, y * film.height]))
