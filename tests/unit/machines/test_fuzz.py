"""Mutated files: the tool that runs thousands of them, on a few, and what it notices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import machine_models as models
import numpy as np
import pytest

import gspcli
from gspcli.machines.formats import machine_of
from gspcli.machines.recognition import Machine, recognized


@pytest.fixture
def tripod(tmp_path: Path) -> Machine:
    path = tmp_path / "tripod.xml"
    path.write_text(models.rps(), encoding="utf-8")
    return recognized(machine_of(path))


def test_mutated_files_are_read_or_refused(load_tool: Callable, tmp_path: Path) -> None:
    tool = load_tool("verify.machine_fuzz")
    random = Random(7)
    groups = list(tool.corpus(tmp_path))
    assert len(groups) == 7
    for group in groups:
        assert "refused" not in tool.read(group[0])
        contents = {path: path.read_bytes() for path in group}
        for _ in range(6):
            victim = random.choice(group)
            victim.write_bytes(tool.mutated(contents[victim], random))
            assert "WRONG" not in tool.read(group[0])
            victim.write_bytes(contents[victim])


def test_a_constraint_that_does_not_hold_is_noticed(load_tool: Callable, tripod: Machine) -> None:
    tool = load_tool("verify.machine_fuzz")
    assert tool.holds(tripod)
    first, *others = tripod.constraints
    moved = replace(first.held.base, points=first.held.base.points + 1e-3)
    wrong = replace(first, held=replace(first.held, base=moved))
    assert not tool.holds(replace(tripod, constraints=(wrong, *others)))


def test_each_mode_closes_the_joints(load_tool: Callable, tripod: Machine, tmp_path: Path) -> None:
    tool = load_tool("verify.machine_files")
    result = gspcli.solve(gspcli.import_machine(tmp_path / "tripod.xml", digits=17).instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    poses = np.concatenate((R.reshape(-1, 9), T), axis=1)
    assert tool.gaps(tripod, poses).max() < tool.CLOSED
    assert tool.gaps(tripod, poses[:1] + np.eye(12)[11] * 1e-4, tries=2).min() > 1e-6
