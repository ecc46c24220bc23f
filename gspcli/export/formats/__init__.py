"""The formats of `gsp export`: each file declares one, under the name of the file."""

from __future__ import annotations

import pkgutil
from importlib import import_module

from gspcli.export.format import ControllerFormat, ModeFormat, SystemFormat

#: By the names that the command line gives them.
FORMATS: dict[str, ControllerFormat | ModeFormat | SystemFormat] = {
    found.name: import_module(f"{__name__}.{found.name}").FORMAT
    for found in pkgutil.iter_modules(__path__)
}
