"""The house plan: imports point one way and heavy libraries stay in their rooms."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import gspcli

PACKAGE = Path(gspcli.__file__).parent
LAYERS = {
    "__main__": 8,
    "cli": 7,
    "pictures": 6,
    "export": 5.5,
    "calibration": 5.5,
    "paper": 6,
    "atlas": 6,
    "reality": 5.8,
    "sensing": 5.2,
    "dynamics": 5.2,
    "motion": 5,
    "machines": 5,
    "solver": 4,
    "certification": 3,
    "continuation": 3,
    "spec": 3,
    "geometry": 2,
    "symbolic": 2,
    "catalogue": 1,
    "defaults": 0,
    "resources": 0.5,
    "workers": 0.5,
    "errors": 0.2,
    "progress": 0,
    "records": 0,
    "ties": 0,
    "wording": 0,
    "__init__": 8,
}
ROOMS = {
    "sympy": {"symbolic"},
    "flint": {"certification"},
    "mpmath": {"geometry"},
    "yaml": {"spec"},
    "pydantic": {"spec"},
    "click": {"cli"},
    "rich": {"cli"},
    "matplotlib": {"pictures"},
    "scipy": {"dynamics"},
}
#: Rooms and files within rooms, the lowest first: each imports itself and those before it.
INNER_ROOMS = {
    "certification": ("numbers", "equations", "counting", "poses", "branches"),
    "motion": (
        "poses",
        "files",
        "collisions",
        "following",
        "workspace",
        "singularities",
        "paths",
        "statics",
    ),
    "solver": (
        "study_systems",
        "arguments",
        "ends",
        "results",
        "starts",
        "problem",
        "side_poses",
        "ledger",
        "strategies",
        "special",
        "all_poses",
        "many_poses",
        "result",
        "api",
    ),
}
#: Rooms that import less than their place allows: the engine has no words of platforms.
STRANGERS = {"continuation": {"geometry", "catalogue", "symbolic"}}
#: Modules that import the native kernel; all others import these.
OF_THE_KERNEL = {"certification", "continuation", "geometry", "motion"}
STANDARD_LIBRARY_ONLY = {"catalogue", "errors", "resources", "progress", "defaults", "wording"}
STANDARD_LIBRARY_ONLY |= {"records"}
#: What lower rooms may import from the face of the package: its number of version, and the picture
#: that a notebook shows of a result.
EXCEPTIONS = {
    "gspcli.__version__": {
        "atlas",
        "certification",
        "cli",
        "export",
        "pictures",
        "reality",
        "sensing",
        "solver",
    },
    "gspcli.notebook_view": {"solver"},
}
ROW = re.compile(r"\| +([0-9.]+) \| `(\w+)` \| [^|]+ \|([^|]*)\|")
#: pandas is imported only inside the `to_frame` methods.
FRAMES = "pandas"


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def _imports(path: Path) -> frozenset[str]:
    found: set[str] = set()
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(found)


def _sources() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def _room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@pytest.mark.parametrize("room", sorted({_room(path) for path in _sources()}))
def test_imports_point_one_way(room: str) -> None:
    imports = [
        (path, name) for path in _sources() if _room(path) == room for name in _imports(path)
    ]
    for path, name in imports:
        top, _, rest = name.partition(".")
        target = rest.split(".")[0]
        where = f"{path}: {name}"
        if top == "gspcli" and target == "_kernel":
            assert room in OF_THE_KERNEL, where
        elif top == "gspcli" and target != room and room not in EXCEPTIONS.get(name, ()):
            assert LAYERS[target] < LAYERS[room], where
            assert target not in STRANGERS.get(room, ()), where
        if top in ROOMS:
            assert room in ROOMS[top], f"{where}: {top} belongs in {ROOMS[top]}"
        if room in STANDARD_LIBRARY_ONLY and top not in ("gspcli", "__future__", FRAMES):
            assert top in sys.stdlib_module_names, where


@pytest.mark.parametrize("room", INNER_ROOMS)
def test_imports_within_a_room_point_one_way(room: str) -> None:
    inner = INNER_ROOMS[room]
    places = {path: path.relative_to(PACKAGE / room).parts[0] for path in _files_of(room)}
    assert {name.removesuffix(".py") for name in places.values()} == set(inner)
    for path, name in places.items():
        place = inner.index(name.removesuffix(".py"))
        for imported in _imports(path):
            parts = imported.split(".")
            if parts[:2] == ["gspcli", room]:
                assert parts[2] in inner[: place + 1], f"{path}: {imported}"


def _files_of(room: str) -> list[Path]:
    """Return the files of a room but for its face."""
    return sorted(set((PACKAGE / room).rglob("*.py")) - {PACKAGE / room / "__init__.py"})


def test_no_string_names_a_module_of_the_solver() -> None:
    """What calls a function there can be seen: it is imported, not looked up by its name."""
    for path in sorted((PACKAGE / "solver").rglob("*.py")):
        assert "importlib" not in path.read_text(encoding="utf-8"), path
        tree = ast.parse(path.read_text(encoding="utf-8"))
        said = {
            node.body[0].value
            for node in ast.walk(tree)
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
            if node.body and isinstance(node.body[0], ast.Expr)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in said:
                assert not node.value.startswith("gspcli"), f"{path}: {node.value}"


#: Lines of a file and of a function at most.
LONGEST_FILE, LONGEST_FUNCTION = 500, 60


@pytest.mark.parametrize("folder", ["gspcli", "tools", "bench"])
def test_files_and_functions_are_short(folder: str) -> None:
    """Functions without their docstrings."""
    root = PACKAGE.parent
    for path in sorted((root / folder).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(root).as_posix()
        lines = text.count("\n")
        assert lines <= LONGEST_FILE, f"{name}: {lines} lines"
        for node in ast.walk(_tree(path)):
            if isinstance(node, ast.FunctionDef) and node.end_lineno is not None:
                said = (ast.get_docstring(node, clean=False) or "").count("\n")
                lines = node.end_lineno - node.lineno - said
                assert lines <= LONGEST_FUNCTION, f"{name}: {node.name} has {lines} lines"


def _module(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_no_file_imports_itself_by_way_of_others() -> None:
    """Not inside of functions or for type checkers either, where Python would not mind."""
    modules = {_module(path): path for path in _sources()}
    graph: dict[str, set[str]] = {}
    for module, path in modules.items():
        tree = _tree(path)
        names = [
            (f"{node.module}.{alias.name}", node.module)
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        ]
        found = {str(name if name in modules else above) for name, above in names}
        graph[module] = (found & modules.keys()) - {module}
    # `import gspcli` alone imports nothing: its names are looked up when they are used.
    del graph["gspcli"]
    TopologicalSorter(graph).prepare()


def test_every_room_has_its_place() -> None:
    rooms = {_room(path) for path in _sources()}
    assert rooms == LAYERS.keys()


def test_the_plan_on_paper_is_that_of_the_tests() -> None:
    """The table of rooms in the documentation has every room with its level and libraries."""
    text = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = [match.groups() for match in ROW.finditer(text)]
    assert {room: float(level) for level, room, _ in rows} == LAYERS
    owned = {(name.strip(), room) for _, room, names in rows for name in names.split(",")}
    assert owned - {("", room) for room in LAYERS} == {
        (library, room) for library, rooms in ROOMS.items() for room in rooms
    }
    said = re.search(r"may import it: ([\w,\s]+)\.", text)
    assert said is not None
    assert set(said[1].replace(",", " ").split()) == OF_THE_KERNEL


def test_what_the_plan_names_exists() -> None:
    """Paths in the documentation of the architecture lead to files of the package."""
    text = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:[a-z_]+/)+[a-z_]*(?:\.py)?)`", text):
        folder = name.split("/")[0]
        base = PACKAGE.parent if (PACKAGE.parent / folder).is_dir() else PACKAGE
        if folder in LAYERS:
            base = PACKAGE
        assert "NAME" in name or (base / name).exists(), name


def _loaded_by(code: str) -> set[str]:
    script = f"import sys\n{code}\nprint(*sys.modules)"
    run = subprocess.run(  # the interpreter of the tests with a fixed script
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(run.stdout.splitlines()[-1].split())


HEAVY = {"numpy", "sympy", "pandas", "flint", "pydantic", "yaml", "rich", "scipy", "matplotlib"}


@pytest.mark.parametrize(
    ("code", "forbidden"),
    [
        ("import gspcli", HEAVY | {"click"}),
        ("from gspcli.cli.main import run; run(['--help'])", HEAVY),
        ("from gspcli.cli.main import run; run(['--version'])", HEAVY),
        (
            "from gspcli.cli.main import run; run(['enumerate', '--format', 'csv'])",
            HEAVY,
        ),
        ("from gspcli.cli.main import run; run(['bound', '17', '--format', 'json'])", HEAVY),
        (
            "from gspcli.cli.main import run; run(['solve', '@dietmaier', '--format', 'json'])",
            HEAVY - {"numpy"} | {"mpmath", "difflib"},
        ),
        (
            "from gspcli.cli.main import run; run(['solve', '@nano-hexapod', '--format', 'json'])",
            # `numpy.ma` is loaded by `np.unique`, which takes as long as solving that platform, and
            # no path is to be followed with more digits.
            HEAVY - {"numpy", "flint"} | {"numpy.ma", "gspcli.solver.strategies.more_digits"},
        ),
    ],
)
def test_start_up_loads_only_what_is_needed(code: str, forbidden: set[str]) -> None:
    assert not _loaded_by(code) & forbidden


def test_code_for_an_instruction_set_stays_in_its_build():
    """Functions that are compiled several times are local to each build.

    The linker merges functions of the same name: all builds would run the one that comes first.
    """
    native = PACKAGE.parent / "native"
    parts = re.findall(
        r"add_part\(\S+ (\w+) ", (PACKAGE.parent / "CMakeLists.txt").read_text("utf-8")
    )
    waiting, seen = [native / f"{part}.cpp" for part in set(parts)], set()
    while waiting:
        file = waiting.pop()
        text = file.read_text("utf-8")
        new = {native / name for name in re.findall(r'#include "(.+)"', text)} - seen
        seen |= new
        waiting += new
    assert native / "border_basis.hpp" in seen
    for file in seen:
        text = file.read_text("utf-8")
        text = re.sub(r"namespace \{.*\n\}  // namespace\n", "", text, flags=re.S)
        body = re.search(r"\)( const)? \{", re.sub(r"//.*", "", text))
        assert body is None, f"{file.name}: a function outside of an anonymous namespace"


def test_no_two_classes_have_one_name() -> None:
    homes: dict[str, set[str]] = {}
    for path in _sources():
        for node in _tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes.setdefault(node.name, set()).add(str(path.relative_to(PACKAGE)))
    shared = {name: places for name, places in homes.items() if len(places) > 1}
    # The second is public: the masses of the drives of a file.
    assert shared == {"Drives": {"geometry/drives.py", "geometry/masses.py"}}
