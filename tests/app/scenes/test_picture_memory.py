"""Pictures as large as the limits allow, and larger ones, stay below 1 GB in a process of their own."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from lensbench.app.scenes import asset_files, photograph, sky_picture
from lensbench.core.text import significant
from lensbench.lenses import picture_file, stop_picture

MOST = 1_000_000        # kB: the promise of docs/reliability.md
CODE = """
import sys
from lensbench.app.scenes.scene_file import SceneFileError, load_scene
try:
    load_scene(sys.argv[1])
    print("read", end=" ")
except SceneFileError as error:
    print(error, end=" ")
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""
FLOOR = '[floor]\ntexture = "{}"\n'
SKY = '[sky]\nimage = "{}"\n'
DEPTH = '[photograph]\nimage = "small.png"\ndepth = "{}"\nfov = 50\nnear = 1000\nfar = 3000\n'


def exr(path, width, height, channels="RGB", dtype=np.float32):
    OpenEXR.File({"compression": OpenEXR.Compression.ZIP_COMPRESSION, "type": OpenEXR.Storage.scanlineimage},
                 {name: np.ones((height, width), dtype) for name in channels}).write(str(path))


def radiance(path, width, height):
    row = bytes([2, 2, width >> 8, width & 255]) + 4 * (width // 127 * bytes([255, 128])
                                                        + bytes([128 + width % 127, 128]))
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + height * row)


def plain(mode, width, height, **options):
    return lambda path: Image.new(mode, (width, height), *options.pop("colour", ())).save(path, **options)


FILES = {
    "texture of 67 million pixels": (FLOOR, "a.png", plain("RGBA", 8192, 8192, compress_level=1), "read"),
    "texture in JPEG, progressive": (FLOOR, "a.jpg", plain("RGB", 8192, 8192, progressive=True), "read"),
    "texture of 13,000²": (FLOOR, "a.png", plain("L", 13_000, 13_000, compress_level=1), "million pixels"),
    "depth map of 67 million pixels": (DEPTH, "a.png", plain("I;16", 8192, 8192, compress_level=1), "one value only"),
    "depth map of 13,300²": (DEPTH, "a.png", plain("I;16", 13_300, 13_300, compress_level=1), "million pixels"),
    "depth map of floats": (DEPTH, "a.exr", lambda path: exr(path, 8192, 8192, "Z"), "one value only"),
    "largest sky": (SKY, "a.exr", lambda path: exr(path, 8192, 4096, "RGBA"), "read"),
    "largest Radiance sky": (SKY, "a.hdr", lambda path: radiance(path, 8192, 4096), "read"),
    "sky of 11,584 × 5,792": (SKY, "a.exr", lambda path: exr(path, 11_584, 5_792, dtype=np.float16), "million numbers"),
    "Radiance sky of 11,584 × 5,792": (SKY, "a.hdr", lambda path: radiance(path, 11_584, 5_792), "million pixels"),
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
@pytest.mark.parametrize("name", FILES)
def test_memory_stays_below_the_promise(name, tmp_path):
    text, file, write, outcome = FILES[name]
    write(tmp_path / file)
    Image.fromarray(np.arange(64, dtype=np.uint8).reshape(8, 8)).save(tmp_path / "small.png")
    (tmp_path / "a.toml").write_text(text.format(file))
    done = subprocess.run([sys.executable, "-c", CODE, str(tmp_path / "a.toml")], capture_output=True, text=True,
                          check=True)
    said, _, peak = done.stdout.strip().rpartition(" ")
    assert re.search(outcome, said) and int(peak) < MOST, done.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
@pytest.mark.parametrize("name", ["texture of 67 million pixels", "largest sky"])
def test_a_picture_of_the_largest_size_is_rendered_below_the_promise(name, tmp_path):
    text, file, write, _ = FILES[name]
    write(tmp_path / file)
    (tmp_path / "a.toml").write_text(text.format(file))
    words = ["render", "pbrt-dgauss-50mm", "--scene", str(tmp_path / "a.toml"), "--size", "60x40", "--samples", "2",
             "-o", str(tmp_path / "o.png")]
    code = f"from lensbench.app.command.main import main\nassert main({words!r}) == 0\n" + CODE.splitlines()[-1]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout.split()[-1]) < MOST, done.stdout


def test_the_page_states_the_limits_of_the_code():
    page = " ".join((Path(__file__).parents[3] / "docs" / "reliability.md").read_text(encoding="utf-8").split())
    for number, words in ((asset_files.MOST_BYTES / 2**20, "MB,"), (picture_file.MOST_PIXELS / 1e6, "million pixels"),
                          (stop_picture.MOST_PIXELS / 1e6, "million, a sky"),
                          (asset_files.TEXTURE_TEXELS / 1e6, "million) and"),
                          (picture_file.MOST_BYTES / 2**20, "MB of memory for the decoder"),
                          (sky_picture.MOST_SAMPLES / 1e6, "million numbers"),
                          (photograph.MOST_PHONE_BYTES / 2**20, "MB; its XMP")):
        assert f"{int(number)} {words}" in page
    assert f"its first bytes: {', '.join(picture_file.FORMATS)}" in page
    scenes = " ".join((Path(__file__).parents[3] / "docs" / "scenes.md").read_text(encoding="utf-8").split())
    assert f"({', '.join(picture_file.FORMATS)})" in scenes
    assert f"{int(asset_files.TEXTURE_TEXELS / 1e6)} million" in scenes
    assert f"{significant(photograph.HALF_END)} or 1e10" in scenes
    assert asset_files.TEXTURE_TEXELS == asset_files.TEXTURE_SIDE**2 // 2 and "8192 × 4096" in scenes
