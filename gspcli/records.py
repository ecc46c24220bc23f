"""Frozen dataclasses that are made quickly: start-up makes dozens, and a short command uses few.

The standard library writes source code for each method of each class and compiles it: six times
for a frozen class, three million instructions. Here only ``__init__`` is written so; all
other methods are functions of the fields, the same for all classes.
"""

from __future__ import annotations

import dataclasses
import operator
import reprlib
from collections.abc import Callable
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal, NoReturn, TypeVar

if TYPE_CHECKING:
    import pandas as pd

Class = TypeVar("Class", bound=type[Any])
Fields = tuple[dataclasses.Field[Any], ...]

_ORDERINGS = (operator.lt, operator.le, operator.gt, operator.ge)


class _Absent:
    """The default of a field whose value is made by a function: it means that none was given."""

    def __repr__(self) -> str:
        return "<factory>"


def _frozen(
    *,
    frozen: Literal[True],
    init: bool = True,
    eq: bool = True,
    order: bool = False,
    kw_only: bool = False,
) -> Callable[[Class], Class]:
    """As `dataclasses.dataclass` with the same arguments."""
    del frozen

    def made(cls: Class) -> Class:
        dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)
        fields = dataclasses.fields(cls)
        key = _key([field.name for field in fields if field.compare])
        methods: dict[str, Any] = {
            "__repr__": _representation(fields),
            "__setattr__": _no_setting,
            "__delattr__": _no_deleting,
        }
        if init:
            methods["__init__"] = _constructor(cls, fields)
        if eq:
            methods |= {"__eq__": _comparison(operator.eq, key), "__hash__": _hashed(key)}
        if order:
            methods |= {f"__{f.__name__}__": _comparison(f, key) for f in _ORDERINGS}
        for name, method in methods.items():
            # A class that says when it is equal has None for its hash.
            if cls.__dict__.get(name) is None:
                setattr(cls, name, method)
        return cls

    return made


def _no_setting(self: object, name: str, value: object) -> NoReturn:
    del self, value
    message = f"cannot assign to field {name!r}"
    raise dataclasses.FrozenInstanceError(message)


def _no_deleting(self: object, name: str) -> NoReturn:
    del self
    message = f"cannot delete field {name!r}"
    raise dataclasses.FrozenInstanceError(message)


def _constructor(cls: type, fields: Fields) -> Callable[..., None]:
    """Return ``__init__``, which is compiled: it runs for each object, and says what it takes."""
    known: dict[str, Any] = {"_put": object.__setattr__, "_absent": _Absent()}
    positional, lines = ["self"], []
    named: list[str] = []
    for field in fields:
        name = value = parameter = field.name
        if field.default is not dataclasses.MISSING:
            known[f"_default_{name}"] = field.default
            parameter = f"{name}=_default_{name}"
        elif field.default_factory is not dataclasses.MISSING:
            known[f"_default_{name}"] = field.default_factory
            parameter = f"{name}=_absent"
            value = f"_default_{name}() if {name} is _absent else {name}"
        (named if field.kw_only else positional).append(parameter)
        lines.append(f" _put(self, {name!r}, {value})")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()")
    parameters = ", ".join(positional + (["*", *named] if named else []))
    source = "\n".join([f"def __init__({parameters}):", *(lines or [" pass"])])
    exec(source, known)
    made: Callable[..., None] = known["__init__"]
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    # `help` looks for the module of what it describes.
    made.__module__ = cls.__module__
    made.__annotations__ = {field.name: field.type for field in fields} | {"return": None}
    return made


def _representation(fields: Fields) -> Callable[[Any], str]:
    names = [field.name for field in fields if field.repr]

    @reprlib.recursive_repr()
    def represent(self: Any) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{self.__class__.__qualname__}({values})"

    return represent


def _key(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return what objects are compared by: the tuple of some attributes."""
    if len(names) == 1:
        alone = attrgetter(*names)
        return lambda self: (alone(self),)
    return attrgetter(*names) if names else lambda self: ()


def _hashed(key: Callable[[Any], tuple[Any, ...]]) -> Callable[[Any], int]:
    return lambda self: hash(key(self))


def _comparison(
    compare: Callable[[Any, Any], Any], key: Callable[[Any], tuple[Any, ...]]
) -> Callable[[Any, Any], Any]:
    def compared(self: Any, other: Any) -> Any:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return compare(key(self), key(other))

    return compared


class EqualByContent:
    """A base of results, which hold arrays: they are equal if all that they hold is."""

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return _same(self, other)

    def __hash__(self) -> int:
        # Equal objects have equal hashes, and arrays have none.
        return hash(type(self))


class Tabular(EqualByContent):
    """A base of results that are also rows of plain data."""

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows."""
        raise NotImplementedError

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())


def _same(one: Any, other: Any) -> bool:
    if one is other:
        return True
    if one.__class__ is not other.__class__:
        return False
    if hasattr(one, "tobytes"):
        return bool(
            one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
        )
    if dataclasses.is_dataclass(one):
        names = [field.name for field in dataclasses.fields(one)]
        return all(_same(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other)


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    dataclass = _frozen
