"""Rooms and their permitted imports, read from the source; and the modules that a start loads."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.lazy import typed_imports

ROOT = Path(__file__).parent.parent
GRAPHICS = {"moderngl", "glfw", "imgui_bundle", "glcontext", "OpenGL"}
MOST_FILES = 25                 # of code in a folder

# Rooms in layers, the lowest first: a room imports rooms of lower layers alone. A room is a folder, or a file beside it
LAYERS = {
    "core": ("named_objects", "lazy text", "kernels", "imaging optics scenery", "pupils", "lens_models", "cameras",
             "analysis", "design rendering", "lightfields"),
    "lenses": ("file_error", "picture_file", "stop_picture tables", "glass", "checks formats", "editing library",
               "lens_file"),
    "app": ("scenes", "settings", "bench", "plots", "session", "drawing notebook", "studies", "workers", "display",
            "panels", "window", "benchmark", "command", "__main__"),
}
# What `lenses` knows of the core: the prescription side; its rooms that trace know more
PRESCRIPTION = {"lazy", "text", "optics.coatings", "optics.finding", "optics.glass",
                "optics.lens_surface", "optics.prescription", "optics.system",
                "optics.zoom_positions"}
TRACING = {"tables": {"optics.scalar_trace"}, "checks": {"optics.paraxial", "optics.scalar_trace"},
           "stop_picture": {"optics.stop_image", "kernels.numeric"}}


def files(folder):
    return sorted(path for path in (ROOT / folder).rglob("*.py") if "__pycache__" not in path.parts)


def module(path):
    """The dotted name that a file is imported by: its path, with lensbench in front."""
    parts = [part for part in path.relative_to(ROOT).with_suffix("").parts if part != "__init__"]
    return ".".join(parts if parts[0] == "lensbench" else ["lensbench", *parts])


@cache
def modules():
    return {module(path): path for folder in ("lensbench", *LAYERS, "shaders") for path in files(folder)}


@cache
def parsed(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path):
    """Dotted names of the modules that a file imports, anywhere in it, types too; of our own, down to the file."""
    names = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            names |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            inside = {f"{node.module}.{name.name}" for name in node.names}
            names |= (inside & modules().keys()) or {node.module}
    return names


def packages(path):
    return {name.split(".")[0] for name in imports(path)}


def room(name):
    """Top folder and room of a module; the room is "" for the facade and the top folders themselves."""
    words = [*name.split("."), "", ""]
    return words[1], words[2]


def circles(graph):
    """Groups of nodes that reach each other, by Tarjan's algorithm."""
    index, low, stack, groups = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph.get(node, ()):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group = stack[stack.index(node):]
            del stack[stack.index(node):]
            groups.append(sorted(group))

    for node in graph:
        if node not in index:
            visit(node)
    return [group for group in groups if len(group) > 1]


def test_imports_run_downward():
    heights = {(top, name): height for top, layers in LAYERS.items()
               for height, layer in enumerate(layers) for name in layer.split()}
    wrong = []
    for name, path in modules().items():
        own = room(name)
        if own not in heights:
            assert name in ("lensbench", *(f"lensbench.{top}" for top in (*LAYERS, "shaders"))), f"{name}: in no room"
            continue
        for other in imports(path) & modules().keys():
            theirs = room(other)
            if theirs[0] == own[0] and theirs in heights and theirs != own and heights[theirs] >= heights[own]:
                wrong.append(f"{name} imports {other}")
    assert not wrong
    assert set(heights) <= {room(name) for name in modules()}, "a room is named that does not exist"


def test_no_files_import_each_other_in_a_circle():
    facade = {"lensbench", "lensbench.lenses", "lensbench.core.analysis"}          # they import names when used
    graph = {name: imports(path) & modules().keys() for name, path in modules().items() if name not in facade}
    assert circles(graph) == []


def test_the_page_of_the_architecture_draws_the_layers():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for top, layers in LAYERS.items():
        drawn = next(line for line in page.split("\n") if line.startswith(f"| `{top}` |")).split("|")[2]
        assert [set(re.findall(r"\w+", layer)) for layer in drawn.split("·")] == [
            set(layer.split()) for layer in layers if layer != "__main__"]


def test_no_folder_has_more_than_25_files():
    counts = Counter(path.parent for path in modules().values() if path.name != "__init__.py")
    assert not {folder: n for folder, n in counts.items() if n > MOST_FILES}


def test_the_core_knows_numpy_numba_and_itself():
    allowed = {"numpy", "numba", "llvmlite", "lensbench"} | set(sys.stdlib_module_names)
    for path in files("core"):
        solver = {"scipy"} if room(module(path))[1] == "design" else set()
        assert packages(path) <= allowed | solver, path
        assert not {name for name in imports(path) if name.startswith("lensbench")
                    and not name.startswith("lensbench.core")} - {"lensbench"}, path


def test_only_the_facade_names_the_notebook():
    outside = [path for top in ("core", "lenses") for path in files(top)]
    assert not [path for path in outside if any(name.startswith("lensbench.app") for name in imports(path))]


def test_the_core_reads_no_file_but_its_key_tile_and_prints_nothing():
    forbidden = re.compile(r"(print|open)|np\.(load|save|savez|loadtxt|savetxt|genfromtxt|fromfile|memmap)|"
                           r".*\.(open|(read|write)_(text|bytes)|tofile)")
    allowed = {"lensbench.core.kernels.sampling": {"np.load"},                  # its key tile
               "lensbench.core.kernels.cache": {"path.open", "temporary.write_bytes"},       # compiled kernels
               "lensbench.core.kernels.compiled_code": {"Path(str(sys.modules[module].__file__)).read_text"}}
    for path in files("core"):
        called = {ast.unparse(node.func) for node in ast.walk(parsed(path)) if isinstance(node, ast.Call)}
        assert not {name for name in called - allowed.get(module(path), set()) if forbidden.fullmatch(name)}, path


def test_kernels_are_declared_with_the_njit_that_keeps_what_it_compiles():
    own = [module(path) for path in files("core") + files("app") if {"numba.njit", "numba.jit"} & {
        f"{node.module}.{name.name}" for node in ast.walk(parsed(path))
        if isinstance(node, ast.ImportFrom) for name in node.names}]
    assert own == ["lensbench.core.kernels.cache"]


@pytest.mark.parametrize("package", ["lensbench", "lensbench.core.analysis", "lensbench.lenses"])
def test_a_package_offers_the_names_of_its_typed_imports(package):
    """One list serves type checkers, `dir`, star imports and the late imports."""
    held = importlib.import_module(package)
    homes = typed_imports(package)
    assert held.__all__ == sorted(homes) and set(homes) <= set(dir(held))
    starred = {}
    exec(f"from {package} import *", starred)
    for name, (module, there) in homes.items():
        value = getattr(importlib.import_module(module), there)
        assert starred[name] is value or inspect.unwrap(starred[name]) is inspect.unwrap(value), name


def test_public_names_that_are_used_exist():
    """Names that are found late escape mypy: those in use of the packages below are looked up."""
    rooms = {"lb": lb, "lb.analysis": lb.analysis, "lb.tolerances": lb.tolerances, "analysis": lb.analysis,
             "lenses": lenses}
    missing = set()
    for path in [*modules().values(), *files("trials")]:
        imports = {name.asname or name.name for node in ast.walk(parsed(path))
                   if isinstance(node, ast.Import | ast.ImportFrom) for name in node.names}
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.Attribute) and (owner := ast.unparse(node.value)) in rooms:
                if owner.split(".")[0] in imports and not hasattr(rooms[owner], node.attr):
                    missing.add((path.relative_to(ROOT).as_posix(), node.lineno, f"{owner}.{node.attr}"))
    assert not missing


def test_lenses_know_the_prescription_and_their_checks_what_they_trace():
    for path in files("lenses"):
        allowed = PRESCRIPTION | TRACING.get(room(module(path))[1], set())
        core = {name.removeprefix("lensbench.core.") for name in imports(path) if name.startswith("lensbench.core.")}
        assert core <= allowed, path
        pictures = {"PIL"} if path.name in ("stop_picture.py", "picture_file.py") else set()
        assert packages(path) <= {"lensbench", "numpy"} | pictures | set(sys.stdlib_module_names), path


def test_only_the_window_meets_both_imgui_and_the_screen():
    for path in files("app"):
        if path.name != "window.py" and "imgui_bundle" in packages(path):
            assert not {"moderngl", "lensbench.app.display.gl_texture"} & (packages(path) | imports(path)), path


def test_what_works_without_a_window_imports_no_graphics():
    for room_ in ("scenes", "settings", "bench", "plots", "session", "command", "workers"):
        for path in files(f"app/{room_}"):
            assert not packages(path) & GRAPHICS, path


# Names that decode a picture, and the files that may call them: each bounds the memory by the header first; the trial
# reads its own pictures
DECODERS = {"open": {"lenses/picture_file.py"}, "File": {"app/scenes/sky_picture.py", "trials/fingerprints.py"},
            "open_heif": {"app/scenes/photograph.py"}, "imread": set(), "load_image": set()}
LIBRARIES = {"PIL", "OpenEXR", "pillow_heif", "imageio", "cv2", "matplotlib", "skimage", "tifffile"}


def decoders(path):
    """The names of DECODERS that a file calls on something of a picture library."""
    imported = {alias.asname or alias.name.split(".")[0] for node in ast.walk(parsed(path))
                if isinstance(node, ast.Import | ast.ImportFrom)
                and (getattr(node, "module", None) or node.names[0].name).split(".")[0] in LIBRARIES
                for alias in node.names}
    return {node.attr for node in ast.walk(parsed(path)) if isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name) and node.value.id in imported} & set(DECODERS) | (
        imported & {"open", "imread", "open_heif", "File"})


def test_pictures_are_decoded_in_listed_places_alone():
    places = {name: set() for name in DECODERS}
    for path in [*modules().values(), *files("trials")]:
        for name in decoders(path):
            places[name].add(path.relative_to(ROOT).as_posix())
    assert places == DECODERS


# How little a start loads


def loaded_by(code):
    """The modules that a fresh interpreter holds after this code."""
    done = subprocess.run([sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True,
                          text=True, check=True)
    return set(done.stdout.split())


def test_the_library_and_the_lenses_load_no_graphics_and_no_picture_formats():
    loaded = loaded_by("import lensbench, lensbench.lenses, lensbench.app.settings.settings")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window.window"})


def test_the_help_of_the_command_loads_no_graphics_no_formats_and_no_lens_files():
    loaded = loaded_by("from lensbench.app.command.main import main; main(['render', '--help'])")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window.window", "lensbench.app.session.export"})


@pytest.mark.parametrize("words", ["lenses --json", "--version", "info --help"])
def test_the_list_of_lenses_and_help_load_neither_numba_nor_numpy(words):
    loaded = loaded_by(f"from lensbench.app.command.main import main; main({words.split()})")
    assert "lensbench.app.command.main" in loaded
    assert not {name.split(".")[0] for name in loaded} & {"numba", "llvmlite", "numpy"}


@pytest.mark.slow
def test_the_window_loads_neither_hidden_plots_nor_checks_nor_picture_formats():
    loaded = loaded_by("import lensbench.app.window.window")
    assert not loaded & {"PIL", "OpenEXR", "matplotlib", "lensbench.lenses.checks",
                         "lensbench.app.panels.analysis.plots"}


# What the window owns


def test_no_state_of_the_window_is_global():
    """Modules hold constants; a mutable dataclass, a class instance of state or a cache of what is drawn does not."""
    for path in [path for room_ in ("drawing", "display", "panels", "window") for path in files(f"app/{room_}")]:
        tree = parsed(path)
        assert not [node for node in ast.walk(tree) if isinstance(node, ast.Global)], path
        mutable = {node.name for node in tree.body if isinstance(node, ast.ClassDef) and not any(
            "frozen=True" in ast.unparse(decorator) for decorator in node.decorator_list)
            and not {ast.unparse(base) for base in node.bases} & {"NamedTuple", "Enum"}}
        made = {ast.unparse(node.value.func) for node in tree.body
                if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.Call)}
        assert not made & mutable, path
        cached = [ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
                  and any("cache" in ast.unparse(decorator) for decorator in node.decorator_list)]
        assert not [text for text in cached if "ImVec2" in text or "imgui." in text], path
