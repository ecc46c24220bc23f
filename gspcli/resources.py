"""Where the files of `data/` are: inside an installed package, or beside it in a checkout."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from gspcli.errors import DataError, GspError
from gspcli.wording import shown, similar

_PACKAGE = Path(__file__).resolve().parent


@cache
def data_directory() -> Path:
    """Return the directory that holds the shipped data.

    Raises
    ------
    DataError
        If neither the installed nor the checked-out location exists.
    """
    for candidate in (_PACKAGE / "data", _PACKAGE.parent / "data"):
        if candidate.is_dir():
            return candidate
    message = f"the data directory of the package is missing (looked beside {_PACKAGE})"
    raise DataError(message)


def data_path(*parts: str) -> Path:
    """Return the path of one shipped file.

    Raises
    ------
    DataError
        If there is no such file.
    """
    path = data_directory().joinpath(*parts)
    if not path.is_file():
        message = f"data file {'/'.join(parts)} is missing from {data_directory()}"
        raise DataError(message)
    return path


#: Folders of `data/` with instance files that are shipped; no name is in both.
INSTANCE_FOLDERS = ("examples", "platforms")


@cache
def instance_files() -> dict[str, Path]:
    """Return the shipped instance files by name: examples, then platforms (do not modify)."""
    folders = (data_directory() / folder for folder in INSTANCE_FOLDERS)
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.yaml"))}


def shipped_file(name: str) -> Path:
    """Return the shipped instance file of a name.

    Raises
    ------
    GspError
        If there is none.
    """
    files = instance_files()
    if name not in files:
        near = similar(name.lower(), files, 1)
        hint = f"did you mean {near[0]}? " if near else ""
        message = f"found no example or platform {shown(name)}: {hint}`gsp example` lists them"
        raise GspError(message)
    return files[name]


@cache
def data_json(*parts: str) -> Any:
    """Return the parsed content of one shipped JSON file (shared; do not modify)."""
    return json.loads(data_path(*parts).read_text(encoding="utf-8"))
