"""Opening and saving from the window: dialogs, recent and dropped files, pictures of the render and of the window.

A message above the picture says what cannot be opened; the settings then stay as they were.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from imgui_bundle import hello_imgui

from lensbench import lenses
from lensbench.app.bench.build import stop_picture, with_readable_stop
from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.lens_choice import with_lens, with_scene
from lensbench.app.panels.controls.controls import lens_title
from lensbench.app.session.edited_lens import can_save_in_place, save_document
from lensbench.app.session.notices import Request
from lensbench.app.session.snapshots import cleaned
from lensbench.app.settings.settings import Settings
from lensbench.app.window.analyses import Analyses
from lensbench.app.window.dialogs import ExportDialog, FilePrompt, Question
from lensbench.app.window.state import WindowState
from lensbench.lenses import READERS, WRITERS
from lensbench.lenses.file_error import open_regular
from lensbench.lenses.stop_picture import SUFFIXES

MOST_READ = 1 << 20             # bytes of a .toml file to know its kind: no kind has more
RECENT = 8                      # files that are remembered
PICTURES = (".png", ".exr", ".ppm")                      # that carry their settings
SAVED = (*PICTURES, ".pfm")
OF_SCENES = (".obj", ".ply", ".gltf", ".glb", ".jpg", ".jpeg", ".heic", ".tif", ".tiff", ".webp", ".bmp", ".hdr")
QUESTIONS = {
    Request.OPEN_LENS: Question("Open lens", "Lens files", tuple(READERS)),
    Request.SAVE_LENS: Question("Save the lens", "Lens files", tuple(WRITERS), True),
    Request.OPEN_SCENE: Question("Open scene", "Scene files", (".toml",)),
    Request.OPEN_PICTURE: Question("Open the settings of a picture", "Pictures by lensbench", PICTURES),
    Request.OPEN_SETTINGS: Question("Open settings", "Settings", (".toml",)),
    Request.SAVE_SETTINGS: Question("Save the settings", "Settings", (".toml",), True, "settings.toml"),
    Request.SAVE_INTRINSICS: Question("Save the intrinsics", "JSON", (".json",), True, "camera.json"),
    Request.SAVE_RENDER: Question("Save the picture", "Pictures", SAVED, True, "lensbench.png"),
    Request.SAVE_WINDOW: Question("Save a picture of the window", "PNG", (".png",), True, "lensbench-window.png"),
    Request.OPEN_STOP_IMAGE: Question("Choose a picture for the stop", "Pictures", SUFFIXES),
    Request.OPEN_LIGHT_FIELD: Question("Open a light field", "Light fields", (".npz",)),
    Request.SAVE_LIGHT_FIELD: Question("Save the light field", "Light fields", (".npz",), True, "field.npz"),
    Request.SAVE_REFOCUSED: Question("Save the picture of the light field", "Pictures", SAVED, True, "refocused.png"),
    **{request: Question("Save the plot", "Plots and tables", (suffix, *others), True, f"analysis{suffix}")
       for request, suffix, others in ((Request.SAVE_PLOT_CSV, ".csv", (".svg", ".png")),
                                       (Request.SAVE_PLOT_SVG, ".svg", (".png", ".csv")),
                                       (Request.SAVE_PLOT_PNG, ".png", (".svg", ".csv")))},
    Request.SAVE_CARD: Question("Save the card", "PNG", (".png",), True, "card.png"),
    Request.CHOOSE_EXPORT_PATH: Question("Export to", "Pictures", SAVED, True, "lensbench.png"),
}
KINDS = {Request.OPEN_LENS: "lens", Request.OPEN_SCENE: "scene", Request.OPEN_PICTURE: "picture",
         Request.OPEN_SETTINGS: "settings", Request.OPEN_LIGHT_FIELD: "light field"}


class Files:
    """File actions of the window: open, save and export."""

    def __init__(self, state: WindowState, export: ExportDialog, analyses: Analyses):
        self._state, self._export, self._analyses = state, export, analyses
        self.prompt = FilePrompt()

    def ask(self, request: Request) -> None:
        """Ask for the file of a request, one of QUESTIONS; a lens is to be saved under its own name."""
        question = QUESTIONS[request]
        if request is Request.SAVE_LENS:
            title = lens_title(self._state.history.present.lens)
            question = replace(question, name=f"{cleaned(title.replace('f/', 'f'))}.toml")
        self.prompt.ask(request, question)

    def answer(self) -> None:
        """Carry out the request, once its file has been chosen."""
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
        elif request in KINDS:
            self.open(path, KINDS[request])
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
        elif request is Request.SAVE_CARD:
            self._state.card_path = path
        elif request is Request.SAVE_SETTINGS:
            self.save_settings(path)
        elif request is Request.SAVE_INTRINSICS:
            self.save_intrinsics(path)
        elif request in (Request.SAVE_PLOT_CSV, Request.SAVE_PLOT_SVG, Request.SAVE_PLOT_PNG):
            self._analyses.save(path)

    def drop(self, paths: Sequence[str]) -> None:
        """Open files that were dropped on the window, each by its kind."""
        for path in paths:
            self.open(Path(path))

    def open(self, path: Path, kind: str | None = None) -> None:
        """Open a lens, a scene, a light field, settings, or the settings of a picture; kind: None detects it."""
        state, path = self._state, path.expanduser().resolve()
        if (kind or path.suffix.lower()) in ("light field", ".npz"):
            state.light_field.worker.open(path)
            self._remember(path)
            return
        if kind is None and path.suffix.lower() in OF_SCENES:
            state.view.say(f"{path.name} is shown by a scene file that names it: docs/scenes.md tells how")
            return
        try:
            settings = self._opened(path, kind or self._kind(path), state.history.present)
        except (ValueError, OSError) as error:
            text = str(error) if not isinstance(error, OSError) else f"{path}: {error.strerror or error}"
            state.view.say(text)
            return
        if (kind or self._kind(path)) in ("picture", "settings"):
            state.view.follows = False                  # its pixels are the file's
        if settings.lens != state.history.present.lens:
            state.say_findings(settings)
        state.take(state.showable(settings))
        self._remember(path)

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

    @staticmethod
    def _kind(path: Path) -> str:
        if path.suffix.lower() in PICTURES:
            return "picture"
        if path.suffix.lower() == ".toml":
            with open_regular(path) as file:
                text = file.read(MOST_READ).decode("utf-8", errors="replace")
            if re.search(r"^\s*version\s*=", text, re.MULTILINE):
                return "settings"
            return "lens" if "columns" in text or "surfaces" in text else "scene"
        return "lens"

    def _opened(self, path: Path, kind: str, current: Settings) -> Settings:
        if kind in ("picture", "settings"):
            from lensbench.app.session.export import read_settings
            from lensbench.app.session.states import load_settings

            say = partial(self._state.view.say, change=True)
            settings = read_settings(path) if kind == "picture" else load_settings(path)
            settings = with_readable_stop(settings, say)
            constrained(settings)              # raises if the lens file is gone
            return settings
        if kind == "scene":
            from lensbench.app.scenes.scene_file import load_scene

            load_scene(path)
            return with_scene(current, str(path), self._state.chooser.locked)
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
            say(str(error))
            return
        if saved is current and current.edited:
            say(f"{path.name} does not hold the whole lens: the edits stay unsaved until a .toml file has them",
                note=True)
        elif saved is not current:
            state.history.part()
            state.lens_written(saved.lens, saved)
            self._remember(path)
        say(f"Lens saved as {path.name}", done=True)
        for remark in remarks:
            say(f"{path.name}: {remark}", note=True)

    def save_settings(self, path: Path) -> None:
        """Save the current settings."""
        from lensbench.app.session.states import save_settings

        try:
            save_settings(path, self._state.history.present)
        except (ValueError, OSError) as error:
            self._state.view.say(str(error))
        else:
            self._state.view.say(f"Settings saved as {path.name}", done=True)

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
            self._state.view.say(str(error))
        else:
            self._state.view.say(f"Intrinsics saved as {path.name}", done=True)

    def save_picture(self, path: Path, bits: int = 8) -> None:
        """Save the picture with its current samples, and with its settings."""
        from lensbench.app.session.export import save_picture

        if self._state.presenter.field_picture is not None:
            self._state.light_field.save_picture(path, self._state.history.present, bits)
            return
        picture = self._state.picture_now()
        if picture is None:
            self._state.view.say("There is no picture yet", note=True)
            return
        try:
            save_picture(path, picture[0], picture[1], bits, choice=picture[2])
        except (ValueError, OSError) as error:
            self._state.view.say(str(error))
        else:
            self._state.view.say(f"Picture saved as {path.name}", done=True)
