"""LensHH files (.lhlt): JSON with a list of surfaces from the object to the image, and the system data.

    {"FormatVersion": 1, "Title": "…", "Designer": "…", "Aperture": {"Type": "EPD", "Value": 8.1},
     "FieldType": "ObjectAngle", "Fields": [{"Y": 2, "Weight": 1}], "GlassCatalogs": ["SCHOTT"],
     "Wavelengths": [{"Value": 0.5876, "Weight": 1, "IsPrimary": true}],
     "Surfaces": [{"Type": "Standard", "Radius": "Infinity", "Thickness": "Infinity", "Material": ""}, …]}

Lengths in mm. An EvenAsphere has AsphericCoefficients of r², r⁴, r⁶ …; a SemiDiameter of 0 is not known. The
configurations of ConfigurationEditor are zoom positions: thicknesses are read, of other values those of the first.
"""

import re
from dataclasses import replace
from math import inf
from typing import Any

from lensbench.core.optics.finding import Kind, Severity
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import ApertureKind, FieldKind
from lensbench.lenses.file_error import RowError, located, number
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.paraxial import FAR
from lensbench.lenses.tables.row_solves import RowSolve
from lensbench.lenses.tables.rows import curvature
from lensbench.lenses.tables.stations import Configurations
from lensbench.lenses.tables.text import (
    check_keys, coefficients, flag, item_lines, items, parse, table, text_value, value
)

APERTURES = {"epd": ApertureKind.PUPIL_DIAMETER, "fnumber": ApertureKind.F_NUMBER,
             "workingfnumber": ApertureKind.WORKING_F_NUMBER, "objectspacena": ApertureKind.OBJECT_NA}
FIELDS = {"objectangle": FieldKind.ANGLE, "objectheight": FieldKind.OBJECT_HEIGHT,
          "paraxialimageheight": FieldKind.IMAGE_HEIGHT, "imageheight": FieldKind.IMAGE_HEIGHT,
          "realimageheight": FieldKind.REAL_IMAGE_HEIGHT}
POWERS = list(range(2, 21, 2))
PARAMETERS = {"curvature": "curvature", "thickness": "thickness", "conic": "conic"}         # of pickups
READ = frozenset({"Title", "Notes", "Designer", "Aperture", "FieldType", "Fields", "GlassCatalogs", "Wavelengths",
                  "Surfaces", "Pickups", "ConfigurationEditor", "IsAfocal", "TelecentricObjectSpace"})
READ_OF_SURFACES = frozenset({
    "Type", "Radius", "Thickness", "Material", "SemiDiameter", "ClearAperturePercent", "Conic", "IsStop", "InnerRadius",
    "ObscurationRadius", "FloatingApertureRadius", "AsphericCoefficients", "HasMarginalRaySolve", "ModelIndexEnabled",
    "ModelNd", "ModelVd", "ModelDPgF"})
# Version, aiming of rays, optimisation; labels, how a rim was found, the focal length of an ideal lens
HARMLESS = frozenset({"FormatVersion", "RayAiming", "PenalizeVignetting", "UseAutomaticVignettingFactors",
                      "MeritFunction", "GlassSubstitutions"})
HARMLESS_OF_SURFACES = frozenset({"Index", "Comment", "SemiDiameterMode", "FocalLength"})
VARIABLE = re.compile(r"\w*(Variable|Min|Max)")         # of an optimisation
ASIDE = {"IsAfocal": "afocal image space", "TelecentricObjectSpace": "telecentric in the object's space"}


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    data, lines = parse(text, path), item_lines(text, "Surfaces")
    design = Design(path, name=text_value(data, "Title"), notes=text_value(data, "Notes"))
    makers = [str(name).upper() for name in items(data.get("GlassCatalogs"))]
    surfaces = [table(surface) for surface in items(data.get("Surfaces"))]
    with located(path, None):
        check_keys(data, READ | HARMLESS)
    for i, surface in enumerate(surfaces):
        with design.row(i, lines) as row:
            _fill(design, row, surface, makers, 0 < i < len(surfaces) - 1)
    with located(path, None):
        _system(design, data)
        _pickups(design, [table(pickup) for pickup in items(data.get("Pickups"))])
        _configurations(design, table(data, "ConfigurationEditor"))
    for key, what in ASIDE.items():
        if flag(data, key):
            design.found(Kind.LEFT_OUT, f"{what} ({key}) is left out")
    return replace(design.lens(), designer=text_value(data, "Designer"))


def _fill(design: Design, row: Row, data: dict[str, Any], makers: list[str], traced: bool) -> None:
    """Fill the row from a surface. traced: it is neither the object nor the image. RowError: not traced."""
    kind = text_value(data, "Type") or "Standard"
    check_keys(data, READ_OF_SURFACES | HARMLESS_OF_SURFACES | set(filter(VARIABLE.fullmatch, data)))
    if traced and kind not in ("Standard", "EvenAsphere"):
        raise RowError(f"the type {kind[:30]} is not traced: it must be Standard or EvenAsphere")
    row.curvature = curvature(data.get("Radius", inf))
    row.conic = value(data, "Conic", 0.0)
    row.thickness = value(data, "Thickness", 0.0, infinite=True)
    floating = value(data, "FloatingApertureRadius", 0.0, infinite=True)
    row.semi_diameter = (floating if 0.0 < floating < inf else value(data, "SemiDiameter", 0.0) *
                         value(data, "ClearAperturePercent", 100.0) / 100.0) or None
    if flag(data, "HasMarginalRaySolve"):
        design.checked.append(RowSolve(len(design.rows), "thickness", "axial height", 0.0, "HasMarginalRaySolve"))
    row.is_stop = flag(data, "IsStop")
    if flag(data, "ModelIndexEnabled"):
        row.glass = media.stated(text_value(data, "Material"), value(data, "ModelNd"), value(data, "ModelVd", 0.0))
        if value(data, "ModelDPgF", 0.0):
            design.found(Kind.GLASS, "the deviation of a model glass from the normal line of partial dispersion "
                                     "(ModelDPgF) is left out", len(design.rows) - 1)
    else:
        row.glass = _medium(design, text_value(data, "Material"), makers)
    if kind == "EvenAsphere":
        row.aspheric = coefficients(data, "AsphericCoefficients", POWERS)
    if value(data, "InnerRadius", 0.0) or value(data, "ObscurationRadius", 0.0):
        design.found(Kind.LEFT_OUT, "an obscuration is left out: the whole circle is used",
                     len(design.rows) - 1, severity=Severity.WARNING)


def _medium(design: Design, name: str, makers: list[str]) -> Glass:
    """The medium of a name, of the first of the file's catalogues that has it."""
    return media.code(name) or media.glass_in(design, name, media.maker_among(name, makers))


def _pickups(design: Design, pickups: list[dict[str, Any]]) -> None:
    """Keep the pickups, whose values the file states, for a check. RowError: a surface that does not exist."""
    for pickup in pickups:
        kind = text_value(pickup, "Parameter")
        row, source = (int(value(pickup, f"{side}SurfaceIndex", 0.0)) for side in ("Target", "Source"))
        if not 0 <= source < row < len(design.rows):
            raise RowError(f"a pickup of surface {row} from surface {source}, which does not come before")
        if row < len(design.rows) - 1:
            quantity = PARAMETERS.get(kind.lower())
            design.checked.append(RowSolve(row, quantity or "thickness", "pickup" if quantity else "other",
                                           value(pickup, "Offset", 0.0), f"pickup of {kind[:30]}", source,
                                           value(pickup, "ScaleFactor", 1.0)))


def _system(design: Design, data: dict[str, Any]) -> None:
    """Aperture, fields and wavelengths."""
    aperture = table(data, "Aperture")
    check_keys(aperture, ("Type", "Value"), " of the Aperture")
    kind, size = text_value(aperture, "Type") or "EPD", value(aperture, "Value", 0.0)     # what is usual is left out
    if aperture and kind.lower() in APERTURES:
        design.state_aperture(APERTURES[kind.lower()], size)
    elif aperture:
        design.found(Kind.LEFT_OUT, f"an aperture of the type {kind[:30] or 'unknown'} is left out")
    kind = text_value(data, "FieldType") or "ObjectAngle"
    points = [table(point) for point in items(data.get("Fields"))]
    for point in points:
        check_keys(point, {"X", "Y", "Weight", *filter(VARIABLE.fullmatch, point)}, " of a field")
    if points and kind.lower() in FIELDS:
        design.state_fields(FIELDS[kind.lower()], [made for point in points for made in design.field_point(
            value(point, "X", 0.0), value(point, "Y", 0.0), value(point, "Weight", 1.0))])
    elif points:
        design.found(Kind.LEFT_OUT, f"fields of the type {kind[:30] or 'unknown'} are left out")
    waves = [table(wave) for wave in items(data.get("Wavelengths"))]
    for wave in waves:
        check_keys(wave, ("Value", "Weight", "IsPrimary"), " of a wavelength")
    design.state_wavelengths([(value(wave, "Value"), value(wave, "Weight", 1.0)) for wave in waves],
                             next((i for i, wave in enumerate(waves) if flag(wave, "IsPrimary")), 0))


def _configurations(design: Design, editor: dict[str, Any]) -> None:
    """Thicknesses of the configurations, as zoom positions."""
    operands = [table(operand) for operand in items(editor.get("Operands"))]
    columns = [items(table(column).get("Values")) for column in items(editor.get("Configurations"))]
    if len(columns) < 2 or not operands:
        return
    listed = Configurations(len(columns), current=int(value(editor, "ActiveConfiguration", 0.0)) + 1)
    for i, operand in enumerate(operands):
        kind, surface = text_value(operand, "Type"), int(value(operand, "SurfaceIndex", 0.0))
        for k, column in enumerate(columns, start=1):
            if i >= len(column):
                raise RowError(f"configuration {k} has {len(column)} values for {len(operands)} operands")
            setting = number(column[i], "a value of a configuration", infinite=True)
            if kind.lower().startswith("thi"):
                listed.put("gap", surface, k, setting)
            else:
                listed.differs(kind[:30], str(setting))
    listed.check()
    design.findings += listed.findings()
    distance = design.rows[0].thickness if design.rows else inf
    design.stations = listed.stations(lambda surface: surface if 0 < surface < len(design.rows) - 1 else None, None,
                                      inf if abs(distance) >= FAR else distance)
