"""The shutter: when the light of a sample passes, from the place of its line and the shape of the shutter.

Each line of the film is open for the same time, `open` seconds. The shutter takes
`ramp` seconds to open and as long to close, and what it lets through rises and falls
in proportion: a trapezoid, or a box where the ramp is 0. With a rolling shutter
the lines open one after the other, the first at 0 s and the last `readout` seconds later.
"""

import math

import numpy as np

from lensbench.kernels.block import TIME, B, Step, X, Y, rows, stage

DIRECTIONS = ("down", "up", "left", "right")        # in which the lines of a picture open, seen upright


@stage
def shutter_time(lanes, p, key):
    """TIME in [0, 1) becomes seconds since the shutter began to open; X, Y are raster pixels, still.

    p: open, ramp, the delay at raster (0, 0), the delay per pixel across and down (s). Times are drawn by the inverse
    of the trapezoid's cumulative, as often as light passes, so that no sample needs a weight.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, time = row[X], row[Y], row[TIME]
    whole, ramp, first, across, down = p[0], p[1], p[2], p[3], p[4]
    for i in range(B):
        time[i] = time[i] * (whole - ramp) + real(0.5) * ramp
    if ramp > real(0):
        for i in range(B):
            early = time[i] < real(0.5) * whole
            light = (time[i] if early else whole - time[i]) - real(0.5) * ramp      # let through before, or after
            edge = math.sqrt(real(2) * ramp * light)
            edge = edge if edge < ramp else light + real(0.5) * ramp
            time[i] = edge if early else whole - edge
    for i in range(B):
        time[i] += first + x[i] * across + y[i] * down


def shutter_step(whole: float, ramp: float, readout: float, direction: str, pixels_x: int, pixels_y: int) -> Step:
    """The step that tells the time: seconds, one of DIRECTIONS and the size of the picture."""
    across = {"right": 1.0, "left": -1.0}.get(direction, 0.0) * readout / pixels_x
    down = {"down": 1.0, "up": -1.0}.get(direction, 0.0) * readout / pixels_y
    first = readout if direction in ("left", "up") else 0.0
    return Step(shutter_time, np.array([whole, ramp, first, across, down]))
