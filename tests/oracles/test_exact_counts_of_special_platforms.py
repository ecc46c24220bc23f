"""Exact counts against the Gröbner bases recorded for special and nearly special platforms.

Those are of msolve and Singular, from other equations modulo other primes.
"""

from __future__ import annotations

import pytest

from gspcli.certification.counting import NotCountedError, count_exactly
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance
from tests.support.special.platforms import platform, recorded

#: Every fourth, and all with parallel lines.
SAMPLE = [name for k, name in enumerate(recorded()) if k % 4 == 0 or "/parallel" in name]
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


@pytest.mark.parametrize("name", SAMPLE)
def test_counts_are_those_of_other_programs(name: str) -> None:
    assert disagreement(platform(name).instance, recorded()[name]) is None
