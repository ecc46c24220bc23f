"""A file that is written and imported."""

from __future__ import annotations

from pathlib import Path

import pytest
from one_hexapod import Write

from gspcli.machines.api import ImportedMachine, import_machine


@pytest.fixture
def read(tmp_path: Path) -> Write:
    def imported(name: str, text: str, **others: str) -> ImportedMachine:
        for other, content in others.items():
            (tmp_path / other.replace("__", ".")).write_text(content, encoding="utf-8")
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return import_machine(path)

    return imported
