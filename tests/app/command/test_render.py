"""The command `lensbench render`: sequences, and renders that are stopped and go on."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from time import sleep

import numpy as np
import pytest
from PIL import Image

from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.app.session.export import read_settings

MOVING = ["render", "pbrt-dgauss-50mm", "--scene", "white-wall", "--end-position=1m,0,0", "--duration", "2s",
          "--size", "12x8", "--samples", "1", "--threads", "1"]


@pytest.mark.slow
def test_frames_are_evenly_spaced_over_the_duration(tmp_path, capsys):
    assert main([*MOVING, "--frames", "4", "--json", "-o", str(tmp_path / "a.png")]) == 0
    names = [f"a-000{i}.png" for i in (1, 2, 3, 4)]
    assert sorted(os.listdir(tmp_path)) == names
    assert [os.path.basename(figures["path"]) for figures in json.loads(capsys.readouterr().out)] == names
    assert [read_settings(tmp_path / name).moment for name in names] == [0.0, 0.5, 1.0, 1.5]


@pytest.mark.slow
def test_frames_that_are_there_are_left_out(tmp_path, capsys):
    words = [*MOVING, "--frames", "3", "--resume", "-o", str(tmp_path / "a.png")]
    assert main(words) == 0
    (tmp_path / "a-0002.png").unlink()
    kept = {name: (tmp_path / name).stat().st_mtime_ns for name in os.listdir(tmp_path)}
    capsys.readouterr()
    assert main(words) == 0
    assert "2 of 3 frames were there already" in capsys.readouterr().out
    assert {name: (tmp_path / name).stat().st_mtime_ns for name in kept} == kept
    assert (tmp_path / "a-0002.png").exists()
    assert main([*words, "--bits", "16"]) == 0
    assert "keep their noise and bit depth" in capsys.readouterr().err


@pytest.mark.slow
def test_frames_older_than_the_lens_file_are_rendered_again(tmp_path, capsys):
    lens = tmp_path / "lens.toml"
    lenses.save(lenses.load("pbrt-dgauss-50mm"), lens)
    words = [MOVING[0], str(lens), *MOVING[2:], "--frames", "2", "--resume", "-o", str(tmp_path / "a.png")]
    assert main(words) == 0
    assert main(words) == 0
    assert "2 of 2 frames were there already" in capsys.readouterr().out
    later = max((tmp_path / f"a-000{i}.png").stat().st_mtime_ns for i in (1, 2)) + 10**9
    os.utime(lens, ns=(later, later))
    assert main(words) == 0
    assert "were there already" not in capsys.readouterr().out


@pytest.mark.slow
def test_frames_of_fewer_samples_are_rendered_again(tmp_path, capsys):
    words = [*MOVING, "--frames", "2", "--resume", "-o", str(tmp_path / "a.png")]
    assert main(words) == 0
    capsys.readouterr()
    assert main([*words, "--samples", "3"]) == 0
    assert "were there already" not in capsys.readouterr().out
    assert read_settings(tmp_path / "a-0002.png").samples == 3


@pytest.mark.parametrize(("words", "message"), [
    (["--frames", "1"], "2 to 100000 frames make a sequence"),
    (["--frames", "3", "--moment", "2s"], "is not before the end")])
def test_sequences_that_cannot_be_are_one_line(tmp_path, capsys, words, message):
    assert main([*MOVING, *words, "-o", str(tmp_path / "a.png")]) == 2
    assert message in capsys.readouterr().err and not os.listdir(tmp_path)


def test_frames_of_what_stands_still_are_refused(tmp_path, capsys):
    still = ["render", "pbrt-dgauss-50mm", "--scene", "white-wall", "--frames", "3"]
    assert main([*still, "-o", str(tmp_path / "a.png")]) == 2
    assert "nothing moves" in capsys.readouterr().err


def test_the_noise_that_was_reached_is_printed(tmp_path, capsys):
    words = ["render", "pbrt-dgauss-50mm", "--scene", "white-wall", "--size", "12x8", "-o", str(tmp_path / "a.png")]
    for impossible in ("0", "-1%", "200%"):             # before anything is rendered
        assert main([*words, f"--until-noise={impossible}"]) == 2
    assert main([*words, "--until-noise", "5%", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["noise_reached"] and figures["noise"] <= 0.05 and figures["samples"] < 64
    assert main([*words, "--until-noise", "0.001%", "--samples", "16"]) == 0
    assert "above the noise asked for" in capsys.readouterr().out


def _heeds(process: int, number: int) -> bool:
    """Whether a process has a handler of its own for a signal (proc(5), SigCgt)."""
    status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    return bool(int(status.split("SigCgt:")[1].split()[0], 16) >> (number - 1) & 1)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="the state of another process is read from /proc")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_keeps_the_samples_and_the_same_command_goes_on(tmp_path, number):
    words = [sys.executable, "-m", "lensbench.app", "render", "pbrt-dgauss-50mm", "--size", "300x200",
             "--threads", "1", "--resume", "-o", str(tmp_path / "a.png")]
    with subprocess.Popen([*words, "--samples", "100000"], stderr=subprocess.PIPE, text=True) as running:
        while not _heeds(running.pid, signal.SIGTERM):              # Python itself heeds the other one from its start
            assert running.poll() is None
            sleep(0.05)
        running.send_signal(number)
        error = running.communicate(timeout=240.0)[1]
    assert running.returncode == 128 + number and "the same command goes on from there" in error
    assert os.listdir(tmp_path) == ["a.png.part.npz"]
    with np.load(tmp_path / "a.png.part.npz") as kept:
        samples = int(kept["samples"])
    done = subprocess.run([*words, "--samples", str(samples + 1)], check=True, capture_output=True, text=True)
    assert f"{samples + 1} samples each" in done.stdout
    with Image.open(tmp_path / "a.png") as read:
        assert read.size == (300, 200)
    assert os.listdir(tmp_path) == ["a.png"]
