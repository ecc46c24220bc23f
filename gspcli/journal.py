"""Many tasks with a work file: it has a line of JSON for each, so that work can be resumed."""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, ClassVar, Protocol, TypeVar

from gspcli.errors import GspError
from gspcli.wording import named

Item = TypeVar("Item")

#: The beginning of a line, and the bytes that are read at a time in the search for the last line.
_BEGIN, _STEP = b'{"', 1 << 16
#: The place of the lock, on systems that lock parts of files.
_FAR = 2**31 - 2
#: Characters of the name of a file that are in that of the lock beside it.
_KEPT = 200


class Done(Protocol):
    """The result of a task: a dataclass whose values JSON can write."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def task(self) -> Hashable:
        """The task."""


Result = TypeVar("Result", bound=Done)


class Journal:
    """A work file that only this process may use."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self._path, self._file = path, file
        self._whole = False

    @classmethod
    @contextmanager
    def opened(cls, path: Path) -> Iterator[Journal]:
        """Open a work file, which need not exist yet.

        Raises
        ------
        GspError
            If it cannot be opened, or another process uses it.
        """
        with _opened_alone(path, path, "opened") as file:
            yield cls(path, file)

    def read(self, decode: Callable[[dict[str, Any]], Item]) -> list[Item]:
        """Return the items of its lines; a last line that was cut off is ignored.

        Parameters
        ----------
        decode
            Converts the values of a line to an item; raises ValueError, TypeError or KeyError for
            other values.

        Raises
        ------
        GspError
            If a line is not an item.
        """
        if not self._path.is_file():
            return []
        self._file.seek(0)
        # Text after the last end of line was being written when the work was interrupted.
        *lines, rest = self._file.read().split(b"\n")
        items = []
        for number, line in enumerate(lines, start=1):
            try:
                items.append(decode(json.loads(line)))
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
                raise self._no_line(number) from error
        if not _BEGIN.startswith(rest[: len(_BEGIN)]):
            raise self._no_line(len(lines) + 1)
        return items

    def append(self, entry: Mapping[str, Any]) -> None:
        """Add a line.

        Raises
        ------
        GspError
            If the disk is full, or the file is no work file.
        """
        try:
            if not self._whole:
                self._cut_off()
                self._whole = True
            line = json.dumps(entry).encode() + b"\n"
            while line:
                line = line[self._file.write(line) :]
        except OSError as error:
            message = f"{self._path}: cannot be written: {error.strerror}"
            raise GspError(message) from error

    def _cut_off(self) -> None:
        """Drop a last line that was cut off when the work was interrupted."""
        if not self._path.is_file():
            return
        end = start = self._file.seek(0, os.SEEK_END)
        rest = b""
        while start > 0 and b"\n" not in rest:
            start, before = max(0, start - _STEP), start
            self._file.seek(start)
            rest = self._file.read(before - start) + rest
        rest = rest[rest.rfind(b"\n") + 1 :]
        if not _BEGIN.startswith(rest[: len(_BEGIN)]):
            message = f"{self._path}: this is not a work file: choose another"
            raise GspError(message)
        self._file.truncate(end - len(rest))

    def _no_line(self, number: int) -> GspError:
        return GspError(f"{self._path}:{number}: this is not a line of a work file")


def _locked(file: BinaryIO) -> bool:
    """Lock a file for this process until it is closed; return whether that was possible."""
    try:
        if sys.platform == "win32":
            import msvcrt

            # Other processes may read it: the lock is far after its end.
            file.seek(_FAR)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        # In a file system without locks no process respects them.
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK)
    return True


@contextmanager
def _opened_alone(file: Path, work: Path, done: str) -> Iterator[BinaryIO]:
    """Open and lock a file; errors name the work file, and say that it cannot be ``done``."""
    try:
        # Every line goes out at once, and at the end.
        opened = file.open("a+b", buffering=0)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        message = f"{named(work)}: cannot be {done}: {reason}"
        raise GspError(message) from error
    with opened:
        if not _locked(opened):
            message = f"{named(work)}: another process is at this work: wait, or use another file"
            raise GspError(message)
        yield opened


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Keep a file that is replaced during the work for this process alone.

    The lock is on a file beside it, which is removed in the end.

    Raises
    ------
    GspError
        If another process works with it.
    """
    lock = path.with_name(f".{path.name[:_KEPT]}.lock")
    with _opened_alone(lock, path, "written"):
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)
