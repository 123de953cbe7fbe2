"""Whatever happens to a lens file: it reads as a lens, or LensFileError says why not in one line."""

import random

import pytest

from lensbench import Lens, lenses

JUNK = [b"nan", b"-inf", b"1e999", b"1e-400", b"-1", b"0", b'"', b"'''", b"[", b"]" * 3, b"{", b"#", b"\xff", b"\0",
        b"=", b"[" * 3000, b"9" * 5000, b"stop", b'"stop"', b"\r", b"\n", b"axpos", b"(m)", b"true", b"1979-05-27",
        b"1_0", b"0x1f", "−٣".encode()]


def damaged(content, rng):
    """The bytes after one to four mishaps: cut, changed, repeated, swapped or sprinkled."""
    for _ in range(rng.randint(1, 4)):
        lines = content.split(b"\n")
        i, j = rng.randrange(len(content) + 1), rng.randrange(len(lines))
        kind = rng.randrange(7)
        if kind == 0:
            content = content[:i]
        elif kind == 1:
            content = content[:i] + rng.choice(JUNK) + content[i:]
        elif kind == 2:
            content = content[:i] + bytes([rng.randrange(256)]) + content[i + 1:]
        elif kind == 3:
            words = lines[j].split(b" ")
            words[rng.randrange(len(words))] = rng.choice(JUNK)
            content = b"\n".join([*lines[:j], b" ".join(words), *lines[j + 1:]])
        elif kind == 4:
            content = b"\n".join([*lines[:j], *lines[j + 1:]])
        elif kind == 5:
            content = b"\n".join([*lines[:j], lines[rng.randrange(len(lines))], *lines[j:]])
        else:
            content = content[:i] + content[i + rng.randint(1, 20):]
    return content


@pytest.mark.parametrize("suffix", [".toml", ".dat"])
@pytest.mark.parametrize("name", lenses.names())
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, name, suffix):
    rng = random.Random(f"{name}{suffix}")
    path = tmp_path / f"lens{suffix}"
    lenses.save(lenses.load(name), path)
    whole = path.read_bytes()
    for _ in range(12):
        path.write_bytes(damaged(whole, rng))
        try:
            lens = lenses.load(path)
        except lenses.LensFileError as error:
            assert "\n" not in str(error) and len(error.reason) < 400
        else:
            assert isinstance(lens, Lens)
            lenses.save(lens, tmp_path / "again.toml")
            assert lenses.load(tmp_path / "again.toml") == lens
