"""Streams that lack characters, are full, closed or abandoned; what an error says at most."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.cli.result import cell_text
from gspcli.cli.streams import _COUNTERPARTS, manner
from gspcli.wording import MOST_LINES, brief, named, shown

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
@pytest.mark.parametrize(
    "words",
    ["bound 421", "realize 6PP", "constraint DPL", "table errata --format markdown", "--help"],
)
def test_what_an_encoding_lacks_is_written_in_ascii(
    environment: dict[str, str], words: str
) -> None:
    run = shell(f"$GSP {words}", **environment)
    assert (run.returncode, run.stderr) == (0, b"")
    encoding = "cp1252" if environment.get("PYTHONIOENCODING") == "cp1252" else "ascii"
    limited = run.stdout.decode(encoding)
    # No text of the package stays escaped.
    assert "\\x" not in limited
    assert "\\u" not in limited
    whole = shell(f"$GSP {words}", PYTHONIOENCODING="utf-8").stdout.decode()
    assert len(limited.splitlines()) == len(whole.splitlines())


def test_columns_stay_below_each_other_in_ascii() -> None:
    run = shell("$GSP realize 6PP", PYTHONIOENCODING="ascii")
    heading, rule, *rows = run.stdout.decode("ascii").splitlines()[2:10]
    assert "sum f" in heading
    assert set(rule) == {"-"}
    assert {row.index("platform -S") for row in rows[:6]} == {heading.index("chain")}


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("√3/2 ≥ √x …", "sqrt(3)/2 >= sqrtx ..."),
        ("x⁻¹² R^ᵀ", "x^-12 R^^T"),
        ("ρ = T·T", "rho = T*T"),
        ("né\udcc3", "n\\xe9\\udcc3"),
        ("Gröbner", "Groebner"),
    ],
)
def test_counterparts_in_ascii(text: str, written: str) -> None:
    assert text.encode(**manner("ascii")).decode() == written
    assert all(counterpart.isascii() for counterpart in _COUNTERPARTS.values())


def test_documents_for_programs_keep_their_texts_in_ascii(tmp_path: Path) -> None:
    import json

    text = (ROOT / "data/examples/dietmaier.yaml").read_text(encoding="utf-8")
    path = tmp_path / "a.yaml"
    path.write_text("".join(
        'name: "ρ … é"\n' if line.startswith("name:") else line
        for line in text.splitlines(keepends=True)
    ), encoding="utf-8")  # fmt: skip
    for encoding in ("ascii", "utf-8"):
        run = shell(f"$GSP check {path} --format json", PYTHONIOENCODING=encoding)
        assert json.loads(run.stdout.decode(encoding))["files"][0]["name"] == "ρ … é"


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
