"""Arbitrary output variables (AOVs): pictures of what the samples of a picture are, instead of the light they find.

An AOV takes the samples of a picture through the same stages, and shows the mean over the samples of a pixel of

direction   (d + 1) / 2 of the ray's unit direction d in the world
origin      the point (mm, camera frame) where the ray leaves the lens
time        when the sample was taken: 0 as the first row begins to open, 1 as the last row has closed
depth       1 / distance (1/m) of the hit, from the camera's origin along −z; 0 for the sky. Of a camera that also sees
            behind itself (`sees_behind`) the distance is that along the ray
weight      the share of light that the camera passes, in the units of the camera's weights
fate        1 (white) where a ray from anywhere in the lens's rear opening arrives in the scene, elsewhere the colour of
            the surface that vignetted the ray: see `fate_colours`

Direction, origin, time and depth are means over the samples that arrive: a blocked sample has no hit, and would draw
the mean towards black at the edge of the pupil. In weight and fate it counts as black. A camera without surfaces blocks
no ray: its fate is 1 where it has any weight.
"""

import colorsys
import math

import numpy as np

from lensbench.core.analysis.model_choice import resolved
from lensbench.core.cameras.base import Camera
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import (
    BLUE, CLEARANCE, DEPTH, EMITS, GREEN, RED, TG, TIME, TR, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
)
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.optics.prescription import Lens
from lensbench.core.scenery.intersect.sky import SKY_DISTANCE
from lensbench.core.scenery.scene import Scene

AOVS = ("direction", "origin", "time", "depth", "weight", "fate")
AVERAGED = ("direction", "origin", "time", "depth")     # over the samples that arrive


# Rows that no stage of these pictures uses otherwise: no light is gathered, and no path is bounced
START_DEPTH, DEPTH_PER_MM = TR, TG      # along the camera's −z: of the ray's start (mm), and per mm of the ray; negated
HAS_ENDED = EMITS                       # 1: a surface has ended the ray

PLACES = 33             # across and down the film, at which a camera is asked whether it sees behind itself
STEEPEST = 1e-3         # cosine to the axis: a depth along it would be a thousandth of the distance

# Parameters of `show_rows`
GAIN, SHIFT = range(2)
# Parameters of `aim_at_rear_opening`
OPENING_X, OPENING_Y, OPENING_Z, OPENING_RADIUS = range(4)


def aov_steps(camera: Camera, scene: Scene, view: str) -> list[Step]:
    """The stages from raster X, Y and U0, U1, TIME to the colours of an AOV; ValueError for an unknown one."""
    if view not in AOVS:
        raise ValueError(f"view {view!r}: choose one of {', '.join(AOVS)}")
    if view == "fate" and camera.traced_lens is not None:
        assert camera.aim_distance is not None
        posed = [] if camera.film_pose.is_upright else [camera.film_pose.step]
        return [camera.film_step, *posed, *_fate_steps(camera.traced_lens, camera.aim_distance)]
    if view == "origin":
        return [camera.film_step, *camera.camera_steps(), Step(show_rows, [1.0, 0.0], [X, Y, Z])]
    if view == "time":
        duration = camera.exposure_time + camera.readout
        gain = 1.0 / duration if duration > 0.0 else 0.0
        return [*camera.steps(timed=True), Step(show_rows, [gain, 0.0], [TIME, TIME, TIME])]
    if view == "direction":
        return [*camera.steps(), Step(show_rows, [0.5, 0.5], [L, M, N])]
    if view == "depth":
        steps = camera.steps(timed=scene.moves)
        cut = len(steps) - len(camera.carried)         # still in the camera frame
        size = np.linalg.norm(camera.world_from_camera_at(camera.shutter_open + camera.exposure_time / 2.0)[:3, 2])
        axial = 0.0 if sees_behind(camera) else 1.0
        return [*steps[:cut], Step(keep_depth, [size, axial]), *steps[cut:], *scene.depth_steps(camera.shutter_open),
                Step(show_depth)]
    return [*camera.steps(), Step(show_white if view == "fate" else show_weight)]


def sees_behind(camera: Camera) -> bool:
    """Whether some ray of the camera leaves it sideways or backwards, as of panoramas and of fisheyes over 180°.

    Of such a camera a depth is the distance along the ray: along the axis it would be 0 or negative.
    """
    camera, film = camera.with_open_stop, camera.film
    shares = np.linspace(1e-6, 1.0 - 1e-6, PLACES)
    x, y = (values.ravel() for values in np.meshgrid(shares * film.pixels_x, shares * film.pixels_y))
    u, v = camera.stage_centre
    inputs = {X: x, Y: y, U0: np.full(x.size, u), U1: np.full(x.size, v), TIME: np.full(x.size, 0.5)}
    slope, weight = Program([camera.clock, camera.film_step, *camera.aimed()]).run(inputs, [N, WEIGHT], x.size)
    return bool((slope[weight > 0.0] > -STEEPEST).any())


def arrival_steps(camera: Camera, timed: bool) -> list[Step]:
    """The stages to 1 in all colours for each sample that arrives; timed: the samples have a TIME."""
    return [*camera.steps(timed=timed), Step(show_white)]


def fate_colours(lens: Lens) -> np.ndarray:
    """Colours in which the view "fate" shows rays that end at the surfaces of a lens.

    Args:
        lens: Lens of n surfaces.
    Returns:
        (n, 3) linear RGB: red at the scene to violet at the film; the surface of the stop is grey.
    """
    n = len(lens.surfaces)
    colours = np.array([colorsys.hls_to_rgb(0.75 * i / max(n - 1, 1), 0.45, 0.75) for i in range(n)])
    colours[lens.stop_index] = 0.25
    return colours


@stage
def show_rows(lanes, p, ints, key):
    """RED, GREEN, BLUE: the rows `ints` × GAIN + SHIFT; WEIGHT: 1 for each sample that arrives. p: GAIN, SHIFT."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight = row[WEIGHT]
    a, b, c = row[ints[0]], row[ints[1]], row[ints[2]]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    gain, shift = p[GAIN], p[SHIFT]
    for i in range(B):
        u, v, w = a[i], b[i], c[i]
        red[i], green[i], blue[i] = gain * u + shift, gain * v + shift, gain * w + shift
        weight[i] = real(1) if weight[i] > real(0) else real(0)


@stage
def keep_depth(lanes, p, ints, key):
    """START_DEPTH, DEPTH_PER_MM: of the ray in the camera frame. p: size of a camera unit in the world, AXIAL.

    AXIAL: 1 for depths along the camera's axis, 0 along the ray.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    z, n, start, slope = row[Z], row[N], row[START_DEPTH], row[DEPTH_PER_MM]
    size, axial = p[0] * p[1], p[1]
    for i in range(B):
        start[i], slope[i] = size * z[i], axial * n[i] - (real(1) - axial)


@stage
def show_depth(lanes, p, ints, key):
    """RED, GREEN, BLUE: 1 / distance of the hit along the camera's −z, 1/m; 0 for the sky. After `keep_depth`."""
    real = lanes.dtype.type
    row = rows(lanes)
    start, slope, depth, weight = row[START_DEPTH], row[DEPTH_PER_MM], row[DEPTH], row[WEIGHT]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        t = depth[i]
        along = -(start[i] + t * slope[i])
        near = real(1000) / along if t < real(SKY_DISTANCE) else real(0)
        red[i], green[i], blue[i] = near, near, near
        weight[i] = real(1) if weight[i] > real(0) else real(0)


@stage
def show_weight(lanes, p, ints, key):
    """RED, GREEN, BLUE: 1, so that the picture is the mean WEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        red[i], green[i], blue[i] = real(1), real(1), real(1)


@stage
def show_white(lanes, p, ints, key):
    """RED, GREEN, BLUE: 1; WEIGHT: 1 for each sample that arrives."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, red, green, blue = row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        red[i], green[i], blue[i] = real(1), real(1), real(1)
        weight[i] = real(1) if weight[i] > real(0) else weight[i]


def _fate_steps(lens: Lens, film_distance: float) -> list[Step]:
    """The stages from the film point to the rear opening, then through one surface at a time."""
    rear, last = lens.surfaces[-1], len(lens.surfaces) - 1
    # The plane of the rim: a ray that meets this disk meets the surface within its rim, however deep the surface is. A
    # tilted rim lies within a sphere about its middle, and its disk is across the axis
    frame, middle = lens.frames[last], np.array([0.0, 0.0, lens.length + float(rear.sag(rear.semi_diameter))])
    middle = middle if frame is None else frame.rotation @ middle + frame.shift
    steps = [Step(aim_at_rear_opening, [*(middle - [0.0, 0.0, lens.length + film_distance]), rear.semi_diameter])]
    for back, colour in enumerate(fate_colours(lens)[::-1]):
        steps += [*surface_steps(lens, film_distance, which=slice(back, back + 1),
                                 at_stop=lens.iris.blocking(lens.stop.semi_diameter)), Step(show_fate, colour)]
    return [*steps, Step(show_passed)]


@stage
def aim_at_rear_opening(lanes, p, ints, key):
    """L, M, N: from the film point X, Y, Z to a uniform point (by U0, U1) of a disk across the axis. p: OPENING_X …."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    u, v, weight, ended = row[U0], row[U1], row[WEIGHT], row[HAS_ENDED]
    middle_x, middle_y, plane, radius = p[OPENING_X], p[OPENING_Y], p[OPENING_Z], p[OPENING_RADIUS]
    for i in range(B):
        a, b = concentric_disk(real, v[i], u[i])
        dx, dy, dz = middle_x + a * radius - x[i], middle_y + b * radius - y[i], plane - z[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + dz * dz)
        l[i], m[i], n[i] = dx * size, dy * size, dz * size
        x[i], y[i] = x[i] - z[i] / dz * dx, y[i] - z[i] / dz * dy           # the ray begins at Z = 0
        z[i], weight[i], ended[i] = real(0), real(1), real(0)


@stage
def show_fate(lanes, p, ints, key):
    """RED, GREEN, BLUE: the colour p where this surface is the first to end the ray; HAS_ENDED: 1 there."""
    real = lanes.dtype.type
    row = rows(lanes)
    clearance, ended, red, green, blue = row[CLEARANCE], row[HAS_ENDED], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        through = clearance[i] <= real(1)           # false for NaN
        first = ended[i] == real(0)
        red[i], green[i], blue[i] = p[0] if first else red[i], p[1] if first else green[i], p[2] if first else blue[i]
        ended[i] = ended[i] if through else real(1)


@stage
def show_passed(lanes, p, ints, key):
    """RED, GREEN, BLUE: 1 where no surface has ended the ray; WEIGHT: 1 for every sample."""
    real = lanes.dtype.type
    row = rows(lanes)
    ended, weight, red, green, blue = row[HAS_ENDED], row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        through = ended[i] == real(0)
        red[i], green[i], blue[i] = (real(1) if through else red[i], real(1) if through else green[i],
                                     real(1) if through else blue[i])
        weight[i] = real(1)


def depth_map(camera: Camera, scene: Scene, time: float = 0.5) -> np.ndarray:
    """Depth of the scene at the centre of each pixel, along the ray through the middle of the pupil.

    Args:
        camera: Any camera; one of the model "auto" is resolved as by `render`.
        scene: The scene, world frame, mm.
        time: When, in [0, 1) of the shutter; matters where camera or scene move.
    Returns:
        float32 (h, w) mm from the camera's origin along its −z, the top row first; inf where only sky is seen, NaN
            where the camera passes no light. Of a camera that also sees sideways or behind itself, such as a panorama
            or a fisheye over 180°, the distance along each ray in mm.
    """
    camera.check_overrides()
    camera, film = resolved(camera, scene).with_open_stop, camera.film
    h, w = film.pixels_y, film.pixels_x
    y, x = np.mgrid[0:h, 0:w] + 0.5
    n = w * h
    middle = camera.stage_centre
    inputs = {X: x.ravel(), Y: y.ravel(), U0: np.full(n, middle[0]), U1: np.full(n, middle[1]), TIME: np.full(n, time)}
    # Distance along the ray, and whether there is a hit
    steps = [*camera.steps(timed=scene.moves), *scene.depth_steps(camera.shutter_open)]
    along, hit, weight = Program(steps).run(inputs, [RED, GREEN, WEIGHT], n)
    # The ray's start and slope along the camera's axis
    z, slope, clock = Program([camera.clock, camera.film_step, *camera.aimed()]).run(inputs, [Z, N, TIME], n)
    pose = camera.world_from_camera
    scale = pose.scale_at(camera.shutter_open + clock) if isinstance(pose, AnimatedTransform) else 1.0
    with np.errstate(invalid="ignore", over="ignore"):
        depth = along if sees_behind(camera) else -(z * scale + slope * along)
    depth = np.where(hit > 0.0, depth, np.inf)
    return np.where(weight > 0.0, depth, np.nan).reshape(h, w).astype(np.float32)
