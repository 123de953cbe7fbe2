"""The sunstar: the rays that the blades of the stop draw about a small bright light, by diffraction.

Lengths in mm. Each straight edge of the open pupil sends a ray of light to either side, across itself. Opposite edges
of an even number of blades share their rays: n blades draw n rays if n is even, 2 n if it is odd. Rounded blades spread
their rays; a round stop has none. The pupil is a polygon in direction cosines from the film point; its Fourier
transform is a sum over the edges. Aberrations are neglected. Many wavelengths are added.

References:
    Lee and Mittra, IEEE Trans. Antennas Propag. 31 (1983): the Fourier transform of a polygon.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import each_of
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.region import open_region

VISIBLE = 0.42, 0.68    # µm, evenly taken
COLOURS = 24
PARTS = 4               # of the directions, for the threads
NEAREST, FARTHEST = 15.0, 150.0     # radii of the pattern, in Airy radii of the pupil
RADII, AZIMUTHS = 48, 720
FLAT = 5e-5             # of the pupil's size, by which its outline may miss an edge
STRAIGHT = 1e-3         # radians: a smaller turn is none
SHORT = 0.1             # of both neighbours: an edge that cuts a corner off
PEAK = 1.5              # × the median over the azimuth: a ray of the star is at least so bright
APART = 0.35            # of the way between rays of the most blades, over which the azimuth is smoothed


@dataclass(frozen=True, eq=False)
class Sunstar:
    """Light about a small bright one, from `sunstar`.

    Args:
        radii: (R,) distance from the light on the film, mm, evenly spaced in their logarithm.
        azimuths: (A,) direction from the light on the film, rad, from +x towards +y of the lens frame, over a whole
            turn.
        density: (R, A) part of the light per mm².
        airy_radius: First dark ring of a round pupil of this area at 0.55 µm, mm.
        outline: (m, 2) the open pupil in direction cosines from the film point.
    """

    radii: np.ndarray
    azimuths: np.ndarray
    density: np.ndarray
    airy_radius: float
    outline: np.ndarray

    @cached_property
    def profile(self) -> np.ndarray:
        """(A,) mean over the radii of density × r³, of median 1: how bright each direction is."""
        shown = (self.density * self.radii[:, None] ** 3).mean(0)
        return np.asarray(shown / np.median(shown))

    @property
    def rays(self) -> np.ndarray:
        """(n,) azimuths of the star's rays, rad: maxima of the smoothed profile well above its median."""
        count = len(self.azimuths)
        width = max(1, int(APART * count / 48))
        kernel = np.ones(2 * width + 1) / (2 * width + 1)
        smooth = np.convolve(np.concatenate([self.profile[-width:], self.profile, self.profile[:width]]), kernel,
                             "valid")
        higher = (smooth > np.roll(smooth, 1)) & (smooth >= np.roll(smooth, -1)) & (smooth > PEAK * np.median(smooth))
        return np.asarray(self.azimuths[higher])


def sunstar(lens: Lens, film_distance: float, film_xy: ArrayLike = (0.0, 0.0), radii: ArrayLike | None = None,
            azimuths: int = AZIMUTHS, colours: int = COLOURS) -> Sunstar:
    """The star about the image of a small bright light.

    Args:
        lens: The lens, stopped down and focused, with its blades.
        film_distance: Last vertex → film, mm.
        film_xy: (2,) array_like. Where the light's image lies on the film, mm, lens frame.
        radii: (R,) array_like or None. Distances from the image, mm; None: from 15 to 150 Airy radii.
        azimuths: Directions over the whole turn: an even number of at least 48.
        colours: Wavelengths of white light, evenly from 0.42 to 0.68 µm.
    Raises:
        LensError: For another number of azimuths or colours, radii that are not positive, a film point that no light
            reaches, and as `open_region`.
    """
    if azimuths < 48 or azimuths % 2 or colours < 1:
        raise LensError("a sunstar needs an even number of azimuths, at least 48, and a wavelength")
    pupil = open_pupil(lens, film_distance, film_xy)
    x, y = pupil.T
    area = abs(0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    airy = 0.61 * 0.55e-3 / (area / pi) ** 0.5
    angles = np.geomspace(NEAREST * airy, FARTHEST * airy, RADII) if radii is None else np.atleast_1d(
        np.asarray(radii, float))
    if not (np.all(angles > 0.0) and np.all(np.isfinite(angles))):
        raise LensError("the radii of a sunstar must be positive lengths")
    around = 2.0 * pi * np.arange(azimuths) / azimuths
    lines = 1e-3 * np.linspace(*VISIBLE, colours) if colours > 1 else np.array([0.55e-3])
    half = np.zeros((len(angles), azimuths // 2))           # the pattern of an open pupil is the same on opposite sides
    parts = [slice(k, None, PARTS) for k in range(PARTS)]
    each_of(lambda chunk: add_pattern(pupil, angles, around[:azimuths // 2][chunk], lines, half[:, chunk]), parts)
    density = np.concatenate([half, half], 1) / (area * colours)
    return Sunstar(angles, around, density, airy, pupil)


def open_pupil(lens: Lens, film_distance: float, film_xy: ArrayLike) -> np.ndarray:
    """Corners (m, 2) of the open pupil in direction cosines from a film point; the arguments are those of `sunstar`.

    LensError where no light reaches the film point, and for a picture in the stop.
    """
    if lens.stop_image is not None:
        raise LensError("the star of a picture in the stop is not known: stars are those of blades")
    film = np.asarray(film_xy, float)
    edge = open_region(lens, film_distance, film)
    if not len(edge):
        raise LensError("no light reaches this place of the film: a light there draws no star")
    away = np.column_stack([edge - film, np.full(len(edge), -film_distance)])
    return _with_corners(-_simplified(away / np.linalg.norm(away, axis=1)[:, None])[:, :2])


def _simplified(outline: np.ndarray) -> np.ndarray:
    """A closed outline (m, 3) without points on a line, to FLAT of its size: Ramer, Douglas and Peucker."""
    closed = np.concatenate([outline, outline[:1]])[:, :2]
    tolerance = FLAT * float(np.ptp(closed, axis=0).max())
    far = int(np.argmax(((closed - closed[0]) ** 2).sum(1)))
    kept, work = {0, far}, [(0, far), (far, len(closed) - 1)]
    while work:
        first, last = work.pop()
        if last - first < 2:
            continue
        chord, rest = closed[last] - closed[first], closed[first + 1:last] - closed[first]
        off = np.abs(chord[0] * rest[:, 1] - chord[1] * rest[:, 0]) / max(float(np.hypot(*chord)), 1e-30)
        middle = first + 1 + int(off.argmax())
        if off.max() > tolerance:
            kept.add(middle)
            work += [(first, middle), (middle, last)]
    return outline[sorted(kept)]


def _with_corners(outline: np.ndarray) -> np.ndarray:
    """A closed outline (m, 2) whose corners between long edges are whole: its points at given azimuths cut them off."""
    edges, before = np.roll(outline, -1, 0) - outline, outline - np.roll(outline, 1, 0)
    outline = outline[np.abs(_cross(before, edges)) > STRAIGHT * np.hypot(*edges.T) * np.hypot(*before.T)]
    edges = np.roll(outline, -1, 0) - outline
    lengths = np.hypot(*edges.T)
    long = np.minimum(np.roll(lengths, 1), np.roll(lengths, -1))
    cut = lengths < SHORT * long
    first, last = np.roll(edges, 1, 0), np.roll(edges, -1, 0)           # of the edges before and behind each
    with np.errstate(divide="ignore", invalid="ignore"):
        on = _cross(edges, last) / _cross(first, last)
    cut &= np.isfinite(on) & (on > 0.0) & (on * np.hypot(*first.T) < 2.0 * SHORT * long)
    corners = np.where(cut[:, None], outline + np.where(cut, on, 0.0)[:, None] * first, outline)
    return corners[~np.roll(cut, 1)]                        # the end of a cut lies on the edge behind it


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@njit(cache=True, nogil=True, error_model="numpy")
def add_pattern(outline, radii, azimuths, lines, out):
    """Add |∫ exp(2πi q·p / λ) dp|² / λ² over a polygon (m, 2), at radii × azimuths, of all wavelengths (mm).

    By Green's theorem a sum over the edges from a to b, with k = 2π q / λ, up to a phase of all: (k × (b − a)) / |k|² ·
    exp(i k·(a + b)/2) · sinc(k·(b − a)/2).
    """
    edges = outline.shape[0]
    for j in range(azimuths.size):
        c, s = cos(azimuths[j]), sin(azimuths[j])
        for i in range(radii.size):
            for w in range(lines.size):
                k = 2.0 * pi * radii[i] / lines[w]
                real, imaginary = 0.0, 0.0
                for e in range(edges):
                    n = e + 1 if e + 1 < edges else 0
                    dx, dy = outline[n, 0] - outline[e, 0], outline[n, 1] - outline[e, 1]
                    along = 0.5 * k * (c * dx + s * dy)
                    wave = (c * dy - s * dx) * (sin(along) / along if abs(along) > 1e-9 else 1.0)
                    phase = 0.5 * k * (c * (outline[n, 0] + outline[e, 0]) + s * (outline[n, 1] + outline[e, 1]))
                    real += wave * cos(phase)
                    imaginary += wave * sin(phase)
                out[i, j] += (real * real + imaginary * imaginary) / (k * k * lines[w] * lines[w])
