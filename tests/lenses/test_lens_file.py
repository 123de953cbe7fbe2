"""Finding, opening and saving lens files: an error is one clear line, and no file is half written."""

import os

import pytest

from lensbench import Glass, Lens, Surface, lenses

NAME = "pbrt-dgauss-50mm"


def refusal(name_or_path):
    with pytest.raises(lenses.LensFileError) as caught:
        lenses.load(name_or_path)
    assert isinstance(caught.value, ValueError) and "\n" not in str(caught.value)
    return caught.value


@pytest.mark.parametrize("typed, offered", [("pbrt-dgaus-50mm", NAME), ("pbrt_dgauss_50mm", NAME), ("tessar", "tessar"),
                                            ("PLANAR", "planar"), ("sonar", "sonnar"), ("fisheye", "fisheye")])
def test_an_unknown_name_is_answered_with_the_nearest(typed, offered):
    assert offered in refusal(typed).reason


def test_an_unknown_name_is_refused_with_the_command_that_lists_the_names():
    for typed in ("qqqqqqqq", "", "x" * 5000, "a\0b", "?"):
        assert "lensbench lenses" in refusal(typed).reason


def test_a_library_name_is_no_path_but_what_looks_like_a_path_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / NAME).mkdir()
    assert lenses.load(NAME).name == "Double Gauss 50 mm f/2"
    assert "folder" in refusal(f"./{NAME}").reason
    lenses.save(lenses.load("lv-czj-tessar-50-f28"), "mine.toml")
    assert lenses.load("mine.toml") == lenses.load("./mine.toml") == lenses.load(tmp_path / "mine.toml")


def test_files_that_hold_no_lens_are_refused_each_with_its_reason(tmp_path):
    cases = {
        "missing.toml": (None, "no such file"),
        "empty.toml": (b"", "empty"),
        "blank.dat": (b" \n\n ", "empty"),
        "binary.toml": (bytes(range(256)), "binary"),
        "zeros.dat": (b"\0" * 100, "binary"),
        "latin.toml": ('title = "Müller"\n'.encode("latin-1"), "UTF-8"),
        "wide.dat": ("1 2 1.5 4\n".encode("utf-16"), "UTF-8"),
        "huge.toml": (b"#" * 2_000_000, "2.0 MB"),
        "lens.abc": (b"VERS 1", ".toml, .dat"),
        "no-suffix": (b"1", ".toml, .dat"),
    }
    for name, (content, reason) in cases.items():
        if content is not None:
            (tmp_path / name).write_bytes(content)
        assert reason in refusal(tmp_path / name).reason, name
    assert "folder" in refusal(tmp_path).reason
    assert "cannot be read" in refusal(tmp_path / ("long" * 200 + ".toml")).reason
    assert "no such file" in refusal(str(tmp_path / "nul\0.toml")).reason


def test_a_wrong_byte_is_named_with_its_line(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"format = 1\n# \xff\n")
    assert refusal(tmp_path / "a.toml").line == 2


def test_a_device_file_is_refused():
    assert "ordinary file" in refusal(os.devnull).reason


def test_line_ends_and_marks_of_other_systems_do_not_matter(tmp_path):
    for suffix in (".toml", ".dat"):
        lenses.save(lenses.load(NAME), tmp_path / f"a{suffix}")
        content = (tmp_path / f"a{suffix}").read_bytes()
        (tmp_path / f"b{suffix}").write_bytes(b"\xef\xbb\xbf" + content.replace(b"\n", b"\r\n"))
        assert lenses.load(tmp_path / f"a{suffix}") == lenses.load(tmp_path / f"b{suffix}")


def test_a_suffix_counts_in_any_case(tmp_path):
    lenses.save(lenses.load(NAME), tmp_path / "A.TOML")
    assert lenses.load(tmp_path / "A.TOML") == lenses.load(NAME)


def test_saving_to_an_invalid_place_is_refused_in_one_line(tmp_path):
    lens = lenses.load(NAME)
    for path, reason in ((tmp_path / "lens.abc", ".toml, .dat"), (tmp_path / "no" / "lens.toml", "there is no folder"),
                         (tmp_path / "nul\0.toml", "null")):
        with pytest.raises(lenses.LensFileError) as caught:
            lenses.save(lens, path)
        assert reason in caught.value.reason and "\n" not in str(caught.value)


def test_a_failed_save_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "lens.toml"
    lenses.save(lenses.load(NAME), path)
    before = path.read_bytes()

    def full_disk(_):
        raise OSError(28, "No space left on device")
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(lenses.LensFileError, match="No space left"):
        lenses.save(lenses.load("lv-czj-tessar-50-f28"), path)
    assert path.read_bytes() == before and os.listdir(tmp_path) == ["lens.toml"]


def test_a_saved_file_stands_alone(tmp_path):
    lenses.save(lenses.load(NAME), tmp_path / "lens.toml")
    assert os.listdir(tmp_path) == ["lens.toml"]


@pytest.mark.parametrize("suffix", [".toml", ".zmx", ".json"])
@pytest.mark.parametrize(("surfaces", "told"), [
    ((Surface(2e9, 9.0, curvature=0.02), Surface(1.0, 9.0, curvature=0.0)), "gaps of more than"),
    ((Surface(1.0, 1e-9, curvature=1e7), Surface(1.0, 9.0, curvature=0.0)), "radius is"),
    ((Surface(1.2345678901234567, 9.123456789012345, Glass(1.5, 60.0, "X" * 190),
              curvature=0.0123456789012345),) * 5000,
     "would not open again")])
def test_a_lens_that_would_not_open_again_is_not_saved(tmp_path, suffix, surfaces, told):
    path = tmp_path / f"a{suffix}"
    with pytest.raises(lenses.LensFileError) as caught:
        lenses.save(Lens(surfaces, 0), path)
    assert told in str(caught.value) and not list(tmp_path.iterdir())
