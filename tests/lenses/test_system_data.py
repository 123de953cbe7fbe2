"""System data in lens files: read, sizing the stop, written and read back equal, and its losses named."""

import json
from dataclasses import replace
from math import asin, inf, sin, tan

import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import Glass, Lens, Positions, Surface, lenses
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.command.main import main
from lensbench.app.panels.readouts import Status, rows
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, Wavelength
from lensbench.lenses import READERS, WRITERS, Kind
from lensbench.lenses.tables.system_text import system_rows
from tests.lenses.samples import DATA, loaded, refusal

GLASS = Glass(1.5168, 64.17)
FULL = (".toml", ".zmx", ".seq", ".len", ".json", ".roa")

# A stop behind a biconvex lens, as each format has it; the object's distance and the aperture are in braces
NEAR = {".seq": """\
RDM; LEN; DIM M
WL 587.5618; REF 1
{aperture}; YAN 0.0
SO 0 {distance}
S 50 5 1.5168:64.17
S -50 20
S 0 60; STO; CIR 9
SI 0 0
""", ".zmx": """\
MODE SEQ
UNIT MM
{aperture}
FTYP 0 0 1 1 0 0 0
YFLN 0
WAVM 1 0.5875618 1
PWAV 1
SURF 0
  DISZ {distance}
SURF 1
  CURV 0.02
  DISZ 5
  GLAS ___BLANK 1 0 1.5168 64.17
  DIAM 12
SURF 2
  CURV -0.02
  DISZ 20
  DIAM 12
SURF 3
  STOP
  DISZ 60
  DIAM 9
SURF 4
""", ".len": """\
LEN NEW "pair" 50 4
{aperture}; UNI 1
AIR; TH {distance}; NXT
GLA MOD A 1.5168 64.17; RD 50; TH 5; AP 12; NXT
AIR; RD -50; TH 20; AP 12; NXT
AIR; TH 60; AP 9; AST; NXT
AIR; WV 0.5875618; WW 1
END 4
"""}


def oracle(distance):
    """Independent of the readers: a thick biconvex lens by its cardinal points, then the stop 20 mm behind it.

    Returns the ratio of the stop's radius to that of the entrance pupil, the place of the pupil from the first vertex,
    and the working slope behind the lens for a slope of 1 at the object.
    """
    n, radius, thickness = 1.5168, 50.0, 5.0
    power = 2.0 * (n - 1.0) / radius - (n - 1.0) ** 2 * thickness / (n * radius**2)
    f = 1.0 / power
    principal = f * (n - 1.0) * thickness / (n * radius)        # depth of both principal planes within the lens
    stop = 20.0 + principal                                     # from the rear principal plane
    pupil = stop * f / (f - stop)                               # its image in front, behind the front principal plane
    ratio = stop / pupil                                        # of the heights of stop and pupil
    reach = distance + principal                                # the object before the front principal plane
    return ratio, principal + pupil, reach / f - 1.0


@pytest.mark.parametrize("suffix", NEAR)
@pytest.mark.parametrize("distance", [20.0, 60.0, 200.0, 1500.0, 1e20])
def test_the_stated_entrance_pupil_is_read_back_at_every_object_distance(tmp_path, suffix, distance):
    ratio, pupil, _ = oracle(distance)
    beam = 5.0 * distance / (distance + pupil)          # OSLO: the height of the axial ray on the first surface
    written = {".seq": "EPD 10", ".zmx": "ENPD 10", ".len": f"EBR {beam!r}"}[suffix]
    lens = loaded(tmp_path, f"a{suffix}", NEAR[suffix].format(aperture=written, distance=distance))
    assert lens.stop.semi_diameter == pytest.approx(5.0 * ratio, rel=1e-12)
    assert 2.0 * lb.first_order(lens).entrance_pupil.radius == pytest.approx(10.0, rel=1e-12)
    assert lens.system.aperture.kind is ApertureKind.PUPIL_DIAMETER
    assert lens.system.aperture.values == pytest.approx((10.0,), rel=1e-12 if suffix == ".len" else 0.0)
    assert lens.system.object_distances == (distance if distance < 1e8 else inf,)


@pytest.mark.parametrize("distance", [20.0, 200.0])
def test_rims_that_are_not_stated_follow_the_chief_ray_of_a_near_object(tmp_path, distance):
    text = NEAR[".seq"].format(aperture="EPD 10", distance=distance).replace("YAN 0.0", "YOB 12.0")
    lens = loaded(tmp_path, "a.seq", text)
    ratio, pupil, _ = oracle(distance)
    chief = 12.0 * pupil / (distance + pupil)           # straight from the object's point to the pupil's centre
    marginal = 5.0 * distance / (distance + pupil)
    assert lens.surfaces[0].semi_diameter == pytest.approx(abs(chief) + abs(marginal), rel=1e-9)


@pytest.mark.parametrize(("suffix", "text", "kind"), [
    (".zmx", "FNUM 8 1", ApertureKind.WORKING_F_NUMBER), (".seq", "FNO 8", ApertureKind.WORKING_F_NUMBER),
    (".len", "FNO 8", ApertureKind.WORKING_F_NUMBER)])
def test_a_working_f_number_fixes_the_slope_behind_the_lens(tmp_path, suffix, text, kind):
    lens = loaded(tmp_path, f"a{suffix}", NEAR[suffix].format(aperture=text, distance=200.0))
    assert lens.system.aperture == Aperture(kind, (8.0,))
    ratio, pupil, slope = oracle(200.0)
    # A slope of 1 at the object is `slope` behind the lens, and 200 + pupil high in the entrance pupil
    assert lens.stop.semi_diameter == pytest.approx((200.0 + pupil) * ratio / abs(slope) / 16.0, rel=1e-9)


@pytest.mark.parametrize(("suffix", "text"), [(".zmx", "OBNA 0.05 0"), (".seq", "NAO 0.05"), (".len", "NAO 0.05")])
def test_the_numerical_aperture_of_the_object_is_that_of_the_real_ray_to_the_stop(tmp_path, suffix, text):
    lens = loaded(tmp_path, f"a{suffix}", NEAR[suffix].format(aperture=text, distance=60.0))
    ray = lb.trace(lens, [0.0, 0.0, -60.0], [0.0, 0.05, (1.0 - 0.05**2)**0.5], clip=False)
    assert lens.stop.semi_diameter == pytest.approx(abs(ray.points[0, 1]), rel=1e-12)
    ratio, pupil, _ = oracle(60.0)                      # the paraxial height, which the real one nears
    assert lens.stop.semi_diameter == pytest.approx(tan(asin(0.05)) * (60.0 + pupil) * ratio, rel=0.02)


@pytest.mark.parametrize(("suffix", "text"), [(".zmx", "FNUM 5 0"), (".seq", "FNO 5"), (".len", "FNO 5")])
def test_the_f_number_of_the_system_wins_over_the_rim_of_the_stop_and_both_figures_are_found(tmp_path, suffix, text):
    lens = loaded(tmp_path, f"a{suffix}", NEAR[suffix].format(aperture=text, distance=1e20))
    assert lb.first_order(lens).f_number == pytest.approx(5.0, rel=1e-12)
    assert lens.system.aperture == Aperture(ApertureKind.F_NUMBER, (5.0,))
    (told,) = (finding for finding in lens.findings if finding.kind is Kind.STOP_SIZE)
    assert told.figures == {"aperture": lens.stop.semi_diameter, "rim": 9.0} and told.surface == lens.stop_index
    assert f"{lens.stop.semi_diameter:.5g} mm" in str(told) and "9 mm" in str(told)


@pytest.mark.parametrize("suffix", [".json", ".roa"])
def test_the_aperture_of_the_system_wins_in_json_formats_too(suffix):
    lens = replace(lenses.load("lenshh-cooke-triplet-50"), system=SystemData())
    text, _ = WRITERS[suffix](lens.with_stop_radius(2.0))
    rim = '"r_max": 2.0' if suffix == ".json" else '"radius": 2.0'
    assert rim in text
    read = READERS[suffix](text.replace(rim, rim.replace("2.0", "3.0")), "a")
    assert read.stop.semi_diameter == pytest.approx(2.0, rel=1e-12)
    assert any(finding.figures.get("rim") == 3.0 for finding in read.findings)


def test_an_aperture_that_no_stop_has_is_left_out_and_the_rim_kept(tmp_path):
    lens = loaded(tmp_path, "a.zmx", NEAR[".zmx"].format(aperture="OBNA 0.1 0", distance="INFINITY"))
    assert lens.stop.semi_diameter == 9.0
    assert any("fits no stop" in str(finding) for finding in lens.findings)
    lens = loaded(tmp_path, "b.zmx", NEAR[".zmx"].format(aperture="ENPD 0", distance="INFINITY"))
    assert lens.system.aperture is None and any("0 is left out" in str(finding) for finding in lens.findings)


def test_fields_with_vignetting_and_wavelengths_of_a_zemax_file(tmp_path):
    text = NEAR[".zmx"].format(aperture="ENPD 10", distance="INFINITY")
    text = text.replace("FTYP 0 0 1 1 0 0 0\nYFLN 0\nWAVM 1 0.5875618 1\nPWAV 1", "\n".join([
        "FTYP 2 0 2 3 0 0 0", "XFLN 0 -1 0 0", "YFLN 0 14 0 0", "FWGN 1 2.5 1 1", "VDXN 0 0 0 0", "VDYN 0 -0.1 0 0",
        "VCXN 0 0.02 0 0", "VCYN 0 0.3 0 0", "WAVM 1 0.248 1", "WAVM 2 0.2483 0.5", "WAVM 3 0.25 1", "WAVM 4 0.55 1",
        "PWAV 2"]))
    system = loaded(tmp_path, "a.zmx", text).system
    assert system.field_kind is FieldKind.IMAGE_HEIGHT
    # the pupil is squeezed to 0.7 of its height and moved down by 0.1: 0.4 is cut off above and 0.2 below
    assert system.fields == (FieldPoint(0.0, 0.0), FieldPoint(-1.0, 14.0, 2.5, (0.02, 0.02, 0.4, 0.2)))
    assert system.wavelengths == (Wavelength(0.248), Wavelength(0.2483, 0.5), Wavelength(0.25))
    assert system.primary_wavelength == 0.2483


def test_a_file_of_another_unit_has_its_system_data_in_mm(tmp_path):
    text = NEAR[".zmx"].format(aperture="ENPD 10", distance="200").replace("UNIT MM", "UNIT CM")
    system = loaded(tmp_path, "a.zmx", text.replace("FTYP 0", "FTYP 1").replace("YFLN 0", "YFLN 3")).system
    assert system.aperture.values == (100.0,) and system.object_distances == (2000.0,)
    assert system.fields == (FieldPoint(0.0, 30.0),)


# What is written reads back equal

share = st.integers(-40, 90).map(lambda percent: percent / 100.0)
size = st.floats(-80.0, 80.0).map(lambda x: float(f"{x:.6g}"))
weights = st.floats(0.0, 10.0)
kinds = st.sampled_from(FieldKind)


@st.composite
def systems(draw, suffix):
    """System data that a format can hold, and the lens that has such a stop."""
    near = draw(st.booleans())
    distance = draw(st.floats(150.0, 1e5)) if near else inf
    symmetric = suffix == ".json"
    single = suffix == ".len"
    cuts = [draw(share) for _ in range(4)]
    if symmetric:
        cuts = [cuts[0], cuts[0], cuts[2], cuts[2]]
    count = 1 if single else draw(st.integers(1, 4))
    fields = tuple(FieldPoint(0.0 if single else draw(size), draw(size), 1.0 if single else draw(weights),
                              (0.0,) * 4 if single else tuple(cuts)) for _ in range(count))
    waves = tuple(Wavelength(w, draw(weights)) for w in draw(st.lists(st.floats(0.42, 0.68), min_size=1, max_size=4)))
    kind = draw(kinds.filter(lambda kind: not (single and kind is FieldKind.REAL_IMAGE_HEIGHT)))
    apertures = {ApertureKind.PUPIL_DIAMETER: 8.0, ApertureKind.F_NUMBER: 6.3}
    if near:
        apertures = {ApertureKind.PUPIL_DIAMETER: 8.0, ApertureKind.WORKING_F_NUMBER: 7.1,
                     ApertureKind.OBJECT_NA: 0.5 * sin(4.0 / distance)}
        if suffix == ".json":
            del apertures[ApertureKind.WORKING_F_NUMBER]
    if suffix in (".toml", ".zmx"):
        apertures[ApertureKind.STOP_SIZE] = 0.0
    stated = draw(st.sampled_from(list(apertures)))
    primary = 0 if single else draw(st.integers(0, len(waves) - 1))
    return SystemData(Aperture(stated, (apertures[stated],)), kind, fields, waves, primary, (distance,))


@pytest.mark.parametrize("suffix", FULL)
@given(data=st.data())
@settings(max_examples=40)
def test_system_data_that_are_written_read_back_equal(suffix, data):
    system = data.draw(systems(suffix))
    lens = Lens((Surface(5.0, 9.0, GLASS, curvature=0.02), Surface(3.0, 9.0, curvature=-0.02),
                 Surface(60.0, 4.0, curvature=0.0)), 2, system=system)
    lens = sized(lens)
    text, remarks = WRITERS[suffix](lens)
    read = READERS[suffix](text, f"a{suffix}")
    if suffix == ".len" and system.aperture.kind is ApertureKind.PUPIL_DIAMETER:        # written as a beam's height
        assert read.system.aperture.values == pytest.approx(system.aperture.values, rel=1e-15)
        read = replace(read, system=replace(read.system, aperture=system.aperture))
    assert remarks == () and read.system == system and read.surfaces == lens.surfaces


def sized(lens):
    """The lens with the stop that its system data ask for, as a reader makes it."""
    text, _ = WRITERS[".toml"](lens)
    aperture = lens.system.aperture
    if aperture.kind is ApertureKind.STOP_SIZE:
        return READERS[".toml"](text, "a.toml")
    from lensbench.lenses.tables.aperture import stop_radius

    radius = stop_radius(lens.surfaces, lens.stop_index, aperture.kind, aperture.values[0],
                         lens.system.object_distances[0], lens.system.primary_wavelength)
    return lens.with_stop_radius(radius)


@pytest.mark.parametrize("suffix", [".toml", ".zmx", ".seq", ".len"])
def test_a_zoom_keeps_an_aperture_for_each_setting(suffix):
    rows = ((50.0, 40.0), (20.0, 60.0))
    lens = Lens((Surface(1.0, 12.0, GLASS, curvature=-0.0125), Surface(50.0, 12.0, curvature=0.0125),
                 Surface(2.0, 8.0, GLASS, curvature=0.025),
                 Surface(40.0, 8.0, curvature=-0.025)), 2, positions=Positions((1, 3), tuple((row,) for row in rows),
                                                                               (0.0, 1.0)))
    diameters = tuple(2.0 * lb.first_order(lens.at(zoom=zoom)).entrance_pupil.radius for zoom in (0.0, 1.0))
    lens = replace(lens, system=SystemData(Aperture(ApertureKind.PUPIL_DIAMETER, diameters),
                                           fields=(FieldPoint(0.0, 5.0),), wavelengths=(Wavelength(0.5875618),)))
    text, _ = WRITERS[suffix](lens)
    read = READERS[suffix](text, f"a{suffix}")
    assert read.system == lens.system and read.surfaces == lens.surfaces
    assert read.positions.stops == ()                   # its size stays


def test_a_stop_that_was_closed_is_written_and_not_the_aperture_that_it_contradicts():
    lens = lenses.load(DATA / "doublet.zmx")
    closed = lens.with_stop_radius(0.5 * lens.stop.semi_diameter)
    for suffix in FULL[1:]:
        text, remarks = WRITERS[suffix](closed)
        assert READERS[suffix](text, f"a{suffix}").stop.semi_diameter == pytest.approx(closed.stop.semi_diameter)
        assert any("the stop has another size" in str(remark) for remark in remarks)


@pytest.mark.parametrize("rounding", [0.0, 1e-13])
@pytest.mark.parametrize("suffix", [".zmx", ".json"])
def test_of_an_entrance_pupil_at_infinity_the_size_of_the_stop_is_written_and_the_rest_said(suffix, rounding):
    stopped = (Surface(0.0, 20.0, Glass(1.5), curvature=1.0 / 64.0), Surface(128.0 + rounding, 20.0, curvature=0.0),
               Surface(10.0, 2.0, curvature=0.0))
    lens = Lens(stopped, 2, system=SystemData(Aperture(ApertureKind.F_NUMBER, (2.0,))))
    text, remarks = WRITERS[suffix](lens)
    assert READERS[suffix](text, f"a{suffix}").stop.semi_diameter == 2.0
    assert "the f-number 2 is left out, as the stop has another size: the size of the stop is written" in map(
        str, remarks)
    plain, remarks = WRITERS[suffix](replace(lens, system=SystemData()))
    assert READERS[suffix](plain, f"a{suffix}").stop.semi_diameter == 2.0 and not remarks


@pytest.mark.parametrize(("suffix", "lost"), [(".dat", ("aperture", "fields", "wavelengths", "object distance")),
                                              (".txt", ("aperture", "wavelengths"))])
def test_formats_without_system_data_say_what_they_leave_out(suffix, lost):
    lens = replace(lenses.load(DATA / "doublet.zmx"), positions=None)
    lens = replace(lens, system=replace(lens.system, object_distances=(500.0,)))
    _, remarks = WRITERS[suffix](lens)
    assert f"left out of its system data: {', '.join(lost)}" in map(str, remarks)
    _, remarks = WRITERS[suffix](replace(lens, system=SystemData()))
    assert not any("system data" in str(remark) for remark in remarks)


def test_what_a_format_cannot_hold_of_the_fields_is_said():
    lens = lenses.load(DATA / "doublet.zmx")
    cut = replace(lens, system=replace(lens.system, fields=(FieldPoint(0.0, 5.0, 1.0, (0.0, 0.0, 0.1, 0.3)),)))
    assert any("mean of both sides" in str(remark) for remark in WRITERS[".json"](cut)[1])
    assert any("largest alone" in str(remark) for remark in WRITERS[".len"](lens)[1])
    assert any("primary one first" in str(remark) for remark in WRITERS[".len"](replace(
        lens, system=replace(lens.system, primary=2)))[1])


@pytest.mark.parametrize(("entry", "told"), [
    ('aperture = { kind = "speed", values = [2.0] }', "speed"), ("fields = [3.0]", "field point"),
    ("primary = 4", "primary"), ("aperture = 2.0", "aperture is written"), ("colour = 1", "colour"),
    ("wavelengths = [{ um = -1.0 }]", "wavelength"), ("fields = [{ y = 1.0, vignetting = [0.1] }]", "four factors")])
def test_a_mistake_in_the_table_of_a_toml_file_is_refused_with_its_line(tmp_path, entry, told):
    text, _ = WRITERS[".toml"](replace(lenses.load("lenshh-cooke-triplet-50"), system=SystemData()))
    error = refusal(tmp_path, "a.toml", f"{text}\n[system]\n{entry}\n")
    assert told in error.reason and error.line is not None


SILICA = """\
MODE SEQ
NAME Lithography singlet
UNIT MM
FNUM 5 0
FTYP 0 0 1 1 0 0 0
YFLN 0
WAVM 1 0.248 1
PWAV 1
SURF 0
  DISZ INFINITY
SURF 1
  STOP
  CURV 0.02
  DISZ 5
  GLAS F_SILICA 0 0 1.5 40
  DIAM 12
SURF 2
  CURV -0.02
  DISZ 48.2
  DIAM 12
SURF 3
"""


def test_a_design_for_248_nm_is_reported_at_248_nm(tmp_path, capsys):
    lens = loaded(tmp_path, "a.zmx", SILICA)
    # Malitson's index of fused silica at 0.248 µm is 1.50855; the thick lensmaker's equation
    n, radius, thickness = 1.50855, 50.0, 5.0
    efl = 1.0 / (2.0 * (n - 1.0) / radius - (n - 1.0) ** 2 * thickness / (n * radius**2))
    assert lens.stop.semi_diameter == pytest.approx(efl / 10.0, rel=1e-4)         # f/5 at 248 nm, on the first surface
    assert main(["info", str(tmp_path / "a.zmx"), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["efl"] == pytest.approx(efl, rel=1e-4) and data["f_number"] == pytest.approx(5.0, rel=1e-12)
    assert data["wavelength"] == lens.reference_wavelength == 0.248
    # One rule for `info`, the window (below) and Python: the primary wavelength, unless another one is given
    assert lb.first_order(lens).efl == pytest.approx(efl, rel=1e-4)
    assert lb.f_number_at_infinity(lens) == pytest.approx(5.0, rel=1e-12)
    assert lb.transmission(lens) == pytest.approx((1.0 - ((n - 1.0) / (n + 1.0))**2)**2, rel=1e-5)
    assert lb.t_number(lens) == pytest.approx(5.0 / lb.transmission(lens)**0.5, rel=1e-12)
    assert main(["info", str(tmp_path / "a.zmx")]) == 0
    assert "Numbers at the primary wavelength" in capsys.readouterr().out
    assert main(["info", "lenshh-cooke-triplet-50"]) == 0
    assert "primary wavelength" not in capsys.readouterr().out
    told = lenses.check(replace(lens, stated_efl=efl))
    assert any("248 nm" in str(finding) for finding in told)
    assert not any(finding.kind is Kind.FOCAL_LENGTH for finding in told)
    assert any(finding.kind is Kind.FOCAL_LENGTH for finding in lenses.check(
        replace(lens, stated_efl=lb.first_order(lens, lb.D_LINE).efl)))             # 10 % longer


def test_a_glass_unknown_at_the_primary_wavelength_is_said_and_the_d_line_taken(tmp_path):
    lens = loaded(tmp_path, "a.zmx", SILICA.replace("F_SILICA 0", "___BLANK 1 0 1.4585 67.8").replace(" 0 1.5 40", ""))
    assert any("not known at the primary wavelength, 0.248" in str(finding) for finding in lens.findings)
    assert lb.first_order(lens).f_number == pytest.approx(5.0, rel=1e-12)


def test_the_read_outs_of_the_window_are_those_of_the_primary_wavelength(tmp_path):
    loaded(tmp_path, "a.zmx", SILICA)
    settings = replace(Settings(), lens=str(tmp_path / "a.zmx"))
    got = readings(settings)
    assert got.wavelength == 0.248 and got.efl == pytest.approx(lb.first_order(lenses.load(settings.lens), 0.248).efl)
    assert got.widest_f_number == pytest.approx(5.0, rel=1e-12)
    scaled = readings(replace(settings, focal_length=100.0))
    assert scaled.efl == pytest.approx(100.0, rel=1e-12)
    shown = {row.name.strip(): row for row in rows(settings, got, Status())}
    assert (shown["at"].value, shown["at"].unit) == ("248", "nm")
    plain = replace(Settings(), lens="lenshh-cooke-triplet-50")
    assert "at" not in {row.name.strip() for row in rows(plain, readings(plain), Status())}


def test_a_zoom_that_is_converted_in_one_position_states_the_aperture_of_that_position(tmp_path):
    lens = lenses.load(DATA / "zoom.zmx")
    lenses.save(lens, tmp_path / "zoom.seq")
    converted = lenses.load(tmp_path / "zoom.seq")
    assert len(converted.system.aperture.values) == 3
    assert main(["convert", str(tmp_path / "zoom.seq"), str(tmp_path / "one.toml"), "--zoom", "1"]) == 0
    one = lenses.load(tmp_path / "one.toml")
    assert one.system.aperture.values == converted.system.aperture.values[-1:]
    assert one.stop.semi_diameter == converted.at(zoom=1.0).stop.semi_diameter


def test_check_knows_a_near_object_from_the_system_data_of_any_format(tmp_path):
    near = loaded(tmp_path, "a.zmx", NEAR[".zmx"].format(aperture="ENPD 10", distance="200"))
    lenses.save(near, tmp_path / "a.toml")
    assert "back-focus" not in {finding.kind for finding in lenses.check(lenses.load(tmp_path / "a.toml"))}
    far = replace(near, system=SystemData())
    assert "back-focus" in {finding.kind for finding in lenses.check(far)}


def test_of_several_wavelengths_the_primary_one_is_named():
    one, two = Wavelength(0.55), Wavelength(0.6)
    ((_, alone),) = system_rows(SystemData(wavelengths=(one,)))
    ((_, both),) = system_rows(SystemData(wavelengths=(one, two), primary=1))
    assert alone == "550 nm" and both == "550, 600 nm, the primary one 600 nm"


@pytest.mark.parametrize("suffix", FULL)
def test_infrared_wavelengths_weights_and_vignetted_fields_survive(suffix):
    """850 and 940 nm, of which the second is the primary one; OSLO has it first, and one field."""
    system = SystemData(Aperture(ApertureKind.STOP_SIZE, (0.0,)), FieldKind.ANGLE,
                        (FieldPoint(0.0, 0.0), FieldPoint(0.0, 14.0, 2.0, (0.1, 0.1, 0.3, 0.3))),
                        (Wavelength(0.85, 2.0), Wavelength(0.94, 0.5)), 1)
    lens = Lens((Surface(5.0, 9.0, GLASS, curvature=0.02), Surface(3.0, 9.0, curvature=-0.02),
                 Surface(46.0, 4.0, curvature=0.0)), 2, system=system)
    read = READERS[suffix](WRITERS[suffix](lens)[0], f"a{suffix}").system
    assert sorted(read.wavelengths, key=lambda wave: wave.micrometres) == list(system.wavelengths)
    assert read.primary_wavelength == 0.94
    assert read.fields == (system.fields if suffix != ".len" else (FieldPoint(0.0, 14.0),))


@pytest.mark.parametrize(("suffix", "aperture"), [(".zmx", "FNUM 0.00001 0"), (".seq", "EPD 1000000"),
                                                  (".len", "EBR 500000")])
def test_a_stop_wider_than_everything_is_not_believed(tmp_path, suffix, aperture):
    lens = loaded(tmp_path, f"a{suffix}", NEAR[suffix].format(aperture=aperture, distance=1e20))
    rims = [surface.semi_diameter for surface in lens.surfaces]
    assert lens.stop.semi_diameter <= 9.0 or suffix == ".seq"          # there all other rims are estimated from it
    assert suffix == ".seq" or any("fits no stop" in str(finding) for finding in lens.findings)
    assert max(rims) == rims[0] or suffix != ".seq"


def test_a_stop_that_is_none_and_a_thickness_behind_a_mirror_are_named():
    def found(*surfaces, stop=1):
        text, _ = WRITERS[".txt"](Lens(surfaces, stop))
        return {finding.kind: str(finding) for finding in READERS[".txt"](text, "a.txt").findings}

    front, back = Surface(5.0, 9.0, GLASS, curvature=0.02), Surface(3.0, 9.0, curvature=-0.02)
    assert not {Kind.STOP_SIZE, Kind.THICKNESS} & set(found(front, back))
    assert "1000000 mm, is that of no stop" in found(front, replace(back, semi_diameter=1e6))[Kind.STOP_SIZE]
    assert "mirrors are not traced" in found(replace(front, thickness=-5.0), back)[Kind.THICKNESS]
    assert "mirrors are not traced" in found(front, replace(back, thickness=-3.0), front, back)[Kind.THICKNESS]
    # A stop inside the bulge is no mirror
    stop = Surface(2.0, 5.0, curvature=0.0)
    assert Kind.THICKNESS not in found(front, replace(back, thickness=-1.0), stop, front, back, stop=2)
