"""Many sets of values of one geometry: those together that paths from one start suit.

Sets in which other distances are zero may have another equation. Sets that are much larger than the
others are in another unit of length, and have a start of their own: with theirs, the paths to all
others would be long, and doubles would not tell their ends apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.poses.many_values import ProvedPoses, ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver.one_geometry import Geometry, Solved, geometry_among
from gspcli.solver.solved_starts import STARTS, SolvedStarts

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Fewer sets of values are solved one by one: solving the geometry costs as much as a few of them.
_LEAST = 4
#: Sets of values whose largest distances are within such a factor have one start. Sets up to the
#: extent of the geometry are alike.
_FACTOR = 8
#: From so many times the extent on the rotations are so far from real ones, as the square of
#: that, that doubles prove hardly any pose: each set is solved alone, with more digits.
_FAR = 512
#: What says which sets have one start.
_Key = tuple[bytes, int]


def solve_rows(
    arrangement: Arrangement,
    rows: Array,
    *,
    count: Callable[[], ExactCount | None],
    proofs: Callable[[Array], ValueProofs | None],
    seed: int,
    jobs: int = 1,
    starts: SolvedStarts = STARTS,
    kept: Callable[[Array, bool], Geometry | None] = lambda *_: None,
) -> Iterator[tuple[int, Solved | None]]:
    """Yield all poses of one geometry with each of many sets of values, in order.

    Parameters
    ----------
    arrangement
        The geometry and the sides; its own values are not used.
    rows
        Sets of values in the units of the instance, shape (b, 6).
    count
        Returns the exact count of the geometry, with values in general position, for the sides
        asked for; None if it is not known. Called only if the geometry seems to have fewer
        solutions than its type.
    proofs
        Returns the equations of the geometry for sets of values (k, 6); None if the poses cannot be
        certified, and nothing be solved here.
    seed
        Source of the random paths. Another seed gives the same sets of poses.
    jobs
        Threads. The result does not depend on them.
    starts
        What is kept of solved platforms.
    kept
        Returns the geometry with a start for sets of values (k, 6), where a solved platform of it
        has poses far away; and whether one of them is to be solved if none is kept.

    Yields
    ------
    How many sets of values come next, and their poses; None if each needs a solution of its
    own, because the geometry is not worth it (too few sets) or not known well enough.
    """
    zero = [(row == 0).tobytes() for row in rows] if (rows == 0).any() else [b""] * len(rows)
    sizes = _sizes(arrangement, rows)
    groups: dict[_Key, list[int]] = {}
    for k, key in enumerate(zip(zero, sizes.tolist(), strict=True)):
        groups.setdefault(key, []).append(k)
    geometries: dict[_Key, tuple[Geometry, ValueProofs]] = {}
    for key, members in groups.items():
        if len(members) < _LEAST or _FACTOR ** key[1] >= _FAR:
            continue
        equations = proofs(rows[members])
        if equations is None:
            break
        geometry = geometry_of_rows(
            arrangement, rows[members], count=count, seed=seed, jobs=jobs, starts=starts, kept=kept
        )
        if geometry is not None:
            geometries[key] = geometry, equations
    begin = 0
    for pattern, group in groupby(zero):
        end = begin + len(list(group))
        alike = {size: start for (zeros, size), start in geometries.items() if zeros == pattern}
        length = min((geometry.batch for geometry, _ in alike.values()), default=end - begin)
        for first in range(begin, end, length):
            part = slice(first, min(first + length, end))
            yield part.stop - first, _solved(alike, sizes[part], rows[part], jobs)
        begin = end


def geometry_of_rows(
    arrangement: Arrangement,
    rows: Array,
    *,
    count: Callable[[], ExactCount | None],
    seed: int,
    jobs: int = 1,
    starts: SolvedStarts = STARTS,
    kept: Callable[[Array, bool], Geometry | None] = lambda *_: None,
) -> Geometry | None:
    """Return the geometry with a start for alike sets of values; None if none is safe.

    Parameters are those of `solve_rows`.
    """
    return (
        kept(rows, False)
        or geometry_among(arrangement, rows, count, seed, jobs, starts)
        or kept(rows, True)
    )


def _sizes(arrangement: Arrangement, rows: Array) -> NDArray[np.int64]:
    """Return how large each set of values is: powers of `_FACTOR` times the extent, shape (b,)."""
    largest = np.abs(rows[:, arrangement.distances]).max(axis=1)
    # Of a geometry without extent only multiples of its values have a meaning.
    unit = arrangement.extent or float(np.median(largest)) or 1.0
    powers = np.floor(np.log(np.maximum(largest / unit, 1)) / np.log(_FACTOR))
    return np.asarray(powers, np.int64)


def _solved(
    starts: dict[int, tuple[Geometry, ValueProofs]],
    sizes: NDArray[np.int64],
    rows: Array,
    jobs: int,
) -> Solved | None:
    """Return the poses for sets of values of some sizes, from the start of each.

    What has no start, or not one that proves the same as the others do, is left incomplete.
    """
    whole: Solved | None = None
    for size in sorted(set(sizes.tolist())):
        if size not in starts:
            continue
        geometry, equations = starts[size]
        chosen = np.flatnonzero(sizes == size)
        if whole is not None and (geometry.account, geometry.proof) != whole[1:]:
            continue
        solved = geometry.solve(rows[chosen], equations, jobs)
        if len(chosen) == len(rows):
            return solved
        if whole is None:
            blank = (np.zeros((len(rows), *x.shape[1:]), x.dtype) for x in solved.poses)
            whole = solved._replace(poses=ProvedPoses(*blank))
        for part, here in zip(whole.poses, solved.poses, strict=True):
            part[chosen] = here
    return whole
