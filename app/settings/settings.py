"""Everything that a person can set, as one frozen value.

The window, the command line and an exported picture's metadata all hold the same Settings; a picture is a pure
function of them. Lengths in mm, angles in radians, exposure in stops. The fields are those of `setting_table`.
"""

import math
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene
from lensbench.app.settings.bodies import BODIES, Body
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS, MODEL_TITLES, CameraKind
from lensbench.app.settings.setting import MOTION, NOTHING, SettingsError, check, converted, spec
from lensbench.app.settings.setting_table import SHAPES, SettingTable
from lensbench.app.settings.text_values import read_ghost_pair
from lensbench.core.imaging.film import UPRIGHT, FilmPose
from lensbench.core.lazy import hashed_once
from lensbench.core.text import MOST_CHARACTERS, cut, excerpt

VERSION = 1                     # of the settings in a picture's metadata
PICTURES = (".png", ".ppm", ".exr")             # formats of pictures that carry their settings
CHOSEN = "chosen"               # key of the automatic model's choice there: a record, and no setting


@hashed_once
@dataclass(frozen=True)
class Settings(SettingTable):
    """All settings of a user, as one frozen value. Lengths in mm, angles in radians, times in seconds."""

    def __post_init__(self) -> None:
        if self.film_radius == math.inf:
            object.__setattr__(self, "film_radius", None)       # a flat film

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and words, with the version; infinity becomes "inf"."""
        plain = {name: "inf" if value == math.inf else value for name, value in asdict(self).items()}
        return {"version": VERSION, **plain}

    @classmethod
    def from_dict(cls, plain: dict[str, Any]) -> "Settings":
        """Read all or a part of `to_dict`; SettingsError for a newer version, unknown names, wrong kinds; FilmError."""
        version = plain.get("version")
        if not isinstance(version, int) or isinstance(version, bool):
            raise SettingsError("not a lensbench settings file: it has no `version`")
        if version > VERSION:
            raise SettingsError(f"these settings are of version {excerpt(version)}, "
                                f"newer than this lensbench reads ({VERSION}): update lensbench")
        unknown = sorted(set(plain) - {f.name for f in fields(cls)} - {"version", CHOSEN})
        if unknown:
            raise SettingsError("these settings have names that lensbench does not know: "
                                f"{cut(', '.join(cut(name) for name in unknown), 4 * MOST_CHARACTERS)}")
        values = {f.name: converted(f.name, f.type, plain[f.name]) for f in fields(cls) if f.name in plain}
        return replace(cls(), **values).checked()

    def checked(self) -> "Settings":
        """Itself; SettingsError or FilmError with the range where a value is invalid."""
        for field in fields(self):
            check(field, getattr(self, field.name))
        lb.Film(self.film_width, self.film_height, self.pixels_x, self.pixels_y)
        _ = self.film_pose
        try:
            read_ghost_pair(self.ghost_pair)
        except ValueError as error:
            raise SettingsError(f"ghost shown alone: {error}") from None
        return self

    @property
    def film(self) -> lb.Film:
        """The part of the film that is used, with its pixels."""
        return lb.Film(self.film_width * self.crop, self.film_height * self.crop, self.pixels_x, self.pixels_y)

    @property
    def sensor(self) -> Body | None:
        """The camera body that is chosen by name, while the film has the size of its sensor."""
        body = BODIES.get(self.body)
        return body if body is not None and body.size == (self.film_width, self.film_height) else None

    @property
    def pixel_pitch(self) -> float:
        """Size (mm) of a pixel that blur is counted in: of the camera body, else of the picture."""
        return self.film.pitch if self.sensor is None else self.sensor.pitch

    @property
    def film_pose(self) -> FilmPose:
        """Tilt, swing, rise, shift and curvature of the film; flat and centred for a camera without a lens."""
        radius = math.inf if self.film_radius is None else self.film_radius
        return FilmPose(self.tilt, self.swing, self.rise, self.shift, radius) if self.has_lens else UPRIGHT

    @property
    def kind(self) -> CameraKind:
        """The row of the camera in the table of camera kinds."""
        return CAMERA_KINDS[self.camera]

    @property
    def camera_title(self) -> str:
        """The title of the lens model, or of a camera without a lens."""
        return MODEL_TITLES[self.lens_model] if self.has_lens else self.kind.title

    @property
    def has_lens(self) -> bool:
        """Whether the camera uses the prescription."""
        return self.kind.has_lens

    @property
    def follows_lens(self) -> bool:
        """Whether the rays are those of the real lens, and not of an ideal camera."""
        return self.has_lens and LENS_MODELS[self.lens_model].follows_lens

    @property
    def is_automatic(self) -> bool:
        """Whether the program chooses the lens model."""
        return self.has_lens and LENS_MODELS[self.lens_model].automatic

    @property
    def has_stop(self) -> bool:
        """Whether the camera has an aperture with an iris."""
        return self.kind.has_stop and (not self.has_lens or LENS_MODELS[self.lens_model].has_stop)

    @property
    def has_f_number(self) -> bool:
        """Whether the setting `f_number` opens the stop."""
        return self.has_stop and self.kind.f_number

    @property
    def focuses(self) -> bool:
        """Whether the picture has a plane in focus."""
        return self.kind.focuses and self.has_stop

    @property
    def picture_shape(self) -> tuple[float, float]:
        """Width and height of the picture with square pixels, in any unit."""
        return SHAPES[self.layout] if self.kind.panorama else (self.film_width, self.film_height)

    @property
    def keyframed(self) -> bool:
        """Whether the camera goes from one keyframe to another."""
        return self.end_position is not None

    @property
    def moves(self) -> bool:
        """Whether the camera moves, or anything in the scene."""
        if self.keyframed:
            return True
        try:
            return cached_scene(self.scene).moves
        except (SceneFileError, OSError):           # the worker reports it
            return False

    @property
    def world_from_camera(self) -> np.ndarray:
        """Transform (4, 4) of the first keyframe, or of a camera without keyframes."""
        return placed(self.position, self.yaw, self.pitch)

    @property
    def placement(self) -> "np.ndarray | lb.AnimatedTransform":
        """Transform from the camera to the world; animated from 0 s to `duration` for a camera with two keyframes."""
        start = self.world_from_camera
        if self.end_position is None:
            return start
        end = placed(self.end_position, self.end_yaw, self.end_pitch)
        if self.moment >= self.duration:
            return end
        return start if np.array_equal(start, end) else lb.AnimatedTransform(start, end, 0.0, self.duration)

    @property
    def present_pose(self) -> np.ndarray:
        """Transform (4, 4) when the shutter opens."""
        placement = self.placement
        return placement.at(self.moment) if isinstance(placement, lb.AnimatedTransform) else placement

    def plain(self, *names: str) -> "Settings":
        """The same settings with these fields at their defaults."""
        made, values = object.__new__(Settings), vars(self)         # `replace` takes ten times as long
        vars(made).update({name: values[name] for name in DEFAULTS}, **{name: DEFAULTS[name] for name in names})
        return made

    @property
    def picture(self) -> "Settings":
        """The settings on which the rendered film depends; all others at their defaults."""
        return self._moving_picture if self.view == "time" or self.moves else self._still_picture

    @cached_property
    def _moving_picture(self) -> "Settings":
        return self._without(RESTARTS_NOTHING)

    @cached_property
    def _still_picture(self) -> "Settings":
        return self._without((*RESTARTS_NOTHING, *RESTARTS_MOTION))

    def _without(self, names: tuple[str, ...]) -> "Settings":
        """The settings without these fields; the coating counts where ghosts show it, strengths where they are seen."""
        unseen = [name for name, is_seen in (
            ("ghost_strength", self.ghosts), ("ghost_pair", self.ghosts), ("star_strength", self.stars)) if not is_seen]
        plain = self.plain(*names, *unseen)
        return replace(plain, coating=self.coating) if self.ghosts else plain

    @cached_property
    def optics(self) -> "Settings":
        """The settings on which lens, film and their read-outs depend; all others at their defaults."""
        return self.plain(*NO_FIGURES)

    @property
    def aim(self) -> "Settings":
        """The settings that aim the camera: `picture` without focus and aperture; focus breathing is neglected."""
        return self.picture._aim

    @cached_property
    def _aim(self) -> "Settings":
        return self.plain("visibility", "fog_light", "focus_position", "focus_distance", "f_number", "seed", "view",
                          "blades", "blade_rotation", "roundness", "stop_image")

    @property
    def sample_view(self) -> str:
        """The shown quantity of the samples, by its name in the core; "" for the picture itself."""
        return "" if self.view == "picture" else self.view


def placed(position: tuple[float, float, float], yaw: float, pitch: float) -> np.ndarray:
    """Pose (4, 4) at a position: yaw about y, then pitch about x of the camera, in radians."""
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ [[1, 0, 0], [0, cp, -sp], [0, sp, cp]]
    matrix[:3, 3] = position
    return matrix


DEFAULTS: dict[str, Any] = {field.name: field.default for field in fields(Settings)}
# Fields whose change never restarts a render; those that restart it only where something moves; those that lens, film
# and their figures do not depend on
RESTARTS_NOTHING = tuple(field.name for field in fields(Settings) if spec(field).restarts == NOTHING)
RESTARTS_MOTION = tuple(field.name for field in fields(Settings) if spec(field).restarts == MOTION)
NO_FIGURES = tuple(field.name for field in fields(Settings) if not spec(field).figures)


def differences(settings: Settings, other: Settings) -> dict[str, Any]:
    """The values of `settings` by name, where `other` has different ones."""
    return {field.name: getattr(settings, field.name) for field in fields(Settings)
            if getattr(settings, field.name) != getattr(other, field.name)}
