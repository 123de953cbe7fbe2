"""What belongs to a lens and is not in its table: water before it, glass before the film, the unit of its lengths."""

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite

from lensbench.core.optics.finding import Change, Kind
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.hypothesis import Hypothesis

WATER = 1.333
PLATE = Glass(1.5168, 64.17)                # window and filters of a sensor
PLATES = (0.2, 6.0)                         # mm: their thickness, in digital cameras and telephones
DIGITAL = 1990                              # before this year there is film, with nothing before it
BEHIND = 8.0                                # mm of air: what a table may leave out behind its last gap
BEHIND_SHARE = 0.4                          # and of the focal length
SAME_FOCAL_LENGTH = 0.005                   # a plate does not change it
SAME_AT_STATIONS = 0.1                      # of the shift of the focus: it is alike at every zoom station
UNITS = {10.0: "centimetres", 25.4: "inches", 1000.0: "metres", 0.1: "millimetres that were read as centimetres",
         1.0 / 25.4: "millimetres that were read as inches", 0.001: "millimetres that were read as metres"}
NORMAL = (1.0, 10.0, 100.0, 1000.0)         # focal lengths that tables are normalised to
SCALE = 0.02                                # between the ratio of focal lengths and the unit


def hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Water or air in front, a plate before the film, another unit."""
    before, after = (1.0, WATER) if lens.front_index == 1.0 else (lens.front_index, 1.0)
    cause = "the lens is immersed in water" if after > 1.0 else "the lens is in air"
    yield Hypothesis(Kind.MEDIUM, Change("front_index", None, before, after), cause,
                     f"front_index {significant(after)} instead of "
                     f"{significant(before)}", replace(lens, front_index=after))
    yield from _plates(lens)
    yield from _scales(lens)


def _plates(lens: Lens) -> Iterator[Hypothesis]:
    """A plane plate in the last gap, or behind it, that explains a wrong back focus and nothing else."""
    fo, last = first_order(lens), lens.surfaces[-1]
    shift, glass = last.thickness - fo.bfl, f"n_d {significant(PLATE.n_d)}"
    if (lens.year and lens.year < DIGITAL) or last.thickness <= 0.0 or not isfinite(shift):
        return
    if lens.stated_efl and not abs(fo.efl / lens.stated_efl - 1.0) <= SAME_FOCAL_LENGTH:
        return
    if not all(abs(other - shift) <= SAME_AT_STATIONS * abs(shift) for other in _shifts(lens)):
        return
    if shift > 0.0:
        thickness = shift / (1.0 - 1.0 / PLATE.n_d)
        if not PLATES[0] <= thickness <= min(PLATES[1], last.thickness):
            return
        space, behind = 0.5 * (last.thickness - thickness), 0.5 * (last.thickness - thickness)
        words = f"a plate of {significant(thickness, 3)} mm ({glass}) in the gap before the film"
    else:
        if -shift > min(BEHIND, BEHIND_SHARE * abs(fo.efl)):
            return
        space, thickness, behind = last.thickness, -0.5 * shift * PLATE.n_d, -0.5 * shift
        words = (f"glass and air behind the last gap that together equal {significant(-shift, 3)} mm of air, such as "
                 f"a plate of up to {significant(-shift * PLATE.n_d, 3)} mm ({glass})")
    if not behind > 0.0:
        return
    rim = last.semi_diameter
    surfaces = (*lens.surfaces[:-1], replace(last, thickness=space), Surface(thickness, rim, PLATE, curvature=0.0),
                Surface(behind, rim, curvature=0.0))
    yield Hypothesis(Kind.COVER_GLASS, Change("cover glass", len(lens.surfaces) - 1, 0.0, thickness),
                     "the cover glass or sensor stack before the film is not in the table", words,
                     replace(lens, surfaces=surfaces, positions=None), 3.0)


def _shifts(lens: Lens) -> list[float]:
    """From the focus to the stored film at every zoom station (mm)."""
    stations = lens.positions.zoom_stations if lens.zooms and lens.positions else ()
    there = [lens.at(zoom=zoom) for zoom in stations]
    return [station.surfaces[-1].thickness - first_order(station).bfl for station in there]


def _scales(lens: Lens) -> Iterator[Hypothesis]:
    """Another unit of all lengths, or a table that is normalised to a round focal length."""
    efl, stated = first_order(lens).efl, lens.stated_efl
    if not stated or not isfinite(efl) or not efl > 0.0:
        return
    ratio = stated / efl
    units = {factor: f"the lengths are {unit}" for factor, unit in UNITS.items()}
    normal = next((f for f in NORMAL if abs(efl / f - 1.0) <= SCALE), None)
    if normal and not any(abs(ratio / factor - 1.0) <= SCALE for factor in units):
        units[ratio] = f"the table is normalised to a focal length of {significant(normal)}"
    for factor, cause in units.items():
        if abs(ratio / factor - 1.0) <= SCALE:
            yield Hypothesis(Kind.SCALE, Change("scale", None, 1.0, factor), cause, f"all lengths × "
                                                                                    f"{significant(factor, 6)}",
                             replace(lens.scaled(factor), stated_efl=stated))
