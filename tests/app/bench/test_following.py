"""A locked to B follows its dials and keeps its lens; differences have the digits that are written."""

from dataclasses import replace

import pytest

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.plots.comparison import difference, followed
from lensbench.app.settings.settings import Settings

A = Settings()
B = replace(A, lens="pbrt-wide-22mm", f_number=4.0, focus_distance=800.0)


@pytest.mark.parametrize("turned", [{"f_number": 8.0}, {"focus_distance": 2500.0}, {"exposure": 1.0}, {"yaw": 0.2},
                                    {"scene": "room"}, {"crop": 0.5, "film_width": 24.0}, {"shutter": 0.01}])
def test_a_takes_the_dial_that_is_turned_and_nothing_else(turned):
    assert followed(A, B, replace(B, **turned)) == replace(A, **turned)


@pytest.mark.parametrize("turned", [{"lens": "pbrt-fisheye-10mm"}, {"lens_model": "thin"}, {"camera": "perspective"},
                                    {"focal_length": 30.0}, {"compare": "side"}, {"wipe": 0.2}, {"overlay": "coc"}, {}])
def test_a_keeps_its_lens_and_camera(turned):
    assert followed(A, B, replace(B, **turned)) == A


def test_what_comes_with_another_lens_is_that_lens_own():
    assert followed(A, B, with_lens(B, "pbrt-telephoto-250mm")) == A


def test_a_slower_lens_opens_as_far_as_it_can_and_focuses_as_near_as_it_can():
    slow = replace(A, lens="pbrt-fisheye-10mm", f_number=8.0)
    assert followed(slow, B, replace(B, f_number=2.7)).f_number is None
    nearest = readings(A).nearest_focus
    assert followed(A, B, replace(B, focus_distance=0.5 * nearest)).focus_distance == pytest.approx(nearest, rel=1e-3)


@pytest.mark.parametrize(("a", "b", "apart"), [
    ("50.4", "22.0", "−28.4"), ("46.5°", "89.0°", "+42.5°"), ("f/8", "f/2.8", "+3.0 EV"), ("T 3.0", "T 4.3", "−1.0 EV"),
    ("ø 6.29", "ø 2.75", "−3.54"), ("0.196", "0.09", "−0.11"), ("−1.5", "2", "+3.5"), ("22.0", "22.0", ""),
    ("–", "3.0", ""), ("1.0 – 2.0", "1.1", ""), ("39.3° × 26.8°", "78.5° × 57.2°", ""), ("f/2", "2", ""),
])
def test_differences_read_as_the_figures_do(a, b, apart):
    assert difference(a, b) == apart
