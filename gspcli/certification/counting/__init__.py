"""Exact counts of solutions by linear algebra modulo a random prime (docs/exact-counts.md)."""

from gspcli.certification.counting.eigenposes import ApproximatePose, poses_by_elimination
from gspcli.certification.counting.exact_counts import (
    ExactCount,
    PartCount,
    SideCount,
    by_points,
    count_exactly,
    count_geometry,
    dimension_exactly,
    exact_count,
    geometry_count,
    with_points_for_lines,
)
from gspcli.certification.counting.modular_platform import NotCountedError

__all__ = [
    "ApproximatePose",
    "ExactCount",
    "NotCountedError",
    "PartCount",
    "SideCount",
    "by_points",
    "count_exactly",
    "count_geometry",
    "dimension_exactly",
    "exact_count",
    "geometry_count",
    "poses_by_elimination",
    "with_points_for_lines",
]
