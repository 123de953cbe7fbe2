"""Damaged files of the project's own formats: each reads as a lens, or LensFileError says why not in one line."""

import pytest

from lensbench import lenses
from tests.lenses.damage import lenses_outlive
from tests.library import CLASSICS
from tests.mishaps import by_bytes, by_lines


@pytest.mark.slow
@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("suffix", [".toml", ".dat"])
@pytest.mark.parametrize("name", [*CLASSICS[::3], "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"])
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, name, suffix, mutate):
    path = tmp_path / f"lens{suffix}"
    lenses.save(lenses.load(name), path)
    for lens in lenses_outlive(path, path.read_bytes(), mutate, 20, name):
        lenses.save(lens, tmp_path / "again.toml")
        assert lenses.load(tmp_path / "again.toml") == lens
