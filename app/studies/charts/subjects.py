"""Lenses to chart, each in front of a film: from the arguments of the command, or one of each kind. Lengths in mm."""

import argparse
import math
from dataclasses import dataclass, replace

import numpy as np

import lensbench as lb
from lensbench.app.state.build import design
from lensbench.app.state.settings import Settings
from lensbench.app.state.zoom import asked_zoom
from lensbench.lenses.catalogue import one_of_each_kind

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
    found, left_out = [], []
    for name in arguments.lens or one_of_each_kind():
        try:
            found.append(subject(name, arguments, exactly=False))
        except (ValueError, OSError) as error:
            if arguments.lens:
                raise
            left_out.append(f"{name}: {error}")
    return found, left_out


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
    part = radii[max(dark[0] - 1, 0)] / radii[-1]
    digits = 1 - math.floor(math.log10(part * film.width))
    width = round(part * film.width, digits)
    return lb.Film(width, width * film.height / film.width, *pixels)
