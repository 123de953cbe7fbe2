"""The ray of a mark in a spot diagram or of a point of a ray fan: its path through the lens, and its end in words."""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.ray_fans import blockers, end_text
from lensbench.app.plots.pixel_rays import PointedRay, landing, path_before_lens
from lensbench.app.plots.plot import Curve, Plot, Points, wavelength_name
from lensbench.app.plots.query import query
from lensbench.app.plots.spots import field_label
from lensbench.app.settings.settings import Settings

NEAR = 0.03                     # of a cell: greatest distance from the cursor to the mark that it chooses

Key = tuple[int, float, float, float]


def nearest_ray(plot: Plot, x: float, y: float) -> Key | None:
    """Field, wavelength (µm) and two pupil coordinates of the ray at a point (x, y) of a spot diagram or of a ray fan.

    In a spot diagram, the ray of the mark at the point; in a fan, that of the curve nearest to y, at the pupil
    coordinate nearest to x. None where no mark or curve is near.
    """
    best, found = NEAR, None
    for layer in plot.layers:
        if not isinstance(layer, Points | Curve) or layer.rays is None:
            continue
        if isinstance(layer, Points):
            away = np.hypot(layer.x - x, layer.y - y)
        else:
            nearest = np.abs(layer.x - x) <= np.abs(layer.x - x).min(initial=math.inf)
            away = np.where(nearest & np.isfinite(layer.rays[:, 2:]).all(1) & np.isfinite(layer.y),
                            NEAR * np.abs(layer.y - y) / (plot.y.high - plot.y.low), math.inf)
        i = int(away.argmin()) if away.size else 0
        if away.size and away[i] < best:
            best, found = float(away[i]), layer.rays[i].tolist()
    return None if found is None else (int(found[0]), found[1], found[2], found[3])


@lru_cache(maxsize=8)
def pointed_ray(settings: Settings, points: int, key: Key) -> PointedRay:
    """The ray of a key of `nearest_ray`; points: of the grid across the pupil. ValueError or OSError without rays."""
    asked, (f, line, s, t) = query(settings), key
    if line not in asked.conditions().wavelengths:      # of a figure of single wavelengths
        asked = asked.lines
    rays = asked.grid(points)
    of_fields = np.ones((len(rays.images), 1))
    place = rays.beams.towards_scene(s * of_fields, t * of_fields)[0][f]
    start = rays.beams.starts(np.array([f]), place)
    lens, away = asked.lens, asked.setup.film_distance
    film_z = lens.length + away
    traced = lb.trace(lens, start[:3].T + [0.0, 0.0, film_z], start[3:6].T, line, record=True, forward=True)
    assert traced.paths is not None
    name = f"{field_label(rays, f)}, {wavelength_name(line)}"
    surface = int(blockers(lens, traced, forward=True)[0])
    if surface >= 0:
        met = traced.paths[0, 1:][np.isfinite(traced.paths[0, 1:, 0])]
        first = met[0] if len(met) else traced.paths[0, 0]
        path = np.vstack([path_before_lens(lens, away, first, start[3:6, 0]), met])
        return PointedRay(path, surface, f"{name}: {end_text(lens, lb.Fate(int(traced.fate[0])), surface)}")
    end, direction = traced.points[0], traced.directions[0]
    film = end + (film_z - end[2]) / direction[2] * direction
    path = np.vstack([path_before_lens(lens, away, traced.paths[0, 1], start[3:6, 0]), traced.paths[0, 1:], film])
    found = landing(settings, path)
    return PointedRay(path, -1, f"{name}: {found.text}", found.point, found.raster)
