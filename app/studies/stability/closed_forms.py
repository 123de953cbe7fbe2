"""Closed forms near their limits: thin lens, depth of field, stored depth, and weights far off the axis."""

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial

import numpy as np

import lensbench as lb
from lensbench.app.studies.stability.sweep import PRECISIONS, Curve, Sweep, curve
from lensbench.core.cameras.ideal_lens import thin
from lensbench.core.kernels.block import RED, WEIGHT, B, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program

FOCAL_LENGTH, F_NUMBER, BLUR = 50.0, 2.0, 0.03125       # mm; f-number; limit of the blur, mm
THOUSANDTH = "one digit more than is displayed"
OWN = "the program's, float64"


def relative(value: float, truth: Fraction) -> float | str:
    """|found / truth − 1| in percent; "NaN" or "inf" if `found` is not finite."""
    value = float(value)
    if not math.isfinite(value):
        return "NaN" if math.isnan(value) else "inf"
    return 100.0 * float(abs(Fraction(value) / truth - 1))


def asked(ask: Callable[[], float], truth: Fraction) -> float | str:
    """Error of an answer in percent, or the name of the error that was raised."""
    try:
        return relative(ask(), truth)
    except lb.LensError as refused:
        return type(refused).__name__


def _rows(values: Sequence[float], forms: dict[str, Callable[[float], float]], truth: Callable[[float], Fraction],
          own: str = OWN) -> tuple[Curve, ...]:
    """Curves of the relative error of functions of one value; names of the program's own begin with `own`."""
    with np.errstate(all="ignore"):
        return tuple(curve(name, [asked(partial(form, value), truth(value)) for value in values], name.startswith(own))
                     for name, form in forms.items())


# Circles of confusion


def _coc(focus: float, distance: float) -> Fraction:
    """Exact circle of confusion A f |s − s_f| / (s (s_f − f)) of float arguments (mm)."""
    f, s_f, s = Fraction(FOCAL_LENGTH), Fraction(focus), Fraction(distance)
    return f / Fraction(F_NUMBER) * f * abs(s - s_f) / (s * (s_f - f))


def _printed_coc(real: type, focus: float, distance: float) -> float:
    f, n, s_f, s = real(FOCAL_LENGTH), real(F_NUMBER), real(focus), real(distance)
    return float(f / n * f * abs(s - s_f) / (s * (s_f - f)))


def _in_dioptres(focus: float, distance: float) -> float:
    """|1/s_f − 1/s| / (1 − f/s_f), valid for infinite distances (mm)."""
    return FOCAL_LENGTH**2 / F_NUMBER * abs(1.0 / focus - 1.0 / distance) / (1.0 - FOCAL_LENGTH / focus)


def _own_coc(focus: float, distance: float) -> float:
    return float(lb.circle_of_confusion(FOCAL_LENGTH, F_NUMBER, focus, distance))


def to_the_focal_length() -> Sweep:
    """Focus distance that approaches the focal length, where the image goes to infinity."""
    beyond = np.logspace(1.0, -14.0, 46)
    forms = {"in dioptres, float64": lambda excess: _in_dioptres(FOCAL_LENGTH * (1.0 + excess), 1e4),
             "as printed, float32": lambda excess: _printed_coc(np.float32, FOCAL_LENGTH * (1.0 + excess), 1e4),
             OWN: lambda excess: _own_coc(FOCAL_LENGTH * (1.0 + excess), 1e4)}
    return Sweep("Thin lens as the focus comes to f", "Focus beyond f", "f", beyond, "Circle of confusion", "%", 0.1,
                  THOUSANDTH, _rows(beyond.tolist(), forms, lambda excess: _coc(FOCAL_LENGTH * (1.0 + excess), 1e4)),
                  "The difference of focus distance and focal length is exact; one less their quotient is not. At f "
                  "and nearer the program raises FocusError.")


def near_the_focus() -> Sweep:
    """A point that approaches the plane in focus."""
    beyond = np.logspace(0.0, -14.0, 43)
    points = {float(excess): 1500.0 * (1.0 + excess) for excess in beyond}
    return Sweep("Blur next to the plane in focus", "Distance from it", "of the focus", beyond, "Circle of confusion",
                  "%", 0.1, THOUSANDTH, _rows(beyond.tolist(), {
                      "in dioptres, float64": lambda excess: _in_dioptres(1500.0, points[excess]),
                      OWN: lambda excess: _own_coc(1500.0, points[excess])},
                      lambda excess: _coc(1500.0, points[excess])),
                  "The difference of two nearly equal reciprocals loses digits that the difference of the two "
                  "distances keeps.")


# Depth of field


def _limit(focus: float, sign: int) -> Fraction:
    """Exact near (sign 1) or far (−1) limit s f² / (f² ± N C (s − f)) of float arguments (mm)."""
    f, s = Fraction(FOCAL_LENGTH), Fraction(focus)
    return s * f * f / (f * f + sign * Fraction(F_NUMBER) * Fraction(BLUR) * (s - f))


def _printed_limit(real: type, focus: float, sign: int) -> float:
    f, n, c, s = real(FOCAL_LENGTH), real(F_NUMBER), real(BLUR), real(focus)
    return float(s * f * f / (f * f + sign * n * c * (s - f)))


def _printed_limits(sign: int, focus: Callable[[float], float]) -> dict[str, Callable[[float], float]]:
    """The formula in both precisions, of a focus distance that follows from the swept value."""
    def limit(real: type) -> Callable[[float], float]:
        return lambda value: _printed_limit(real, focus(value), sign)

    return {f"as printed, {precision}": limit(real) for real, precision in PRECISIONS}


def hyperfocal() -> Sweep:
    """Far limit while the focus distance approaches the hyperfocal distance."""
    before = np.logspace(-0.3, -13.0, 43)
    whole = lb.hyperfocal(FOCAL_LENGTH, F_NUMBER, BLUR)         # a sum of powers of two: exact
    focus = {float(gap): whole * (1.0 - float(gap)) for gap in before}
    forms = {**_printed_limits(-1, focus.__getitem__),
             OWN: lambda gap: lb.depth_of_field(FOCAL_LENGTH, F_NUMBER, focus[gap], BLUR)[1]}
    return Sweep("Depth of field at the hyperfocal", "Focus before the hyperfocal", "of it", before, "Far limit", "%",
                  0.1, THOUSANDTH, _rows(before.tolist(), forms, lambda gap: _limit(focus[gap], -1)),
                  "The far limit goes to infinity there and is infinite beyond; a focus distance in float32 is too "
                  "coarse to give the far limit.")


def far_focus() -> Sweep:
    """Near limit while the focus distance goes to infinity."""
    values = np.logspace(2.0, 100.0, 50)
    forms = {**_printed_limits(1, float),
             OWN: lambda focus: lb.depth_of_field(FOCAL_LENGTH, F_NUMBER, focus, BLUR)[0]}
    return Sweep("Depth of field of a far focus", "Focus", "mm", values, "Near limit", "%", 0.1, THOUSANDTH,
                  _rows(values.tolist(), forms, lambda focus: _limit(focus, 1)),
                  "As printed, the formula overflows, and at infinity it is NaN; divided by the distance it is valid "
                  "at infinity too.")


# Depth in numbers


def depth() -> Sweep:
    """Distance of a pixel, stored in one number."""
    values = np.logspace(2.0, 7.0, 41)
    near, far = 10.0, 1e8

    def buffer(real: type, reverse: bool) -> Callable[[float], float]:
        def stored(distance: float) -> float:
            squeeze = 1.0 / (1.0 - near / far)
            z = squeeze * (1.0 - near / distance)
            kept = float(real(squeeze * near / distance - squeeze * near / far)) if reverse else 1.0 - float(real(z))
            return near / (kept / squeeze + (near / far if reverse else 1.0 - 1.0 / squeeze))
        return stored

    def traced(distance: float) -> float:
        wall = lb.Rectangle((0.0, 0.0, -distance), (distance, 0.0, 0.0), (0.0, distance, 0.0))
        steps = lb.Scene("wall", plates=(wall,)).depth_steps()
        slope = np.float32(0.25)
        size = np.float32(1.0) / np.sqrt(np.float32(1.0) + slope * slope)
        ray = {X: [0.0], Y: [0.0], Z: [0.0], L: [slope * size], M: [0.0], N: [-size]}
        along = Program(steps, np.float32).run({row: np.array(v) for row, v in ray.items()}, [RED], 1)[0, 0]
        return float(along) * float(size)

    forms = {"screen z, float32": buffer(np.float32, False), "screen z, float64": buffer(np.float64, False),
             "screen z reversed, float32": buffer(np.float32, True), "distance along the ray, float32": traced}
    return Sweep("Depth kept in a number", "Distance", "mm", values, "Distance", "%", 0.1,
                  "a metre in a kilometre", _rows(values.tolist(), forms, Fraction, "distance along the ray, float32"),
                  "Almost all steps of a perspective z from 10 mm to 100 km lie in the first metre.")


# Weights


def weights() -> Sweep:
    """Fourth power of the cosine at the film, for rays that become parallel to the film."""
    left = np.logspace(math.log10(60.0), -4.0, 36)
    tangents = {float(angle): float(np.float32(1.0 / math.tan(math.radians(angle)))) for angle in left}

    def stage(real: type) -> Callable[[float], float]:
        def weight(angle: float) -> float:
            steps = thin(0.0, 0.0, 1.0, math.inf).steps(1.0)
            samples = {X: np.full(B, tangents[angle]), Y: np.zeros(B)}
            return float(Program(steps, real).run(samples, [WEIGHT], B)[0, 0])
        return weight

    def by_the_angle(real: type) -> Callable[[float], float]:
        return lambda angle: float(np.cos(np.arctan(real(tangents[angle]))) ** 4)

    def by_the_sine(real: type) -> Callable[[float], float]:
        def weight(angle: float) -> float:
            tangent = real(tangents[angle])
            sine2 = tangent * tangent / (real(1) + tangent * tangent)
            return float((real(1) - sine2) ** 2)
        return weight

    def cos4(angle: float) -> Fraction:
        return 1 / (1 + Fraction(tangents[angle]) ** 2) ** 2

    forms = {f"{name}, {precision}": form(real) for name, form in
             (("cosine of the angle", by_the_angle), ("1 − sin²", by_the_sine), ("by the tangent", stage))
             for real, precision in PRECISIONS}
    return Sweep("cos⁴ near 90°", "Angle between ray and film", "°", left, "Weight", "%", 0.1,
                  "a thousandth of a stop", _rows(left.tolist(), forms, cos4, own="by the tangent"),
                  "The cosine of an angle near 90° is a small difference; computed from the tangent it is a quotient.")


SWEEPS: dict[str, Callable[[], Sweep]] = {
    "Thin lens as the focus comes to f": to_the_focal_length, "Blur next to the plane in focus": near_the_focus,
    "Depth of field at the hyperfocal": hyperfocal, "Depth of field of a far focus": far_focus,
    "Depth kept in a number": depth, "cos⁴ near 90°": weights}
