"""The analyses by name: what `lensbench analyse` offers."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from lensbench.app.plots.aperture_plots import (
    axial_figure, breathing_figure, focus_shift_figure, illumination_figure, stack_figure
)
from lensbench.app.plots.field_plots import depth_figure, field_figure
from lensbench.app.plots.light_plots import bokeh_figure, ghosts_figure, star_figure
from lensbench.app.plots.plot import Figure
from lensbench.app.plots.point_plots import (
    encircled_figure, line_spread_figure, mtf_field_figure, mtf_frequency_figure, mtf_map_figure, psf_figure
)
from lensbench.app.plots.query import Query
from lensbench.app.plots.ray_plots import fans_figure, grid_figure, seidel_figure, wavefront_figure
from lensbench.app.plots.spots import spots_figure


class Analysis(NamedTuple):
    """One analysis: its figure from a query and the points across the pupil, and what it shows in a few words.

    few: of a few fields, those that a query chooses; others run over the field, or have none.
    """

    figure: Callable[[Query, int], Figure]
    shows: str
    few: bool = False


ANALYSES = {
    "spots": Analysis(spots_figure, "spots of the fields through focus", few=True),
    "fans": Analysis(fans_figure, "transverse aberration over the height in the stop", few=True),
    "opd": Analysis(partial(fans_figure, kind="opd"), "optical path difference over the height in the stop", few=True),
    "field": Analysis(field_figure, "field curvature, distortion and lateral colour"),
    "grid": Analysis(grid_figure, "distortion as the image of a square grid"),
    "mtf": Analysis(mtf_field_figure, "MTF over the field at 10 and 30 lp/mm"),
    "mtf-frequency": Analysis(mtf_frequency_figure, "MTF against the frequency", few=True),
    "mtf-map": Analysis(mtf_map_figure, "MTF over focus and field"),
    "psf": Analysis(psf_figure, "picture of a point on the axis, four decades", few=True),
    "encircled": Analysis(encircled_figure, "encircled energy of three fields", few=True),
    "line-spread": Analysis(line_spread_figure, "line spread of three fields", few=True),
    "bokeh": Analysis(bokeh_figure, "pictures of points of light over field and distance", few=True),
    "wavefront": Analysis(wavefront_figure, "wavefront of the axis, with Zernike coefficients", few=True),
    "seidel": Analysis(seidel_figure, "Seidel sums of each surface"),
    "axial": Analysis(axial_figure, "longitudinal aberration and chromatic focal shift"),
    "focus-shift": Analysis(focus_shift_figure, "best focus against the aperture"),
    "breathing": Analysis(breathing_figure, "field of view against the focus distance"),
    "depth": Analysis(depth_figure, "depth of field over the field"),
    "stack": Analysis(stack_figure, "effect of the glass before a sensor, and of an adapter"),
    "sunstar": Analysis(star_figure, "rays of light that the blades draw about a small light"),
    "ghosts": Analysis(ghosts_figure, "images of a light at the corner by two reflections, ranked"),
    "illumination": Analysis(illumination_figure, "relative illumination, split into natural falloff and vignetting"),
}
