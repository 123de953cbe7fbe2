"""rayoptics lens files (.roa): its sequential model in JSON, each object wrapped with the name of its class.

`ifcs` are the surfaces from the object to the image, `gaps` what lies between
them, profiles stand in `profile_dict` or in the surface. EvenPolynomial has
coefficients of r², r⁴ …, RadialPolynomial of r, r², r³ … and ec = 1 + k. Mirrors,
tilts, decentres, gratings and ideal lenses are refused.
"""

from typing import Any

from lensbench.glass import AIR, Glass
from lensbench.lenses import media
from lensbench.lenses.design import Design, Row
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.json_text import coefficients, item_lines, items, parse, table, value
from lensbench.lenses.rows import RowError
from lensbench.prescription import Lens

UNITS = {"mm": 1.0, "cm": 10.0, "meters": 1000.0, "m": 1000.0, "in": 25.4, "inches": 25.4}
APERTURES = {("object", "epd"): "EPD", ("object", "pupil"): "EPD", ("image", "f/#"): "FNO", ("object", "NA"): "NA"}
MISSING_RIM = 1.0           # what rayoptics puts where no rim was computed


def read(text: str, path: str) -> Lens:
    """The lens of a file's text; `path` is named in errors. LensFileError: the line and what is wrong."""
    model = table(parse(text, path), "optical_model")
    sequence = table(model, "seq_model")
    surfaces, gaps = items(sequence.get("ifcs")), items(sequence.get("gaps"))
    if not surfaces:
        raise LensFileError(path, None, "there is no seq_model with ifcs: this is no rayoptics lens")
    system = table(model, "system_spec")
    design = Design(path, name=str(system.get("title") or ""))
    dimensions = str(system.get("_dimensions") or system.get("dimensions") or "mm")
    if dimensions not in UNITS:
        raise LensFileError(path, None, f"dimensions {dimensions!r}: lengths must be in {', '.join(UNITS)}")
    design.unit = UNITS[dimensions]
    lines = item_lines(text, "ifcs")
    stop = sequence.get("stop_surface")
    for i, surface in enumerate(surfaces):
        row = Row(lines[i] if i < len(lines) else None, is_stop=i == stop and not isinstance(stop, bool))
        try:
            if 0 < i < len(surfaces) - 1:
                _fill(row, surface, table(model, "profile_dict"))
            if i < len(gaps):
                gap = table(gaps[i])
                row.thickness = value(gap, "thi", infinite=True)
                row.glass = _glass(design, gap.get("medium"))
        except RowError as error:
            raise LensFileError(path, row.line, f"surface {i}: {error}") from None
        design.add(row)
    inner = design.rows[1:-1]
    if all(row.semi_diameter in (None, MISSING_RIM) for row in inner):
        for row in inner:
            row.semi_diameter = None
    try:
        _system(design, table(model, "optical_spec"))
    except RowError as error:
        raise LensFileError(path, None, str(error)) from None
    return design.lens()


def _system(design: Design, spec: dict[str, Any]) -> None:
    """Aperture and field."""
    pupil = table(spec, "pupil")
    key = [str(word) for word in items(pupil.get("_key") or pupil.get("key"))]
    kind = APERTURES.get((key[-2], key[-1])) if len(key) > 1 else None
    if kind:
        design.aperture = (kind, value(pupil, "value"))
    field = table(spec, "field_of_view")
    key = [str(word) for word in items(field.get("_key") or field.get("key"))]
    points = [table(point) for point in items(field.get("fields"))]
    size = max((abs(value(point, "y", 0.0)) for point in points), default=0.0)
    if field.get("is_relative"):
        size *= abs(value(field, "value", 0.0))
    if size and len(key) > 1:
        where = "angle" if key[-1] == "angle" else "object" if key[-2] == "object" else "image"
        design.field_of_view = (where, size)


def _class_of(wrapped: Any) -> str:
    """The last word of a wrapper's class."""
    names = items(wrapped.get("__instance_type__")) if isinstance(wrapped, dict) else []
    return str(names[-1]) if names else ""


def _fill(row: Row, wrapped: Any, profiles: dict[str, Any]) -> None:
    """Fill the row from an interface. RowError: not traced."""
    kind, surface = _class_of(wrapped), table(wrapped)
    if kind != "Surface":
        raise RowError(f"an interface of the class {kind or 'unknown'} is not traced")
    mode = surface.get("interact_mode", "transmit")
    if mode not in ("transmit", "dummy"):
        raise RowError("a mirror (interact_mode reflect) is not traced" if mode == "reflect" else
                       f"interact_mode {mode} is not traced")
    if surface.get("decenter") is not None:
        raise RowError("a tilt or decentre (decenter) is not traced")
    if surface.get("phase_element") is not None:
        raise RowError("a grating or hologram (phase_element) is not traced")
    if value(surface, "max_aperture", MISSING_RIM, infinite=True) > 0.0:
        row.semi_diameter = value(surface, "max_aperture", MISSING_RIM)
    for wrapped_aperture in items(surface.get("clear_apertures")):
        if _class_of(wrapped_aperture) == "Circular":
            row.semi_diameter = value(table(wrapped_aperture), "radius") or None
    wrapped_profile = surface.get("profile") or profiles.get(str(surface.get("profile_id")))
    shape, kind = table(wrapped_profile), _class_of(wrapped_profile)
    if kind not in ("Spherical", "Conic", "EvenPolynomial", "RadialPolynomial"):
        raise RowError(f"the profile {kind or 'is missing, or'} is not traced")
    row.curvature = value(shape, "cv")
    if kind == "RadialPolynomial":
        row.conic = value(shape, "ec", 1.0) - 1.0
        row.aspheric = coefficients(shape, "coefs", list(range(1, 21)))
    elif kind != "Spherical":
        row.conic = value(shape, "cc", 0.0)
        row.aspheric = coefficients(shape, "coefs", list(range(2, 21, 2)))


def _glass(design: Design, wrapped: Any) -> Glass:
    """The medium of a gap."""
    medium, kind = table(wrapped), _class_of(wrapped)
    if kind == "Air" or (not medium and not kind):
        return AIR
    if isinstance(medium.get("gname"), str):
        module = str(items(wrapped.get("__instance_type__"))[0])
        glass, finding = media.named(medium["gname"], module.rpartition(".")[2].upper())
        if finding:
            design.found(finding)
        return glass
    if "n" in medium:
        label = medium.get("label") or medium.get("name") or ""
        return media.stated(label if isinstance(label, str) else "", value(medium, "n"), value(medium, "v", 0.0))
    raise RowError(f"the medium {kind} is not read")
