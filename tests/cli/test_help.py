"""Help, and completion by the shell."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete

from gspcli.catalogue.kinds import KINDS
from gspcli.cli.commands import BY_HEADING, COMMANDS
from gspcli.cli.main import cli
from gspcli.cli.streams import coloured

# Help: quick, complete, and the same in the documentation.


Run = Callable[..., object]
HEADINGS = [f"{heading}:" for heading in BY_HEADING]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_examples(name: str) -> None:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    leaves = command.commands.values() if isinstance(command, click.Group) else [command]
    for leaf in leaves:
        assert leaf.help is not None
        assert "Examples:" in leaf.help, name
        undocumented = [
            p.name for p in leaf.params if isinstance(p, click.Option) and not (p.help or p.hidden)
        ]
        assert not undocumented
        page = leaf.get_help(click.Context(leaf, info_name=name, terminal_width=80))
        assert max(map(len, page.splitlines())) <= 80, page
        assert "\n\n      " not in page.split("Options:")[0], "a paragraph is indented"


def test_help_exits_with_0_and_lists_every_command(gsp: Run) -> None:
    outcome = gsp("--help")
    assert outcome.code == 0
    assert all(f"\n  {name} " in outcome.out for name in COMMANDS)
    assert "..." not in outcome.out.split("What types are:")[1]


def test_help_imports_no_command() -> None:
    code = "import sys; from gspcli.cli.main import run; run(['--help']); print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(run.stdout.splitlines()[-1].split())
    commands = {f"gspcli.cli.commands.{name.replace('-', '_')}" for name in COMMANDS}
    assert not loaded & commands


def test_help_groups_the_commands(gsp: Run) -> None:
    assert [line for line in gsp("--help").out.splitlines() if line in HEADINGS] == HEADINGS


def test_no_arguments_show_the_help_and_exit_with_2(gsp: Run) -> None:
    outcome = gsp()
    assert outcome.code == 2
    assert "What types are:" in outcome.err
    assert outcome.out == ""


def test_unknown_commands_and_options_exit_with_2(gsp: Run) -> None:
    assert gsp("frobnicate").code == 2
    assert gsp("enumerate", "--frobnicate").code == 2


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("slove", "there is no command 'slove': did you mean solve?"),
        ("Solve", "there is no command 'Solve': did you mean solve?"),
        ("platform.yaml", "did you mean gsp solve platform.yaml?"),
        ("@dietmaier", "did you mean gsp solve @dietmaier?"),
        ("frobnicate", "there is no command 'frobnicate': gsp --help lists them"),
    ],
)
def test_a_wrong_command_is_told_what_was_meant(gsp: Run, word: str, said: str) -> None:
    outcome = gsp(word)
    assert outcome.code == 2
    assert said in outcome.err


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"TERM": "xterm"}, True),
        ({"TERM": "xterm", "NO_COLOR": "1"}, False),
        ({"TERM": "xterm", "NO_COLOR": ""}, True),
        ({"TERM": "dumb"}, False),
    ],
)
def test_colour_is_for_terminals_and_who_wants_it(
    monkeypatch: pytest.MonkeyPatch, settings: dict[str, str], expected: bool
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    terminal, pipe = io.StringIO(), io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    assert coloured(terminal) is expected
    assert not coloured(pipe)


def test_the_version(gsp: Run) -> None:
    from gspcli import __version__

    assert gsp("--version").out == f"gsp, version {__version__}\n"


# What the shell completes, by the words that click's scripts are given.


def _completed(line: str) -> list[str]:
    """Return what a line with the word to complete at its end can become; files as <file>."""
    _, *words, incomplete = line.split(" ")
    items = ShellComplete(cli, {}, "gsp", "_GSP_COMPLETE").get_completions(words, incomplete)
    return [item.value if item.type == "plain" else f"<{item.type}>" for item in items]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("gsp sol", ["solve"]),
        ("gsp solve @diet", ["@dietmaier"]),
        ("gsp solve plat", ["<file>"]),
        ("gsp check a.yaml @six", ["@six-planes"]),
        ("gsp show hex", ["hexapod"]),
        ("gsp show DL", ["DLP", "DLL"]),
        ("gsp bound 3d", ["3D3A"]),
        ("gsp realize D", ["<file>", *(kind.name for kind in KINDS if kind.is_distance)]),
        ("gsp enumerate --only PL,AH", ["PL,AHL", "PL,AHH"]),
        ("gsp enumerate --class 5", ["5D1A"]),
        ("gsp enumerate --columns id,gen", ["id,generic_one_sided", "id,generic_two_sided"]),
        ("gsp solve x.yaml --rotation Z", ["ZXY", "ZYX"]),
        ("gsp analyze x.yaml p", ["<file>"]),
        ("gsp track x.yaml v", ["<file>"]),
        ("gsp measure x.yaml p.csv --require range,cond", ["range,condition"]),
        ("gsp solve x.yaml --format j", ["json", "jsonl"]),
        ("gsp solve x.yaml -o p", ["<file>"]),
        ("gsp example fix", ["fixture-3-2-1"]),
        ("gsp bound --part b", ["bounds"]),
    ],
)
def test_completions(line: str, expected: list[str]) -> None:
    assert _completed(line) == expected


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes() -> None:
    script = """
eval "$(_GSP_COMPLETE=bash_source gsp)"
COMP_WORDS=(gsp solve @diet) COMP_CWORD=2
_gsp_completion gsp
echo "${COMPREPLY[*]}"
"""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    run = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == "@dietmaier\n"
