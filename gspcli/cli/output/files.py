"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from gspcli.errors import GspError


def check_writable(path: Path) -> None:
    """Complain of a place where no file can be written before the work, not after it.

    Raises
    ------
    GspError
        If the file is a folder, or cannot be made in its folder.
    """
    folder = path.resolve().parent
    if path.is_dir():
        code = errno.EISDIR
    elif not folder.is_dir():
        code = errno.ENOENT
    elif not os.access(folder, os.W_OK) and not _is_special(path):
        code = errno.EACCES
    else:
        return
    message = f"{path}: cannot be written: {os.strerror(code)}"
    raise GspError(message)


def _is_special(path: Path) -> bool:
    """Return whether a path is a device or a pipe, which cannot be replaced by a file."""
    return path.exists() and not path.is_file() and not path.is_dir()


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file so that it is never seen half-written; write to a device or a pipe as it is.

    Raises
    ------
    GspError
        If the file cannot be written.
    """
    data = content.encode() if isinstance(content, str) else content
    if _is_special(path):
        with path.open("wb") as device:
            device.write(data)
        return
    # A link stays one.
    path = path.resolve()
    import tempfile

    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        message = f"{path}: cannot be written: {error.strerror}"
        raise GspError(message) from error
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        Path(temporary).replace(path)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        message = f"{path}: cannot be written: {error.strerror}"
        raise GspError(message) from error
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
