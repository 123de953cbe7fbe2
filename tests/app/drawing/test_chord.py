"""Chords of keys, as imgui takes them."""

from imgui_bundle import imgui

from lensbench.app.drawing.controls import chord


def test_a_chord_holds_its_key_and_its_modifiers():
    key = imgui.Key
    code = chord(key.mod_ctrl, key.mod_shift, key.z)
    assert type(code) is int
    assert code & int(key.mod_mask_) == int(key.mod_ctrl) + int(key.mod_shift)
    assert code & ~int(key.mod_mask_) == int(key.z)
