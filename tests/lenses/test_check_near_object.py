"""The check of lenses for a near object: sound lenses at a near distance pass, a lost sign is named."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses import Kind, Severity

NAMES = ("lenshh-cooke-triplet-50", "pbrt-dgauss-50mm", "mamiya-sekor-macro-c-80-f4", "rodenstock-rodagon-wa-80-f4",
         "olympus-zuiko-auto-macro-50-f2")


def near(name, magnification=0.2):
    """A lens of the library for an object of which it makes an image of this magnification; its film where it was."""
    lens = replace(lenses.load(name), positions=None)
    fo = lb.first_order(lens)
    distance = fo.efl * (1.0 + 1.0 / magnification) - fo.front_principal        # Newton's law
    return replace(lens, system=replace(lens.system, object_distances=(distance,)))


def doubts(lens):
    return [finding for finding in lenses.check(lens) if finding.severity is Severity.WARNING]


@pytest.mark.parametrize("name", NAMES)
def test_a_sound_lens_passes_and_a_lost_sign_of_a_strong_radius_is_named(name):
    lens = near(name)
    assert doubts(lens) == []
    inner = [i for i, surface in enumerate(lens.surfaces) if abs(surface.curvature) * surface.semi_diameter > 0.35]
    assert inner
    for i in inner:
        surfaces = list(lens.surfaces)
        surfaces[i] = replace(surfaces[i], curvature=-surfaces[i].curvature)
        found = doubts(replace(lens, surfaces=tuple(surfaces)))
        assert {Kind.BLUR, Kind.RAY, Kind.BACK_FOCUS} & {finding.kind for finding in found}, i
        assert i in {finding.surface for finding in found if finding.kind is Kind.SIGN}, i


@pytest.mark.slow
@pytest.mark.parametrize("name", lenses.names())
def test_no_lens_of_the_library_is_doubted_for_a_near_object(name):
    assert not {Kind.BLUR, Kind.RAY, Kind.SIGN} & {finding.kind for finding in doubts(near(name, 0.1))}


def test_a_single_element_and_an_image_at_infinity_are_not_judged():
    lens = replace(near("lenshh-cooke-triplet-50"), stop_index=0)
    alone = replace(lens, surfaces=tuple(replace(surface, glass=lb.AIR if i else surface.glass)
                                         for i, surface in enumerate(lens.surfaces[:2])))
    assert not {Kind.BLUR, Kind.RAY} & {finding.kind for finding in doubts(alone)}
    rear = replace(lens.surfaces[-1], thickness=0.0)           # a collimator stores no back focus
    collimator = replace(lens, surfaces=(*lens.surfaces[:-1], rear), system=replace(
        lens.system, object_distances=(-lb.first_order(lens).ffl,)))
    assert not {Kind.BLUR, Kind.RAY, Kind.BACK_FOCUS} & {finding.kind for finding in doubts(collimator)}
