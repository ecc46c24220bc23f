"""What is kept of solved platforms: inspected, cleared, passed; no answer depends on it."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_path
from gspcli.solver import solve, solve_batch, solve_values
from gspcli.solver.starts.solved_starts import STARTS, SolvedStarts, Sort
from gspcli.spec import load

NONE = dict.fromkeys(Sort, 0)


@cache
def platform(name: str):
    if name == "octahedral-3-3":
        return load(data_path("examples", f"{name}.yaml"))
    return random_instance(parse_type(name), np.random.default_rng(7))[0]


def rows_of(instance, number=6):
    own = np.array([row.value.value for row in instance.constraints])
    return own * (1 + 0.02 * np.random.default_rng(8).normal(size=(number, 6)))


def sizes(starts):
    return {sort: number for sort, number in starts.sizes.items() if number}


def test_of_each_sort_the_last_are_kept():
    starts, made = SolvedStarts(), []
    assert starts.sizes == NONE
    for k in range(70):
        starts.keep(Sort.COUNT, k, str(k))
        starts.fetch(Sort.COUNT, 0)
    assert starts.sizes == {**NONE, Sort.COUNT: 64}
    # What was used last, and what was kept last.
    assert starts.fetch(Sort.COUNT, 0) == "0"
    assert starts.fetch(Sort.COUNT, 1) is None
    assert starts.fetch(Sort.COUNT, 69) == "69"
    assert starts.fetch(Sort.PLATFORM, 69) is None
    for _ in range(2):
        # None is an answer, too: that nothing is known.
        assert starts.kept(Sort.COUNT, 1, lambda: made.append(1)) is None
    assert made == [1]
    starts.clear()
    assert starts.sizes == NONE


def test_what_is_kept_is_told():
    starts = SolvedStarts()
    starts.keep(Sort.START, 1, 2)
    assert "1 solved platforms with complex values" in repr(starts)
    for sort in Sort:
        assert sort.value in repr(starts)


def test_each_has_its_own():
    starts, others = SolvedStarts(), SolvedStarts()
    instance = platform("octahedral-3-3")
    STARTS.clear()
    for _ in range(2):
        solve(instance, starts=starts)
    special = {Sort.PLATFORM: 1, Sort.GEOMETRY: 1, Sort.COUNT: 1}
    assert sizes(starts) == sizes(starts) | special
    assert others.sizes == STARTS.sizes == NONE
    solve(instance)
    assert STARTS.sizes[Sort.PLATFORM] == 1


@pytest.mark.parametrize("call", [solve_batch, lambda *a, **k: list(solve_values(*a, **k))])
def test_batches_keep_what_they_solve_in_what_they_are_given(call):
    starts, instance = SolvedStarts(), platform("6PP")
    STARTS.clear()
    call(instance, rows_of(instance), starts=starts)
    kept = sizes(starts)
    assert set(kept) == {Sort.GEOMETRY}
    assert STARTS.sizes == NONE
    call(instance, rows_of(instance), starts=starts)
    assert sizes(starts) == kept


def test_nothing_is_remembered_elsewhere(monkeypatch):
    """After all was forgotten a call does what the first one did."""
    instance, seen = platform("octahedral-3-3"), []
    starts = SolvedStarts()

    def watched(kind):
        function = getattr(SolvedStarts, kind)

        def call(self, *given):
            found = function(self, *given)
            seen.append((kind, given[0], found is None))
            return found

        monkeypatch.setattr(SolvedStarts, kind, call)

    watched("fetch")
    watched("keep")
    calls = []
    for again in (False, False, True):
        if again:
            starts.clear()
        seen.clear()
        solve(instance, starts=starts)
        calls.append(list(seen))
    first, second, cleared = calls
    assert cleared == first != second


def test_importing_keeps_nothing():
    code = (
        "from gspcli.solver.starts.solved_starts import STARTS as s; print(sum(s.sizes.values()))"
    )
    run = subprocess.run(
        [sys.executable, "-c", f"import gspcli; gspcli.solve; {code}"],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ,
    )
    assert run.stdout.strip() == "0"
