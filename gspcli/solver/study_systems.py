"""From an instance to quadrics on the Study quadric, which is what path tracking solves.

Times N, an angle, a one-sided DPH or DHP, the mutual moment of two lines and a DPP are each one
quadric in the Study parameters (e, f). DPL, DLP and DLL are products of two quadrics of one space,
``G H = tau N^2``. For DPL, a and b are orthonormal and perpendicular to the line, and A, B are the
distances to the planes through it with these normals: ``(A + iB)(A - iB) = d^2 N^2``. If the first
coordinate of the direction v is negative, a, b and v are left-handed, else right-handed. For DLL,
with the mutual moment M and the cosine C of two lines: ``(M + idC)(M - idC) = d^2 N^2``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, DLP, DPL, DPP, Kind
from gspcli.continuation.quadrics import BASES, COEFFICIENTS, NORM, SPACES
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Real numbers, or complex ones.
Scalars = NDArray[Any]


def target_systems(arrangement: Arrangement) -> list[System]:
    """Return a system for each combination of sides asked for, all of one structure.

    The arrangement should be `Arrangement.normalized`: lengths of order one, points near the
    origins.
    """
    return list(systems_of(*coefficients_at(arrangement)))


def coefficients_at(arrangement: Arrangement) -> tuple[Structure, Coefficients]:
    """Return the structure and, for each combination of sides asked for, the coefficients."""
    values = arrangement.values
    if len(arrangement.angles):
        values = values.copy()
        values[arrangement.angles] = arrangement.cosines(arrangement.values)
    geometry = (arrangement.y, arrangement.x, arrangement.u, arrangement.v)
    return coefficients_of(arrangement.kinds, *geometry, values * side_choices(arrangement))


def side_choices(arrangement: Arrangement) -> Array:
    """Return the sign of each value for each combination of sides asked for, shape (k, n).

    The positive side of the first constraint that has both comes first.
    """
    return _choices(arrangement.kinds, tuple(arrangement.signs.tolist()))


@lru_cache
def _choices(kinds: tuple[Kind, ...], signs: tuple[int, ...]) -> Array:
    choices = [
        (1, -1) if kind.has_sides and sign == 0 else (1 if sign >= 0 else -1,)
        for kind, sign in zip(kinds, signs, strict=True)
    ]
    found = np.array(list(product(*choices)))
    found.setflags(write=False)
    return found


def systems_of(structure: Structure, coefficients: Coefficients) -> Iterator[System]:
    """Yield the systems of one structure with coefficients along a leading axis."""
    return (System.of(structure, *rest) for rest in zip(*coefficients, strict=True))


def complex_system(
    kinds: Sequence[Kind], y: Array, x: Array, u: Array, v: Array, parameters: Complex
) -> System:
    """Return a system of a platform with complex values, in canonical order.

    Of the distance of two lines, which its factors have in them, only the square on the right is
    complex: so factors are conjugate, and stay so on the way to a real platform.

    Parameters
    ----------
    kinds, y, x, u, v
        As for `coefficients_of`, shape (6, 3).
    parameters
        What the equations are linear in: squares of distances without sides, shape (6,).
    """
    square = [kind.is_squared for kind in kinds]
    lines = [kind is DLL for kind in kinds]
    values = np.where(square, np.sqrt(parameters), parameters)
    values = np.where(lines, np.abs(values), values)
    structure, coefficients = coefficients_of(kinds, y, x, u, v, values[None])
    coefficients.tau[:, lines] = parameters[lines]
    return System(structure, coefficients.take(0)).canonical()


def coefficients_of(
    kinds: Sequence[Kind], y: Array, x: Array, u: Array, v: Array, values: Scalars
) -> tuple[Structure, Coefficients]:
    """Return the structure and the coefficients of platforms with constraints of the same kinds.

    Parameters
    ----------
    kinds
        The kinds of the six constraints.
    y, x, u, v
        As for `equation`, for each constraint: shape (6, 3), or (count, 6, 3) if they differ.
    values
        Likewise, shape (count, 6); a distance of two lines is zero for all or for none. Complex
        values give complex systems of the same geometry. All of them may be arrays of objects that
        calculate like complex numbers, and so are the coefficients then.
    """
    count = len(values)
    g = np.zeros((count, EQUATIONS, COEFFICIENTS), np.result_type(values, complex))
    h, tau = np.zeros_like(g), np.zeros_like(g[..., 0])
    shape = [("", False)] * EQUATIONS
    meeting = tuple(
        kind is DLL and value == 0 for kind, value in zip(kinds, values[0].tolist(), strict=True)
    )
    for members, rows in _alike(tuple(kinds), meeting):
        points = y[..., rows, :], x[..., rows, :]
        directions = u[..., rows, :], v[..., rows, :]
        rule = equation(kinds[members[0]], *points, *directions, values[:, rows])
        g[:, rows] = rule.g
        if rule.h is not None:
            h[:, rows], tau[:, rows] = rule.h, rule.tau
        for i in members:
            shape[i] = rule.letter, rule.h is not None
    return _structure(*zip(*shape, strict=True)), Coefficients(g, h, tau)


@cache
def _alike(
    kinds: tuple[Kind, ...], meeting: tuple[bool, ...]
) -> list[tuple[list[int], slice | list[int]]]:
    """Return the constraints whose equations are of one form: their indices, and an index."""
    forms = list(zip(kinds, meeting, strict=True))
    groups = [
        [i for i, other in enumerate(forms) if other == form] for form in dict.fromkeys(forms)
    ]
    # Slices are much quicker than lists.
    return [
        (group, slice(group[0], group[-1] + 1) if group[-1] - group[0] < len(group) else group)
        for group in groups
    ]


@cache
def _structure(letters: tuple[str, ...], products: tuple[bool, ...]) -> Structure:
    return Structure("".join(letters), products)


class QuadricEquation(NamedTuple):
    """Constraints of one form as ``G = 0`` or, if there is a second factor, ``G H = tau N^2``."""

    letter: str
    """The space of the quadrics."""
    g: Scalars
    """Shape (..., 27)."""
    h: Complex | None = None
    tau: Scalars | None = None
    """Shape (...)."""


def equation(kind: Kind, y: Array, x: Array, u: Array, v: Array, value: Scalars) -> QuadricEquation:
    """Return the equation of a constraint, or of many of one kind along leading axes.

    Parameters
    ----------
    kind
        The kind.
    y, x
        A point of the platform's and of the base's primitive, shape (..., 3).
    u, v
        Their unit directions, shape (..., 3); those of points do not matter.
    value
        The distance, signed if the kind has sides, or for an angle the value of ``R u . v``;
        shape (...). Lines at a distance of zero have one quadric, so all of them or none.
    """
    # Components first, as `forms_of` takes vectors.
    a, b = _components(y), _components(x)
    letter, like = kind.space, y * x
    if kind is DPL or kind is DLP:
        height, direction = (study.base_height, v) if kind is DPL else (study.plane_height, u)
        normals = map(_components, _across(direction))
        first, second = (_quadric(letter, height(a, b, normal), like) for normal in normals)
        return _factors(letter, first, second, value)
    form, *further = study.forms_of(kind, a, b, _components(u), _components(v))
    quadric = _quadric(letter, form, like)
    if kind is not DLL:
        return QuadricEquation(letter, quadric - _constant(value**2 if kind is DPP else value))
    if (value == 0).all():
        return QuadricEquation(letter, quadric)
    turned = value[..., None] * _quadric(letter, further[0], like)
    return _factors(letter, quadric, turned, value)


def _components(vectors: Scalars) -> list[Scalars]:
    return [vectors[..., k] for k in range(3)]


def _factors(letter: str, a: Scalars, b: Scalars, distance: Scalars) -> QuadricEquation:
    return QuadricEquation(letter, a + 1j * b, a - 1j * b, distance**2)


def _constant(value: Scalars) -> Scalars:
    """Return the quadric of a constant, shape (..., 27)."""
    return np.asarray(value[..., None] * NORM, dtype=value.dtype)


def _across(direction: Array) -> tuple[Array, Array]:
    """Return two unit vectors that complete a unit vector to an orthonormal basis."""
    # The reflection that takes it into the first unit vector, up to sign, has them as rows.
    mirror = direction.copy()
    mirror[..., 0] += np.copysign(1, direction[..., 0].astype(complex).real)
    scaled = mirror[..., 1:] / np.abs(mirror[..., :1])
    rows = np.eye(3)[1:] - scaled[..., None] * mirror[..., None, :]
    return rows[..., 0, :], rows[..., 1, :]


#: The places in its basis of the functions that span each space.
_PLACES = {
    letter: {place: k for k, place in enumerate(functions)} for letter, functions in SPACES.items()
}


def _quadric(letter: str, form: study.Form, like: Scalars) -> Scalars:
    """Return the quadric of a combination of the functions of a space, shape (..., 27).

    The coefficients have the leading axes (...) and the type of `like`, (..., 3).
    """
    places = _PLACES[letter]
    rows = np.zeros((*like.shape[:-1], len(places)), like.dtype)
    for place, entry in form.items():
        rows[..., places[place]] = entry
    return _times(rows, BASES[letter])


def _times(rows: Scalars, basis: NDArray[np.float64]) -> Scalars:
    """Return combinations of the rows of a basis, of which most entries are zero."""
    if rows.dtype != object:
        return np.asarray(rows @ basis)
    found = np.zeros((*rows.shape[:-1], basis.shape[1]), object)
    for i, j in zip(*(x.tolist() for x in np.nonzero(basis)), strict=True):
        # Most of them are 1.
        found[..., j] += rows[..., i] if basis[i, j] == 1 else rows[..., i] * basis[i, j].item()
    return found
