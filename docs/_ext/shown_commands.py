"""What the pages and helps show of `gsp`: every command line, and how to run it.

In a page a command stands in a block of ``console`` or in an indented block, after ``$ `` or, if it
is one of `gsp`, bare; in a help under *Examples*. What follows it in a block of ``console`` is its
output. In a row of a table a command is the last cell but one, and the last is part of its output.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from gspcli.cli.main import run
from tools.build.samples import commands
from tools.recording import ROOT

#: Made when the site is built.
_GENERATED = {
    "commands.md",
    "options.md",
    "output.md",
    "errata.md",
    "geometry-counts.md",
    "platforms.md",
}
#: Programs that are run where they are installed. Lines that begin with another one are not ours.
OTHERS = ("printf", "msolve", "phc", "Singular", "M2")
_OURS = re.compile(rf"(?:gsp|{'|'.join(OTHERS)}) ")
_CONSOLE = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_ROW = re.compile(r"^\|.*\| `(gsp [^`]+)` \|(?: `([^`]+)`)? \|$", re.MULTILINE)
_INDENTED = re.compile(r"^ {4}(?:\$ |(?=gsp ))(.+)$", re.MULTILINE)
_THEN = ("&&", "|")
#: What takes hours, a cluster, or a limit of time that it uses up: it is only read.
ENDLESS = re.compile(
    r"--time|--count 100000|=5:7:500"
    r"|gsp maximize-real (?!.*--show)"
)
#: What takes seconds.
LONG = re.compile(
    r"table (all|errata) --check|--all-modes|gsp workspace platform|--of pose|--folds|gsp sample"
    r"|gsp calibrate|gsp clearance platform.yaml( --mode| path| *$|  )|--random 200|cranks"
    r"|sensors platform|3DLL 3ALL|=-9:9:60|atlas summary --format"
)


@dataclass(frozen=True)
class Shown:
    """A command line that is shown.

    Attributes
    ----------
    place
        The name of the page, such as ``docs/tutorial-machine.md``, or ``gsp solve --help``.
    line
        The command line, without the prompt.
    output
        What it is shown to print, or an empty string if nothing is shown.
    says
        What is somewhere in its output, as a table says.
    """

    place: str
    line: str
    output: str = ""
    says: str = ""

    @property
    def steps(self) -> list[list[str]]:
        """The words of each program in it, without operators and comments."""
        steps: list[list[str]] = [[]]
        for word in _words(self.line):
            if word in _THEN:
                steps.append([])
            else:
                steps[-1].append(word)
        return steps

    @property
    def calls(self) -> list[list[str]]:
        """The arguments of each call of `gsp` in it."""
        return [words[1:] for words in self.steps if words[0] == "gsp"]

    @property
    def missing(self) -> list[str]:
        """The programs that it needs and that are not here."""
        programs = (words[0] for words in self.steps)
        return [p for p in programs if p != "gsp" and not (p in OTHERS and shutil.which(p))]


@dataclass(frozen=True)
class Done:
    """What a command line did: the exit code of the last program that ran, and what was printed."""

    code: int
    results: str
    errors: str

    @property
    def output(self) -> str:
        """What was printed, results before errors."""
        return self.results + self.errors


def is_short(shown: Shown) -> bool:
    """Return whether a command takes no longer than tests can wait for."""
    return not (ENDLESS.search(shown.line) or LONG.search(shown.line))


def pages() -> list[Path]:
    """Return the pages that a reader sees, generated ones left out."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return [page for page in found if page.name not in _GENERATED]


def shown_in(page: Path) -> list[Shown]:
    """Return the command lines of a page, in order."""
    place = page.relative_to(ROOT).as_posix()
    text = page.read_text(encoding="utf-8")
    found: list[tuple[int, Shown]] = []
    for block in _CONSOLE.finditer(text):
        found += [(block.start(), shown) for shown in _of_block(place, block[1])]
    for match in _INDENTED.finditer(text):
        found.append((match.start(), Shown(place, match[1])))
    for match in _ROW.finditer(text):
        found.append((match.start(), Shown(place, match[1], says=match[2] or "")))
    ours = (entry for entry in found if _OURS.match(entry[1].line))
    return [shown for _, shown in sorted(ours, key=lambda entry: entry[0])]


def _of_block(place: str, block: str) -> Iterator[Shown]:
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        line, _, output = part.partition("\n")
        yield Shown(place, line, output)


def helps() -> dict[str, list[Shown]]:
    """Return the examples of all helps by the names of the commands."""
    found = {}
    for name, command in commands():
        place = f"gsp {name} --help"
        text = (command.help or "").partition("Examples:")[2]
        # A line that ends in an operator or a backslash goes on in the next.
        text = re.sub(r"(?:\\|(?<=\|))\n *", " ", text)
        found[name] = [Shown(place, line) for line in re.findall(r"^ *(gsp .+?) *$", text, re.M)]
    return found


def run_line(line: str) -> Done:
    """Run a command line in the current folder, calls of `gsp` in this process."""
    code, results, said = 0, "", ""
    for chain in _split(_words(line), "&&"):
        given = b""
        for words in _split(chain, "|"):
            command, *target = _split(words, ">")
            code, printed, errors = _run(command, given)
            if target:
                Path(target[0][0]).write_bytes(printed)
                printed = b""
            given = printed
            said += errors
        results += given.decode()
        if code:
            break
    return Done(code, results, said)


def _words(line: str) -> list[str]:
    lexer = shlex.shlex(line, posix=True, punctuation_chars="|&>")
    lexer.whitespace_split = True
    return list(lexer)


def _split(words: list[str], operator: str) -> list[list[str]]:
    parts: list[list[str]] = [[]]
    for word in words:
        if word == operator:
            parts.append([])
        else:
            parts[-1].append(word)
    return parts


def _run(words: list[str], given: bytes) -> tuple[int, bytes, str]:
    """Run one program; return its exit code, its output and its standard error."""
    if words[0] != "gsp":
        done = subprocess.run(words, input=given, capture_output=True, check=False)
        return done.returncode, done.stdout, done.stderr.decode()
    arguments: list[str] = []
    for word in words[1:]:
        names = sorted(Path().glob(word)) if "*" in word and "/" in word else []
        arguments += map(str, names) if names else [word]
    stdin = io.TextIOWrapper(io.BytesIO(given), encoding="utf-8")
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="\n")
    errors = io.StringIO()
    with (
        mock.patch.object(sys, "stdin", stdin),
        mock.patch.dict(os.environ, {"COLUMNS": "100", "NO_COLOR": "1"}),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(errors),
    ):
        code = run(arguments)
        out.flush()
    return code, out.buffer.getvalue(), errors.getvalue()
