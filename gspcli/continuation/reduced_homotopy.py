"""A homotopy with fewer unknowns for quadrics of which only the multiples of N move.

Without products and without mutual moments of lines each equation is linear in the monomials of e,
in the six coordinates of ``w = e ^ f``, in ``h = f.f`` and in N times the value. Quantities that
linear algebra eliminates need not be followed (native/reduced_homotopy.hpp).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.start import StartSystem
from gspcli.continuation.tracker import QUICK, PathStatus, TrackerOptions, helpful
from gspcli.records import dataclass

#: Where lost paths are noticed at once, and few unknowns make jumps rare.
LONG_STEPS = replace(QUICK, predictor_tolerance=1e-2, contraction=0.25)
#: Quadrics are nearly dependent if a combination is smaller than this part of the largest. They are
#: dependent, up to rounding, below the other one.
_NEARLY, _DEPENDENT = 1e-2, 1e-13
#: How far values of a start are from others: this part of what the equations are, or of what the
#: values are in a combination.
_SPREAD, _OF_VALUES = 0.5, 0.25
#: Places of the squares of e, and of ``e.f``.
_SQUARES, _PRODUCTS = [0, 4, 7, 9], [10, 15, 20, 25]


class Balance(NamedTuple):
    """Combinations of six quadrics, each of which has a value times N on the other side.

    Two similar plates with the same order of joints make the six legs of a hexapod dependent: a
    combination of the rounded quadrics is of size eps, and the poses depend on the same combination
    of the values over eps. Divided by eps this equation is like the others.
    """

    #: The multiple of N in each quadric, shape (6,).
    constants: FloatArray
    #: What makes quadrics without them orthonormal, shape (6, 6).
    combinations: FloatArray
    #: Orthonormal combinations of the quadrics, in columns, and their sizes as parts of the
    #: largest, shapes (6, 6) and (6,).
    directions: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, quadrics: FloatArray) -> Balance | None:
        """Return that of quadrics (6, 27); None if they are not nearly dependent, or dependent."""
        constants = quadrics[:, _SQUARES].mean(axis=1)
        directions, sizes, _ = np.linalg.svd(_apart(quadrics, constants), full_matrices=False)
        parts = sizes / sizes[0]
        if not _DEPENDENT < parts[-1] < _NEARLY:
            return None
        return cls(constants, directions.T / sizes[:, None], directions, parts)

    def quadrics(self, given: FloatArray) -> FloatArray:
        """Return the combinations of the quadrics (6, 27)."""
        found: FloatArray = self.combinations @ _apart(given, self.constants)
        return found

    def spread(self, values: FloatArray) -> FloatArray:
        """Return by how much values differ from others that are like them.

        Parameters
        ----------
        values
            Of the quadrics, shape (6,).

        Returns
        -------
        FloatArray
            A matrix: its products with vectors of order one are such differences, shape (6, 6).
        """
        own = np.abs((values - self.constants) @ self.directions)
        sizes = np.maximum(_SPREAD * self.sizes, np.minimum(_OF_VALUES * own, _SPREAD))
        found: FloatArray = self.directions * sizes
        return found


def _apart(quadrics: FloatArray, constants: FloatArray) -> FloatArray:
    """Return quadrics (6, 27) without multiples of N and of e.f."""
    found = quadrics.copy()
    found[:, _SQUARES] -= constants[:, None]
    found[:, _PRODUCTS] -= quadrics[:, _PRODUCTS[:1]]
    return found


#: Entries below this part of the largest are zero, ...
_ZERO = 1e-12
#: ... and smaller pivots than this part are not divided by.
_SMALL = 1e-3
#: The most free quantities; with more there is no gain.
_MOST_FREE = 3


class ReducedEnds(NamedTuple):
    """The ends of P paths to each of B targets."""

    points: ComplexArray
    """In the coordinates of the homotopy, shape (B, P, d)."""
    study: ComplexArray
    """Study points of any norm, shape (B, P, 8)."""
    status: NDArray[np.uint8]
    """`PathStatus`, regular or failed, shape (B, P)."""
    steps: NDArray[np.int32]
    """Steps taken, shape (B, P)."""


@dataclass(frozen=True, eq=False)
class ReducedHomotopy:
    """Six quadrics that are solved for some of the quantities w and h."""

    #: The quantities that are eliminated, and the others.
    pivots: NDArray[np.int32]
    free: NDArray[np.int32]
    #: Equation j is: pivot + slopes . free quantities + form in e_i e_j = N value. The value is row
    #: j of the combinations times the values less the constants. Shapes (6, 10), (6, free), (6,),
    #: (6, 6). The last equations have no pivot, and slopes that are small or zero.
    forms: FloatArray
    slopes: FloatArray
    constants: FloatArray
    combinations: FloatArray

    @classmethod
    def of(cls, quadrics: FloatArray) -> ReducedHomotopy | None:
        """Return six quadrics (6, 27), without their values, solved for pivots.

        The result is None in two cases: the quadrics depend on more than w and h, or so few
        quantities can be eliminated that there is no gain. Nearly dependent quadrics are combined
        before (`balance`).
        """
        balance = Balance.of(quadrics)
        if balance is not None:
            quadrics = balance.quadrics(quadrics)
        mixed = quadrics[:, 10:26].reshape(-1, 4, 4)
        # e.f vanishes.
        mixed = mixed - mixed[:, :1, :1] * np.eye(4)
        if np.abs(mixed + mixed.swapaxes(1, 2)).max() > _ZERO * np.abs(quadrics).max():
            return None
        w = [mixed[:, i, j] for i, j in ((0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2))]
        quantities = np.stack([*w, quadrics[:, 26]], axis=1)
        if not quantities[:, 6].any():
            quantities = quantities[:, :6]
        pivots, combinations = _solved(quantities)
        free = np.delete(np.arange(quantities.shape[1]), pivots)
        slopes = (combinations @ quantities)[:, free]
        if np.abs(slopes[len(pivots) :]).max(initial=0) <= _ZERO * np.abs(quantities).max():
            slopes[len(pivots) :] = 0
        if len(free) > _MOST_FREE:
            return None
        forms = combinations @ quadrics[:, :10]
        constants = np.zeros(len(quadrics))
        if balance is not None:
            constants, combinations = balance.constants, combinations @ balance.combinations
        places = pivots.astype(np.int32), free.astype(np.int32)
        return cls(*places, forms, slopes, constants, combinations)

    def points(self, study: ComplexArray) -> ComplexArray:
        """Return Study points (..., 8) in the coordinates of the homotopy, (..., 4 + free)."""
        e, f = study[..., :4], study[..., 4:]
        norm = np.sqrt((np.abs(e) ** 2).sum(axis=-1, keepdims=True))
        # Points with e = 0 are no poses; they give NaN.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            e, f = e / norm, f / norm
        outer = e[..., :, None] * f[..., None, :]
        w = outer - outer.swapaxes(-1, -2)
        pairs = ((0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2))
        quantities = [*(w[..., i, j] for i, j in pairs), (f * f).sum(axis=-1)]
        return np.stack([*np.moveaxis(e, -1, 0), *(quantities[k] for k in self.free)], axis=-1)

    def track(
        self,
        start_values: ComplexArray,
        starts: ComplexArray,
        start: NDArray[np.int32],
        values: ComplexArray,
        *,
        options: TrackerOptions = LONG_STEPS,
        jobs: int = 1,
    ) -> ReducedEnds:
        """Track solutions for some values to those for many other values, along straight lines.

        Parameters
        ----------
        start_values
            Complex values of S solved systems, shape (S, 6).
        starts
            Their solutions, shape (S, P, 4 + free).
        start
            The solved system from which paths lead to each target, shape (B,).
        values
            The values of the targets, shape (B, 6).
        options, jobs
            As for `tracker.track`.
        """
        return ReducedEnds(
            *_kernel.track_values(
                self.pivots,
                self.free,
                np.ascontiguousarray(self.forms),
                np.ascontiguousarray(self.slopes),
                self._combined(start_values),
                np.ascontiguousarray(starts),
                start,
                self._combined(values),
                predictor_tolerance=options.predictor_tolerance,
                contraction=options.contraction,
                radius_fraction=options.radius_fraction,
                min_step=options.min_step,
                max_steps=options.max_steps,
                jobs=helpful(jobs, len(values)),
            )
        )

    def _combined(self, values: ComplexArray) -> ComplexArray:
        combined = (values - self.constants) @ self.combinations.T
        return np.ascontiguousarray(combined, np.complex128)


def ends_from_start(
    start: StartSystem,
    quadrics: ComplexArray,
    options: TrackerOptions = LONG_STEPS,
    *,
    lower_rank: bool = False,
    keep_lost: bool = False,
) -> ComplexArray | None:
    """Return the ends of the paths from a start system to six quadrics.

    Both are solved for the same quantities; the other coefficients move along straight lines.

    Parameters
    ----------
    start
        A start system of the same structure, without products.
    quadrics
        Coefficients, shape (6, 27); lengths of order one.
    options
        The options of the tracker.
    lower_rank
        Whether the quadrics may determine fewer quantities than those of the start, or determine
        some badly.
    keep_lost
        Whether a lost path ends where Newton's method leads from its last point: near a double
        solution, perhaps.

    Returns
    -------
    ComplexArray or None
        Study points of any norm, shape (paths, 8); NaN for a lost path that is not kept. None if
        special quadrics cannot be solved for the quantities of the start.
    """
    found = _kernel.track_reduced(
        start.system.coefficients.g,
        np.ascontiguousarray(start.points),
        quadrics,
        predictor_tolerance=options.predictor_tolerance,
        contraction=options.contraction,
        radius_fraction=options.radius_fraction,
        min_step=options.min_step,
        max_steps=options.max_steps,
        lower_rank=lower_rank,
    )
    if found is None:
        return None
    study, status = found
    if not keep_lost:
        study[status != PathStatus.REGULAR] = np.nan
    return np.asarray(study)


def _solved(quantities: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Return pivots, and the combinations of rows that solve for them (Gauss-Jordan).

    The rows without a pivot come last: what they have of the quantities is zero, or too small to
    divide by.
    """
    rows = np.concatenate((quantities, np.eye(len(quantities))), axis=1)
    width = quantities.shape[1]
    largest = np.abs(quantities).max()
    pivots: list[int] = []
    for k in range(len(rows)):
        rest = np.abs(rows[k:, :width])
        rest[:, pivots] = 0
        row, column = divmod(int(rest.argmax()), width)
        if rest[row, column] < _SMALL * largest:
            break
        rows[[k, k + row]] = rows[[k + row, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= rows[others, column, None] * rows[k]
        pivots.append(column)
    return np.array(pivots, np.intp), np.asarray(rows[:, width:])
