"""Fields and wavelengths of a user's choice: what is read, where the fields lie, and what a lens does not have."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.state.analysis.aperture_figures import illumination_figure
from lensbench.app.state.analysis.ghost_images import ghost_ray, ghosts_figure
from lensbench.app.state.analysis.own_conditions import OwnFields, read_fields, read_wavelengths, with_own
from lensbench.app.state.analysis.query import query
from lensbench.app.state.analysis.spots import spots_figure
from lensbench.app.state.settings import Settings
from lensbench.kernels.figures import f_number_text
from lensbench.optics.ghost_path import ghost_path
from lensbench.optics.system import FieldKind, FieldPoint

ASKED = query(replace(Settings(), lens="lib-tronnier-1953", focus_distance=math.inf))


@pytest.mark.parametrize(("text", "found"), [
    ("0,0.7,1", OwnFields((0.0, 0.7, 1.0))), ("0, 14, 20deg", OwnFields((0.0, 14.0, 20.0), "°")),
    ("3°", OwnFields((3.0,), "°")), ("0mm,10mm", OwnFields((0.0, 10.0), "mm")), ("Design", OwnFields())])
def test_fields_are_read_as_parts_angles_or_heights(text, found):
    assert read_fields(text) == found


@pytest.mark.parametrize(("text", "said"), [
    ("", "numbers"), ("0,x", "numbers"), ("0,2", "parts of the largest up to 1"), ("-0.1", "from 0"),
    ("nan", "finite"), ("1deg,2mm", "one unit"), (",".join(["0"] * 9), "1 to 8 fields")])
def test_fields_that_mean_nothing_are_refused(text, said):
    with pytest.raises(ValueError, match=said):
        read_fields(text)


def test_wavelengths_are_nanometres_with_weights():
    assert read_wavelengths("486.1,587.6:2") == ((0.4861, 1.0), (0.5876, 2.0))
    for text, said in (("0.55", "nanometres"), ("550,550", "twice"), ("-550", "positive"), ("550:-1", "negative"),
                       ("550:0", "one positive"), ("550:", "numbers"),
                       (",".join(map(str, range(400, 413))), "1 to 12")):
        with pytest.raises(ValueError, match=said):
            read_wavelengths(text)


def test_chosen_fields_and_wavelengths_are_those_of_the_figure():
    """The angles against the slopes of rays traced from the scene by `lb.trace`: 1e-6 rad, that of the search."""
    own = with_own(ASKED, read_fields("0,10,20deg"), read_wavelengths("500,600:3"))
    rays = own.grid(16, own.heights)
    assert rays.conditions.wavelengths == (0.5, 0.6) and rays.conditions.weights == (0.25, 0.75)
    assert np.degrees(rays.field_angles) == pytest.approx([0.0, 10.0, 20.0], abs=1e-4)
    table = spots_figure(own, 16).table
    assert {row[0] for row in table.rows} == set(rays.image_heights) and {row[3] for row in table.rows} == {0.5, 0.6}
    heights = with_own(ASKED, read_fields("0.5,1"), None).heights
    assert heights == (0.5 * ASKED.largest_height, ASKED.largest_height)
    assert with_own(ASKED, read_fields("3,12mm"), None).heights == (3.0, 12.0)


def test_ghosts_are_those_of_the_chosen_wavelength():
    """The label said the chosen wavelength, the light was that of the d line."""
    asked = query(replace(Settings(), lens="lenshh-cooke-triplet-50", f_number=None, focus_distance=math.inf))
    blue = with_own(asked, None, read_wavelengths("410"))
    lens, away, line = asked.setup.lens, asked.setup.film_distance, blue.conditions().primary_wavelength
    expected = lb.analysis.ghosts(lens, away, (0.0, 0.0, math.inf), line, "single-layer", 21)
    figure = ghosts_figure(blue, 8, "axis", "single-layer")
    assert "410 nm" in figure.conditions and sum(row[2] for row in figure.table.rows) == pytest.approx(expected.total)
    assert expected.total > 3.0 * sum(row[2] for row in ghosts_figure(asked, 8, "axis", "single-layer").table.rows)
    path, pair = ghost_ray(blue, "axis", (0, 1)), (0, 1)
    way = path[1] - path[0]
    ray = ghost_path(lens, pair, path[0], way / np.linalg.norm(way), line)
    np.testing.assert_allclose(path[:-1], ray.points, atol=1e-9)


def test_illumination_is_that_of_the_chosen_wavelength():
    asked = query(replace(Settings(), lens="canon-178-degree-fisheye-y-155-f28", f_number=None,
                          focus_distance=math.inf))
    figure = illumination_figure(with_own(asked, None, read_wavelengths("410")), 9)
    name, radius, total = next(row[:3] for row in reversed(figure.table.rows[:9]) if row[2] > 0.2)
    light = [lb.falloff(asked.setup.lens, asked.setup.film_distance, [radius], line).total[0]
             for line in (0.41, lb.D_LINE)]
    assert "410 nm" in figure.conditions and name == f_number_text(asked.setup.f_number)
    assert total == pytest.approx(light[0], rel=1e-9) and light[0] > 1.03 * light[1]


def test_fields_that_a_lens_does_not_have_say_so():
    for text, said in (("0,80deg", "80°: no ray through the middle of the stop"), ("design", "states no fields")):
        with pytest.raises(lb.LensError, match=said):
            with_own(ASKED, read_fields(text), None)
    near = replace(ASKED, object_distance=1000.0)
    with pytest.raises(lb.LensError, match="needs --focus inf"):
        with_own(near, read_fields("95deg"), None)
    points = FieldPoint(0.0, 0.0), FieldPoint(0.0, 12.0)
    system = replace(ASKED.lens.system, field_kind=FieldKind.ANGLE, fields=points)
    stated = replace(ASKED, lens=replace(ASKED.lens, system=system))
    by_angle = with_own(ASKED, read_fields("0,12deg"), None).heights
    assert with_own(stated, read_fields("design"), None).heights == pytest.approx(by_angle, abs=1e-9)
