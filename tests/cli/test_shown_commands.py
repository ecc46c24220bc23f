"""Every command that a page or a help shows runs, and prints what is shown there."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from docs._ext import shown_commands, shown_output, stand_ins
from docs._ext.shown_commands import ENDLESS, LONG, Shown, is_short
from gspcli.cli.main import cli

PAGES = {page.name: shown_commands.shown_in(page) for page in shown_commands.pages()}
PAGES = {name: shown for name, shown in PAGES.items() if shown}
HELPS = shown_commands.helps()
ALL = [shown for group in (*PAGES.values(), *HELPS.values()) for shown in group]
#: Pages whose commands are run by tests of their own, which look at more.
ELSEWHERE = {"calibrate.md", "tutorial-machine.md"}
#: Exit codes that are meant; 0 otherwise. What a machine of the reader's keeps is not known.
CODES = {
    "hexapod.yaml path.csv --require": (1,),
    "platform.yaml path.csv .*--require": (0, 1),
    r"leg P1 B2 = 2\.7 \+-": (1,),
    "leg P1 B7": (2,),
    "gsp path .* --from home --to 2": (1,),
    r"leg P1 B2 = 2\.953": (1,),
    # What it lists depends on its random numbers.
    r"certify .*\.phc": (0, 1),
}


def _run(commands: list[Shown]) -> None:
    """Run command lines and compare; what needs a program that is not here is left out."""
    unmade: set[str] = set()
    able = []
    for shown in commands:
        words = {word for words in shown.steps for word in words}
        if shown.missing or words & unmade:
            unmade |= {word for word in words if re.search(r"\.(out|phc)$", word)}
        else:
            able.append(shown)
    for shown, done in zip(able, shown_output.run_in_order(able), strict=True):
        codes = next((c for part, c in CODES.items() if re.search(part, shown.line)), (0,))
        assert done.code in codes, (shown.place, shown.line, done.output)
        assert shown.says in done.output, (shown.line, done.output)
        if shown.output:
            advice = "run python -m docs._ext.shown_output"
            assert shown_output.same(done.output, shown.output), (shown.line, done.output, advice)


@pytest.mark.parametrize("name", [name for name in PAGES if name not in ELSEWHERE])
def test_the_commands_of_a_page_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    _run([shown for shown in PAGES[name] if is_short(shown) and not _runs_elsewhere(shown)])


def _runs_elsewhere(shown: Shown) -> bool:
    """Whether an earlier page shows the same programs, of which one takes seconds."""
    page = Path(shown.place).name
    return page == "tutorial-machine.md" and "d.phc" in shown.line


@pytest.mark.parametrize("name", HELPS)
def test_the_examples_of_a_help_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert HELPS[name]
    monkeypatch.chdir(tmp_path)
    _run([shown for shown in HELPS[name] if is_short(shown)])


@pytest.mark.slow
@pytest.mark.parametrize("shown", [s for s in ALL if LONG.search(s.line)], ids=lambda s: s.line)
def test_commands_that_take_long(
    shown: Shown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if ENDLESS.search(shown.line) or Path(shown.place).name in ELSEWHERE:
        pytest.skip("run by a test of its own, or by nobody")
    monkeypatch.chdir(tmp_path)
    # Commands before it on its page may write the files that it reads.
    page = PAGES.get(Path(shown.place).name, [])
    before = page[: page.index(shown)] if shown in page else []
    _run([*filter(is_short, before), shown])


def test_commands_that_are_not_run_are_written_correctly(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for shown in ALL:
        if not is_short(shown) or shown.missing:
            for words in shown.calls:
                stand_ins.prepare(shown, set())
                _parse(words)


def _parse(words: list[str]) -> None:
    """Read the words of a call without doing what they ask for."""
    command: click.Command = cli
    context = click.Context(cli)
    while isinstance(command, click.Group):
        found = command.get_command(context, words[0])
        assert found is not None, words
        command, words = found, words[1:]
    command.make_context("gsp", list(words))


def test_output_that_is_not_that_of_today_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (wrong,) = [s for s in PAGES["dynamics.md"] if s.line.endswith("0.02,0,0")]
    spoilt = Shown(wrong.place, wrong.line, wrong.output.replace("28.5166", "28.5167"))
    with pytest.raises(AssertionError, match="shown_output"):
        _run([spoilt])
