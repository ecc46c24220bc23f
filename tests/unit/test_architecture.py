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
    "journal": 0.6,
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
    "click": {"cli"},
    "rich": {"cli"},
    "matplotlib": {"pictures"},
    "scipy": {"dynamics"},
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


def _loaded_by(code: str) -> set[str]:
    script = f"import sys\n{code}\nprint(*sys.modules)"
    run = subprocess.run(  # the interpreter of the tests with a fixed script
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(run.stdout.splitlines()[-1].split())


HEAVY = {"numpy", "sympy", "pandas", "flint", "yaml", "rich", "scipy", "matplotlib"}


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
            HEAVY - {"numpy", "yaml"} | {"mpmath", "difflib"},
        ),
        (
            "from gspcli.cli.main import run; run(['solve', '@nano-hexapod', '--format', 'json'])",
            # `numpy.ma` is loaded by `np.unique`, which takes as long as solving that platform, and
            # no path is to be followed with more digits.
            HEAVY - {"numpy", "yaml", "flint"}
            | {"numpy.ma", "gspcli.solver.strategies.more_digits"},
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
