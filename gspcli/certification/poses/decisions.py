"""What `gsp solve` asks of each pose: whether it is certified, and whether it is real."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from flint import ctx
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.local_frames import Centring
from gspcli.certification.equations.skew_lines import are_skew
from gspcli.certification.poses.distinct import all_different
from gspcli.certification.poses.floating import prove
from gspcli.certification.poses.pose_proofs import FIRST_PRECISION, certify_equations
from gspcli.defaults import TOLERANCE
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Line

Complex = NDArray[np.complex128]
#: Sine (squared, of complex lines the bilinear one) below which lines are no business of doubles.
_PARALLEL = 1e-4


class Decisions(NamedTuple):
    """Answers for n poses.

    Attributes
    ----------
    certified
        Whether exactly one simple solution is proved to be near, different from those near the
        other certified poses, and proved to be real or not to be; shape (n,).
    real
        Whether it is proved to be real, shape (n,).
    deviation
        Bound of how far a certified pose is off, in any entry of R, and of T by the scale of the
        equations; shape (n,).
    """

    certified: NDArray[np.bool_]
    real: NDArray[np.bool_]
    deviation: NDArray[np.float64]


def decide(instance: Instance, R: ArrayLike, T: ArrayLike) -> Decisions:
    """Certify the poses of an instance, and decide which are real.

    Most poses are proved in floating point, many at a time; the others, and those that are not
    proved different from them, by `certify`. What is proved is the same.

    Parameters
    ----------
    instance, R, T
        As for `certify`.
    """
    rotations = np.asarray(R, dtype=np.complex128).reshape(-1, 3, 3)
    translations = np.asarray(T, dtype=np.complex128).reshape(-1, 3)
    if not Centring.of(instance).is_none:
        return _by_balls(instance, rotations, translations)
    with ctx.workprec(FIRST_PRECISION):
        system = BallSystem(instance, FIRST_PRECISION)
        places = translations / system.scale
        proofs = prove(system, rotations, places)
    entries = np.concatenate((rotations.reshape(-1, 9), places), axis=1)
    tolerance = TOLERANCE * np.maximum(1, np.abs(entries).max(axis=1, initial=0))
    certified = proofs.isolated & (proofs.real | proofs.complex) & (proofs.deviation <= tolerance)
    certified &= are_skew(instance, rotations, proofs.deviation)
    real, deviation = certified & proofs.real, proofs.deviation
    rest = np.flatnonzero(~certified)
    others = certify_equations(instance, rotations[rest], translations[rest]) if len(rest) else ()
    for k, one in zip(rest, others, strict=True):
        decided = one.certified and one.real is not None
        certified[k] = decided and one.same_as is None and not one.unresolved
        real[k], deviation[k] = bool(one.real), one.deviation or 0.0
    if all_different(entries[certified], deviation[certified]):
        return Decisions(certified, certified & real, deviation)
    return _by_balls(instance, rotations, translations)


def _by_balls(instance: Instance, rotations: Complex, translations: Complex) -> Decisions:
    every = certify_equations(instance, rotations, translations)
    single = [c.certified and c.same_as is None and not c.unresolved for c in every]
    certified = np.array(single, bool) & np.array([c.real is not None for c in every], bool)
    real = certified & np.array([bool(c.real) for c in every], bool)
    return Decisions(certified, real, np.array([c.deviation or 0.0 for c in every]))


def nearly_parallel(instance: Instance, R: Complex) -> NDArray[np.bool_]:
    """Return at which poses the lines of which DLL are nearly parallel, shape (n, 6).

    There its equation holds whatever their distance, so that the constraint is to be measured.
    """
    nearly = np.zeros((len(R), len(instance.constraints)), bool)
    for k, constraint in enumerate(instance.constraints):
        line, other = constraint.platform, constraint.base
        if constraint.kind is DLL and isinstance(line, Line) and isinstance(other, Line):
            normal = np.cross(R @ line.unit, other.unit)
            sizes = 1 + np.abs(R).max(axis=(1, 2)) ** 2
            nearly[:, k] = np.abs((normal**2).sum(axis=1)) <= _PARALLEL * sizes
    return nearly
