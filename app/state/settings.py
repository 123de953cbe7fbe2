"""Everything that a person can set, as one frozen value.

The window, the command line and an exported picture's metadata all hold the
same Settings; a picture is a pure function of them. Lengths in mm, angles in
radians, exposure in stops.
"""

import math
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property, lru_cache
from types import UnionType
from typing import Any, get_args, get_origin

import numpy as np

import lensbench as lb
from lensbench.lens_models.polynomial import DEGREES
from lensbench.optics.iris import MOST_BLADES

VERSION = 3                     # of the settings in a picture's metadata
CHOSEN = "chosen"               # there, what the automatic model came to: a record, and no setting
MODELS = {                      # the cameras that the bench offers
    "auto": "Automatic",
    "trace": "Full lens trace",
    "polynomial": "Fitted polynomial",
    "thick": "Thick lens",
    "thin": "Thin lens",
    "pinhole": "Pinhole",
    "table": "Table of rays",
    "perspective": "Perspective, no lens",
    "orthographic": "Orthographic",
    "fisheye": "Ideal fisheye",
    "environment": "Panorama",
    "hole": "Pinhole of finite size",
    "bare": "Bare sensor, no lens",
}
REAL = ("auto", "trace", "polynomial", "table")     # those of them that follow the real lens
LENSLESS = ("perspective", "orthographic", "fisheye", "environment", "hole", "bare")    # without a prescription
PROJECTIONS = {                 # of the ideal fisheye: what the angle from the axis becomes on the film
    "equidistant": "Equidistant, r = f θ",
    "equisolid": "Equisolid, r = 2f sin θ/2",
    "stereographic": "Stereographic, r = 2f tan θ/2",
    "orthographic": "Orthographic, r = f sin θ",
}
LAYOUTS = {"equirectangular": "Equirectangular", "equal-area": "Equal area", "cube-map": "Cube map"}
SHAPES = {"equirectangular": (2, 1), "equal-area": (1, 1), "cube-map": (4, 3)}     # of a panorama with square pixels
FOV_AXES = {"shorter": "Shorter side", "longer": "Longer side", "horizontal": "Width", "vertical": "Height",
            "diagonal": "Diagonal"}
DISPERSIONS = {"auto": "Where the glasses are known", "on": "On", "off": "Off"}
FOCUS_POSITIONS = {"auto": "Automatic", "paraxial": "Paraxial", "real": "Least blur"}
READOUT_DIRECTIONS = {"down": "Down", "up": "Up", "left": "Left", "right": "Right"}          # in the upright picture
MEDIUMS = {"air": "Air", "fog": "Fog", "water": "Water"}
EXPOSURES = {"plain": "As it is", "triangle": "Exposed", "automatic": "Auto ISO"}
METERINGS = {"mean": "Average", "highlights": "Highlights"}
BITS = (8, 10, 12, 14, 16)
TONES = {"none": "None", "filmic": "Filmic", "agx": "AgX-like"}
OVERLAYS = {"none": "None", "coc": "Circle of confusion", "peaking": "Focus peaking", "clipping": "Clipping zebra"}
VIEWS = {                       # what is shown: the picture, or what its samples are
    "picture": "Picture",
    "direction": "Ray direction",
    "origin": "Ray origin",
    "fate": "Fate of the rays",
    "time": "Time",
    "depth": "Depth",
    "weight": "Sample weight",
}
COMPARISONS = {"off": "Off", "side": "Side by side", "wipe": "Wipe", "difference": "Difference"}
# Fields that never restart a render; those of motion, which only what moves reads; those of the camera's place
LOOK = ("samples", "exposure", "tone", "overlay", "compare", "wipe", "limit", "exposing", "metering", "iso", "noise",
        "full_well", "quantum_efficiency", "read_noise", "bits")
MOTION = ("end_position", "end_yaw", "end_pitch", "duration", "moment", "shutter", "shutter_ramp", "readout",
          "readout_direction")
PLACE = ("position", "yaw", "pitch")
LIMITS = {"diagonal": "Diagonal / 1500", "pixel": "One pixel"}


FINITE = ("film_width", "film_height", "crop", "fov", "fisheye_fov", "yaw", "pitch", "end_yaw", "end_pitch", "moment",
          "blade_rotation", "exposure")
# What must be positive, and what may be 0 as well: its words and its unit
POSITIVE = {"focal_length": ("focal length", " mm"), "scene_width": ("width of the scene", " mm"),
            "hole_distance": ("film distance", " mm"), "hole_diameter": ("hole", " mm"), "duration": ("duration", " s"),
            "shutter": ("shutter", " s"), "iso": ("ISO", ""), "full_well": ("full well", " electrons"),
            "f_number": ("f-number", ""), "visibility": ("visibility", " mm")}
NOT_NEGATIVE = {"lens_radius": ("lens radius", " mm"), "readout": ("read-out", " s"),
                "read_noise": ("read noise", " electrons"), "fog_light": ("light of the fog", "")}


class SettingsError(ValueError):
    """Settings that cannot be; the message says what to do."""


@dataclass(frozen=True)
class Settings:
    """What a person set. Fields from `exposure` on never restart a render."""

    lens: str = "pbrt-dgauss-50mm"          # a library name, or a path
    focal_length: float | None = None       # scale the whole prescription to this EFL; None: as it was designed
    zoom: float = 0.0                       # of a zoom lens, 0 (wide) to 1 (tele); focus moves its groups
    scene: str = "still-life"               # a built-in name, or a path to a scene file
    model: str = "auto"                     # a key of MODELS
    degree: int = 9                         # of the fitted polynomial: one of DEGREES
    dispersion: str = "auto"                # of the models that follow the real lens: a key of DISPERSIONS
    splats: bool = True                     # whether small lights are traced from their own side
    film_width: float = 36.0
    film_height: float = 24.0
    crop: float = 1.0                       # part of the film that is used, (0, 1]: the field of view
    fov: float = 0.6                        # of the perspective camera alone, along fov_axis
    fov_axis: str = "shorter"               # of the perspective camera and the ideal fisheye: a key of FOV_AXES
    fisheye_fov: float = math.pi            # of the ideal fisheye, along fov_axis
    projection: str = "equidistant"         # of the ideal fisheye: a key of PROJECTIONS
    layout: str = "equirectangular"         # of the panorama: a key of LAYOUTS
    scene_width: float = 1500.0             # of the orthographic camera: mm of scene across the film
    hole_distance: float = 50.0             # of the pinhole of finite size: hole → film, mm
    hole_diameter: float | None = None      # of that hole, mm; None: the sharpest
    lens_radius: float = 0.0                # of the orthographic camera, mm: how wide its rays part; 0: parallel
    pixels_x: int = 960
    pixels_y: int = 640
    f_number: float | None = 2.8            # None: wide open
    blades: int | None = None               # of the stop, 0 for a circle; None: as the lens was designed
    blade_rotation: float = 0.0             # counter-clockwise, of the blades that are set here
    roundness: float = 0.0                  # of these blades: 0 straight, 1 a circle
    focus_distance: float = 1200.0          # from the film; math.inf is allowed
    focusing: str = "auto"                  # where the film stands for that, behind a real lens: a key of FOCUSINGS
    medium: str = "air"                     # before the camera: a key of MEDIUMS
    visibility: float = 10_000.0            # of fog and water, mm: there black has a fiftieth of its contrast
    fog_light: float = 0.5                  # the radiance that fog and water scatter into the view
    wet: bool = False                       # whether the lens itself stands in the water, and no flat window before it
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)     # of the camera in the world
    yaw: float = 0.0                        # to the left is positive
    pitch: float = 0.0                      # up is positive
    end_position: tuple[float, float, float] | None = None     # of the second keyframe; None: the camera stands still
    end_yaw: float = 0.0
    end_pitch: float = 0.0
    duration: float = 1.0                   # from the first keyframe to the second, s
    moment: float = 0.0                     # when the shutter opens, s after the first keyframe
    shutter: float = 1.0 / 125.0            # for how long it is open, s
    shutter_ramp: float = 0.0               # in which it opens, and in which it closes: a part of `shutter`, up to 1/2
    readout: float = 0.0                    # from the opening of the first line to that of the last, s; 0: at once
    readout_direction: str = "down"         # a key of READOUTS
    samples: int = 256                      # where the render stops
    seed: int = 0
    view: str = "picture"                   # a key of VIEWS
    exposure: float = 0.0
    exposing: str = "plain"                 # what makes the picture bright, beside `exposure`: a key of EXPOSURES
    metering: str = "mean"                  # of the automatic exposure: a key of METERINGS
    iso: float = 100.0
    noise: bool = False                     # whether the picture is what a sensor makes of the light
    full_well: float = 50_000.0             # electrons
    quantum_efficiency: float = 0.5         # electrons a photon
    read_noise: float = 3.0                 # electrons, rms
    bits: int = 14                          # one of BITS
    tone: str = "filmic"
    overlay: str = "none"
    compare: str = "off"                    # with the picture A: a key of COMPARISONS
    wipe: float = 0.5                       # where A ends and B begins, as a part of the picture's width
    limit: str = "diagonal"                 # of the circle of confusion, for the depth of field

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, with the version; infinity becomes "inf"."""
        plain = {name: "inf" if value == math.inf else value for name, value in asdict(self).items()}
        return {"version": VERSION, **plain}

    @classmethod
    def from_dict(cls, plain: dict[str, Any]) -> "Settings":
        """Read what to_dict wrote, or a part of it; SettingsError for a newer version, unknown names or values of a
        wrong kind, FilmError for a film that cannot be.
        """
        version = plain.get("version")
        if not isinstance(version, int):
            raise SettingsError("these settings carry no version: they are not of lensbench")
        if version > VERSION:
            raise SettingsError(f"these settings are of version {version}, "
                                f"newer than this lensbench reads ({VERSION}): update lensbench")
        known = {f.name for f in fields(cls)}
        unknown = sorted(set(plain) - known - {"version", CHOSEN})
        if unknown:
            raise SettingsError(f"these settings have names that lensbench does not know: {', '.join(unknown)}")
        before = {"focusing": "paraxial"} if version < 3 else {}            # there was no choice
        given = {f.name: _of_kind(f.name, f.type, plain[f.name]) for f in fields(cls) if f.name in plain}
        return replace(cls(), **{**before, **given}).checked()

    def checked(self) -> "Settings":
        """Itself, or a SettingsError or FilmError that says which value cannot be."""
        for name, choices in (("model", MODELS), ("tone", TONES), ("overlay", OVERLAYS), ("limit", LIMITS),
                              ("view", VIEWS), ("compare", COMPARISONS), ("dispersion", DISPERSIONS),
                              ("focusing", FOCUS_POSITIONS), ("fov_axis", FOV_AXES), ("projection", PROJECTIONS),
                              ("layout", LAYOUTS), ("readout_direction", READOUT_DIRECTIONS),
                              ("medium", MEDIUMS), ("exposing", EXPOSURES), ("metering", METERINGS), ("bits", BITS),
                              ("degree", DEGREES)):
            if getattr(self, name) not in choices:
                raise SettingsError(f"{name} {getattr(self, name)!r}: choose one of {', '.join(map(str, choices))}")
        if not 0 <= self.seed < 1 << 32:
            raise SettingsError(f"seed {self.seed!r}: it must be a whole number from 0 to {(1 << 32) - 1}")
        for name in FINITE:
            if not math.isfinite(getattr(self, name)):
                raise SettingsError(f"{name} is {getattr(self, name)}: it must be a finite number")
        for table, zero in ((POSITIVE, False), (NOT_NEGATIVE, True)):
            for name, (what, unit) in table.items():
                value = getattr(self, name)
                if value is not None and not (math.isfinite(value) and (value > 0.0 or zero and value == 0.0)):
                    raise SettingsError(f"{what} {value:g}{unit}: it must be "
                                        + ("0 or positive" if zero else "a positive number"))
        for name in ("position", "end_position"):
            if not all(math.isfinite(x) for x in getattr(self, name) or ()):
                raise SettingsError(f"{name} {getattr(self, name)}: it must be three finite numbers")
        if not 0.0 < self.quantum_efficiency <= 1.0:
            raise SettingsError(f"quantum efficiency {self.quantum_efficiency:g}: it must lie between 0 and 1")
        if not (self.blades is None or self.blades == 0 or 3 <= self.blades <= MOST_BLADES):
            raise SettingsError(f"{self.blades} blades: a stop has 3 to {MOST_BLADES} of them, or 0 for a circle")
        if not 0.0 <= self.roundness <= 1.0:
            raise SettingsError(f"roundness {self.roundness:g}: it must lie from 0 (straight blades) to 1 (a circle)")
        if not 0.0 <= self.shutter_ramp <= 0.5:
            raise SettingsError(f"shutter ramp {self.shutter_ramp:g}: it must lie from 0 to 0.5 of the shutter time")
        if not 0.0 <= self.zoom <= 1.0:
            raise SettingsError(f"zoom {self.zoom:g}: it must lie from 0 (wide) to 1 (tele)")
        if not 0.0 <= self.wipe <= 1.0:
            raise SettingsError(f"wipe {self.wipe:g}: it must lie from 0 to 1")
        if not 0.0 < self.crop <= 1.0:
            raise SettingsError(f"crop {self.crop:g}: it must lie between 0 and 1")
        if not 0.0 < self.fov < math.pi:
            raise SettingsError(f"field of view {math.degrees(self.fov):g}°: it must lie between 0° and 180°")
        if not 0.0 < self.fisheye_fov < 2.0 * math.pi:
            raise SettingsError(f"field of view {math.degrees(self.fisheye_fov):g}°: of a fisheye it must lie between "
                                "0° and 360°")
        if math.isnan(self.focus_distance) or self.focus_distance <= 0.0:
            raise SettingsError(f"focus distance {self.focus_distance:g} mm: it must be positive")
        if self.samples < 1:
            raise SettingsError(f"{self.samples} samples: at least 1 is needed")
        lb.Film(self.film_width, self.film_height, self.pixels_x, self.pixels_y)
        return self

    @property
    def film(self) -> lb.Film:
        """The part of the film that is used, with its pixels."""
        return lb.Film(self.film_width * self.crop, self.film_height * self.crop, self.pixels_x, self.pixels_y)

    @property
    def lensless(self) -> bool:
        """Whether the camera uses no prescription."""
        return self.model in LENSLESS

    @property
    def focuses(self) -> bool:
        """Whether its picture has a plane in focus."""
        return self.model not in ("pinhole", "fisheye", "environment", "hole", "bare")

    @property
    def keyframed(self) -> bool:
        """Whether the camera goes from one keyframe to another."""
        return self.end_position is not None

    @property
    def moves(self) -> bool:
        """Whether the camera moves, or anything before it."""
        return self.keyframed or _scene_moves(self.scene)

    @property
    def world_from_camera(self) -> np.ndarray:
        """(4, 4) of the first keyframe, or of the camera that stands still."""
        return _placed(self.position, self.yaw, self.pitch)

    @property
    def placement(self) -> "np.ndarray | lb.AnimatedTransform":
        """Where the camera stands: animated from 0 s to `duration` where it goes while the shutter is open."""
        start = self.world_from_camera
        if self.end_position is None:
            return start
        end = _placed(self.end_position, self.end_yaw, self.end_pitch)
        if self.moment >= self.duration:
            return end
        return start if np.array_equal(start, end) else lb.AnimatedTransform(start, end, 0.0, self.duration)

    @property
    def present_place(self) -> np.ndarray:
        """(4, 4) when the shutter opens."""
        place = self.placement
        return place.at(self.moment) if isinstance(place, lb.AnimatedTransform) else place

    def plain(self, *names: str) -> "Settings":
        """With these fields as they are by default."""
        default = Settings()
        return replace(self, **{name: getattr(default, name) for name in names})

    @cached_property
    def picture(self) -> "Settings":
        """What the rendered film depends on: everything else is set to its default."""
        timed = self.moves or self.view == "time"
        return self.plain(*LOOK) if timed else self.plain(*LOOK, *MOTION)

    @cached_property
    def aim(self) -> "Settings":
        """What each place of the picture looks at: `picture` without focus and aperture, a little breathing aside."""
        return self.picture.plain("visibility", "fog_light", "focusing", "focus_distance", "f_number", "seed", "view",
                                  "blades", "blade_rotation", "roundness")

    @property
    def sample_view(self) -> str:
        """What of the samples is shown in place of the light, as the core names it; "" for the picture itself."""
        return "" if self.view == "picture" else self.view


@lru_cache(maxsize=1)
def _scene_moves(scene: str) -> bool:
    """Whether anything moves in a scene; a file is looked at when it is chosen."""
    from lensbench.app.state.scene_file import find_scene

    try:
        return find_scene(scene).moves
    except (ValueError, OSError):               # the worker's to report
        return False


def _placed(position: tuple[float, float, float], yaw: float, pitch: float) -> np.ndarray:
    """(4, 4): yaw about y, then pitch about the camera's x, at the position."""
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ [[1, 0, 0], [0, cp, -sp], [0, sp, cp]]
    matrix[:3, 3] = position
    return matrix


def _of_kind(name: str, kind: Any, value: Any) -> Any:
    """The value as one of the field's type; SettingsError where it is of another."""
    if isinstance(kind, UnionType):                     # of one kind and None
        return None if value is None else _of_kind(name, get_args(kind)[0], value)
    if get_origin(kind) is tuple:
        kinds = get_args(kind)
        if not isinstance(value, list | tuple) or len(value) != len(kinds):
            raise SettingsError(f"{name} is {value!r}: it must be {len(kinds)} numbers")
        return tuple(_of_kind(name, kind, part) for kind, part in zip(kinds, value, strict=True))
    if kind is float and value == "inf":
        return math.inf
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if type(value) is not kind:
        what = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}[kind]
        raise SettingsError(f"{name} is {value!r}: it must be {what}")
    return value
