"""Figures of the axis: longitudinal aberration by pupil height, and the focus by wavelength."""

import numpy as np

from lensbench.analysis.axial_curves import chromatic_focal_shift, longitudinal_aberration
from lensbench.app.state.analysis.figure import Axis, Curve, Figure, Plot, Table, reach, wavelength_name
from lensbench.app.state.analysis.query import Query
from lensbench.optics.finding import Kind


def axial_figure(query: Query, points: int) -> Figure:
    """Where axial rays cross the axis against their height in the stop, and the paraxial focus against wavelength.

    points: heights in the stop. LensError for a lens with a cylinder or toroid, and one without a focus.
    """
    query = query.lines
    given, away = query.conditions(), query.setup.film_distance
    along = longitudinal_aberration(query.lens, away, given, max(points, 9))
    shift = chromatic_focal_shift(query.lens, away, given)
    limit = reach(np.concatenate([along.foci.ravel(), shift.foci]))
    curves = [Curve(wavelength_name(line), foci, along.heights, line)
              for line, foci in zip(given.wavelengths, along.foci, strict=True)]
    zero = Curve("", np.zeros(2), np.array([0.0, 1.0]), "grid", weight=1.0)
    colours = 1000.0 * shift.wavelengths
    rest = Curve("", np.zeros(2), colours[[0, -1]], "grid", weight=1.0)
    focus = Axis("Focus (mm)", -limit, limit)
    table = Table(("wavelength (um)", "height in the stop", "focus behind the film (mm)"),
                  tuple((line, height, at) for line, foci in zip(given.wavelengths, along.foci, strict=True)
                        for height, at in zip(along.heights, foci, strict=True))
                  + tuple((line, 0.0, at) for line, at in zip(shift.wavelengths, shift.foci, strict=True)))
    return Figure("Longitudinal aberration and chromatic focal shift", ((
        Plot(focus, Axis("Height in the stop", 0.0, 1.0), (zero, *curves), "Longitudinal aberration",
             across=True),
        Plot(focus, Axis("Wavelength (nm)", colours[0], colours[-1]),
             (rest, Curve("paraxial focus", shift.foci, colours)),
             "Paraxial focus", across=True)),), table, query.words(None, "axis"),
        tuple(str(finding) for finding in given.findings if finding.kind in (Kind.GLASS, Kind.LEFT_OUT)))
