"""Settings as a short text: the same settings come back, and other texts are refused in one line."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings as limits, strategies as st

from lensbench.app.session.states import PREFIX, is_state_text, settings_of_text, state_text
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings

ELSEWHERE = replace(Settings(), lens="lv-czj-biotar-75-f15", scene="night-lights", f_number=None,
                    focus_distance=math.inf, position=(12.5, -40.0, 300.25), yaw=0.125, blades=6, tone="agx",
                    exposure=0.5, film_width=24.0)


def test_a_state_comes_back_and_fits_a_message():
    text = state_text(ELSEWHERE)
    assert settings_of_text(text) == ELSEWHERE and len(text) < 280
    assert settings_of_text(state_text(Settings())) == Settings() and len(state_text(Settings())) < 40
    assert settings_of_text(f"  {text[:30]}\n{text[30:]} ") == ELSEWHERE          # as a chat may break it
    assert is_state_text(text) and not is_state_text("https://example.org")


@limits(max_examples=60)
@given(st.floats(1.0, 32.0), st.floats(300.0, 1e5), st.floats(-3.0, 3.0), st.integers(1, 4096))
def test_numbers_come_back_to_seven_digits(f_number, focus, yaw, samples):
    settings = replace(Settings(), f_number=f_number, focus_distance=focus, yaw=yaw, samples=samples)
    got = settings_of_text(state_text(settings))
    assert got.f_number == pytest.approx(f_number, rel=1e-6) and got.focus_distance == pytest.approx(focus, rel=1e-6)
    assert got.yaw == pytest.approx(yaw, rel=1e-6) and got.samples == samples


@pytest.mark.parametrize("text", [
    "", "lens", PREFIX, PREFIX + "!!!", PREFIX + "AAAA", state_text(ELSEWHERE)[:-9], PREFIX + "A" * 70000,
    state_text(ELSEWHERE).replace("lensbench:", "http:")])
def test_what_is_no_state_is_refused(text):
    with pytest.raises(SettingsError):
        settings_of_text(text)


@limits(max_examples=200)
@given(st.binary(max_size=80))
def test_damage_is_refused_and_never_another_error(raw):
    import base64
    try:
        settings_of_text(PREFIX + base64.urlsafe_b64encode(raw).decode())
    except ValueError as error:
        assert "\n" not in str(error)
