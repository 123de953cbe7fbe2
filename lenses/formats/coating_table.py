"""Coatings in the TOML format: the table `coating`, by the number of the surface.

    [coating]
    0 = "multi-layer"                   # or "single-layer", "uncoated"
    2 = { layers = [[1.38, 0.25], [2.05, 0.5], ["matched", 0.25]], wavelength = 0.55 }
    4 = { wavelengths = [0.45, 0.65], angles_deg = [0.0, 40.0], reflectances = [[0.004, 0.01], [0.003, 0.009]] }

A layer is its index and its optical thickness in waves of `wavelength` (µm), from the side of the smaller index on;
"matched" suits the index to the glass. A table has a row for each wavelength and a number for each angle.
"""

from math import degrees, radians

from lensbench.core.optics.coatings import COATINGS, Coating, CoatingError, Layer
from lensbench.core.text import excerpt
from lensbench.lenses.file_error import RowError, number
from lensbench.lenses.formats.toml_header import digits, listed, quoted

MATCHED = "matched"
LAYERS, TABLE = {"layers", "wavelength"}, {"wavelengths", "angles", "angles_deg", "reflectances"}


def read(value: object) -> Coating:
    """A coating from its entry; RowError says what is wrong."""
    if isinstance(value, str):
        if value not in COATINGS:
            raise RowError(f"{excerpt(value)} is no coating: it is one of {', '.join(COATINGS)}, or layers, or a table")
        return COATINGS[value]
    if not isinstance(value, dict) or not (value.keys() <= LAYERS or value.keys() <= TABLE) or not value:
        raise RowError("a coating is a name, or { layers = [[1.38, 0.25]], wavelength = 0.55 }, or { wavelengths = "
                       "[…], angles_deg = […], reflectances = [[…], …] }")
    try:
        if "layers" in value or "wavelength" in value:
            made = Coating(tuple(map(_layer, _list(value.get("layers", []), "layers"))))
            return (Coating(made.layers, number(value["wavelength"], "wavelength")) if "wavelength" in value
                    else made)
        if "angles" in value and "angles_deg" in value:
            raise RowError("give the angles in radians or in degrees, not both")
        angles = (_numbers(value["angles"], "angles") if "angles" in value else
                  tuple(map(radians, _numbers(value.get("angles_deg", [0.0]), "angles_deg"))))
        return Coating(wavelengths=_numbers(value.get("wavelengths"), "wavelengths"), angles=angles,
                       reflectances=tuple(_numbers(row, "reflectances")
                                          for row in _list(value.get("reflectances"), "reflectances")))
    except CoatingError as error:
        raise RowError(str(error).removeprefix("coating: ")) from None


def entry(coating: Coating) -> str:
    """The entry of a coating, that reads back equal."""
    for name, known in COATINGS.items():
        if coating == known:
            return quoted(name)
    if coating.wavelengths:
        rows = ", ".join(map(listed, coating.reflectances))
        exact = all(radians(degrees(angle)) == angle for angle in coating.angles)
        angles = (f"angles_deg = {listed(map(degrees, coating.angles))}" if exact else
                  f"angles = {listed(coating.angles)}")
        return f"{{ wavelengths = {listed(coating.wavelengths)}, {angles}, reflectances = [{rows}] }}"
    layers = ", ".join(f"[{quoted(MATCHED) if index is None else digits(index)}, {digits(waves)}]"
                       for index, waves in coating.layers)
    return f"{{ layers = [{layers}], wavelength = {digits(coating.wavelength)} }}"


def _layer(value: object) -> Layer:
    if not isinstance(value, list) or len(value) != 2:
        raise RowError("a layer is its index and its thickness in waves: [1.38, 0.25]")
    return Layer(None if value[0] == MATCHED else number(value[0], "index"), number(value[1], "thickness"))


def _list(value: object, name: str) -> list:
    if not isinstance(value, list):
        raise RowError(f"{name} must be a list")
    return value


def _numbers(value: object, name: str) -> tuple[float, ...]:
    return tuple(number(each, name) for each in _list(value, name))
