"""System data of a CODE V sequence file (.seq): aperture, fields with vignetting, wavelengths.

    EPD 10                      entrance-pupil diameter; FNO f-number of the image, NAO, NA numerical aperture of the
                                object and of the image
    WL 656.3 587.6 486.1        wavelengths (nm); WTW their weights, REF the number of the primary one
    YAN 0 10 14                 fields by angle; YOB by object height, YIM and YRI by paraxial and real image height; X…
    WTF 1 1 1                   their weights
    VUY 0 0.1 0.2               share of the pupil cut off at +y; VLY at −y, VUX at +x, VLX at −x

For a near object FNO is the f-number at work.
"""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from math import isfinite

from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, SystemData
from lensbench.lenses.tables.aperture import f_number_kind
from lensbench.lenses.tables.design import Design
from lensbench.lenses.tables.text import EXACT, exact

APERTURES = {"EPD": ApertureKind.PUPIL_DIAMETER, "FNO": ApertureKind.F_NUMBER, "NAO": ApertureKind.OBJECT_NA,
             "NA": ApertureKind.IMAGE_NA}
FIELDS = {"AN": FieldKind.ANGLE, "OB": FieldKind.OBJECT_HEIGHT, "IM": FieldKind.IMAGE_HEIGHT,
          "RI": FieldKind.REAL_IMAGE_HEIGHT}
VIGNETTING = ("VUX", "VLX", "VUY", "VLY")
SYSTEM = frozenset((*APERTURES, *(axis + name for axis in "XY" for name in FIELDS), *VIGNETTING, "WL", "WTW", "REF",
                    "WTF"))


def read(design: Design, values: Mapping[str, Sequence[str]]) -> None:
    """Give the design, whose rows are complete, the system data of a file: numbers in text, by command."""
    for key, kind in APERTURES.items():
        if values.get(key):
            design.state_aperture(f_number_kind(design.rows[0].thickness) if key == "FNO" else kind,
                                  float(values[key][0]))
    lengths = [float(Decimal(word).scaleb(-3, EXACT)) for word in values.get("WL", ())]
    weights = [float(word) for word in values.get("WTW", ())]
    reference = float((values.get("REF") or ["1"])[0])
    if lengths:
        design.state_wavelengths([(w, weights[i] if i < len(weights) else 1.0) for i, w in enumerate(lengths)],
                                 int(max(min(reference, 1e6), 0.0)) - 1)
    name = next((name for name in FIELDS if values.get(f"X{name}") or values.get(f"Y{name}")), None)
    if name is None:
        return
    columns = [[float(word) for word in values.get(key, ())] for key in (f"X{name}", f"Y{name}", "WTF", *VIGNETTING)]
    points = []
    for i in range(max(len(columns[0]), len(columns[1]))):
        x, y, weight, *cuts = [column[i] if i < len(column) else float(k == 2) for k, column in enumerate(columns)]
        points += design.field_point(x, y, weight, (cuts[0], cuts[1], cuts[2], cuts[3]))
    design.state_fields(FIELDS[name], points)


def aperture_key(kind: ApertureKind) -> str:
    """Command of an aperture."""
    if kind is ApertureKind.WORKING_F_NUMBER:
        return "FNO"
    return next(key for key, own in APERTURES.items() if own is kind)


def lines(system: SystemData, aperture: Aperture | None) -> list[str]:
    """Lines of the system data; the aperture is of a kind that the format holds, its first value is written."""
    waves = [str(EXACT.normalize(exact(w.micrometres).scaleb(3, EXACT))) for w in system.wavelengths]
    written = [f"WL {' '.join(waves)}", f"WTW {' '.join(repr(w.weight) for w in system.wavelengths)}",
               f"REF {system.primary + 1}"]
    if aperture is not None and isfinite(aperture.values[0]):
        written.append(f"{aperture_key(aperture.kind)} {aperture.values[0]!r}")
    name = next(name for name, kind in FIELDS.items() if kind is system.field_kind)
    columns = {f"X{name}": [p.x for p in system.fields], f"Y{name}": [p.y for p in system.fields],
               "WTF": [p.weight for p in system.fields]}
    if any(any(point.vignetting) for point in system.fields):
        columns |= {key: [point.vignetting[i] for point in system.fields] for i, key in enumerate(VIGNETTING)}
    return written + [" ".join([key, *map(repr, column)]) for key, column in columns.items()]
