"""Camera bodies: facts that agree with themselves, and what they change."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench.app.bench.constraints import with_body, with_equivalent_film, with_film
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.command.options import read_film
from lensbench.app.settings.bodies import BODIES, bodies_named
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings


def test_every_body_has_square_pixels_and_is_found_by_its_name():
    assert len(BODIES) >= 40
    for name, body in BODIES.items():
        # published sides are rounded to 0.1 mm
        assert body.width / body.across == pytest.approx(body.height / body.down, rel=0.06 / body.height + 0.005), name
        assert 0.0005 < body.pitch < 0.02 and body.across * body.down <= 200e6
        assert bodies_named(name) == (body,) and bodies_named(name.upper()) == (body,)
        assert read_film(name) == body
    assert [body.name for body in bodies_named("a7 iv")] == ["Sony A7 IV"] and not bodies_named("kodak")
    assert len(bodies_named("nikon z")) > 2


def test_a_body_sets_the_film_and_counts_blur_in_its_own_pixels():
    settings = with_body(Settings(limit="pixel"), "Sony A7 IV")
    assert (settings.film_width, settings.film_height) == (35.9, 23.9)
    assert settings.sensor == BODIES["Sony A7 IV"] and blur_limit(settings) == pytest.approx(35.9 / 7008, rel=0.002)
    assert settings.pixels_x == Settings().pixels_x                 # the picture is no larger
    assert blur_limit(replace(settings, pixels_x=240, pixels_y=160, crop=0.5)) == blur_limit(settings)
    plain = with_film(settings, 35.9, 23.9)
    assert plain.sensor is None and blur_limit(plain) == plain.film.pitch
    assert replace(settings, film_width=24.0).sensor is None        # of another size: no longer that camera
    assert with_body(settings, "").sensor is None


def test_the_equivalent_picture_on_another_body_keeps_the_field_of_view():
    start = Settings(f_number=5.6)
    other = with_body(start, "Fujifilm X-T5", with_equivalent_film)
    ratio = BODIES["Fujifilm X-T5"].width / 36.0
    assert other.sensor is not None and other.f_number == pytest.approx(start.f_number * ratio, rel=0.02)
    assert lb.Film(*other.sensor.size).diagonal == pytest.approx(28.26, abs=0.01)


def test_a_settings_file_with_an_unknown_body_is_refused():
    assert Settings.from_dict(with_body(Settings(), "Leica M11").to_dict()).sensor == BODIES["Leica M11"]
    with pytest.raises(SettingsError, match="camera body “?.*Box Brownie.*Format"):
        Settings.from_dict({"version": 1, "body": "Box Brownie"})


def test_an_ambiguous_camera_names_those_that_it_may_be():
    with pytest.raises(ValueError, match="Nikon Z6 III, Nikon Z7 II, Nikon Z8"):
        read_film("nikon z")
