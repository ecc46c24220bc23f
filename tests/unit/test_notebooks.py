"""The notebooks run, cell by cell, and show what their words say."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import pytest

import gspcli

FOLDER = Path(gspcli.__file__).resolve().parents[1] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def run(path: Path) -> list[Any]:
    """Return the values of the last expressions of the cells, as a notebook shows them."""
    document = json.loads(path.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4
    names: dict[str, Any] = {}
    shown = []
    for cell in document["cells"]:
        if cell["cell_type"] != "code":
            continue
        # Committed without outputs: they would not be renewed.
        assert cell["outputs"] == []
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop()
        assert isinstance(last, ast.Expr)
        exec(compile(tree, path.name, "exec"), names)
        shown.append(eval(compile(ast.Expression(last.value), path.name, "eval"), names))
    return shown


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(FOLDER)
    shown = run(path)
    assert len(shown) >= 2
    if path.stem == "all-modes":
        found, frame, conditions = shown
        assert found.counts.real == len(conditions) == 16
        assert len(frame) >= 16
        assert found._repr_html_()
    elif path.stem == "machine-from-log":
        sentences, numbers, solved = shown
        assert "rz left-handed" in sentences[1]
        assert (numbers["sigma"] > 0).all()
        assert solved.counts.real
    else:
        sentences, _ = shown
        assert "the outlier is leg P3 B6" in sentences[2]


def test_the_page_lists_them() -> None:
    page = (FOLDER.parent / "view.md").read_text(encoding="utf-8")
    listed = re.findall(r"\(notebooks/([\w-]+)\.ipynb\)", page)
    assert sorted(listed) == [path.stem for path in NOTEBOOKS]
    assert (FOLDER.parents[1] / "binder" / "requirements.txt").read_text("utf-8") == ".[plot]\n"
