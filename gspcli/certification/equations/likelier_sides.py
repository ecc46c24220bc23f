"""The likelier of two sides of a plane for a pose, by its distances from both equations."""

from __future__ import annotations

from collections.abc import Sequence

#: The nearer side is taken if the two distances differ by this part of their sum.
_CLEAR = 0.9


def likelier(pairs: Sequence[tuple[float, float]], said: int) -> tuple[int, ...]:
    """Return the side whose equation is nearer; both, the likelier first, if it is not clear.

    Parameters
    ----------
    pairs
        The distances from both equations, measured in several ways; the way that separates the
        sides best is used.
    said
        1 or -1 for the likelier side if it is not clear, or 0.
    """
    a, b = max(pairs, key=_contrast)
    order = (0, 1) if a <= b else (1, 0)
    if _contrast((a, b)) > _CLEAR:
        return order[:1]
    return {1: (0, 1), -1: (1, 0)}.get(said, order)


def _contrast(pair: tuple[float, float]) -> float:
    return abs(pair[0] - pair[1]) / (sum(pair) or 1.0)
