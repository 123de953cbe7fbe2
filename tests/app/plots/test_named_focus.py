"""Focus on a thing by its name: the front of what the picture shows of it is in focus."""

from dataclasses import replace

import pytest

from lensbench.app.command.main import parsed
from lensbench.app.command.options import settings_from
from lensbench.app.plots.named_focus import focused_on, named_things
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings

SCENE = """
[[sphere]]
name = "Vase"
centre = [-200, -100, -1000]
radius = 100
[[sphere]]
centre = [300, 100, -2500]
radius = 150
[[rectangle]]
name = "poster"
centre = [0, 0, -4000]
right = [1000, 0, 0]
up = [0, 800, 0]
[[disk]]
centre = [0, 0, -3000]
normal = [0, 0, 1]
radius = 50
"""


@pytest.fixture
def settings(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(SCENE)
    return Settings(scene=str(path), position=(0.0, 0.0, 200.0))


@pytest.mark.parametrize(("name", "middle", "radius"), [
    ("vase", (-200.0, -100.0, -1200.0), 100.0), ("sphere 2", (300.0, 100.0, -2700.0), 150.0)])
def test_the_front_of_a_ball_that_points_at_the_film_is_in_focus(settings, name, middle, radius):
    """Along the line from the lens, near the film, to its middle: nearer than it by the radius."""
    focused, remark = focused_on(settings, name)
    away = sum(part * part for part in middle) ** 0.5
    assert focused.focus_distance == pytest.approx(-middle[2] * (1.0 - radius / away), rel=0.005) and remark == ""
    assert focused == replace(settings, focus_distance=focused.focus_distance)


def test_a_hidden_thing_is_focused_through_what_hides_it_with_a_remark(settings):
    focused, remark = focused_on(settings, "poster")
    assert "disk in front of it hides its middle" in remark and focused.focus_distance == pytest.approx(4200.0)


def test_names_are_offered_and_a_wrong_one_is_refused(settings):
    assert {"subject", "vase", "sphere 1", "poster", "rectangle 1"} <= set(named_things(settings))
    with pytest.raises(SettingsError, match="choose one of vase"):
        focused_on(settings, "vasse")
    with pytest.raises(SettingsError, match="does not show its middle"):
        focused_on(replace(settings, yaw=2.0), "vase")
    with pytest.raises(SettingsError, match="has no focus"):
        focused_on(replace(settings, camera="fisheye"), "vase")


def test_the_option_focuses_and_excludes_a_distance(settings):
    command = ["render", "pbrt-dgauss-50mm", "--scene", settings.scene, "--position=0,0,20cm", "-o", "x.png"]
    asked = settings_from(parsed([*command, "--focus-on", "Vase"]))
    assert asked.focus_distance == pytest.approx(1102.0, abs=3.0)
    with pytest.raises(SettingsError, match="give one of them"):
        settings_from(parsed([*command, "--focus-on", "Vase", "--focus", "2m"]))
