"""Optiland's lens files (.json): surfaces with a geometry, a place on the axis and the material behind them.

Lengths in mm. The first surface is the object, the last one the image. Gaps are
differences of the positions z; the writer gives z all the digits of the sum of the
gaps. EvenAsphere has coefficients of r², r⁴ …, OddAsphere of r, r², r³ ….
BiconicGeometry adds the arcs of its two sections; ToroidalGeometry rotates the arc
of y–z about an axis along y. Both are cylinders if one section is straight.
Mirrors, tilts, decentres and other geometries are refused.
"""

import re
from decimal import Decimal
from math import inf, isinf
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, Severity, note
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind
from lensbench.core.text import excerpt
from lensbench.lenses.file_error import LensFileError, RowError, located, number
from lensbench.lenses.glass import catalogue, media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.row_solves import RowSolve
from lensbench.lenses.tables.rows import curvature, radius_text
from lensbench.lenses.tables.system_text import WrittenSystem, written_system
from lensbench.lenses.tables.text import (
    EXACT, check_keys, coefficients, exact, exact_value, flag, item_lines, items, parse, table, text_of, text_value,
    value
)

APERTURES = {"EPD": ApertureKind.PUPIL_DIAMETER, "imageFNO": ApertureKind.F_NUMBER,
             "objectNA": ApertureKind.OBJECT_NA, "float_by_stop_size": ApertureKind.STOP_SIZE}
FIELDS = {"angle": FieldKind.ANGLE, "object_height": FieldKind.OBJECT_HEIGHT,
          "paraxial_image_height": FieldKind.IMAGE_HEIGHT, "real_image_height": FieldKind.REAL_IMAGE_HEIGHT,
          "AngleField": FieldKind.ANGLE, "ObjectHeightField": FieldKind.OBJECT_HEIGHT,
          "ParaxialImageHeightField": FieldKind.IMAGE_HEIGHT, "RealImageHeightField": FieldKind.REAL_IMAGE_HEIGHT}
TELECENTRIC = ("telecentric", "object_space_telecentric")
UNITS = {"nm": -3, "um": 0, "mm": 3, "cm": 4, "m": 6}          # powers of ten, in µm
FRAME = frozenset({"x", "y", "z", "rx", "ry", "rz"})
MATERIAL = frozenset({"type", "name", "index", "abbe", "catalog", "reference", "filename", "propagation_model"})
# By object: versions and drawing; what repeats the neighbours; numerics of rays; how a name is looked up
READ = {
    "": ({"name", "aperture", "fields", "wavelengths", "pickups", "solves", "surface_group"},
         {"version", "ray_tracer"}),
    "surface": ({"type", "surface_type", "geometry", "material_post", "is_stop", "aperture", "is_reflective",
                 "interaction_model", "coating", "bsdf"}, {"thickness", "material_pre", "comment"}),
    "interaction_model": ({"type", "interaction_type", "is_reflective", "coating", "bsdf"}, set()),
    "geometry": ({"type", "cs", "radius", "conic", "coefficients", "radius_x", "radius_y", "conic_x", "conic_y",
                  "conic_yz", "coeffs_poly_y"}, {"tol", "max_iter", "geometry_type"}),
    "cs": (FRAME, set()),
    "material": (MATERIAL, {"absorp", "model", "match_policy", "robust_search", "min_wavelength", "max_wavelength",
                            "bounds"}),
    "aperture": ({"type", "value", "object_space_telecentric"}, set()),
    "fields": ({"fields", "field_type", "field_definition", "telecentric", "object_space_telecentric"}, set()),
    "field": ({"x", "y", "vx", "vy", "weight", "field_type"}, set()),
    "wavelengths": ({"wavelengths"}, {"polarization"}),
    "wavelength": ({"value", "unit", "weight", "is_primary"}, set()),
}
SOLVES = {"MarginalRayHeight": ("thickness", "axial height", -1), "ChiefRayHeight": ("thickness", "chief height", -1),
          "MarginalRayAngle": ("curvature", "axial slope", 0), "ChiefRayAngle": ("curvature", "chief slope", 0)}
OTHER = ("thickness", "other", -1)
PLAIN_INTERACTION = ("", "RefractiveReflectiveModel")


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    data = parse(text, path)
    surfaces = items(table(data, "surface_group").get("surfaces"))
    if not surfaces:
        raise LensFileError(path, None, "there is no surface_group with surfaces: this is no Optiland lens")
    with located(path, None):
        _check(data, "")
    lines = item_lines(text, "surfaces")
    design = Design(path, name=text_value(data, "name"))
    vertices: list[Decimal] = []
    for i, surface in enumerate(surfaces):
        with design.row(i, lines) as row:
            if not isinstance(surface, dict):
                raise RowError("a surface must be an object in braces")
            vertices.append(_fill(design, row, surface, i, i in (0, len(surfaces) - 1)))
    for row, z, after in zip(design.rows, vertices, vertices[1:], strict=False):
        row.thickness = float(EXACT.subtract(after, z)) if z.is_finite() and after.is_finite() else inf
    with located(path, None):
        _system(design, data)
        _solves(design, data)
    return design.lens()


def _check(data: dict[str, Any], name: str) -> None:
    """Raise RowError for an entry of an object that is neither read nor harmless. name: of the object in READ."""
    check_keys(data, set().union(*READ[name]), f" of the {name}" if name else "")


def _solves(design: Design, data: dict[str, Any]) -> None:
    """Keep the pickups and solves, whose values the file states, for a check."""
    last = len(design.rows) - 2
    for entry in map(table, items(data.get("pickups"))):
        kind = text_value(entry, "attr_type")
        row, source = (int(value(entry, f"{side}_surface_idx", -1.0)) for side in ("target", "source"))
        factor, offset = value(entry, "scale", 1.0), value(entry, "offset", 0.0)
        known = kind in ("thickness", "conic") or (kind == "radius" and factor and not offset)
        if 0 < row <= last and 0 <= source <= last:
            quantity = "curvature" if kind == "radius" else kind if known else "thickness"
            design.checked.append(RowSolve(
                row, quantity, "pickup" if known else "other", offset, f"pickup of {kind[:30]}", source,
                1.0 / factor if kind == "radius" and known else factor))
    for entry in map(table, items(table(data, "solves").get("solves"))):
        kind = text_value(entry, "type")
        quantity, rule, shift = next((SOLVES[name] for name in SOLVES if kind.startswith(name)), OTHER)
        row = int(value(entry, "surface_idx", last + 1.0)) + shift
        if 0 < row <= last:
            design.checked.append(RowSolve(row, quantity, rule, value(entry, "height", value(entry, "angle", 0.0)),
                                           kind[:40] or "solve"))


def _system(design: Design, data: dict[str, Any]) -> None:
    """Aperture, fields and wavelengths."""
    aperture, kind = table(data, "aperture"), text_value(table(data, "aperture"), "type")
    _check(aperture, "aperture")
    _check(table(data, "wavelengths"), "wavelengths")
    _check(table(data, "fields"), "fields")
    if kind in APERTURES:
        size = value(aperture, "value")
        design.state_aperture(APERTURES[kind], size / 2.0 if kind == "float_by_stop_size" else size)
    elif aperture:
        design.found(Kind.LEFT_OUT, f"the aperture {excerpt(aperture.get('type'), 40)} is left out",
                     severity=Severity.WARNING)
    if any(flag(table(data, section), key) for section in ("aperture", "fields") for key in TELECENTRIC):
        design.found(Kind.LEFT_OUT, "telecentric in the object's space: left out")
    fields = table(data, "fields")
    points = [table(point) for point in items(fields.get("fields"))]
    named = fields.get("field_type") or table(fields, "field_definition").get("field_type") or next(
        (point.get("field_type") for point in points), None)
    if isinstance(named, str) and named in FIELDS:
        made = []
        for point in points:
            _check(point, "field")
            vx, vy = (value(point, name, 0.0) for name in ("vx", "vy"))
            made += design.field_point(value(point, "x", 0.0), value(point, "y", 0.0), value(point, "weight", 1.0),
                                       (vx, vx, vy, vy))
        design.state_fields(FIELDS[named], made)
    elif points:
        design.found(Kind.LEFT_OUT, f"the fields of the type {str(named)[:40]} are left out")
    waves = [table(wave) for wave in items(table(data, "wavelengths").get("wavelengths"))]
    pairs = []
    for wave in waves:
        _check(wave, "wavelength")
        unit = str(wave.get("unit") or "um")
        if unit not in UNITS:
            raise RowError(f"a wavelength in {excerpt(unit)}: it must be in {', '.join(UNITS)}")
        micrometres = float(exact_value(wave, "value").scaleb(UNITS[unit], EXACT))
        pairs.append((micrometres, value(wave, "weight", 1.0)))
    if pairs:
        design.state_wavelengths(pairs, next((i for i, wave in enumerate(waves) if flag(wave, "is_primary")), 0))


def _fill(design: Design, row: Row, surface: dict[str, Any], index: int, is_end: bool) -> Decimal:
    """Fill the row from a surface and return its place on the axis. RowError: not traced."""
    geometry, frame = table(surface, "geometry"), table(surface, "geometry", "cs")
    interaction = table(surface, "interaction_model")
    for key in ("x", "y", "rx", "ry", "rz"):
        if value(frame, key, 0.0):
            raise RowError(f"a {'tilt' if 'r' in key else 'decentre'} (cs.{key}) is not read from this format")
    z = exact_value(frame, "z", 0.0, infinite=True)
    for key in ("coating", "bsdf"):
        if surface.get(key) or interaction.get(key):
            design.found(Kind.LEFT_OUT, f"surface {index}: its {key} is left out", index - 1)
    if flag(surface, "is_reflective") or flag(interaction, "is_reflective"):
        raise RowError("a mirror (is_reflective) is not traced")
    if is_end:
        row.curvature = curvature(geometry.get("radius", inf))
    else:
        kind = str(surface.get("type") or surface.get("surface_type") or "Surface")
        effect = str(interaction.get("type") or interaction.get("interaction_type") or "")
        if "araxial" in kind or "iffract" in kind or effect not in PLAIN_INTERACTION:
            raise RowError(f"{kind} {effect} is not traced".replace("  ", " "))
        for name, entry in (("surface", surface), ("cs", frame), ("interaction_model", interaction)):
            _check(entry, name)
        _shape(row, geometry)
        row.is_stop = flag(surface, "is_stop")
        aperture = surface.get("aperture")
        if isinstance(aperture, dict) and aperture.get("r_max") is not None:
            size = value(aperture, "r_max", infinite=True)
            row.semi_diameter = size if 0.0 < size < inf else None
            if value(aperture, "r_min", 0.0):
                design.found(Kind.LEFT_OUT, f"surface {index}: a central obscuration (r_min) is left out", index - 1)
        elif isinstance(aperture, int | float | Decimal) and not isinstance(aperture, bool):
            row.semi_diameter = number(aperture, "aperture") / 2.0 or None
        elif aperture is not None:
            design.found(Kind.LEFT_OUT, f"surface {index}: an aperture that is not round is left out", index - 1)
    row.glass = _glass(design, table(surface, "material_post")) if surface.get("material_post") else AIR
    return z


def _shape(row: Row, geometry: dict[str, Any]) -> None:
    """Curvature, conic and aspheric terms of a geometry."""
    kind = text_value(geometry, "type")
    if kind not in ("Plane", "StandardGeometry", "EvenAsphere", "OddAsphere", "BiconicGeometry", "ToroidalGeometry"):
        raise RowError(f"the geometry {kind or 'is missing, or'} is not traced")
    _check(geometry, "geometry")
    if kind in ("BiconicGeometry", "ToroidalGeometry"):
        if any(value(geometry, key, 0.0) for key in ("conic_x", "conic_y", "conic_yz")) or any(
                number(a, "coeffs_poly_y") for a in items(geometry.get("coeffs_poly_y"))):
            raise RowError(f"a {kind} with conics or aspheric terms is not traced")
        row.curvature = curvature(geometry.get("radius_y"))
        row.curvature_x = curvature(geometry.get("radius_x"))
        row.toroid = "arcs" if kind == "BiconicGeometry" else "torus"
        return
    row.curvature = curvature(geometry.get("radius", inf))
    row.conic = value(geometry, "conic", 0.0)
    if kind in ("EvenAsphere", "OddAsphere"):
        powers = list(range(2, 21, 2)) if kind == "EvenAsphere" else list(range(1, 21))
        row.aspheric = coefficients(geometry, "coefficients", powers)


def _glass(design: Design, material: dict[str, Any]) -> Glass:
    """The medium of a material."""
    _check(material, "material")
    way = text_value(table(material, "propagation_model"), "class")
    if way not in ("", "HomogeneousPropagation"):
        raise RowError(f"a gradient index ({way[:40]}) is not traced")
    kind = material.get("type")
    if kind in ("IdealMaterial", "AbbeMaterial"):
        v_d = value(material, "abbe") if kind == "AbbeMaterial" else 0.0
        return media.stated(text_value(material, "name"), value(material, "index"), v_d)
    if kind == "Material" and isinstance(material.get("name"), str):
        maker = text_value(material, "catalog") or text_value(material, "reference")
        return media.glass_in(design, material["name"], maker or None)
    if kind == "MaterialFile" and isinstance(material.get("filename"), str):
        # …/glass/schott/N-BK7.yml or …/main/SiO2/Malitson.yml
        *_, folder, file = ("", *re.split(r"[/\\]", material["filename"]))
        stem = file.removesuffix(".yml")
        name, source = (stem, folder) if folder.upper() in catalogue.MAKERS else (folder, stem)
        return media.glass_in(design, name, source)
    raise RowError("a mirror is not traced" if kind == "Mirror" else f"the material {kind} is not read")


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of an Optiland .json file, and findings about what it cannot hold, other than shapes."""
    remarks: list[Finding] = []
    air = _material(AIR)
    vertex, before = Decimal(0), air
    system = written_system(lens, [], lambda kind, distance: kind in APERTURES.values())
    remarks += system.findings
    distance = system.data.object_distances[0]
    far = -inf if isinf(distance) else EXACT.minus(exact(distance))
    surfaces = [{"type": "ObjectSurface", "geometry": {"type": "Plane", "cs": _frame(far), "radius": inf},
                 "material_post": air, "comment": ""}]
    for i, s in enumerate(lens.surfaces):
        after = _material(s.glass)
        remarks += media.glass_loss(s.glass, i, with_maker=True)
        surfaces.append(_surface(_geometry(s, vertex), before, after, s.thickness, i == lens.stop_index) | {
            "aperture": {"type": "RadialAperture", "r_max": s.semi_diameter, "r_min": 0.0}})
        vertex, before = EXACT.add(vertex, exact(s.thickness)), after
    image = {"type": "Plane", "cs": _frame(vertex), "radius": inf}
    surfaces.append(_surface(image, before, before, 0.0, False))
    data = {
        "version": 1.0, "name": lens.name, **_system_data(system, 2.0 * lens.stop.semi_diameter, remarks),
        "pickups": [], "solves": {"solves": []}, "surface_group": {"surfaces": surfaces}}
    return text_of(data) + "\n", remarks


def _system_data(system: WrittenSystem, stop: float, remarks: list[Finding]) -> dict[str, Any]:
    """Aperture, fields and wavelengths; what they lose is added to `remarks`. stop: its diameter (mm)."""
    data, aperture = system.data, system.aperture or Aperture(ApertureKind.STOP_SIZE, (0.5 * stop,))
    size = aperture.values[0]
    if aperture.kind is ApertureKind.STOP_SIZE:
        size = 2.0 * size or stop
    if any(point.vignetting[0] != point.vignetting[1] or point.vignetting[2] != point.vignetting[3]
           for point in data.fields):
        remarks.append(note(Kind.LEFT_OUT, "of its vignetting factors only the mean of both sides is written"))
    kind = next(name for name, own in FIELDS.items() if own is data.field_kind)
    fields = [{"field_type": kind, "x": point.x, "y": point.y,
               "vx": 0.5 * (point.vignetting[0] + point.vignetting[1]),
               "vy": 0.5 * (point.vignetting[2] + point.vignetting[3]), "weight": point.weight}
              for point in data.fields]
    waves = [{"value": wave.micrometres, "is_primary": i == data.primary, "unit": "um", "weight": wave.weight}
             for i, wave in enumerate(data.wavelengths)]
    return {"aperture": {"type": next(name for name, own in APERTURES.items() if own is aperture.kind), "value": size,
                         "object_space_telecentric": False},
            "fields": {"fields": fields, "telecentric": False, "field_type": kind, "object_space_telecentric": False},
            "wavelengths": {"wavelengths": waves, "polarization": "ignore"}}


def _surface(geometry: dict[str, Any], before: dict[str, Any], after: dict[str, Any], thickness: float,
             is_stop: bool) -> dict[str, Any]:
    """A surface in the format of both older and newer Optiland versions."""
    return {"type": "Surface", "thickness": thickness, "geometry": geometry, "material_pre": before,
            "material_post": after, "is_stop": is_stop, "aperture": None, "coating": None, "bsdf": None,
            "is_reflective": False, "comment": "",
            "interaction_model": {"type": "RefractiveReflectiveModel", "is_reflective": False, "coating": None,
                                  "bsdf": None}}


def _frame(z: float | Decimal) -> dict[str, Any]:
    return {"x": 0.0, "y": 0.0, "z": z, "rx": 0.0, "ry": 0.0, "rz": 0.0, "reference_cs": None}


def _geometry(s: Surface, vertex: Decimal) -> dict[str, Any]:
    """Geometry of a surface; its radius has the digits that restore the curvature."""
    radius = Decimal(radius_text(s.curvature))
    if s.curvature_x is not None:
        return {"type": "BiconicGeometry", "cs": _frame(vertex), "radius_x": Decimal(radius_text(s.curvature_x)),
                "radius_y": radius, "conic_x": 0.0, "conic_y": 0.0}
    terms = dict(s.aspheric)
    plain = {"cs": _frame(vertex), "radius": radius, "conic": s.conic}
    if not terms:
        return {"type": "StandardGeometry", **plain}
    step = 1 if any(power % 2 for power in terms) else 2
    return {"type": "OddAsphere" if step == 1 else "EvenAsphere", **plain, "tol": 1e-10, "max_iter": 100,
            "coefficients": [terms.get(power, 0.0) for power in range(step, max(terms) + 1, step)]}


def _material(glass: Glass) -> dict[str, Any]:
    maker = media.maker_of(glass)
    if maker:
        return {"type": "Material", "name": glass.name, "reference": maker.lower(), "catalog": maker.lower(),
                "robust_search": False, "min_wavelength": None, "max_wavelength": None}
    named = {"name": glass.name} if glass.name and glass.n_d != 1.0 else {}
    if glass.v_d is None or glass.n_d == 1.0:
        return {"type": "IdealMaterial", "index": glass.n_d, "absorp": 0.0, **named}
    return {"type": "AbbeMaterial", "index": glass.n_d, "abbe": glass.v_d, "model": "buchdahl", **named}
