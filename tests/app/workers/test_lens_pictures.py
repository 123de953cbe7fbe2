"""Small pictures of lenses: read where they are kept, rendered by a process, named by content, and never in the way."""

import os
import sys
from time import monotonic, sleep, time

import numpy as np
import pytest
from PIL import Image

from lensbench.app.workers.lens_pictures import DAYS, LONGER_SIDE, LensPictures, file_name, thumbnail_settings

LENS, OTHER, THIRD = "pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "pbrt-telephoto-250mm"
# Instead of the renderer: writes a grey picture, and fails for one lens
QUICK = (sys.executable, "-c", f"""
import sys
from PIL import Image
for line in sys.stdin:
    name, path = line.rstrip().split("\\t")
    if name == "{OTHER}":
        print("LensError: no light", flush=True)
        continue
    Image.new("RGB", (6, 4), (9, 9, 9)).save(path + ".part", "PNG")
    import os; os.replace(path + ".part", path)
    print("ok", flush=True)
""")


def until(done, seconds=180.0):
    end = monotonic() + seconds
    while not done():
        assert monotonic() < end
        sleep(0.01)


@pytest.fixture
def made(tmp_path):
    thumbnails = LensPictures(tmp_path, command=QUICK)
    yield thumbnails
    thumbnails.stop()


def test_a_picture_is_made_once_and_then_read(made, tmp_path):
    made.want([LENS], True)
    until(lambda: not made.missing)
    assert made.found[LENS].shape == (4, 6, 3) and (tmp_path / file_name(LENS)).exists()
    again = LensPictures(tmp_path, command=("there is no such program",))
    again.want([LENS], False)
    until(lambda: not again.missing)
    assert np.array_equal(again.found[LENS], made.found[LENS]) and again.problems == {}
    again.stop()


def test_nothing_is_rendered_while_the_processor_is_needed(made):
    made.want([LENS], False)
    sleep(0.5)
    assert made.missing == 1
    made.want([LENS], True)
    until(lambda: not made.missing)


def test_two_processes_render_at_once_after_the_first_picture(tmp_path):
    """Each picture but the first waits for another process that is at work."""
    command = (sys.executable, "-c", f"""
import os, sys, time
from pathlib import Path
from PIL import Image
for line in sys.stdin:
    name, path = line.rstrip().split("\\t")
    Path({str(tmp_path)!r}, str(os.getpid())).touch()
    end = time.monotonic() + 120.0
    while name != "{LENS}" and len(list(Path({str(tmp_path)!r}).glob("[0-9]*[0-9]"))) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    Image.new("RGB", (6, 4)).save(path, "PNG")
    print("ok" if time.monotonic() < end else "alone", flush=True)
""")
    made = LensPictures(tmp_path / "kept", command=command, processes=2)
    made.want([LENS, OTHER, THIRD], True)
    until(lambda: not made.missing)
    made.stop()
    assert made.problems == {} and made.found.keys() == {LENS, OTHER, THIRD}


def test_a_lens_without_a_picture_says_why_and_the_others_go_on(made):
    made.want([OTHER, LENS], True)
    until(lambda: not made.missing)
    assert made.problems == {OTHER: "LensError: no light"} and LENS in made.found


def test_a_process_that_cannot_start_is_a_problem_and_no_end(tmp_path):
    made = LensPictures(tmp_path, command=("there is no such program",))
    made.want([LENS], True)
    until(lambda: not made.missing)
    assert "No such file" in made.problems[LENS]
    made.stop()


def test_a_damaged_file_is_made_again(made, tmp_path):
    (tmp_path / file_name(LENS)).write_bytes(b"\x89PNG no more")
    made.want([LENS], True)
    until(lambda: not made.missing)
    assert made.found[LENS].shape == (4, 6, 3)


def test_unused_files_are_removed_and_others_stay(made, tmp_path):
    old, new = tmp_path / "0.png", tmp_path / "1.png"
    for path in (old, new):
        path.write_bytes(b"")
    long_ago = time() - (DAYS + 1) * 86400.0
    os.utime(old, (long_ago, long_ago))
    made.want([LENS], True)
    until(lambda: made._tasks and all(task.done for task in made._tasks))
    assert not old.exists() and new.exists()


def test_the_file_changes_with_the_lens_and_the_look():
    assert file_name(LENS) != file_name(OTHER) and file_name(LENS) == file_name(LENS)
    assert file_name(LENS, "a section") != file_name(LENS)


def test_a_stopped_worker_leaves_no_process(tmp_path):
    slow = LensPictures(None, command=(sys.executable, "-c", "import time; time.sleep(600)"))
    slow.want([LENS], True)
    until(lambda: slow._processes)
    process, = slow._processes
    slow.stop()
    assert process.poll() is not None and not slow._folder.exists()


def test_a_thumbnail_shows_the_lens_at_its_best():
    settings = thumbnail_settings(LENS)
    assert max(settings.pixels_x, settings.pixels_y) == LONGER_SIDE and settings.f_number is None


@pytest.mark.slow
def test_the_renderer_writes_a_picture_with_bright_lights(tmp_path):
    made = LensPictures(tmp_path)
    made.want([LENS], True)
    until(lambda: not made.missing, 240.0)
    assert made.problems == {}
    with Image.open(tmp_path / file_name(LENS)) as picture:
        pixels = np.asarray(picture)
    assert pixels.shape[1] == LONGER_SIDE and pixels.max() > 250 and pixels.std() > 20.0
    made.stop()
