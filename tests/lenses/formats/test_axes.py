"""Broken axes of Zemax and CODE V files: the conventions of each program, read as poses about one line."""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses import READERS, WRITERS
from lensbench.lenses.editing.elements import body_at

HEAD = "MODE SEQ\nUNIT {unit}\nENPD 4\nSURF 0\n  TYPE STANDARD\n  DISZ INFINITY\n"
GLASS = "  GLAS ___BLANK 1 0 1.5 60 0 0 0 0 0 0\n"


def zemax(*blocks, unit="MM"):
    text = HEAD.format(unit=unit)
    for i, block in enumerate(blocks, start=1):
        text += f"SURF {i}\n" + "".join(f"  {line}\n" for line in block.split("; "))
    return READERS[".zmx"](text, "x.zmx")


FRONT = "TYPE STANDARD; STOP; CURV 0.02; DISZ 3; GLAS ___BLANK 1 0 1.5 60 0 0 0 0 0 0; DIAM 5"
REAR = "TYPE STANDARD; CURV -0.02; DISZ {gap}; DIAM 5"
IMAGE = "TYPE STANDARD; CURV 0; DISZ 0"


def test_a_zemax_element_tilts_between_two_breaks_right_handed():
    lens = zemax("TYPE STANDARD; CURV 0; DISZ 7; DIAM 6", "TYPE COORDBRK; DISZ 0; PARM 1 0.2; PARM 2 0.4; PARM 3 10",
                 FRONT, REAR.format(gap=-3), "TYPE COORDBRK; DISZ 43; PARM 1 -0.2; PARM 2 -0.4; PARM 3 -10; PARM 6 1",
                 IMAGE)
    pose = lens.surfaces[1].pose
    assert (pose.decentre_x, pose.decentre_y, pose.tilt_y) == (0.2, 0.4, 0.0)
    assert pose.tilt_x == pytest.approx(radians(10.0))
    assert lens.surfaces[2].pose.pivot == 1 and lens.surfaces[0].pose is None
    assert [s.thickness for s in lens.surfaces] == pytest.approx([7.0, 3.0, 40.0], abs=1e-12)


def test_inches_scale_a_decentre():
    lens = zemax("TYPE COORDBRK; DISZ 0; PARM 1 0.1", FRONT, REAR.format(gap=0), "TYPE COORDBRK; DISZ 1; PARM 1 -0.1",
                 IMAGE, unit="IN")
    assert lens.surfaces[0].pose.decentre_x == pytest.approx(2.54)


@pytest.mark.parametrize(("breaks", "said", "surface"), [
    (("PARM 3 10", "PARM 3 0; PARM 1 0.1"), "does not return to its line before the image", 4),
    (("PARM 3 90", "PARM 3 -90"), "90°", 1), (("PARM 3 70", "PARM 3 -70; PARM 6 1"), "from −60° to 60°", 1),
    (("PARM 1 1e5", "PARM 1 -1e5"), "−10 m to 10 m", 1), (("PARM 1 1e9", "PARM 1 -1e9"), "lost in the rounding", 1)])
def test_axes_that_no_lens_has_are_refused_at_the_line_of_their_break(breaks, said, surface):
    blocks = (f"TYPE COORDBRK; DISZ 0; {breaks[0]}", FRONT, REAR.format(gap=-3), f"TYPE COORDBRK; DISZ 43; {breaks[1]}",
              IMAGE)
    with pytest.raises(lenses.LensFileError, match=said) as caught:
        zemax(*blocks)
    assert caught.value.line == HEAD.count("\n") + 1 + sum(2 + block.count("; ") for block in blocks[:surface - 1])


def test_a_decentre_beyond_the_limit_in_mm_names_its_surface():
    with pytest.raises(lenses.LensFileError, match="surface 0: decentre_x 11000 mm") as caught:
        zemax("TYPE COORDBRK; DISZ 0; PARM 1 11", FRONT, REAR.format(gap=0), "TYPE COORDBRK; DISZ 1; PARM 1 -11", IMAGE,
              unit="METER")
    assert caught.value.line


def configured(*blocks, configurations):
    """A Zemax lens of these blocks and lines of configurations."""
    text = HEAD.format(unit="MM") + "".join(f"SURF {i}\n" + "".join(f"  {line}\n" for line in block.split("; "))
                                            for i, block in enumerate(blocks, start=1))
    return READERS[".zmx"](text + "\n".join(configurations), "x.zmx"), text


def test_breaks_keep_their_pose_in_every_position_and_the_ways_behind_them_vary():
    """The element moves by 1 mm between two breaks: both gaps beside it change, of which one is that of a break."""
    blocks = ("TYPE STANDARD; CURV 0; DISZ 7; DIAM 6", "TYPE COORDBRK; DISZ 0; PARM 2 0.4; PARM 3 10", FRONT,
              REAR.format(gap=-3), "TYPE COORDBRK; DISZ 43; PARM 2 -0.4; PARM 3 -10; PARM 6 1", IMAGE)
    lens, _ = configured(*blocks, configurations=("MNUM 2 1", "THIC 1 1 7", "THIC 1 2 8", "THIC 5 1 43", "THIC 5 2 42"))
    assert lens.positions.gaps == (0, 2)
    for position, gaps in enumerate(([7.0, 3.0, 40.0], [8.0, 3.0, 39.0])):
        moved = lens.at(zoom=float(position))
        assert [s.thickness for s in moved.surfaces] == pytest.approx(gaps, abs=1e-12)
        assert moved.vertex(1) == pytest.approx([0.0, 0.4, gaps[0]], abs=1e-12)
        assert moved.frames[1].rotation == pytest.approx(lens.frames[1].rotation)
        assert moved.frames[2] is moved.frames[1]


def test_a_decentre_that_comes_with_a_gap_is_refused_at_its_break():
    """Between two tilted breaks a longer way moves the element sideways: no pose that all positions have."""
    blocks = ("TYPE COORDBRK; DISZ 5; PARM 3 10", FRONT, REAR.format(gap=-8),
              "TYPE COORDBRK; DISZ 43; PARM 3 -10; PARM 6 1", IMAGE)
    with pytest.raises(lenses.LensFileError, match="position 2 has other tilts or decentres than the first") as caught:
        configured(*blocks, configurations=("MNUM 2 1", "THIC 1 1 5", "THIC 1 2 6", "THIC 3 1 -8", "THIC 3 2 -9"))
    assert caught.value.line
    lens, _ = configured(*blocks, configurations=("MNUM 2 1", "THIC 4 1 43", "THIC 4 2 44"))
    assert lens.positions.thicknesses[1][0][0] - lens.positions.thicknesses[0][0][0] == pytest.approx(1.0)


def zoom_lens():
    return lenses.load("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed")


def bent(lens, first, last, **pose):
    return replace(lens, surfaces=tuple(
        replace(s, pose=lb.SurfacePose(**pose, pivot=i - first)) if first <= i <= last else s
        for i, s in enumerate(lens.surfaces)))


@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".toml"])
@pytest.mark.parametrize("spans", [False, True])
def test_a_zoom_lens_tilted_is_written_in_all_its_positions(suffix, spans, tmp_path):
    """The group between two varying gaps, or a body with such a gap within it, against rays of each position."""
    lens = zoom_lens()
    first, gap = lens.positions.gaps[0] + 1, lens.positions.gaps[1]
    last = gap + 1 if spans else gap
    lens = bent(lens, first, last, decentre_x=0.2, decentre_y=-0.1, tilt_x=0.01, tilt_y=-0.02)
    lost = lenses.save(lens, tmp_path / f"zoom{suffix}")
    read = lenses.load(tmp_path / f"zoom{suffix}")
    if suffix == ".seq" and spans:
        assert read.positions is None and any(
            f"surface {gap + 1} is tilted about another one, and the gap between them varies" in remark.message
            for remark in lost)
        return
    assert not any("left out: its zoom" in remark.message or "left out: with" in remark.message for remark in lost)
    origins = np.column_stack([np.linspace(-8.0, 9.0, 12), np.linspace(5.0, -6.0, 12), np.full(12, -10.0)])
    ways = np.tile([0.01, -0.02, 1.0], (12, 1))
    for zooms in zip(lens.positions.zoom_stations, read.positions.zoom_stations, strict=True):
        expected, traced = (lb.trace(variant.at(zoom=zoom), origins, ways, clip=False)
                            for variant, zoom in zip((lens, read), zooms, strict=True))
        assert np.isfinite(expected.points).all()
        assert traced.points == pytest.approx(expected.points, abs=1e-8)
        assert traced.directions == pytest.approx(expected.directions, abs=1e-10)


def test_a_body_of_a_zoom_lens_moves_with_its_gaps():
    """At every position, the tilted lens is the lens of that position, alone, tilted."""
    lens = zoom_lens()
    first, last = lens.positions.gaps[0] + 1, lens.positions.gaps[1]
    pose = {"decentre_x": 0.2, "tilt_y": 0.03}
    for zoom in (0.0, 0.37, 1.0):
        alone = bent(replace(lens.at(zoom=zoom), positions=None), first, last, **pose)
        there = bent(lens, first, last, **pose).at(zoom=zoom)
        assert replace(there, positions=None) == alone
        for one, two in zip(there.frames, alone.frames, strict=True):
            assert (one is None) == (two is None) and (one is None or np.array_equal(one.shift, two.shift))


def test_a_tilt_among_the_properties_of_a_surface_is_refused_at_its_line():
    still, tilted = (f"SCBD 1 0 0 0.0 0.0 {angle} 0.0 0.0" for angle in ("0.0", "9.0E+00"))
    lens = zemax(FRONT, f"{REAR.format(gap=40)}; {still}", IMAGE)
    assert lens.is_centred and not any("SCBD" in finding.message for finding in lens.findings)
    with pytest.raises(lenses.LensFileError, match=r"SURF 2: a tilt or decentre .*\(SCBD\) is not read") as caught:
        zemax(FRONT, f"{REAR.format(gap=40)}; {tilted}", IMAGE)
    assert caught.value.line == HEAD.count("\n") + 2 + FRONT.count("; ") + 2 + 4


def test_a_stop_on_a_coordinate_break_is_named():
    lens = zemax("TYPE COORDBRK; STOP; DISZ 0; PARM 1 0.1", FRONT.replace("STOP; ", ""), REAR.format(gap=0),
                 "TYPE COORDBRK; DISZ 1; PARM 1 -0.1", IMAGE)
    assert any("SURF 1: the stop is marked on a coordinate break" in finding.message for finding in lens.findings)


def test_an_image_far_behind_an_afocal_lens_hides_no_decentre():
    lens = codev("  XDE 0.3; DAR", "S -0.02 1e13", "  CIR 5", "SI")
    assert lens.surfaces[0].pose.decentre_x == 0.3


def about(axis, degrees, axes):
    """Axes (3, 3), rows, after a right-handed turn about one of themselves: Rodrigues' formula."""
    k, t = axes[axis], radians(degrees)
    return np.array([v * cos(t) + np.cross(k, v) * sin(t) + k * (k @ v) * (1.0 - cos(t)) for v in axes])


def assert_stands(lens, i, vertex, axes):
    """Surface i has this vertex and this axis, which its pose gives a point of the axis 1 mm behind the vertex."""
    frame, z = lens.frames[i], lens.vertices[i]
    placed = np.array([0.0, 0.0, z]) if frame is None else frame.at(z)
    ahead = np.array([0.0, 0.0, z + 1.0]) if frame is None else frame.at(z + 1.0)
    assert placed == pytest.approx(vertex, abs=1e-9) and ahead - placed == pytest.approx(axes[2], abs=1e-9)


def test_breaks_of_zemax_are_right_handed_turns_after_the_decentre_or_in_reverse_before_it():
    """By the help of OpticStudio: decentre, tilts about x, y, z; with order 1 about z, y, x, and then the decentre.

    The second break returns by the same numbers with their signs changed.
    """
    lens = zemax("TYPE STANDARD; CURV 0; DISZ 7; DIAM 6",
                 "TYPE COORDBRK; DISZ 2; PARM 1 0.2; PARM 2 -0.4; PARM 3 10; PARM 4 -20; PARM 5 30", FRONT,
                 REAR.format(gap=-5),
                 "TYPE COORDBRK; DISZ 9; PARM 1 -0.2; PARM 2 0.4; PARM 3 -10; PARM 4 20; PARM 5 -30; PARM 6 1", IMAGE)
    axes, vertex = np.eye(3), np.array([0.2, -0.4, 7.0])
    for axis, degrees in ((0, 10.0), (1, -20.0), (2, 30.0)):
        axes = about(axis, degrees, axes)
    assert about(0, 10.0, np.eye(3))[1, 2] > 0.0                # right-handed about x: y turns towards z
    assert_stands(lens, 0, (0.0, 0.0, 0.0), np.eye(3))
    assert_stands(lens, 1, vertex + 2.0 * axes[2], axes)
    assert_stands(lens, 2, vertex + 5.0 * axes[2], axes)
    assert lens.length + lens.surfaces[-1].thickness == pytest.approx(7.0 + 9.0, abs=1e-9)      # the centred image


def test_a_break_of_zemax_with_order_1_tilts_first():
    """Forwards with order 1; back, by the inverse, with order 0."""
    lens = zemax("TYPE COORDBRK; DISZ 0; PARM 1 0.2; PARM 2 -0.4; PARM 3 10; PARM 4 -20; PARM 5 30; PARM 6 1", FRONT,
                 REAR.format(gap=-3),
                 "TYPE COORDBRK; DISZ 9; PARM 1 -0.2; PARM 2 0.4; PARM 3 -10; PARM 4 20; PARM 5 -30", IMAGE)
    axes = np.eye(3)
    for axis, degrees in ((2, 30.0), (1, -20.0), (0, 10.0)):
        axes = about(axis, degrees, axes)
    vertex = 0.2 * axes[0] - 0.4 * axes[1]
    shift = [0.0, 0.0, lens.vertex(0)[2] - vertex[2]]            # a lens begins at z = 0
    assert_stands(lens, 0, vertex + shift, axes)
    assert_stands(lens, 1, vertex + 3.0 * axes[2] + shift, axes)


def codev(*lines):
    text = ["RDM N", "EPD 4", "SO 0 1e13", "S 0.02 3 1.5", "  CIR 5", "STO", *lines]
    return READERS[".seq"]("\n".join(text), "x.seq")


def by_code_v(ade, bde, cde):
    """Axes after the tilts of CODE V: left-handed about x and y, right-handed about z, each about the turned axis."""
    axes = about(0, -ade, np.eye(3))
    return about(2, cde, about(1, -bde, axes))


def test_a_surface_of_codev_with_dar_alone_is_placed_by_its_turns():
    lens = codev("  ADE 10; BDE 5; XDE 0.3; ZDE 0.2; DAR", "S -0.02 40", "  CIR 5", "SI")
    axes = by_code_v(10.0, 5.0, 0.0)
    assert axes[2, 1] > 0.0 and axes[2, 0] < 0.0        # left-handed: ADE turns the axis z up, BDE towards −x
    assert_stands(lens, 0, (0.3, 0.0, lens.vertex(0)[2]), axes)
    assert_stands(lens, 1, (0.0, 0.0, lens.length), np.eye(3))
    assert lens.length == pytest.approx(3.0 - 0.2)      # from the first vertex
    assert lens.surfaces[-1].thickness == pytest.approx(40.0)


def test_groups_of_codev_tilt_and_go_back():
    lens = codev("  ADE 10; BDE -7; CDE 20; YDE 0.5", "S -0.02 -3", "  CIR 5", "S 0 43", "  CIR 9",
                 "  ADE 10; BDE -7; CDE 20; YDE 0.5; REV", "SI")
    axes, vertex = by_code_v(10.0, -7.0, 20.0), np.array([0.0, 0.5, 0.0])
    for i, way in enumerate((0.0, 3.0, 0.0)):
        assert_stands(lens, i, vertex + way * axes[2], axes)
    assert lens.surfaces[-1].thickness + lens.length == pytest.approx(43.0, abs=1e-9)


@pytest.mark.parametrize(("lines", "said", "line"), [
    (["  ADE 10", "S -0.02 40", "  CIR 5", "SI"], "does not return", 7),
    (["  ADE 10; BEN", "S -0.02 40", "  CIR 5", "SI"], "mirror bend", 7),
    (["  CIR 5", "  ADE 70; DAR", "S -0.02 40", "  CIR 5", "SI"], "from −60° to 60°", 8),
    (["S -0.02 40", "  CIR 5", "SI", "  XDE 1"], "of the object or of the image", 10)])
def test_what_codev_tilts_cannot_be_is_refused_at_their_line(lines, said, line):
    with pytest.raises(lenses.LensFileError, match=said) as caught:
        codev(*lines)
    assert caught.value.line == line


def test_commands_of_codev_for_a_range_of_surfaces_set_each_of_them():
    lens = codev("S -0.02 40", "  CIR 5", "SI", "CIR S1..2 4.5", "XDE S1..2 0.3", "DAR S1..2")
    assert [s.semi_diameter for s in lens.surfaces[1:]] == [4.5] and body_at(lens, 0) == (0, 1)
    assert [lens.vertex(i)[0] for i in range(2)] == [0.3, 0.3]


@pytest.mark.parametrize(("command", "said"), [
    ("CIR SA 4", "CIR: 'SA' is not read"), ("CIR S2..1 4", "is no range of surfaces"), ("XDE S9 1", "no surface 9"),
    ("ADE S1..9 5", "no surface 4"), ("CIR S1..X 4", "is no range of surfaces")])
def test_commands_of_codev_for_surfaces_that_are_none_are_refused(command, said):
    with pytest.raises(lenses.LensFileError, match=said):
        codev("S -0.02 40", "  CIR 5", "SI", command)


CROSSED = lb.Lens((lb.Surface(4.0, 9.0, lb.Glass(1.6), curvature=1 / 40.0),
                   lb.Surface(3.0, 9.0, curvature=0.01, curvature_x=-1 / 55.0),
                   lb.Surface(2.0, 9.0, lb.Glass(1.5), curvature=0.0, curvature_x=1 / 70.0),
                   lb.Surface(40.0, 9.0, curvature=0.0)), 0)


@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".toml"])
@pytest.mark.parametrize("pose", [{"roll": 0.3}, {"roll": -2.0, "decentre_x": 0.4, "tilt_x": 0.1, "tilt_y": -0.2}])
def test_rolled_cylinders_are_written_with_their_element_and_read_with_the_same_rays(suffix, pose):
    """A body with a toroid, and a cylinder with a roll of its own, against rays in all directions across the axis."""
    lens = bent(bent(CROSSED, 0, 1, **pose), 2, 2, roll=0.7)
    text, lost = WRITERS[suffix](lens)
    read = READERS[suffix](text, "x" + suffix)
    assert body_at(read, 0) == (0, 1) and not any("another lens" in remark.message for remark in lost)
    assert read.surfaces[1].pose.roll == pytest.approx(pose["roll"], abs=1e-9)
    assert read.surfaces[0].pose.roll == read.surfaces[1].pose.roll and read.surfaces[3].pose is None
    turns = np.linspace(0.0, 6.0, 40)
    origins = np.column_stack([5.0 * np.cos(turns), 5.0 * np.sin(turns), np.full(40, -9.0)])
    assert lb.trace(read, origins, [0.0, 0.1, 1.0]).directions == pytest.approx(
        lb.trace(lens, origins, [0.0, 0.1, 1.0]).directions, abs=1e-9, nan_ok=True)


def test_a_roll_of_codev_is_right_handed_and_turns_a_cylinder_alone():
    lens = codev("  CDE 20; DAR", "S -0.02 40", "  AAS", "  CUX 0.0", "  CIR 5", "  CDE 30; DAR", "SI")
    assert lens.surfaces[0].pose is None                        # round, and no body with the cylinder
    assert replace(lens.surfaces[1].pose, roll=0.0).is_centred
    assert lens.surfaces[1].pose.roll == pytest.approx(radians(30.0), abs=1e-12)


def test_the_object_of_a_lens_whose_first_surface_pivots_about_the_second_keeps_its_distance():
    pose = lb.SurfacePose(tilt_x=0.2)
    lens = lb.Lens((lb.Surface(6.0, 5.0, lb.Glass(1.5), curvature=0.02, pose=replace(pose, pivot=-1)),
                    lb.Surface(40.0, 5.0, curvature=-0.02, pose=pose)), 0,
                    system=lb.SystemData(object_distances=(200.0,)))
    for suffix in (".zmx", ".seq"):
        read_lens = READERS[suffix](WRITERS[suffix](lens)[0], "x" + suffix)
        distance = read_lens.system.object_distances[0] + read_lens.vertex(1)[2]
        assert distance == pytest.approx(200.0 + 6.0, abs=1e-9), suffix


def test_positions_that_move_a_body_sideways_are_left_out_of_zemax_files():
    """A pivot behind a varying gap: the first vertex of the body moves along the tilted axis."""
    lens = zoom_lens()
    gap = lens.positions.gaps[1]
    first, last = lens.positions.gaps[0] + 1, gap + 1
    lens = replace(lens, surfaces=tuple(
        replace(s, pose=lb.SurfacePose(tilt_x=0.02, pivot=i - last)) if first <= i <= last else s
        for i, s in enumerate(lens.surfaces)))
    text, lost = WRITERS[".zmx"](lens)
    assert any(f"left out: surface {first} is tilted about one behind it" in remark.message for remark in lost)
    read = READERS[".zmx"](text, "x.zmx")
    assert read.positions is None
    for i in range(len(lens.surfaces)):
        assert read.vertex(i) == pytest.approx(lens.at(zoom=0.0, close=0.0).vertex(i), abs=1e-9)


@pytest.mark.parametrize(("suffix", "first", "pivot", "last"), [
    (".zmx", 12, 14, 14), (".seq", 12, 14, 14), (".zmx", 6, 7, 8)])
def test_a_way_that_differs_by_rounding_is_no_varying_gap(suffix, first, pivot, last):
    """Ways back to the line are differences of heights that vary; surfaces 6 to 8 have a varying gap within them."""
    lens = lenses.load("canon-ef-ii-28-80-f35")
    pose = {"decentre_x": 0.2, "decentre_y": -0.1, "tilt_x": 0.02, "tilt_y": 0.01}
    lens = replace(lens, surfaces=tuple(
        replace(s, pose=lb.SurfacePose(**pose, pivot=i - pivot)) if first <= i <= last else s
        for i, s in enumerate(lens.surfaces)))
    read = READERS[suffix](WRITERS[suffix](lens)[0], "x" + suffix)
    assert read.positions.gaps == lens.positions.gaps
    assert read.positions.thicknesses[-1][-1][-1] == pytest.approx(lens.positions.thicknesses[-1][-1][-1], abs=1e-9)


@pytest.mark.parametrize("suffix", [".zmx", ".seq"])
def test_near_objects_keep_their_distance_from_the_film_before_a_front_that_pivots_about_its_rear(suffix):
    """The file has them from the vertex of the front, which the tilt moves back by 0.4 mm."""
    lens, pose = zoom_lens(), lb.SurfacePose(tilt_x=0.6)
    lens = replace(lens, surfaces=(replace(lens.surfaces[0], pose=replace(pose, pivot=-1)),
                                   replace(lens.surfaces[1], pose=pose), *lens.surfaces[2:]))
    read_lens = READERS[suffix](WRITERS[suffix](lens)[0], "x" + suffix)
    assert 1500.0 in lens.positions.distances[0]
    for expected, read in zip(lens.positions.distances, read_lens.positions.distances, strict=True):
        assert read == pytest.approx(expected, rel=1e-12)
