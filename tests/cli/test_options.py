"""One spelling of each option, and one meaning of each spelling, in all commands."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable

import click
import pytest

from gspcli.cli.completion import _words_of
from gspcli.cli.pose_options import PoseType
from tools.build.samples import commands

#: What differs by nature: the formats and tables that a command has.
_CHOICES_OF_A_COMMAND = {"--format", "--part"}
#: Options that go together: a command with the first has the others.
_TOGETHER = {
    "--set": ("--delta",),
    "--delta": ("--set",),
    "--near": ("--euler", "--pivot"),
    "--pose": ("--euler", "--pivot"),
    "--euler": ("--pivot",),
    "--scheduler": ("--jobs",),
}


def _uses() -> dict[str, dict[str, click.Option]]:
    """Return the options by spelling and command."""
    found: dict[str, dict[str, click.Option]] = defaultdict(dict)
    for name, command in commands():
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                for spelling in (*parameter.opts, *parameter.secondary_opts):
                    found[spelling][name] = parameter
    return found


USES = _uses()
#: The types by spelling: completion in this process gives some others later.
TYPES = {
    spelling: {type(option.type) for option in uses.values()} for spelling, uses in USES.items()
}


#: Options whose meaning in a command is its own: `gsp import` prints no proved solutions, a path
#: begins and ends at poses, and the columns of `gsp enumerate` are those of its own table.
OWN = {
    "--all": {"path", "freedoms"},
    "--along": {"track"},
    "--columns": {"enumerate"},
    "--digits": {"import"},
    "--from": {"path", "calibrate"},
    "--stiffness": {"dynamics"},
    "--to": {"path"},
}


def _said(option: click.Option) -> str:
    """Return the first clause of a help: the meaning, before what is special to a command."""
    return re.split(r"[.:;](?:\s|$)", option.help or "")[0]


@pytest.mark.parametrize("spelling", [name for name, uses in USES.items() if len(uses) > 1])
def test_an_option_means_the_same_in_all_commands(spelling: str) -> None:
    own = OWN.get(spelling, set())
    uses = [option for name, option in USES[spelling].items() if name not in own]
    assert len({option.metavar for option in uses}) == 1
    assert len({option.is_flag for option in uses}) == 1
    assert len({_said(option) for option in uses}) == 1
    assert own or len(TYPES[spelling]) == 1
    assert len({(option.multiple, option.nargs) for option in uses}) == 1
    if spelling not in _CHOICES_OF_A_COMMAND:
        choices = {
            tuple(option.type.choices) for option in uses if isinstance(option.type, click.Choice)
        }
        assert len(choices) < 2


@pytest.mark.parametrize("first", _TOGETHER)
def test_options_that_go_together(first: str) -> None:
    assert USES[first]
    for other in _TOGETHER[first]:
        assert set(USES[first]) <= set(USES[other]), other


def test_a_pose_is_written_in_one_way() -> None:
    poses = [
        option for uses in USES.values() for option in uses.values() if option.metavar == "POSE"
    ]
    assert len(poses) > 8
    assert all(isinstance(option.type, PoseType) for option in poses)
    assert set(USES["--near"]) | set(USES["--pose"]) == {
        name for uses in USES.values() for name, o in uses.items() if isinstance(o.type, PoseType)
    }


def test_who_reads_an_instance_takes_other_values_for_it() -> None:
    # Of these the values make no difference, or there is none to begin with.
    without = {"check", "calibrate", "freedoms", "measure", "maximize-real", "realize"}
    readers = {
        name
        for name, command in commands()
        if any("SPEC" in _words_of(p) for p in command.params if isinstance(p, click.Argument))
    }
    assert readers - without == set(USES["--set"])


def test_results_go_to_a_file_everywhere() -> None:
    named = {name for name, _ in commands()}
    assert named == set(USES["-o"])


@pytest.mark.parametrize("pose", ["1,2,3,1,0,0,0", "1,2,3,0,0,0 --euler ZYX", "@FILE"])
def test_every_command_takes_a_pose_in_each_form(gsp: Callable, tmp_path, pose: str) -> None:
    file = tmp_path / "pose.csv"
    file.write_text("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n")
    words = pose.replace("FILE", str(file)).split()
    spec = "@octahedral-3-3"
    runs = {
        ("solve", spec, "--near"): (),
        ("measure", spec, "--pose"): (),
        ("analyze", spec, "--pose"): (),
        ("clearance", spec, "--pose"): (),
        ("scan", spec, "--vary", "x=0:1:2", "--pose"): (),
    }
    for run, more in runs.items():
        outcome = gsp(*run, *words, *more)
        assert outcome.code == 0, outcome.err
    several = tmp_path / "poses.csv"
    several.write_text("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n1,2,4,1,0,0,0\n")
    for run, more in runs.items():
        outcome = gsp(*run, f"@{several}", *more)
        assert (outcome.code, outcome.out) == (2, "")
        assert "found 2 poses, expected one" in outcome.err


def test_values_are_set_and_added_to(gsp: Callable) -> None:
    spec = "@octahedral-3-3"
    set_ = gsp("solve", spec, "--set", "1=1.6", "--format", "csv").out
    one = gsp("solve", spec, "--set", "1=1.5", "--delta", "1=0.1", "--format", "csv").out
    assert set_ == one
    other = gsp("solve", spec, "--delta", "1=0.1", "--format", "csv").out
    assert other != gsp("solve", spec, "--format", "csv").out
    wrong = gsp("analyze", spec, "--delta", "1=-9")
    assert (wrong.code, wrong.out) == (2, "")
    assert wrong.err.startswith("error: --delta '1=-9': found '-9', expected a distance")
