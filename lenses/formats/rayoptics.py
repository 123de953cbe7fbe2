"""rayoptics lens files (.roa): its sequential model in JSON, each object wrapped with the name of its class.

`ifcs` are the surfaces from the object to the image, `gaps` their distances and
media; the profile of a surface is in `profile_dict` or in the surface. EvenPolynomial
has coefficients of r², r⁴ …, RadialPolynomial of r, r², r³ … and ec = 1 + k; YToroid
rotates its section y–z (cv) about an axis along y, at 1/cR. Wavelengths in nm.
Mirrors, tilts, decentres, gratings and ideal lenses are refused.
"""

import re
from decimal import Decimal
from math import isinf
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens, refracts
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import LensFileError, RowError, located, number
from lensbench.lenses.glass import media
from lensbench.lenses.tables.aperture import f_number_kind
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.system_text import WrittenSystem, with_working_f_number, written_system
from lensbench.lenses.tables.text import (
    EXACT, check_keys, coefficients, exact, exact_value, flag, item_lines, items, parse, table, text_of, text_value,
    value
)

UNITS = {"mm": 1.0, "cm": 10.0, "meters": 1000.0, "m": 1000.0, "in": 25.4, "inches": 25.4}        # lower case
APERTURES = {                   # an f-number is at work, which for an object at infinity is the same
    ("object", "epd"): ApertureKind.PUPIL_DIAMETER, ("object", "pupil"): ApertureKind.PUPIL_DIAMETER,
    ("image", "f/#"): ApertureKind.F_NUMBER, ("object", "NA"): ApertureKind.OBJECT_NA,
    ("image", "NA"): ApertureKind.IMAGE_NA}
FIELDS = {("object", "angle"): FieldKind.ANGLE, ("object", "height"): FieldKind.OBJECT_HEIGHT,
          ("image", "height"): FieldKind.IMAGE_HEIGHT, ("image", "real height"): FieldKind.REAL_IMAGE_HEIGHT}
# By object: what is read, and what is harmless: drawing, other views of the same model, what the program recomputes
READ = {
    "optical_model": ({"system_spec", "seq_model", "optical_spec", "profile_dict"},
                      {"ro_version", "radius_mode", "specsheet", "parts_dict", "ele_model", "part_tree", "parax_model",
                       "name", "note", "analysis_results"}),
    "system_spec": ({"title", "_dimensions", "dimensions", "temperature", "pressure"}, {"initials"}),
    "seq_model": ({"ifcs", "gaps", "stop_surface"}, {"z_dir", "do_apertures", "cur_surface"}),
    "surface": ({"interact_mode", "refract_mode", "decenter", "phase_element", "max_aperture", "clear_apertures",
                 "profile", "profile_id"}, {"delta_n", "label", "edge_apertures", "z_type"}),
    "gap": ({"thi", "medium"}, set()),
    "profile": ({"cv", "cc", "ec", "coefs", "cR", *(f"coef{power}" for power in range(1, 31))}, {"max_nonzero_coef"}),
    "optical_spec": ({"spectral_region", "pupil", "field_of_view", "defocus"}, {"do_aiming"}),
    "spectral_region": ({"wavelengths", "spectral_wts", "reference_wvl"}, {"render_colors", "coating_wvl"}),
    "pupil": ({"key", "_key", "value"}, {"pupil_rays", "ray_labels"}),
    "field_of_view": ({"key", "_key", "value", "_value", "is_relative", "fields"},
                      {"index_labels", "index_label_type", "is_wide_angle"}),
    "field": ({"x", "y", "_x", "_y", "vux", "vlx", "vuy", "vly", "wt"}, {
        "aim_pt", "aim_info", "z_enp", "chief_ray", "ref_sphere", "vcx", "vcy", "vdx", "vdy", "van"}),
}
MERCURY = 760.0             # mm, of one atmosphere
COLOURS = ("#268bd2", "#859900", "#dc322f")
VIGNETTING = ("vux", "vlx", "vuy", "vly")
MISSING_RIM = 1.0           # the rim that rayoptics writes if none was computed
FAR_OBJECT = 1e10
CLASSES = {                 # of catalogue glasses, and the formula with which rayoptics reckons their six coefficients
    "SCHOTT": ("opticalglass.schott", "SchottGlass", "sellmeier"),
    "OHARA": ("opticalglass.ohara", "OharaGlass", "sellmeier"),
    "HOYA": ("opticalglass.hoya", "HoyaGlass", "schott"),
    "CDGM": ("opticalglass.cdgm", "CDGMGlass", "schott"),
    "SUMITA": ("opticalglass.sumita", "SumitaGlass", "schott"),
}
SAMPLES = 60                # wavelengths at which the index of another glass is tabulated


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    model = table(parse(text, path), "optical_model")
    sequence = table(model, "seq_model")
    surfaces, gaps = items(sequence.get("ifcs")), items(sequence.get("gaps"))
    if not surfaces:
        raise LensFileError(path, None, "there is no seq_model with ifcs: this is no rayoptics lens")
    with located(path, None):
        for name, entry in (("optical_model", model), ("seq_model", sequence), (
                "system_spec", table(model, "system_spec")), ("optical_spec", table(model, "optical_spec"))):
            _check(entry, name)
    system = table(model, "system_spec")
    design = Design(path, name=text_value(system, "title"))
    dimensions = (text_value(system, "_dimensions") or text_value(system, "dimensions") or "mm").lower()
    if dimensions not in UNITS:
        raise LensFileError(path, None, f"dimensions {excerpt(dimensions)}: lengths must be in {', '.join(UNITS)}")
    design.unit = UNITS[dimensions]
    lines = item_lines(text, "ifcs")
    stop = sequence.get("stop_surface")
    for i, surface in enumerate(surfaces):
        with design.row(i, lines) as row:
            row.is_stop = i == stop and not isinstance(stop, bool)
            profiles = table(model, "profile_dict")
            if 0 < i < len(surfaces) - 1:
                _fill(design, row, surface, profiles, i)
            else:
                row.curvature = value(table(_profile_of(table(surface), profiles)), "cv", 0.0)
            if i < len(gaps):
                gap = table(gaps[i])
                _check(gap, "gap")
                row.thickness = value(gap, "thi", infinite=True)
                row.glass = _glass(design, gap.get("medium"))
    bare = [(row, table(surface)) for row, surface in zip(design.rows[1:-1], surfaces[1:-1], strict=True)]
    if all(not items(surface.get("clear_apertures")) and row.semi_diameter in (None, MISSING_RIM)
           for row, surface in bare):
        for row, _ in bare:
            row.semi_diameter = None
    with located(path, None):
        _system(design, table(model, "optical_spec"))
        design.state_air(value(system, "temperature", 20.0), value(system, "pressure", MERCURY) / MERCURY)
    return design.lens()


def _check(data: dict[str, Any], name: str) -> None:
    """Raise RowError for an entry of an object that is neither read nor harmless. name: of the object in READ."""
    check_keys(data, set().union(*READ[name]), f" of the {name}")


def _system(design: Design, spec: dict[str, Any]) -> None:
    """Aperture, fields and wavelengths."""
    for name in ("pupil", "spectral_region", "field_of_view"):
        _check(table(spec, name), name)
    shift = value(table(spec, "defocus"), "focus_shift", 0.0)
    if shift:
        design.found(Kind.LEFT_OUT, f"a defocus (focus_shift) of {significant(shift * design.unit)} mm is left out: "
                                    "the film stands where the lens is focused")
    pupil = table(spec, "pupil")
    kind = APERTURES.get(_key(pupil))
    if kind is ApertureKind.F_NUMBER:
        kind = f_number_kind(design.rows[0].thickness)
    if kind:
        design.state_aperture(kind, value(pupil, "value"))
    elif pupil:
        design.found(Kind.LEFT_OUT, f"the aperture {' '.join(_key(pupil))} is left out")
    region = table(spec, "spectral_region")
    waves = [float(EXACT.divide(exact(w), Decimal(1000))) for w in items(region.get("wavelengths"))
             if number(w, "wavelengths") is not None]
    weights = [number(weight, "spectral_wts") for weight in items(region.get("spectral_wts"))] + [1.0] * len(waves)
    if waves:
        design.state_wavelengths(list(zip(waves, weights, strict=False)), int(value(region, "reference_wvl", 0.0)))
    field = table(spec, "field_of_view")
    field_kind = FIELDS.get(_key(field))
    points = [table(point) for point in items(field.get("fields"))]
    if field_kind is None:
        if points:
            design.found(Kind.LEFT_OUT, f"the fields by {' '.join(_key(field))} are left out")
        return
    largest = value(field, "_value" if "_value" in field else "value", 0.0)
    scale = exact(largest) if flag(field, "is_relative") else Decimal(1)
    made = []
    for point in points:
        _check(point, "field")
        x, y = (float(EXACT.multiply(exact_value(point, f"_{axis}" if f"_{axis}" in point else axis, 0.0), scale))
                for axis in "xy")
        vux, vlx, vuy, vly = (value(point, name, 0.0) for name in VIGNETTING)
        made += design.field_point(x, y, value(point, "wt", 1.0), (vux, vlx, vuy, vly))
    design.state_fields(field_kind, made)


def _key(specification: dict[str, Any]) -> tuple[str, str]:
    """The side and the quantity of an aperture or a field."""
    words = ["", "", *(str(word) for word in items(specification.get("_key") or specification.get("key")))]
    return words[-2], words[-1]


def _class_of(wrapped: Any) -> str:
    """The last word of a wrapper's class."""
    names = items(wrapped.get("__instance_type__")) if isinstance(wrapped, dict) else []
    return str(names[-1]) if names else ""


def _profile_of(surface: dict[str, Any], profiles: dict[str, Any]) -> Any:
    """The wrapped profile of an interface, its own or one of the list that it names."""
    return surface.get("profile") or profiles.get(str(surface.get("profile_id")))


def _fill(design: Design, row: Row, wrapped: Any, profiles: dict[str, Any], index: int) -> None:
    """Fill the row from an interface. RowError: not traced."""
    kind, surface = _class_of(wrapped), table(wrapped)
    if kind != "Surface":
        raise RowError(f"an interface of the class {kind or 'unknown'} is not traced")
    _check(surface, "surface")
    mode = "reflect" if surface.get("refract_mode") == "REFL" else surface.get("interact_mode", "transmit")
    if mode not in ("transmit", "dummy"):
        raise RowError("a mirror (interact_mode reflect) is not traced" if mode == "reflect" else
                       f"interact_mode {mode} is not traced")
    if surface.get("decenter") is not None:
        raise RowError("a tilt or decentre (decenter) is not read from this format")
    if surface.get("phase_element") is not None:
        raise RowError("a grating or hologram (phase_element) is not traced")
    if value(surface, "max_aperture", MISSING_RIM, infinite=True) > 0.0:
        row.semi_diameter = value(surface, "max_aperture", MISSING_RIM)
    for wrapped_aperture in items(surface.get("clear_apertures")):
        aperture = table(wrapped_aperture)
        if _class_of(wrapped_aperture) != "Circular" or flag(aperture, "is_obscuration") or any(
                value(aperture, key, 0.0) for key in ("x_offset", "y_offset")):
            design.found(Kind.LEFT_OUT, f"surface {index}: an aperture that is not round and centred is left out",
                         index - 1)
        else:
            row.semi_diameter = value(aperture, "radius") or None
    wrapped_profile = _profile_of(surface, profiles)
    shape, kind = table(wrapped_profile), _class_of(wrapped_profile)
    if kind not in ("Spherical", "Conic", "EvenPolynomial", "RadialPolynomial", "YToroid", "XToroid"):
        raise RowError(f"the profile {kind or 'is missing, or'} is not traced")
    _check(shape, "profile")
    row.curvature = value(shape, "cv")
    if kind == "RadialPolynomial":
        row.conic = float(EXACT.subtract(exact_value(shape, "ec", 1.0), Decimal(1)))
        row.aspheric = _terms(shape, 1)
    elif kind != "Spherical":
        row.conic = value(shape, "cc", 0.0)
        row.aspheric = _terms(shape, 2)
    if kind in ("YToroid", "XToroid"):
        row.curvature_x, row.toroid = value(shape, "cR", 0.0), "torus"
        if kind == "XToroid":
            row.curvature, row.curvature_x, row.toroid = row.curvature_x, row.curvature, "torus about x"


def _terms(shape: dict[str, Any], step: int) -> dict[int, float]:
    """Coefficients of r^step, r^(2 step) …; older versions store them one by one."""
    powers = list(range(step, 21, step))
    if not any(number(a, "coefs") for a in items(shape.get("coefs"))):
        shape = {"coefs": [shape.get(f"coef{power}") or 0.0 for power in powers]}
    return coefficients(shape, "coefs", powers)


def _glass(design: Design, wrapped: Any) -> Glass:
    """The medium of a gap."""
    medium, kind = table(wrapped), _class_of(wrapped)
    if kind in ("Air", "Vacuum") or (not medium and not kind):
        return AIR
    if isinstance(medium.get("gname"), str):
        names = items(wrapped.get("__instance_type__")) if isinstance(wrapped, dict) else []
        maker = str(names[0]).rpartition(".")[2].upper() if names else None
        return media.glass_in(design, medium["gname"], maker)
    label = text_value(medium, "label") or text_value(medium, "name")
    if label.upper() in media.AIR_NAMES and label:
        return AIR
    formula = re.fullmatch(r"eval_formula_(\d)", text_value(medium, "rndx_fct_name"))
    if formula:
        ends = [number(w, "data_range") for w in items(medium.get("data_range"))]
        if len(ends) != 2:
            raise RowError(f"the material {label} has no range of wavelengths (data_range)")
        return media.from_database(label, int(formula[1]), [number(c, "coefs") for c in items(medium.get("coefs"))],
                                   (ends[0], ends[1]))
    if "n" in medium:
        return media.stated(label, value(medium, "n"), value(medium, "v", 0.0))
    if items(medium.get("wvls")):
        indices = [number(n, "rndx") for n in items(medium.get("rndx"))]
        lines = [float(EXACT.divide(exact(w), Decimal(1000))) for w in items(medium.get("wvls"))
                 if number(w, "wvls") > 0.0]
        points = list(zip(lines, indices, strict=False))
        return media.listed(label, text_value(medium, "_catalog") or None, points) or media.tabulated(label, points)
    raise RowError(f"the medium {kind} is not read")


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .roa file, and findings about what it cannot hold, other than shapes."""
    remarks: list[Finding] = []
    flat = ("Spherical", {"cv": 0.0})
    indices = [1.0, *(s.glass.n_d for s in lens.surfaces)]
    ifcs, profiles = [_interface(0, "dummy", 0.0, MISSING_RIM, "Obj")], [flat]
    system = written_system(lens, [], with_working_f_number(APERTURES.values()))
    remarks += system.findings
    distance = system.data.object_distances[0]
    gaps = [_gap(FAR_OBJECT if isinf(distance) else distance, AIR)]
    for i, s in enumerate(lens.surfaces):
        bends = refracts(lens.in_air, i) or s.curvature != 0.0 or not s.is_spherical
        ifcs.append(_interface(i + 1, "transmit" if bends else "dummy", s.glass.n_d - indices[i], s.semi_diameter,
                               clear=True))
        profiles.append(_profile(s))
        gaps.append(_gap(s.thickness, s.glass))
        if not (media.is_plain_table(s.glass) or media.is_known(s.glass)):
            remarks += media.glass_loss(s.glass, i, with_maker=True)
    ifcs.append(_interface(len(ifcs), "dummy", 0.0, MISSING_RIM, "Img"))
    profiles.append(flat)
    title = " ".join(lens.name.split())
    model = {
        "ro_version": "0.9.8", "radius_mode": True, "specsheet": None,
        "system_spec": _wrapped("rayoptics.optical.opticalmodel", "SystemSpec", {
            "title": title, "initials": "", "_dimensions": "mm", "temperature": 20.0, "pressure": 760.0}),
        "seq_model": _wrapped("rayoptics.seq.sequential", "SequentialModel", {
            "ifcs": ifcs, "gaps": gaps, "z_dir": [1] * len(gaps), "do_apertures": False,
            "stop_surface": lens.stop_index + 1, "cur_surface": len(gaps) - 1}),
        "optical_spec": _specification(system, 2.0 * lens.stop.semi_diameter),
        "profile_dict": {str(i): _wrapped("rayoptics.elem.profiles", *profile) for i, profile in enumerate(profiles)},
        "parts_dict": {}}
    if title != lens.name:
        remarks.append(note(Kind.TEXT, "the name is written in one line"))
    return text_of({"optical_model": _wrapped("rayoptics.optical.opticalmodel", "OpticalModel", model)}) + "\n", remarks


def _wrapped(module: str, kind: str, attributes: dict[str, Any]) -> dict[str, Any]:
    return {"__instance_type__": [module, kind], "attributes": attributes}


def _interface(index: int, mode: str, step: float, rim: float, label: str = "", clear: bool = False) -> dict[str, Any]:
    """A surface; clear: write its rim as an aperture too, which rayoptics does not recompute."""
    round_ones = [_wrapped("rayoptics.elem.surface", "Circular", {
        "x_offset": 0.0, "y_offset": 0.0, "rotation": 0.0, "radius": rim})] if clear else []
    return _wrapped("rayoptics.elem.surface", "Surface", {
        "interact_mode": mode, "delta_n": step, "decenter": None, "max_aperture": rim, "label": label,
        "clear_apertures": round_ones, "edge_apertures": [], "profile_id": str(index)})


def _profile(s: Surface) -> tuple[str, dict[str, Any]]:
    """Class and values of a surface's shape."""
    terms = dict(s.aspheric)
    if s.curvature_x is not None:
        return "YToroid", {"cv": s.curvature, "cR": s.curvature_x, "cc": 0.0, "coefs": [0.0] * 10,
                           "max_nonzero_coef": 0}
    if not terms:
        return ("Conic", {"cv": s.curvature, "cc": s.conic}) if s.conic else ("Spherical", {"cv": s.curvature})
    step = 1 if any(power % 2 for power in terms) else 2
    coefs = [terms.get(power, 0.0) for power in range(step, 21, step)]
    shape: dict[str, Any] = {"cv": s.curvature, "coefs": coefs, "max_nonzero_coef": max(terms) // step}
    if step == 1:
        return "RadialPolynomial", shape | {"ec": EXACT.add(exact(s.conic), Decimal(1))}
    return "EvenPolynomial", shape | {"cc": s.conic}


def _gap(thickness: float, glass: Glass) -> dict[str, Any]:
    return _wrapped("rayoptics.seq.gap", "Gap", {"thi": thickness, "medium": _medium(glass)})


def _medium(glass: Glass) -> dict[str, Any]:
    """The medium: a class of its maker, a table of indices, or n_d and V_d."""
    if glass.n_d == 1.0:
        return _wrapped("opticalglass.opticalmedium", "Air", {})
    maker = media.maker_of(glass)
    module, kind, formula = CLASSES.get(maker, ("", "", ""))
    c = list(glass.coefficients)
    if glass.formula == formula and len(c) == 6:
        return _wrapped(module, kind, {"gname": glass.name, "coefs": c if formula == "schott" else c[::2] + c[1::2]})
    if maker or media.is_known(glass) or media.is_plain_table(glass):
        if glass.formula == "table":
            points = [(EXACT.multiply(exact(w), Decimal(1000)), n) for w, n in glass.coefficients]
        else:
            low, high = glass.wavelengths or (0.4, 0.7)
            steps = [low * (high / low) ** (i / (SAMPLES - 1)) for i in range(1, SAMPLES - 1)]
            points = [(exact(1000.0 * w), glass.index(w)) for w in steps]
        return _wrapped("opticalglass.opticalmedium", "InterpolatedMedium", {
            "label": glass.name, "_catalog": maker, "wvls": [w for w, _ in points], "rndx": [n for _, n in points],
            "kvals": None, "kvals_wvls": None})
    if glass.v_d is None:
        return _wrapped("opticalglass.opticalmedium", "ConstantIndex", {
            "label": glass.name, "n": glass.n_d, "_catalog_name": ""})
    return _wrapped("opticalglass.modelglass", "ModelGlass", {
        "label": glass.name, "_catalog_name": "user", "n": glass.n_d, "v": glass.v_d})


def _specification(system: WrittenSystem, spare: float) -> dict[str, Any]:
    """Wavelengths, aperture and fields. spare: diameter for a lens without an entrance pupil (mm)."""
    data, aperture = system.data, system.aperture or Aperture(ApertureKind.PUPIL_DIAMETER, (spare,))
    kind = ApertureKind.F_NUMBER if aperture.kind is ApertureKind.WORKING_F_NUMBER else aperture.kind
    module = "rayoptics.raytr.opticalspec"
    fields = [_wrapped(module, "Field", {
        "x": point.x, "y": point.y, **dict(zip(VIGNETTING, point.vignetting, strict=True)), "wt": point.weight,
        "aim_pt": [0.0, 0.0]}) for point in data.fields]
    key = next(key for key, own in FIELDS.items() if own is data.field_kind)
    return _wrapped(module, "OpticalSpecs", {
        "spectral_region": _wrapped(module, "WvlSpec", {
            "wavelengths": [EXACT.multiply(exact(wave.micrometres), Decimal(1000)) for wave in data.wavelengths],
            "spectral_wts": [wave.weight for wave in data.wavelengths],
            "render_colors": [COLOURS[i % len(COLOURS)] for i in range(len(data.wavelengths))],
            "reference_wvl": data.primary, "coating_wvl": 550.0}),
        "pupil": _wrapped(module, "PupilSpec", {
            "_key": ["aperture", *next(key for key, own in APERTURES.items() if own is kind)],
            "value": aperture.values[0],
            "pupil_rays": [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]],
            "ray_labels": ["00", "+X", "-X", "+Y", "-Y"]}),
        "field_of_view": _wrapped(module, "FieldSpec", {
            "key": ["field", *key], "value": data.largest_field, "is_relative": False,
            "index_labels": ["axis" if point.x == point.y == 0.0 else f"{i}" for i, point in enumerate(data.fields)],
            "fields": fields}),
        "defocus": _wrapped(module, "FocusRange", {"focus_shift": 0.0, "defocus_range": 0.0})})
