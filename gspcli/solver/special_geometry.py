"""One platform of a special geometry: followed from a start of its own, which is kept.

Planar bodies, symmetric ones and shared joints are what most platforms have, and leave fewer poses
than the type. Paths from the stored start system would end at infinity; those from a start of the
geometry do not. The start and the geometry's count are kept for the process.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import count
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np

from gspcli.catalogue.kinds import Kind
from gspcli.certification.equations.frames import Frames
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry as Primitive
from gspcli.solver.direct import all_proved, is_reducible
from gspcli.solver.geometry_start import SolvedSystem, Way
from gspcli.solver.one_geometry import geometry_about, solved_system
from gspcli.solver.pose_set import PoseSet, joined
from gspcli.solver.proof import Ground, Proof

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.solver.search import Search

#: Squares of distances, in typical lengths, are about this; what has a sign is about zero.
_SQUARE = 0.5
#: How far the start's values are from real ones.
_SPREAD = 0.5
#: So many counts are kept for the process, those used last.
_KEPT = 64
_UNITS = Units("unit", AngleUnit.DEGREE)

Row = tuple[Kind, Primitive, Primitive, Side]


def proved_by_geometry(
    instance: Instance, proofs: ValueProofs, arrangement: Arrangement, *, seed: int, limit: float
) -> PoseSet | None:
    """Return as many poses as the geometry has, all proved; None if paths do not lead to them.

    The first platform of a geometry is worth a start of its own only if that is quickly found.

    Parameters
    ----------
    instance, proofs, arrangement
        The platform, exactly, as equations, and in floating point.
    seed
        Source of random values and of the random prime of the count.
    limit
        Work that the count may take.
    """
    if not has_kept_count(arrangement):
        return None
    visits = _visits(_rows(instance))
    is_known = next(visits.count) > 0
    length = 2.0 ** ceil(log2(arrangement.length_with(arrangement.values[None])))
    square = [kind.is_distance and not kind.has_sides for kind in arrangement.kinds]
    values = arrangement.values[None]
    geometry = geometry_about(
        arrangement,
        length,
        np.where(square, _SQUARE, 0.0),
        np.full(len(square), _SPREAD),
        count=lambda: kept_count(instance, seed, limit),
        seed=seed,
        # What needs more care costs less without a start.
        ways=(Way.FLAT, Way.SOLVED, Way.QUICK) if is_known else (Way.FLAT,),
        solved=visits.solved_system(length) if is_known else None,
    )
    if geometry is None or geometry.proof is None:
        return None
    points, unit = geometry.quick_ends(values, 1)
    ends = points.reshape(len(geometry.choices), -1, 8)
    poses = all_proved(proofs, arrangement, ends, geometry.frames(unit))
    return poses and replace(poses, account=geometry.account, proof=geometry.proof)


def poses_of_geometry(
    arrangement: Arrangement,
    proofs: ValueProofs | None,
    searches: Sequence[Search],
    count: ExactCount,
) -> PoseSet | None:
    """Return as many poses as the geometry has, all proved; None if they take long to find.

    None also if its count proves nothing: that of the platform may.

    Parameters
    ----------
    arrangement, proofs
        The platform in floating point, and its equations.
    searches
        For each choice of sides, all of which are alike.
    count
        That of the geometry.
    """
    counted = Proof.modulo(Ground.GEOMETRY, count.error)
    if counted is None or not count.solutions or not count.has_lone_lines:
        return None
    most = count.solutions // len(searches)
    ends = [search.pursuit.distinct_simple() for search in searches]
    if proofs and all(len(points) == most for points in ends):
        poses = all_proved(proofs, arrangement, np.stack(ends), Frames.of(arrangement))
        if poses is not None:
            expected = sum(search.pursuit.paths for search in searches)
            account = PathAccount(
                expected=expected,
                found=count.solutions,
                at_infinity=expected - count.solutions,
                basis=Basis.COUNT,
            )
            return replace(poses, account=account, proof=counted)
    from gspcli.solver.search import Effort
    from gspcli.solver.uncounted import without_count

    poses = joined([without_count(search, most, Effort.LITTLE) for search in searches])
    if poses.certified.sum() != count.solutions:
        return None
    return replace(poses, proof=poses.proof_by_type or counted)


def has_kept_count(arrangement: Arrangement) -> bool:
    """Return whether the count of a geometry is worth keeping, and its values are general."""
    return is_reducible(arrangement) and bool(arrangement.values[arrangement.distances].all())


def kept_count(instance: Instance, seed: int, limit: float | None) -> ExactCount | None:
    """Return the count of an instance's geometry, kept for the process; None if it is not known."""
    return _count(_rows(instance), seed, limit)


def _rows(instance: Instance) -> tuple[Row, ...]:
    return tuple((row.kind, row.platform, row.base, row.side) for row in instance.constraints)


class _Visits:
    """How often platforms of a geometry were solved, and the first whose poses were all proved."""

    def __init__(self) -> None:
        self.count = count()
        self.first: tuple[Arrangement, PoseSet] | None = None
        self._systems: dict[float, SolvedSystem] = {}

    def solved_system(self, length: float) -> SolvedSystem | None:
        """Return the first in a unit of length, always the same object."""
        if self.first is not None and length not in self._systems:
            arrangement, poses = self.first
            self._systems[length] = solved_system(arrangement, length, poses)
        return self._systems.get(length)


@lru_cache(maxsize=_KEPT)
def _visits(rows: tuple[Row, ...]) -> _Visits:
    return _Visits()


def keep_solved(instance: Instance, arrangement: Arrangement, poses: PoseSet) -> None:
    """Keep all poses of a platform of a special geometry: its start is made from them."""
    visits = _visits(_rows(instance))
    if visits.first is None:
        visits.first = arrangement, poses


@lru_cache(maxsize=_KEPT)
def _count(rows: tuple[Row, ...], seed: int, limit: float | None) -> ExactCount | None:
    from gspcli.certification.counting import geometry_count

    given = tuple(
        Constraint(kind=kind, platform=platform, base=base, value=Number.of(1), side=side)
        for kind, platform, base, side in rows
    )
    return geometry_count(Instance(given, _UNITS), seed=seed, limit=limit)
