"""The record says what was found, how, and nothing else."""

from __future__ import annotations

import csv
import io

import pytest

from gspcli.defaults import SEED
from gspcli.errors import CheckFailed
from tools.atlas.records import RecordVerdict, contents, verdict
from tools.atlas.tasks import PRIMES, Result, Task, TraceTest, Tracked

SUBJECT, FAMILY = "DPP DPP DPL", "3D3A PP PP PL"


PASSED, FAILED = TraceTest(1e-14, 1e-5), TraceTest(2e-5, 1e-5)

Key = tuple[str, int, int]


def _results(counts: dict[Key, int | None], trace: TraceTest | None = None) -> dict[Task, Result]:
    results = {}
    for (subject, sides, characteristic), count in counts.items():
        task = Task(subject, sides, characteristic)
        paths = None if characteristic or count is None else Tracked(count, trace)
        results[task] = Result(task, count, 0.1, paths)
    return results


def _rows(
    counts: dict[Key, int | None], trace: TraceTest | None = None
) -> dict[str, dict[str, str]]:
    text = contents(_results(counts, trace))["families.csv"]
    return {row["family"]: row for row in csv.DictReader(io.StringIO(text))}


def _modulo(subject: str, *counts: int | None) -> dict[Key, int | None]:
    return {(subject, 1, p): count for p, count in zip(PRIMES, counts, strict=True)}


def test_without_results_nothing_is_confirmed() -> None:
    rows = _rows({})
    assert len(rows) == 896
    evidence = ("confirmed", "orders", "certified", "trace", "trace_without_one")
    assert {row[column] for row in rows.values() for column in evidence} == {""}
    assert rows[FAMILY]["one_sided"] == "32"


def test_methods_are_named() -> None:
    everything = {**_modulo(SUBJECT, 32, 32), (SUBJECT, 1, 0): 32}
    row = _rows(everything, PASSED)[FAMILY]
    assert (row["confirmed"], row["orders"]) == ("groebner+tracking+trace", "32 32")
    assert (row["trace"], row["trace_without_one"]) == ("1e-14", "1e-05")
    assert _rows(everything, FAILED)[FAMILY]["confirmed"] == "groebner+tracking"
    assert _rows(_modulo(SUBJECT, 32, 32))[FAMILY]["confirmed"] == "groebner"
    assert _rows({(SUBJECT, 1, 0): 32})[FAMILY]["confirmed"] == "tracking"
    # One prime is not enough.
    assert _rows(_modulo(SUBJECT, 32, None))[FAMILY]["confirmed"] == ""


def test_too_few_certified_poses_confirm_nothing() -> None:
    row = _rows({(SUBJECT, 1, 0): 30}, PASSED)[FAMILY]
    assert (row["one_sided"], row["confirmed"], row["certified"]) == ("32", "", "30")


def test_verdicts() -> None:
    verdicts = [
        verdict(_results({(SUBJECT, 1, 0): count}, trace)[Task(SUBJECT, 1, 0)])
        for count, trace in ((32, PASSED), (32, FAILED), (31, PASSED), (33, PASSED))
    ]
    equal, unfinished, different = (
        RecordVerdict.EQUAL,
        RecordVerdict.UNFINISHED,
        RecordVerdict.DIFFERENT,
    )
    assert verdicts == [equal, unfinished, unfinished, different]


@pytest.mark.parametrize(
    ("counts", "problem"),
    [
        (_modulo(SUBJECT, 32, 31), "32 by theorem, but counted were"),
        (_modulo(SUBJECT, 31, 31), "32 by theorem, but counted were"),
        ({(SUBJECT, 1, 0): 33}, "33 poses are certified"),
        ({("DPP DPP DPH", 2, 0): 33}, "33 poses are certified"),
        (
            {**_modulo("DPP DPP DPH", 16, 16), **{("DPP DPP DPH", 2, p): 31 for p in PRIMES}},
            "by theorem, but counted were",
        ),
        ({("ssssss", 1, p): 39 for p in PRIMES}, "by theorem, but counted were"),
    ],
)
def test_disagreement_is_an_error(counts: dict[Key, int | None], problem: str) -> None:
    with pytest.raises(CheckFailed, match=problem):
        _rows(counts)


def test_results_of_another_seed_are_not_recorded() -> None:
    task = Task(SUBJECT, 1, 0, SEED + 1)
    assert contents({task: Result(task, 32, 0.1)}) == contents({})
