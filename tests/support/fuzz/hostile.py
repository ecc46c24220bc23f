"""Invalid command lines and files, drawn at random.

`options` draws a command with some of its options and arguments, found in its declaration, and
values that fit badly; `inputs` gives a command a good file that was spoilt. Run them in an empty
folder.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import click

from gspcli.cli.commands import COMMANDS
from gspcli.cli.main import cli
from gspcli.resources import instance_files

LONG = "n" * 300
#: Numbers that are none, too large, or on the edge of what is meant.
NUMBERS = (
    *("nan", "inf", "-inf", "-1", "0", "-0", "1", "2", "3", "0.5", "1e-320", "1e308", "1e999"),
    *("1" + "0" * 30, "9" * 5000, "", " ", "x", "1_0", "0x1", "½", "٣", "1,2", "--1", "1/0"),
)
WORDS = (
    "",
    "-",
    "--",
    "@",
    "@nobody",
    "ö.yaml",
    "\udcc3",
    "a\tb",
    "\x1b[31m",
    "%s",
    LONG,
    "é" * 999,
)
TYPES = (
    *("6PP", "6-3", "421", "0", "3851", "3D3A PL PL LP", "PP", "LL", "P-P", "3D3A", "7PP", "3-3"),
    *("P1-p1", "P1-p1 P1-p2 P2-p2 P2-p3 P3-p3 P3-p1", "DPL DPL DLP ALL ALH AHH", "L1^l1"),
)
SPECS = ("@octahedral-3-3", "@example-6.8", "@dietmaier", "@point-on-line", "@no-real-pose", "@")
POSES = (
    "0,0,1,1,0,0,0",
    "0,0,0,0,0,0,0",
    "1,2,3",
    "0,0,1,0,0,0",
    "a,b,c,d,e,f,g",
    "nan,0,0,1,0,0,0",
)
GRIDS = (
    *("1=1:2:3", "1=2:1:3", "7=1:2:3", "1=1:2:1", "1=nan:2:3", "1=1:2:999999999", "=::", "z=0:1:2"),
    *("x=-1:1:3", "1=5", "1=-5", "1=1/0", "z=1", "1=1e999", "z=0:1"),
)
FILES = (
    *("none.csv", "none/none.csv", ".", "/dev/null", LONG + ".csv", "empty", "binary", "notes.txt"),
    *("poses.csv", "values.csv", "poses.json", "good.yaml", "/dev/full", "locked/a.csv"),
)
TARGETS = (
    "a.csv",
    "a.json",
    "a.md",
    "a.tex",
    "a.txt",
    "a.svg",
    "a",
    "none/a.csv",
    ".",
    "/dev/full",
)
#: Commands that work as long as they are let are asked for little.
LITTLE = {
    "sample": ["--count", "20", "--jobs", "1"],
    "maximize-real": ["--attempts", "1", "--time", "0.2", "--jobs", "1"],
    "atlas": ["--jobs", "1"],
    "scan": ["--jobs", "1"],
}
_MOST_BYTES = 300_000
VALUES = b"t,1,2\n0,1.5,1.5\n1,1.51,1.49\n2,1.5,1.5\n"
POSE_FILE = b"x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,0\n0.1,0,1,1,0.1,0,0\n"
POSE_LIST = [{"quaternion": [1, 0, 0, 0], "T": [0, 0, 1], "real": True}]
STATE = {"schema": "gsp.maximize-real/1", "subject": "6PP", "seed": 20031, "attempts": 1, "real": 0}


@dataclass
class Hostile:
    """A command with the files that it finds, by name, and what it reads from standard input."""

    words: list[str]
    files: dict[str, bytes] = field(default_factory=dict)
    stdin: bytes = b""


def common_files() -> dict[str, bytes]:
    """Return the files that names in `FILES` mean."""
    return {
        "empty": b"",
        "binary": bytes(range(256)) * 8,
        "notes.txt": b"one\ntwo three\n",
        "poses.csv": POSE_FILE,
        "values.csv": VALUES,
        "poses.json": json.dumps(POSE_LIST).encode(),
        "good.yaml": instance_files()["octahedral-3-3"].read_bytes(),
    }


def options(rng: Random) -> Hostile:
    """Return a command with options and arguments that may be anything."""
    name = rng.choice(list(COMMANDS))
    words, command = [name], cli.get_command(click.Context(cli), name)
    if isinstance(command, click.Group):
        child = rng.choice([*command.commands, rng.choice(WORDS)])
        words.append(child)
        command = command.commands.get(child)
    given: list[str] = []
    if command is not None:
        for parameter in command.params:
            if isinstance(parameter, click.Argument):
                given += _arguments(parameter, rng)
            elif rng.random() < 0.08 and "--help" not in parameter.opts:
                given += _option(parameter, rng)
    if rng.random() < 0.05:
        given.insert(rng.randrange(len(given) + 1), rng.choice(("--frobnicate", "--", *WORDS)))
    if rng.random() < 0.9:
        given += [word for word in LITTLE.get(name, []) if command is not None]
    stdin = rng.choice((b"", VALUES, POSE_FILE, bytes(range(256))))
    return Hostile([*words, *given], common_files(), stdin)


def _arguments(parameter: click.Argument, rng: Random) -> list[str]:
    count = 1 if parameter.nargs == 1 else rng.choice((0, 1, 1, 1, 2))
    return [word for _ in range(count) for word in _value(parameter, rng).split("\0")]


def _option(parameter: click.Parameter, rng: Random) -> list[str]:
    option = rng.choice([*parameter.opts, *parameter.secondary_opts])
    if getattr(parameter, "is_flag", False):
        return [option]
    return [option, _value(parameter, rng)]


def _value(parameter: click.Parameter, rng: Random) -> str:
    """Return a value that fits what a parameter is called, or not."""
    if rng.random() < 0.05:
        return rng.choice(rng.choice((NUMBERS, WORDS, TYPES, FILES, GRIDS, POSES)))
    kind, name = parameter.type, (parameter.metavar or parameter.name or "").upper()
    if isinstance(kind, click.Choice):
        return str(rng.choice(list(kind.choices)))
    if isinstance(kind, (click.types.IntParamType, click.types.FloatParamType)):
        return rng.choice(rng.choice((NUMBERS, ("1", "2", "3", "0.5"))))
    for part, pool in _POOLS:
        if part in name:
            return rng.choice(pool)
    return rng.choice(rng.choice((NUMBERS, WORDS)))


_POOLS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("SPEC", (*SPECS * 4, "good.yaml", "empty", "binary", ".", "-", LONG)),
    ("TYPE", (*TYPES, *("6PP", "421", "3D3A PL PL LP") * 8)),
    ("NAMES", TYPES),
    ("OUTPUT", TARGETS),
    ("=", GRIDS),
    ("NUMBERS", (*POSES, *POSES[:1] * 4)),
    ("POSE", (*POSES, *POSES[:1] * 4)),
    ("FILE", (*FILES, *TARGETS)),
    ("VALUES", (*FILES, *("-", "values.csv") * 6)),
    ("POSES", (*FILES, *("-", "poses.csv", "poses.json") * 4)),
    ("KINDS", ("PP", "A", "D", "XX", "PP,PL", "")),
    ("COLUMNS", ("id", "-id", "number,id", "nothing", "")),
    ("CLASS", ("3D3A", "6D", "generic", "planar", "all", "nothing")),
    ("EULER", ("ZYX", "xyz", "XXY", "Zyx", "")),
    ("FORM", ("matrix", "ZYX", "quaternion", "euler", "")),
    ("ADDRESS", ("tcp://127.0.0.1:1", "nowhere", "")),
)


#: What reads a file, as the words before and after its name.
READERS: dict[str, list[list[str]]] = {
    "spec.yaml": [
        ["check", "{}"],
        ["check", "{}", "--format", "json"],
        ["solve", "{}"],
        ["solve", "{}", "--no-prove", "--format", "csv"],
        ["measure", "{}", "--pose", "0,0,1,1,0,0,0"],
        ["count", "{}", "--effort", "0.1"],
        ["analyze", "{}", "--pose", "0,0,1,1,0,0,0"],
        ["realize", "{}"],
        ["show", "{}"],
        ["export", "{}", "--to", "sympy"],
    ],
    "poses.csv": [
        ["measure", "@octahedral-3-3", "{}"],
        ["measure", "@octahedral-3-3", "{}", "--euler", "ZYX"],
        ["certify", "@octahedral-3-3", "{}"],
        ["solve", "@octahedral-3-3", "--near", "@{}"],
        ["track", "@octahedral-3-3", "{}"],
    ],
    "values.csv": [
        ["track", "@octahedral-3-3", "{}", "--jobs", "1"],
        ["track", "@octahedral-3-3", "{}", "--relative", "--format", "csv"],
    ],
    "poses.json": [["certify", "@octahedral-3-3", "{}"], ["measure", "@octahedral-3-3", "{}"]],
    "state.json": [["maximize-real", "6PP", *LITTLE["maximize-real"], "--resume", "{}"]],
    "work.jsonl": [
        ["scan", "@octahedral-3-3", "--vary", "1=1.4:1.6:3", "--jobs", "1", "--resume", "{}"]
    ],
}


def _good(name: str, rng: Random) -> bytes:
    if name == "spec.yaml":
        return rng.choice(sorted(instance_files().values())).read_bytes()
    return {
        "poses.csv": POSE_FILE,
        "values.csv": VALUES,
        "poses.json": json.dumps(POSE_LIST).encode(),
        "state.json": json.dumps(STATE).encode(),
        "work.jsonl": b'{"scan": "0123456789abcdef", "number": 0}\n',
    }[name]


def inputs(rng: Random) -> Hostile:
    """Return a command that reads a good file which was spoilt up to three times."""
    name = rng.choice(["spec.yaml", *READERS])
    content = _good(name, rng)
    for _ in range(rng.randrange(1, 4)):
        content = rng.choice(_SPOILING)(content, rng)[:_MOST_BYTES]
    words = rng.choice(READERS[name])
    if rng.random() < 0.2 and name not in ("state.json", "work.jsonl"):
        return Hostile([word.replace("{}", "-") for word in words], {}, content)
    return Hostile([word.replace("{}", name) for word in words], {name: content})


def _bytes_changed(content: bytes, rng: Random) -> bytes:
    changed = bytearray(content or b" ")
    for _ in range(rng.randrange(1, 4)):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed)


def _cut(content: bytes, rng: Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def _lines(content: bytes, rng: Random) -> bytes:
    """Return the content with a line left out, doubled, moved or repeated many times."""
    lines = content.split(b"\n")
    k = rng.randrange(len(lines))
    line = lines.pop(k)
    how = rng.randrange(4)
    if how == 1:
        lines[k:k] = [line, line]
    elif how == 2:
        lines.insert(rng.randrange(len(lines) + 1), line)
    elif how == 3:
        lines[k:k] = [line] * rng.choice((70, 500))
    return b"\n".join(lines)


def _token(content: bytes, rng: Random) -> bytes:
    """Return the content with a word or number replaced."""
    words = content.split(b" ")
    new = rng.choice((*NUMBERS, *WORDS[:9], "[" * 50, "{" * 5000, "&a", "*a", "!!int", "null"))
    words[rng.randrange(len(words))] = new.encode("utf-8", "surrogateescape")
    return b" ".join(words)


def _number(content: bytes, rng: Random) -> bytes:
    """Return the content with digits, wherever they stand, replaced."""
    places = [k for k, byte in enumerate(content) if byte in b"0123456789"]
    if not places:
        return content
    k = rng.choice(places)
    return content[:k] + rng.choice(NUMBERS).encode() + content[k + 1 :]


def _long(content: bytes, rng: Random) -> bytes:
    k = rng.randrange(len(content) + 1)
    return content[:k] + rng.choice((b"9", b" ", b"x", b"\n", b'"', b"[")) * 120_000 + content[k:]


_SPOILING: tuple[Callable[[bytes, Random], bytes], ...] = (
    *(_bytes_changed, _cut, _lines, _lines, _token, _token, _number, _number, _number, _long),
)


def write_files(hostile: Hostile, folder: Path) -> None:
    """Write the files of a command, and a folder in which nothing can be written."""
    for name, content in hostile.files.items():
        (folder / name).write_bytes(content)
    (folder / "locked").mkdir()
    (folder / "locked").chmod(0o500)


def text(words: list[str]) -> Any:
    """Return a command for a message: escaped where it cannot be printed, and shortened."""
    return " ".join(word if len(word) < 60 else word[:57] + "..." for word in map(ascii, words))
