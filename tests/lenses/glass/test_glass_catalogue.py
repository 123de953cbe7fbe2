"""The glass catalogues against the published data of the makers, and the search for a glass."""

import csv
import os
import subprocess
import sys

import pytest

from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE, Glass, GlassError
from lensbench.lenses.file_error import LensFileError, RowError
from lensbench.lenses.glass import agf, catalogue as glass_catalogue, media

# Indices on the makers' data sheets, printed to five digits: n_d, n_F, n_C
PUBLISHED = {
    "SCHOTT N-BK7": (1.51680, 1.52238, 1.51432), "SCHOTT SF6": (1.80518, 1.82775, 1.79609),
    "SCHOTT N-SF11": (1.78472, 1.80651, 1.77596), "SCHOTT F2": (1.62004, 1.63208, 1.61503),
    "SCHOTT N-SK16": (1.62041, 1.62756, 1.61727), "OHARA S-FPL53": (1.43875, 1.44195, 1.43733),
    "OHARA S-TIH6": (1.80518, 1.82777, 1.79610), "HIKARI J-BK7A": (1.51680, 1.522382, 1.514324),
    "HIKARI J-LASFH24": (1.90200, 1.927478, 1.891774)}


@pytest.fixture(autouse=True)
def no_files_of_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))


@pytest.mark.parametrize("name", PUBLISHED)
def test_glasses_have_the_indices_of_their_data_sheets(name):
    glass = glass_catalogue.find(name)
    for wavelength, n in zip((D_LINE, F_LINE, C_LINE), PUBLISHED[name], strict=True):
        assert glass.index(wavelength) == pytest.approx(n, abs=1.6e-5)      # five digits, and a maker's own rounding


def test_every_glass_has_the_published_index_and_abbe_number():
    # Printed to four or five digits; MC-FAD61's published coefficients give another index than its table
    with glass_catalogue.FILE.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 1950 and len(rows) == len(glass_catalogue.shipped())
    for row, entry in zip(rows, glass_catalogue.shipped(), strict=True):
        glass = entry.make()
        assert glass.name == row["name"] and glass.index(sum(glass.wavelengths) / 2.0) > 1.0
        if row["n_d"] and row["name"] != "MC-FAD61":
            assert glass.index() == pytest.approx(float(row["n_d"]), abs=6e-5), row["name"]
            assert (glass.n_d - 1.0) / (glass.index(F_LINE) - glass.index(C_LINE)) == pytest.approx(
                float(row["v_d"]), rel=5e-3), row["name"]


def test_the_model_errs_by_what_its_description_says():
    wavelengths = [0.4 + 0.01 * i for i in range(31)]
    squares, worst = [], []
    for entry in glass_catalogue.shipped():
        glass = entry.make()
        if entry.maker != "MISC" and entry.n_d and glass.wavelengths[0] <= 0.4001 and glass.wavelengths[1] >= 0.7:
            model = Glass(glass.n_d, glass.v_d)
            errors = [model.index(w) - glass.index(max(w, glass.wavelengths[0])) for w in wavelengths]
            squares += [e * e for e in errors]
            worst.append(max(map(abs, errors)))
    worst.sort()
    assert (sum(squares) / len(squares)) ** 0.5 < 8.7e-5
    assert worst[-1] < 2.4e-3 and worst[int(0.95 * len(worst))] < 6e-4 and worst[len(worst) // 2] < 1.7e-4


@pytest.mark.parametrize("text", ["N-BK7", "nbk7", " n-bk7 ", "N BK7", "NBK7_SCHOTT", "Schott N-BK7", "SCHOTT:N-BK7"])
def test_a_name_is_found_however_it_is_spelled(text):
    assert glass_catalogue.find(text).name == "N-BK7"
    assert glass_catalogue.resolve(text) == (glass_catalogue.find("N-BK7"), "SCHOTT", "")


def test_the_maker_decides_where_several_use_a_name():
    assert glass_catalogue.resolve("LAF2", "SCHOTT").maker == "SCHOTT"
    assert glass_catalogue.resolve("LAF2", "Hoya") == (glass_catalogue.find("LAF2_HOYA"), "HOYA", "")
    assert glass_catalogue.find("LAF2", "SCHOTT") != glass_catalogue.find("LAF2", "HOYA")
    assert "SCHOTT" in glass_catalogue.resolve("LAF2").note
    assert glass_catalogue.resolve("N-BK7", "OHARA").note == "OHARA makes no N-BK7: that of SCHOTT is used"


def test_an_unknown_glass_is_an_error_that_names_the_nearest():
    with pytest.raises(glass_catalogue.UnknownGlass, match=r"'N-BK77' is in no catalogue: did you mean SCHOTT N-BK7 "):
        glass_catalogue.find("N-BK77")
    for text in ("", "_", "_SCHOTT", "847238", "no such glass" * 50):
        with pytest.raises(glass_catalogue.UnknownGlass, match="in no catalogue"):
            glass_catalogue.find(text)


@pytest.mark.parametrize("code, name", [("517642", "N-BK7"), ("517.642", "N-BK7"), ("517:642", "N-BK7"),
                                        ("847238", "N-SF57"), ("003283", "S-LAH79"), ("517642.251", "N-BK7")])
def test_a_six_digit_code_is_a_glass_and_says_which(code, name):
    glass, maker, note = glass_catalogue.resolve(code)
    assert glass.name == name and glass == glass_catalogue.from_code(code)
    assert note.startswith(f"code {code} is read as {maker} {name} (n_d {glass.n_d:.5f}")


def test_a_code_that_no_glass_has_is_the_nearest_glass():
    assert glass_catalogue.from_code("518644") == glass_catalogue.nearest(1.518, 64.4)
    for text in ("N-BK7", "51764", "517000", "5176422"):
        with pytest.raises(GlassError, match="no glass code"):
            glass_catalogue.from_code(text)


def test_the_name_of_an_older_kind_finds_the_newer_glass_with_a_note():
    glass, maker, note = glass_catalogue.resolve("LAK33A")
    assert (glass.name, maker) == ("N-LAK33A", "SCHOTT")
    assert note.startswith("LAK33A is in no catalogue: SCHOTT N-LAK33A")
    with pytest.raises(glass_catalogue.UnknownGlass):
        glass_catalogue.find("LAK33A")


def test_every_glass_is_the_nearest_to_its_own_numbers():
    for entry in glass_catalogue.shipped()[::37]:
        if entry.n_d:
            near = glass_catalogue.nearest(entry.n_d, entry.v_d, entry.maker)
            assert abs(near.n_d - entry.n_d) < 5e-4 and abs(near.v_d / entry.v_d - 1.0) < 5e-3


def test_the_catalogue_is_read_only_when_a_glass_is_asked_for():
    code = ("import lensbench.lenses.glass.catalogue as g; assert g.shipped.cache_info().currsize == 0; "
            "g.find('N-BK7'); assert g.shipped.cache_info().currsize == 1")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_fused_silica_and_caf2_have_their_measured_indices_from_the_ultraviolet_on():
    # I. H. Malitson, J. Opt. Soc. Am. 55, 1205 (1965) and Appl. Opt. 2, 1103 (1963): printed to five digits
    silica, fluorite = glass_catalogue.find("F_SILICA"), glass_catalogue.find("CaF2")
    for wavelength, n in ((0.213856, 1.53430), (0.248272, 1.50840), (0.404656, 1.46961), (1.01398, 1.45024)):
        assert silica.index(wavelength) == pytest.approx(n, abs=3e-5)
    assert fluorite.index(0.248272) == pytest.approx(1.46793, abs=3e-5)
    with pytest.raises(GlassError, match="is known from 0.21 to 3.71 µm"):
        silica.index(0.193)


def test_a_formula_glass_that_no_maker_lists_is_found_under_the_names_of_design_programs():
    for name in ("SILICA", "fused_silica", "SiO2"):
        glass, assumed = media.named(name)
        assert assumed == "" and glass.index(0.35) == glass_catalogue.find("F_SILICA").index(0.35)
    assert media.named("BaF2")[0].name == "BAF2"
    assert media.named("BaF2", "CDGM")[0].index(D_LINE) == pytest.approx(1.5697, abs=5e-5)
    assert glass_catalogue.resolve("CaF2", "Daimon-20").note == (
        "no CAF2 of DAIMON-20 is known: that of the catalogue MISC is used")
    assert media.named("BaF2", "Malitson")[0].index(D_LINE) == pytest.approx(1.47448, abs=1e-5)


@pytest.mark.parametrize(("number", "coefficients", "name"), [
    (1, [0.0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161], "F_SILICA"),
    (3, [2.1864582, -2.4475348e-4, 2.0, 1.4155787e-2, -2.0, -4.4329781e-4, -4.0, 7.7664259e-5, -6.0, -2.9936382e-6,
         -8.0], "PMMA"),
    (2, [0.0, 1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653], "N-BK7"),
])
def test_formulas_of_refractiveindex_info_give_the_index_of_the_catalogue(number, coefficients, name):
    glass, known = media.from_database("m", number, coefficients, (0.37, 1.0)), glass_catalogue.find(name)
    assert glass.wavelengths == (0.37, 1.0)
    for wavelength in (0.38, 0.5, 0.9):
        assert glass.index(wavelength) == pytest.approx(known.index(wavelength), abs=1e-9)


def test_other_formulas_of_refractiveindex_info_are_refused_and_gases_are_air():
    assert media.from_database("CO2", 6, [0.0, 0.00000154489, 0.0584738, 0.083091927, 210.9241], (0.4, 1.8)).n_d == 1.0
    for number, coefficients in ((4, [1.0] * 9), (3, [2.0, 0.1, 5.0]), (1, [0.0, 1.0]), (2, [])):
        with pytest.raises(RowError, match="the material m"):
            media.from_database("m", number, coefficients, (0.4, 0.7))


# AGF files

BK7 = """CC A catalogue of our own
NM OUR-BK7 2 517642 1.516800 64.17 0 0
GC said to be dear
ED 7.1 8.3 2.51 -0.0009 0
CD 1.03961212E+00 6.00069867E-03 2.31792344E-01 2.00179144E-02 1.01046945E+00 1.03560653E+02 0 0 0 0
LD 0.3 2.5
NM OUR-SERIES 1 0 1.523080 58.57 0
CD 2.286575 -8.7334582e-3 1.174288400E-002 2.904175600E-004 -1.250669500E-005 9.264625300E-007
LD 0.334 2.5
"""


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "lensbench" / "glass"
    folder.mkdir(parents=True)
    return folder


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_an_agf_file_is_read_in_any_of_its_encodings(tmp_path, encoding):
    path = tmp_path / "ours.agf"
    path.write_bytes(BK7.replace("dear", "teuer für uns").replace("\n", "\r\n").encode(encoding))
    catalogue = agf.read(path)
    assert (catalogue.maker, catalogue.findings) == ("OURS", ())
    ours, series = catalogue.glasses
    schott = glass_catalogue.find("N-BK7")
    assert ours.index(0.45) == schott.index(0.45) and ours.wavelengths == (0.3, 2.5)
    assert series.index() == pytest.approx(1.52308, abs=5e-6) and series.v_d == pytest.approx(58.57, abs=5e-3)


SERIES = """NM WRAPPED-BK7 13 517641 1.516800 64.14 0
CD 2.27110883E+00 -9.38988354E-03 -1.00277081E-04
   1.09572221E-02
 1.20210067E-04 3.31079774E-06 -1.48235581E-08 0 0
LD 0.365015
2.05809
"""


def test_a_record_wrapped_over_lines_is_read_to_its_end(tmp_path):
    path = tmp_path / "wrapped.agf"
    path.write_text(SERIES)
    glass, = agf.read(path).glasses
    assert len(glass.coefficients) == 9 and glass.coefficients[3:7] == (
        1.09572221e-2, 1.20210067e-4, 3.31079774e-6, -1.48235581e-8)
    assert glass.index(F_LINE) == pytest.approx(1.522382, abs=1e-6)      # Hikari's J-BK7A, as printed
    assert glass.wavelengths == (0.365015, 2.05809)
    path.write_text(" ".join(SERIES.split("\n")).replace(" CD", "\nCD").replace(" LD", "\nLD"))
    assert agf.read(path).glasses == (glass,)


@pytest.mark.parametrize("n_d, v_d, doubt", [
    ("1.516800", "64.17", None), ("1.51681", "64.16", None),            # rounded otherwise
    ("1.516850", "64.17", "n_d 1.516800, its NM record states 1.516850"),
    ("1.516800", "64.71", "V_d 64.17, its NM record states 64.71"),
])
def test_a_formula_that_contradicts_its_nm_record_is_reported_with_both_figures(folder, n_d, v_d, doubt):
    path = folder / "ours.agf"
    path.write_text(BK7.replace("1.516800 64.17", f"{n_d} {v_d}"))
    doubts = agf.read(path).doubts
    note = glass_catalogue.resolve("OUR-BK7").note
    assert media.named("OUR-BK7") == (glass_catalogue.find("OUR-BK7"), note)        # a finding of the lens
    if doubt is None:
        assert not doubts and not note
    else:
        assert doubts == {"OUR-BK7": note} and doubt in note and note.startswith("ours.agf:2: ")


def test_glasses_of_the_users_folder_are_found_and_go_first(folder):
    (folder / "ours.AGF").write_text(BK7.replace("OUR-SERIES", "N-BK7"), encoding="utf-8")
    assert glass_catalogue.find("our-bk7").name == "OUR-BK7"
    assert glass_catalogue.resolve("N-BK7")[1:] == ("OURS", "")
    assert glass_catalogue.resolve("N-BK7_SCHOTT").maker == "SCHOTT"
    (folder / "ours.AGF").write_text(BK7, encoding="utf-8")
    os.utime(folder / "ours.AGF", ns=(1, 1))
    assert glass_catalogue.resolve("N-BK7").maker == "SCHOTT"           # a file that changes is read again


def test_glasses_of_the_user_that_cannot_be_read_are_said_where_glasses_are_chosen(folder, monkeypatch):
    assert glass_catalogue.unread_text() == ""
    (folder / "bad.agf").write_bytes(b"")
    assert glass_catalogue.unread_text() == f"{folder / 'bad.agf'}: holds no glass (no NM line)"
    (folder / "worse.agf").write_bytes(b"")
    assert glass_catalogue.unread_text().endswith("(no NM line), and 1 more")

    def closed(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(folder), "iterdir", closed)
    assert glass_catalogue.unread_text() == f"{folder} cannot be read: Permission denied"
    assert glass_catalogue.find("N-BK7").name == "N-BK7"
    with pytest.raises(glass_catalogue.UnknownGlass, match="Permission denied"):
        glass_catalogue.find("OUR-BK7")


def test_invalid_glasses_of_an_agf_file_are_left_out_and_reported(tmp_path):
    path = tmp_path / "odd.agf"
    path.write_text(BK7 + "NM BARE 2 0 1.5 60\nNM NONSENSE 77 0 1.5 60\nCD 1 2\nNM SHORT\nNM WORD 2 0 1.5 60\nCD x y\n"
                    "NM OFF 2 0 1.7 64\nCD 1.03961212 6.00069867E-03 0.231792344 0.0200179144 1.01046945 103.560653\n"
                    "LD 2.5 0.3\nNM OUR-BK7 2 0 1.5 60\nCD 1 0.01\n", encoding="utf-8")
    catalogue = agf.read(path)
    assert [glass.name for glass in catalogue.glasses] == ["OUR-BK7", "OUR-SERIES"]
    lines = [finding.split(": ")[0] for finding in catalogue.findings]
    assert lines == [f"odd.agf:{n}" for n in (10, 11, 13, 14, 16, 19)]


@pytest.mark.parametrize("content, reason", [(b"", "no NM line"), (b"\x00\xff\xfe" * 99, "a binary file"),
                                             (b"NM A 2 0 1.5 60\n", "no coefficients")])
def test_a_file_that_holds_no_glass_is_an_error_of_one_line(tmp_path, folder, content, reason):
    (folder / "bad.agf").write_bytes(content)
    with pytest.raises(LensFileError, match=reason):
        agf.read(folder / "bad.agf")
    with pytest.raises(LensFileError, match="cannot be read"):
        agf.read(tmp_path / "none.agf")
    with pytest.raises(glass_catalogue.UnknownGlass, match=r"bad\.agf"):
        glass_catalogue.find("A")


def quan_and_fry(wavelength, salt):
    """Index in air of water of 20 °C with salt (g/kg) at 0.40 to 0.70 µm, Appl. Opt. 34, 3477 (1995)."""
    t, w = 20.0, 1000.0 * wavelength
    return (1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * salt - 2.02e-6 * t * t
            + (15.868 + 0.01155 * salt - 0.00423 * t) / w - 4382.0 / w**2 + 1.1455e6 / w**3)


@pytest.mark.parametrize(("name", "salt"), [("WATER", 0.0), ("seawater", 35.0)])
def test_water_has_the_dispersion_that_others_measured(name, salt):
    water, note = media.named(name)
    assert "Daimon" in note and ("35 g/kg" in note) == bool(salt)
    for wavelength in (0.4047, 0.4358, F_LINE, 0.5461, D_LINE, 0.6328, C_LINE, 0.69):
        assert water.index(wavelength) == pytest.approx(quan_and_fry(wavelength, salt), abs=3e-5)
    # As design programs have them
    assert (water.n_d, water.v_d) == pytest.approx((1.339462, 54.90) if salt else (1.333041, 55.77), abs=0.1)
    assert water.n_d == pytest.approx(1.339462 if salt else 1.333041, abs=2e-5)
    assert 1.327 < water.index(0.8) - 6.2e-3 * bool(salt) < 1.330
    with pytest.raises(GlassError, match="0.2 to 1.12"):
        water.index(1.2)


def test_hikaris_former_names_lead_to_hikaris_glasses():
    resolved = glass_catalogue.resolve("E-LLF6")
    assert (resolved.maker, resolved.glass.name) == ("HIKARI", "J-LLF6") and "its current name" in resolved.note


def test_a_name_in_several_catalogues_says_which_was_taken():
    glass, note = media.named("F2")
    assert glass == glass_catalogue.find("F2", "SCHOTT") and note == (
        "F2 is made by SCHOTT and CDGM and SUMITA: that of SCHOTT is used")
    assert media.named("F2", "SUMITA") == (glass_catalogue.find("F2", "SUMITA"), "")
