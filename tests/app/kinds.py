"""Every kind of camera and every model of a lens, as changes of Settings."""

from dataclasses import replace

from lensbench.app.bench.constraints import with_camera
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
from lensbench.app.settings.settings import Settings

KINDS = {**{name: {"camera": "lens", "lens_model": name} for name in LENS_MODELS},
         **{name: {"camera": name} for name, kind in CAMERA_KINDS.items() if not kind.has_lens}}


def of_kind(settings: Settings, name: str) -> Settings:
    """The settings with a camera without a lens, or with a lens by one of its models."""
    return replace(with_camera(settings, KINDS[name]["camera"]), **KINDS[name])
