"""Natural frequencies and mode shapes of a platform that its drives hold at a pose.

The drives are springs. The forces that hold the platform against gravity add a geometric stiffness,
since their directions change with the pose. So do the weights. This part is small for stiff
machines. For soft machines it decides whether the pose is stable.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gspcli.dynamics.actuation import PAIRS, Actuation, Flags, numbers_at, polarized
from gspcli.dynamics.arrays import by_chunks, checked_array, checked_rows, make_read_only, plain
from gspcli.dynamics.mass_model import MassModel, named_drives
from gspcli.dynamics.moving_bodies import MovingBodies, equation_of_motion
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Array, Instance
from gspcli.records import EqualByContent, dataclass
from gspcli.ties import ALIKE, definite_vectors, first_largest

if TYPE_CHECKING:
    import pandas as pd

FREQUENCIES = tuple(f"f{k}" for k in range(1, 7))
#: Poses computed at a time: their intermediate arrays stay in the cache of a core.
_CHUNK = 200


@dataclass(frozen=True, eq=False)
class NaturalModes(EqualByContent):
    """The natural modes at n poses, the slowest first. All arrays are read-only.

    There are six, or as many as there are drives if several rods share a drive.
    """

    #: The platform.
    instance: Instance
    #: The poses, shapes (n, 3, 3) and (n, 3), in length units.
    R: Array
    T: Array
    #: Squares of the angular frequencies, 1/s^2, shape (n, 6): negative if the pose is unstable in
    #: that mode. NaN at singular poses.
    squares: Array
    #: How the platform moves in each mode, a twist in radians and length units about its origin,
    #: shape (n, 6, 6): ``shapes[p, k]`` is mode k at pose p. The largest component is one radian or
    #: the typical length of the platform, and positive.
    shapes: Array
    #: The forces of the constraints that hold the platform against gravity, N and N m, shape (n,
    #: 6): those along the rods where cranks and slides are the drives.
    preload: Array
    #: Which poses are singular, shape (n,).
    singular: Flags
    #: The condition number where it is above 1e8, and about as many digits of the preload are lost
    #: as it has; else NaN; shape (n,).
    nearly_singular: Array
    #: Torques and forces of the m drives against gravity, N m and N, shape (n, m).
    torques: Array

    def __post_init__(self) -> None:
        make_read_only(self)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        count = f"{len(self.T)} pose{'' if len(self.T) == 1 else 's'}"
        if self.singular.all():
            return f"<NaturalModes of {name}: {count}, all singular>"
        low, high = np.nanmin(self.frequencies), np.nanmax(self.frequencies)
        return f"<NaturalModes of {name}: {count}, {low:.6g} to {high:.6g} Hz>"

    @cached_property
    def frequencies(self) -> Array:
        """Natural frequencies, Hz, shape (n, 6): negative where the pose is unstable.

        Then the deviation grows by a factor e in ``1 / (2 pi |f|)`` seconds.
        """
        signed: Array = np.sign(self.squares) * np.sqrt(np.abs(self.squares)) / (2 * np.pi)
        return signed

    def to_frame(self) -> pd.DataFrame:
        """Return a table with a row for each pose: its number and f1 ... f6 in Hz."""
        import pandas as pd

        columns = dict(zip(FREQUENCIES, self.frequencies.T, strict=False))
        return pd.DataFrame({"row": np.arange(1, len(self.T) + 1), **columns})

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data; singular poses have null for their numbers."""
        parts = [self.frequencies, self.shapes, self.preload, self.nearly_singular]
        columns = [range(1, len(self.T) + 1), *map(plain, parts), self.singular.tolist()]
        keys = ["row", "frequencies", "shapes", "preload", "nearly_singular", "singular"]
        if named_drives(self.instance):
            keys.append("torques")
            columns.append(plain(self.torques))
        return {
            "schema": "gsp.dynamics-modes/1",
            **self.instance.to_json(),
            **named_drives(self.instance),
            "rows": [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)],
        }


def natural_modes(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    stiffness: ArrayLike | None = None,
    drives: ArrayLike | None = None,
) -> NaturalModes:
    """Return the natural frequencies and mode shapes of a platform held at poses by its drives.

    Parameters
    ----------
    instance
        A platform with masses.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), in length units.
    stiffness
        Of the drives, N/m and N m/rad, one number or one each; by default what the instance states.
    drives
        Readings of the drives, as in `inverse_dynamics`.

    Raises
    ------
    ArgumentError
        As `inverse_dynamics`, or if no stiffness is known.

    Notes
    -----
    ``det(K - w^2 M) = 0`` with ``K = J^T k J - sum F0 H + V''``: F0 are the forces that hold the
    weights, H the second derivatives of the values, V the potential energy of the weights. In
    equilibrium K does not depend on how the pose is parametrized. With cranks and slides F0 are the
    torques, and J and H the derivatives of their angles and ways. Where rods share a drive, K and M
    are restricted to the motions that the drives leave: ``J^-1`` times which rod has which drive.
    """
    model = MassModel.of(instance)
    R, T = checked_rows(R, T)
    given = model.stiffness
    if stiffness is not None:
        given = checked_array(stiffness, (model.machine.count,), "stiffness")
    if given is None:
        message = (
            "found no stiffness: state drives: {stiffness: ...} under `dynamics` in the instance "
            "file, in N/m and N m/rad"
        )
        raise ArgumentError(message, "stiffness")
    if not (given > 0).all():
        message = f"found {given.min():g}, expected stiffnesses above 0"
        raise ArgumentError(message, "stiffness")

    q = numbers_at(model, R, T, drives)

    def some(rows: slice) -> tuple[Any, ...]:
        return _modes(model, R[rows], T[rows] * model.metre, q[rows], given)

    return NaturalModes(instance, R, T, *by_chunks(len(R), _CHUNK, some))


def _modes(model: MassModel, R: Array, T: Array, q: Array, stiffness: Array) -> tuple[Any, ...]:
    """Return squares, shapes, preload, what is singular and torques, as `NaturalModes` has them."""
    acting, still = Actuation(model, R, T, q), np.zeros((len(T), 6))
    singular, conditions = acting.conditions()
    pulls = np.where(singular[:, None, None], np.eye(6), acting.pulls)
    mass, weights = equation_of_motion(model, R, T, q, still)
    held = _solved(pulls, weights)
    # The rates of the drives by the twist: of those that several rods share the first one's.
    J = acting.pulls[:, model.machine.first]
    K = np.einsum("nki,k,nkj->nij", J, stiffness, J)
    K = K - acting.bend(held) + _weight_stiffness(acting)
    M = mass + np.einsum("nki,k,nkj->nij", J, model.rotors, J)
    basis: Array = np.eye(6)
    if model.machine.count < len(basis):
        basis = np.asarray(np.linalg.solve(pulls, model.users), float)
        K, M = (np.swapaxes(basis, -1, -2) @ matrix @ basis for matrix in (K, M))
    # M = C C^T turns K x = w^2 M x into a symmetric problem.
    C = np.linalg.cholesky(M)
    half = np.linalg.solve(C, np.swapaxes(np.linalg.solve(C, K), -1, -2))
    squares: Array
    squares, vectors = np.linalg.eigh((half + np.swapaxes(half, -1, -2)) / 2)
    vectors = _chosen_basis(squares, vectors)
    shapes: Array = np.swapaxes(basis @ np.linalg.solve(np.swapaxes(C, -1, -2), vectors), -1, -2)
    weighted = shapes * np.repeat([model.bodies.length, 1.0], 3)
    sizes = np.abs(weighted)
    # The first of the largest entries, up to rounding errors; its quotient is exactly one.
    first = first_largest(sizes)
    weighted = weighted / np.take_along_axis(weighted, first[..., None], axis=-1)
    shapes = weighted * np.repeat([1.0, model.bodies.length / model.metre], 3)
    # Entries that are rounding errors become zero, without a sign.
    shapes = np.where(np.abs(weighted) < ALIKE, 0.0, shapes)
    at_rest = MovingBodies(model, acting.at).wrenches(still, still, model.gravity)
    rows = np.where(singular[:, None, None], np.eye(6), acting.at.jacobian)
    preload = _solved(rows, at_rest.on_platform)
    for part in (squares, shapes, preload, held):
        part[singular] = np.nan
    return squares, shapes, preload, singular, conditions, held @ model.users


def _solved(rows: Array, wrenches: Array) -> Array:
    """Return the forces whose wrenches are given, (n, 6, 6), (n, 6) -> (n, 6)."""
    columns = np.swapaxes(rows, -1, -2)
    return np.asarray(np.linalg.solve(columns, wrenches[..., None])[..., 0], float)


def _chosen_basis(squares: Array, vectors: Array) -> Array:
    """Return eigenvectors that do not depend on rounding errors where eigenvalues are equal.

    Symmetric platforms have pairs of equal frequencies, and any orthonormal basis of their modes is
    right (`definite_vectors`). Shapes (n, 6) and (n, 6, 6), eigenvectors are columns.
    """
    vectors = vectors.copy()
    tolerance = ALIKE * np.abs(squares).max(axis=-1)
    close = np.diff(squares, axis=-1) <= tolerance[:, None]
    for row in np.flatnonzero(close.any(axis=-1)).tolist():
        vectors[row] = definite_vectors(squares[row], vectors[row])
    return vectors


def _weight_stiffness(acting: Actuation) -> Array:
    """Return the second derivatives of the potential energy of the weights, (n, 6, 6)."""
    R, T, q = (part[:, None] for part in (acting.R, acting.T, acting.q))
    bodies = MovingBodies(acting.model, acting.model.machine.at(R, T, q))
    return polarized(bodies.potential_bend(PAIRS))
