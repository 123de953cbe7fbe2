"""A radius with more digits than a table prints: a program solved for it, which hides a mistake in another number."""

from lensbench.kernels.figures import significant
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.prescription import Lens

PUBLISHED = 5           # significant digits of a printed radius
SOLVED = 9              # significant digits of a radius left by a solve
SINGLE = 6e-8           # relative: digits beyond it are the noise of a float32
DOUBLE = 1e-12


def digit_findings(lens: Lens) -> list[Finding]:
    """The one radius with many digits among radii with few, unless a solve or pickup of the file sets it."""
    radii = {i: 1.0 / s.curvature for i, s in enumerate(lens.surfaces) if s.curvature}
    long = [i for i, radius in radii.items() if _digits(radius, SINGLE) > PUBLISHED + 1]
    rest = [_digits(radius, SINGLE) for i, radius in radii.items() if i not in long]
    if len(long) != 1 or len(rest) < 3 or max(rest) > PUBLISHED or _digits(radii[long[0]], DOUBLE) < SOLVED:
        return []
    if any(found.kind is Kind.RULE and found.surface == long[0] for found in lens.findings):
        return []
    return [Finding(Kind.SOLVED_RADIUS, long[0],
                    f"radius {significant(radii[long[0]], 10)} mm has many digits where no other has more than "
                    f"{max(rest)}: it was solved for, to focus the lens, and is not that of the source; another number "
                    "may be wrong")]


def _digits(value: float, tolerance: float) -> int:
    """Number of significant decimal digits that give a value to a relative tolerance."""
    return next(digits for digits in range(1, 18) if abs(float(f"{value:.{digits}g}") - value) <= tolerance * abs(value)
                or digits == 17)
