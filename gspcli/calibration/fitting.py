"""Least squares with unknown poses, and where they start.

Poses are measured with errors, so that they are unknowns beside the parameters of the platform. A
pose occurs in its own rows only: a QR factorization of its six columns leaves rows without it.
Their solution is the exact least-squares solution for all unknowns (variable projection of
separable problems; Golub and Pereyra 1973), at the cost of a fit with known poses.

A pose that was measured whole is its own start. Of others with six readings all real poses for the
readings with the stated geometry are found, and the one is taken that agrees best with what was
measured. Rows of less start at the pose of another row, or a mode of the stated values, from which
least squares lead to what they tell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.measurements import Measurements, Noise, WhitenedRows, value_rows
from gspcli.calibration.model import Model
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.least_squares import descend
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import apply, rotation_from_vector, vector_from_rotation
from gspcli.geometry.readings import values_of, without_corrections
from gspcli.records import dataclass
from gspcli.solver import solve, solve_values
from gspcli.solver.poses import PoseSet

Array = NDArray[np.float64]

#: Singular values below this part of the largest are zero: derivatives are exact up to rounding.
_ROUNDING = 1e-9
#: Iterations end where no parameter changes by more than this part of a length, or the sum of
#: squares by this part of itself.
_STEP, _DECREASE = 1e-13, 1e-14
#: Weights of a robust fit are those of the iteration before: its steps shrink by a factor only, so
#: that parameters are a multiple of the last step away. The sum of losses stands still long before.
_ROBUST_STEP = 1e-12
_MOST = 400
#: This many rows have their derivatives in memory at a time.
_BLOCK = 2000
#: Residuals beyond this many standard deviations count by their modulus, not their square.
HUBER = 2.0


class LinearEquations(NamedTuple):
    """The linear equations of one iteration, poses removed."""

    residual: Array
    """All residuals divided by their deviations, NaN where nothing was measured, shape (n, q)."""
    right: Array
    """Those left after the poses, shape (m,)."""
    slopes: Array
    """Their derivatives by the free parameters, shape (m, f)."""
    back: Callable[[Array], Array] | None
    """Gives the twists of the poses, (n, 6), for a step of the parameters; None if poses are exact.
    """


@dataclass(frozen=True, eq=False)
class Fit:
    """The end of a fit."""

    #: With the parameters found.
    model: Model
    #: The poses found, shapes (n, 3, 3) and (n, 3).
    R: Array
    T: Array
    #: The residuals in standard deviations, NaN where nothing was measured, shape (n, q).
    residual: Array
    #: The sum of squares (of a robust fit, of the losses).
    cost: float
    #: Degrees of freedom: numbers measured less poses less parameters.
    freedom: int
    #: Singular values of the derivatives by the free parameters, each divided by its size, and the
    #: directions that belong to them (rows), shapes (f,) and (f, f).
    singular: Array
    directions: Array
    #: Which directions were estimated, shape (f,); the others keep what is stated.
    known: NDArray[np.bool_]
    #: Whether the iterations came to their end.
    converged: bool

    @cached_property
    def covariance(self) -> Array:
        """The covariance of all parameters, shape (p, p): zero for what was not estimated."""
        free = self.model.free
        scaled = self.directions[self.known] * self.model.sizes[free]
        found = np.zeros((len(free), len(free)))
        found[np.ix_(free, free)] = (scaled.T / self.singular[self.known] ** 2) @ scaled
        return found


def fit(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    *,
    huber: float | None = None,
    prior: float = np.inf,
) -> Fit:
    """Estimate the free parameters, and the poses unless they are exact.

    Levenberg and Marquardt's method with scaled steps of least norm: a direction that the data do
    not tell (`known`) is not moved along.

    Parameters
    ----------
    model, R, T
        Where to start.
    seen, noise
        What was measured, and how well.
    huber
        Where residuals begin to count less, in standard deviations (a pseudo-Huber loss); None for
        squares.
    prior
        A direction whose standard deviation would be larger than this length is not estimated: it
        is known better without the data.

    Raises
    ------
    GspError
        If a value has no derivative at a pose.
    """
    damping, free, size = 0.0, model.free, model.sizes[model.free]
    system = _equations(model, R, T, seen, noise, huber)
    cost, converged = _cost(system.residual, huber), False
    for _ in range(_MOST):
        U, s, V = _factors(system.slopes * size, system.right)
        keep = _known(s, prior)
        filtered = np.where(keep, s / (s**2 + (damping * s[0]) ** 2 + ~keep), 0.0)
        scaled = -V.T @ (filtered * U)
        step = np.zeros(len(free))
        step[free] = scaled * size
        moved = model.moved(step)
        places = (R, T) if system.back is None else _moved(R, T, system.back(step[free]))
        with np.errstate(all="ignore"):
            tried = _equations(moved, *places, seen, noise, huber, check=False)
        after = _cost(tried.residual, huber)
        if after <= cost * (1 + 1e-12):
            least = _STEP if huber is None else _ROBUST_STEP
            small = float(np.abs(scaled).max(initial=0)) <= least * model.length
            still = huber is None and damping == 0 and cost - after <= _DECREASE * cost
            converged = small or still
            model, (R, T), system, cost = moved, places, tried, after
            damping = damping / 10 if damping > 1e-9 else 0.0
        elif float(np.abs(scaled).max(initial=0)) <= 1e3 * _STEP * model.length:
            # Rounding alone keeps the sum from falling.
            converged = True
        else:
            damping = max(damping * 10, 1e-6)
        if converged or damping > 1e3:
            break
    _, s, V = _factors(system.slopes * size, system.right)
    known = _known(s, prior)
    rows = np.isfinite(system.residual).sum(axis=1)
    spare = rows if noise.exact else np.maximum(rows - 6, 0)
    freedom = int(spare.sum()) - int(known.sum())
    left = system.residual
    return Fit(model, R, T, left, cost, freedom, s, V, known, converged)


def _equations(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    huber: float | None,
    *,
    check: bool = True,
) -> LinearEquations:
    """Return the equations at poses as `reduced`, for many rows in blocks.

    The equations of a block are replaced by their triangular factor, and the twists are computed
    from the block again: memory does not grow with the derivatives of all rows.
    """
    if len(R) <= _BLOCK:
        return reduced(model, R, T, seen, noise, huber, check=check)
    seen = replace(seen, sorts=seen.measured_sorts)

    def block(rows: slice) -> LinearEquations:
        return reduced(model, R[rows], T[rows], seen.taken(rows), noise, huber, check=check)

    blocks = [slice(k, k + _BLOCK) for k in range(0, len(R), _BLOCK)]
    left, factors = [], []
    for one in map(block, blocks):
        left.append(one.residual)
        factors.append(np.linalg.qr(np.column_stack((one.slopes, one.right)), mode="r"))
    triangles = np.concatenate(factors)

    def back(step: Array) -> Array:
        systems = map(block, blocks)
        return np.concatenate([one.back(step) for one in systems if one.back is not None])

    return LinearEquations(
        np.concatenate(left), triangles[:, -1], triangles[:, :-1], None if noise.exact else back
    )


def reduced(
    model: Model,
    R: Array,
    T: Array,
    seen: Measurements,
    noise: Noise,
    huber: float | None = None,
    *,
    check: bool = True,
) -> LinearEquations:
    """Return the equations at poses, the poses removed."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        r, J, P = seen.rows(model, R, T, noise)
    J = J[..., model.free]
    there = np.isfinite(r)
    if check:
        _check(there & ~(np.isfinite(J).all(axis=-1) & np.isfinite(P).all(axis=-1)), seen)
    left = r
    weight = np.where(there, 1.0, 0.0)
    if huber is not None:
        weight = weight * (1 + (np.where(there, r, 0.0) / huber) ** 2) ** -0.25
    r, J, P = (
        np.where(there.reshape(*there.shape, *[1] * (part.ndim - 2)), part, 0.0)
        for part in (r, J, P)
    )
    r, J, P = r * weight, J * weight[..., None], P * weight[..., None]
    if noise.exact:
        return LinearEquations(left, r.reshape(-1), J.reshape(-1, J.shape[-1]), None)
    Q, U = np.linalg.qr(P * _twist_sizes(model), mode="complete")
    Q = np.swapaxes(Q, 1, 2)
    right, slopes = (Q @ r[..., None])[..., 0], Q @ J
    ends = U[:, :6], right[:, :6], slopes[:, :6]

    def back(step: Array) -> Array:
        return _twists(*ends, step) * _twist_sizes(model)

    return LinearEquations(
        left, right[:, 6:].reshape(-1), slopes[:, 6:].reshape(-1, J.shape[-1]), back
    )


def redundancies(found: Fit, seen: Measurements, noise: Noise) -> Array:
    """Return which part of an error of each number its own residual shows, shape (n, q).

    The diagonal of ``1 - A (A^T A)^-1 A^T`` with the derivatives A by poses and parameters (Baarda
    1968); zero for what was not measured.
    """
    r, J, P = seen.rows(found.model, found.R, found.T, noise)
    there = np.isfinite(r)[..., None]
    J = np.where(there, J, 0.0)[..., found.model.free]
    V = np.eye(r.shape[1])
    if not noise.exact:
        Q = np.linalg.qr(np.where(there, P, 0.0) * _twist_sizes(found.model), mode="complete")[0]
        V = Q[..., 6:] @ np.swapaxes(Q[..., 6:], 1, 2)
    free = found.model.free
    S = V @ J
    shown = np.einsum("...kk->...k", np.broadcast_to(V, (len(r), *V.shape[-2:])))
    shown = shown - np.einsum("nkf,fg,nkg->nk", S, found.covariance[np.ix_(free, free)], S)
    return np.asarray(np.where(there[..., 0], shown, 0.0))


def _check(wrong: NDArray[np.bool_], seen: Measurements) -> None:
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise GspError(
            f"row {seen.lines[row]}: the value of constraint {column + 1} is zero or at its end "
            "there and has no derivative: leave that number blank"
        )


def _twist_sizes(model: Model) -> Array:
    return np.array([1 / model.length] * 3 + [1.0] * 3)


def _factors(slopes: Array, right: Array) -> tuple[Array, Array, Array]:
    """Return ``U^T right``, singular values and directions; of few rows filled up with zeros."""
    full = np.column_stack((slopes, right))
    count = slopes.shape[1]
    if len(full) < count + 1:
        full = np.pad(full, ((0, count + 1 - len(full)), (0, 0)))
    triangle: Array = np.asarray(np.linalg.qr(full, mode="r"))
    U, s, V = np.linalg.svd(triangle[:count, :count])
    right = triangle[:count, count]
    return U.T @ right, s, V


def _known(singular: Array, prior: float) -> NDArray[np.bool_]:
    """Return which directions the data determine better than rounding, and than is known before."""
    floor = _ROUNDING * float(singular.max(initial=0.0))
    return np.asarray((singular > floor) & (singular * prior > 1))


def _twists(U: Array, right: Array, slopes: Array, step: Array) -> Array:
    """Return the twists of poses, scaled, that belong to a step of the free parameters."""
    wanted = -(right + slopes @ step)
    # A pose that its row does not determine moves as little as it can.
    scale = np.abs(U).max(axis=(1, 2), initial=0.0)
    least = np.abs(np.diagonal(U, axis1=1, axis2=2)).min(axis=1)
    whole = least > _ROUNDING * scale
    twist = np.zeros((len(U), 6))
    twist[whole] = np.linalg.solve(U[whole], wanted[whole, :, None])[..., 0]
    if not whole.all():
        inverse = np.linalg.pinv(U[~whole], rcond=_ROUNDING)
        twist[~whole] = (inverse @ wanted[~whole, :, None])[..., 0]
    return twist


def _moved(R: Array, T: Array, twist: Array) -> tuple[Array, Array]:
    """Return poses after twists."""
    return rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]


def _cost(residual: Array, huber: float | None) -> float:
    square = np.nan_to_num(residual, nan=0.0, posinf=np.inf) ** 2
    if huber is None:
        return float(square.sum())
    return float((2 * huber**2 * (np.sqrt(1 + square / huber**2) - 1)).sum())


#: Poses R, T of a row.
Poses = tuple[Array, Array]

#: Rows with fewer numbers start at this many poses of others and take this many steps; in the end
#: they may be off by this part of a typical length.
_STARTS, _STEPS, _AGREES = 8, 30, 0.05


class FitStart(NamedTuple):
    """Where a fit starts: the model, with its frames, and poses, (n, 3, 3) and (n, 3)."""

    model: Model
    R: Array
    T: Array
    home: str = ""
    """Which pose was taken for home and why, in words; empty if none was needed, or it is stated.
    """


def started(instance: Instance, model: Model, seen: Measurements, noise: Noise) -> FitStart:
    """Return the model and the poses to start from.

    With unknown frames the pose of a row is the one nearest to home. If no home is stated all real
    poses for the stated values are tried, and the one is taken whose poses are nearest to those
    measured.

    Raises
    ------
    GspError
        If no pose agrees with a row.
    """
    read = np.asarray(np.isfinite(seen.readings).all(axis=1))
    if seen.drives is not None:
        read &= np.isfinite(seen.drives).all(axis=1)
    R, T = seen.rotations.copy(), seen.positions - apply(seen.rotations, seen.pivot)
    known, start, home = seen.whole & (not model.with_frames), model, ""
    if model.with_frames and not read.any():
        raise GspError("no row has all six readings: with unknown frames some rows must have them")
    rest = read & ~known
    if rest.any():
        some = seen.taken(rest)
        modes = _modes(instance, model, some, noise)
        if model.with_frames:
            first, home = _from_home(instance, model, some, modes, noise)
            R[rest], T[rest], start = first.R, first.T, first.model
        else:
            # The poses that agree best with what was measured.
            same = (some.taken(np.full(len(R), k)) for k, (R, _) in enumerate(modes))
            rows = (there.rows(model, *at, noise) for there, at in zip(same, modes, strict=True))
            R[rest], T[rest] = _least(modes, list(map(_costs, rows)))
    R, T = _with_less(instance, start, seen, R, T, noise, ~known & ~read)
    return FitStart(replace(start, free=model.free), R, T, home)


def _from_home(
    instance: Instance, model: Model, seen: Measurements, modes: list[Poses], noise: Noise
) -> tuple[Fit, str]:
    """Return the fit of frames to the poses of all rows near home, and which home that is."""
    result = solve(instance)
    if result.home is None:
        raise GspError("the stated values have no real pose: state those of a pose of the machine")

    if instance.home is not None:
        places = _nearest(model, modes, result.home.R, result.home.T)
        return fit(_with_frames(model, seen, *places), *places, seen, noise), ""
    tried = []
    for R, T in zip(result.R[result.real].real, result.T[result.real].real, strict=True):
        places = _nearest(model, modes, R, T)
        near = _with_frames(model, seen, *places)
        tried.append((float(_costs(seen.rows(near, *places, noise)).sum()), near, places))
    order = sorted(range(len(tried)), key=lambda k: tried[k][0])
    best = order[0]
    home = f"no home is stated, and mode {best + 1} of {len(tried)} was taken"
    if len(tried) > 1:
        # Before the machine is fitted chi-squared means nothing, but their ratio does.
        ratio = (tried[order[1]][0] / max(tried[best][0], 1e-300)) ** 0.5
        home += f": poses of the next best are {ratio:.2g} times as far from those measured"
    _, near, places = tried[best]
    return fit(near, *places, seen, noise), f"{home}; `home` in SPEC says which is right"


def _with_frames(model: Model, seen: Measurements, R: Array, T: Array) -> Model:
    """Return the model with the frames that poses show, only these free."""
    # With the stated geometry first, so that the frames of base and platform stay where they are.
    free = model.free & (np.arange(len(model.free)) >= model.geometry + 12)
    return replace(model, frames=_frames(model, seen, R, T), free=free)


def _with_less(
    instance: Instance,
    model: Model,
    seen: Measurements,
    R: Array,
    T: Array,
    noise: Noise,
    less: NDArray[np.bool_],
) -> tuple[Array, Array]:
    """Return poses R, T with those filled in of rows that have less than a pose and six readings.

    Raises
    ------
    GspError
        If no pose agrees with a row.
    """
    if not less.any():
        return R, T
    R, T = R.copy(), T.copy()
    if less.all():
        modes = solve(instance)
        starts = modes.R[modes.real].real, modes.T[modes.real].real
    else:
        starts = R[~less], T[~less]
    if not len(starts[0]):
        message = "the stated values have no real pose, and no row has a whole pose or six readings"
        raise GspError(message)
    for k in np.flatnonzero(less).tolist():
        there = seen.taken(np.full(len(starts[0]), k))
        costs = _costs(there.rows(model, *starts, noise))
        nearest = np.argsort(costs)[:_STARTS]
        found = _settled(model, there.taken(nearest), starts[0][nearest], starts[1][nearest], noise)
        costs = _costs(there.taken(nearest).rows(model, *found, noise))
        best = int(costs.argmin())
        # As far off as poses of stated numbers can be, and not only noise.
        if not costs[best] < (_AGREES * model.length / (noise.value or noise.position)) ** 2:
            raise GspError(
                f"row {seen.lines[k]}: no pose near those of other rows agrees with what it has: "
                "leave the row out"
            )
        R[k], T[k] = found[0][best], found[1][best]
    return R, T


def _costs(rows: WhitenedRows) -> Array:
    """Return the sum of squares of each row, infinite where one is not a number."""
    return np.asarray(np.nansum(rows.residual**2, axis=1))


def _settled(
    model: Model, seen: Measurements, R: Array, T: Array, noise: Noise
) -> tuple[Array, Array]:
    """Return the poses of least squares for each row, from poses near them."""
    sizes = np.array([1.0] * 3 + [model.length] * 3)

    def equations(R: Array, T: Array) -> tuple[Array, Array]:
        r, _, P = seen.rows(model, R, T, noise)
        there = np.isfinite(r)
        return np.where(there, r, 0.0), np.where(there[..., None], P, 0.0) * sizes

    def moved(step: Array, R: Array, T: Array) -> tuple[Array, Array]:
        twist = step * sizes
        return rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]

    R, T = descend(equations, moved, (R, T), steps=_STEPS, noise=1.0).point
    return R, T


def _modes(instance: Instance, model: Model, seen: Measurements, noise: Noise) -> list[Poses]:
    """Return for each row the real poses of its readings."""
    found = []
    plain = replace(noise, crank=0.0, slide=0.0, value=noise.value or noise.position)
    for k, poses in enumerate(_solved(instance, model, seen)):
        R, T = poses.R[poses.real].real, poses.T[poses.real].real
        same = seen.taken(np.full(len(R), k))
        apart = np.abs(value_rows(model, R, T, same, plain).residual).max(axis=1, initial=0.0)
        # Readings of distances to planes have a sign.
        right = apart * plain.value < 1e-3 * model.length
        if not right.any():
            raise GspError(
                f"row {seen.lines[k]}: no real pose has these readings with the stated geometry: "
                "measure the whole pose, or leave the row out"
            )
        found.append((R[right], T[right]))
    return found


def _solved(instance: Instance, model: Model, seen: Measurements) -> Iterator[PoseSet]:
    """Yield all poses of each row for its readings, with the drives where they are."""
    units = [1.0 if kind.is_distance else model.in_radians for kind in model.kinds]
    values = values_of(instance, seen.readings / units)
    sided = [row.kind.has_sides for row in instance.constraints]
    values = np.where(sided, np.abs(values), values)
    if seen.drives is None or not model.drives:
        yield from solve_values(_both_sides(instance), values)
        return
    drives = Machine.of(instance)
    q = np.zeros((len(seen), drives.count))
    for one, readings in zip(model.drives, seen.drives.T, strict=True):
        q[:, drives.names.index(one.drive_name)] = one.numbers(readings)
    for numbers, row in zip(q, values.tolist(), strict=True):
        there = _both_sides(drives.instance_at(numbers))
        yield solve(there.with_values(dict(enumerate(map(Number.of, row)))))


def _nearest(model: Model, modes: list[Poses], home_R: Array, home_T: Array) -> tuple[Array, Array]:
    """Return for each row the pose that is nearest to home."""
    apart = [
        np.linalg.norm(R - home_R, axis=(1, 2)) + np.linalg.norm(T - home_T, axis=1) / model.length
        for R, T in modes
    ]
    return _least(modes, apart)


def _least(modes: list[Poses], apart: list[Array]) -> tuple[Array, Array]:
    """Return for each row the pose that is least apart."""
    best = [(R[k], T[k]) for (R, T), k in zip(modes, map(np.argmin, apart), strict=True)]
    return np.array([R for R, _ in best]), np.array([T for _, T in best])


def _both_sides(instance: Instance) -> Instance:
    """Return the platform whose readings are values, on either side of its planes."""
    plain = without_corrections(instance)
    rows = tuple(replace(row, side=Side.BOTH) for row in plain.constraints)
    return replace(plain, constraints=rows)


def _frames(model: Model, seen: Measurements, R: Array, T: Array) -> Array:
    """Return frames of device and target in which poses of the base's frame are those measured."""
    A, B = np.eye(3), np.eye(3)
    turned = np.isfinite(seen.rotations).all(axis=(1, 2))
    if turned.any():
        A, B = _common_turns(R[turned], seen.rotations[turned])
    sights = [(seen.pivot, seen.positions)] if np.isfinite(seen.positions).any() else []
    blocks = {b.name: b.point for b in model.blocks if b.body == "platform" and b.sort == "point"}
    for name, where in seen.points.items():
        at = seen.targets.get(name)
        sights.append((blocks[name] if at is None else at, where))
    frames = np.zeros(12)
    if sights:
        A, frames[3:6], frames[9:] = _places(A, B, R, T, sights, turned=bool(turned.any()))
    frames[:3], frames[6:9] = vector_from_rotation(A), vector_from_rotation(B)
    return frames


def _common_turns(R: Array, seen: Array) -> tuple[Array, Array]:
    """Return rotations A and B with ``A R B = seen`` for all poses, as well as it can be.

    ``A R - seen B^T = 0`` is linear (Zhuang, Roth and Sudhakar 1994 solve it by quaternions).
    """
    rows = []
    for turn, measured in zip(R, seen, strict=True):
        rows.append(np.hstack((np.kron(np.eye(3), turn.T), -np.kron(measured, np.eye(3)))))
    null = np.linalg.svd(np.concatenate(rows))[2][-1].reshape(2, 3, 3)
    if np.linalg.det(null[0]) < 0:
        null = -null
    A, B = (_nearest_rotation(part) for part in null)
    return A, B.T


def _nearest_rotation(matrix: Array) -> Array:
    left, _, right = np.linalg.svd(matrix)
    sign = np.array([1.0, 1.0, np.linalg.det(left @ right)])
    return np.asarray((left * sign) @ right)


def _places(
    A: Array, B: Array, R: Array, T: Array, sights: list[tuple[Array, Array]], *, turned: bool
) -> tuple[Array, Array, Array]:
    """Return A, and the shifts a and b, with ``A (R (B y + b) + T) + a`` as it was seen."""
    rows, right, here, there = [], [], [], []
    for at, seen in sights:
        kept = np.isfinite(seen).all(axis=1)
        here.append((R[kept] @ (B @ at)) + T[kept])
        there.append(seen[kept])
    if not turned:
        p, q = np.concatenate(here), np.concatenate(there)
        A = _nearest_rotation((q - q.mean(axis=0)).T @ (p - p.mean(axis=0)))
    for (_, seen), place, measured in zip(sights, here, there, strict=True):
        turns = A @ R[np.isfinite(seen).all(axis=1)]
        rows.append(np.concatenate((np.broadcast_to(np.eye(3), turns.shape), turns), axis=2))
        right.append(measured - place @ A.T)
    shifts = np.linalg.lstsq(np.concatenate(rows).reshape(-1, 6), np.concatenate(right).ravel())[0]
    found: Array = np.asarray(shifts, float)
    return A, found[:3], found[3:]
