"""Exact counts against the Gröbner bases recorded for special and nearly special platforms.

Those are of msolve and Singular, from other equations modulo other primes
(tools/special/counts.py). Of the 800 platforms a sample is counted; all with ``-m slow``.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from gspcli.certification.counting import NotCountedError, count_exactly
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance

EVERY = 12
#: Of angles with nine decimals six primes leave some doubt: there are few to choose from.
FINE = 10**10


def disagreement(instance: Instance, record: dict[str, str]) -> str | None:
    """What differs from the record, if anything does."""
    try:
        count = count_exactly(instance)
    except NotCountedError as error:
        # Angles of ten decimals and more: there are too few primes.
        return None if "roots of unity" in str(error) else str(error)
    if count.finite != (record["finite"] == "yes"):
        return f"finite {count.finite}"
    if not count.finite:
        return None
    found = (
        count.solutions - count.spurious,
        count.distinct - count.spurious_distinct,
        count.spurious,
    )
    expected = tuple(int(record[key] or 0) for key in ("count", "distinct", "spurious"))
    if found != expected:
        return f"{found}, expected {expected}"
    if ModularPlatform(instance, SEED).requirements.order > FINE:
        return None
    return None if max(count.error, count.distinct_error) < 1e-9 else f"error {count.error}"


def compare(load_tool: Callable, chosen: Callable[[int, str], bool]) -> dict[str, str]:
    tool = load_tool("special.platforms")
    records = tool.recorded()
    platforms = [p for k, p in enumerate(tool.platforms()) if p.id in records and chosen(k, p.id)]
    assert len(platforms) > 50
    found = {p.id: disagreement(p.instance, records[p.id]) for p in platforms}
    return {name: text for name, text in found.items() if text is not None}


def test_a_sample_and_all_parallel_lines(load_tool: Callable) -> None:
    assert not compare(load_tool, lambda k, name: k % EVERY == 0 or "/parallel" in name)


@pytest.mark.slow
def test_all(load_tool: Callable) -> None:
    assert not compare(load_tool, lambda k, name: True)
