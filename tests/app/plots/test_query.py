"""Wavelengths, fields and cells of figures: what a lens file states, what its glasses know, what is left out."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.plots.aperture_plots import axial_figure, breathing_figure
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.query import query
from lensbench.app.plots.spots import spots_figure
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.window.layouts import LAYOUTS
from lensbench.core.imaging.spectrum import WHITES
from lensbench.core.optics.system import Wavelength

GAUSS = lenses.load("pbrt-dgauss-50mm")
FLINT = tuple(replace(each, glass=lb.Glass(each.glass.n_d, 40.0)) if each.glass.n_d != 1.0 else each
              for each in GAUSS.surfaces)


def asked(folder, surfaces, lines, primary=0, **changes):
    """The query of a double Gauss of these surfaces, designed for these wavelengths (µm)."""
    system = replace(GAUSS.system, wavelengths=tuple(Wavelength(line, 1.0) for line in lines), primary=primary)
    lenses.save(replace(GAUSS, surfaces=surfaces, system=system), str(folder / "lens.toml"))
    return query(replace(Settings(), lens=str(folder / "lens.toml"), **changes))


def test_a_design_for_the_e_line_keeps_its_colours(tmp_path):
    """The film lies where the e line is in focus; figures of all colours were those of the e line."""
    mine = asked(tmp_path, FLINT, (0.48, 0.5461, 0.6438), primary=1)
    assert mine.lines.conditions().wavelengths == (0.48, 0.5461, 0.6438)
    figure = axial_figure(mine, 9)
    assert figure.conditions.startswith("object 1.20 m · 480, 546, 644 nm") and figure.remarks == ()
    own = lenses.load(str(tmp_path / "lens.toml"))
    foci = [lb.first_order(own, line).bfl for line in (0.48, 0.5461, 0.6438)]      # paraxial, of a distant object
    shown = axial_figure(replace(mine, object_distance=np.inf), 9).table
    found = [next(at for line, height, at in shown.rows if line == each and height == 0.0)
             for each in (0.48, 0.5461, 0.6438)]
    np.testing.assert_allclose(np.diff(found), np.diff(foci), rtol=1e-9)
    assert abs(np.diff(foci)).min() > 0.05


def test_one_glass_without_dispersion_leaves_the_colours_of_the_others(tmp_path):
    first, *others = FLINT
    mine = asked(tmp_path, (replace(first, glass=GAUSS.surfaces[0].glass), *others), (0.4861, 0.5876, 0.6563), 1)
    assert len(mine.lines.conditions().wavelengths) == 3
    assert "1 of 6 glasses" in " ".join(axial_figure(mine, 9).remarks)


def test_a_glass_that_is_known_at_the_primary_wavelength_alone_is_named(tmp_path):
    deep = lb.Glass(1.508, None, "deep", "table", ((0.24, 1.5133), (0.248, 1.5084), (0.26, 1.5024)))
    first, *others = GAUSS.surfaces
    mine = asked(tmp_path, (replace(first, glass=deep), *others), (0.248,))
    remarks = " ".join(axial_figure(mine, 9).remarks)
    assert "figures at 248 nm alone" in remarks and "deep" in remarks and "is not known:" not in remarks


def test_a_wavelength_that_no_glass_knows_is_refused_with_the_glass(tmp_path):
    mine = asked(tmp_path, FLINT, (0.248,))
    for figure in (axial_figure, breathing_figure):
        with pytest.raises(lb.LensError, match=r"no wavelength is left .*0\.365 to 1\.014 µm"):
            figure(mine, 9)


def test_breathing_ends_at_the_edge_of_light():
    """Of a film of 200 × 150 mm no chief ray meets the corner: the figure was empty, without a word."""
    figure = breathing_figure(query(replace(Settings(), film_width=200.0, film_height=150.0)), 16)
    assert "edge of light, 28." in figure.conditions and np.isfinite([row[1] for row in figure.table.rows]).all()
    bare = lb.analysis.breathing(GAUSS, lb.Film(200.0, 150.0))
    assert np.isnan(bare.half_angles).all() and "12 of 12" in str(bare.findings[-1])


def test_cells_of_spots_do_not_grow_to_a_pixel_of_the_whole_film():
    figure = spots_figure(query(replace(Settings(), pixels_x=1, pixels_y=1)), 16)
    assert figure.rows[0][0].cell < 1.0 and any("a pixel, " in remark for remark in figure.remarks)
    assert "pixel" not in {layer.name for layer in figure.rows[0][0].named()}


WORDS = {"picture": "423, 450, 503, 547, 595, 644 nm, weighted as the picture",
         "photopic": "470, 510, 555, 610, 650 nm, weighted by photopic vision",
         "lens": "480, 546, 644 nm, weighted as the lens file states",
         "fdc": "486, 588, 656 nm, weighted equally at F, d and C"}


@pytest.mark.parametrize("white", WHITES)
def test_the_line_below_names_the_weights_of_white_light(tmp_path, white):
    mine = asked(tmp_path, FLINT, (0.48, 0.5461, 0.6438), primary=1, white=white)
    for name in ("spots", "mtf", "mtf-frequency", "mtf-map", "psf", "encircled", "line-spread", "bokeh", "depth",
                 "focus-shift", "stack"):
        assert f" · {WORDS[white]} · " in ANALYSES[name].figure(mine, 8).conditions, name
    for name in ("fans", "opd", "field", "wavefront", "axial"):         # of single wavelengths
        assert " · 480, 546, 644 nm · " in ANALYSES[name].figure(mine, 8).conditions, name


def test_a_picture_without_colour_errors_is_white_at_one_wavelength(tmp_path):
    plain = asked(tmp_path, FLINT, (0.48, 0.5461, 0.6438), primary=1, dispersion="off")
    assert plain.conditions().wavelengths == (0.5461,)
    infrared = asked(tmp_path, FLINT, (0.85, 0.94), primary=0)
    assert infrared.conditions().wavelengths == (0.85,)
    with pytest.raises(SettingsError, match="white light"):
        replace(Settings(), white="blue").checked()


def test_layouts_choose_white_light():
    chosen = {name: layout.white for name, layout in LAYOUTS.items()}
    assert chosen["Photographer"] == chosen["Student"] == Settings().white == "picture"
    assert chosen["Designer"] == chosen["Editor"] == "lens"
