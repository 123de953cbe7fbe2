"""Settings of a light-field capture: its kind, views, samples and pixels."""

from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.constraints import with_longer_side
from lensbench.app.state.request import Request
from lensbench.app.state.settings import Settings

KINDS = {"lens": "Lens", "microlenses": "Microlenses", "array": "Array"}


@dataclass
class Form:
    """Entries of the capture form, and the panel's requests to the window."""

    kind: str = "lens"                                  # a key of KINDS
    views: int = 9                                      # across, and down; or the pixels behind a microlens
    samples: int = 16                                   # for each pixel of each view
    longer: int = 640                                   # pixels
    microlenses: int = 240                              # along the longer side
    f_number: float | None = None                       # of the microlenses; None: that which matches the lens
    moments: int = 1                                    # parts of the exposure that are kept apart
    spacing: float = 5.0                                # mm from pinhole to pinhole
    open: bool = False                                  # the form is shown although a recording exists
    requests: set[Request] = field(default_factory=set) # to the window

    def settings(self, present: Settings) -> Settings:
        """The present settings with the form's pixels and samples."""
        longer = self.microlenses if self.kind == "microlenses" else self.longer
        return replace(with_longer_side(present, longer), samples=self.samples, view="picture")

    def bytes(self, present: Settings) -> int:
        """Memory (bytes) that the recording will take."""
        film, square = self.settings(present).film, (self.views, self.views)
        if self.kind == "lens":
            with suppress(ValueError, OSError):         # which recording reports
                return _recorded(self.settings(present).picture, square, self.moments)
        size = lb.light_field_bytes(film, square)
        return size if self.kind != "microlenses" else size + lb.light_field_bytes(film, square, np.float32)

    def plenoptic(self, present: Settings) -> lb.PlenopticCamera:
        """The plenoptic camera; raises as `lb.PlenopticCamera` for impossible entries."""
        return _plenoptic(self.settings(present).picture, self.views, self.f_number)


@lru_cache(maxsize=4)
def _recorded(settings: Settings, views: tuple[int, int], moments: int) -> int:
    return lb.recording_bytes(camera(settings), views, moments=moments)


@lru_cache(maxsize=4)
def _plenoptic(settings: Settings, pixels: int, f_number: float | None) -> lb.PlenopticCamera:
    return lb.PlenopticCamera(camera(settings), pixels, f_number)
