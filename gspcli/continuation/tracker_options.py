"""Settings of the path tracker, and its presets.

`python -m tools.verify.presets` measures the number of paths that each preset loses for random
platforms; the table is in docs/solver.md.
"""

from __future__ import annotations

from dataclasses import replace

from gspcli.records import dataclass


@dataclass(frozen=True)
class TrackerOptions:
    """Settings of the path tracker."""

    predictor_tolerance: float = 1e-4
    """Aimed length of the first Newton correction; points have norm 1."""
    contraction: float = 0.05
    """Largest accepted ratio of the second to the first Newton correction."""
    arrival: float = 1.0
    """Largest accepted second Newton correction at the target. Solutions that are nearer to each
    other than its square root attract Newton's method all alike from farther away."""
    radius_fraction: float = 0.7
    """Largest step, as a part of the estimated radius of convergence of the Taylor series."""
    min_step: float = 1e-14
    """A step in t below this fails."""
    waypoint: float = 1e-3
    """Distance 1 - t from which the endgame starts for paths that need it; 0 if there is to be
    none."""
    nearest: float = 1e-12
    """Distance 1 - t below which a path that still cannot step to the target needs it. Two
    regular solutions as near as 1e-6 are distinguished only if this is small."""
    max_steps: int = 1000
    """Accepted and rejected steps after which a path fails."""
    late_steps: int = 60
    """Steps beyond the waypoint after which a path needs the endgame."""
    digits: int = 16
    """Digits to compute with: 16, or 32, about 20 times slower. Start systems and start points stay
    doubles, taken as exact; of a target 32 digits may be given."""
    short_series: bool = False
    """Whether the Taylor series have few terms (with 16 digits): quicker where steps are few."""


# All equations, with all their unknowns.

#: The first attempt at paths from a stored start system.
DEFAULT = TrackerOptions()
#: The second attempt, for paths that are lost or have jumped.
CAREFUL = TrackerOptions(
    predictor_tolerance=1e-6, contraction=0.02, radius_fraction=0.4, late_steps=1000
)
#: The last attempt with 16 digits.
PARANOID = TrackerOptions(
    predictor_tolerance=1e-8,
    contraction=0.01,
    radius_fraction=0.2,
    max_steps=10_000,
    late_steps=10_000,
)
#: From a solved system to others of its structure: longer steps and fewer terms. Lost paths are
#: detected and followed again.
SHORT = replace(DEFAULT, predictor_tolerance=3e-3, contraction=0.1, short_series=True)
#: With 32 digits, up to the beginning of the endgame.
EXTENDED = replace(CAREFUL, digits=32)
#: With 32 digits, as near to the target as they allow, for ends that are proved with more digits.
DEEP = replace(EXTENDED, arrival=1e-12, waypoint=0.0, nearest=1e-28, min_step=1e-30, max_steps=150)
# Equations that are solved for some unknowns first (`reduced_homotopy`); lost paths are detected.

#: From a stored start system, or from the start of a geometry to others with complex values.
FROM_START = replace(
    DEFAULT, predictor_tolerance=3e-3, contraction=0.1, min_step=1e-10, max_steps=200
)
#: From a solved platform with complex values to others of its structure.
LONG_STEPS = replace(FROM_START, predictor_tolerance=1e-2, contraction=0.25)
#: From the start of a geometry to real values near it; only values move.
VALUE_STEPS = replace(FROM_START, predictor_tolerance=2e-2, contraction=0.35, radius_fraction=0.8)
#: For paths that `VALUE_STEPS` lose.
SHORT_STEPS = replace(FROM_START, predictor_tolerance=1e-4, contraction=0.05, max_steps=1000)
