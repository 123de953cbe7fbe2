"""Digests of pictures, traces, pupils and analyses: proof that a change of the code changes no number.

    python -m trials.fingerprints before.json           # in the state before
    python -m trials.fingerprints after.json            # in the state after
    python -m trials.fingerprints --compare before.json after.json

Equal digests are equal bits. Compare runs of one machine whose kernels were compiled before, not those of two machines:
a process that compiles a kernel itself can round otherwise in the last place. So run it twice after an edit.
"""

import contextlib
import hashlib
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenEXR

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main

SIZE, SAMPLES = "96x64", "4"
RENDERS = {                                 # of each, arguments of `lensbench render`
    **{f"scene {scene}": f"sigma-dg-hsm-art-35-f14 --scene {scene}" for scene in sorted(lb.SCENES)},
    **{f"scene {scene}, open shutter": f"pbrt-dgauss-50mm --scene {scene} --shutter 0.05 --moment 0.2"
       for scene in sorted(lb.SCENES)},
    **{f"camera {kind} in {scene}": f"--camera {kind} --scene {scene}" for scene in ("still-life", "night-lights")
       for kind in ("perspective", "orthographic", "fisheye", "environment", "finite-pinhole", "bare-sensor")},
    **{f"model {model} of {lens}": f"{lens} --scene still-life --lens-model {model}"
       for model in ("trace", "polynomial", "thick", "thin", "pinhole")
       for lens in ("pbrt-dgauss-50mm", "brendel-tessar-100-f28", "pbrt-fisheye-10mm")},
    **{f"view {view}": f"pbrt-dgauss-50mm --scene still-life --view {view}"
       for view in ("direction", "origin", "fate", "time", "depth", "weight")},
    **{f"medium {medium} in {scene}": f"pbrt-dgauss-50mm --scene {scene} --medium {medium}"
       for medium in ("fog", "water") for scene in ("dusk-street", "room", "night-lights")},
    "layout": "--camera environment --layout cube-map --scene room",
    "dispersion off": "pbrt-dgauss-50mm --scene night-lights --dispersion off",
    "no light tracing": "pbrt-dgauss-50mm --scene night-lights --no-light-tracing",
    "ghosts": "pbrt-dgauss-50mm --scene night-lights --ghosts --coating single-layer",
    "stars": "pbrt-dgauss-50mm --scene night-lights --stars --f-number 16",
    "tilted film": "pbrt-dgauss-50mm --scene room --tilt 5deg --swing 3deg --rise 3mm",
    "rolling shutter": "pbrt-dgauss-50mm --scene fairground --shutter 0.02 --readout 0.03",
    "moving camera": "pbrt-dgauss-50mm --scene room --end-yaw 10deg --duration 1 --shutter 0.5 --moment 0",
    "noise": "pbrt-dgauss-50mm --scene room --noise --iso 3200",
}
ANALYSED = ("pbrt-dgauss-50mm", "sigma-dg-hsm-art-35-f14", "canon-ef-28-105-f4",
            "carl-zeiss-touit-makro-planar-t-macro-50-f28")


def digest(*arrays: object) -> str:
    """16 hex digits of arrays; of NaN any bits."""
    computed = hashlib.sha256()
    for array in arrays:
        values = np.asarray(array)
        if values.dtype.kind == "f":
            values = np.where(np.isnan(values), np.nan, values) + 0.0
        computed.update(f"{values.dtype} {values.shape}".encode() + np.ascontiguousarray(values).tobytes())
    return computed.hexdigest()[:16]


def command(*arguments: str) -> None:
    """Run one command of lensbench, silently."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as messages:
        if main(arguments):
            raise RuntimeError(messages.getvalue().strip())


def pictures(folder: Path) -> Iterator[tuple[str, str]]:
    """Names and digests of rendered pictures."""
    for name, arguments in RENDERS.items():
        path = folder / "picture.exr"
        command("render", *arguments.split(), "--size", SIZE, "--samples", SAMPLES, "-o", str(path))
        with OpenEXR.File(str(path)) as file:
            yield f"render: {name}", digest(*(channel.pixels for _, channel in sorted(file.channels().items())))


def numbers(folder: Path) -> Iterator[tuple[str, str]]:
    """Names and digests of traces, pupils and analyses."""
    random = np.random.default_rng(0)
    for name in lenses.names()[::3]:
        lens = lenses.load(name)
        origins = random.uniform(-1.0, 1.0, (200, 3)) * [10.0, 10.0, 0.0] - [0.0, 0.0, 50.0]
        directions = random.uniform(-0.3, 0.3, (200, 3)) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
        traced = lb.trace(lens, origins, directions)
        yield f"trace: {name}", digest(traced.points, traced.directions, traced.fate)
    for name in lenses.names()[::9]:
        lens = lenses.load(name)
        with contextlib.suppress(ValueError):
            pupil = lb.exit_pupil(lens, lb.film_distance(lens, np.inf), [0.0, 5.0, 10.0])
            yield f"pupil: {name}", digest(pupil.area, pupil.bounds, *pupil.rims)
    for name in ANALYSED:
        path = folder / "numbers.json"
        command("analyse", name, "-o", str(path))
        yield f"analyses: {name}", hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def run(path: Path) -> None:
    """Compute all digests and write them."""
    computed = {}
    with tempfile.TemporaryDirectory() as folder:
        for source in (numbers, pictures):
            try:
                for name, text in source(Path(folder)):
                    computed[name] = text
            finally:
                path.write_text(json.dumps(computed, indent=1))
    print(f"{len(computed)} digests")


def compare(before: Path, after: Path) -> bool:
    """Whether two files agree; prints what differs."""
    first, second = (json.loads(path.read_text()) for path in (before, after))
    for name in sorted(first.keys() | second.keys()):
        if first.get(name) != second.get(name):
            print(f"{name}: {first.get(name)} → {second.get(name)}")
    return bool(first == second)


if __name__ == "__main__":
    if sys.argv[1] == "--compare":
        sys.exit(not compare(Path(sys.argv[2]), Path(sys.argv[3])))
    run(Path(sys.argv[1]))
