"""The dialogs for files and for the export.

The system's own file dialog is used if there is one, otherwise a dialog in the
window. Both answer in a later frame.
"""

import os
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui, portable_file_dialogs as native

from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import applies, cancels, paragraph, radio, warning
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.session.notices import Request
from lensbench.app.session.picture_render import export_render
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import Task

fa = icons_fontawesome_6
HELPERS = ("zenity", "kdialog", "matedialog", "qarma")
FORMATS = {                     # suffix, bits, tooltip
    "PNG, 8 bits": (".png", 8, "As the window shows it, with its settings"),
    "PNG, 16 bits": (".png", 16, "As the window shows it, in finer steps, with its settings"),
    "PPM, 16 bits": (".ppm", 16, "As PNG of 16 bits, without compression, for simple programs"),
    "EXR, linear": (".exr", 16, "Linear light, without exposure and tone curve, with its settings"),
    "PFM, linear": (".pfm", 16, "Linear light, for simple programs; holds no settings"),
}
SUFFIXES = {suffix for suffix, *_ in FORMATS.values()}
USUAL = 1920                    # pixels of the longer side, offered where the window has fewer
LONGEST = 20_000                # pixels of an exported picture's longer side


def has_native_dialog() -> bool:
    """Whether the system has a file dialog."""
    if sys.platform in ("win32", "darwin"):
        return True
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(shown) and any(shutil.which(helper) for helper in HELPERS)


def pictures_folder() -> Path:
    """The user's folder of pictures, else the home, else the root: the first that can be read."""
    named = Path("~/.config/user-dirs.dirs").expanduser()
    try:
        stated = re.search(r'^XDG_PICTURES_DIR="(.+)"', named.read_text(errors="replace"), re.MULTILINE)
    except OSError:
        stated = None
    places = [Path(stated[1].replace("$HOME", str(Path.home())))] if stated else []
    return next((folder for folder in (*places, Path.home() / "Pictures", Path.home())
                 if folder.is_dir() and os.access(folder, os.R_OK)), Path("/"))


@dataclass(frozen=True)
class Question:
    """What a file dialog asks for."""

    title: str
    kind: str                               # of the files, in words
    suffixes: tuple[str, ...]
    save: bool = False
    name: str = ""                          # proposed for saving


class FilePrompt:
    """Dialog that asks for one file at a time: the system's own, or one in the window."""

    def __init__(self):
        self._native = has_native_dialog()
        self._request: Request | None = None
        self._question: Question | None = None
        self._dialog: Any = None
        self._folder = pictures_folder()
        self._text = ""
        self._open = False
        self._problem = ""

    @property
    def asks(self) -> Request | None:
        """The request whose file is asked for; None where no dialog is open."""
        return self._request if self._question is not None else None

    def ask(self, request: Request, question: Question) -> None:
        """Ask; a question that is still open is dropped. The request comes back with the answer."""
        self._request, self._question, self._text, self._problem = request, question, question.name, ""
        if self._native:
            pattern = " ".join(f"*{suffix} *{suffix.upper()}" for suffix in question.suffixes)
            filters = [question.kind, pattern, "All files", "*"]
            start = str(self._folder / question.name)
            dialog = native.save_file if question.save else native.open_file
            self._dialog = dialog(question.title, start, filters)
        else:
            self._open = True

    @property
    def folder(self) -> Path:
        """Where the file asked for last was; the first folder that is shown next."""
        return self._folder

    @folder.setter
    def folder(self, folder: Path) -> None:
        if folder.is_dir():
            self._folder = folder

    def answer(self) -> tuple[Request, Path] | None:
        """Request and path, once, when the path is known. Draws the window's own dialog; call it in every frame."""
        if self._question is None or self._request is None:
            return None
        path = self._native_answer() if self._dialog is not None else self._own_answer(self._question)
        if path is None:
            return None
        question, self._question = self._question, None
        self.folder = path.parent
        return self._request, _saved_as(path, question) if question.save else path

    def _native_answer(self) -> Path | None:
        if not self._dialog.ready(0):
            return None
        result, self._dialog = self._dialog.result(), None
        chosen = result if isinstance(result, str) else next(iter(result), "")
        if not chosen:
            self._question = None
            return None
        return Path(chosen)

    def _own_answer(self, question: Question) -> Path | None:
        """The dialog in the window: the content of a folder, and a line for a name or a path."""
        title = f"{question.title}###File"
        if self._open:
            imgui.open_popup(title)
            self._open = False
        centre_next(28.0)
        shown, still_open = imgui.begin_popup_modal(title, True, imgui.WindowFlags_.no_saved_settings
                                                    | imgui.WindowFlags_.no_resize)
        if not shown:
            self._question = None
            return None
        chosen = self._listing(question)
        if chosen is not None or not still_open:
            imgui.close_current_popup()
            if chosen is None:
                self._question = None
        imgui.end_popup()
        return chosen

    def _listing(self, question: Question) -> Path | None:
        # The folder and its content
        if imgui.button(fa.ICON_FA_ARROW_UP + "###Up"):
            self._folder, self._problem = self._folder.parent, ""
        imgui.set_item_tooltip("The folder above")
        imgui.same_line()
        imgui.align_text_to_frame_padding()
        paragraph(str(self._folder))
        if imgui.begin_child("Files", ImVec2(0.0, theme.em(17.0)), imgui.ChildFlags_.frame_style):
            paths: list[Path] = []
            try:
                paths = _content(self._folder, question.suffixes)
                if not paths:
                    paragraph(f"No files of these types here: {' '.join(question.suffixes)}")
            except OSError as error:
                paragraph(f"This folder cannot be read: {error.strerror or error}")
            for path in paths:
                folder = os.path.isdir(path)
                icon = fa.ICON_FA_FOLDER if folder else "     "
                if imgui.selectable(f"{icon}  {path.name}###{path.name}", path.name == self._text,
                                    imgui.SelectableFlags_.no_auto_close_popups)[0]:
                    self._problem = ""
                    if folder:
                        self._folder = path
                    else:
                        self._text = path.name
        imgui.end_child()

        # The name, and the buttons
        imgui.set_next_item_width(-1.0)
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        entered, self._text = imgui.input_text("##Name", self._text, imgui.InputTextFlags_.enter_returns_true)
        path = self._folder / os.path.expanduser(self._text.strip() or ".")
        problem = self._problem or (replaced(_saved_as(path, question)) if question.save and path.name else "")
        if problem:
            warning(problem)
        verb = "Save" if question.save else "Open"
        if imgui.button(verb, ImVec2(theme.em(6.0), 0.0)) or entered:
            if os.path.isdir(path):
                self._folder, self._text, self._problem = path, "", ""
            elif not question.save and not os.path.isfile(path):
                self._problem = f"There is no file {path.name} here"
            elif question.save and not os.path.isdir(path.parent):
                self._problem = f"There is no folder {path.parent}"
            else:
                return path
        imgui.same_line()
        if cancels("Cancel", 6.0):
            self._question = None
            imgui.close_current_popup()
        return None


def _saved_as(path: Path, question: Question) -> Path:
    """The path with a suffix that the question asks for."""
    return path if path.suffix.lower() in question.suffixes else path.with_name(path.name + question.suffixes[0])


def replaced(path: Path) -> str:
    """A sentence that a file of this name is replaced; empty where there is none."""
    return f"There is a file {path.name}: it will be replaced" if os.path.isfile(path) else ""


def _content(folder: Path, suffixes: Sequence[str]) -> list[Path]:
    """Folders, then files of these kinds, without hidden ones; OSError for a folder that cannot be read."""
    paths = [path for path in folder.iterdir() if not path.name.startswith(".")]
    folders = sorted((path for path in paths if os.path.isdir(path)), key=lambda path: path.name.lower())
    files = [path for path in paths if path.suffix.lower() in suffixes and os.path.isfile(path)]
    return folders + sorted(files, key=lambda path: path.name.lower())


def centre_next(width: float) -> None:
    """Put the next dialog, `width` em wide, in the middle of the window."""
    viewport = imgui.get_main_viewport()
    middle = viewport.get_center()
    imgui.set_next_window_pos(middle, imgui.Cond_.always, ImVec2(0.5, 0.5))
    width = min(theme.em(width), 0.95 * viewport.work_size.x)
    imgui.set_next_window_size(ImVec2(width, 0.0))


class ExportDialog:
    """Export: the current picture at once, or any size and number of samples rendered in the background."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        self.path = Path("lensbench.png")       # relative until a folder is known
        self.wants_path = False                 # Browse was pressed
        self.wants_current: tuple[Path, int] | None = None      # path and bits of the current picture, to be saved
        self._settings: Settings | None = None
        self._format = "PNG, 8 bits"
        self._open = False
        self._task: Task[bool] | None = None
        self._wake = wake

    @property
    def task(self) -> Task[bool] | None:
        """The export under way, for its progress."""
        return self._task

    @property
    def busy(self) -> bool:
        """Whether an export is under way."""
        return self._task is not None and not self._task.done

    def open(self, settings: Settings, follows: bool, folder: Path) -> None:
        """Show the dialog for these settings. follows: their pixels are those of the window, often too few to keep.

        folder: of the first export.
        """
        self.path = folder / self.path          # an absolute path stays
        if follows and max(settings.pixels_x, settings.pixels_y) < USUAL:
            settings = with_longer_side(settings, USUAL)
        self._settings, self._open = settings, True

    def take_path(self, path: Path) -> None:
        """Export to the path that was chosen by Browse."""
        self.path = path
        suffix = path.suffix.lower()
        if suffix != FORMATS[self._format][0]:
            self._format = next((name for name, (known, *_) in FORMATS.items() if known == suffix), self._format)
        self._open = True

    def resume(self) -> None:
        """Show the dialog again as it was."""
        self._open = True

    def cancel(self) -> None:
        """Cancel an export under way."""
        if self._task is not None:
            self._task.cancel()

    def draw(self) -> tuple[str, bool] | None:
        """Call it in every frame. Returns once, when an export ends, a message and whether it is a success."""
        message = self._ended()
        if self._settings is None:
            return message
        if self._open:
            imgui.open_popup("Export")
            self._open = False
        centre_next(31.0)
        shown, _ = imgui.begin_popup_modal("Export", None, imgui.WindowFlags_.no_saved_settings
                                           | imgui.WindowFlags_.no_resize)
        if not shown:
            return message
        if self._task is not None:
            task_progress(self._task)
            if cancels("Close", 6.0):
                imgui.close_current_popup()
            imgui.set_item_tooltip("It goes on in the background")
        else:
            self._form(self._settings)
        imgui.end_popup()
        return message

    def _form(self, settings: Settings) -> None:
        """Size, samples, format and file, then the buttons."""
        indent = theme.em(6.0)

        # Size, samples, format and file
        _label("Size", indent)
        imgui.set_next_item_width(theme.em(6.0))
        longer = max(settings.pixels_x, settings.pixels_y)
        changed, longer = imgui.input_int("##Longer side", longer, 0)
        if changed:
            settings = with_longer_side(settings, min(max(longer, 16), LONGEST))
        imgui.same_line()
        imgui.text_disabled(f"px along the longer side: {settings.pixels_x} × {settings.pixels_y}")
        _label("Samples", indent)
        imgui.set_next_item_width(theme.em(6.0))
        changed, samples = imgui.input_int("##Samples a pixel", settings.samples, 0)
        if changed:
            settings = replace(settings, samples=min(max(samples, 1), 1_000_000))
        imgui.same_line()
        imgui.text_disabled("a pixel")
        for i, name in enumerate(FORMATS):
            if i % 3:
                imgui.same_line(indent + i % 3 * theme.em(8.0))
            else:
                _label("" if i else "Format", indent)
            if radio(name, name == self._format):
                self._format = name
                if self.path.suffix.lower() in SUFFIXES:
                    self.path = self.path.with_suffix(FORMATS[name][0])
            imgui.set_item_tooltip(FORMATS[name][2])
        _label("File", indent)
        imgui.set_next_item_width(-theme.em(6.0))
        _, text = imgui.input_text("##File", str(self.path))
        self.path = Path(text)
        imgui.same_line()
        if imgui.button("Browse…", ImVec2(-1.0, 0.0)):
            self.wants_path = True
            imgui.close_current_popup()
        self._settings = settings
        suffix, bits, _ = FORMATS[self._format]
        path = Path(os.path.expanduser(str(self.path)))
        named = bool(path.name) and not os.path.isdir(path)
        problem = replaced(with_format(path, suffix)) if named else "Give the file a name"
        if problem:
            _label("", indent)
            warning(problem)

        # The buttons
        imgui.dummy(ImVec2(0.0, theme.em(0.3)))
        imgui.begin_disabled(not named)
        if applies("Render", 6.0):
            self.path = with_format(path, suffix)
            self._task = self._export(settings, self.path, bits)
            imgui.close_current_popup()
        imgui.set_item_tooltip("Render it in the background: the status bar shows the progress")
        imgui.same_line()
        if imgui.button("Save as it is now", ImVec2(theme.em(9.0), 0.0)):
            self.path = with_format(path, suffix)
            self.wants_current = self.path, bits
            imgui.close_current_popup()
        imgui.set_item_tooltip("The picture on the screen, with the pixels and samples that it has")
        imgui.end_disabled()
        imgui.same_line()
        if cancels("Cancel", 6.0):
            imgui.close_current_popup()

    def _export(self, settings: Settings, path: Path, bits: int) -> Task[bool]:
        """Begin to export; the result of the task is whether there is a file."""
        def work(task: Task[bool]) -> bool:
            return export_render(settings, path, bits, task.report, lambda: task.cancelled) is not None

        return Task(f"Rendering {path.name}", work, self._wake)

    def _ended(self) -> tuple[str, bool] | None:
        task = self._task
        if task is None or not task.done:
            return None
        self._task = None
        if task.error is not None:
            return task.message, False
        return (f"Exported {self.path.name} to {self.path.parent}", True) if task.result else None


def with_format(path: Path, suffix: str) -> Path:
    """The path with this suffix, instead of that of another format; what else follows a dot is part of the name."""
    return path.with_suffix(suffix) if path.suffix.lower() in SUFFIXES else path.with_name(path.name + suffix)


def _label(text: str, indent: float) -> None:
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(text)
    imgui.same_line(indent)
