"""The light field of the window: passes the panel's requests to the worker, and the worker's pictures to the view.

What the panel chooses is no part of the settings: undo takes back settings, and loses nothing here.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.constraints import MARGIN
from lensbench.app.bench.light_field_query import Look, Recorded, Recording, light_field_picture, picture_settings
from lensbench.app.bench.tone import depth_picture, light_of, with_codes
from lensbench.app.display.frame import View
from lensbench.app.display.presenter import Presenter
from lensbench.app.panels.light_field.capture_form import Form
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.light_field_worker import Compared, FieldPicture, LightFieldWorker


class LightFieldController:
    """Lives as long as the window."""

    def __init__(self, view: View, presenter: Presenter, settings: Settings, requests: set[Request],
                 wake: Callable[[], None]):
        self.form, self.look = Form(requests=requests), Look()
        self.worker = LightFieldWorker(wake)
        self._view, self._presenter = view, presenter
        self._recording: Recorded | None = None        # that the look is of
        self._settings = settings.picture               # that the camera showed last
        self._compared: Compared | None = None

    @property
    def field_picture(self) -> FieldPicture | None:
        """The picture of the light field that is shown instead of the camera's; None while the camera's is shown."""
        return self.worker.field_picture if self.look.show != "camera" else None

    @property
    def occupies_processor(self) -> bool:
        """Whether the render has to leave the processor to the light field."""
        return self.look.show != "camera" or self.worker.task is not None

    def begin(self, current: Settings) -> bool:
        """At the beginning of a frame: take the worker's results. True: the difference from A is to be shown."""
        view, worker = self._view, self.worker
        worker.collect()
        while worker.messages:                  # other threads add to the same list
            view.say(*worker.messages.pop(0), about="light field")

        # A changed camera is shown, a new recording too
        if current.picture != self._settings:
            self._settings, self.look = current.picture, replace(self.look, show="camera")
        if worker.recording is not self._recording:
            self._recording = worker.recording
            if self._recording is not None:
                self.look, self.form.open = Look.of(self._recording), False

        # The pixel that was clicked on, and its mark
        picked, view.picked = view.picked, None
        behind = self._behind
        if picked is not None:
            self._pick((picked[0] // behind, picked[1] // behind))
        self.ask()
        self._show()
        x, y = self.look.pixel
        view.cross = (x * behind + behind // 2, y * behind + behind // 2) \
            if self.look.show in ("view", "rays", "depth") else None
        view.line = self.look.show == "rays"

        compared = worker.compared
        if compared is None or compared is self._compared:
            return False
        self._compared = compared
        self._presenter.keep(compared.image, compared.settings)
        view.pinned = compared.settings
        return True

    def ask(self) -> None:
        """Have the current look rendered, from now on."""
        if self.look.show != "camera":
            self.worker.want(self.look)

    def await_field_picture(self) -> None:
        """Hold the frame for the picture of the current look, if it is about to come."""
        if self.look.show != "camera":
            self.worker.await_field_picture()
            self._show()

    def answer(self, requests: set[Request], current: Settings) -> None:
        """Carry out the panel's requests."""
        if Request.RECORD in requests:
            self._record(current)
        if Request.FIND_DEPTH in requests:
            self.worker.find_depth()
        if Request.COMPARE in requests and self.field_picture is not None:
            self.worker.compare(self.field_picture)

    def picture(self, current: Settings, path: Path | None = None) -> tuple[NDArray[np.float32], Settings] | None:
        """The linear picture (h, w, 3) of the light field, and its settings, exposed as the current ones; None yet.

        path: of a file that it is for, some of which hold depths themselves.
        """
        shown = self.worker.field_picture
        if shown is None:
            return None
        settings = picture_settings(shown.recording, shown.look)
        if not shown.coded:
            image = shown.image
            if shown.coarse and isinstance(shown.recording, Recording):
                image = light_field_picture(shown.recording, shown.look, None)
            return image, replace(settings, exposure=current.exposure, tone=current.tone)
        depth = self.worker.known_depth
        if shown.look.deep == "depth" and path is not None and depth is not None:
            return depth_picture(depth, path), with_codes(settings)
        return light_of(shown.image), with_codes(settings)

    def save_picture(self, path: Path, current: Settings, bits: int = 8) -> None:
        """Save the picture of the light field, with the exposure and the tone curve of the current settings."""
        from lensbench.app.session.export import save_picture

        picture = self.picture(current, path)
        if picture is None:
            self._view.say("There is no picture of a light field yet")
            return
        try:
            save_picture(path, *picture, bits)
        except (ValueError, OSError) as error:
            self._view.say(str(error), about="picture")
        else:
            self._view.say(f"Picture saved as {path.name}", done=True, about="picture")

    def _show(self) -> None:
        self._presenter.field_picture = self.field_picture

    def _record(self, current: Settings) -> None:
        form, settings = self.form, self.form.settings(current)
        square = form.views, form.views
        if form.kind == "lens":
            self.worker.record(settings, square, form.moments)
        elif form.kind == "array":
            self.worker.record_array(settings, square, form.spacing)
        else:
            self.worker.expose(settings, form.views, form.f_number)

    @property
    def _behind(self) -> int:
        """Pixels of the shown picture for one pixel of a view, across and down."""
        shown = self.field_picture
        if shown is None or not isinstance(shown.recording, Recording) or shown.recording.raw is None:
            return 1
        return shown.recording.raw.camera.pixels if shown.look.sensor else 1

    def _pick(self, pixel: tuple[int, int]) -> None:
        """A click on a pixel of the light field's picture focuses there, or says how its depth becomes known."""
        depth, self.look = self.worker.known_depth, replace(self.look, pixel=pixel)
        if depth is None and self.look.show == "focus" and isinstance(self._recording, Recording):
            self._view.say("A click focuses once the depth is known: “Find the depth” on the tab Depth", note=True)
        if depth is not None and self.look.show == "focus" and isinstance(self._recording, Recording):
            distance = float(depth.distance[pixel[1], pixel[0]])
            self.look = replace(self.look, distance=max(distance, self._recording.nearest * MARGIN))
