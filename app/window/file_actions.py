"""Opening and saving from the window: dialogs, recent and dropped files, pictures of the render and of the window.

A message above the picture says what cannot be opened; the settings then stay as they were.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from imgui_bundle import hello_imgui

from lensbench import lenses
from lensbench.app.bench.build import stop_picture, with_readable_stop
from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.framing import with_scene
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.panels.controls.controls import lens_title, scene_title
from lensbench.app.scenes.opened_scenes import is_balls
from lensbench.app.scenes.photograph import carries_depth
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.scenes.scene_writer import is_own, own_scene, save_scene, scene_table
from lensbench.app.session.contact_sheet import SUFFIXES as SHEETS
from lensbench.app.session.edited_lens import can_save_in_place, save_document
from lensbench.app.session.file_kinds import PHOTOGRAPHS, SUFFIXES as OPENED, file_kind
from lensbench.app.session.notices import Request
from lensbench.app.session.snapshots import cleaned
from lensbench.app.settings.settings import Settings
from lensbench.app.window.analyses import Analyses
from lensbench.app.window.dialogs import ExportDialog, FilePrompt, Question
from lensbench.app.window.scene_form import Mesh, Opened, Photograph, SceneForm, Sky
from lensbench.app.window.state import WindowState
from lensbench.app.workers.task import Task
from lensbench.lenses import WRITERS
from lensbench.lenses.stop_picture import SUFFIXES

RECENT = 8                      # files that are remembered
SAVED = (".png", ".exr", ".ppm", ".pfm")
STAND = ("position", "yaw", "pitch", "focus_distance")      # of the camera
QUESTIONS = {
    Request.OPEN: Question("Open", "Lenses, scenes, meshes, skies, photographs, settings, light fields", OPENED),
    Request.CHOOSE_DEPTH: Question("Choose the depth map", "Depth maps", (".exr", *PHOTOGRAPHS)),
    Request.SAVE_LENS: Question("Save the lens", "Lens files", tuple(WRITERS), True),
    Request.SAVE_SCENE: Question("Save the scene", "Scene files", (".toml",), True),
    Request.SAVE_SETTINGS: Question("Save the settings", "Settings", (".toml",), True, "settings.toml"),
    Request.SAVE_INTRINSICS: Question("Save the intrinsics", "JSON", (".json",), True, "camera.json"),
    Request.SAVE_RENDER: Question("Save the picture", "Pictures", SAVED, True, "lensbench.png"),
    Request.SAVE_WINDOW: Question("Save a picture of the window", "PNG", (".png",), True, "lensbench-window.png"),
    Request.OPEN_STOP_IMAGE: Question("Choose a picture for the stop", "Pictures", SUFFIXES),
    Request.SAVE_LIGHT_FIELD: Question("Save the light field", "Light fields", (".npz",), True, "field.npz"),
    Request.SAVE_REFOCUSED: Question("Save the picture of the light field", "Pictures", SAVED, True, "refocused.png"),
    **{request: Question("Save the plot", "Plots and tables", (suffix, *others), True, f"analysis{suffix}")
       for request, suffix, others in ((Request.SAVE_PLOT_CSV, ".csv", (".svg", ".png")),
                                       (Request.SAVE_PLOT_SVG, ".svg", (".png", ".csv")),
                                       (Request.SAVE_PLOT_PNG, ".png", (".svg", ".csv")))},
    Request.SAVE_SHEET: Question("Save the sheet: a grid as PNG or JPEG, a moving picture as GIF or WebP", "Sheets",
                                 SHEETS, True, "sheet.png"),
    Request.SAVE_CARD: Question("Save the card", "PNG", (".png",), True, "card.png"),
    Request.CHOOSE_EXPORT_PATH: Question("Export to", "Pictures", SAVED, True, "lensbench.png"),
}


class Files:
    """File actions of the window: open, save and export."""

    def __init__(self, state: WindowState, export: ExportDialog, analyses: Analyses):
        self._state, self._export, self._analyses = state, export, analyses
        self.prompt = FilePrompt()
        self.form = SceneForm(state, self.show)

    def ask(self, request: Request) -> None:
        """Ask for the file of a request, one of QUESTIONS; a lens is to be saved under its own name."""
        question = QUESTIONS[request]
        if request is Request.SAVE_LENS:
            title = lens_title(self._state.history.present.lens)
            question = replace(question, name=f"{cleaned(title.replace('f/', 'f'))}.toml")
        if request is Request.SAVE_SCENE:
            question = replace(question, name=f"{cleaned(scene_title(self._state.history.present.scene))}.toml")
        self.prompt.ask(request, question)

    def answer(self) -> None:
        """Carry out the request, once its file has been chosen; take a scene that has been read."""
        self._take_scene()
        asked = self.prompt.asks
        answer = self.prompt.answer()
        if answer is None:
            if asked is Request.CHOOSE_EXPORT_PATH and self.prompt.asks is None:
                self._export.resume()               # no file was chosen
            return
        request, path = answer
        if self._state.remember:
            hello_imgui.save_lasting_pref("folder", str(path.parent))
        if request is Request.OPEN_STOP_IMAGE:
            self.put_into_stop(path)
        elif request is Request.OPEN:
            self.open(path)
        elif request is Request.CHOOSE_DEPTH:
            self.form.take_depth(path)
        elif request is Request.SAVE_RENDER:
            self.save_picture(path)
        elif request is Request.SAVE_WINDOW:
            self._state.screenshot = path
        elif request is Request.SAVE_LIGHT_FIELD:
            self._state.light_field.worker.save(path)
        elif request is Request.SAVE_REFOCUSED:
            self._state.light_field.save_picture(path, self._state.history.present)
        elif request is Request.CHOOSE_EXPORT_PATH:
            self._export.take_path(path)
        elif request is Request.SAVE_LENS:
            self.save_lens(path)
        elif request is Request.SAVE_SCENE:
            self.save_scene(path)
        elif request in (Request.SAVE_CARD, Request.SAVE_SHEET):
            self._state.shelf_path = request, path
        elif request is Request.SAVE_SETTINGS:
            self.save_settings(path)
        elif request is Request.SAVE_INTRINSICS:
            self.save_intrinsics(path)
        elif request in (Request.SAVE_PLOT_CSV, Request.SAVE_PLOT_SVG, Request.SAVE_PLOT_PNG):
            self._analyses.save(path)

    def drop(self, paths: Sequence[str]) -> None:
        """Open files that were dropped on the window, each by its kind; of two pictures the depth map is the second."""
        for path in sorted(paths, key=lambda path: "depth" in Path(path).stem.lower()):
            self.open(Path(path))

    def open(self, path: Path) -> None:
        """Open a file of any kind: a lens, a scene, a mesh, a sky, a photograph, settings, a light field."""
        state, path = self._state, path.expanduser().resolve()
        try:
            kind = file_kind(path)
            waiting = self.form.waits
            if waiting is not None and path != waiting.path and kind in ("photograph", "sky"):
                self.form.take_depth(path)
                return
            self.form.waits = None
            if kind == "light field":
                state.light_field.worker.open(path)
            elif kind == "scene":
                self._load(path.name, lambda: str(path))
            elif kind == "mesh":
                self.show(Mesh(path))
            elif kind == "sky":
                self.form.base = self._base()
                self.show(Sky(path, base=self.form.base))
            elif kind == "photograph":
                if carries_depth(path):
                    self.show(Photograph(path))
                else:
                    self.form.waits = Photograph(path)
            else:
                self._take(self._opened(path, kind, state.history.present), kind, path.name)
        except (ValueError, OSError) as error:
            text = str(error) if not isinstance(error, OSError) else f"{path}: {error.strerror or error}"
            state.view.say(text, about="open")
            return
        state.view.notices.forget(lambda notice: notice.about == "open")
        self._remember(path)

    def _take(self, settings: Settings, kind: str, name: str) -> None:
        state = self._state
        if kind != "lens" and state.view.follows:
            state.view.follows = False                  # its pixels are the file's
            state.say_locked(name, settings)
        if settings.lens != state.history.present.lens:
            state.say_findings(settings)
        state.take(state.showable(settings))

    def _base(self) -> str:
        """The current scene, if its objects may stand under an opened sky; "" if not."""
        scene = self._state.history.present.scene
        try:
            table = scene_table(scene)
            return "" if "photograph" in table or table.get("enclosed") or is_balls(table) else scene
        except (OSError, ValueError):
            return ""

    def show(self, opened: Opened) -> None:
        """Show a mesh, a sky or a photograph in a scene of its own, and the form with its values."""
        self._load(opened.path.name, lambda: str(own_scene(opened.table(), opened.path.stem)))

    def _load(self, name: str, path: Callable[[], str]) -> None:
        """Write and read a scene in the background."""
        def work(_: Task[str]) -> str:
            scene = path()
            cached_scene(scene)             # raises where it cannot be read
            return scene

        if self._state.opening is not None:
            self._state.opening.cancel()
        self._state.opening = Task(f"Opening {name}", work, self._state.wake)

    def _take_scene(self) -> None:
        """Take the scene that has been read, as one step of undo; or the reason why it cannot be."""
        state, task = self._state, self._state.opening
        if task is None or not task.done:
            return
        state.opening = None
        if task.error is not None:
            state.view.say(task.message, about="open")
        elif task.result is not None:
            current = state.history.present
            chosen = with_scene(current, task.result, state.chooser.locked)
            if self._keeps_camera(current.scene, task.result):
                chosen = replace(chosen, **{name: getattr(current, name) for name in STAND})
            state.history.part()
            state.take(chosen)
            self.form.visible, self.form.waits = is_own(task.result), None

    @staticmethod
    def _keeps_camera(before: str, after: str) -> bool:
        """Whether the camera stays where it is: before the same subject, turned or under another sky."""
        if not is_own(after):
            return False
        try:
            subject = cached_scene(before).subject
        except (ValueError, OSError):
            return False
        return subject == cached_scene(after).subject and (subject is not None or is_own(before))

    def put_into_stop(self, path: Path) -> None:
        """Give the stop the shape of a picture; a message says why one cannot be read."""
        state, name = self._state, str(path.expanduser().resolve())
        try:
            stop_picture(name)
        except ValueError as error:
            state.view.say(str(error))
            return
        state.take(replace(state.history.present, stop_image=name))

    def _remember(self, path: Path) -> None:
        state = self._state
        state.recent = [path, *(other for other in state.recent if other != path)][:RECENT]
        if state.remember:
            hello_imgui.save_lasting_pref("recent", json.dumps([str(file) for file in state.recent]))

    def _opened(self, path: Path, kind: str, current: Settings) -> Settings:
        if kind in ("picture", "settings"):
            from lensbench.app.session.export import read_settings
            from lensbench.app.session.states import load_settings

            say = partial(self._state.view.say, change=True)
            settings = read_settings(path) if kind == "picture" else load_settings(path)
            settings = with_readable_stop(settings, say)
            constrained(settings)              # raises if the lens file is gone
            return settings
        lenses.load(path)                       # raises if it cannot be read now
        return with_lens(current, str(path), self._state.chooser.locked)

    def save_edited(self) -> None:
        """Save the edited lens in its own file; one of the library has none, and is saved as another file."""
        current = self._state.history.present
        if not current.edited:
            self._state.view.say("The lens has no edits to save")
        elif can_save_in_place(current):
            self.save_lens(Path(current.lens))
        else:
            self.ask(Request.SAVE_LENS)

    def save_lens(self, path: Path) -> None:
        """Save the lens in the format of the suffix; messages name what the format cannot hold.

        The file of an edited lens becomes the lens; where the format cannot hold all of it, the edits stay marked as
        unsaved.
        """
        state = self._state
        say, current = state.view.say, state.history.present
        try:
            saved, remarks = save_document(current, path)
        except (ValueError, OSError) as error:
            say(str(error), about="lens")
            return
        if saved is current and current.edited:
            say(f"{path.name} does not hold the whole lens: the edits stay unsaved until a .toml file has them",
                note=True)
        elif saved is not current:
            state.history.part()
            state.lens_written(saved.lens, saved)
            self._remember(path)
        say(f"Lens saved as {path.name}", done=True, about="lens")
        for remark in remarks:
            say(f"{path.name}: {remark}", note=True)

    def save_scene(self, path: Path) -> None:
        """Save the scene as a scene file, which becomes the scene; the notice names the files that were copied."""
        state, path = self._state, path.resolve()
        try:
            copied = save_scene(state.history.present.scene, path)
        except (ValueError, OSError) as error:
            state.view.say(f"The scene cannot be saved: {error}", about="scene")
            return
        state.take(replace(state.history.present, scene=str(path)))
        self._remember(path)
        state.view.say(f"Scene saved as {path.name}" + (f", with a copy of {', '.join(copied)}" if copied else ""),
                       done=True)

    def save_settings(self, path: Path) -> None:
        """Save the current settings."""
        from lensbench.app.session.states import save_settings

        try:
            save_settings(path, self._state.history.present)
        except (ValueError, OSError) as error:
            self._state.view.say(str(error), about="settings")
        else:
            self._state.view.say(f"Settings saved as {path.name}", done=True, about="settings")

    def save_intrinsics(self, path: Path) -> None:
        """Save the camera's intrinsics and pose as JSON."""
        from lensbench.app.bench.camera_kinds import camera
        from lensbench.app.bench.readouts import intrinsics
        from lensbench.app.session.export import replacing

        try:
            of = camera(self._state.history.present)
            _ = of.intrinsics                           # raises where there are none, with the reason
            text = intrinsics(of)
            assert text is not None
            with replacing(path) as file:
                file.write_text(text + "\n", encoding="utf-8")
        except (ValueError, OSError) as error:
            self._state.view.say(str(error), about="intrinsics")
        else:
            self._state.view.say(f"Intrinsics saved as {path.name}", done=True, about="intrinsics")

    def save_picture(self, path: Path, bits: int = 8) -> None:
        """Save the picture with its current samples, and with its settings."""
        from lensbench.app.session.export import save_picture

        if self._state.presenter.field_picture is not None:
            self._state.light_field.save_picture(path, self._state.history.present, bits)
            return
        picture = self._state.picture_now()
        if picture is None:
            self._state.view.say("There is no picture yet", note=True, about="picture")
            return
        try:
            save_picture(path, picture[0], picture[1], bits, choice=picture[2])
        except (ValueError, OSError) as error:
            self._state.view.say(str(error), about="picture")
        else:
            self._state.view.say(f"Picture saved as {path.name}", done=True, about="picture")
