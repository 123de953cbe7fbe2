"""Every analysis of every odd lens and film: a figure, or one line that says what cannot be shown; never a crash."""

import math
from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings

LENS = lenses.load("pbrt-dgauss-50mm")
CROWN = lb.Glass(1.5)
AFOCAL = lb.Lens((lb.Surface(0.0, 10.0, CROWN, curvature=0.01), lb.Surface(300.0, 10.0, curvature=0.0),
                  lb.Surface(0.0, 10.0, CROWN, curvature=0.0), lb.Surface(0.0, 10.0, curvature=-0.02)), 0,
                  name="afocal")
PINHOLE = replace(LENS, surfaces=tuple(replace(each, semi_diameter=0.001) if i == 2 else each
                                       for i, each in enumerate(LENS.surfaces)))
CLOSED = replace(PINHOLE, surfaces=tuple(replace(each, semi_diameter=0.001, pose=lb.SurfacePose(decentre_x=3.0))
                                         if i == 9 else each for i, each in enumerate(PINHOLE.surfaces)))
BESIDE = replace(LENS, surfaces=tuple(replace(each, pose=lb.SurfacePose(decentre_y=60.0)) if i < 2 else each
                                      for i, each in enumerate(LENS.surfaces)))
WAVELENGTHS = replace(LENS, system=replace(LENS.system, wavelengths=()))


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("lens", "changes", "refused"), [
    (None, {"pixels_x": 1, "pixels_y": 1}, set()),
    (None, {"film_width": 200.0, "film_height": 150.0}, set()),             # far beyond the image circle
    ("pbrt-fisheye-10mm", {}, set()),                                       # fields beyond what the lens sees
    (WAVELENGTHS, {}, set()), (None, {"focus_distance": math.inf}, set()), (None, {"f_number": 22.0}, set()),
    (AFOCAL, {}, {"field", "grid", "focus-shift", "breathing", "illumination"}),
    (AFOCAL, {"focus_distance": math.inf}, {"spots", "fans", "mtf", "wavefront", "psf", "depth", "stack"}),
    (PINHOLE, {}, {"axial"}),                                               # light of the stop's 10⁻⁸
    (CLOSED, {}, set(ANALYSES) - {"breathing", "sunstar"}),                 # two pinholes, one decentred: no light
    (BESIDE, {"focus_distance": math.inf}, {"spots", "fans", "mtf", "field", "illumination", "bokeh"}),    # no light
    ("lentil-schneider-anamorphic-31-2001", {}, {"seidel", "axial", "illumination"}),
])
def test_every_analysis_shows_a_figure_or_says_what_it_cannot_show(tmp_path, lens, changes, refused):
    if isinstance(lens, lb.Lens):
        lenses.save(lens, str(tmp_path / "odd.toml"))
        lens = str(tmp_path / "odd.toml")
    settings = replace(Settings(), blades=6 if "lentil" not in str(lens) else None,
                       f_number=changes.get("f_number"), **({"lens": lens} if lens else {}),
                       **{key: value for key, value in changes.items() if key != "f_number"})
    asked, left_out = query(settings), {}
    for name, each in ANALYSES.items():
        try:
            figure = each.figure(asked, 16)
            assert figure.table.rows and figure.conditions, name
        except lb.LensError as error:
            left_out[name] = str(error)
    assert refused <= set(left_out), refused - set(left_out)
    if not refused:
        assert set(left_out) <= {"sunstar"}, left_out
    assert all(10 < len(why) < 700 and "\n" not in why for why in left_out.values())
