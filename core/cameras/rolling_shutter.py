"""Rolling-shutter rows: projection of moving points onto the row of the film that is open when they fall on it."""

from collections.abc import Callable

import numpy as np

from lensbench.cameras.placed_shutter import PlacedShutter, film_centre

Project = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Raster points (n, 2) → raster points of n objects, with the camera where it is while the rows of the former are open;
and which objects are visible, (n,) bool."""

ITERATIONS = 40         # of the secant rule, at most


def project_onto_open_rows(camera: PlacedShutter, project: Project, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Raster points (n, 2) of n objects, each on the row that is open when it falls there; and which are visible."""
    raster, visible = project(film_centre(camera.film, n))
    if camera.moves and camera.readout > 0.0:
        raster, visible = _solve_rows(camera, project, raster)
    with np.errstate(invalid="ignore"):
        inside = ((raster >= 0.0) & (raster <= [camera.film.pixels_x, camera.film.pixels_y])).all(1)
    return raster, visible & inside


def _solve_rows(camera: PlacedShutter, project: Project, raster: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fixed points of `project` along the readout, by the secant rule for each object on its own."""
    axis = 0 if camera.readout_direction in ("left", "right") else 1
    before, open_at = film_centre(camera.film, len(raster)), raster.copy()
    error_before = raster[:, axis] - before[:, axis]
    for _ in range(ITERATIONS):
        raster, visible = project(open_at)
        error = raster[:, axis] - open_at[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -error * (open_at[:, axis] - before[:, axis]) / (error - error_before)
        step = np.where(np.isfinite(step), step, error)
        before, error_before, open_at = open_at, error, open_at.copy()
        open_at[:, axis] += step
        if not (np.abs(step) > 1e-11).any():
            break
    raster, visible = project(open_at)
    with np.errstate(invalid="ignore"):                 # a fast panorama may miss a point, or see it twice
        return raster, visible & (np.abs(raster[:, axis] - open_at[:, axis]) < 1e-6)
