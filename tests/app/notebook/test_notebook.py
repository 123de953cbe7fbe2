"""What the library offers at a prompt: pictures, names instead of objects, cards."""

import base64
import io
import math
import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.tone import develop
from lensbench.app.notebook.render import shown_progress
from lensbench.app.session.export import ExportError, read_settings

FILM = lb.Film(36.0, 24.0, 30, 20)
CAMERA = lb.PerspectiveCamera(FILM)
RAMP = lb.Picture(np.linspace(0.0, 2.0, 600, dtype=np.float32).reshape(10, 20, 3))


def test_a_render_is_an_array_that_shows_itself():
    picture = lb.render(CAMERA, "grid-wall", 2)
    assert isinstance(picture, np.ndarray) and picture.dtype == np.float32
    np.testing.assert_array_equal(picture, lb.render(CAMERA, lb.builtin_scene("grid-wall"), 2))
    shown = np.asarray(Image.open(io.BytesIO(picture._repr_png_())), float) / 255.0
    np.testing.assert_allclose(shown, develop(np.asarray(picture), 0.0, "filmic"), atol=0.51 / 255.0)
    assert picture[..., 0]._repr_png_() is None and isinstance(picture.mean(), np.floating)
    brighter = lb.develop(picture, 1.0, "none")
    np.testing.assert_allclose(brighter, develop(np.asarray(picture), 1.0, "none"))
    again = np.asarray(Image.open(io.BytesIO(brighter._repr_png_())), float) / 255.0       # not developed twice
    np.testing.assert_allclose(again, brighter, atol=0.51 / 255.0)


@pytest.mark.slow
def test_the_name_of_a_lens_takes_the_picture_of_the_command():
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.session.picture_render import render
    from lensbench.app.settings.settings import Settings

    settings = replace(with_lens(Settings(scene="still-life"), "pbrt-dgauss-50mm"), samples=1)
    np.testing.assert_array_equal(lb.render("pbrt-dgauss-50mm", "still-life", 1), render(settings)[0])


@pytest.mark.parametrize("make, kind, message", [
    (lambda: lb.render(3, "still-life"), TypeError, "int is not a camera"),
    (lambda: lb.render(None, "still-life"), TypeError, "NoneType is not a camera"),
    (lambda: lb.render(lenses.load("pbrt-dgauss-50mm"), "room"), TypeError, "LensCamera.lens, lb.Film"),
    (lambda: lb.render(CAMERA, 5), TypeError, "int is not a scene"),
    (lambda: lb.render("pbrt-dgauss-50mm", lb.Scene()), TypeError, "does not place the camera"),
    (lambda: lb.render("no-such-lens", "room"), lenses.LensFileError, "no library lens"),
    (lambda: lb.render(CAMERA, "no-such-scene"), ValueError, "no built-in scene"),
    (lambda: lb.render(CAMERA, "room", 0), ValueError, "at least 1"),
    (lambda: lb.load_scene("stil-life"), ValueError, "did you mean still-life"),
    (lambda: lb.develop(RAMP, tone="film"), ValueError, "choose one of none, filmic, agx"),
    (lambda: lb.develop(RAMP, math.nan), ValueError, "exposure"),
    (lambda: lb.develop(RAMP[..., 0]), ValueError, r"must be \(height, width, 3\)"),
    (lambda: lb.develop(np.zeros((2, 2, 3), np.uint8)), ValueError, "linear light as floats"),
    (lambda: lb.save(RAMP, "picture.jpg"), ExportError, "pictures are written as"),
    (lambda: lb.save(lb.develop(RAMP), "picture.exr"), ExportError, "holds linear light"),
    (lambda: lb.save(lb.develop(RAMP), "picture.png", exposure=1.0), ValueError, "give the exposure to develop"),
    (lambda: lb.save(RAMP, "picture.exr", tone="agx"), ValueError, "leave them out"),
    (lambda: lb.show(), TypeError, "show what"),
    (lambda: lb.show(5), TypeError, "int cannot be shown"),
])
def test_what_cannot_be_is_said(make, kind, message):
    with pytest.raises(kind, match=message):
        make()


def test_saved_pictures_hold_what_was_given_and_no_settings(tmp_path):
    lb.save(RAMP, tmp_path / "one.png", exposure=1.0, tone="agx", bits=16)
    lb.save(lb.develop(RAMP, 1.0, "agx"), tmp_path / "two.png", bits=16)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
    lb.save(RAMP, tmp_path / "light.pfm")
    raw = (tmp_path / "light.pfm").read_bytes()[-RAMP.nbytes:]
    np.testing.assert_array_equal(np.frombuffer(raw, "<f4").reshape(RAMP.shape)[::-1], RAMP)
    lb.save(RAMP, tmp_path / "plain.ppm")
    for name in ("one.png", "plain.ppm"):
        with pytest.raises(ExportError, match="settings"):
            read_settings(tmp_path / name)


def test_cards_draw_the_lens_and_state_its_figures(tmp_path):
    lens = lenses.load("pbrt-dgauss-50mm")
    card = lens._repr_html_()
    assert "50.0" in card or "50 mm" in card or f"{lb.first_order(lens).efl:.1f}" in card
    camera = lb.LensCamera(lens, FILM, 800.0, 4.0)
    drawn = camera._repr_html_()
    assert "0.8 m from the film" in drawn and "<svg" in drawn
    # The rays of the axial object point meet on the film, to a fiftieth of its height
    rays = re.findall(r'points="([^"]*)" fill="none" stroke="#d08a2c"', drawn)
    ends = [ray.split()[-1].split(",")[1] for ray in rays]
    assert len(ends) == 7 and np.ptp(np.array(ends, float)) < 2.0
    assert "fov" in CAMERA._repr_html_().lower()
    scene = lb.Scene("two <balls>", spheres=[lb.Sphere((0.0, 0.0, -900.0), 150.0)], subject=(900.0, 400.0))
    shown = scene._repr_html_()
    assert "two &lt;balls&gt;" in shown and "at 0.9 m, 0.4 m high" in shown
    drawn = Image.open(io.BytesIO(base64.b64decode(re.findall(r"base64,([^\"]*)", shown)[0])))
    assert drawn.size == (300, 200)
    page = lb.show("a <caption>", lens, camera, RAMP, lb.develop(RAMP), scene, open_browser=False)
    page.save(tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert text.count("<svg") == 2 and text.count("<img") == 3 and "a &lt;caption&gt;" in text


def test_a_notebook_shows_a_bar_for_what_takes_long_and_takes_it_away(monkeypatch):
    shown = []
    handle = SimpleNamespace(update=lambda page: shown.append(page._repr_html_()))
    display = SimpleNamespace(display=lambda page, display_id: shown.append(page._repr_html_()) or handle)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=1)))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr("lensbench.app.notebook.render.SILENT", -1.0)
    with shown_progress(None) as show:
        show(0.25)
        show(0.5)
    assert len(shown) == 3 and 'value="0.250"' in shown[0] and 'value="0.500"' in shown[1] and shown[2] == ""
    told = []
    lb.render(CAMERA, "grid-wall", 20, progress=told.append)
    assert told[-1] == 1.0 and told == sorted(told)
    np.testing.assert_array_equal(lb.render(CAMERA, "grid-wall", 20, progress=told.append),
                                  lb.render(CAMERA, "grid-wall", 20, progress=False))
