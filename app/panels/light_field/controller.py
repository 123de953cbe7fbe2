"""The bench's light field: what the panel asks for goes to its worker, what comes of it to the easel.

What the panel chooses is no part of the settings: undo takes back what was set, and loses nothing here.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lensbench.app.panels.light_field.capture_settings import Form
from lensbench.app.state.constraints import MARGIN
from lensbench.app.state.depth_colours import depth_picture, light_of, with_codes
from lensbench.app.state.light_field_query import Look, Recorded, Recording, picture_settings
from lensbench.app.state.settings import Settings
from lensbench.app.workers.light_field_worker import Compared, FieldPicture, LightFieldWorker

if TYPE_CHECKING:
    from lensbench.app.window.session import Session


class LightFieldController:
    """Lives as long as the bench."""

    def __init__(self, session: "Session"):
        self.form, self.look = Form(), Look()
        self.worker = LightFieldWorker(session.wake)
        self._session = session
        self._recording: Recorded | None = None        # that the look is of
        self._settings = session.history.present.picture  # that the camera showed last
        self._compared: Compared | None = None

    @property
    def field_picture(self) -> FieldPicture | None:
        """What the picture shows in place of the camera's."""
        return self.worker.field_picture if self.look.show != "camera" else None

    def begin(self) -> None:
        """At the beginning of a frame: news from the worker; a camera that has been set anew is shown."""
        session, worker = self._session, self.worker
        worker.collect()
        messages, worker.messages = worker.messages, []
        for message, done in messages:
            session.view.say(message, done)
        present = session.history.present.picture
        if present != self._settings:
            self._settings, self.look = present, replace(self.look, show="camera")
        if worker.recording is not self._recording:
            self._recording = worker.recording
            if self._recording is not None:
                self.look, self.form.open = Look.of(self._recording), False
        picked, session.view.picked = session.view.picked, None
        behind = self._behind
        if picked is not None:
            self._pick((picked[0] // behind, picked[1] // behind))
        self.ask()
        self._show()
        x, y = self.look.pixel
        session.view.cross = (x * behind + behind // 2, y * behind + behind // 2) \
            if self.look.show in ("view", "rays", "depth") else None
        session.view.line = self.look.show == "rays"
        compared = worker.compared
        if compared is not None and compared is not self._compared:
            self._compared = compared
            session.presenter.keep(compared.image, compared.settings)
            session.view.pinned = compared.settings
            session.edited = replace(session.edited, compare="difference")

    def ask(self) -> None:
        """Have what is looked at shown, from now on."""
        if self.look.show != "camera":
            self.worker.want(self.look)

    def await_field_picture(self) -> None:
        """Hold the frame for the picture that a hand has just asked for, where it is about to come."""
        if self.look.show != "camera":
            self.worker.await_field_picture()
            self._show()

    def _show(self) -> None:
        self._session.presenter.field_picture = self.field_picture

    def _record(self, present: Settings) -> None:
        form, settings = self.form, self.form.settings(present)
        square = form.views, form.views
        if form.kind == "lens":
            self.worker.record(settings, square, form.moments)
        elif form.kind == "array":
            self.worker.record_array(settings, square, form.spacing)
        else:
            self.worker.expose(settings, form.views, form.f_number)

    @property
    def _behind(self) -> int:
        """How many pixels of the picture that is shown stand for one of a view, across and down."""
        shown = self.field_picture
        if shown is None or not isinstance(shown.recording, Recording) or shown.recording.raw is None:
            return 1
        return shown.recording.raw.camera.pixels if shown.look.sensor else 1

    def _pick(self, pixel: tuple[int, int]) -> None:
        """A pixel of the light field's picture was clicked on: focus there where its depth is known."""
        found, self.look = self.worker.found, replace(self.look, pixel=pixel)
        if found is not None and self.look.show == "focus" and isinstance(self._recording, Recording):
            distance = float(found.distance[pixel[1], pixel[0]])
            self.look = replace(self.look, distance=max(distance, self._recording.field.nearest * MARGIN))

    def end(self) -> None:
        """After the panels: what they have asked for."""
        session, worker = self._session, self.worker
        wanted, self.form.requests = self.form.requests, set()
        present = session.history.present
        if "record" in wanted:
            self._record(present)
        if "depth" in wanted:
            worker.find_depth()
        if "compare" in wanted and self.field_picture is not None:
            worker.compare(self.field_picture)
        for request, kind in (("open", "light field"), ("save", "save light field"), ("picture", "refocused")):
            if request in wanted:
                session.files.ask(kind)
        session.worker.hold(self.look.show != "camera" or worker.task is not None)

    def save_picture(self, path: Path) -> None:
        """Save what the light field shows."""
        from lensbench.app.files.export import save_picture

        field_picture, present = self.worker.field_picture, self._session.history.present
        if field_picture is None:
            self._session.view.say("There is no picture of a light field yet")
            return
        settings = picture_settings(field_picture.recording, field_picture.look)
        image = field_picture.image
        if field_picture.look.coded:
            settings, found = with_codes(settings), self.worker.found
            image = depth_picture(found, path) if field_picture.look.deep == "depth" and found else light_of(image)
        else:
            settings = replace(settings, exposure=present.exposure, tone=present.tone)
        try:
            save_picture(path, image, settings)
        except (ValueError, OSError) as error:
            self._session.view.say(str(error))
        else:
            self._session.view.say(f"The picture was saved as {path.name}", done=True)
