"""The real beam of the axis point of a near object: whether it passes and meets, and a lost sign that explains it.

Lengths in mm. The beam fills the stop and is judged in best focus: the film of such a lens is where it was set. With
the magnification m, the blur that is allowed at f(1 + |m|) behind the lens is that of a lens of this focal length.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from lensbench.core.optics.finding import Change, Finding, Kind
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, Trace, trace
from lensbench.core.text import fixed, significant
from lensbench.lenses.checks.axial_beam import SHARES, WORDS, allowed_blur
from lensbench.lenses.checks.hypotheses import with_surface

SEARCHED = np.linspace(0.02, 1.3, 65)       # of the slope to the rim of the paraxial entrance pupil
INNER = 0.9             # of the aperture's radius: outer rays of a fast lens may fail nearer than it was meant for
TRUSTED = 0.5           # of the allowed blur: a lens with another sign that is no better proves nothing
MOST = 3                # signs that are named; more would prove none


@dataclass(frozen=True)
class _Beam:
    """focus: last vertex → best focus. blur and allowed: rms radii there; inf and another fate if a ray fails."""

    focus: float
    blur: float
    allowed: float
    f_number: float
    fate: Fate = Fate.PASSED
    surface: int = -1
    share: float = 1.0


def near_findings(lens: Lens) -> list[Finding]:
    """Findings about a lens whose object is near: the lost sign that explains them, then what is wrong.

    Nothing for a lens without rotational symmetry, an object that touches the lens, a pupil that no paraxial ray
    reaches, and an image at infinity or before the lens where no back focus is stored.
    """
    beam, stored = _beam(lens), lens.surfaces[-1].thickness
    if beam is None or _is_sound(beam) or (beam.fate == Fate.PASSED and not _is_real(beam) and not stored > 0.0):
        return []
    distance = significant(lens.system.object_distances[0], 5)
    if beam.fate != Fate.PASSED:
        wrong = Finding(Kind.RAY, beam.surface, f"a ray from the axis point of the object, {distance} mm before the "
                        f"lens, at {fixed(100.0 * beam.share, 0)} % of the aperture's radius, "
                        f"{WORDS[beam.fate].format(beam.surface)}", figures={"share": beam.share})
    elif not _is_real(beam):
        wrong = Finding(Kind.BACK_FOCUS, len(lens.surfaces) - 1, f"the lens forms no real image of the object, "
                        f"{distance} mm before it: the beam meets {significant(beam.focus, 5)} mm behind the last "
                        f"surface, the stored back focus is {significant(stored, 5)} mm",
                        figures={"focus": beam.focus, "stored": stored})
    else:
        wrong = Finding(Kind.BLUR, None, f"the axis point of the object, {distance} mm before the lens, becomes a disk "
                        f"of {significant(beam.blur, 3)} mm rms radius in best focus, at full aperture, f/"
                        f"{significant(beam.f_number, 3)} at work, where lenses of this speed and kind stay below "
                        f"{significant(beam.allowed, 2)} mm",
                        figures={"blur": beam.blur, "allowed": beam.allowed, "f_number": beam.f_number})
    signs = sorted(_signs(lens), key=lambda sign: sign.figures["blur_after"])
    perhaps = "" if len(signs) == 1 else "perhaps "
    return [*(replace(sign, message=f"{perhaps}{sign.message}") for sign in signs if len(signs) <= MOST), wrong]


def _is_sound(beam: _Beam) -> bool:
    return beam.fate == Fate.PASSED and _is_real(beam) and beam.blur <= beam.allowed


def _is_real(beam: _Beam) -> bool:
    return 0.0 < beam.focus < inf


def _signs(lens: Lens) -> Iterator[Finding]:
    """A finding for each radius with whose other sign the lens is good."""
    for i, surface in enumerate(lens.surfaces):
        if not surface.curvature:
            continue
        changed = _beam(with_surface(lens, i, curvature=-surface.curvature))
        if changed is None or not _is_sound(changed) or changed.blur > TRUSTED * changed.allowed:
            continue
        old = 1.0 / surface.curvature
        yield Finding(Kind.SIGN, i,
                      f"a radius has the wrong sign: with the other one the blur is {significant(changed.blur, 4)} mm",
                      f"radius of surface {i}: {significant(-old, 7)} instead of {significant(old, 7)} (one sign)",
                      figures={"blur_after": changed.blur}, change=Change("radius", i, old, -old))


def _beam(lens: Lens) -> _Beam | None:
    """The beam; None where it cannot be judged."""
    distance, fo = lens.system.object_distances[0], first_order(lens)
    pupil = fo.entrance_pupil
    if not (lens.is_rotationally_symmetric and 0.0 < distance < inf and isfinite(fo.efl)
            and isfinite(pupil.radius) and 0.0 < distance + pupil.z < inf):
        return None
    slope = pupil.radius / (distance + pupil.z)
    front = Lens(lens.surfaces[:lens.stop_index + 1], lens.stop_index, front_index=lens.front_index)
    to_stop = _traced(front, distance, SEARCHED * slope)
    outside = np.flatnonzero((to_stop.fate != Fate.PASSED)
                             | (np.abs(to_stop.points[:, 1]) > lens.stop.semi_diameter * (1.0 + 1e-6)))
    if outside.size and not outside[0]:
        return None
    slopes = SHARES * slope * (SEARCHED[outside[0] - 1] if outside.size else 1.0)
    rays = _traced(lens, distance, slopes)
    failed = np.flatnonzero(rays.fate)
    if failed.size and SHARES[failed[0]] < INNER:
        fate = Fate(int(rays.fate[failed[0]]))
        return _Beam(inf, inf, inf, inf, fate, int(rays.surface[failed[0]]) + (fate == Fate.MISSED),
                     float(SHARES[failed[0]]))
    passed = np.flatnonzero((rays.fate == Fate.PASSED) & (SHARES < 1.0))
    behind = (rays.directions[:, 1] / rays.directions[:, 2])[passed]
    height = rays.points[passed, 1] + (lens.length - rays.points[passed, 2]) * behind
    focus = -float(height @ behind) / float(behind @ behind) if behind.any() else inf
    if not isfinite(focus):
        return _Beam(inf, inf, inf, inf)
    sine = abs(float(rays.directions[passed[-1], 1])) / float(SHARES[passed[-1]])
    magnified = lens.front_index * float(np.sin(np.arctan(slopes[-1]))) / sine     # Abbe's sine condition
    f_number, blur = 0.5 / sine, float(np.sqrt(np.mean((height + focus * behind)**2)))
    return _Beam(focus, blur, abs(fo.efl) * (1.0 + magnified) * allowed_blur(lens, f_number), f_number)


def _traced(lens: Lens, distance: float, slopes: np.ndarray) -> Trace:
    """Rays from the axis point of the object, whatever the rims are."""
    cosines = 1.0 / np.sqrt(1.0 + slopes**2)
    directions = np.stack([0.0 * slopes, slopes * cosines, cosines], axis=1)
    return trace(lens, np.tile([0.0, 0.0, -distance], (len(slopes), 1)), directions, clip=False, forward=True)
