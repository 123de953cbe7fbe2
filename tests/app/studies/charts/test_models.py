"""Charts of camera models: errors of a known size, the Pareto front by brute force, and the command."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.app.drawing.sheet import look
from lensbench.app.studies.charts.curves import Chart, Mark
from lensbench.app.studies.charts.ladder import Model, ladder
from lensbench.app.studies.charts.sheet import _one
from lensbench.app.studies.charts.truth import Truth
from lensbench.app.studies.timing import time_in_turn
from lensbench.core.kernels.block import WEIGHT, B, Step, X, Y, rows, stage

FILM = lb.Film(36.0, 24.0, 600, 400)


@stage
def shifted(lanes, p, ints, key):
    """Film point moved by p mm to the right."""
    x = rows(lanes)[X]
    for i in range(B):
        x[i] += p[0]


@stage
def shaded(lanes, p, ints, key):
    """Less light off the axis: divided by 1 + p r²."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, weight = row[X], row[Y], row[WEIGHT]
    for i in range(B):
        weight[i] /= real(1) + p[0] * (x[i] * x[i] + y[i] * y[i])


def camera(name, f_number=8.0, film=FILM, focus=1000.0):
    return lb.LensCamera(lenses.load(name), film, focus, f_number)


def of(models, name):
    return next(model for model in models if model.name == name)


@pytest.mark.parametrize("name, film", [
    ("pbrt-dgauss-50mm", FILM), ("pbrt-fisheye-10mm", lb.Film(18.0, 12.0, 600, 400))])
def test_rays_of_film_points_next_to_the_true_ones_are_off_by_that_distance(name, film):
    there = camera(name, film=film)
    trace = of(ladder(there), "trace, float64")
    off = 0.05
    moved = Model("moved", "trace", aim=trace.aim, lens=(Step(shifted, [off]), *trace.lens), real=np.float64)
    error = Truth(there).error(moved)
    # In focus it does not matter by which place of the pupil: aberrations and the second derivative are left
    assert error.focus == pytest.approx(off / film.pitch, rel=0.02)
    assert Truth(there).error(trace).worst < 1e-8


@pytest.mark.parametrize("name, film", [
    ("pbrt-dgauss-50mm", FILM), ("pbrt-fisheye-10mm", lb.Film(18.0, 12.0, 600, 400))])
def test_the_rays_for_other_programs_come_from_the_scene_to_the_film(name, film):
    there = camera(name, film=film)
    origins, directions = Truth(there).arriving(50.0)
    assert origins[:, 2] == pytest.approx(-50.0)
    traced = lb.trace(there.lens, origins, directions)
    # A ray at the very rim may end there by its rounding
    assert (traced.fate == lb.Fate.PASSED).mean() > 0.999
    ways = traced.directions / traced.directions[:, 2:]
    landed = (traced.points + ways * (there.lens.length + there.film_distance - traced.points[:, 2:]))[:, :2]
    assert np.abs(landed).max(0) == pytest.approx([film.width / 2.0, film.height / 2.0], rel=0.01)
    plane = np.full(len(landed), there.lens.length + there.film_distance)
    back = lb.trace(there.lens, np.column_stack([landed, plane]), -traced.directions)
    assert back.directions == pytest.approx(-directions, abs=1e-9)


def test_light_that_is_darker_off_the_axis_is_off_by_its_stops():
    there, fall = camera("pbrt-dgauss-50mm"), 0.002
    trace = of(ladder(there), "trace, float64")
    dark = Model("dark", "trace", aim=(*trace.aim, Step(shaded, [fall])), lens=trace.lens, real=np.float64)
    worst = math.log2(1.0 + fall * FILM.diagonal**2 / 4.0)
    # The outermost film point that is looked at halves the last 16th of the area; the trace itself is off by 0.003
    assert 0.95 * worst < Truth(there).error(dark).stops_worst < worst + 0.003


@pytest.mark.slow
def test_each_rung_of_the_ladder_is_nearer_to_the_truth_and_an_ideal_lens_is_off_by_the_distortion():
    there = camera("pbrt-dgauss-50mm", 8.0)
    truth, models = Truth(there), ladder(there)
    rms = {model.name: truth.error(model).rms for model in models}
    degrees = [rms[f"degree {degree}"] for degree in (3, 5, 7, 9, 11)]
    assert sorted(degrees, reverse=True) == degrees
    assert rms["trace, float64"] < rms["trace, float32"] < degrees[2] < rms["thick lens"]
    # Distortion, as the chief rays have it, over the film: where it is largest it bounds the rms of what is in focus
    radii = np.linspace(0.1, 1.0, 10) * FILM.diagonal / 2.0
    percent = lb.distortion(there.lens, there.film_distance, radii).percent
    largest = float(np.abs(percent / 100.0 * radii).max()) / FILM.pitch
    assert 0.1 * largest < truth.error(of(models, "thick lens")).focus < 1.5 * largest


def test_a_model_that_loses_rays_says_so():
    there = camera("pbrt-dgauss-50mm", 8.0)
    trace = of(ladder(there), "trace, float64")
    stopped = lb.stopped_down(there.lens, 11.0)
    lens = tuple(lb.LensCamera(stopped, FILM, 1000.0).camera_steps()[1:])
    lost = Truth(there).error(Model("smaller stop", "trace", aim=trace.aim, lens=lens, real=np.float64)).lost
    # On the axis the area goes as 1 / N²; the field's edge loses a like part
    assert lost == pytest.approx(1.0 - (8.0 / 11.0) ** 2, abs=0.05)


numbers = st.floats(1e-3, 1e3)


@given(st.lists(st.tuples(numbers, numbers, st.booleans()), max_size=12))
@settings(deadline=None)
def test_the_front_is_what_nothing_valid_beats(points):
    marks = tuple(Mark(str(i), "trace", cost, error, why="" if valid else "no")
                  for i, (cost, error, valid) in enumerate(points))
    front = Chart("a", "A", "cost", "error", marks).front
    for mark in marks:
        beaten = any(other.is_valid and other.cost <= mark.cost and other.error <= mark.error
                     and (other.cost, other.error) != (mark.cost, mark.error) for other in marks)
        if mark.why or beaten:
            assert mark not in front
        else:                                           # of equal marks one is found
            assert any((mark.cost, mark.error) == (one.cost, one.error) for one in front)


def test_works_are_taken_in_turn():
    order = []
    times = time_in_turn({name: lambda name=name: order.append(name) for name in "abc"}, 0.0)
    assert "".join(order) == "abc" * 6 and set(times) == set("abc")


@pytest.mark.slow
def test_the_command_prints_figures_and_writes_the_chart(tmp_path, capsys):
    path = tmp_path / "chart.svg"
    assert main(["chart", "lenshh-cooke-triplet-50", "--f-number", "8", "--json", "-o", str(path)]) == 0
    chart = json.loads(capsys.readouterr().out)["charts"][0]
    marks = {mark["name"]: mark for mark in chart["marks"]}
    assert {"pinhole", "thin lens", "thick lens", "degree 3", "degree 11", "table", "trace, float32", "trace, float64",
            "scalar reference"} <= set(marks)
    assert all(mark["figures"]["streamed, ns"] > 0.0 for mark in marks.values())
    assert marks["trace, float32"]["figures"]["fused, ns"] > marks["trace, float32"]["figures"]["streamed, ns"] > 0.0
    assert b"<svg" in path.read_bytes()[:1000]


@pytest.mark.slow
def test_what_cannot_stand_is_marked_with_the_reason(tmp_path, capsys):
    figures = tmp_path / "chart.json"
    assert main(["chart", "lentil-schneider-anamorphic-31-2001", "-o", str(figures)]) == 0
    said = capsys.readouterr().out
    assert "Not valid: thin lens: " in said and "Not valid: degree 9: " in said and "cylinder" in said
    marks = {mark["name"]: mark for mark in json.loads(figures.read_text())["charts"][0]["marks"]}
    assert not marks["degree 9"]["valid"] and marks["trace, float32"]["valid"]


@pytest.mark.parametrize("arguments, said", [
    (["chart", "pbrt-dgauss-50mm", "-o", "chart.pdf"], ".svg or .png"),
    (["chart", "no-such-lens"], "no-such-lens"),
    (["chart", "pbrt-dgauss-50mm", "--f-number", "0.5"], "f/"),
    (["chart", "pbrt-dgauss-50mm", "-o", "/nowhere/at/all/chart.svg"], "no folder")])
def test_what_cannot_be_charted_is_said_in_a_line(capsys, arguments, said):
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


@pytest.mark.slow
def test_names_of_marks_that_lie_upon_each_other_do_not_touch():
    marks = tuple(Mark(f"method {i}", "polynomial", 1.0 + 0.02 * i, 0.1, spread=5.0, worst=0.2,
                       figures={"cost, ns": 1.0}) for i in range(6))
    with look():
        figure = _one(Chart("a", "A", "Cost (ns)", "Error (px)", marks), "")
        boxes = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text()]
    assert len(boxes) == len(marks)
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[i + 1:])
        assert figure.axes[0].get_window_extent().containsx(box.x0)
