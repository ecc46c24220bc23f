"""The counts of all types in summary: by class, and against the bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from statistics import median_low

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.counts import Method, generic_counts, study_bound
from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import CLASSES, GspType, all_types


@dataclass(frozen=True)
class ClassSummary:
    """The generic counts of a class, or of all types.

    Attributes
    ----------
    name
        The class, or ``all``.
    sides
        ``one-sided`` or ``two-sided``.
    types
        How many types.
    smallest, median, largest
        Of their counts.
    of_largest
        A family with the largest count.
    different
        How many different counts there are.
    proved
        How many of them are proved, see `is_proved`.
    """

    name: str
    sides: str
    types: int
    smallest: int
    median: int
    largest: int
    of_largest: str
    different: int
    proved: int


@dataclass(frozen=True)
class BoundSummary:
    """How far a bound is from the generic counts of a class.

    Attributes
    ----------
    bound
        Its name, as in the columns of the catalogue.
    name
        The class, or ``all``.
    types
        How many types it applies to.
    sharp
        For how many of them it is the count.
    median, largest
        Factor by which it exceeds the count.
    of_largest
        A family with the largest factor.
    """

    bound: str
    name: str
    types: int
    sharp: int
    median: Fraction
    largest: Fraction
    of_largest: str


def one_sided(gsp_type: GspType) -> int:
    """Return the one-sided count."""
    return generic_counts(gsp_type).one_sided


def two_sided(gsp_type: GspType) -> int:
    """Return the two-sided count."""
    return generic_counts(gsp_type).two_sided


def one_plane(gsp_type: GspType) -> int:
    """Return the one-sided count with one of the two planes of each DLL, as in Table 3."""
    return int(one_sided(gsp_type) // 2 ** gsp_type.count(DLL))


def is_proved(gsp_type: GspType) -> bool:
    """Return whether so many poses are certified as a proved bound allows at most."""
    counts = generic_counts(gsp_type)
    certified = counts.established in (Method.BOTH, Method.TRACKING)
    bounds = (type_bounds(gsp_type).refined_one_sided.value, study_bound(gsp_type.distances))
    return certified and counts.one_sided == min(bounds)


#: What each bound is a bound of.
BOUNDED: dict[str, Callable[[GspType], int]] = {
    "theorem_5_2": two_sided,
    "theorem_5_3": two_sided,
    "theorem_5_4": one_sided,
    "table_3": one_plane,
    "refined_one_sided": one_sided,
    "refined_two_sided": two_sided,
    "study": one_sided,
}


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
                    sum(map(is_proved, types)),
                )
            )
    return summaries


def bound_summaries() -> list[BoundSummary]:
    """Return how sharp each bound is, in each class that it applies to and in all together."""
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
    if name == "study":
        return study_bound(gsp_type.distances)
    return type_bounds(gsp_type).values()[name]
