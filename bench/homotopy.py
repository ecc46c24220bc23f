"""The parameter homotopy that the numerical peers are given, and the writing of polynomials.

The peers start where we start: from the solved generic system of the same structure. They track
in the affine part e0 = 1 of the Study quadric, seven equations in seven unknowns; random
instances have no solution near e0 = 0. Random patches, with an eighth equation, were slower.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sympy.polys.rings import PolyElement

from bench.polynomials import Equation, affine, equations, expanded, study
from gspcli.continuation.accounts import random_start
from gspcli.continuation.quadrics import NORM
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import Structure
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.poses import Field, pose_from_study
from gspcli.solver.systems import target_systems

#: Coefficients with the exponents of the unknowns e1 e2 e3 f0 f1 f2 f3.
Terms = list[tuple[complex, tuple[int, ...]]]
UNKNOWNS = 7
_ROW, _COLUMN = np.triu_indices(4)


@dataclass(frozen=True)
class Product:
    """A summand of an equation: a product of two polynomials, or one of them alone."""

    first: Terms
    second: Terms | None = None

    @property
    def factors(self) -> list[Terms]:
        """The one or two factors."""
        return [self.first] if self.second is None else [self.first, self.second]


@dataclass(frozen=True, eq=False)
class Homotopy:
    """Seven equations at the start and at the target, each a sum of products that is zero."""

    start: list[list[Product]]
    target: list[list[Product]]
    points: NDArray[np.complex128]
    """The solutions of the start system, shape (paths, 7)."""

    @classmethod
    def of(cls, instance: Instance, seed: int) -> Homotopy:
        """Return the homotopy from the stored start system to an instance."""
        structure, order = structure_of(instance)
        system = start_system(structure)
        given = random_start(system, seed, 0)
        motion = study()
        rows = [equations(instance, motion)[i] for i in order]
        relation = [Product(terms(affine(motion.relations[0])))]
        start = [
            [Product(quadric(g), quadric(h) if product else None)]
            for g, h, product in zip(*given.coefficients[:2], structure.products, strict=True)
        ]
        return cls(
            start=[*start, relation],
            target=[*map(_scaled, rows), relation],
            points=system.points[:, 1:] / system.points[:, :1],
        )


def structure_of(instance: Instance) -> tuple[Structure, tuple[int, ...]]:
    """Return the structure of an instance in canonical order, and that order."""
    [system] = target_systems(Arrangement.of(instance).normalised)
    return system.structure.canonical(), system.structure.order


def blackbox_system(instance: Instance) -> list[PolyElement]:
    """Return seven exact polynomials in the seven unknowns with e0 = 1."""
    motion = study()
    rows = [expanded(row) for row in equations(instance, motion)]
    return [affine(row) for row in (*rows, *motion.relations)]


def split_system(instance: Instance) -> list[Terms]:
    """Return the seven equations with each product split in two, by an unknown u more.

    ``G = d N u`` and ``u H = d N`` for ``G H = d^2 N^2``, all in floating point. With it the mixed
    volume is the number of solutions where there are three products and three angles.
    """
    [system] = target_systems(Arrangement.of(instance))
    products = system.structure.products
    more = sum(products)

    def extended(polynomial: Terms, unknown: int | None = None) -> Terms:
        tail = tuple(int(k == unknown) for k in range(more))
        return [(value, (*powers, *tail)) for value, powers in polynomial]

    rows: list[Terms] = []
    u = 0
    for g, h, tau, product in zip(*system.coefficients, products, strict=True):
        if not product:
            rows.append(extended(quadric(g)))
            continue
        right = quadric(-np.sqrt(tau) * NORM)
        rows.append(extended(quadric(g)) + extended(right, u))
        rows.append(extended(quadric(h), u) + extended(right))
        u += 1
    return [*rows, extended(terms(affine(study().relations[0])))]


def poses(points: Field) -> tuple[Field, Field]:
    """Return R and T of affine points, shape (n, 7)."""
    full = np.concatenate([np.ones((len(points), 1)), points], axis=1)
    return pose_from_study(full[:, :4], full[:, 4:])


def terms(polynomial: PolyElement, scale: float = 1.0) -> Terms:
    """Return a polynomial in floating point, multiplied by a number."""
    return [(float(value) * scale, powers) for powers, value in polynomial.terms()]


def quadric(coefficients: NDArray[np.complex128]) -> Terms:
    """Return a packed quadric (27,) of the package in the affine unknowns."""
    pairs = [*zip(_ROW, _COLUMN, strict=True), *((i, 4 + j) for i in range(4) for j in range(4))]
    entries = [*zip(coefficients[:26], pairs, strict=True)]
    entries += [(coefficients[26], (k, k)) for k in range(4, 8)]
    return [(complex(value), _powers(pair)) for value, pair in entries if value != 0]


@dataclass(frozen=True)
class Style:
    """How a program writes polynomials."""

    names: Sequence[str]
    imaginary: str
    exponent: str = "e"

    def written(self, polynomial: Iterable[tuple[complex, tuple[int, ...]]]) -> str:
        """Return the text of a polynomial, every term with its sign."""
        return "".join(self._term(value, powers) for value, powers in polynomial)

    def product(self, pair: Product) -> str:
        """Return the text of a product."""
        return "*".join(f"({self.written(factor)})" for factor in pair.factors)

    def _term(self, value: complex, powers: tuple[int, ...]) -> str:
        named = zip(self.names, powers, strict=True)
        factors = [name if k == 1 else f"{name}^{k}" for name, k in named if k]
        number = self._real(value.real)
        if value.imag:
            number = f"+({number}{self._real(value.imag)}*{self.imaginary})"
        return "*".join([number, *factors])

    def _real(self, value: float) -> str:
        return f"{value:+.16e}".replace("e", self.exponent)


def _powers(pair: tuple[int, int]) -> tuple[int, ...]:
    return tuple(sum(int(k == i) for k in pair) for i in range(1, 8))


def _scaled(equation: Equation) -> list[Product]:
    """Return an equation scaled so that the coefficients have norm one."""
    size = np.linalg.norm([float(value) for value in expanded(equation).coeffs()])
    return [
        Product(terms(affine(p), 1 / size), None if q == 1 else terms(affine(q)))
        for p, q in equation
    ]
