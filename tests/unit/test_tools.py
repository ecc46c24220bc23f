"""The programs of tools/: rooms that import downwards, and nothing that the package needs."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"
LEVELS = {
    "recording": 0,
    "browser": 0,
    "charts": 0,
    "oracle": 1,
    "equations": 1,
    "special": 2,
    "build": 2,
    "witnesses": 2,
    "verify": 3,
    "fuzz": 3,
}
SOURCES = sorted(TOOLS.rglob("*.py"))


def _imported(path: Path) -> set[str]:
    """Return what a file imports of tools: the room, or the file at the top."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    names = {f"{node.module}.{alias.name}" for node in froms for alias in node.names}
    return {name.split(".")[1] for name in names if name.startswith("tools.")}


@pytest.mark.parametrize("room", LEVELS)
def test_imports_point_one_way(room: str) -> None:
    paths = [p for p in SOURCES if p.relative_to(TOOLS).parts[0].removesuffix(".py") == room]
    assert paths
    for path in paths:
        for name in _imported(path) - {room}:
            assert LEVELS[name] < LEVELS[room], f"{path}: {name}"


def test_the_rooms_are_named_where_one_looks_first() -> None:
    text = (TOOLS / "__init__.py").read_text(encoding="utf-8")
    parts = [path.relative_to(TOOLS).parts for path in SOURCES]
    rooms = {part[0] for part in parts if len(part) > 1}
    assert rooms == LEVELS.keys() - {"recording", "browser", "charts"}
    assert all(f"- `{room}`: " in text for room in rooms)


def test_the_package_imports_none() -> None:
    for path in (ROOT / "gspcli").rglob("*.py"):
        assert not _imported(path), path
