"""The section in a cell of the lens browser: to scale, in the middle, with its glass and its stop."""

import numpy as np
import pytest

from lensbench import lenses
from lensbench.app.panels.section_pictures import HEIGHT, WIDTH, SectionLook, section_picture
from lensbench.app.workers.lens_pictures import LensPictures

SIZE = (240, 80)


def inked(picture):
    """Rows and columns, from the first to the last, in which there is something."""
    rows, columns = np.nonzero(picture[..., 3].max(1))[0], np.nonzero(picture[..., 3].max(0))[0]
    return rows[0], rows[-1], columns[0], columns[-1]


@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_a_section_fills_its_picture_in_one_direction_and_keeps_its_shape(name, dark):
    lens = lenses.load(name)
    picture = section_picture(lens, SectionLook(SIZE, dark, 1.0))
    assert picture.shape == (SIZE[1], SIZE[0], 4) and picture.dtype == np.uint8
    top, bottom, left, right = inked(picture)
    across, down = right - left + 1, bottom - top + 1
    radius = max(surface.semi_diameter for surface in lens.surfaces)
    scale = min(WIDTH * SIZE[0] / lens.length, 0.5 * HEIGHT * SIZE[1] / radius)
    assert across == pytest.approx(scale * lens.length, abs=6.0)
    assert down == pytest.approx(2.0 * scale * radius, abs=3.0)
    assert left + right == pytest.approx(SIZE[0], abs=2.0) and top + bottom == pytest.approx(SIZE[1], abs=2.0)


def test_glass_has_the_colour_of_its_theme_and_air_has_none():
    lens = lenses.load("pbrt-dgauss-50mm")
    dark, light = (section_picture(lens, SectionLook(SIZE, theme, 1.0)) for theme in (True, False))
    row = SIZE[1] // 2
    glass = (dark[row, :, 3] > 0) & (light[row, :, 3] > 0)
    assert 10 < glass.sum() < SIZE[0] // 2
    assert not np.array_equal(dark[row, glass], light[row, glass])
    assert dark[0, 0, 3] == 0


@pytest.mark.slow
def test_the_process_draws_the_same_section_and_its_opacity_survives_the_file(tmp_path):
    look = SectionLook(SIZE, False, 1.5)
    made = LensPictures(tmp_path, command=look.command, look="section", processes=1)
    made.want(["pbrt-dgauss-50mm"], True)
    made._tasks[0].join(60.0)
    made.stop()
    assert np.array_equal(made.found["pbrt-dgauss-50mm"], section_picture(lenses.load("pbrt-dgauss-50mm"), look))
