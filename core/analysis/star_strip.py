"""Pictures of a Siemens star through copies of a lens: what their spread of contrast looks like on the film.

The star is folded with the spots of a copy's rays, as sharp as these are; diffraction is left out. Its lines run from
about 10 cycles / mm at its edge to 60 near its middle on 36 × 24 mm; on a film of half the size they are twice as fine.
"""

from collections.abc import Sequence

import numpy as np

from lensbench.analysis.manufacture import Judge, Production
from lensbench.analysis.manufactured_lens import manufactured
from lensbench.imaging.film import Film
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import trace

PAIRS = 36              # of sectors
PART = 36               # windows along the diagonal of the film
SIDE, FINE = 96, 4      # pixels of a picture; of each, points of the star that are averaged, along a side


def star_pictures(lens: Lens, run: Production, copies: Sequence[int], film: Film | None = None,
                  wavelengths=None) -> tuple[np.ndarray, float]:
    """Pictures of a star in every field, through the design and through copies of it.

    Parameters
    ----------
    lens : Lens
        That of the run.
    run : Production
        As `production` gives it for `film`.
    copies : sequence of int
        Numbers of the copies, from 0.
    film, wavelengths
        As for `production`.

    Returns
    -------
    (1 + copies, fields, SIDE, SIDE) array, float
        The design first; 0 black to 1 white, row 0 at the bottom (y of the lens frame points up). Then the width of a
        picture on the film, mm.

    Raises
    ------
    LensError
        As `production`, and for copies that the run does not have.
    """
    judge = Judge(lens, film, None, wavelengths)
    width = 2.0 * judge.height / PART
    seen = [_points(judge, lens, run.nominal_film)]
    seen += [_points(judge, manufactured(lens, run, copy), run.film[copy]) for copy in copies]
    fine, star = width / (SIDE * FINE), np.fft.rfft2(_star(2 * SIDE * FINE))
    found = np.empty((len(seen), len(run.fields), SIDE, SIDE))
    for row, points in enumerate(seen):
        for field in range(len(run.fields)):
            here = judge.fields == field
            weights = np.outer(judge.weights, judge.areas[here]).ravel()
            found[row, field] = _folded(star, points[:, here].reshape(-1, 2), weights, fine)
    return found, width


def _points(judge: Judge, lens: Lens, film_z: float) -> np.ndarray:
    """Where the rays of a run land (wavelengths, rays, 2), mm."""
    found = []
    for wavelength in judge.wavelengths:
        rays = trace(lens, judge.origins, judge.directions, wavelength, clip=False, forward=True)
        away = (film_z - rays.points[:, 2:]) / rays.directions[:, 2:]
        found.append(rays.points[:, :2] + away * rays.directions[:, :2])
    return np.array(found)


def _star(side: int) -> np.ndarray:
    """A star (side, side) of 0 and 1 about the middle."""
    at = np.arange(side) - 0.5 * (side - 1)
    return (np.floor(np.arctan2(at[:, None], at[None]) * (PAIRS / np.pi)) % 2.0).astype(float)


def _folded(star: np.ndarray, points: np.ndarray, weights: np.ndarray, fine: float) -> np.ndarray:
    """The star, given by its transform, with each of its points spread over a spot about its middle."""
    side = 2 * SIDE * FINE
    known = np.isfinite(points).all(1)
    points, weights = points[known], weights[known] / weights[known].sum()
    places = (points - weights @ points) / fine
    low = np.floor(places).astype(int)
    (fx, fy), spot = (places - low).T, np.zeros((side, side))
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        part = np.where(dx, fx, 1.0 - fx) * np.where(dy, fy, 1.0 - fy)
        np.add.at(spot, ((low[:, 1] + dy) % side, (low[:, 0] + dx) % side), weights * part)
    picture = np.fft.irfft2(star * np.fft.rfft2(spot), (side, side))
    edge = SIDE * FINE // 2
    middle = picture[edge:side - edge, edge:side - edge]
    return np.clip(middle.reshape(SIDE, FINE, SIDE, FINE).mean((1, 3)), 0.0, 1.0)
