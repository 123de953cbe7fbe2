"""The table of results of reading the lens files in a folder."""

import pytest

from lensbench import lenses
from tests.lenses.outcome import tables


def test_the_table_counts_the_files_that_are_read_and_those_that_are_refused(tmp_path):
    lenses.save(lenses.load("pbrt-dgauss-50mm"), tmp_path / "good.zmx")
    (tmp_path / "bad.zmx").write_text("no lens")
    lines = tables(tmp_path)
    assert "| Zemax `.zmx` | 2 | 1 | 1 |" in lines and "| all | 2 | 1 | 1 |" in lines


def test_a_folder_that_is_missing_or_holds_no_lens_files_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="there is no such folder"):
        tables(tmp_path / "no")
    with pytest.raises(SystemExit, match=r"holds no lens files \(\.zmx, "):
        tables(tmp_path)
