"""Output: tables, streams, terminals, and hostile input."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import click
import pytest
from rich.cells import cell_len

from gspcli.cli.files import check_writable, write_whole
from gspcli.cli.render import Output, _lines, emit, folded, lay_out
from gspcli.cli.result import Field, Result, cell_text, column_texts
from gspcli.cli.streams import printable, progress, working
from gspcli.errors import GspError
from gspcli.wording import MOST_LINES, brief, named, shown
from tests.support.fuzz import commands
from tools.build.samples import choices, described, samples
from tools.build.samples import words as sample_words

# The five formats, files written whole, terminals of any width.


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
    assert rows == [["name", "count", "value"], ["a|b", "3", repr(1 / 3)], ["c_d & e", "", "true"]]


def test_json_of_rows(capsys: pytest.CaptureFixture[str]) -> None:
    emit(Output("json", None), replace(TABLE, schema="things", name="rows"))
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "gsp.things/1"
    assert document["rows"][1] == {"name": "c_d & e", "count": None, "value": True}


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


# Tables laid out for a width: digits, folded headings and prose, columns left out, records.


def _drawn(table: Result, width: int) -> list[str]:
    return list(_lines(table, lay_out(table, width), width, bold=False))


def _numbers(*values: float) -> Result:
    return Result([Field("x", align="right", aligned=True)], [{"x": value} for value in values])


@pytest.mark.parametrize(
    ("values", "digits", "texts"),
    [
        ((12.3456789, -0.5), 6, ["12.3457", "-0.5000"]),
        ((12.3456789, -0.5), 4, ["12.35", "-0.50"]),
        ((0.1234567, -1e-9), 6, ["0.123457", "0.000000"]),
        ((1.5e7, 2.25), 6, ["1.5e+07", "2.25"]),
        ((1.5e-7, -2.25e-8), 6, ["1.5e-07", "-2.25e-08"]),
        ((54321.9876, 1.0), 6, ["54321.99", "1.00"]),
        ((0.0, -0.0), 6, ["0", "0"]),
        ((1.0, math.inf), 6, None),
    ],
)
def test_points_stand_under_each_other(
    values: tuple[float, ...], digits: int, texts: list[str] | None
) -> None:
    table = _numbers(*values)
    found = column_texts(table, table.columns[0], digits)
    assert found == (texts or ["1", "inf"])


def test_so_many_decimals_as_were_asked_for_at_any_width() -> None:
    column = Field("x", decimals=9, align="right", essential=True)
    table = Result([column, column], [{"x": 1 / 3}])
    assert _drawn(table, 200)[-1] == "0.333333333  0.333333333"
    assert _drawn(table, 20) == ["x 0.333333333", "x 0.333333333"]


def test_digits_go_before_records_are_made() -> None:
    columns = [Field(k, align="right", essential=True, aligned=True) for k in "abc"]
    table = Result(columns, [dict.fromkeys("abc", -math.pi)])
    assert _drawn(table, 28)[-1] == "-3.14159  -3.14159  -3.14159"
    assert _drawn(table, 27)[-1] == "-3.1416  -3.1416  -3.1416"
    assert _drawn(table, 20)[-1] == "-3.14  -3.14  -3.14"
    assert _drawn(table, 18) == ["a -3.14159", "b -3.14159", "c -3.14159"]


def test_what_matters_least_goes_first() -> None:
    columns = [Field("aaaa", essential=True), *(Field(k * 4, minor=ord(k)) for k in "cbd")]
    table = Result(columns, [{}])
    kept = {}
    for width in (24, 17, 11, 5, 4):
        grid = lay_out(table, width)
        assert grid is not None
        kept[width] = "".join(column.key[0] for column in grid.columns)
    assert kept == {24: "acbd", 17: "acb", 11: "ab", 5: "a", 4: "a"}
    assert lay_out(table, 3) is None


def test_columns_of_one_meaning_go_together() -> None:
    point = [Field(k * 4, meaning="a coordinate") for k in "xyz"]
    table = Result([Field("aaaa", essential=True), *point, Field("bbbb", minor=-1)], [{}])
    grid = lay_out(table, 24)
    assert grid is not None
    assert [column.key for column in grid.columns] == ["aaaa", "bbbb"]


def test_headings_and_prose_are_folded_at_blanks() -> None:
    table = Result(
        [Field("n", "how many", align="right"), Field("why", fold=" "), Field("l", fold=", ")],
        [
            {
                "n": 12,
                "why": "one two three four five six seven eight nine ten",
                "l": "a b, c d, e f",
            }
        ],
    )
    assert _drawn(table, 46) == [
        " how  why                        l",
        "many",
        "─" * 46,
        "  12  one two three four five    a b, c d, e f",
        "      six seven eight nine ten",
    ]
    lists = Result([Field("l", fold=", ")], [{"l": "a b, c d, e f"}])
    assert _drawn(lists, 10)[2:] == ["a b, c d,", "e f"]


def test_a_word_is_never_broken() -> None:
    assert folded("  a 1234567890 b", 6) == ["  a", "  1234567890", "  b"]
    assert folded("a, b c, d", 5, ", ") == ["a,", "b c,", "d"]
    assert folded("", 5) == [""]


def test_records_say_every_cell_that_is_not_empty() -> None:
    columns = [
        Field("x", align="right", essential=True),
        Field("empty"),
        Field("text", essential=True),
        Field("y", align="right"),
    ]
    rows = [{"x": 1.5, "text": "t" * 30, "y": 2}, {"x": -10.25, "text": "u", "y": 3}]
    assert _drawn(Result(columns, rows), 30) == [
        "x    1.5",
        "text:",
        "t" * 30,
        "y 2",
        "",
        "x -10.25",
        "text: u",
        "y 3",
    ]


def test_cells_for_people() -> None:
    assert [cell_text(v) for v in (None, True, 1 / 3, [1, 2.5], "a\nb")] == [
        "", "yes", "0.333333", "1 2.5", "a b",
    ]  # fmt: skip
    assert printable("a\x1b[2Jb\u202ec\nd") == "a\\x1b[2Jb\\u202ec\nd"


# Streams that lack characters, are full, closed or abandoned; what an error says at most.


Run = Callable[..., object]
LIMITED = [
    {"PYTHONIOENCODING": "ascii"},
    {"PYTHONIOENCODING": "cp1252"},
    {"PYTHONUTF8": "0", "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"},
]
ROOT = Path(__file__).parents[2]


def shell(script: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of the shell, in which $GSP is the command."""
    settings = os.environ | {"GSP": f"{sys.executable} -m gspcli"} | environment
    return subprocess.run(
        ["/bin/sh", "-c", script], capture_output=True, env=settings, check=False, cwd=ROOT
    )


@pytest.mark.parametrize("environment", LIMITED)
def test_output_is_utf_8_whatever_the_system_says(environment: dict[str, str]) -> None:
    whole = shell("$GSP realize 6PP")
    assert "Σf" in whole.stdout.decode()
    assert shell("$GSP realize 6PP", **environment).stdout == whole.stdout


FULL = "error: standard output: cannot be written: No space left on device\n"
CLOSED = "error: standard output: cannot be written: it is closed\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("$GSP bound 1 >/dev/full", FULL),
        ("$GSP bound 1 --format json >/dev/full", FULL),
        ("$GSP --help >/dev/full", FULL),
        # The error of the platform is not printed, since the answer was lost.
        ("$GSP solve @griffis-duffy >/dev/full", FULL),
        ("$GSP bound 1 -o /dev/full --format csv", FULL.replace("standard output", "/dev/full")),
        ("$GSP frobnicate 2>/dev/full", ""),
        ("$GSP bound 1 >&-", CLOSED),
        ("$GSP --help >&-", CLOSED),
        ("$GSP bound 1 >&- 2>&-", ""),
        ("$GSP solve @dietmaier >&- 2>&-", ""),
        ("$GSP frobnicate 2>&-", ""),
        ("$GSP check - <&-", "error: standard input: cannot be read: Bad file descriptor\n"),
        ("$GSP check - <&- >&- 2>&-", ""),
    ],
)
def test_a_full_disk_and_a_closed_stream_are_told_in_one_line(script: str, said: str) -> None:
    run = shell(script)
    assert run.stderr.decode() == said
    assert run.returncode == 2


def test_a_reader_that_stops_early_is_no_failure() -> None:
    # More than a pipe holds, written at once.
    run = shell("{ $GSP view @octahedral-3-3; echo $? >&2; } | head -c 1")
    assert run.stdout == b"<"
    said, code = run.stderr.splitlines()
    assert said.startswith(b"home is mode 3: ")
    assert code == b"0"


def test_what_cannot_be_said_is_no_failure() -> None:
    run = shell("$GSP bound 1 --format csv 2>&-")
    assert (run.returncode, run.stderr) == (0, b"")
    assert run.stdout.startswith(b"number,id")


def test_no_file_takes_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    assert shell(f"$GSP bound 1 -o {path} <&- >&- 2>&-").returncode == 0
    assert path.read_text().startswith("number,id")


@pytest.mark.parametrize(
    "words",
    [
        ["solve", "a" * 300],
        ["solve", "@" + "a" * 300],
        ["bound", "1", "-o", "a" * 300 + ".csv"],
        ["new", "6PP", "-o", "a" * 300 + ".yaml"],
        ["measure", "@dietmaier", "a" * 300 + ".csv"],
        ["enumerate", "--only", "a" * 100_000],
        ["bound", "a" * 100_000],
        ["bound", "P-P " * 100_000],
        ["a" * 100_000],
        ["solve", "--" + "a" * 100_000],
        ["solve", "@dietmaier", "--seed", "a" * 100_000],
        ["solve", "@dietmaier", "--set", "a" * 100_000],
        ["solve", "@dietmaier", "--rotation", "a" * 100_000],
        ["count", "--type", "6PP", "--geometry", "a" * 100_000],
        ["derive", "a" * 100_000],
        ["view", "@dietmaier", "--from", "a" * 100_000],
        ["scan", "@dietmaier", "--vary", "a" * 100_000],
    ],
    ids=lambda words: " ".join(word[:12] for word in words),
)
def test_what_was_written_is_repeated_in_part(gsp: Run, words: list[str]) -> None:
    outcome = gsp(*words)
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) <= MOST_LINES
    assert "a" * 61 not in outcome.err
    assert max(map(len, outcome.err.splitlines())) < 700


def test_the_first_of_many_mistakes_are_told(gsp: Run, tmp_path: Path) -> None:
    text = (ROOT / "data/examples/dietmaier.yaml").read_text(encoding="utf-8")
    path = tmp_path / "bad.yaml"
    path.write_text("".join(f"key{k}: 1\n" for k in range(65)) + text, encoding="utf-8")
    outcome = gsp("solve", path)
    assert outcome.code == 2
    first, *_, last = lines = outcome.err.splitlines()
    assert first.startswith(f"error: {path}:1:1: key0: found the unknown key 'key0'")
    assert (len(lines), last) == (MOST_LINES, "… and 61 more mistakes")
    # The command that is for it says all.
    assert gsp("check", path).out.count("\nmistake: ") == 65


def test_brief() -> None:
    assert brief("a\nb\nc\nd\ne") == "a\nb\nc\nd\ne"
    assert brief("a\nb\nc\nd\ne\nf", "row") == "a\nb\nc\nd\n… and 2 more rows"
    assert len(brief("x" * 10_000)) <= 602
    assert shown("x" * 61) == "'" + "x" * 59 + "…'"
    assert named("a/" + "b" * 255) == "a/" + "b" * 255
    assert len(named("a/" + "b" * 256)) == 60


def test_a_text_that_is_no_unicode_is_written(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "n\udcc3.yaml"
    try:
        path.write_bytes((ROOT / "data/examples/dietmaier.yaml").read_bytes())
    except OSError:
        pytest.skip("this system has no such names")
    run = shell(f"$GSP check {tmp_path}/n*.yaml --format csv")
    assert (run.returncode, run.stderr) == (0, b"")
    assert b"n\\udcc3.yaml" in run.stdout
    outcome = gsp("check", path, "--format", "csv", "-o", tmp_path / "a.csv")
    assert outcome.code == 0
    assert cell_text(1) == "1"


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no device that never ends")
@pytest.mark.parametrize(
    "words",
    [
        ("check", "/dev/zero"),
        ("track", "@octahedral-3-3", "/dev/zero"),
        ("maximize-real", "6PP", "--resume", "/dev/zero"),
    ],
)
def test_files_that_never_end_are_refused(gsp, words, monkeypatch) -> None:
    monkeypatch.setattr("gspcli.spec.document.LARGEST_TABLE", 1 << 20)
    run = gsp(*words)
    assert run.code == 2
    assert run.err.rstrip().endswith(" MB")
    assert "/dev/zero: cannot be read: it has more than " in run.err


UNBUFFERED = {"PYTHONUNBUFFERED": "1"}


@pytest.mark.parametrize("words", ["enumerate", "enumerate --format json", "view @dietmaier"])
@pytest.mark.parametrize("environment", [{}, UNBUFFERED])
def test_an_output_that_is_cut_is_an_error(
    words: str, environment: dict[str, str], tmp_path: Path
) -> None:
    # A file of at most 8 blocks stands for a disk with a little room.
    run = shell(f"ulimit -f 8; $GSP {words} > {tmp_path / 'cut'}", **environment)
    assert run.returncode == 2
    assert run.stderr.decode().endswith(FULL.replace("No space left on device", "File too large"))


@pytest.mark.parametrize("environment", [{}, UNBUFFERED])
def test_a_pipe_that_does_not_wait_is_waited_for(environment: dict[str, str]) -> None:
    command = [sys.executable, "-m", "gspcli", "enumerate", "--format", "csv"]
    whole = shell("$GSP enumerate --format csv").stdout
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with subprocess.Popen(command, stdout=writer, env=os.environ | environment) as process:
        os.close(writer)
        # The pipe is full before anything is read.
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=1)
        with os.fdopen(reader, "rb") as file:
            assert file.read() == whole
    assert len(whole) > 1 << 16
    assert process.returncode == 0


# Every command at every width in a pseudo-terminal: no number is cut, no line too wide.


WIDTHS = [40, 48, 60, 72, 80, 96, 100, 120, 140, 160, 180, 200]
#: Treated as no terminal: everything in its full width.
_UNLIMITED = 50_000
Shown = Callable[..., tuple[list[str], int]]
EXAMPLES = "data/examples"
#: What is tested besides a sample of each command that prints tables and is not here.
CALLS = [
    ["enumerate", "--first", "4"],
    ["enumerate", "--by-class"],
    ["enumerate", "--coincident", "--only", "PP"],
    ["enumerate", "--coincident", "6PP", "--first", "4"],
    ["show", "421"],
    ["bound", "421"],
    ["bound", "3D3A PL PL LP"],
    ["constraint"],
    ["constraint", "DLL"],
    ["realize", "DPL DPL DLP ALL ALH AHH"],
    ["table", "1"],
    ["table", "2"],
    ["table", "3"],
    ["table", "errata"],
    ["derive"],
    ["atlas", "summary"],
    ["check", f"{EXAMPLES}/dietmaier.yaml", f"{EXAMPLES}/example-6.8.yaml"],
    ["solve", f"{EXAMPLES}/example-6.8.yaml"],
    ["solve", f"{EXAMPLES}/dietmaier.yaml", "--all"],
    ["solve", f"{EXAMPLES}/dietmaier.yaml", "--digits", "20"],
    ["solve", "@dietmaier", "--rotation", "matrix"],
    [
        "solve",
        "@dietmaier",
        "--rotation",
        "ZYX",
        "--near",
        "0,0,0,0,0,0",
        "--euler",
        "ZYX",
        "--decimals",
        "9",
    ],
    ["solve", "@no-real-pose"],
    ["solve", "@parallel-edges"],
    ["example"],
    ["count", "@planar-hexagons", "@example-6.8"],
    ["count", "--type", "6PP", "--geometry", "generic,3-3"],
    ["analyze", "@rubin-m2"],
    ["analyze", "@octahedral-3-3", "--mode", "1", "--load", "0,0,-9.81", "--tolerance", "0.001"],
    ["dynamics", "MASSES", "--mode", "15"],
    ["dynamics", "MASSES", "--mode", "1", "--modes"],
    ["clearance", "@octahedral-3-3", "--mode", "1"],
    ["clearance", "@octahedral-3-3", "--mode", "1", "--of", "pose"],
    ["sensors", "@rubin-m2"],
    ["sensors", "@simscape-hexapod"],
    ["solve", "@rubin-m2", "--reading", "leg P1 B2 = 2.913 ± 0.002"],
    ["workspace", "@workspace-study", "--shift", "z=0:10:2"],
    ["workspace", "@workspace-study", "--over", "x,z"],
    ["workspace", "@workspace-study", "--over", "x,z", "--boxes", "--gap", "0.9"],
    ["scan", "@octahedral-3-3", "--vary", "1=1.4:1.6:5"],
    ["measure", "@dietmaier", "--pose", "0.1,0.2,1.5,1,0.1,0,0"],
    ["sample", "3D3A PH PH PH", "--count", "20", "--jobs", "1"],
]
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]\d+)?(?![\w.])")
_FEWEST_DIGITS = 3


def _others() -> Iterator[list[str]]:
    """Yield a call of each command that is not in `CALLS`; its files have names in capitals."""
    known = {call[0] for call in CALLS}
    for name, command in described().items():
        if "table" in choices(command, "format") and name.split()[0] not in known:
            yield [name, *shlex.split(samples(name, command)[0])]


@pytest.mark.parametrize("call", [*CALLS, *_others()], ids=" ".join)
def test_no_number_is_cut_at_any_width(shown: Shown, call: list[str], tmp_path: Path) -> None:
    run = sample_words(call[0], shlex.join(call[1:]), tmp_path)
    (*pages, whole, _), code = shown(*run, widths=[*WIDTHS, _UNLIMITED])
    assert code in (0, 1, 4)
    # Home is said once, with the first page.
    full = set(_NUMBER.findall(whole + pages[0].partition("home is mode")[2][:4]))
    rounded = sorted(map(float, full))
    for width, page in zip(WIDTHS, pages, strict=True):
        assert page.count("…") <= whole.count("…")
        for number in set(_NUMBER.findall(page)) - full:
            assert _is_rounded(number, rounded), f"{number} at {width} columns"
        for line in page.splitlines():
            assert cell_len(line) <= width or " " not in line.strip(), f"{width}: {line}"


def _is_rounded(text: str, known: list[float]) -> bool:
    """Return whether a number is one of those known, to fewer digits."""
    mantissa, _, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    half = 0.5001 * 10.0 ** (int(exponent or 0) - decimals)
    significant = len(mantissa.replace(".", "").lstrip("-0"))
    near = any(abs(float(text) - value) <= half for value in known)
    return near and (significant >= _FEWEST_DIGITS or decimals > 0 or not known)


@pytest.mark.parametrize("width", [60, 80, 120])
def test_help_fits(shown: Shown, width: int) -> None:
    (page,), code = shown("--help", widths=[width])
    assert code == 0
    assert max(map(cell_len, page.splitlines())) <= width


def test_wider_terminals_show_no_less(shown: Shown) -> None:
    (*pages, _), _ = shown("enumerate", "--first", "2", widths=WIDTHS[2:])
    left_out = [page.partition("(left out")[2].count(",") for page in pages]
    assert all(a >= b for a, b in pairwise(left_out))
    assert left_out[0] > left_out[-1]


def test_the_bounds_of_the_paper_stay_longest(shown: Shown) -> None:
    (*pages, _), _ = shown("enumerate", "--first", "2", widths=[60, 80])
    for page in pages:
        heading = " ".join(page.splitlines()[:3])
        assert heading.count("Thm") == 3
        assert "Table" in heading
        assert "refined" in page.split("(left out")[1]


def test_colour_of_errors(shown: Shown) -> None:
    (coloured,), _ = shown("show", "9999", widths=[80], styled=True)
    assert "\x1b[31m" in coloured
    for setting in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        for call in (["show", "9999"], ["bound", "1"]):
            pages, _ = shown(*call, widths=[80], environment=setting, styled=True)
            assert "\x1b" not in "".join(pages)


def test_what_a_terminal_would_obey_is_written_out(shown: Shown) -> None:
    pages, code = shown("check", "\x1b[2Jbad\x07.yaml", widths=[80], styled=True)
    assert code == 2
    assert "\x1b[2J" not in "".join(pages)
    assert "\\x1b[2Jbad\\x07.yaml" in pages[0]


def test_remarks_stay_where_fewer_digits_make_room():
    from gspcli.cli.render import lay_out
    from gspcli.cli.result import Field, Result

    numbers = [Field(key, align="right", essential=True) for key in "abc"]
    row = {"a": 0.123456, "b": 0.123456, "c": 0.123456, "d": 1.5, "e": "home"}
    columns = [*numbers, Field("d", minor=2), Field("e", minor=-1)]
    table = Result(columns, [row])

    def shown(width):
        return [column.key for column in lay_out(table, width).columns]

    assert [shown(width) for width in (40, 34, 30, 26)] == [
        list("abcde"), list("abce"), list("abce"), list("abc"),
    ]  # fmt: skip


# A sample of the attacks on the command line, and that they see what they look for.


@pytest.fixture(scope="module")
def attacks():
    commands.prepare()
    return commands


@pytest.mark.parametrize("kind", ["options", "inputs", "streams"])
def test_nothing_is_undocumented(attacks, kind):
    for seed in range(12):
        code, problems = attacks.attack(kind, seed)
        assert code in attacks.DOCUMENTED
        assert problems == []


def test_a_process(attacks):
    assert attacks.attack("processes", 3)[1] == []


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ((0, ""), ""),
        ((2, "error: no\n"), ""),
        ((130, ""), ""),
        ((70, "error: internal error: ValueError\n"), "exit code 70"),
        ((2, ""), "exit code 2 without an error"),
        ((2, "error: a\n" + "b\n" * 5), "an error of 6 lines"),
        ((2, "error: " + "b" * 1000 + "\n"), "a line of 1007 characters"),
        ((0, "x.py:3: RuntimeWarning: overflow\n"), "'Warning:' is said"),
        ((1, "Traceback (most recent call last):\n"), "'Traceback' is said"),
        ((-11, ""), "exit code -11"),
    ],
)
def test_what_does_not_hold_is_seen(attacks, tmp_path, told, found):
    hostile = attacks.Hostile(["solve", "x"])
    problems = attacks.wrong(hostile, attacks.Told(*told), tmp_path)
    assert problems[:1] == ([f"{found}: gsp 'solve' 'x'"] if found else [])
    (tmp_path / ".a.csv.x1").touch()
    assert ".a.csv.x1 is left: gsp 'solve' 'x'" in attacks.wrong(
        hostile, attacks.Told(*told), tmp_path
    )
