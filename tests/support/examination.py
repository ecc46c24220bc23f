"""What must hold of every answer to a generic platform with a known real pose.

- every path is accounted for and ends at an isolated simple finite pose;
- there are as many different poses as the generic count, no two of them nearer than `SEPARATION`;
- the conjugate of every pose is a pose, and exactly those said to be real are their own conjugates;
- every pose satisfies the constraints as stated;
- the hidden pose is among the real ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import residuals
from gspcli.geometry.quaternions import Field
from gspcli.solver import PoseSet

#: Poses nearer than this, in the chart of `_charted`, count as the same.
SEPARATION = 1e-9
#: How far the conjugate of a pose may be from a pose, and the hidden pose from a real one.
MATCH = 1e-6
#: Largest residual relative to the length, a complex pose's to the square of its size.
RESIDUAL = 1e-8

Array = NDArray[np.float64]
Pose = tuple[Array, Array]


@dataclass(frozen=True)
class Finding:
    """What is found of one answer.

    Attributes
    ----------
    expected, found, real
        The generic count, the distinct poses, and the real ones.
    residual, separation, asymmetry
        The largest residual, the smallest distance of two poses, and the largest distance of a
        conjugate from the nearest pose.
    problems
        What does not hold; empty if all does.
    """

    expected: int
    found: int
    real: int
    residual: float
    separation: float
    asymmetry: float
    problems: tuple[str, ...]

    @classmethod
    def of_entry(cls, entry: Mapping[str, Any]) -> Finding:
        """Return the finding with the given attributes, a list for the tuple."""
        return cls(**{**entry, "problems": tuple(entry["problems"])})


def examine(arrangement: Arrangement, poses: PoseSet, expected: int, hidden: Pose) -> Finding:
    """Return what is found of the answer to a generic platform with a known real pose."""
    R, T, real = poses.R, poses.T, poses.real
    charted = _charted(arrangement, R, T)
    separation = _distances(charted, charted, 2)[:, 1].min(initial=np.inf)
    to_conjugate, conjugate = _nearest(charted.conj(), charted)
    hidden_R, hidden_T = (part[None].astype(complex) for part in hidden)
    to_hidden, nearest = _nearest(_charted(arrangement, hidden_R, hidden_T), charted)
    size = np.maximum(1, np.abs(R).max((1, 2), initial=0)) + np.abs(T).max(1) / arrangement.length
    relative = residuals(arrangement, R, T)
    relative[:, arrangement.distances] /= arrangement.length
    residual = (relative.max(axis=1) / size**2).max(initial=0)
    own = conjugate == np.arange(len(R))
    statements = {
        "lost paths": poses.account.lost > 0,
        "paths on curves": poses.account.on_curves > 0,
        "poses at infinity": poses.account.at_infinity > 0,
        "spurious ends": poses.account.spurious > 0,
        "multiple poses": bool((poses.multiplicity > 1).any()),
        "wrong number": len(R) != expected,
        "equal poses": separation < SEPARATION,
        "conjugate missing": to_conjugate.max(initial=0) > MATCH,
        "reality wrong": bool((own != real).any()),
        "residual": not residual < RESIDUAL,
        "hidden pose missing": not (len(R) and to_hidden[0] < MATCH and real[nearest[0]]),
    }
    return Finding(
        expected,
        len(R),
        int(real.sum()),
        float(residual),
        float(separation),
        float(to_conjugate.max(initial=0)),
        tuple(name for name, wrong in statements.items() if wrong),
    )


def _charted(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return (R, T, 1) scaled to norm 1, so that large poses are compared by relative size."""
    flat = np.concatenate((R.reshape(-1, 9), T / arrangement.length, np.ones((len(R), 1))), axis=1)
    charted: Field = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    return charted


def _distances(points: Field, among: Field, count: int) -> Array:
    return np.asarray(_tree(among).query(_flat(points), count)[0]).reshape(len(points), -1)


def _nearest(points: Field, among: Field) -> tuple[Array, NDArray[np.intp]]:
    distances, index = _tree(among).query(_flat(points))
    return np.asarray(distances), np.asarray(index)


def _tree(points: Field) -> KDTree:
    return KDTree(_flat(points))


def _flat(points: Field) -> Array:
    return np.concatenate((points.real, points.imag), axis=1)
