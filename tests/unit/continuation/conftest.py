"""Random and special platforms as systems of quadrics, without the platform layer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from gspcli.continuation.quadrics import NORM, monomials, swap_quadrics
from gspcli.continuation.systems import Structure, System
from tests.support.study_forms import BODY_TRANSLATION, MOMENT, RHO, ROTATION, TRANSLATION

Array = NDArray[np.float64]


def rotation(rng: np.random.Generator) -> Array:
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def turned(u: Array, v: Array) -> Array:
    """The quadric of u.R v."""
    return np.einsum("i,j,ijk->k", u, v, ROTATION)


def point_point(y: Array, x: Array, d: float) -> Array:
    """|R y + T - x|^2 = d^2."""
    constant = (y @ y + x @ x - d * d) * NORM
    return RHO + constant + 2 * y @ BODY_TRANSLATION - 2 * x @ TRANSLATION - 2 * turned(x, y)


def point_plane(y: Array, x: Array, n: Array, d: float) -> Array:
    """n.(R y + T - x) = d."""
    return n @ TRANSLATION + turned(n, y) - (n @ x + d) * NORM


def plane_point(v: Array, b: Array, x: Array, d: float) -> Array:
    """v.(R^T (x - T) - b) = d: the motion swapped for its inverse."""
    return swap_quadrics(point_plane(x, b, v, 0.0)) - d * NORM


def normals(v: Array) -> tuple[Array, Array]:
    a = np.cross(v, np.eye(3)[np.argmin(np.abs(v))])
    a /= np.linalg.norm(a)
    return a, np.cross(v, a)


def constraint(kind: str, rng: np.random.Generator, pose: tuple[Array, Array]) -> tuple:
    """A random constraint that holds at a pose: space, is a product, G, H, tau."""
    r, t = pose
    y, x, v, n = rng.standard_normal((4, 3))
    v, n = v / np.linalg.norm(v), n / np.linalg.norm(n)
    across = r @ y + t - x
    back = r.T @ (x - t) - y
    if kind == "PP":
        return "s", False, point_point(y, x, float(np.linalg.norm(across))), NORM, 0
    if kind == "PH":
        return "p", False, point_plane(y, x, n, n @ across), NORM, 0
    if kind == "HP":
        return "q", False, plane_point(v, y, x, v @ back), NORM, 0
    if kind == "A":
        return "a", False, turned(n, v) - (n @ r @ v) * NORM, NORM, 0
    if kind == "PL":
        a, b = (point_plane(y, x, m, 0.0) for m in normals(n))
        return "p", True, a + 1j * b, a - 1j * b, across @ across - (across @ n) ** 2
    if kind == "LP":
        a, b = (plane_point(m, y, x, 0.0) for m in normals(v))
        return "q", True, a + 1j * b, a - 1j * b, back @ back - (back @ v) ** 2
    moment = turned(n, np.cross(y, v)) - turned(np.cross(n, x), v)
    moment = moment + np.einsum("i,j,ijk->k", n, v, MOMENT)
    cross = np.cross(r @ v, n)
    d = across @ cross / np.linalg.norm(cross)
    return "l", True, moment + 1j * d * turned(n, v), moment - 1j * d * turned(n, v), d * d


def platform(kinds: str, rng: np.random.Generator) -> tuple[System, Array, Array]:
    """A random platform of the kinds given, and the pose that its values come from."""
    r, t = rotation(rng), rng.standard_normal(3)
    rows = [constraint(kind, rng, (r, t)) for kind in kinds.split()]
    spaces, products, g, h, tau = zip(*rows, strict=True)
    return System.of(Structure("".join(spaces), tuple(products)), g, h, tau), r, t


def point_at_a_line(distance: float, rng: np.random.Generator) -> System:
    """Five legs and a point that has a distance from a line at a real pose."""
    r, t = rotation(rng), rng.standard_normal(3)
    rows = [constraint("PP", rng, (r, t)) for _ in range(5)]
    y, n = rng.standard_normal((2, 3))
    n /= np.linalg.norm(n)
    side = normals(n)
    x = r @ y + t + distance * side[0]
    a, b = (point_plane(y, x, m, 0.0) for m in side)
    rows.append(("p", True, a + 1j * b, a - 1j * b, distance * distance))
    spaces, products, g, h, tau = zip(*rows, strict=True)
    return System.of(Structure("".join(spaces), tuple(products)), g, h, tau)


def legs(y: Sequence[Array], x: Sequence[Array], d: Sequence[float]) -> System:
    """Six legs of lengths d from platform points y to base points x."""
    rows = [point_point(np.asarray(a), np.asarray(b), c) for a, b, c in zip(y, x, d, strict=True)]
    return System.of(Structure("ssssss"), rows)


def legs_at(y: Sequence[Array], x: Sequence[Array], r: Array, t: Array) -> System:
    """Six legs with the lengths that they have at a pose."""
    d = [float(np.linalg.norm(r @ a + t - b)) for a, b in zip(y, x, strict=True)]
    return legs(y, x, d)


def poses(points: NDArray[np.complex128]) -> tuple[NDArray, NDArray]:
    """R and T of Study points with N = 1."""
    m = monomials(points)
    return np.einsum("ijk,pk->pij", ROTATION, m), m @ TRANSLATION.T


@pytest.fixture(scope="session")
def build() -> SimpleNamespace:
    functions: tuple[Callable, ...] = (rotation, platform, point_at_a_line, legs, legs_at, poses)
    return SimpleNamespace(**{f.__name__: f for f in functions})
