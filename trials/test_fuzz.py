"""Readers against 2,000 mishaps of bytes and 2,000 of lines for every sample file: an error or a lens, no traceback.

Of the samples of the tests and of lenses of the library in each format; with LENSBENCH_LENS_FILES=FOLDER of every
lens file in that folder, too. A file on which a reader hangs ends the run with the place where it does.
"""

import os
from pathlib import Path

import pytest

from lensbench import lenses
from lensbench.lenses.formats import READERS, WRITERS
from tests.lenses.mishaps import by_bytes, by_lines, outlive
from tests.lenses.samples import DATA

TIMES = int(os.environ.get("LENSBENCH_FUZZ_TIMES", "2000"))
OWN = os.environ.get("LENSBENCH_LENS_FILES")
FILES = sorted(path for folder in (DATA, OWN) if folder for path in Path(folder).rglob("*")
               if path.suffix.lower() in READERS and path.name != "README.txt")
LENSES = ("pbrt-dgauss-50mm", "lib-us10281683")


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("source", FILES, ids=lambda path: path.name)
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, source, mutate):
    found = outlive(tmp_path / f"damaged{source.suffix}", source.read_bytes(), mutate, TIMES, source.name)
    _can_be_used(found, tmp_path)


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("name", LENSES)
def test_a_damaged_file_of_our_own_is_a_lens_or_one_clear_line(tmp_path, name, suffix, mutate):
    lenses.save(lenses.load(name), tmp_path / f"whole{suffix}")
    found = outlive(tmp_path / f"damaged{suffix}", (tmp_path / f"whole{suffix}").read_bytes(), mutate, TIMES, name)
    _can_be_used(found, tmp_path)


def _can_be_used(found, folder):
    """What was read can be checked, and written in every format."""
    for lens in found[::max(1, len(found) // 20)]:
        lenses.check(lens)
        for suffix in WRITERS:
            lenses.save(lens, folder / f"again{suffix}")
            again = lenses.load(folder / f"again{suffix}")
            assert suffix != ".toml" or again == lens
