"""The five formats, files written whole, terminals of any width."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest

from gspcli.cli.render import Output, emit
from gspcli.cli.result import Field, Result
from gspcli.cli.streams import check_writable, progress, working, write_whole
from gspcli.errors import GspError

TABLE = Result(
    columns=[
        Field("name", essential=True),
        Field("count", "how many", align="right"),
        Field("value", align="right"),
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
    emit(Output("json", None), TABLE, schema="things")
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "gsp.things/1"
    assert document["rows"][1] == {
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
    assert "% A title\n% a note\n\\begin{tabular}{lrr}\n\\toprule\n" in shown


def test_latex_numbers_and_roots(capsys: pytest.CaptureFixture[str]) -> None:
    rows = [{"x": -1e-5, "y": "[√3/2"}, {"x": -2, "y": "x_1 < √5"}]
    emit(Output("latex", None), Result([Field("y"), Field("x", align="right")], rows))
    shown = capsys.readouterr().out
    assert "{}[$\\sqrt{3}$/2 & $-1 \\times 10^{-5}$ \\\\\n" in shown
    assert "x\\_1 \\textless{} $\\sqrt{5}$ & $-2$ \\\\\n" in shown


SEVERAL = [
    Result([Field("a")], [{"a": 1}], part="first", summary=["one row"]),
    Result([Field("b")], [{"b": 2}], part="second"),
]


def test_csv_of_numbers_alone_is_that_of_the_writer(capsys: pytest.CaptureFixture[str]) -> None:
    numbers = [[1, 0.1, 1e-300], [-2, math.nan, math.inf], [3, -0.0, 123456789012345680.0]]
    columns = [Field(key) for key in ("a", 'b,"c"', "d")]
    keys = [column.key for column in columns]
    rows = [dict(zip(keys, row, strict=True)) for row in numbers]
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows([keys, *numbers])
    emit(Output("csv", None), Result(columns, rows))
    assert capsys.readouterr().out == buffer.getvalue()
    emit(Output("csv", None), Result(columns, [*rows, dict.fromkeys(keys)]))
    assert capsys.readouterr().out == buffer.getvalue() + ",,\n"


def test_one_table_a_csv(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with pytest.raises(click.UsageError, match="choose --part of first, second"):
        emit(Output("csv", None), SEVERAL)
    emit(Output("csv", None, "second"), SEVERAL)
    assert capsys.readouterr().out == "b\n2\n"
    emit(Output("csv", tmp_path / "all.csv"), SEVERAL)
    assert (tmp_path / "all-first.csv").read_text() == "a\n1\n"
    assert (tmp_path / "all-second.csv").read_text() == "b\n2\n"
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines()[1] == "one row"


def test_one_part_in_other_formats(capsys: pytest.CaptureFixture[str]) -> None:
    emit(Output("markdown", None, "first"), SEVERAL)
    assert capsys.readouterr().out == "one row\n\n| a |\n|---|\n| 1 |\n"
    emit(Output("json", None), SEVERAL, schema="pair")
    assert json.loads(capsys.readouterr().out) == {
        "schema": "gsp.pair/1",
        "first": [{"a": 1}],
        "second": [{"b": 2}],
    }


def test_a_piped_table_is_never_cut(capsys: pytest.CaptureFixture[str]) -> None:
    wide = Result(columns=[Field("x")], rows=[{"x": "y" * 5000}])
    emit(Output("table", None), wide)
    assert "y" * 5000 in capsys.readouterr().out


def test_a_narrow_terminal_loses_whole_columns_and_is_told(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "20")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    emit(Output("table", None), TABLE)
    captured = capsys.readouterr()
    assert "how" in captured.out
    assert "value" not in captured.out
    assert captured.err == "(left out to fit the\nterminal: value)\n"


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


def test_a_place_that_cannot_be_written_is_known_before_the_work(tmp_path: Path) -> None:
    check_writable(tmp_path / "new.csv")
    check_writable(Path(os.devnull))
    for path in (tmp_path, tmp_path / "missing" / "out.csv"):
        with pytest.raises(GspError, match="cannot be written"):
            check_writable(path)


def test_pipes_and_links_stay_what_they_are(tmp_path: Path) -> None:
    pipe, link, target = (tmp_path / name for name in ("pipe", "link.csv", "target.csv"))
    os.mkfifo(pipe)
    link.symlink_to(target)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, "text")
    write_whole(link, "text")
    assert os.read(reader, 10) == b"text"
    os.close(reader)
    assert link.is_symlink()
    assert target.read_text() == "text"


def test_a_reader_that_stops_is_no_failure() -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "gspcli", "enumerate"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as run:
        assert run.stdout is not None
        assert run.stderr is not None
        run.stdout.readline()
        run.stdout.close()
        assert run.stderr.read() == b""
    assert run.returncode == 0


def _until_shown(label: str, capsys: pytest.CaptureFixture[str]) -> bool:
    """Work until the label is on standard error: how long that takes depends on the machine."""
    for _ in range(6000):
        if label in capsys.readouterr().err:
            return True
        time.sleep(0.01)
    return False


def test_progress_shows_while_the_first_item_takes_long(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setattr("gspcli.cli.streams._PATIENCE_SECONDS", 0.01)
    monkeypatch.setattr("rich.console.Console.is_terminal", True)
    items = (_until_shown("counting", capsys) for _ in range(1))
    assert list(progress(items, total=1, label="counting")) == [True]
    capsys.readouterr()
    monkeypatch.setattr("gspcli.cli.streams._PATIENCE_SECONDS", 100)
    assert list(progress([1, 2], label="counting")) == [1, 2]
    assert "counting" not in capsys.readouterr().err


def test_work_of_unknown_length_shows_that_it_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setattr("gspcli.cli.streams._PATIENCE_SECONDS", 0.01)
    monkeypatch.setattr("rich.console.Console.is_terminal", True)
    with working("solving"):
        assert _until_shown("solving", capsys)
    capsys.readouterr()
    monkeypatch.setattr("gspcli.cli.streams._PATIENCE_SECONDS", 100)
    with working("solving"):
        pass
    assert "solving" not in capsys.readouterr().err


def test_a_part_that_the_answer_does_not_have_is_an_error(gsp, tmp_path):
    """Nothing was printed, no file written, and the exit code was 0."""
    path = tmp_path / "a.csv"
    for words, has in (
        (["analyze", "@rubin-m2", "--part", "stiffness"], "wrenches, jacobian"),
        (["table", "1", "--part", "table-2"], "table-1"),
        (["table", "1", "--part", "table-2", "-o", path], "table-1"),
    ):
        run = gsp(*words)
        assert (run.code, run.out) == (2, "")
        assert f"--part {words[3]}: there is no such table in this answer, which has {has}" in (
            run.err
        )
    assert not path.exists()
    assert gsp("analyze", "@rubin-m2", "--part", "stiffness", "--stiffness", "1").code == 0


def test_the_file_that_is_read_is_not_replaced(gsp, tmp_path):
    spec, rows = tmp_path / "a.yaml", tmp_path / "rows.csv"
    spec.write_text(gsp("example", "octahedral-3-3").out)
    rows.write_text("x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,0\n")
    link = tmp_path / "link.csv"
    link.symlink_to(rows)
    for words in (
        ["solve", spec, "--format", "json", "-o", spec],
        ["measure", spec, rows, "-o", rows],
        ["measure", spec, rows, "-o", link],
        ["export", spec, "--to", "msolve", "-o", spec],
    ):
        before = spec.read_text(), rows.read_text()
        run = gsp(*words)
        assert run.code == 2
        assert "it is the file that is read: choose another" in run.err
        assert before == (spec.read_text(), rows.read_text())
    assert gsp("measure", spec, rows, "-o", tmp_path / "other.csv").code == 0
