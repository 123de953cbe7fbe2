"""Lens and scene files that change on disk are read again; what cannot be read keeps the last good picture."""

import os
from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import design
from lensbench.app.settings.settings import Settings
from lensbench.app.window.state import FileWatch
from tests.app.conftest import SMALL

SCENE = '[floor]\nheight = "{height}m"\n'


def write(path, text):
    """Change the content; the time stamp of a file may be as coarse as two seconds."""
    path.write_text(text, encoding="utf-8")
    later = path.stat().st_mtime_ns + 2_000_000_000
    os.utime(path, ns=(later, later))


def test_a_change_is_noticed_once_and_at_most_once_a_second(tmp_path):
    path = tmp_path / "scene.toml"
    write(path, SCENE.format(height=-1))
    settings, watch = replace(Settings(), scene=str(path)), FileWatch()
    assert watch.changed(settings, 0.0) == ([], {})             # seen for the first time
    write(path, SCENE.format(height=-2) + "\n")
    assert watch.changed(settings, 0.5) == ([], {})
    assert watch.changed(settings, 1.0) == ([str(path)], {})
    assert watch.changed(settings, 2.0) == ([], {})


def test_a_change_is_noticed_of_a_file_named_within_the_second_after_a_look(tmp_path):
    path = tmp_path / "scene.toml"
    write(path, SCENE.format(height=-1))
    settings, watch = replace(Settings(), scene=str(path)), FileWatch()
    watch.changed(Settings(), 0.0)
    assert watch.changed(settings, 0.4) == ([], {})
    write(path, SCENE.format(height=-2) + "\n")
    assert watch.changed(settings, 1.0) == ([str(path)], {})


@pytest.mark.parametrize("broken", ["[floor\n", None])
def test_an_unreadable_or_missing_file_is_said_once_until_it_can_be_read(tmp_path, broken):
    path = tmp_path / "scene.toml"
    write(path, SCENE.format(height=-1))
    settings, watch = replace(Settings(), scene=str(path)), FileWatch()
    watch.changed(settings, 0.0)
    path.unlink() if broken is None else write(path, broken)
    changed, problems = watch.changed(settings, 1.0)
    assert changed == [] and "scene.toml has changed and cannot be read" in problems[str(path)]
    assert watch.changed(settings, 2.0) == ([], {})
    write(path, SCENE.format(height=-3) + "\n\n")
    assert watch.changed(settings, 3.0) == ([str(path)], {})


@pytest.mark.slow
def test_the_window_reloads_a_lens_file_and_keeps_the_picture_while_it_is_half_written(drive, tmp_path):
    path, other = tmp_path / "mine.toml", tmp_path / "other.toml"
    lenses.save(lenses.load("lv-czj-tessar-50-f28"), path)
    lenses.save(lenses.load("lv-czj-tessar-50-f28").scaled(1.5), other)
    text = other.read_text(encoding="utf-8")

    def use(hand):
        hand.picture()
        start = replace(SMALL, lens=str(path))
        hand.session.take(start)
        hand.picture()
        hand.ctx.yield_(5)
        before, generation = hand.session.presenter.update, hand.session.worker.generation
        write(path, text[:len(text) // 2])
        hand.wait(lambda: hand.session.view.messages, "word of the broken file")
        assert "mine.toml has changed and cannot be read" in hand.session.view.messages[0]
        hand.ctx.yield_(5)
        assert hand.session.worker.generation == generation and hand.session.presenter.update is before
        assert hand.settings == start
        # Other settings are rendered with the last good lens, and every panel shows it
        hand.session.take(replace(start, focus_distance=1500.0))
        hand.picture()
        assert hand.settings == replace(start, focus_distance=1500.0) and len(hand.session.view.messages) == 1
        write(path, text + "\n\n")
        hand.wait(lambda: "Reloaded mine.toml" in hand.session.view.messages, "the reloaded lens")
        hand.picture()
        assert hand.session.view.messages == ["Reloaded mine.toml"]
        assert hand.session.presenter.update.generation > generation
        efl = lb.first_order(design(hand.settings)).efl
        assert efl == pytest.approx(1.5 * lb.first_order(lenses.load("lv-czj-tessar-50-f28")).efl, rel=1e-6)

    drive(use)
