"""Panel of the read-outs: every figure in one table, each with a tooltip that defines it."""

import math
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench.app.bench.build import coating, design, focus_text, picture_wavelength, published
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.readouts import SOFT, Readings, colours
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, wrapped_tooltip
from lensbench.app.plots.blur import focus_words
from lensbench.app.plots.comparison import difference
from lensbench.app.settings.setting_table import LIMITS
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_angle, format_distance, format_length
from lensbench.core.text import f_number_text, fixed, significant
from lensbench.lenses.tables.paraxial import is_d_line

NONE = "–"


@dataclass(frozen=True)
class Status:
    """Progress of the rendering: samples a second over the whole picture, frames a second, samples a pixel."""

    rays_per_second: float = 0.0
    fps: float = 0.0
    samples: int = 0


@dataclass(frozen=True)
class Row:
    """One read-out. gap: space above it. amber: it concerns the depth of field."""

    name: str
    value: str
    unit: str
    meaning: str
    gap: bool = False
    amber: bool = False


@dataclass(frozen=True)
class PairedRow:
    """One read-out of A and B in words, and B less A, or "" where the two read the same or are no single numbers."""

    name: str
    a: str
    b: str
    apart: str
    unit: str
    meaning: str
    gap: bool = False


def readouts_panel(settings: Settings, status: Status, other: Settings | None = None,
                   other_status: Status | None = None) -> None:
    """Draw the table in the rest of the window.

    other: the settings A while they are compared; their figures are shown before those of the current settings.
    """
    width = imgui.get_content_region_avail().x
    if width < 24.0:
        return
    if other is not None:
        _compared(settings, status, other, other_status or Status(), width)
        return
    got = readings(settings)
    colour, line = theme.colours(), imgui.get_text_line_height()
    draw = imgui.get_window_draw_list()
    pitch, unit_width = round(1.22 * line), theme.em(1.9)
    if words := focus_words(settings):
        paragraph(words)
        imgui.set_item_tooltip("Depth of field, from the film; blur of a point at infinity, of the picture's width")
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0.0, 0.0))
    for row in own(settings, rows(settings, got, status)):
        if row.gap:
            imgui.dummy(ImVec2(width, round(0.4 * line)))
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(width, pitch))
        if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
            wrapped_tooltip([row.meaning], 24.0)
        y = corner.y + math.floor(0.5 * (pitch - line))
        right = corner.x + width - unit_width
        extent = imgui.calc_text_size(row.value).x
        tint = colour.dim if row.value == NONE else colour.amber_text if row.amber else colour.strong
        # A long value on a narrow panel covers the column of the unit, then a part of the name
        room = right - corner.x - extent
        if room >= imgui.calc_text_size(row.name).x + 0.4 * line:
            draw.add_text(ImVec2(corner.x, y), theme.packed(colour.dim), row.name)
        else:
            draw.push_clip_rect(corner, ImVec2(corner.x + max(room - 0.4 * line, 0.0), corner.y + pitch), True)
            draw.add_text(ImVec2(corner.x, y), theme.packed(colour.dim), row.name)
            draw.pop_clip_rect()
        draw.add_text(ImVec2(math.floor(right - extent), y), theme.packed(tint), row.value)
        if row.value != NONE:
            draw.add_text(ImVec2(right + round(0.45 * line), y), theme.packed(colour.dim), row.unit)
    imgui.pop_style_var()
    if got.reason:
        imgui.dummy(ImVec2(width, round(0.4 * line)))
        paragraph(got.reason)


def _compared(settings: Settings, status: Status, other: Settings, other_status: Status, width: float) -> None:
    """A, B and the difference of each figure in three columns; figures too wide for these in two lines."""
    theme.small()
    colour, line, draw = theme.colours(), imgui.get_text_line_height(), imgui.get_window_draw_list()
    pitch, gap = round(1.22 * line), theme.em(0.5)
    table = [row for row in paired_rows(settings, status, other, other_status) if (row.a, row.b) != (NONE, NONE)]
    names = min(max(imgui.calc_text_size(row.name).x for row in table), 0.42 * width)
    column, ends = columns(width, names, gap + max(imgui.calc_text_size(row.apart).x for row in table))
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0.0, 0.0))
    header = PairedRow("", "A", "B", "B − A", "", "Reference, current, difference")
    for row in [header, *table]:
        if row.gap:
            imgui.dummy(ImVec2(width, round(0.4 * line)))
        wide = any(imgui.calc_text_size(value).x > column - gap for value in (row.a, row.b))
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(width, (2.0 if wide else 1.0) * pitch))
        if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
            wrapped_tooltip([f"{row.meaning}\n\nA {row.a} {row.unit}\nB {row.b} {row.unit}"], 24.0)
        y = corner.y + math.floor(0.5 * (pitch - line))
        draw.add_text(ImVec2(corner.x, y), theme.packed(colour.dim), theme.shortened(row.name, names))
        places = ((row.a, width, 0.0), (row.b, width, pitch)) if wide else \
            ((row.a, ends[0], 0.0), (row.b, ends[1], 0.0))
        for (value, end, down), tint in zip(places, (theme.compared(), colour.strong), strict=True):
            draw.add_text(ImVec2(math.floor(corner.x + end - imgui.calc_text_size(value).x), y + down),
                          theme.packed(colour.dim if value == NONE else tint), value)
        if not wide:
            draw.add_text(ImVec2(math.floor(corner.x + width - imgui.calc_text_size(row.apart).x), y),
                          theme.packed(colour.dim), row.apart)
    imgui.pop_style_var()
    imgui.pop_font()


def columns(width: float, names: float, apart: float) -> tuple[float, tuple[float, float]]:
    """Width of the columns of A and B, and where they end; pixels.

    width: of the panel. names, apart: of the names at the left and of the differences at the right, with their gap; all
    three columns are equally wide where these leave room.
    """
    column = (width - names - max(apart, (width - names) / 3.0)) / 2.0
    return column, (names + column, names + 2.0 * column)


def paired_rows(settings: Settings, status: Status, other: Settings, other_status: Status) -> list[PairedRow]:
    """The rows of two settings by their names, in the order of the current ones.

    What follows a comma in a name, as the coating of a T-stop, may differ; the meaning alone then has it.
    """
    mine = rows(settings, readings(settings), status)
    theirs = {_key(row): row for row in rows(other, readings(other), other_status)}
    pairs = []
    for row in mine:
        a = theirs.pop(_key(row), None)
        value, b = (a.value if a is not None else NONE), row.value
        same_unit = a is None or a.unit == row.unit
        apart = difference(value, b) if same_unit else ""
        apart += f" {row.unit}" if apart and row.unit and apart[-1].isdigit() else ""
        name = row.name if a is None or a.name == row.name else _key(row)
        meaning = row.meaning if name == row.name or a is None else f"{row.meaning}\n\nA: {a.name}. B: {row.name}"
        pairs.append(PairedRow(name, value, b, apart, row.unit, meaning, row.gap))
    pairs += [PairedRow(row.name, row.value, NONE, "", row.unit, row.meaning) for row in theirs.values()]
    return pairs


def _key(row: Row) -> str:
    return row.name.partition(",")[0]


def own(settings: Settings, table: list[Row]) -> list[Row]:
    """The rows with a value; for a camera with a lens all rows, so that none moves while a dial turns."""
    if settings.has_lens and settings.has_stop:
        return table
    rows: list[Row] = []
    gap = False
    for row in table:
        gap = gap or row.gap
        if row.value != NONE:
            rows.append(replace(row, gap=gap and bool(rows)))
            gap = False
    return rows


def rows(settings: Settings, got: Readings, status: Status) -> list[Row]:
    """The table: optics, field, sharpness, places, then the progress of the rendering."""
    limit = NONE if got.limit is None else f"{fixed(1000.0 * got.limit, 1)} µm"
    field = NONE if got.fov_horizontal is None or got.fov_vertical is None else \
        f"{format_angle(got.fov_horizontal)} × {format_angle(got.fov_vertical)}"
    start = settings.kind.measured_from
    return [
        Row("Focal length", *_length(got.efl), "Effective focal length (EFL), f: from the rear principal plane P′ "
                                               "to the rear focus F′"),
        *_wavelength(settings, got),
        *_across(got),
        Row("Back focal length", *_length(got.bfl), "Back focal length (BFL): from the last vertex "
                                                    "to the rear focus F′"),
        Row("f-number", _f_number(got.f_number), "", "N as set: focal length over the diameter of the entrance pupil, "
                                                     "for an object at infinity"),
        Row("Working f-number", _f_number(got.working_f_number), "",
            "1 / (2 sin θ′) of the real marginal ray at the current focus, with clear apertures and magnification"),
        _t_stop(settings, got),
        _colours(settings),
        Row("Field of view", field, "", "Horizontal × vertical, of the film that is used or of a smaller image circle, "
                                        "focused at infinity: by rays of the real lens, with its distortion; "
                                        "2 atan(h / 2f) for an ideal one, and for one with cylinders", gap=True),
        Row("Diagonal", NONE if got.fov_diagonal is None else format_angle(got.fov_diagonal), "",
            "Field of view across the film's diagonal"),
        Row("35 mm equivalent", *_length(got.equivalent), "The focal length that sees the same diagonal on a "
                                                          "36 × 24 mm film"),
        Row("Equivalent f-number", _f_number(None if got.f_number is None or got.efl is None else lb.equivalent(
            got.efl, settings.film, got.f_number).f_number), "",
            "The f-number that gives the same depth of field on a 36 × 24 mm film, with the equivalent focal length: "
            "the same field, blur and light in all"),
        Row("Depth of field", *_range(got.near_limit, got.far_limit),
            f"From the near to the far limit, measured from {start}: the circle of confusion (CoC) stays below "
            f"{limit}, {LIMITS.get(settings.limit, settings.limit).lower()}{SOFT if got.soft else ''}",
            gap=True, amber=not got.soft),
        Row("Blur in focus", NONE if got.focusing.blur is None else significant(1000.0 * got.focusing.blur, 3), "µm",
            f"Of a point in focus on the axis: 2√2 × the rms radius of its real rays. {focus_text(got.focusing)}",
            amber=True),
        Row("Hyperfocal", *_distance(got.hyperfocal), "Focused here, all is sharp from half this distance to infinity"),
        Row("Nearest focus", *_distance(got.nearest_focus), f"Nearest distance from {start} that the lens can focus"),
        Row("Magnification", _magnification(got.magnification), "", "Size of the image to that of the object "
                                                                    "in focus, m"),
        Row("Exposure value", _exposure_value(settings, got), "EV",
            "log2 N²/t with the working f-number and the shutter time, at ISO 100: EV − log2 ISO/100"),
        Row("Film distance", *_length(got.film_distance, 2),
            "From the last vertex to the film" if settings.has_lens else "From the hole to the film", gap=True),
        Row("Entrance pupil", *_diameter(got.entrance_pupil),
            "Entrance-pupil diameter E (with blades: the circle of equal area)"),
        Row("Exit pupil", *_diameter(got.exit_pupil),
            "Exit-pupil diameter E′ (with blades: the circle of equal area)"),
        Row("Airy disk", NONE if got.airy is None else fixed(1000.0 * got.airy, 1), "µm",
            "Diameter of the first dark ring of a point of light, 2.44 λ N: what diffraction alone does"),
        Row("Rays", NONE if status.rays_per_second <= 0.0 else significant(status.rays_per_second / 1e6, 3), "M/s",
            "Camera rays traced into the scene a second", gap=True),
        Row("Frames", NONE if status.fps <= 0.0 else fixed(status.fps, 0), "fps", "Frames of the window a second"),
        Row("Samples", f"{status.samples}", "", "Samples of every pixel so far"),
    ]


def _wavelength(settings: Settings, got: Readings) -> list[Row]:
    """The row of the primary wavelength of a lens that was not designed for the d line."""
    if is_d_line(got.wavelength):
        return []
    picture = ("The picture is that of this wavelength too" if not colours(settings).used else
               "The picture sees the visible spectrum")
    return [Row("  at", significant(1000.0 * got.wavelength), "nm",
                "The primary wavelength of the design: that of focal lengths, focus, depth of field, pupils and Airy "
                f"disk. {picture}")]


def _t_stop(settings: Settings, got: Readings) -> Row:
    """The T-stop with the coating that it assumes."""
    meaning = "Estimate: the f-number of a lens without losses that would be as bright, N / √transmission"
    if got.t_number is None:
        return Row("T-stop", NONE, "", meaning)
    of = coating(settings, design(settings))
    return Row(f"T-stop, {of.name}", _f_number(got.t_number, "T "), "",
               f"{meaning}. Assumes {of.name} glass: {of.why}. The button “Flare” sets the coating")


def _across(got: Readings) -> list[Row]:
    """The additional rows of a lens with cylinders."""
    if got.foci is None:
        return []
    squeeze = (f". Objects are {significant(got.across / got.efl, 3)} times as wide on the film"
               if got.across and got.efl else "")
    return [
        Row("Focal length across", *_length(got.across),
            f"Across the picture, in the section x–z; the focal length above is that of y–z, up the picture{squeeze}"),
        Row("Foci across, up", " ".join(_signed(focus) for focus in got.foci), "mm",
            "How far behind the film the lens, by its first order, focuses the light of its sections x–z and y–z: what "
            "lies between is its astigmatism on the axis. The film lies where the blur of the whole pupil is least"),
    ]


def _signed(length: float) -> str:
    if not math.isfinite(length):
        return "∞"
    return f"{'−' if length < 0.0 else '+'}{fixed(abs(length), 2)}"


def _colours(settings: Settings) -> Row:
    """The wavelengths of the picture, and the reason."""
    value, wavelength = NONE, None
    try:
        used, why = colours(settings)[1:]
        if settings.has_lens:
            wavelength = picture_wavelength(settings, published(settings))
            value = "24 wavelengths" if used else "d line"
    except (ValueError, OSError) as error:
        why = str(error)
    if wavelength is not None:
        return Row("Colours", significant(1000.0 * wavelength), "nm", why)
    return Row("Colours", value, "", why)


def _length(length: float | None, digits: int | None = None) -> tuple[str, str]:
    if length is None:
        return NONE, "mm"
    if digits is not None:
        return fixed(length, digits), "mm"
    sign = "−" if length < 0.0 else ""
    return sign + format_length(abs(length)).removesuffix(" mm"), "mm"


def _diameter(diameter: float | None) -> tuple[str, str]:
    value, unit = _length(diameter)
    return (value if value == NONE else f"ø {value}"), unit


def _distance(distance: float | None) -> tuple[str, str]:
    return (NONE if distance is None else format_distance(distance).removesuffix(" m")), "m"


def _range(near: float | None, far: float | None) -> tuple[str, str]:
    if near is None or far is None:
        return NONE, "m"
    digits = 3 if near < 9995.0 else 2 if near < 99950.0 else 1
    while digits < 6 and fixed(near / 1000.0, digits - 1) == fixed(far / 1000.0, digits - 1):
        digits += 1
    return f"{fixed(near / 1000.0, digits)} – {fixed(far / 1000.0, digits)}", "m"


def _exposure_value(settings: Settings, got: Readings) -> str:
    f_number = got.working_f_number or got.f_number
    return NONE if f_number is None else fixed(lb.Exposure(f_number, settings.shutter, settings.iso).ev100, 1)


def _f_number(f_number: float | None, sign: str = "f/") -> str:
    """Two digits after the point, so that f-numbers and T-numbers can be compared."""
    return NONE if f_number is None else f_number_text(f_number, 2 if f_number < 9.995 else 1, sign)


def _magnification(magnification: float | None) -> str:
    if magnification is None:
        return NONE
    if magnification <= 0.0:
        return "1 : ∞"
    ratio = significant(1.0 / magnification if magnification < 1.0 else magnification, 3)
    return f"1 : {ratio}" if magnification < 1.0 else f"{ratio} : 1"
