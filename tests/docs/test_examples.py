"""What pages, notebooks and the tour show is run."""

from __future__ import annotations

import ast
import contextlib
import io
import json
import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gspcli
from docs._ext.shown_commands import pages
from gspcli.cli.main import run
from gspcli.errors import SpecError
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import loads, read_text
from tools.recording import ROOT

# The Python that pages show without output runs: `>>>` examples are run by doctest.


MEASURED = ROOT / "docs" / "calibration" / "measured.csv"
#: The page whose model of a machine stands for the file of the reader.
IMPORTED = (ROOT / "docs" / "import.md").read_text("utf-8")

#: Run by a test of its own, with what it prints.
ELSEWHERE = {"dynamics.md"}
BLOCKS = [
    pytest.param(block, id=f"{page.name}-{number}")
    for page in pages()
    if page.name not in ELSEWHERE
    for number, block in enumerate(
        re.findall(r"^```python\n(.*?)^```$", page.read_text("utf-8"), re.DOTALL | re.MULTILINE), 1
    )
]
#: What stands for the files of the reader.
FILES = {
    "platform.yaml": "figure-3",
    "hexapod.yaml": "rubin-m2",
    "machine.yaml": "workspace-study-cones",
    "mine.yaml": "rubin-m2",
}


@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_runs(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, machine in FILES.items():
        Path(name).write_text(instance_files()[machine].read_text("utf-8"), encoding="utf-8")
    model = re.search(r"^```xml\n(.*?)^```$", IMPORTED, re.DOTALL | re.MULTILINE)
    assert model is not None
    Path("robot.xml").write_text(model[1], encoding="utf-8")
    log = MEASURED.with_name("controller-log.csv")
    Path(log.name).write_text(log.read_text("utf-8"), encoding="utf-8")
    exec(block, _measured() if "calibrate" in block else _found())


def _found() -> dict[str, object]:
    """Return what a page has said before: an instance, its poses and their values."""
    instance = gspcli.load(instance_files()[FILES["platform.yaml"]])
    found = gspcli.solve(instance)
    R, T = found.R[found.real].real, found.T[found.real].real
    return {"instance": instance, "R": R, "T": T, "values": np.abs(gspcli.measure(instance, R, T))}


def _measured() -> dict[str, object]:
    """Return the measurements that the page on calibration has as a file."""
    rows = np.loadtxt(MEASURED, delimiter=",", skiprows=2)
    R = rotation_from_quaternion(rows[:, 10:14])
    return {"values": rows[:, 1:7], "R": R, "T": rows[:, 7:10]}


def test_pages_have_blocks() -> None:
    assert len(BLOCKS) >= 7


# The notebooks run, cell by cell, and show what their words say.


FOLDER = Path(gspcli.__file__).resolve().parents[1] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def run_notebook(path: Path) -> list[Any]:
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
    shown = run_notebook(path)
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
    assert (FOLDER.parents[1] / ".binder" / "requirements.txt").read_text("utf-8") == ".[plot]\n"


# The tutorial of a machine with legs: every command, and the answers on the page.


MOUNT = Path(__file__).resolve().parents[2] / "docs" / "tutorial-machine.md"


def test_the_mount_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From drawing to trajectory: every command, and the answers on the page."""
    monkeypatch.chdir(tmp_path)
    page = MOUNT.read_text(encoding="utf-8")
    table = re.search(r"```text\n(t,x.*?)```", page, re.DOTALL)
    assert table is not None
    Path("path.csv").write_text(table[1], encoding="utf-8")
    said = ""
    for line in re.findall(r"^ {4}\$ gsp (.*)$", page, re.MULTILINE):
        words = shlex.split(line, comments=True)
        assert run(words) == 0, (words, capsys.readouterr().err)
        printed = capsys.readouterr()
        said += printed.out + printed.err
    assert "2 real poses, each proved, all different\ncomplete, proved" in said
    assert "of constraint 4 leaves its range from 0.4789 to 0.5071 at t = 3.854" in said


# The page on calibration: every command runs, and says what the page says that it says.


DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_every_command_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (DOCS / "calibration").glob("*.csv"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    page = (DOCS / "calibrate.md").read_text(encoding="utf-8")
    said, refused = "", 0
    lines = re.findall(r"^ {4}\$ gsp (.*)$", page, re.MULTILINE)
    assert len(lines) >= 8
    for line in lines:
        code = run(shlex.split(line))
        printed = capsys.readouterr()
        said += printed.out + printed.err
        doubted = "measured.csv" in line and not re.search(r"--robust|-o wrong", line)
        expected = 4 if "level.csv" in line else 1 if doubted else 0
        assert code == expected, (line, printed.err)
        refused += code == 4
    assert refused == 1
    assert "the data do not fit: chi-squared is 2146 of 102" in said
    assert "16 of 3000 poses within ranges and cones" in said
    assert re.search(r"lengths to 0\.01\d mm \(median\), offset.\d to 0\.03", said)
    assert "chi-squared 2146 of 102 degrees of freedom" in said
    assert re.search(r"worst row: 8, 11\d\d of chi-squared \(80\.\d* of 96 without it\)", said)
    assert "measure poses that turn the platform" in said
    calibrated = Path("calibrated.yaml").read_text(encoding="utf-8")
    assert calibrated.count(", offset: ") == 6
    assert calibrated.count("# ± ") == 12


# The page on dynamics shows the output of its lines of Python.


PAGE = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")


def _blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files of the page."""
    names = ("hexapod.yaml", "rotary.yaml", "path.csv")
    for name, content in zip(names, _blocks("yaml") + _blocks("csv"), strict=True):
        (tmp_path / name).write_text(content, encoding="utf-8")
    monkeypatch.chdir(tmp_path)


def test_the_python(folder):
    pytest.importorskip("scipy")
    (code,), (shown,) = _blocks("python"), _blocks("text")
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        exec(code, {})
    assert text.getvalue() == shown


# The page *From the paper to a command* leaves nothing out; its commands run with all others.


PAPER_PAGE = Path(__file__).resolve().parents[2] / "docs" / "paper.md"
#: What the paper numbers.
NUMBERED = {
    "Equation": range(1, 19),
    "Figure": range(1, 17),
    "Table": range(1, 4),
    "Proposition": ("2.2", "4.1", "6.1", "6.4", "6.5", "6.7"),
    "Theorem": ("5.1", "5.2", "5.3", "5.4", "6.9"),
    "Example": ("6.2", "6.8"),
    "Definition": ("2.1", "6.3"),
    "Algorithm": ("6.6",),
}


def _named(page: str) -> dict[str, set[str]]:
    """Return what the first column of the tables names, by kind."""
    found: dict[str, set[str]] = {kind: set() for kind in NUMBERED}
    for cell in re.findall(r"^\| ([^|]+) \|.*`gsp ", page, re.MULTILINE):
        for kind in found:
            for match in re.finditer(rf"{kind}s? ((?:\(?[\d.]+\)?(?:, )?)+)", cell, re.IGNORECASE):
                found[kind] |= set(re.findall(r"[\d.]*\d", match[1]))
    return found


def test_everything_that_the_paper_numbers_has_a_command() -> None:
    named = _named(PAPER_PAGE.read_text(encoding="utf-8"))
    for kind, numbers in NUMBERED.items():
        assert {str(number) for number in numbers} <= named[kind], kind


def test_a_row_that_is_missing_is_seen() -> None:
    page = PAPER_PAGE.read_text(encoding="utf-8").replace("| Figure 8,", "| Figure 88,")
    assert "8" not in _named(page)["Figure"]


# What the pages show of instance files: correct ones with real poses, messages of mistakes.


FILE_PAGE = (ROOT / "docs" / "machine-file.md").read_text(encoding="utf-8")
FILE, MESSAGES = (
    re.search(rf"```{kind}\n(.*?)```", FILE_PAGE, re.DOTALL)[1] for kind in ("yaml", "text")
)


def test_the_file_is_correct():
    assert read_text(FILE).warnings == ()


#: Files of `gsp freedoms` may have fewer than six constraints: its page is left out.
PAGES = [
    ROOT / "README.md",
    *sorted(set((ROOT / "docs").glob("*.md")) - {ROOT / "docs" / "constraint-solvers.md"}),
]
EXAMPLES = [
    pytest.param(text, id=f"{page.name}-{number}")
    for page in PAGES
    for number, text in enumerate(
        re.findall(r"```yaml\n(gsp: .*?)```", page.read_text(encoding="utf-8"), re.DOTALL), 1
    )
]


@pytest.mark.parametrize("text", EXAMPLES)
def test_every_instance_in_the_pages_has_real_poses(text):
    reading = read_text(text)
    assert reading.warnings == ()
    result = solve(reading.instance)
    assert result.verdict == "complete"
    assert result.counts.real > 0


def test_the_messages_are_those_of_its_mistakes():
    wrong = FILE.replace("[P1, L5]", "[P1, L7]").replace("value: 60", "value: 200")
    with pytest.raises(SpecError) as caught:
        loads(wrong.replace("value: 70", "vlaue: 70"), name="f.yaml")
    assert f"{caught.value}\n" == MESSAGES
