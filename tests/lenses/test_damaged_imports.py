"""Files of other programs after mishaps: a lens or one clear line; what was read can be written in every format."""

import random

import pytest

from lensbench import Lens, lenses
from tests.lenses.samples import DATA
from tests.lenses.test_damaged_files import damaged

WORDS = [b"INFINITY", b"1e400", b"-1e300", b"1e-310", b"1,5", b"1D5", b"S3", b"99999999999", b"REFL", b"MIRROR",
         b"'", b'"', b"&", b";", b"ZOO", b"PRV", b"END", b"NXT", b"SURF 1", b"PARM 1 5", b"GLAS X 2 5 0 0", b"GLA",
         b"ASP ARA 3", b"XDAT 1 400", b"AsphericalOddCount\t-3", b"MNUM 1e9", b"null", b"true", b"[]", b"{}", b"NaN",
         b"-Infinity"]
SAMPLES = sorted(path.name for path in DATA.iterdir())


def mishap(content, rng):
    """The bytes after one to four mishaps, those of words in these formats among them."""
    if rng.random() < 0.4:
        lines = content.split(b"\n")
        j = rng.randrange(len(lines))
        words = lines[j].split(b" ")
        words[rng.randrange(len(words))] = rng.choice(WORDS)
        lines[j] = b" ".join(words)
        content = b"\n".join(lines)
    return damaged(content, rng)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, name):
    rng = random.Random(name)
    path = tmp_path / name
    whole = (DATA / name).read_bytes()
    assert isinstance(lenses.load(DATA / name), Lens)
    read = 0
    for turn in range(300):
        content = mishap(whole, rng)
        path.write_bytes(content.decode("latin-1").encode("utf-16") if turn % 10 == 0 else content)
        try:
            lens = lenses.load(path)
        except lenses.LensFileError as error:
            assert "\n" not in str(error) and len(error.reason) < 400
            continue
        read += 1
        assert isinstance(lens, Lens)
        if turn % 5 == 0:
            lenses.save(lens, tmp_path / "again.toml")
            assert lenses.load(tmp_path / "again.toml") == lens
            for suffix in (".zmx", ".seq", ".txt", ".len", ".dat", ".json", ".roa"):
                lenses.save(lens, tmp_path / f"again{suffix}")
                written = lenses.load(tmp_path / f"again{suffix}")
                assert len(written.surfaces) - len(lens.surfaces) in (0, 1)     # .dat sets its stop apart
    assert read > (2 if name.endswith((".json", ".roa")) else 20)       # a bracket lost is the whole of a JSON file


# What would keep a careless reader busy for minutes; the loaders of all of these need milliseconds
ENDLESS = {
    "digits.seq": b"S " + b"9" * 900_000 + b"x 1",
    "digits.zmx": b"SURF 0\nSURF 1\n  CURV " + b"9" * 900_000 + b"x\nSURF 2\n",
    "quotes.len": b'LEN NEW ' + b'\\"' * 400_000,
    "quotes.seq": b"'\"" * 400_000,
    "stops.seq": b"S;STO\n" * 150_000,
    "surfaces.zmx": b"SURF 1\n SQAP 1\n" * 60_000,
    "surfaces.len": b"LEN NEW\n" + b"NXT\n" * 240_000,
    "items.json": b'{"surface_group": {"surfaces": [' + b"1," * 400_000 + b"1]}}",
    "items.roa": b'{"optical_model": {"seq_model": {"ifcs": [' + b"{}," * 300_000 + b"{}]}}}",
    "tabs.txt": b"[lens data]\n" + b"\t" * 900_000,
}


@pytest.mark.parametrize("name", ENDLESS)
def test_no_file_keeps_a_reader_busy(tmp_path, name):
    (tmp_path / name).write_bytes(ENDLESS[name])
    with pytest.raises(lenses.LensFileError) as caught:
        lenses.load(tmp_path / name)
    assert "\n" not in str(caught.value)
