"""Poses far away from those of a solved platform with the same geometry and other values.

Poses 1e10 lengths away and more hardly depend on the values: Newton's method in balls leads from
those of one platform to those of another. Where a start of the geometry is kept, that is done in
the kernel (`kept_geometry`); for distances of two lines there is none.
"""

from __future__ import annotations

from collections.abc import Iterator

from gspcli.certification.poses.locator import Located
from gspcli.solver.results.pose_set import are_far
from gspcli.solver.side_poses import SidePoses

#: Bits in which poses are sought, half of those of the first elimination.
_BITS = 352
#: After this many poses of which none is near for these values the others are not tried.
_FAILURES = 2


def from_known_poses(side: SidePoses) -> Iterator[None]:
    """Locate poses near those of a solved platform that are far away."""
    problem = side.problem
    known = problem.starts.platform(problem.arrangement)
    if known is None or not known.has_geometry_of(problem.instance):
        return
    poses, done, failures = known.poses, set(), 0
    far = are_far(poses.R, poses.T, known.arrangement.length)
    if poses.signs is not None:
        far &= (poses.signs == problem.choices[side.k]).all(axis=1)
    for T in poses.T[far]:
        point = known.points.get(T.tobytes())
        if point is None or T.tobytes() in done:
            continue
        # Conjugates are added with a pose.
        done |= {T.tobytes(), (T.conj() + 0.0).tobytes()}
        located = side.locator.locate_exactly(point, side.sides, _BITS)
        if isinstance(located, Located):
            side.found.add([located])
            side.found.add_conjugates()
            yield
            continue
        failures += 1
        if failures == _FAILURES:
            return
    side.found.add_close_conjugates()
    yield
