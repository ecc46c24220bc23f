"""The files that commands write, whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gspcli.errors import GspError
from gspcli.wording import named

#: Characters of the name of a file that are in that of the temporary one: names have a limit.
_KEPT = 32


def check_writable(path: Path) -> None:
    """Raise before the work, not after it, if no file can be written to a place."""
    with _told(path):
        # A name that is too long raises in the first call.
        folder = path.resolve().parent
        if path.is_dir():
            code = errno.EISDIR
        elif not folder.is_dir():
            code = errno.ENOENT
        elif not os.access(folder, os.W_OK) and not _is_special(path):
            code = errno.EACCES
        else:
            path.exists()
            return
        raise OSError(code, os.strerror(code))


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say which file cannot be written, except for a closed pipe."""
    try:
        yield
    except BrokenPipeError:
        raise
    except (OSError, ValueError, RuntimeError) as error:
        # Those without a number are a zero byte in a name, and links that lead to themselves.
        reason = getattr(error, "strerror", None) or str(error)
        raise GspError(f"{named(path)}: cannot be written: {reason}") from error


def _is_special(path: Path) -> bool:
    """Return whether a path is a device or a pipe, which cannot be replaced by a file."""
    return path.exists() and not path.is_file() and not path.is_dir()


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file so that it is never seen half-written; write to a device or a pipe directly."""
    data = content.encode(errors="backslashreplace") if isinstance(content, str) else content
    with _told(path):
        if _is_special(path):
            with path.open("wb") as device:
                device.write(data)
        else:
            # A link stays one.
            _replace(path.resolve(), data)


def _replace(path: Path, data: bytes) -> None:
    temporary = path.with_name(f".{path.name[:_KEPT]}.{os.urandom(8).hex()}")
    try:
        with temporary.open("xb") as file:
            file.write(data)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
