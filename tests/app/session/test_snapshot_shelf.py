"""The shelf of snapshots: kept, named, found again and removed as files, whole or not at all."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.session.export import ExportError, read_settings
from lensbench.app.session.snapshots import THUMBNAIL, SnapshotShelf, cleaned
from lensbench.app.settings.settings import Settings

SETTINGS = replace(Settings(), pixels_x=360, pixels_y=240, f_number=4.0, tone="none")
IMAGE = np.full((240, 360, 3), 0.25, np.float32)


def test_moments_are_found_again_by_another_session(tmp_path):
    shelf = SnapshotShelf(tmp_path / "deep" / "snapshots")
    shelf.load()
    assert shelf.snapshots == []
    first = shelf.keep(IMAGE, SETTINGS, "Swirl: at f/4?")
    second = shelf.keep(2.0 * IMAGE, replace(SETTINGS, f_number=8.0), "Swirl: at f/4?")
    assert (first.name, second.name) == ("Swirl at f⁄4", "Swirl at f⁄4 2")
    shelf.rename(second, "closed")
    later = SnapshotShelf(tmp_path / "deep" / "snapshots")
    later.load()
    assert {kept.name: kept.settings.f_number for kept in later.snapshots} == {"Swirl at f⁄4": 4.0, "closed": 8.0}
    assert later.snapshots[0].thumbnail.shape == (192, THUMBNAIL, 3)
    assert read_settings(first.path) == SETTINGS
    # sRGB of 0.25: 1.055 · 0.25^(1/2.4) − 0.055 = 0.537
    np.testing.assert_allclose(first.codes(), 0.537, atol=0.003)
    later.remove(later.snapshots[0])
    assert len(list((tmp_path / "deep" / "snapshots").iterdir())) == 1


def test_a_strange_file_on_the_shelf_is_said_and_the_others_are_read(tmp_path):
    shelf = SnapshotShelf(tmp_path)
    shelf.keep(IMAGE, SETTINGS, "good")
    (tmp_path / "bad.png").write_bytes(b"no picture")
    said = []
    later = SnapshotShelf(tmp_path, said.append)
    later.load()
    assert [snapshot.name for snapshot in later.snapshots] == ["good"] and len(said) == 1 and "bad" in said[0]


def test_a_shelf_that_cannot_be_written_says_so(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ExportError, match="not kept"):
        SnapshotShelf(tmp_path / "file").keep(IMAGE, SETTINGS, "a")


def test_names_become_names_of_files():
    assert cleaned("  a/b\\c:  ..") == "a b c" and cleaned("///") == "snapshot" and len(cleaned("x" * 500)) == 60
