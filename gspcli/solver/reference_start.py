"""Solved platforms with complex values, one a structure, from which paths to others are short.

The stored start systems are quadrics without a geometry. A reference is a platform: its geometry is
real, its values are complex numbers of the usual size, so that nothing about it is special. On the
way to a real platform quadrics stay real but for values, which the kernel makes use of.
Equations are matched with those that they are most like, without which nothing is gained; and of
the frames that the bodies of the reference may have, those are taken in which they are most like.
Where the paths lead is proved afterwards; else it is forgotten.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, cached_property
from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind, Primitive
from gspcli.continuation.quadrics import (
    ComplexArray,
    FloatArray,
    pack,
    unpack,
)
from gspcli.continuation.start import StartSystem, path_count
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.continuation.tracker_options import SHORT
from gspcli.geometry.quaternions import quaternion_product
from gspcli.records import dataclass
from gspcli.solver.solved_starts import SolvedStarts, Sort
from gspcli.solver.study_systems import complex_system

if TYPE_CHECKING:
    from gspcli.continuation.tracked_paths import TrackedPaths

Array = NDArray[np.float64]

#: A kind whose equation is of a space, and a product or not. Of the mutual moment of lines that
#: meet there is no value that could be complex.
_KINDS: dict[tuple[str, bool], Kind] = {
    ("a", False): ALL,
    ("p", False): DPH,
    ("q", False): DHP,
    ("s", False): DPP,
    ("p", True): DPL,
    ("q", True): DLP,
    ("l", True): DLL,
}
#: Of the random geometries; the next where the paths to one go wrong.
_SEEDS = (0, 3, 1)
#: The parameters, what the equations are linear in: a mean for squares of distances, and zero else,
#: plus i times numbers between these with random signs.
_MEAN, _SPREAD = 0.6, (0.2, 0.4)
#: In so many frames a reference is compared with a platform: four times as many take a twentieth
#: off the steps, and longer to compare than that saves.
_FRAMES = 64


@dataclass(frozen=True, eq=False)
class Reference:
    """A solved platform.

    Attributes
    ----------
    start
        Its system in canonical order; with products balanced.
    scale
        The unit of f in it.
    """

    start: StartSystem
    scale: float

    @cached_property
    def turned(self) -> Turned:
        """The same platform in other frames."""
        return _turned(self.start.system.coefficients)


class Turned(NamedTuple):
    """A system in K random frames of both bodies, the first of them its own."""

    maps: FloatArray
    """What takes Study points in these frames to those of the system, orthogonal, (K, 8, 8)."""
    coefficients: Coefficients
    """Leading axis (K,)."""
    aims: ComplexArray
    """The conjugate first factors, shape (K, 27, 6)."""


def reference_start(structure: Structure, starts: SolvedStarts) -> Reference | None:
    """Return the reference of a structure in canonical order.

    It is solved when it was asked for `OFTEN` times. None before, and where there is none.
    """
    if not starts.is_frequent(structure):
        return None
    return starts.kept(Sort.REFERENCE, structure, lambda: _solved_reference(structure))


def _solved_reference(structure: Structure) -> Reference | None:
    sorts = list(zip(structure.spaces, structure.products, strict=True))
    if any(sort not in _KINDS for sort in sorts):
        return None
    # Where no structure is frequent it is not needed.
    from gspcli.continuation.tracked_paths import track_all

    for seed in _SEEDS:
        given = complex_platform(tuple(_KINDS[sort] for sort in sorts), seed)
        tracked = next(track_all([given], seed=seed))
        points = tracked.first().points
        if not tracked.is_regular or len(points) != path_count(structure):
            continue
        scale = 1.0
        if any(structure.products):
            balanced, unit = given.coefficients.balanced()
            given, scale = System(structure, balanced), float(unit)
            points[:, 4:] /= scale
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        return Reference(StartSystem(given, points), scale)
    return None


def complex_platform(
    kinds: tuple[Kind, ...], seed: int, *, flat: tuple[bool, bool] = (False, False)
) -> System:
    """Return a platform with complex values, lengths of order one.

    Parameters
    ----------
    kinds, seed
        Of its constraints, and of its random numbers.
    flat
        Whether the points of the platform, and of the base, are of one plane.
    """
    rng = np.random.default_rng([seed, len(kinds)])
    y, x = rng.uniform(-1, 1, (2, len(kinds), 3))
    y[:, 2] *= not flat[0]
    x[:, 2] *= not flat[1]
    y, x = (z - z.mean(axis=0) for z in (y, x))
    length = np.sqrt(max((z**2).sum(axis=1).max() for z in (y, x)))
    u, v = rng.normal(size=(2, len(kinds), 3))
    u, v = (z / np.linalg.norm(z, axis=1, keepdims=True) for z in (u, v))
    for i, kind in enumerate(kinds):
        u[i] *= kind.platform is not Primitive.POINT
        v[i] *= kind.base is not Primitive.POINT
    square = np.array([kind.is_distance and not kind.has_sides for kind in kinds])
    turns = rng.choice([-1.0, 1.0], len(kinds)) * rng.uniform(*_SPREAD, len(kinds))
    parameters = np.where(square, _MEAN, 0.0) + 1j * turns
    return complex_system(kinds, y / length, x / length, u, v, parameters)


def track_near(
    reference: Reference,
    given: Coefficients,
    *,
    seed: int,
    jobs: int,
) -> Iterator[TrackedPaths]:
    """Yield the first attempt at the paths from a reference to B systems of one platform.

    Parameters
    ----------
    reference, given
        With equations in canonical order; the systems differ in their sides alone.
    seed, jobs
        As for `track_all`.
    """
    from gspcli.continuation.tracked_paths import TrackedPaths, first_attempts

    start, inner = _nearest(reference, given.in_units(np.array(reference.scale)))
    targets = inner.normalized()
    attempts = first_attempts(start.system, targets, start.points, options=SHORT, jobs=jobs)
    for i, (row, regular) in enumerate(attempts):
        target, sizes = System(start.system.structure, targets.take(i)), inner.take(i).sizes()
        yield TrackedPaths(start, target, reference.scale, sizes, row, regular, seed, jobs)


def _turned(coefficients: Coefficients) -> Turned:
    rng = np.random.default_rng(_FRAMES)
    platform, base = rng.normal(size=(2, _FRAMES, 1, 4))
    platform[0] = base[0] = (1, 0, 0, 0)
    platform /= np.linalg.norm(platform, axis=-1, keepdims=True)
    base /= np.linalg.norm(base, axis=-1, keepdims=True)
    # Quaternions are multiplied by that of one frame on the left, of the other on the right.
    turns = quaternion_product(base, quaternion_product(np.eye(4)[None], platform)).swapaxes(1, 2)
    maps = np.zeros((_FRAMES, 8, 8))
    maps[:, :4, :4] = maps[:, 4:, 4:] = turns
    turn = turns[:, None]

    def moved(quadrics: ComplexArray) -> ComplexArray:
        a, b, c = unpack(quadrics)
        back = turn.swapaxes(2, 3)
        square = np.broadcast_to(c, (_FRAMES, len(c)))
        return np.asarray(pack(back @ a @ turn, back @ b @ turn, square))

    g, h = moved(coefficients.g), moved(coefficients.h)
    tau = np.broadcast_to(coefficients.tau, g.shape[:2])
    return Turned(maps, Coefficients(g, h, tau), g.conj().swapaxes(1, 2))


def _nearest(reference: Reference, given: Coefficients) -> tuple[StartSystem, Coefficients]:
    """Return a reference in frames, and the equations of systems (B, ...), as like as they can be.

    Each equation takes the place of one of its sort, so that they are alike on the whole; factors
    are exchanged and multiplied by phases.
    """
    structure, turned = reference.start.system.structure, reference.turned
    factors = np.concatenate(given.take(0).normalized()[:2])
    # Frame by frame: one large product has threads, which wait for each other on a busy machine.
    products = np.moveaxis(factors @ turned.aims, 0, -1)
    free = _with_phases(structure)
    products = np.where(np.tile(free, 2)[:, None, None], products, products.real)
    likeness = np.abs(products).reshape(2, EQUATIONS, EQUATIONS, -1)
    orders, chosen = _orders(structure)
    # Of all orders and frames.
    sums = chosen @ likeness.max(axis=0).reshape(EQUATIONS**2, -1)
    best, frame = divmod(int(sums.argmax()), len(turned.maps))
    order = orders[best]
    first, second = likeness[:, order, np.arange(EQUATIONS), frame]
    swap = (second > first)[:, None]
    g, h, tau = (part[:, order] for part in given)
    g, h = np.where(swap, h, g), np.where(swap, g, h)
    system = System(structure, turned.coefficients.take(frame))
    phase = np.einsum("ic,ic->i", g[0], system.coefficients.g.conj())
    phase = np.where(free, phase, phase.real)
    phase /= np.abs(phase)
    points = reference.start.points @ turned.maps[frame]
    return StartSystem(system, points), Coefficients(g, h, tau).scaled(1 / phase, phase)


@cache
def _with_phases(structure: Structure) -> NDArray[np.bool_]:
    """Return which equations are multiplied by phases, shape (6,); others by signs, to stay real.

    Products, whose factors stay conjugate; and the distances to three planes of one body, whose
    normals would else be linearly dependent somewhere on the way for every other platform: there
    poses go to infinity whatever the values are.
    """
    sorts = list(zip(structure.spaces, structure.products, strict=True))
    three = [sort for sort in (("p", False), ("q", False)) if sorts.count(sort) == 3]
    return np.array([sort[1] or sort in three for sort in sorts])


@cache
def _orders(structure: Structure) -> tuple[NDArray[np.intp], Array]:
    """Return the orders (n, 6) in which every equation takes the place of one of its sort.

    And which entries of a matrix they choose: a row by the equation, a column by the place;
    shape (n, 36).
    """
    sorts = list(zip(structure.spaces, structure.products, strict=True))
    orders = [
        order
        for order in permutations(range(EQUATIONS))
        if all(sorts[i] == sort for i, sort in zip(order, sorts, strict=True))
    ]
    chosen = np.zeros((len(orders), EQUATIONS, EQUATIONS))
    for one, order in zip(chosen, orders, strict=True):
        one[order, range(EQUATIONS)] = 1
    return np.array(orders), chosen.reshape(len(orders), -1)
