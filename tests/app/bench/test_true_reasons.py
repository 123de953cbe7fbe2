"""Errors and findings of odd lenses name the true reason, and what to do."""

from dataclasses import replace
from math import inf

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.command.main import main
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.finding import Kind
from lensbench.lenses.checks.geometry import geometry_findings

GLASS = lb.Glass(1.9)
# A ball: paraxial focus 0.5556 mm behind it, the rays of its rim meet inside, as in a phone's lens without its aspheres
BALL = lb.Lens((lb.Surface(0.5, 8.5, curvature=0.0), lb.Surface(20.0, 9.9, GLASS, curvature=0.1),
                lb.Surface(0.0, 9.9, curvature=-0.1)), 0)


def test_a_lens_without_room_for_the_film_of_its_least_blur_is_focused_paraxially(tmp_path):
    assert lb.first_order(BALL).bfl == pytest.approx(1.0 / 1.8) and lb.film_distance(BALL, inf, "real") < 0.0
    lenses.save(BALL, tmp_path / "ball.toml")
    settings = replace(Settings(), lens=str(tmp_path / "ball.toml"), focus_distance=inf, f_number=None)
    assert bench_of(settings).focusing.method == "paraxial"
    assert camera(settings).film_distance == pytest.approx(1.0 / 1.8)
    with pytest.raises(lb.FocusError, match=r"mm before its last vertex, .*by real rays at this aperture; its paraxial "
                                            r"focus lies 0\.5556 mm behind it\. Stop down, focus paraxially"):
        lb.LensCamera(BALL, lb.Film(), focus_method="real")


def test_an_eye_that_ends_in_glass_is_told_so(tmp_path, capsys):
    eye = lb.Lens((lb.Surface(3.0, 4.0, lb.Glass(1.376), curvature=0.128),
                   lb.Surface(20.0, 2.0, lb.Glass(1.336), curvature=0.0)), 1)
    lenses.save(eye, tmp_path / "eye.toml")
    main(["info", str(tmp_path / "eye.toml")])
    printed = capsys.readouterr().out
    assert printed.count("none: this lens ends in glass: its film must be in air") == 2
    assert "forms no real image" not in printed


def test_a_gap_of_negative_thickness_may_follow_a_mirror():
    lens = lenses.load("lenshh-cooke-triplet-50")
    for i in (1, 2):                                                    # air, and glass
        surfaces = list(lens.surfaces)
        surfaces[i] = replace(surfaces[i], thickness=-3.0)
        found = [f for f in geometry_findings(replace(lens, surfaces=tuple(surfaces))) if f.kind is Kind.THICKNESS]
        assert [f.surface for f in found] == [i] and "mirrors are not traced" in str(found[0])
