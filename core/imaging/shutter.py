"""The shutter: when the light of a sample passes, by its line and the shape of the shutter's opening.

Each line of the film is open for the same time, `open_time` seconds. The shutter takes
`ramp` seconds to open and as long to close; what it lets through rises and falls
linearly: a trapezoid, or a box if the ramp is 0. With a rolling shutter
the lines open one after the other, the first at 0 s and the last `readout` seconds later.
"""

import math

import numpy as np

from lensbench.kernels.block import TIME, B, Step, X, Y, rows, stage

DIRECTIONS = ("down", "up", "left", "right")        # of a rolling shutter, in the upright picture

OPEN_TIME, RAMP, DELAY, DELAY_X, DELAY_Y = range(5)   # parameters of `shutter_time` (s)


@stage
def shutter_time(lanes, p, ints, key):
    """TIME in [0, 1) becomes seconds since the shutter began to open; X, Y are raster pixels.

    p: OPEN_TIME, RAMP, DELAY at raster (0, 0), DELAY_X and DELAY_Y per pixel. The inverse of the trapezoid's
    cumulative distribution makes times as frequent as light passes, so that all samples have the same weight.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, time = row[X], row[Y], row[TIME]
    open_time, ramp, delay, delay_x, delay_y = p[OPEN_TIME], p[RAMP], p[DELAY], p[DELAY_X], p[DELAY_Y]

    # Invert the cumulative distribution: its linear part, then its parabolas
    for i in range(B):
        time[i] = time[i] * (open_time - ramp) + real(0.5) * ramp
    if ramp > real(0):
        for i in range(B):
            early = time[i] < real(0.5) * open_time
            light = (time[i] if early else open_time - time[i]) - real(0.5) * ramp  # before, or after
            edge = math.sqrt(real(2) * ramp * light)
            edge = edge if edge < ramp else light + real(0.5) * ramp
            time[i] = edge if early else open_time - edge

    # Add the delay of the line
    for i in range(B):
        time[i] += delay + x[i] * delay_x + y[i] * delay_y


def shutter_step(open_time: float, ramp: float, readout: float, direction: str, pixels_x: int, pixels_y: int) -> Step:
    """The step from TIME in [0, 1) to seconds; times in s, direction one of DIRECTIONS, pixels of the picture."""
    delay_x = {"right": 1.0, "left": -1.0}.get(direction, 0.0) * readout / pixels_x
    delay_y = {"down": 1.0, "up": -1.0}.get(direction, 0.0) * readout / pixels_y
    delay = readout if direction in ("left", "up") else 0.0
    return Step(shutter_time, np.array([open_time, ramp, delay, delay_x, delay_y]))
