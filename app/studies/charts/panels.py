"""Charts of pupils, focusing, pictures and samplers from the arguments of the command: lenses before films, and panels.

Lengths in mm.
"""

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import design
from lensbench.app.bench.zoom import asked_zoom
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.studies.charts.curves import Panel
from lensbench.app.studies.charts.methods import focus_panel, image_panel, pupil_panels
from lensbench.app.studies.charts.samplers import sampling_panels, scenes as sampling_scenes
from lensbench.lenses.library.catalogue import one_of_each_kind

PIXELS = (6000, 4000)
FILM = (36.0, 24.0)
AWAY = 50.0                     # default focus distance, in focal lengths from the film
DARK = 0.1                      # share of the light on the axis at which the film ends


@dataclass(frozen=True)
class Subject:
    """One lens in front of its film. key: its name or path; title: its name in words."""

    key: str
    title: str
    camera: lb.LensCamera


def subjects(arguments: argparse.Namespace) -> tuple[list[Subject], list[str]]:
    """The requested lenses, or a library lens of each kind; and a line for each lens that is left out, with the reason.

    Of several lenses, each is limited to its widest stop and to its nearest focus. A single lens raises the errors of a
    camera: ValueError, OSError.
    """
    if len(arguments.lens) == 1:
        return [subject(arguments.lens[0], arguments, exactly=True)], []
    lenses, left_out = [], []
    for name in arguments.lens or one_of_each_kind():
        try:
            lenses.append(subject(name, arguments, exactly=False))
        except (ValueError, OSError) as error:
            if arguments.lens:
                raise
            left_out.append(f"{name}: {error}")
    return lenses, left_out


def subject(name: str, arguments: argparse.Namespace, exactly: bool) -> Subject:
    """A lens with the settings of the arguments; exactly: an error instead of the nearest possible setting."""
    lens = design(replace(Settings(), lens=name, focal_length=arguments.focal_length).checked())
    lens = lens.at(zoom=asked_zoom(lens, arguments.zoom), close=0.0)
    efl, f_number = abs(lb.first_order(lens).efl), getattr(arguments, "f_number", None)
    focus = arguments.focus
    if focus is None or not exactly:
        focus = max(AWAY * efl if focus is None else focus, 1.02 * lb.nearest_focus(lens))
    if f_number is not None and not exactly:
        f_number = max(f_number, lb.first_order(lens).f_number)
    width, height = arguments.film or FILM
    pixels = arguments.size or PIXELS
    camera = lb.LensCamera(lens, lb.Film(width, height, *pixels), focus, f_number)
    if arguments.film is None:
        camera = replace(camera, film=_lit(camera, pixels))
    return Subject(name, lens.name or name, camera)


def _lit(camera: lb.LensCamera, pixels: tuple[int, int]) -> lb.Film:
    """The film reduced to the part that the lens lights."""
    film, radii = camera.film, 0.5 * camera.film.diagonal * np.geomspace(0.02, 1.0, 160)
    if not camera.lens.is_rotationally_symmetric:
        return film
    dark = np.flatnonzero(lb.falloff(camera.lens, camera.film_distance, radii).total < DARK)
    if not dark.size:
        return film
    share = radii[max(dark[0] - 1, 0)] / radii[-1]
    digits = 1 - math.floor(math.log10(share * film.width))
    width = round(share * film.width, digits)
    return lb.Film(width, width * film.height / film.width, *pixels)


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
    """The panels asked for; StoppedError where `progress` returns False; ValueError, OSError of the readers."""
    if arguments.of in PER_LENS:
        names = arguments.lens or (LENSES if arguments.of == "pupil" else FOCUS_LENSES)
        lenses, _ = subjects(argparse.Namespace(**{**vars(arguments), "lens": names}))
        made = [_of_lens(arguments.of, lens, share_of(progress, i, len(lenses))) for i, lens in enumerate(lenses)]
        if arguments.of == "pupil":                     # first row: light of all lenses; second: samples
            return [panel for row in zip(*made, strict=True) for panel in row]
        return [panel for row in made for panel in row]
    if arguments.of == "sampler":
        return sampling_panels(_known(arguments.scene or [], list(sampling_scenes())), progress)
    names = _known(arguments.scene or list(IMAGE_SCENES), list(lb.SCENES))
    focus = IMAGE_FOCUS if arguments.focus is None else arguments.focus
    changed = {"lens": arguments.lens or [LENSES[0]], "focus": focus}
    lenses, _ = subjects(argparse.Namespace(**{**vars(arguments), **changed}))
    pairs = [(lens, name) for lens in lenses for name in names]
    return [_of_scene(lens, name, share_of(progress, i, len(pairs)), len(lenses) > 1)
            for i, (lens, name) in enumerate(pairs)]


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


def share_of(progress: Callable[[float], bool], i: int, n: int) -> Callable[[float], bool]:
    """The progress of the i-th of n pieces of work, as the share of all of them."""
    return lambda share: progress((i + share) / n)
