"""The table of settings: one field each, with its unit, range, choices, command-line option, and what it restarts.

The metadata of each field is a Spec (see `setting`). Lengths in mm, angles in radians, exposure in stops. A new setting
is one field here; `settings` has what follows from the values.
"""

import math
from dataclasses import dataclass

from lensbench.app.settings.bodies import BODIES
from lensbench.app.settings.camera_facts import CAMERAS, LENS_MODELS, MODEL_TITLES, LensSettings
from lensbench.app.settings.setting import (
    ANGLE, DISTANCE, LENGTH, MOMENT, MOTION, NOTHING, PART, PLACE, SPAN, Interval, setting
)
from lensbench.app.settings.text_values import (
    read_angle, read_count, read_distance, read_electrons, read_exposure, read_film_radius, read_ghost_pair, read_iso,
    read_length, read_light, read_part, read_position, read_seed, read_signed_length, read_time, read_whole
)
from lensbench.core.imaging.film import MAX_SIDE, STEEPEST
from lensbench.core.imaging.spectrum import WHITES
from lensbench.core.lens_models.polynomial import DEGREES
from lensbench.core.optics.iris import MOST_BLADES
from lensbench.core.scenery.values import FRAMING_NAMES

LARGEST_SEED = (1 << 32) - 1
LEAN = Interval(-STEEPEST, STEEPEST)
MOVED = Interval(-1000.0, 1000.0)   # mm
CURVED = Interval(-1e6, 1e6, infinite=True)    # mm
NARROWEST = math.radians(0.001)  # field of view
PROJECTIONS = {                 # of the ideal fisheye: from the angle to the axis to the radius on the film
    "equidistant": "Equidistant, r = f θ",
    "equisolid": "Equisolid, r = 2f sin θ/2",
    "stereographic": "Stereographic, r = 2f tan θ/2",
    "orthographic": "Orthographic, r = f sin θ",
}
LAYOUTS = {"equirectangular": "Equirectangular", "equal-area": "Equal area", "cube-map": "Cube map"}
SHAPES = {"equirectangular": (2, 1), "equal-area": (1, 1), "cube-map": (4, 3)}     # of a panorama with square pixels
FOV_AXES = {"shorter": "Shorter side", "longer": "Longer side", "horizontal": "Width", "vertical": "Height",
            "diagonal": "Diagonal"}
DISPERSIONS = {"auto": "Where there is dispersion data", "on": "On", "off": "Off"}
FOCUS_POSITIONS = {"auto": "Best contrast", "real": "Least blur", "paraxial": "Paraxial"}
READOUT_DIRECTIONS = {"down": "Down", "up": "Up", "left": "Left", "right": "Right"}     # in the upright picture
MEDIUMS = {"air": "Air", "fog": "Fog", "water": "Water"}
EXPOSURES = {"plain": "As it is", "triangle": "Exposed", "automatic": "Auto ISO"}
METERINGS = {"mean": "Average", "highlights": "Highlights"}
BITS = (8, 10, 12, 14, 16)
TONES = {"none": "None", "filmic": "Filmic", "agx": "AgX-like"}
OVERLAYS = {"none": "None", "coc": "Circle of confusion", "peaking": "Focus peaking", "clipping": "Clipping zebra",
            "plane": "Plane of focus"}
DEEP = ("coc", "peaking", "plane")      # overlays that need the depth of what is seen
VIEWS = {                       # what is shown: the picture, or a quantity of its samples
    "picture": "Picture",
    "direction": "Ray direction",
    "origin": "Ray origin",
    "fate": "Fate of the rays",
    "time": "Time",
    "depth": "Depth",
    "weight": "Sample weight",
}
FRAMINGS = {name: name.replace("-", " ").capitalize() for name in FRAMING_NAMES}
COMPARISONS = {"off": "Off", "side": "Side by side", "wipe": "Wipe", "difference": "Difference"}
LIMITS = {"diagonal": "Diagonal / 1500", "pixel": "One pixel"}


@dataclass(frozen=True)
class SettingTable(LensSettings):
    """All settings with their defaults. Lengths in mm, angles in radians, times in seconds."""

    zoom: float = setting(0.0, bounds=PART, rule="it must lie from 0 (wide) to 1 (tele)")
    scene: str = setting("still-life", figures=False)   # a built-in name, or a path to a scene file
    camera: str = setting(
        "lens", choices=CAMERAS, metavar="KIND", help="which camera: lens (by default), " + ", ".join(
            f"{name} ({title[0].lower() + title[1:]})" for name, title in CAMERAS.items() if name != "lens"))
    lens_model: str = setting(
        "auto", choices=MODEL_TITLES, metavar="MODEL",
        help="how the camera “lens” models its lens: auto (the simplest that is accurate enough, by default), "
        + ", ".join(f"{name} ({title[0].lower() + title[1:]})" for name, title in MODEL_TITLES.items()
                    if not LENS_MODELS[name].automatic))
    degree: int = setting(9, choices=DEGREES, read=read_count, metavar="N",
                          help="degree of the fitted polynomial: " + ", ".join(map(str, DEGREES)))
    dispersion: str = setting(
        "auto", choices=DISPERSIONS, help="colour errors of the lens: traced where there is "
        "dispersion data (auto), on (an error where they are not), or off")
    light_tracing: bool = setting(
        True, figures=False,
        help="trace small lights from the light to the film, so that their blur is smooth at once (by default), or not")
    ghosts: bool = setting(
        False, figures=False,
        help="add the ghosts of the sun and of small lights: light that two surfaces of the lens reflect to the film")
    ghost_strength: float = setting(
        1.0, "strength of the ghosts", bounds=Interval(0.0, 1000.0), figures=False, read=read_part, metavar="FACTOR",
        help="on the light of the ghosts; 1, by default, is true to scale with the direct light")
    ghost_pair: str = setting(
        "", "ghost shown alone", figures=False, read=read_ghost_pair, metavar="I-J",
        help="show the ghost of these two surfaces alone, numbered from 0 at the scene, such as 3-7")
    stars: bool = setting(
        False, figures=False,
        help="add the stars of the sun and of small lights: light that the edges of the blades diffract about them")
    star_strength: float = setting(
        1.0, "strength of the stars", bounds=Interval(0.0, 1000.0), figures=False, read=read_part, metavar="FACTOR",
        help="on the light of the stars; 1, by default, is true to scale with the direct light")
    film_width: float = setting(36.0, unit="mm", bounds=LENGTH)
    film_height: float = setting(24.0, unit="mm", bounds=LENGTH)
    body: str = setting("", "camera body", choices={"": "None"} | {name: name for name in BODIES}, restarts=NOTHING,
                        figures=True, rule="choose one of those in the list Format")
    crop: float = setting(1.0, bounds=Interval(1e-4, 1.0))     # part of the film that is used, by length
    fov: float = setting(0.6, "field of view", "°", Interval(NARROWEST, math.radians(179.99)))
    fov_axis: str = setting("shorter", choices=FOV_AXES,
                            help="side of the film for the field of view of a perspective or fisheye camera")
    fisheye_fov: float = setting(math.pi, "field of view of a fisheye", "°", Interval(NARROWEST, math.radians(359.99)))
    projection: str = setting("equidistant", choices=PROJECTIONS,
                              help="of the ideal fisheye: how an angle from the axis becomes a radius on the film")
    layout: str = setting("equirectangular", choices=LAYOUTS, help="of the panorama")
    scene_width: float = setting(
        1500.0, "width of the scene", "mm", Interval(1e-3, 1e9), read=read_distance, metavar="DISTANCE",
        help="width of the scene on the film of the orthographic camera, such as 1.5m")
    hole_distance: float = setting(
        50.0, "film distance", "mm", LENGTH, read=read_length, metavar="LENGTH",
        help="of the pinhole of finite size: distance from the hole to the film, such as 50mm")
    hole_diameter: float | None = setting(
        None, "hole", "mm", Interval(1e-3, 1e4), none="sharpest", read=read_length, metavar="LENGTH",
        help="of the pinhole of finite size, such as 0.3mm; the sharpest by default")
    lens_radius: float = setting(
        0.0, unit="mm", bounds=Interval(0.0, 1e6), read=read_length, metavar="LENGTH",
        help="of the orthographic camera: radius of its opening, for a depth of field; 0 for parallel rays")
    tilt: float = setting(0.0, "tilt of the film", "°", LEAN, read=read_angle, metavar="ANGLE",
                          help="of the film about its horizontal middle: the top goes back, such as 5; near ground "
                          "comes into focus")
    swing: float = setting(0.0, "swing of the film", "°", LEAN, read=read_angle, metavar="ANGLE",
                           help="of the film about its vertical middle: the right side goes back")
    rise: float = setting(0.0, unit="mm", bounds=MOVED, read=read_signed_length, metavar="LENGTH",
                          help="of the lens over the film's centre, such as 10mm: the picture shows what is higher; "
                          "with a minus, write --rise=-10mm")
    shift: float = setting(0.0, unit="mm", bounds=MOVED, read=read_signed_length, metavar="LENGTH",
                           help="of the lens to the right of the film's centre: the picture shows more of the right")
    film_radius: float | None = setting(
        None, "radius of the film", "mm", CURVED, none="flat", read=read_film_radius, metavar="LENGTH",
        help="of a film that is curved as a sphere; with a minus, as in --film-radius=-90mm, its sides come nearer to "
        "the lens; flat by default")
    pixels_x: int = setting(960, "pixels across", bounds=Interval(1, MAX_SIDE))
    pixels_y: int = setting(640, "pixels down", bounds=Interval(1, MAX_SIDE))
    f_number: float | None = setting(2.8, "f-number", bounds=Interval(0.01, 1e4), none="open")     # None: wide open
    blades: int | None = setting(
        None, choices=(0, *range(3, MOST_BLADES + 1)), none="designed", read=read_whole, metavar="N",
        rule=f"a stop has 3 to {MOST_BLADES} of them, or 0 for a circle",
        help="number of blades of the iris, 0 for a circle")
    blade_rotation: float = setting(0.0, unit="°", bounds=ANGLE, read=read_angle, metavar="ANGLE",
                                    help="rotation of these blades, counter-clockwise")
    roundness: float = setting(
        0.0, bounds=PART, rule="it must lie from 0 (straight blades) to 1 (a circle)", read=read_part, metavar="PART",
        help="of these blades: 0%% for straight ones, 100%% for a circle")
    stop_image: str = setting(
        "", "picture in the stop", read=str, metavar="FILE",
        help="picture whose shape the stop takes instead of blades: white passes, black is opaque; its longer side "
        "is the diameter of the stop")
    focus_distance: float = setting(
        1200.0, unit="mm", bounds=DISTANCE._replace(infinite=True), read=read_distance, metavar="DISTANCE",
        option="focus",
        help="from the film to the object in focus: 1.2m, 120cm, inf; metres where no unit is given. Without it and "
        "without a position of the camera, the camera is placed where it frames the scene's subject in focus")
    focus_position: str = setting(
        "auto", choices=FOCUS_POSITIONS,
        help="position of the film behind a real lens: best contrast of 30 lp/mm on the axis (auto, by default), the "
        "least blur of all rays (real), or the paraxial focus (paraxial)")
    medium: str = setting("air", choices=MEDIUMS, help="the medium before the camera")
    visibility: float = setting(
        10_000.0, unit="mm", bounds=DISTANCE, figures=False, read=read_distance, metavar="DISTANCE",
        help="of fog or water: distance at which a black object keeps 2%% of its contrast, such as 10m")
    fog_light: float = setting(0.5, "light of the fog", bounds=Interval(0.0, 1e6), figures=False, read=read_light,
                               metavar="L", help="radiance that fog or water scatters into the view")
    immersed: bool = setting(False,
                             help="put the lens itself into the water, without a flat window before it")
    position: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0), unit="mm", bounds=PLACE, figures=False, read=read_position, metavar="X,Y,Z",
        help="of the camera, such as 0,20cm,1m; with a minus first, write --position=-1m,0,0")
    framing: str = setting(
        "subject", choices=FRAMINGS, restarts=NOTHING, metavar="NAME",
        help="what the camera is framed on, of those that the scene has: " + ", ".join(FRAMINGS))
    yaw: float = setting(0.0, bounds=ANGLE, unit="°", figures=False, read=read_angle, metavar="ANGLE",
                         help="turn the camera to the left")
    pitch: float = setting(0.0, bounds=ANGLE, unit="°", figures=False, read=read_angle, metavar="ANGLE",
                           help="turn the camera up")
    end_position: tuple[float, float, float] | None = setting(
        None, unit="mm", bounds=PLACE, restarts=MOTION, none="none", read=read_position, metavar="X,Y,Z",
        help="of a second keyframe: the camera moves there from --position in --duration")
    end_yaw: float = setting(0.0, bounds=ANGLE, unit="°", restarts=MOTION, read=read_angle, metavar="ANGLE",
                             help="of the second keyframe")
    end_pitch: float = setting(0.0, bounds=ANGLE, unit="°", restarts=MOTION, read=read_angle, metavar="ANGLE",
                               help="of the second keyframe")
    duration: float = setting(1.0, unit="s", bounds=SPAN, restarts=MOTION, read=read_time, metavar="TIME",
                              help="from the first keyframe to the second, such as 2s")
    moment: float = setting(0.0, bounds=MOMENT, unit="s", restarts=MOTION, read=read_time, metavar="TIME",
                            help="when the shutter opens, after the first keyframe")
    shutter: float = setting(1.0 / 125.0, unit="s", bounds=SPAN, restarts=MOTION, read=read_time, metavar="TIME",
                             help="exposure time, such as 1/125 or 20ms")
    shutter_ramp: float = setting(
        0.0, bounds=Interval(0.0, 0.5), rule="it must lie from 0 to 0.5 of the shutter time", restarts=MOTION,
        read=read_part, metavar="PART",
        help="part of the shutter time in which it opens, and in which it closes: 0 to 50%%")
    readout: float = setting(
        0.0, "read-out", "s", Interval(0.0, 1e6), restarts=MOTION, read=read_time, metavar="TIME",
        help="of a rolling shutter, from the first row of the picture to the last, such as 20ms; 0: all at once")
    readout_direction: str = setting("down", choices=READOUT_DIRECTIONS, restarts=MOTION,
                                     help="in which the rows of a rolling shutter open")
    samples: int = setting(256, bounds=Interval(1, 1_000_000_000), restarts=NOTHING, read=read_count, metavar="N",
                           help="samples a pixel, on average, at which the render stops: noisy parts of the picture "
                                "take more of them")
    seed: int = setting(0, bounds=Interval(0, LARGEST_SEED), rule=f"it must be a whole number from 0 to {LARGEST_SEED}",
                        figures=False, read=read_seed, metavar="N", help="sampler seed")
    view: str = setting("picture", choices=VIEWS, figures=False,
                        help="what is shown: the picture, or a quantity of its samples; of one sample, that of the "
                             "middle of each pixel and of the pupil")
    exposure: float = setting(0.0, unit="stops", bounds=Interval(-60.0, 60.0), restarts=NOTHING,
                              read=read_exposure, metavar="STOPS", help="such as +1 or -0.5")
    exposing: str = setting(
        "plain", choices=EXPOSURES, restarts=NOTHING,
        help="what sets the brightness: the light as it is (plain), f-number, shutter and ISO (triangle), or those "
        "with the ISO that a meter chooses (automatic)")
    metering: str = setting("mean", choices=METERINGS, restarts=NOTHING, help="of the automatic exposure")
    iso: float = setting(100.0, "ISO", bounds=Interval(1e-3, 1e9), restarts=NOTHING, read=read_iso, metavar="ISO",
                         help="ISO speed of the sensor, such as 400")
    noise: bool = setting(False, restarts=NOTHING, help="have a sensor record the picture, with its noise")
    full_well: float = setting(50_000.0, unit="electrons", bounds=Interval(1.0, 1e12), restarts=NOTHING,
                               read=read_electrons, metavar="N", help="electrons that a pixel of the sensor holds")
    quantum_efficiency: float = setting(0.5, bounds=Interval(1e-4, 1.0), restarts=NOTHING, read=read_part,
                                        metavar="PART", help="electrons a photon, such as 50%%")
    read_noise: float = setting(3.0, unit="electrons", bounds=Interval(0.0, 1e9), restarts=NOTHING, read=read_electrons,
                                metavar="N", help="noise of reading a pixel, in electrons rms")
    bits: int = setting(14, choices=BITS, restarts=NOTHING, read=read_count, metavar="N", option="sensor-bits",
                        help="of the sensor's converter: " + ", ".join(map(str, BITS)))
    tone: str = setting("filmic", choices=TONES, restarts=NOTHING, help="tone curve of the developed picture")
    white: str = setting("picture", "white light", choices=WHITES, restarts=NOTHING)
    overlay: str = setting("none", choices=OVERLAYS, restarts=NOTHING)
    compare: str = setting("off", choices=COMPARISONS, restarts=NOTHING)        # with the picture A
    wipe: float = setting(0.5, bounds=PART, restarts=NOTHING)       # where A ends and B begins, as a part of the width
    limit: str = setting("diagonal", choices=LIMITS, restarts=NOTHING, figures=True)     # sharp up to this diameter
