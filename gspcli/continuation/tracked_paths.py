"""The paths to one system, tracked with 16 or 32 digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from itertools import groupby, islice

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.endpoints import (
    ACCOUNTS,
    SINGULAR_ERROR,
    AccountOptions,
    SolutionCurve,
    SystemSolutions,
    all_regular,
    clusters,
    distances,
    find_ends,
    infinite,
    random_start,
    regular_ends,
    regular_error,
    simple,
)
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.start import StartSystem, start_system
from gspcli.continuation.systems import EQUATIONS, Coefficients, FineCoefficients, System
from gspcli.continuation.tracker import (
    CAREFUL,
    DEFAULT,
    PathResults,
    PathStatus,
    TrackerOptions,
    track,
)
from gspcli.defaults import SEED
from gspcli.records import dataclass
from gspcli.ties import definite_basis, definite_sign

#: Angles of the random phases. With zero a path between real systems can meet a fold; with larger
#: angles a path is longer and has more steps.
_PHASES = (0.3, 1.0)


@dataclass(frozen=True, eq=False)
class Followed:
    """Solutions of a system, in the order of those of the system from which they were followed."""

    points: ComplexArray
    """Shape (n, 8), scaled to N = e.e = 1."""
    condition: FloatArray
    """Condition number of each (`SystemSolutions.condition`), shape (n,)."""


def follow(
    known: System,
    points: ComplexArray,
    target: System,
    *,
    rng: np.random.Generator,
    options: TrackerOptions = DEFAULT,
    jobs: int = 1,
) -> Followed | None:
    """Follow solutions of one system to another of the same structure, along a complex path.

    The random path decides which solution leads to which. If the points are all solutions of a
    system with the generic number of solutions, they lead to all solutions of the target. Paths
    that end at infinity or at each other are not analysed, unlike in `solve_systems`.

    Parameters
    ----------
    known
        A system; lengths of order one (`Coefficients.balanced`), as those of the target.
    points
        Solutions of it, shape (n, 8), of any norm.
    target
        Another system with its equations in the same order.
    rng
        Source of the path.
    options, jobs
        As for `track`.

    Returns
    -------
    Followed or None
        None unless all paths end at finite regular solutions that are distinct.
    """
    g, h = np.exp(1j * rng.uniform(*_PHASES, size=(2, EQUATIONS)))
    square = np.einsum("ni,ni->n", points.conj(), points).real
    starts = points * (1 / np.sqrt(square))[:, None]
    results = track(
        known.normalized().scaled(g, h), target.normalized(), starts, options=options, jobs=jobs
    )
    if not all_regular(results)[0]:
        return None
    return Followed(_finite(results.points[0]), results.condition[0])


# Ends at infinity give meaningless numbers.
@np.errstate(divide="ignore", invalid="ignore")
def _finite(points: ComplexArray) -> ComplexArray:
    return np.asarray(points / np.sqrt((points[..., :4] ** 2).sum(axis=-1, keepdims=True)))


Array = NDArray[np.bool_]

#: The largest part of the paths that is followed again.
_FEW = 0.02


def collided(points: ComplexArray, error: FloatArray, regular: Array) -> Array:
    """Return which regular ends (P, 8), with errors (P,), another path shares, shape (P,)."""
    together = np.zeros(len(points), dtype=np.bool_)
    index = np.flatnonzero(regular)
    for group in clusters(points[index], error[index]):
        if len(group) > 1:
            together[index[group]] = True
    return together


def retracked(
    origin: System, target: System, points: ComplexArray, first: PathResults, jobs: int
) -> PathResults:
    """Return first results (1, P) after a second attempt at the few wrong paths.

    One of hundreds of paths may fail or jump; with smaller steps it does not. If many paths go
    wrong, the target is special, and the first results are returned.
    """
    error = regular_error(first.correction[0])
    known = first.is_simple[0]
    wrong = collided(first.points[0], error, known)
    # Paths that have failed, and paths at whose end Newton's method has not converged.
    wrong |= ~known & (first.status[0] != PathStatus.SINGULAR)
    if not 0 < wrong.sum() <= max(2, _FEW * len(wrong)):
        return first
    again = track(origin, target, points[wrong], options=CAREFUL, jobs=jobs)
    columns = {}
    for column in fields(first):
        columns[column.name] = part = getattr(first, column.name).copy()
        if len(part):
            part[0, wrong] = getattr(again, column.name)[0]
    return PathResults(**columns)


#: The last attempt with 16 digits.
_TINY_STEPS = TrackerOptions(
    predictor_tolerance=1e-8,
    contraction=0.01,
    radius_fraction=0.2,
    max_steps=10_000,
    late_steps=10_000,
)
#: With 32 digits, up to the beginning of the endgame; and as near to the target as they allow, for
#: ends that are proved with more digits.
_IN_32_DIGITS = replace(CAREFUL, digits=32)
_TO_THE_END = replace(
    _IN_32_DIGITS, arrival=1e-12, waypoint=0.0, nearest=1e-32, min_step=1e-34, max_steps=150
)
#: Below this e.e of a point of norm one is zero up to rounding.
_INFINITE = 1e-14


@dataclass(frozen=True)
class DimensionOptions:
    """Settings of the tests for solution sets of positive dimension."""

    rank: float = 1e-6
    """A singular value of the Jacobian matrix with rows of length 1 below this may be zero. Ends of
    the endgame are known to 1e-8 or so, a small part of which the distance test sorts out."""
    row: float = 1e-8
    """A row shorter than this part of the longest one is rounding, and stays short."""
    distance: float = 0.03
    """How far from a solution, of norm 1, others are sought along the kernel: far enough that an
    isolated solution of moderate multiplicity is left, near enough that a curve is still there."""
    least: float = 0.1
    """Corrected points nearer than this part of the distance have returned to the solution, ..."""
    most: float = 5.0
    """... and those further away than this many distances have gone elsewhere."""
    tries: int = 4
    """Trial directions for each dimension of the kernel, and as many more; a quarter of them must
    arrive."""
    spread: float = 0.15
    """Directions that the arrivals span to less than this part of the main one are its bend."""
    zero: float = 1e-13
    """Length of the values at which a point has been corrected."""
    newton_steps: int = 60
    """Limit of corrections: half the distance each where solutions are multiple."""
    damping: float = 0.01
    """Part of the length of the values that is the damping of Levenberg and Marquardt."""
    difference: float = 1e-4
    """Step of the difference quotient of the Jacobian matrix, linear or quadratic in the point:
    any will do."""
    stride: float = 2.0
    """Length of the steps of a sample motion, in units of the distance; corrected ones may have
    from the least part up to five times that length."""
    finite: float = 1e-6
    """Least N of a real point of norm 1 that is shown to people as a pose."""


DIMENSION = DimensionOptions()


def _scaled_jacobians(
    target: System, points: ComplexArray, options: DimensionOptions
) -> ComplexArray:
    """Return the Jacobian matrices (n, 8, 8) with rows of length 1; the last row is the patch.

    Rows that vanish up to rounding stay small: the gradient of one equation may be zero.
    """
    jacobian = target.jacobians(points)
    rows = jacobian / _row_lengths(jacobian, options)
    return np.concatenate([rows, points.conj()[:, None, :]], axis=1)


def _row_lengths(jacobian: ComplexArray, options: DimensionOptions) -> FloatArray:
    size = np.linalg.norm(jacobian, axis=-1, keepdims=True)
    return np.asarray(np.maximum(size, options.row * size.max(axis=-2, keepdims=True)))


def kernel(
    target: System, point: ComplexArray, options: DimensionOptions = DIMENSION
) -> ComplexArray:
    """Return an orthonormal basis (8, k) of the kernel of the Jacobian matrix at a solution.

    The point itself, which is always in the kernel, is not included.
    """
    rows = _scaled_jacobians(target, point[None], options)[0]
    # A real basis if there is one.
    _, values, basis = np.linalg.svd(rows if rows.imag.any() else rows.real)
    inside = definite_basis(basis[values < options.rank].conj().T)
    return np.asarray(inside, dtype=np.complex128)


def correct(
    target: System, points: ComplexArray, options: DimensionOptions = DIMENSION
) -> tuple[ComplexArray, NDArray[np.bool_]]:
    """Move points (n, 8) of norm 1 to near solutions, singular ones included.

    The Levenberg-Marquardt method with damping proportional to the residual, which converges
    quadratically to solution sets of any dimension if they are smooth and reduced, and linearly
    if they are multiple. Real points stay real if the system is.

    Returns
    -------
    points, converged
        Shapes (n, 8) and (n,).
    """
    points = points.copy()
    values = target.values(points)
    for _ in range(options.newton_steps):
        size = np.linalg.norm(values, axis=1)
        active = np.flatnonzero((size >= options.zero) & np.isfinite(size))
        if not len(active):
            break
        jacobian = target.jacobians(points[active])
        adjoint = jacobian.conj().swapaxes(1, 2)
        damping = options.damping * np.maximum(size[active], options.zero)
        damped = jacobian @ adjoint + damping[:, None, None] * np.eye(7)
        steps = adjoint @ np.linalg.solve(damped, values[active, :, None])
        moved = points[active] - steps[..., 0]
        points[active] = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        values[active] = target.values(points[active])
    return points, np.linalg.norm(values, axis=1) < options.zero


def split(
    target: System, point: ComplexArray, options: DimensionOptions = DIMENSION
) -> ComplexArray | None:
    """Return first guesses (2, 8) of two solutions that rounding has merged to a double one.

    Along the kernel v of the Jacobian matrix the equations are ``u.F(z) + s^2 u.F''(v, v) / 2``,
    u from the left kernel. If z lies between two solutions, they are ``z + s v`` and ``z - s v``.
    The result is None if the dimension of the kernel is not one.
    """
    basis = kernel(target, point, options)
    if basis.shape[1] != 1:
        return None
    v = basis[:, 0]
    jacobian = target.jacobians(point[None])[0]
    size = _row_lengths(jacobian, options)
    u = np.linalg.svd(jacobian / size)[0][:, -1].conj() / size[:, 0]
    step = options.difference
    ahead, behind = target.jacobians(np.array([point + step * v, point - step * v]))
    bend = u @ (ahead - behind) @ v / (2 * step)
    if not abs(bend) > 0:
        return None
    s = np.sqrt(-2 * (u @ target.values(point[None])[0]) / bend)
    return np.array([point + s * v, point - s * v])


def tangents(
    target: System,
    point: ComplexArray,
    rng: np.random.Generator,
    options: DimensionOptions = DIMENSION,
) -> ComplexArray:
    """Estimate the tangent directions of the solution set at a solution.

    Points at a small distance in random directions of the kernel are moved to nearby solutions.
    At an isolated solution they return to it or do not converge. On a solution set of dimension d
    they arrive at points whose differences span d directions. This is evidence and no proof.

    Returns
    -------
    ndarray
        An orthonormal basis, shape (8, d), with d = 0 for an isolated solution. Real if the
        point and the system are.
    """
    basis = kernel(target, point, options)
    count = options.tries * (basis.shape[1] + 1)
    weights = rng.standard_normal((count, basis.shape[1])).astype(np.complex128)
    if basis.imag.any():
        weights += 1j * rng.standard_normal(weights.shape)
    directions = weights @ basis.T
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-300)
    moved, converged = correct(target, point + options.distance * directions, options)
    shifts = moved / (moved @ point.conj())[:, None] - point
    distance = np.linalg.norm(shifts, axis=1)
    relative = distance / options.distance
    near = converged & (relative > options.least) & (relative < options.most)
    # All of a solution set is singular; another isolated solution in general is not.
    for i in np.flatnonzero(near):
        near[i] = kernel(target, moved[i], options).shape[1] > 0
    if not basis.shape[1] or near.sum() < count // options.tries:
        return np.zeros((8, 0), dtype=np.complex128)
    shifts = shifts[near] / distance[near, None]
    _, values, spanned = np.linalg.svd(shifts if shifts.imag.any() else shifts.real)
    dimension = int((values > options.spread * values[0]).sum())
    along = definite_sign(spanned[:dimension].conj())
    return np.asarray(along.T, dtype=np.complex128)


def _in_kernel(
    target: System, points: ComplexArray, vectors: ComplexArray, options: DimensionOptions
) -> ComplexArray:
    """Project vectors (n, 8) to the kernels of `kernel` at points (n, 8)."""
    _, values, basis = np.linalg.svd(_scaled_jacobians(target, points, options))
    inside = np.where(values < options.rank, (basis @ vectors[..., None])[..., 0], 0.0)
    return np.asarray((basis.conj().swapaxes(1, 2) @ inside[..., None])[..., 0])


def sample_motions(
    target: System, points: ComplexArray, directions: ComplexArray, steps: int = 24
) -> list[ComplexArray]:
    """Return consecutive solutions along positive-dimensional solution sets.

    Parameters
    ----------
    points
        Solutions on them, shape (n, 8).
    directions
        A tangent (`tangents`) at each point, shape (n, 8).

    Returns
    -------
    list of ndarray
        A motion from each point, shape (at most steps + 1, 8), norm 1; real if the point and the
        direction are. It ends before infinity.
    """
    real = np.asarray(~(points.imag.any(axis=1) | directions.imag.any(axis=1)))
    motions = [[point] for point in points]
    moving = np.arange(len(points))
    while len(moving) and len(motions[moving[0]]) <= steps:
        now = np.array([motions[i][-1] for i in moving])
        tangent = _in_kernel(target, now, directions, DIMENSION)
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        trial = now + DIMENSION.stride * DIMENSION.distance * tangent / np.maximum(length, 1e-300)
        trial[real] = trial[real].real
        trial /= np.linalg.norm(trial, axis=1, keepdims=True)
        moved, converged = correct(target, trial, DIMENSION)
        inner = (now.conj() * moved).sum(axis=1, keepdims=True)
        moved *= np.where(real[:, None], 1.0, np.exp(-1j * np.angle(inner)))
        directions = moved - now
        size = np.linalg.norm(directions, axis=1)
        relative = size / DIMENSION.distance
        most = DIMENSION.most * DIMENSION.stride
        going = converged & (relative > DIMENSION.least) & (relative < most)
        # A motion ends at infinity, where e.e is zero and the points are no poses.
        going &= np.abs((moved[:, :4] ** 2).sum(axis=1)) > _INFINITE
        moving, real, directions = moving[going], real[going], directions[going]
        for i, point in zip(moving, moved[going], strict=True):
            motions[i].append(point)
    return [np.array(motion) for motion in motions]


def real_point(target: System, point: ComplexArray) -> ComplexArray | None:
    """Search for a real finite solution near a complex one.

    Returns
    -------
    ndarray or None
        Shape (8,), norm 1, zero imaginary parts; None if the system is not real or none was
        found.
    """
    if not target.is_real:
        return None
    # The phase with the smallest imaginary part.
    phase = np.exp(-0.5j * np.angle((point**2).sum()))
    candidate = (phase * point).real.astype(np.complex128)
    moved, converged = correct(target, candidate[None] / np.linalg.norm(candidate), DIMENSION)
    finite = (moved[0, :4] ** 2).sum().real > DIMENSION.finite
    return moved[0] if converged[0] and finite else None


def classify_endpoints(
    start: StartSystem,
    target: System,
    results: PathResults,
    seed: int,
    jobs: int,
    options: AccountOptions = ACCOUNTS,
) -> SystemSolutions:
    """Return the ends of all paths to one target, from their first results (1, P)."""
    best = None
    for attempt in range(options.attempts):
        origin = random_start(start, seed, attempt)
        if attempt:
            care = CAREFUL if attempt < options.attempts - 1 else _TINY_STEPS
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


def _completed(
    ends: SystemSolutions, other: SystemSolutions, regular: NDArray[np.bool_]
) -> SystemSolutions:
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
        self.correction = results.correction[0].copy()
        self.regular = results.is_simple[0]
        self.error = regular_error(self.correction)

    def endpoints(self, seed: int) -> SystemSolutions:
        for options in (CAREFUL, _TINY_STEPS):
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
        for name in ("points", "left", "status", "condition", "correction"):
            getattr(self, name)[index] = getattr(results, name)[0]
        self.regular[index] = results.is_simple[0]
        self.error[index] = regular_error(self.correction[index])

    def _find_singular_ends(self) -> NDArray[np.int64]:
        """Store the ends of the paths that are not regular; return their winding numbers.

        Zero marks regular paths, and -1 paths whose end stays unknown. Paths that doubles cannot
        follow are followed with more digits.
        """
        winding = np.where(self.regular, 0, -1)
        for options in (CAREFUL, _IN_32_DIGITS):
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
        results = self._track(self.target, self.target, self.points[index], _TINY_STEPS)
        regular = self._simple(results.status[0], results.points[0])
        chosen = index[regular]
        for name in ("points", "condition"):
            getattr(self, name)[chosen] = getattr(results, name)[0][regular]
        self.error[chosen] = regular_error(results.correction[0][regular])
        self.regular[chosen] = True
        winding[chosen] = 0

    def _classify(self, winding: NDArray[np.int64], rng: np.random.Generator) -> SystemSolutions:
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
        return SystemSolutions(
            self.points[index],
            np.array([count for _, count in rows], dtype=np.int64),
            self.condition[index],
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
        results = self._track(self.target, self.target, guesses, _TINY_STEPS)
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

    def _curves(self, found: list[_OnCurve]) -> tuple[SolutionCurve, ...]:
        if not found:
            return ()
        motions = sample_motions(
            self.target,
            np.array([end.point for end in found]),
            np.array([end.tangents[:, 0] for end in found]),
        )
        return tuple(
            SolutionCurve(
                end.tangents.shape[1],
                self.points[end.members],
                motion,
                not (end.point.imag.any() or end.tangents.imag.any()),
            )
            for end, motion in zip(found, motions, strict=True)
        )


#: Distances from the target below which doubles may not distinguish paths.
_NEAR = 1e-3
#: Steps from near the target within which most paths arrive that do not end at infinity.
_FEW_STEPS = 12
_BATCH = 256
_BATCH_PATHS = 65_536


class TrackedPaths:
    """The paths from the start system of a structure to one target.

    Parameters
    ----------
    start
        The start system.
    target
        The equations in canonical order, balanced.
    scale
        The unit of f in them (`Coefficients.balanced`).
    sizes
        The divisors of their factors, shape (6,) each.
    results
        The first attempt at all paths, (1, P).
    is_regular
        Whether all of them end at distinct finite regular solutions, by doubles.
    seed, jobs
        Source of random paths; threads.
    """

    def __init__(
        self,
        start: StartSystem,
        target: System,
        scale: float,
        sizes: tuple[FloatArray, FloatArray],
        results: PathResults,
        is_regular: bool,
        seed: int,
        jobs: int,
    ) -> None:
        self.is_regular = is_regular
        self.scale = scale
        self._sizes = sizes
        self.seed = seed
        self._start = start
        self._target = target
        self._results = results
        self._jobs = jobs

    @property
    def count(self) -> int:
        """The number of paths: the generic count of the structure."""
        return len(self._start.points)

    def first(self) -> PathResults:
        """Return the ends (1, P) of the first attempt at all paths, in the target's coordinates."""
        return self._ends(self._results)

    def distinct_simple(self) -> ComplexArray:
        """Return the ends of the first attempt that no other path shares, shape (k, 8).

        They are finite and clearly simple solutions of the system in doubles.
        """
        results = self._results
        points, error = results.points[0], regular_error(results.correction[0])
        chosen = results.is_simple[0] & ~infinite(points, error)
        chosen &= ~collided(points, error, chosen)
        ends: ComplexArray = self.first().points[0, chosen]
        return ends

    def balanced(self, given: Coefficients) -> Coefficients:
        """Return equations with more digits in the form in which they are tracked.

        Parameters
        ----------
        given
            The coefficients in canonical order: arrays of objects, no leading axes.
        """
        return given.in_units(np.array(self.scale)).divided(*self._sizes)

    def track(
        self, index: NDArray[np.intp], target: FineCoefficients, *, attempt: int = 0
    ) -> Iterator[tuple[NDArray[np.intp], PathResults]]:
        """Track some paths with more digits up to the target, from where fewer digits may fail.

        Parameters
        ----------
        index
            Which paths, shape (k,).
        target
            The equations (`balanced`).
        attempt
            Another number gives other paths from the same start points.

        Yields
        ------
        The paths that arrive after few steps, and their ends; then the other paths, arrived or not,
        and their ends. Most paths to infinity never arrive.
        """
        origin = random_start(self._start, self.seed, attempt)
        points, left = self._near(origin, target, index)
        yield from self._in_parts(origin, target, points, None, left, _TO_THE_END)

    def _in_parts(
        self,
        origin: System,
        target: FineCoefficients,
        points: ComplexArray,
        low: ComplexArray | None,
        left: FloatArray,
        options: TrackerOptions,
    ) -> Iterator[tuple[NDArray[np.intp], PathResults]]:
        """Yield the paths that arrive after few steps, and their ends, then the other paths.

        Parameters
        ----------
        origin, points, low, left, options
            As for `track`.
        target
            The equations (`balanced`).
        """
        rest, limit = np.arange(len(points)), _FEW_STEPS
        while True:
            results = track(
                origin,
                target.high,
                points,
                more=target.more,
                low=low,
                left=left,
                options=replace(options, max_steps=min(limit, options.max_steps)),
                jobs=self._jobs,
            )
            ends = self._ends(results)
            arrived = results.status[0] == PathStatus.REGULAR
            if limit >= options.max_steps or arrived.all():
                yield rest, ends
                return
            yield rest[arrived], ends.take(arrived)
            # The others continue from where they stopped.
            rest, limit = rest[~arrived], options.max_steps
            points, low, left = (
                x[0, ~arrived] for x in (results.points, results.low, results.left)
            )

    def _near(
        self, origin: System, target: FineCoefficients, index: NDArray[np.intp]
    ) -> tuple[ComplexArray, FloatArray]:
        """Return the last points of some paths that doubles can reach, and the rest of the way."""
        near = System(origin.structure, target.nearby(origin.coefficients, _NEAR))
        points = self._start.points[index]
        results = track(origin, near, points, options=CAREFUL, jobs=self._jobs)
        arrived = results.status[0] == PathStatus.REGULAR
        there = np.where(arrived[:, None], results.points[0], points)
        return there, np.where(arrived, _NEAR, 1.0)

    def solutions(self, options: AccountOptions = ACCOUNTS) -> SystemSolutions:
        """Return the ends of all paths by numerical path tracking only."""
        if self.is_regular:
            ends = regular_ends(self._results, 0)
        else:
            ends = classify_endpoints(
                self._start, self._target, self._results, self.seed, self._jobs, options
            )
        return ends.scaled_to_one(self.scale)

    def _ends(self, results: PathResults) -> PathResults:
        """Return ends in the coordinates of the system."""
        points, low = results.points.copy(), results.low.copy()
        for part in (points, low):
            part[..., 4:] *= self.scale
        return replace(results, points=points, low=low)


def solve_systems(targets: Iterable[System], *, seed: int = SEED) -> Iterator[SystemSolutions]:
    """Yield the solutions of many systems, in order, as they become known.

    Each result has all isolated solutions, and evidence of any others. Consecutive systems of one
    structure are tracked together, which is quicker than a loop. Lost paths are tracked again with
    smaller steps. Another seed gives the same solutions.
    """
    for tracked_paths in track_all(targets, seed=seed):
        yield tracked_paths.solutions()


def track_all(
    targets: Iterable[System], *, seed: int, jobs: int = 1, options: TrackerOptions = DEFAULT
) -> Iterator[TrackedPaths]:
    """Yield the first attempt at the paths of many systems, in order.

    Consecutive systems of one structure are tracked together, which is quicker than a loop.

    Parameters
    ----------
    targets
        The systems; real ones have solutions in conjugate pairs.
    seed
        Source of the random paths. Another seed gives the same solutions.
    jobs
        Threads. The result does not depend on them.
    options
        Settings of the first attempt.
    """
    for structure, group in groupby(targets, key=lambda target: target.structure):
        start = start_system(structure.canonical())
        size = max(1, min(_BATCH, _BATCH_PATHS // len(start.points)))
        while batch := list(islice(group, size)):
            given = Coefficients.stacked([target.canonical() for target in batch])
            balanced, scale = given.balanced()
            sizes = given.in_units(scale).sizes()
            origin = random_start(start, seed, 0)
            attempts = first_attempts(origin, balanced, start.points, options=options, jobs=jobs)
            for i, (row, regular) in enumerate(attempts):
                target = System(start.system.structure, balanced.take(i))
                divisors = sizes[0][i], sizes[1][i]
                yield TrackedPaths(
                    start, target, float(scale[i]), divisors, row, regular, seed, jobs
                )


def first_attempts(
    origin: System,
    targets: Coefficients,
    points: ComplexArray,
    *,
    options: TrackerOptions,
    jobs: int,
) -> Iterator[tuple[PathResults, bool]]:
    """Yield the ends of paths from the solutions of a system to each of B targets.

    Parameters
    ----------
    origin, targets, points, options, jobs
        As for `track`.

    Yields
    ------
    The ends (1, P), after a second attempt at the few wrong paths, and whether all are
    distinct finite regular solutions, by doubles.
    """
    results = track(origin, targets, points, options=options, jobs=jobs)
    for i, regular in enumerate(all_regular(results).tolist()):
        row = PathResults(*(getattr(results, f.name)[i : i + 1] for f in fields(results)))
        if not regular:
            row = retracked(origin, System(origin.structure, targets.take(i)), points, row, jobs)
            regular = bool(all_regular(row)[0])
        yield row, regular
