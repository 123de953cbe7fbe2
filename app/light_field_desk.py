"""The bench's light field: what the panel asks for goes to its worker, what comes of it to the easel.

What the panel chooses is no part of the settings: undo takes back what was set, and loses nothing here.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import lensbench as lb
from lensbench.app.depth_colours import depth_picture, light_of, with_codes
from lensbench.app.light_field_look import Look, Recorded, Recording, picture_settings
from lensbench.app.light_field_worker import Compared, FieldWorker, Sight
from lensbench.app.optics import camera
from lensbench.app.reach import MARGIN, with_longer_side
from lensbench.app.settings import Settings

if TYPE_CHECKING:
    from lensbench.app.session import Bench

KINDS = {"lens": "Lens", "microlenses": "Microlenses", "array": "Array"}


@dataclass
class Form:
    """What is to be recorded; and what the panel asks of the window."""

    kind: str = "lens"                                  # a key of KINDS
    views: int = 9                                      # across, and down; or the pixels behind a microlens
    samples: int = 16                                   # for each pixel of each view
    longer: int = 640                                   # pixels
    microlenses: int = 240                              # along the longer side
    f_number: float | None = None                       # of the microlenses; None: that which matches the lens
    moments: int = 1                                    # parts of the exposure that are kept apart
    spacing: float = 5.0                                # mm from pinhole to pinhole
    open: bool = False                                  # shown though there is a recording
    requests: set[str] = field(default_factory=set)     # record, cancel, open, save, picture, depth, compare

    def settings(self, present: Settings) -> Settings:
        """What the camera sees now, with the form's pixels and samples."""
        longer = self.microlenses if self.kind == "microlenses" else self.longer
        return replace(with_longer_side(present, longer), samples=self.samples, view="picture")

    def bytes(self, present: Settings) -> int:
        """Of memory that the recording will take."""
        film, square = self.settings(present).film, (self.views, self.views)
        size = lb.light_field_bytes(film, square, moments=self.moments if self.kind == "lens" else 1)
        return size if self.kind != "microlenses" else size + lb.light_field_bytes(film, square, np.float32)

    def plenoptic(self, present: Settings) -> lb.PlenopticCamera:
        """The plenoptic camera; what making one raises where there is none."""
        return _plenoptic(self.settings(present).picture, self.views, self.f_number)


@lru_cache(maxsize=4)
def _plenoptic(settings: Settings, pixels: int, f_number: float | None) -> lb.PlenopticCamera:
    return lb.PlenopticCamera(camera(settings), pixels, f_number)


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
        from lensbench.app.export import save_picture

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
