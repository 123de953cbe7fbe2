"""Charts of samplers, whole pictures, pupils and focusing: their curves obey known laws."""

import json
import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.app.studies.charts.curves import Curve, Panel, draw_panels, panel_table, plain_panels
from lensbench.app.studies.charts.methods import VARIANTS, focus_panel, image_panel, pupil_panels, reached
from lensbench.app.studies.charts.samplers import COUNTS, DEFAULT, WHITE, gains, samplers, soft_scene, squares
from lensbench.core.kernels.block import KEYS, PITCH, SAMPLE, TIME, U0, U1, V0, V1, B, Step, X, Y, lane_buffer
from lensbench.core.kernels.program import Program, run_steps
from lensbench.core.kernels.sampling import add_corners
from lensbench.core.optics import focus

NARROW = lb.Film(3.0, 2.0, 37, 25)


def film(width=36.0, height=24.0):
    return lb.Film(width, height, 180, 120)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(samplers(NARROW, True)))
def test_every_sampler_fills_its_pixel_and_all_squares(name):
    program, lanes = Program(samplers(NARROW, True)[name], np.float64), lane_buffer(np.float64)
    key = np.zeros(KEYS, np.uint32)
    samples = np.empty((64, 7, B))
    for key[SAMPLE] in range(64):
        run_steps(lanes, program.code, key)
        samples[key[SAMPLE]] = lanes.reshape(-1, PITCH)[[X, Y, U0, U1, V0, V1, TIME], :B]
    size, zero = [NARROW.pixels_x, NARROW.pixels_y], np.zeros(B)
    samples[:, :2] -= Program([Step(add_corners, size)]).run({X: zero, Y: zero}, [X, Y], B)
    numbers = samples.transpose(1, 0, 2)
    assert numbers.min() >= 0.0 and numbers.max() < 1.0
    # The mean of n independent ones is off by 0.29 / √n, here five times
    assert np.abs(numbers.mean(axis=(1, 2)) - 0.5).max() < 5.0 * 0.29 / math.sqrt(64 * B)
    # No two dimensions follow each other
    dimensions = numbers.reshape(7, -1)
    assert np.abs(np.corrcoef(dimensions) - np.eye(7)).max() < 0.06


@pytest.mark.slow
def test_a_net_gains_on_white_noise_and_white_noise_does_not():
    camera, scene = soft_scene()
    steps = samplers(camera.film)
    ratios = gains(dict(squares(camera, scene, COUNTS, {name: steps[name] for name in (DEFAULT, WHITE)}, 2048)))
    # The goals of the default, and of white noise what the spread of three pictures allows
    assert all(gain >= least for gain, least in zip(ratios[DEFAULT].values(), (2.0, 3.0, 4.5, 6.0), strict=True))
    assert all(0.9 < gain < 1.1 for gain in ratios[WHITE].values())


def test_a_goal_is_reached_where_a_power_of_time_passes_it_for_good():
    points = tuple((t, 5.0 / math.sqrt(t)) for t in (1.0, 2.0, 8.0, 64.0))
    assert reached(points, 1.0) == pytest.approx(25.0)
    assert reached(points, 0.5) == math.inf
    assert reached(points, 9.0) == 1.0
    assert reached(((1.0, 0.5), (2.0, 2.0), (4.0, 0.5)), 1.0) == pytest.approx(2.0 * math.sqrt(2.0))


@pytest.mark.slow
def test_a_wrong_model_never_gets_there_and_the_polynomial_does():
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film(), 1200.0, 2.0)
    panel = image_panel("focus-ruler", camera, lb.builtin_scene("focus-ruler"), longest=0.15, converged=256)
    ends = {curve.name: curve.points[-1][1] for curve in panel.curves}
    assert len(ends) == len(VARIANTS)
    assert ends["pinhole"] > 10.0 and ends["thin lens"] > 5.0
    assert ends["full trace"] < 4.0 and ends["polynomial, degree 9"] < 4.0
    assert all(math.isinf(curve.figures["to 1 %, s"]) for curve in panel.curves[:3])
    for curve in panel.curves:
        seconds = [point[0] for point in curve.points]
        assert seconds == sorted(seconds) and seconds[0] > 0.0


@pytest.mark.slow
def test_solved_regions_waste_least_and_lose_no_light():
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film(), 2000.0)
    light, waste = pupil_panels("pbrt-dgauss-50mm", camera)
    lost = {curve.name: curve.points[-1] for curve in light.curves}
    blocked = {curve.name: curve.points for curve in waste.curves}
    solved = "solved regions"
    # 4096 samples and cells know the light to a few parts in a thousand; the paraxial disk loses much more here
    assert lost[solved][1] < 0.5 and lost["paraxial disk"][1] > 2.0
    assert blocked[solved][0][1] < 2.0
    boxes = blocked["boxes, of 256 to a million rays"]
    assert all(percent > 20.0 for _, percent in boxes)
    assert [percent for _, percent in boxes] == sorted((percent for _, percent in boxes), reverse=True)


@pytest.mark.slow
def test_the_whole_bundle_finds_the_least_blur_and_one_ray_does_not():
    panel = focus_panel("pbrt-wide-22mm", lenses.load("pbrt-wide-22mm"))
    blur = {curve.name: curve.figures["blur, µm"] for curve in panel.curves}
    assert blur["whole bundle (the program's)"] < 0.01
    assert blur["closed form (the program's)"] == pytest.approx(blur["school formula, float64"], rel=1e-6)
    assert blur["closed form (the program's)"] > 10.0           # spherical aberration, wide open
    assert blur["golden section over 200 rays"] < 0.01


@pytest.mark.slow
def test_the_time_of_a_focusing_method_is_that_of_fresh_computations(monkeypatch):
    """The program keeps its newest film distances: a repeated question cost 3.7 µs, a new one 508."""
    computed = []
    solve = focus._solved_film_distance
    monkeypatch.setattr(focus, "_solved_film_distance", lambda *values: computed.append(values) or solve(*values))
    panel = focus_panel("pbrt-wide-22mm", lenses.load("pbrt-wide-22mm"))
    times = {curve.name: curve.figures["time, µs"] for curve in panel.curves}
    assert len(computed) >= 3 * 6                       # distances, and rounds with the one before
    assert times["whole bundle (the program's)"] > times["closed form (the program's)"]     # 24 rays, and none


def test_panels_are_drawn_printed_and_told_as_data(tmp_path):
    curves = (Curve("one", "green", ((1.0, 2.0), (10.0, 0.2)), {"time, ms": 10.0}),
              Curve("nowhere", "grey", (), {"time, ms": 1.0, "blur, µm": math.inf}, dotted=True))
    panel = Panel("key", "A title", "Time (ms)", "Error (%)", curves, ((1.0, "a goal"),), (1.0, 10.0), "Conditions")
    draw_panels([panel, panel], tmp_path / "panels.svg", "Many")
    written = (tmp_path / "panels.svg").read_text()
    assert written.startswith("<?xml") and "nan" not in written.lower().replace("nand", "")
    table = panel_table(panel)
    assert "Conditions" in table and "∞" in table and "time, ms" in table
    assert plain_panels([panel])[0]["curves"][0]["points"] == [[1.0, 2.0], [10.0, 0.2]]


@pytest.mark.slow
def test_the_command_charts_what_it_is_asked_for(tmp_path, capsys):
    assert main(["chart", "pbrt-wide-22mm", "--of", "focus", "-o", str(tmp_path / "focus.json")]) == 0
    (panel,) = json.loads((tmp_path / "focus.json").read_text())["charts"]
    assert panel["title"] == "Wide angle 22 mm f/2.7" and len(panel["curves"]) == 7
    assert "Wide angle" in capsys.readouterr().out
    assert main(["chart", "--of", "sampler", "--scene", "nowhere"]) == 2
    assert "choose of soft, still-life" in capsys.readouterr().err
