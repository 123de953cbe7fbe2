"""The left column: lists of lens, scene, film and camera, the dials, and buttons with popups.

Every control returns changed settings, within the range of the lens.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.camera_kinds import unfit
from lensbench.app.bench.constraints import (
    constrained, with_body, with_camera, with_equivalent_film, with_film, with_layout, with_projection
)
from lensbench.app.bench.framing import (
    SIZE, frame_height, framed, framing_of, framings, resized, with_framing, with_scene
)
from lensbench.app.bench.lens_choice import FILM, FOCUS
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import angle, check_box, drop_list, explain, padlock, picked
from lensbench.app.panels.controls import popups
from lensbench.app.panels.controls.dials import dial_count, dials
from lensbench.app.panels.controls.flare_popup import FlareState, flare_in_use, flare_popup
from lensbench.app.panels.controls.popups import can_disperse, dispersion_popup, focus_popup
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene
from lensbench.app.session.edited_lens import edit_mark
from lensbench.app.session.lens_shelf import film_name, format_name
from lensbench.app.session.notices import Request
from lensbench.app.settings.bodies import bodies_named
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
from lensbench.app.settings.setting_table import FOV_AXES, FRAMINGS, LAYOUTS, PROJECTIONS
from lensbench.app.settings.settings import Settings
from lensbench.core.lens_models.polynomial import DEGREES
from lensbench.core.text import significant

BODY_ROWS = 6                   # of the list of camera bodies, which scrolls
FILM_SIDES = (0.1, 1000.0)      # mm, of a custom film
DEGREE_TIP = "Degree of the polynomial in film point and pupil: the higher, the nearer to the lens and the slower.\n" \
             "The panel Models charts one against the other"


@dataclass
class Chooser:
    """The state of the open lists, and their requests to the window."""

    film: tuple[float, float] = (36.0, 24.0)
    body: str = ""                                          # what is typed to find a camera body
    equivalent: bool = False                                # another film keeps field of view and depth of field
    locked: set[str] = field(default_factory=set)           # LOCKS that another lens leaves as they are
    requests: set[Request] = field(default_factory=set)     # of the window
    flare: FlareState = field(default_factory=FlareState)
    heights: dict[str, float] = field(default_factory=dict)     # pixels that the content of each popup needs
    kept: tuple[tuple, float] | None = None                 # the subject's size, and where the camera showed it so

    def sized(self, before: Settings, after: Settings) -> Settings:
        """Settings after another field of view: with the padlock of the framing, the subject keeps its size."""
        if after == before or SIZE not in self.locked or FOCUS in self.locked:
            return after
        try:
            place = before.position, before.focus_distance
            height = self.kept[1] if self.kept and self.kept[0] == place else frame_height(before)
            if height is None:
                return after
            after = resized(after, height)
        except (ValueError, OSError):                       # the worker reports the lens
            return after
        self.kept = (after.position, after.focus_distance), height
        return after


def controls_panel(settings: Settings, chooser: Chooser) -> Settings:
    """Draw the controls into the current window; the changed settings."""
    _lens(settings, chooser)
    settings = _scene(settings, chooser)
    settings = _layout(settings) if settings.kind.panorama else _film(settings, chooser)
    settings = _camera(settings)
    for name in settings.kind.lists:
        settings = LISTS[name](settings)
    # The dials share the room that is left
    count, dial_height = dial_count(settings), imgui.get_text_line_height() + theme.em(2.6)
    free = imgui.get_content_region_avail().y - count * dial_height - theme.em(0.3) - 1.15 * imgui.get_frame_height()
    gap = min(max(free / (2.0 * count + 1.0), theme.scale()), theme.em(0.45))
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(imgui.get_style().item_spacing.x, gap))
    imgui.dummy(ImVec2(0.0, theme.em(0.3)))
    settings = dials(settings, chooser.locked, chooser.sized)
    imgui.pop_style_var()
    return _more(settings, chooser)


def _more(settings: Settings, chooser: Chooser) -> Settings:
    """A row of flat buttons below the dials, each with a popup of less common settings."""
    colour = theme.colours()
    parts: list[tuple[str, str, bool, Callable[[Settings], Settings]]] = [
        ("Shutter", "Shutter time, keyframes of the camera, rolling shutter", popups.shutter_in_use(settings),
         popups.motion_popup),
        ("Noise", "The sensor that records the picture, and its noise", popups.sensor_in_use(settings),
         popups.sensor_popup)]
    if settings.has_stop:
        parts.append(("Flare", "Ghosts and stars of lights; blades and coating, which shape them",
                      flare_in_use(settings), partial(flare_popup, state=chooser.flare, requests=chooser.requests)))
    if settings.has_lens:
        parts.append(("Tilt/shift", "How the film is focused; tilt, swing, rise, shift, curvature",
                      settings.focus_position != "auto" or popups.film_dials_in_use(settings), focus_popup))
    if can_disperse(settings):
        parts.append(("Colour", "Dispersion of the glasses: the colour errors of the lens",
                      settings.dispersion != "auto", dispersion_popup))
    parts.append(("Air", "Fog or water in front of the camera", popups.medium_in_use(settings), popups.air_popup))
    style = imgui.get_style()
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(3.5 * theme.scale(), style.frame_padding.y))
    for name, tip, used, content in parts:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if used else colour.dim)))
        if imgui.button(f"{name}###Drawer {name.partition('/')[0]}"):
            imgui.open_popup(name)
        imgui.pop_style_color(2)
        explain(tip)
        # Over the column, so that the picture stays in sight; over the buttons where there is too little room above
        width, above = imgui.get_window_width(), imgui.get_item_rect_min().y
        room = max(above, min(chooser.heights.get(name, 0.0), imgui.get_main_viewport().size.y), theme.em(8.0))
        imgui.set_next_window_pos(ImVec2(imgui.get_window_pos().x, room), imgui.Cond_.always, ImVec2(0.0, 1.0))
        imgui.set_next_window_size(ImVec2(width, 0.0))
        imgui.set_next_window_size_constraints(ImVec2(width, 0.0), ImVec2(width, room))
        if imgui.begin_popup(name):
            imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(style.item_spacing.x, theme.scale()))
            settings = content(settings)
            imgui.pop_style_var()
            chooser.heights[name] = imgui.get_cursor_pos_y() + style.window_padding.y
            imgui.end_popup()
        imgui.same_line(0.0, 0.0)
    imgui.pop_style_var()
    return settings


# The lists


def _labelled(label: str) -> None:
    """The label of a list, dim at the left; the list comes after it."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(label)
    imgui.same_line(theme.em(3.95) + imgui.get_style().window_padding.x)


@lru_cache(maxsize=64)
def lens_title(name: str) -> str:
    """The title of a library lens, or the name of a file."""
    card = lenses.card(name)
    return Path(name).stem if card is None else card.title


def lens_name(settings: Settings) -> str:
    """The title of the lens of these settings, with a mark where it has unsaved edits."""
    return lens_title(settings.lens) + edit_mark(settings)


def _lens(settings: Settings, chooser: Chooser) -> None:
    """The lens, on a button that looks like a list: it opens the browser."""
    colour, used = theme.colours(), settings.has_lens
    _labelled("Lens")
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    imgui.push_style_var(imgui.StyleVar_.button_text_align, ImVec2(0.0, 0.5))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.text if used else colour.dim)))
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*colour.frame))
    if imgui.button(f"{theme.shortened(lens_name(settings), room - theme.em(2.2))}###Lens", ImVec2(room, 0.0)):
        chooser.requests.add(Request.BROWSE_LENSES)
    imgui.pop_style_color(2)
    imgui.pop_style_var()
    tip = "The lens: a design of the library, or a file of your own. A click opens the browser (L)\n" \
          "A file can also be dropped on the window"
    explain(tip if used else f"{tip}\nThis camera has none: choosing one changes the camera to one with a lens")
    angle(corner, room)


def scene_title(name: str) -> str:
    """The name of a built-in scene in words; of a scene file the name that it states, else that of the file."""
    if name in lb.SCENES:
        return name.replace("-", " ").capitalize()
    try:
        return " ".join(cached_scene(name).name.split()) or Path(name).stem
    except (SceneFileError, OSError):               # the worker reports it
        return Path(name).stem


def _scene(settings: Settings, chooser: Chooser) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        for name in lb.SCENES:
            if imgui.selectable(scene_title(name), name == settings.scene)[0]:
                chosen = with_scene(settings, name, chooser.locked)
        imgui.separator()
        if imgui.selectable("Open…", False)[0]:
            chooser.requests.add(Request.OPEN)

    corner = imgui.get_cursor_screen_pos()
    _labelled("Scene")
    drop_list("Scene", scene_title(settings.scene), "What the camera looks at", content,
              imgui.get_content_region_avail().x - theme.em(2.2))
    imgui.same_line(0.0, 4.0 * theme.scale())
    if imgui.button(f"{icons_fontawesome_6.ICON_FA_EXPAND}###Framing", ImVec2(-1.0, 0.0)):
        imgui.open_popup("Framings")
    imgui.set_item_tooltip("Framing: moves the camera along its direction until the subject fills the picture so far,\n"
                           "and focuses there")
    if imgui.begin_popup("Framings"):
        current, named = framing_of(settings), framings(settings.scene)
        for name, framing in named.items():
            if name == "subject" and any(framing[1:] == other[1:] for other in named.values() if other is not framing):
                continue                                    # it has a name of the body
            if imgui.selectable(FRAMINGS[name], framing[1:] == current[1:])[0]:
                chosen = with_framing(settings, name)
        imgui.end_popup()
    padlock(SIZE, chooser.locked, ImVec2(corner.x + theme.em(2.85), corner.y + imgui.get_style().frame_padding.y))
    return chosen


def _film(settings: Settings, chooser: Chooser) -> Settings:
    chosen = settings

    def content() -> None:
        nonlocal chosen
        if imgui.is_window_appearing():
            chooser.film = (settings.film_width, settings.film_height)
        change = with_equivalent_film if chooser.equivalent else with_film
        for name, (width, height) in lb.FORMATS.items():
            if imgui.selectable(name, name == film_name((settings.film_width, settings.film_height)))[0]:
                chosen = change(settings, width, height)
        imgui.separator()
        body_name = _bodies(settings, chooser)
        if body_name is not None:
            chosen = with_body(settings, body_name, change)
            if body_name:
                chooser.locked.add(FILM)                # another lens leaves the camera that one owns
            imgui.close_current_popup()
        imgui.separator()
        chooser.equivalent = check_box("Keep the picture", chooser.equivalent)
        imgui.set_item_tooltip("With another film, focal length and f-number change by as much as its diagonal: the\n"
                               "field of view and the depth of field stay. Pin the picture as A first, to compare")
        imgui.align_text_to_frame_padding()
        imgui.text_disabled("Custom")
        imgui.same_line()
        width, height = chooser.film
        imgui.set_next_item_width(theme.em(3.6))
        _, width = imgui.input_double("×##Film width", width, 0.0, 0.0, "%.4g")
        imgui.same_line()
        imgui.set_next_item_width(theme.em(3.6))
        _, height = imgui.input_double("mm##Film height", height, 0.0, 0.0, "%.4g")
        chooser.film = (width, height)
        imgui.same_line()
        possible = all(FILM_SIDES[0] <= side <= FILM_SIDES[1] for side in (width, height))
        imgui.begin_disabled(not possible)
        if imgui.button("Set"):
            chosen = change(settings, width, height)
            imgui.close_current_popup()
        imgui.end_disabled()
        if not possible:
            imgui.text_colored(imgui.ImVec4(*theme.colours().warning),
                               f"A side measures {significant(FILM_SIDES[0])} to {significant(FILM_SIDES[1])} mm")

    corner = imgui.get_cursor_screen_pos()
    _labelled("Format")
    body = settings.sensor
    drop_list("Film", format_name(settings), "The film's size, or the camera body by its name" if body is None else
              f"{body.facts}.\nThe picture is rendered at {settings.pixels_x} × {settings.pixels_y}; blur is counted "
              "in pixels of the sensor", content)
    if settings.has_lens:
        padlock(FILM, chooser.locked, ImVec2(corner.x + theme.em(2.85), corner.y + imgui.get_style().frame_padding.y))
    if chosen == settings:
        return settings
    if chosen.focal_length != settings.focal_length:        # the picture is kept
        return constrained(chosen)
    return chooser.sized(settings, chosen) if SIZE in chooser.locked else constrained(framed(chosen, chooser.locked))


def _bodies(settings: Settings, chooser: Chooser) -> str | None:
    """Draw the camera bodies that match what is typed; the chosen one, "" for none, None for no choice."""
    chosen = None
    imgui.set_next_item_width(-1.0)
    _, chooser.body = imgui.input_text_with_hint("##Camera body", "Camera, such as Sony A7 IV", chooser.body)
    rows = bodies_named(chooser.body)
    count = min(max(len(rows), 1) + (settings.sensor is not None), BODY_ROWS)
    if imgui.begin_child("Bodies", ImVec2(0.0, count * imgui.get_text_line_height_with_spacing())):
        if settings.sensor is not None and imgui.selectable("No camera by name", False)[0]:
            chosen = ""
        for body in rows:
            if imgui.selectable(body.name, body is settings.sensor)[0]:
                chosen = body.name
            imgui.set_item_tooltip(f"{body.facts}.\nLocks the format, so that another lens keeps it")
        if not rows:
            imgui.text_disabled("No such camera")
    imgui.end_child()
    return chosen


def _camera(settings: Settings) -> Settings:
    """One list of both settings: the models of the lens, then the cameras without one."""
    chosen = settings

    def content() -> None:
        nonlocal chosen
        imgui.text_disabled("With the lens")
        for name, model in LENS_MODELS.items():
            reason = unfit(settings, name)
            imgui.begin_disabled(bool(reason))
            if imgui.selectable(model.title, settings.has_lens and name == settings.lens_model)[0]:
                chosen = replace(with_camera(settings, "lens"), lens_model=name)
            imgui.end_disabled()
            imgui.set_item_tooltip(reason or model.tooltip)
        imgui.separator()
        imgui.text_disabled("Without a lens")
        for name, kind in CAMERA_KINDS.items():
            if kind.has_lens:
                continue
            if imgui.selectable(kind.title, name == settings.camera)[0]:
                chosen = with_camera(settings, name)
            imgui.set_item_tooltip(kind.tooltip)

    fitted = settings.has_lens and LENS_MODELS[settings.lens_model].has_degree
    _labelled("Camera")
    drop_list("Camera", settings.camera_title, "The camera, and how it models its lens", content,
              imgui.get_content_region_avail().x - theme.em(3.4 if fitted else 0.0))
    if fitted:
        imgui.same_line(0.0, 4.0 * theme.scale())
        degrees = {degree: f"{degree}" for degree in DEGREES}
        chosen = replace(chosen, degree=picked("Degree", settings.degree, degrees, DEGREE_TIP))
    return chosen if chosen == settings else constrained(chosen)


def _layout(settings: Settings) -> Settings:
    _labelled("Layout")
    chosen = picked("Layout", settings.layout, LAYOUTS, "Map from directions to the panorama")
    return settings if chosen == settings.layout else with_layout(settings, chosen)


def _projection(settings: Settings) -> Settings:
    _labelled("Rule")
    chosen = picked("Rule", settings.projection, PROJECTIONS,
                    "Map from the angle θ to the axis to the distance r from the middle of the picture")
    return settings if chosen == settings.projection else with_projection(settings, chosen)


def _fov_axis(settings: Settings) -> Settings:
    _labelled("Along")
    axis = picked("Along", settings.fov_axis, FOV_AXES, "The side of the film for the field of view")
    return settings if axis == settings.fov_axis else constrained(replace(settings, fov_axis=axis))


LISTS: dict[str, Callable[[Settings], Settings]] = {"projection": _projection, "fov_axis": _fov_axis}
