"""An option that changes nothing is named, and no other one."""

import pytest

from lensbench.app.command.main import main


@pytest.mark.slow
@pytest.mark.parametrize("options, said", [
    ("--camera perspective --f-number open --lens-radius 5mm", ["--lens-radius has no effect on the camera perspective",
                                                                "--f-number open makes this camera a pinhole"]),
    ("--camera perspective --f-number 2 --fov-axis diagonal --blades 6", []),
    ("--camera orthographic --f-number 2 --lens-radius 5mm", ["--f-number has no effect on the camera orthographic"]),
    ("--camera environment --layout equal-area --size 8x8", []),
    ("--camera environment --layout equal-area --size 16x8 --focus 2m", ["has the shape 1:1: 16x8 stretches it",
                                                                         "--focus has no effect"]),
    ("--camera fisheye --degree 5 --visibility 3m",
     ["--degree has no effect on the camera fisheye: give --lens-model",
      "--visibility has no effect on the camera fisheye: give --medium"]),
    ("pbrt-dgauss-50mm --ghosts --medium water", ["--ghosts: ghosts are not traced through a flat port"]),
    ("--camera perspective --ghosts --stars", ["--ghosts: ghosts need a lens with surfaces",
                                               "--stars: stars need a lens with surfaces"]),
    ("pbrt-dgauss-50mm --star-strength 2", ["--star-strength has no effect on the camera lens: give --stars too"]),
    ("pbrt-dgauss-50mm --lens-model pinhole --f-number 4 --blades 5",
     ["--f-number has no effect on the camera lens: the lens model pinhole has no stop", "--blades has no effect"]),
    ("pbrt-dgauss-50mm --roundness 50% --blade-rotation 10",
     ["--roundness has no effect on the camera lens: give --blades too",
      "--blade-rotation has no effect on the camera lens: give --blades too"]),
    ("pbrt-dgauss-50mm --blades 7 --roundness 50% --blade-rotation 10", []),
    ("--camera perspective --f-number 2 --blades 0 --roundness 50%", ["--roundness has no effect on the camera persp"]),
    ("--camera perspective --focal-length 80mm", ["--focal-length has no effect on the camera perspective"]),
    ("pbrt-dgauss-50mm --coating uncoated --duration 5s",
     ["--coating has no effect on the camera lens: give --ghosts too", "--duration has no effect on the camera lens"]),
    ("pbrt-dgauss-50mm --coating uncoated --ghosts --focal-length 80mm", ["no ghosts: the scene has no sun"]),
    ("pbrt-dgauss-50mm --lens-model thin --focus-position real", ["the lens model thin has one focus"]),
    ("pbrt-dgauss-50mm --iso 800 --metering highlights --shutter 0.01 --readout 5ms --read-noise 3",
     ["--iso has no effect on the camera lens: give --exposing triangle", "give --exposing automatic",
      "--shutter has no effect on the camera lens: nothing moves", "--readout has no effect", "give --noise"]),
    ("pbrt-dgauss-50mm --exposing triangle --iso 800 --shutter 0.01 --f-number 4", []),
    ("pbrt-dgauss-50mm --noise --iso 800 --read-noise 3 --lens-model pinhole", []),
    ("pbrt-dgauss-50mm --end-position 9,0,0 --shutter 0.01 --readout 5ms", []),
    ("pbrt-dgauss-50mm --view depth --ghosts --noise --iso 800 --exposing triangle --tone agx --until-noise 1%",
     ["--ghosts has no effect on the view depth: give --view picture", "--noise has no effect on the view depth",
      "--iso has no effect on the view depth", "--exposing has no effect", "--tone has no effect",
      "--until-noise has no effect on the view depth"]),
    ("pbrt-dgauss-50mm --view depth --no-ghosts --shutter 0.01", ["--shutter has no effect on the camera lens"]),
    ("pbrt-dgauss-50mm --bits 16", []),
    ("pbrt-dgauss-50mm --bits 8 -o x.exr", ["--bits has no effect on x.exr: it holds linear light as floats"]),
    *((f"--camera {camera} --exposing triangle --shutter 1/1000 --iso 100",
       [f"--{option} has no effect on the camera {camera.split()[0]}: the exposure triangle needs an f-number"
        for option in ("exposing", "shutter", "iso")])
      for camera in ("fisheye", "orthographic", "environment --size 16x8", "bare-sensor")),
    ("--camera fisheye --exposing automatic --shutter 1/1000 --metering highlights",
     ["--shutter has no effect on the camera fisheye: the exposure triangle needs an f-number"]),
    ("--camera fisheye --exposing triangle --iso 400 --noise", ["--exposing has no effect on the camera fisheye"]),
    ("pbrt-dgauss-50mm --lens-model pinhole --exposing triangle", ["--exposing has no effect on the camera lens"]),
    ("--camera finite-pinhole --exposing triangle --shutter 1/1000 --iso 100", []),
    ("--camera perspective --f-number 2 --exposing triangle --shutter 1/1000 --iso 100", []),
    ("pbrt-dgauss-50mm --exposing automatic --shutter 1/1000 --iso 400",
     ["--shutter has no effect on the camera lens: --exposing automatic makes up", "--exposing automatic chooses"]),
    ("pbrt-dgauss-50mm --exposing automatic --noise --shutter 1/1000", []),
    ("pbrt-dgauss-50mm --exposure +1 --exposing triangle --shutter 0.01 --iso 800 --noise --sensor-bits 12 --tone agx "
     "-o x.exr", [f"--{option} has no effect on x.exr: it holds linear light"
                  for option in ("exposure", "exposing", "shutter", "iso", "noise", "sensor-bits", "tone")]),
    ("pbrt-dgauss-50mm --exposure +1 --no-noise -o x.pfm", ["--exposure has no effect on x.pfm"]),
    ("pbrt-dgauss-50mm --end-position 9,0,0 --shutter 0.01 --f-number 4 -o x.exr", []),
    ("pbrt-dgauss-50mm --exposure +1 --tone agx --noise --until-noise 9% -o x.exr", ["--noise has no effect on x.exr"]),
    ("pbrt-dgauss-50mm --camera bare-sensor", ["pbrt-dgauss-50mm has no effect: the camera bare-sensor has no lens"]),
])
def test_options_without_an_effect_are_named(options, said, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["-o", "x.png", *options.split()]
    if "--size" not in words:
        words += ["--size", "12x8"]
    assert main(["render", *words, "--scene", "white-wall", "--samples", "1"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("lensbench: ")]
    assert len(lines) == len(said)
    for text in said:
        assert any(text in line for line in lines)
