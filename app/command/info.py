"""The command `lensbench info`: provenance, first-order data, glasses and check of a lens."""

import argparse
import math
from dataclasses import replace
from typing import Any

from lensbench.app.command.lens_options import add_close_option, add_lens_options
from lensbench.app.command.output import print_json
from lensbench.core.text import escaped, f_number_text, fixed, significant

PIXELS = 960                            # across a picture, for intrinsics: as the bench has it


def add_info_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench info`."""
    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    add_lens_options(parser)
    add_close_option(parser)
    parser.add_argument("--json", action="store_true", help="print JSON: lengths in mm, angles in degrees")


def info(arguments: argparse.Namespace) -> int:
    """Print what is known of a lens, as text or JSON."""
    import lensbench as lb
    from lensbench.app.bench.build import design, picture_wavelength, published
    from lensbench.app.bench.coating import coating
    from lensbench.app.bench.lens_choice import USUAL, own_film
    from lensbench.app.bench.zoom import positioned, station_lines, stations
    from lensbench.app.command import lens_card
    from lensbench.app.settings.lens_settings import AUTO
    from lensbench.app.settings.settings import Settings
    from lensbench.app.settings.text_values import format_distance
    from lensbench.lenses.tables.paraxial import is_d_line

    settings = replace(Settings(), lens=arguments.lens, focal_length=arguments.focal_length).checked()
    lens = published(settings)
    card, seen_at = lens_card.lens_card(lens), picture_wavelength(settings, lens)
    lens = positioned(design(settings), arguments)
    if getattr(arguments, "f_number", None) is not None:
        lens = lb.stopped_down(lens, arguments.f_number)
    assumed = coating(replace(Settings(), coating=arguments.coating or AUTO), lens)
    film = own_film(settings.lens, lens) if settings.focal_length is None else USUAL
    data = {**_lens_data(lens, assumed.name, film), "picture_wavelength": seen_at, **card, "coating": assumed.name,
            "positions": stations(lens)}
    if arguments.json:
        print_json({"units": {"length": "mm", "angle": "degrees"}, **data})
        return 0
    far = "" if data["focus_distance"] is None else ", focused at infinity"
    rows = [(label, text(data[key]) if data[key] is not None else "not known") for key, label, text in (
        ("efl", "Effective focal length", _mm),
        *([("efl_across", "  across, in the section x–z", _mm)] if data["efl_across"] is not None else []),
        ("stated_efl", "  as published", lambda length: f"{significant(length)} mm"),
        ("f_number", "f-number", lambda number: f_number_text(number, 2) + far),
        *([("working_f_number", "Working f-number", lambda number: f"{f_number_text(number, 2)}, focused at "
            f"{format_distance(data['focus_distance'])}")] if data["working_f_number"] is not None else []),
        ("t_number", "T-number", lambda number: f"{f_number_text(number, 2, 'T/')}{far}, {assumed.name}: "
         f"{assumed.why}"),
        ("bfl", "Back focus", _mm),
        *([("bfl_across", "  across, in the section x–z", _mm)] if data["bfl_across"] is not None else []),
        ("ffl", "Front focus", _mm),
        ("front_principal", "Front principal plane, from the first vertex", _mm),
        ("rear_principal", "Rear principal plane, from the last vertex", _mm))]
    rows += [(label, f"{_mm(data[key]['z'])}, radius {_mm(data[key]['radius'])}") for key, label in (
        ("entrance_pupil", "Entrance pupil, from the first vertex"),
        ("exit_pupil", "Exit pupil, from the first vertex"))]
    view = data["field_of_view"]
    rows += [("Petzval radius", f"{fixed(data['petzval_radius'], 1)} mm"),
             ("Nearest focus, from the film", f"none: {data['no_focus']}" if data["nearest_focus"] is None
              else f"{fixed(data['nearest_focus'] / 1000.0, 3)} m"),
             ("Field of view, h × v, diagonal", f"none: {data['no_focus']}" if view is None else
              f"{_degrees(view['horizontal'])} × {_degrees(view['vertical'])}, {_degrees(view['diagonal'])} on "
              f"{significant(film[0])} × {significant(film[1])} mm{'' if film == lens.film_size else ' (assumed)'}")]
    if data["intrinsics"]:
        pixels = data["intrinsics"]
        rows.append((f"Intrinsics at {pixels['width']} × {pixels['height']} pixels of that film",
                     f"fx {fixed(pixels['fx'], 2)}, fy {fixed(pixels['fy'], 2)}, cx {fixed(pixels['cx'], 2)}, cy "
                     f"{fixed(pixels['cy'], 2)}, focused at infinity"))
    if not is_d_line(data["wavelength"]):
        rows.insert(0, ("Figures at the primary wavelength", f"{significant(1000.0 * data['wavelength'])} nm"
                        + (", its pictures too" if seen_at is not None else "")))
    if data["out_of_line"]:
        which = ", ".join(map(str, data["out_of_line"]))
        rows.insert(0, ("Tilted or decentred", f"surfaces {which}; focal lengths, pupils and f-number are those of the "
                                               "centred lens"))
    year = f"{data['year']}{lens_card.star(card, 'year')}" if data["year"] else ""
    print(escaped(", ".join(word for word in (data["name"] or arguments.lens, data["kind"], year) if word)))
    print("\n".join(map(escaped, [
        *lens_card.card_lines(card, data["source"]),
        *(f"{label:{lens_card.WIDTH}}{text}{lens_card.star(card, label)}" for label, text in rows),
        *station_lines(data["positions"]), *lens_card.glass_lines(card)])))
    print("".join(f"Found: {finding}\n" for finding in data["findings"]), end="")
    return 0


def _degrees(angle: float | None) -> str:
    """An angle in degrees to a tenth."""
    return "not known" if angle is None else f"{fixed(angle, 1)}°"


def _mm(length: float) -> str:
    """A length in mm to the micrometre."""
    return f"{fixed(length, 3)} mm"


def _lens_data(lens, coating: str, film_size: tuple[float, float]) -> dict[str, Any]:
    """The figures of `lensbench info`: lengths in mm, angles in degrees.

    film_size: width and height for field of view and intrinsics.
    """
    import lensbench as lb
    from lensbench.lenses.tables.paraxial import at_reference

    lens, wavelength = at_reference(lens)
    fo, at_infinity = lb.first_order(lens, wavelength), lens.at(close=0.0)      # an f-number counts at infinity
    nearest, no_focus = None, ""
    try:
        nearest = lb.nearest_focus(lens)
    except lb.FocusError as error:                      # the other figures stand
        no_focus = str(error)
    across = None if len(lens.sections) == 1 else lb.first_order(lens.section("x"), wavelength)
    squeeze = fo.efl / across.efl if across and math.isfinite(fo.efl) and math.isfinite(across.efl) else 1.0
    film = lb.Film(film_size[0] * abs(squeeze), film_size[1])   # as wide as what a lens with cylinders squeezes into it
    return {
        "name": lens.name, "kind": lens.kind, "year": lens.year, "source": lens.source,
        "stated_efl": lens.stated_efl, "stated_f_number": lens.stated_f_number,
        "surfaces": len(lens.surfaces), "stop_index": lens.stop_index, "length": lens.length,
        "wavelength": wavelength, "efl": fo.efl, "bfl": fo.bfl, "ffl": fo.ffl,
        "f_number": lb.first_order(at_infinity, wavelength).f_number, **_close_focus(lens),
        "efl_across": across and across.efl, "bfl_across": across and across.bfl,
        "t_number": lb.t_number(at_infinity, coating, wavelength),
        "transmission": lb.transmission(lens, wavelength, coating),
        "front_principal": fo.front_principal, "rear_principal": fo.rear_principal,
        "entrance_pupil": {"z": fo.entrance_pupil.z, "radius": fo.entrance_pupil.radius},
        "exit_pupil": {"z": fo.exit_pupil.z, "radius": fo.exit_pupil.radius},
        "petzval_radius": fo.petzval_radius, "stop_radius": fo.stop_radius,
        "nearest_focus": nearest, "no_focus": no_focus,
        "out_of_line": [i for i, surface in enumerate(lens.surfaces) if surface.pose is not None],
        "film": film_size,
        "field_of_view": None if nearest is None else _field_of_view(at_infinity, film, wavelength),
        "intrinsics": _intrinsics(lens, film),
        "findings": [str(finding) for finding in lens.findings],
    }


def _field_of_view(lens, film, wavelength: float) -> dict[str, float | None]:
    """Degrees across, down and across the diagonal at infinity: by rays; 2 atan(h / 2f) of a lens with cylinders.

    Of a smaller image circle where the film is dark outside; None where no light through the middle of the stop comes.
    """
    import lensbench as lb
    from lensbench.app.bench.readouts import traced_angles

    axes = ("horizontal", "vertical", "diagonal")
    if lens.is_rotationally_symmetric:
        found = traced_angles(lens, film.width, film.height, wavelength, "paraxial")
        return {axis: None if angle is None else math.degrees(angle) for axis, angle in zip(axes, found, strict=True)}
    efl = lens.front_index * abs(lb.first_order(lens, wavelength).efl)
    return {axis: math.degrees(lb.field_of_view(efl, film, axis)) for axis in axes}


def _close_focus(lens) -> dict[str, float | None]:
    """The plane in focus (mm from the film) of focus groups away from infinity, and the working f-number there.

    None for both of other lenses, and where the lens forms no image.
    """
    import lensbench as lb

    found: dict[str, float | None] = {"focus_distance": None, "working_f_number": None}
    if not (lens.has_focus_groups and lens.positions.close):
        return found
    at_infinity = lens.at(close=0.0)
    try:
        film_distance = (lb.film_distance(at_infinity, math.inf) + lens.surfaces[-1].thickness
                         - at_infinity.surfaces[-1].thickness)
        return {"focus_distance": lb.focused_distance(lens, film_distance),
                "working_f_number": lb.working_f_number(lens, film_distance)}
    except lb.LensError:
        return found


def _intrinsics(lens, film) -> dict[str, float] | None:
    """Focal length and principal point in pixels, of a film of PIXELS across, focused at infinity.

    None where the lens forms no image there, and of one without rotational symmetry.
    """
    import lensbench as lb

    if not lens.is_rotationally_symmetric:
        return None
    film = replace(film, pixels_x=PIXELS, pixels_y=round(PIXELS * film.height / film.width))
    try:
        found = lb.LensCamera(lens, film).intrinsics
    except (lb.FocusError, lb.CameraError):
        return None
    return {"width": film.pixels_x, "height": film.pixels_y, **found._asdict()}
