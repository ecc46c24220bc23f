"""One platform of a special geometry: followed from a start of its own, which is kept.

Planar bodies, symmetric ones and shared joints are what most platforms have, and leave fewer poses
than the type. Paths from the stored start system would end at infinity; those from a start of the
geometry do not. The start and the geometry's count are kept for the process.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil, log2
from typing import TYPE_CHECKING

import numpy as np

from gspcli.catalogue.kinds import Kind
from gspcli.certification.many_values import ValueProofs
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry as Primitive
from gspcli.solver.direct import all_proved, is_reducible
from gspcli.solver.geometry_start import Way
from gspcli.solver.one_geometry import geometry_about
from gspcli.solver.pose_set import PoseSet

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount

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

    Parameters
    ----------
    instance, proofs, arrangement
        The platform, exactly, as equations, and in floating point.
    seed
        Source of random values and of the random prime of the count.
    limit
        Work that the count may take.
    """
    if not is_reducible(arrangement) or not arrangement.values[arrangement.distances].all():
        return None
    square = [kind.is_distance and not kind.has_sides for kind in arrangement.kinds]
    values = arrangement.values[None]
    geometry = geometry_about(
        arrangement,
        2.0 ** ceil(log2(arrangement.length_with(values))),
        np.where(square, _SQUARE, 0.0),
        np.full(len(square), _SPREAD),
        count=lambda: kept_count(instance, seed, limit),
        seed=seed,
        # What needs more care costs less without a start.
        ways=(Way.FLAT, Way.QUICK),
    )
    if geometry is None or geometry.proof is None:
        return None
    points, unit = geometry.quick_ends(values, 1)
    ends = points.reshape(len(geometry.choices), -1, 8)
    poses = all_proved(proofs, arrangement, ends, geometry.frames(unit))
    return poses and replace(poses, account=geometry.account, proof=geometry.proof)


def kept_count(instance: Instance, seed: int, limit: float) -> ExactCount | None:
    """Return the count of an instance's geometry, kept for the process; None if it is not known."""
    rows = tuple((row.kind, row.platform, row.base, row.side) for row in instance.constraints)
    return _count(rows, seed, limit)


@lru_cache(maxsize=_KEPT)
def _count(rows: tuple[Row, ...], seed: int, limit: float) -> ExactCount | None:
    from gspcli.certification.counting import geometry_count

    given = tuple(
        Constraint(kind=kind, platform=platform, base=base, value=Number.of(1), side=side)
        for kind, platform, base, side in rows
    )
    return geometry_count(Instance(given, _UNITS), seed=seed, limit=limit)
