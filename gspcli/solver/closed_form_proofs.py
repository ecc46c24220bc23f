"""Proofs of the poses of the closed form, for as many sets of values as there are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.many_values import ProvedPoses, ValueProofs
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import quaternion_product
from gspcli.solver.batch import Block
from gspcli.solver.pose_set import PoseSet
from gspcli.solver.proof import CountKind, Proof
from gspcli.solver.study_systems import side_choices

Array = NDArray[np.float64]
Index = NDArray[np.intp]


def prove_closed_forms(
    proofs: ValueProofs,
    arrangement: Arrangement,
    rows: Array,
    found: Sequence[PoseSet | None],
) -> tuple[Index, ProvedPoses] | None:
    """Return what is proved of sets of poses, and which these are.

    Parameters
    ----------
    proofs, arrangement
        The geometry, exactly and in floating point.
    rows
        The sets of values, shape (b, 6).
    found
        The poses of each. Sets that have not as many as the type are left out.
    """
    choices = side_choices(arrangement.with_values(np.ones_like(rows[0])))
    chosen, points = [], []
    for k, (row, poses) in enumerate(zip(rows, found, strict=True)):
        given = arrangement.with_values(row)
        index = None if poses is None else _by_sides(given, choices, poses)
        if poses is None or index is None:
            continue
        pure = np.concatenate((np.zeros((len(poses.T), 1)), poses.T), axis=1)
        e = poses.quaternions
        study = np.concatenate((e, quaternion_product(pure, e) / 2), axis=1)
        chosen.append(k)
        points.append(study[index].astype(np.complex128))
    if not chosen:
        return None
    where = np.array(chosen, np.intp)
    return where, proofs.decide(rows[where], choices, np.stack(points), OWN)


def block_of(poses: ProvedPoses, rows: Index) -> Block:
    """Return some of the sets of poses (by their indices), each as many as the type has."""
    number = poses.R.shape[1]
    return Block(
        quaternions=poses.quaternions[rows],
        R=poses.R[rows],
        T=poses.T[rows],
        real=poses.real[rows],
        account=PathAccount(expected=number, found=number, basis=Basis.COUNT),
        proof=Proof(CountKind.TYPE),
    )


def _by_sides(given: Arrangement, choices: Array, poses: PoseSet) -> Index | None:
    """Return the poses of each choice of sides, shape (k, m); None if distances are zero."""
    if poses.signs is None or any(_is_zero(given)):
        return None
    here = (poses.signs[None] == np.where(given.sided, choices, 1)[:, None]).all(axis=2)
    return np.stack([np.flatnonzero(members) for members in here])


def _is_zero(given: Arrangement) -> list[bool]:
    """Return which distances are zero where that makes another equation."""
    return [
        not value and (kind.has_sides or kind is DLL)
        for kind, value in zip(given.kinds, given.values.tolist(), strict=True)
    ]
