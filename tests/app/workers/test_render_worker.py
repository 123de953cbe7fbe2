"""The background renderer: what it shows is what was asked for last, and it never waits or dies."""

import threading
from dataclasses import replace
from time import monotonic, sleep

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.auto_model import choose
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.settings.settings import Settings
from lensbench.app.workers import compilers, render_job, render_worker as module
from lensbench.app.workers.render_worker import PAUSED_SAMPLES, RenderWorker

SMALL = replace(Settings(), pixels_x=96, pixels_y=64, samples=8)
PATIENCE = 240.0            # seconds: the first picture compiles the kernels


def wait(what):
    end = monotonic() + PATIENCE
    while not what():
        assert monotonic() < end
        sleep(0.002)


@pytest.fixture
def start():
    workers = []

    def begin(settings=SMALL, **options):
        workers.append(RenderWorker(settings, threads=2, **options))
        return workers[-1]

    yield begin
    for worker in workers:
        worker.stop()


def done(worker, samples=SMALL.samples):
    update = worker.newest()
    return update is not None and update.generation == worker.generation and update.samples == samples


def test_a_picture_is_on_the_screen_when_the_window_says_so_until_the_next_restart(start):
    worker = start()
    wait(lambda: done(worker))
    assert not worker.on_screen
    worker.shown(worker.newest())
    assert worker.on_screen
    worker.again()
    assert not worker.on_screen


def test_the_picture_is_that_of_the_same_passes_bit_for_bit(start, monkeypatch):
    view, scene = camera(SMALL), lb.builtin_scene(SMALL.scene)
    picture = lb.render(view, scene, samples=8)         # first: the very first picture leaves small lights to chance
    passes, add = [], lb.Rendering.add

    def noted(rendering, count, *rest):
        done = add(rendering, count, *rest)
        if done and rendering.samples == count:         # the first of a rendering, or of one that took its own light
            passes.clear()
        passes.append((count, done))
        return done

    monkeypatch.setattr(lb.Rendering, "add", noted)
    worker = start()
    wait(lambda: done(worker) and worker.newest().depth is not None)
    monkeypatch.undo()
    update = worker.newest()
    if update.choice is not None:                       # the automatic model, as it was chosen
        view = update.choice.applied(view)
    again = lb.Rendering(view, scene, seed=SMALL.seed)
    for count, finished in passes:
        if finished:
            again.add(count)
    np.testing.assert_array_equal(update.image, again.image())
    np.testing.assert_array_equal(update.depth, lb.depth_map(view, scene))
    # One call adds its samples in another order: eight float32 roundings, with a margin for dark pixels
    np.testing.assert_allclose(again.image(), picture, rtol=8 * np.finfo(np.float32).eps, atol=1e-6)
    assert update.settings == SMALL and worker.error is None


def test_a_dragged_picture_reuses_samples_and_a_still_one_has_none_bit_for_bit(start, monkeypatch):
    settings = replace(SMALL, samples=20, lens_model="polynomial", degree=5)
    dragged = replace(settings, focus_distance=1230.0)
    shown, passes, add = [], [], lb.Rendering.add

    def noted(rendering, count, *rest):
        done = add(rendering, count, *rest)
        if done and rendering.samples == count:         # the first of a rendering, or of one that took its own light
            passes.clear()
        passes.append((count, done))
        return done

    worker = start(settings)
    wait(lambda: done(worker, 20) and worker.newest().depth is not None)
    monkeypatch.setattr(lb.Rendering, "add", noted)
    monkeypatch.setattr(worker, "_wake", lambda: shown.append(worker.newest()))
    worker.restart(dragged)
    wait(lambda: done(worker, 20))
    monkeypatch.undo()
    first = next(update for update in shown if update.settings.focus_distance == 1230.0)
    assert first.samples == 1 and first.plain is not None
    again = lb.Rendering(camera(dragged), lb.builtin_scene(dragged.scene), seed=dragged.seed)
    for count, finished in passes:
        if finished:
            again.add(count)
    update = worker.newest()
    assert update.plain is None and not update.is_provisional
    np.testing.assert_array_equal(update.image, again.image())
    # The old samples bring the first picture nearer to the complete one
    assert ((first.image - update.image) ** 2).mean() < 0.5 * ((first.plain - update.image) ** 2).mean()


def test_what_changes_only_the_development_does_not_begin_anew(start):
    worker = start()
    wait(lambda: done(worker))
    update = worker.newest()
    worker.restart(replace(SMALL, exposure=2.0, tone="agx", overlay="coc"))
    assert worker.generation == update.generation
    worker.restart(replace(SMALL, samples=12))
    wait(lambda: done(worker, 12))
    assert worker.newest().generation == update.generation


def test_of_many_settings_the_last_one_is_rendered_and_no_older_picture_follows_a_newer(start):
    generations = []
    wake = threading.Event()
    worker = start(wake=wake.set)
    wait(lambda: done(worker))
    for i in range(1, 40):
        worker.restart(replace(SMALL, focus_distance=1200.0 + i))
        wake.wait(0.004)
        wake.clear()
        generations.append(worker.newest().generation)
    wait(lambda: done(worker))
    assert worker.newest().settings.focus_distance == 1239.0
    assert generations == sorted(generations)


def test_a_hand_that_never_rests_sees_pictures_all_the_same(start):
    worker = start(replace(SMALL, pixels_x=480, pixels_y=320))
    wait(lambda: worker.newest() is not None)
    generations, i, end = set(), 0, monotonic() + PATIENCE
    while len(generations) < 5:
        assert monotonic() < end
        i += 1
        worker.restart(replace(SMALL, pixels_x=480, pixels_y=320, focus_distance=1200.0 + i))
        generations.add(worker.newest().generation)
        sleep(0.001)                            # far less than a pass


def test_a_pause_holds_and_new_settings_still_get_a_first_picture(start):
    worker = start()
    wait(lambda: done(worker))
    worker.pause()
    worker.restart(replace(SMALL, samples=4096))
    worker.restart(replace(SMALL, samples=4096, f_number=4.0))
    wait(lambda: done(worker, PAUSED_SAMPLES))
    sleep(0.1)
    assert worker.newest().samples == PAUSED_SAMPLES and worker.paused
    worker.restart(replace(SMALL, f_number=4.0))
    worker.resume()
    wait(lambda: done(worker))


@pytest.mark.parametrize(("changed", "word"), [
    ({"lens": "no-such-lens"}, "no-such-lens"),
    ({"focus_distance": 10.0}, "near"),
    ({"f_number": 0.5}, "f/"),
    ({"film_width": 0.0}, "film"),
    ({"scene": "no-such-scene"}, "no-such-scene"),
])
def test_settings_of_no_picture_are_an_error_and_the_old_picture_stays(start, changed, word):
    worker = start()
    wait(lambda: done(worker))
    image = worker.newest().image
    worker.restart(replace(SMALL, **changed))
    wait(lambda: worker.error is not None)
    assert word in str(worker.error.error).lower() and isinstance(worker.error.error, ValueError)
    assert worker.newest().image is image
    worker.restart(SMALL)
    wait(lambda: done(worker))
    assert worker.error is None


def test_an_unforeseen_error_is_news_too(start, monkeypatch):
    worker = start()
    wait(lambda: done(worker))
    monkeypatch.setattr(module, "prepare", lambda settings: 1 // 0)
    worker.again()
    wait(lambda: worker.error is not None)
    assert isinstance(worker.error.error, ZeroDivisionError)
    monkeypatch.undo()
    worker.again()
    wait(lambda: done(worker))


def test_a_drag_does_not_wait_for_the_choices_of_settings_that_have_gone_by(start, monkeypatch):
    worker = start()
    wait(lambda: done(worker) and not worker.newest().is_provisional)
    go, begun = threading.Event(), []

    def slow(settings, *rest):
        begun.append(settings.focus_distance)
        assert go.wait(PATIENCE)
        return choose(settings, *rest)

    monkeypatch.setattr(render_job, "choose", slow)
    try:
        for i in range(1, 9):
            worker.restart(replace(SMALL, focus_distance=1200.0 + 50.0 * i))
            end = monotonic() + 120.0
            while worker.newest().generation != worker.generation:
                assert monotonic() < end
                sleep(0.002)
            worker.shown(worker.newest())
            wait(lambda: begun)                 # the choice is asked for
            sleep(0.05)
        assert len(begun) == 1
    finally:
        go.set()
    wait(lambda: done(worker) and not worker.newest().is_provisional)
    assert len(begun) <= 3                      # the choices of the settings between are never begun


def test_a_frame_is_not_held_for_settings_that_fail(start, monkeypatch):
    worker = start()
    wait(lambda: done(worker))
    monkeypatch.setattr(module, "HOLD_SECONDS", 60.0)
    begin = monotonic()
    worker.restart(replace(SMALL, scene="no-such-scene"))
    worker.await_set_up()
    assert monotonic() - begin < 30.0 and worker.error is not None


def test_other_settings_do_not_wait_for_the_frame_of_the_picture_before(start, monkeypatch):
    worker = start(replace(SMALL, lens_model="polynomial", degree=5))
    wait(lambda: done(worker))
    monkeypatch.setattr(module, "FIRST_SECONDS", 60.0)      # both longer than the test may take
    monkeypatch.setattr(module, "HOLD_SECONDS", 60.0)
    begin = monotonic()
    for distance in (1230.0, 1260.0, 1290.0):               # no frame shows their pictures: it would wait for the next
        worker.restart(replace(SMALL, lens_model="polynomial", degree=5, focus_distance=distance))
        wait(lambda: worker.newest().generation == worker.generation)
    assert monotonic() - begin < 30.0


PLAIN = replace(SMALL, lens_model="polynomial", degree=5)       # no model is chosen


def moved(worker, i, followed=True):
    """Turn the focus, wait for the first picture, and show it."""
    worker.restart(replace(PLAIN, focus_distance=1200.0 + 50.0 * i))
    wait(lambda: worker.newest() is not None and worker.newest().generation == worker.generation)
    worker.shown(worker.newest(), followed)


def settled(worker):
    """Show the pictures until the last one is complete."""
    wait(lambda: worker.shown(worker.newest()) or done(worker))


@pytest.fixture
def traced(monkeypatch):
    """The arguments of the calls of `own_light`, each with its rendering first."""
    calls, own_light = [], lb.Rendering.own_light

    def told(*arguments):
        calls.append(arguments)
        return own_light(*arguments)

    monkeypatch.setattr(lb.Rendering, "own_light", told)
    return calls


def test_lights_are_traced_at_once_after_a_rest_and_seldom_while_a_dial_is_dragged(start, traced, monkeypatch):
    worker = start(PLAIN)
    settled(worker)
    assert len(traced) == 1
    monkeypatch.setattr(render_job, "LIGHT_SECONDS", 600.0)
    monkeypatch.setattr(module, "REST_SECONDS", 2.0)
    for i in range(1, 7):
        moved(worker, i)
    assert len(traced) == 1
    settled(worker)                                         # at rest: its own light
    assert len(traced) == 2 and traced[1][0].camera is not traced[0][0].camera
    monkeypatch.setattr(render_job, "LIGHT_SECONDS", 0.0)   # long after the last ones: at once, and during a drag
    monkeypatch.setattr(module, "REST_SECONDS", 600.0)
    moved(worker, 7)
    wait(lambda: len(traced) == 3)


def test_lights_wait_for_the_panels(start, traced, monkeypatch):
    worker = start(PLAIN)
    settled(worker)
    monkeypatch.setattr(render_job, "LIGHT_SECONDS", 0.0)
    monkeypatch.setattr(module, "HOLD_SECONDS", 600.0)
    moved(worker, 1, followed=False)
    sleep(0.2)
    assert len(traced) == 1 and worker.newest().samples == 1
    settled(worker)
    assert len(traced) == 2


def test_lights_leave_the_processors_to_the_first_picture_of_other_settings(start, traced, monkeypatch):
    monkeypatch.setattr(render_job, "LIGHT_SECONDS", 600.0)
    worker = start(PLAIN)
    settled(worker)
    is_wanted, free, add, answers = traced[0][3], threading.Event(), lb.Rendering.add, []
    monkeypatch.setattr(lb.Rendering, "add", lambda *rest: free.wait(PATIENCE) and add(*rest))
    worker.restart(replace(PLAIN, focus_distance=1500.0))
    asking = threading.Thread(target=lambda: answers.append(is_wanted()))
    asking.start()
    sleep(0.2)
    assert not answers
    free.set()
    settled(worker)
    asking.join(PATIENCE)
    assert answers == [True]


def test_a_second_model_of_the_same_picture_gives_way_at_once(start, monkeypatch):
    worker = start()
    wait(lambda: done(worker) and not worker.newest().is_provisional)
    restarted, add, updates = threading.Event(), lb.Rendering.add, []

    def other_model(settings, view, *rest):
        chosen = choose(settings, view, *rest)
        assert chosen.choice.model != "trace"
        return chosen._replace(choice=replace(chosen.choice, model="trace", degree=0))

    def hold_back(rendering, count, *rest):
        if rendering.samples == 0 and worker.newest().generation == worker.generation and not restarted.is_set():
            worker.restart(SMALL)                           # while the first pass of the second model begins
            restarted.set()
            updates.append(add(rendering, count, *rest))
            return updates[-1]
        return add(rendering, count, *rest)

    monkeypatch.setattr(render_job, "choose", other_model)
    monkeypatch.setattr(module, "FIRST_SECONDS", 60.0)
    monkeypatch.setattr(lb.Rendering, "add", hold_back)
    worker.restart(replace(SMALL, focus_distance=1500.0))
    wait(restarted.is_set)
    wait(lambda: updates)
    assert updates == [False]


@pytest.mark.slow
def test_a_complete_picture_is_rendered_again_when_its_light_tracing_is_compiled(start, monkeypatch):
    compiled, traced = threading.Event(), []
    monkeypatch.setattr(compilers, "trace_lights", lambda scene: traced.append(scene) or compiled.wait(PATIENCE))
    settings = replace(SMALL, scene="night-lights")
    worker = start(settings, expect=lambda asked: asked == settings)
    wait(lambda: done(worker))
    first = worker.newest()
    sleep(0.1)
    assert worker.generation == first.generation and len(traced) == 1
    compiled.set()
    wait(lambda: worker.generation > first.generation and done(worker))
    assert not np.array_equal(worker.newest().image, first.image)


def test_it_ends_in_the_middle_of_its_work():
    worker = RenderWorker(replace(SMALL, samples=10**6), threads=2)
    wait(lambda: worker.newest() is not None)
    worker.stop()
    assert not any(thread.name.startswith("lensbench r") for thread in threading.enumerate())
