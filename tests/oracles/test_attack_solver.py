"""Random crowded platforms (tools/fuzz/solver.py): always the same, and counted right."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from types import ModuleType

import pytest

from gspcli.atlas.groebner import msolve_path

MOST = 96
COUNTED = (1, 4, 10, 12)


@pytest.fixture(scope="module")
def attack(load_tool: Callable) -> ModuleType:
    return load_tool("fuzz.solver")


def test_platforms_are_the_same_by_their_numbers(attack: ModuleType) -> None:
    drawn = [attack.platform(number, MOST) for number in range(20)]
    assert drawn == [attack.platform(number, MOST) for number in range(20)]
    assert {platform.group for platform in drawn} == set(attack.MAKERS)
    assert len({platform.text for platform in drawn}) == len(drawn)
    assert all(platform.instance.expected <= MOST for platform in drawn)


def test_what_takes_too_long_is_not_counted(attack: ModuleType, monkeypatch) -> None:
    def forever(platform: object, *, with_real: bool) -> dict[str, object]:
        while True:
            pass

    monkeypatch.setattr(attack, "counted", forever)
    monkeypatch.setattr(attack, "COUNT_LIMIT_S", 1)
    _, row, found, failure = attack.tried(1, most=MOST, seeds=1, with_real=False)
    assert row is None
    assert len(found) == 1
    assert "not within 1 s" in failure


@pytest.mark.skipif(
    not (msolve_path() and shutil.which("Singular")), reason="msolve or Singular is not installed"
)
@pytest.mark.parametrize("number", COUNTED)
def test_answers_are_those_of_other_programs(attack: ModuleType, number: int) -> None:
    name, row, found, failure = attack.tried(number, most=MOST, seeds=1, with_real=False)
    judgement = attack.Judgement()
    judgement.add(name, found, failure, row, 1e9)
    assert not judgement.remarks


def test_a_wrong_answer_is_noticed(attack: ModuleType) -> None:
    judgement = attack.Judgement()
    row = {"finite": "yes", "count": "8", "distinct": "8", "real": "4"}
    said = attack.Answer("complete", 7, 8, 4, 7, "exact count", 0.1)
    judgement.add("crowd/0", [said], "", row, 1.0)
    assert judgement.wrong == 1
    assert "wrong complete" in judgement.remarks["crowd/0"]
