"""The automatic model of the renderer: the speeds that it keeps."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

from lensbench.app.state.settings import Settings
from lensbench.app.workers import automatic_model
from lensbench.app.workers.automatic_model import MOST_SPEEDS, AutomaticModel


def test_the_speeds_of_the_newest_zoom_positions_are_kept_and_no_others(monkeypatch):
    camera = SimpleNamespace(model="polynomial", degree=6)
    choice = SimpleNamespace(ns_per_ray=2.0, trace_ns_per_ray=5.0, applied=lambda camera: camera)
    monkeypatch.setattr(automatic_model, "choose", lambda *given: SimpleNamespace(choice=choice))
    places = [replace(Settings(lens_model="auto"), zoom=i / 300.0) for i in range(300)]
    with ThreadPoolExecutor(1) as pool:
        model = AutomaticModel(pool)
        for settings in places:
            assert not model.is_timed(settings, camera)
            assert model.chosen_camera(settings, camera, None, lambda work: work.result() is not None) is camera
            assert model.time(settings, camera, lambda work: work.result() == (2.0, 5.0))
    known = [model.is_timed(settings, camera) for settings in places]
    assert known == [False] * (300 - MOST_SPEEDS) + [True] * MOST_SPEEDS
