"""The command improve: the lens it writes, what it reports, and its refusals."""

import json
import signal
import subprocess
import sys

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main


@pytest.mark.slow
def test_the_command_writes_the_improved_lens_in_focus_and_its_steps(tmp_path, capsys):
    path = tmp_path / "better.toml"
    assert main(["improve", "lenshh-cooke-triplet-50", "--vary", "5.radius,5.radius", "-o", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["spots_mm"][-1] < told["spots_mm"][0] and told["image_height_mm"] == pytest.approx(18.2)
    assert told["ended"] == "converged" and len(told["numbers"]) == 1 and len(told["judged"]) == 2
    written, before = lenses.load(path), lenses.load("lenshh-cooke-triplet-50")
    assert written.surfaces[5].curvature == told["numbers"][0]["after"]
    goal = lb.goal_of(before, 18.2)
    judgement = lb.judge(written, goal)
    assert judgement.rms == pytest.approx(told["spots_mm"][-1], rel=1e-6)
    assert written.surfaces[-1].thickness == pytest.approx(judgement.films[0], abs=1e-6)
    for now, target in zip((lb.first_order(written).f_number, lb.first_order(written).efl), goal.positions[0].held,
                         strict=True):
        assert now == pytest.approx(target, rel=1e-4)


def test_refusals_are_one_line(capsys):
    for words, said in ((["--vary", "9.radius"], "of surfaces 0 to 5"), (["--glasses", "brass"], "no glass of BRASS"),
                        (["--vary", "3.semi-diameter"], "bends no ray")):
        assert main(["improve", "lenshh-cooke-triplet-50", *words]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.slow
def test_wave_errors_are_reported_in_waves(capsys):
    assert main(["improve", "lenshh-cooke-triplet-50", "--merit", "wavefront", "--vary", "5.radius"]) == 0
    out = capsys.readouterr().out
    assert "waves rms" in out and "judged   wavelengths F, d and C" in out and "converged: " in out


@pytest.mark.slow
def test_ctrl_c_ends_it_and_keeps_the_best_lens(tmp_path):
    path = tmp_path / "better.toml"
    run = subprocess.Popen([sys.executable, "-c", "from lensbench.app.command.main import main; import sys; sys.exit("
                            "main(sys.argv[1:]))", "improve", "lenshh-cooke-triplet-50", "--vary", "all", "-o",
                            str(path)], stdout=subprocess.PIPE, text=True)
    for line in run.stdout:
        if line.startswith("step  2"):
            run.send_signal(signal.SIGINT)
            break
    rest = run.communicate(timeout=120)[0]
    assert run.returncode == 0
    assert "cancelled" in rest and lenses.load(path).surfaces != lenses.load("lenshh-cooke-triplet-50").surfaces
