"""Views of what the samples of a picture are, in place of the light that they find.

A view is a picture as any other, of the same samples through the same stages; what it
shows of each is averaged over samples of a pixel:

direction   (d + 1) / 2 of the ray's unit direction d in the world
origin      the point (mm, camera frame) where the ray leaves the lens
time        when it was taken: 0 as the first line begins to open, 1 as the last one has closed
depth       1 / distance (1/m) of what it meets, from the camera's origin along −z; 0 for the sky
weight      its weight: what the camera lets through, in the units of the camera's weights
fate        1 (white) where a ray to anywhere in the lens's rear opening arrives in the scene, and where
            it does not, the colour of the surface that ended it: see `fate_colours`

Direction, origin, time and depth are means over the samples that arrive: what the camera blocks
meets nothing, and would draw them towards black at the edge of the pupil. In weight and fate it counts as
black. A camera without surfaces ends no ray: its fate is 1 where it has any weight.
"""

import colorsys
import math

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.real_lens import LensCamera
from lensbench.kernels.block import (
    BLUE,
    CLEARANCE,
    DEPTH,
    EMITS,
    GREEN,
    RED,
    TG,
    TIME,
    TR,
    U0,
    U1,
    WEIGHT,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.optics.block_trace import MORE, SURFACE, trace_step
from lensbench.optics.prescription import Lens
from lensbench.scenery.scene import SKY_DISTANCE, Scene

AOVS = ("direction", "origin", "time", "depth", "weight", "fate")
AVERAGED = ("direction", "origin", "time", "depth")     # over the samples that arrive


def aov_steps(camera: Camera, scene: Scene, view: str) -> list[Step]:
    """The stages from raster X, Y and U0, U1, TIME to the colours of a view; ValueError for one that is none."""
    if view not in AOVS:
        raise ValueError(f"view {view!r}: choose one of {', '.join(AOVS)}")
    if view == "fate" and isinstance(camera, LensCamera) and camera.is_traced:
        return [camera.film_step, *_fates(camera)]
    if view == "origin":
        return [camera.film_step, *camera.camera_steps(), _shown((X, Y, Z))]
    if view == "time":
        lasting = camera.exposure_time + camera.readout
        return [*camera.steps(timed=True), _shown((TIME, TIME, TIME), 1.0 / lasting if lasting > 0.0 else 0.0)]
    steps = camera.steps()
    if view == "direction":
        return [*steps, _shown((L, M, N), 0.5, 0.5)]
    if view == "depth":
        steps = camera.steps(timed=scene.moves)
        here = len(steps) - len(camera.carried)
        size = np.linalg.norm(camera.world_from_camera_at(camera.shutter_open + camera.exposure_time / 2.0)[:3, 2])
        return [*steps[:here], Step(kept, [size]), *steps[here:], *scene.depth_steps(camera.shutter_open),
                Step(nearness, [])]
    return [*steps, Step(passed, [1.0 if view == "fate" else 0.0])]


def arrival_steps(camera: Camera, timed: bool) -> list[Step]:
    """The stages to 1 in all colours for each sample that arrives; timed: the samples have a TIME."""
    return [*camera.steps(timed=timed), Step(passed, [1.0])]


def fate_colours(lens: Lens) -> np.ndarray:
    """(surfaces, 3): how “fate” shows rays that end at each, red at the scene to violet at the film; the stop grey."""
    n = len(lens.surfaces)
    colours = np.array([colorsys.hls_to_rgb(0.75 * i / max(n - 1, 1), 0.45, 0.75) for i in range(n)])
    colours[lens.stop_index] = 0.25
    return colours


def _shown(names: tuple[int, int, int], gain: float = 1.0, shift: float = 0.0) -> Step:
    return Step(shown, [*names, gain, shift])


@stage
def shown(lanes, p, key):
    """Three rows, times a gain, plus a shift, as colours; every sample that arrives weighs the same. p: rows, both."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight = row[WEIGHT]
    a, b, c = row[np.int64(p[0])], row[np.int64(p[1])], row[np.int64(p[2])]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    gain, shift = p[3], p[4]
    for i in range(B):
        u, v, w = a[i], b[i], c[i]
        red[i], green[i], blue[i] = gain * u + shift, gain * v + shift, gain * w + shift
        weight[i] = real(1) if weight[i] > real(0) else real(0)


@stage
def kept(lanes, p, key):
    """TR, TG: how far behind the camera's origin its ray begins, p[0] times Z, and N, still in the camera frame."""
    row = rows(lanes)
    z, n, behind, slope = row[Z], row[N], row[TR], row[TG]
    for i in range(B):
        behind[i], slope[i] = p[0] * z[i], n[i]


@stage
def nearness(lanes, p, key):
    """RED, GREEN, BLUE: 1 / distance of the hit along the camera's −z, which `kept` knows, in 1/m; 0 for the sky."""
    real = lanes.dtype.type
    row = rows(lanes)
    behind, slope, depth, weight = row[TR], row[TG], row[DEPTH], row[WEIGHT]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        t = depth[i]
        along = -(behind[i] + t * slope[i])
        near = real(1000) / along if t < real(SKY_DISTANCE) else real(0)
        red[i], green[i], blue[i] = near, near, near
        weight[i] = real(1) if weight[i] > real(0) else real(0)


@stage
def passed(lanes, p, key):
    """White; p[0] is 1 where every sample that arrives weighs the same, 0 where its weight is the view."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, red, green, blue = row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    level = p[0] > real(0)
    for i in range(B):
        red[i], green[i], blue[i] = real(1), real(1), real(1)
        weight[i] = real(1) if level & (weight[i] > real(0)) else weight[i]


def _fates(camera: LensCamera) -> list[Step]:
    """From the film point to the rear opening, then surface by surface, with a note after each."""
    lens, rear = camera.lens, camera.lens.surfaces[-1]
    # The rim's own plane: a ray meets the surface within its rim where it meets this disk, however deep the surface is
    plane = float(rear.sag(rear.semi_diameter)) - camera.film_distance
    steps = [Step(to_opening, [plane, rear.semi_diameter])]
    kernel, numbers = trace_step(lens, camera.film_distance)[:2]
    sign, at, place = numbers[0], 1, 0.0
    for back, colour in enumerate(fate_colours(lens)[::-1], start=1):
        one = numbers[at:at + SURFACE + MORE[int(numbers[at])]].copy()
        at += len(one)
        place += one[1]
        one[1] = place                      # the gap before it: from the film, and not from the surface before
        blades = lens.iris.blocking(lens.stop.semi_diameter) if back + lens.stop_index == len(lens.surfaces) else []
        steps += [Step(kernel, [sign, *one, place]), *blades, Step(noted, colour)]
    return [*steps, Step(settled, [])]


@stage
def to_opening(lanes, p, key):
    """From the film point X, Y to a point of the disk of radius p[1] in the plane Z = p[0], evenly by U0, U1."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    u, v, weight, ended = row[U0], row[U1], row[WEIGHT], row[EMITS]
    plane, radius = p[0], p[1]
    for i in range(B):
        a, b = concentric_disk(real, v[i], u[i])
        dx, dy = a * radius - x[i], b * radius - y[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + plane * plane)
        l[i], m[i], n[i] = dx * size, dy * size, plane * size
        z[i], weight[i], ended[i] = real(0), real(1), real(0)


@stage
def noted(lanes, p, key):
    """RED, GREEN, BLUE become the colour p where this surface is the first to end the ray; EMITS: it has ended."""
    real = lanes.dtype.type
    row = rows(lanes)
    margin, ended, red, green, blue = row[CLEARANCE], row[EMITS], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        through = margin[i] <= real(1)              # which NaN is not
        here = ended[i] == real(0)
        red[i], green[i], blue[i] = p[0] if here else red[i], p[1] if here else green[i], p[2] if here else blue[i]
        ended[i] = ended[i] if through else real(1)


@stage
def settled(lanes, p, key):
    """White where no surface ended the ray; every sample weighs the same."""
    real = lanes.dtype.type
    row = rows(lanes)
    ended, weight, red, green, blue = row[EMITS], row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        through = ended[i] == real(0)
        red[i], green[i], blue[i] = (real(1) if through else red[i], real(1) if through else green[i],
                                     real(1) if through else blue[i])
        weight[i] = real(1)
