"""Table 1: the eight rotations of Example 6.2 with three angles of π/3 (page 76)."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.paper.printed import Difference, Row, differences_from, read_table


def compute() -> list[Row]:
    """Return the eight rotations in exact radicals, derived, in the order of the print."""
    from gspcli.symbolic.examples import example_6_2_rotations

    return [
        {f"r{i + 1}{j + 1}": str(rotation[i, j]) for i in range(3) for j in range(3)}
        for rotation in example_6_2_rotations()
    ]


def printed() -> list[Row]:
    """Return the table as printed."""
    return read_table(1)


def differences() -> Iterator[Difference]:
    """Yield the entries that are printed differently."""
    return differences_from(1, compute())
