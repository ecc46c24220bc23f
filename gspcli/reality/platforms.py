"""Many platforms of one type as arrays: random numbers, systems and solutions.

Distances to planes and of lines are zero in *reduced* platforms. For one side this is no
restriction: the plane can be moved instead of changing its distance. A small distance gives, for
each sign, a real solution near each one of the reduced platform. So all sides, and both signs of
the mutual moment of two lines, have as many real solutions as one (docs/real-counts.md).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DPH, Kind, Primitive
from gspcli.continuation.endpoints import SystemSolutions
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.geometry.arrangement import Bodies
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import dot, normalized, rotation_from_quaternion
from gspcli.records import dataclass
from gspcli.solver.study_systems import coefficients_of, systems_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Platforms(Bodies):
    """The numbers of platforms; points of the lines and planes of angles are zero."""

    #: Distances, signed where there are sides, and of angles ``R u . v``; shape (..., 6).
    values: Array

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, index: int | slice | NDArray[np.int64] | None) -> Platforms:
        """Return some of the platforms; None adds a leading axis."""
        return Platforms(
            self.kinds, *(part[index] for part in (self.y, self.x, self.u, self.v, self.values))
        )

    def systems(self) -> Iterator[System]:
        """Yield the system of each platform, for the sides that its values have."""
        return systems_of(*coefficients_of(self.kinds, self.y, self.x, self.u, self.v, self.values))

    def on_all_sides(self) -> Platforms:
        """Return each platform with all combinations of sides, one directly after the other."""
        sided = [kind.has_sides for kind in self.kinds]
        signs = np.array(list(product(*[(1, -1) if free else (1,) for free in sided])))
        each = self[np.repeat(np.arange(len(self)), len(signs))]
        return replace(each, values=each.values * np.tile(signs, (len(self), 1)))

    def solutions(self, seed: int) -> Iterator[SystemSolutions]:
        """Yield the solutions of each platform by path tracking."""
        return solve_systems(self.systems(), seed=seed)


def random_platforms(kinds: Sequence[Kind], count: int, rng: np.random.Generator) -> Platforms:
    """Return random platforms, each with at least one real pose.

    Points are uniform in the cube from -1 to 1, and directions on the sphere. The values are those
    of a hidden pose with a uniform rotation and a translation in the same cube. `gsp new` draws
    from this distribution, but rounds, and rejects hidden poses with condition numbers above 1000.
    """
    shape = (count, len(kinds))
    distance = np.array([kind.is_distance for kind in kinds])[:, None]
    y, x = rng.uniform(-1, 1, size=(2, *shape, 3)) * distance
    u, v = normalized(rng.normal(size=(2, *shape, 3)))
    u *= np.array([kind.platform is not Primitive.POINT for kind in kinds])[:, None]
    v *= np.array([kind.base is not Primitive.POINT for kind in kinds])[:, None]
    R = rotation_from_quaternion(rng.normal(size=(count, 4)))
    T = rng.uniform(-1, 1, size=(count, 3))
    bodies = Bodies(tuple(kinds), y, x, u, v)
    values = measured(bodies, R, T)
    _, w, _ = bodies.placed(R, T)
    for i, kind in enumerate(kinds):
        if not kind.is_distance:
            values[:, i] = dot(w[:, i], v[:, i])
        elif not kind.has_sides:
            values[:, i] = np.abs(values[:, i])
    return Platforms(bodies.kinds, y, x, u, v, values)


def reduced(platforms: Platforms) -> Platforms:
    """Return platforms with planes moved to distance zero, and lines that meet."""
    y, x, values = platforms.y.copy(), platforms.x.copy(), platforms.values.copy()
    for i, kind in enumerate(platforms.kinds):
        shift = values[..., i, None]
        if kind is DPH:
            x[..., i, :] += shift * platforms.v[..., i, :]
        elif kind is DHP:
            y[..., i, :] += shift * platforms.u[..., i, :]
        if kind in (DPH, DHP, DLL):
            values[..., i] = 0.0
    return replace(platforms, y=y, x=x, values=values)


def multiplier(kinds: tuple[Kind, ...]) -> int:
    """Return how many solutions, on all sides, belong to one solution of a reduced platform."""
    return int(2 ** sum(kind in (DPH, DHP, DLL) for kind in kinds))


#: The error of a solution of norm 1 is about the condition number times this, ...
_EPS = float(np.finfo(float).eps)
#: ... and less than this many times that: smaller imaginary parts are those of real ones, ...
_REAL = 100.0
#: ... and above this many times not.
_COMPLEX = 10_000.0
#: Points with a smaller relative imaginary part are probably real.
_FLAT = 1e-6


def look_real(points: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Return which points of any norm are probably real, without proof, shape (n, 8) -> (n,)."""
    pivot = points[np.arange(len(points)), np.abs(points).argmax(axis=-1)]
    return np.asarray(np.abs((points / pivot[:, None]).imag).max(axis=-1) < _FLAT)


@dataclass(frozen=True, eq=False)
class Reality:
    """Which solutions of a system are real."""

    #: Shape (n,).
    real: NDArray[np.bool_]
    #: Whether this is clear for all of them: all are simple, and no imaginary part and no distance
    #: of real ones has the size of an error. This is a numerical argument and no proof.
    decided: bool

    @property
    def count(self) -> int:
        """The number of real ones."""
        return int(self.real.sum())


def reality(points: NDArray[np.complex128], condition: NDArray[np.float64]) -> Reality:
    """Return which solutions are real.

    Real systems have conjugate solutions. A solution with an imaginary part of the size of its
    error equals its conjugate, unless another solution is as near.

    Parameters
    ----------
    points
        All solutions of a system, scaled to N = 1, shape (n, 8).
    condition
        Their condition numbers, shape (n,).
    """
    z = normalized(points)
    error = _EPS * condition
    height = np.linalg.norm(z.imag, axis=-1)
    real = height < _REAL * error
    unclear = ~(real | (height > _COMPLEX * error))
    x = z[real].real
    overlap = np.abs(x @ x.T)
    np.fill_diagonal(overlap, 0.0)
    # The sine of the angle between two lines, squared.
    apart = 1.0 - overlap.max(axis=-1, initial=0.0) ** 2
    # The two of a conjugate pair that look real are within their errors of each other.
    double = apart < np.maximum(4 * _REAL * error[real], 1e-7) ** 2
    return Reality(real, not (unclear.any() or double.any()))
