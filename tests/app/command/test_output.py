"""Output files of the commands: a place that cannot be written ends it before its work."""

import pytest

from lensbench.app.command.main import main

COMMANDS = {
    "improve": ("improve", "lenshh-cooke-triplet-50", ".toml"),
    "tolerances": ("tolerances", "lenshh-cooke-triplet-50", ".svg"),
    "novel": ("lightfield", "novel", "no-such-array.npz", ".png"),
    "refocus": ("lightfield", "refocus", "no-such-field.npz", ".png"),
    "view": ("lightfield", "view", "no-such-field.npz", "--depth", ".png"),
    "trace": ("trace", "lenshh-cooke-triplet-50", "--rays", "no-such-rays.csv", ".csv"),
    "convert": ("convert", "lenshh-cooke-triplet-50", ".zmx"),
    "contact-sheet": ("contact-sheet", "pbrt-dgauss-50mm", ".jpg"),
    "export": ("export", "camera", "pbrt-dgauss-50mm", "--to", "pbrt", ".pbrt"),
}


@pytest.fixture(autouse=True)
def no_work(monkeypatch):
    """The long work of the commands fails at its first step."""
    def begun(*arguments, **named):
        raise AssertionError("the work has begun")

    for work in ("core.design.standard_goal.goal_of", "core.design.tolerances.sensitivities",
                 "app.session.contact_sheet.rendered_cells"):
        monkeypatch.setattr(f"lensbench.{work}", begun)


def refused(capsys, name, path):
    *words, _ = COMMANDS[name]
    target = [str(path)] if name == "convert" else ["-o", str(path)]
    assert main([*words, *target]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"lensbench: {path}: ") and error.count("\n") == 1, error
    return error


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_is_missing_is_named(tmp_path, capsys, name):
    assert f"there is no folder {tmp_path / 'no'}" in refused(capsys, name, tmp_path / "no" / f"a{COMMANDS[name][-1]}")


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_in_place_of_the_file_is_refused(tmp_path, capsys, name):
    target = tmp_path / f"a{COMMANDS[name][-1]}"
    target.mkdir()
    assert "this is a folder" in refused(capsys, name, target)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_suffix_that_is_not_written_is_refused_with_those_that_are(tmp_path, capsys, name):
    assert COMMANDS[name][-1] in refused(capsys, name, tmp_path / "a.xyz")
    assert not list(tmp_path.iterdir())
