"""Charts of pupils, focusing, pictures and samplers: from the arguments of the command to panels of curves."""

import argparse
from collections.abc import Callable
from dataclasses import replace

import lensbench as lb
from lensbench.app.state.settings import SettingsError
from lensbench.app.studies.charts.curves import Panel
from lensbench.app.studies.charts.focusing import focus_panel
from lensbench.app.studies.charts.images import image_panel
from lensbench.app.studies.charts.pupils import pupil_panels
from lensbench.app.studies.charts.sampling import sampling_panels
from lensbench.app.studies.charts.sampling import scenes as sampling_scenes
from lensbench.app.studies.charts.subjects import Subject, subjects

TITLES = {"pupil": "Exit-pupil regions: cost and error",
          "focus": "Focusing: cost and excess blur",
          "image": "Whole pictures: error against time",
          "sampler": "Samples that white noise needs for the same error"}
LENSES = ("pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-fisheye-10mm")
FOCUS_LENSES = (*LENSES, "lentil-takumar-1969")
IMAGE_SCENES = ("still-life", "focus-ruler", "night-lights")
IMAGE_FOCUS = 1200.0            # mm: the middle of the built-in scenes
PER_LENS = ("pupil", "focus")


def panels(arguments: argparse.Namespace, progress: Callable[[float], bool]) -> list[Panel]:
    """The panels that the arguments ask for.

    progress: receives the finished share; StoppedError where it returns False. Errors in lenses and scenes are those of
    the readers: ValueError, OSError.
    """
    if arguments.of in PER_LENS:
        names = arguments.lens or (LENSES if arguments.of == "pupil" else FOCUS_LENSES)
        found, _ = subjects(argparse.Namespace(**{**vars(arguments), "lens": names}))
        made = [_of_lens(arguments.of, each, _part(progress, i, len(found))) for i, each in enumerate(found)]
        if arguments.of == "pupil":                     # first row: light of all lenses; second: samples
            return [panel for row in zip(*made, strict=True) for panel in row]
        return [panel for row in made for panel in row]
    if arguments.of == "sampler":
        return sampling_panels(_known(arguments.scene or [], list(sampling_scenes())), progress)
    names = _known(arguments.scene or list(IMAGE_SCENES), list(lb.SCENES))
    focus = IMAGE_FOCUS if arguments.focus is None else arguments.focus
    changed = {"lens": arguments.lens or [LENSES[0]], "focus": focus}
    found, _ = subjects(argparse.Namespace(**{**vars(arguments), **changed}))
    pairs = [(each, name) for each in found for name in names]
    return [_of_scene(each, name, _part(progress, i, len(pairs)), len(found) > 1)
            for i, (each, name) in enumerate(pairs)]


def _of_lens(of: str, subject: Subject, progress: Callable[[float], bool]) -> list[Panel]:
    if of == "pupil":
        return pupil_panels(subject.key, subject.camera, progress)
    return [focus_panel(subject.key, subject.camera.lens, progress)]


def _of_scene(subject: Subject, name: str, progress: Callable[[float], bool], several: bool) -> Panel:
    panel = image_panel(f"{subject.key}, {name}", subject.camera, lb.builtin_scene(name), progress)
    return replace(panel, title=f"{name}, {subject.title}") if several else panel


def _known(names: list[str], all_names: list[str]) -> list[str]:
    """The names; SettingsError with a list of all names if one is unknown."""
    for name in names:
        if name not in all_names:
            raise SettingsError(f"no scene “{name}”: choose of {', '.join(all_names)}")
    return names


def _part(progress: Callable[[float], bool], i: int, n: int) -> Callable[[float], bool]:
    return lambda share: progress((i + share) / n)
