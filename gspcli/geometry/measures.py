"""What distances measure, as forms in the Study parameters (e, f), whatever the rotation."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLP, DPH, DPL, DPP
from gspcli.geometry.poses import (
    BODY_TRANSLATION_FORMS,
    TRANSLATION_FORMS,
    cross,
    rotated_forms,
)
from gspcli.geometry.residuals import Arrangement

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measures:
    """What the distances measure, as forms in the Study parameters.

    A form (a, b), shape (4, 8), is ``s^2 e^T a e + s e^T b f`` at the Study point (s e, f).

    Attributes
    ----------
    heights
        N times the heights over planes and the moments of two lines, shape (k, 4, 8).
    squares
        N times the squared distances of points but for ``4 f.f``; those of the spheres
        first, then those of the cylinders, shape (m, 4, 8).
    axial
        For each cylinder N times the height along its axis, shape (m - spheres, 4, 8).
    normals
        N times the vector product of the directions of two lines, shape (l, 3, 4, 8).
    skew
        Which of the heights are moments of these lines, l of them.
    flat, curved
        Positions of the heights and of the squares among the distances.
    basis
        The forms of T or of U if all distances are simplest in those, else None.
    signs
        The combinations of sides asked for: ``height = sign distance``, shape (s, k).
    """

    heights: Array
    squares: Array
    axial: Array
    normals: Array
    skew: list[int]
    flat: list[int]
    curved: list[int]
    basis: Array | None
    signs: Array

    @property
    def spheres(self) -> int:
        """How many of the squares are those of spheres."""
        return len(self.squares) - len(self.axial)

    @cached_property
    def stacked(self) -> Array:
        """All forms and those of N T side by side, shape (4, 8 forms)."""
        translation = np.zeros((3, 4, 8))
        translation[..., 4:] = TRANSLATION_FORMS
        parts = (self.heights, self.squares, self.axial, self.normals, translation)
        forms = np.concatenate([part.reshape(-1, 4, 8) for part in parts])
        return forms.transpose(1, 0, 2).reshape(4, -1)


def measures(arrangement: Arrangement, parallel: Collection[int] = ()) -> Measures:
    """Return the forms of the distances of an arrangement.

    Parameters
    ----------
    arrangement
        The geometry.
    parallel
        Line-line distances whose lines are parallel at the rotations in question.
    """
    indices = arrangement.distances.tolist()
    heights: list[tuple[int, Array]] = []
    spheres: list[tuple[int, Array]] = []
    cylinders: list[tuple[int, Array, Array]] = []
    normals: list[Array] = []
    skew: list[int] = []
    sorts = set()
    for j, i in enumerate(indices):
        kind = arrangement.kinds[i]
        y, x, u, v = (a[i] for a in (arrangement.y, arrangement.x, arrangement.u, arrangement.v))
        if kind is DPH:
            heights.append((j, _base_height(y, x, v)))
        elif kind is DHP:
            heights.append((j, -_platform_height(y, x, u)))
        elif kind is DPP:
            spheres.append((j, _square(y, x)))
        elif kind is DLP:
            cylinders.append((j, _square(y, x), _platform_height(y, x, u)))
        elif i in parallel and arrangement.values[i] == 0:
            # One line on the other: two planes, not the cylinder of radius zero about them.
            across = np.linalg.svd(v[None])[2][1:]
            heights += [(j, _base_height(y, x, normal)) for normal in across]
        elif kind is DPL or i in parallel:
            cylinders.append((j, _square(y, x), _base_height(y, x, v)))
        else:
            skew.append(len(heights))
            heights.append((j, _moment(y, x, u, v)))
            normals.append(_form(rotated_forms(u, cross(v, np.eye(3)))))
        sorts.add("q" if kind in (DHP, DLP) else "s" if kind is DPP else "p")
    flat = [j for j, _ in heights]
    return Measures(
        heights=np.array([h for _, h in heights]).reshape(-1, 4, 8),
        squares=np.array([h for _, h, *_ in (*spheres, *cylinders)]).reshape(-1, 4, 8),
        axial=np.array([h for _, _, h in cylinders]).reshape(-1, 4, 8),
        normals=np.array(normals).reshape(-1, 3, 4, 8),
        skew=skew,
        flat=flat,
        curved=[j for j, _ in spheres] + [j for j, _, _ in cylinders],
        basis=TRANSLATION_FORMS
        if "q" not in sorts
        else BODY_TRANSLATION_FORMS
        if "p" not in sorts
        else None,
        signs=signs_of(arrangement, [indices[j] for j in flat]),
    )


def _form(a: Array, b: Array | None = None) -> Array:
    """Return forms from their two matrices, ``(..., 4, 4)`` twice to ``(..., 4, 8)``."""
    return np.concatenate((a, np.zeros_like(a) if b is None else b), axis=-1)


def _base_height(y: Array, x: Array, v: Array) -> Array:
    """Return the form of ``v . (R y + T - x)``."""
    return _form(rotated_forms(y, v) - (v @ x) * np.eye(4), np.tensordot(v, TRANSLATION_FORMS, 1))


def _platform_height(y: Array, x: Array, u: Array) -> Array:
    """Return the form of ``R u . (R y + T - x) = u . (y + U - R^T x)``."""
    turned = (u @ y) * np.eye(4) - rotated_forms(u, x)
    return _form(turned, np.tensordot(u, BODY_TRANSLATION_FORMS, 1))


def _moment(y: Array, x: Array, u: Array, v: Array) -> Array:
    """Return the form of ``(R y + T - x) . (R u x v)``.

    N R is quadratic in e, and N [T]x R is its derivative along f: twice the polar form.
    """
    turned = rotated_forms(cross(y, u), v) - rotated_forms(u, cross(v, x))
    return _form(turned, 2 * rotated_forms(u, v))


def _square(y: Array, x: Array) -> Array:
    """Return the form of ``|R y + T - x|^2`` but for ``4 f.f = N T.T``."""
    turned = (x @ x + y @ y) * np.eye(4) - 2 * rotated_forms(y, x)
    moved = np.tensordot(y, BODY_TRANSLATION_FORMS, 1) - np.tensordot(x, TRANSLATION_FORMS, 1)
    return _form(turned, 2 * moved)


@cache
def _signs(free: tuple[bool, ...], fixed: tuple[int, ...]) -> Array:
    choices = [(1, -1) if f else (s,) for f, s in zip(free, fixed, strict=True)]
    return np.array(list(product(*choices)), float)


def signs_of(arrangement: Arrangement, planes: list[int]) -> Array:
    """Return the sign combinations of some plane constraints, shape (s, k).

    A line-line distance has both signs, a distance to a plane those of its sides; a distance
    of zero has one.
    """
    sides = [int(arrangement.signs[i]) for i in planes]
    free = tuple(s == 0 and arrangement.values[i] != 0 for i, s in zip(planes, sides, strict=True))
    return _signs(free, tuple(s or 1 for s in sides))
