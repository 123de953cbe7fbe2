"""Transmission of the picture in the stop over the cells of the exit pupil.

The rays of the object are traced through the open stop; where they meet it, the picture lets a part of their light
pass. A cell takes its mean, by points on the stop that follow from the one of its middle and the slopes at the chief
ray. Of amplitudes the mean is another: where the picture is black and white, a part of the cell is open; where it is
grey, all of the cell is dimmed.
"""

from typing import NamedTuple

import numpy as np

from lensbench.analysis.grids.field_beams import FieldBeams
from lensbench.optics.stop_image import StopImage

ACROSS = 8              # points across a cell


class StopTransmission(NamedTuple):
    """Means (F, N, N) over the cells: of the transmitted light, and of the amplitude, its square root."""

    light: np.ndarray
    amplitude: np.ndarray

    @property
    def open_part(self) -> np.ndarray:
        """(F, N, N) part of each cell that is open; 0 where the picture is opaque."""
        return np.divide(self.amplitude**2, self.light, out=np.zeros_like(self.light), where=self.light > 0.0)

    @property
    def dimming(self) -> np.ndarray:
        """(F, N, N) light that passes the open part of each cell, for light 1 on it."""
        return np.divide(self.light, self.open_part, out=np.zeros_like(self.light), where=self.light > 0.0)


def stop_transmission(beams: FieldBeams, grid: np.ndarray, image: StopImage) -> StopTransmission:
    """Means over the cells of a grid (F, 2, N) of the exit pupil; 0 where no ray meets the stop."""
    fields, _, n = grid.shape
    s, t = (np.ascontiguousarray(np.broadcast_to(each, (fields, n, n)))
            for each in (grid[:, 0, None, :], grid[:, 1, :, None]))
    middle = beams.on_stop(s, t)
    steps = (grid[:, :, 1] - grid[:, :, 0])[:, None, :] * beams.stop_slopes         # (F, 2, 2), in stop radii a cell
    light, amplitude, within = (np.zeros((fields, n, n)) for _ in range(3))
    offsets = (np.arange(ACROSS) + 0.5) / ACROSS - 0.5
    for across in offsets.tolist():
        for up in offsets.tolist():
            moved = (steps @ [across, up]).T[:, :, None, None]
            x, y = middle + moved
            with np.errstate(invalid="ignore"):
                inside = x * x + y * y <= 1.0           # beyond, the rim of the stop has the cell's open part
            share = image.at(x, y)
            light += share
            amplitude += np.sqrt(share)
            within += inside
    # A cell that only touches the stop takes the nearest point of its rim
    x, y = middle / np.maximum(1.0, np.hypot(*middle))
    edge = np.where(within > 0.0, 0.0, image.at(x, y))
    light, amplitude, count = light + edge, amplitude + np.sqrt(edge), np.maximum(within, 1.0)
    return StopTransmission(light / count, amplitude / count)
