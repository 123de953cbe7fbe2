"""What a workshop refuses: thin edges, thin centres and steep surfaces, against geometry that is computed anew."""

import re
from dataclasses import replace
from math import asin, degrees, radians, sin

import pytest

from lensbench import Glass, Lens, Surface, lenses
from lensbench.app.session.edited_lens import original
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.finding import Kind, Severity
from lensbench.lenses.checks.geometry import CENTRE, EDGE, LEAST_EDGE, STEEPEST, has_estimated_clear_apertures

CROWN = Glass(1.5168, 64.17)


def singlet(front, back, thickness, semi, behind=20.0, **changes):
    """A lens of one element (radii in mm) with a stop behind it."""
    return Lens((Surface(thickness, semi, CROWN, curvature=1.0 / front, **changes),
                 Surface(behind, semi, curvature=1.0 / back),
                 Surface(60.0, 0.9 * semi, curvature=0.0)), 2)


def found(lens, kind):
    return [f for f in lenses.check(lens) if f.kind is kind and f.figures.keys() & {"edge", "centre", "slope"}]


def sphere(radius, height):
    return radius - (radius * radius - height * height) ** 0.5


def test_a_thin_edge_is_found():
    semi, radius = 8.0, 40.0
    thickness = 0.07 + 2.0 * sphere(radius, semi)                       # an edge of 0.07 mm
    (finding,) = found(singlet(radius, -radius, thickness, semi), Kind.EDGE)
    assert finding.figures["edge"] == pytest.approx(0.07, abs=1e-9) and finding.surface == 0
    assert finding.severity is Severity.WARNING
    assert not found(singlet(radius, -radius, thickness + 0.3, semi), Kind.EDGE)


def test_the_edge_of_an_asphere_includes_its_coefficients():
    semi, radius, r4 = 8.0, 40.0, 5e-5
    depth = r4 * semi**4                                                # 0.2 mm that the sphere does not have
    thickness = 0.07 + depth + 2.0 * sphere(radius, semi)
    lens = singlet(radius, -radius, thickness, semi, aspheric=((4, r4),))
    assert found(lens, Kind.EDGE)[0].figures["edge"] == pytest.approx(0.07, abs=1e-9)


def test_a_thin_centre_is_found_and_a_layer_of_resin_is_none():
    (finding,) = found(singlet(-60.0, 60.0, 0.3, 8.0), Kind.THICKNESS)
    assert finding.figures == {"centre": 0.3, "diameter": 16.0}
    assert not found(singlet(-60.0, 60.0, 0.4, 8.0), Kind.THICKNESS)
    doublet = singlet(-60.0, 60.0, 2.0, 8.0)
    layer = Surface(0.1, 8.0, Glass(1.52, 50.0, "resin"), curvature=-1.0 / 60.0)
    assert not found(replace(doublet, surfaces=(layer, *doublet.surfaces), stop_index=3), Kind.THICKNESS)


@pytest.mark.parametrize("slope", [60.0, 75.0])
def test_a_steep_surface_is_found(slope):
    semi = 8.0
    radius = semi / sin(radians(slope))
    findings = found(singlet(200.0, radius, 3.0, semi), Kind.SLOPE)
    assert [f.surface for f in findings] == ([1] if slope > STEEPEST else [])
    if findings:
        assert findings[0].figures["slope"] == pytest.approx(slope, abs=0.5)


def test_findings_about_the_library_are_true():
    """Edge, centre and slope of every finding follow again from the numbers of its surfaces."""
    count = 0
    for name in lenses.names()[::6]:
        lens = lenses.load(name).at(zoom=0.0, close=0.0)
        for finding in lenses.check(lens):
            i, figures = finding.surface, finding.figures
            assert finding.kind in (Kind.EDGE, Kind.THICKNESS, Kind.SLOPE)
            front = lens.surfaces[i]
            count += 1
            if finding.kind is Kind.SLOPE:
                if front.is_spherical:
                    assert figures["slope"] == pytest.approx(degrees(asin(min(
                        1.0, front.semi_diameter * abs(front.curvature)))), abs=3.0)
                continue
            back = lens.surfaces[i + 1]
            assert figures["diameter"] == 2.0 * max(front.semi_diameter, back.semi_diameter)
            if finding.kind is Kind.THICKNESS:
                assert figures["centre"] == front.thickness < CENTRE * figures["diameter"]
            else:
                rim = min(front.semi_diameter, back.semi_diameter)
                edge = front.thickness + float(back.sag(0.0, rim)) - float(front.sag(0.0, rim))
                assert figures["edge"] == pytest.approx(edge, abs=1e-9)
                assert edge < max(EDGE * figures["diameter"], LEAST_EDGE)
    assert count > 3


def test_a_radius_that_a_solve_sets_is_no_doubt(tmp_path):
    """A solve leaves all digits of a double: the check took it for a mistake of the table."""
    from lensbench.lenses.editing import cells
    from lensbench.lenses.editing.document import LensDocument, Solve

    document = cells.with_value(LensDocument(lenses.load("pbrt-dgauss-50mm")), 9, "curvature", 1.0 / 437.07)
    document = cells.with_rule(document, Solve(10, "efl", 50.0))
    path = tmp_path / "solved.toml"
    lenses.save(document, path)
    solved = lenses.load(path)
    assert len(re.sub(r"0+$", "", f"{1.0 / solved.surfaces[10].curvature:.15g}".replace(".", ""))) > 9
    assert Kind.SOLVED_RADIUS not in {finding.kind for finding in lenses.check(solved)}
    bare = replace(solved, findings=())
    assert Kind.SOLVED_RADIUS in {finding.kind for finding in lenses.check(bare)}


def test_a_stop_that_is_too_wide_does_not_make_clear_apertures_estimates(tmp_path):
    semi, radius = 8.0, 40.0
    lens = singlet(radius, -radius, 0.07 + 2.0 * sphere(radius, semi), semi)
    lenses.save(lens.with_stop_radius(1e6), tmp_path / "a.txt")
    wide = lenses.load(tmp_path / "a.txt")
    assert [f.kind for f in wide.findings] == [Kind.STOP_SIZE]
    assert not has_estimated_clear_apertures(wide)
    assert not original(replace(Settings(), lens=str(tmp_path / "a.txt"))).lens.estimates
    (finding,) = found(wide, Kind.EDGE)
    assert finding.severity is Severity.WARNING and "estimated" not in str(finding)
