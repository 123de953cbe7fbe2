"""Writer of CODE V sequence files (.seq); `codev` describes the format.

A glass that no catalogue has is written as n_d:V_d, which CODE V and Optiland read. rayoptics does not, and takes the
private glass whose label is that text.
"""

from dataclasses import replace
from decimal import Decimal
from math import degrees, isinf

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE, Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture
from lensbench.lenses.formats.codev import APERTURES, aperture_key, system_lines
from lensbench.lenses.formats.codev_surfaces import KEYS, TERMS
from lensbench.lenses.glass import catalogue, media
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.axes import angles
from lensbench.lenses.tables.stations import Station, stations_of
from lensbench.lenses.tables.system_text import with_working_f_number, written_system
from lensbench.lenses.tables.text import LONGEST_NAME, is_number

SAMPLES = (0.4046561, 0.4358343, F_LINE, 0.5460740, D_LINE, C_LINE, 0.7065188)      # µm: h, g, F, e, d, C, r


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .seq file, and findings about what it cannot hold, other than shapes."""
    stations, remarks = stations_of(lens)
    lens = lens.at(zoom=0.0, close=0.0)
    pivots = [i for i, surface in enumerate(lens.surfaces) if surface.pose is not None and any(
        min(i, i - surface.pose.pivot) <= gap < max(i, i - surface.pose.pivot) for gap in stations[0].gaps)] \
        if stations else []
    if pivots:
        stations, remarks = [], [note(Kind.POSITION, f"its zoom and focus positions are left out: surface {pivots[0]} "
                                                     "is tilted about another one, and the gap between them varies",
                                      pivots[0])]
    title = _short(lens.name)
    blank = " " if title.startswith("Z") else ""        # rayoptics takes a word Z… for a zoom position
    private = _private_glasses(lens)
    kept = replace(lens, surfaces=tuple(replace(s, aspheric=tuple((power, a) for power, a in s.aspheric if power > 2))
                                        for s in lens.surfaces))        # without the r² terms, which bend the rays
    system = written_system(kept, stations, with_working_f_number(APERTURES.values()))
    remarks += system.findings
    distance = system.data.object_distances[0]
    lines = ["RDM N; LEN", *([f"TITLE '{blank}{title}'"] if title else []), "DIM M",
             *system_lines(system.data, system.aperture), *_private_lines(private), *_model_lines(lens, private),
             f"SO 0.0 {'0.1e14' if isinf(distance) else repr(distance)}"]
    by_numbers: list[int] = []
    for i, s in enumerate(lens.surfaces):
        glass = s.glass
        words = [f"S {s.curvature!r} {s.thickness!r}"]
        if glass in private:
            words.append(f"'{private[glass]}'")
        elif glass.n_d != 1.0:
            maker = media.maker_of(glass)
            words.append(f"{catalogue.key(glass.name)}_{maker}" if maker else _code(glass))
            if glass.name and not maker:
                words.append(f"! {' '.join(glass.name.split())[:LONGEST_NAME]}")
                by_numbers.append(i)
        lines.append(" ".join(words))
        lines += ["  STO"] if i == lens.stop_index else []
        if s.curvature_x is not None:
            lines += ["  AAS", f"  CUX {s.curvature_x!r}"]
        lines.append(f"  CIR {s.semi_diameter!r}")
        if (frame := lens.frames[i]) is not None:
            moved, (a, b, c) = lens.vertex(i) - [0.0, 0.0, lens.vertices[i]], angles(frame.rotation)
            values = [*moved.tolist(), -degrees(a), -degrees(b), degrees(c)]
            lines += [*(f"  {key} {value!r}" for key, value in zip(KEYS, values, strict=True)), "  DAR"]
        letters = {power: letter for letter, power in TERMS.items()}
        if s.aspheric:
            lines += ["  ASP", f"  K {s.conic!r}"]
            lines += [f"  {letters[power]} {a!r}" for power, a in s.aspheric if power in letters]
        elif s.conic:
            lines += ["  CON", f"  K {s.conic!r}"]
        if glass not in private:
            remarks += media.glass_loss(glass, i, with_maker=True)
    lines += ["SI 0.0 0.0", *_zoom_lines(lens, stations, system.aperture), "GO", ""]
    if by_numbers:
        of = f"surface {by_numbers[0]}" if len(by_numbers) == 1 else f"surfaces {', '.join(map(str, by_numbers))}"
        remarks.append(note(Kind.GLASS, f"{of}: known by n_d and V_d, and not as a catalogue has it, the glass is "
                                        "written by these numbers, its name as a comment",
                            by_numbers[0] if len(by_numbers) == 1 else None))
    if title != lens.name:
        remarks.append(note(Kind.TEXT, "the name is written in one short line, without quotes"))
    remarks += configurations.lost_positions(stations, _short)
    return "\n".join(lines), remarks


def _zoom_lines(lens: Lens, stations: list[Station], aperture: Aperture | None) -> list[str]:
    """Lines of the zoom positions: their number, their names, and the values of each quantity."""
    if not stations:
        return []
    lines = [f"ZOO {len(stations)}"]
    if any(station.name for station in stations):
        lines += ["ZOO TIT", *(f"TIT Z{k} '{_short(s.name)}'" for k, s in enumerate(stations, start=1))]
    for quantity, surface, values in configurations.rows(lens, stations, 1e13, aperture):
        name = f"ZOO {'CIR' if quantity == 'stop' else 'THI'} S{surface or 'O'}"
        if quantity == "aperture" and aperture is not None:
            name = f"ZOO {aperture_key(aperture.kind)}"
        lines.append(_cut(name, [repr(value) for value in values]))
    return lines


def _short(text: str) -> str:
    return " ".join(text.replace("'", " ").split())[:LONGEST_NAME].strip()


def _private_glasses(lens: Lens) -> dict[Glass, str]:
    """Glasses given as tables of indices, each with a unique name under which a reader finds it."""
    names: dict[Glass, str] = {}
    for glass in dict.fromkeys(surface.glass for surface in lens.surfaces):
        name = _short(glass.name)
        if media.is_plain_table(glass) and name == glass.name != "" and not is_number(name) and not media.code(name) \
                and name.upper() not in {*media.MIRROR_NAMES, *(other.upper() for other in names.values())}:
            names[glass] = name
    return names


def _private_lines(names: dict[Glass, str]) -> list[str]:
    """A block PRV … END for each table: wavelengths (nm) with all digits, and indices."""
    lines: list[str] = []
    for glass, name in names.items():
        wavelengths = [str(Decimal(repr(w)).scaleb(3)) for w, _ in glass.coefficients]
        indices = [repr(n) for _, n in glass.coefficients]
        lines += ["PRV", _cut("PWL", wavelengths), _cut(f"'{name}'", indices), "END"]
    return lines


def _code(glass: Glass) -> str:
    """A glass by n_d and V_d, 0 for an unknown one."""
    return f"{glass.n_d!r}:{glass.v_d or 0.0!r}"


def _model_lines(lens: Lens, private: dict[Glass, str]) -> list[str]:
    """A block PRV … END for the glasses that are written as n_d:V_d, with their indices at a few lines."""
    models = dict.fromkeys(_code(s.glass) for s in lens.surfaces
                           if s.glass.n_d != 1.0 and s.glass not in private and not media.maker_of(s.glass))
    if not models:
        return []
    lines = ["PRV", _cut("PWL", [str(Decimal(repr(w)).scaleb(3).normalize()) for w in SAMPLES])]
    for code in models:
        n_d, v_d = map(float, code.split(":"))
        glass = Glass(n_d, v_d or None)
        lines.append(_cut(f"'{code}'", [f"{glass.index(w)!r}" for w in SAMPLES]))
    return [*lines, "END"]


def _cut(name: str, words: list[str]) -> str:
    """Lines of a command of many values, four on a line."""
    rows = [" ".join(words[k:k + 4]) for k in range(0, len(words), 4)]
    return " &\n ".join([f"{name} {rows[0]}", *rows[1:]])
