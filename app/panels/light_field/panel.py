"""The panel *Light field*: record the light through every part of the pupil; choose focus and aperture afterwards."""

import math
from dataclasses import replace

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

import lensbench as lb
from lensbench.app.bench.light_field_query import (
    SHOWN, ArrayRecording, Look, Recorded, Recording, f_number_match, format_place, with_aperture
)
from lensbench.app.bench.tone import develop
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, small_note, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.panels.light_field.capture_form import Form, recording_form
from lensbench.app.panels.light_field.pupil_pad import (
    array_body, coverage_greys, figures, millimetres, pupil_grid, pupil_pad, pupil_picture
)
from lensbench.app.panels.light_field.slices import Strip, depth_body, moment_chooser, rays_body
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.session.notices import Request
from lensbench.app.settings import dial_scales, text_values
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.light_field_worker import LightFieldWorker
from lensbench.core.text import fixed, significant

fa = icons_fontawesome_6
SHOWN_TIPS = {
    "camera": "The picture is the camera's",
    "focus": "The picture is computed from the light field, with this focus and aperture",
    "view": "The picture is one view, as a single cell of the pupil sees the scene",
    "rays": "The light of the clicked pixel by direction, and of its line by view",
    "depth": "The distance of every pixel, by the parallax of the views; and a picture with everything in focus",
}


def light_field_panel(settings: Settings, look: Look, form: Form, worker: LightFieldWorker, strip: Strip) -> Look:
    """Draw the panel; returns the look after the user's changes. strip: makes a texture of a small linear picture."""
    recording = worker.recording
    if recording is None or form.open:
        recording_form(settings, form, worker.task, recording is not None)
        return look
    _head(recording, form)
    if worker.task is not None:
        task_progress(worker.task)
    if isinstance(recording, ArrayRecording):
        return array_body(look, recording, worker.field_picture)
    before = look
    look = replace(look, show=toggles("Show", SHOWN, look.show, SHOWN_TIPS, 0.0))
    if look.show == "view":
        return _view(look, recording, settings)
    if look.show == "rays":
        return rays_body(look, recording, settings, strip)
    if look.show == "depth":
        return depth_body(look, recording, worker, form)
    look = _focus(look, recording, worker, form)
    if look != before and look.show == before.show == "camera":
        look = replace(look, show="focus")
    return look


# The recording


def _head(recording: Recorded, form: Form) -> None:
    """The size of the recording, and its buttons."""
    (across, down), film = recording.views, recording.settings.film
    right = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    imgui.align_text_to_frame_padding()
    imgui.text_unformatted(f"{across} × {down} views")
    imgui.set_item_tooltip(f"{film.pixels_x} × {film.pixels_y} pixels each, {recording.settings.samples} samples a "
                           f"pixel: {fixed(recording.size / 1e6, 0, grouped=True)} MB")
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
    width = theme.em(1.75)
    imgui.same_line(right - 4.0 * width)
    for icon, name, request, tip in (
            (fa.ICON_FA_CIRCLE_DOT, "new", None, "Record another"),
            (fa.ICON_FA_FOLDER_OPEN, "open", Request.OPEN, "Open a light field"),
            (fa.ICON_FA_FLOPPY_DISK, "save", Request.SAVE_LIGHT_FIELD, "Save the light field (.npz)"),
            (fa.ICON_FA_IMAGE, "picture", Request.SAVE_REFOCUSED, "Save the picture that it shows (.png, .exr …)")):
        if imgui.button(f"{icon}###Light field {name}", ImVec2(width, 0.0)):
            if request is None:
                form.open = True
            else:
                form.requests.add(request)
        imgui.set_item_tooltip(tip)
        imgui.same_line(0.0, 0.0)
    imgui.pop_style_color()
    imgui.new_line()


# Its pictures


def _focus(look: Look, recording: Recording, worker: LightFieldWorker, form: Form) -> Look:
    """Focus, aperture and viewpoint, their figures, and the comparison with the camera's own picture."""
    field = recording.field
    nearest = max(recording.nearest, 10.0)
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(imgui.get_style().item_spacing.x, theme.scale()))
    distance = dial("Refocus", look.distance,
                    dial_scales.focus_scale(nearest * 1.0001, recording.settings.focus_distance),
                    "Focus distance, measured as the camera measures it. In the amber zone neighbouring views\n"
                    "lie at most a pixel apart; outside it blur breaks into dots", recording.clear_range)
    look = replace(look, distance=distance)
    shown = look.f_number or field.f_number
    f_number = dial("Synthetic aperture", shown, dial_scales.aperture_scale(field.f_number, field.f_number),
                    "A part of the recorded aperture, summed from its views; it cannot be wider")
    if f_number != shown:
        look = with_aperture(look, f_number, field)
    imgui.pop_style_var()
    look = moment_chooser(look, recording)
    look = pupil_pad(look, recording)
    _figures(look, recording, worker)
    _comparison(look, worker, form)
    return look


def _figures(look: Look, recording: Recording, worker: LightFieldWorker) -> None:
    """At the right of the pad: viewpoint, number of views, their shift, time."""
    field = recording.field
    apart, (near, far) = field.apart(recording.seen(look.distance)), recording.clear_range
    field_picture = worker.field_picture
    taken = float(field.shares(look.f_number, look.view).sum())
    figures((
        ("Centre", format_place(look.view), "The middle of the aperture in the pupil, in pupil radii: right and up"),
        ("Views", f"{significant(taken, 3)} of {field.places[..., 0].size}", "Number of views within the aperture"),
        ("Shift", f"{fixed(apart, 2)} px", "Shift between neighbouring views"),
        ("Time", "–" if field_picture is None else f"{fixed(1000.0 * field_picture.seconds, 0)} ms",
         "To compute the picture")))
    unknown = 0.0 if field_picture is None or field_picture.look != look.asked else 1.0 - field_picture.covered
    if unknown > 0.0:
        small_note(f"{significant(100.0 * unknown, 2)} % of the picture lies beyond what all views recorded; black: no "
                   "view saw it", True)
    if not near <= look.distance <= far:
        small_note(f"Outside {text_values.format_distance(near)} to {text_values.format_distance(far)}, neighbouring "
                   "views lie more than a pixel apart, and blur breaks into dots: record more views", True)


def _comparison(look: Look, worker: LightFieldWorker, form: Form) -> None:
    field_picture = worker.field_picture
    ready = (worker.task is None and field_picture is not None and field_picture.look == look.asked
             and not field_picture.coarse and look.show == "focus")
    imgui.begin_disabled(not ready)
    if imgui.button("Compare with the camera"):
        form.requests.add(Request.COMPARE)
    imgui.end_disabled()
    if imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_disabled | imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Render with the camera what is shown here, focused the same, through the same part of its "
                          "pupil and the same part of its exposure;\nkeep it as A, and show the difference")
    psnr = worker.psnr(look.asked)
    if psnr is not None:
        imgui.same_line()
        imgui.text_unformatted("identical" if math.isinf(psnr) else f"{fixed(psnr, 1)} dB")
        imgui.set_item_tooltip("Peak signal to noise: linear light, clipped to 0 … 1. The camera's own picture is A")


def _sensor(look: Look, raw: lb.RawPicture, settings: Settings) -> None:
    """The sensor of a plenoptic camera behind one microlens, and the match of the f-numbers."""
    x, y = look.pixel
    behind = develop(raw.behind(x, y)[::-1], settings.exposure, settings.tone)
    pupil_picture(behind)
    figures((("Lens", f"{x}, {y}", "The microlens that was clicked on, across and down; at the left its pixels"),
             *f_number_match(raw.camera)))


def _view(look: Look, recording: Recording, settings: Settings) -> Look:
    """One cell of the pupil, or the sensor of a plenoptic camera."""
    field = recording.field
    if recording.raw is not None:
        look = replace(look, sensor=toggles("Show", {False: "One cell", True: "Sensor"}, look.sensor, {
            False: "What one cell of the pupil sees: the pixels at one place behind all microlenses",
            True: "The raw picture: behind each microlens a small picture of the pupil"}))
        if look.sensor:
            _sensor(look, recording.raw, settings)
            return look
    look = moment_chooser(look, recording)
    paragraph("Light that each cell passes to the clicked pixel")
    look = pupil_grid(look, recording, coverage_greys(recording, look.pixel))
    i, j = look.cell
    u, v = field.places[j, i]
    x, y = look.pixel
    covered = field.coverage[j, i]
    figures((
        ("View", f"{i + 1}, {j + 1}", "Across from the left, up from below"),
        ("Centre", format_place((u, v)), "The cell's middle in the pupil, in pupil radii"),
        ("", millimetres((u * recording.pupil_radius, v * recording.pupil_radius)),
         "The same in mm, on the plane of the exit pupil"),
        ("Share", f"{fixed(100.0 * float(covered[y, x]), 1)} %",
         "Coverage: the part of a full cell's light that reaches the clicked pixel, times cos⁴θ"),
        ("Most", f"{fixed(100.0 * float(covered.max()), 1)} %", "The greatest coverage of any pixel")))
    return look
