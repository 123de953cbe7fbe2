"""The worker of the analysis panels: coarse first, refined when still, and only what a panel wants."""

from dataclasses import replace
from threading import Event, Timer
from time import monotonic, sleep

from lensbench.app.plots.plot import Figure, Table
from lensbench.app.workers import analysis_worker
from lensbench.app.workers.analysis_worker import AnalysisWorker, Job
from lensbench.core.kernels.pauses import pause


def waited(worker, job, done, name="Spots"):
    """Frames of one panel until its answer is as wanted."""
    end = monotonic() + 120.0
    while True:
        worker.advance()
        answer = worker.want(name, job)
        if answer is not None and done(answer):
            return answer
        assert monotonic() < end
        sleep(0.002)


def test_a_figure_is_coarse_first_and_refined_when_still(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    calls = []

    def make(query, points):
        calls.append((query, points))
        return Figure(str(points), (), Table((), ()))

    worker, job = AnalysisWorker(), Job(make, "a lens", (), (16, 64))
    waited(worker, job, lambda answer: answer.refined)
    assert calls == [("a lens", 16), ("a lens", 64)]
    worker.advance()
    worker.want("Spots", job)
    assert not worker.busy and calls == [("a lens", 16), ("a lens", 64)]     # equal jobs are not computed again


def test_a_panel_that_is_no_longer_drawn_computes_nothing(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    begun, go_on, calls = Event(), Event(), []

    def make(query, points):
        calls.append((query, points))
        begun.set()
        assert go_on.wait(20.0)
        return Figure("", (), Table((), ()))

    worker = AnalysisWorker()
    worker.advance()
    worker.want("Spots", Job(make, "first"))
    worker.advance()                            # a frame in which no panel is drawn
    assert begun.wait(20.0)
    worker.advance()
    go_on.set()
    while worker._is_working(refined=False):
        sleep(0.002)
    assert calls == [("first", 16)] and not worker.busy


def test_the_end_waits_for_a_figure_under_way():
    """Its thread was left when the window had ended."""
    begun, go_on, ended = Event(), Event(), Event()

    def make(query, points):
        begun.set()
        assert go_on.wait(20.0)
        ended.set()
        return Figure("", (), Table((), ()))

    worker = AnalysisWorker()
    worker.advance()
    worker.want("Spots", Job(make, "a lens"))
    worker.advance()
    assert begun.wait(20.0)
    Timer(0.1, go_on.set).start()
    worker.stop()
    assert ended.is_set() and not worker._is_working(refined=False)


def test_an_error_is_a_message_and_the_next_job_has_its_own_answer():
    def make(query, points):
        if query == "dark":
            raise ValueError("no light of these fields reaches the film")
        return Figure("", (), Table((), ()))

    worker = AnalysisWorker()
    answer = waited(worker, Job(make, "dark"), lambda answer: answer.figure is None)
    assert answer.message == "no light of these fields reaches the film" and answer.refined
    assert waited(worker, Job(make, "lit"), lambda answer: answer.job.query == "lit").figure is not None


def test_figures_begin_after_the_first_pass_of_the_picture_but_do_not_wait_for_ever(monkeypatch):
    monkeypatch.setattr(analysis_worker, "PATIENCE", 1e9)
    picture, calls = [], []

    def make(query, points):
        calls.append((query, bool(picture)))
        return Figure("", (), Table((), ()))

    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    worker = AnalysisWorker(waits=lambda: not picture)
    job = Job(make, "a lens")
    assert worker.want("Spots", job) is None and worker.busy
    worker.advance()
    sleep(0.02)
    assert calls == [] and worker.busy
    picture.append("first pass")
    waited(worker, job, lambda answer: answer.refined)
    assert calls == 2 * [("a lens", True)]
    picture.clear()
    monkeypatch.setattr(analysis_worker, "PATIENCE", 0.01)
    waited(worker, Job(make, "another"), lambda answer: answer.job.query == "another")
    assert calls[:3] == [*2 * [("a lens", True)], ("another", False)]


def test_a_refined_figure_waits_for_the_picture_too(monkeypatch):
    """It began during the first pass: its job had been wanted for long enough."""
    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    monkeypatch.setattr(analysis_worker, "PATIENCE", 1e9)
    waits, calls = [], []

    def make(query, points):
        calls.append(points)
        waits.append("the next picture")        # it begins while this figure is made
        return Figure("", (), Table((), ()))

    worker, job = AnalysisWorker(waits=lambda: bool(waits)), Job(make, "a lens", (), (16, 64))
    waited(worker, job, lambda answer: not answer.refined)
    for _ in range(10):
        worker.advance()
        worker.want("Spots", job)
        sleep(0.002)
    assert calls == [16]
    waits.clear()
    waited(worker, job, lambda answer: answer.refined)
    assert calls == [16, 64]


def test_a_figure_under_way_pauses_while_the_picture_waits_and_goes_on_where_it_was(monkeypatch):
    monkeypatch.setattr(analysis_worker, "PATIENCE", 1e9)
    waits, parts, go_on = Event(), [], Event()

    def make(query, points):
        parts.append("first")
        assert go_on.wait(60.0)
        pause()
        parts.append("second")
        return Figure("", (), Table((), ()))

    worker, job = AnalysisWorker(waits=waits.is_set), Job(make, "a lens")
    worker.want("Spots", job)
    worker.advance()
    while not parts:
        sleep(0.001)
    waits.set()                                 # a dial moves
    go_on.set()
    sleep(0.02)
    assert parts == ["first"] and worker.want("Spots", job) is None
    waits.clear()
    waited(worker, job, lambda answer: answer.figure is not None)
    assert parts[:2] == ["first", "second"]


def test_a_refined_figure_ends_when_its_panel_wants_another_one(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    refining, finished = Event(), []

    def make(query, points):
        if query == "before" and points == 64:
            refining.set()
            while True:                         # it would never end
                sleep(0.001)
                pause()
        finished.append((query, points))
        return Figure("", (), Table((), ()))

    worker = AnalysisWorker()
    waited(worker, Job(make, "before", (), (16, 64)), lambda answer: refining.is_set())
    waited(worker, Job(make, "after", (), (16, 64)), lambda answer: answer.refined and answer.job.query == "after")
    assert finished == [("before", 16), ("after", 16), ("after", 64)]


def test_the_work_begins_before_the_panel_asks_where_the_window_knows_what_it_will_want(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 1e9)
    calls, begun = [], Event()

    def make(query, points):
        calls.append(query)
        if query == "after":
            begun.set()
        return Figure("", (), Table((), ()))

    worker, after = AnalysisWorker(), Job(make, "after")
    waited(worker, Job(make, "before"), lambda answer: True)
    worker.advance({"Spots": after, "no longer drawn": Job(make, "never")})
    assert begun.wait(60.0) and worker.wants("Spots") and not worker.wants("no longer drawn")
    assert waited(worker, after, lambda answer: answer.job == after).figure is not None
    assert calls.count("after") == 1 and "never" not in calls


def test_a_coarse_figure_does_not_wait_for_a_refined_one_that_is_under_way(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 0.0)
    refining, go_on = Event(), Event()

    def make(query, points):
        if points == 64:
            refining.set()
            assert go_on.wait(60.0)             # without a place where it could pause or end
        return Figure(query, (), Table((), ()))

    worker = AnalysisWorker()
    waited(worker, Job(make, "before", (), (16, 64)), lambda answer: refining.is_set())
    after = Job(make, "after", (), (16, 64))
    assert waited(worker, after, lambda answer: answer.job == after).figure.title == "after"
    assert not go_on.is_set()
    go_on.set()                                 # the older figure, done at last, does not take the place of the newer
    assert waited(worker, after, lambda answer: answer.refined).job == after


def test_a_frame_is_held_for_figures_that_are_about_to_come_and_not_for_slow_ones(monkeypatch):
    monkeypatch.setattr(analysis_worker, "STILL", 1e9)
    monkeypatch.setattr(analysis_worker, "HOLD_SECONDS", 30.0)
    begun, go_on = Event(), Event()

    def make(query, points):
        begun.set()
        if query == "awaited":
            go_on.wait(60.0)
        return Figure(query, (), Table((), ()))

    worker, awaited = AnalysisWorker(), Job(make, "awaited")
    waited(worker, Job(make, "first"), lambda answer: True)
    begun.clear()
    worker.follow({"Spots": awaited})           # at the end of the frame before
    assert begun.wait(60.0)
    worker.advance()
    Timer(0.05, go_on.set).start()
    worker.await_coarse()
    answer = worker.want("Spots", awaited)
    assert answer is not None and answer.job == awaited and not worker.is_late

    go_on.clear()
    monkeypatch.setattr(worker, "_seconds", {"Spots": 40.0})       # of a processor, the last time
    worker.follow({"Spots": replace(awaited, points=(8, 16))})
    worker.advance()
    worker.await_coarse()                       # at once
    worker.want("Spots", replace(awaited, points=(8, 16)))
    assert worker.is_late
    go_on.set()


def test_answers_of_panels_that_are_not_shown_are_dropped():
    worker, job = AnalysisWorker(), Job(lambda query, points: Figure("", (), Table((), ())), "a lens")
    waited(worker, job, lambda answer: True, "Wavefront")
    waited(worker, job, lambda answer: True, "Spots")
    worker.forget()
    worker.advance()
    assert worker.want("Wavefront", job) is None and worker.want("Spots", job) is not None
