"""Rotations and directions near their singularities: keyframe interpolation and the poles of a panorama."""

import math
from collections.abc import Callable

import numpy as np

import lensbench as lb
from lensbench.app.studies.stability.refraction import PI, exact, exactly, floats, root, sine_cosine
from lensbench.app.studies.stability.sweep import PRECISIONS, Sweep, curves_of
from lensbench.core.imaging.transform import quaternion, rotation_matrix
from lensbench.core.kernels.block import TIME, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program

Turned = Callable[[np.ndarray, np.ndarray], np.ndarray]         # two rotations (3, 3) → the one half-way (3, 3)

AXIS = np.array([2.0, 3.0, 6.0])                # × 1/7: of length 1
FIRST = np.array([[6.0, 2.0, 3.0], [-3.0, 6.0, 2.0], [-2.0, -3.0, 6.0]]) / 7.0          # rotation at the first keyframe
WIDE = 8192                     # pixels across a panorama


# Turns


def turn(angle) -> np.ndarray:
    """Exact rotation (3, 3): FIRST, then a rotation about AXIS by an exact angle (radians)."""
    x, y, z = exact(AXIS) / 7
    sine, cosine = sine_cosine(np.array(angle, dtype=object))
    across = np.array([[x * 0, -z, y], [z, x * 0, -x], [-y, x, x * 0]], dtype=object)
    rotation = exact(np.eye(3)) + sine * across + (1 - cosine) * (across @ across)
    return rotation @ (exact(np.round(7.0 * FIRST)) / 7)


def programs(real: type) -> Turned:
    """The program's method: the stage that moves the rays of a moving camera, at half the time."""
    def halfway(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        first, last = np.eye(4), np.eye(4)
        first[:3, :3], last[:3, :3] = start, end
        steps = lb.AnimatedTransform(first, last).steps(0.0, 1.0)
        ray = {X: np.zeros(3), Y: np.zeros(3), Z: np.zeros(3), L: np.eye(3)[0], M: np.eye(3)[1], N: np.eye(3)[2],
                 TIME: np.full(3, 0.5)}
        return Program(steps, real).run(ray, [L, M, N], 3)
    return halfway


def naive_quaternion(rotation: np.ndarray, real: type) -> np.ndarray:
    """Quaternion from the trace alone: w = √(1 + tr) / 2, the other parts divided by it."""
    m: np.ndarray = rotation.astype(real)
    w = real(0.5) * np.sqrt(np.maximum(real(1) + np.trace(m), real(0)))
    return np.array([w, *(np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / (real(4) * w))])


def school(real: type, naive: bool) -> Turned:
    """(sin(Ω/2) p + sin(Ω/2) q) / sin Ω, Ω by the arc cosine; naive: with quaternions from the trace."""
    def halfway(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            between = end @ start.T
            q = naive_quaternion(between, real) if naive else quaternion(between).astype(real)
            p: np.ndarray = np.array([1.0, 0.0, 0.0, 0.0], real)
            angle = np.arccos(np.clip(p @ q, real(-1), real(1)))
            half = np.sin(real(0.5) * angle) / np.sin(angle)
            return rotation_matrix(half * (p + q)) @ start
    return halfway


def _turned(title: str, axis: str, values: np.ndarray, angles: np.ndarray, note: str) -> Sweep:
    """Half-way rotations between FIRST and rotations by angles (°), compared with the exact ones."""
    methods: dict[str, Turned] = {
        "slerp by the arc cosine, float32": school(np.float32, False),
        "slerp by the arc cosine, float64": school(np.float64, False),
        "quaternion by the trace, float32": school(np.float32, True),
        "quaternion by the trace, float64": school(np.float64, True),
        "part of the turn, float32": programs(np.float32), "part of the turn, float64": programs(np.float64)}
    results: dict[str, list[float | str]] = {name: [] for name in methods}
    with exactly():
        for angle in exact(angles) * PI / 180:
            end, half = floats(turn(angle)), turn(angle / 2)
            for name, method in methods.items():
                rotated = method(FIRST, end)
                off = exact(np.where(np.isfinite(rotated), rotated, 0.0)) - half
                size = math.degrees(float(root(np.array((off * off).sum() / 2))))
                results[name].append(size if np.isfinite(rotated).all() else "NaN")
    return Sweep(title, axis, "°", values, "Orientation half-way", "°", 1e-3, "a twentieth of a pixel at 50 mm",
                 curves_of(results, ("part of the turn",)), note)


def half_a_turn() -> Sweep:
    """Keyframes that approach half a turn apart."""
    left = np.logspace(math.log10(90.0), -11.0, 40)
    return _turned("Keyframes half a turn apart", "Less than half a turn by", left, 180.0 - left,
                   "The trace of half a turn is −1, so that the root of 1 + trace has no digits left; the largest of "
                   "the four parts of the quaternion keeps its digits. At exactly half a turn the axis has no sign; "
                   "the camera always takes the same one.")


def no_turn() -> Sweep:
    """Keyframes that approach each other."""
    values = np.logspace(1.0, -12.0, 40)
    return _turned("Keyframes nearly equal", "Turn", values, values,
                   "Slerp divides by the sine of an angle that vanishes; a share of the rotation does not.")


# Panorama


def _directions(left: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Exact directions (n, 3) at exact angles (radians) from straight up; azimuths in turns to the right of −z."""
    sine, cosine = sine_cosine(left)
    across, ahead = sine_cosine(2 * PI * turns)
    return np.stack([sine * across, cosine, -sine * ahead], 1)


TURNS = np.array([-0.4375, -0.25, -0.0625, 0.125, 0.3125])


def pole() -> Sweep:
    """Directions of pixels that approach straight up."""
    values = np.logspace(math.log10(45.0), -9.0, 40)
    film = lb.Film(width=32.0, height=16.0, pixels_x=WIDE, pixels_y=WIDE // 2)
    steps = lb.EnvironmentCamera(film).camera_steps()

    def stage(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return Program(steps, x.dtype.type).run({X: x, Y: y}, [L, M, N], len(x)).T

    def school_form(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        real = x.dtype.type
        theta, phi = real(math.pi) * (real(0.5) + y / real(16)), -real(2 * math.pi) * x / real(32)
        return np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], 1)

    results: dict[str, list[float | str]] = {}
    with exactly():
        for angle in values:
            for real, precision in PRECISIONS:
                x = np.asarray(-32.0 * TURNS, real)
                y = np.full(len(TURNS), real(16.0 * (angle / 180.0 - 0.5)))
                truth = _directions(PI * (exact(y) / 16 + exact(np.float64(0.5))), -exact(x) / 32)
                for name, form in (("sines and cosines", school_form), ("by the half angle", stage)):
                    off = exact(form(x, y)) - truth
                    results.setdefault(f"{name}, {precision}", []).append(
                        1e6 * float(floats(root((off * off).sum(1))).max()))
    return Sweep("Poles of the panorama", "From straight up", "°", values, "Direction", "µrad", 77.0,
                 f"a tenth of a pixel of {WIDE} around", curves_of(results, ("by the half angle",)),
                 "The error is the rounding of a float32 y next to the edge of the film; neither form adds to it.")


def back_from_the_pole() -> Sweep:
    """Directions that approach straight up, projected back to the pixel."""
    values = np.logspace(math.log10(45.0), -9.0, 40)
    camera = lb.EnvironmentCamera(lb.Film(width=32.0, height=16.0, pixels_x=WIDE, pixels_y=WIDE // 2))

    def by_arc_cosine(real: type) -> Callable[[np.ndarray], np.ndarray]:
        def film(points: np.ndarray) -> np.ndarray:
            x, y, z = points.astype(real).T
            return np.stack([-np.arctan2(x, -z) / real(2 * math.pi) * real(32),
                             (np.arccos(np.clip(y, -1, 1)) / real(math.pi) - real(0.5)) * real(16)], 1)
        return film

    methods = {"arc cosine, float32": by_arc_cosine(np.float32), "arc cosine, float64": by_arc_cosine(np.float64),
               "arc tangent, float64": lambda points: camera.film_from_point(points, None)[0]}
    results: dict[str, list[float | str]] = {name: [] for name in methods}
    with exactly():
        for angle in values:
            up = exact(np.full(len(TURNS), angle)) * PI / 180
            points = floats(_directions(up, exact(TURNS)))
            truth = np.stack([-32 * exact(TURNS), 16 * (up / PI - exact(np.float64(0.5)))], 1)
            for name, method in methods.items():
                off = (exact(method(points)) - truth) * (WIDE // 32)
                off[:, 0] *= sine_cosine(up)[0]         # a pixel's width up there
                results[name].append(float(floats(root((off * off).sum(1))).max()))
    return Sweep("Back from the pole to the film", "From straight up", "°", values, "Place", "px", 0.1,
                 "a tenth of a pixel", curves_of(results, ("arc tangent",)),
                 "The cosine of a small angle is 1; in float32 the arc cosine is first nonzero at a thousand pixels.")


SWEEPS: dict[str, Callable[[], Sweep]] = {
    "Keyframes half a turn apart": half_a_turn, "Keyframes nearly equal": no_turn, "Poles of the panorama": pole,
    "Back from the pole to the film": back_from_the_pole}
