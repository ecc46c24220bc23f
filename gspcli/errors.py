"""The exceptions of the package, all `GspError`, and the exit code each one maps to."""

from __future__ import annotations

from typing import Any

from gspcli.records import dataclass
from gspcli.wording import brief, named

#: Exit code of what the user interrupted; those of errors are `GspError.exit_code`.
INTERRUPTED = 130


class GspError(Exception):
    """Base class of every error that a user can cause or should read.

    The text of an error is one to five lines: where, what was found, what was expected or
    what to do.
    """

    exit_code = 2


class TypeNameError(GspError):
    """A name that denotes no platform type, family or constraint kind."""


@dataclass(frozen=True, order=True)
class Location:
    """A place in a file; `line` and `column` count from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{named(self.file)}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Mistake:
    """One mistake in an input file.

    Parameters
    ----------
    location
        Where in the file, or None when the mistake has no place.
    path
        The key path, as ``constraints[3].value``; empty for the whole document.
    message
        What was found, what was expected and what to do.
    """

    location: Location | None
    path: str
    message: str

    def __str__(self) -> str:
        parts = [str(part) for part in (self.location, self.path) if part]
        return ": ".join([*parts, self.message])


class SpecError(GspError):
    """An instance file with mistakes: the text has the first ones, `mistakes` all of them."""

    def __init__(self, mistakes: list[Mistake]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__(brief("\n".join(map(str, mistakes)), "mistake"))

    def __reduce__(self) -> tuple[Any, ...]:
        # The text of an exception is not what it is made from.
        return type(self), (list(self.mistakes),)


class ArgumentError(GspError, ValueError):
    """A wrong argument of a function; the text begins with its name and index.

    Parameters
    ----------
    message
        What was found and what was expected.
    where
        The argument, as ``lengths[3]``.
    """

    def __init__(self, message: str, where: str = "") -> None:
        self.message, self.where = message, where
        super().__init__(f"{where}: {message}" if where else message)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.message, self.where)

    def within(self, where: str) -> ArgumentError:
        """Return the error of a part as one of the whole: ``[2]`` in ``base`` is ``base[2]``."""
        joint = "." if self.where and not self.where.startswith("[") and where else ""
        return ArgumentError(self.message, f"{where}{joint}{self.where}")


class DataError(GspError):
    """Shipped data is missing or does not have the recorded content."""


class CheckFailed(GspError):
    """A check that was asked for did not hold."""

    exit_code = 1


class NotFiniteError(GspError):
    """The solution set of an instance is not finite."""

    exit_code = 3


class IncompleteError(GspError):
    """An answer could not be completed or certified."""

    exit_code = 4
