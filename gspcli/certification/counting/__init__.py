"""Exact counts of solutions by linear algebra modulo a random prime (docs/exact-counts.md)."""

from gspcli.certification.counting.eigenposes import ApproximatePose, poses_by_elimination
from gspcli.certification.counting.exact_counts import (
    DEFAULT_LIMIT,
    ExactCount,
    SideCount,
    count_exactly,
    count_geometry,
    exact_count,
    geometry_count,
)
from gspcli.certification.counting.modular_platform import NotCountedError

__all__ = [
    "DEFAULT_LIMIT",
    "ApproximatePose",
    "ExactCount",
    "NotCountedError",
    "SideCount",
    "count_exactly",
    "count_geometry",
    "exact_count",
    "geometry_count",
    "poses_by_elimination",
]
