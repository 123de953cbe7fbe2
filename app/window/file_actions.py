"""Opening and saving from the window: dialogs, recent and dropped files, pictures of the render and of the window.

Whatever cannot be opened is said above the picture, and the settings stay as they were.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lensbench import lenses
from lensbench.app.state.build import design
from lensbench.app.state.constraints import constrained, with_model
from lensbench.app.state.pose import at_home
from lensbench.app.state.settings import LOOK, MOTION, Settings
from lensbench.app.window.dialogs import Question
from lensbench.lenses import READERS, WRITERS

if TYPE_CHECKING:
    from lensbench.app.window.session import Session

RECENT = 8                      # files that are remembered
PICTURES = (".png", ".exr", ".ppm")                      # that carry their settings
SAVED = (*PICTURES, ".pfm")
QUESTIONS = {
    "lens": Question("lens", "Open lens", "Lens files", tuple(READERS)),
    "save lens": Question("save lens", "Save the lens", "Lens files", tuple(WRITERS), True, "lens.toml"),
    "scene": Question("scene", "Open scene", "Scene files", (".toml",)),
    "picture": Question("picture", "Open the settings of a picture", "Pictures by lensbench", PICTURES),
    "settings": Question("settings", "Open settings", "Settings", (".toml",)),
    "save settings": Question("save settings", "Save the settings", "Settings", (".toml",), True, "settings.toml"),
    "intrinsics": Question("intrinsics", "Save the intrinsics", "JSON", (".json",), True, "camera.json"),
    "screenshot": Question("screenshot", "Save the picture", "Pictures", SAVED, True, "lensbench.png"),
    "window": Question("window", "Save a picture of the window", "PNG", (".png",), True, "lensbench-window.png"),
    "light field": Question("light field", "Open a light field", "Light fields", (".npz",)),
    "save light field": Question("save light field", "Save the light field", "Light fields", (".npz",), True,
                                 "field.npz"),
    "refocused": Question("refocused", "Save the picture of the light field", "Pictures", SAVED, True,
                          "refocused.png"),
    "export": Question("export", "Export to", "Pictures", SAVED, True, "lensbench.png"),
}


class Files:
    """What the window does with files."""

    def __init__(self, session: "Session"):
        self._session = session
        self.recent: list[Path] = []

    def ask(self, kind: str) -> None:
        """Ask for a file: a key of QUESTIONS."""
        self._session.prompt.ask(QUESTIONS[kind])

    def answer(self) -> None:
        """Do what was asked for, once there is an answer."""
        answer = self._session.prompt.answer()
        if answer is None:
            return
        purpose, path = answer
        if purpose == "screenshot":
            self.save_picture(path)
        elif purpose == "window":
            self._session.photograph(path)
        elif purpose == "save light field":
            self._session.light_field.worker.save(path)
        elif purpose == "refocused":
            self._session.light_field.save_picture(path)
        elif purpose == "export":
            self._session.export.take_path(path)
        elif purpose == "save lens":
            self.save_lens(path)
        elif purpose == "save settings":
            self.save_settings(path)
        elif purpose == "intrinsics":
            self.save_intrinsics(path)
        else:
            self.open(path, purpose)

    def drop(self, paths: Sequence[str]) -> None:
        """Files have been dropped on the window: each is opened as what it is."""
        for path in paths:
            self.open(Path(path))

    def open(self, path: Path, kind: str | None = None) -> None:
        """Take a lens, a scene, a light field, settings or those of a picture; without a kind, by what it is."""
        session, path = self._session, path.expanduser().resolve()
        if (kind or path.suffix.lower()) in ("light field", ".npz"):
            session.light_field.worker.open(path)
            self._remember(path)
            return
        try:
            settings = self._opened(path, kind or self._kind(path), session.history.present)
        except (ValueError, OSError) as error:
            text = str(error) if not isinstance(error, OSError) else f"{path}: {error.strerror or error}"
            session.view.say(text)
            return
        if settings.lens != session.history.present.lens:
            session.say_findings(settings)
        settings = session.showable(settings)
        session.edited = settings
        session.history.edit(settings, False, 0.0)
        session.apply()
        self._remember(path)

    def _remember(self, path: Path) -> None:
        self.recent = [path, *(other for other in self.recent if other != path)][:RECENT]
        self._session.keep_recent()

    @staticmethod
    def _kind(path: Path) -> str:
        if path.suffix.lower() in PICTURES:
            return "picture"
        if path.suffix.lower() == ".toml":
            text = path.read_text(encoding="utf-8", errors="replace")
            if re.search(r"^\s*version\s*=", text, re.MULTILINE):
                return "settings"
            return "lens" if "columns" in text or "surfaces" in text else "scene"
        return "lens"

    @staticmethod
    def _opened(path: Path, kind: str, present: Settings) -> Settings:
        if kind in ("picture", "settings"):
            from lensbench.app.files.export import read_settings
            from lensbench.app.files.settings_file import load_settings

            settings = read_settings(path) if kind == "picture" else load_settings(path)
            constrained(settings)              # where its lens is gone, that is said here
            return settings
        if kind == "scene":
            from lensbench.app.state.scene_file import load_scene

            load_scene(path)
            return at_home(replace(present, scene=str(path)))
        model = "auto" if present.lensless else present.model
        return constrained(with_model(replace(present, lens=str(path), focal_length=None, zoom=0.0), model))

    def save_lens(self, path: Path) -> None:
        """Save the lens, as it is scaled and zoomed, in the format of the suffix; what that cannot hold is said."""
        say = self._session.view.say
        try:
            remarks = lenses.save(design(self._session.history.present), path)
        except (ValueError, OSError) as error:
            say(str(error))
            return
        say(f"The lens was saved as {path.name}", done=True)
        for remark in remarks:
            say(f"{path.name}: {remark}")

    def save_settings(self, path: Path) -> None:
        """Save the present settings."""
        from lensbench.app.files.settings_file import save_settings

        try:
            save_settings(path, self._session.history.present)
        except (ValueError, OSError) as error:
            self._session.view.say(str(error))

    def save_intrinsics(self, path: Path) -> None:
        """Save the camera's intrinsics and pose as JSON."""
        from lensbench.app.files.export import ExportError, replacing
        from lensbench.app.state.build import camera
        from lensbench.app.state.intrinsics import intrinsics

        try:
            text = intrinsics(camera(self._session.history.present))
            if text is None:
                raise ExportError("This camera has no intrinsics: it is not projective")
            with replacing(path) as part:
                part.write_text(text + "\n", encoding="utf-8")
        except (ValueError, OSError) as error:
            self._session.view.say(str(error))

    def save_picture(self, path: Path) -> None:
        """Save the picture that is shown, as far as it has come, with its settings."""
        from lensbench.app.files.export import save_picture

        update = self._session.worker.newest()
        if update is None:
            self._session.view.say("There is no picture yet")
            return
        present = self._session.history.present
        settings = replace(update.settings, **{name: getattr(present, name) for name in (*LOOK, *MOTION)})
        settings = replace(settings, samples=update.samples)
        try:
            save_picture(path, update.image, settings, choice=update.choice)
        except (ValueError, OSError) as error:
            self._session.view.say(str(error))
