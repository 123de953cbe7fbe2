"""Broken axes of Zemax and CODE V files: the conventions of each program, read as poses about one line."""

from math import radians

import pytest

from lensbench import lenses
from lensbench.lenses import READERS

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


@pytest.mark.parametrize(("breaks", "said"), [
    (("PARM 3 10", "PARM 3 0"), "does not return to its line before the image"), (("PARM 3 90", "PARM 3 -90"), "90°"),
    (("PARM 3 70", "PARM 3 -70; PARM 6 1"), "from −60° to 60°"), (("PARM 1 1e9", "PARM 1 -1e9"), "−10 m to 10 m"),
    (("PARM 3 nan", "PARM 3 0"), "nan")])
def test_axes_that_no_lens_has_are_refused_in_a_line(breaks, said):
    with pytest.raises(lenses.LensFileError, match=said):
        zemax(f"TYPE COORDBRK; DISZ 0; {breaks[0]}", FRONT, REAR.format(gap=-3), f"TYPE COORDBRK; DISZ 43; {breaks[1]}",
              IMAGE)


def codev(*lines):
    text = ["RDM N", "EPD 4", "SO 0 1e13", "S 0.02 3 1.5", "  CIR 5", "STO", *lines]
    return READERS[".seq"]("\n".join(text), "x.seq")


def test_codev_tilts_are_left_handed_and_return_with_dar():
    lens = codev("  ADE 10; BDE 5; XDE 0.3; DAR", "S -0.02 40", "  CIR 5", "SI")
    pose = lens.surfaces[0].pose
    assert pose.tilt_x < 0.0 and pose.tilt_y == pytest.approx(radians(-5.0), rel=0.02) and pose.decentre_x == 0.3
    assert lens.surfaces[1].pose is None and lens.length == pytest.approx(3.0)
    alone = codev("  ADE 10; DAR", "S -0.02 40", "  CIR 5", "SI").surfaces[0].pose
    assert alone.tilt_x == pytest.approx(radians(-10.0)) and alone.tilt_y == 0.0


def test_codev_groups_tilt_and_go_back():
    lens = codev("  ADE 10; YDE 0.5", "S -0.02 -3", "  CIR 5", "S 0 43", "  CIR 9", "  ADE 10; YDE 0.5; REV", "SI")
    assert lens.surfaces[1].pose.pivot == 1 and lens.surfaces[0].pose.decentre_y == 0.5
    assert lens.surfaces[-1].thickness + lens.length == pytest.approx(43.0, abs=1.0)
    with pytest.raises(lenses.LensFileError, match="does not return"):
        codev("  ADE 10", "S -0.02 40", "  CIR 5", "SI")
    with pytest.raises(lenses.LensFileError, match="mirror bend"):
        codev("  ADE 10; BEN", "S -0.02 40", "  CIR 5", "SI")
