"""Files of other programs after mishaps: a lens or one clear line; what was read can be written in every format.

The short form of `make fuzz`, which goes through 2,000 mishaps of each kind for every sample.
"""

import pytest

from lensbench import Lens, lenses
from lensbench.lenses.formats.table import WRITERS
from tests.lenses.damage import lenses_outlive
from tests.lenses.samples import DATA
from tests.mishaps import by_bytes, by_lines

SAMPLES = sorted(path.name for path in DATA.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("mutate", [by_bytes, by_lines], ids=lambda mutate: mutate.__name__)
@pytest.mark.parametrize("name", SAMPLES)
def test_a_damaged_file_is_a_lens_or_one_clear_line(tmp_path, name, mutate):
    assert isinstance(lenses.load(DATA / name), Lens)
    outcomes = lenses_outlive(tmp_path / name, (DATA / name).read_bytes(), mutate, 200, "short")
    # A bracket lost is the whole of a JSON file
    assert len(outcomes) > (2 if name.endswith((".json", ".roa", ".lhlt")) else 15)
    for lens in outcomes[::5]:
        for suffix in WRITERS:
            lenses.save(lens, tmp_path / f"again{suffix}")
            again = lenses.load(tmp_path / f"again{suffix}")
            assert len(again.surfaces) - len(lens.surfaces) in (0, 1)       # .dat sets its stop apart
            assert suffix != ".toml" or again == lens


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
    "exponent.json": b'{"version": 1e' + b"9" * 5000 + b"}",
    "exponent.seq": b"PRV; PWL 1e-" + b"9" * 3000 + b" 500; 'A' 1.5 1.6; END; S; S 0 0 'A'; S\n",
    "items.roa": b'{"optical_model": {"seq_model": {"ifcs": [' + b"{}," * 300_000 + b"{}]}}}",
    "tabs.txt": b"[lens data]\n" + b"\t" * 900_000,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ENDLESS)
def test_no_file_keeps_a_reader_busy(tmp_path, name):
    (tmp_path / name).write_bytes(ENDLESS[name])
    with pytest.raises(lenses.LensFileError) as caught:
        lenses.load(tmp_path / name)
    assert "\n" not in str(caught.value)
