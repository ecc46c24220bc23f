"""Proofs, at exact motions, of the slips in Sections 4 to 6.1.

Every function returns its evidence in a sentence and raises `CheckFailed` if there is none.
"""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np

from gspcli.errors import CheckFailed
from gspcli.symbolic.rational_motions import Exact, random_motion, random_vector

_X, _Y, _Z = np.eye(3, dtype=int).astype(object)


def equation_5() -> str:
    """Prove that the second line of equation (5) does not equal its first, and what does."""
    random = Random(5)
    printed_holds = 0
    for _ in range(10):
        motion, y, x = random_motion(random), random_vector(random), random_vector(random)
        R, T = motion.rotation, motion.translation
        first = _square(R @ y + T - x)
        common = y @ y + T @ T + x @ x - 2 * (x @ T) - 2 * ((R @ y) @ x)
        _require(first == common + 2 * (T @ (R @ y)), "2[T, RY] is wrong, too")
        _require(first == common + 2 * (y @ (R.T @ T)), "the third line is wrong")
        printed_holds += first == common + 2 * (T @ (R.T @ y))
    _require(printed_holds == 0, "the printed line holds")
    return (
        "at ten exact random motions the first line equals the third and the second with "
        "2[T, RY], and differs from the second as printed"
    )


def directions_of_lines() -> str:
    """Prove that the vector of a line must be along it, not normal to it."""
    distances = [_square(np.cross(3 * _X, v)) for v in (_Z, _X)]
    _require(distances == [9, 0], f"{distances}")
    angles = [u @ _Z for u in (_Z, _X)]
    _require(angles == [1, 0], f"{angles}")
    return (
        "the point (3, 0, 0) is 3 from the z axis: |(3, 0, 0) × v| is 3 for v along the axis and 0 "
        "for the normal v = (1, 0, 0); a line normal to a plane makes 90° with it: u1·u2 is "
        "cos(90° − 90°) = 1 for u1 along the line and 0 for u1 normal to it"
    )


def distance_of_lines() -> str:
    """Prove that the equation of DLL holds with the vectors u along the lines as its v."""
    along = np.cross(_X, _Y)
    offset = 2 * _X - 5 * _Y + 3 * _Z
    squared = _square(along) * 9
    _require(squared == (offset @ along) ** 2, "the equation does not hold")
    return "for lines along x and y, 3 apart, the equation with v1 = u1 and v2 = u2 gives d = 3"


def first_distance() -> str:
    """Prove that the equation of the first DPP, with its points at the origins, has d1 squared."""
    motion, zero = random_motion(Random(3)), 0 * _X
    R, T = motion.rotation, motion.translation
    _require(_square(R @ zero + T - zero) == T @ T, "[T, T] is not the square of the distance")
    return "with Y1 = X1 = 0 the distance d1 of (9) is the length of T, as (10) uses it"


def turned_directions() -> str:
    """Prove that R belongs to the lines of the platform, L4 to L6, in Section 6.1."""
    R = random_motion(Random(6)).rotation
    of_base, of_platform = (R @ _Z) @ _X, _Z @ (R @ _X)
    _require(of_base != of_platform, "both are the same")
    return (
        "(11) has s1·Rs4, which is cos∠(L1, RL4); at an exact random rotation, with s1 = (0, 0, 1) "
        "and s4 = (1, 0, 0), Rs1·s4 is another number"
    )


def _square(vector: Exact) -> Any:
    return vector @ vector


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise CheckFailed(message)
