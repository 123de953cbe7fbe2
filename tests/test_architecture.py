"""Rooms and their permitted imports, read from the source; and the modules that a start loads."""

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ROOMS = {"core": "lensbench", "lenses": "lensbench.lenses", "app": "lensbench.app"}
PACKAGES = ROOMS | {"shaders": "lensbench.shaders"}
SETTINGS = "lensbench.app.state.settings"
GRAPHICS = {"moderngl", "glfw", "imgui_bundle", "glcontext", "OpenGL"}

# The rooms of core and app in layers, the lowest first: a room imports rooms of lower layers alone
CORE = (
    {"kernels"},
    {"imaging", "optics", "scenery"},
    {"pupils"},
    {"lens_models"},
    {"cameras"},
    {"analysis"},
    {"design", "rendering"},
    {"lightfields"},
)
APP = (
    {"state"},
    {"widgets", "files"},
    {"notebook"},
    {"studies"},
    {"workers"},
    {"display"},
    {"panels"},
    {"window"},
    {"studies.benchmark"},
    {"command"},
    {"__main__"},
)


def files(room):
    return sorted(path for path in (ROOT / room).rglob("*.py") if "__pycache__" not in path.parts)


def module(path):
    """The dotted name that a file is imported by."""
    room, *inside = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([PACKAGES[room], *(part for part in inside if part != "__init__")])


@cache
def parsed(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imports(path):
    """Dotted names of the modules that a file imports, anywhere in it, types too; of our own, down to the file."""
    found = set()
    tree = parsed(path)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            inside = {f"{node.module}.{name.name}" for name in node.names}
            ours = {name for name in inside if name in modules()}
            found |= ours or {node.module}
    return found


def typed_settings(path):
    """Whether a file of app.state names Settings in types alone, as makers do that settings.py itself imports."""
    hints = [node for node in ast.walk(parsed(path))
             if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    return path.parent == ROOT / "app" / "state" and any(
        isinstance(inner, ast.ImportFrom) and inner.module == SETTINGS for hint in hints for inner in hint.body)


@cache
def modules():
    return {module(path) for room in ROOMS for path in files(room)}


def room(name, layers):
    """The deepest room of these layers that a module lies in, by its path inside core or app."""
    rooms = set().union(*layers)
    words = name.split(".")[1 if layers is CORE else 2:]
    found = [".".join(words[:n]) for n in range(len(words), 0, -1) if ".".join(words[:n]) in rooms]
    assert found, f"{name} lies in no room: name its layer here"
    return found[0]


def part(name):
    """Of a core module, its path inside core; None for the other top folders and for other packages."""
    words = name.split(".")
    if words[0] != "lensbench" or words[1:2] in (["lenses"], ["app"], ["shaders"]):
        return None
    return ".".join(words[1:])


def core_files():
    return [path for path in files("core") if path != ROOT / "core" / "__init__.py"]


def inside(layers):
    """Modules of core or app that are files of a room."""
    top = ROOT / ("core" if layers is CORE else "app")
    return [path for path in files(top.name) if path != top / "__init__.py"]


def circles(graph):
    """Groups of nodes that reach each other, by Tarjan's algorithm."""
    index, low, stack, found = {}, {}, [], []

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
            found.append(sorted(group))

    for node in graph:
        if node not in index:
            visit(node)
    return [group for group in found if len(group) > 1]


def packages(path):
    return {name.split(".")[0] for name in imports(path)}


@pytest.mark.parametrize("path", files("core"), ids=module)
def test_the_core_knows_numpy_numba_and_itself(path):
    allowed = {"numpy", "numba", "llvmlite", "lensbench"} | set(sys.stdlib_module_names)
    if path == ROOT / "core" / "design" / "improve.py":         # the solver, imported when it runs
        allowed |= {"scipy"}
    assert packages(path) <= allowed
    above = {name for name in imports(path) if name.startswith("lensbench") and part(name) is None}
    if path == ROOT / "core" / "__init__.py":           # the names of `lb`, each imported when it is used
        above = {name for name in above if not name.startswith("lensbench.app.notebook.")}
    assert not above


@pytest.mark.parametrize("path", core_files(), ids=module)
def test_the_core_reads_no_file_but_its_key_tile_and_prints_nothing(path):
    called = {ast.unparse(node.func) for node in ast.walk(parsed(path))
              if isinstance(node, ast.Call)}
    if path.parts[-1] == "sampling.py" or "sampling" in path.parts:
        called -= {"np.load"}
    if module(path) == "lensbench.kernels.cache":       # it keeps compiled kernels
        called -= {"path.open", "part.write_bytes"}
    if module(path) == "lensbench.kernels.kernel_version":      # it hashes sources
        called -= {"Path(str(sys.modules[module].__file__)).read_text"}
    assert not {name for name in called if name in ("print", "open") or re.fullmatch(
        r"np\.(load|save|savez|loadtxt|savetxt|genfromtxt|fromfile|memmap)|.*\.(open|(read|write)_(text|bytes)|tofile)",
        name)}


def test_kernels_are_declared_with_the_njit_that_keeps_what_it_compiles():
    own = [module(path) for path in files("core") + files("app") if {"numba.njit", "numba.jit"} & {
        f"{node.module}.{name.name}" for node in ast.walk(parsed(path))
        if isinstance(node, ast.ImportFrom) for name in node.names}]
    assert own == ["lensbench.kernels.cache"]


@pytest.mark.parametrize("package", ["core", "core/analysis", "lenses"])
def test_the_names_of_a_package_are_found_where_its_typed_imports_find_them(package):
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    typed = next(node.body for node in tree.body if isinstance(node, ast.If))
    named = {(name.asname or name.name, node.module, name.name) for node in typed for name in node.names}
    lists = {node.targets[0].id: ast.literal_eval(node.value) for node in tree.body
             if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)}
    found = {(each.partition("=")[0], f"lensbench.{home}", each.rpartition("=")[2])
             for home, names in lists["_HOMES"].items() for each in names.split()}
    found |= {(home, "lensbench", home) for home, names in lists["_HOMES"].items() if not names}    # a whole module
    assert found == named
    assert sorted(lists["__all__"]) == sorted(name for name, *_ in named)


@pytest.mark.parametrize("layers", [CORE, APP], ids=["core", "app"])
def test_imports_run_downward(layers):
    height = {name: place for place, names in enumerate(layers) for name in names}
    wrong = []
    for path in inside(layers):
        own = room(module(path), layers)
        for name in imports(path):
            ours = part(name) if layers is CORE else name.startswith("lensbench.app.")
            if not ours or name == module(path).rpartition(".")[0]:
                continue
            other = room(name, layers)
            if other != own and height[other] >= height[own]:
                wrong.append(f"{module(path)} imports {name}")
    assert not wrong


@pytest.mark.parametrize("layers", [CORE, APP], ids=["core", "app"])
def test_no_room_is_named_that_does_not_exist(layers):
    top = ROOT / ("core" if layers is CORE else "app")
    for name in set().union(*layers):
        place = top.joinpath(*name.split("."))
        assert place.is_dir() or place.with_suffix(".py").is_file(), f"{name} is no room of {top.name}"


@pytest.mark.parametrize("layers", [CORE, APP], ids=["core", "app"])
def test_the_page_of_the_architecture_draws_the_layers(layers):
    page = re.sub(r'\w+\["(studies\.\w+)"\]', r"\1", (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    drawn = next(line for line in page.split("\n") if "-->" in line and set(line.split()) & layers[0])
    rows = [set(row.split()) - {"&"} for row in reversed(drawn.split("-->"))]
    assert rows == [layer for layer in layers if layer != {"__main__"}]


def test_no_files_import_each_other_in_a_circle():
    graph = {module(path): imports(path) & modules() - ({SETTINGS} if typed_settings(path) else set())
             for name in ROOMS for path in files(name) if path != ROOT / "core" / "__init__.py"}
    assert circles(graph) == []


def test_no_rooms_import_each_other_in_a_circle():
    graph = {}
    for layers in (CORE, APP):
        for path in inside(layers):
            own = (layers is APP, room(module(path), layers))
            ours = {name for name in imports(path) & modules() if name != "lensbench"
                    and (part(name) if layers is CORE else name.startswith("lensbench.app."))}
            graph.setdefault(own, set()).update((layers is APP, room(name, layers)) for name in ours
                                                if name != module(path).rpartition(".")[0])
    assert circles(graph) == []


def test_every_folder_with_python_files_is_a_package_that_is_installed():
    listed = set(re.findall(r'^    "(lensbench[\w.]*)",$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.M))
    folders = {path.parent for name in PACKAGES for path in (ROOT / name).rglob("*.py")}
    assert {module(folder / "__init__.py") for folder in folders} == listed


@pytest.mark.parametrize("path", files("lenses"), ids=module)
def test_lenses_know_the_prescription_and_the_glass_and_their_check_what_it_traces(path):
    allowed = {"optics.adjacent_media", "optics.lens_surface", "optics.prescription", "optics.surface_pose",
               "optics.zoom_positions", "optics.glass", "optics.coatings", "optics.finding", "optics.system",
               "kernels.figures", "kernels.hashed", "kernels.lazy_names", "kernels.quotation"}
    if path.name == "aperture.py":
        allowed |= {"optics.scalar_trace"}
    if path.parent.name == "checks":
        allowed |= {"optics.paraxial", "optics.scalar_trace"}
    if path.parent.name == "editing":
        allowed |= {"optics.surface_numbers"}
    if path.name == "stop_picture.py":
        allowed |= {"optics.stop_image", "kernels.srgb"}
    assert {part(name) for name in imports(path)} - {None} <= allowed
    assert not {name for name in imports(path) if name.startswith("lensbench.app")}
    pictures = {"PIL"} if path.name in ("stop_picture.py", "picture_file.py") else set()
    assert packages(path) <= {"lensbench", "numpy"} | pictures | set(sys.stdlib_module_names)


@pytest.mark.parametrize("path", files("app"), ids=module)
def test_only_the_window_meets_both_imgui_and_the_screen(path):
    if path.name != "window.py" and "imgui_bundle" in packages(path):
        assert not {"moderngl", "lensbench.app.display.gl_texture"} & (packages(path) | imports(path))


@pytest.mark.parametrize("path", [path for name in ("state", "files", "command", "workers")
                                  for path in files(f"app/{name}")], ids=module)
def test_what_works_without_a_window_imports_no_graphics(path):
    assert not packages(path) & GRAPHICS


# Names that decode a picture, and the files that may call them: each bounds the memory by the header first
DECODERS = {"open": {"lenses/picture_file.py"}, "File": {"app/state/scene_assets/sky_picture.py"},
            "open_heif": {"app/state/scene_assets/heic_depth.py"}, "imread": set(), "load_image": set()}


def decoders(path):
    """The names of DECODERS that a file calls on something of PIL, OpenEXR, pillow_heif or another picture library."""
    tree, libraries, found = ast.parse(path.read_text(encoding="utf-8")), set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            top = (getattr(node, "module", None) or node.names[0].name).split(".")[0]
            if top in {"PIL", "OpenEXR", "pillow_heif", "imageio", "cv2", "matplotlib", "skimage", "tifffile"}:
                libraries |= {alias.asname or alias.name.split(".")[0] for alias in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in libraries:
            found |= {node.attr} & set(DECODERS)
    return found | (libraries & {"open", "imread", "open_heif", "File"})


def test_pictures_are_decoded_in_listed_places_alone():
    found = {name: set() for name in DECODERS}
    for path in (each for top in (*PACKAGES, "trials") for each in files(top)):
        for name in decoders(path):
            found[name].add(path.relative_to(ROOT).as_posix())
    assert found == DECODERS


# How little a start loads


def loaded_by(code):
    """The modules that a fresh interpreter holds after this code."""
    done = subprocess.run([sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True,
                          text=True, check=True)
    return set(done.stdout.split())


def test_the_library_and_the_lenses_load_no_graphics_and_no_picture_formats():
    loaded = loaded_by("import lensbench, lensbench.lenses, lensbench.app.state.settings")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window.window"})


def test_the_help_of_the_command_loads_no_graphics_no_formats_and_no_lens_files():
    loaded = loaded_by("from lensbench.app.command.main import main; main(['render', '--help'])")
    assert not loaded & (GRAPHICS | {"PIL", "OpenEXR", "lensbench.app.window.window", "lensbench.app.files.export"})


@pytest.mark.parametrize("words", ["lenses --json", "--version", "info --help"])
def test_the_list_of_lenses_and_help_load_neither_numba_nor_numpy(words):
    loaded = loaded_by(f"from lensbench.app.command.main import main; main({words.split()})")
    assert "lensbench.app.command.library" in loaded
    assert not {name.split(".")[0] for name in loaded} & {"numba", "llvmlite", "numpy"}


@pytest.mark.slow
def test_the_window_loads_neither_hidden_plots_nor_checks_nor_picture_formats():
    loaded = loaded_by("import lensbench.app.window.window")
    assert not loaded & {"PIL", "OpenEXR", "matplotlib", "lensbench.lenses.checks",
                         "lensbench.app.panels.analysis.spots"}


# What the window owns


@pytest.mark.parametrize("path", [path for name in ("widgets", "display", "panels", "window")
                                  for path in files(f"app/{name}")], ids=module)
def test_no_state_of_the_window_is_global(path):
    """Modules hold constants; a mutable dataclass, a class instance of state or a cache of what is drawn does not."""
    tree = parsed(path)
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Global)]
    mutable = {node.name for node in tree.body if isinstance(node, ast.ClassDef) and not any(
        "frozen=True" in ast.unparse(decorator) for decorator in node.decorator_list)
        and not {ast.unparse(base) for base in node.bases} & {"NamedTuple", "Enum"}}
    made = {ast.unparse(node.value.func) for node in tree.body
            if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.Call)}
    assert not made & mutable
    cached = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
              and any("cache" in ast.unparse(decorator) for decorator in node.decorator_list)]
    assert not [node.name for node in cached if "ImVec2" in ast.unparse(node) or "imgui." in ast.unparse(node)]
