"""The package: imports, start-up, wheel, public names, pickles."""

from __future__ import annotations

import ast
import os
import pickle
import re
import subprocess
import sys
import tomllib
import zipfile
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest

import gspcli
import gspcli._kernel
from gspcli.errors import ArgumentError, GspError, Location, Mistake, SpecError

# The house plan: imports point one way and heavy libraries stay in their rooms.


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
    "symbolic": 2.5,
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
    "flint": {"certification", "geometry"},
    "mpmath": {"geometry", "sensing"},
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
#: What rooms may import besides: lower ones from the face of the package its number of version, and
#: the picture that a notebook shows of a result.
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
    # The engine knows Study coordinates, and nothing else of platforms.
    "gspcli.geometry.study": {"continuation"},
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
        ("from gspcli.cli.main import run; run(['enumerate', '--format', 'csv'])", HEAVY),
        ("from gspcli.cli.main import run; run(['bound', '17', '--format', 'json'])", HEAVY),
        (
            "from gspcli.cli.main import run; run(['solve', '@dietmaier', '--format', 'json'])",
            HEAVY - {"numpy", "yaml", "flint"} | {"mpmath", "difflib"},
        ),
        (
            "from gspcli.cli.main import run; run(['solve', '@nano-hexapod', '--format', 'json'])",
            # `numpy.ma` is loaded by `np.unique`, which takes as long as solving that platform, and
            # no path is to be followed with more digits.
            HEAVY - {"numpy", "yaml", "flint"} | {"numpy.ma", "gspcli.solver.further"},
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
    assert native / "motion_ring.hpp" in seen
    for file in seen:
        text = file.read_text("utf-8")
        text = re.sub(r"namespace \{.*\n\}  // namespace\n", "", text, flags=re.S)
        body = re.search(r"\)( const)? \{", re.sub(r"//.*", "", text))
        assert body is None, f"{file.name}: a function outside of an anonymous namespace"


# The public names of the package.


def test_every_public_name_can_be_imported() -> None:
    for name in gspcli.__all__:
        assert getattr(gspcli, name) is not None
    assert set(dir(gspcli)) == set(gspcli.__all__)


def test_public_names_are_all_listed() -> None:
    assert set(gspcli._HOMES) | {"__version__"} == set(gspcli.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'frobnicate'"):
        _ = gspcli.frobnicate


# Files for services and archives: they agree with the package and with each other.


ROOT = Path(gspcli.__file__).resolve().parents[1]


def test_check_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    from gspcli.cli.main import run

    assert run(["check", "--schema"]) == 0
    recorded = (ROOT / "data" / "instance.schema.json").read_text(encoding="utf-8")
    assert capsys.readouterr().out.rstrip() == recorded.rstrip()
    assert run(["check"]) == 2
    assert run(["check", "--schema", "@dietmaier"]) == 2


# The wheel holds the kernel and the data, and works without the checkout.


#: Stands for the CMakeLists.txt of the checkout, with the same rule of installation.
KERNEL = """
cmake_minimum_required(VERSION 3.24)
project(gspcli LANGUAGES NONE)
install(FILES "{kernel}" DESTINATION gspcli)
"""
CHECK = """
import gspcli, pathlib, sys
from gspcli.cli.main import run
from gspcli.resources import data_directory
home = pathlib.Path(sys.argv[1]).resolve()
assert home in pathlib.Path(gspcli.__file__).resolve().parents, gspcli.__file__
assert home in data_directory().parents, data_directory()
examples = data_directory() / "examples"
sys.exit(run(["solve", str(examples / "example-6.8.yaml")])
         or run(["solve", str(examples / "dietmaier.yaml")])
         or run(["table", "3"]))
"""


def test_an_installed_wheel_is_complete(tmp_path: Path) -> None:
    wheels, home = tmp_path / "wheels", tmp_path / "home"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = [*pip, "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(wheels)]
    kernel = tmp_path / "kernel"
    kernel.mkdir()
    (kernel / "CMakeLists.txt").write_text(KERNEL.format(kernel=gspcli._kernel.__file__))
    environment = {
        **os.environ,
        "SKBUILD_BUILD_DIR": str(tmp_path / "build"),
        "SKBUILD_CMAKE_SOURCE_DIR": str(kernel),
    }
    subprocess.run([*build, str(ROOT)], check=True, env=environment)
    (wheel,) = wheels.iterdir()
    data = [x for x in zipfile.ZipFile(wheel).namelist() if x.startswith("gspcli/data/")]
    made_of = [x for x in data if x.endswith("manifest.json")]
    assert made_of == ["gspcli/data/start-systems/manifest.json"]
    assert not any("trajectories" in x for x in data)
    subprocess.run([*pip, "install", "--no-deps", "--target", str(home), str(wheel)], check=True)
    # -S leaves the editable installation out; the dependencies are put back by hand.
    dependencies = [path for path in sys.path if path.endswith("site-packages")]
    run = subprocess.run(
        [sys.executable, "-S", "-c", CHECK, str(home)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(home), *dependencies])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert "complete, proved: all 64 solutions" in run.stdout
    assert "complete, proved: all 40 solutions" in run.stdout


def test_wheels_are_checked_for_the_versions_that_are_promised() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    page = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    found = re.search(r"Python 3\.(\d+) to 3\.(\d+) on Linux", page)
    assert found is not None
    first, last = map(int, found.groups())
    builds = project["tool"]["cibuildwheel"]["build"]
    assert builds == [f"cp3{minor}-*" for minor in range(first, last + 1)]
    assert project["project"]["requires-python"] == f">=3.{first}"
    assert project["tool"]["scikit-build"]["wheel"]["py-api"] in {b.rstrip("-*") for b in builds}


# Results and errors go through pickle; functions take the names that commands take.


def copied(one):
    return pickle.loads(pickle.dumps(one))


def subclasses(kind):
    yield kind
    for one in kind.__subclasses__():
        yield from subclasses(one)


@pytest.mark.parametrize("kind", [*dict.fromkeys(subclasses(GspError))], ids=lambda k: k.__name__)
def test_an_error_is_the_same_after_it(kind):
    if kind is SpecError:
        places = [Mistake(Location("f.yaml", k, 2), "units", f"found {k}") for k in range(7)]
        error = SpecError([*places, Mistake(None, "", "nothing")])
        assert copied(error).mistakes == error.mistakes
    elif issubclass(kind, ArgumentError) and kind is not ArgumentError:
        # A mistake of a row: the row, and what was found.
        error = kind(3, "found 1")
    elif kind is ArgumentError:
        error = ArgumentError("found 1", "lengths[3]")
        assert (copied(error).message, copied(error).where) == ("found 1", "lengths[3]")
    else:
        error = kind("found 1, expected 2")
    again = copied(error)
    assert (type(again), str(again), again.exit_code) == (kind, str(error), error.exit_code)


@pytest.fixture(scope="module")
def hexapod():
    return gspcli.example("rubin-m2")


@pytest.fixture(scope="module")
def solved(hexapod):
    return gspcli.solve(hexapod)


def of_functions(hexapod, solved):
    """Yield what public functions return, by their names."""
    R, T = solved.R[solved.real].real, solved.T[solved.real].real
    values = gspcli.measure(hexapod, R[0], T[0])
    yield "solve", solved
    yield "solve_batch", gspcli.solve_batch(hexapod, np.tile(values, (2, 1)))
    yield "certify", gspcli.certify(hexapod, R, T)
    yield "track", gspcli.track(hexapod, np.stack((values, values * 1.0001)))
    yield "clearance", gspcli.clearance(hexapod, R, T)
    yield "analyze", gspcli.analyze(hexapod, R, T, stiffness=1)
    yield "check", gspcli.check("@nothing")
    yield "count", gspcli.count(hexapod, effort=1e-6)
    yield "derive", gspcli.derive("psc")
    yield "derive expanded", gspcli.derive("ppp", expand=True)
    yield "bound", gspcli.bound("6PP")
    yield "show", gspcli.show("6PP")
    yield "table", gspcli.table(1)
    yield "sample", gspcli.sample("3D3A PH PH PH", 2)
    yield "exported", gspcli.exported(hexapod, "msolve")
    yield "sensors", gspcli.sensors(hexapod)
    yield "atlas_summary", gspcli.atlas_summary()


def test_results_are_the_same_after_it(hexapod, solved):
    for name, result in of_functions(hexapod, solved):
        again = copied(result)
        assert repr(again) == repr(result), name
        if hasattr(result, "to_json") and name not in ("certify",):
            assert repr(again.to_json()) == repr(result.to_json()), name


def test_certificates_prove_the_same_after_it(hexapod, solved):
    proved = gspcli.certify(hexapod, solved.R, solved.T)
    for one, again in zip(proved, copied(proved), strict=True):
        assert (again.certified, again.real, again.outcome) == (
            one.certified, one.real, one.outcome,
        )  # fmt: skip


def test_a_follower_stands_where_it_stood(hexapod, solved):
    pose = solved.real_solutions[0]
    follower = gspcli.Follower(hexapod, pose.R.real, pose.T.real)
    follower.forward(follower.values * 1.001)
    again = copied(follower)
    assert np.allclose(again.values, follower.values, rtol=1e-14)
    assert np.allclose(again.T, follower.T, rtol=1e-12)


@pytest.mark.parametrize("name", sorted({*gspcli.__all__} - {"__version__"}))
def test_functions_and_classes_are_found_by_name(name):
    """What is sent to another process is found there."""
    one = getattr(gspcli, name)
    assert copied(one) is one


def test_functions_take_the_names_that_commands_take():
    assert gspcli.bound("3D3A PL PL LP").subject.id
    assert gspcli.show(421).subject.number == gspcli.show("421").subject.number == 421
    assert gspcli.constraint_facts("PL") == gspcli.constraint_facts("dpl")
    assert gspcli.new("6-3", seed=2) == gspcli.new("6-3", seed=2)
    assert gspcli.new("421").type.number == gspcli.new(421).type.number == 421
    assert gspcli.sample("3D3A PH PH PH", 2).tally.platforms == 2
    for wrong in (lambda: gspcli.bound("6XX"), lambda: gspcli.show("4D2A"),
                  lambda: gspcli.constraint_facts("LL"), lambda: gspcli.new("6QQ"),
                  lambda: gspcli.sample("6PP", -1), lambda: gspcli.bound(None)):  # fmt: skip
        with pytest.raises(GspError):
            wrong()


def test_a_path_and_a_frame_are_taken(tmp_path, hexapod):
    pd = pytest.importorskip("pandas")
    path = tmp_path / "a.yaml"
    gspcli.dump(hexapod, path)
    gspcli.dump(hexapod, str(path))
    assert gspcli.load(path) == hexapod
    base, platform = np.arange(18.0).reshape(6, 3), np.arange(18.0).reshape(6, 3) ** 2 % 7
    given = gspcli.hexapod(base, platform, [1, 2, 3, 4, 5, 6])
    frames = [pd.DataFrame(rows, columns=list("xyz")) for rows in (base, platform)]
    assert gspcli.hexapod(*frames, pd.Series([1, 2, 3, 4, 5, 6])) == given


def test_results_are_equal_after_pickling():
    instance = gspcli.example("nano-hexapod")
    result = gspcli.solve(instance)
    home = result.home
    for one in (
        result,
        result.solutions[0],
        home,
        gspcli.analyze(instance, home),
        gspcli.clearance(instance, home.R, home.T),
        gspcli.freedoms(instance, home.R, home.T),
    ):
        again = pickle.loads(pickle.dumps(one))
        assert again == one
        assert hash(again) == hash(one)
    assert result != gspcli.solve(gspcli.set_values(instance, {1: "0.001"}, delta=True))
