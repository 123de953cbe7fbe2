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
from lensbench.app.workers.light_field_worker import Compared, FieldWorker, Sight

if TYPE_CHECKING:
    from lensbench.app.window.session import Bench


class LightFieldDesk:
    """Lives as long as the bench."""

    def __init__(self, bench: "Bench"):
        self.form, self.look = Form(), Look()
        self.worker = FieldWorker(bench.woken)
        self._bench = bench
        self._recording: Recorded | None = None        # that the look is of
        self._settings = bench.history.present.picture  # that the camera showed last
        self._compared: Compared | None = None

    @property
    def sight(self) -> Sight | None:
        """What the picture shows in place of the camera's."""
        return self.worker.sight if self.look.show != "camera" else None

    def begin(self) -> None:
        """At the beginning of a frame: news from the worker; a camera that has been set anew is shown."""
        bench, worker = self._bench, self.worker
        said, worker.said = worker.said, []
        for message, done in said:
            bench.view.say(message, done)
        present = bench.history.present.picture
        if present != self._settings:
            self._settings, self.look = present, replace(self.look, show="camera")
        if worker.recording is not self._recording:
            self._recording = worker.recording
            if self._recording is not None:
                self.look, self.form.open = Look.of(self._recording), False
        picked, bench.view.picked = bench.view.picked, None
        behind = self._behind
        if picked is not None:
            self._pick((picked[0] // behind, picked[1] // behind))
        self.ask()
        self._show()
        x, y = self.look.pixel
        bench.view.cross = (x * behind + behind // 2, y * behind + behind // 2) \
            if self.look.show in ("view", "rays", "depth") else None
        bench.view.line = self.look.show == "rays"
        compared = worker.compared
        if compared is not None and compared is not self._compared:
            self._compared = compared
            bench.easel.keep(compared.image, compared.settings)
            bench.view.pinned = compared.settings
            bench.edited = replace(bench.edited, compare="difference")

    def ask(self) -> None:
        """Have what is looked at shown, from now on."""
        if self.look.show != "camera":
            self.worker.want(self.look)

    def await_sight(self) -> None:
        """Hold the frame for the picture that a hand has just asked for, where it is about to come."""
        if self.look.show != "camera":
            self.worker.await_sight()
            self._show()

    def _show(self) -> None:
        self._bench.easel.sight = self.sight

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
        sight = self.sight
        if sight is None or not isinstance(sight.recording, Recording) or sight.recording.raw is None:
            return 1
        return sight.recording.raw.camera.pixels if sight.look.sensor else 1

    def _pick(self, pixel: tuple[int, int]) -> None:
        """A pixel of the light field's picture was clicked on: focus there where its depth is known."""
        found, self.look = self.worker.found, replace(self.look, pixel=pixel)
        if found is not None and self.look.show == "focus" and isinstance(self._recording, Recording):
            distance = float(found.distance[pixel[1], pixel[0]])
            self.look = replace(self.look, distance=max(distance, self._recording.field.nearest * MARGIN))

    def end(self) -> None:
        """After the panels: what they have asked for."""
        bench, worker = self._bench, self.worker
        wanted, self.form.requests = self.form.requests, set()
        present = bench.history.present
        if "record" in wanted:
            self._record(present)
        if "cancel" in wanted:
            worker.cancel()
        if "depth" in wanted:
            worker.find_depth()
        if "compare" in wanted and self.sight is not None:
            worker.compare(self.sight)
        for request, kind in (("open", "light field"), ("save", "save light field"), ("picture", "refocused")):
            if request in wanted:
                bench.files.ask(kind)
        bench.worker.hold(self.look.show != "camera" or worker.task is not None)

    def save_picture(self, path: Path) -> None:
        """Save what the light field shows."""
        from lensbench.app.files.export import save_picture

        sight, present = self.worker.sight, self._bench.history.present
        if sight is None:
            self._bench.view.say("There is no picture of a light field yet")
            return
        settings = picture_settings(sight.recording, sight.look)
        image = sight.image
        if sight.look.coded:
            settings, found = with_codes(settings), self.worker.found
            image = depth_picture(found, path) if sight.look.deep == "depth" and found else light_of(image)
        else:
            settings = replace(settings, exposure=present.exposure, tone=present.tone)
        try:
            save_picture(path, image, settings)
        except (ValueError, OSError) as error:
            self._bench.view.say(str(error))
        else:
            self._bench.view.say(f"The picture was saved as {path.name}", done=True)
