"""Every reader against 2,000 mishaps of each kind for every sample file: one clear line, or what the file says.

Lens files: the samples of the tests and lenses of the library in each format; with LENSBENCH_LENS_FILES=FOLDER of every
lens file in that folder, too. Settings, pictures, recordings, scenes and glass catalogues: small whole ones.
LENSBENCH_FUZZ_TIMES=N is another number of mishaps. A traceback, a warning of numpy, an endless message or a damaged
recording that opens fails; a file on which a reader hangs ends the run with the place where it does.
"""

import os
import re
from pathlib import Path

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.scenes.scene_file import SceneFileError, load_scene
from lensbench.lenses.formats.table import READERS, WRITERS
from lensbench.lenses.glass import agf
from tests.app.scenes.test_scene_file import DOCUMENT
from tests.app.session.test_damaged_files import WAYS, files, goes_on  # noqa: F401 - the fixture
from tests.lenses.damage import lenses_outlive
from tests.lenses.glass.test_glass_catalogue import BK7
from tests.lenses.samples import DATA
from tests.lenses.wrong_types import outlived, rng_of, texts
from tests.mishaps import by_bytes, by_lines, outlive

TIMES = int(os.environ.get("LENSBENCH_FUZZ_TIMES", "2000"))
OWN = os.environ.get("LENSBENCH_LENS_FILES")
FILES = sorted(path for folder in (DATA, OWN) if folder for path in Path(folder).rglob("*")
               if path.suffix.lower() in READERS and path.name != "README.txt")
LENSES = ("pbrt-dgauss-50mm", "lib-us10281683")


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("source", FILES, ids=lambda path: path.name)
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, source, mutate):
    survivors = lenses_outlive(tmp_path / f"damaged{source.suffix}", source.read_bytes(), mutate, TIMES, source.name)
    _can_be_used(survivors, tmp_path)


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("name", LENSES)
def test_a_damaged_file_of_our_own_is_a_lens_or_one_clear_line(tmp_path, name, suffix, mutate):
    lenses.save(lenses.load(name), tmp_path / f"whole{suffix}")
    whole = (tmp_path / f"whole{suffix}").read_bytes()
    survivors = lenses_outlive(tmp_path / f"damaged{suffix}", whole, mutate, TIMES, name)
    _can_be_used(survivors, tmp_path)


@pytest.mark.parametrize("source", FILES, ids=lambda path: path.name)
def test_a_value_of_another_type_is_one_clear_line(tmp_path, source):
    assert any([outlived(tmp_path / f"damaged{source.suffix}", text)
                for text in texts(source, rng_of(source.name), TIMES)])


@pytest.mark.parametrize(("name", "way"), WAYS, ids=lambda way: getattr(way, "__name__", way))
def test_damaged_settings_pictures_and_recordings_are_one_clear_line_or_what_was_written(files, tmp_path, name, way):  # noqa: F811
    goes_on(files, tmp_path, name, way, TIMES)


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
def test_a_damaged_scene_is_a_scene_or_one_clear_line(tmp_path, mutate):
    example = re.search(r"```toml\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.S)
    assert example
    whole = example[1].encode()
    survivors = outlive(tmp_path / "scene.toml", whole, mutate, TIMES, "scene", load_scene, SceneFileError)
    assert all(isinstance(scene, lb.Scene) for scene in survivors) and survivors


@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
def test_a_damaged_glass_catalogue_is_glasses_or_one_clear_line(tmp_path, mutate):
    assert outlive(tmp_path / "glass.agf", BK7.encode(), mutate, TIMES, "glass", agf.read, lenses.LensFileError)


def _can_be_used(scene, folder):
    """What was read can be checked, and written in every format."""
    for lens in scene[::max(1, len(scene) // 20)]:
        lenses.check(lens)
        for suffix in WRITERS:
            lenses.save(lens, folder / f"again{suffix}")
            again = lenses.load(folder / f"again{suffix}")
            assert suffix != ".toml" or again == lens
