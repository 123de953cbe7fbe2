"""The project's lens file: round trips equal to the last bit; each mistake names its line."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import AIR, Glass, Lens, Surface, lenses
from lensbench.core.optics.lens_surface import SurfacePose
from tests.library import EVERY

ROWS = """format = 1
title = "Two lenses"
units = "mm"
columns = ["radius", "thickness", "n_d", "semi_diameter"]
surfaces = [
    [50.0, 4.0, 1.5, 10.0],
    [inf, 3.0, 1.0, 10.0],
    [0, 2.0, 1.0, 8.0, "stop"],
    [-50.0, 40.0, 1.0, 9.0],
]
"""

SHAPED = """format = 1
columns = ["radius", "thickness", "n_d", "semi_diameter", "conic"]
surfaces = [
    [50.0, 4.0, 1.5, 10.0, -1.5],
    [inf, 3.0, 1.0, 10.0, 0],
    [0, 2.0, 1.0, 8.0, 0, "stop"],
    [-50.0, 40.0, 1.0, 9.0, 0],
]

[aspheric]
0 = { r4 = 1e-5, r7 = -2.5e-9 }

[radius_x]
1 = 25
3 = inf
"""

lengths = st.floats(-1e4, 1e4)
sides = st.floats(1e-3, 1e3)
texts = st.text(st.characters(codec="utf-8"), max_size=20)
glasses = st.just(AIR) | st.builds(Glass, st.floats(1.0, 4.0), st.none() | st.floats(1.0, 120.0), texts)
curvatures = st.just(0.0) | st.floats(1e-12, 1e5) | st.floats(-1e5, -1e-12)
terms = st.dictionaries(st.integers(2, 20), st.floats(-1.0, 1.0), max_size=4).map(lambda terms: tuple(terms.items()))
surfaces = (st.builds(Surface, lengths, st.floats(1e-6, 1e6), glasses, curvature=curvatures)
            | st.builds(Surface, lengths, st.floats(1e-6, 1e6), glasses, st.floats(-20.0, 20.0), terms,
                        curvature=curvatures)
            | st.builds(Surface, lengths, st.floats(1e-6, 1e6), glasses, curvature=curvatures, curvature_x=curvatures))


@st.composite
def prescriptions(draw):
    table = tuple(draw(st.lists(surfaces, min_size=1, max_size=6)))
    numbers = st.none() | st.floats(-1e6, 1e6)
    return Lens(table, draw(st.integers(0, len(table) - 1)), draw(texts), draw(texts),
                draw(st.none() | st.integers(1, 9999)), draw(texts), draw(numbers), draw(numbers), draw(texts),
                maker=draw(texts), designer=draw(texts), patent=draw(texts), estimates=draw(texts),
                film_size=draw(st.none() | st.tuples(sides, sides)))


@given(prescriptions())
@settings(max_examples=150)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    assert lenses.save(lens, path) == ()
    assert lenses.load(path) == lens


@pytest.mark.parametrize("name", EVERY)
def test_a_library_lens_survives_scaling_saving_and_loading(tmp_path, name):
    lens = lenses.load(name).scaled(0.7351)
    lenses.save(lens, tmp_path / "scaled.toml")
    assert lenses.load(tmp_path / "scaled.toml") == lens


def test_a_conic_an_asphere_and_a_cylinder_are_read_as_they_are_written(tmp_path):
    lens = load_text(tmp_path, SHAPED)
    assert lens.surfaces[0] == Surface(4.0, 10.0, Glass(1.5), curvature=0.02, conic=-1.5,
                                       aspheric=((4, 1e-5), (7, -2.5e-9)))
    assert lens.surfaces[1] == Surface(3.0, 10.0, curvature=0.0, curvature_x=0.04)
    assert lens.surfaces[3] == Surface(40.0, 9.0, curvature=-0.02, curvature_x=0.0)


def test_the_blades_of_the_stop_are_kept_and_may_be_turned_in_degrees(tmp_path):
    lens = replace(load_text(tmp_path, ROWS), blades=9, blade_rotation=0.1, roundness=0.25)
    assert lenses.save(lens, tmp_path / "bladed.toml") == ()
    assert lenses.load(tmp_path / "bladed.toml") == lens
    turned = load_text(tmp_path, ROWS + "[stop]\nblades = 5\nrotation_deg = 36\n")
    assert (turned.blades, turned.roundness) == (5, 0.0) and turned.blade_rotation == pytest.approx(math.pi / 5)
    wet = replace(lens, front_index=1.333)
    assert lenses.save(wet, tmp_path / "wet.toml") == () and lenses.load(tmp_path / "wet.toml") == wet
    for suffix in (".dat", ".zmx", ".seq"):
        remarks = lenses.save(wet, tmp_path / f"bladed{suffix}")
        assert any("circle of equal area" in str(remark) for remark in remarks)
        assert any("1.333" in str(remark) for remark in remarks)
    closed = lb.stopped_down(replace(lenses.load("pbrt-dgauss-50mm"), blades=5), 4.0)
    assert lenses.save(closed, tmp_path / "closed.toml") == () and lenses.load(tmp_path / "closed.toml") == closed
    assert "computed_f_number = 4.0\n" in (tmp_path / "closed.toml").read_text()
    for suffix in (".zmx", ".seq", ".len", ".json", ".dat"):        # a round stop of as much area
        lenses.save(closed, tmp_path / f"closed{suffix}")
        assert lb.first_order(lenses.load(tmp_path / f"closed{suffix}")).f_number == pytest.approx(4.0, rel=1e-6)
    with pytest.raises(lenses.LensFileError, match="before the lens"):
        load_text(tmp_path, ROWS.replace("units", "front_index = 0.5\nunits"))


@pytest.mark.parametrize(("table", "reason"), [
    ("blades = 2", "3 to 24"), ("blades = 5.5", "3 to 24"), ("roundness = 2", "between 0"), ("edges = 5", "table"),
    ("rotation = 1\nrotation_deg = 2", "not both"), ('blades = "many"', "number")])
def test_an_invalid_stop_is_refused_with_its_line(tmp_path, table, reason):
    with pytest.raises(lenses.LensFileError) as caught:
        load_text(tmp_path, ROWS + "[stop]\n" + table + "\n")
    assert caught.value.line == ROWS.count("\n") + 1 and reason in caught.value.reason


def test_the_formula_of_a_glass_survives(tmp_path):
    glass = Glass(1.5168, 64.17, "N-BK7", "sellmeier",
                  (1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653), (0.3, 2.5))
    lens = Lens((Surface(4.0, 10.0, glass, curvature=0.02), Surface(40.0, 10.0, curvature=-0.02)), 0)
    lenses.save(lens, tmp_path / "glass.toml")
    assert lenses.load(tmp_path / "glass.toml") == lens


@pytest.mark.parametrize("name", EVERY)
def test_a_library_file_is_written_as_it_stands(tmp_path, name):
    # of a file without what came later not a byte changes
    lenses.save(lenses.load(name), tmp_path / "again.toml")
    again = (tmp_path / "again.toml").read_text(encoding="utf-8")
    shipped = lenses.library.catalogue.path_of(name).read_text(encoding="utf-8")
    left_out = {"image_circle", "computed_efl", "computed_f_number"}
    assert ([line for line in again.split("\n") if line.split(" =")[0] not in left_out]
            == [line for line in shipped.split("\n") if line.split(" =")[0] not in left_out])


def test_a_plane_is_radius_zero_or_inf_and_the_stop_is_marked(tmp_path):
    lens = load_text(tmp_path, ROWS)
    assert lens.surfaces[1].curvature == lens.surfaces[2].curvature == 0.0
    assert lens.stop_index == 2 and lens.name == "Two lenses" and not lens.findings
    assert lens.surfaces[0] == Surface(4.0, 10.0, Glass(1.5), curvature=0.02)


def test_an_immense_radius_is_no_trouble(tmp_path):
    lens = load_text(tmp_path, ROWS.replace("[50.0,", "[1e9,"))
    assert lens.surfaces[0].curvature == 1e-9


def test_columns_may_be_in_any_order(tmp_path):
    names = '"radius", "thickness", "n_d", "semi_diameter"'
    text = ROWS.replace(names, '"n_d", "radius", "semi_diameter", "thickness"')
    for old, new in (("50.0, 4.0, 1.5, 10.0", "1.5, 50.0, 10.0, 4.0"), ("inf, 3.0, 1.0, 10.0", "1, inf, 10.0, 3.0"),
                     ("0, 2.0, 1.0, 8.0", "1.0, 0, 8.0, 2.0"), ("-50.0, 40.0, 1.0, 9.0", "1.0, -50.0, 9.0, 40.0")):
        text = text.replace(old, new)
    assert load_text(tmp_path, text) == load_text(tmp_path, ROWS)


def test_without_a_stop_the_smallest_rim_limits_with_a_finding(tmp_path):
    lens = load_text(tmp_path, ROWS.replace(', "stop"', ""))
    assert lens.stop_index == 2
    assert len(lens.findings) == 1 and "no stop" in lens.findings[0].message and "surface 2" in lens.findings[0].message


def test_of_two_stops_the_one_that_limits_the_axial_beam_is_the_stop(tmp_path):
    # the beam has 0.94 of its height at the second stop: a rim of 8 there limits, one of 9.9 leaves it to the 10
    two = ROWS.replace("[50.0, 4.0, 1.5, 10.0]", '[50.0, 4.0, 1.5, 10.0, "stop"]')
    lens = load_text(tmp_path, two)
    assert lens.stop_index == 2 and "2 stops" in lens.findings[0].message
    wide = two.replace("[0, 2.0, 1.0, 8.0,", "[0, 2.0, 1.0, 9.9,")
    assert load_text(tmp_path, wide).stop_index == 0


MISTAKES = {
    "too few columns": ("[50.0, 4.0, 1.5, 10.0]", "[50.0, 4.0, 1.5]", 6, "3 values"),
    "too many columns": ("[50.0, 4.0, 1.5, 10.0]", "[50.0, 4.0, 1.5, 10.0, 7.0]", 6, "5 values"),
    "nan": ("[50.0, 4.0,", "[50.0, nan,", 6, "thickness is nan"),
    "infinite gap": ("[inf, 3.0,", "[inf, inf,", 7, "thickness is inf"),
    "nan radius": ("[-50.0,", "[nan,", 9, "radius is nan"),
    "negative rim": ("1.0, 9.0]", "1.0, -9.0]", 9, "must be positive"),
    "no rim": ("1.0, 9.0]", "1.0, 0]", 9, "must be positive"),
    "index below one": ("4.0, 1.5,", "4.0, 0.9,", 6, "at least 1"),
    "text for a number": ("[50.0, 4.0,", '[50.0, "thick",', 6, "must be a number"),
    "truth for a number": ("[50.0, 4.0,", "[50.0, true,", 6, "must be a number"),
    "radius too small": ("[50.0,", "[1e-9,", 6, "radius"),
    "immense number": ("[50.0, 4.0,", "[50.0, 1e999,", 6, "finite"),
    "row without brackets": ("[inf, 3.0, 1.0, 10.0]", "7", 7, "brackets"),
    "unknown column": ('"n_d", ', '"n_e", ', 4, "'n_e' is unknown"),
    "missing column": ('"n_d", ', "", 4, "one column 'n_d'"),
    "unknown key": ("title", "tilte", 2, "'tilte' is unknown"),
    "unit": ('"mm"', '"inch"', 3, "units"),
    "title of the wrong type": ('"Two lenses"', "7", 2, "title must be a text"),
    "maker of the wrong type": ('units = "mm"', "maker = 3", 3, "maker must be a text"),
    "film of one side": ('units = "mm"', "film_size = [36]", 3, "a width and a height"),
    "film of nested sides": ('units = "mm"', "film_size = [[36], 24]", 3, "film_size"),
    "film without height": ('units = "mm"', "film_size = [36, 0]", 3, "film_size"),
    "counts of the wrong type": ('units = "mm"', "counts = { elements = 1.5 }", 3, "whole numbers"),
    "an unknown count": ('units = "mm"', "counts = { lenses = 2 }", 3, "whole numbers"),
    "later format": ("format = 1", "format = 9", 1, "format 9"),
    "syntax": ("columns = [", "columns = ]", 4, "not valid TOML"),
    "broken off": ("    [-50.0, 40.0, 1.0, 9.0],\n]\n", "    [-50.0, 40", 9, "breaks off"),
    "no surfaces": (ROWS[ROWS.index("surfaces"):], "", None, "no surfaces"),
}


SHAPED_MISTAKES = {
    "conic that is none": ("-1.5]", "nan]", 4, "conic is nan"),
    "no such surface": ("3 = inf", "4 = inf", 15, "no surface '4'"),
    "a surface by name": ("3 = inf", "three = inf", 15, "no surface 'three'"),
    "a surface twice": ("3 = inf", "01 = inf", 15, "surface 1 is listed twice"),
    "radius across that is none": ("1 = 25", "1 = nan", 14, "radius is nan"),
    "power that is none": ("r7 =", "x7 =", 11, "'x7' is no power"),
    "power too high": ("r7 =", "r70 =", 4, "power 70"),
    "coefficient that is none": ("-2.5e-9", "nan", 11, "r7 is nan"),
    "terms without names": ("{ r4 = 1e-5, r7 = -2.5e-9 }", "[1e-5]", 11, "written {"),
    "table that is none": ("[aspheric]\n0 = { r4 = 1e-5, r7 = -2.5e-9 }", "aspheric = 3", 10, "must be a table"),
    "both across and aspheric": ("1 = 25", "0 = 25", 4, "curvature_x"),
}


@pytest.mark.parametrize("mistake", SHAPED_MISTAKES)
def test_a_mistake_in_a_shape_names_its_line(tmp_path, mistake):
    old, new, line, reason = SHAPED_MISTAKES[mistake]
    assert old in SHAPED
    with pytest.raises(lenses.LensFileError) as caught:
        load_text(tmp_path, SHAPED.replace(old, new))
    assert caught.value.line == line and reason in caught.value.reason


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_clear_line_with_its_place(tmp_path, mistake):
    old, new, line, reason = MISTAKES[mistake]
    assert old in ROWS
    with pytest.raises(lenses.LensFileError) as caught:
        load_text(tmp_path, ROWS.replace(old, new))
    error = caught.value
    assert error.line == line and reason in error.reason and "\n" not in str(error)
    assert error.path == str(tmp_path / "lens.toml") and str(error).startswith(error.path)


def load_text(folder, text):
    path = folder / "lens.toml"
    path.write_text(text, encoding="utf-8")
    return lenses.load(path)


COATED = ROWS + """
[coating]
0 = "multi-layer"
1 = { layers = [[1.38, 0.25], [2.05, 0.5], ["matched", 0.25]], wavelength = 0.53 }
3 = { wavelengths = [0.45, 0.65], angles_deg = [0.0, 40.0], reflectances = [[0.004, 0.01], [0.003, 0.009]] }
"""


def test_coatings_are_kept_to_the_last_bit_and_other_formats_say_that_they_leave_them_out(tmp_path):
    (tmp_path / "a.toml").write_text(COATED)
    lens = lenses.load(tmp_path / "a.toml")
    first, second, stop, last = (surface.coating for surface in lens.surfaces)
    assert first == lb.COATINGS["multi-layer"] and stop is None
    assert second.layers[2].n is None and second.wavelength == 0.53
    assert last.angles[1] == math.radians(40.0) and last.reflectances[1][0] == 0.003
    odd = replace(lens, surfaces=(replace(lens.surfaces[0], coating=replace(last, angles=(0.0, 0.7))),
                                  *lens.surfaces[1:]))
    for variant in (lens, odd):
        assert not lenses.save(variant, tmp_path / "b.toml") and lenses.load(tmp_path / "b.toml") == variant
    assert any("coatings of 3 of 4 surfaces" in finding.message for finding in lenses.save(lens, tmp_path / "c.len"))


@pytest.mark.parametrize(("entry", "message"), [
    ('"gold"', "is no coating"), ("{ layers = [[1.38]] }", "a layer is its index"),
    ("{ layers = [[0.2, 0.25]] }", "must lie between 1 and 10"), ("{}", "a coating is a name"),
    ("{ wavelengths = [0.5], reflectances = [[2.0]] }", "from 0 to 1|between 0 and 1"),
    ("{ wavelengths = [0.5], angles = [0.0], angles_deg = [0.0], reflectances = [[0.1]] }", "not both")])
def test_a_wrong_coating_names_its_line(tmp_path, entry, message):
    (tmp_path / "a.toml").write_text(f"{ROWS}[coating]\n1 = {entry}\n")
    with pytest.raises(lenses.LensFileError, match=message) as caught:
        lenses.load(tmp_path / "a.toml")
    assert caught.value.line == ROWS.count("\n") + 2


POSED = ROWS + """
[pose]
1 = { decentre_y = 0.5, tilt_x_deg = 2.0 }
2 = { tilt_y = 0.1, pivot = 1 }
"""


def test_a_pose_is_read_in_radians_or_degrees_and_a_mistake_names_its_line():
    poses = [surface.pose for surface in lenses.READERS[".toml"](POSED, "x.toml").surfaces]
    assert poses == [None, SurfacePose(0.0, 0.5, math.radians(2.0)), SurfacePose(tilt_y=0.1, pivot=1), None]
    for wrong, said in (("tilt_x_deg = 90.0", "tilt_x 90° of a surface"), ("tilt_x = nan", "NaN|nan|finite"),
                        ("pivot = 3", "surface 1 pivots about the vertex of surface -2"), ("tip = 1", "tilt_x_deg")):
        with pytest.raises(lenses.LensFileError, match=said) as caught:
            lenses.READERS[".toml"](POSED.replace("tilt_x_deg = 2.0", wrong), "x.toml")
        assert caught.value.line == POSED.split("\n").index("1 = { decentre_y = 0.5, tilt_x_deg = 2.0 }") + 1


@pytest.mark.parametrize("stop", [{"blades": 7, "blade_reach": 1.05}, {"blades": 5, "blade_reach": 1.0}, {"blades": 5},
                                  {"blade_reach": 1.2}])
def test_the_reach_of_blades_loads_equal(stop, tmp_path):
    lens = replace(lenses.load("pbrt-dgauss-50mm"), **stop)
    lenses.save(lens, tmp_path / "a.toml")
    assert lenses.load(tmp_path / "a.toml").iris == lens.iris
