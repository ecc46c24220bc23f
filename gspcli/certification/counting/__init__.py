"""Exact counts of solutions by linear algebra modulo a random prime (docs/exact-counts.md)."""

from gspcli.certification.counting.counts import (
    DEFAULT_LIMIT,
    ExactCount,
    NotCountedError,
    SideCount,
    count_exactly,
    count_geometry,
    exact_count,
    geometry_count,
)

__all__ = [
    "DEFAULT_LIMIT",
    "ExactCount",
    "NotCountedError",
    "SideCount",
    "count_exactly",
    "count_geometry",
    "exact_count",
    "geometry_count",
]
