"""Fields and wavelengths of a user's choice: what is read, where the fields lie, and what a lens does not have."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.plots.aperture_plots import breathing_figure, focus_shift_figure, illumination_figure
from lensbench.app.plots.light_plots import ghost_ray, ghosts_figure
from lensbench.app.plots.query import OwnFields, query, read_fields, read_wavelengths, with_own
from lensbench.app.plots.spots import spots_figure
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.ghost_path import ghost_path
from lensbench.core.optics.system import FieldKind, FieldPoint
from lensbench.core.text import f_number_text
from tests.lenses.test_system_data import SILICA

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
    lens, away, line = asked.bench.lens, asked.bench.film_distance, blue.conditions().primary_wavelength
    expected = lb.analysis.ghosts(lens, away, (0.0, 0.0, math.inf), line, "single-layer", 21)
    figure = ghosts_figure(blue, 8, "axis", "single-layer")
    assert "410 nm" in figure.conditions and sum(row[2] for row in figure.table.rows) == pytest.approx(expected.total)
    assert expected.total > 3.0 * sum(row[2] for row in ghosts_figure(asked, 8, "axis", "single-layer").table.rows)
    path, pair = ghost_ray(blue, "axis", (0, 1)), (0, 1)
    way = path[1] - path[0]
    ray = ghost_path(lens, pair, path[0], way / np.linalg.norm(way), line)
    np.testing.assert_allclose(path[:-1], ray.points, atol=1e-9)


SELLMEIER = ((0.6961663, 0.0684043), (0.4079426, 0.1162414), (0.8974794, 9.896161))        # Malitson, 1965: silica


def silica(line):
    """Focal length and back focus (mm) of the biconvex lens R = 50, d = 5 at a wavelength (µm), by the lensmaker."""
    n = math.sqrt(1.0 + sum(b * line**2 / (line**2 - c**2) for b, c in SELLMEIER))
    efl = 1.0 / (2.0 * (n - 1.0) / 50.0 - (n - 1.0) ** 2 * 5.0 / (n * 50.0**2))
    return efl, efl * (1.0 - (n - 1.0) * 5.0 / (n * 50.0))


@pytest.fixture
def lithography(tmp_path):
    """A query of a singlet that is designed for 248 nm."""
    path = tmp_path / "silica.zmx"
    path.write_text(SILICA)
    return query(replace(Settings(), lens=str(path), f_number=None, focus_distance=math.inf, film_width=3.6,
                         film_height=2.4, focus_position="paraxial"))


def test_breathing_of_a_design_off_the_d_line_is_that_of_the_chosen_wavelength(lithography):
    """The film lies in the focus of 248 nm; the chief ray of its corner and the focal length are those of 400 nm."""
    efl, bfl = silica(0.4)
    for asked, line in ((lithography, 0.248), (with_own(lithography, None, read_wavelengths("400")), 0.4)):
        figure = breathing_figure(asked, 16)
        assert f"{1000.0 * line:.0f} nm" in figure.conditions
        distance, half, change, focal, magnification = figure.table.rows[0]
        assert distance == math.inf and change == 0.0 and focal == pytest.approx(silica(line)[0], rel=1e-5)
        # The ray from the scene through the middle of the stop, on the first surface, traced to the film
        slope = math.radians(half)
        ray = lb.trace(asked.lens, [[0.0, 0.0, 0.0]], [[0.0, math.sin(slope), math.cos(slope)]], line, clip=False)
        point, way = ray.points[0], ray.directions[0]
        height = point[1] + (5.0 + silica(0.248)[1] - point[2]) / way[2] * way[1]
        assert height == pytest.approx(0.5 * math.hypot(3.6, 2.4), rel=1e-5)


def test_focus_shift_has_the_f_numbers_of_the_design(lithography):
    """The file states f/5 at 248 nm, which is f/5.5 at the d line; the depths of focus are those of its cones."""
    figure = focus_shift_figure(lithography, 16)
    widest, depth = figure.table.rows[0][0], np.array([row[3] for row in figure.table.rows])
    numbers = np.array([row[0] for row in figure.table.rows])
    assert widest == pytest.approx(5.0, rel=1e-9)
    # Of a point in even light: blur times the f-number; aberrations fall as 1 / N²
    blur = 2.0 * lithography.bench.film.pitch
    assert depth[-1] == pytest.approx(blur * numbers[-1], rel=2e-3)


def test_illumination_is_that_of_the_chosen_wavelength():
    asked = query(replace(Settings(), lens="canon-178-degree-fisheye-y-155-f28", f_number=None,
                          focus_distance=math.inf))
    figure = illumination_figure(with_own(asked, None, read_wavelengths("410")), 9)
    name, radius, total = next(row[:3] for row in reversed(figure.table.rows[:9]) if row[2] > 0.2)
    light = [lb.falloff(asked.bench.lens, asked.bench.film_distance, [radius], line).total[0]
             for line in (0.41, lb.D_LINE)]
    assert "410 nm" in figure.conditions and name == f_number_text(asked.bench.f_number)
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
