"""Lenses from damaged files: what is read must be sound."""

import math
from dataclasses import fields

from lensbench import Lens, lenses
from lensbench.lenses import Kind
from tests.mishaps import also_wide, outlive


def lenses_outlive(path, whole, mutate, times, seed):
    """Lenses loaded from a file after each of `times` random changes; a traceback, a hang or a NaN fails."""
    result = outlive(path, whole, also_wide(mutate, whole), times, seed, lenses.load, lenses.LensFileError, 700)
    for lens in result:
        assert_sound(lens)
    return result


def assert_sound(lens):
    """Assert that every number of a lens is finite."""
    assert isinstance(lens, Lens)
    for surface in lens.surfaces:
        for field in fields(surface):
            value = getattr(surface, field.name)
            assert not isinstance(value, float) or math.isfinite(value)
        assert all(math.isfinite(a) for _, a in surface.aspheric)
        assert math.isfinite(surface.glass.n_d) and math.isfinite(surface.glass.v_d or 0.0)
    assert all(value is None or math.isfinite(value) for value in (lens.stated_efl, lens.stated_f_number))
    assert not any("\n" in finding.message for finding in lens.findings)
    assert not any("nan" in finding.message.split() for finding in lens.findings if finding.kind is not Kind.NOT_READ)
