"""The pictures of a light field in the background: an error in one does not end the others."""

import weakref
from time import monotonic, sleep

import numpy as np

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Look, Recording
from lensbench.app.settings.settings import Settings
from lensbench.app.workers import light_field_worker as module
from lensbench.app.workers.light_field_worker import LightFieldWorker


def test_an_unforeseen_error_becomes_a_message_and_the_next_look_is_rendered(monkeypatch, capsys):
    image = np.zeros((2, 3, 3), np.float32)
    monkeypatch.setattr(module, "light_field_picture",
                        lambda recording, look, depth, coarse: 1 // 0 if look.distance < 1000.0 else image)
    worker = LightFieldWorker()
    worker.recording = object()
    end = monotonic() + 120.0
    try:
        worker.want(Look(show="focus", distance=500.0))
        while not worker.messages:
            assert monotonic() < end
            sleep(0.002)
        worker.want(Look(show="focus", distance=2000.0))
        while worker.field_picture is None:
            assert monotonic() < end
            sleep(0.002)
        assert worker.messages[0][0].startswith("ZeroDivisionError") and worker.field_picture.image is image
        assert "Traceback" in capsys.readouterr().err
    finally:
        worker.stop()


def test_a_forgotten_recording_is_freed_though_the_thread_of_the_pictures_waits(monkeypatch):
    class Held:
        """A recording without content, for weak references."""

    monkeypatch.setattr(module, "light_field_picture",
                        lambda recording, look, depth, coarse: np.zeros((2, 3, 3), np.float32))
    worker, end = LightFieldWorker(), monotonic() + 120.0
    worker.recording = Held()
    watched = weakref.ref(worker.recording)
    try:
        worker.want(Look(show="focus"))
        while worker.field_picture is None:
            assert monotonic() < end
            sleep(0.002)
        worker.forget()
        while watched() is not None:
            assert monotonic() < end
            sleep(0.002)
        worker.recording = Held()                       # the same look, of another recording
        worker.want(Look(show="focus"))
        while worker.field_picture is None:
            assert monotonic() < end
            sleep(0.002)
        assert worker.field_picture.recording is worker.recording
    finally:
        worker.stop()


def test_looks_in_passing_are_refocused_coarsely_and_the_one_that_rests_in_full(monkeypatch):
    monkeypatch.setattr(module, "STILL", 1.0)
    settings = Settings(pixels_x=60, pixels_y=40, lens_model="thin", samples=1)
    recording = Recording(lb.capture_light_field(camera(settings), lb.builtin_scene(settings.scene), (3, 3), 4),
                          settings)
    worker, end = LightFieldWorker(), monotonic() + 120.0
    worker.recording = recording

    def pictured(look, coarse):
        while (shown := worker.field_picture) is None or shown.look != look.asked or shown.coarse != coarse:
            assert monotonic() < end
            sleep(0.002)
        return shown.image

    try:
        for distance in (900.0, 1100.0, 1500.0):
            look = Look(show="focus", distance=distance)
            worker.want(look)
            assert np.array_equal(pictured(look, True), recording.field.refocus(distance, coarse=True))
        assert worker._numbered == 3                    # none of them in full yet
        full = pictured(look, False)
        assert np.array_equal(full, recording.field.refocus(1500.0)) and worker._numbered == 4
        sleep(0.1)
        assert worker.field_picture.image is full       # and it stays
    finally:
        worker.stop()
