"""Writer of OSLO lens files (.len); `oslo` describes the format."""

import re
from dataclasses import replace
from math import isinf

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture, ApertureKind, FieldPoint
from lensbench.core.text import significant
from lensbench.lenses.formats.oslo import APERTURES, FIELDS, LEAST_ABBE, POWERS, TERMS, beam_share
from lensbench.lenses.glass import media
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.paraxial import reference_wavelength
from lensbench.lenses.tables.rows import radius_text
from lensbench.lenses.tables.stations import Station, placed, stations_of
from lensbench.lenses.tables.system_text import WrittenSystem, with_working_f_number, written_system
from lensbench.lenses.tables.text import LONGEST_NAME, is_number


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .len file, and findings about what it cannot hold, other than shapes."""
    stations, remarks = stations_of(lens)
    lens = lens.at(zoom=0.0, close=0.0)
    words = [word for word in lens.name.replace('"', " ").replace("\\", " ").split() if not is_number(word)]
    name = " ".join(words)[:LONGEST_NAME].strip()
    system = written_system(lens, stations, with_working_f_number(APERTURES.values()))
    remarks += system.findings
    distance = system.data.object_distances[0]
    system = _with_beams(system, lens, stations)
    lines = ["// OSLO 6.6", f'LEN NEW "{name}" {lens.stated_efl or 100.0!r} {len(lens.surfaces) + 1}',
             *_system_lines(system, remarks), "UNI 1.0", "// SRF 0", "AIR",
             f"TH {'1.0e20' if isinf(distance) else repr(distance)}"]
    for i, s in enumerate(lens.surfaces):
        lines.append(f"NXT  // SRF {i + 1}")
        lines.append(_glass_line(s.glass, i, remarks))
        lines += _shape_lines(s)
        lines += [f"TH {s.thickness!r}", f"AP {s.semi_diameter!r}"]
        lines += ["AST"] if i == lens.stop_index else []
    lines += [f"NXT  // SRF {len(lens.surfaces) + 1}", "AIR",
              *_wavelength_lines(system, bool(lens.system.wavelengths), remarks),
              *_configuration_lines(lens, stations, system.aperture), f"END {len(lens.surfaces) + 1}", ""]
    if name != lens.name:
        remarks.append(note(Kind.TEXT, "the name is written short, without quotes and without words that are numbers, "
                                       "as OSLO needs it"))
    remarks += configurations.lost_positions(stations, lambda text: "")
    return "\n".join(lines), remarks


def _with_beams(system: WrittenSystem, lens: Lens, stations: list[Station]) -> WrittenSystem:
    """The system data with twice the radius of the entrance beam instead of the diameter of the entrance pupil."""
    aperture = system.aperture
    if aperture is None or aperture.kind is not ApertureKind.PUPIL_DIAMETER:
        return system
    wavelength = reference_wavelength(lens.surfaces, system.data)
    shares = [beam_share(placed(lens.surfaces, station), lens.stop_index, station.distance, wavelength)
              for station in stations or [Station({}, system.data.object_distances[0])]]
    values = aperture.values if len(aperture.values) == len(shares) else aperture.values[:1] * len(shares)
    beams = tuple(value * share for value, share in zip(values, shares, strict=True))
    return replace(system, aperture=replace(aperture, values=beams if len(set(beams)) > 1 else beams[:1]))


def _system_lines(system: WrittenSystem, remarks: list[Finding]) -> list[str]:
    """Lines of the aperture and the largest field; what is lost is added to `remarks`."""
    lines = [_aperture_line(system.aperture.kind, system.aperture.values[0])] if system.aperture else []
    data = system.data
    key = next((key for key, kind in FIELDS.items() if kind is data.field_kind), None)
    if key is None:
        remarks.append(note(Kind.LEFT_OUT, f"left out of its system data: the fields by {data.field_kind}"))
        return lines
    if data.fields != (FieldPoint(0.0, data.fields[0].y),):
        remarks.append(note(Kind.LEFT_OUT, "of its fields the largest alone is written, as if it lay along y, without "
                                           "weight and vignetting"))
        return [*lines, f"{key} {data.largest_field!r}"]
    return [*lines, f"{key} {data.fields[0].y!r}"]


def _aperture_line(kind: ApertureKind, value: float) -> str:
    """Line of an aperture; EBR is a radius."""
    key = next((key for key, own in APERTURES.items() if own is kind), "FNO")
    return f"{key} {value / 2.0 if key == 'EBR' else value!r}"


def _wavelength_lines(system: WrittenSystem, is_stated: bool, remarks: list[Finding]) -> list[str]:
    """Lines of the wavelengths, the primary one first; a finding about another order is added to `remarks`."""
    waves = list(system.data.wavelengths)
    waves.insert(0, waves.pop(system.data.primary))
    if is_stated and system.data.primary:
        remarks.append(note(Kind.TEXT, "its wavelengths are written in another order: the primary one first"))
    return [f"WV {' '.join(repr(wave.micrometres) for wave in waves)}",
            f"WW {' '.join(repr(wave.weight) for wave in waves)}"]


def _configuration_lines(lens: Lens, stations: list[Station], aperture: Aperture | None) -> list[str]:
    """Lines of the differences in the configurations from the second on."""
    rows = configurations.rows(lens, stations, 1e20, aperture)
    lines = []
    for k in range(1, len(stations)):
        lines.append(f"CFG {k + 1}")
        for quantity, i, values in rows:
            if quantity == "aperture" and aperture is not None:
                lines.append(_aperture_line(aperture.kind, values[k]))
            else:
                lines.append(f"{'AP' if quantity == 'stop' else 'TH'} {i} {values[k]!r}")
    return lines


def _glass_line(glass: Glass, i: int, remarks: list[Finding]) -> str:
    """Line of the medium behind surface i; findings about its losses are added to `remarks`."""
    remarks += media.glass_loss(glass, i)
    if glass.n_d == 1.0:
        return "AIR"
    if media.is_known(glass):
        return f"GLA {glass.name}"
    label = re.sub(r'[\s";/]+', "_", glass.name.strip())[:LONGEST_NAME]
    if is_number(label or "G") or label != glass.name:
        remarks.append(note(Kind.GLASS, f"the glass {glass.name!r} is written as G{label}", i))
        label = f"G{label}"
    if glass.v_d and glass.v_d <= LEAST_ABBE:
        remarks.append(note(Kind.GLASS, f"surface {i}: an Abbe number of {significant(glass.v_d)} is left out, it "
                                        f"would be read as an index", i, v_d=glass.v_d))
    dispersion = f" {glass.v_d!r}" if glass.v_d and glass.v_d > LEAST_ABBE else ""
    return f"GLA MOD {label} {glass.n_d!r}{dispersion}"


def _shape_lines(s: Surface) -> list[str]:
    """The lines of curvature, conic and aspheric terms of a surface."""
    lines = [f"RD {radius_text(s.curvature)}"] if s.curvature else []
    lines += [f"CVX {s.curvature_x!r}"] if s.curvature_x is not None else []
    lines += [f"CC {s.conic!r}"] if s.conic else []
    terms = dict(s.aspheric)
    if set(terms) <= set(TERMS.values()):
        return lines + [f"{key} {terms[power]!r}" for key, power in TERMS.items() if power in terms]
    kind = "ARA" if any(power % 2 for power in terms) else "ASR"
    lines.append(f"ASP {kind} {max(terms) // POWERS[kind]}")
    return lines + [f"AS{power // POWERS[kind]} {a!r}" for power, a in terms.items()]
