"""Values of another type in files of every format: a lens, or one clear line."""

import pytest

from lensbench import lenses
from lensbench.lenses import WRITERS
from tests.lenses.samples import DATA, changed_json, loaded, refusal
from tests.lenses.wrong_types import outlived, rng_of, sources, texts, toml_text

TIMES = 30          # of each sample; `make fuzz` goes through thousands


@pytest.mark.parametrize("name", sources())
def test_a_value_of_another_type_is_one_clear_line(tmp_path, name):
    read = [outlived(tmp_path / name, text) for text in texts(DATA / name, rng_of(name), TIMES)]
    assert 0 < sum(read) < TIMES            # some values are no mistake, such as another name


@pytest.mark.parametrize("suffix", [".toml", ".dat", ".json", ".roa", ".zmx", ".seq", ".len", ".txt"])
def test_a_value_of_another_type_in_a_file_of_our_own_is_one_clear_line(tmp_path, suffix):
    whole = tmp_path / f"whole{suffix}"
    lenses.save(lenses.load("lib-us10281683"), whole)
    for text in texts(whole, rng_of(suffix), TIMES):
        outlived(tmp_path / f"a{suffix}", text)


@pytest.mark.parametrize(("keys", "value", "told"), [
    (["aperture", "type"], {"a": 1}, "type is {'a': 1}: it must be a text"),
    (["aperture"], 5, "aperture is 5: it must be an object"),
    (["fields", "fields", 0, "y"], 10**400, "y is inf"), (["fields", "fields"], "all", "must be a list"),
    (["wavelengths", "wavelengths", 0, "unit"], "furlong", "furlong"),
    (["surface_group", "surfaces", 1, "is_stop"], "yes", "it must be true or false"),
    (["surface_group", "surfaces", 1, "geometry", "radius"], [1.0], "radius is [Decimal('1.0')]")])
def test_mistaken_types_name_their_entry(tmp_path, keys, value, told):
    import json

    text, _ = WRITERS[".json"](lenses.load("lenshh-cooke-triplet-50"))
    assert told in refusal(tmp_path, "a.json", changed_json(json.loads(text), keys, value)).reason


@pytest.mark.parametrize("name", ["triplet.seq", "doublet.zmx"])
def test_a_field_beyond_all_lengths_is_left_out_with_a_warning(tmp_path, name):
    old, new = {"triplet.seq": ("YAN   0.0 10.0 14.0", "YAN 0.0 1e308 14.0"),
                "doublet.zmx": ("YFLN 0 1.0 2.0", "YFLN 0 1e308 2.0")}[name]
    lens = loaded(tmp_path, name, (DATA / name).read_text().replace(old, new, 1))
    assert any("it must lie within" in str(finding) for finding in lens.findings)
    assert len(lens.system.fields) == 2 and lens.surfaces == lenses.load(DATA / name).surfaces


def test_values_are_written_as_toml():
    assert toml_text([True, "x", 1.5, []]) == '[true, "x", 1.5, []]' and toml_text(None) == "{}"
