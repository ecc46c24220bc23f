"""A summary of the counts of all types: by class, and compared with the bounds."""

from __future__ import annotations

import csv
from collections.abc import Callable
from fractions import Fraction
from statistics import median_low
from typing import TYPE_CHECKING, Any

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.counts import FAMILIES_FILE, FOLDER, generic_counts
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import CLASSES, GspType, all_types
from gspcli.records import dataclass
from gspcli.resources import data_path

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class ClassSummary:
    """The generic counts of a class, or of all types."""

    #: The class, or ``all``.
    name: str
    #: ``one-sided`` or ``two-sided``.
    sides: str
    #: The number of types.
    types: int
    #: The extremes and the median of their counts.
    smallest: int
    median: int
    largest: int
    #: A family with the largest count.
    of_largest: str
    #: The number of different counts.
    different: int


@dataclass(frozen=True)
class BoundSummary:
    """A bound compared with the generic counts of a class."""

    #: Its name, as in the columns of the catalogue.
    bound: str
    #: The class, or ``all``.
    name: str
    #: The number of types to which it applies.
    types: int
    #: The number of types for which it equals the count.
    sharp: int
    #: The factor by which it exceeds the count.
    median: Fraction
    largest: Fraction
    #: A family with the largest factor.
    of_largest: str


@dataclass(frozen=True, eq=False)
class CountSummary:
    """The generic counts of all types in summary.

    Attributes
    ----------
    counts
        The counts of each class, and of all types.
    bounds
        The comparison of each bound with them.
    """

    counts: tuple[ClassSummary, ...]
    bounds: tuple[BoundSummary, ...]

    def __repr__(self) -> str:
        return f"<CountSummary of {max(one.types for one in self.counts)} types>"

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each class and way to count sides (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame([vars(one) for one in self.counts])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.atlas-summary/1``."""
        return {
            "schema": "gsp.atlas-summary/1",
            "counts": [dict(vars(one)) for one in self.counts],
            "bounds": [
                {**vars(one), "median": float(one.median), "largest": float(one.largest)}
                for one in self.bounds
            ],
        }


def atlas_summary() -> CountSummary:
    """Summarize the generic counts of all types by class, and compare the bounds with them."""
    return CountSummary(tuple(class_summaries()), tuple(bound_summaries()))


def one_sided(gsp_type: GspType) -> int:
    """Return the one-sided count."""
    return generic_counts(gsp_type).one_sided


def two_sided(gsp_type: GspType) -> int:
    """Return the two-sided count."""
    return generic_counts(gsp_type).two_sided


def one_plane(gsp_type: GspType) -> int:
    """Return the one-sided count with one of the two planes of each DLL, as in Table 3."""
    return int(one_sided(gsp_type) // 2 ** gsp_type.count(DLL))


#: The count that each bound bounds.
BOUNDED: dict[str, Callable[[GspType], int]] = {
    "theorem_5_2": two_sided,
    "theorem_5_3": two_sided,
    "theorem_5_4": one_sided,
    "table_3": one_plane,
    "refined_one_sided": one_sided,
    "refined_two_sided": two_sided,
}


def trace_extremes() -> tuple[float, float]:
    """Return the largest defect of all trace tests and the smallest without one solution."""
    text = data_path(FOLDER, FAMILIES_FILE).read_text(encoding="utf-8")
    rows = [row for row in csv.DictReader(text.splitlines()) if row["trace"]]
    return (
        max(float(row["trace"]) for row in rows),
        min(float(row["trace_without_one"]) for row in rows),
    )


def classes_with_types() -> list[tuple[str, list[GspType]]]:
    """Return the classes, and all of them together last."""
    groups = [(c.id, [t for t in all_types() if t.platform_class == c]) for c in CLASSES]
    return [*groups, ("all", list(all_types()))]


def class_summaries() -> list[ClassSummary]:
    """Return a summary of the counts of each class and of all, one-sided and two-sided."""
    summaries = []
    for name, types in classes_with_types():
        for sides, read in (("one-sided", one_sided), ("two-sided", two_sided)):
            values = [read(t) for t in types]
            summaries.append(
                ClassSummary(
                    name,
                    sides,
                    len(values),
                    min(values),
                    median_low(values),
                    max(values),
                    max(types, key=read).family.id,
                    len(set(values)),
                )
            )
    return summaries


def bound_summaries() -> list[BoundSummary]:
    """Return the comparison of each bound with each class to which it applies, and with all."""
    summaries = []
    for bound, read in BOUNDED.items():
        groups = []
        for name, types in classes_with_types():
            values = [(_bound(bound, t), t) for t in types]
            factors = [(Fraction(b, read(t)), t) for b, t in values if b is not None]
            if factors:
                groups.append((name, factors))
        # A bound of one class needs no total.
        for name, factors in groups if len(groups) > 2 else groups[:1]:
            ratios = [factor for factor, _ in factors]
            summaries.append(
                BoundSummary(
                    bound,
                    name,
                    len(ratios),
                    ratios.count(Fraction(1)),
                    median_low(ratios),
                    max(ratios),
                    max(factors, key=lambda pair: pair[0])[1].family.id,
                )
            )
    return summaries


def _bound(name: str, gsp_type: GspType) -> int | None:
    return type_bounds(gsp_type).values()[name]
