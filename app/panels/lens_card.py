"""The lens card: provenance, what the lens consists of, its check, and its glasses in a map of n_d over V_d."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import published
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap
from lensbench.app.session.lens_shelf import film_name
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import Measurements, Task
from lensbench.core.text import f_number_text, fixed, significant
from lensbench.lenses.tables.counts import counts
from lensbench.lenses.tables.system_text import system_rows

LABEL = 5.6                     # em, the column of labels
MAP = 11.0                      # em, the height of the map of glasses
DISPERSIONS, INDICES = (15.0, 95.0), (1.42, 2.02)       # ends of the map
NEAR = 9.0                      # pixels from the mouse to a point of the map


@dataclass(frozen=True)
class GlassRow:
    """A medium of the lens that is no air: the surface before it, its glass, and its size (mm)."""

    surface: int
    glass: lb.Glass
    thickness: float
    diameter: float


class LensCardState:
    """The check of the current lens, made in the background."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        self.checks: Measurements[lb.Lens, tuple[lenses.Finding, ...]] = Measurements(_checked, wake, keep_all=False)


def _checked(lens: lb.Lens, _task: Task[tuple[lenses.Finding, ...]]) -> tuple[lenses.Finding, ...]:
    return tuple(lenses.check(lens))


def lens_card_panel(settings: Settings, state: LensCardState, lit: tuple[int, ...] = ()) -> None:
    """Draw the card into the current window, which scrolls.

    lit: indices of the surfaces under the mouse in the section; the glasses at them are marked.
    """
    if not settings.has_lens:
        paragraph("This camera has no lens")
        return
    try:
        lens = published(settings.plain("zoom", "blades", "blade_rotation", "roundness", "stop_image", "medium",
                                        "immersed"))
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return
    state.checks.want(lens)
    paragraph(lens.name or settings.lens, True)
    theme.small()
    card = lenses.card(settings.lens) if not settings.edited else None
    for label, text in (*provenance(lens), *([("Good for", ", ".join(card.uses))] if card and card.uses else [])):
        _row(label, text)
    _check(lens, state)
    table = glass_rows(lens)
    if table:
        imgui.dummy(ImVec2(0.0, theme.em(0.3)))
        fronts = {lit[0]} if len(lit) == 2 else {surface - near for surface in lit for near in (0, 1)}     # or both
        marked = frozenset(row.surface for row in table if row.surface in fronts)
        _glass_map(table, marked)
        _glass_table(table, "rims" in lens.estimates, marked)
    imgui.pop_font()


@lru_cache(maxsize=8)
def provenance(lens: lb.Lens) -> list[tuple[str, str]]:
    """Labels and texts of what is known of a lens; a star marks what is estimated."""
    count = counts(lens)
    groups = f"{count.elements} in {count.groups} group{'' if count.groups == 1 else 's'}"
    aspheres = f", {count.aspheres} asphere{'' if count.aspheres == 1 else 's'}" if count.aspheres else ""
    moving = f", {count.focus_groups} focus group{'' if count.focus_groups == 1 else 's'}" if count.focus_groups else ""
    stated = [f"{significant(lens.stated_efl)} mm" if lens.stated_efl else "",
              f_number_text(lens.stated_f_number) if lens.stated_f_number else ""]
    lengths = [lb.first_order(lens.at(zoom=zoom), lens.reference_wavelength).efl
               for zoom in ((0.0, 1.0) if lens.zooms else (None,))]
    year = f"{lens.year}{'*' if 'year' in lens.estimates else ''}" if lens.year else ""
    rows = [("Kind", lens.kind), ("Maker", lens.maker), ("Designer", lens.designer), ("Year", year),
            ("Patent", lens.patent), ("Source", lens.source if lens.source != lens.patent else ""),
            ("Computed", f"{'–'.join(significant(efl, 4) for efl in lengths)} mm  "
             f"{f_number_text(lb.f_number_at_infinity(lens), 2)}"),
            ("Published", "  ".join(text for text in stated if text)),
            ("Made for", film_name(lens.film_size) if lens.film_size else ""),
            *((label.removeprefix("Designed ").capitalize(), text) for label, text in system_rows(lens.system)),
            ("Elements", groups + aspheres + moving), ("Estimated *", lens.estimates), ("Notes", lens.notes)]
    return [(label, text) for label, text in rows if text]


@lru_cache(maxsize=8)
def glass_rows(lens: lb.Lens) -> tuple[GlassRow, ...]:
    """The glasses from the scene to the film."""
    return tuple(GlassRow(i, front.glass, front.thickness, 2.0 * max(front.semi_diameter, back.semi_diameter))
                 for i, (front, back) in enumerate(pairwise(lens.surfaces)) if front.glass.n_d != 1.0)


def _row(label: str, text: str, colour: theme.Colour | None = None) -> None:
    imgui.text_disabled(label)
    imgui.same_line(theme.em(LABEL) + imgui.get_style().window_padding.x)
    imgui.push_text_wrap_pos(0.0)
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour or theme.colours().text)))
    imgui.text_unformatted(text)
    imgui.pop_style_color()
    imgui.pop_text_wrap_pos()


def _check(lens: lb.Lens, state: LensCardState) -> None:
    """The result of the check: its doubts in the colour of warnings, then its notes."""
    checks = state.checks
    if lens in checks.problems:
        _row("Check", checks.problems[lens])
        return
    if lens not in checks.found:
        _row("Check", "…")
        return
    findings = checks.found[lens]
    if not findings:
        _row("Check", "nothing found")
    for i, finding in enumerate(sorted(findings, key=lambda doubt: doubt.severity is not lenses.Severity.WARNING)):
        is_doubt = finding.severity is lenses.Severity.WARNING
        colour = theme.colours().warning if is_doubt else theme.colours().text
        where = "" if finding.surface is None else f"Surface {finding.surface}: "
        _row("" if i else "Check", where + finding.message, colour)


def _glass_map(table: tuple[GlassRow, ...], marked: frozenset[int]) -> None:
    """The glasses over their Abbe numbers; the number at a point is that of the surface before the glass."""
    known = [row for row in table if row.glass.v_d is not None]
    if not known:
        return
    n, v = np.array([row.glass.n_d for row in known]), np.array([row.glass.v_d for row in known], float)
    limits = (min(DISPERSIONS[0], float(v.min()) - 3.0), max(DISPERSIONS[1], float(v.max()) + 3.0),
              min(INDICES[0], float(n.min()) - 0.02), max(INDICES[1], float(n.max()) + 0.02))
    points = begin_glass_map("Glass map", MAP, limits, v, n, implot.Flags_.no_inputs)       # the wheel scrolls the card
    if points is None:
        return
    colour, pixel, draw = theme.colours(), theme.scale(), implot.get_plot_draw_list()
    labelled: list[ImVec2] = []
    for row, point, index, abbe in zip(known, points, n.tolist(), v.tolist(), strict=True):
        draw.add_circle_filled(point, 4.0 * pixel, theme.packed((*colour.glass(index, abbe)[:3], 0.9)))
        draw.add_circle(point, 4.0 * pixel, theme.packed(colour.glass_outline), 0, pixel)
        if row.surface in marked:
            draw.add_circle(point, 6.5 * pixel, theme.packed(colour.strong), 0, 2.0 * pixel)
        if all(abs(point.x - other.x) + abs(point.y - other.y) > theme.em(0.9) for other in labelled):
            draw.add_text(ImVec2(point.x + 6.0 * pixel, point.y - 0.5 * imgui.get_text_line_height()),
                          theme.packed(colour.dim), str(row.surface))
            labelled.append(point)
    end_glass_map()
    nearest = nearest_glasses(points)
    if nearest and imgui.is_window_hovered():
        row = known[nearest[0]]
        imgui.set_tooltip(f"Behind surface {row.surface}{f': {row.glass.name}' if row.glass.name else ''}\n"
                          f"n_d {fixed(row.glass.n_d, 5)}, V_d {fixed(row.glass.v_d or 0.0, 2)}")


def begin_glass_map(name: str, height: float, limits: tuple[float, float, float, float], v_d: np.ndarray,
                    n_d: np.ndarray, flags: int = 0, once: bool = False) -> list[ImVec2] | None:
    """Begin the plot of n_d over V_d, which falls to the right as makers draw it; the glasses in pixels.

    None where the plot is not seen. height: in em. limits: ends of V_d and of n_d. once: the user may change them.
    """
    if not implot.begin_plot(name, ImVec2(-1.0, theme.em(height)), PLOT_FLAGS | flags):
        return None
    implot.setup_axes("V_d", "n_d", AXIS_FLAGS | implot.AxisFlags_.invert, AXIS_FLAGS)
    implot.setup_axes_limits(*limits, implot.Cond_.once if once else implot.Cond_.always)
    implot.setup_finish()
    implot.push_plot_clip_rect()
    return [ImVec2(x, y) for x, y in PlotMap.current(log=False, falling=True).pixels(v_d, n_d).tolist()]


def nearest_glasses(points: Sequence[ImVec2]) -> list[int]:
    """Indices of the points nearest to the mouse, several where they coincide; none where all are farther than NEAR."""
    mouse = imgui.get_mouse_pos()
    away = [abs(point.x - mouse.x) + abs(point.y - mouse.y) for point in points]
    least = min(away, default=math.inf)
    return [i for i, distance in enumerate(away) if distance == least] if least < NEAR * theme.scale() else []


def end_glass_map() -> None:
    """End the plot that `begin_glass_map` began."""
    implot.pop_plot_clip_rect()
    implot.end_plot()


def _glass_table(table: tuple[GlassRow, ...], is_estimated: bool, marked: frozenset[int]) -> None:
    """One row a glass; a star marks estimated diameters."""
    flags = imgui.TableFlags_.sizing_stretch_prop | imgui.TableFlags_.pad_outer_x
    if not imgui.begin_table("Glasses", 5, flags):
        return
    for title in ("", "n_d", "V_d", f"ø{'*' if is_estimated else ''} mm", "Glass"):
        imgui.table_setup_column(title)
    imgui.table_headers_row()
    for row in table:
        imgui.table_next_row()
        if row.surface in marked:
            imgui.table_set_bg_color(imgui.TableBgTarget_.row_bg0, theme.packed(theme.colours().frame_active))
        glass = row.glass
        for text in (str(row.surface), fixed(glass.n_d, 4), "–" if glass.v_d is None else fixed(glass.v_d, 1),
                     fixed(row.diameter, 1), glass.name):
            imgui.table_next_column()
            imgui.text_unformatted(text)
    imgui.end_table()
