"""Values of settings in the text of their dials: lengths in mm or m, angles in degrees, times in s or ms."""

from collections.abc import Callable
from dataclasses import Field
from typing import Any

from lensbench.app.state.setting import spec
from lensbench.app.state.text_values import (
    format_angle,
    format_distance,
    format_duration,
    format_electrons,
    format_exposure,
    format_f_number,
    format_hole,
    format_length,
    format_light,
    format_part,
    format_signed_length,
    format_time,
    read_angle,
    read_aperture,
    read_distance,
    read_electrons,
    read_exposure,
    read_film_radius,
    read_length,
    read_light,
    read_part,
    read_signed_length,
    read_time,
)

READERS: dict[str, Callable[[str], Any]] = {"f_number": read_aperture}      # of settings whose option lies elsewhere
FORMS: dict[Callable[[str], Any], Callable[[float], str]] = {               # of the values that these read
    read_angle: format_angle, read_aperture: format_f_number, read_distance: format_distance,
    read_electrons: format_electrons, read_exposure: format_exposure, read_film_radius: format_signed_length,
    read_length: format_length, read_light: format_light, read_part: format_part,
    read_signed_length: format_signed_length, read_time: format_duration}
OWN_FORMS = {"shutter": format_time, "hole_diameter": format_hole}


def reader(of: Field) -> Callable[[str], Any] | None:
    """What reads the text that a user types for this field of Settings; None for one that is not typed."""
    return READERS.get(of.name) or spec(of).read


def value_text(of: Field, value: float) -> str:
    """The text of a value of this field of Settings (mm, radians, seconds or a plain number), as its dial shows it."""
    read = reader(of)
    form = OWN_FORMS.get(of.name) or (FORMS.get(read) if read is not None else None)
    return form(value) if form is not None else spec(of).shown(value)
