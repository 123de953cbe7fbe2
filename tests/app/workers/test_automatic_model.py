"""The automatic model of the renderer: the speeds that it keeps."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

from lensbench.app.settings.settings import Settings
from lensbench.app.workers import render_job
from lensbench.app.workers.render_job import MOST_SPEEDS, AutomaticModel


def test_the_speeds_of_the_newest_zoom_positions_are_kept_and_no_others(monkeypatch):
    camera = SimpleNamespace(model="polynomial", degree=6)
    choice = SimpleNamespace(ns_per_ray=2.0, trace_ns_per_ray=5.0, applied=lambda camera: camera)
    monkeypatch.setattr(render_job, "choose", lambda *arguments: SimpleNamespace(choice=choice))
    places = [replace(Settings(lens_model="auto"), zoom=i / 300.0) for i in range(300)]
    with ThreadPoolExecutor(1) as pool:
        model = AutomaticModel(pool)
        for settings in places:
            assert not model.is_timed(settings, camera)
            assert model.chosen_camera(settings, camera, None, lambda work: work.result() is not None) is camera
            assert model.time(settings, camera, lambda work: work.result() == (2.0, 5.0))
    known = [model.is_timed(settings, camera) for settings in places]
    assert known == [False] * (300 - MOST_SPEEDS) + [True] * MOST_SPEEDS


def test_the_speeds_of_an_edited_lens_are_its_own(monkeypatch):
    """A lens before which another one was attached has twice the surfaces: the bar showed the time of half of them."""
    camera = SimpleNamespace(model="polynomial", degree=6)
    monkeypatch.setattr(render_job, "choose", lambda settings, *_: SimpleNamespace(choice=SimpleNamespace(
        ns_per_ray=2.0, trace_ns_per_ray=9.0 if settings.edited else 5.0, applied=lambda camera: camera),
        of=settings))
    plain = Settings(lens_model="auto")
    edited = replace(plain, edited="a document of another lens")
    with ThreadPoolExecutor(1) as pool:
        model = AutomaticModel(pool)
        for settings, speeds in ((plain, (2.0, 5.0)), (edited, (2.0, 9.0))):
            model.chosen_camera(settings, camera, None, lambda work: work.result() is not None)
            assert not model.is_timed(settings, camera)
            assert model.time(settings, camera, lambda work: work.result() is not None)
            assert model.fields(settings, camera, False)["speeds"] == speeds
