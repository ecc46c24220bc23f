"""Whether a regular solution is at infinity, decided in extended precision.

A solution with a very small homogenizing coordinate (N of a rotation, s of a translation) is at
infinity or merely far away, and double precision may not tell which. Here Newton's
method is run in fixed-point arithmetic of many digits, the coefficients taken as exact, and what is
left of the coordinate is compared with what the last digit of the coefficients can do to it:

* larger by far, and the solution is finite, with a pose accurate to the last digit;
* not larger, and the solution is at infinity for a platform that cannot be told from this one;
* in between, nothing is said.

It is slow, a few hundredths of a second, and rarely needed.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.distance_forms import Measures
from gspcli.geometry.quaternions import ROTATION_FORMS, TRANSLATION_FORMS, Field, normalized

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Arrays of `_Fixed`.
Digits = NDArray[Any]
#: The values of n - p homogeneous equations, from coefficients and n unknowns in p groups.
_Equations = Callable[[list[Digits], Digits], list[Any]]

#: Binary digits after the point.
_BITS = 320
#: Newton's method has converged when steps are smaller.
_CONVERGED = 2.0**-200
_STEPS = 60
#: Step of difference quotients.
_DIFFERENCE = 2.0**-120
#: How many random changes of the coefficients are tried, and of what size.
_CHANGES = 4
_LAST_DIGIT = 2.0**-52
#: A coordinate this many times larger than its changes is not zero, ...
_FINITE = 1e3
#: ... and one that is not even this many times larger may be zero.
_INFINITE = 3e1


class _Fixed:
    """A complex number in fixed point."""

    __slots__ = ("im", "re")

    def __init__(self, re: int, im: int) -> None:
        self.re, self.im = re, im

    @classmethod
    def of(cls, z: complex) -> _Fixed:
        """Return a number exactly, but for digits below the last place."""
        return cls(int(Fraction(z.real) * 2**_BITS), int(Fraction(z.imag) * 2**_BITS))

    def __add__(self, other: _Fixed) -> _Fixed:
        return _Fixed(self.re + other.re, self.im + other.im)

    def __sub__(self, other: _Fixed) -> _Fixed:
        return _Fixed(self.re - other.re, self.im - other.im)

    def __mul__(self, other: _Fixed) -> _Fixed:
        a, b, c, d = self.re, self.im, other.re, other.im
        return _Fixed((a * c - b * d) >> _BITS, (a * d + b * c) >> _BITS)

    def __complex__(self) -> complex:
        return complex(self.re / 2**_BITS, self.im / 2**_BITS)


def _digits(values: Field) -> Digits:
    numbers: Digits = np.empty(values.shape, object)
    numbers.reshape(-1)[:] = [_Fixed.of(z) for z in values.reshape(-1).tolist()]
    return numbers


def _rounded(numbers: Digits | list[Any]) -> Complex:
    return np.array(numbers).astype(complex)


def refined_rotation(forms: Array, e: Complex) -> tuple[Complex, bool | None]:
    """Return a simple intersection point of three real quadrics, and whether N is not zero there.

    The point has norm 1 and is accurate to the last digit if that is decided; None says that
    it is not.
    """
    refined = _refined(_rotation_equations, [forms], e, [slice(0, 4)])
    if refined is None:
        return e, None
    z, changes = refined
    point = _rounded(z)
    return normalized(point), _differs(complex(z @ z), 2 * changes @ point)


def _rotation_equations(given: list[Digits], z: Digits) -> list[Any]:
    e = z[:4]
    return [e @ form @ e for form in given[0]]


def finite_pose(
    forms: Array, given: Measures, signs: Array, distances: Array, e: Complex, X: Complex
) -> tuple[Complex, Complex] | Literal[False] | None:
    """Return the pose near a point, False if its translation is infinite, None if undecided.

    Parameters
    ----------
    forms
        The quadrics of the angles, shape (3, 4, 4).
    given, signs, distances
        What the distances measure, the sign of each height, and the distances.
    e
        The quaternion of the rotation, shape (4,).
    X
        ``(s, f)``, the Study point being (s e, f); shape (5,).
    """
    planes, curved = len(given.heights), len(given.squares)
    if planes + curved != 3:
        return None

    def equations(numbers: list[Digits], z: Digits) -> list[Any]:
        angles, heights, squares, axial, normals, d = numbers
        e, s, f = z[:4], z[4], z[5:]
        norm = e @ e
        length = d * s

        def height(form: Digits) -> Any:
            return e @ (form[:, :4] @ e) * s + e @ (form[:, 4:] @ f)

        values = [*_rotation_equations([angles], z), e @ f]
        for k, (j, sign) in enumerate(zip(given.flat, signs.tolist(), strict=True)):
            h = height(heights[k])
            if k not in given.skew:
                values.append(h - length[j] * norm if sign > 0 else h + length[j] * norm)
            elif distances[j] == 0:
                values.append(h)
            else:
                normal = [e @ (form[:, :4] @ e) for form in normals[given.skew.index(k)]]
                square = sum((n * n for n in normal[1:]), normal[0] * normal[0])
                values.append(h * h - length[j] * length[j] * square)
        for k, j in enumerate(given.curved):
            square = height(squares[k]) * s + f @ f * four - length[j] * length[j] * norm
            if k >= given.spheres:
                along = height(axial[k - given.spheres])
                square = square * norm - along * along
            values.append(square)
        return values

    four = _Fixed.of(4)
    numbers = [forms, given.heights, given.squares, given.axial, given.normals, distances]
    start = np.concatenate((e, X / np.linalg.norm(X)))
    refined = _refined(equations, numbers, start, [slice(0, 4), slice(4, 9)])
    if refined is None:
        return None
    z, changes = refined
    finite = _differs(complex(z[4]), changes[:, 4])
    return _pose(z) if finite else finite


def _refined(
    equations: _Equations, coefficients: list[Array], start: Complex, groups: list[slice]
) -> tuple[Digits, Complex] | None:
    """Return the solution near a start, and how changes of the coefficients move it.

    The unknowns of each group are homogeneous. The changes have shape (_CHANGES, n). Returns
    None if Newton's method does not converge.
    """
    exact = [_digits(c) for c in coefficients]
    patches = np.zeros((len(groups), len(start)), complex)
    for row, group in zip(patches, groups, strict=True):
        row[group] = start[group].conj()
    z = _digits(start)
    inverse = np.zeros((0, 0), complex)
    last = np.inf
    for _ in range(_STEPS):
        values = _rounded(equations(exact, z))
        if not len(inverse) or last > 1e-8:
            try:
                inverse = np.linalg.inv(np.vstack((_derivatives(equations, exact, z), patches)))
            except np.linalg.LinAlgError:
                return None
        step = inverse[:, : len(values)] @ values
        z = z - _digits(step)
        size = float(np.abs(step).max())
        if size < _CONVERGED:
            break
        if size > 0.5 * last:
            return None
        last = size
    else:
        return None
    moved = float(np.abs(_rounded(z) - start).max())
    if moved > 0.1:
        return None
    rng = np.random.default_rng(_BITS)
    changes = []
    for _ in range(_CHANGES):
        other = [_digits(_changed(c, rng)) for c in coefficients]
        changes.append(inverse[:, : len(values)] @ _rounded(equations(other, z)))
    return z, np.array(changes)


def _derivatives(equations: _Equations, coefficients: list[Digits], z: Digits) -> Complex:
    here = np.array(equations(coefficients, z))
    step = _Fixed.of(_DIFFERENCE)
    columns = []
    for i in range(len(z)):
        there = z.copy()
        there[i] = there[i] + step
        columns.append(_rounded(np.array(equations(coefficients, there)) - here) / _DIFFERENCE)
    return np.array(columns).T


def _changed(forms: Array, rng: np.random.Generator) -> Array:
    """Return forms with errors in the last digit of the largest coefficient of each."""
    axes = tuple(range(1, forms.ndim)) if forms.ndim < 4 else (2, 3)
    sizes = np.abs(forms).max(axis=axes, keepdims=True, initial=0) if axes else np.abs(forms)
    changes: Array = _LAST_DIGIT * sizes * rng.choice([-1.0, 1.0], size=forms.shape)
    return forms + changes


def _differs(coordinate: complex, changes: Complex) -> bool | None:
    """Return whether a coordinate is not zero, None if that cannot be decided."""
    change = float(np.abs(changes).max())
    if abs(coordinate) > _FINITE * change:
        return True
    return False if abs(coordinate) < _INFINITE * change else None


def _pose(z: Digits) -> tuple[Complex, Complex]:
    """Return the pose of (e, s, f)."""
    e = z[:4]
    norm = complex(e @ e)
    outer = (e[:, None] * e[None, :]).reshape(16)
    R = _rounded(_digits(ROTATION_FORMS) @ outer).reshape(3, 3) / norm
    T = [complex(e @ (form @ z[5:])) for form in _digits(TRANSLATION_FORMS)]
    return R, np.array(T) / (norm * complex(z[4]))
