"""Systems of six equations on the Study quadric."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.continuation.quadrics import (
    COEFFICIENTS,
    LETTERS,
    NORM,
    ComplexArray,
    FloatArray,
    evaluate,
    gradients,
)
from gspcli.records import dataclass

EQUATIONS = 6
# The degree in f of each coefficient, and which coefficients have the degree 0, 1, 2.
DEGREE_IN_F = np.repeat([0, 1, 2], [10, 16, 1])
_OF_DEGREE = np.eye(3)[DEGREE_IN_F]


@dataclass(frozen=True, order=True)
class Structure:
    """The structure of a system: the space of quadrics of each equation, and which are products.

    Parameters
    ----------
    spaces
        Six letters of ``apqls`` (`gspcli.continuation.quadrics`).
    products
        Whether each equation is ``G H = tau N^2``; otherwise it is ``G = 0``.

    Raises
    ------
    ValueError
        If there are not six of both, or a letter is unknown.
    """

    spaces: str
    products: tuple[bool, ...] = (False,) * EQUATIONS

    def __post_init__(self) -> None:
        if len(self.spaces) != EQUATIONS or not set(self.spaces) <= set(LETTERS):
            raise ValueError(f"spaces must be six letters of {LETTERS!r}, not {self.spaces!r}")
        if len(self.products) != EQUATIONS:
            raise ValueError(f"products must be six truth values, not {len(self.products)}")

    @cached_property
    def is_product(self) -> NDArray[np.bool_]:
        """The products as an array, shape (6,), not writeable."""
        mask = np.array(self.products, dtype=np.bool_)
        mask.setflags(write=False)
        return mask

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Positions of the equations in canonical order: by letter, quadrics before products."""
        key = [(LETTERS.index(x), p) for x, p in zip(self.spaces, self.products, strict=True)]
        return tuple(sorted(range(EQUATIONS), key=key.__getitem__))

    def canonical(self) -> Structure:
        """Return the structure with its equations in canonical order."""
        return self._canonical

    @cached_property
    def _canonical(self) -> Structure:
        return Structure(
            "".join(self.spaces[i] for i in self.order), tuple(self.products[i] for i in self.order)
        )


class Coefficients(NamedTuple):
    """The coefficients of one system, or of many along leading axes."""

    g: ComplexArray
    """Quadrics or first factors, shape (..., 6, 27)."""
    h: ComplexArray
    """Second factors, shape (..., 6, 27); zero where there is no product."""
    tau: ComplexArray
    """Right-hand sides of the products, shape (..., 6); zero where there is none."""

    def sizes(self) -> tuple[FloatArray, FloatArray]:
        """Return the norms of the first and second factors, 1 where they vanish, shape (..., 6)."""
        size_g, size_h = (np.sqrt((x.real**2 + x.imag**2).sum(axis=-1)) for x in self[:2])
        size_g[size_g == 0] = size_h[size_h == 0] = 1.0
        return size_g, size_h

    def normalized(self) -> Coefficients:
        """Return the equations with every factor scaled to norm 1."""
        return self.divided(*self.sizes())

    def divided(self, g: FloatArray, h: FloatArray) -> Coefficients:
        """Return the same equations with factors divided by `g` and `h`, shape (..., 6)."""
        return Coefficients(self.g / g[..., None], self.h / h[..., None], self.tau / g / h)

    def balanced(self) -> tuple[Coefficients, FloatArray]:
        """Return the normalized equations in e and f / scale, and the scales (...).

        The scale, a power of two, makes the coefficients of e e, e f and f f alike in size, so
        that the unit of length does not matter.
        """
        factors = np.concatenate([self.g, self.h], axis=-2)
        square = (factors.real**2 + factors.imag**2) @ _OF_DEGREE
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log2(square) / 2
            # The least-squares slope of log(size) over the degree in f.
            ratio = logarithm[..., 1:] - logarithm[..., :1]
        known = np.isfinite(ratio)
        slope = np.where(known, ratio, 0.0).sum(axis=-2) @ [1.0, 2.0]
        weight = known.sum(axis=-2) @ [1.0, 4.0]
        scale = np.exp2(-np.rint(slope / np.maximum(1.0, weight)))
        return self.in_units(scale).normalized(), scale

    def in_units(self, scale: FloatArray) -> Coefficients:
        """Return the equations in e and f / scale, for scales of shape (...)."""
        powers = scale[..., None, None] ** DEGREE_IN_F
        return Coefficients(self.g * powers, self.h * powers, self.tau)

    def scaled(self, g: ComplexArray, h: ComplexArray) -> Coefficients:
        """Return the same equations with their factors multiplied by `g` and `h`, shape (6,)."""
        return Coefficients(self.g * g[:, None], self.h * h[:, None], self.tau * g * h)

    def towards(self, target: Coefficients, t: complex) -> Coefficients:
        """Return the point `t` of the line from these coefficients (0) to `target` (1)."""
        return Coefficients(*(x + t * (y - x) for x, y in zip(self, target, strict=True)))

    @classmethod
    def stacked(cls, systems: Sequence[System]) -> Coefficients:
        """Return the coefficients of systems along a new leading axis."""
        return cls(*map(np.array, zip(*(system.coefficients for system in systems), strict=True)))

    def take(self, index: int | slice | NDArray[np.intp]) -> Coefficients:
        """Return some of many systems, by their index on the first axis."""
        return Coefficients(self.g[index], self.h[index], self.tau[index])


class FineCoefficients(NamedTuple):
    """Coefficients of one system in 32 digits, as unevaluated sums of two doubles."""

    high: Coefficients
    """The numbers in doubles, leading axis (1,)."""
    more: Coefficients
    """What is to be added to them, leading axis (1,)."""

    @classmethod
    def of(cls, numbers: Coefficients) -> FineCoefficients:
        """Return the sums nearest to numbers of any precision: arrays of objects, no batch axes."""
        columns = [_split(x) for x in numbers]
        return cls(*(Coefficients(*(x[part] for x in columns)) for part in _PARTS))

    def nearby(self, start: Coefficients, distance: float) -> Coefficients:
        """Return the equations moved by a part of the way to others, rounded to doubles."""
        return self.high.take(0).towards(start, distance)


_PARTS = slice(0, 1), slice(1, 2)


def _split(numbers: NDArray[Any]) -> ComplexArray:
    """Return two doubles whose sum is nearest to each number, leading axis (2,)."""
    parts = np.zeros((2, *numbers.shape), np.complex128)
    # Most coefficients are zero.
    places = np.nonzero(numbers != 0)
    rest = numbers[places]
    for part in parts:
        part[places] = near = rest.astype(np.complex128)
        rest = rest - near
    return parts


@dataclass(frozen=True, eq=False)
class System:
    """Six equations ``G_i = 0`` or ``G_i H_i = tau_i N^2`` on the Study quadric ``e.f = 0``.

    `System.of` checks its arguments.
    """

    #: Spaces and products.
    structure: Structure
    #: The numbers, no leading axes.
    coefficients: Coefficients

    @classmethod
    def of(
        cls,
        structure: Structure,
        g: ArrayLike,
        h: ArrayLike | None = None,
        tau: ArrayLike | None = None,
    ) -> System:
        """Return the system with the given coefficients.

        They are real or complex, of any scale. The origins of T, U and rho should be near the
        geometry: an origin at a distance of 1e6 costs six digits.

        Parameters
        ----------
        structure
            Spaces and products.
        g
            Quadrics, shape (6, 27).
        h
            Second factors, shape (6, 27); rows of equations that are no products are ignored.
            It may be omitted if there are no products.
        tau
            Right-hand sides of the products, shape (6,); they may be omitted like h.

        Raises
        ------
        ValueError
            For a wrong shape or a number that is not finite.
        """
        if any(structure.products) and (h is None or tau is None):
            raise ValueError("a system with products needs their second factors h and values tau")
        products = structure.is_product
        shape = (EQUATIONS, COEFFICIENTS)
        arrays = []
        for name, value, wanted in (
            ("g", g, shape),
            ("h", np.zeros(shape) if h is None else h, shape),
            ("tau", np.zeros(EQUATIONS) if tau is None else tau, (EQUATIONS,)),
        ):
            array = np.array(value, dtype=np.complex128)
            if array.shape != wanted:
                raise ValueError(f"{name} must have shape {wanted}, not {array.shape}")
            if name != "g":
                array[~products] = 0
            if not np.isfinite(array).all():
                raise ValueError(f"{name} has entries that are not finite")
            array.setflags(write=False)
            arrays.append(array)
        return cls(structure, Coefficients(*arrays))

    def canonical(self) -> System:
        """Return the system with its equations in canonical order (the same solutions)."""
        order = list(self.structure.order)
        coefficients = Coefficients(*(x[order] for x in self.coefficients))
        return System(self.structure.canonical(), coefficients)

    def normalized(self) -> System:
        """Return the equations with every factor scaled to norm 1."""
        return System(self.structure, self.coefficients.normalized())

    def scaled(self, g: ComplexArray, h: ComplexArray) -> System:
        """Return the same equations with their factors multiplied by `g` and `h`, shape (6,)."""
        return System(self.structure, self.coefficients.scaled(g, h))

    def towards(self, target: System, t: complex) -> System:
        """Return the point `t` of the line from this system (0) to `target` (1)."""
        return System(self.structure, self.coefficients.towards(target.coefficients, t))

    @property
    def is_real(self) -> bool:
        """Whether all coefficients are real."""
        return not any(x.imag.any() for x in self.coefficients)

    @property
    def _products(self) -> NDArray[np.bool_]:
        return self.structure.is_product

    def values(self, points: ComplexArray) -> ComplexArray:
        """Return e.f and the six equations at points (P, 8): shape (P, 7)."""
        g, h, tau = self.coefficients
        e, f = points[:, :4], points[:, 4:]
        rows = evaluate(g, points)
        if self._products.any():
            n = evaluate(NORM[None], points)
            product = rows * evaluate(h, points) - tau * n**2
            rows = np.where(self._products, product, rows)
        return np.concatenate([(e * f).sum(axis=1, keepdims=True), rows], axis=1)

    def residuals(self, points: ComplexArray) -> FloatArray:
        """Return the largest of the seven equations at points (P, 8) of norm 1: shape (P,).

        Each equation is divided by the size of the terms that cancel in it, which is 1 for a
        quadric of norm 1.
        """
        g, h, tau = self.coefficients
        size = np.ones((len(points), 1 + EQUATIONS))
        if self._products.any():
            terms = (evaluate(g, points), evaluate(h, points))
            right = tau * evaluate(NORM[None], points)
            product = np.sqrt(sum(np.abs(x) ** 2 for x in (*terms, right)))
            size[:, 1:] = np.where(self._products, product + 1e-300, 1.0)
        values = np.abs(self.values(points)) / size
        return np.asarray(values.max(axis=1, initial=0.0))

    def jacobians(self, points: ComplexArray) -> ComplexArray:
        """Return the derivatives of `values` at points (P, 8): shape (P, 7, 8)."""
        g, h, tau = self.coefficients
        rows = gradients(g, points)
        if self._products.any():
            first, second = evaluate(g, points)[..., None], evaluate(h, points)[..., None]
            n = evaluate(NORM[None], points)[..., None] * tau[:, None]
            dh, dn = gradients(h, points), gradients(NORM[None], points)
            product = second * rows + first * dh - 2 * n * dn
            rows = np.where(self._products[:, None], product, rows)
        study = np.roll(points, 4, axis=1)[:, None, :]
        return np.concatenate([study, rows], axis=1)

    def bends(self, points: ComplexArray, steps: ComplexArray) -> ComplexArray:
        """Return the terms of second order of `values` at points plus steps (P, 8): (P, 7)."""
        g, h, tau = self.coefficients
        rows = evaluate(g, steps)
        if self._products.any():
            n, dn = (evaluate(NORM[None], x) for x in (points, steps))
            first, second = (evaluate(quadrics, points) for quadrics in (g, h))
            along_g, along_h, along_n = (
                np.einsum("pkj,pj->pk", gradients(quadrics, points), steps)
                for quadrics in (g, h, NORM[None])
            )
            product = first * evaluate(h, steps) + second * rows + along_g * along_h
            product = product - tau * (2 * n * dn + along_n**2)
            rows = np.where(self._products, product, rows)
        study = (steps[:, :4] * steps[:, 4:]).sum(axis=1, keepdims=True)
        return np.concatenate([study, rows], axis=1)
