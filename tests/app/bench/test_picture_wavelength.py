"""Lenses that were designed for another wavelength than the d line: film, picture and figures are at theirs."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of, design, flare, picture_wavelength, published, wavelength_remark
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.readouts import colours
from lensbench.app.command.main import main
from lensbench.app.plots.light_plots import ghosts_figure
from lensbench.app.plots.query import query
from lensbench.app.plots.section import sketch
from lensbench.app.settings.settings import Settings
from lensbench.core.rendering.ghost_image import GhostImage
from tests.lenses.test_system_data import SILICA

SMALL = Settings(film_width=3.6, film_height=2.4, pixels_x=36, pixels_y=24, lens_model="trace", f_number=None,
                 focus_distance=math.inf)
GREEN = SILICA.replace("WAVM 1 0.248 1", "WAVM 1 0.5461 1")


@pytest.fixture
def settings(tmp_path):
    def of(text, **changed):
        path = tmp_path / "a.zmx"
        path.write_text(text)
        return replace(SMALL, lens=str(path), **changed)

    return of


def thick(n, radius=50.0, thickness=5.0):
    """Focal length and back focus of the biconvex lens, by the lensmaker's equation."""
    efl = 1.0 / (2.0 * (n - 1.0) / radius - (n - 1.0) ** 2 * thickness / (n * radius**2))
    return efl, efl * (1.0 - (n - 1.0) * thickness / (n * radius))


def test_film_and_picture_of_a_design_for_248_nm_are_those_at_248_nm(settings):
    silica = settings(SILICA, focus_position="paraxial")
    efl, bfl = thick(1.50855)                           # Malitson's index at 0.248 µm; 1.45846 at the d line
    assert bench_of(silica).film_distance == pytest.approx(bfl, rel=1e-4) == camera(silica).film_distance
    assert bench_of(silica).film_distance < 0.92 * thick(1.45846)[1]
    assert readings(silica).efl == pytest.approx(efl, rel=1e-4)
    # Rays from the middle of the film leave the lens parallel to the axis
    slow = camera(replace(silica, f_number=50.0))
    rays = slow.generate_rays([[18.0, 12.0]] * 3, [[0.1, 0.5], [0.5, 0.9], [0.3, 0.1]])
    assert np.abs(rays.directions[:, :2]).max() < 3e-6      # of the aberration; at the d line they lean by 7e-4
    assert "248 nm alone" in wavelength_remark(silica) and "248 nm alone" in colours(silica).why
    assert not colours(silica).possible


def test_t_stop_and_ghosts_of_a_design_for_248_nm_are_those_of_its_coating_at_248_nm(settings, capsys):
    """The reflectance of one layer in closed form: a quarter wave at 550 nm alone."""
    reflected = single_layer(1.50855, 0.248)
    coated = settings(SILICA, coating="single-layer", focus_position="paraxial")
    assert readings(coated).t_number == pytest.approx(readings(coated).f_number / (1.0 - reflected), rel=1e-5)
    assert main(["info", coated.lens, "--coating", "single-layer", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["transmission"] == pytest.approx((1.0 - reflected) ** 2, rel=1e-5)
    assert data["t_number"] == pytest.approx(data["f_number"] / (1.0 - reflected), rel=1e-5)
    figure = ghosts_figure(query(replace(coated, f_number=50.0)), 8, "axis", "single-layer")
    (_, _, share, *_, paraxial), = figure.table.rows
    assert paraxial == pytest.approx(reflected**2, rel=1e-4) and share == pytest.approx(reflected**2, rel=2e-3)


def single_layer(n, wavelength):
    """Reflectance of a quarter wave of 1.38 at 550 nm at normal incidence (Born and Wolf, § 1.6)."""
    phase = 0.5 * math.pi * 0.55 / wavelength
    off, on = ((1.0 + sign * n, n / 1.38 + sign * 1.38) for sign in (-1.0, 1.0))
    part = [half[0] ** 2 * math.cos(phase) ** 2 + half[1] ** 2 * math.sin(phase) ** 2 for half in (off, on)]
    return part[0] / part[1]


def test_ghosts_in_the_picture_of_a_design_for_248_nm_reflect_as_at_248_nm(settings):
    """Both reflections of the only ghost of the sun, over those of bare glass; at f/50 within a degree of normal."""
    n, sums = 1.50855, {}
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)))
    for name in ("uncoated", "single-layer"):
        seen = settings(SILICA, coating=name, focus_position="paraxial", f_number=50.0, ghosts=True, stars=True)
        assert flare(seen).wavelength == 0.248
        image = GhostImage(camera(seen), scene, flare(seen))
        with ThreadPoolExecutor(1) as pool:
            image.add(1, pool, 1, lambda: True)
        picture = np.zeros((24, 36, 3), np.float32)
        image.add_to(picture)
        sums[name] = picture.sum((0, 1))
    expected = (single_layer(n, 0.248) / ((n - 1.0) / (n + 1.0)) ** 2) ** 2         # 0.31; below 0.21 in visible light
    np.testing.assert_allclose(sums["single-layer"] / sums["uncoated"], expected, rtol=1e-3)
    assert flare(replace(settings(GREEN), ghosts=True)).wavelength is None          # a picture in colours


def test_a_visible_design_keeps_its_colours_and_its_film_and_turns_to_its_line_without_them(settings):
    green = settings(GREEN, focus_position="paraxial")
    assert colours(green).used and wavelength_remark(green) == "" and camera(green).disperses
    for changed in ({}, {"focus_distance": 600.0}):         # the film is where the design has it, not the d line
        seen = replace(green, **changed)
        assert camera(seen).disperses and camera(seen).film_distance == bench_of(seen).film_distance
    assert camera(green).film_distance == pytest.approx(thick(1.46008)[1], rel=1e-5)
    assert camera(green).film_distance < thick(1.45846)[1] - 0.1
    plain = replace(green, dispersion="off")
    assert picture_wavelength(plain, published(plain)) == 0.5461 and "546.1 nm" in colours(plain).why
    assert colours(plain).possible
    assert bench_of(plain).film_distance == pytest.approx(thick(1.46008)[1], rel=1e-4)    # Malitson's at 0.5461 µm


def test_the_section_of_a_visible_design_shows_its_glasses_and_the_rays_of_its_line(settings):
    shown = sketch(settings(GREEN, focus_position="paraxial"))
    assert shown.glasses[0].v_d == pytest.approx(67.8, abs=0.1)         # of silica
    assert lb.first_order(shown.lens).bfl == pytest.approx(thick(1.46008)[1], rel=1e-5)


def test_lenses_for_the_d_line_are_what_they_were():
    settings = Settings()
    assert picture_wavelength(settings, published(settings)) is None and wavelength_remark(settings) == ""
    assert design(settings) is published(settings)


def test_a_rendered_picture_says_its_wavelength_and_info_too(settings, tmp_path, capsys):
    path = settings(SILICA).lens
    assert main(["render", path, "--size", "24x16", "--samples", "1", "-o", str(tmp_path / "a.png")]) == 0
    assert "248 nm alone" in capsys.readouterr().err
    assert main(["info", path]) == 0
    assert "248 nm, its pictures too" in capsys.readouterr().out


def test_a_saved_lens_keeps_its_glass(settings, tmp_path):
    lens = published(settings(SILICA))
    lenses.save(lens, tmp_path / "b.zmx")
    assert lenses.load(tmp_path / "b.zmx").surfaces[0].glass.name == "F_SILICA"
    assert lb.first_order(lens, 0.248).efl == pytest.approx(lb.first_order(design(settings(SILICA))).efl, rel=1e-12)
