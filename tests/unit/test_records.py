"""Records are the frozen dataclasses of the standard library, made with less compiling."""

from __future__ import annotations

import ast
import builtins
import copy
import dataclasses
import inspect
import os
import pickle
import pydoc
import subprocess
from dataclasses import field
from pathlib import Path

import pytest

import gspcli
from gspcli import records

PACKAGE = Path(gspcli.__file__).parent


def classes(dataclass):
    """Return classes of all sorts, made by one decorator."""

    @dataclass(frozen=True)
    class Plain:
        """Some fields."""

        a: int
        b: str = "b"
        c: list[int] = field(default_factory=list, repr=False)
        d: float = field(default=0.0, compare=False)

        def __post_init__(self):
            if self.a < 0:
                raise ValueError("negative")

    @dataclass(frozen=True, order=True)
    class Ordered(Plain):
        """One field more."""

        e: int = 3

    @dataclass(frozen=True, eq=False)
    class Alone:
        """Equal to itself only."""

        a: float

    @dataclass(frozen=True)
    class One:
        """One field."""

        a: float

        def __eq__(self, other):
            return NotImplemented

    @dataclass(frozen=True, kw_only=True)
    class Named:
        """By name only."""

        a: int = 1
        b: int

    @dataclass(frozen=True, init=False)
    class Own:
        """Its own constructor."""

        a: int

        def __init__(self, text):
            object.__setattr__(self, "a", int(text))

        def __repr__(self):
            return "own"

    @dataclass(frozen=True)
    class Empty:
        """No field."""

    return {cls.__name__: cls for cls in (Plain, Ordered, Alone, One, Named, Own, Empty)}


OURS, STANDARD = classes(records.dataclass), classes(dataclasses.dataclass)
CALLS = [
    ("Plain", (1,), {}),
    ("Plain", (2, "x"), {"d": 1.5}),
    ("Plain", (2, "x", [1]), {}),
    ("Plain", (-1,), {}),
    ("Plain", (), {}),
    ("Plain", (1,), {"z": 0}),
    ("Ordered", (1, "b", (), 2.0, 5), {}),
    ("Ordered", (2, "a", ()), {}),
    ("Alone", (float("nan"),), {}),
    ("One", (float("nan"),), {}),
    ("Named", (), {"b": 2}),
    ("Named", (2,), {}),
    ("Named", (), {}),
    ("Own", ("7",), {}),
    ("Empty", (), {}),
]


def outcome(action):
    """Return what an action gives, or the error that it raises."""
    try:
        return action()
    except (AttributeError, TypeError, ValueError) as error:
        return type(error), str(error)


@pytest.mark.parametrize(("name", "given", "named"), CALLS)
def test_objects_are_as_those_of_the_standard_library(name, given, named):
    def told(cls):
        made = outcome(lambda: cls(*given, **named))
        if isinstance(made, tuple):
            return made
        same = [
            outcome(lambda change=change: repr(change()))
            for change in (
                lambda: dataclasses.replace(made),
                lambda: dataclasses.replace(made, a=5),
                lambda: setattr(made, "a", 1),
                lambda: setattr(made, "other", 1),
                lambda: delattr(made, "a"),
                lambda: made < made,
                lambda: made == copy.deepcopy(made),
                lambda: made == copy.copy(made),
                lambda: made != object(),
                lambda: cls.__hash__ is object.__hash__ or hash(made),
            )
        ]
        return repr(made), vars(made).keys(), same

    assert told(OURS[name]) == told(STANDARD[name])


def test_order_and_equality_are_those_of_the_fields():
    def told(cls):
        some = [cls(a, b, (), d, e) for a in (1, 2) for b in "xy" for d in (0, 1) for e in (1, 2)]
        pairs = [(x < y, x <= y, x > y, x >= y, x == y) for x in some for y in some]
        return pairs, [hash(x) == hash(y) for x in some for y in some]

    assert told(OURS["Ordered"]) == told(STANDARD["Ordered"])
    assert OURS["Plain"](1) != OURS["Ordered"](1)


@pytest.mark.parametrize("name", OURS)
def test_classes_say_the_same_of_themselves(name):
    ours, standard = OURS[name], STANDARD[name]
    assert str(inspect.signature(ours)) == str(inspect.signature(standard))
    assert [f.name for f in dataclasses.fields(ours)] == [
        f.name for f in dataclasses.fields(standard)
    ]
    assert ours.__match_args__ == standard.__match_args__
    assert (ours.__hash__ is None) == (standard.__hash__ is None)


def test_objects_travel_to_other_processes():
    line = gspcli.parse_type("6PP")
    assert pickle.loads(pickle.dumps(line)) == line


def test_a_class_compiles_its_constructor_only(monkeypatch):
    compiled = []
    real = builtins.exec
    monkeypatch.setattr(builtins, "exec", lambda *given: (compiled.append(1), real(*given))[1])
    classes(records.dataclass)
    ours, compiled[:] = len(compiled), []
    classes(dataclasses.dataclass)
    assert ours == len(OURS) - 1
    assert len(compiled) > 5 * ours


def test_frozen_classes_of_the_package_are_records():
    """Those with slots, which records have not, are beside them; the others can change."""
    for path in PACKAGE.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        sources = {
            alias.asname or alias.name: node.module
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                for decorator in node.decorator_list:
                    text = ast.unparse(decorator)
                    if text.startswith("dataclass") and "frozen" in text and "slots" not in text:
                        assert sources["dataclass"] == "gspcli.records", f"{path}: {node.name}"


def test_help_on_the_package_has_all_records():
    text = pydoc.plain(pydoc.render_doc(gspcli))
    assert "class Point(" in text
    assert "__init__(self, position" in text
    assert gspcli.Point.__init__.__module__ == gspcli.Point.__module__


_INTERPRETERS = sorted(
    path
    for path in Path.home().glob(".pyenv/versions/3.*/bin/python")
    if tuple(map(int, path.parts[-3].split(".")[:2])) >= (3, 11)
)
_SCRIPT = """
import pydoc, sys, types
from gspcli.records import dataclass
module = types.ModuleType("places")
module.__all__ = ["Place"]
exec('''
@dataclass(frozen=True)
class Place:
    x: float
''', module.__dict__ | {"dataclass": dataclass, "__name__": "places"}, vars(module))
assert "__init__(self, x" in pydoc.plain(pydoc.render_doc(module))
"""


@pytest.mark.skipif(not _INTERPRETERS, reason="no other interpreters are installed by pyenv")
@pytest.mark.parametrize("interpreter", _INTERPRETERS, ids=lambda path: path.parts[-3])
def test_help_on_records_in_each_python(interpreter):
    settings = os.environ | {"PYTHONPATH": str(PACKAGE.parent)}
    run = subprocess.run(
        [interpreter, "-c", _SCRIPT], env=settings, capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stderr) == (0, "")
