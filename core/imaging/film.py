"""The film: its size in millimetres, its pixels, and common formats.

Raster (x, y) are pixels with the origin at the top left corner of the picture
and pixel centres at +0.5. A raster point lies on the film, in the camera frame,
at ((0.5 − x/w) width, (y/h − 0.5) height) mm: the image on the film is inverted.
"""

from dataclasses import dataclass
from math import hypot, isfinite

from lensbench.kernels.block import B, Step, X, Y, Z, rows, stage
from lensbench.kernels.figures import significant

AXES = ("shorter", "longer", "horizontal", "vertical", "diagonal")      # of a field of view
MAX_PIXELS = 200_000_000
MAX_SIDE = 2**24                            # pixels; float32 counts no further

PITCH_X, EDGE_X, PITCH_Y, EDGE_Y = range(4)        # parameters of `film_from_raster`, mm

FORMATS: dict[str, tuple[float, float]] = {     # width, height in mm
    "Full frame 36 × 24": (36.0, 24.0),
    "APS-C 23.5 × 15.6": (23.5, 15.6),
    "Micro Four Thirds 17.3 × 13": (17.3, 13.0),
    "1 inch 13.2 × 8.8": (13.2, 8.8),
    "1/1.7 inch 7.6 × 5.7": (7.6, 5.7),
    "1/2.55 inch 5.6 × 4.2": (5.6, 4.2),
    "Super 35 24.9 × 18.7": (24.89, 18.66),
    "Super 16 12.5 × 7.4": (12.52, 7.41),
    "Medium 44 × 33": (43.8, 32.9),
    "6 × 6 cm 56 × 56": (56.0, 56.0),
    "6 × 7 cm 70 × 56": (70.0, 56.0),
    "Large 4 × 5 inch": (127.0, 101.6),
}


class FilmError(ValueError):
    """Invalid size, pixels or field of view of a film; the message says what to do."""


@dataclass(frozen=True)
class Film:
    """A film or sensor: its size and its pixels, which need not be square.

    Parameters
    ----------
    width, height : float
        Size in mm, across and down.
    pixels_x, pixels_y : int
        Number of pixels across and down.

    Raises
    ------
    FilmError
        For a side that is not positive, or a number of pixels outside the limits.
    """

    width: float = 36.0
    height: float = 24.0
    pixels_x: int = 960
    pixels_y: int = 640

    def __post_init__(self):
        for side, size in (("width", self.width), ("height", self.height)):
            if not (isfinite(size) and size > 0.0):
                raise FilmError(f"film {side} {significant(size)} mm: it must be a positive number")
        for side, pixels in (("across", self.pixels_x), ("down", self.pixels_y)):
            if not (isfinite(pixels) and int(pixels) == pixels and 1 <= pixels <= MAX_SIDE):
                raise FilmError(f"{pixels} pixels {side}: it must be a whole number from 1 to {MAX_SIDE}")
        object.__setattr__(self, "pixels_x", int(self.pixels_x))
        object.__setattr__(self, "pixels_y", int(self.pixels_y))
        if self.pixels_x * self.pixels_y > MAX_PIXELS:
            raise FilmError(f"{self.pixels_x} × {self.pixels_y} pixels: "
                            f"at most {MAX_PIXELS // 10**6} million are possible")

    @property
    def diagonal(self) -> float:
        """The diagonal (mm)."""
        return hypot(self.width, self.height)

    def extent(self, axis: str) -> float:
        """Size of the film along an axis.

        Parameters
        ----------
        axis : str
            One of AXES: shorter, longer, horizontal, vertical or diagonal.

        Returns
        -------
        float
            mm.

        Raises
        ------
        FilmError
            Another axis.
        """
        w, h = self.width, self.height
        sizes = {"shorter": min(w, h), "longer": max(w, h), "horizontal": w, "vertical": h, "diagonal": self.diagonal}
        if axis not in sizes:
            raise FilmError(f"film along {axis!r}: choose one of {', '.join(AXES)}")
        return sizes[axis]

    @property
    def pitch(self) -> float:
        """Size of a pixel (mm): the geometric mean of its sides."""
        return (self.width / self.pixels_x * self.height / self.pixels_y) ** 0.5

    @property
    def step(self) -> Step:
        """The step from raster pixels to the camera frame."""
        return Step(film_from_raster, [self.width / self.pixels_x, self.width / 2.0,
                                       self.height / self.pixels_y, self.height / 2.0])


@stage
def film_from_raster(lanes, p, ints, key):
    """Raster X, Y become the point of the film in the camera frame: X, Y in mm, Z = 0. p: PITCH_X … EDGE_Y."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z = row[X], row[Y], row[Z]
    pitch_x, edge_x, pitch_y, edge_y = p[PITCH_X], p[EDGE_X], p[PITCH_Y], p[EDGE_Y]
    for i in range(B):
        x[i] = edge_x - x[i] * pitch_x
        y[i] = y[i] * pitch_y - edge_y
        z[i] = real(0)
