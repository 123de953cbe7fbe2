"""Random command lines of `render`: odd but possible values, and impossible ones; what must come of each."""

import math
import random
import warnings
from dataclasses import fields

import numpy as np
import OpenEXR

from lensbench.app.command.lens_options import dest
from lensbench.app.command.main import main
from lensbench.app.settings.camera_facts import CAMERAS
from lensbench.app.settings.setting import spec
from lensbench.app.settings.settings import Settings

JUNK = ("", "nan", "-nan", "inf", "-inf", "0", "-0", "1e308", "1e-320", "-1e300", "1e300m", "9" * 400, "x" * 10_000,
        "\x1b[2J", "a\nb", "--", "1/0", "0/0", "1e309s", "½", "٣", "1,5", "%", "1e5%", "{}", "\udcff")
UNITS = {"mm": "mm", "°": "deg", "s": "s"}
LENSES = ("pbrt-dgauss-50mm", "lib-us10281683", "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed")
SCENES = ("still-life", "grid-wall", "night-lights", "fairground")
OWN = {"samples", "lens_model"}                 # set here, so that a picture takes milliseconds
NAMES = [field for field in fields(Settings) if spec(field).help and field.name not in OWN]


def words(rng):
    """The arguments of one command, without its output."""
    lens_model = rng.choice(("pinhole", "thin", "thick", "trace", "trace"))
    arguments = ["render", rng.choice(LENSES), "--size", f"{rng.randint(1, 12)}x{rng.randint(1, 9)}", "--samples", "1",
             f"--lens-model={lens_model}", f"--scene={rng.choice(SCENES)}"]
    if rng.random() < 0.4:
        arguments.append(f"--camera={rng.choice(list(CAMERAS))}")
    chosen = rng.sample(NAMES, rng.randint(1, 4))
    arguments += [argument for field in chosen if (argument := option(field, rng))]
    if rng.random() < 0.25:
        arguments.append(f"--f-number={number(0.01, 1e4, rng)!r}")
    if rng.random() < 0.15:
        arguments.append(f"--film={number(1e-3, 1e4, rng)!r}x{number(1e-3, 1e4, rng)!r}")
    if rng.random() < 0.15:
        arguments.append(f"--fov={number(1e-3, 179.0, rng)!r}deg")
    if rng.random() < 0.1:
        arguments.append(f"--zoom={rng.choice((0.0, 1.0, 0.37, '105mm', '1e300mm'))}")
    if rng.random() < 0.1:
        arguments.append(rng.choice(("--size=", "--film=", "--scene=", "--fov=", "--zoom=", "--f-number="))
                     + rng.choice(JUNK))
    return arguments


def option(field, rng):
    """An option of one setting with a value: an end of its range, one within it, or junk."""
    about, name = spec(field), dest(field).replace("_", "-")
    if rng.random() < 0.08:
        return f"--{name}={rng.choice(JUNK)}"
    if field.type is bool:
        return rng.choice((f"--{name}", f"--no-{name}"))
    if about.choices:
        return f"--{name}={rng.choice(list(about.choices))}"
    if about.bounds is None:
        return ""
    low, high = about.bounds.low, about.bounds.high
    if isinstance(field.default, int):
        return f"--{name}={rng.choice((int(low), int(high), rng.randint(int(low), int(min(high, 99)))))}"
    if "position" in field.name:
        return f"--{name}=" + ",".join(f"{number(low, high, rng)!r}mm" for _ in range(3))
    if about.bounds.infinite and rng.random() < 0.2:
        return f"--{name}=inf"
    value = number(low, high, rng)
    return f"--{name}={math.degrees(value) if about.unit == '°' else value!r}{UNITS.get(about.unit, '')}"


def number(low, high, rng):
    """A number from low to high: an end, or one of an even exponent."""
    if rng.random() < 0.25:
        return rng.choice((low, high))
    least = max(low, 1e-3 * min(1.0, high))
    size = math.exp(rng.uniform(math.log(least), math.log(high)))
    return max(-size, low) if low < 0.0 and rng.random() < 0.5 else size


def fault(arguments, folder, capsys):
    """What is wrong with the outcome of a command, "" for a picture of finite numbers or one clear line."""
    path = folder / "a.exr"
    path.unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code = main([*arguments, f"--output={path}"])
    told = capsys.readouterr().err
    if code == 2:
        lines = told.splitlines()
        plain = told.replace(str(folder), "").removesuffix("\n")
        return "" if len(lines) >= 1 and all(len(line) < 900 for line in lines) and plain.replace(
            "\n", "").isprintable() else f"message {plain[:500]!r}"
    if code != 0:
        return f"code {code}: {told}"
    pixels = OpenEXR.File(str(path)).channels()["RGB"].pixels
    if not np.isfinite(pixels).all():
        return "not finite"
    return "" if pixels.min() >= 0.0 or "--view" in " ".join(arguments) else "negative"


def faults(times, seed, folder, capsys):
    """The faulty ones of random commands, with what is wrong."""
    rng = random.Random(seed)
    faults = []
    for _ in range(times):
        arguments = words(rng)
        if wrong := fault(arguments, folder, capsys):
            faults.append((wrong, arguments))
    return faults
