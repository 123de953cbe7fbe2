"""The pictures that a window keeps: the reference A, and the snapshots.

A refines together with the current picture, B, and follows B's dials while the two are locked. It has a render worker
of its own, at low priority, which works while A is shown and never gets ahead of B in samples, so that B stays as fast
as it can be. A picture of a light field cannot be rendered again: as A it stays as it is.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from lensbench.app.bench.build import with_readable_stop
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.constraints import constrained
from lensbench.app.display.small_textures import SmallTextures
from lensbench.app.panels import snapshots as panel
from lensbench.app.panels.controls.controls import lens_title, scene_title
from lensbench.app.plots.comparison import followed
from lensbench.app.session.export import save_picture
from lensbench.app.session.notices import Request
from lensbench.app.session.picture_formats import copy_picture
from lensbench.app.session.snapshots import Snapshot, SnapshotShelf
from lensbench.app.session.states import is_state_text, named_files, settings_of_text, snapshots_folder, state_text
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_f_number
from lensbench.app.window.contact_sheets import ContactSheetDialog
from lensbench.app.window.state import WindowState
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.app.workers.render_worker import RenderWorker
from lensbench.app.workers.task import Task


class Comparing:
    """Lives as long as the window."""

    def __init__(self, window: WindowState, threads: int | None = None):
        self._window, self._threads = window, threads
        self._worker: RenderWorker | None = None        # from when A is first shown
        self._kept: RenderUpdate | None = None          # the picture A as pinned, or as shown last
        self._is_pinned = False                         # that picture is the pinned one, and not the worker's
        self._taken: RenderUpdate | None = None         # the worker's newest update that was shown
        self._before: Settings | None = None            # B in the frame before

    def pin(self) -> bool:
        """Make the shown picture A; returns False if there is none yet."""
        window, presenter = self._window, self._window.presenter
        if not presenter.pin(window.history.present) or presenter.pinned is None:
            return False
        window.view.pinned = presenter.pinned.settings
        return True

    def pin_codes(self, codes: NDArray[np.float32], settings: Settings) -> None:
        """Make a saved picture A; while it is shown, it is rendered again. codes: of the screen (h, w, 3), 0 to 1."""
        self._window.presenter.keep_codes(codes, settings)
        self._window.view.pinned = settings

    @property
    def is_live(self) -> bool:
        """Whether A can be rendered, and is shown."""
        pinned = self._window.presenter.pinned
        return pinned is not None and not pinned.field_picture and self._window.history.present.compare != "off"

    def advance(self, is_held: bool) -> None:
        """Once a frame: let A follow B, and show its newest picture. held: the processor is left to other work."""
        view, current = self._window.view, self._window.history.present
        before, self._before = self._before, current
        pinned = self._window.presenter.pinned
        if pinned is not self._kept:                    # another picture was pinned
            self._kept, self._is_pinned, self._taken = pinned, True, None
        if view.pinned is not None and view.locked and before is not None and pinned and not pinned.field_picture:
            view.pinned = followed(view.pinned, before, current)
        if self.is_live:
            self._render(is_held)
            self._show()
        elif self._worker is not None:
            self._worker.hold(True)

    def _render(self, is_held: bool) -> None:
        """Let A's worker render as many samples as B has."""
        window, a, b = self._window, self._window.view.pinned, self._window.presenter.update
        assert a is not None
        if b is None or b.generation != window.worker.generation:
            return                                      # B's first picture comes first
        complete = b.samples >= b.settings.samples
        settings = replace(a, samples=a.samples if complete else min(b.samples, a.samples))
        if self._worker is None:
            self._worker = RenderWorker(settings, window.wake, self._threads, urgent=False)
        self._worker.hold(is_held or window.worker.paused)
        self._worker.restart(settings)
        failure = self._worker.error
        if failure is not None and self._kept is not None:
            window.view.say(f"A: {failure.error}")
            window.view.pinned = self._kept.settings

    def _show(self) -> None:
        """Show A's newest picture, unless the pinned one has more samples."""
        window, a, kept = self._window, self._window.view.pinned, self._kept
        update = self._worker.newest() if self._worker is not None else None
        if update is None or kept is None or a is None or update.settings.picture != a.picture:
            return
        if self._is_pinned and kept.settings.picture == a.picture and update.samples < kept.samples:
            return
        if update is not self._taken or a != kept.settings:
            self._taken, self._is_pinned = update, False
            window.presenter.repin(update, a)
            self._kept = window.presenter.pinned

    def settled(self, samples: int) -> bool:
        """Whether A is on the screen with this many samples, or is not live."""
        kept, a = self._kept, self._window.view.pinned
        return not self.is_live or kept is not None and a is not None and kept.settings == a \
            and kept.samples >= min(samples, a.samples)

    def reload(self) -> None:
        """Render A again, because a file has changed on disk."""
        if self._worker is not None and self._window.view.pinned is not None:
            self._worker.reload(self._window.view.pinned)

    def closed(self) -> None:
        """The window is about to close."""
        if self._worker is not None:
            self._worker.stop()


class Snapshots:
    """Lives as long as the window."""

    def __init__(self, window: WindowState, comparing: Comparing, folder: Path | None = None):
        self._window, self._comparing = window, comparing
        self._temporary = None if folder is not None or window.remember else TemporaryDirectory()
        self.shelf = SnapshotShelf(folder or (Path(self._temporary.name) if self._temporary else snapshots_folder()),
                                   window.view.say)
        self.state = panel.SnapshotsState()
        self.dialog = ContactSheetDialog(window.requests)
        self.task: Task[list[str]] | None = None        # the sheet that is being made
        self._sheet_name = ""
        self._pictures: dict[str, NDArray[np.uint8]] = {}
        self._textures = SmallTextures(self._pictures)
        self._loading: Task[None] | None = None
        self._carding: Snapshot | None = None
        self._tasks: list[tuple[Task[None], str]] = []

    def draw(self) -> None:
        """The panel."""
        if not self._load().done:
            imgui.text_disabled("Reading the snapshots")
            return
        self._pictures.clear()
        self._pictures.update({str(snapshot.path): snapshot.thumbnail for snapshot in self.shelf.snapshots})
        self._textures.begin_frame()
        before = self._window.edited
        compare = panel.snapshots_panel(self.shelf.snapshots, self.state, before.compare,
                                        lambda snapshot: self._textures.of(str(snapshot.path)))
        if compare != before.compare:
            self._window.edited = replace(before, compare=compare)

    def _load(self) -> Task[None]:
        """Read the shelf, once."""
        if self._loading is None:
            self._loading = Task("Reading the snapshots", lambda _: self.shelf.load(), self._window.wake)
        return self._loading

    def answer(self, requests: set[Request]) -> None:
        """Do what the panel and the keys have asked for; call it once a frame."""
        for task, success in list(self._tasks):
            if task.done:
                self._tasks.remove((task, success))
                self._window.view.say(success if task.error is None else task.message, done=task.error is None)
        self._end_sheet()
        if Request.PIN in requests or self._window.view.pinned is None:
            self.state.reference = None
        if Request.CONTACT_SHEET in requests:
            self.dialog.open(self._window.history.present)
        action, self.state.action = self.state.action, None
        renamed, self.state.new_name = self.state.new_name, None
        try:
            if renamed is not None:
                self.state.replace(renamed[0], self.shelf.rename(*renamed))
            if Request.KEEP_SNAPSHOT in requests or action is not None and action[0] == panel.KEEP:
                self._keep()
            text = imgui.get_clipboard_text() or "" if Request.PASTE in requests else ""
            if is_state_text(text):                     # another text is for the panel that has the focus
                self.paste(text)
            number, self._window.snapshot_number = self._window.snapshot_number, 0
            if number:
                self._open_number(number)
            if action is not None and action[0] == panel.SHEET:
                self.dialog.sheet = None
                self._window.requests.add(Request.SAVE_SHEET)
            if action is not None and action[0] == panel.PASTE:
                self.paste(imgui.get_clipboard_text() or "")
            if Request.COPY_PICTURE in requests:
                self._copy_current()
            if Request.COPY_STATE in requests:
                self._copy_state(self._window.history.present)
            if action is not None and action[1] is not None:
                self._do(action[0], action[1])
        except (ValueError, OSError) as error:
            self._window.view.say(str(error))

    def paste(self, text: str) -> None:
        """Open the state of a text; a note says if it is none."""
        if not is_state_text(text):
            self._window.view.say("The clipboard holds no lensbench state: such a text begins with lensbench:",
                                  note=True)
            return
        self._take(settings_of_text(text))

    def save(self, request: Request, path: Path) -> None:
        """Write the card of the snapshot, or the sheet, that was asked for."""
        from lensbench.app.session.snapshots import write_card

        if request is Request.SAVE_SHEET:
            self._begin_sheet(path)
            return
        snapshot, dark = self._carding, self._window.dark
        if snapshot is not None:
            self._tasks.append((Task("Writing the card", lambda _: write_card(path, snapshot.codes(), snapshot.settings,
                                                                            snapshot.name, dark), self._window.wake),
                                f"Card saved as {path.name}"))

    def _begin_sheet(self, path: Path) -> None:
        """Render the lenses of the dialog, or take the chosen snapshots, and write them as one file."""
        from lensbench.app.session.contact_sheet import Cell, rendered_cells, write_sheet

        lenses, snapshots = self.dialog.sheet, self.state.marked or list(self.shelf.snapshots)
        self.cancel()
        self._sheet_name = path.name

        def work(task: Task[list[str]]) -> list[str]:
            cells: list[Cell | str] = [*map(Cell.of, snapshots)] if lenses is None else [
                *rendered_cells(*lenses, task.report, lambda: task.cancelled)]
            pictures = [cell for cell in cells if isinstance(cell, Cell)]
            problems = [cell for cell in cells if isinstance(cell, str)]
            if not task.cancelled and pictures:
                write_sheet(path, pictures)
            return problems if pictures or not problems else [*problems, f"No picture: {path.name} was not written"]

        self.task = Task(f"Rendering {path.name}", work, self._window.wake)

    def _end_sheet(self) -> None:
        """Report a sheet that is done."""
        task, say = self.task, self._window.view.say
        if task is None or not task.done:
            return
        self.task = None
        if task.cancelled or task.error is not None:
            say(f"{self._sheet_name} was cancelled: nothing was written" if task.cancelled else task.message,
                note=task.cancelled)
            return
        for problem in task.result or ():
            say(problem)
        if not any(problem.startswith("No picture") for problem in task.result or ()):
            say(f"Saved {self._sheet_name}", done=True)

    def cancel(self) -> None:
        """Cancel a sheet under way."""
        if self.task is not None:
            self.task.cancel()

    def _open_number(self, number: int) -> None:
        """Open a snapshot of the shelf, from 1 for the newest."""
        self._load().join()
        if number > len(self.shelf.snapshots):
            self._window.view.say(f"There is no snapshot {number}: B keeps the picture as one", note=True)
        else:
            self._do(panel.OPEN, self.shelf.snapshots[number - 1])

    def _keep(self) -> None:
        picture = self._window.picture_now()
        if picture is None:
            self._window.view.say("There is no picture yet", note=True, about="picture")
            return
        image, settings, _ = picture
        self._load().join()                     # reading it later would forget this one
        self.shelf.keep(image, settings, _name(settings))
        if not self._window.panel_shown("Snapshots"):
            self._window.view.say("Snapshot kept: see the panel Snapshots", done=True)

    def _do(self, action: str, snapshot: Snapshot) -> None:
        if action == panel.OPEN:
            reference = self.state.reference
            self._take(snapshot.settings, reference is not None and reference is not snapshot)
        elif action == panel.COMPARE:
            self._comparing.pin_codes(snapshot.codes(), snapshot.settings)
            self.state.reference = snapshot
            shown = self._window.edited.compare
            self._window.edited = replace(self._window.edited, compare="side" if shown == "off" else shown)
        elif action == panel.TEXT:
            self._copy_state(snapshot.settings)
        elif action == panel.COPY:
            self._copy(snapshot.path, snapshot.name)
        elif action == panel.CARD:
            self._carding = snapshot
            self._window.requests.add(Request.SAVE_CARD)
        elif action == panel.REMOVE:
            self.shelf.remove(snapshot)
            self.state.replace(snapshot, None)

    def _take(self, settings: Settings, compares: bool = False) -> None:
        """The settings of a snapshot; their pixels only where the picture does not follow the window.

        compares: a comparison that is shown goes on, with them as B.
        """
        window = self._window
        settings = with_readable_stop(settings, partial(window.view.say, change=True))
        if window.view.follows:
            settings = replace(settings, pixels_x=window.history.present.pixels_x,
                               pixels_y=window.history.present.pixels_y)
        shown = window.history.present
        window.take(window.showable(replace(constrained(settings), compare=shown.compare if compares else "off",
                                            wipe=shown.wipe)))

    def _copy_state(self, settings: Settings) -> None:
        imgui.set_clipboard_text(state_text(settings))
        files = named_files(settings)
        self._window.view.say("State copied as text" + (
            f"; it names {' and '.join(files)}, which the receiver needs too" if files else ""), done=True)

    def _copy_current(self) -> None:
        picture = self._window.picture_now()
        if picture is None:
            self._window.view.say("There is no picture yet", note=True, about="picture")
            return

        def work(_: Task[None]) -> None:
            with TemporaryDirectory() as folder:
                path = Path(folder) / "lensbench.png"
                save_picture(path, picture[0], picture[1])
                copy_picture(path)

        self._tasks.append((Task("Copying the picture", work, self._window.wake), "Picture copied"))

    def _copy(self, path: Path, name: str) -> None:
        self._tasks.append((Task("Copying the picture", lambda _: copy_picture(path), self._window.wake),
                            f"{name} copied"))


def _name(settings: Settings) -> str:
    """A first name for a snapshot: lens, stop and scene."""
    if not settings.has_lens:
        return f"{settings.camera_title}, {scene_title(settings.scene)}"
    f_number, title = settings.f_number or readings(settings).widest_f_number, lens_title(settings.lens)
    stop = format_f_number(f_number) if f_number else ""
    stop = f" at {stop}" if stop and stop not in title.split() else ""       # wide open the title states it already
    return f"{title}{stop}, {scene_title(settings.scene)}"
