"""Solves and pickups of lens files: solved where the file has no value, and checked where it has one.

The oracle is a paraxial trace of its own, surface by surface: n′u′ = n u − y c (n′ − n), then y′ = y + t u′.
"""

import json
from math import radians, tan

import pytest
from hypothesis import assume, given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.lenses import READERS, Kind
from tests.lenses.samples import DATA, changed_json, changed_sample, loaded, refusal

OSLO = """\
LEN NEW "t" 80 3
EBR 10; {system}; UNI 1
AIR; TH {distance}; NXT
GLA 1.5; {first}; TH 5; AP 12; {stop}NXT
AIR; {second}; {gap}; AP 12; NXT
AIR; WV 0.58756; WW 1
END 3
"""


def oslo(first="RD 60", second="RD -60", gap="PY 0", system="ANG 5", distance="1e20", stop="AST; "):
    text = OSLO.format(first=first, second=second, gap=gap, system=system, distance=distance, stop=stop)
    return READERS[".len"](text, "a.len")


def traced(lens, y, u):
    """Heights at the surfaces and at the end of the last gap, and slopes behind the surfaces."""
    n, heights, slopes = 1.0, [], []
    for s in lens.surfaces:
        heights.append(y)
        u = (n * u - y * s.curvature * (s.glass.n_d - n)) / s.glass.n_d
        n = s.glass.n_d
        slopes.append(u)
        y += s.thickness * u
    return [*heights, y], slopes


def test_an_axial_slope_fixes_the_focal_length():
    lens = oslo(second="PU -0.125")
    assert lb.first_order(lens, 0.58756).efl == pytest.approx(10.0 / 0.125, rel=1e-12)      # beam radius over slope
    assert traced(lens, 10.0, 0.0)[0][-1] == pytest.approx(0.0, abs=1e-12)                   # PY 0: the paraxial image


@given(st.floats(-0.2, -0.02), st.floats(-0.3, -0.05), st.floats(0.5, 4.0), st.sampled_from(["1e20", "150"]))
@settings(max_examples=60, deadline=None)
def test_axial_solves_hold_by_an_independent_trace(first, second, height, distance):
    lens = oslo(f"PU {first!r}", f"PU {second!r}", f"PY {height!r}", distance=distance)
    heights, slopes = traced(lens, 10.0, 0.0 if distance == "1e20" else 10.0 / 150.0)
    assert slopes == pytest.approx([first, second], rel=1e-9)
    assert heights[-1] == pytest.approx(height, rel=1e-9)


@given(st.floats(-0.3, 0.3), st.floats(-20.0, 20.0), st.sampled_from(["ANG 8", "ANG -3", "OBH -12"]))
@settings(max_examples=60, deadline=None)
def test_chief_solves_hold_by_an_independent_trace(slope, height, field):
    distance = "150" if field.startswith("OBH") else "1e20"
    u = 12.0 / 150.0 if field.startswith("OBH") else tan(radians(float(field.split()[1])))     # the stop is surface 0
    inside = u / 1.5 * 5.0
    assume(abs(slope) > 1e-3 and abs(height - inside) > 1e-3)
    lens = oslo("RD 60", f"PUC {slope!r}", f"PYC {height!r}", field, distance)
    heights, slopes = traced(lens, 0.0, u)
    assert slopes[1] == pytest.approx(slope, rel=1e-9) and heights[-1] == pytest.approx(height, rel=1e-9, abs=1e-9)


def test_an_edge_solve_makes_the_surfaces_touch():
    lens = oslo("RD 60", "RD -45; CC -1", "PY 0")
    touching = READERS[".len"](OSLO.format(first="RD 60", second="RD -45; CC -1", gap="PY 0", system="ANG 5",
                                           distance="1e20", stop="AST; ").replace("TH 5", "EC 11"), "a.len")
    front, back = lens.surfaces
    assert touching.surfaces[0].thickness == pytest.approx(float(front.sag(0.0, 11.0) - back.sag(0.0, 11.0)), rel=1e-12)


@pytest.mark.parametrize(("pickup", "value"), [
    ("PK CVM 1", "RD -60"), ("PK CV 1", "RD 60"), ("PK CV -1 0.01", f"CV {1 / 60 + 0.01!r}"),
    ("RD 70; PK CVM 1", "RD -60"), ("PK CVM 1; RD 70", "RD 70"), ("PU -0.1; RD 70", "RD 70"),
    ("CC -2; AD 1e-5; PK CVM 1", "RD -60"), ("RDF 70", "RD 70"), ("PU -0.1; CSD", "RD 0")])
def test_a_curvature_is_picked_up_and_the_last_command_holds(pickup, value):
    assert oslo(second=pickup).surfaces == oslo(second=value).surfaces


@pytest.mark.parametrize(("pickup", "gap"), [("PK TH 1", 5.0), ("PK THM 1 70", 65.0), ("PK LN 1 2 3", 8.0),
                                             ("PK LNM 1 0 60", 55.0)])
def test_a_thickness_is_picked_up(pickup, gap):
    assert oslo(gap=pickup).surfaces[1].thickness == gap


@pytest.mark.parametrize(("words", "told"), [
    ({"second": "PU -0.1", "system": "FNO 4"}, "axial ray is not known"),
    ({"second": "PUC 0.1", "system": "GIH 4"}, "chief ray is not known"),
    ({"second": "PK CV 3"}, "does not come before"), ({"second": "PK TD 1"}, "PK TD"),
    ({"second": "PU -0.1", "gap": "PYC 0", "system": "ANG 0"}, "no thickness"),
    ({"stop": "EC 4; AST; ", "second": "PU -0.1"}, "is solved, too")])
def test_a_solve_that_is_not_solved_refuses_the_file(words, told):
    with pytest.raises(lenses.LensFileError) as caught:
        oslo(**words)
    assert told in str(caught.value)


def test_a_chief_ray_that_later_surfaces_aim_is_not_solved():
    text = OSLO.format(first="PUC 0.05", second="RD -60; AST", gap="TH 50", system="ANG 5", distance="1e20", stop="")
    with pytest.raises(lenses.LensFileError, match="chief ray is not known"):
        READERS[".len"](text, "a.len")


def test_configurations_behind_the_surfaces_are_zoom_positions(tmp_path):
    text = OSLO.format(first="RD 60", second="RD -60", gap="TH 50", system="ANG 5", distance="1e20", stop="AST; ")
    lens = loaded(tmp_path, "a.len", text + "CFG NEW\nTH 1 2 8\nTH 2 2 44\nCFWT 2 1\nEND\nOPE NEW\nO 1 \"X\"\nEND\n")
    assert sorted(row[0] for row in lens.positions.thicknesses) == [(5.0, 50.0), (8.0, 44.0)]
    assert "CFG CV is not understood" in refusal(tmp_path, "a.len", text + "CFG NEW\nCV 1 2 0.1\nEND\n").reason
    assert "LEN is not understood" in refusal(tmp_path, "a.len", text + "LEN UPD\n").reason
    assert "XYZ" in refusal(tmp_path, "a.len", text + "XYZ 3\n").reason


# Values beside their solves

ZEMAX = """\
MODE SEQ
UNIT MM
ENPD 20
FTYP 0 0 1 1 0 0 0
YFLN 5
WAVM 1 0.5875618 1
PWAV 1
SURF 0
  DISZ INFINITY
SURF 1
  STOP
  CURV {c0!r} 0 0 0 0
  DISZ 5
  GLAS ___BLANK 1 0 1.5 0
  DIAM 12
SURF 2
  CURV {c1!r} {flag}
  DISZ {gap!r}
  {solve}
  DIAM 12
SURF 3
"""
C0, N, T = 1.0 / 60.0, 1.5, 5.0


def zemax(c1, gap=40.0, flag="0 0 0 0", solve="COMM none"):
    lens = READERS[".zmx"](ZEMAX.format(c0=C0, c1=c1, gap=gap, flag=flag, solve=solve), "a.zmx")
    return [finding for finding in lens.findings if finding.kind is Kind.UNSOLVED]


def bent(slope):
    """Curvature of surface 1 for a marginal ray of height 10 that leaves with this slope."""
    inside = -10.0 * C0 * (N - 1.0) / N
    y = 10.0 + T * inside
    return (N * inside - slope) / (y * (1.0 - N)), y


@pytest.mark.parametrize(("right", "wrong"), [
    (dict(c1=-C0, flag="4 1 -1 0"), dict(c1=-0.9 * C0, flag="4 1 -1 0")),
    (dict(c1=bent(-0.2)[0], flag="2 -0.2 0"), dict(c1=1.1 * bent(-0.2)[0], flag="2 -0.2 0")),
    (dict(c1=bent(-0.2)[0], solve="MAZA -0.2"), dict(c1=1.1 * bent(-0.2)[0], solve="MAZA -0.2")),
    (dict(c1=bent(-0.2)[0], gap=bent(-0.2)[1] / 0.2, solve="MAZH 0 0"), dict(
        c1=bent(-0.2)[0], gap=44.0, solve="MAZH 0 0")),
    (dict(c1=bent(-0.2)[0], gap=(bent(-0.2)[1] - 1.0) / 0.2, solve="MAZH 1 0"), dict(
        c1=bent(-0.2)[0], gap=44.0, solve="MAZH 1 0")),
    (dict(c1=-C0, gap=11.0, solve="PZUP 1 2 1 0"), dict(c1=-C0, gap=12.0, solve="PZUP 1 2 1 0")),
    (dict(c1=-C0, gap=45.0, solve="TCOM 1 50"), dict(c1=-C0, gap=44.0, solve="TCOM 1 50")),
    (dict(c1=-C0, gap=45.0, solve="TOLE 1 50"), dict(c1=-C0, gap=44.0, solve="TOLE 1 50"))])
def test_zemax_values_that_contradict_their_solves_are_named(right, wrong):
    assert zemax(**right) == []
    (doubt,) = zemax(**wrong)
    assert doubt.figures["solved"] != doubt.figures["stored"] and "follows from a solve" in str(doubt)


def test_a_solve_that_cannot_be_checked_is_named():
    (doubt,) = zemax(-C0, solve="EDGE 1 0")
    assert "EDGE) that cannot be checked" in str(doubt)
    (doubt,) = zemax(-C0, solve="MAZH 0 0.7")            # of a real ray
    assert "cannot be checked" in str(doubt)


def test_a_picked_up_glass_must_be_that_of_its_surface(tmp_path):
    lens = changed_sample("doublet.zmx", tmp_path, ("___BLANK 1 0 1.62", "F2 2 1 1.62"))
    assert any("picked up from surface 1, which has N-BK7" in str(finding) for finding in lens.findings)


@pytest.mark.parametrize(("command", "told"), [
    ("PIK RDY S2 Z1 RDY S1 Z1 -1", "(PIK RDY): it is -0.045"), ("PIK THI S4 THI S2 1.5", "(PIK THI): it is 9"),
    ("PIK GLA S3 GLA S1", "(PIK GLA) that cannot be checked"), ("THI S6 HMY 0.5", "(THI HMY): it is"),
    ("CUY S6 UMY -0.09", "(CUY UMY): it is"), ("CUY S6 APL", "(CUY APL) that cannot be checked")])
def test_codev_values_that_contradict_their_solves_are_named(tmp_path, command, told):
    whole = lenses.load(DATA / "triplet.seq")
    lens = changed_sample("triplet.seq", tmp_path, ("SI    0.0 0.0", f"SI    0.0 0.0\n{command}"))
    messages = [str(finding) for finding in lens.findings if finding not in whole.findings]
    assert lens == whole and len(messages) == 1 and told in messages[0]


@pytest.mark.parametrize(("solve", "told"), [
    ({"pickups": [{"source_surface_idx": 1, "attr_type": "radius", "target_surface_idx": 2, "scale": -1.0,
                   "offset": 0.0}]}, "pickup of radius"),
    ({"solves": {"solves": [{"type": "MarginalRayHeightThicknessSolve", "surface_idx": 2, "height": 0.3}]}},
     "MarginalRayHeight")])
def test_optiland_values_that_contradict_their_solves_are_named(tmp_path, solve, told):
    text, _ = lenses.WRITERS[".json"](lenses.load("lenshh-cooke-triplet-50"))
    lens = loaded(tmp_path, "a.json", json.dumps(json.loads(text) | solve))
    (doubt,) = (finding for finding in lens.findings if finding.kind is Kind.UNSOLVED)
    assert told in str(doubt) and "solved" in doubt.figures


def test_lenshh_values_that_contradict_their_solves_are_named(tmp_path):
    model = json.loads((DATA / "zoom.lhlt").read_text())
    pickup = {"TargetSurfaceIndex": 2, "Parameter": "Curvature", "SourceSurfaceIndex": 1, "ScaleFactor": -1.0}
    lens = loaded(tmp_path, "a.lhlt", changed_json(model, ["Pickups"], [pickup]))
    assert any("pickup of Curvature" in str(finding) and finding.figures for finding in lens.findings)
    lens = loaded(tmp_path, "a.lhlt", changed_json(model, ["Surfaces", 6, "HasMarginalRaySolve"], True))
    assert any("HasMarginalRaySolve" in str(finding) and finding.figures for finding in lens.findings)
