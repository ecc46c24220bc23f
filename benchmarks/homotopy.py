"""The parameter homotopy that the numerical peers are given, and the writing of polynomials.

The peers start where we start: from the solved generic system of the same structure. They track
in the affine part e0 = 1 of the Study quadric, seven equations in seven unknowns; random
instances have no solution near e0 = 0. Random patches, with an eighth equation, were slower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.endpoints import random_start
from gspcli.continuation.quadrics import NORM
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import Structure
from gspcli.export.polynomial_systems import (
    Monomial,
    Polynomial,
    Style,
    SumOfProducts,
    equations,
    expanded,
    study_affine,
)
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import Field, pose_from_study
from gspcli.solver.study_systems import target_systems

#: Coefficients with their monomials in the unknowns.
Terms = list[tuple[complex, Monomial]]
#: The quaternion without its first component, which is one, and the dual one. The equations are
#: those of `gspcli.export`, which the solver does not know.
NAMES = study_affine().names[:-1]
UNKNOWNS = len(NAMES)
#: The Study quadric.
RELATION = study_affine().relations[0]
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
        stated = stated_equations(instance)
        rows = [stated[i] for i in order]
        relation = [Product(terms(RELATION))]
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
    [system] = target_systems(Arrangement.of(instance).normalized)
    return system.structure.canonical(), system.structure.order


def stated_equations(instance: Instance) -> list[SumOfProducts]:
    """Return the equations of an instance with rational numbers as sums of products.

    Raises
    ------
    ValueError
        If a number is irrational.
    """
    rows, constants = equations(instance, study_affine())
    if constants.names:
        message = f"irrational: {', '.join(map(str, constants.names.values()))}"
        raise ValueError(message)
    return rows


def blackbox_system(instance: Instance) -> list[Polynomial]:
    """Return seven exact polynomials in the seven unknowns with e0 = 1."""
    return [*map(expanded, stated_equations(instance)), RELATION]


def split_system(instance: Instance) -> list[Terms]:
    """Return the seven equations with each product split in two, by an unknown u more.

    ``G = d N u`` and ``u H = d N`` for ``G H = d^2 N^2``, all in floating point. With it the mixed
    volume is the number of solutions where there are three products and three angles.
    """
    [system] = target_systems(Arrangement.of(instance))
    products = system.structure.products

    def extended(polynomial: Terms, unknown: int) -> Terms:
        return [(value, (*monomial, split_name(unknown))) for value, monomial in polynomial]

    rows: list[Terms] = []
    u = 0
    for g, h, tau, product in zip(*system.coefficients, products, strict=True):
        if not product:
            rows.append(quadric(g))
            continue
        right = quadric(-np.sqrt(tau) * NORM)
        rows.append(quadric(g) + extended(right, u))
        rows.append(extended(quadric(h), u) + right)
        u += 1
    return [*rows, terms(RELATION)]


def split_name(index: int) -> str:
    """Return the name of an unknown that splits a product."""
    return f"u{index + 1}"


def poses(points: Field) -> tuple[Field, Field]:
    """Return R and T of affine points, shape (n, 7)."""
    full = np.concatenate([np.ones((len(points), 1)), points], axis=1)
    return pose_from_study(full[:, :4], full[:, 4:])


def terms(polynomial: Polynomial, scale: float = 1.0) -> Terms:
    """Return a polynomial in floating point, multiplied by a number."""
    return [(float(value) * scale, monomial) for monomial, value in polynomial.terms.items()]


def quadric(coefficients: NDArray[np.complex128]) -> Terms:
    """Return a packed quadric (27,) of the package in the affine unknowns."""
    pairs = [*zip(_ROW, _COLUMN, strict=True), *((i, 4 + j) for i in range(4) for j in range(4))]
    entries = [*zip(coefficients[:26], pairs, strict=True)]
    entries += [(coefficients[26], (k, k)) for k in range(4, 8)]
    return [(complex(value), _monomial(pair)) for value, pair in entries if value != 0]


def written_product(style: Style, pair: Product) -> str:
    """Return the text of a product."""
    return "*".join(f"({style.written(factor)})" for factor in pair.factors)


def _monomial(pair: tuple[int, int]) -> Monomial:
    return tuple(NAMES[k - 1] for k in sorted(pair) if k)


def _scaled(equation: SumOfProducts) -> list[Product]:
    """Return an equation scaled so that the coefficients have norm one."""
    size = np.linalg.norm([float(value) for value in expanded(equation).terms.values()])
    return [Product(terms(p, 1 / size), None if q.value == 1 else terms(q)) for p, q in equation]
