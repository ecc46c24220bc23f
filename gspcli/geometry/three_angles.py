"""The poses of platforms with three angles as Study points, if they are in general position.

First the rotations, then for each the translations, natively for many sets of values at a time
(native/closed_form.cpp; paper, Section 6).
"""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPP
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import BODY_TRANSLATION_FORMS, TRANSLATION_FORMS
from gspcli.records import dataclass

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: A vector of a constraint: a list is quicker than an array for so few numbers.
_Vector = list[float]


@dataclass(frozen=True, eq=False)
class Measures:
    """The measured distances as forms in the Study parameters.

    A form (a, b), shape (4, 8), is ``s^2 e^T a e + s e^T b f`` at the Study point (s e, f).
    """

    #: All forms, shape (count, 4, 8), each times N. First the heights over planes and the moments
    #: of two lines. Then the squared distances of points without ``4 f.f``: those for spheres,
    #: those for cylinders. Then the height along the axis of each cylinder. Last the three
    #: components of the vector product of the directions of two lines.
    forms: Array
    #: Which of the heights are moments of two lines.
    skew: list[int]
    #: Positions of the heights and of the squares among the distances.
    flat: list[int]
    curved: list[int]
    #: How many of the squares are those of spheres.
    spheres: int
    #: The forms of T or of U if all distances are simplest in them, else None.
    basis: Array | None
    #: The combinations of sides asked for: ``height = sign distance``, shape (s, k).
    signs: Array


def measures(arrangement: Arrangement) -> Measures:
    """Return the forms of the distances of an arrangement."""
    indices = arrangement.distances.tolist()
    heights: list[tuple[int, _Vector]] = []
    spheres: list[tuple[int, _Vector]] = []
    cylinders: list[tuple[int, _Vector]] = []
    axial: list[_Vector] = []
    normals: list[_Vector] = []
    skew: list[int] = []
    sorts = set()
    given = arrangement
    for j, i in enumerate(indices):
        kind = given.kinds[i]
        y, x, u, v = (part[i].tolist() for part in (given.y, given.x, given.u, given.v))
        form, *further = study.forms_of(kind, y, x, u, v)
        if kind.has_sides:
            heights.append((j, _row(form)))
        elif kind is DLL:
            skew.append(len(heights))
            heights.append((j, _row(form)))
            normals += [_row(study.rotation_form(_product(v, axis), u)) for axis in _AXES]
        else:
            (cylinders if further else spheres).append((j, _row(form)))
            axial += map(_row, further)
        sorts.add("q" if kind in (DHP, DLP) else "s" if kind is DPP else "p")
    flat = [j for j, _ in heights]
    rows = [row for _, row in (*heights, *spheres, *cylinders)] + axial + normals
    return Measures(
        forms=(np.array(rows) @ _FUNCTIONS).reshape(-1, 4, 8),
        skew=skew,
        flat=flat,
        curved=[j for j, _ in (*spheres, *cylinders)],
        spheres=len(spheres),
        basis=TRANSLATION_FORMS
        if "q" not in sorts
        else BODY_TRANSLATION_FORMS
        if "p" not in sorts
        else None,
        signs=signs_of(arrangement, [indices[j] for j in flat]),
    )


_AXES = np.eye(3).tolist()


def _product(a: _Vector, b: _Vector) -> _Vector:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]


def _row(form: study.Form) -> _Vector:
    return [form.get(place, 0.0) for place in range(study.STUDY)]


def _function_forms() -> Array:
    """Return the forms of N times each function but T.T, which is zero here, shape (26, 32)."""
    forms = study.form_hessians()[: study.STUDY, :4].copy()
    forms[:, :, :4] /= 2
    forms[study.RHO] = 0
    return forms.reshape(study.STUDY, 32)


_FUNCTIONS = _function_forms()


@cache
def _signs(free: tuple[bool, ...], fixed: tuple[int, ...]) -> Array:
    choices = [(1, -1) if f else (s,) for f, s in zip(free, fixed, strict=True)]
    return np.array(list(product(*choices)), float)


def signs_of(arrangement: Arrangement, planes: list[int]) -> Array:
    """Return the sign combinations of some plane constraints, shape (s, k).

    A line-line distance has both signs, a distance to a plane those of its sides; a distance
    of zero has one.
    """
    sides = arrangement.signs[planes].tolist() if planes else []
    values = arrangement.values[planes].tolist() if planes else []
    free = tuple(s == 0 and value != 0 for s, value in zip(sides, values, strict=True))
    return _signs(free, tuple(s or 1 for s in sides))


class StudyPoints(NamedTuple):
    """Poses for sets of values, b in number."""

    #: Study points of any norm, shape (b, s, n, 8) for s combinations of sides; exactly real for
    #: real poses, zero where a set is not in general position.
    points: Complex
    #: Which sets are in general position, shape (b,): by Bezout's theorem they have no other poses.
    general: NDArray[np.bool_]
    #: The sign of each constraint for each combination, shape (s, 6).
    signs: Array


def study_points(given: Arrangement, distances: Array, values: Array) -> StudyPoints:
    """Return all poses of one geometry for sets of values.

    Parameters
    ----------
    given
        The geometry with lengths of order one, and frames at the centres of the points.
    distances
        In the unit of `given`, shape (b, 3); a distance of zero is zero in `given`, too.
    values
        The sets of values, shape (b, 6); only the angles are used.
    """
    shapes, angles = measures(given), given.angles
    points, general = _kernel.closed_forms(
        given.u[angles],
        given.v[angles],
        given.cosines(values),
        shapes.forms,
        shapes.spheres,
        shapes.skew,
        shapes.signs,
        shapes.basis,
        distances[:, shapes.flat],
        distances[:, shapes.curved],
    )
    signs = np.ones((len(shapes.signs), len(given.kinds)))
    signs[:, given.distances[shapes.flat]] = shapes.signs
    return StudyPoints(points, general, signs)
