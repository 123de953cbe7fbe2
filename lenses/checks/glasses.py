"""Glasses that nobody makes: index and Abbe number far from every known glass, or from the named one."""

from functools import lru_cache

import numpy as np

from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.glass import catalogue
from lensbench.lenses.glass.media import MISC, OTHERS

STEP_N, STEP_V = 0.01, 2.0      # a glass of another melt, maker or century is about so far from one of today
FAR = 4.0                       # such steps from every known glass: the first flints of 1890 are at 3.4
NAMED_N, NAMED_V = 0.01, 0.08   # and between a glass and its name; V_d as a share: other kinds share old names
RESIN_N, LEAST_V = (1.57, 1.78), 14.0       # resins: from polycarbonate to the densest for spectacles and telephones
RESIN_V, RESIN_SLOPE = 36.0, 55.0           # V_d of the lightest, and its fall by n_d: flint glass lies above it


def glass_findings(lens: Lens) -> list[Finding]:
    """Findings about each medium once, at its first surface."""
    findings = []
    media: dict[tuple[float, float], list[int]] = {}
    for i, surface in enumerate(lens.surfaces):
        glass = surface.glass
        if glass.n_d > 1.0 and glass.v_d is not None:
            media.setdefault((glass.n_d, glass.v_d), []).append(i)
    for (n_d, v_d), indices in media.items():
        wrong = _misnamed(lens, indices)
        name, away = _nearest(n_d, v_d)
        if away <= FAR or _is_resin(n_d, v_d):
            findings += wrong
            continue
        where = f"surface{'s' if len(indices) > 1 else ''} {', '.join(map(str, indices))}"
        labels = list(dict.fromkeys(lens.surfaces[i].glass.name for i in indices if lens.surfaces[i].glass.name))
        figures = {"n_d": n_d, "V_d": v_d, "steps": away}
        message = (f"no known glass is near n_d {significant(n_d)}, V_d {significant(v_d)} ({where}); the nearest is "
                   f"{name}")
        if len(labels) > 1:
            figures["names"] = float(len(labels))
            message += f". It is the glass of {', '.join(labels)} alike: a program may have replaced unknown names"
        findings.append(Finding(Kind.GLASS, indices[0], message, next((f.proposal for f in wrong), None),
                                figures=figures))
    return findings


def _is_resin(n_d: float, v_d: float) -> bool:
    """Whether these are numbers of a resin of high index: it disperses more than glass, and is in no catalogue."""
    return RESIN_N[0] <= n_d <= RESIN_N[1] and LEAST_V <= v_d <= RESIN_V - RESIN_SLOPE * (n_d - RESIN_N[0])


def _misnamed(lens: Lens, indices: list[int]) -> list[Finding]:
    """Of surfaces with one glass, those whose name belongs to another glass."""
    findings = []
    for i in indices:
        glass = lens.surfaces[i].glass
        known = (catalogue.lookup(glass.name) or _other(glass.name)) if glass.name else None
        if known is None or known.v_d is None or glass.v_d is None or (
                abs(known.n_d - glass.n_d) <= NAMED_N and abs(known.v_d / glass.v_d - 1.0) <= NAMED_V):
            continue
        findings.append(Finding(
            Kind.GLASS, i, f"the glass is named {glass.name}, but has n_d {significant(glass.n_d)} and V_d "
                           f"{significant(glass.v_d)}",
            f"{glass.name} of surface {i}: n_d {significant(known.n_d, 6)}, V_d {significant(known.v_d, 4)}"))
    return findings


def _other(name: str) -> Glass | None:
    """The plastic or crystal of `OTHERS` with this name."""
    return next((Glass(*numbers, known) for known, numbers in OTHERS.items()
                 if catalogue.key(known) == catalogue.key(name)), None)


def distance_to_known(n_d: float, v_d: float, glass_only: bool = False) -> float:
    """Steps from the nearest known glass, or plastic."""
    return _nearest(n_d, v_d, glass_only)[1]


def _nearest(n_d: float, v_d: float, glass_only: bool = False) -> tuple[str, float]:
    """The known glass nearest to these numbers, in words, and how many steps it is away."""
    names, n, v, glasses = _map()
    count = glasses if glass_only else len(names)
    away = np.hypot((n[:count] - n_d) / STEP_N, (v[:count] - v_d) / STEP_V)
    nearest = int(np.argmin(away))
    return f"{names[nearest]}, {significant(n[nearest], 5)} and {significant(v[nearest], 3)}", float(away[nearest])


@lru_cache(maxsize=1)
def _map() -> tuple[list[str], np.ndarray, np.ndarray, int]:
    """Names, n_d and V_d of every known glass, then of crystals and plastics; and the number of glasses."""
    entries = sorted((entry for entry in catalogue.entries() if entry.n_d and entry.v_d),
                     key=lambda entry: entry.maker == MISC)
    known = [(entry.name, entry.n_d, entry.v_d) for entry in entries]
    known += [(name, *numbers) for name, numbers in OTHERS.items()]
    names, n, v = zip(*known, strict=True)
    return list(names), np.array(n), np.array(v), sum(entry.maker != MISC for entry in entries)
