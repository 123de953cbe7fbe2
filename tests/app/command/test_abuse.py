"""The command line under abuse: a picture of finite numbers, or one clear line. The short form of `make abuse`."""

import pytest

from tests.app.command.abuse import fault, faults

SMALL = ["render", "pbrt-dgauss-50mm", "--lens-model=thin", "--size=6x4", "--samples=1", "--scene=grid-wall"]


@pytest.mark.slow
def test_random_commands_end_with_a_picture_or_one_clear_line(tmp_path, capsys):
    assert faults(150, "short", tmp_path, capsys) == []


@pytest.mark.parametrize("words", [
    "--f-number=1e308", "--f-number=1e-320", "--focal-length=1e300", "--focal-length=1e-300", "--fov=1e-320",
    "--camera=perspective --fov=1e-320", "--camera=perspective --f-number=0", "--focus=1e-308",
    "--camera=finite-pinhole --hole-diameter=1e-320",
    "--focus=1e308", "--exposure=1e300", "--medium=fog --fog-light=1e150", "--scene=" + "x" * 10_000,
    "--film=1e300x1e300", "--film=1e-300x1e-300", "--shutter=1/" + "9" * 400, "--iso=1e300", "--position=1e300,0,0"])
def test_a_value_that_once_ended_in_a_failure_is_one_line_with_the_range(tmp_path, capsys, words):
    assert fault([*SMALL, *words.split()], tmp_path, capsys) == ""
    assert not (tmp_path / "a.exr").exists()
