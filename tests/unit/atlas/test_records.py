"""The record says what was found, how, and nothing else."""

from __future__ import annotations

import csv
import io

import pytest

from gspcli.atlas.journal import Result
from gspcli.atlas.records import contents
from gspcli.atlas.tasks import PRIMES, SEED, Task
from gspcli.errors import CheckFailed

SUBJECT, FAMILY = "DPP DPP DPL", "3D3A PP PP PL"


def _rows(counts: dict[tuple[str, int, int], int | None]) -> dict[str, dict[str, str]]:
    results = {Task(*key): Result(Task(*key), count, 0.1) for key, count in counts.items()}
    rows = csv.DictReader(io.StringIO(contents(results)["families.csv"]))
    return {row["family"]: row for row in rows}


def _modulo(subject: str, *counts: int | None) -> dict[tuple[str, int, int], int | None]:
    return {(subject, 1, p): count for p, count in zip(PRIMES, counts, strict=True)}


def test_without_results_there_is_only_the_law() -> None:
    rows = _rows({})
    assert len(rows) == 896
    assert {row["method"] for row in rows.values()} == {"law"}
    assert {row["orders"] + row["certified"] for row in rows.values()} == {""}


def test_methods_are_named() -> None:
    both = _rows({**_modulo(SUBJECT, 32, 32), (SUBJECT, 1, 0): 32})[FAMILY]
    assert (both["method"], both["one_sided"], both["orders"]) == (
        "groebner+tracking",
        "32",
        "32 32",
    )
    assert _rows(_modulo(SUBJECT, 32, 32))[FAMILY]["method"] == "groebner"
    assert _rows({(SUBJECT, 1, 0): 32})[FAMILY]["method"] == "tracking"
    # One prime is not enough.
    assert _rows(_modulo(SUBJECT, 32, None))[FAMILY]["method"] == "law"


def test_what_was_counted_prevails_over_the_law() -> None:
    row = _rows({**_modulo(SUBJECT, 31, 31), (SUBJECT, 1, 0): 31})[FAMILY]
    assert (row["one_sided"], row["method"]) == ("31", "groebner+tracking")


def test_too_few_certified_poses_establish_nothing() -> None:
    alone = _rows({(SUBJECT, 1, 0): 30})[FAMILY]
    assert (alone["one_sided"], alone["method"], alone["certified"]) == ("32", "law", "30")
    both = _rows({**_modulo(SUBJECT, 32, 32), (SUBJECT, 1, 0): 30})[FAMILY]
    assert (both["method"], both["certified"]) == ("groebner", "30")


@pytest.mark.parametrize(
    ("counts", "problem"),
    [
        (_modulo(SUBJECT, 32, 31), "the methods disagree"),
        ({**_modulo(SUBJECT, 32, 32), (SUBJECT, 1, 0): 33}, "33 poses are certified"),
        ({(SUBJECT, 1, 0): 33}, "33 poses are certified"),
        ({("DPP DPP DPH", 2, 0): 33}, "33 poses are certified"),
        (
            {
                **_modulo("DPP DPP DPH", 16, 16),
                **{("DPP DPP DPH", 2, p): 31 for p in PRIMES},
            },
            "the methods disagree",
        ),
        ({("ssssss", 1, p): 39 for p in PRIMES}, "the methods disagree"),
    ],
)
def test_disagreement_is_an_error(
    counts: dict[tuple[str, int, int], int | None], problem: str
) -> None:
    with pytest.raises(CheckFailed, match=problem):
        _rows(counts)


def test_results_of_another_seed_are_not_recorded() -> None:
    task = Task(SUBJECT, 1, 0, SEED + 1)
    assert contents({task: Result(task, 32, 0.1)}) == contents({})
