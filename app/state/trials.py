"""Three pictures for the first minutes: a lens and a scene that show at once what a lens does."""

from dataclasses import dataclass, replace

from lensbench.app.state.constraints import constrained
from lensbench.app.state.lens_choice import with_lens
from lensbench.app.state.settings import Settings
from lensbench.kernels.cache import resumable


@dataclass(frozen=True)
class Trial:
    """One picture. about: what to look at and what to turn next. f_number None: wide open."""

    title: str
    about: str
    lens: str
    scene: str
    f_number: float | None = None
    blades: int | None = None


TRIALS = (
    Trial("Swirl", "A Biotar of 1927, wide open. Its rims cut the blur at the edge to cat's eyes that turn about the "
          "middle. Turn Aperture towards f/4: the swirl goes", "lentil-zeiss-biotar-1927", "foliage"),
    Trial("Fisheye", "180° on one picture, by the real rays of a design of 1964. Move the mouse to the edge of the "
          "circle: the section shows where its rays enter", "lib-miyamoto-fisheye-1964", "room"),
    Trial("Hexagon bokeh", "Six straight blades at f/2: lights out of focus are images of the stop. Turn Aperture, "
          "focus on a light by a click, or set the blades by the button Stop", "canon-rf-l-usm-85-f12", "night-lights",
          2.0, 6),
)


@resumable
def tried(settings: Settings, trial: Trial) -> Settings:
    """The settings of a trial, with the pixels and the samples of the present ones.

    LensFileError, LensError or OSError if its lens cannot be read.
    """
    plain = replace(Settings(), scene=trial.scene, samples=settings.samples, pixels_x=settings.pixels_x,
                    pixels_y=settings.pixels_y)
    return constrained(replace(with_lens(plain, trial.lens), f_number=trial.f_number, blades=trial.blades))
