"""The ray of a mark in the spots: its path through the lens, and where in the scene it comes from."""

from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.analysis.figure import Plot, Points, wavelength_name
from lensbench.app.state.analysis.query import query
from lensbench.app.state.analysis.spots import field_label
from lensbench.app.state.pixel.beam import landing
from lensbench.app.state.pixel.lens_rays import path_before_lens
from lensbench.app.state.pixel.pointed import PointedRay
from lensbench.app.state.settings import Settings

NEAR = 0.03                     # of a cell: a mark so near to the cursor is meant

Key = tuple[int, int, int, int]


def nearest_ray(plot: Plot, x: float, y: float) -> Key | None:
    """Field, wavelength, row and column of the pupil of the mark at a place of the spots; None where there is none."""
    best, key = NEAR, None
    for layer in plot.layers:
        if isinstance(layer, Points) and layer.rays is not None and layer.x.size:
            away = np.hypot(layer.x - x, layer.y - y)
            i = int(away.argmin())
            if away[i] < best:
                best = float(away[i])
                f, c, row, column = layer.rays[i].tolist()
                key = f, c, row, column
    return key


@lru_cache(maxsize=8)
def pointed_ray(settings: Settings, points: int, key: Key) -> PointedRay:
    """The ray of a grid with so many points across the pupil; ValueError or OSError where there is none."""
    asked, (f, c, row, column) = query(settings), key
    rays = asked.grid(points)
    s, t = rays.pupil[:, 0, column:column + 1], rays.pupil[:, 1, row:row + 1]
    place = rays.beams.towards_scene(s, t)[0][f]
    start = rays.beams.starts(np.array([f]), place)
    lens, away = asked.lens, asked.setup.film_distance
    film_z, line = lens.length + away, rays.conditions.wavelengths[c]
    traced = lb.trace(lens, start[:3].T + [0.0, 0.0, film_z], start[3:6].T, line, clip=False, record=True, forward=True)
    assert traced.paths is not None
    end, direction = traced.points[0], traced.directions[0]
    film = end + (film_z - end[2]) / direction[2] * direction
    path = np.vstack([path_before_lens(lens, away, traced.paths[0, 1], start[3:6, 0]), traced.paths[0, 1:], film])
    found = landing(settings, path)
    words = f"{field_label(rays, f)}, {wavelength_name(line)}: {found.text}"
    return PointedRay(path, -1, words, found.point, found.raster)
