"""Numbers and files on the command line that nothing can be done with: exit code 2, and why."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import click
import pytest

from gspcli.cli.options import Finite
from tools.build.samples import commands

Run = Callable[..., object]
HUGE = "1" + "0" * 30
_KEPT = {"schema": "gsp.maximize-real/1", "subject": "6PP", "seed": 20031, "attempts": 1, "real": 2}
_SHAPES = {"kinds": ["DPP"] * 6, **dict.fromkeys("yxuv", [[0.0] * 3] * 6), "values": [1.0] * 6}
FORGED = [
    json.dumps(_KEPT | changes).encode()
    for changes in (
        {"attempts": "many"},
        {"attempts": -1},
        {"real": 1.5},
        _SHAPES | {"y": [[0.0] * 2] * 6},
        _SHAPES | {"values": [1.0] * 5},
        _SHAPES | {"values": [float("nan")] * 6},
    )
]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("count @dietmaier --effort nan", "'--effort': nan is not a finite number"),
        ("count @dietmaier --effort inf", "'--effort': inf is not a finite number"),
        ("certify @dietmaier - --max-deviation nan", "'--max-deviation': nan is not"),
        ("analyze @dietmaier --length inf", "'--length': inf is not a finite number"),
        ("workspace @workspace-study --gap nan", "'--gap': nan is not a finite number"),
        ("calibrate @dietmaier - --prior nan", "'--prior': nan is not a finite number"),
        ("calibrate @dietmaier - --prior inf", "'--prior': inf is not a finite number"),
        ("sensors @dietmaier --need nan", "'--need': nan is not a finite number"),
        ("calibrate @workspace-study --plan 3001", "'--plan': 3001 is not at most 300"),
        *(
            (words.replace("NUMBER", number), "expected")
            for number in ("nan", "inf", "1e999")
            for words in (
                "calibrate @dietmaier - --sigma value=NUMBER",
                "calibrate @dietmaier - --target P1=0,0,NUMBER",
                "measure @dietmaier - --pivot 0,0,NUMBER",
                "measure @dietmaier --pose 0,0,NUMBER,1,0,0,0",
                "solve @dietmaier --set 1=NUMBER",
                "analyze @dietmaier --load 0,0,NUMBER",
                "scan @dietmaier --vary x=0:NUMBER:5 --pose 0,0,1,1,0,0,0",
                "workspace @workspace-study --shift z=0:NUMBER:3",
                "sensors @dietmaier --sigma point=NUMBER",
                "measure @dietmaier --pose 0,0,1,1,0,0,0 --require condition<=NUMBER",
            )
        ),
        (f"sample 6PP --count {HUGE}", f"'--count': {HUGE} is not at most 1000000000"),
        (f"sample 6PP --seed {HUGE}", f"'--seed': {HUGE} is not at most 9223372036854775807"),
        (f"sample 6PP --jobs {HUGE}", f"'--jobs': {HUGE} is not at most 1000"),
        (f"solve @dietmaier --jobs {HUGE}", f"'--jobs': {HUGE} is not at most 1000"),
        (f"solve @dietmaier --seed {HUGE}", "is not at most 9223372036854775807"),
        ("solve @dietmaier --seed -1", "-1 is not in the range x>=0"),
        (f"enumerate --max-table-3 {HUGE}", "is not at most 1000000000"),
        (f"enumerate --first {HUGE}", "is not at most 1000000000"),
        (f"track @dietmaier - --steps {HUGE}", "is not at most 1000000000"),
    ],
)
def test_numbers_that_are_none_or_too_large(gsp: Run, words: str, said: str) -> None:
    outcome = gsp(*words.split())
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err


def test_every_option_that_is_a_number_refuses_what_is_not_finite() -> None:
    """In one place, `Finite`: comparisons with NaN are false, so that a range lets it pass."""
    found = 0
    for name, command in commands():
        for option in command.params:
            if isinstance(option.type, click.types.FloatParamType):
                found += 1
                assert isinstance(option.type, Finite), (name, option.name)
            if isinstance(option.type, click.types.FloatParamType | click.types.IntParamType):
                for number in ("nan", "inf", "-inf", "1e999"):
                    with pytest.raises(click.BadParameter):
                        option.type.convert(number, None, None)
    assert found >= 9


@pytest.mark.parametrize("content", [b"\xb9\x00\xff", b"[" * 100_000, b"{}", *FORGED])
def test_a_state_that_is_none(gsp: Run, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "state.json"
    path.write_bytes(content)
    outcome = gsp("maximize-real", "6PP", "--attempts", "1", "--resume", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == (
        f"error: {path}: this is not a state of gsp maximize-real: choose another file\n"
    )
    assert path.read_bytes() == content


def test_a_journal_that_is_none(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "work.jsonl"
    path.write_bytes(b"\xb9\x00\xff")
    outcome = gsp("scan", "@octahedral-3-3", "--vary", "1=1.4:1.6:5", "--resume", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == f"error: {path}:1: this is not a line of a work file\n"
    assert path.read_bytes() == b"\xb9\x00\xff"


def test_a_cell_of_a_megabyte(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text('x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,"' + "1" * 1_000_000 + '"\n')
    outcome = gsp("certify", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert f"{path}:2:1: found no row of CSV: field larger than field limit" in outcome.err
    for words in (("measure", "@dietmaier", path), ("view", "@dietmaier", "--track", path)):
        outcome = gsp(*words)
        assert (outcome.code, outcome.out) == (2, "")
        assert len(outcome.err) < 300


def test_a_row_over_several_lines(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text('x,y,z,qw,qx,qy,qz\n0,0,1,1,0,0,0\n0,b,",1,0,0,0\n0,0,1,1,0,0,0\n')
    outcome = gsp("certify", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}:3:1: ")


def test_a_column_and_a_count_of_thousands_of_digits(gsp: Run, tmp_path: Path) -> None:
    path = tmp_path / "values.csv"
    path.write_text("t," + "9" * 5000 + ",1\n0,1,1\n1,1,1\n")
    outcome = gsp("track", "@dietmaier", path)
    assert (outcome.code, outcome.out) == (2, "")
    assert "…, expected a constraint from 1 to 6" in outcome.err
    for words in (
        ("scan", "@dietmaier", "--vary", "1=1:2:" + "9" * 5000),
        ("workspace", "@workspace-study", "--shift", "z=0:1:" + "9" * 5000),
        ("workspace", "@workspace-study", "--shift", "z=0:1:999999999"),
    ):
        outcome = gsp(*words)
        assert (outcome.code, outcome.out) == (2, "")
        assert len(outcome.err) < 300
