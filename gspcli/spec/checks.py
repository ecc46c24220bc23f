"""Checks of instance files: their mistakes, and the platforms that they describe."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.coincidence import canonical_bonds
from gspcli.errors import Mistake, SpecError
from gspcli.geometry.instance import Instance
from gspcli.records import EqualByContent, dataclass
from gspcli.spec.meaning import bonds, sharing
from gspcli.spec.reading import read
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class CheckedFile(EqualByContent):
    """The check of one file."""

    #: The name of the file.
    name: str
    #: The platform; None if the file has mistakes.
    instance: Instance | None
    #: Its mistakes, and remarks about unusual content, each with its place.
    mistakes: tuple[Mistake, ...] = ()
    warnings: tuple[Mistake, ...] = ()

    @property
    def valid(self) -> bool:
        """Whether there is no mistake."""
        return self.instance is not None

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data."""
        entry: dict[str, Any] = {"file": self.name, "valid": self.valid}
        if self.instance is None:
            return {**entry, "problems": [_plain(one) for one in self.mistakes]}
        facts = _facts(self.instance)
        return {**entry, **facts, "warnings": [_plain(one) for one in self.warnings]}


@dataclass(frozen=True, eq=False)
class CheckResult(EqualByContent):
    """The checks of several files.

    Attributes
    ----------
    files
        The checks in the given order.
    """

    files: tuple[CheckedFile, ...]

    def __repr__(self) -> str:
        wrong = sum(not one.valid for one in self.files)
        warned = sum(len(one.warnings) for one in self.files)
        said = f"{wrong} with mistakes, {counted(warned, 'warning')}"
        return f"<CheckResult: {counted(len(self.files), 'file')}, {said}>"

    @property
    def valid(self) -> bool:
        """Whether no file has a mistake."""
        return all(one.valid for one in self.files)

    @property
    def mistakes(self) -> list[Mistake]:
        """The mistakes in all files."""
        return [mistake for one in self.files for mistake in one.mistakes]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each file (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame([one.to_json() for one in self.files])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.check/1``."""
        return {"schema": "gsp.check/1", "files": [one.to_json() for one in self.files]}


def check(
    *sources: str | Path | TextIO | BinaryIO, names: Sequence[str] | None = None
) -> CheckResult:
    """Check instance files and return the platforms that they describe.

    Parameters
    ----------
    sources
        Paths, ``-`` for standard input, or open files.
    names
        Their names in the result; their paths if None.
    """
    names = [_name(one) for one in sources] if names is None else names
    pairs = zip(sources, names, strict=True)
    return CheckResult(tuple(_checked(source, name) for source, name in pairs))


def _checked(source: str | Path | TextIO | BinaryIO, name: str) -> CheckedFile:
    try:
        reading = read(source)
    except SpecError as error:
        return CheckedFile(name, None, tuple(error.mistakes))
    return CheckedFile(name, reading.instance, warnings=reading.warnings)


def _name(source: str | Path | TextIO | BinaryIO) -> str:
    return str(source if isinstance(source, str | Path) else getattr(source, "name", "input"))


def _facts(instance: Instance) -> dict[str, Any]:
    platform, base = sharing(instance)
    bound = type_bounds(instance.type).refined_one_sided.value
    return {
        **instance.to_json(),
        "shared": {"platform": platform, "base": base},
        "pattern": " ".join(map(str, canonical_bonds(bonds(instance)))),
        "expected": instance.expected,
        "bound": bound * instance.side_choices,
    }


def _plain(mistake: Mistake) -> dict[str, object]:
    location = mistake.location
    return {
        "line": location.line if location else None,
        "column": location.column if location else None,
        "path": mistake.path,
        "message": mistake.message,
    }
