"""The ends of all paths of one system: re-tracking, endgame, classification.

If all paths end at distinct regular solutions, nothing of this is needed. Otherwise some paths are
tracked again with smaller steps: those that failed, and those that ended at the same regular
solution, because one of them has jumped. Paths that stopped before the target go through the
endgame. If some are still lost, all is repeated along other random paths. The account with the
fewest lost paths counts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.dimension import real_point, sample_motions, split, tangents
from gspcli.continuation.endgame import find_ends
from gspcli.continuation.endpoints import (
    ACCOUNTS,
    AccountOptions,
    Endpoints,
    EndsOnCurve,
    random_start,
)
from gspcli.continuation.ends import (
    SINGULAR_ERROR,
    clusters,
    distances,
    infinite,
    regular_error,
)
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import ComplexArray
from gspcli.continuation.regularity import clearly_simple, simple
from gspcli.continuation.retracked_paths import collided
from gspcli.continuation.start import StartSystem
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import PathResults, PathStatus, track
from gspcli.continuation.tracker_options import CAREFUL, EXTENDED, PARANOID, TrackerOptions
from gspcli.records import dataclass


def classify_endpoints(
    start: StartSystem,
    target: System,
    results: PathResults,
    seed: int,
    jobs: int,
    options: AccountOptions = ACCOUNTS,
) -> Endpoints:
    """Return the ends of all paths to one target, from their first results (1, P)."""
    best = None
    for attempt in range(options.attempts):
        origin = random_start(start, seed, attempt)
        if attempt:
            care = CAREFUL if attempt < options.attempts - 1 else PARANOID
            results = track(origin, target, start.points, options=care, jobs=jobs)
        ends = _Attempt(start, origin, target, results, jobs, options).endpoints(seed)
        if best is not None:
            ends = _completed(ends, best, simple(target, best.points))
        if best is None or ends.doubts < best.doubts:
            best = ends
        if not any(best.doubts):
            break
    assert best is not None
    return best


def _completed(ends: Endpoints, other: Endpoints, regular: NDArray[np.bool_]) -> Endpoints:
    """Add regular solutions from another attempt: one lost path ends at each."""
    lost = ends.account.lost
    if not lost or not len(other.points):
        return ends
    index = [
        i
        for i in np.flatnonzero(regular)
        if other.multiplicity[i] == 1
        and distances(ends.points, other.points[i]).min(initial=1.0) > SINGULAR_ERROR
    ]
    if not index or len(index) > lost:
        return ends
    found = ends.account.found + len(index)
    return replace(
        ends,
        points=np.concatenate([ends.points, other.points[index]]),
        multiplicity=np.concatenate([ends.multiplicity, other.multiplicity[index]]),
        condition=np.concatenate([ends.condition, other.condition[index]]),
        residual=np.concatenate([ends.residual, other.residual[index]]),
        account=replace(ends.account, found=found, lost=lost - len(index)),
    )


@dataclass(frozen=True, eq=False)
class _OnCurve:
    """Paths that ended at one point of a positive-dimensional solution set."""

    members: NDArray[np.intp]
    point: ComplexArray
    tangents: ComplexArray


class _Attempt:
    """The paths from one origin to one target."""

    def __init__(
        self,
        start: StartSystem,
        origin: System,
        target: System,
        results: PathResults,
        jobs: int,
        options: AccountOptions,
    ) -> None:
        self.start = start
        self.origin = origin
        self.target = target
        self.jobs = jobs
        self.options = options
        self.points = results.points[0].copy()
        self.left = results.left[0].copy()
        self.status = results.status[0].copy()
        self.condition = results.condition[0].copy()
        self.residual = results.residual[0].copy()
        self.correction = results.correction[0].copy()
        self.regular = clearly_simple(results)[0]
        self.error = regular_error(self.correction)

    def endpoints(self, seed: int) -> Endpoints:
        for options in (CAREFUL, PARANOID):
            wrong = collided(self.points, self.error, self.regular)
            wrong |= self.status == PathStatus.FAILED
            if wrong.any():
                self._track_again(np.flatnonzero(wrong), options)
        winding = self._find_singular_ends()
        return self._classify(winding, np.random.default_rng([seed, 1 << 16]))

    def _track(
        self, origin: System, target: System, points: ComplexArray, options: TrackerOptions
    ) -> PathResults:
        return track(origin, target, points, options=options, jobs=self.jobs)

    def _track_again(self, index: NDArray[np.intp], options: TrackerOptions) -> None:
        results = self._track(self.origin, self.target, self.start.points[index], options)
        for name in ("points", "left", "status", "condition", "residual", "correction"):
            getattr(self, name)[index] = getattr(results, name)[0]
        self.regular[index] = clearly_simple(results)[0]
        self.error[index] = regular_error(self.correction[index])

    def _find_singular_ends(self) -> NDArray[np.int64]:
        """Store the ends of the paths that are not regular; return their winding numbers.

        Zero marks regular paths, and -1 paths whose end stays unknown. Paths that doubles cannot
        follow are followed with more digits.
        """
        winding = np.where(self.regular, 0, -1)
        for options in (CAREFUL, EXTENDED):
            index = np.flatnonzero(winding < 0)
            if not len(index):
                break
            points = self._waypoints(index, options)
            ends = find_ends(
                self.origin, self.target, points, options.waypoint, options, self.options.endgame
            )
            known = ends.error < self.options.end_error
            # Two solutions are so near to each other that every circle contains the branch point,
            # too: the result of Newton's method is kept.
            nearly = ~known & self._simple(self.status[index], self.points[index])
            self.regular[index[nearly]] = True
            self.points[index[known]] = ends.points[known]
            self.condition[index[known]] = np.inf
            self.error[index[known]] = SINGULAR_ERROR
            winding[index] = np.where(known, ends.winding, np.where(nearly, 0, -1))
            self._recognize_regular(index[known & (ends.winding == 1)], winding)
        return winding

    def _waypoints(self, index: NDArray[np.intp], options: TrackerOptions) -> ComplexArray:
        """Return the points of some paths at which the endgame starts; NaN if not reached."""
        points: ComplexArray = self.points[index]
        away = np.flatnonzero(options.digits > 16 | (self.left[index] != options.waypoint))
        if len(away):
            near = self.origin.towards(self.target, 1 - options.waypoint)
            starts = self.start.points[index[away]]
            results = self._track(self.origin, near, starts, options)
            arrived = results.status[0] == PathStatus.REGULAR
            points[away] = np.where(arrived[:, None], results.points[0], np.nan)
        return points

    def _simple(self, status: NDArray[np.uint8], points: ComplexArray) -> NDArray[np.bool_]:
        """Return which ends of Newton's method are simple solutions of the target."""
        arrived = status == PathStatus.REGULAR
        return np.asarray(arrived & simple(self.target, points))

    def _recognize_regular(self, index: NDArray[np.intp], winding: NDArray[np.int64]) -> None:
        """Treat ends of unbranched paths as regular if Newton's method confirms them."""
        results = self._track(self.target, self.target, self.points[index], PARANOID)
        regular = self._simple(results.status[0], results.points[0])
        chosen = index[regular]
        for name in ("points", "condition", "residual"):
            getattr(self, name)[chosen] = getattr(results, name)[0][regular]
        self.error[chosen] = regular_error(results.correction[0][regular])
        self.regular[chosen] = True
        winding[chosen] = 0

    def _classify(self, winding: NDArray[np.int64], rng: np.random.Generator) -> Endpoints:
        lost = int((winding < 0).sum())
        known = np.flatnonzero(winding >= 0)
        away = infinite(self.points[known], self.error[known])
        finite = known[~away]
        rows, found, suspect = [], list[_OnCurve](), False
        for group in clusters(self.points[finite], self.error[finite]):
            members = finite[group]
            first = members[np.argmin(self.condition[members])]
            if self.regular[first]:
                # One path leads to each solution: all others have jumped.
                lost += len(members) - 1
                rows.append((first, 1))
                continue
            point, along = self._tangents(self.points[first], rng)
            if along.shape[1]:
                found.append(_OnCurve(members, point, along))
                continue
            if len(members) == 2 and self._separated(members):
                rows.extend((i, 1) for i in members)
                continue
            of_cycle = np.bincount(winding[members])
            cycle = np.arange(len(of_cycle))
            suspect |= bool((of_cycle[1:] % cycle[1:]).any())
            rows.append((first, len(members)))
        index = np.array([first for first, _ in rows], dtype=np.intp)
        return Endpoints(
            self.points[index],
            np.array([count for _, count in rows], dtype=np.int64),
            self.condition[index],
            self.target.residuals(self.points[index]),
            PathAccount(
                expected=len(self.points),
                found=sum(count for _, count in rows),
                at_infinity=int(away.sum()),
                on_curves=sum(len(end.members) for end in found),
                lost=lost,
            ),
            suspect,
            self._curves(found),
        )

    def _separated(self, members: NDArray[np.intp]) -> bool:
        """Replace a double end of two paths by two near regular solutions, if there are two."""
        guesses = split(self.target, self.points[members[0]])
        if guesses is None or not np.isfinite(guesses).all():
            return False
        results = self._track(self.target, self.target, guesses, PARANOID)
        error = regular_error(results.correction[0])
        regular = self._simple(results.status[0], results.points[0])
        if not regular.all() or len(clusters(results.points[0], error)) < 2:
            return False
        if distances(results.points[0], self.points[members[0]]).max() > self.options.split:
            return False
        self.points[members] = results.points[0]
        self.condition[members] = results.condition[0]
        return True

    def _tangents(
        self, point: ComplexArray, rng: np.random.Generator
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return a point of the solution set at an end, real if possible, and its tangents."""
        along = tangents(self.target, point, rng)
        candidate = real_point(self.target, point) if along.shape[1] else None
        if candidate is not None:
            real = tangents(self.target, candidate, rng)
            if real.shape[1] and not real.imag.any():
                return candidate, real
        return point, along

    def _curves(self, found: list[_OnCurve]) -> list[EndsOnCurve]:
        if not found:
            return []
        motions = sample_motions(
            self.target,
            np.array([end.point for end in found]),
            np.array([end.tangents[:, 0] for end in found]),
        )
        return [
            EndsOnCurve(
                end.tangents.shape[1],
                self.points[end.members],
                motion,
                not (end.point.imag.any() or end.tangents.imag.any()),
            )
            for end, motion in zip(found, motions, strict=True)
        ]
