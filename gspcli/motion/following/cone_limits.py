"""The parts of a trajectory on which legs keep their cones, proved between the rows, too.

A mode is followed once more, and each proved part is kept: on it the pose is within a radius of a
chord. The quadric of a cone (`gspcli.certification.branches.moving_cones`) is a polynomial along
the chord, plus a bounded change within the radius. If its sign is not proved, the part is halved,
and both halves are proved again. They belong to the same branch: each shares an end with the part,
and there is no other pose near that end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.moving_cones import MovingCones
from gspcli.certification.branches.taylor import MovingQuadrics, MovingSystem
from gspcli.geometry.coordinates import Coordinate
from gspcli.geometry.instance import Instance
from gspcli.motion.following.branch_follower import FollowOptions
from gspcli.motion.following.branch_steps import (
    PROVED,
    SCALED,
    SCALED_EXACTLY,
    BranchSteps,
    Segment,
    corrected,
    newton,
)
from gspcli.motion.following.chord_equations import Parts
from gspcli.motion.following.chords import on_patch, prove
from gspcli.motion.following.part_models import PartModels
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Most halvings of a step between rows in the search for the place at which a cone is violated.
_HALVINGS = 34
#: After this many halvings residuals are computed in balls: doubles are not accurate enough.
_IN_DOUBLES = 16
#: How many parts are tested at a time.
_PIECE = 256
#: Rounding of sums of products, relative to the same expression of moduli, as in `chords`.
_ROUNDING = 2.0**-44
_OUTWARD = 1 + 2.0**-30
#: The change of the ends of chords when they are scaled again.
_AGAIN = 2.0**-48
_ENDS = ("first", "last")


@dataclass(frozen=True)
class Stretch:
    """A part of the path of a mode.

    Attributes
    ----------
    begin, end
        Rows, counted from 0, with fractions.
    states
        For each cone: 1 if it is proved to be kept all along, -1 if it is proved to be violated all
        along, else 0.
    """

    begin: float
    end: float
    states: tuple[int, ...]


class ConeProofs:
    """The cones of an instance along one trajectory.

    Parameters
    ----------
    instance
        The platform with the cones. A value of zero is zero at all rows, as for `MovingSystem`.
    chosen
        The coordinates that move.
    rows
        Values and coordinates, shape (r, 6 + coordinates); distances not negative.
    """

    def __init__(self, instance: Instance, chosen: tuple[Coordinate, ...], rows: Array) -> None:
        self.system = MovingSystem(instance, chosen)
        self.limits = MovingCones(instance, chosen)
        self.rows = rows
        self._models: dict[tuple[MovingSystem, int], PartModels] = {}

    def stretches(self, points: Array) -> list[list[Stretch]]:
        """Return the proved stretches of modes, in order; there may be gaps between them.

        Parameters
        ----------
        points
            Their Study points of norm one at the rows, lengths in units of the scale of the system,
            shape (m, r, 8), NaN from where a mode has ended.
        """
        found: list[list[Stretch]] = [[] for _ in points]
        ends = np.isfinite(points[:, :, 0]).sum(axis=1)
        begun = np.zeros(len(points), np.int64)
        while True:
            # Most begin at the first row; after a failed proof the next one begins at the row after
            # it.
            row = int(
                begun[begun < np.minimum(ends, len(self.rows) - 1)].min(initial=len(self.rows))
            )
            here = np.flatnonzero((begun == row) & (ends > row))
            if row + 1 >= len(self.rows) or not len(here):
                return found
            kept: list[Segment] = []
            follower = BranchSteps(self.system, self.rows[None, row:], FollowOptions(), kept=kept)
            branches = follower.run(np.zeros(len(here), np.int64), points[here, row])
            for one, stretch in self._judged(row, kept):
                found[here[one]].append(stretch)
            begun[here] += np.maximum(branches.reached, 0) + 1

    def _judged(self, row: int, segments: list[Segment]) -> list[tuple[int, Stretch]]:
        """Return branches and states on some segments, counted from a row, by time."""
        self._models.clear()
        found: list[tuple[int, Stretch]] = []
        queue = segments[::-1]
        while queue:
            now = [queue.pop() for _ in range(min(_PIECE, len(queue)))]
            states, hopeless = self._states(row, now)
            again = [
                k
                for k, one in enumerate(now)
                if not (states[k].all() or hopeless[k]) and one.level < _HALVINGS
            ]
            halves: dict[int, list[Segment]] = {}
            for exact in (False, True):
                chosen = [k for k in again if (now[k].level >= _IN_DOUBLES) == exact]
                pairs = self._halved(row, [now[k] for k in chosen], exact=exact)
                halves |= {k: pair for k, pair in zip(chosen, pairs, strict=True) if pair}
            for k, one in enumerate(now):
                if k in halves:
                    queue += halves[k]
                    continue
                size = 2.0**-one.level
                begin = row + one.row + one.part * size
                stretch = Stretch(begin, begin + size, tuple(states[k].tolist()))
                found.append((one.branch, stretch))
        return sorted(found, key=lambda pair: pair[1].begin)

    def _model(self, system: MovingSystem, row: int, one: Segment) -> PartModels:
        """Return the equations between the rows of a segment."""
        key = system, one.row
        if key not in self._models:
            rows = self.rows[row + one.row : row + one.row + 2]
            self._models[key] = PartModels(system, (rows[0], rows[1]))
        return self._models[key]

    def _piece(self, system: MovingSystem, row: int, one: Segment) -> MovingQuadrics | None:
        """Return the equations on a segment, or None if it is too long for them."""
        return self._model(system, row, one).piece(one.part, one.level)

    def _states(self, row: int, segments: list[Segment]) -> tuple[Index, NDArray[np.bool_]]:
        """Return the states of the cones, (n, cones), and whether halving is useless, (n,)."""
        states = np.zeros((len(segments), len(self.limits.cones)), np.int64)
        hopeless = np.zeros(len(segments), bool)
        pieces = [self._piece(self.limits, row, one) for one in segments]
        known = [k for k, piece in enumerate(pieces) if piece is not None]
        if not known:
            return states, hopeless
        parts = Parts.of(self.limits.shapes, [piece for piece in pieces if piece is not None])
        middle, change, wide, least = _enclosed(parts, [segments[k] for k in known])
        states[known] = np.where(middle > wide, 1, np.where(middle < -wide, -1, 0))
        # The uncertainty of the pose does not decrease any more.
        hopeless[known] = ((states[known] != 0) | (change < least)).all(axis=1)
        return states, hopeless

    def _halved(self, row: int, segments: list[Segment], *, exact: bool) -> list[list[Segment]]:
        """Return two halves of each segment, or None if they are not proved.

        Parameters
        ----------
        row
            The row from which the rows of the segments are counted.
        segments
            The segments.
        exact
            Whether residuals are computed in balls.
        """
        found: list[list[Segment]] = [[] for _ in segments]
        halves = [
            [replace(one, part=2 * one.part + k, level=one.level + 1) for one in segments]
            for k in (0, 1)
        ]
        pieces = [[self._piece(self.system, row, one) for one in half] for half in halves]
        good = [k for k in range(len(segments)) if all(half[k] is not None for half in pieces)]
        if not good:
            return found
        parts = [[piece for k in good if (piece := half[k]) is not None] for half in pieces]
        chords = [
            [
                self._model(self.system, row, half[k]).exact(half[k].part, half[k].level)
                for k in good
            ]
            if exact
            else None
            for half in halves
        ]
        first, last = (np.stack([getattr(segments[k], key) for k in good]) for key in _ENDS)
        middle, converged = newton(self.system.shapes, parts[0], (first + last) / 2)
        if chords[0] is not None:
            middle = corrected(self.system.shapes, parts[0], chords[0], middle)
        for which, ends in enumerate(((first, middle), (middle, last))):
            shapes = self.system.shapes
            proofs = prove(Parts.of(shapes, parts[which]), *ends, chords[which])
            for j, k in enumerate(good):
                one = replace(
                    halves[which][k],
                    first=ends[0][j],
                    last=ends[1][j],
                    end=proofs.end[j],
                    radius=proofs.radius[j],
                    alone=proofs.uniqueness[j],
                )
                if converged[j] and proofs.measure[j] < PROVED and _joined(one, segments[k], exact):
                    found[k].append(one)
        return [pair if len(pair) == 2 else [] for pair in found]


def _joined(one: Segment, other: Segment, exact: bool) -> bool:
    """Whether two segments have the same pose at their common end."""
    scaled = SCALED_EXACTLY if exact else SCALED
    return 4 * one.end + scaled < other.alone or 4 * other.end + scaled < one.alone


def _enclosed(parts: Parts, segments: list[Segment]) -> tuple[Array, Array, Array, Array]:
    """Enclose quadrics on segments.

    Returns
    -------
    middle
        Their values in the middle of the chord, shape (n, k).
    change
        Bounds of their change along it.
    wide
        Bounds of their difference from the middle on the branch.
    least
        The part of this bound that halving does not reduce.
    """
    first, last = (np.stack([getattr(one, key) for one in segments]) for key in _ENDS)
    _, z, d = on_patch(first, last)
    quadrics, errors = parts.quadrics[:, :, 0], parts.errors[:, :, 0]
    by_z, by_d = (np.einsum("nkpxy,ny->nkpx", quadrics, w) for w in (z, d))
    count, k, degree, _ = by_z.shape
    gradient = np.zeros((count, k, degree + 1, 8))
    gradient[:, :, :-1] = by_z
    gradient[:, :, 1:] += by_d
    value = np.zeros((count, k, degree + 2))
    value[..., :-1] = np.einsum("nkpx,nx->nkp", gradient, z) / 2
    value[..., 1:] += np.einsum("nkpx,nx->nkp", gradient, d) / 2
    change = np.abs(value[..., 1:]) @ 0.5 ** np.arange(1, degree + 2)
    sizes = np.linalg.norm(quadrics, axis=(3, 4)) @ 0.5 ** np.arange(degree) + errors
    slope = np.linalg.norm(gradient, axis=3) @ 0.5 ** np.arange(degree + 1)
    near, end = (np.array([getattr(one, key) for one in segments]) for key in ("radius", "end"))
    length = (np.linalg.norm(z, axis=1) + np.linalg.norm(d, axis=1) / 2)[:, None]

    def left_out(radius: Array) -> Array:
        r = radius[:, None] + _AGAIN
        tube = (slope + errors * length) * r + sizes * r**2 / 2
        lost = (errors + _ROUNDING * sizes) * (length + r) ** 2
        bound: Array = (tube + lost) * _OUTWARD
        return bound

    wide = (change + left_out(near)) * _OUTWARD
    return value[..., 0], change, wide, left_out(end)
