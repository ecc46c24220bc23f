"""Realistic machines drawn at random: what they are, and how their times are judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.geometry.arrangement import Arrangement
from gspcli.spec import dumps
from tools.special.realistic import machines
from tools.verify.realistic import Row, measured, outliers, wrong

LIKE = Row("6-6/0", "", "complete", 40, 8, 0, 20.0, 1.0, 0.1)


def test_a_machine_depends_on_its_number_alone() -> None:
    every = list(machines(24, rows=2))
    assert {machine.structure for machine in every} >= {"6-6", "6-3", "3-3", "fixture", "coupling"}
    again = next(machines(18, rows=2, begin=17))
    assert dumps(again.instance) == dumps(every[17].instance)
    assert np.array_equal(again.rows, every[17].rows)
    assert next(machines(1, seed=1, rows=2)).text != every[0].text


def test_hexapods_share_joints_as_they_say() -> None:
    joints = {"6-6": (6, 6), "6-3": (6, 3), "3-3": (3, 3)}
    for machine in machines(24, rows=1):
        given = Arrangement.of(machine.instance)
        if machine.structure in joints:
            found = tuple(len({tuple(p) for p in body.tolist()}) for body in (given.x, given.y))
            assert found == joints[machine.structure], machine


@pytest.mark.parametrize("number", [5, 7, 9])
def test_all_answers_to_a_machine_are_complete_and_proved(number: int) -> None:
    row = measured(number)
    assert row.structure == ("3-3", "coupling", "fixture")[number // 2 - 2]
    assert not list(wrong([row]))
    assert row.poses >= row.real >= 1


def test_what_is_slower_than_its_structure_is_named() -> None:
    rows = [LIKE, LIKE, replace(LIKE, machine="6-6/1", row=0.31), replace(LIKE, others=2.9)]
    assert [line.partition(" ms")[0] for line in outliers(rows)] == ["6-6/1: row 0.31"]


def test_an_answer_that_is_not_proved_is_named() -> None:
    rows = [replace(LIKE, verdict="complete, not proved"), replace(LIKE, incomplete=1), LIKE]
    assert len(list(wrong(rows))) == 2
