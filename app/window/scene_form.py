"""The small window of an opened mesh, sky or photograph: what its scene takes from the user, applied at once.

It follows the scene of the settings, so that undo shows the values of the scene before.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import number, paragraph, picked
from lensbench.app.panels.controls.controls import scene_title
from lensbench.app.scenes.opened_scenes import (
    AXES, MATERIALS, is_balls, is_metric, mesh_table, photograph_table, sky_table, standing
)
from lensbench.app.scenes.scene_writer import is_own, read_table
from lensbench.app.scenes.table_values import Table
from lensbench.app.session.notices import Request
from lensbench.app.window.state import WindowState

INDENT, WIDTH = 8.0, 12.0       # em of the fields
MATERIAL_NAMES = dict(zip(MATERIALS, ("Of the file", "Clay", "Glaze", "Metal", "Glass"), strict=True))
MEANINGS = {"disparity": "Bright is near", "distance": "Bright is far"}


@dataclass(frozen=True)
class Mesh:
    """A mesh on its floor. height: mm. turn: degrees."""

    path: Path
    height: float | None = None
    up: str = "y"
    turn: float = 0.0
    material: str = ""

    def table(self) -> Table:
        """The table of its scene."""
        return mesh_table(self.path, self.height, self.up, self.turn, self.material)

    def edited(self, requests: set[Request]) -> "Mesh":
        """Draw its controls."""
        height = number("Height", 0.1 * (self.height or 0.0), (0.1, 1e6), 0.2, "%.1f cm",
                        "Height of the object on its floor", WIDTH, INDENT)
        turn = number("Turn", self.turn, (-180.0, 180.0), 0.5, "%.0f°", "Rotation about the vertical", WIDTH, INDENT)
        up = _choice("Up", self.up, {axis: axis for axis in AXES}, "The axis of the file that points up")
        material = _choice("Material", self.material, MATERIAL_NAMES, "The materials of the file, or one for all of it")
        return replace(self, height=10.0 * height, turn=turn, up=up, material=material)


@dataclass(frozen=True)
class Sky:
    """A picture of all directions around a scene. turn: degrees. base: the scene under it; "": balls."""

    path: Path
    turn: float = 0.0
    brightness: float = 1.0
    base: str = ""

    def table(self) -> Table:
        """The table of its scene."""
        return sky_table(self.path, self.base, self.turn, self.brightness)

    def edited(self, requests: set[Request], base: str) -> "Sky":
        """Draw its controls. base: the scene whose objects may stand under it; "" for none."""
        turn = number("Turn", self.turn, (-180.0, 180.0), 0.5, "%.0f°", "Moves what is ahead to the left",
                      WIDTH, INDENT)
        brightness = number("Brightness", self.brightness, (0.01, 100.0), 0.01, "%.2f ×", "Factor on its light",
                            WIDTH, INDENT)
        names = {"": "Three balls", **({base: scene_title(base)} if base else {})}
        return replace(self, turn=turn, brightness=brightness,
                       base=_choice("Under it", self.base, names, "What stands under the sky"))


@dataclass(frozen=True)
class Photograph:
    """A photograph with its depth map. depth: its own file, "": in the photograph. fov: degrees. near, far: mm."""

    path: Path
    fov: float | None = None
    depth: str = ""
    depth_is: str = "disparity"
    near: float = 1000.0
    far: float = 10_000.0

    def table(self) -> Table:
        """The table of its scene."""
        return photograph_table(self.path, self.fov, self.depth, self.near, self.far, self.depth_is)

    def edited(self, requests: set[Request]) -> "Photograph":
        """Draw its controls."""
        imgui.align_text_to_frame_padding()
        imgui.text_disabled("Depth map")
        imgui.same_line(theme.em(INDENT))
        if imgui.button(f"{theme.shortened(Path(self.depth).name, theme.em(WIDTH - 1.0)) or 'In the photograph'}"
                        "###Depth map", ImVec2(theme.em(WIDTH), 0.0)):
            requests.add(Request.CHOOSE_DEPTH)
        imgui.set_item_tooltip("The file that holds the distances: PNG, TIFF or OpenEXR. A click chooses another")
        fov = number("Field of view", self.fov or 0.0, (1.0, 170.0), 0.2, "%.1f°", "Angle across the photograph",
                     WIDTH, INDENT)
        values = replace(self, fov=fov)
        if not self.depth:
            return values
        values = replace(values, depth_is=_choice("Depth is", self.depth_is, MEANINGS, "What bright means in the map"))
        if is_metric(self.depth):
            return values
        near = number("Nearest", 0.001 * self.near, (0.01, 1e5), 0.01, "%.2f m", "The least distance of the map",
                      WIDTH, INDENT)
        far = number("Farthest", 0.001 * self.far, (0.01, 1e5), 0.05, "%.2f m", "The greatest distance of the map",
                     WIDTH, INDENT)
        return replace(values, near=1000.0 * near, far=1000.0 * max(far, 1.001 * near))


Opened = Mesh | Sky | Photograph


def opened_of(scene: str) -> Opened | None:
    """What a scene of the program's own folder shows; None for another kind. OSError, ValueError, LookupError."""
    table = read_table(scene)
    if (entry := table.get("photograph")) is not None:
        return Photograph(Path(entry["image"]), entry.get("fov"), **{
            key: entry[key] for key in ("depth", "depth_is", "near", "far") if key in entry})
    if "image" in (sky := table.get("sky", {})):
        return Sky(Path(sky["image"]), sky.get("turn", 0.0), sky.get("brightness", 1.0),
                   "" if is_balls(table) else scene)
    if len(meshes := table.get("mesh", [])) == 1 and "height" in meshes[0]:
        up, turn = standing(meshes[0].get("rotation", AXES["y"]))
        return Mesh(Path(meshes[0]["file"]), meshes[0]["height"], up, turn,
                    meshes[0].get("material", {}).get("kind", ""))
    return None


def _choice(label: str, value: str, names: dict[str, str], tip: str) -> str:
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(label)
    imgui.same_line(theme.em(INDENT))
    return picked(label, value, names, tip, theme.em(WIDTH))


class SceneForm:
    """The window; visible until it is closed or another scene is chosen."""

    def __init__(self, state: WindowState, show: Callable[[Opened], None]):
        self.visible = False
        self.waits: Photograph | None = None        # a photograph that needs its depth map
        self.base = ""                              # the scene before a sky was opened
        self._state, self._show = state, show
        self._scene = ""
        self._shown: Opened | None = None           # what the scene of the settings shows
        self._draft: Opened | None = None           # the same with the changes of the controls

    def take_depth(self, path: Path) -> None:
        """Use a depth map for the photograph that waits for one, or that is shown."""
        photograph = self.waits or self._draft
        if isinstance(photograph, Photograph):
            self._show(replace(photograph, depth=str(path)))

    def draw(self) -> None:
        """Call it in every frame."""
        scene = self._state.history.present.scene
        if scene != self._scene:
            self._scene, self._shown = scene, None
            if is_own(scene):
                try:
                    self._shown = opened_of(scene)
                except (OSError, ValueError, LookupError, TypeError):      # the worker reports it
                    self._shown = None
            self._draft, self.visible = self._shown, self.visible and self._shown is not None
        draft = self.waits or (self._draft if self.visible else None)
        if draft is None:
            return
        view = imgui.get_main_viewport()
        imgui.set_next_window_pos(ImVec2(view.work_pos.x + theme.em(0.5), view.work_pos.y + view.work_size.y
                                         - theme.em(2.5)), imgui.Cond_.appearing, ImVec2(0.0, 1.0))
        imgui.set_next_window_size(ImVec2(theme.em(22.0), 0.0))
        flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_collapse \
            | imgui.WindowFlags_.no_resize
        for part in (imgui.Col_.window_bg, imgui.Col_.title_bg, imgui.Col_.title_bg_active):
            imgui.push_style_color(part, imgui.ImVec4(*theme.colours().popup))
        imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
        waited = self.waits                             # its buttons may end it
        shown, still_open = imgui.begin(f"{draft.path.name}###Opened", True, flags)
        if shown:
            draft = self._edited(draft)
        imgui.end()
        imgui.pop_style_var()
        imgui.pop_style_color(3)
        if not still_open:
            self.visible, self.waits = False, None
        elif waited is None:
            self._apply(draft)

    def _edited(self, draft: Opened) -> Opened:
        requests = self._state.requests
        if self.waits is not None:
            paragraph("A photograph becomes a scene by its depth map: drop the file on the window, or choose it")
            if imgui.button("Choose depth map…"):
                requests.add(Request.CHOOSE_DEPTH)
            imgui.same_line()
            if imgui.button("Use as sky"):
                self.waits = None
                self._show(Sky(draft.path))
            imgui.set_item_tooltip("A picture of all directions, twice as wide as high")
            return draft
        draft = draft.edited(requests, draft.base or self.base) if isinstance(draft, Sky) else draft.edited(requests)
        if imgui.button("Save scene as…"):
            requests.add(Request.SAVE_SCENE)
        imgui.set_item_tooltip("Write a scene file of your own; undo takes the opening back")
        return draft

    def _apply(self, draft: Opened) -> None:
        """Show the draft once no control is held."""
        changed = draft != self._draft
        self._draft = draft
        if draft != self._shown and not changed and not imgui.is_any_item_active() and self._state.opening is None:
            self._shown = draft
            self._show(draft)
