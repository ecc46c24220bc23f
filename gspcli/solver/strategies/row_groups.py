"""Sets of values of one geometry in groups, each of which has one start.

Sets in which other distances are zero may have another equation. Sets that are much larger than the
others have another unit of length and a start of their own. With a common start the paths to the
other sets would be long, and doubles would not separate their ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.starts.start import Start, start_among
from gspcli.solver.strategies.kept_geometry import kept_among

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Fewer sets of values are solved one by one: solving the geometry costs as much as a few of them.
_LEAST = 4
#: Sets of values whose largest distances are within such a factor have one start. Sets up to the
#: extent of the geometry are alike.
_FACTOR = 8
#: From this many times the extent on the rotations are so far from real ones, as the square of
#: that, that doubles prove hardly any pose: each set is solved alone, with more digits.
_FAR = 512


def groups_of(
    problem: Problem, rows: Array, solve: Callable[[Problem], PoseSet]
) -> Iterator[tuple[Index, Problem]]:
    """Yield sets of values that can be solved together: their indices, and their platform.

    Parameters
    ----------
    problem
        The platform; its own values are not used.
    rows
        Sets of values in the units of the instance, shape (b, 6).
    solve
        Returns all poses of a platform.
    """
    sizes = None if problem.has_closed_form else _sizes(problem.arrangement, rows)
    zero = [(row == 0).tobytes() for row in rows] if (rows == 0).any() else [b""] * len(rows)
    groups: dict[tuple[bytes, int], list[int]] = {}
    for k, pattern in enumerate(zero):
        groups.setdefault((pattern, 0 if sizes is None else int(sizes[k])), []).append(k)
    for (_, size), members in groups.items():
        if sizes is not None and (len(members) < _LEAST or _FACTOR**size >= _FAR):
            continue
        group = problem.with_rows(rows[members])
        if group.proofs is None:
            continue
        if sizes is not None:
            group.start = common_start(group, solve)
            if group.start is None or group.start.proof is None:
                continue
            if group.start.found < group.expected:
                group.count_geometry()
        yield np.array(members, np.intp), group


def common_start(problem: Problem, solve: Callable[[Problem], PoseSet]) -> Start | None:
    """Return a start for sets of values of one size; None if none is safe."""
    among = problem.arrangement, problem.values, problem.count_geometry
    return (
        kept_among(problem, solve, begin=False)
        or start_among(*among, problem.seed, problem.jobs, problem.starts)
        or kept_among(problem, solve, begin=True)
    )


def _sizes(arrangement: Arrangement, rows: Array) -> NDArray[np.int64]:
    """Return how large each set of values is: powers of `_FACTOR` times the extent, shape (b,)."""
    largest = np.abs(rows[:, arrangement.distances]).max(axis=1)
    # Of a geometry without extent only multiples of its values have a meaning.
    unit = arrangement.extent or float(np.median(largest)) or 1.0
    powers = np.floor(np.log(np.maximum(largest / unit, 1)) / np.log(_FACTOR))
    return np.asarray(powers, np.int64)
