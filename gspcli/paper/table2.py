"""Table 2: the eight positions of P1 in Example 6.8 with the distances 6, 4 and 5 (page 79)."""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.paper.printed import Difference, Row, differences_from, read_table


def compute(r1: int = 6, r2: int = 4, r3: int = 5) -> list[Row]:
    """Return the eight points in exact radicals, derived, in the order of the print.

    The distances are those of equation (17). The print shows what they would be with the
    second and third exchanged: ``compute(6, 5, 4)``.
    """
    from gspcli.symbolic.examples import example_6_8_points

    points = example_6_8_points(r1, r2, r3)
    return [{name: str(x) for name, x in zip("xyz", point, strict=True)} for point in points]


def printed() -> list[Row]:
    """Return the table as printed."""
    return read_table(2)


def differences() -> Iterator[Difference]:
    """Yield the entries that are printed differently."""
    return differences_from(2, compute())
