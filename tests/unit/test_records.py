"""Records are the frozen dataclasses of the standard library, made with less compiling."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
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
