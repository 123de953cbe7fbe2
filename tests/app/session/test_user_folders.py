"""The folders of what a user keeps: those of the XDG base directory specification, its defaults where none is named."""

import pytest

from lensbench.app.session.states import snapshots_folder, unsaved_folder
from lensbench.app.workers.lens_pictures import pictures_folder
from lensbench.lenses.glass.catalogue import user_folder

FOLDERS = [(snapshots_folder, "XDG_DATA_HOME", ".local/share", "snapshots"),
           (unsaved_folder, "XDG_CONFIG_HOME", ".config", "unsaved"),
           (user_folder, "XDG_CONFIG_HOME", ".config", "glass"),
           (pictures_folder, "XDG_CACHE_HOME", ".cache", "thumbnails")]


@pytest.mark.parametrize("folder, variable, default, name", FOLDERS)
def test_a_folder_is_where_the_variable_says_and_else_at_its_default(folder, variable, default, name, tmp_path,
                                                                     monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv(variable, str(tmp_path / "elsewhere"))
    assert folder() == tmp_path / "elsewhere" / "lensbench" / name
    monkeypatch.setenv(variable, "")                # counts as not set
    assert folder() == tmp_path / default / "lensbench" / name
    monkeypatch.delenv(variable)
    assert folder() == tmp_path / default / "lensbench" / name
