"""Optiland's lens files (.json): surfaces with a geometry, a place on the axis and the material behind them.

Lengths in mm. The first surface is the object, the last one the image; the gaps
are differences of the places z. EvenAsphere has coefficients of r², r⁴ …,
OddAsphere of r, r², r³ …. Mirrors, tilts, decentres and other geometries are refused.
"""

from math import hypot, inf, isinf
from typing import Any

from lensbench.glass import AIR, Glass
from lensbench.lenses import media
from lensbench.lenses.design import Design, Row
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.json_text import coefficients, item_lines, items, parse, table, value
from lensbench.lenses.rows import RowError, curvature, number
from lensbench.prescription import Lens

APERTURES = {"EPD": "EPD", "imageFNO": "FNO", "objectNA": "NA"}
FIELDS = {"angle": "angle", "object_height": "object", "paraxial_image_height": "image", "real_image_height": "image"}


def read(text: str, path: str) -> Lens:
    """The lens of a file's text; `path` is named in errors. LensFileError: the line and what is wrong."""
    data = parse(text, path)
    surfaces = items(table(data, "surface_group").get("surfaces"))
    if not surfaces:
        raise LensFileError(path, None, "there is no surface_group with surfaces: this is no Optiland lens")
    lines = item_lines(text, "surfaces")
    design = Design(path, name=data["name"] if isinstance(data.get("name"), str) else "")
    places: list[float] = []
    for i, surface in enumerate(surfaces):
        row = Row(lines[i] if i < len(lines) else None)
        try:
            if not isinstance(surface, dict):
                raise RowError("a surface must be an object in braces")
            places.append(_fill(design, row, surface, i, i in (0, len(surfaces) - 1)))
        except RowError as error:
            raise LensFileError(path, row.line, f"surface {i}: {error}") from None
        design.add(row)
    for row, z, after in zip(design.rows, places, places[1:], strict=False):
        row.thickness = inf if isinf(z) or isinf(after) else after - z
    try:
        _system(design, data)
    except RowError as error:
        raise LensFileError(path, None, str(error)) from None
    return design.lens()


def _system(design: Design, data: dict[str, Any]) -> None:
    """Aperture and field."""
    aperture = table(data, "aperture")
    kind = aperture.get("type")
    if kind in APERTURES:
        design.aperture = (APERTURES[kind], value(aperture, "value"))
    elif kind == "float_by_stop_size":
        for row in design.rows:
            if row.is_stop:
                row.semi_diameter = value(aperture, "value") / 2.0
    fields = table(data, "fields")
    points = [table(point) for point in items(fields.get("fields"))]
    sizes = [hypot(value(point, "x", 0.0), value(point, "y", 0.0)) for point in points]
    named = fields.get("field_type") or next((point.get("field_type") for point in points), None)
    if isinstance(named, str) and named in FIELDS and any(sizes):
        design.field_of_view = (FIELDS[named], max(sizes))


def _fill(design: Design, row: Row, surface: dict[str, Any], index: int, is_end: bool) -> float:
    """Fill the row from a surface and return its place on the axis. RowError: not traced."""
    geometry, frame = table(surface, "geometry"), table(surface, "geometry", "cs")
    for key in ("x", "y", "rx", "ry", "rz"):
        if value(frame, key, 0.0):
            raise RowError(f"a {'tilt' if 'r' in key else 'decentre'} (cs.{key}) is not traced")
    z = value(frame, "z", 0.0, infinite=True)
    if surface.get("is_reflective"):
        raise RowError("a mirror (is_reflective) is not traced")
    if not is_end:
        kind = str(surface.get("type") or surface.get("surface_type") or "Surface")
        interaction = str(table(surface, "interaction_model").get("type", ""))
        if "araxial" in kind or "hinLens" in interaction or "iffract" in kind + interaction:
            raise RowError(f"{kind} {interaction} is not traced".replace("  ", " "))
        _shape(row, geometry)
        row.is_stop = bool(surface.get("is_stop"))
        aperture = surface.get("aperture")
        if isinstance(aperture, dict) and aperture.get("r_max") is not None:
            size = value(aperture, "r_max", infinite=True)
            row.semi_diameter = size if 0.0 < size < inf else None
        elif isinstance(aperture, int | float) and not isinstance(aperture, bool):
            row.semi_diameter = number(aperture, "aperture") / 2.0 or None
        elif aperture is not None:
            design.found(f"surface {index}: an aperture that is not round is left out")
    row.glass = _glass(design, table(surface, "material_post")) if surface.get("material_post") else AIR
    return z


def _shape(row: Row, geometry: dict[str, Any]) -> None:
    """Curvature, conic and aspheric terms of a geometry."""
    kind = geometry.get("type")
    if kind == "BiconicGeometry":
        if value(geometry, "conic_x", 0.0) or value(geometry, "conic_y", 0.0):
            raise RowError("a BiconicGeometry with conics is not traced")
        row.curvature = curvature(geometry.get("radius_y"))
        row.curvature_x = curvature(geometry.get("radius_x"))
        return
    if kind not in ("Plane", "StandardGeometry", "EvenAsphere", "OddAsphere"):
        raise RowError(f"the geometry {kind} is not traced")
    row.curvature = curvature(geometry.get("radius", inf))
    row.conic = value(geometry, "conic", 0.0)
    if kind in ("EvenAsphere", "OddAsphere"):
        powers = list(range(2, 21, 2)) if kind == "EvenAsphere" else list(range(1, 21))
        row.aspheric = coefficients(geometry, "coefficients", powers)


def _glass(design: Design, material: dict[str, Any]) -> Glass:
    """The medium of a material."""
    kind = material.get("type")
    if kind == "IdealMaterial":
        return media.model(value(material, "index"), 0.0)
    if kind == "AbbeMaterial":
        return media.model(value(material, "index"), value(material, "abbe"))
    if kind == "Material" and isinstance(material.get("name"), str):
        maker = material.get("reference")
        glass, finding = media.named(material["name"], maker if isinstance(maker, str) else None)
        if finding:
            design.found(finding)
        return glass
    raise RowError("a mirror is not traced" if kind == "Mirror" else f"the material {kind} is not read")
