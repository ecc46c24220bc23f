"""Start systems: a generic system of every structure with all its solutions.

The data contain 119 monomials of six spaces, up to the exchange of p and q. The other start systems
are derived: by the exchange, and for products ``G H = tau N^2`` as the system with ``tau = 0`` and
generic G and H. Its solutions are those of the 2^m systems with one factor of each product.
"""

from __future__ import annotations

import json
from functools import cache
from itertools import product

import numpy as np

from gspcli.continuation.quadrics import (
    LETTERS,
    ComplexArray,
    swap_letters,
    swap_points,
    swap_quadrics,
)
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.continuation.tracker import CAREFUL, DEFAULT, PathStatus, track
from gspcli.errors import DataError
from gspcli.records import dataclass
from gspcli.resources import data_path

FOLDER = "start-systems"
_SEED = 119


@dataclass(frozen=True, eq=False)
class StartSystem:
    """A generic system and all its solutions."""

    system: System
    """In canonical order; factors of norm 1; `tau` is zero."""
    points: ComplexArray
    """All solutions, shape (paths, 8), of single precision at least: the tracker corrects them."""


def distinct(points: ComplexArray) -> bool:
    """Return whether no two of some points (n, 8) of norm 1 agree up to a factor."""
    gram = np.abs(points.conj() @ points.T)
    np.fill_diagonal(gram, 0.0)
    return bool(gram.max(initial=0.0) < 1 - 1e-10)


@cache
def _stored() -> tuple[ComplexArray, ComplexArray, dict[str, slice]]:
    """Return the factors (2, 6, 5, 27), all points (n, 8), and the points of each monomial."""
    manifest = json.loads(data_path(FOLDER, "manifest.json").read_text(encoding="utf-8"))
    factors = np.load(data_path(FOLDER, "factors.npy")).astype(np.complex128)
    affine = np.load(data_path(FOLDER, "points.npy")).astype(np.complex128)
    slices, begin = {}, 0
    for spaces, count in manifest["counts"].items():
        slices[spaces] = slice(begin, begin + count)
        begin += count
    if begin != len(affine):
        raise DataError(f"{FOLDER}: the manifest counts {begin} points, the file has {len(affine)}")
    points = np.concatenate([np.ones((begin, 1), dtype=np.complex128), affine], axis=1)
    return factors, points / np.linalg.norm(points, axis=1, keepdims=True), slices


def generic_factors(factors: ComplexArray, spaces: str) -> tuple[ComplexArray, ComplexArray]:
    """Return the first and second factors (6, 27) of a canonical monomial from the stored table."""
    index = [LETTERS.index(x) for x in spaces]
    g, h = factors[:, np.arange(EQUATIONS), index]
    return g, h


@cache
def _base(spaces: str) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return first and second factors and the solutions of a monomial in canonical order."""
    factors, points, slices = _stored()
    if spaces in slices:
        return *generic_factors(factors, spaces), points[slices[spaces]]
    swapped = Structure(swap_letters(spaces))
    order = np.argsort(swapped.order)
    mirror = swapped.canonical().spaces
    if mirror not in slices:
        raise ValueError(f"no start system for the spaces {spaces!r}: at most three may be a")
    g, h = generic_factors(factors, mirror)
    return swap_quadrics(g)[order], swap_quadrics(h)[order], swap_points(points[slices[mirror]])


def intersection_number(spaces: str) -> int:
    """Return the stored generic number of solutions of six quadrics of the given spaces.

    Raises
    ------
    ValueError
        If more than three are of space a, so that there is no finite number.
    """
    return len(_base(Structure(spaces).canonical().spaces)[2])


@cache
def path_count(structure: Structure) -> int:
    """Return the generic number of solutions of a structure: 2^products times I."""
    return int(2 ** sum(structure.products) * intersection_number(structure.spaces))


@cache
def start_system(structure: Structure) -> StartSystem:
    """Return the start system of a structure in canonical order; made on first use.

    Raises
    ------
    ValueError
        If more than three equations are of space a.
    DataError
        If the stored solutions do not lead to those of the products.
    """
    if structure != structure.canonical():
        raise ValueError("the structure must be in canonical order")
    g, h, points = _base(structure.spaces)
    products = structure.is_product
    zero = np.zeros(EQUATIONS, dtype=np.complex128)
    base = System(Structure(structure.spaces), Coefficients(g, np.zeros_like(h), zero))
    coefficients = Coefficients(g, np.where(products[:, None], h, 0), zero).normalized()
    system = System(structure, coefficients)
    if not products.any():
        return StartSystem(system, points)
    choices = np.array(list(product(*[(False, True) if p else (False,) for p in products])))
    chosen = np.where(choices[:, :, None], h, g)
    sides = Coefficients(
        chosen, np.zeros_like(chosen), np.zeros(choices.shape, dtype=np.complex128)
    )
    rng = np.random.default_rng(_SEED)
    for options in (DEFAULT, CAREFUL, CAREFUL, CAREFUL):
        phases = np.exp(2j * np.pi * rng.random(EQUATIONS))
        start = base.scaled(phases, phases)
        ends = track(start, sides, points, options=options)
        if (ends.status == PathStatus.REGULAR).all() and all(map(distinct, ends.points)):
            return StartSystem(system, ends.points.reshape(-1, 8))
    raise DataError(f"the start system of {structure} could not be derived from the stored one")
