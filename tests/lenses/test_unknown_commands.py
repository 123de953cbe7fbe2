"""What a reader does not understand refuses the file by name; what is listed as harmless changes nothing.

docs/lens-files.md lists the harmless commands; a test compares the page with the readers.
"""

import json
import re
from pathlib import Path

import pytest

from lensbench import lenses
from lensbench.lenses import WRITERS
from lensbench.lenses.formats import (
    codev_surfaces, deeplens, flaresim, lens_explorer, lenshh, optiland, oslo, rayoptics, zemax
)
from tests.lenses.samples import DATA, loaded, refusal

PAGE = Path(__file__).parents[2] / "docs" / "lens-files.md"
TEXT = {                    # sample, a line behind which a command may stand, how it is written
    "oslo": ("pair.len", "TH   4.0", "{} 1"), "oslo, behind": ("pair.len", "END  6", "{} 1"),
    "zemax": ("doublet.zmx", "SURF 2", "  {} 1"), "zemax, header": ("doublet.zmx", "UNIT MM X W X CM MR CPMM", "{} 1"),
    "codev": ("triplet.seq", "  CIR 8.5", "  {} 1"), "codev, system": ("triplet.seq", "DIM   M", "{} 1"),
    "flaresim": ("triplet.lens", "focal_length: 50.0", "{}: 1"), "lensoptics": ("zoom.fx", "#!scale 0.5", "#!{} 1"),
    "optical bench": ("zoom.txt", "AsphericalOddCount\t1", "{}\t1")}
HARMLESS = {"oslo": oslo.HARMLESS, "oslo, behind": oslo.BEHIND, "zemax": zemax.HARMLESS,
            "zemax, header": zemax.HARMLESS_HEADER, "codev": codev_surfaces.HARMLESS,
            "codev, system": codev_surfaces.HARMLESS, "flaresim": flaresim.HARMLESS}
# Sample, the way to an object, the harmless entries
OBJECTS = [
    ("phone.json", (), deeplens.HARMLESS), ("phone.json", ("surfaces", 1), deeplens.HARMLESS_OF_SURFACES),
    ("zoom.lhlt", (), lenshh.HARMLESS), ("zoom.lhlt", ("Surfaces", 1), lenshh.HARMLESS_OF_SURFACES),
    *(("zoom.lhlt", way, ()) for way in (("Aperture",), ("Fields", 0), ("Wavelengths", 0))),
    ("zoom.json", ("variable",), {"pair_order"}), ("zoom.json", (), lens_explorer.HARMLESS),
    ("zoom.json", ("surfaces", 1), lens_explorer.HARMLESS_OF_SURFACES)]
OPTILAND = {"": (), "surface": ("surface_group", "surfaces", 1), "aperture": ("aperture",), "fields": ("fields",),
            "geometry": ("surface_group", "surfaces", 1, "geometry"), "field": ("fields", "fields", 0),
            "cs": ("surface_group", "surfaces", 1, "geometry", "cs"), "wavelengths": ("wavelengths",),
            "interaction_model": ("surface_group", "surfaces", 1, "interaction_model"),
            "material": ("surface_group", "surfaces", 1, "material_post"),
            "wavelength": ("wavelengths", "wavelengths", 0)}
MODEL = ("optical_model", "attributes")
SPEC = (*MODEL, "optical_spec", "attributes")
RAYOPTICS = {
    "optical_model": MODEL, "system_spec": (*MODEL, "system_spec", "attributes"), "optical_spec": SPEC,
    "seq_model": (*MODEL, "seq_model", "attributes"),
    "surface": (*MODEL, "seq_model", "attributes", "ifcs", 1, "attributes"),
    "gap": (*MODEL, "seq_model", "attributes", "gaps", 1, "attributes"),
    "profile": (*MODEL, "profile_dict", "1", "attributes"),
    "spectral_region": (*SPEC, "spectral_region", "attributes"), "pupil": (*SPEC, "pupil", "attributes"),
    "field_of_view": (*SPEC, "field_of_view", "attributes"),
    "field": (*SPEC, "field_of_view", "attributes", "fields", 0, "attributes")}


def with_command(section, command):
    """A sample with a command behind a line."""
    sample, line, written = TEXT[section]
    text = (DATA / sample).read_text()
    assert f"\n{line}\n" in text
    return sample, text.replace(f"\n{line}\n", f"\n{line}\n{written.format(command)}\n", 1)


@pytest.mark.parametrize("section", TEXT)
def test_an_unknown_command_refuses_the_file_by_name(tmp_path, section):
    sample, text = with_command(section, "QWXZ")
    error = refusal(tmp_path, sample, text)
    assert "QWXZ" in error.reason and "is not understood, and may change the lens" in error.reason
    assert text.split("\n")[error.line - 1].split()[0].lstrip("#!").startswith("QWXZ")


@pytest.mark.parametrize("section", HARMLESS)
def test_harmless_commands_change_nothing(tmp_path, section):
    for command in sorted(HARMLESS[section]):
        if command == "RDM":                        # it says that numbers are radii, as they are here
            continue
        sample, text = with_command(section, command)
        whole = lenses.load(DATA / sample)
        lens = loaded(tmp_path, sample, text)
        assert lens == whole and lens.findings == whole.findings, command


@pytest.mark.parametrize("command", ["  SQAP 1 1", "  OBDC 0 1", "  COAT AR"])
def test_what_a_zemax_file_states_of_apertures_and_coatings_is_said(tmp_path, command):
    text = (DATA / "doublet.zmx").read_text().replace("\nSURF 2\n", f"\nSURF 2\n{command}\n", 1)
    lens, whole = loaded(tmp_path, "a.zmx", text), lenses.load(DATA / "doublet.zmx")
    assert lens.surfaces == whole.surfaces and len(lens.findings) == len(whole.findings) + 1


def test_merit_functions_and_tolerances_of_a_zemax_file_are_passed_over(tmp_path):
    text = (DATA / "doublet.zmx").read_text()
    more = "EFFL 0 2 0 0 0 0 100 1 0 0\nTRAC 0 1 0 0 1.1E-1 0 0 1.2E-2 0 0\nBLNK Default\nTOL TIRR 1 2 0 0 1\n"
    whole = lenses.load(DATA / "doublet.zmx")
    assert loaded(tmp_path, "a.zmx", text.replace("\nBLNK\n", f"\n{more}", 1)) == whole
    assert "QWXZ" in refusal(tmp_path, "a.zmx", text.replace("\nBLNK\n", "\nQWXZ 1 2\n", 1)).reason


ENTRIES = [(name, way, tuple(sorted(keys))) for name, way, keys in (
    *OBJECTS, *(("cooke.json", way, optiland.READ[name][1]) for name, way in OPTILAND.items()),
    *(("cooke.roa", way, rayoptics.READ[name][1]) for name, way in RAYOPTICS.items()))]


@pytest.mark.parametrize(("name", "way", "harmless"), ENTRIES, ids=str)
def test_unknown_entries_of_json_refuse_the_file_and_harmless_ones_change_nothing(tmp_path, name, way, harmless):
    text = (DATA / name).read_text() if (DATA / name).exists() else WRITERS[Path(name).suffix](
        lenses.load("lenshh-cooke-triplet-50"))[0]
    whole = loaded(tmp_path, name, text)

    def changed(key, value):
        model = node = json.loads(text)
        for step in way:
            node = node[step]
        node.setdefault(key, value)
        return json.dumps(model)

    assert "qwxz" in refusal(tmp_path, name, changed("qwxz", 1.0)).reason
    assert loaded(tmp_path, name, changed("qwxz", None)) == whole               # an empty entry says nothing
    for key in harmless:
        lens = loaded(tmp_path, name, changed(key, "x"))
        assert lens == whole and lens.findings == whole.findings, key


def test_deeplens_with_a_diffractive_element_is_refused(tmp_path):
    model = json.loads((DATA / "phone.json").read_text()) | {"DOE": {"type": "DOE", "d": 3.0}}
    assert "a diffractive element (DOE) is not traced" in refusal(tmp_path, "a.json", json.dumps(model)).reason


@pytest.mark.parametrize(("key", "value", "kept"), [("pos_xy", [0, 0], True), ("pos_xy", [0, 1], False),
                                                    ("vec_local", [0, 0, 1], True), ("vec_local", [0, 0.1, 1], False)])
def test_a_surface_of_deeplens_off_its_place_is_refused(tmp_path, key, value, kept):
    model = json.loads((DATA / "phone.json").read_text())
    model["surfaces"][1][key] = value
    if kept:
        assert loaded(tmp_path, "a.json", json.dumps(model)) == lenses.load(DATA / "phone.json")
    else:
        assert key in refusal(tmp_path, "a.json", json.dumps(model)).reason


@pytest.mark.parametrize(("suffix", "old", "new"), [
    (".toml", 'units = "mm"', 'units = "mm"\nqwxz = 1'), (".dat", "# ", "QWXZ 1\n# ")])
def test_our_own_and_pbrts_files_are_strict(tmp_path, suffix, old, new):
    text, _ = WRITERS[suffix](lenses.load("pbrt-dgauss-50mm"))
    assert re.search("qwxz|one has 2 values", str(refusal(tmp_path, f"a{suffix}", text.replace(old, new, 1))))


def test_the_page_lists_every_harmless_command():
    section = PAGE.read_text(encoding="utf-8").partition("## What is passed over")[2].partition("\n## ")[0]
    named = set(re.findall(r"[\w.]+", section))
    lists = [*HARMLESS.values(), *(harmless for _, _, harmless in OBJECTS), oslo.BLOCKS,
             *(entry[1] for read in (optiland.READ, rayoptics.READ) for entry in read.values())]
    missing = sorted({word for words in lists for word in words} - named)
    assert not missing
