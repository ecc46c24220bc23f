"""The five formats, files written whole, terminals of any width."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest

from gspcli.cli.output import Column, Output, Table, emit, write_whole
from gspcli.errors import GspError

TABLE = Table(
    columns=[
        Column("name", essential=True),
        Column("count", "how many", align="right"),
        Column("value", align="right"),
    ],
    rows=[
        {"name": "a|b", "count": 3, "value": 1 / 3},
        {"name": "c_d & e", "count": None, "value": True},
    ],
    title="A title",
    notes=["a note"],
)


def _shown(capsys: pytest.CaptureFixture[str], fmt: str) -> str:
    emit(Output(fmt, None), TABLE)
    return capsys.readouterr().out


def test_csv_has_full_precision_and_empty_cells(capsys: pytest.CaptureFixture[str]) -> None:
    rows = list(csv.reader(io.StringIO(_shown(capsys, "csv"))))
    assert rows == [
        ["name", "count", "value"],
        ["a|b", "3", repr(1 / 3)],
        ["c_d & e", "", "true"],
    ]


def test_json_of_rows(capsys: pytest.CaptureFixture[str]) -> None:
    assert json.loads(_shown(capsys, "json"))[1] == {
        "name": "c_d & e",
        "count": None,
        "value": True,
    }


def test_json_of_a_document(capsys: pytest.CaptureFixture[str]) -> None:
    emit(Output("json", None), TABLE, document={"schema": "x/1"})
    assert json.loads(capsys.readouterr().out) == {"schema": "x/1"}


def test_markdown(capsys: pytest.CaptureFixture[str]) -> None:
    assert _shown(capsys, "markdown").splitlines() == [
        "### A title",
        "",
        "| name | how many | value |",
        "|---|---:|---:|",
        "| a\\|b | 3 | 0.333333 |",
        "| c_d & e |  | yes |",
        "",
        "a note",
    ]


def test_latex_escapes(capsys: pytest.CaptureFixture[str]) -> None:
    shown = _shown(capsys, "latex")
    assert r"c\_d \& e &  & yes \\" in shown
    assert shown.startswith("% A title\n\\begin{tabular}{lrr}\n\\toprule\n")


def test_a_piped_table_is_never_cut(capsys: pytest.CaptureFixture[str]) -> None:
    wide = Table(columns=[Column("x")], rows=[{"x": "y" * 5000}])
    emit(Output("table", None), wide)
    assert "y" * 5000 in capsys.readouterr().out


def test_a_narrow_terminal_loses_whole_columns_and_is_told(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "20")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    emit(Output("table", None), TABLE)
    captured = capsys.readouterr()
    assert "how many" in captured.out
    assert "value" not in captured.out
    assert captured.err == "(left out to fit the terminal: value)\n"


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "out.csv"
    emit(Output("csv", target), TABLE)
    assert target.read_text().startswith("name,count,value\n")
    with pytest.raises(GspError, match="cannot be written"):
        write_whole(tmp_path / "missing" / "out.csv", "text")
    with pytest.raises(TypeError):
        write_whole(target, 3)  # type: ignore[arg-type]
    assert target.read_text().startswith("name,count,value\n")
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]
