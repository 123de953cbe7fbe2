"""Spaces: the point under the mouse in every space on its way to the film, and the camera's intrinsics.

While the mouse is elsewhere, the point is the one last pointed at, or the middle of the picture.
"""

import math
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, icons_fontawesome_6, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.readouts import intrinsics
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.plots.pixel_rays import thing_at
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.setting_table import VIEWS
from lensbench.app.settings.settings import Settings
from lensbench.core.rendering.aovs import sees_behind
from lensbench.core.text import fixed, significant, true_minus

fa = icons_fontawesome_6
NONE = "–"
NEAR, FAR = 100.0, 100_000.0    # mm: the planes between which the screen's z runs
DIGITS = {"raster": 1, "ndc": 4, "screen": 3, "film": 3, "camera": 3, "world": 3}


def spaces_panel(settings: Settings, raster: tuple[float, float], depth: NDArray[np.float32] | None,
                 image: NDArray[np.float32] | None) -> bool:
    """Draw the table of the raster point `at`; whether the intrinsics are to be saved to a file.

    depth: (h, w) as `lb.depth_map` has it; image: (h, w, 3), the result of the core.
    """
    try:
        of = _camera(settings.picture)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return False
    text, pixels = intrinsics(of), intrinsic_rows(of)
    pitch = _table([*rows(of, raster, depth), *_object(settings, of, raster, depth),
                    *_values(settings, raster, image), *pixels])
    return text is not None and _kept(text, len(pixels) * pitch, pitch)


_camera, _sees_behind = lru_cache(maxsize=2)(camera), lru_cache(maxsize=2)(sees_behind)
Row = tuple[str, tuple[str, ...], str, str]         # name, numbers, unit, meaning


def rows(of: lb.Camera, raster: tuple[float, float], depth: NDArray[np.float32] | None) -> list[Row]:
    """The point in each space."""
    places = of.places([raster], math.nan)
    flat = (
        ("Raster", places.raster[0], DIGITS["raster"], "px", "Pixels from the upper left corner; their middles at +½"),
        ("NDC", places.ndc[0], DIGITS["ndc"], "", "Normalised device coordinates: 0 to 1 across and down the picture"),
        ("Screen", places.screen[0], DIGITS["screen"], "", "The shorter side of the picture spans −1 to 1, y up"),
        ("Film", places.film[0][:2], DIGITS["film"], "mm", "Point on the film; the image is upside down"),
    )
    table = [(name, tuple(number(value, digits) for value in values), unit, meaning)
             for name, values, digits, unit, meaning in flat]
    deep = along(of, raster, depth)
    points = of.places([raster], deep) if deep is not None else places
    for name, values, meaning in (
            ("Camera", points.camera[0], "Camera frame: x right, y up, the camera looks along −z"),
            ("World", points.world[0], "World frame, in which the scene is laid out")):
        numbers = tuple(number(value / 1000.0, DIGITS[name.lower()]) for value in values) \
            if np.isfinite(values).all() else (NONE,)
        table.append((name, numbers, "m", meaning))
    table += _screen_z(of, float(points.camera[0, 2]) if deep is not None else math.nan)
    table.append(("Distance", (NONE if deep is None else number(deep / 1000.0, 3),), "m",
                  "Along the ray, from the camera to the object it meets"))
    return table


def _object(settings: Settings, of: lb.Camera, raster: tuple[float, float],
            depth: NDArray[np.float32] | None) -> list[Row]:
    """The point in the frame of the object that it lies on."""
    scene, deep = cached_scene(settings.scene), along(of, raster, depth)
    ray = of.with_open_stop.generate_rays([raster], [of.pupil_centre])
    if deep is not None and not settings.moves and of.medium is None:       # to the last digit, and not to a pixel
        deep = float(scene.distance(ray.origins, ray.directions)[0])
    thing = None
    if deep is not None and math.isfinite(deep):
        thing = thing_at(scene.objects, ray.origins[0] + deep * ray.directions[0], settings.moment)
    if thing is None:
        return [("Object", (NONE,), "m", "Frame of an object of the scene: only sky or floor is seen here")]
    name, point = thing
    return [("Object", tuple(number(value / 1000.0, 3) for value in point), "m",
             f"Frame of the {name} that is seen here; its centre is the origin")]


def _screen_z(of: lb.Camera, z: float) -> list[Row]:
    """The point's depth by a perspective matrix, and the resolution of a 32-bit buffer there."""
    try:
        spaces = of.spaces(NEAR, FAR)
    except lb.CameraError:
        return []
    meaning = (f"Depth as the perspective matrix has it: 0 at {significant(NEAR / 1000.0)} m from the eye, 1 at "
               f"{significant(FAR / 1000.0)} m; and the smallest step that 32 bits resolve here")
    depth = spaces.eye - z
    if not NEAR <= depth <= FAR:
        return [("Screen z", (NONE,), "", meaning)]
    if not spaces.perspective:
        return [("Screen z", (number((depth - NEAR) / (FAR - NEAR), 5),), "", meaning)]
    value, step = (1.0 - NEAR / depth) / (1.0 - NEAR / FAR), 1000.0 * lb.depth_resolution(depth, NEAR, FAR)
    return [("Screen z", (number(value, 5), significant(step, 2)), "µm", meaning)]


def along(of: lb.Camera, raster: tuple[float, float], depth: NDArray[np.float32] | None) -> float | None:
    """Distance (mm) along the ray of a raster point to the object there; None for sky, no light, or no valid depth.

    depth: (h, w) as `lb.depth_map` has it: along the axis, or along the ray of a camera that sees behind itself.
    """
    if depth is None or depth.shape != (of.film.pixels_y, of.film.pixels_x):
        return None
    x, y = (min(max(int(coordinate), 0), size - 1) for coordinate, size in zip(raster, depth.shape[::-1], strict=True))
    deep = float(depth[y, x])
    if not math.isfinite(deep):
        return None
    ray, distance = of.with_open_stop.generate_rays([raster], [of.pupil_centre]), deep
    if not _sees_behind(of):
        frame = np.linalg.inv(np.reshape(of.placement(0.0, np.array([raster])), (4, 4)))
        start, direction = frame[2, :3] @ ray.origins[0] + frame[2, 3], frame[2, :3] @ ray.directions[0]
        distance = (-deep - start) / direction if direction != 0.0 else math.nan
    return distance if ray.weights[0] > 0.0 and math.isfinite(distance) and distance > 0.0 else None


def number(value: float, digits: int) -> str:
    """With a true minus, and no minus zero."""
    return true_minus(fixed(value, digits)) if math.isfinite(value) else NONE


def _values(settings: Settings, raster: tuple[float, float], image: NDArray[np.float32] | None) -> list[Row]:
    """Row of the pixel's values."""
    if image is None or not (0 <= raster[1] < image.shape[0] and 0 <= raster[0] < image.shape[1]):
        return []
    name = "Light" if settings.view == "picture" else VIEWS[settings.view]
    values = image[int(raster[1]), int(raster[0])].tolist()
    return [(name, tuple(true_minus(significant(value, 3)) for value in values), "",
             "Red, green and blue of the pixel, linear, as it was rendered" if settings.view == "picture" else
             "The quantity that this view shows, as an EXR file stores it")]


def _table(table: list[Row]) -> float:
    """Draw the rows, as close as they have to be; returns how far they are apart."""
    width, line = imgui.get_content_region_avail().x, imgui.get_text_line_height()
    colour, draw = theme.colours(), imgui.get_window_draw_list()
    first = theme.em(4.6)
    unit = max(theme.em(1.9), 0.45 * line + max(imgui.calc_text_size(text).x for _, _, text, _ in table))
    room = (imgui.get_content_region_avail().y - theme.em(0.4)) / len(table)
    pitch = math.floor(min(max(room, 0.92 * line), 1.26 * line))        # closer where the panel is low
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0.0, 0.0))
    for name, numbers, unit_text, meaning in table:
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(width, pitch))
        if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
            imgui.set_item_tooltip(f"{name}: {meaning}\n{', '.join(numbers)} {unit_text}".rstrip())
        y = corner.y + math.floor(0.5 * (pitch - line))
        draw.add_text(ImVec2(corner.x, y), theme.packed(colour.dim), name)
        step = (width - first - unit) / 3.0
        for i, value in enumerate(numbers):
            x = corner.x + first + (i + 3 - len(numbers) + 1) * step - imgui.calc_text_size(value).x
            draw.add_text(ImVec2(math.floor(x), y), theme.packed(colour.dim if value == NONE else colour.strong), value)
        draw.add_text(ImVec2(corner.x + width - unit + round(0.45 * line), y), theme.packed(colour.dim), unit_text)
    imgui.pop_style_var()
    return pitch


# Intrinsics


def intrinsic_rows(of: lb.Camera) -> list[Row]:
    """The intrinsics as rows."""
    try:
        intrinsics = of.intrinsics
    except lb.CameraError as error:
        return [("Intrinsics", (NONE,), "", f"Focal length and principal point: none; {error}")]
    middle = ("cx, cy", (number(intrinsics.cx, 1), number(intrinsics.cy, 1)), "px",
              "Intrinsics: the principal point, where the axis meets the picture")
    if of.gaussian.slope_film == 0.0:               # an orthographic camera
        return [("fx, fy", (significant(intrinsics.fx, 4), significant(intrinsics.fy, 4)), "px/mm",
                 "Intrinsics of parallel rays: pixels across and down that a millimetre of the scene covers"), middle]
    return [("fx, fy", (number(intrinsics.fx, 1), number(intrinsics.fy, 1)), "px",
             "Intrinsics: the focal length in pixels across and down; of a lens, that of its first order"), middle]


def _kept(text: str, up: float, height: float) -> bool:
    """Buttons next to the intrinsics, so far up from here; whether these are to be saved."""
    after = imgui.get_cursor_screen_pos()
    imgui.set_cursor_screen_pos(ImVec2(after.x + theme.em(4.0), after.y - up))
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(theme.em(0.25), 0.0))
    if imgui.button(fa.ICON_FA_COPY + "###Copy intrinsics", ImVec2(0.0, height)):
        imgui.set_clipboard_text(text)
    imgui.set_item_tooltip("Copy intrinsics and pose as JSON")
    imgui.same_line(0.0, theme.em(0.2))
    is_pressed = imgui.button(fa.ICON_FA_FLOPPY_DISK + "###Save intrinsics", ImVec2(0.0, height))
    imgui.set_item_tooltip("Save intrinsics and pose as JSON")
    imgui.pop_style_var()
    imgui.set_cursor_screen_pos(after)
    return is_pressed
