"""Trace tests: a check that some solutions of a system are all of them.

Five of the equations cut out a curve. Let the sixth, G = 0 or G H = tau N^2 with factors of a
space F, move through the systems with G + s k for a general member k of F. On the curve, the
functions m / k with m in F have poles only where k = 0, and so has s, of the same order. So the
sum of m / k over *all* solutions is a polynomial in s of degree one: its second differences are
zero. Those over a part of the solutions are not, unless the part is made of all solutions on some
components of the curve. The proof is in docs/counts.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import BASES, ComplexArray, evaluate, random_quadrics
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.continuation.tracker import PathStatus, track
from gspcli.continuation.tracker_options import CAREFUL, PARANOID
from gspcli.records import dataclass

#: A test is passed if the defect is below this part of `without_one`; without a solution it is
#: about 1.
TOLERANCE = 1e-2
#: The part below which no other random k is tried, and the options of the paths.
_GOOD = 1e-6
_ATTEMPTS = (CAREFUL, CAREFUL, PARANOID)


@dataclass(frozen=True)
class TraceTest:
    """The outcome of a trace test.

    Attributes
    ----------
    defect
        Second difference of the sum over all solutions, relative to the sum of their sizes.
    without_one
        The smallest defect if one solution is omitted.
    """

    defect: float
    without_one: float

    @property
    def passed(self) -> bool:
        """Whether the defect is only rounding, and much larger if one solution is omitted."""
        return self.ratio < TOLERANCE

    @property
    def ratio(self) -> float:
        """The defect divided by the smallest one with an omitted solution."""
        return self.defect / self.without_one if self.without_one > 0 else np.inf


def trace_test(target: System, points: ComplexArray, seed: int) -> TraceTest:
    """Test whether some solutions of a system are all of them.

    Parameters
    ----------
    target
        A system in general position.
    points
        Its regular solutions, Study points of shape (n, 8).
    seed
        Source of the random numbers.

    Returns
    -------
    Trace
        The best of a few attempts: paths may come near to a branch point.
    """
    coefficients, scale = target.coefficients.balanced()
    points = np.array(points, dtype=np.complex128)
    points[:, 4:] /= scale
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    best = TraceTest(np.inf, 0.0)
    for attempt, options in enumerate(_ATTEMPTS):
        rng = np.random.default_rng([seed, attempt])
        moving = moving_equation(target.structure)
        space = target.structure.spaces[moving]
        member = random_quadrics(space, rng)[0]
        ends = track(
            System(target.structure, coefficients),
            _moved(coefficients, target.structure, moving, member),
            points,
            options=options,
        )
        if not (ends.status == PathStatus.REGULAR).all():
            continue
        middle = _functions(space, member, points)
        one, other = (_functions(space, member, ends.points[k::2]) for k in range(2))
        found = _trace(np.concatenate(list(one - 2 * middle + other), axis=1), middle)
        best = min(best, found, key=lambda trace: trace.ratio)
        if best.ratio < _GOOD:
            break
    return best


def moving_equation(structure: Structure) -> int:
    """Return which equation is moved.

    With three angles it is one of them: the other five would leave a curve in pieces, one for
    each orientation. Otherwise it is a distance, not a product if there is another one.
    """
    if structure.spaces.count("a") == 3:
        return structure.spaces.index("a")
    distances = [i for i in range(EQUATIONS) if structure.spaces[i] != "a"]
    return min(distances, key=lambda i: structure.products[i])


def _moved(
    coefficients: Coefficients, structure: Structure, moving: int, member: ComplexArray
) -> Coefficients:
    """Return the systems with G + k and G - k and, for a product, H + k and H - k."""
    count = 4 if structure.products[moving] else 2
    g, h, tau = (np.stack([x] * count) for x in coefficients)
    g[0, moving] += member
    g[1, moving] -= member
    h[2:3, moving] += member
    h[3:4, moving] -= member
    return Coefficients(g, h, tau)


def _functions(space: str, member: ComplexArray, points: ComplexArray) -> ComplexArray:
    """Return m / k for an orthonormal basis of the members m of a space."""
    basis = np.linalg.qr(BASES[space].T)[0].T
    return np.asarray(evaluate(basis, points) / evaluate(member[None], points))


def _trace(differences: ComplexArray, values: ComplexArray) -> TraceTest:
    """Return the outcome from the second differences and the values of each solution."""
    total = differences.sum(axis=0)
    size = np.linalg.norm(values, axis=1).sum()
    rest: NDArray[np.float64] = np.linalg.norm(total - differences, axis=1)
    return TraceTest(float(np.linalg.norm(total) / size), float(rest.min() / size))
