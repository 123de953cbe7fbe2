"""The rooms and who may know whom, read from the imports; and how little a start loads."""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ROOMS = {"core": "lensbench", "lenses": "lensbench.lenses", "app": "lensbench.app"}
GRAPHICS = {"moderngl", "glfw", "imgui_bundle", "glcontext", "OpenGL"}

# The layers of the core, the lowest first: a file knows its own layer and those below
LAYERS = (
    {"lanes", "driver", "strips", "disk", "turn", "interpolation", "roots", "normal_equations", "halves"},
    {"transform", "motion", "shutter", "spaces", "formats", "sampling", "film", "glass", "surfaces", "spectrum",
     "positions", "iris", "sensor", "exposure"},
    {"prescription", "scene", "scenery"},
    {"tracing", "blocktracer", "paraxial", "photometry", "axial_bundle"},
    {"pupil", "margins", "pupil_islands", "pupil_rim", "pupil_table", "pupil_aim", "pupil_edge", "pupil_outline",
     "pupil_nodes", "pupil_grid", "pupil_colours", "focus", "confusion", "polynomial", "aberrations", "falloff",
     "vignetting", "tabulated"},
    {"cameras"},
    {"judge", "accuracy", "views", "emission", "fronts", "detours", "sightings", "splats"},
    {"render"},
    {"analysis", "lightfield", "capture", "lumigraph", "novel", "plenoptic", "shear", "depth", "distortion"},
)
WORKBENCH = {"lanes", "driver", "strips", "disk", "turn"}
KNOW_THE_WORKBENCH_ALONE = {"transform", "shutter", "sampling", "film", "scene", "scenery"}


def files(room):
    return sorted(path for path in (ROOT / room).rglob("*.py") if "__pycache__" not in path.parts)


def module(path):
    """The dotted name that a file is imported by."""
    room, *inside = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([ROOMS[room], *(part for part in inside if part != "__init__")])


@cache
def imports(path):
    """Dotted names of the modules that a file imports, anywhere in it; of our own, down to the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            inside = {f"{node.module}.{name.name}" for name in node.names}
            ours = {name for name in inside if name in modules()}
            found |= ours or {node.module}
    return found


@cache
def modules():
    return {module(path) for room in ROOMS for path in files(room)}


def part(name):
    """Of a core module, the file or folder at the top of core; None for other rooms and packages."""
    words = name.split(".")
    if words[0] != "lensbench" or words[1:2] in (["lenses"], ["app"], ["shaders"]):
        return None
    return words[1] if len(words) > 1 else "__init__"


def core_files():
    return [path for path in files("core") if path != ROOT / "core" / "__init__.py"]


def packages(path):
    return {name.split(".")[0] for name in imports(path)}


@pytest.mark.parametrize("path", files("core"), ids=module)
def test_the_core_knows_numpy_numba_and_itself(path):
    allowed = {"numpy", "numba", "llvmlite", "lensbench"} | set(sys.stdlib_module_names)
    assert packages(path) <= allowed
    assert not {name for name in imports(path) if name.startswith("lensbench") and part(name) is None}


@pytest.mark.parametrize("path", core_files(), ids=module)
def test_the_core_reads_no_file_but_its_key_tile_and_prints_nothing(path):
    called = {ast.unparse(node.func) for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
              if isinstance(node, ast.Call)}
    if path.parts[-1] == "sampling.py" or "sampling" in path.parts:
        called -= {"np.load"}
    assert not {name for name in called if name in ("print", "open") or re.fullmatch(
        r"np\.(load|save|savez|loadtxt|savetxt|genfromtxt|fromfile|memmap)|.*\.(open|(read|write)_(text|bytes)|tofile)",
        name)}


def layer(name):
    places = [place for place, names in enumerate(LAYERS) if name in names]
    assert places, f"core/{name} has no place in LAYERS: say which files it may know"
    return places[0]


@pytest.mark.parametrize("path", core_files(), ids=module)
def test_a_file_of_the_core_knows_only_what_lies_below_it(path):
    own = part(module(path))
    for name in {part(name) for name in imports(path)} - {None, own}:
        assert name != "__init__", f"{path.name} imports the whole package: name the file"
        assert layer(name) <= layer(own), f"{own} must not know {name}"
        if own in KNOW_THE_WORKBENCH_ALONE and name not in WORKBENCH:
            assert {own, name} == {"scene", "scenery"}, f"{own} knows at most the workbench, not {name}"


@pytest.mark.parametrize("path", files("lenses"), ids=module)
def test_lenses_know_the_prescription_and_the_glass_and_their_check_what_it_traces(path):
    allowed = {"prescription", "positions", "glass"}
    if path.name == "check.py" or path.parent.name == "check":
        allowed |= {"paraxial", "surfaces", "tracing"}
    assert {part(name) for name in imports(path)} - {None} <= allowed
    assert not {name for name in imports(path) if name.startswith("lensbench.app")}
    assert packages(path) <= {"lensbench", "numpy"} | set(sys.stdlib_module_names)


@pytest.mark.parametrize("path", files("app"), ids=module)
def test_only_the_window_meets_both_imgui_and_the_screen(path):
    if path.name != "window.py" and "imgui_bundle" in packages(path):
        assert not {"moderngl", "lensbench.app.screen"} & (packages(path) | imports(path))


@pytest.mark.parametrize("name", ["settings", "arguments", "cli", "export", "readings", "scale", "tone", "history"])
def test_what_works_without_a_window_imports_no_graphics(name):
    assert not packages(ROOT / "app" / f"{name}.py") & GRAPHICS


# How little a start loads


def loaded_by(code):
    """The modules that a fresh interpreter holds after this code."""
    done = subprocess.run([sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True,
                          text=True, check=True)
    return set(done.stdout.split())


def test_the_library_and_the_lenses_load_no_graphics_and_no_picture_formats():
    loaded = loaded_by("import lensbench, lensbench.lenses, lensbench.app.settings")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window"})


def test_the_help_of_the_command_loads_no_graphics_no_formats_and_no_lens_files():
    loaded = loaded_by("from lensbench.app.cli import main; main(['render', '--help'])")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window", "lensbench.app.export"})
